// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/essential.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/math/median.h"
#include "rastro/math/robust_kernel.h"
#include "rastro/multiview/ransac.h"
#include "rastro/multiview/sampson_errors.h"

namespace rastro {
namespace {

/// Two rotations and a direction: the four motions of E are both rotations with both signs.
struct Decomposition {
  std::array<Eigen::Matrix3d, 2> rotations;
  Eigen::Vector3d direction;
};

Decomposition decompose(const Eigen::Matrix3d& essential) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV();
  if (u.determinant() < 0.0) u.col(2) *= -1.0;
  if (v.determinant() < 0.0) v.col(2) *= -1.0;
  Eigen::Matrix3d quarter_rotation;
  quarter_rotation << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  return {{u * quarter_rotation * v.transpose(), u * quarter_rotation.transpose() * v.transpose()}, u.col(2)};
}

bool counts(std::span<const std::uint8_t> is_inlier, std::size_t i) { return is_inlier.empty() || is_inlier[i] != 0; }

/// A unit vector moved within its tangent plane.
struct Direction {
  Eigen::Vector3d value;
  Eigen::Matrix<double, 3, 2> tangents() const {
    const Eigen::Vector3d first = value.unitOrthogonal();
    return (Eigen::Matrix<double, 3, 2>() << first, value.cross(first)).finished();
  }
  Direction moved(const Eigen::Vector2d& step) const { return {(value + tangents() * step).normalized()}; }
};

using Matrix5x9 = Eigen::Matrix<double, 5, 9>;
using Row9 = Eigen::Matrix<double, 1, 9>;

/// Derivatives of E's coefficients (row by row) by a rotation of R from the left and a motion of t in its tangent
/// plane.
Matrix5x9 essential_derivatives(const Eigen::Matrix3d& rotation, const Direction& direction) {
  const Eigen::Matrix3d cross = hat(direction.value);
  const Eigen::Matrix<double, 3, 2> tangents = direction.tangents();
  Matrix5x9 derivatives;
  for (int i = 0; i < 5; ++i) {
    const Eigen::Matrix3d d = i < 3 ? Eigen::Matrix3d(cross * hat(Eigen::Vector3d::Unit(i)) * rotation)
                                    : Eigen::Matrix3d(hat(tangents.col(i - 3)) * rotation);
    derivatives.row(i) << d.row(0), d.row(1), d.row(2);
  }
  return derivatives;
}

/// Sampson distance and its derivative by E's coefficients.
struct SampsonTerm {
  double distance;
  Eigen::Matrix<double, 9, 1> gradient;
};

SampsonTerm sampson_term(const Eigen::Matrix3d& e, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector3d p = a.homogeneous(), q = b.homogeneous(), line_b = e * p, line_a = e.transpose() * q;
  const double square = line_b.head<2>().squaredNorm() + line_a.head<2>().squaredNorm() + 1e-30;
  const double scale = 1.0 / std::sqrt(square), distance = q.dot(line_b) * scale;
  const double bend = distance / square;  // how the distance shrinks with the lines' lengths
  SampsonTerm term;
  term.distance = distance;
  for (int r = 0; r < 3; ++r) {
    const double along_p = scale * q(r) - (r < 2 ? bend * line_b(r) : 0.0);
    for (int c = 0; c < 3; ++c) term.gradient(3 * r + c) = along_p * p(c) - (c < 2 ? bend * line_a(c) * q(r) : 0.0);
  }
  return term;
}

struct Motion {
  SO3 rotation;
  Direction direction;
  Eigen::Matrix3d essential() const { return hat(direction.value) * rotation.matrix(); }
};

/// One Gauss-Newton step over the pairs that `use` accepts, those with errors beyond `kernel` down-weighted; nullopt if
/// they do not determine it.
template <typename Use>
std::optional<Motion> step_from(const Motion& motion, std::span<const Eigen::Vector2d> a,
                                std::span<const Eigen::Vector2d> b, const CauchyKernel& kernel, const Use& use) {
  const Eigen::Matrix3d essential = motion.essential();
  const Matrix5x9 derivatives = essential_derivatives(motion.rotation.matrix(), motion.direction);
  Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!use(i)) continue;
    const SampsonTerm term = sampson_term(essential, a[i], b[i]);
    const Eigen::Matrix<double, 5, 1> row = derivatives * term.gradient;
    const double weight = kernel.weight(term.distance * term.distance);
    normal.noalias() += weight * row * row.transpose();
    right.noalias() -= weight * term.distance * row;
  }
  // A little damping keeps unobservable directions (the translation without motion) fixed.
  normal.diagonal().array() += 1e-12 * normal.trace() + 1e-300;
  const Eigen::Matrix<double, 5, 1> step = normal.ldlt().solve(right);
  if (!step.allFinite() || step.norm() > 1.0) return std::nullopt;
  return Motion{SO3::exp(step.head<3>()) * motion.rotation, motion.direction.moved(step.tail<2>())};
}

