// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/math/robust_kernel.h"
#include "rastro/optimize/bundle_adjustment.h"

/// Implementation of adjust_bundle().
namespace rastro {

/// A point with less depth counts as behind the camera.
constexpr double least_bundle_depth = 1e-9;

/// Chunks that depend on the count alone.
inline void in_chunks(TaskPool* pool, int count, const std::function<void(int, int)>& body) {
  constexpr int grain = 2048;
  if (pool != nullptr && count > grain) return pool->for_chunks(0, count, grain, body);
  body(0, count);
}

inline HuberKernel bundle_kernel(const BundleObservation& seen, const BundleOptions& options) {
  const double width = std::isnan(seen.right_x) ? options.huber_mono : options.huber_stereo;
  return {width > 0.0 ? width : std::numeric_limits<double>::infinity()};
}

inline HuberKernel relative_pose_kernel(const BundleOptions& options) {
  return {options.huber_pose > 0.0 ? options.huber_pose : std::numeric_limits<double>::infinity()};
}

/// d of true pose = exp(d) * to_from_from at the cameras: translation, rotation.
inline Vector6d relative_pose_error(const BundleRelativePose& measured, const SE3& from_from_world,
                                    const SE3& to_from_world) {
  return (to_from_world * from_from_world.inverse() * measured.to_from_from.inverse()).log();
}

struct BundleStep {
  Eigen::VectorXd cameras;              ///< (translation, rotation) of each free camera, applied from the left.
  std::vector<Eigen::Vector3d> points;  ///< One per point.
};

/// The normal equations of a bundle with the points eliminated. Reuses its structure and memory between steps.
class BundleNormal {
 public:
  BundleNormal(const Bundle& bundle, const BundleOptions& options, TaskPool* pool);
  ~BundleNormal();
  /// Index of a camera among the free ones; < 0: fixed.
  int free_index(std::size_t camera) const { return free_index_[camera]; }
  /// At the bundle's cameras and points; `damping`: fraction of the diagonal that is added to it. False if there is no
  /// solution.
  bool solve(const Bundle& bundle, double damping, BundleStep& step);

 private:
  using Matrix63 = Eigen::Matrix<double, 6, 3>;
  /// Rotation and translation: for many points cheaper than the quaternion.
  struct CameraMatrix {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
  };
  struct Point {
    Eigen::Matrix3d inverse;
    Eigen::Vector3d right;
  };
  /// Diagonal blocks and right-hand sides of the cameras, from one chunk of points.
  struct CameraSums {
    std::vector<Matrix6d> blocks;
    std::vector<Vector6d> right;
  };
  class Reduced;

  void sort(const Bundle& bundle);
  void find_rows(const Bundle& bundle);
  void add_points(const Bundle& bundle, int begin, int end, double damping, CameraSums& sums);
  template <int Rows>
  void add_observation(const Bundle& bundle, std::size_t k, Eigen::Matrix3d& normal, Eigen::Vector3d& right,
                       CameraSums& sums);
  void reduce_row(int row, double damping);
  void add_relative_poses(const Bundle& bundle);
  /// Normal equations of a relative pose whose ends are not both fixed; `from`, `to`: among the free cameras, or < 0.
  struct PoseLink {
    int from = -1, to = -1;
    Matrix6d of_from, of_to, between;  ///< `between`: of the row `to` and the column `from`.
    Vector6d right_from, right_to;
  };

  const BundleOptions& options_;
  TaskPool* pool_;
  std::vector<int> free_index_;
  int free_ = 0;
  std::vector<std::uint32_t> order_;      ///< Observations by point.
  std::vector<std::size_t> point_begin_;  ///< In order_; one more than there are points.
  std::vector<int> link_camera_;          ///< By index in order_: index of its camera; -1: fixed or not used now.
  std::vector<Matrix63> links_;           ///< By index in order_.
  std::vector<std::uint32_t> row_link_;   ///< Indices in order_, by free camera.
  std::vector<std::size_t> row_begin_;    ///< In row_link_.
  std::vector<std::uint32_t> point_of_;   ///< By index in order_.
  std::vector<CameraMatrix> cameras_;
  std::vector<Point> points_;
  std::vector<CameraSums> sums_;  ///< One per chunk of points.
  std::vector<PoseLink> pose_links_;
  std::unique_ptr<Reduced> reduced_;
};

}  // namespace rastro
