// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/euroc/euroc.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/ground_truth.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs max_stereo_difference = 1'000'000;  // Both shutters are triggered together.

bool is_camera_folder(const fs::path& path) { return is_file(path / "data.csv") && is_folder(path / "data"); }

/// Where the camera folders lie, and the main camera where the path itself names one.
struct Location {
  fs::path root;
  std::string camera;
};

std::vector<std::string> camera_names(const fs::path& root) {
  std::vector<std::string> names;
  for (const auto& name : folder_names(root)) {
    if (name.starts_with("cam") && is_camera_folder(root / name)) names.push_back(name);
  }
  return names;
}

std::optional<Location> find_location(const fs::path& path) {
  if (!camera_names(path / "mav0").empty()) return Location{path / "mav0", ""};
  if (!camera_names(path).empty()) return Location{path, ""};
  const fs::path folder = path.has_filename() ? path : path.parent_path();
  if (is_camera_folder(folder) && !is_file(folder / "rgb.txt")) {
    const fs::path whole = fs::absolute(folder);
    return Location{folder.has_parent_path() ? folder.parent_path() : whole.parent_path(), whole.filename().string()};
  }
  return std::nullopt;
}

ImageList read_list(const fs::path& root, const std::string& camera, SourceInfo& info) {
  const std::string file = (root / camera / "data.csv").string();
  auto list = parse_euroc_image_list(read_text_file(file), file);
  if (auto warning = unit_warning(list.unit, StampUnit::nanoseconds, file); !warning.empty())
    info.warnings.push_back(warning);
  return list;
}

void add_camera(SourceInfo& info, const fs::path& root, const std::string& name, bool wanted) {
  const fs::path file = root / name / "sensor.yaml";
  if (wanted && is_file(file)) return read_cameras(info, file, {name});
  info.cameras.push_back(uncalibrated(name));
}

std::string choose_camera(const Location& location, const std::vector<std::string>& names, const std::string& wanted) {
  if (!wanted.empty() && std::find(names.begin(), names.end(), wanted) == names.end()) {
    throw Error(fmt::format("there is no camera '{}'", wanted), location.root.string(),
                fmt::format("there are {}", fmt::join(names, ", ")));
  }
  if (!wanted.empty()) return wanted;
  return location.camera.empty() ? names.front() : location.camera;
}

/// The next camera after the main one is the right one of a stereo pair.
std::string right_of(const std::vector<std::string>& names, const std::string& main) {
  const auto found = std::find(names.begin(), names.end(), main);
  return found != names.end() && found + 1 != names.end() ? *(found + 1) : "";
}

void add_right(Recording& recording, const fs::path& root, const std::string& right, const ImageList& left_list) {
  const auto list = read_list(root, right, recording.info);
  const auto partner = associate(left_list.images, list.images, max_stereo_difference);
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < partner.size(); ++i) {
    if (partner[i] < 0) continue;
    recording.frames[i].right =
        (root / right / "data" / list.images[static_cast<std::size_t>(partner[i])].file).string();
    ++pairs;
  }
  recording.info.has_right = pairs > 0;
  if (pairs < partner.size()) {
    recording.info.warnings.push_back(fmt::format("{} of {} frames have an image of {}", pairs, partner.size(), right));
  }
}

/// The pose that a Vicon or a laser tracker gives is of its own target; sensor.yaml says where that sits on the body.
Trajectory in_body_frame(Trajectory trajectory, const fs::path& folder) {
  const fs::path file = folder / "sensor.yaml";
  if (!is_file(file)) return trajectory;
  const SE3 target_from_body = parse_sensor_pose(read_text_file(file.string()), file.string()).inverse();
  for (auto& pose : trajectory) pose.world_from_body = pose.world_from_body * target_from_body;
  return trajectory;
}

/// Guessed by its own numbers, as that of the images is by theirs, with a warning where it is not nanoseconds.
StampUnit ground_truth_unit(SourceInfo& info, const std::string& text, const fs::path& file) {
  const StampUnit unit = guess_column_unit(text, StampUnit::nanoseconds);
  if (auto warning = unit_warning(unit, StampUnit::nanoseconds, file.string()); !warning.empty())
    info.warnings.push_back(std::move(warning));
  return unit;
}

