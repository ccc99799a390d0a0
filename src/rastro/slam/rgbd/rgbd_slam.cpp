// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/rgbd_slam.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rastro/backend/pipeline.h"
#include "rastro/base/checked_options.h"
#include "rastro/base/error.h"
#include "rastro/base/stopwatch.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/graph/edit.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/odometry/rgbd_tracking/rgbd_follower.h"
#include "rastro/slam/rgbd/mapper.h"
#include "rastro/slam/rgbd/relocaliser.h"
#include "rastro/slam/rgbd/tracked_map.h"

namespace rastro {
namespace {

SlamReason reason_of(OdometryReason reason) {
  switch (reason) {
    case OdometryReason::none:
    case OdometryReason::no_motion:
    case OdometryReason::pure_rotation:
      return SlamReason::none;
    case OdometryReason::first_frame:
      return SlamReason::first_frame;
    case OdometryReason::too_few_points:
      return SlamReason::too_few_points;
    case OdometryReason::dark_or_blank:
      return SlamReason::dark_or_blank;
    case OdometryReason::blurred:
      return SlamReason::blurred;
    case OdometryReason::repeated_frame:
      return SlamReason::repeated_frame;
    case OdometryReason::gap:
      return SlamReason::gap;
    case OdometryReason::too_little_parallax:
    case OdometryReason::few_inliers:
    case OdometryReason::calibration_doubtful:
      return SlamReason::few_inliers;
  }
  return SlamReason::none;
}

/// What the map's files and pictures need of a frame.
Frame kept_of(const Frame& frame) {
  Frame kept;
  kept.index = frame.index;
  kept.stamp = frame.stamp;
  kept.image = frame.image;
  kept.colour.rgb = frame.colour.rgb;
  kept.depth = frame.depth;
  kept.mask = frame.mask;
  return kept;
}

/// Of b in a * b, at the right, where both are known so well.
Matrix6d chained(const Matrix6d& of_a, const SE3& b, const Matrix6d& of_b) {
  const Matrix6d turned = b.inverse().adjoint();
  const Matrix6d sum = turned * of_a * turned.transpose() + of_b;
  return 0.5 * (sum + sum.transpose());
}

/// At the right of the pose to errors in the world's axes.
Matrix6d in_world_axes(const Matrix6d& covariance, const SE3& pose) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = pose.rotation().matrix();
  const Matrix6d turned = turn * covariance * turn.transpose();
  return 0.5 * (turned + turned.transpose());
}

/// What every map of a run shares.
Map base_map(const RgbdSlamOptions& options, const Camera& camera) {
  Map map;
  map.method = "rgbd";
  const DepthNoise noise{options.follow.depth_sigma_m, options.follow.depth_sigma_per_m2};
  map.cameras.push_back({CameraKind::depth, camera, 0.0, noise, SE3()});
  map.sessions.push_back({0, 0, "", 0, 0, {true, 0.0, "depth camera"}});
  return map;
}

/// Rays of its features and blocks of its surfaces are taken by the camera of this run.
void check_camera(const Camera& other, const Camera& camera) {
  constexpr double most_share = 0.01;  // of the width: calibrations of one camera differ by less
  const double most_px = most_share * camera.width;
  const double apart_px = std::max({std::abs(other.fx - camera.fx), std::abs(other.fy - camera.fy),
                                    std::abs(other.cx - camera.cx), std::abs(other.cy - camera.cy)});
  if (other.width == camera.width && other.height == camera.height && apart_px <= most_px) return;
  throw Error(fmt::format("was made by another camera ({} x {} pixels, focal length {:.1f} px)", other.width,
                          other.height, other.fx),
              "--map",
              fmt::format("this run has {} x {} pixels, focal length {:.1f} px: give a map of the same camera",
                          camera.width, camera.height, camera.fx));
}

/// With the map to localize in as this method needs it, keyframes counted from 0. Error where it lacks what they are
/// found by.
SlamContext with_usable_map(SlamContext context, const Camera& camera) {
  if (!context.map) return context;
  const Map& map = *context.map;
  check_camera(camera_of(map, "--map").intrinsics, camera);
  const auto features = map.layer<FeatureLayer>();
  const auto images = map.layer<ImageLayer>();
  for (const Keyframe& keyframe : map.keyframes) {
    const ImageFeatures* image = features ? features->find(keyframe.id) : nullptr;
    const bool has_images =
        images && std::binary_search(images->keyframes.begin(), images->keyframes.end(), keyframe.id);
    if (!image || !has_images || image->depths.size() != image->features.size())
      throw Error("has keyframes without features, their depths or depth images", "--map",
                  "give a map that 'rgbd' made");
  }
  context.map = std::make_shared<const Map>(renumbered(map));
  return context;
}

/// Where and how surely the frame is, as far as the follower knows.
struct Anchor {
  std::int64_t keyframe = -1;
  SE3 world_from_keyframe;                           ///< In the follower's world.
  Matrix6d covariance = Matrix6d::Zero();            ///< Of the keyframe, from the graph.
  SE3 world_from_reference;                          ///< What the follower's covariance counts from.
  Matrix6d reference_covariance = Matrix6d::Zero();  ///< Of the reference as seen from the keyframe.
};

}  // namespace

