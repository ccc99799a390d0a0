// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_edge.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Across the edge: as many as there is room for, so that a near view takes no longer than others. Below the fewest the
/// search region is larger than most images.
constexpr double most_samples_per_pixel = 2.0, fewest_samples_per_pixel = 0.5;
constexpr double blur_samples = 1.4;  ///< Standard deviation of the Gaussian whose derivative detects the change.
constexpr int kernel_radius = 4;
constexpr double coarsest_radius_px = 2.5;  ///< Minimum pixels in the radius to resolve lines.
constexpr int fewest_profiles = 9, most_profiles = 161, most_offsets = 801;
constexpr double steepest = 0.14;        ///< Maximum tangent of the angle to the rough direction.
constexpr double largest_change = 25.0;  ///< Intensity levels per pixel; more counts as this.
constexpr double smallest_score = 1.5;   ///< Intensity levels per pixel.
/// An edge of twice the contrast is not twice as likely: this many intensity levels per pixel count half of infinitely
/// many.
constexpr double half_score = 5.0;
constexpr double weakest_share = 0.08;  ///< Of the best score.
constexpr int segments = 4;             ///< Along the edge, each with its own sign.
constexpr std::size_t most_edges = 6;
constexpr double min_distance_samples = 2.0;  ///< Maxima closer than this are one.
constexpr double reach_samples = 3.0;         ///< From the line to the peak of a profile.
constexpr double image_sigma_px = 0.12;       ///< Common shift of all profiles by blur and compression.

/// The part of the face around the rough point, rectified: sample (row, column) is at along(row), across(column).
struct Strip {
  Vector3d origin, along, across;  ///< Camera frame.
  double step_along = 0.0, step_across = 0.0;
  double samples_per_pixel = most_samples_per_pixel;  ///< Across.
  int rows = 0, columns = 0;
  std::vector<float> change;  ///< Across the edge, intensity levels per pixel; NaN outside the image.

  double s(double row) const { return (row - 0.5 * (rows - 1)) * step_along; }
  double t(double column) const { return (column - 0.5 * (columns - 1)) * step_across; }
  Vector3d point(double row, double column) const { return origin + s(row) * along + t(column) * across; }
  float at(int row, int column) const {
    return change[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
  }
};

/// A line in a strip: the column at a row is `column + slope * (row - middle)`.
struct StripLine {
  double column = 0.0, slope = 0.0, score = 0.0;
  double sigma_column = 0.0;

