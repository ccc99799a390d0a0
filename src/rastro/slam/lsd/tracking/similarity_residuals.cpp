// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/similarity_residuals.h"

#include <algorithm>
#include <cmath>

#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

double bilinear_intensity(const PaddedImage& image, double x, double y) {
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const double fraction_x = x - column, fraction_y = y - row;
  const std::uint8_t *above = image.row(row) + column, *below = image.row(row + 1) + column;
  const double top = above[0] + fraction_x * (above[1] - above[0]);
  const double bottom = below[0] + fraction_x * (below[1] - below[0]);
  return top + fraction_y * (bottom - top);
}

/// Derivatives by the tangent of Sim3 of a value whose derivative by the moved point's position, times the inverse
/// depth and turned into a's axes, is `by_ray`: the point moves by rotation x ray + log scale * ray + inverse depth *
/// translation.
SimilarityResidual::Row by_tangent(const Eigen::Vector3d& by_ray, const Eigen::Vector3d& ray, double inverse_depth) {
  SimilarityResidual::Row row = SimilarityResidual::Row::Zero();
  row.head<3>() = inverse_depth * by_ray.transpose();
  row.segment<3>(3) = ray.cross(by_ray).transpose();
  row[6] = by_ray.dot(ray);
  return row;
}

}  // namespace

/// What all points have in common.
struct SimilarityResiduals::Motion {
  explicit Motion(const State& state)
      : scaled_rotation(state.b_from_a.scale() * state.b_from_a.rotation().matrix()),
        inverse_rotation(scaled_rotation.transpose()),
        translation(state.b_from_a.translation()),
        brightness(state.brightness) {
    // The gradient of a, rotated about the optical axis, as in AlignmentKernels.
    const Eigen::Vector2d axis(scaled_rotation(0, 0) + scaled_rotation(1, 1),
                               scaled_rotation(1, 0) - scaled_rotation(0, 1));
    gradient_turn = brightness.gain * axis.normalized();
  }

  Eigen::Matrix3d scaled_rotation, inverse_rotation;  ///< The latter times the square of the scale.
  Eigen::Vector3d translation;
  AffineBrightness brightness;
  Eigen::Vector2d gradient_turn;
};

/// A point of a moved into b: `scaled` is its position times its inverse depth in a.
struct SimilarityResiduals::Projected {
  std::size_t point;
  Eigen::Vector3d ray, scaled;
  double inverse_depth, depth_variance;  ///< In a.
  Eigen::Vector2d pixel;
};

double SimilarityResidual::squared_error() const {
  const double photometric = intensity * intensity / intensity_variance;
  return has_depth ? photometric + inverse_depth * inverse_depth / inverse_depth_variance : photometric;
}

SimilarityResidual SimilarityResiduals::residual(int point, const State& state) const {
  return residual(point, Motion(state));
}

SimilarityResidual SimilarityResiduals::residual(int point, const Motion& motion) const {
  SimilarityResidual result;
  Projected p;
  p.point = static_cast<std::size_t>(point);
  p.ray = {static_cast<double>(points_.x[p.point]), static_cast<double>(points_.y[p.point]), 1.0};
  p.inverse_depth = static_cast<double>(points_.inverse_depth[p.point]);
  p.depth_variance = static_cast<double>(points_.variance[p.point]);
  p.scaled = motion.scaled_rotation * p.ray + p.inverse_depth * motion.translation;
  if (!(p.scaled.z() > 0.0)) return result;
  const LevelCamera& camera = points_.camera;
  p.pixel = {camera.fx * p.scaled.x() / p.scaled.z() + camera.cx, camera.fy * p.scaled.y() / p.scaled.z() + camera.cy};
  result.inside =
      p.pixel.x() >= 0.0 && p.pixel.x() < image_.width() - 1 && p.pixel.y() >= 0.0 && p.pixel.y() < image_.height() - 1;
  if (!result.inside) return result;
  set_intensity(p, motion, result);
  if (result.used) set_inverse_depth(p, motion, result);
  return result;
}