/// All four motions of E have the same E up to its sign, so any of them may be refined.
Motion motion_of(const Eigen::Matrix3d& essential) {
  const Decomposition parts = decompose(essential);
  return {SO3::from_matrix(parts.rotations[0]), {parts.direction}};
}

/// Gauss-Newton over the pairs with is_inlier.
std::optional<Motion> refined_over(Motion motion, std::span<const Eigen::Vector2d> a,
                                   std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier,
                                   const CauchyKernel& kernel, int iterations) {
  for (int i = 0; i < iterations; ++i) {
    const auto next = step_from(motion, a, b, kernel, [&](std::size_t k) { return counts(is_inlier, k); });
    if (!next) return std::nullopt;
    const double change = (next->essential() - motion.essential()).norm();
    motion = *next;
    if (change < 1e-13) break;
  }
  return motion;
}

class EssentialProblem {
 public:
  static constexpr std::size_t sample_size = 5;
  EssentialProblem(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                   const CalibratedRansacOptions& options)
      : a_(a), b_(b), focal_px_(options.focal_px), kernel_width_px_(options.max_error_px / 3.0) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      pixels_.add((focal_px_ * a[i]).cast<float>(), (focal_px_ * b[i]).cast<float>());
    }
  }

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 5>& sample, Sink&& sink) const {
    for (const Eigen::Matrix3d& model : essential_from_five(a_, b_, sample.data())) sink(model);
  }

  void errors(const Eigen::Matrix3d& essential, float* out) const {
    const Eigen::DiagonalMatrix<double, 3> to_rays(1.0 / focal_px_, 1.0 / focal_px_, 1.0);
    Eigen::Matrix3d fundamental = to_rays * essential * to_rays;
    fundamental /= fundamental.norm();
    sampson_errors(fundamental.cast<float>(), pixels_, out);
  }

  std::optional<Eigen::Matrix3d> refit(const RobustFit& best, float limit) const {
    if (best.inliers < 6) return std::nullopt;
    Motion motion = motion_of(best.model);
    for (int i = 0; i < 2; ++i) {
      const auto next =
          step_from(motion, a_, b_, kernel(), [&](std::size_t k) { return best.squared_errors[k] <= limit; });
      if (!next) return std::nullopt;
      motion = *next;
    }
    return motion.essential();
  }

  /// An outlier near its epipolar line by chance would pull a least-squares model towards itself and so stay an inlier.
  CauchyKernel kernel() const { return {kernel_width_px_ / focal_px_}; }
  double cost(const std::vector<float>& squared_errors, double max_error_px) const {
    const CauchyKernel in_pixels{kernel_width_px_};
    double sum = 0.0;
    for (const float e : squared_errors) {
      const double squared = static_cast<double>(e), limit = max_error_px * max_error_px;
      sum += in_pixels.cost(squared < limit ? squared : limit);
    }
    return sum;
  }

 private:
  std::span<const Eigen::Vector2d> a_, b_;
  double focal_px_, kernel_width_px_;
  PointPairs pixels_;
};

std::vector<std::uint8_t> inliers_of(const std::vector<float>& squared_errors, double max_error_px) {
  const auto limit = static_cast<float>(max_error_px * max_error_px);
  std::vector<std::uint8_t> flags(squared_errors.size());
  std::transform(squared_errors.begin(), squared_errors.end(), flags.begin(),
                 [=](float e) { return static_cast<std::uint8_t>(e <= limit); });
  return flags;
}

/// Refines over pairs within a wide limit first, since a model of few pairs rejects some of the true ones; keeps the
/// best of all stages.
void polish(const EssentialProblem& problem, std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
            double max_error_px, RobustFit& best) {
  double best_cost = problem.cost(best.squared_errors, max_error_px);
  std::vector<float> errors = best.squared_errors;
  Motion motion = motion_of(best.model);
  const auto refine_over = [&](const Motion& from, const std::vector<std::uint8_t>& is_inlier, int iterations) {
    const auto refined = refined_over(from, a, b, is_inlier, problem.kernel(), iterations);
    if (refined) problem.errors(refined->essential(), errors.data());
    return refined;
  };
  for (const double widening : {2.5, 1.5, 1.0}) {
    const auto refined = refine_over(motion, inliers_of(errors, widening * max_error_px), 4);
    if (!refined) break;
    motion = *refined;
    const double cost = problem.cost(errors, max_error_px);
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best.model = motion.essential();
    best.squared_errors = errors;
  }
  if (const auto refined = refine_over(motion_of(best.model), inliers_of(best.squared_errors, max_error_px), 5)) {
    best.model = refined->essential();
    best.squared_errors = errors;
  }
}