  double at(const Strip& strip, double row) const { return column + slope * (row - 0.5 * (strip.rows - 1)); }
};

float gray_at(const GrayImage& gray, const Vector2d& pixel) {
  const double x = std::floor(pixel.x()), y = std::floor(pixel.y());
  if (!(x >= 0.0 && y >= 0.0 && x < gray.width() - 1 && y < gray.height() - 1))
    return std::numeric_limits<float>::quiet_NaN();
  const auto u = static_cast<int>(x), v = static_cast<int>(y);
  const auto dx = static_cast<float>(pixel.x() - x), dy = static_cast<float>(pixel.y() - y);
  const std::uint8_t* upper = gray.row(v) + u;
  const std::uint8_t* lower = gray.row(v + 1) + u;
  const float top = static_cast<float>(upper[0]) * (1.0F - dx) + static_cast<float>(upper[1]) * dx;
  const float bottom = static_cast<float>(lower[0]) * (1.0F - dx) + static_cast<float>(lower[1]) * dx;
  return top * (1.0F - dy) + bottom * dy;
}

double pixels_per_meter(const Camera& camera, const Vector3d& point, const Vector3d& direction) {
  constexpr double step = 1e-3;
  const auto here = camera.project(point), there = camera.project(point + step * direction);
  return here && there ? (*there - *here).norm() / step : 0.0;
}

/// Derivative of a Gaussian, per pixel.
std::vector<float> derivative_kernel(double samples_per_pixel) {
  std::vector<float> kernel;
  double sum = 0.0;
  for (int k = -kernel_radius; k <= kernel_radius; ++k) {
    const double x = k / blur_samples;
    kernel.push_back(static_cast<float>(x * std::exp(-0.5 * x * x)));
    sum += static_cast<double>(kernel.back()) * k;
  }
  for (float& value : kernel) value = static_cast<float>(static_cast<double>(value) * samples_per_pixel / sum);
  return kernel;
}

void fill_changes(const LengthView& view, Strip& strip) {
  const std::vector<float> kernel = derivative_kernel(strip.samples_per_pixel);
  std::vector<float> profile(static_cast<std::size_t>(strip.columns + 2 * kernel_radius));
  strip.change.resize(static_cast<std::size_t>(strip.rows) * static_cast<std::size_t>(strip.columns));
  float* change = strip.change.data();
  for (int row = 0; row < strip.rows; ++row) {
    for (int k = 0; k < strip.columns + 2 * kernel_radius; ++k) {
      const auto pixel = view.camera.project(strip.point(row, k - kernel_radius));
      profile[static_cast<std::size_t>(k)] =
          pixel ? gray_at(view.gray, *pixel) : std::numeric_limits<float>::quiet_NaN();
    }
    for (int column = 0; column < strip.columns; ++column) {
      float sum = 0.0F;
      for (std::size_t k = 0; k < kernel.size(); ++k) sum += kernel[k] * profile[static_cast<std::size_t>(column) + k];
      *change++ = sum;
    }
  }
}

std::optional<Strip> strip_of(const LengthView& view, const LengthFace& face, const LengthEdgeSearch& search) {
  Strip strip;
  const Vector3d normal = face.normal();
  strip.origin = face.foot(search.spot);
  strip.along = search.direction - search.direction.dot(normal) * normal;
  if (strip.along.norm() < 0.5 || strip.origin.z() < 0.1) return std::nullopt;
  strip.along.normalize();
  strip.across = normal.cross(strip.along);
  if (strip.across.dot(search.inwards) < 0.0) strip.across = -strip.across;
  const double across = pixels_per_meter(view.camera, strip.origin, strip.across);
  const double along = pixels_per_meter(view.camera, strip.origin, strip.along);
  const double radius_px = across * search.radius_m;
  if (radius_px < coarsest_radius_px || !(along > 0.0)) return std::nullopt;
  constexpr int most_beside = (most_offsets - 1) / 2;
  strip.samples_per_pixel = std::min(most_samples_per_pixel, most_beside / radius_px);
  if (strip.samples_per_pixel < fewest_samples_per_pixel) return std::nullopt;
  const auto columns_beside = static_cast<int>(std::ceil(radius_px * strip.samples_per_pixel));
  strip.columns = 2 * std::min(columns_beside, most_beside) + 1;
  strip.rows = 2 * static_cast<int>(std::ceil(search.half_length_m * along)) + 1;
  if (strip.rows < fewest_profiles) return std::nullopt;
  strip.rows = std::min(strip.rows, most_profiles);
  strip.step_across = 1.0 / (across * strip.samples_per_pixel);
  strip.step_along = 2.0 * search.half_length_m / (strip.rows - 1);
  fill_changes(view, strip);
  return strip;
}

/// Mean change along a line; signs may differ between its segments. Zero if less than half of it is in the image.
double score_of(const Strip& strip, const StripLine& line) {
  double total = 0.0;
  int seen = 0;
  for (int segment = 0; segment < segments; ++segment) {
    const int begin = strip.rows * segment / segments, end = strip.rows * (segment + 1) / segments;
    double sum = 0.0;
    for (int row = begin; row < end; ++row) {
      const double column = line.at(strip, row);
      const auto left = static_cast<int>(std::floor(column));
      if (left < 0 || left >= strip.columns - 1) continue;
      const double part = column - left;
      const double change =
          (1.0 - part) * static_cast<double>(strip.at(row, left)) + part * static_cast<double>(strip.at(row, left + 1));
      if (!std::isfinite(change)) continue;
      sum += std::clamp(change, -largest_change, largest_change);
      ++seen;
    }
    total += std::abs(sum);
  }
  return 2 * seen >= strip.rows ? total / seen : 0.0;
}

StripLine best_slope(const Strip& strip, int column) {
  const double half_rows = 0.5 * (strip.rows - 1);
  const double steepest_samples = steepest * strip.step_along / strip.step_across;
  const int slopes = std::clamp(static_cast<int>(std::ceil(steepest_samples * half_rows)), 1, 30);
  StripLine best;
  for (int k = -slopes; k <= slopes; ++k) {
    StripLine line{static_cast<double>(column), steepest_samples * k / slopes, 0.0, 0.0};
    line.score = score_of(strip, line);
    if (line.score > best.score) best = line;
  }
  return best;
}

/// Position of the profile's peak change near `column`, with subsample accuracy; nullopt without a peak of that sign.
std::optional<double> peak_near(const Strip& strip, int row, double column, double sign) {
  const int begin = std::max(1, static_cast<int>(std::ceil(column - reach_samples)));
  const int end = std::min(strip.columns - 2, static_cast<int>(std::floor(column + reach_samples)));
  int best = -1;
  double most = 0.0;
  for (int k = begin; k <= end; ++k) {
    const double value = sign * static_cast<double>(strip.at(row, k));
    if (value > most) most = value, best = k;
  }
  if (best < 0) return std::nullopt;
  const double before = sign * static_cast<double>(strip.at(row, best - 1));
  const double after = sign * static_cast<double>(strip.at(row, best + 1));
  const double bend = before - 2.0 * most + after;
  if (!(bend < 0.0) || before > most || after > most) return std::nullopt;
  return best + 0.5 * (before - after) / bend;
}

struct Peak {
  double row = 0.0, column = 0.0;  ///< Row relative to the middle.
};

std::vector<Peak> peaks_along(const Strip& strip, const StripLine& line) {
  std::vector<Peak> peaks;
  for (int segment = 0; segment < segments; ++segment) {
    const int begin = strip.rows * segment / segments, end = strip.rows * (segment + 1) / segments;
    double sum = 0.0;
    for (int row = begin; row < end; ++row) {
      const int column = std::clamp(static_cast<int>(std::lround(line.at(strip, row))), 0, strip.columns - 1);
      const auto change = static_cast<double>(strip.at(row, column));
      if (std::isfinite(change)) sum += std::clamp(change, -largest_change, largest_change);
    }
    for (int row = begin; row < end; ++row) {
      const auto column = peak_near(strip, row, line.at(strip, row), sum < 0.0 ? -1.0 : 1.0);
      if (column) peaks.push_back({row - 0.5 * (strip.rows - 1), *column});
    }
  }
  return peaks;
}

/// Line through the peaks; nullopt if they are too few or do not agree.
std::optional<StripLine> refined(const Strip& strip, const StripLine& rough) {
  const std::vector<Peak> peaks = peaks_along(strip, rough);
  if (static_cast<int>(peaks.size()) < std::max(fewest_profiles - 2, strip.rows / 3)) return std::nullopt;
  StripLine line = rough;
  Eigen::Matrix2d information;
  double weights = 0.0, squares = 0.0;
  for (int round = 0; round < 6; ++round) {
    const TukeyKernel kernel{round < 2 ? 4.0 : 2.0};
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    weights = squares = 0.0;
    for (const Peak& peak : peaks) {
      const double error = peak.column - (line.column + line.slope * peak.row);
      const double weight = kernel.weight(error * error);
      const Eigen::Vector2d factors(1.0, peak.row);
      normal += weight * factors * factors.transpose();
      right += weight * peak.column * factors;
      weights += weight;
      squares += weight * error * error;
    }
    if (weights < fewest_profiles - 2 || normal.determinant() < 1e-6) return std::nullopt;
    const Eigen::Vector2d solution = normal.ldlt().solve(right);
    line.column = solution[0], line.slope = solution[1];
    information = normal;
  }
  const double scatter = std::sqrt(squares / weights);
  // Neighboring profiles share pixels, so they count half.
  line.sigma_column = std::max(scatter, 0.2) * std::sqrt(2.0 * information.inverse()(0, 0));
  line.sigma_column = std::hypot(line.sigma_column, image_sigma_px * strip.samples_per_pixel);
  return line;
}

/// Depths beside a line relative to the face.
struct BesideLine {
  int measured = 0, on_face = 0, nearer = 0;
  double share(int count) const { return measured >= 8 ? static_cast<double>(count) / measured : 0.5; }
};

BesideLine beside(const LengthView& view, const LengthFace& face, const Strip& strip, const StripLine& line, int side) {
  BesideLine counts;
  for (int row = 0; row < strip.rows; row += 2) {
    for (const double pixels : {1.5, 2.5, 3.5}) {
      const Vector3d point = strip.point(row, line.at(strip, row) + side * pixels * strip.samples_per_pixel);
      const auto pixel = view.camera.project(point);
      if (!pixel) continue;
      const auto x = static_cast<int>(std::lround(pixel->x())), y = static_cast<int>(std::lround(pixel->y()));
      if (x < 0 || y < 0 || x >= view.depth.width() || y >= view.depth.height()) continue;
      const auto z = static_cast<double>(view.depth.at(x, y));
      if (!(z > 0.0)) continue;
      const double expected = face.depth_at(point / point.z());
      const double gate = std::max(0.01, 3.0 * view.depth_sigma(expected));
      ++counts.measured;
      if (std::abs(z - expected) <= gate) ++counts.on_face;
      if (z < expected - gate) ++counts.nearer;
    }
  }
  return counts;
}

/// Depth evidence for a line: the face should be on its inner side, end there, and not be occluded.
double depth_factor(const LengthView& view, const LengthFace& face, const Strip& strip, const StripLine& line) {
  if (!(face.support > 0.0)) return 1.0;
  const BesideLine inner = beside(view, face, strip, line, 1), outer = beside(view, face, strip, line, -1);
  const double hidden = outer.measured >= 8 ? outer.share(outer.nearer) : 0.0;
  const double carried = inner.share(inner.on_face);
  return (0.05 + 0.95 * carried * carried) * (2.0 - outer.share(outer.on_face)) * (1.0 - 0.9 * hidden);
}

LengthEdge edge_of(const LengthView& view, const LengthFace& face, const Strip& strip, const StripLine& line) {
  LengthEdge edge;
  const double middle = 0.5 * (strip.rows - 1);
  edge.point = strip.point(middle, line.column);
  edge.direction = (strip.step_along * strip.along + line.slope * strip.step_across * strip.across).normalized();
  const Vector3d ray = edge.point / edge.point.z();
  const double sigma_across = line.sigma_column * strip.step_across, sigma_depth = face.depth_sigma_at(ray);
  edge.covariance = sigma_across * sigma_across * strip.across * strip.across.transpose() +
                    sigma_depth * sigma_depth * ray * ray.transpose();
  edge.pixel_m = strip.samples_per_pixel * strip.step_across;
  edge.score = line.score / (line.score + half_score) * depth_factor(view, face, strip, line);
  for (int end = 0; end < 2; ++end) {
    const double row = end * (strip.rows - 1);
    const auto pixel = view.camera.project(strip.point(row, line.at(strip, row)));
    if (pixel) edge.pixels[static_cast<std::size_t>(end)] = *pixel;
  }
  return edge;
}

/// Maxima over the columns, best first.
std::vector<StripLine> strong_lines(const Strip& strip) {
  std::vector<StripLine> all, peaks, kept;
  for (int column = 1; column < strip.columns - 1; ++column) all.push_back(best_slope(strip, column));
  for (std::size_t k = 1; k + 1 < all.size(); ++k)
    if (all[k].score >= all[k - 1].score && all[k].score > all[k + 1].score) peaks.push_back(all[k]);
  all.swap(peaks);
  std::stable_sort(all.begin(), all.end(), [](const StripLine& a, const StripLine& b) { return a.score > b.score; });
  for (const StripLine& line : all) {
    if (line.score < std::max(smallest_score, weakest_share * all.front().score) || kept.size() == most_edges) break;
    const bool alone = std::all_of(kept.begin(), kept.end(), [&](const StripLine& other) {
      return std::abs(other.column - line.column) >= min_distance_samples;
    });
    if (alone) kept.push_back(line);
  }
  return kept;
}

}  // namespace

std::vector<LengthEdge> find_edges(const LengthView& view, const LengthFace& face, const LengthEdgeSearch& search) {
  std::vector<LengthEdge> edges;
  const auto strip = strip_of(view, face, search);
  if (!strip) return edges;
  std::vector<StripLine> lines;
  for (const StripLine& rough : strong_lines(*strip)) {
    const auto line = refined(*strip, rough);
    if (!line || std::abs(line->column - rough.column) > reach_samples) continue;
    const bool known = std::any_of(lines.begin(), lines.end(), [&](const StripLine& other) {
      return std::abs(other.column - line->column) < min_distance_samples;
    });
    if (!known) lines.push_back(*line);
  }
  for (const StripLine& line : lines) edges.push_back(edge_of(view, face, *strip, line));
  std::stable_sort(edges.begin(), edges.end(),
                   [](const LengthEdge& a, const LengthEdge& b) { return a.score > b.score; });
  return edges;
}

}  // namespace rastro
