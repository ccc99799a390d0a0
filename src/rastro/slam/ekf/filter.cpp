// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/filter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr Eigen::Index first_capacity = 64;

/// Derivative of a rotated vector with respect to the rotation angle.
Eigen::Vector2d rotated_left(const Eigen::Vector2d& vector) { return {-vector.y(), vector.x()}; }

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

}  // namespace

EkfFilter::EkfFilter(const SE2& world_from_body, const Eigen::Vector2d& scale_sigma)
    : mean_(Eigen::VectorXd::Zero(first_capacity)), covariance_(Eigen::MatrixXd::Zero(first_capacity, first_capacity)) {
  mean_.head<2>() = world_from_body.translation();
  mean_[2] = world_from_body.rotation().angle();
  covariance_.diagonal().segment<2>(3) = scale_sigma.cwiseAbs2();
}

SE2 EkfFilter::world_from_body() const { return {SO2::from_angle(mean_[2]), mean_.head<2>()}; }

Eigen::Matrix3d EkfFilter::body_covariance() const {
  return covariance_.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
}

SE2 EkfFilter::scaled(const SE2& last_from_body) const {
  return {SO2::from_angle((1.0 + mean_[4]) * last_from_body.rotation().angle()),
          (1.0 + mean_[3]) * last_from_body.translation()};
}

EkfFilter::Own EkfFilter::own_covariance() const {
  return covariance_.topLeftCorner<own_size, own_size>().selfadjointView<Eigen::Lower>();
}

Eigen::Matrix2d EkfFilter::landmark_covariance(std::size_t number) const {
  const Eigen::Index row = row_of(number);
  return covariance_.block<2, 2>(row, row).selfadjointView<Eigen::Lower>();
}

Eigen::Matrix2d EkfFilter::landmark_covariance(std::size_t a, std::size_t b) const {
  if (a == b) return landmark_covariance(a);
  if (a < b) return landmark_covariance(b, a).transpose();
  return covariance_.block<2, 2>(row_of(a), row_of(b));
}

Eigen::MatrixXd EkfFilter::covariance() const {
  return covariance_.topLeftCorner(size(), size()).selfadjointView<Eigen::Lower>();
}

void EkfFilter::predict(const SE2& last_from_body, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix2d rotation = world_from_body().rotation().matrix();
  const Eigen::Vector2d told = rotation * last_from_body.translation();
  const double told_angle = last_from_body.rotation().angle();
  const Eigen::Vector2d step = (1.0 + mean_[3]) * told;

  Own F = Own::Identity();
  F.block<2, 1>(0, 2) = rotated_left(step);
  F.block<2, 1>(0, 3) = told;
  F(2, 4) = told_angle;
  Eigen::Matrix3d G = Eigen::Matrix3d::Identity();
  G.topLeftCorner<2, 2>() = rotation;

  mean_.head<2>() += step;
  mean_[2] = wrapped(mean_[2] + (1.0 + mean_[4]) * told_angle);
  Own own = F * own_covariance() * F.transpose();
  own.topLeftCorner<3, 3>() += G * covariance * G.transpose();
  covariance_.topLeftCorner<own_size, own_size>().triangularView<Eigen::Lower>() = own;
  auto rest = covariance_.block(own_size, 0, size() - own_size, own_size);
  rest.col(0) += F(0, 2) * rest.col(2) + F(0, 3) * rest.col(3);
  rest.col(1) += F(1, 2) * rest.col(2) + F(1, 3) * rest.col(3);
  rest.col(2) += F(2, 4) * rest.col(4);
}

Eigen::Index EkfFilter::involved(std::size_t number, Eigen::Index which) const {
  return which < 3 ? which : row_of(number) + which - 3;
}

Eigen::Matrix<double, 5, 5> EkfFilter::involved_covariance(std::size_t number) const {
  Eigen::Matrix<double, 5, 5> result;
  for (Eigen::Index a = 0; a < 5; ++a) {
    for (Eigen::Index b = 0; b < 5; ++b) result(a, b) = entry(involved(number, a), involved(number, b));
  }
  return result;
}

EkfFilter::Derivative EkfFilter::derivative(std::size_t number) const {
  const SE2 body_from_world = world_from_body().inverse();
  const Eigen::Matrix2d rotation = body_from_world.rotation().matrix();
  Derivative H;
  H.leftCols<2>() = -rotation;
  H.col(2) = -rotated_left(body_from_world * landmark(number));
  H.rightCols<2>() = rotation;
  return H;
}

EkfFilter::Expected EkfFilter::expected(std::size_t number) const {
  const Derivative H = derivative(number);
  return {world_from_body().inverse() * landmark(number), H * involved_covariance(number) * H.transpose()};
}