void add_ground_truth(SourceInfo& info, const fs::path& root) {
  for (const char* name : {"state_groundtruth_estimate0", "groundtruth0", "vicon0", "mocap0"}) {
    const fs::path file = root / name / "data.csv";
    if (!is_file(file)) continue;
    read_ground_truth(info, file, "body", [&] {
      const std::string text = read_text_file(file.string());
      const StampUnit unit = ground_truth_unit(info, text, file);
      return in_body_frame(parse_euroc_trajectory(text, file.string(), unit), root / name);
    });
    if (!info.ground_truth.empty()) return;
  }
  const fs::path leica = root / "leica0" / "data.csv";
  if (!is_file(leica)) return;
  read_ground_truth(info, leica, "body", [&] {
    const std::string text = read_text_file(leica.string());
    return parse_leica_positions(text, leica.string(), ground_truth_unit(info, text, leica));
  });
  if (!info.ground_truth.empty()) {
    info.warnings.push_back(leica.string() +
                            ": has positions of its prism only; the rotations of the ground truth are meaningless");
  }
}

}  // namespace

Trajectory parse_leica_positions(std::string_view text, std::string_view where, StampUnit unit) {
  Trajectory trajectory;
  for (const auto& line : content_lines(text)) {
    const auto here = at_line(where, line.number);
    const auto words = split(line.text, ',');
    if (words.size() != 4)
      throw Error(fmt::format("{} columns instead of the 4 of 'stamp,x,y,z'", words.size()), here, "");
    const auto stamp = parse_stamp(words[0], unit);
    const auto x = parse_finite(words[1]), y = parse_finite(words[2]), z = parse_finite(words[3]);
    if (!stamp || !x || !y || !z) throw Error("a column is not a finite number", here, "");
    trajectory.push_back({*stamp, SE3(SO3(), {*x, *y, *z})});
  }
  if (trajectory.empty()) throw Error("has no positions", where, "");
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  return trajectory;
}

SE3 parse_sensor_pose(std::string_view text, std::string_view where) {
  // ASL's own files begin with "%YAML:1.0", which is no YAML.
  const auto begin = text.starts_with('%') ? std::min(text.find('\n'), text.size()) : 0;
  try {
    const auto data = YAML::Load(std::string(text.substr(begin)))["T_BS"]["data"].as<std::vector<double>>();
    if (data.size() != 16) throw Error(fmt::format("T_BS has {} numbers instead of 16", data.size()), where, "");
    Eigen::Matrix4d matrix;
    for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = data[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    const double departure = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!matrix.allFinite() || !(departure < 0.02)) throw Error("T_BS is not a rigid transform", where, "");
    return SE3::from_matrix(matrix);
  } catch (const YAML::Exception& exception) {
    throw Error("T_BS cannot be read (" + one_line(exception.msg) + ")", where, "");
  }
}

ImageList parse_euroc_image_list(std::string_view text, std::string_view where) {
  std::vector<RawListLine> lines;
  for (const auto& line : content_lines(text)) {
    const auto words = split(line.text, ',');
    if (words.size() != 2) {
      throw Error(fmt::format("{} columns instead of the 2 of 'stamp,file'", words.size()), at_line(where, line.number),
                  "");
    }
    lines.push_back({line.number, words[0], words[1]});
  }
  return make_image_list(lines, StampUnit::nanoseconds, where);
}

std::optional<Recording> index_euroc(const fs::path& path, const OpenOptions& options) {
  const auto location = find_location(path);
  if (!location) return std::nullopt;
  auto names = camera_names(location->root);
  const std::string main = choose_camera(*location, names, options.camera);
  const std::string right = right_of(names, main);

  Recording recording;
  recording.info.path = path.string();
  recording.info.format = "euroc";
  const auto list = read_list(location->root, main, recording.info);
  recording.stamp_unit = unit_name(list.unit);
  for (const auto& image : list.images) {
    recording.frames.push_back({image.stamp, (location->root / main / "data" / image.file).string(), "", "", 0});
  }
  add_camera(recording.info, location->root, main, !calibration_is_given(options));
  if (!right.empty()) {
    add_right(recording, location->root, right, list);
    add_camera(recording.info, location->root, right, options.calibration_file.empty());
    recording.info.left_from_right = relative_pose(recording.info.cameras[0], recording.info.cameras[1]);
  }
  add_ground_truth(recording.info, location->root);
  return recording;
}

}  // namespace rastro