class RgbdSlam::State {
 public:
  State(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context);

  SlamUpdate process(const Frame& frame);
  std::vector<SlamEvent> finish();
  Trajectory trajectory() const { return map_.trajectory(); }
  std::shared_ptr<const Map> snapshot() const { return map_.snapshot(); }

 private:
  /// What mapping made of a keyframe.
  struct MappedKeyframe {
    std::int64_t keyframe = 0;
    int stretch = 0;
    MapRevision revision;
  };

  bool exists() const { return anchor_.keyframe >= 0; }
  void follow(const Frame& frame, SlamUpdate& update);
  void on_pose(const Frame& frame, const RgbdFollow& followed, SlamUpdate& update);
  void on_loss(const Frame& frame, SlamUpdate& update);
  void look_around(const Frame& frame, SlamUpdate& update);
  bool start_again(const Frame& frame, const SE3& world_from_camera, const std::optional<Constraint>& tie,
                   SlamUpdate& update);
  bool needs_keyframe(const RgbdFollow& followed) const;
  void make_keyframe(const Frame& frame, const SE3& world_from_camera, const std::vector<Constraint>& ties, int submap,
                     const Matrix6d& covariance, SlamUpdate& update);
  Constraint way_edge(const SE3& world_from_camera, const Matrix6d& covariance) const;
  void apply(MappedKeyframe mapped, std::vector<SlamEvent>& events);
  void say_pose(const SE3& world_from_camera, const Matrix6d& covariance, SlamUpdate& update);

  RgbdSlamOptions options_;
  Camera camera_;
  bool maps_;
  Mapper mapper_;
  TrackedMap map_;
  Relocaliser relocaliser_;
  RgbdFollower follower_;
  Anchor anchor_;
  MapArchive* archive_;           ///< Null: nothing is kept safe.
  std::int64_t seen_ = 0;         ///< Frames given, of any kind.
  std::int64_t anchor_seen_ = 0;  ///< When the last keyframe was made.
  bool following_ = true;         ///< False: the follower knows no place to go on from.
  bool lost_ = false;
  int lost_frames_ = 0;  ///< With something to see in them.
  int stretch_ = 0;      ///< Of frames followed without a break.
  SE3 last_pose_;
  Pipeline<MappedKeyframe> pipeline_;  ///< Last: its jobs use what is above.
};

RgbdSlam::State::State(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context)
    : options_(checked(options, "rgbd options")),
      camera_(camera),
      maps_(context.map == nullptr),
      mapper_(options_, camera, context),
      map_(context.map ? *context.map : base_map(options_, camera), mapper_.pictures(), context.map != nullptr),
      relocaliser_(options_, camera, mapper_.depths()),
      follower_(options_.follow, camera, context.pool),
      archive_(maps_ ? context.archive : nullptr),
      following_(maps_),
      lost_(!maps_),
      pipeline_({.own_thread = context.pipelined && context.pool != nullptr && context.pool->threads() > 1}) {}