void EkfFilter::times_derivative(std::size_t number, const Derivative& H, Columns& product) const {
  product.setZero(size(), 2);
  for (Eigen::Index which = 0; which < 5; ++which) {
    const Eigen::Index middle = involved(number, which);
    product.topRows(middle) += covariance_.row(middle).head(middle).transpose() * H.col(which).transpose();
    product.bottomRows(size() - middle) +=
        covariance_.col(middle).segment(middle, size() - middle) * H.col(which).transpose();
  }
}

void EkfFilter::update(std::size_t number, const Eigen::Vector2d& in_body, const Eigen::Matrix2d& noise) {
  RASTRO_CHECK(number < count_, "a landmark that the filter has");
  const Derivative H = derivative(number);
  const Eigen::Vector2d innovation = in_body - world_from_body().inverse() * landmark(number);
  times_derivative(number, H, cross_);
  correct(innovation, H * involved_covariance(number) * H.transpose(), noise);
}

void EkfFilter::unite(std::size_t a, std::size_t b, const Eigen::Matrix2d& noise) {
  RASTRO_CHECK(a < count_ && b < count_ && a != b, "two landmarks that the filter has");
  cross_.setZero(size(), 2);
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    for (Eigen::Index row = 0; row < size(); ++row)
      cross_(row, axis) = entry(row, row_of(a) + axis) - entry(row, row_of(b) + axis);
  }
  const Eigen::Matrix2d own = cross_.middleRows<2>(row_of(a)) - cross_.middleRows<2>(row_of(b));
  correct(landmark(b) - landmark(a), own, noise);
}

/// `cross_`: P H^T; `own`: H P H^T.
void EkfFilter::correct(const Eigen::Vector2d& innovation, const Eigen::Matrix2d& own, const Eigen::Matrix2d& noise) {
  const Eigen::Matrix2d innovation_covariance = own + noise;
  gain_ = cross_ * innovation_covariance.inverse();
  mean_.head(size()) += gain_ * innovation;
  mean_[2] = wrapped(mean_[2]);
  // (I - KH) P H^T - K R: only rounding error for the optimal gain; Joseph's form retains it.
  rest_ = cross_ - gain_ * own;
  rest_ -= gain_ * noise;
  shrink(cross_, gain_, rest_);
}

void EkfFilter::shrink(const Columns& PHt, const Columns& gain, const Columns& rest) {
  for (Eigen::Index column = 0; column < size(); ++column) {
    const Eigen::Index below = size() - column;
    auto target = covariance_.col(column).segment(column, below);
    const auto short_form = PHt(column, 0) * gain.col(0).tail(below) + PHt(column, 1) * gain.col(1).tail(below);
    const auto joseph = gain(column, 0) * rest.col(0).tail(below) + gain(column, 1) * rest.col(1).tail(below);
    target = (target - short_form) - joseph;
  }
}

void EkfFilter::add(const Eigen::Vector2d& in_body, const Eigen::Matrix2d& noise) {
  const Eigen::Index row = size();
  reserve(row + 2);
  const Eigen::Matrix2d rotation = world_from_body().rotation().matrix();
  const Eigen::Vector2d offset = rotation * in_body;
  mean_.segment<2>(row) = mean_.head<2>() + offset;

  Eigen::Matrix<double, 2, 3> by_body;
  by_body << Eigen::Matrix2d::Identity(), rotated_left(offset);
  const Own own = own_covariance();
  covariance_.block<2, own_size>(row, 0) = by_body * own.topRows<3>();
  covariance_.block(row, own_size, 2, row - own_size) =
      by_body * covariance_.block(own_size, 0, row - own_size, 3).transpose();
  covariance_.block<2, 2>(row, row) =
      by_body * own.topLeftCorner<3, 3>() * by_body.transpose() + rotation * noise * rotation.transpose();
  ++count_;
}

void EkfFilter::remove(std::size_t number) {
  RASTRO_CHECK(number < count_, "a landmark that the filter has");
  --count_;
  if (number == count_) return;
  const Eigen::Index to = row_of(number), from = row_of(count_), between = from - to - 2;
  mean_.segment<2>(to) = mean_.segment<2>(from);
  covariance_.block(to, 0, 2, to) = covariance_.block(from, 0, 2, to);
  covariance_.block(to + 2, to, between, 2) = covariance_.block(from, to + 2, 2, between).transpose();
  covariance_.block<2, 2>(to, to) = covariance_.block<2, 2>(from, from);
}

/// By a quarter, since memory grows with the square.
void EkfFilter::reserve(Eigen::Index size) {
  if (size <= mean_.size()) return;
  const Eigen::Index capacity = std::max(size, std::min(mean_.size() + mean_.size() / 4, row_of(most_)));
  mean_.conservativeResize(capacity);
  covariance_.conservativeResize(capacity, capacity);
}

/// The covariance, the mean, and three times two columns of an update.
std::size_t EkfFilter::bytes_for(Eigen::Index size) {
  return sizeof(double) * static_cast<std::size_t>(size * size + 7 * size);
}

}  // namespace rastro
