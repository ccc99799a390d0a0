// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/candidates.h"

#include <algorithm>
#include <numbers>

#include "rastro/slam/ekf/association.h"

namespace rastro {

void Candidates::move(const Motion& motion) {
  const SE2 body_from_last = motion.last_from_body.inverse();
  const Eigen::Matrix2d rotation = body_from_last.rotation().matrix();
  for (auto& [seen, observations, last_frame] : candidates_) {
    seen.in_body = body_from_last * seen.in_body;
    seen.direction += body_from_last.rotation().angle();
    Eigen::Matrix<double, 2, 3> by_motion;
    by_motion.leftCols<2>() = -rotation;
    by_motion.col(2) = Eigen::Vector2d(seen.in_body.y(), -seen.in_body.x());
    seen.covariance =
        rotation * seen.covariance * rotation.transpose() + by_motion * motion.covariance * by_motion.transpose();
  }
}

bool Candidates::may_be(const Candidate& candidate, const Sighting& sighting) const {
  if (candidate.seen.kind != sighting.kind || candidate.seen.sensor_id != sighting.sensor_id) return false;
  return sighting.kind != LandmarkKind::corner || angle_between(candidate.seen.direction, sighting.direction) <=
                                                      options_.max_direction_deg * std::numbers::pi / 180.0;
}

bool Candidates::confirms(const Sighting& sighting, std::int64_t frame) {
  auto nearest = candidates_.end();
  double least = options_.gate;
  for (auto candidate = candidates_.begin(); candidate != candidates_.end(); ++candidate) {
    if (!may_be(*candidate, sighting)) continue;
    const double distance = squared_mahalanobis(sighting.in_body - candidate->seen.in_body,
                                                sighting.covariance + candidate->seen.covariance);
    if (distance > least) continue;
    least = distance;
    nearest = candidate;
  }
  if (nearest == candidates_.end()) {
    candidates_.push_back({sighting, 0, frame - 1});
    nearest = candidates_.end() - 1;
  }
  // Two sightings of one frame are one observation.
  if (nearest->last_frame < frame) ++nearest->observations;
  nearest->seen = sighting;
  nearest->last_frame = frame;
  if (nearest->observations < options_.observations) return false;
  candidates_.erase(nearest);
  return true;
}

void Candidates::forget(std::int64_t frame) {
  std::erase_if(candidates_,
                [&](const Candidate& candidate) { return frame - candidate.last_frame > options_.candidate_frames; });
}

}  // namespace rastro
