// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <string>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/cli/export_formats.h"
#include "rastro/cli/keyframe_images.h"
#include "rastro/cli/mcap_input.h"
#include "rastro/cli/run_notes.h"
#include "rastro/dataset/image_file.h"
#include "rastro/dataset/open.h"
#include "rastro/map/images/pack_images.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

/// A folder beside the output for images of the recording, gone with this object.
class ImageFolder {
 public:
  explicit ImageFolder(const std::string& out) : path_(out + ".images") {
    std::error_code ignored;
    if (fs::exists(path_, ignored))
      throw Error("is there already", path_.string(), "an interrupted export left it; remove it");
  }
  ~ImageFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ImageFolder(const ImageFolder&) = delete;
  ImageFolder& operator=(const ImageFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string jpeg_of(const fs::path& file) {
  const std::string extension = file.extension().string();
  if (extension == ".jpg" || extension == ".jpeg" || extension == ".JPG") return read_whole_file(file);
  constexpr bool want_color = true;
  DecodedImage decoded = read_image(file.string(), want_color);
  Frame frame;
  frame.image = std::move(decoded.gray);
  frame.color = std::move(decoded.color);
  const PackedImages packed = pack_images(frame);
  return {packed.color.begin(), packed.color.end()};
}

/// lsd maps what an undistorted camera sees, but the images are as recorded; those of a pair were rectified.
void use_recorded_camera(const Map& map, const RecordingOfRun& recording, McapRun& run) {
  if (!run.camera || run.camera->distortion != Distortion::none || map.cameras.front().kind == CameraKind::stereo)
    return;
  OpenOptions options;
  options.camera = recording.camera;
  const auto source = open(recording.path, options);
  const auto& cameras = source->info().cameras;
  if (!cameras.empty() && cameras.front().camera) run.camera = *cameras.front().camera;
}

void add_recorded(const Map& map, int submap, const std::vector<MapRecording>& recordings, const fs::path& folder,
                  McapRun& run) {
  for (const auto& [id, name] : write_keyframe_images(map, submap, recordings, folder))
    run.images.push_back({map.find(id)->stamp, [file = folder / name] { return jpeg_of(file); }});
  for (const MapRecording& part : recordings)
    if (!part.recording.path.empty()) return use_recorded_camera(map, part.recording, run);
}

/// Of a map of cameras without images: those of its recording, where that is there or was named.
void add_images(const ExportJob& job, const fs::path& folder, McapRun& run) {
  const bool named = !job.settings.images.empty();
  if (named && !run.of_camera) throw Error("does not apply to a map without a camera", "--images", "omit it");
  if (!job.input.map || !run.of_camera || run.keyframes.empty() || !run.images.empty()) return;
  const auto recordings = recordings_of_map(*job.input.map, job.input.path, job.settings.images);
  if (!any_found(recordings)) return;
  try {
    add_recorded(*job.input.map, job.settings.cloud.submap, recordings, folder, run);
  } catch (const Error& error) {
    if (named) throw;
    log_warning(std::string("no images are written: ") + error.what());
    run.images.clear();
  }
}

}  // namespace

ExportFacts export_mcap(const ExportJob& job) {
  constexpr std::size_t default_points = 1'000'000;
  const int submap = job.settings.cloud.submap;
  const ViewSceneOptions options = scene_options(job.settings.scene, submap, default_points);
  const RunRecord record = notes_of_run(job.input);
  McapRun run =
      mcap_run_of(job.input, record, view_scene_of(job.input, record, options, job.pool, job.progress), submap);
  const ImageFolder folder(job.settings.out);
  add_images(job, folder.path(), run);
  std::size_t bytes = 0;
  ExportFacts messages;
  write_export(job.settings.out, [&](const PutPiece& put) {
    for (const McapTopic& topic : put_mcap(run, [&](std::string_view piece) {
           put(piece);
           bytes += piece.size();
         }))
      messages[topic.topic] = topic.messages;
  });
  return {{"bytes", bytes}, {"messages", messages}};
}

}  // namespace rastro::cli