SlamUpdate RgbdSlam::State::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  ++seen_;
  while (auto mapped = pipeline_.take_due({seen_, frame.stamp})) apply(std::move(*mapped), update.events);
  update.times.push_back({"wait", stage.lap_ms()});
  update.world_from_body = last_pose_;
  follow(frame, update);
  last_pose_ = update.world_from_body;
  if (archive_ != nullptr && archive_->wants_map()) archive_->keep(map_.snapshot());
  update.milliseconds = whole.lap_ms();
  return update;
}

void RgbdSlam::State::follow(const Frame& frame, SlamUpdate& update) {
  Stopwatch stage;
  if (!following_) {
    update.state = exists() ? SlamState::lost : SlamState::initialising;
    update.reason = SlamReason::not_found;
    look_around(frame, update);
    update.times.push_back({"relocalise", stage.lap_ms()});
    return;
  }
  const RgbdFollow followed = follower_.follow(frame);
  update.times.push_back({"follow", stage.lap_ms()});
  update.reason = reason_of(followed.reason);
  update.detail = followed.detail;
  update.world_from_body = followed.world_from_camera;
  const bool nothing_new =
      followed.reason == OdometryReason::dark_or_blank || followed.reason == OdometryReason::repeated_frame;
  if (followed.state == OdometryState::initialising) {
    update.state = SlamState::initialising;
  } else if (followed.reason == OdometryReason::repeated_frame && !lost_ && exists()) {
    update.state = SlamState::weak;
    map_.add_frame(frame.stamp, anchor_.keyframe, anchor_.world_from_keyframe.inverse() * followed.world_from_camera);
  } else if (followed.state == OdometryState::lost || nothing_new) {
    update.state = SlamState::lost;
    on_loss(frame, update);
    update.times.push_back({"relocalise", stage.lap_ms()});
  } else {
    on_pose(frame, followed, update);
    update.times.push_back({"keyframe", stage.lap_ms()});
  }
}

void RgbdSlam::State::on_pose(const Frame& frame, const RgbdFollow& followed, SlamUpdate& update) {
  update.state = followed.state == OdometryState::weak ? SlamState::weak : SlamState::tracking;
  if (lost_) update.state = SlamState::relocalised;
  lost_ = false;
  lost_frames_ = 0;
  update.score = followed.points > 0 ? static_cast<double>(followed.inliers) / followed.points : 1.0;
  update.used = followed.inliers + followed.surface_points;
  const SE3& pose = followed.world_from_camera;
  if (!exists()) {
    make_keyframe(frame, pose, {}, map_.new_submap(), Matrix6d::Zero(), update);
  } else {
    const Matrix6d from_keyframe =
        chained(anchor_.reference_covariance, anchor_.world_from_reference.inverse() * pose, followed.covariance);
    const SE3 keyframe_from_camera = anchor_.world_from_keyframe.inverse() * pose;
    const Matrix6d covariance = chained(anchor_.covariance, keyframe_from_camera, from_keyframe);
    if (followed.new_reference || needs_keyframe(followed)) {
      make_keyframe(frame, pose, {way_edge(pose, from_keyframe)}, map_.submap(anchor_.keyframe), covariance, update);
    } else {
      say_pose(pose, covariance, update);
    }
    map_.add_frame(frame.stamp, anchor_.keyframe, anchor_.world_from_keyframe.inverse() * pose);
    return;
  }
  map_.add_frame(frame.stamp, anchor_.keyframe, SE3());
}

bool RgbdSlam::State::needs_keyframe(const RgbdFollow& followed) const {
  const SE3 moved = anchor_.world_from_keyframe.inverse() * followed.world_from_camera;
  return moved.translation().norm() >= options_.keyframe_distance_m ||
         moved.rotation().log().norm() >= options_.keyframe_angle_rad ||
         seen_ - anchor_seen_ >= options_.keyframe_frames;
}

