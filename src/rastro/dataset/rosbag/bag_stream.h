// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <set>
#include <string>

#include "rastro/dataset/rosbag/bag_records.h"

namespace rastro {

/// The messages of some topics of a bag in order, and beside them the depth image of each frame. A driver may record
/// depth long before or after the image of the same moment, so depth is found by its stamp among all that was recorded
/// within half a second. Holds what was recorded in that time, and no more than a bounded number of bytes.
class BagStream {
 public:
  /// Depth of `depth_topic` (empty: none) is not among the messages that next() gives.
  BagStream(const std::string& path, std::set<std::string> topics, std::string depth_topic);

  /// nullopt at the end of the bag.
  std::optional<BagMessage> next();

  /// The depth message whose stamp is nearest to `stamp` (of two as near, the later one), at most 20 ms from it and
  /// recorded at most half a second from `recorded`, the time of the message that next() gave last. nullptr where there
  /// is none. Valid until the next call.
  const BagMessage* depth_near(TimeNs stamp, TimeNs recorded);

  /// Whether any depth was recorded before the message that next() gave last.
  bool has_past_depth() const { return !past_.empty(); }

 private:
  std::optional<BagMessage> read();
  bool look_ahead();
  void keep(BagMessage depth);

  BagRecords records_;
  std::set<std::string> topics_;
  std::string depth_topic_;
  std::deque<BagMessage> past_;   ///< Depth only.
  std::deque<BagMessage> ahead_;  ///< Read, but not given yet.
  std::size_t past_bytes_ = 0, ahead_bytes_ = 0;
};

}  // namespace rastro
