// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/backend/guided_search.h"
#include "rastro/optimize/pose_refinement.h"
#include "rastro/slam/orb/map/map_view.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// A feature of a frame and the point it shows: a landmark of the map, or a feature with depth of a keyframe that the
/// map does not know yet.
struct TrackedPoint {
  std::uint32_t feature = 0;
  std::int64_t landmark = -1;  ///< -1: not yet one, but:
  std::int64_t keyframe = -1;
  std::uint32_t keyframe_feature = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< World of the view.
};

/// A landmark and where a feature track, not its descriptor, says it is in a frame.
struct LandmarkTrack {
  std::int64_t landmark = -1;
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();  ///< Normalised: (x/z, y/z).
};

/// Where a frame is, and why it is thought so.
struct TrackingResult {
  bool ok = false;
  SE3 camera_from_world;
  Matrix6d covariance = Matrix6d::Zero();  ///< As PoseRefinement's.
  int matches = 0;                         ///< Before outliers were left out.
  int inliers = 0;                         ///< Those in `points`.
  int predicted = 0;                       ///< Inliers of the first search.
  double mean_squared = 0.0;
  std::vector<TrackedPoint> points;
  std::vector<std::int64_t> visible;  ///< Landmarks that should be seen; ids ascend.
  std::int64_t reference = -1;        ///< Keyframe that shares most points.
};

/// Finds frames in a view of the map, METHODS 6: constant velocity, else the reference keyframe, then all landmarks
/// around (Mur-Artal et al. 2015, section V). A value: a copy goes its own way.
class FrameTracker {
 public:
  FrameTracker(const OrbSlamOptions& options, const Camera& camera, CameraKind sensor, double baseline);

  /// A newer view; the last pose moves with the map.
  void set_view(std::shared_ptr<const MapView> view);
  const MapView* view() const { return view_.get(); }
  /// Where tracking goes on from, standing still as far as is known; `points` may be empty.
  void restart(const SE3& camera_from_world, std::vector<TrackedPoint> points,
               std::shared_ptr<const FeatureFrame> frame);
  /// Points with depth of a keyframe that a later view will know.
  void add_depth_points(std::int64_t keyframe, std::shared_ptr<const FeatureFrame> frame, const SE3& camera_from_world,
                        const std::vector<std::uint32_t>& features);
  /// The next frame is predicted from the pose where it is ok. `tracks` takes the place of a search where enough of
  /// it fits one pose.
  TrackingResult track(const std::shared_ptr<const FeatureFrame>& frame, const std::vector<LandmarkTrack>& tracks = {});
  /// The same from a pose that is about right, as after relocalisation.
  TrackingResult track_from(const std::shared_ptr<const FeatureFrame>& frame, const SE3& camera_from_world);
  /// Where the next frame should be.
  SE3 predicted() const { return velocity_ * last_pose_; }
  const SE3& last_pose() const { return last_pose_; }
  /// The next camera from the last one, if it goes on as it went.
  const SE3& velocity() const { return velocity_; }

 private:
  /// Features with depth of a keyframe that the view does not know yet.
  struct DepthPoints {
    std::int64_t keyframe = -1;
    std::shared_ptr<const FeatureFrame> frame;
    std::vector<std::uint32_t> features;
    std::vector<Eigen::Vector3d> positions;
  };
  /// A guided search, and what its subjects stand for.
  struct Search {
    GuidedSearch windows;
    std::vector<TrackedPoint> points;
  };

  void move_to(const MapView& view);
  std::int64_t common_keyframe(const MapView& view) const;
  PoseRefinement predict_pose(const FeatureFrame& frame, const std::vector<LandmarkTrack>& tracks) const;
  PoseRefinement pose_by_last_frame(const FeatureFrame& frame, const SE3& start, float radius_px) const;
  PoseRefinement pose_by_tracks(const std::vector<LandmarkTrack>& tracks) const;
  std::optional<SE3> pose_by_reference(const FeatureFrame& frame) const;
  TrackingResult track_local_map(const FeatureFrame& frame, const SE3& predicted) const;
  Search search_in(const FeatureFrame& frame, float radius_px) const;
  void add_landmarks(const SE3& pose, Search& search, std::vector<std::int64_t>& visible) const;
  void add_depth_points(const SE3& pose, Search& search) const;
  PoseRefinement refine(const FeatureFrame& frame, const Search& search, const std::vector<FeatureMatch>& matches,
                        const SE3& start) const;
  std::int64_t reference_of(const std::vector<TrackedPoint>& points) const;
  void accept(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& result);

  OrbSlamOptions options_;
  Camera camera_;
  CameraKind sensor_;
  double baseline_;
  std::vector<double> level_scales_;
  std::shared_ptr<const MapView> view_;
  std::vector<DepthPoints> depth_points_;
  std::shared_ptr<const FeatureFrame> last_frame_;
  std::vector<TrackedPoint> last_points_;
  SE3 last_pose_;  ///< camera_from_world
  SE3 velocity_;   ///< Next camera from last camera.
  std::int64_t reference_ = -1;
};

}  // namespace rastro
