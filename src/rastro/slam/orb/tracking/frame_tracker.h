// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/backend/guided_search.h"
#include "rastro/optimize/pose_refinement.h"
#include "rastro/slam/orb/map/frame_trajectory.h"
#include "rastro/slam/orb/map/map_view.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// A feature of a frame and its point: a landmark of the map, or a feature with depth of a keyframe that is not in the
/// view yet.
struct TrackedPoint {
  std::uint32_t feature = 0;
  std::int64_t landmark = -1;  ///< -1: not a landmark yet, but:
  std::int64_t keyframe = -1;
  std::uint32_t keyframe_feature = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< In the world of the view.
};

/// The position of a landmark in a frame from a feature track, not from its descriptor.
struct LandmarkTrack {
  std::int64_t landmark = -1;
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();  ///< Normalized: (x/z, y/z).
};

/// The pose of a frame and the evidence for it.
struct TrackingResult {
  bool ok = false;
  SE3 camera_from_world;
  Matrix6d covariance = Matrix6d::Zero();  ///< As that of PoseRefinement.
  int matches = 0;                         ///< Including outliers.
  int inliers = 0;                         ///< Those in `points`.
  int supporting = 0;                      ///< Of these, with a distance known well enough to tell where the camera is.
  int predicted = 0;                       ///< Inliers of the first search.
  double chance_inliers = 0.0;             ///< Inliers that a wrong pose would have, where this had to be known.
  double mean_squared = 0.0;
  std::vector<TrackedPoint> points;
  std::vector<TrackedPoint> outliers;                    ///< Matched, but inconsistent with the pose.
  std::vector<std::int64_t> visible;                     ///< Landmarks that should be visible; ids ascend.
  std::int64_t reference = -1;                           ///< Keyframe that shares most points.
  std::shared_ptr<const DirectObservation> direct = {};  ///< By which the pose was refined; null: by features alone.
};

/// Tracks frames in a view of the map, METHODS 6: by constant velocity, else by the reference keyframe, then by the
/// local map (Mur-Artal et al. 2015, section V). Copies are independent of each other.
class FrameTracker {
 public:
  FrameTracker(const OrbSlamOptions& options, const Camera& camera, CameraKind sensor, double baseline);

  /// How many supporting inliers a pose needs from now on (default: options.min_inliers).
  void set_min_inliers(int inliers) { options_.min_inliers = inliers; }
  /// Sets a newer view; the last pose moves with the map.
  void set_view(std::shared_ptr<const MapView> view);
  const MapView* view() const { return view_.get(); }
  /// Restarts tracking from this pose, with zero velocity; `points` may be empty.
  void restart(const SE3& camera_from_world, std::vector<TrackedPoint> points,
               std::shared_ptr<const FeatureFrame> frame);
  /// Adds points with depth of a keyframe that is not in the view yet.
  void add_depth_points(std::int64_t keyframe, std::shared_ptr<const FeatureFrame> frame, const SE3& camera_from_world,
                        const std::vector<std::uint32_t>& features);
  /// Tracks the next frame. If the result is ok (enough inliers, and min_chance_ratio times those that fit by chance),
  /// the following frame is predicted from its pose. `tracks` replace the search where enough of them fit one pose.
  TrackingResult track(const std::shared_ptr<const FeatureFrame>& frame, const std::vector<LandmarkTrack>& tracks = {});
  /// Tracks from a given approximate pose, as after relocalization; chance_inliers is not compared.
  TrackingResult track_from(const std::shared_ptr<const FeatureFrame>& frame, const SE3& camera_from_world);
  /// The last frame has this pose, as more than its features show.
  void correct(const SE3& camera_from_world);
  /// How many landmarks fit a wrong pose by chance: the mean over poses rotated by more than a search window, each
  /// refined as if it were right. What stands out less from it is no evidence for a pose (a contrario validation:
  /// Moisan and Stival 2004, "A probabilistic criterion to detect rigid point matches between two images").
  double chance_inliers(const FeatureFrame& frame, const SE3& camera_from_world) const;
  /// Predicted pose of the next frame.
  SE3 predicted() const { return velocity_ * last_pose_; }
  const SE3& last_pose() const { return last_pose_; }
  /// Motion from the last camera to the next, at constant velocity.
  const SE3& velocity() const { return velocity_; }

 private:
  /// Features with depth of a keyframe that is not in the view yet.
  struct DepthPoints {
    std::int64_t keyframe = -1;
    std::shared_ptr<const FeatureFrame> frame;
    std::vector<std::uint32_t> features;
    std::vector<Eigen::Vector3d> positions;
  };
  /// A guided search, and the points of its subjects.
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
  /// Of a landmark's position; null: certain.
  const Eigen::Matrix3d* covariance_of(std::int64_t landmark) const;
  PoseRefinement refine(const FeatureFrame& frame, const Search& search, const std::vector<FeatureMatch>& matches,
                        const SE3& start, bool starts_judged = false) const;
  bool is_established(const TrackedPoint& point) const;
  std::optional<PoseRefinement> refine_by_established(const FeatureFrame& frame, const Search& search,
                                                      const std::vector<FeatureMatch>& matches,
                                                      const PoseRefinement& by_all) const;
  int supporting(const SE3& camera_from_world, const std::vector<TrackedPoint>& points) const;
  std::int64_t reference_of(const std::vector<TrackedPoint>& points) const;
  bool exceeds_chance(const FeatureFrame& frame, TrackingResult& result);
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
  double chance_share_ = 0.05;  ///< Of the visible landmarks, those that fit by chance: as last estimated.
};

}  // namespace rastro
