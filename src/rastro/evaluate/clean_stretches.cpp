// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/clean_stretches.h"

#include <map>

#include "rastro/base/error.h"

namespace rastro {

CleanStretches::CleanStretches(const TrackTable& occluded, const TrackTable& clean) {
  std::map<TimeNs, const TrackFrame*> by_stamp;
  for (const TrackFrame& frame : clean.frames) by_stamp.emplace(frame.stamp, &frame);
  in_frame_.resize(occluded.frames.size());
  std::map<std::int64_t, std::size_t> open;  // id -> its stretch that reached the frame before
  for (std::size_t k = 0; k < occluded.frames.size(); ++k) {
    std::map<std::int64_t, std::size_t> still_open;
    if (const auto found = by_stamp.find(occluded.frames[k].stamp); found != by_stamp.end()) {
      ++shared_frames_;
      for (const TrackedFeature& feature : found->second->features) {
        const auto before = open.find(feature.id);
        const bool goes_on = feature.state == TrackState::tracked && before != open.end();
        const std::size_t stretch = goes_on ? before->second : stretches_.size();
        if (!goes_on) stretches_.push_back({static_cast<std::int64_t>(k), {}});
        if (!still_open.emplace(feature.id, stretch).second) continue;
        stretches_[stretch].places.push_back(feature.pixel.cast<double>());
        in_frame_[k].push_back(stretch);
      }
    }
    open = std::move(still_open);
  }
  if (shared_frames_ == 0)
    throw Error("the two runs have no frame of the same time", "--clean",
                "give a run on the recording that the occluded copy was made from");
}

const Stretch* CleanStretches::nearest(std::int64_t frame, const Eigen::Vector2d& pixel, double radius_px) const {
  const Stretch* best = nullptr;
  double best_distance = radius_px;
  for (const std::size_t index : in_frame_[static_cast<std::size_t>(frame)]) {
    const Stretch& stretch = stretches_[index];
    const double distance = (*stretch.at(frame) - pixel).norm();
    if (best ? distance < best_distance : distance <= best_distance) {
      best = &stretch;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace rastro
