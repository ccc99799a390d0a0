// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/source.h"
#include "rastro/viewer/scene.h"

namespace rastro::cli {

/// Any frame of a recording: the next ones by going on, others by opening it there. Of one thread at a time.
class FramesOnRequest {
 public:
  /// Error where it cannot be opened.
  explicit FramesOnRequest(std::string path);
  const SourceInfo& info() const { return source_->info(); }
  /// By its number in the recording. Error for one that cannot be read.
  Frame frame(std::int64_t index);

 private:
  void reopen(std::int64_t first);

  std::string path_;
  std::unique_ptr<Source> source_;
  std::int64_t next_ = 0;
};

/// A frame's place on the timeline.
struct RecordedPose {
  TimeNs stamp = 0;
  std::optional<SE3> pose;  ///< world_from_camera, or of the body of a laser.
};

/// world_from_camera by the ground truth of the recording; nullopt where it has none at that time.
std::optional<SE3> true_pose(const SourceInfo& info, TimeNs stamp);

/// A scene with these frames on its timeline and nothing else; title and method are left to the caller.
ViewScene scene_of_recorded(const std::vector<RecordedPose>& poses, const SourceInfo& info);

}  // namespace rastro::cli
