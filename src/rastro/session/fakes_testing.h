// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/sensor/source.h"
#include "rastro/session/track_run.h"

namespace rastro {

/// A source of small gray frames; frames in `broken` throw instead.
class FakeSource : public Source {
 public:
  explicit FakeSource(std::int64_t frames, std::vector<std::int64_t> broken = {}, std::int64_t first = 0,
                      std::int64_t step = 1)
      : broken_(std::move(broken)), next_(first), step_(step), end_(first + frames * step) {}

  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (next_ >= end_) return std::nullopt;
    const std::int64_t index = next_;
    next_ += step_;
    if (unusable_from_ >= 0 && index >= unusable_from_) throw UnusableSource("size changed");
    if (std::find(broken_.begin(), broken_.end(), index) != broken_.end()) {
      throw Error("frame " + std::to_string(index) + " is broken");
    }
    Frame frame;
    frame.index = index;
    frame.stamp = 50'000'000 * index;
    frame.name = std::to_string(index);
    frame.image = GrayImage(32, 24);
    return frame;
  }

  void describe(const CalibratedCamera& camera) { info_.cameras = {camera}; }
  void become_unusable_from(std::int64_t frame) { unusable_from_ = frame; }

 private:
  SourceInfo info_;
  std::vector<std::int64_t> broken_;
  std::int64_t next_, step_, end_;
  std::int64_t unusable_from_ = -1;
};

/// A tracker with one feature that it loses in every third frame and re-identifies in the next.
class FakeTracker {
 public:
  TrackFrame process(GrayView, TimeNs stamp, GrayView mask) {
    TrackFrame frame;
    frame.index = next_++;
    frame.stamp = stamp;
    frame.masked = mask.empty() ? 0 : 1;
    if (frame.index % 3 == 2) {
      frame.lost = 1;
      frame.health = TrackHealth::few_corners;
      return frame;
    }
    TrackedFeature feature;
    feature.age = ++age_;
    feature.last_seen = last_seen_;
    feature.state = frame.index == 0       ? TrackState::fresh
                    : frame.index % 3 == 0 ? TrackState::reidentified
                                           : TrackState::tracked;
    frame.fresh = feature.state == TrackState::fresh ? 1 : 0;
    frame.tracked = feature.state == TrackState::tracked ? 1 : 0;
    frame.reidentified = feature.state == TrackState::reidentified ? 1 : 0;
    last_seen_ = frame.index;
    frame.features.push_back(feature);
    return frame;
  }

 private:
  std::int64_t next_ = 0, last_seen_ = -1;
  std::int32_t age_ = 0;
};

/// Records its input.
class FakeSink : public TrackSink {
 public:
  void write(const TrackFrame& frame, GrayView image) override {
    if (fail_at == frame.index) throw Error("the disk is full");
    frames.push_back(frame);
    image_was_there = image_was_there && image.width == 32;
  }
  void finish() override { ++finished; }

  std::vector<TrackFrame> frames;
  int finished = 0;
  bool image_was_there = true;
  std::int64_t fail_at = -1;
};

}  // namespace rastro
