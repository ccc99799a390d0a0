// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "rastro/backend/rgbd/frame_report.h"
#include "rastro/base/stopwatch.h"
#include "rastro/feature/orb.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/place/vocabulary.h"
#include "rastro/slam/lsd/constraint_search.h"
#include "rastro/slam/lsd/current_keyframe.h"
#include "rastro/slam/lsd/initialization/two_view_start.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/lsd_relocalization.h"
#include "rastro/slam/lsd/pose_search.h"
#include "rastro/slam/lsd/pose_uncertainty.h"
#include "rastro/slam/lsd/semi_dense_graph.h"
#include "rastro/slam/map_budget.h"

namespace rastro {
namespace {

constexpr double memory_reserve_mb = 100.0;  // for everything except the map

TwoViewStartOptions start_options(const LsdOptions& options) {
  TwoViewStartOptions start;
  start.min_parallax_deg = options.init_parallax_deg;
  start.seed = options.seed;
  return start;
}

LsdOptions options_for(LsdOptions options, const LsdSensor& sensor) {
  if (sensor.is_metric()) options.trusted_share = options.trusted_share_depth;
  return options;
}

}  // namespace

class LsdSlam::State {
 public:
  State(const LsdOptions& options, const LsdSensor& sensor, const SlamContext& context);
  SlamUpdate process(const Frame& frame);
  Trajectory trajectory() const;
  std::shared_ptr<const Map> snapshot() const { return graph_.snapshot(sensor_); }
  MapMemory map_memory() const;

 private:
  /// Of the last frame with a pose.
  struct Motion {
    SE3 camera_from_keyframe, velocity;  ///< The camera's motion since the frame before, in the keyframe's unit.
    TimeNs stamp = 0, duration = 0;      ///< Of that frame; between both.
    int lost_frames = 0, weak_frames = 0;
    bool lost = false;

    /// Of the camera within `time`, at this velocity.
    SE3 within(TimeNs time) const {
      return duration > 0 ? SE3::exp(velocity.log() * (static_cast<double>(time) / static_cast<double>(duration)))
                          : SE3();
    }
  };

  bool is_usable(const Frame& frame, SlamUpdate& update);
  void on_unusable_frame();
  void start(LsdFrame frame, SlamUpdate& update);
  void start_from_two_views(LsdFrame frame, SlamUpdate& update);
  void start_from_sensor(const LsdFrame& frame, SlamUpdate& update);
  void begin_map(CurrentKeyframe first, SlamUpdate& update);
  void follow(const LsdFrame& frame, SlamUpdate& update);
  void follow_kept_frames(std::size_t first);
  void doubt(SlamUpdate& update) const;
  void set_covariance(const ImageAlignment& tracked, SlamUpdate& update) const;
  void accept(const LsdFrame& frame, const ImageAlignment& tracked);
  bool needs_keyframe(const ImageAlignment& tracked) const;
  void change_keyframe(const LsdFrame& frame, const ImageAlignment& tracked, SlamUpdate& update);
  void finish_keyframe(SlamUpdate& update);
  void connect(std::int64_t id, const BagOfWords& words, SlamUpdate& update);
  void on_loss(const LsdFrame& frame, const PoseVerdict& verdict, SlamUpdate& update);
  bool relocalize(const LsdFrame& frame, bool was_tried, SlamUpdate& update);
  void stay_within_budget(SlamUpdate& update);
  CurrentKeyframe restored_keyframe(std::int64_t id) const;
  BagOfWords words_of(GrayView image, GrayView mask);

