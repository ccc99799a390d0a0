// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd/reference_adjustment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

constexpr CauchyKernel kernel{2.0};
constexpr double least_depth_m = 0.05;
// A smaller drop of the cost is not worth another step.
constexpr double least_gain = 1e-4;
constexpr double nearest = 20.0, farthest = 1e-3;  // 1/m

using Matrix36 = Eigen::Matrix<double, 3, 6>;

Eigen::Vector3d homogeneous(const Eigen::Vector2d& ray) { return {ray.x(), ray.y(), 1.0}; }

/// One sighting against the present poses and depths, whitened but for the kernel.
struct Residual {
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_in_anchor, p;
  bool in_front = false;
};

Residual residual_of(const AnchoredSighting& sighting, const AnchoredPoint& point, const SE3& camera_from_anchor,
                     double ray_sigma) {
  Residual r;
  r.p_in_anchor = homogeneous(point.ray) / point.inverse_depth;
  r.p = camera_from_anchor * r.p_in_anchor;
  r.in_front = r.p.z() > least_depth_m;
  if (!r.in_front) return r;
  r.error.head<2>() = (sighting.ray - r.p.head<2>() / r.p.z()) / ray_sigma;
  if (sighting.inverse_depth > 0.0)
    r.error.z() = (sighting.inverse_depth - 1.0 / r.p.z()) / sighting.inverse_depth_sigma;
  return r;
}

class Adjuster {
 public:
  explicit Adjuster(ReferenceWindow& window) : window_(window) {
    slot_.assign(window.world_from_camera.size(), -1);
    for (std::size_t i = 0; i < window.fixed.size(); ++i) {
      if (!window.fixed[i]) slot_[i] = 6 * free_++;
    }
    gather_pairs();
  }
  bool anything_free() const { return free_ > 0; }
  double cost() const;
  /// The normal equations of the cameras at the present state; depths are eliminated.
  void build(double damping);
  /// The step they ask for.
  void step();

  std::vector<SE3> poses;      ///< Of the trial.
  std::vector<double> depths;  ///< Inverse, of the trial.

 private:
  /// Sightings of one point: [begin, end).
  struct Span {
    std::size_t begin = 0, end = 0;
  };
  void gather_pairs();
  void add_sighting(const AnchoredSighting& sighting, const AnchoredPoint& point);
  void eliminate(std::size_t point, double damping);
  void add_link(const CameraLink& link);
  int slot(int camera) const { return slot_[static_cast<std::size_t>(camera)]; }
  const SE3& pose(int camera) const { return window_.world_from_camera[static_cast<std::size_t>(camera)]; }

  ReferenceWindow& window_;
  std::vector<int> slot_;  ///< First row of each camera; -1: fixed.
  int free_ = 0;
  std::vector<Span> spans_;
  Eigen::MatrixXd normal_;
  Eigen::VectorXd right_;
  // Of the point in hand: its row of the normal equations, and which cameras it touches.
  Eigen::VectorXd cross_;
  std::vector<int> touched_;
  double depth_normal_ = 0.0, depth_right_ = 0.0;
  struct Eliminated {
    Eigen::VectorXd cross;
    double normal = 0.0, right = 0.0;
  };
  std::vector<Eliminated> eliminated_;
};

void Adjuster::gather_pairs() {
  spans_.resize(window_.points.size());
  for (std::size_t i = 0; i < window_.sightings.size(); ++i) {
    const auto point = static_cast<std::size_t>(window_.sightings[i].point);
    RASTRO_CHECK(point < spans_.size() && (spans_[point].end == 0 || spans_[point].end == i),
                 "sightings of one point stand together");
    if (spans_[point].end == 0) spans_[point].begin = i;
    spans_[point].end = i + 1;
  }
  eliminated_.resize(window_.points.size());
}

double Adjuster::cost() const {
  double sum = 0.0;
  for (const AnchoredSighting& sighting : window_.sightings) {
    const AnchoredPoint& point = window_.points[static_cast<std::size_t>(sighting.point)];
    const Residual r =
        residual_of(sighting, point, pose(sighting.camera).inverse() * pose(point.camera), window_.ray_sigma);
    if (r.in_front) sum += kernel.cost(r.error.squaredNorm());
  }
  for (const AnchoredPoint& point : window_.points) {
    const double error = point.read_inverse_depth - point.inverse_depth;
    sum += kernel.cost(point.information * error * error);
  }
  for (const CameraLink& link : window_.links) {
    const Vector6d error = (link.from_from_to.inverse() * pose(link.from).inverse() * pose(link.to)).log();
    sum += kernel.cost(error.dot(link.information * error));
  }
  return sum;
}

