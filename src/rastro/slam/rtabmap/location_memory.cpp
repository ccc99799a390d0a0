// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/location_memory.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {

void LocationMemory::begin(std::int64_t keyframe, std::vector<std::int64_t> words, bool linked) {
  RASTRO_CHECK(locations_.empty() || keyframe > last_, "locations come in their order");
  const bool first = locations_.empty();
  const std::int64_t before = std::exchange(last_, keyframe);
  Location location;
  location.keyframes = {keyframe};
  location.words = std::move(words);
  locations_.emplace(keyframe, std::move(location));
  location_of_[keyframe] = keyframe;
  short_term_.push_back(keyframe);
  reweighted_.insert(keyframe);
  if (linked && !first) link(before, keyframe);
}

void LocationMemory::rehearse(std::int64_t keyframe) {
  Location& last = own(last_);
  last.keyframes.push_back(keyframe);
  last.weight += 1.0;
  location_of_[keyframe] = last_;
  reweighted_.insert(last_);
}

std::optional<std::int64_t> LocationMemory::leave_short_term(int most) {
  if (static_cast<int>(short_term_.size()) <= most) return std::nullopt;
  const std::int64_t oldest = short_term_.front();
  short_term_.pop_front();
  own(oldest).stage = MemoryStage::working;
  own(oldest).entered = entries_++;
  working_.insert(oldest);
  return oldest;
}

void LocationMemory::close_loop(std::int64_t newer, std::int64_t earlier) {
  link(newer, earlier);
  own(newer).weight += own(earlier).weight;
  own(earlier).weight = 0.0;
  reweighted_.insert({newer, earlier});
}

void LocationMemory::link(std::int64_t a, std::int64_t b) {
  const auto add = [](std::vector<std::int64_t>& neighbors, std::int64_t id) {
    if (std::find(neighbors.begin(), neighbors.end(), id) == neighbors.end()) neighbors.push_back(id);
  };
  if (a == b) return;
  add(own(a).neighbors, b);
  add(own(b).neighbors, a);
}

void LocationMemory::transfer(std::int64_t location) {
  own(location).stage = MemoryStage::long_term;
  working_.erase(location);
}

void LocationMemory::retrieve(std::int64_t location) {
  own(location).stage = MemoryStage::working;
  own(location).entered = entries_++;
  working_.insert(location);
}

std::optional<std::int64_t> LocationMemory::least(const std::set<std::int64_t>& immune) const {
  std::optional<std::int64_t> least;
  const auto order = [this](std::int64_t id) { return std::tuple(at(id).weight, at(id).entered); };
  for (const std::int64_t id : working_)
    if (!immune.contains(id) && (!least || order(id) < order(*least))) least = id;
  return least;
}

std::vector<std::int64_t> LocationMemory::forgotten_neighbors(std::int64_t location, int reach, int most) const {
  std::vector<std::int64_t> found, border{location};
  std::set<std::int64_t> seen{location};
  for (int step = 0; step < reach; ++step) {
    std::vector<std::int64_t> next;
    for (const std::int64_t id : border) {
      for (const std::int64_t neighbor : at(id).neighbors) {
        if (!seen.insert(neighbor).second) continue;
        next.push_back(neighbor);
        if (at(neighbor).stage != MemoryStage::long_term) continue;
        if (static_cast<int>(found.size()) >= most) return found;
        found.push_back(neighbor);
      }
    }
    border = std::move(next);
  }
  return found;
}

std::vector<std::int64_t> LocationMemory::take_reweighted() {
  std::vector<std::int64_t> ids(reweighted_.begin(), reweighted_.end());
  reweighted_.clear();
  return ids;
}

}  // namespace rastro
