// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/kitti/kitti_raw.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/ground_truth.h"
#include "rastro/dataset/kitti/kitti_images.h"
#include "rastro/dataset/kitti/oxts.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr double usual_rate_hz = 10.0;

std::vector<std::string> camera_names(const fs::path& path) {
  std::vector<std::string> names;
  for (const char* name : {"image_00", "image_02", "image_01", "image_03"}) {
    if (!image_names(path / name / "data").empty()) names.emplace_back(name);
  }
  return names;
}

fs::path calibration_file(const fs::path& path) {
  const fs::path above = fs::absolute(path / "x").lexically_normal().parent_path().parent_path();
  for (const auto& file : {path / "calib_cam_to_cam.txt", above / "calib_cam_to_cam.txt"})
    if (is_file(file)) return file;
  return {};
}

void set_stamps(Recording& recording, const fs::path& folder, const std::vector<std::string>& names,
                double wanted_rate_hz) {
  const fs::path file = folder / "timestamps.txt";
  if (!is_file(file)) {
    const double rate_hz = wanted_rate_hz > 0.0 ? wanted_rate_hz : usual_rate_hz;
    recording.info.has_stamps = false;
    recording.info.warnings.push_back(
        fmt::format("no {}; stamps are made up at {:g} Hz, --rate HZ changes that", file.string(), rate_hz));
    for (std::size_t k = 0; k < names.size(); ++k)
      recording.frames[k].stamp = made_up_stamp(static_cast<std::int64_t>(k), rate_hz);
    return;
  }
  const auto stamps = parse_kitti_timestamps(read_text_file(file.string()), file.string());
  const auto rows = rows_of_images(names, stamps.size());
  const auto stamped =
      static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](auto row) { return row >= 0; }));
  for (std::size_t k = 0; k < stamped; ++k) recording.frames[k].stamp = stamps[static_cast<std::size_t>(rows[k])];
  if (stamped == names.size()) return;
  recording.info.warnings.push_back(fmt::format("{}: {} timestamps for {} images; the last {} images are ignored",
                                                file.string(), stamps.size(), names.size(), names.size() - stamped));
  recording.frames.resize(stamped);
}

/// Synced drives hold rectified images; "extract" ones do not, which their size tells.
bool is_unrectified(const Recording& recording, const fs::path& file, const std::string& name) {
  const auto size = image_size(recording.frames.front().image);
  if (!size) return false;
  const auto calibration = read_calibration(file.string());
  const auto fits = [&](const std::string& wanted) {
    return std::any_of(calibration.cameras.begin(), calibration.cameras.end(), [&](const auto& entry) {
      return entry.name == wanted && entry.camera.width == size->width && entry.camera.height == size->height;
    });
  };
  return !fits(name) && fits(name + "_raw");
}

void add_cameras(Recording& recording, const fs::path& path, const std::string& main, const std::string& right,
                 bool given) {
  std::vector<std::string> names = {main};
  if (recording.info.has_right) names.push_back(right);
  const fs::path file = calibration_file(path);
  if (given || file.empty()) {
    for (const auto& name : names) recording.info.cameras.push_back(uncalibrated(name));
    return;
  }
  if (is_unrectified(recording, file, main)) {
    for (auto& name : names) name += "_raw";
    recording.info.warnings.push_back("the images have the size of unrectified ones and are read as such");
  }
  read_cameras(recording.info, file, names);
}

/// The poses of oxts are of the GPS/IMU unit; the files of the calibration tell where the camera is on it.
void pose_on_body(SourceInfo& info, const fs::path& cam_to_cam) {
  auto& main = info.cameras.front();
  if (cam_to_cam.empty() || main.calibration_file != cam_to_cam.string()) return;
  const auto body_from_first =
      oxts_from_first_camera(cam_to_cam.parent_path(), cam_to_cam, !main.name.ends_with("_raw"));
  const auto first_from_main = first_from_camera(cam_to_cam, main.name);
  if (body_from_first && first_from_main) main.body_from_camera = *body_from_first * *first_from_main;
}

void add_oxts(SourceInfo& info, const fs::path& path) {
  const fs::path folder = path / "oxts";
  if (!is_file(folder / "timestamps.txt")) return;
  read_ground_truth(info, folder / "data", "body", [&] { return read_oxts(folder); });
  if (info.ground_truth.empty()) return;
  try {
    pose_on_body(info, calibration_file(path));
  } catch (const Error& error) {
    info.warnings.push_back(std::string("the pose of the camera on the GPS/IMU unit is not used: ") + error.what());
  }
}

}  // namespace

std::vector<TimeNs> parse_kitti_timestamps(std::string_view text, std::string_view where) {
  std::vector<TimeNs> stamps;
  for (const auto& line : content_lines(text)) {
    const auto stamp = parse_date_stamp(line.text);
    if (!stamp) {
      throw Error(
          fmt::format("{} is not a date and time such as '2011-09-26 13:02:25.964389445'", in_quotes(line.text)),
          at_line(where, line.number), "");
    }
    stamps.push_back(*stamp);
  }
  if (stamps.empty()) throw Error("has no timestamps", where, "");
  return stamps;
}

std::optional<Recording> index_kitti_raw(const fs::path& path, const OpenOptions& options) {
  const auto cameras = camera_names(path);
  if (cameras.empty()) return std::nullopt;
  if (!options.camera.empty() && std::find(cameras.begin(), cameras.end(), options.camera) == cameras.end()) {
    throw Error(fmt::format("there is no camera '{}'", options.camera), path.string(),
                fmt::format("there are {}", fmt::join(cameras, ", ")));
  }
  const std::string main = options.camera.empty() ? cameras.front() : options.camera;
  const std::string right = kitti_right_of(main);
  const auto names = image_names(path / main / "data");

  Recording recording;
  recording.info.path = path.string();
  recording.info.format = "kitti_raw";
  recording.frames = kitti_frames(path / main / "data", right.empty() ? fs::path() : path / right / "data", names);
  recording.stamp_unit = "date";
  set_stamps(recording, path / main, names, options.rate_hz);
  describe_right(recording, right, path / right / "data");

  add_cameras(recording, path, main, right, calibration_is_given(options));
  add_oxts(recording.info, path);
  return recording;
}

}  // namespace rastro