void Adjuster::add_sighting(const AnchoredSighting& sighting, const AnchoredPoint& point) {
  const SE3 camera_from_anchor = pose(sighting.camera).inverse() * pose(point.camera);
  const Residual r = residual_of(sighting, point, camera_from_anchor, window_.ray_sigma);
  if (!r.in_front) return;
  const double inverse = 1.0 / r.p.z(), by_ray = 1.0 / window_.ray_sigma;
  Eigen::Matrix3d by_point = Eigen::Matrix3d::Zero();
  by_point.topRows<2>() << inverse, 0.0, -r.p.x() * inverse * inverse, 0.0, inverse, -r.p.y() * inverse * inverse;
  by_point.topRows<2>() *= by_ray;
  if (sighting.inverse_depth > 0.0) by_point(2, 2) = -inverse * inverse / sighting.inverse_depth_sigma;
  const double weight = kernel.weight(r.error.squaredNorm());
  const Eigen::Matrix3d rotation = camera_from_anchor.rotation().matrix();
  Matrix36 by_camera, by_anchor;
  by_camera << -by_point, by_point * hat(r.p);
  const Eigen::Matrix3d by_anchor_point = by_point * rotation;
  by_anchor << by_anchor_point, -by_anchor_point * hat(r.p_in_anchor);
  const Eigen::Vector3d by_depth = -by_anchor_point * (r.p_in_anchor / point.inverse_depth);
  depth_normal_ += weight * by_depth.squaredNorm();
  depth_right_ += weight * by_depth.dot(r.error);
  const int c = slot(sighting.camera), a = slot(point.camera);
  if (c >= 0) {
    normal_.block<6, 6>(c, c).noalias() += weight * by_camera.transpose() * by_camera;
    right_.segment<6>(c).noalias() += weight * by_camera.transpose() * r.error;
    cross_.segment<6>(c).noalias() += weight * by_camera.transpose() * by_depth;
    touched_.push_back(c);
  }
  if (a >= 0) {
    normal_.block<6, 6>(a, a).noalias() += weight * by_anchor.transpose() * by_anchor;
    right_.segment<6>(a).noalias() += weight * by_anchor.transpose() * r.error;
    cross_.segment<6>(a).noalias() += weight * by_anchor.transpose() * by_depth;
  }
  if (c >= 0 && a >= 0) {
    const Matrix6d both = weight * by_camera.transpose() * by_anchor;
    normal_.block<6, 6>(c, a) += both;
    normal_.block<6, 6>(a, c) += both.transpose();
  }
}

void Adjuster::eliminate(std::size_t index, double damping) {
  const AnchoredPoint& point = window_.points[index];
  if (slot(point.camera) >= 0) touched_.push_back(slot(point.camera));
  const double error = point.read_inverse_depth - point.inverse_depth;
  const double weight = kernel.weight(point.information * error * error) * point.information;
  depth_normal_ += weight;
  depth_right_ += weight * error;
  const double normal = depth_normal_ * (1.0 + damping) + 1e-9;
  for (const int i : touched_) {
    right_.segment<6>(i) -= cross_.segment<6>(i) * (depth_right_ / normal);
    for (const int j : touched_)
      normal_.block<6, 6>(i, j).noalias() -= cross_.segment<6>(i) / normal * cross_.segment<6>(j).transpose();
  }
  eliminated_[index] = {cross_, normal, depth_right_};
}

void Adjuster::add_link(const CameraLink& link) {
  const SE3 way = pose(link.from).inverse() * pose(link.to);
  const Vector6d error = (way.inverse() * link.from_from_to).log();
  const double weight = kernel.weight(error.dot(link.information * error));
  // way * exp(d_to) and exp(-d_from) * way = way * exp(-Ad d_from).
  const Matrix6d by_from = -way.inverse().adjoint();
  const int f = slot(link.from), t = slot(link.to);
  const Matrix6d weighted = weight * link.information;
  if (t >= 0) {
    normal_.block<6, 6>(t, t) += weighted;
    right_.segment<6>(t) += weighted * error;
  }
  if (f >= 0) {
    normal_.block<6, 6>(f, f) += by_from.transpose() * weighted * by_from;
    right_.segment<6>(f) += by_from.transpose() * weighted * error;
  }
  if (f >= 0 && t >= 0) {
    normal_.block<6, 6>(f, t) += by_from.transpose() * weighted;
    normal_.block<6, 6>(t, f) += weighted * by_from;
  }
}

void Adjuster::build(double damping) {
  normal_ = Eigen::MatrixXd::Zero(6 * free_, 6 * free_);
  right_ = Eigen::VectorXd::Zero(6 * free_);
  for (std::size_t i = 0; i < window_.points.size(); ++i) {
    cross_ = Eigen::VectorXd::Zero(6 * free_);
    touched_.clear();
    depth_normal_ = depth_right_ = 0.0;
    for (std::size_t k = spans_[i].begin; k < spans_[i].end; ++k) add_sighting(window_.sightings[k], window_.points[i]);
    eliminate(i, damping);
  }
  for (const CameraLink& link : window_.links) add_link(link);
  normal_.diagonal() *= 1.0 + damping;
  normal_.diagonal().array() += 1e-6;
}

void Adjuster::step() {
  const Eigen::VectorXd moved = normal_.ldlt().solve(right_);
  poses = window_.world_from_camera;
  depths.resize(window_.points.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (slot_[i] >= 0) poses[i] = poses[i] * SE3::exp(moved.segment<6>(slot_[i]));
  }
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const double change = (eliminated_[i].right - eliminated_[i].cross.dot(moved)) / eliminated_[i].normal;
    depths[i] = std::clamp(window_.points[i].inverse_depth + change, farthest, nearest);
  }
}

}  // namespace

std::pair<double, double> adjust_references(ReferenceWindow& window, int iterations) {
  RASTRO_CHECK(window.fixed.size() == window.world_from_camera.size(), "every camera is fixed or not");
  Adjuster adjuster(window);
  const double before = adjuster.cost();
  double cost = before, damping = 1e-4;
  for (int i = 0; i < iterations && adjuster.anything_free(); ++i) {
    adjuster.build(damping);
    adjuster.step();
    const auto swap = [&] {
      window.world_from_camera.swap(adjuster.poses);
      for (std::size_t k = 0; k < adjuster.depths.size(); ++k)
        std::swap(window.points[k].inverse_depth, adjuster.depths[k]);
    };
    swap();
    const double now = adjuster.cost();
    if (!(now < cost)) {
      swap();
      damping *= 100.0;
      continue;
    }
    const bool done = cost - now < least_gain * cost;
    cost = now;
    damping *= 0.1;
    if (done) break;
  }
  return {before, cost};
}

}  // namespace rastro
