// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/map/graph/map.h"
#include "rastro/math/sim3.h"
#include "rastro/place/place_index.h"
#include "rastro/slam/lsd/inverse_depth_map.h"
#include "rastro/slam/lsd/lsd_sensor.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/sensed_depths.h"

namespace rastro {

class KnownMapDepths;

/// An undistorted image with depths: in meters, or in a unit of its own: where it was made, the mean inverse depth
/// was 1.
struct SemiDenseKeyframe {
  std::int64_t id = 0;
  std::int64_t frame = 0;  ///< Index in the recording.
  TimeNs stamp = 0;
  GrayImage image;
  InverseDepthMap depth;
  double mean_inverse_depth = 1.0;
  GrayImage mask = {};  ///< Zero: must not be used; empty: all may be.
  std::vector<SensedDepth> sensed = {};
};

/// A frame's pose relative to a keyframe and in its unit, so that it follows the keyframe's later corrections.
struct PlacedFrame {
  std::int64_t index = 0;
  TimeNs stamp = 0;
  std::int64_t keyframe = 0;
  SE3 keyframe_from_camera;
};

/// What an alignment's covariance lacks: errors common to all pixels, as a share of the mean distance and in radians.
Matrix6d common_covariance(double mean_inverse_depth);

/// Keyframes with similarities as poses, and the constraints between them (Engel et al. 2014, section 3.1). The world's
/// unit is that of the first keyframe of each submap.
class SemiDenseGraph {
 public:
  /// `metric`: all scales are 1.
  SemiDenseGraph(const LsdOptions& options, bool metric)
      : options_(options), metric_(metric), has_scale_errors_(!metric && options.start != "random") {}

  /// Its id must be size().
  void add(std::shared_ptr<const SemiDenseKeyframe> keyframe, const Sim3& world_from_keyframe, int submap);
  /// The same keyframe with better depths.
  void replace(std::shared_ptr<const SemiDenseKeyframe> keyframe);
  /// Of a finished keyframe: it can be recognized from now on.
  void add_words(std::int64_t id, const BagOfWords& words) {
    if (!places_.contains(id)) places_.add(id, words);
  }
  /// Relative poses are in the units of the keyframes themselves.
  void add_edge(const Constraint& edge);
  /// The depths of a keyframe became better: of what came into view in it, the scale is known as well as that.
  void know_scale(std::int64_t id, double scale_variance_of_new);
  /// Drops image and depths of the oldest keyframe that has them, but for the last `kept`. False: there is none.
  bool forget_oldest(std::int64_t kept);
  /// With what a map takes that is kept beside it.
  std::size_t bytes() const;
  void add_frame(const PlacedFrame& frame) { frames_.push_back(frame); }
  /// The same frames with other poses.
  void set_frames(std::vector<PlacedFrame> frames) {
    frames_ = std::move(frames);
    ++revision_;
  }
  /// Of one submap, which has more or earlier keyframes, the frame becomes that of both.
  void merge(const Constraint& edge);
  /// All poses; or, in a large map, only those of the keyframes few steps of odometry from `around`: where no loop was
  /// closed, nothing new is known of the others.
  void optimize(std::optional<std::int64_t> around = std::nullopt);
  /// world_from_keyframe by keyframe.
  void set_poses(std::vector<Sim3> poses) {
    poses_ = std::move(poses);
    ++revision_;
  }

  std::int64_t size() const { return static_cast<std::int64_t>(keyframes_.size()); }
  const SemiDenseKeyframe& keyframe(std::int64_t id) const { return *keyframes_[static_cast<std::size_t>(id)]; }
  const Sim3& pose(std::int64_t id) const { return poses_[static_cast<std::size_t>(id)]; }  ///< world_from_keyframe
  int submap(std::int64_t id) const { return submaps_[static_cast<std::size_t>(id)]; }
  const std::vector<Constraint>& edges() const { return edges_; }
  /// Whether it has a constraint with a keyframe of an earlier visit.
  bool closes_loop(std::int64_t id) const { return links_[static_cast<std::size_t>(id)].closes_loop; }
  /// Standard deviation, as a share, of its scale relative to the first keyframe of its submap, beyond ordinary drift:
  /// in a fast turn of one camera the motions are hardly known from which depths of what comes into view follow. By the
  /// constraints that tell most, of those that the last optimization did not switch off. At most 1: unknown.
  double scale_error(std::int64_t id) const {
    return std::sqrt(std::min(1.0, links_[static_cast<std::size_t>(id)].scale_variance));
  }
  /// Keyframes so few steps of odometry away, but for itself; sorted. Where the camera came back to an early one and
  /// went on from there, these are not those with the nearest numbers.
  std::vector<std::int64_t> within_steps(std::int64_t id, int steps) const;
  int new_submap() const;
  /// Other keyframes of its submap, the nearest in position and viewing direction first, at most `most` of those whose
  /// views may overlap; `is_wanted` (if any) selects.
  std::vector<std::int64_t> near(std::int64_t id, int most,
                                 const std::function<bool(std::int64_t)>& is_wanted = {}) const {
    return near(id, Sim3(), most, is_wanted);
  }
  /// The same about another pose, relative to keyframe `id`.
  std::vector<std::int64_t> near(std::int64_t id, const Sim3& keyframe_from_pose, int most,
                                 const std::function<bool(std::int64_t)>& is_wanted = {}) const;
  /// Finished keyframes that share most words, the most similar first.
  std::vector<std::int64_t> similar(const BagOfWords& words, int most,
                                    const std::function<bool(std::int64_t)>& is_wanted = {}) const;

  /// world_from_camera in the world's unit.
  SE3 pose_of(const PlacedFrame& frame) const;
  /// Farthest that the last frame can be from where it seems to be, as seen from a keyframe: by the drift of the path
  /// between, a share of it, and by the motion in `missed` frames since.
  double reach_from(std::int64_t id, double drift, int missed) const;
  const std::vector<PlacedFrame>& frames() const { return frames_; }  ///< In the order of the recording.
  Trajectory trajectory() const;                                      ///< Of the submap with most frames.
  /// `known`: depths of the map before, to be used again; null: all are made anew.
  std::shared_ptr<const Map> snapshot(const LsdSensor& sensor, KnownMapDepths* known = nullptr) const;

 private:
  std::vector<std::uint8_t> fixed_poses(const std::optional<std::int64_t>& around) const;
  int largest_submap() const;
  int public_submap(int submap, int largest) const;
  Constraint public_form(const Constraint& edge) const;
  double step_variance(std::int64_t id) const;
  double beyond_drift(double scale_variance) const;
  void update_scale_errors();
  std::vector<double> map_scale_variances() const;

  struct Links {
    std::vector<std::int64_t> odometry;  ///< Made of it, or it of them.
    bool closes_loop = false;
    std::size_t step = 0;         ///< Index of the edge of the keyframe it was made of; size(): it begins a submap.
    double scale_variance = 0.0;  ///< scale_error(), squared.
    std::size_t bytes_in_map = 0;
  };

  LsdOptions options_;
  bool metric_;
  bool has_scale_errors_;  ///< Depths that begin at random have no scale to be in error of.
  std::vector<std::shared_ptr<const SemiDenseKeyframe>> keyframes_;
  std::vector<Sim3> poses_;
  std::vector<int> submaps_;
  std::vector<Links> links_;
  std::vector<Constraint> edges_;
  std::vector<PlacedFrame> frames_;  ///< In the order of the recording.
  PlaceIndex places_;
  std::int64_t revision_ = 0;
};

}  // namespace rastro
