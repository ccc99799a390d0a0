// SPDX-License-Identifier: Apache-2.0
// KITTI's "KEY: numbers" files: odometry calib.txt (P0 to P3) and raw calib_cam_to_cam.txt, calib_velo_to_cam.txt,
// calib_imu_to_velo.txt. Geiger et al. 2013, "Vision meets robotics: the KITTI dataset".
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/camera/file/formats.h"

namespace rastro::calibration {
namespace {

struct Values {
  int line = 0;
  std::vector<double> numbers;
};

/// The lines of a file by key. Lines that are not numbers (calib_time) are skipped.
class KittiFields {
 public:
  KittiFields(std::string_view text, std::string_view where) : where_(where) {
    for (const auto& [number, line] : content_lines(text)) add(number, line);
  }

  bool has(const std::string& key) const { return fields_.contains(key); }
  std::string at(const std::string& key) const { return at_line(where_, fields_.at(key).line); }

  Eigen::MatrixXd matrix(const std::string& key, int rows, int columns) const {
    const auto found = fields_.find(key);
    if (found == fields_.end()) throw Error(fmt::format("no line '{}:'", key), where_, "is the file complete?");
    const auto& numbers = found->second.numbers;
    if (numbers.size() != static_cast<std::size_t>(rows * columns))
      throw Error(fmt::format("{} has {} values, expected {}", key, numbers.size(), rows * columns), at(key),
                  "is the file complete?");
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const RowMajor>(numbers.data(), rows, columns);
  }

  /// 3x4: [R t]. Both are read before they are combined: an Error must not pass through a half-filled Eigen matrix.
  Eigen::MatrixXd rigid_rows(const std::string& rotation_key, const std::string& translation_key) const {
    const Eigen::MatrixXd rotation = matrix(rotation_key, 3, 3), translation = matrix(translation_key, 3, 1);
    Eigen::MatrixXd rows(3, 4);
    rows << rotation, translation;
    return rows;
  }
  const std::string& where() const { return where_; }

 private:
  void add(int number, std::string_view line) {
    const auto colon = line.find(':');
    if (colon == std::string_view::npos)
      throw Error(fmt::format("'{}' is not of the form 'KEY: numbers'", one_line(line, 40)), at_line(where_, number),
                  "");
    const std::string key(trim(line.substr(0, colon)));
    if (key == "calib_time") return;
    Values values{number, {}};
    for (const auto word : split_words(line.substr(colon + 1))) {
      const auto value = parse_finite(word);
      if (!value)
        throw Error(fmt::format("{} holds '{}', not a finite number", one_line(key, 40), one_line(word, 40)),
                    at_line(where_, number), "");
      values.numbers.push_back(*value);
    }
    if (!fields_.emplace(key, std::move(values)).second)
      throw Error(fmt::format("the line '{}:' occurs twice", one_line(key, 40)), at_line(where_, number), "");
  }

