// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <memory>

#include "rastro/backend/acceptance.h"
#include "rastro/backend/loop_candidates.h"
#include "rastro/backend/rgbd/edge_covariance.h"
#include "rastro/backend/rgbd/frame_report.h"
#include "rastro/backend/rgbd/loop_confirmation.h"
#include "rastro/backend/rgbd/rgbd_session.h"

namespace rastro {

/// Those that a frame can be matched with; features in long-term memory can be read again.
std::vector<std::int64_t> RgbdSession::keyframes_near(const SE3& pose) const {
  return map_.nearest(pose, map_.submap(anchor_.keyframe), options_, mapper_.signatures() != nullptr);
}

std::vector<std::shared_ptr<const ImageFeatures>> RgbdSession::with_features(
    const std::vector<std::int64_t>& ids) const {
  std::vector<std::shared_ptr<const ImageFeatures>> keyframes;
  for (const std::int64_t id : ids) {
    const auto& keyframe = map_.keyframes()[static_cast<std::size_t>(id)];
    const bool forgotten = keyframe->features.size() == 0 && mapper_.signatures();
    keyframes.push_back(forgotten ? with_id(*mapper_.signatures()->read(id).image, id) : keyframe);
  }
  return keyframes;
}

/// Keyframes from where a new one would hardly see anything else; none where they are few.
std::vector<std::int64_t> RgbdSession::known_here(const SE3& pose) const {
  std::vector<std::int64_t> known;
  for (const std::int64_t id : keyframes_near(pose)) {
    const SE3 moved = map_.pose(id).inverse() * pose;
    if (share_of_reach(moved, options_.keyframe_distance_m, options_.keyframe_angle_rad) < 1.0) known.push_back(id);
  }
  if (static_cast<int>(known.size()) < options_.dense_keyframes) known.clear();
  return known;
}

/// Where the map has keyframes enough, the frame is matched with one of them instead of becoming one more, so that the
/// map grows with the places and not with the time. Tracking and match together give the pose, each by its covariance.
bool RgbdSession::revisit(const Frame& frame, const SE3& pose, const Matrix6d& from_keyframe, SlamUpdate& update) {
  const std::vector<std::int64_t> known = known_here(pose);
  if (known.empty() || frame.depth.empty()) return false;
  const auto seed = seed_for(options_.follow.seed ^ 0x5EEDULL, static_cast<std::uint64_t>(counts_.seen));
  const auto found = relocalizer_.find_among(as_keyframe(frame), with_features(known), seed);
  if (!found || !found->looks_alike) return false;
  const Matrix6d of_match = found->constraint.information.inverse(), of_path = covariance_of(pose, from_keyframe);
  const SE3 matched = map_.pose(found->keyframe) * found->constraint.a_from_b;
  const Matrix6d both = of_path + chained(map_.covariance(found->keyframe), found->constraint.a_from_b, of_match);
  // One that would correct the map is a loop closure, which mapping judges.
  if (!agrees_with_map(pose, matched)) return false;
  const Evidence evidence{.graph_sigmas = graph_sigmas(pose, matched, both)};
  if (judge(evidence, {.max_graph_sigmas = options_.loop_max_sigmas}) != Rejection::none) return false;
  const Matrix6d tracked = with_common_errors(from_keyframe, options_), gain = tracked * (tracked + of_match).inverse();
  const SE3 fused = pose * SE3::exp(gain * (pose.inverse() * matched).log());
  if (anchor_.keyframe != found->keyframe) {
    Constraint edge{anchor_.keyframe, found->keyframe};
    edge.from_from_to = Sim3(anchor_.world_from_keyframe.inverse() * pose * found->constraint.a_from_b.inverse());
    const SE3 back = found->constraint.a_from_b.inverse();
    edge.information = information_of(chained(tracked, back, of_inverse(of_match, found->constraint.a_from_b)));
    edge.kind = ConstraintKind::proximity;
    edge.inliers = found->constraint.inliers;
    connect(edge, frame.stamp);
  }
  anchor_at(found->keyframe, found->constraint);
  anchor_.world_from_reference = fused;
  anchor_.reference_covariance = (Matrix6d::Identity() - gain) * tracked;
  move(fused * pose.inverse());
  say_pose(fused, covariance_of(fused, anchor_.reference_covariance), update);
  return true;
}

/// Hands an edge between two keyframes of the map to mapping, once for each pair.
void RgbdSession::connect(const Constraint& edge, TimeNs stamp) {
  if (map_.are_connected(edge.from, edge.to)) return;
  const auto job = [this, edge, segment = segment_] { return MappedKeyframe{edge.to, segment, mapper_.connect(edge)}; };
  pipeline_.submit(job, {counts_.seen, stamp}, {.frames = options_.backend_delay_frames});
}

}  // namespace rastro
