// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/kitti/kitti_odometry.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/ground_truth.h"
#include "rastro/dataset/kitti/kitti_images.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr double usual_rate_hz = 10.0;

std::vector<std::string> camera_names(const fs::path& path) {
  std::vector<std::string> names;
  for (const char* name : {"image_0", "image_2", "image_1", "image_3"}) {
    if (!image_names(path / name).empty()) names.emplace_back(name);
  }
  return names;
}

std::string choose_camera(const fs::path& path, const std::vector<std::string>& names, const std::string& wanted) {
  if (wanted.empty()) return names.front();
  if (std::find(names.begin(), names.end(), wanted) != names.end()) return wanted;
  throw Error(fmt::format("there is no camera '{}'", wanted), path.string(),
              fmt::format("there are {}", fmt::join(names, ", ")));
}

void set_made_up_stamps(Recording& recording, double rate_hz) {
  recording.info.has_stamps = false;
  for (std::size_t k = 0; k < recording.frames.size(); ++k) {
    recording.frames[k].stamp = made_up_stamp(static_cast<std::int64_t>(k), rate_hz);
  }
}

/// Stamps by the number in the file's name; images without a row in times.txt are omitted.
void set_stamps(Recording& recording, std::vector<std::string>& names, const fs::path& path,
                const OpenOptions& options) {
  const fs::path file = path / "times.txt";
  const double rate_hz = options.rate_hz > 0.0 ? options.rate_hz : usual_rate_hz;
  if (!is_file(file)) {
    set_made_up_stamps(recording, rate_hz);
    recording.info.warnings.push_back(
        fmt::format("no times.txt; stamps are made up at {:g} Hz, --rate HZ changes that", rate_hz));
    return;
  }
  const auto times = parse_kitti_times(read_text_file(file.string()), file.string());
  const auto rows = rows_of_images(names, times.size());
  const auto stamped =
      static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](auto row) { return row >= 0; }));
  for (std::size_t k = 0; k < stamped; ++k) recording.frames[k].stamp = times[static_cast<std::size_t>(rows[k])];
  if (stamped < names.size()) {
    recording.info.warnings.push_back(fmt::format("{}: {} timestamps for {} images; the last {} images are ignored",
                                                  file.string(), times.size(), names.size(), names.size() - stamped));
    recording.frames.resize(stamped);
    names.resize(stamped);
  }
}

fs::path poses_file(const fs::path& path) {
  const fs::path whole = fs::absolute(path / "x").lexically_normal().parent_path();
  for (const auto& file : {path / "poses.txt", path / "groundtruth.txt",
                           whole.parent_path().parent_path() / "poses" / (whole.filename().string() + ".txt")}) {
    if (is_file(file)) return file;
  }
  return {};
}

Trajectory stamped_poses(const Recording& recording, const std::vector<std::string>& names, const fs::path& file) {
  const auto poses = parse_kitti_poses(read_text_file(file.string()), file.string());
  const auto rows = rows_of_images(names, poses.size());
  Trajectory trajectory;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (rows[k] >= 0) trajectory.push_back({recording.frames[k].stamp, poses[static_cast<std::size_t>(rows[k])]});
  }
  if (!std::is_sorted(trajectory.begin(), trajectory.end(),
                      [](const auto& a, const auto& b) { return a.stamp < b.stamp; })) {
    throw Error("cannot be stamped, the stamps of the images go backward", file.string(), "");
  }
  return trajectory;
}

void add_cameras(Recording& recording, const fs::path& path, const std::string& main, const std::string& right,
                 bool given) {
  std::vector<std::string> names = {main};
  if (recording.info.has_right) names.push_back(right);
  const fs::path file = path / "calib.txt";
  if (!given && is_file(file)) return read_cameras(recording.info, file, names);
  for (const auto& name : names) recording.info.cameras.push_back(uncalibrated(name));
}

/// The poses of KITTI are of image_0; for another main camera they become those of a body whose camera sits beside it.
void pose_on_body(SourceInfo& info, const fs::path& path) {
  auto& main = info.cameras.front();
  const fs::path file = path / "calib.txt";
  if (info.ground_truth.empty() || main.name == "image_0" || !is_file(file)) return;
  main.body_from_camera = first_from_camera(file, main.name);
  if (main.body_from_camera) info.ground_truth_frame = "body";
}

}  // namespace

std::optional<Recording> index_kitti_odometry(const fs::path& path, const OpenOptions& options) {
  const auto cameras = camera_names(path);
  if (cameras.empty()) return std::nullopt;
  const std::string main = choose_camera(path, cameras, options.camera);
  const std::string right = kitti_right_of(main);
  auto names = image_names(path / main);

  Recording recording;
  recording.info.path = path.string();
  recording.info.format = "kitti_odometry";
  recording.frames = kitti_frames(path / main, right.empty() ? fs::path() : path / right, names);
  set_stamps(recording, names, path, options);
  describe_right(recording, right, path / right);
  add_cameras(recording, path, main, right, calibration_is_given(options));
  if (const auto file = poses_file(path); !file.empty()) {
    read_ground_truth(recording.info, file, "camera", [&] { return stamped_poses(recording, names, file); });
    pose_on_body(recording.info, path);
  }
  return recording;
}

}  // namespace rastro
