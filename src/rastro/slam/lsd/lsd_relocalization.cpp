// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_relocalization.h"

#include <fmt/format.h>

#include <utility>

namespace rastro {
namespace {

constexpr int short_loss = 5;  // frames, after which a camera may be anywhere

}  // namespace

void LsdRelocalization::add(const LsdFrame& frame, const JudgedAlignment& tracked) {
  Hypothesis& hypothesis = *hypothesis_;
  const SE3& pose = tracked.alignment.image_from_reference;
  hypothesis.before = hypothesis.frames.empty() ? pose : hypothesis.camera_from_keyframe;
  hypothesis.camera_from_keyframe = pose;
  hypothesis.frames.push_back({frame.index, frame.stamp, hypothesis.id, pose.inverse()});
  hypothesis.search.remember(frame.pyramid);
  last_ = tracked;
}

/// Whether the frame agrees with the hypothesis.
bool LsdRelocalization::follows(const LsdFrame& frame, const CurrentKeyframe& current) {
  const CurrentKeyframe& keyframe = hypothesis_->keyframe ? *hypothesis_->keyframe : current;
  const SE3& pose = hypothesis_->camera_from_keyframe;
  const JudgedAlignment tracked =
      hypothesis_->search.track(keyframe, frame.pyramid, {pose, pose * hypothesis_->before.inverse(), 0});
  if (tracked.verdict.grade != PoseGrade::tracking) return false;
  add(frame, tracked);
  return true;
}

bool LsdRelocalization::begin_near(const LsdFrame& frame, const CurrentKeyframe& current, const ExpectedMotion& last,
                                   const PoseSearch& search) {
  const JudgedAlignment tracked = search.track(current, frame.pyramid, {last.camera_from_keyframe, SE3(), last.missed});
  if (tracked.verdict.grade != PoseGrade::tracking) return false;
  // The camera went on meanwhile.
  const double reach_deg = options_.max_jump_deg * (last.missed + 1);
  const bool is_near = last.missed <= short_loss && tracked.jump_deg <= reach_deg;
  hypothesis_.emplace(Hypothesis{std::nullopt, current.id(), {}, {}, {}, search, is_near});
  add(frame, tracked);
  return true;
}

/// Whether the camera can be there by now, from where it was last seen. Between submaps nothing is known.
bool LsdRelocalization::is_within_reach(const PlacedFrame& found, int missed) const {
  if (graph_.frames().empty()) return true;
  const PlacedFrame& last = graph_.frames().back();
  if (graph_.submap(last.keyframe) != graph_.submap(found.keyframe)) return true;
  const double distance = (graph_.pose_of(found).translation() - graph_.pose_of(last).translation()).norm();
  const double inverse = graph_.keyframe(found.keyframe).mean_inverse_depth;
  const double mean_distance = graph_.pose(found.keyframe).scale() / (inverse > 0.0 ? inverse : 1.0);
  return distance <= mean_distance + graph_.reach_from(found.keyframe, options_.max_drift, missed);
}

bool LsdRelocalization::begin_similar(const LsdFrame& frame, const BagOfWords& words, const PoseSearch& search,
                                      int missed) {
  for (const std::int64_t id : graph_.similar(words, options_.similar_keyframes)) {
    CurrentKeyframe candidate = make_(id);
    const JudgedAlignment found = search.find(candidate, frame.pyramid);
    if (found.verdict.grade != PoseGrade::tracking) continue;
    const SE3 keyframe_from_camera = found.alignment.image_from_reference.inverse();
    if (!is_within_reach({frame.index, frame.stamp, id, keyframe_from_camera}, missed)) continue;
    hypothesis_.emplace(Hypothesis{std::move(candidate), id, {}, {}, {}, search, false});
    add(frame, found);
    return true;
  }
  return false;
}

std::optional<LsdRelocalization::Confirmed> LsdRelocalization::take(
    const LsdFrame& frame, const CurrentKeyframe& current, const ExpectedMotion& last, const PoseSearch& search,
    bool was_tried, const std::function<BagOfWords()>& words, SlamUpdate& update) {
  update.state = SlamState::lost;
  if (hypothesis_ && !follows(frame, current)) hypothesis_.reset();
  const bool is_new = !hypothesis_;
  if (is_new && (was_tried || !begin_near(frame, current, last, search)) &&
      !begin_similar(frame, words(), search, last.missed + 1)) {
    if (update.reason == SlamReason::none) update.reason = SlamReason::not_found;
    return std::nullopt;
  }
  const auto agreeing = static_cast<int>(hypothesis_->frames.size());
  if (agreeing < options_.relocalize_frames && !hypothesis_->is_near) {
    update.reason = SlamReason::unconfirmed;
    update.detail =
        fmt::format("in keyframe {}: {} of {} frames agree", hypothesis_->id, agreeing, options_.relocalize_frames);
    return std::nullopt;
  }
  hypothesis_->frames.pop_back();
  Confirmed confirmed{std::move(hypothesis_->keyframe), hypothesis_->id, std::move(hypothesis_->frames),
                      hypothesis_->before, last_};
  hypothesis_.reset();
  return confirmed;
}

}  // namespace rastro
