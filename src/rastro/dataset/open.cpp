// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/open.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/euroc/euroc.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/images/images.h"
#include "rastro/dataset/kitti/kitti_odometry.h"
#include "rastro/dataset/kitti/kitti_raw.h"
#include "rastro/dataset/laser_log/open_log.h"
#include "rastro/dataset/recording.h"
#include "rastro/dataset/registered_depth.h"
#include "rastro/dataset/tum_rgbd/tum_rgbd.h"
#include "rastro/dataset/video/video.h"

namespace rastro {
namespace {

constexpr const char* known_formats =
    "looked for EuRoC (mav0/cam0/data.csv), TUM RGB-D (rgb.txt), KITTI odometry (image_0), KITTI raw (image_00/data) "
    "and "
    "images; name a video file itself";

std::optional<Recording> guess(const std::string& path, const OpenOptions& options) {
  if (!is_folder(path)) return index_images(path, options);
  if (auto recording = index_euroc(path, options)) return recording;
  if (auto recording = index_tum_rgbd(path, options)) return recording;
  if (auto recording = index_kitti_raw(path, options)) return recording;
  if (auto recording = index_kitti_odometry(path, options)) return recording;
  return index_images(path, options);
}

bool holds_recording(const std::filesystem::path& path) {
  try {
    return guess(path.string(), {}).has_value();
  } catch (const Error&) {
    return false;
  }
}

[[noreturn]] void refuse_folder(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_empty(path, ignored)) throw Error("the folder is empty", path, known_formats);
  for (const auto& name : folder_names(path)) {
    if (holds_recording(std::filesystem::path(path) / name)) {
      throw Error("is not a recording itself", path,
                  fmt::format("did you mean {}?", (std::filesystem::path(path) / name).string()));
    }
  }
  throw Error("is not a recording of a known format", path, known_formats);
}

/// Size of the first image that can be read among the first few.
std::optional<ImageSize> first_image_size(const Recording& recording) {
  constexpr std::size_t tries = 5;
  for (std::size_t k = 0; k < std::min(tries, recording.frames.size()); ++k) {
    if (const auto size = image_size(recording.frames[k].image)) return size;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Recording> index_recording(const std::string& path, const OpenOptions& options) {
  if (is_file(path) && !has_image_ending(path)) return std::nullopt;
  std::error_code ignored;
  const bool exists = std::filesystem::exists(path, ignored);
  const bool is_pattern = !exists && path.find_first_of("*?[") != std::string::npos;
  if (!is_file(path) && !is_pattern) require_folder(path);
  auto recording = guess(path, options);
  if (!recording) refuse_folder(path);
  recording->info.frame_count = static_cast<std::int64_t>(recording->frames.size());
  if (options.rate_hz > 0.0 && recording->info.has_stamps)
    recording->info.warnings.push_back("--rate is for data without stamps; those of the recording are used");
  finish_calibration(recording->info, options, first_image_size(*recording));
  return recording;
}

std::unique_ptr<Source> open(const std::string& path, const OpenOptions& options) {
  if (auto log = open_log(path, options))
    return read_ahead(registered_depth(std::move(log), options), options.read_ahead);
  auto recording = index_recording(path, options);
  auto source = recording ? make_recording_source(std::move(*recording), options) : open_video(path, options);
  return read_ahead(registered_depth(std::move(source), options), options.read_ahead);
}

}  // namespace rastro
