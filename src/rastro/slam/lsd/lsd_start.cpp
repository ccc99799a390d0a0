// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rastro {
namespace {

void set_tracking(SlamUpdate& update) {
  update.state = SlamState::tracking;
  update.reason = SlamReason::none;
  update.detail.clear();
}

}  // namespace

TwoViewStartOptions two_view_options(const LsdOptions& options) {
  TwoViewStartOptions start;
  start.min_parallax_deg = options.init_parallax_deg;
  start.seed = options.seed;
  return start;
}

LsdStart::LsdStart(const LsdOptions& options, const LsdSensor& sensor, const LsdFrameMaker& frames, TaskPool* pool)
    : options_(options), sensor_(sensor), frames_(frames), two_views_(two_view_options(options), sensor.camera, pool) {}

std::optional<SE3> LsdStart::take(const LsdFrame& frame, LsdMapping& mapping, PoseSearch& search, SlamUpdate& update) {
  if (sensor_.is_metric()) return from_sensor(frame, mapping, search, update);
  if (options_.start == "two_views") return from_two_views(frame, mapping, search, update);
  KeyframeDepths first(options_, sensor_, mapping.pools(), mapping.graph().size(), frame, nullptr);
  return from_one_frame(frame, std::move(first), mapping, search, update);
}

/// A pair or a depth camera knows the depths of the very first frame.
std::optional<SE3> LsdStart::from_sensor(const LsdFrame& frame, LsdMapping& mapping, PoseSearch& search,
                                         SlamUpdate& update) {
  KeyframeDepths first(options_, sensor_, mapping.pools(), mapping.graph().size(), frame, nullptr);
  update.reason = frame.right.empty() && frame.depth.empty() ? SlamReason::no_data : SlamReason::too_few_points;
  update.detail = fmt::format("{} pixels have a measured depth, need {}", first.pixels(), options_.start_pixels);
  if (first.pixels() < options_.start_pixels) return std::nullopt;
  return from_one_frame(frame, std::move(first), mapping, search, update);
}

SE3 LsdStart::from_one_frame(const LsdFrame& frame, KeyframeDepths first, LsdMapping& mapping, PoseSearch& search,
                             SlamUpdate& update) {
  mapping.begin_map(std::move(first), update);
  mapping.add_frame({frame.index, frame.stamp, mapping.depths().id(), SE3()});
  search.remember(frame.pyramid);
  set_tracking(update);
  return {};
}

std::optional<SE3> LsdStart::from_two_views(const LsdFrame& frame, LsdMapping& mapping, PoseSearch& search,
                                            SlamUpdate& update) {
  const auto found = two_views_.take(frame.index, frame.stamp, frame.image, frame.mask);
  update.reason = two_views_.frames().size() == 1 ? SlamReason::first_frame : SlamReason::too_few_points;
  update.detail = two_views_.detail();
  if (!found) return std::nullopt;
  const TwoViewStart::KeptFrame& first = two_views_.frames()[found->first];
  const LsdFrame first_frame = frames_.from_image(first.index, first.stamp, first.image, first.mask);
  mapping.begin_map({options_, sensor_, mapping.pools(), mapping.graph().size(), first_frame, &found->depth}, update);
  const FollowedFrames followed = follow_kept_frames(found->first, mapping, search);
  two_views_.reset();
  set_tracking(update);
  if (followed.newest) return followed.last;
  update.state = SlamState::lost;
  update.reason = SlamReason::poor_match;
  update.detail = "the map begins with earlier frames; this one does not fit";
  return followed.last;
}

/// Those since the first view, and those right before it as long as they fit without doubt and need no keyframe of
/// their own, in the order of the recording.
LsdStart::FollowedFrames LsdStart::follow_kept_frames(std::size_t first, LsdMapping& mapping, PoseSearch& search) {
  const auto& kept = two_views_.frames();
  search.remember(mapping.depths().current().pyramid());
  PoseSearch backward = search;
  std::vector<PlacedFrame> placed{{kept[first].index, kept[first].stamp, mapping.depths().id(), SE3()}};
  FollowedFrames followed;
  for (std::size_t k = first + 1; k < kept.size(); ++k) {
    const auto pose = follow_kept(k, followed.last, mapping, search, false, placed);
    followed.newest = pose.has_value();
    if (pose) followed.last = *pose;
  }
  SE3 before;
  for (std::size_t k = first; k-- > 0;) {
    const auto pose = follow_kept(k, before, mapping, backward, true, placed);
    if (!pose) break;
    before = *pose;
  }
  std::sort(placed.begin(), placed.end(), [](const PlacedFrame& a, const PlacedFrame& b) { return a.index < b.index; });
  for (const PlacedFrame& frame : placed) mapping.add_frame(frame);
  return followed;
}

std::optional<SE3> LsdStart::follow_kept(std::size_t k, const SE3& guess, LsdMapping& mapping, PoseSearch& search,
                                         bool is_before, std::vector<PlacedFrame>& placed) const {
  const TwoViewStart::KeptFrame& kept = two_views_.frames()[k];
  const LsdFrame frame = frames_.from_image(kept.index, kept.stamp, kept.image, kept.mask);
  const CurrentKeyframe keyframe = mapping.depths().current();
  const auto [tracked, verdict, jump_deg] = search.track(keyframe, frame.pyramid, {guess, SE3(), 0});
  if (verdict.grade != PoseGrade::tracking || (is_before && keyframe.is_left_by(tracked))) return std::nullopt;
  search.remember(frame.pyramid);
  placed.push_back({frame.index, frame.stamp, mapping.depths().id(), tracked.image_from_reference.inverse()});
  if (!is_before) mapping.depths().refine(frame, tracked);
  return tracked.image_from_reference;
}

}  // namespace rastro
