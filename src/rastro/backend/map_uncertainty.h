// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"

namespace rastro {

/// How uncertain the parts of a map (keyframes, submaps) are relative to the first, for the covariances of poses
/// tracked against them. Each part has the errors of the one that it was tracked against, and its own: an upper bound,
/// as optimization only reduces them. Where tracking comes back to an early part, its smaller uncertainty counts again.
/// Of one camera the scale is uncertain too: an error of a part's scale moves what is far from it.
///
/// Covariances are of (position m, rotation rad) in the world's axes.
class MapUncertainty {
 public:
  /// Of a pose at `position` tracked against a part, from its covariance relative to the map around. A part that was
  /// never added is certain.
  Matrix6d of_pose(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& tracked) const;
  bool contains(std::int64_t part) const { return parts_.contains(part); }
  /// Adds or replaces a part at `position` that was tracked against `from`. `scale_variance`: of the logarithm of the
  /// new part's scale relative to that of `from`.
  void add(std::int64_t part, std::int64_t from, const Eigen::Vector3d& position, const Matrix6d& tracked,
           double scale_variance);
  /// Replaces what was known of the part.
  void set(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& covariance);
  /// Takes over another estimate of the part, as after a loop closure, by covariance intersection: never too certain,
  /// whatever errors both have in common (Julier and Uhlmann 1997). Directions without variance stay without.
  void reduce(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& covariance);
  /// The part's submap was transformed by `new_from_old` and joined to that of `joined_to`: it has the errors of both.
  /// A part that was never added, at `position` (of the new world), has those of `joined_to` alone.
  void join(std::int64_t part, std::int64_t joined_to, const Eigen::Vector3d& position, const Sim3& new_from_old);
  /// Parts with larger numbers than this one, with their positions.
  std::vector<std::pair<std::int64_t, Eigen::Vector3d>> after(std::int64_t part) const;
  /// The part is gone: nothing is tracked against it any more.
  void forget(std::int64_t part) { parts_.erase(part); }
  /// The part was thought at `before` and is seen at `after` now (world_from_camera), say by landmarks that come back
  /// into view. Where that is beyond 99 % of its errors, one of both is wrong, and the difference is an error too.
  void contradict(std::int64_t part, const SE3& before, const SE3& after);
  /// A loop closure ties `later` to `earlier`: the errors in between are known at both ends, as those of a Brownian
  /// bridge. Where the chain is at share f of the whole, 1 - f of its variance is left.
  void close_loop(std::int64_t earlier, std::int64_t later);

 private:
  using Matrix7d = Eigen::Matrix<double, 7, 7>;
  struct Entry {
    Eigen::Vector3d position;
    Matrix7d covariance;  ///< (position, rotation, logarithm of the scale)
  };
  Matrix7d moved_to(const Entry& part, const Eigen::Vector3d& position) const;
  Matrix7d covariance_of(std::int64_t part, const Eigen::Vector3d& position) const;

  std::map<std::int64_t, Entry> parts_;
};

}  // namespace rastro
