// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "rastro/math/se2.h"

namespace rastro {

/// The extended Kalman filter over one robot pose (x, y, angle), the scale of its odometry and any number of landmarks
/// (x, y), poses and landmarks in the world frame; Durrant-Whyte and Bailey 2006, equations 8 to 10. A landmark is
/// measured as its position in the body frame: linear in both positions, and without an angle that wraps. Only the
/// lower triangle of the covariance is stored, so it always stays symmetric.
class EkfFilter {
 public:
  /// The body has exactly this pose, and there are no landmarks. `scale_sigma`: standard deviations of the shares by
  /// which the odometry is wrong for the whole drive, in translation and in rotation (wheels of another size, another
  /// axle track); zero: no share is estimated.
  explicit EkfFilter(const SE2& world_from_body = {}, const Eigen::Vector2d& scale_sigma = Eigen::Vector2d::Zero());

  SE2 world_from_body() const;
  /// The estimated shares, see the constructor: a true motion is 1 + share times what is told.
  Eigen::Vector2d odometry_scale() const { return mean_.segment<2>(3); }
  /// A motion as told, with that scale.
  SE2 scaled(const SE2& last_from_body) const;
  /// Covariance of (x, y, angle) in the world's axes.
  Eigen::Matrix3d body_covariance() const;
  std::size_t landmarks() const { return count_; }
  Eigen::Vector2d landmark(std::size_t number) const { return mean_.segment<2>(row_of(number)); }
  Eigen::Matrix2d landmark_covariance(std::size_t number) const;
  /// Of landmark a with landmark b.
  Eigen::Matrix2d landmark_covariance(std::size_t a, std::size_t b) const;
  /// The full covariance: body, odometry's scale, then landmarks in the order of their numbers. For tests; a copy.
  Eigen::MatrixXd covariance() const;

  /// Prediction step with a motion as told, which the estimated scale corrects. `covariance` is that of the motion's
  /// translation (in the body frame before it) and angle, without the scale's. Linear in the number of landmarks.
  void predict(const SE2& last_from_body, const Eigen::Matrix3d& covariance);

  /// Predicted observation of a landmark, with the covariance from the filter's state; without the sensor's noise.
  struct Expected {
    Eigen::Vector2d in_body;
    Eigen::Matrix2d covariance;
  };
  Expected expected(std::size_t number) const;

  /// Update step with one observed landmark. Joseph's form, (I - KH) P (I - KH)^T + K R K^T, stays positive definite
  /// where rounding breaks the short form. H has five nonzero columns, so the update takes two passes of rank two over
  /// one triangle: quadratic in the number of landmarks. `noise` is positive definite.
  void update(std::size_t number, const Eigen::Vector2d& in_body, const Eigen::Matrix2d& noise);

  /// Update step with the knowledge that two landmarks are the same one, up to `noise`.
  void unite(std::size_t a, std::size_t b, const Eigen::Matrix2d& noise);

  /// Adds a landmark at its first observation; its number is the previous count. Its covariances with the body and with
  /// all other landmarks follow from the body's.
  void add(const Eigen::Vector2d& in_body, const Eigen::Matrix2d& noise);
  /// Removes a landmark; the last one takes its number.
  void remove(std::size_t number);

  /// There will be no more landmarks than this: no memory is taken for more in advance.
  void expect_at_most(std::size_t landmarks) { most_ = landmarks; }
  /// Memory taken, with what is for landmarks to come.
  std::size_t bytes() const { return bytes_for(mean_.size()); }
  /// Memory of so many landmarks without any to come.
  static std::size_t bytes_of(std::size_t landmarks) { return bytes_for(row_of(landmarks)); }

 private:
  using Own = Eigen::Matrix<double, 5, 5>;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 2>;
  using Derivative = Eigen::Matrix<double, 2, 5>;

  /// Body and scale come before the landmarks.
  static constexpr Eigen::Index own_size = 5;
  static Eigen::Index row_of(std::size_t number) { return own_size + 2 * static_cast<Eigen::Index>(number); }
  Eigen::Index size() const { return row_of(count_); }
  Eigen::Index involved(std::size_t number, Eigen::Index which) const;
  Own own_covariance() const;
  double entry(Eigen::Index a, Eigen::Index b) const { return a >= b ? covariance_(a, b) : covariance_(b, a); }
  Eigen::Matrix<double, 5, 5> involved_covariance(std::size_t number) const;
  /// Of the measurement with respect to the body's x, y, angle and the landmark's x, y.
  Derivative derivative(std::size_t number) const;
  void correct(const Eigen::Vector2d& innovation, const Eigen::Matrix2d& own, const Eigen::Matrix2d& noise);
  void times_derivative(std::size_t number, const Derivative& H, Columns& product) const;
  void shrink(const Columns& PHt, const Columns& gain, const Columns& rest);
  void reserve(Eigen::Index size);
  static std::size_t bytes_for(Eigen::Index size);

  std::size_t count_ = 0;
  std::size_t most_ = std::numeric_limits<std::uint32_t>::max();
  // Grown in steps; entries beyond size() and above the diagonal are undefined.
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
  Columns cross_, gain_, rest_;  // Kept between updates to reuse their memory.
};

}  // namespace rastro
