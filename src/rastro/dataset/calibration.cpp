// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/calibration.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/base/text_file.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/tum_rgbd/depth_factor.h"

namespace rastro {
namespace {

constexpr double field_of_view_error = 0.05;

CalibratedCamera calibrated(const std::string& name, const CalibratedCameraEntry& entry,
                            const std::filesystem::path& file) {
  CalibratedCamera camera{name, entry.camera, entry.body_from_camera, file.string()};
  camera.calibration_error = entry.calibration_error.value_or(camera.calibration_error);
  return camera;
}

Camera camera_from_intrinsics(const std::array<double, 4>& values) {
  Camera camera;
  camera.fx = values[0];
  camera.fy = values[1];
  camera.cx = values[2];
  camera.cy = values[3];
  return camera;
}

const CalibratedCameraEntry* find_entry(const Calibration& calibration, const std::string& name, bool only_name) {
  for (const auto& entry : calibration.cameras)
    if (entry.name == name) return &entry;
  return only_name && calibration.cameras.size() == 1 ? &calibration.cameras.front() : nullptr;
}

Calibration read_with_warnings(SourceInfo& info, const std::filesystem::path& file) {
  auto calibration = read_calibration(file.string());
  info.depth_registration = calibration.depth;
  for (const auto& warning : calibration.warnings)
    info.warnings.push_back(fmt::format("{}: {}", file.string(), warning));
  return calibration;
}

std::string names_in(const Calibration& calibration) {
  std::vector<std::string> names;
  for (const auto& entry : calibration.cameras) names.push_back(entry.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

[[noreturn]] void refuse_cameras(const Calibration& calibration, const std::string& wanted,
                                 const std::filesystem::path& file) {
  throw Error(fmt::format("has {}, but not {}", names_in(calibration), wanted), file.string(),
              "--camera NAME chooses a camera, --calibration FILE another file");
}

/// A file for the depth alone: without a camera of any format, which is no mistake then.
bool has_only_depth_factor(const std::filesystem::path& file) {
  const std::string text = read_text_file(file.string());
  return !holds_camera(text) && parse_depth_factor(text, file.string());
}

/// Along the file's chain of camera_from_previous, back to the last camera that has none.
std::optional<SE3> chained(const Calibration& calibration, const std::string& name) {
  SE3 first_from_this;
  for (const auto& entry : calibration.cameras) {
    first_from_this = entry.camera_from_previous ? first_from_this * entry.camera_from_previous->inverse() : SE3();
    if (entry.name == name) return first_from_this;
  }
  return std::nullopt;
}

void set_stereo_pose(SourceInfo& info, const Calibration& calibration, const std::vector<std::string>& names) {
  if (names.size() < 2) return;
  info.left_from_right = relative_pose(info.cameras[0], info.cameras[1]);
  if (info.left_from_right || calibration.cameras.size() < 2) return;
  const auto first_from_left = chained(calibration, names[0]), first_from_right = chained(calibration, names[1]);
  if (first_from_left && first_from_right) info.left_from_right = first_from_left->inverse() * *first_from_right;
}

/// A file of another program names its cameras as it likes; left comes before right in all of them.
void read_cameras_in_order(SourceInfo& info, const Calibration& calibration, const std::filesystem::path& file,
                           const std::vector<std::string>& names) {
  const std::size_t count = std::min(names.size(), calibration.cameras.size());
  std::vector<std::string> entries;
  for (std::size_t k = 0; k < count; ++k) {
    entries.push_back(calibration.cameras[k].name);
    info.cameras.push_back(calibrated(names[k], calibration.cameras[k], file));
  }
  const std::vector<std::string> named(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count));
  info.warnings.push_back(fmt::format("{}: has other names: {} is taken for {}", file.string(),
                                      fmt::join(entries, ", "), fmt::join(named, ", ")));
  for (std::size_t k = count; k < names.size(); ++k) {
    info.cameras.push_back(uncalibrated(names[k]));
    info.warnings.push_back(fmt::format("{}: no calibration for {}", file.string(), names[k]));
  }
  set_stereo_pose(info, calibration, entries);
}

void read_given_cameras(SourceInfo& info, const std::filesystem::path& file, const std::vector<std::string>& names) {
  const auto calibration = read_calibration(file.string());
  const bool any_name = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return find_entry(calibration, name, false) != nullptr;
  });
  // One camera of several is not told by an order.
  if (any_name || names.size() == 1) return read_cameras(info, file, names);
  read_cameras_in_order(info, read_with_warnings(info, file), file, names);
}

void apply_given(SourceInfo& info, const OpenOptions& options, std::optional<ImageSize> size) {
  auto& main = info.cameras.front();
  if (!options.calibration_file.empty()) {
    std::vector<std::string> names;
    for (const auto& camera : info.cameras) names.push_back(camera.name);
    info.cameras.clear();
    if (info.format == "images" || info.format == "video" || info.format.starts_with("live_")) {
      read_unnamed_camera(info, options.calibration_file, names.front(), options.camera);
    } else {
      read_given_cameras(info, options.calibration_file, names);
    }
  } else if (options.intrinsics) {
    main.camera = camera_from_intrinsics(*options.intrinsics);
    main.calibration_file = "--intrinsics";
  } else if (options.field_of_view_deg && !main.camera) {
    if (!size) throw Error("the size of the images is unknown", "--fov", "give --intrinsics fx,fy,cx,cy instead");
    main.camera = camera_from_field_of_view(*options.field_of_view_deg, size->width, size->height);
    main.calibration_file = "--fov";
    main.calibration_error = field_of_view_error;
  } else if (options.field_of_view_deg) {
    info.warnings.push_back(fmt::format("--fov is not used: there is a calibration ({})", main.calibration_file));
  }
}

void fit_to_images(SourceInfo& info, CalibratedCamera& camera, const ImageSize& size) {
  if (camera.camera->width == 0) {
    camera.camera->width = size.width;
    camera.camera->height = size.height;
  } else if (camera.camera->width != size.width || camera.camera->height != size.height) {
    info.warnings.push_back(fmt::format("{}: the calibration is for images of {}x{}, these are {}x{}",
                                        camera.calibration_file, camera.camera->width, camera.camera->height,
                                        size.width, size.height));
  }
}

}  // namespace