Constraint RgbdSlam::State::way_edge(const SE3& world_from_camera, const Matrix6d& covariance) const {
  Constraint edge;
  edge.from = anchor_.keyframe;
  edge.to = map_.keyframe_count();
  edge.from_from_to = Sim3(anchor_.world_from_keyframe.inverse() * world_from_camera);
  Matrix6d softened = covariance;
  softened.diagonal().head<3>().array() += options_.edge_sigma_m * options_.edge_sigma_m;
  softened.diagonal().tail<3>().array() += options_.edge_sigma_rad * options_.edge_sigma_rad;
  edge.information = softened.inverse();
  edge.information = (0.5 * (edge.information + edge.information.transpose())).eval();
  edge.kind = ConstraintKind::odometry;
  return edge;
}

void RgbdSlam::State::make_keyframe(const Frame& frame, const SE3& world_from_camera,
                                    const std::vector<Constraint>& ties, int submap, const Matrix6d& covariance,
                                    SlamUpdate& update) {
  const std::int64_t id = map_.keyframe_count();
  const auto order =
      std::make_shared<const KeyframeOrder>(KeyframeOrder{id, kept_of(frame), world_from_camera, submap, ties});
  map_.add_pending({world_from_camera, submap}, covariance);
  anchor_ = {id, world_from_camera, covariance, world_from_camera, Matrix6d::Zero()};
  anchor_seen_ = seen_;
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  say_pose(world_from_camera, covariance, update);
  const auto job = [this, order, stretch = stretch_] {
    return MappedKeyframe{order->id, stretch, mapper_.add(*order)};
  };
  pipeline_.submit(job, {seen_, frame.stamp}, {.frames = options_.backend_delay_frames});
}

void RgbdSlam::State::say_pose(const SE3& world_from_camera, const Matrix6d& covariance, SlamUpdate& update) {
  update.world_from_body = world_from_camera;
  update.covariance = in_world_axes(covariance, world_from_camera);
  const int submap = map_.submap(anchor_.keyframe);
  if (submap == 0) return;
  if (update.state == SlamState::tracking) update.state = SlamState::weak;
  update.reason = SlamReason::apart;
  update.detail = fmt::format("in submap {}, not tied to the first yet: placed by a guess", submap);
}

void RgbdSlam::State::on_loss(const Frame& frame, SlamUpdate& update) {
  if (!lost_) lost_frames_ = 0;
  lost_ = true;
  if (update.reason == SlamReason::dark_or_blank || update.reason == SlamReason::repeated_frame) return;
  look_around(frame, update);
}

/// For the map first; ground that was not found again long enough is taken for new.
void RgbdSlam::State::look_around(const Frame& frame, SlamUpdate& update) {
  if (frame.image.empty() || frame.depth.empty()) {
    if (update.reason == SlamReason::not_found || update.reason == SlamReason::none)
      update.reason = SlamReason::no_data;
    return;
  }
  ++lost_frames_;
  if ((lost_frames_ - 1) % options_.relocalise_every == 0) {
    const auto seed = seed_for(options_.follow.seed ^ 0x5EEDULL, static_cast<std::uint64_t>(seen_));
    const Relocaliser::Try tried = relocaliser_.find(frame, map_.keyframes(), seed);
    if (update.detail.empty())
      update.detail = fmt::format("{} features, not found in {} keyframes", tried.features, tried.compared);
    if (tried.found) {
      const auto& [keyframe, tie] = *tried.found;
      const Constraint edge{keyframe,        map_.keyframe_count(),     Sim3(tie.a_from_b),
                            tie.information, ConstraintKind::proximity, 1.0,
                            tie.inliers};
      if (!start_again(frame, map_.pose(keyframe) * tie.a_from_b, edge, update)) return;
      update.score = static_cast<double>(tie.inliers) / std::max(1, tie.matches);
      update.used = tie.inliers;
      update.events.push_back(
          {"relocalised", fmt::format("in keyframe {} with {} inliers of {} matches after {} frames", keyframe,
                                      tie.inliers, tie.matches, lost_frames_)});
      return;
    }
  }
  if (maps_ && exists() && lost_frames_ >= options_.lost_frames) {
    const SE3 guess = update.world_from_body;
    if (start_again(frame, guess, std::nullopt, update))
      update.events.push_back({"submap", fmt::format("{} begun, nothing known was seen in {} frames",
                                                     map_.submap(anchor_.keyframe), lost_frames_)});
  }
}

