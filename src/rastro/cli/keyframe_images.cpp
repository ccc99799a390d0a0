// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/keyframe_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text_file.h"
#include "rastro/camera/stereo_rectification.h"
#include "rastro/cli/readable_frames.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/recording.h"
#include "rastro/map/images/pack_images.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;
using Names = std::map<KeyframeId, std::string>;

/// Of a submap (-1: of all), those of one recording.
std::vector<const Keyframe*> keyframes_of(const Map& map, int submap, const std::set<KeyframeId>& of_recording) {
  std::vector<const Keyframe*> keyframes;
  for (const Keyframe& keyframe : map.keyframes)
    if ((submap < 0 || keyframe.submap == submap) && of_recording.contains(keyframe.id)) keyframes.push_back(&keyframe);
  return keyframes;
}

bool same_intrinsics(const Camera& a, const Camera& b) {
  constexpr double most_px = 1e-3;
  const auto near = [](double x, double y) { return std::abs(x - y) < most_px; };
  return near(a.fx, b.fx) && near(a.fy, b.fy) && near(a.cx, b.cx) && near(a.cy, b.cy) && a.distortion == b.distortion;
}

std::string bytes_of(const Frame& frame) {
  const PackedImages packed = pack_images(frame);
  return {reinterpret_cast<const char*>(packed.color.data()), packed.color.size()};
}

/// Frames by number, and by stamp where the map holds other recordings as well.
class FrameFinder {
 public:
  explicit FrameFinder(const Recording& recording) : recording_(recording) {
    for (std::size_t k = 0; k < recording.frames.size(); ++k) by_stamp_.emplace(recording.frames[k].stamp, k);
  }

  const RecordedFrame* find(const Keyframe& keyframe) const {
    const auto& frames = recording_.frames;
    const bool numbered = keyframe.frame >= 0 && keyframe.frame < static_cast<std::int64_t>(frames.size());
    const RecordedFrame* frame = numbered ? &frames[static_cast<std::size_t>(keyframe.frame)] : nullptr;
    // Stamps that are made up depend on the run's --rate.
    if (frame && (frame->stamp == keyframe.stamp || !recording_.info.has_stamps)) return frame;
    const auto found = by_stamp_.find(keyframe.stamp);
    return found == by_stamp_.end() ? nullptr : &frames[found->second];
  }

 private:
  const Recording& recording_;
  std::map<TimeNs, std::size_t> by_stamp_;
};

void copy_image(const fs::path& from, const fs::path& to) {
  std::error_code code;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, code);
  if (code) throw Error("cannot be copied to " + to.string() + " (" + code.message() + ")", from.string(), "");
}

/// Where the images of a recording go, and what their names begin with: those of several may be named alike.
struct Target {
  fs::path folder;
  std::string prefix;
};

Names write_files(const Recording& recording, const Map& map, const std::vector<const Keyframe*>& keyframes,
                  const Target& target) {
  const auto rectification = rectification_of(map, recording.info);
  const FrameFinder finder(recording);
  Names names;
  for (const Keyframe* keyframe : keyframes) {
    const RecordedFrame* recorded = finder.find(*keyframe);
    if (!recorded) continue;
    fs::path file = fs::path(recorded->image).filename();
    if (rectification) file.replace_extension(".jpg");
    std::string name = target.prefix + file.string();
    std::replace(name.begin(), name.end(), ' ', '_');  // ends the name in COLMAP's text
    if (rectification) {
      Frame frame;
      frame.image = remap(read_image(recorded->image).gray.view(), rectification->left);
      write_whole_file(target.folder / name, bytes_of(frame));
    } else {
      copy_image(recorded->image, target.folder / name);
    }
    names[keyframe->id] = std::move(name);
  }
  return names;
}

/// Of a video or a bag, whose images are no files.
Names write_decoded(Source& source, const Map& map, const std::vector<const Keyframe*>& keyframes,
                    const Target& target) {
  const auto rectification = rectification_of(map, source.info());
  std::map<std::int64_t, const Keyframe*> wanted;
  for (const Keyframe* keyframe : keyframes) wanted[keyframe->frame] = keyframe;
  Names names;
  while (names.size() < wanted.size()) {
    auto frame = next_readable(source);
    if (!frame) break;
    const auto found = wanted.find(frame->index);
    if (found == wanted.end() || (source.info().has_stamps && frame->stamp != found->second->stamp)) continue;
    if (rectification) frame->image = remap(frame->image.view(), rectification->left), frame->color = {};
    frame->depth = {};
    std::string& name = names[found->second->id];
    name = fmt::format("{}{:06}.jpg", target.prefix, frame->index);
    write_whole_file(target.folder / name, bytes_of(*frame));
  }
  return names;
}

Names images_of_recording(const Map& map, const MapRecording& part, const std::vector<const Keyframe*>& keyframes,
                          const Target& target) {
  if (part.recording.path.empty() || keyframes.empty()) return {};
  OpenOptions options;
  options.camera = part.recording.camera;
  options.want_color = options.want_right = true;
  if (const auto indexed = index_recording(part.recording.path, options))
    return write_files(*indexed, map, keyframes, target);
  return write_decoded(*open(part.recording.path, options), map, keyframes, target);
}

}  // namespace

std::optional<StereoRectification> rectification_of(const Map& map, const SourceInfo& info) {
  const MapCamera& camera = camera_of(map, info.path);
  if (camera.kind != CameraKind::stereo || info.cameras.size() < 2) return std::nullopt;
  const auto &left = info.cameras[0].camera, &right = info.cameras[1].camera;
  if (!left || !right || !info.left_from_right || same_intrinsics(*left, camera.intrinsics)) return std::nullopt;
  auto made = rectify_stereo(*left, *right, *info.left_from_right);
  if (!made || !same_intrinsics(made->camera, camera.intrinsics))
    throw Error("its calibration does not match the rectified camera of the map", info.path,
                "use the calibration of the run");
  return made;
}

Names write_keyframe_images(const Map& map, int submap, const std::vector<MapRecording>& recordings,
                            const fs::path& folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code)
    throw Error("the folder cannot be created (" + code.message() + ")", folder.string(), "choose another --out");
  Names names;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const auto keyframes = keyframes_of(map, submap, recordings[k].keyframes);
    const Target target{folder, k > 0 ? fmt::format("session{}_", k) : ""};
    const Names written = images_of_recording(map, recordings[k], keyframes, target);
    if (written.size() < keyframes.size())
      log_warning(fmt::format("{} lacks the frames of {} of {} keyframes: these have no image", recordings[k].named,
                              keyframes.size() - written.size(), keyframes.size()));
    names.insert(written.begin(), written.end());
  }
  return names;
}

}  // namespace rastro::cli