void SimilarityResiduals::set_intensity(const Projected& p, const Motion& motion, SimilarityResidual& result) const {
  const double in_b = bilinear_intensity(image_, p.pixel.x(), p.pixel.y()), gain = motion.brightness.gain;
  result.used = in_b > noise_.darkest && in_b < noise_.brightest;
  if (!result.used) return;
  const auto in_a = static_cast<double>(points_.intensity[p.point]);
  result.intensity = in_b - gain * in_a - motion.brightness.offset;
  const Eigen::Vector2d& turn = motion.gradient_turn;
  const auto gx = static_cast<double>(points_.gradient_x[p.point]),
             gy = static_cast<double>(points_.gradient_y[p.point]);
  const Eigen::Vector2d gradient(turn.x() * gx - turn.y() * gy, turn.y() * gx + turn.x() * gy);
  const Eigen::Vector3d by_position(gradient.x() / p.scaled.z(), gradient.y() / p.scaled.z(),
                                    -gradient.dot(p.scaled.head<2>()) / (p.scaled.z() * p.scaled.z()));
  result.by_state_intensity = by_tangent(motion.inverse_rotation * by_position, p.ray, p.inverse_depth);
  result.by_state_intensity[7] = -in_a;
  result.by_state_intensity[8] = -1.0;
  const double by_inverse_depth = by_position.dot(motion.translation);
  result.intensity_variance = (1.0 + gain * gain) * noise_.intensity_sigma * noise_.intensity_sigma +
                              by_inverse_depth * by_inverse_depth * p.depth_variance;
}

void SimilarityResiduals::set_inverse_depth(const Projected& p, const Motion& motion,
                                            SimilarityResidual& result) const {
  const int x = static_cast<int>(std::lround(p.pixel.x())), y = static_cast<int>(std::lround(p.pixel.y()));
  result.has_depth = depth_.is_known(x, y);
  if (!result.has_depth) return;
  const double z = p.scaled.z();
  result.inverse_depth = p.inverse_depth / z - static_cast<double>(depth_.mean.at(x, y));
  const Eigen::Vector3d by_position(0.0, 0.0, -p.inverse_depth / (z * z));
  result.by_state_inverse_depth = by_tangent(motion.inverse_rotation * by_position, p.ray, p.inverse_depth);
  const double by_inverse_depth = (z - p.inverse_depth * motion.translation.z()) / (z * z);
  result.inverse_depth_variance =
      static_cast<double>(depth_.variance.at(x, y)) + by_inverse_depth * by_inverse_depth * p.depth_variance;
}

void SimilarityResiduals::add(const SimilarityResidual& residual, Step& score, Linear& linear) const {
  linear.inside += residual.inside;
  if (!residual.used) return;
  const HuberKernel huber{noise_.huber_width};
  const double squared = residual.squared_error(), weight = huber.weight(squared);
  ++linear.used;
  linear.with_depth += residual.has_depth;
  // 99.7 % of normal errors, of one or of two residuals.
  linear.inliers += squared < (residual.has_depth ? 11.8 : 9.0);
  linear.cost_sum += huber.cost(squared);
  linear.squares += weight * squared;
  const auto fold = [&](const SimilarityResidual::Row& row, double value, double variance) {
    const double precision = weight / variance;
    for (int column = 0; column < similarity_unknowns; ++column)
      linear.hessian.col(column).head(column + 1) += precision * row[column] * row.head(column + 1).transpose();
    score.noalias() += precision * value * row.transpose();
  };
  fold(residual.by_state_intensity, residual.intensity, residual.intensity_variance);
  if (residual.has_depth)
    fold(residual.by_state_inverse_depth, residual.inverse_depth, residual.inverse_depth_variance);
}

SimilarityResiduals::Linear SimilarityResiduals::linearize(const State& state) const {
  Linear linear;
  const Motion motion(state);
  for (int begin = 0; begin < points_.count; begin += alignment_chunk) {
    Step score = Step::Zero();
    for (int i = begin; i < std::min(begin + alignment_chunk, points_.count); ++i)
      add(residual(i, motion), score, linear);
    linear.scores.push_back(score);
    linear.gradient += score;
  }
  // Only its upper half was added.
  linear.hessian.triangularView<Eigen::StrictlyLower>() = linear.hessian.transpose();
  if (fix_scale_) hold_scale(linear);
  if (linear.used >= similarity_unknowns && linear.with_depth > 0 && state.brightness.plausible())
    linear.cost = linear.cost_sum / linear.used;
  return linear;
}

void SimilarityResiduals::hold_scale(Linear& linear) {
  constexpr int scale = 6;
  const double known = 1e6 * linear.hessian(scale, scale) + 1e6;
  linear.hessian.row(scale).setZero();
  linear.hessian.col(scale).setZero();
  linear.hessian(scale, scale) = known;
  linear.gradient[scale] = 0.0;
  for (Step& score : linear.scores) score[scale] = 0.0;
}

SimilarityState SimilarityResiduals::retract(const State& state, const Step& step) {
  return {state.b_from_a * Sim3::exp(step.head<7>()),
          {state.brightness.gain + step[7], state.brightness.offset + step[8]}};
}

double SimilarityResiduals::step_px(const Step& step) const {
  const auto inverse_depth = static_cast<double>(points_.mean_inverse_depth);
  return points_.camera.fx * (inverse_depth * step.head<3>().norm() + step.segment<3>(3).norm() + std::abs(step[6]));
}

}  // namespace rastro