bool RgbdSlam::State::start_again(const Frame& frame, const SE3& world_from_camera,
                                  const std::optional<Constraint>& tie, SlamUpdate& update) {
  follower_.restart(world_from_camera);
  const RgbdFollow followed = follower_.follow(frame);
  following_ = followed.new_reference;
  if (!following_) return false;
  ++stretch_;
  lost_ = false;
  update.state = SlamState::relocalised;
  update.reason = SlamReason::none;
  update.detail.clear();
  if (tie) {
    const Matrix6d covariance = chained(map_.covariance(tie->from), tie->rigid(), tie->information.inverse());
    make_keyframe(frame, world_from_camera, {*tie}, map_.submap(tie->from), covariance, update);
  } else {
    make_keyframe(frame, world_from_camera, {}, map_.new_submap(), Matrix6d::Zero(), update);
  }
  map_.add_frame(frame.stamp, anchor_.keyframe, SE3());
  return true;
}

/// The follower goes on from where the graph put its keyframe.
void RgbdSlam::State::apply(MappedKeyframe mapped, std::vector<SlamEvent>& events) {
  events.insert(events.end(), mapped.revision.events.begin(), mapped.revision.events.end());
  const SE3 before = map_.pose(mapped.keyframe);
  map_.apply(std::move(mapped.revision));
  if (mapped.keyframe == anchor_.keyframe) anchor_.covariance = map_.covariance(mapped.keyframe);
  if (mapped.stretch != stretch_) return;
  const SE3 correction = map_.pose(mapped.keyframe) * before.inverse();
  constexpr double least = 1e-9;
  if (!(correction.log().norm() > least)) return;
  follower_.move(correction);
  map_.move_pending(mapped.keyframe + 1, correction);
  if (mapped.keyframe != anchor_.keyframe)
    anchor_.world_from_keyframe = correction * anchor_.world_from_keyframe;
  else
    anchor_.world_from_keyframe = map_.pose(mapped.keyframe);
  anchor_.world_from_reference = correction * anchor_.world_from_reference;
  last_pose_ = correction * last_pose_;
}

std::vector<SlamEvent> RgbdSlam::State::finish() {
  std::vector<SlamEvent> events;
  while (auto mapped = pipeline_.take_next()) apply(std::move(*mapped), events);
  if (!maps_) return events;
  MapRevision revision = mapper_.settle();  // no job is under way any more
  events.insert(events.end(), revision.events.begin(), revision.events.end());
  map_.apply(std::move(revision));
  if (map_.make_largest_first()) events.push_back({"submap", "the largest is the first from now on"});
  return events;
}

RgbdSlam::RgbdSlam(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context)
    : options_(options),
      camera_(camera),
      context_(with_usable_map(context, camera)),
      state_(std::make_unique<State>(options, camera, context_)) {}
RgbdSlam::~RgbdSlam() = default;
SlamUpdate RgbdSlam::process(const Frame& frame) { return state_->process(frame); }
std::vector<SlamEvent> RgbdSlam::finish() { return state_->finish(); }
Trajectory RgbdSlam::trajectory() const { return state_->trajectory(); }
std::shared_ptr<const Map> RgbdSlam::snapshot() const { return state_->snapshot(); }

void RgbdSlam::reset() {
  state_.reset();  // its jobs end before the next ones begin
  state_ = std::make_unique<State>(options_, camera_, context_);
}

}  // namespace rastro
