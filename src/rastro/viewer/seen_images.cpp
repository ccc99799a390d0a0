// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/seen_images.h"

#include <cstdlib>
#include <iterator>
#include <utility>

namespace rastro {

void SeenImages::add(TimeNs stamp, LiveImage image) {
  image.features = {};
  const std::lock_guard lock(mutex_);
  const auto [added, is_new] = images_.try_emplace(stamp, std::move(image));
  if (is_new) bytes_ += added->second.jpeg.size();
  if (bytes_ <= most_bytes) return;
  for (auto each = images_.begin(); each != images_.end();) {
    bytes_ -= each->second.jpeg.size();
    each = images_.erase(each);
    if (each != images_.end()) ++each;
  }
}

std::optional<LiveImage> SeenImages::near(TimeNs stamp) const {
  constexpr TimeNs farthest = 150'000'000;
  const std::lock_guard lock(mutex_);
  const auto after = images_.lower_bound(stamp);
  const std::pair<const TimeNs, LiveImage>* nearest = after == images_.end() ? nullptr : &*after;
  if (after != images_.begin()) {
    const auto& before = *std::prev(after);
    if (nearest == nullptr || stamp - before.first < nearest->first - stamp) nearest = &before;
  }
  if (nearest == nullptr || std::llabs(nearest->first - stamp) > farthest) return std::nullopt;
  return nearest->second;
}

}  // namespace rastro
