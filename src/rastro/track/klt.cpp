// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/klt.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "rastro/track/klt_patch.h"

namespace rastro {
namespace {

constexpr int points_per_chunk = 16;
// Fixed-point scales of klt_patch.h.
constexpr double intensity_scale = 32.0;
constexpr double gradient_scale = 16.0;
constexpr double everywhere = std::numeric_limits<double>::infinity();

/// The whole pixel and the fraction of the upper left corner of the window around a center; nullopt if the window
/// leaves the padding.
struct Corner {
  int x = 0, y = 0;
  std::int16_t fraction_x = 0, fraction_y = 0;
};

std::optional<Corner> corner_of(const PaddedImage& image, double x, double y, int size) {
  // The vectors read up to 35 pixels right of the corner; centers farther out than this are lost anyway.
  constexpr double slack = 8.0;
  if (!(x >= -slack && y >= -slack && x <= image.width() - 1 + slack && y <= image.height() - 1 + slack))
    return std::nullopt;
  const double left = x - size / 2, top = y - size / 2;
  const double floor_x = std::floor(left), floor_y = std::floor(top);
  const auto fraction = [](double value) {
    return static_cast<std::int16_t>(std::min(32767.0, std::round(value * 32768.0)));
  };
  return Corner{static_cast<int>(floor_x), static_cast<int>(floor_y), fraction(left - floor_x),
                fraction(top - floor_y)};
}

std::optional<KltWindow> window_of(const PaddedImage& image, double x, double y, int size) {
  const auto corner = corner_of(image, x, y, size);
  if (!corner) return std::nullopt;
  return KltWindow{image.row(corner->y) + corner->x, image.stride(), corner->fraction_x, corner->fraction_y};
}

/// The 2x2 normal equations of a patch with its mean brightness change eliminated, solved for the step.
class StepSolver {
 public:
  StepSolver(const KltPatch& patch, double min_eigenvalue) : count_(static_cast<double>(patch.size) * patch.size) {
    x_ = static_cast<double>(patch.x) / count_;
    y_ = static_cast<double>(patch.y) / count_;
    xx_ = static_cast<double>(patch.xx) - count_ * x_ * x_;
    xy_ = static_cast<double>(patch.xy) - count_ * x_ * y_;
    yy_ = static_cast<double>(patch.yy) - count_ * y_ * y_;
    const double smaller = 0.5 * (xx_ + yy_ - std::sqrt((xx_ - yy_) * (xx_ - yy_) + 4.0 * xy_ * xy_));
    determinant_ = xx_ * yy_ - xy_ * xy_;
    solvable_ = determinant_ > 0.0 && smaller >= min_eigenvalue * count_ * gradient_scale * gradient_scale;
  }
  bool solvable() const { return solvable_; }
  Eigen::Vector2d step(const KltMismatch& mismatch) const {
    const double e = static_cast<double>(mismatch.e);
    const double ex = static_cast<double>(mismatch.ex) - x_ * e, ey = static_cast<double>(mismatch.ey) - y_ * e;
    constexpr double scale = gradient_scale / intensity_scale;
    return Eigen::Vector2d(yy_ * ex - xy_ * ey, xx_ * ey - xy_ * ex) * (-scale / determinant_);
  }

 private:
  double count_, x_, y_, xx_, xy_, yy_, determinant_;
  bool solvable_;
};

double ratio_of(const KltResidual& sums, int size) {
  const double count = static_cast<double>(size) * size;
  const auto variance = [count](std::int64_t squares, std::int64_t sum) {
    return static_cast<double>(squares) - static_cast<double>(sum) * static_cast<double>(sum) / count;
  };
  return variance(sums.squared_difference, sums.difference) / std::max(1.0, variance(sums.squared_patch, sums.patch));
}

/// Moves `at` (in pixels of this level) until the window fits. False if it cannot be tracked.
bool align_patch(const PaddedImage& image, const KltPatch& patch, const StepSolver& solver, const KltOptions& options,
                 const KltKernels& kernels, double reach_px, double epsilon_px, Eigen::Vector2d& at) {
  const Eigen::Vector2d start = at;
  Eigen::Vector2d last_step = Eigen::Vector2d::Zero();
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const auto window = window_of(image, at.x(), at.y(), patch.size);
    if (!window) return false;
    const Eigen::Vector2d step = solver.step(kernels.mismatch(*window, patch));
    at += step;
    if ((at - start).squaredNorm() > reach_px * reach_px) return false;
    if (step.squaredNorm() < epsilon_px * epsilon_px) return true;
    // Two steps that undo each other: the minimum lies between (Bouguet's stop).
    if (iteration > 0 && (step + last_step).cwiseAbs().maxCoeff() < epsilon_px) {
      at -= 0.5 * step;
      return true;
    }
    last_step = step;
  }
  return true;
}

/// Tracks one point through `levels` levels of the pyramids; nullopt if it is lost.
struct Follower {
  const Pyramid& from;
  const Pyramid& to;
  const KltOptions& options;
  const KltKernels& kernels;

