// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/map/scans/scan_layer.h"
#include "rastro/sensor/laser_scan.h"

namespace rastro {

/// The scans that the occupancy grid is made of, by keyframes. From one place a limited number of them is kept, however
/// long the body stays and however often it comes back: memory grows with the map, not with time.
class GridScans {
 public:
  void begin_keyframe();
  /// To the newest keyframe. One scan in `every` is kept of those that show something new.
  void add(const LaserScan& scan, const SE2& keyframe_from_body, const SE2& world_from_body, std::size_t every);
  /// Drops every second scan, since consecutive ones are nearly the same; false where there is none to drop.
  bool thin();

  /// Of the keyframe with this number; null where it has none.
  std::shared_ptr<const KeyframeScans> of(std::size_t keyframe) const;
  std::size_t bytes() const;

 private:
  using Place = std::array<std::int64_t, 3>;  ///< Cell of position and direction of the body.

  bool is_new(const SE2& world_from_body);
  bool drop_odd(KeyframeScans& scans, std::size_t& number);

  std::vector<std::shared_ptr<const KeyframeScans>> finished_;  ///< Of all keyframes but the newest.
  KeyframeScans newest_;
  bool begun_ = false;

  std::optional<SE2> last_;            ///< world_from_body of the last scan that was new, but for `place_`.
  std::map<Place, int> new_in_place_;  ///< Scans.
  std::optional<Place> place_;
  bool open_ = false;     ///< The place takes scans during this visit.
  std::size_t seen_ = 0;  ///< New scans, of which one in `every` is kept.
  std::size_t scan_bytes_ = 0;
};

}  // namespace rastro
