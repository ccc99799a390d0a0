// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/grid_scans.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "rastro/slam/ekf/scan_features.h"

namespace rastro {
namespace {

constexpr double moved_m = 0.03, moved_rad = 2.0 * std::numbers::pi / 180.0;
constexpr double place_m = 0.5, place_rad = std::numbers::pi / 6.0;
/// The first visit of a place takes up to `most_in_place` scans, a later one only where there are fewer than `few`.
constexpr int few = 4, most_in_place = 16;

std::size_t memory_of(const KeyframeScan& scan) {
  return sizeof(KeyframeScan) + scan.points.size() * sizeof(Eigen::Vector2d);
}

}  // namespace

void GridScans::begin_keyframe() {
  if (begun_) finished_.push_back(newest_.empty() ? nullptr : std::make_shared<KeyframeScans>(std::move(newest_)));
  newest_.clear();
  begun_ = true;
}

void GridScans::add(const LaserScan& scan, const SE2& keyframe_from_body, const SE2& world_from_body,
                    std::size_t every) {
  if (!is_new(world_from_body) || seen_++ % every != 0) return;
  const SE2 keyframe_from_laser = keyframe_from_body * scan.body_from_laser;
  newest_.push_back({keyframe_from_laser.translation(), returns_in(scan, keyframe_from_laser)});
  scan_bytes_ += memory_of(newest_.back());
}

bool GridScans::is_new(const SE2& world_from_body) {
  if (last_) {
    const SE2 motion = last_->inverse() * world_from_body;
    if (motion.translation().norm() < moved_m && std::abs(motion.rotation().angle()) < moved_rad) return false;
  }
  last_ = world_from_body;
  const Eigen::Vector2d position = world_from_body.translation() / place_m;
  const Place place = {std::llround(position.x()), std::llround(position.y()),
                       std::llround(world_from_body.rotation().angle() / place_rad)};
  int& count = new_in_place_[place];
  if (place != place_) open_ = count < few;
  place_ = place;
  if (!open_ || count >= most_in_place) return false;
  ++count;
  return true;
}

bool GridScans::thin() {
  std::size_t number = 0;
  bool thinned = false;
  for (auto& scans : finished_) {
    if (!scans) continue;
    KeyframeScans kept = *scans;
    if (!drop_odd(kept, number)) continue;
    thinned = true;
    scans = kept.empty() ? nullptr : std::make_shared<KeyframeScans>(std::move(kept));
  }
  return drop_odd(newest_, number) || thinned;
}

bool GridScans::drop_odd(KeyframeScans& scans, std::size_t& number) {
  return std::erase_if(scans, [&](const KeyframeScan& scan) {
           if (number++ % 2 == 0) return false;
           scan_bytes_ -= memory_of(scan);
           return true;
         }) > 0;
}

std::shared_ptr<const KeyframeScans> GridScans::of(std::size_t keyframe) const {
  if (keyframe < finished_.size()) return finished_[keyframe];
  return newest_.empty() ? nullptr : std::make_shared<KeyframeScans>(newest_);
}

std::size_t GridScans::bytes() const {
  constexpr std::size_t node = sizeof(std::pair<const Place, int>) + 4 * sizeof(void*);
  return scan_bytes_ + finished_.size() * (sizeof(finished_[0]) + sizeof(KeyframeScans)) + new_in_place_.size() * node;
}

}  // namespace rastro
