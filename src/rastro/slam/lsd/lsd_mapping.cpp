// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_mapping.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "rastro/base/stopwatch.h"
#include "rastro/slam/lsd/lsd_motion.h"
#include "rastro/slam/lsd/pose_uncertainty.h"
#include "rastro/slam/lsd/refinement/final_refinement.h"
#include "rastro/slam/lsd/refinement/frame_correction.h"
#include "rastro/slam/lsd/tracking/pose_check.h"
#include "rastro/slam/map_budget.h"

namespace rastro {
namespace {

constexpr double memory_reserve_mb = 100.0;  // for everything except the map

/// Of the new keyframe relative to the one before, in the new one's unit.
Constraint edge_to_new(std::int64_t before, std::int64_t id, const Sim3& before_from_new, double mean_inverse_depth,
                       const ImageAlignment& tracked) {
  const double unit = before_from_new.scale();
  const Matrix6d to_new = tracked.image_from_reference.adjoint();
  Matrix6d covariance = to_new * tracked.covariance * to_new.transpose();
  covariance.topLeftCorner<3, 3>() /= unit * unit;
  covariance.topRightCorner<3, 3>() /= unit;
  covariance.bottomLeftCorner<3, 3>() /= unit;
  covariance += common_covariance(mean_inverse_depth);
  Constraint edge{before, id, before_from_new, covariance.inverse()};
  edge.inliers = tracked.points;
  edge.scale_variance = scale_variance_of_new(share_of_new(tracked), tracked.motion_error());
  return edge;
}

}  // namespace

LsdMapping::LsdMapping(const LsdOptions& options, const LsdSensor& sensor, const LsdFrameMaker& frames,
                       const LsdPools& pools, const SlamContext& context)
    : options_(options),
      sensor_(sensor),
      frames_(frames),
      pools_(pools),
      graph_(options, sensor.is_metric()),
      constraints_(options, sensor, graph_, pools.mapping),
      features_(OrbOptions{}),
      stop_(context.stop),
      on_finishing_(context.on_finishing),
      safe_{.archive = context.archive},
      budget_bytes_(map_budget_bytes(context, memory_reserve_mb)) {}

void LsdMapping::begin_map(KeyframeDepths first, SlamUpdate& update) {
  if (depths_) finish_keyframe(update);
  const std::int64_t id = first.id();
  const int submap = graph_.new_submap();
  depths_.emplace(std::move(first));
  is_finished_ = false;
  change_ = {};
  graph_.add(depths_->published(), Sim3(), submap);
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  if (submap > 0) update.events.push_back({"submap", fmt::format("{} begins with keyframe {}", submap, id)});
}

std::optional<Sim3> LsdMapping::process(const MappingInput& input, SlamUpdate& update) {
  const LsdFrame& frame = *input.frame;
  graph_.add_frame({frame.index, frame.stamp, input.keyframe, input.tracked.image_from_reference.inverse()});
  Stopwatch stage;
  if (input.use == MappingInput::Use::keyframe) {
    finish_keyframe(update);
    if (const auto before_from_earlier = go_on_in_earlier(input, update)) return before_from_earlier;
    return change_keyframe(input, update);
  }
  if (input.use == MappingInput::Use::refine) {
    if (const auto tracked = on_newest(input)) refine(frame, *tracked);
    update.times.push_back({"depth", stage.lap_ms()});
  }
  return std::nullopt;
}

void LsdMapping::refine(const LsdFrame& frame, const ImageAlignment& tracked) {
  depths_->refine(frame, tracked);
  if (!is_finished_)
    graph_.know_scale(depths_->id(), scale_variance_of_new(change_.share_of_new, tracked.motion_error()));
}

/// The alignment with the newest keyframe of a frame that was tracked on it, or on the one before. nullopt: it was
/// tracked on another one.
std::optional<ImageAlignment> LsdMapping::on_newest(const MappingInput& input) const {
  ImageAlignment tracked = input.tracked;
  if (input.keyframe == depths_->id()) return tracked;
  if (input.keyframe != change_.before) return std::nullopt;
  tracked.image_from_reference = on_new_keyframe(tracked.image_from_reference, change_.before_from_new);
  tracked.gain /= change_.gain;
  tracked.offset -= tracked.gain * change_.offset;
  return tracked;
}

Sim3 LsdMapping::change_keyframe(const MappingInput& input, SlamUpdate& update) {
  Stopwatch stage;
  const std::int64_t before = depths_->id(), id = graph_.size();
  const Sim3 before_from_new = depths_->change_to(id, *input.frame, input.tracked, input.depth_from_color);
  is_finished_ = false;
  change_ = {before, before_from_new, input.tracked.gain, input.tracked.offset, share_of_new(input.tracked)};
  graph_.add(depths_->published(), graph_.pose(before) * before_from_new, graph_.submap(before));
  graph_.add_edge(edge_to_new(before, id, before_from_new, depths_->mean_inverse_depth(), input.tracked));
  stay_within_budget(update);
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  update.times.push_back({"depth", stage.lap_ms()});
  return before_from_new;
}

/// Where the camera was before, the map has a keyframe already (the reactivation of Engel et al. 2013, section 2.3):
/// nullopt where none is near enough, or the frame does not fit where the map says.
std::optional<Sim3> LsdMapping::go_on_in_earlier(const MappingInput& input, SlamUpdate& update) {
  constexpr double max_deviation = 0.1;  // mean distances, between alignment and map
  const std::int64_t before = depths_->id();
  if (input.keyframe != before || options_.return_share <= 0.0) return std::nullopt;
  Stopwatch stage;
  const SE3& frame_from_before = input.tracked.image_from_reference;
  const auto nearest =
      graph_.near(before, Sim3(frame_from_before.inverse()), 1, [&](std::int64_t other) { return other != before; });
  if (nearest.empty()) return std::nullopt;
  const Sim3 expected_change = graph_.pose(before).inverse() * graph_.pose(nearest.front());
  const SE3 expected = on_new_keyframe(frame_from_before, expected_change);
  KeyframeDepths earlier = restored_keyframe(nearest.front());
  const ImageAlignment tracked = earlier.current().track(input.frame->pyramid, expected);
  const SE3 deviation = tracked.image_from_reference * expected.inverse();
  const bool is_there =
      deviation.translation().norm() * earlier.mean_inverse_depth() + deviation.rotation().log().norm() < max_deviation;
  const bool is_sure = judge_pose(tracked, earlier.mean_inverse_depth(), 0.0, options_).grade == PoseGrade::tracking;
  if (!is_there || !is_sure || !earlier.current().is_met_by(tracked)) return std::nullopt;
  depths_.emplace(std::move(earlier));
  is_finished_ = true;
  const double unit = expected_change.scale();
  const SE3& frame_from_earlier = tracked.image_from_reference;
  const Sim3 before_from_earlier = Sim3(frame_from_before.inverse()) *
                                   Sim3(unit, frame_from_earlier.rotation(), unit * frame_from_earlier.translation());
  change_ = {before, before_from_earlier, input.tracked.gain / tracked.gain,
             (input.tracked.offset - tracked.offset) / tracked.gain};
  update.events.push_back({"returned", fmt::format("to keyframe {}", nearest.front())});
  update.times.push_back({"depth", stage.lap_ms()});
  return before_from_earlier;
}

void LsdMapping::return_to(std::int64_t id, SlamUpdate& update) {
  finish_keyframe(update);
  depths_.emplace(restored_keyframe(id));
  is_finished_ = true;
  change_ = {};
}

std::shared_ptr<const Map> LsdMapping::map_to_keep() {
  constexpr double most_share = 0.05;  // of the time
  if (safe_.archive == nullptr || safe_.snapshot_ms > most_share * safe_.since.elapsed_ms()) return nullptr;
  if (is_stopped() || !safe_.archive->wants_map()) return nullptr;
  Stopwatch watch;
  auto map = graph_.snapshot(sensor_, &safe_.known);
  safe_.snapshot_ms = watch.lap_ms();
  safe_.since = Stopwatch();
  return map;
}

void LsdMapping::finish(SlamUpdate& update) {
  if (!depths_) return;
  finish_keyframe(update);
  is_finished_ = true;
  if (is_stopped() || options_.refine_iterations == 0 || graph_.size() < FinalRefinement::least_keyframes) return;
  FinalRefinement refinement(options_, graph_, sensor_);
  const std::string summary = refinement.run(
      pools_.tracking, [this] { return is_stopped(); }, on_finishing_);
  if (!refinement.is_better()) return;
  graph_.set_poses(refinement.poses());
  if (!sensor_.is_metric()) graph_.set_frames(frames_between_corrected_keyframes(graph_));
  update.events.push_back({"map_revised", summary});
}

/// Its depths stay as they were when an earlier one went on: smoothed each time, they would lose detail.
void LsdMapping::finish_keyframe(SlamUpdate& update) {
  if (is_finished_) return;
  Stopwatch stage;
  const auto finished = depths_->published();
  graph_.replace(finished);
  const BagOfWords words = words_of(finished->image.view(), finished->mask.view());
  if (!is_stopped()) connect(finished->id, words, update);
  graph_.add_words(finished->id, words);
  update.times.push_back({"constraints", stage.lap_ms()});
}

void LsdMapping::connect(std::int64_t id, const BagOfWords& words, SlamUpdate& update) {
  const std::vector<Constraint> found = constraints_.find(id, words);
  const bool is_loop = add_constraints(found, update);
  if (!found.empty()) graph_.optimize(is_loop ? std::nullopt : std::optional(id));
  if (is_loop && connect_before(id, update)) graph_.optimize();
}

/// The corrected map tells where the keyframes right before a loop saw the place already.
bool LsdMapping::connect_before(std::int64_t id, SlamUpdate& update) {
  bool is_any = false;
  for (std::int64_t before = id - 1; before > id - ConstraintSearch::consecutive && before >= 0; --before) {
    if (is_stopped() || graph_.closes_loop(before) || graph_.keyframe(before).image.empty()) break;
    if (!add_constraints(constraints_.find_revisited(before), update)) break;
    is_any = true;
  }
  return is_any;
}

/// Whether one closes a loop or joins submaps.
bool LsdMapping::add_constraints(const std::vector<Constraint>& found, SlamUpdate& update) {
  bool is_loop = false;
  for (const Constraint& edge : found) {
    is_loop |= edge.kind != ConstraintKind::proximity;
    if (graph_.submap(edge.from) != graph_.submap(edge.to)) join(edge, update);
    if (edge.kind == ConstraintKind::loop)
      update.events.push_back({"loop_closed", fmt::format("keyframe {} with {}", edge.to, edge.from)});
    graph_.add_edge(edge);
  }
  return is_loop;
}

void LsdMapping::join(const Constraint& edge, SlamUpdate& update) {
  const int from = graph_.submap(edge.from), to = graph_.submap(edge.to);
  update.events.push_back(
      {"joined", fmt::format("submaps {} and {} by keyframes {} and {}", from, to, edge.from, edge.to)});
  graph_.merge(edge);
  if (from != 0 && to != 0) return;
  const Sim3& pose = graph_.pose(edge.to);
  Matrix6d by = Matrix6d::Zero();
  by.topLeftCorner<3, 3>() = pose.scale() * pose.rotation().matrix();
  by.bottomRightCorner<3, 3>() = pose.rotation().matrix();
  joint_ = {from == 0 ? edge.from : edge.to, by * edge.information.inverse() * by.transpose(),
            sensor_.is_metric() ? 0.0 : edge.scale_variance};
}

KeyframeDepths LsdMapping::restored_keyframe(std::int64_t id) const {
  const SemiDenseKeyframe& known = graph_.keyframe(id);
  return {options_,    sensor_, pools_, id, frames_.from_image(known.frame, known.stamp, known.image, known.mask),
          &known.depth};
}

MappedKeyframe LsdMapping::current() const {
  const std::int64_t id = depths_->id();
  return {depths_->current(), graph_.pose(id), graph_.submap(id), graph_.scale_error(id)};
}

/// The oldest keyframes keep their poses only.
void LsdMapping::stay_within_budget(SlamUpdate& update) {
  constexpr std::int64_t kept = 3;
  if (budget_bytes_ == 0) return;
  const std::int64_t before = forgotten_;
  const auto most = static_cast<std::size_t>(MapBudget::full_share * static_cast<double>(budget_bytes_));
  while (graph_.bytes() > most && graph_.forget_oldest(kept)) ++forgotten_;
  if (forgotten_ > before) update.events.push_back({"memory", memory().measures});
}

MapMemory LsdMapping::memory() const {
  return {graph_.bytes(), budget_bytes_,
          forgotten_ == 0 ? std::string() : fmt::format("depths of the {} oldest keyframes dropped", forgotten_)};
}

BagOfWords LsdMapping::words_of(GrayView image, GrayView mask) {
  BagOfWords words = standard_vocabulary()->words_of(features_.extract(image, mask, pools_.mapping).descriptors);
  words.nodes = {};
  return words;
}

}  // namespace rastro