bool calibration_is_given(const OpenOptions& options) {
  return !options.calibration_file.empty() || options.intrinsics;
}

CalibratedCamera uncalibrated(const std::string& name) { return {name, std::nullopt, std::nullopt, ""}; }

void read_cameras(SourceInfo& info, const std::filesystem::path& file, const std::vector<std::string>& names) {
  const auto calibration = read_with_warnings(info, file);
  std::vector<std::string> unknown;
  for (const auto& name : names) {
    const auto* entry = find_entry(calibration, name, names.size() == 1);
    if (!entry) unknown.push_back(name);
    info.cameras.push_back(entry ? calibrated(name, *entry, file) : uncalibrated(name));
  }
  if (unknown.size() == names.size()) refuse_cameras(calibration, fmt::format("{}", fmt::join(unknown, ", ")), file);
  for (const auto& name : unknown)
    info.warnings.push_back(fmt::format("{}: no calibration for {}", file.string(), name));
  set_stereo_pose(info, calibration, names);
}

void read_unnamed_camera(SourceInfo& info, const std::filesystem::path& file, const std::string& own_name,
                         const std::string& wanted) {
  const auto calibration = read_with_warnings(info, file);
  const auto* entry = wanted.empty() ? &calibration.cameras.front() : find_entry(calibration, wanted, false);
  if (!entry) refuse_cameras(calibration, wanted, file);
  const bool only = calibration.cameras.size() == 1;
  if (wanted.empty() && !only) {
    info.warnings.push_back(fmt::format("{}: has {}; {} is used, --camera NAME selects another", file.string(),
                                        names_in(calibration), entry->name));
  }
  info.cameras.push_back(calibrated(only ? own_name : entry->name, *entry, file));
}

std::optional<SE3> first_from_camera(const std::filesystem::path& file, const std::string& name) {
  return chained(read_calibration(file.string()), name);
}

std::filesystem::path find_calibration_file(const std::filesystem::path& folder) {
  for (const char* file : {"camera.yaml", "camera.yml", "calibration.yaml", "calibration.yml", "camera_info.yaml",
                           "camchain.yaml", "sensor.yaml", "calib.txt"}) {
    if (is_file(folder / file) && !has_only_depth_factor(folder / file)) return folder / file;
  }
  return {};
}

std::optional<SE3> relative_pose(const CalibratedCamera& left, const CalibratedCamera& right) {
  if (!left.body_from_camera || !right.body_from_camera) return std::nullopt;
  return left.body_from_camera->inverse() * *right.body_from_camera;
}

void finish_calibration(SourceInfo& info, const OpenOptions& options, std::optional<ImageSize> size) {
  apply_given(info, options, size);
  for (auto& camera : info.cameras) {
    if (!camera.camera) continue;
    camera.camera->readout_s = options.readout_s.value_or(camera.camera->readout_s);
    camera.calibration_error = options.calibration_error.value_or(camera.calibration_error);
    if (size) fit_to_images(info, camera, *size);
    for (const auto& warning : calibration_warnings(*camera.camera)) {
      info.warnings.push_back(fmt::format("{} of {}: {}", camera.name, camera.calibration_file, warning));
    }
  }
  if (!info.cameras.front().camera) {
    info.warnings.push_back(fmt::format(
        "no calibration found for {}; --calibration FILE, --intrinsics fx,fy,cx,cy or --fov DEG gives one", info.path));
  }
}

}  // namespace rastro