/// Median angle between the directions to the points after removing the rotation.
double median_parallax_deg(const Eigen::Matrix3d& rotation, std::span<const Eigen::Vector2d> a,
                           std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!counts(is_inlier, i)) continue;
    const Eigen::Vector3d p = rotation * a[i].homogeneous(), q = b[i].homogeneous();
    const double angle = std::atan2(p.cross(q).norm(), p.dot(q));
    if (std::isfinite(angle)) angles.push_back(angle);
  }
  return upper_median_or(std::move(angles), 0.0) * 180.0 / std::numbers::pi;
}

}  // namespace

Eigen::Matrix3d essential_of(const SE3& second_from_first) {
  return hat(second_from_first.translation().normalized()) * second_from_first.rotation().matrix();
}

std::optional<RecoveredPose> recover_pose(const Eigen::Matrix3d& essential, std::span<const Eigen::Vector2d> a,
                                          std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier) {
  RASTRO_CHECK(a.size() == b.size() && (is_inlier.empty() || is_inlier.size() == a.size()), "pairs have two points");
  if (!essential.allFinite()) return std::nullopt;
  const Decomposition parts = decompose(essential);
  std::array<int, 4> in_front{};
  for (std::size_t r = 0; r < 2; ++r) {
    const Eigen::Vector3d& t = parts.direction;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (!counts(is_inlier, i)) continue;
      // Signs of the depths at which the rays are closest to each other.
      const Eigen::Vector3d p = parts.rotations[r] * a[i].homogeneous(), q = b[i].homogeneous();
      const double pp = p.squaredNorm(), qq = q.squaredNorm(), pq = p.dot(q), pt = p.dot(t), qt = q.dot(t);
      const double first = pq * qt - pt * qq, second = pp * qt - pq * pt;
      if (first > 0.0 && second > 0.0) ++in_front[2 * r];
      if (first < 0.0 && second < 0.0) ++in_front[2 * r + 1];
    }
  }
  const auto best = static_cast<std::size_t>(std::max_element(in_front.begin(), in_front.end()) - in_front.begin());
  if (in_front[best] == 0) return std::nullopt;
  const Eigen::Matrix3d& rotation = parts.rotations[best / 2];
  RecoveredPose pose;
  pose.second_from_first = SE3(SO3::from_matrix(rotation), best % 2 == 0 ? parts.direction : -parts.direction);
  pose.in_front = in_front[best];
  std::swap(in_front[best], in_front[3]);
  pose.runner_up = *std::max_element(in_front.begin(), in_front.begin() + 3);
  pose.median_parallax_deg = median_parallax_deg(rotation, a, b, is_inlier);
  return pose;
}

std::optional<SE3> refine_relative_pose(const SE3& start, std::span<const Eigen::Vector2d> a,
                                        std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier,
                                        int iterations) {
  RASTRO_CHECK(a.size() == b.size() && (is_inlier.empty() || is_inlier.size() == a.size()), "pairs have two points");
  if (!(start.translation().norm() > 0.0)) return std::nullopt;
  const auto motion =
      refined_over({start.rotation(), {start.translation().normalized()}}, a, b, is_inlier, {1e9}, iterations);
  if (!motion) return std::nullopt;
  return SE3(motion->rotation, motion->direction.value);
}

std::optional<EssentialFit> estimate_essential(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                               const CalibratedRansacOptions& options) {
  RASTRO_CHECK(a.size() == b.size(), "pairs have two points");
  const EssentialProblem problem(a, b, options);
  auto found = ransac_of<Eigen::Matrix3d>(problem, a.size(), options);
  if (!found || found->inliers < 5) return std::nullopt;
  if (found->inliers > 5) polish(problem, a, b, options.max_error_px, *found);
  EssentialFit fit;
  fit.is_inlier = inliers_of(found->squared_errors, options.max_error_px);
  fit.inliers = static_cast<int>(std::count(fit.is_inlier.begin(), fit.is_inlier.end(), 1));
  fit.iterations = found->iterations;
  const auto pose = recover_pose(found->model, a, b, fit.is_inlier);
  if (!pose) return std::nullopt;
  fit.second_from_first = pose->second_from_first;
  fit.essential = essential_of(fit.second_from_first);
  fit.in_front = pose->in_front;
  fit.median_parallax_deg = pose->median_parallax_deg;
  return fit;
}

}  // namespace rastro
