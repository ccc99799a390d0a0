// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/track_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/cli/keyframe_images.h"
#include "rastro/cli/live_sink.h"
#include "rastro/cli/live_tracks.h"
#include "rastro/cli/recorded_frames.h"
#include "rastro/cli/scene_input.h"
#include "rastro/cli/track_run_input.h"
#include "rastro/export/read_tracks.h"
#include "rastro/viewer/frame_block.h"
#include "rastro/viewer/scene_writer.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

/// A run, as its frames are asked for.
class TrackedFrames {
 public:
  explicit TrackedFrames(const std::string& folder) : table_(read_tracks(folder)), input_(read_run_input(folder)) {
    if (table_.frames.empty()) throw Error("has no frames", folder, "there is nothing to show");
    const auto recording = recording_of_run(folder);
    try {
      if (!recording.path.empty()) images_.emplace(recording.path);
    } catch (const Error& error) {
      log_warning(std::string(error.what()) + "; tracks are shown without images");
    }
    if (recording.path.empty()) log_warning("the recording of " + folder + " is gone: tracks are shown without images");
  }

  const TrackTable& table() const { return table_; }
  SourceInfo info() const { return images_ ? images_->info() : SourceInfo{}; }

  std::string block(std::int64_t row) {
    if (row < 0 || row >= static_cast<std::int64_t>(table_.frames.size()))
      throw Error("has no such frame", "the run", "");
    const LiveFeatures features = features_of(static_cast<std::size_t>(row));
    Frame frame = image_of(table_.frames[static_cast<std::size_t>(row)]);
    frame.index = row;
    return frame_block(frame, info(), &features);
  }

 private:
  /// With what they did in the frames before, as far back as the page shows it.
  LiveFeatures features_of(std::size_t row) const {
    constexpr std::size_t frames_back = 64;
    FeatureTrails trails;
    LiveFeatures features;
    for (std::size_t k = row - std::min(row, frames_back); k <= row; ++k)
      trails.add(features = live_features(table_.frames[k]));
    trails.write_to(features);
    return features;
  }

  /// Gray of the size of the image where it cannot be read.
  Frame image_of(const TrackFrame& tracked) {
    try {
      if (images_) return images_->frame(tracked.index);
    } catch (const Error&) {  // 'rastro check' tells
    }
    Frame blank;
    blank.name = "the image cannot be read";
    blank.image = GrayImage(width_without_image(), height_without_image());
    return blank;
  }

  /// Where the run does not say, as far as its features reach.
  int width_without_image() const { return input_.image_width > 0 ? input_.image_width : reach(0); }
  int height_without_image() const { return input_.image_height > 0 ? input_.image_height : reach(1); }
  int reach(int axis) const {
    constexpr float most_px = 16'384.0F;
    float farthest = 63.0F;
    for (const TrackFrame& frame : table_.frames)
      for (const TrackedFeature& feature : frame.features) farthest = std::max(farthest, feature.pixel[axis]);
    return 1 + static_cast<int>(std::min(farthest, most_px));
  }

  TrackTable table_;
  TrackRunInput input_;
  std::optional<FramesOnRequest> images_;
};

/// A change of health is an event.
void add_health(const TrackTable& table, ViewScene& scene) {
  TrackHealth before = TrackHealth::good;
  for (const TrackFrame& frame : table.frames) {
    const bool good = frame.health == TrackHealth::good;
    const auto row = static_cast<std::int64_t>(scene.frames.states.size());
    scene.frames.states.push_back(static_cast<std::uint8_t>(scene_state_of(good ? "tracking" : "weak")));
    if (frame.health != before && !good)
      scene.events.push_back({row, to_seconds(frame.stamp), name_of(frame.health), ""});
    before = frame.health;
  }
}

}  // namespace

bool is_track_run(const std::string& path) {
  std::error_code ignored;
  const fs::path folder = path;
  const auto has = [&](const char* file) { return fs::is_regular_file(folder / file, ignored); };
  return has("about.json") && (has("tracks.csv") || has("tracks.yaml"));
}

NamedScene track_scene(const std::string& path) {
  const auto frames = std::make_shared<TrackedFrames>(path);
  SourceInfo info = frames->info();
  info.has_image = true;
  std::vector<RecordedPose> poses;
  for (const TrackFrame& frame : frames->table().frames) poses.push_back({frame.stamp, true_pose(info, frame.stamp)});
  ViewScene scene = scene_of_recorded(poses, info);
  scene.method = "track";
  scene.title = scene_name(path);
  add_health(frames->table(), scene);
  NamedScene named{scene.title, scene_bytes(scene)};
  named.frame_block = [frames](std::int64_t frame) { return frames->block(frame); };
  return named;
}

}  // namespace rastro::cli