  std::optional<Eigen::Vector2d> follow(const Eigen::Vector2d& point, const Eigen::Vector2d& guess, int levels,
                                        double* ratio) const {
    KltPatch patch;
    Eigen::Vector2d at = guess;
    for (int level = levels - 1; level >= 0; --level) {
      const double scale = 1.0 / (1 << level);
      const PaddedImage& image = from.level(level);
      const Eigen::Vector2d center = point * scale;
      const auto window = window_of(image, center.x(), center.y(), options.window_px);
      if (!window) return std::nullopt;
      kernels.cut(*window, options.window_px, patch);
      const StepSolver solver(patch, options.min_eigenvalue);
      Eigen::Vector2d here = at * scale;
      // A coarse level without texture has no information; only on the finest level is the point lost.
      if (!solver.solvable()) {
        if (level == 0) return std::nullopt;
        continue;
      }
      const double epsilon_px = level == 0 ? options.epsilon_px : options.coarse_epsilon_px;
      if (!align_patch(to.level(level), patch, solver, options, kernels, everywhere, epsilon_px, here))
        return std::nullopt;
      at = here / scale;
    }
    if (ratio) {
      const auto window = window_of(to.level(0), at.x(), at.y(), options.window_px);
      if (!window) return std::nullopt;
      *ratio = ratio_of(kernels.residual(*window, patch), options.window_px);
    }
    return at;
  }
};

bool inside(const PaddedImage& image, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= image.width() - 1 && pixel.y() <= image.height() - 1;
}

KltResult follow_point(const Follower& forward, const Follower& backward, const Eigen::Vector2f& point,
                       const Eigen::Vector2f& guess) {
  const KltOptions& options = forward.options;
  const Eigen::Vector2d start = point.cast<double>();
  const int levels = std::min(forward.from.levels(), forward.to.levels());
  double ratio = 0.0;
  const auto found = forward.follow(start, guess.cast<double>(), levels, &ratio);
  if (!found || !inside(forward.to.level(0), *found)) return {};
  KltResult result{found->cast<float>(), ratio <= options.max_residual_ratio, static_cast<float>(ratio)};
  if (result.followed && options.backward_levels > 0) {
    const auto back = backward.follow(*found, start, std::min(levels, options.backward_levels), nullptr);
    result.followed = back && (*back - start).norm() <= options.max_backward_px;
  }
  return result;
}

}  // namespace

void klt_follow(const Pyramid& previous, const Pyramid& current, std::span<const Eigen::Vector2f> points,
                std::span<const Eigen::Vector2f> guesses, const KltOptions& options, TaskPool* pool,
                std::span<KltResult> results) {
  RASTRO_CHECK(points.size() == guesses.size() && points.size() == results.size(),
               "one guess and one result per point");
  RASTRO_CHECK(options.window_px % 2 == 1 && options.window_px >= 5 && options.window_px <= klt_largest_window,
               "window");
  RASTRO_CHECK(previous.level(0).padding() >= klt_padding && current.level(0).padding() >= klt_padding, "padding");
  const KltKernels& kernels = klt_kernels();
  const Follower forward{previous, current, options, kernels};
  const Follower backward{current, previous, options, kernels};
  const auto follow = [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto k = static_cast<std::size_t>(i);
      results[k] = follow_point(forward, backward, points[k], guesses[k]);
    }
  };
  const int count = static_cast<int>(points.size());
  if (pool) {
    pool->for_chunks(0, count, points_per_chunk, follow);
  } else {
    follow(0, count);
  }
}

