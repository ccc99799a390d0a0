// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>

#include "rastro/track/track_sink.h"

namespace rastro {

/// What became of the features of a first frame in a second one.
struct MatchCounts {
  int in_first = 0;      ///< Features of the first frame.
  int followed = 0;      ///< Of these, followed by optical flow in every frame between, and there in the second.
  int reidentified = 0;  ///< Lost at least once in between, and there again in the second.
};

/// match_A_B.png: two frames side by side. Magenta lines join features tracked throughout, green lines those lost and
/// re-identified in between; the counts stand above (the image of Galardi, Castro, Pire).
class MatchImage : public TrackSink {
 public:
  /// Frames of the recording; first < second, else Error.
  MatchImage(std::filesystem::path path, std::int64_t first, std::int64_t second);
  void write(const TrackFrame& frame, GrayView image) override;
  /// Warns when one of the two frames was not in the run.
  void finish() override;
  /// nullopt as long as the second frame has not been seen.
  const std::optional<MatchCounts>& counts() const { return counts_; }

 private:
  struct Start {
    Eigen::Vector2f pixel;
    bool was_lost = false;
  };
  void begin(const TrackFrame& frame, GrayView image);
  void follow(const TrackFrame& frame);
  void draw(const TrackFrame& frame, GrayView image);

  std::filesystem::path path_;
  std::int64_t first_, second_;
  GrayImage first_image_;
  std::map<std::int64_t, Start> starts_;  ///< By id.
  bool begun_ = false;
  std::optional<MatchCounts> counts_;
};

}  // namespace rastro
