// SPDX-License-Identifier: Apache-2.0
#if RASTRO_WITH_ROSBAG

#include "rastro/dataset/rosbag/bag_stream.h"

#include <cstdlib>

#include "rastro/dataset/rosbag/bag_messages.h"

namespace rastro {
namespace {

constexpr TimeNs most_depth_offset = 20'000'000;     ///< Between the stamps, as in TUM's associate.py.
constexpr TimeNs longest_depth_delay = 500'000'000;  ///< Between the times of recording.
constexpr std::size_t most_kept_bytes = std::size_t{1} << 28;

/// The depth message nearest to a stamp among those it is shown in the order of recording.
struct NearestDepth {
  TimeNs stamp = 0, recorded = 0;
  const BagMessage* message = nullptr;
  TimeNs offset = most_depth_offset;
  bool passed = false;  ///< Depth of this stamp or a later one was there: what follows is farther away.

  void consider(const BagMessage& depth) {
    if (std::abs(depth.time - recorded) > longest_depth_delay) return;
    const TimeNs difference = stamp_of(depth) - stamp;
    passed = passed || difference >= 0;
    if (std::abs(difference) > offset) return;
    offset = std::abs(difference);
    message = &depth;
  }
};

}  // namespace

BagStream::BagStream(const std::string& path, std::set<std::string> topics, std::string depth_topic)
    : records_(path), topics_(std::move(topics)), depth_topic_(std::move(depth_topic)) {
  topics_.insert(depth_topic_);
  topics_.erase("");  // Of kinds that the bag does not have.
}

std::optional<BagMessage> BagStream::next() {
  while (true) {
    std::optional<BagMessage> message;
    if (ahead_.empty()) {
      message = read();
    } else {
      message = std::move(ahead_.front());
      ahead_.pop_front();
      ahead_bytes_ -= message->bytes.size();
    }
    if (!message || message->topic != depth_topic_) return message;
    keep(std::move(*message));
  }
}

const BagMessage* BagStream::depth_near(TimeNs stamp, TimeNs recorded) {
  NearestDepth nearest{stamp, recorded};
  for (const auto& depth : past_) nearest.consider(depth);
  for (std::size_t k = 0; !nearest.passed; ++k) {
    if (k == ahead_.size() && !look_ahead()) break;
    if (ahead_[k].time > recorded + longest_depth_delay) break;
    if (ahead_[k].topic == depth_topic_) nearest.consider(ahead_[k]);
  }
  return nearest.message;
}

std::optional<BagMessage> BagStream::read() {
  while (auto message = records_.next())
    if (topics_.contains(message->topic)) return message;
  return std::nullopt;
}

bool BagStream::look_ahead() {
  if (ahead_bytes_ > most_kept_bytes) return false;
  auto message = read();
  if (!message) return false;
  ahead_bytes_ += message->bytes.size();
  ahead_.push_back(std::move(*message));
  return true;
}

void BagStream::keep(BagMessage depth) {
  past_bytes_ += depth.bytes.size();
  past_.push_back(std::move(depth));
  const auto is_old = [&] {
    return past_bytes_ > most_kept_bytes || past_.back().time - past_.front().time > longest_depth_delay;
  };
  while (past_.size() > 1 && is_old()) {
    past_bytes_ -= past_.front().bytes.size();
    past_.pop_front();
  }
}

}  // namespace rastro

#endif
