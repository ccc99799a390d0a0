// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/math/robust_kernel.h"
#include "rastro/optimize/bundle_normal.h"

namespace rastro {
namespace {

/// Squared sigmas at which a residual is capped; a point behind a camera gets this value.
constexpr double most_squared = 1e6;

void check(const Bundle& bundle) {
  RASTRO_CHECK(bundle.fixed.size() == bundle.camera_from_world.size(), "every camera is fixed or free");
  for (const BundleObservation& seen : bundle.observations)
    RASTRO_CHECK(seen.camera < bundle.fixed.size() && seen.point < bundle.points.size() && seen.sigma > 0.0,
                 "an observation is of a camera and a point of the bundle and has a sigma");
  for (const BundleRelativePose& measured : bundle.relative_poses)
    RASTRO_CHECK(
        measured.from < bundle.fixed.size() && measured.to < bundle.fixed.size() && measured.from != measured.to,
        "a relative pose is of two cameras of the bundle");
}

double squared_error(const BundleObservation& seen, const SE3& camera_from_world, const Eigen::Vector3d& point,
                     double baseline) {
  const Eigen::Vector3d p = camera_from_world * point;
  if (!(p.z() > least_bundle_depth)) return std::numeric_limits<double>::infinity();
  const double inverse = 1.0 / p.z();
  double squared = (p.head<2>() * inverse - seen.ray).squaredNorm();
  if (!std::isnan(seen.right_x)) {
    const double off = (p.x() - baseline) * inverse - seen.right_x;
    squared += off * off;
  }
  return squared / (seen.sigma * seen.sigma);
}

void moved(const Bundle& bundle, const BundleNormal& normal, const BundleStep& step, std::vector<SE3>& cameras,
           std::vector<Eigen::Vector3d>& points) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const int index = normal.free_index(i);
    const SE3& before = bundle.camera_from_world[i];
    if (index < 0) continue;
    const SO3 rotation = SO3::exp(step.cameras.segment<3>(6 * index + 3));
    cameras[i] =
        SE3(rotation * before.rotation(), rotation * before.translation() + step.cameras.segment<3>(6 * index).eval());
  }
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = bundle.points[i] + step.points[i];
}

class Adjustment {
 public:
  Adjustment(Bundle& bundle, const BundleOptions& options, TaskPool* pool)
      : bundle_(bundle), options_(options), pool_(pool), normal_(bundle, options, pool) {}

  BundleResult run() {
    BundleResult result;
    result.squared_errors.resize(bundle_.observations.size());
    double cost = cost_of(bundle_.camera_from_world, bundle_.points, result.squared_errors);
    result.first_cost = cost;
    std::vector<SE3> cameras = bundle_.camera_from_world;
    std::vector<Eigen::Vector3d> points = bundle_.points;
    std::vector<double> errors(result.squared_errors.size());
    constexpr double first_damping = 1e-5, most_damping = 1e8;
    double damping = first_damping, growth = 2.0;
    const auto stopped = [&] { return options_.stopped && options_.stopped(); };
    while (result.iterations < options_.iterations && !result.converged && damping < most_damping && !stopped()) {
      ++result.iterations;
      BundleStep step;
      if (normal_.solve(bundle_, damping, step)) {
        moved(bundle_, normal_, step, cameras, points);
        const double next = cost_of(cameras, points, errors);
        if (next <= cost) {
          result.converged = cost - next <= options_.least_gain * cost;
          cost = next;
          bundle_.camera_from_world = cameras;
          bundle_.points.swap(points);
          result.squared_errors.swap(errors);
          damping = std::max(1e-9, 0.1 * damping);
          growth = 2.0;
          continue;
        }
      }
      damping *= growth * 5.0;
      growth *= 2.0;
    }
    result.last_cost = cost;
    return result;
  }

 private:
  double cost_of(const std::vector<SE3>& cameras, const std::vector<Eigen::Vector3d>& points,
                 std::vector<double>& errors) {
    const int count = static_cast<int>(bundle_.observations.size());
    in_chunks(pool_, count, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const BundleObservation& seen = bundle_.observations[at];
        errors[at] = squared_error(seen, cameras[seen.camera], points[seen.point], bundle_.baseline);
      }
    });
    double cost = 0.0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const double squared = errors[i] < most_squared ? errors[i] : most_squared;
      cost += 0.5 * bundle_kernel(bundle_.observations[i], options_).cost(squared);
    }
    for (const BundleRelativePose& measured : bundle_.relative_poses) {
      const Vector6d error = relative_pose_error(measured, cameras[measured.from], cameras[measured.to]);
      cost += 0.5 * relative_pose_kernel(options_).cost(error.dot(measured.information * error));
    }
    return cost;
  }

  Bundle& bundle_;
  const BundleOptions& options_;
  TaskPool* pool_;
  BundleNormal normal_;
};

}  // namespace

BundleResult adjust_bundle(Bundle& bundle, const BundleOptions& options, TaskPool* pool) {
  check(bundle);
  return Adjustment(bundle, options, pool).run();
}

}  // namespace rastro
