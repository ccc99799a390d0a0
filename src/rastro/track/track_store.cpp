// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/track_store.h"

#include <algorithm>

namespace rastro {

void Track::start(std::int64_t new_id) {
  id = new_id;
  last_seen = seen_before = -1;
  age = 0;
  descriptor_spread = 0;
  layer = -1;
  patch_frame_ = older_patch_frame_ = -1;
  patch_.clear();
  older_patch_.clear();
  std::fill(frames_.begin(), frames_.end(), -1);
}

void Track::observe(std::int64_t frame, const Eigen::Vector2f& pixel, const Eigen::Vector2f& ideal,
                    const Descriptor& descriptor) {
  const std::size_t at = slot(frame);
  frames_[at] = frame;
  pixels_[at] = pixel;
  ideals_[at] = ideal;
  descriptors_[at] = descriptor;
  seen_before = last_seen;
  last_seen = frame;
  ++age;
}

void Track::keep_patch(std::int64_t frame, int interval, const Pyramid& pyramid, const Eigen::Vector2f& pixel,
                       int window_px) {
  if (patch_frame_ >= 0 && frame - patch_frame_ < interval) return;
  std::swap(older_patch_, patch_);
  older_patch_frame_ = patch_frame_;
  patch_.keep(pyramid, pixel, window_px);
  patch_frame_ = frame;
}

void Track::measure_spread() {
  descriptor_spread = 0;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    if (frames_[i] < 0) continue;
    descriptor_spread = std::max(descriptor_spread, hamming_distance(descriptors_[i], last_descriptor()));
  }
}

std::size_t TrackStore::create() {
  std::size_t index = tracks_.size();
  if (unused_.empty()) {
    tracks_.emplace_back(window_);
  } else {
    index = unused_.back();
    unused_.pop_back();
  }
  tracks_[index].start(next_id_++);
  return index;
}

void TrackStore::mark_lost(std::size_t index) {
  tracks_[index].measure_spread();
  const auto by_id = [&](std::size_t a, std::size_t b) { return tracks_[a].id < tracks_[b].id; };
  lost_.insert(std::lower_bound(lost_.begin(), lost_.end(), index, by_id), index);
}

void TrackStore::mark_found(std::size_t index) { lost_.erase(std::find(lost_.begin(), lost_.end(), index)); }

void TrackStore::forget_old(std::int64_t current) {
  const auto is_old = [&](std::size_t index) { return tracks_[index].last_seen < current - window_; };
  for (const std::size_t index : lost_) {
    if (is_old(index)) unused_.push_back(index);
  }
  std::erase_if(lost_, is_old);
}

}  // namespace rastro