  std::string where_;
  std::map<std::string, Values> fields_;
};

struct Projection {
  Camera camera;
  SE3 camera_from_first;
};

/// P = K [I | t], where t is the position of the first (rectified) camera in this one's frame.
Projection split_projection(const Eigen::MatrixXd& p, const std::string& key, const std::string& where) {
  const bool rectified = p(0, 1) == 0.0 && p(1, 0) == 0.0 && p(2, 0) == 0.0 && p(2, 1) == 0.0 && p(2, 2) == 1.0;
  if (!rectified)
    throw Error(fmt::format("{} is not the projection of a rectified camera, [fx 0 cx x; 0 fy cy y; 0 0 1 z]", key),
                where, "");
  Projection result;
  result.camera.fx = p(0, 0);
  result.camera.fy = p(1, 1);
  result.camera.cx = p(0, 2);
  result.camera.cy = p(1, 2);
  require_usable(result.camera, where);
  const double z = p(2, 3);
  result.camera_from_first = SE3(SO3(), {(p(0, 3) - p(0, 2) * z) / p(0, 0), (p(1, 3) - p(1, 2) * z) / p(1, 1), z});
  return result;
}

constexpr int most_cameras = 4;

/// Appends the rectified cameras whose projections are present; `key` and `name` take the camera's number.
template <typename Name>
void add_rectified(const KittiFields& fields, const Name& key, const Name& name, Calibration& result) {
  std::optional<Projection> previous;
  for (int i = 0; i < most_cameras; ++i) {
    if (!fields.has(key(i))) continue;
    const Projection now = split_projection(fields.matrix(key(i), 3, 4), key(i), fields.at(key(i)));
    CalibratedCameraEntry entry;
    entry.name = name(i);
    entry.camera = now.camera;
    if (previous) {
      entry.camera_from_previous = now.camera_from_first * previous->camera_from_first.inverse();
      // 0 and 1 are the gray pair, 2 and 3 the color pair.
      if (i % 2 == 1 && fields.has(key(i - 1)))
        check_baseline(*entry.camera_from_previous, key(i - 1), key(i), result.warnings);
    }
    previous = now;
    result.cameras.push_back(std::move(entry));
  }
}

void add_unrectified(const KittiFields& fields, Calibration& result) {
  std::optional<SE3> previous_from_first;
  for (int i = 0; i < most_cameras; ++i) {
    const std::string suffix = fmt::format("_{:02}", i);
    if (!fields.has("K" + suffix)) continue;
    const Eigen::MatrixXd matrix = fields.matrix("K" + suffix, 3, 3), size = fields.matrix("S" + suffix, 1, 2),
                          distortion = fields.matrix("D" + suffix, 1, 5);
    CalibratedCameraEntry entry;
    entry.name = fmt::format("image{}_raw", suffix);
    entry.camera.fx = matrix(0, 0);
    entry.camera.fy = matrix(1, 1);
    entry.camera.cx = matrix(0, 2);
    entry.camera.cy = matrix(1, 2);
    set_size(entry.camera, size(0), size(1), fields.at("S" + suffix));
    set_distortion(entry.camera, "plumb_bob", {distortion.data(), 5}, fields.at("D" + suffix), "D" + suffix);
    require_usable(entry.camera, fields.at("K" + suffix));
    if (fields.has("R" + suffix) && fields.has("T" + suffix)) {
      const Eigen::MatrixXd transform = fields.rigid_rows("R" + suffix, "T" + suffix);
      const SE3 from_first = rigid_transform(transform, "R" + suffix, fields.at("R" + suffix), result.warnings);
      if (previous_from_first) entry.camera_from_previous = from_first * previous_from_first->inverse();
      previous_from_first = from_first;
    }
    result.cameras.push_back(std::move(entry));
  }
}

Calibration parse_odometry(const KittiFields& fields) {
  Calibration result;
  result.format = "kitti_odometry";
  add_rectified(
      fields, +[](int i) { return fmt::format("P{}", i); }, +[](int i) { return fmt::format("image_{}", i); }, result);
  return result;
}

Calibration parse_raw(const KittiFields& fields) {
  Calibration result;
  result.format = "kitti_raw";
  add_rectified(
      fields, +[](int i) { return fmt::format("P_rect_{:02}", i); },
      +[](int i) { return fmt::format("image_{:02}", i); }, result);
  for (auto& entry : result.cameras) {
    const std::string key = "S_rect_" + entry.name.substr(entry.name.size() - 2);
    const Eigen::MatrixXd size = fields.matrix(key, 1, 2);
    set_size(entry.camera, size(0), size(1), fields.at(key));
  }
  add_unrectified(fields, result);
  return result;
}

bool has_key(std::string_view text, std::string_view key) {
  for (const auto& [number, line] : content_lines(text))
    if (line.starts_with(key) && line.substr(key.size()).starts_with(':')) return true;
  return false;
}

}  // namespace

bool looks_like_kitti(std::string_view text) {
  for (const auto* key :
       {"P0", "P1", "P2", "P3", "P_rect_00", "P_rect_01", "P_rect_02", "P_rect_03", "K_00", "calib_time"})
    if (has_key(text, key)) return true;
  // OpenCV's file of a pair has them too, beside M1 and with or without its first line.
  return has_key(text, "R") && has_key(text, "T") && !has_key(text, "M1") && !text.starts_with("%YAML");
}

Calibration parse_kitti(std::string_view text, std::string_view where) {
  const KittiFields fields(text, where);
  for (const auto* key : {"P0", "P1", "P2", "P3"})
    if (fields.has(key)) return parse_odometry(fields);
  Calibration result = parse_raw(fields);
  if (result.cameras.empty())
    throw Error("has no camera (no P0, P_rect_00 or K_00)", where, "name calib.txt or calib_cam_to_cam.txt");
  return result;
}

}  // namespace rastro::calibration

namespace rastro {

SE3 parse_kitti_transform(std::string_view text, std::string_view where) {
  const calibration::KittiFields fields(text, where);
  std::vector<std::string> ignored;
  // Read separately first: it reports a missing key, for which there is no line to name.
  const Eigen::MatrixXd rows = fields.rigid_rows("R", "T");
  return calibration::rigid_transform(rows, "R", fields.at("R"), ignored);
}

std::optional<SO3> read_kitti_rectification(const std::string& path) {
  const calibration::KittiFields fields(read_text_file(path), path);
  const std::string key = "R_rect_00";
  if (!fields.has(key)) return std::nullopt;
  std::vector<std::string> ignored;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, 4);
  const Eigen::MatrixXd rotation = fields.matrix(key, 3, 3);
  rows.leftCols<3>() = rotation;
  return calibration::rigid_transform(rows, key, fields.at(key), ignored).rotation();
}

SE3 read_kitti_transform(const std::string& path) { return parse_kitti_transform(read_text_file(path), path); }

}  // namespace rastro
