// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/clean_segments.h"

#include <map>

#include "rastro/base/error.h"

namespace rastro {

CleanSegments::CleanSegments(const TrackTable& occluded, const TrackTable& clean) {
  std::map<TimeNs, const TrackFrame*> by_stamp;
  for (const TrackFrame& frame : clean.frames) by_stamp.emplace(frame.stamp, &frame);
  in_frame_.resize(occluded.frames.size());
  std::map<std::int64_t, std::size_t> open;  // id -> its segment that reached the previous frame
  for (std::size_t k = 0; k < occluded.frames.size(); ++k) {
    std::map<std::int64_t, std::size_t> still_open;
    if (const auto found = by_stamp.find(occluded.frames[k].stamp); found != by_stamp.end()) {
      ++shared_frames_;
      for (const TrackedFeature& feature : found->second->features) {
        const auto before = open.find(feature.id);
        const bool goes_on = feature.state == TrackState::tracked && before != open.end();
        const std::size_t segment = goes_on ? before->second : segments_.size();
        if (!goes_on) segments_.push_back({static_cast<std::int64_t>(k), {}});
        if (!still_open.emplace(feature.id, segment).second) continue;
        segments_[segment].positions.push_back(feature.pixel.cast<double>());
        in_frame_[k].push_back(segment);
      }
    }
    open = std::move(still_open);
  }
  if (shared_frames_ == 0)
    throw Error("the two runs have no frames with equal stamps", "--clean",
                "give a run on the recording that the occluded copy was made from");
}

const CleanSegment* CleanSegments::nearest(std::int64_t frame, const Eigen::Vector2d& pixel, double radius_px) const {
  const CleanSegment* best = nullptr;
  double best_distance = radius_px;
  for (const std::size_t index : in_frame_[static_cast<std::size_t>(frame)]) {
    const CleanSegment& segment = segments_[index];
    const double distance = (*segment.at(frame) - pixel).norm();
    if (best ? distance < best_distance : distance <= best_distance) {
      best = &segment;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace rastro