  LsdOptions options_;
  LsdSensor sensor_;
  TaskPool* pool_;
  LsdFrameMaker frames_;
  FrameCheck check_;
  SemiDenseGraph graph_;
  PoseUncertainty uncertainty_;
  TwoViewStart start_;
  ConstraintSearch constraints_;
  PoseSearch search_;
  LsdRelocalization relocalization_;
  OrbExtractor features_;
  std::optional<CurrentKeyframe> current_;
  Motion motion_;
  SE3 last_pose_;               ///< world_from_camera
  std::size_t budget_bytes_;    ///< 0: none.
  std::int64_t forgotten_ = 0;  ///< Keyframes without depths.
};

LsdSlam::State::State(const LsdOptions& options, const LsdSensor& sensor, const SlamContext& context)
    : options_(options_for(options, sensor)),
      sensor_(sensor),
      pool_(context.pool),
      frames_(sensor, options.levels, context.pool),
      check_(options.frame_check),
      graph_(options, sensor.is_metric()),
      start_(start_options(options), sensor.camera, context.pool),
      constraints_(options_, sensor_, graph_),
      search_(options_, sensor_.camera),
      relocalization_(options_, graph_, [this](std::int64_t id) { return restored_keyframe(id); }),
      features_(OrbOptions{}),
      budget_bytes_(map_budget_bytes(context, memory_reserve_mb)) {}

/// One frame, as in figure 3 of Engel et al. 2014.
SlamUpdate LsdSlam::State::process(const Frame& frame) {
  Stopwatch whole;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  update.world_from_body = last_pose_;
  if (is_usable(frame, update)) {
    LsdFrame undistorted_frame = frames_.make(frame);
    if (current_ && !(motion_.lost && motion_.lost_frames > options_.lost_frames))
      follow(undistorted_frame, update);
    else
      start(std::move(undistorted_frame), update);
  }
  last_pose_ = update.world_from_body;
  update.world_from_body = update.world_from_body * sensor_.camera_from_left();
  update.milliseconds = whole.lap_ms();
  return update;
}

bool LsdSlam::State::is_usable(const Frame& frame, SlamUpdate& update) {
  const FrameCheckResult checked = check_.check(frame.image.view(), frame.stamp);
  update.reason = reason_of(checked.reason);
  update.detail = checked.detail;
  if (checked.useful() || checked.reason == OdometryReason::blurred) return true;
  update.state = current_ ? SlamState::lost : SlamState::initializing;
  if (frame.image.empty()) update.reason = SlamReason::no_data;
  if (checked.reason != OdometryReason::repeated_frame) on_unusable_frame();
  return false;
}

/// The camera moves on unseen. That alone is no reason for a new submap: it may be covered for long.
void LsdSlam::State::on_unusable_frame() {
  motion_.lost = current_.has_value();
  motion_.lost_frames = std::min(motion_.lost_frames + 1, options_.lost_frames);
  relocalization_.reset();
}

CurrentKeyframe LsdSlam::State::restored_keyframe(std::int64_t id) const {
  const SemiDenseKeyframe& known = graph_.keyframe(id);
  return {options_,    sensor_, pool_, id, frames_.from_image(known.frame, known.stamp, known.image, known.mask),
          &known.depth};
}

void LsdSlam::State::start(LsdFrame frame, SlamUpdate& update) {
  update.state = current_ ? SlamState::lost : SlamState::initializing;
  if (current_ && (relocalize(frame, false, update) || relocalization_.is_unconfirmed())) return;
  if (sensor_.is_metric()) return start_from_sensor(frame, update);
  if (options_.start == "two_views") return start_from_two_views(std::move(frame), update);
  begin_map({options_, sensor_, pool_, graph_.size(), frame, nullptr}, update);
  update.state = SlamState::tracking;
  accept(frame, {});
}

void LsdSlam::State::start_from_two_views(LsdFrame frame, SlamUpdate& update) {
  const auto found = start_.take(frame.index, frame.stamp, std::move(frame.image), std::move(frame.mask));
  update.reason = start_.frames().size() == 1 ? SlamReason::first_frame : SlamReason::too_few_points;
  update.detail = start_.detail();
  if (!found) return;
  const TwoViewStart::KeptFrame& first = start_.frames()[found->first];
  const LsdFrame first_frame = frames_.from_image(first.index, first.stamp, first.image, first.mask);
  begin_map({options_, sensor_, pool_, graph_.size(), first_frame, &found->depth}, update);
  follow_kept_frames(found->first);
  start_.reset();
  update.state = SlamState::tracking;
  update.reason = SlamReason::none;
  update.detail.clear();
  update.world_from_body = graph_.pose_of({0, 0, current_->id(), motion_.camera_from_keyframe.inverse()});
}

/// A pair or a depth camera knows the depths of the very first frame.
void LsdSlam::State::start_from_sensor(const LsdFrame& frame, SlamUpdate& update) {
  CurrentKeyframe first(options_, sensor_, pool_, graph_.size(), frame, nullptr);
  update.reason = frame.right.empty() && frame.depth.empty() ? SlamReason::no_data : SlamReason::too_few_points;
  update.detail = fmt::format("{} pixels have a measured depth, need {}", first.pixels(), options_.start_pixels);
  if (first.pixels() < options_.start_pixels) return;
  update.reason = SlamReason::none;
  update.detail.clear();
  begin_map(std::move(first), update);
  update.state = SlamState::tracking;
  accept(frame, {});
  update.world_from_body = graph_.pose_of({0, 0, current_->id(), SE3()});
  doubt(update);
}

void LsdSlam::State::begin_map(CurrentKeyframe first, SlamUpdate& update) {
  if (current_) finish_keyframe(update);
  const std::int64_t id = first.id();
  const int submap = graph_.new_submap();
  current_.emplace(std::move(first));
  graph_.add(current_->published(), Sim3(), submap);
  uncertainty_.set_known(id, Eigen::Vector3d::Zero());
  motion_ = {};
  search_.remember(current_->pyramid());
  relocalization_.reset();
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  if (submap > 0) update.events.push_back({"submap", fmt::format("{} begins with keyframe {}", submap, id)});
}

/// Those since the first view, and those right before it as long as they fit without doubt and need no keyframe of
/// their own, in the order of the recording.
void LsdSlam::State::follow_kept_frames(std::size_t first) {
  const auto& kept = start_.frames();
  std::vector<PlacedFrame> placed;
  PoseSearch backward = search_;
  const auto track = [&](std::size_t k, const SE3& guess, PoseSearch& search) -> std::optional<ImageAlignment> {
    const LsdFrame frame = frames_.from_image(kept[k].index, kept[k].stamp, kept[k].image, kept[k].mask);
    const auto [tracked, verdict, jump_deg] = search.track(*current_, frame.pyramid, {guess, SE3(), 0});
    if (verdict.grade != PoseGrade::tracking || (k < first && needs_keyframe(tracked))) return std::nullopt;
    search.remember(frame.pyramid);
    placed.push_back({frame.index, frame.stamp, current_->id(), tracked.image_from_reference.inverse()});
    if (k > first) current_->refine(frame, tracked);
    return tracked;
  };
  SE3 pose;
  for (std::size_t k = first + 1; k < kept.size(); ++k)
    if (const auto tracked = track(k, pose, search_)) pose = tracked->image_from_reference;
  motion_.camera_from_keyframe = pose;
  placed.push_back({kept[first].index, kept[first].stamp, current_->id(), SE3()});
  pose = SE3();
  for (std::size_t k = first; k-- > 0;) {
    const auto tracked = track(k, pose, backward);
    if (!tracked) break;
    pose = tracked->image_from_reference;
  }
  std::sort(placed.begin(), placed.end(), [](const PlacedFrame& a, const PlacedFrame& b) { return a.index < b.index; });
  for (const PlacedFrame& frame : placed) graph_.add_frame(frame);
}

void LsdSlam::State::follow(const LsdFrame& frame, SlamUpdate& update) {
  if (motion_.lost) return void(relocalize(frame, false, update));
  Stopwatch stage;
  const auto [tracked, verdict, jump_deg] =
      search_.track(*current_, frame.pyramid, {motion_.camera_from_keyframe, motion_.velocity, 0});
  update.times.push_back({"track", stage.lap_ms()});
  motion_.weak_frames = verdict.grade == PoseGrade::weak ? motion_.weak_frames + 1 : 0;
  if (verdict.grade == PoseGrade::lost || motion_.weak_frames > options_.lost_frames)
    return on_loss(frame, verdict, update);
  update.state = SlamState::tracking;
  doubt(update);
  update.score = tracked.inlier_share;
  update.used = tracked.points;
  accept(frame, tracked);
  update.world_from_body = graph_.pose_of({0, 0, current_->id(), motion_.camera_from_keyframe.inverse()});
  set_covariance(tracked, update);
  if (verdict.grade == PoseGrade::weak) {
    update.state = SlamState::weak;
    update.reason = verdict.reason;
    update.detail = verdict.detail;
  } else if (needs_keyframe(tracked)) {
    change_keyframe(frame, tracked, update);
  } else {
    current_->refine(frame, tracked);
  }
  update.times.push_back({"depth", stage.lap_ms()});
}

/// What is not known yet: where a submap lies, and random depths at first.
void LsdSlam::State::doubt(SlamUpdate& update) const {
  constexpr std::int64_t until_converged = 5;  // keyframes
  const std::int64_t id = current_->id();
  if (graph_.submap(id) != 0) {
    update.reason = SlamReason::apart;
    update.detail = fmt::format("in submap {}, not connected to the first yet", graph_.submap(id));
  } else if (options_.start == "random" && id < until_converged) {
    update.reason = SlamReason::unconfirmed;
    update.detail = "depths that began at random have not converged yet";
  } else {
    return;
  }
  update.state = SlamState::weak;
}

/// None in a submap apart from the first: where it lies is unknown.
void LsdSlam::State::set_covariance(const ImageAlignment& tracked, SlamUpdate& update) const {
  const std::int64_t id = current_->id();
  if (graph_.submap(id) != 0) return;
  update.covariance = uncertainty_.of_frame(id, graph_.pose(id).scale(), current_->mean_inverse_depth(),
                                            update.world_from_body, tracked);
}

void LsdSlam::State::accept(const LsdFrame& frame, const ImageAlignment& tracked) {
  motion_.velocity = motion_.lost ? SE3() : tracked.image_from_reference * motion_.camera_from_keyframe.inverse();
  motion_.camera_from_keyframe = tracked.image_from_reference;
  motion_.duration = motion_.lost ? 0 : frame.stamp - motion_.stamp;
  motion_.stamp = frame.stamp;
  motion_.lost = false;
  motion_.lost_frames = 0;
  search_.remember(frame.pyramid);
  graph_.add_frame({frame.index, frame.stamp, current_->id(), tracked.image_from_reference.inverse()});
}

/// Engel et al. 2013, section 2.3: the distance in mean inverse depths; and what is out of view.
bool LsdSlam::State::needs_keyframe(const ImageAlignment& tracked) const {
  const double distance = tracked.image_from_reference.inverse().translation().norm();
  return tracked.rms < options_.keyframe_residual &&
         (distance * current_->mean_inverse_depth() > options_.keyframe_distance ||
          tracked.overlap < options_.keyframe_overlap);
}

void LsdSlam::State::change_keyframe(const LsdFrame& frame, const ImageAlignment& tracked, SlamUpdate& update) {
  finish_keyframe(update);
  const std::int64_t before = current_->id(), id = graph_.size();
  const SE3 depth_from_color = motion_.within(frame.depth_stamp - frame.stamp);
  const Sim3 before_from_new = current_->change_to(id, frame, tracked.image_from_reference, depth_from_color);
  graph_.add(current_->published(), graph_.pose(before) * before_from_new, graph_.submap(before));
  const double unit = before_from_new.scale();
  const Matrix6d to_new = tracked.image_from_reference.adjoint();
  Matrix6d covariance = to_new * tracked.covariance * to_new.transpose();
  covariance.topLeftCorner<3, 3>() /= unit * unit;
  covariance.topRightCorner<3, 3>() /= unit;
  covariance.bottomLeftCorner<3, 3>() /= unit;
  covariance += common_covariance(current_->mean_inverse_depth());
  Constraint edge{before, id, before_from_new, covariance.inverse()};
  edge.inliers = tracked.points;
  graph_.add_edge(edge);
  if (update.covariance) uncertainty_.set(id, graph_.pose(id).translation(), *update.covariance);
  motion_.camera_from_keyframe = SE3();
  motion_.velocity = SE3(motion_.velocity.rotation(), motion_.velocity.translation() / unit);
  stay_within_budget(update);
  update.events.push_back({"keyframe", fmt::format("{}", id)});
}

void LsdSlam::State::finish_keyframe(SlamUpdate& update) {
  Stopwatch stage;
  const auto finished = current_->published();
  graph_.replace(finished);
  const BagOfWords words = words_of(finished->image.view(), finished->mask.view());
  connect(finished->id, words, update);
  graph_.add_words(finished->id, words);
  update.times.push_back({"constraints", stage.lap_ms()});
}

void LsdSlam::State::connect(std::int64_t id, const BagOfWords& words, SlamUpdate& update) {
  const std::vector<Constraint> found = constraints_.find(id, words);
  for (const Constraint& edge : found) {
    if (graph_.submap(edge.from) != graph_.submap(id)) {
      update.events.push_back({"joined", fmt::format("submaps {} and {} by keyframes {} and {}",
                                                     graph_.submap(edge.from), graph_.submap(id), edge.from, id)});
      graph_.merge(edge);
    }
    if (edge.kind == ConstraintKind::loop)
      update.events.push_back({"loop_closed", fmt::format("keyframe {} with {}", id, edge.from)});
    graph_.add_edge(edge);
  }
  if (!found.empty()) graph_.optimize();
}

void LsdSlam::State::on_loss(const LsdFrame& frame, const PoseVerdict& verdict, SlamUpdate& update) {
  update.reason = verdict.reason;
  update.detail = verdict.detail;
  motion_.lost = true;
  motion_.weak_frames = 0;
  relocalize(frame, true, update);
}

/// `was_tried`: on the current keyframe.
bool LsdSlam::State::relocalize(const LsdFrame& frame, bool was_tried, SlamUpdate& update) {
  const ExpectedMotion last{motion_.camera_from_keyframe, motion_.velocity, motion_.lost_frames};
  ++motion_.lost_frames;
  auto found = relocalization_.take(
      frame, *current_, last, search_, was_tried, [&] { return words_of(frame.image.view(), frame.mask.view()); },
      update);
  if (!found) return false;
  if (found->keyframe) {
    finish_keyframe(update);
    current_.emplace(std::move(*found->keyframe));
  }
  for (const PlacedFrame& earlier : found->earlier) graph_.add_frame(earlier);
  motion_.lost = false;
  motion_.camera_from_keyframe = found->last_pose;
  accept(frame, found->tracked.alignment);
  update.state = SlamState::relocalized;
  update.reason = SlamReason::none;
  update.detail.clear();
  update.events.push_back({"relocalized", fmt::format("in keyframe {}", found->id)});
  update.score = found->tracked.alignment.inlier_share;
  update.used = found->tracked.alignment.points;
  update.world_from_body = graph_.pose_of({0, 0, found->id, motion_.camera_from_keyframe.inverse()});
  start_.reset();
  return true;
}

/// The oldest keyframes keep their poses only.
void LsdSlam::State::stay_within_budget(SlamUpdate& update) {
  constexpr std::int64_t kept = 3;
  if (budget_bytes_ == 0) return;
  const std::int64_t before = forgotten_;
  const auto most = static_cast<std::size_t>(MapBudget::full_share * static_cast<double>(budget_bytes_));
  while (graph_.bytes() > most && graph_.forget_oldest(kept)) ++forgotten_;
  if (forgotten_ > before) update.events.push_back({"memory", map_memory().measures});
}

MapMemory LsdSlam::State::map_memory() const {
  return {graph_.bytes(), budget_bytes_,
          forgotten_ == 0 ? std::string() : fmt::format("depths of the {} oldest keyframes dropped", forgotten_)};
}

BagOfWords LsdSlam::State::words_of(GrayView image, GrayView mask) {
  BagOfWords words = standard_vocabulary()->words_of(features_.extract(image, mask, pool_).descriptors);
  words.nodes = {};
  return words;
}

Trajectory LsdSlam::State::trajectory() const {
  Trajectory trajectory = graph_.trajectory();
  for (StampedPose& pose : trajectory) pose.world_from_body = pose.world_from_body * sensor_.camera_from_left();
  return trajectory;
}

LsdSlam::LsdSlam(const LsdOptions& options, const LsdSensor& sensor, const SlamContext& context)
    : options_(options),
      sensor_(sensor),
      context_(context),
      state_(std::make_unique<State>(options, sensor, context)) {}
LsdSlam::~LsdSlam() = default;
SlamUpdate LsdSlam::process(const Frame& frame) { return state_->process(frame); }
std::vector<SlamEvent> LsdSlam::finish() { return {}; }
Trajectory LsdSlam::trajectory() const { return state_->trajectory(); }
std::shared_ptr<const Map> LsdSlam::snapshot() const { return state_->snapshot(); }
MapMemory LsdSlam::map_memory() const { return state_->map_memory(); }
void LsdSlam::reset() { state_ = std::make_unique<State>(options_, sensor_, context_); }

}  // namespace rastro