void KltReference::keep(const Pyramid& pyramid, const Eigen::Vector2f& point, int window_px) {
  const PaddedImage& image = pyramid.level(0);
  const auto corner = corner_of(image, static_cast<double>(point.x()), static_cast<double>(point.y()), window_px);
  if (!corner) return;
  size_ = window_px;
  fraction_x_ = corner->fraction_x;
  fraction_y_ = corner->fraction_y;
  // The vectors read behind the last row.
  constexpr std::size_t slack = 64;
  const auto side = static_cast<std::size_t>(stride());
  pixels_.resize(side * side + slack);
  // One pixel more on each side for the gradients, and one for interpolation.
  const int left = corner->x - 1 - margin(), top = corner->y - 1 - margin();
  for (int y = 0; y < stride(); ++y) {
    std::memcpy(pixels_.data() + static_cast<std::size_t>(y) * side, image.row(top + y) + left, side);
  }
}

void KltReference::cut(const Eigen::Matrix2f& current_from_reference, KltPatch& patch) const {
  // A window with hardly any rotation is cut out without resampling.
  constexpr float hardly = 0.03F;
  const std::ptrdiff_t side = stride();
  if ((current_from_reference - Eigen::Matrix2f::Identity()).cwiseAbs().maxCoeff() < hardly) {
    const std::uint8_t* corner = pixels_.data() + (margin() + 1) * (side + 1);
    klt_kernels().cut({corner, side, fraction_x_, fraction_y_}, size_, patch);
    return;
  }
  constexpr float one = 65536.0F;
  const auto fixed = [](float pixels) { return static_cast<std::int32_t>(std::lround(pixels * one)); };
  const Eigen::Matrix2f reference_from_current = current_from_reference.inverse();
  KltRotation rotation;
  rotation.pixels = pixels_.data();
  rotation.side = stride();
  rotation.across_x = fixed(reference_from_current(0, 0));
  rotation.across_y = fixed(reference_from_current(1, 0));
  rotation.down_x = fixed(reference_from_current(0, 1));
  rotation.down_y = fixed(reference_from_current(1, 1));
  rotation.rows = size_ + 3;
  // The window's center is fixed; fractions of the corner come in 1/32768.
  const int half = 1 + size_ / 2, middle = (margin() + half) * 65536;
  rotation.x = middle + 2 * fraction_x_ - half * (rotation.across_x + rotation.down_x);
  rotation.y = middle + 2 * fraction_y_ - half * (rotation.across_y + rotation.down_y);
  std::array<std::uint8_t, KltRotation::row_length*(klt_largest_window + 3) + 64> rotated{};
  klt_kernels().rotate(rotation, rotated.data());
  klt_kernels().cut({rotated.data() + KltRotation::row_length + 1, KltRotation::row_length, 0, 0}, size_, patch);
}

KltResult KltReference::align(const Pyramid& current, const Eigen::Vector2f& guess, double reach_px,
                              const KltOptions& options, const Eigen::Matrix2f& current_from_reference) const {
  if (empty()) return {};
  const KltKernels& kernels = klt_kernels();
  KltPatch patch;
  cut(current_from_reference, patch);
  const StepSolver solver(patch, options.min_eigenvalue);
  const PaddedImage& image = current.level(0);
  Eigen::Vector2d at = guess.cast<double>();
  if (!solver.solvable() || !align_patch(image, patch, solver, options, kernels, reach_px, options.epsilon_px, at) ||
      !inside(image, at))
    return {};
  const auto window = window_of(image, at.x(), at.y(), size_);
  if (!window) return {};
  const double ratio = ratio_of(kernels.residual(*window, patch), size_);
  return {at.cast<float>(), ratio <= options.max_residual_ratio, static_cast<float>(ratio)};
}

double KltReference::residual_ratio(const Pyramid& current, const Eigen::Vector2f& point,
                                    const Eigen::Matrix2f& current_from_reference) const {
  constexpr double outside = 1e9;
  if (empty()) return outside;
  const KltKernels& kernels = klt_kernels();
  KltPatch patch;
  cut(current_from_reference, patch);
  const auto window =
      window_of(current.level(0), static_cast<double>(point.x()), static_cast<double>(point.y()), size_);
  return window ? ratio_of(kernels.residual(*window, patch), size_) : outside;
}

}  // namespace rastro
