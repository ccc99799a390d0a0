// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/surface_truth/surface_ground_truth_reader.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/image_file.h"

namespace rastro {
namespace {

constexpr std::size_t most_kept = 40;  // The window of a tracker and a little more, about 1.4 MB each.
constexpr const char* remedy = "write the recording anew with `rastro simulate`";

double finite_number(const YAML::Node& node, const std::string& file, const char* key) {
  const std::optional<double> value = node.IsScalar() ? parse_finite(node.Scalar()) : std::nullopt;
  if (!value) throw Error(std::string("'") + key + "' is not a finite number", file, remedy);
  return *value;
}

std::vector<double> numbers(const YAML::Node& root, const std::string& file, const char* key, std::size_t count) {
  const YAML::Node node = root[key];
  if (!node || !node.IsSequence() || node.size() != count)
    throw Error(std::string("'") + key + "' is not a list of " + std::to_string(count) + " numbers", file, remedy);
  std::vector<double> result;
  for (const YAML::Node& item : node) result.push_back(finite_number(item, file, key));
  return result;
}

YAML::Node load(const std::string& file) {
  const std::string text = read_text_file(file);
  try {
    YAML::Node root = YAML::Load(text);
    if (root.IsMap()) return root;
  } catch (const YAML::Exception&) {  // NOLINT(bugprone-empty-catch): both ways end in the same line.
  }
  throw Error("this is not a YAML map", file, remedy);
}

Camera camera_of(const YAML::Node& root, const std::string& file) {
  Camera camera;
  const std::vector<double> size = numbers(root, file, "resolution", 2);
  for (const double side : size)
    if (side < 2.0 || side > 1e5 || side != std::floor(side)) throw Error("'resolution' is out of range", file, remedy);
  camera.width = static_cast<int>(size[0]), camera.height = static_cast<int>(size[1]);
  const std::vector<double> intrinsics = numbers(root, file, "intrinsics", 4);
  camera.fx = intrinsics[0], camera.fy = intrinsics[1], camera.cx = intrinsics[2], camera.cy = intrinsics[3];
  if (!(camera.fx > 0.0 && camera.fy > 0.0)) throw Error("the focal length is not positive", file, remedy);
  const std::vector<double> coefficients = numbers(root, file, "distortion_coefficients", 4);
  std::copy(coefficients.begin(), coefficients.end(), camera.coefficients.begin());
  const bool bent = std::any_of(coefficients.begin(), coefficients.end(), [](double value) { return value != 0.0; });
  camera.distortion = bent ? Distortion::radial_tangential : Distortion::none;
  return camera;
}

StampedPose pose_of(const TextLine& line, const std::string& file) {
  const std::string where = at_line(file, line.number);
  const std::vector<std::string_view> fields = split(line.text, ',');
  if (fields.size() != 8)
    throw Error("there are " + std::to_string(fields.size()) + " columns in place of 8", where, remedy);
  const std::optional<std::int64_t> stamp = parse_int64(fields[0]);
  if (!stamp) throw Error("the stamp is not a whole number", where, remedy);
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::optional<double> value = parse_finite(fields[i + 1]);
    if (!value) throw Error("column " + std::to_string(i + 2) + " is not a finite number", where, remedy);
    values[i] = *value;
  }
  const Eigen::Quaterniond rotation(values[3], values[4], values[5], values[6]);
  if (std::abs(rotation.norm() - 1.0) > 1e-3) throw Error("the quaternion is not of unit length", where, remedy);
  return {*stamp, SE3(SO3(rotation), {values[0], values[1], values[2]})};
}

}  // namespace

struct SurfaceGroundTruthReader::Images {
  std::int64_t frame = 0;
  Image<std::uint16_t> inverse_depth, surface;

  bool holds(int x, int y) const { return x >= 0 && y >= 0 && x < surface.width() && y < surface.height(); }
  /// Change of the inverse depth from (x, y) along x or y, in steps a pixel, from neighbors on the same surface.
  double slope(int x, int y, int step_x, int step_y) const {
    const auto same = [&](int other_x, int other_y) {
      return holds(other_x, other_y) && surface.at(other_x, other_y) == surface.at(x, y);
    };
    const bool before = same(x - step_x, y - step_y), after = same(x + step_x, y + step_y);
    const double here = inverse_depth.at(x, y);
    const double from = before ? inverse_depth.at(x - step_x, y - step_y) : here;
    const double to = after ? inverse_depth.at(x + step_x, y + step_y) : here;
    return before && after ? 0.5 * (to - from) : to - from;
  }
};

SurfaceGroundTruthReader::SurfaceGroundTruthReader(const std::string& ground_truth_folder)
    : folder_(ground_truth_folder) {
  const std::string camera_file = folder_ + "/camera.yaml", pose_file = folder_ + "/camera.csv";
  const YAML::Node root = load(camera_file);
  camera_ = camera_of(root, camera_file);
  const YAML::Node step = root["inverse_depth_step"];
  if (!step) throw Error("'inverse_depth_step' is missing", camera_file, remedy);
  inverse_depth_step_ = finite_number(step, camera_file, "inverse_depth_step");
  if (!(inverse_depth_step_ > 0.0)) throw Error("'inverse_depth_step' is not positive", camera_file, remedy);
  const std::string text = read_text_file(pose_file);
  for (const TextLine& line : content_lines(text)) poses_.push_back(pose_of(line, pose_file));
  if (poses_.empty()) throw Error("there are no poses", pose_file, remedy);
}

SurfaceGroundTruthReader::~SurfaceGroundTruthReader() = default;
SurfaceGroundTruthReader::SurfaceGroundTruthReader(SurfaceGroundTruthReader&&) noexcept = default;

const SurfaceGroundTruthReader::Images& SurfaceGroundTruthReader::images(std::int64_t frame) const {
  const auto known =
      std::find_if(kept_.begin(), kept_.end(), [&](const auto& images) { return images->frame == frame; });
  if (known != kept_.end()) {
    std::rotate(kept_.begin(), known, known + 1);
    return *kept_.front();
  }
  auto images = std::make_unique<Images>();
  images->frame = frame;
  const std::string name = std::to_string(poses_[static_cast<std::size_t>(frame)].stamp) + ".png";
  const auto read = [&](const std::string& file) {
    Image<std::uint16_t> image = read_raw_depth(file);
    if (image.width() != camera_.width || image.height() != camera_.height)
      throw Error("the image size is not that of camera.yaml", file, remedy);
    return image;
  };
  images->inverse_depth = read(folder_ + "/depth/" + name);
  images->surface = read(folder_ + "/surface/" + name);
  if (kept_.size() >= most_kept) kept_.pop_back();
  kept_.insert(kept_.begin(), std::move(images));
  return *kept_.front();
}

std::optional<RecordedSurfacePoint> SurfaceGroundTruthReader::surface_at(std::int64_t frame,
                                                                         const Eigen::Vector2d& pixel) const {
  return surface_near(frame, pixel, 0);
}

std::optional<RecordedSurfacePoint> SurfaceGroundTruthReader::corner_surface_at(std::int64_t frame,
                                                                                const Eigen::Vector2d& pixel) const {
  return surface_near(frame, pixel, 1);
}

/// The surface at the nearest pixel center, or the nearest surface up to `reach` pixels around it, continued as a
/// plane.
std::optional<RecordedSurfacePoint> SurfaceGroundTruthReader::surface_near(std::int64_t frame,
                                                                           const Eigen::Vector2d& pixel,
                                                                           int reach) const {
  if (frame < 0 || frame >= frame_count()) return std::nullopt;
  if (!(pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera_.width - 0.5 && pixel.y() < camera_.height - 0.5))
    return std::nullopt;
  const int x = static_cast<int>(std::floor(pixel.x() + 0.5)), y = static_cast<int>(std::floor(pixel.y() + 0.5));
  const std::optional<Eigen::Vector2d> ray = camera_.unproject(pixel);
  if (!ray) return std::nullopt;
  const Images& seen = images(frame);
  // On a plane the inverse depth changes linearly over the image.
  const auto steps_from = [&](int cx, int cy) {
    if (seen.inverse_depth.at(cx, cy) == 0) return 0.0;
    return seen.inverse_depth.at(cx, cy) + (pixel.x() - cx) * seen.slope(cx, cy, 1, 0) +
           (pixel.y() - cy) * seen.slope(cx, cy, 0, 1);
  };
  double steps = steps_from(x, y);
  std::uint32_t surface = seen.surface.at(x, y);
  for (int cy = std::max(0, y - reach); cy <= std::min(camera_.height - 1, y + reach); ++cy) {
    for (int cx = std::max(0, x - reach); cx <= std::min(camera_.width - 1, x + reach); ++cx) {
      constexpr double clearly_nearer = 1.02;
      if (steps_from(cx, cy) <= clearly_nearer * steps) continue;
      steps = steps_from(cx, cy);
      surface = seen.surface.at(cx, cy);
    }
  }
  if (!(steps >= 0.5)) return std::nullopt;
  const double depth = 1.0 / (steps * inverse_depth_step_);
  const SE3& pose = poses_[static_cast<std::size_t>(frame)].world_from_body;
  return RecordedSurfacePoint{pose * Eigen::Vector3d(ray->x() * depth, ray->y() * depth, depth), surface};
}

RecordedView SurfaceGroundTruthReader::view_of(std::int64_t frame, const Eigen::Vector3d& point_in_world) const {
  RecordedView view;
  if (frame < 0 || frame >= frame_count() || !point_in_world.allFinite()) return view;
  const Eigen::Vector3d point = poses_[static_cast<std::size_t>(frame)].world_from_body.inverse() * point_in_world;
  const std::optional<Eigen::Vector2d> pixel = camera_.project(point);
  if (!pixel || !(pixel->x() >= -0.5 && pixel->y() >= -0.5 && pixel->x() < camera_.width - 0.5 &&
                  pixel->y() < camera_.height - 0.5))
    return view;
  view.inside = true;
  view.pixel = *pixel;
  const int x = static_cast<int>(std::floor(pixel->x() + 0.5)), y = static_cast<int>(std::floor(pixel->y() + 0.5));
  const Images& seen = images(frame);
  const double nearest_allowed = 1.01 / (point.z() * inverse_depth_step_) + 1.0;
  for (int row = y - 1; row <= y + 1; ++row)
    for (int column = x - 1; column <= x + 1; ++column)
      view.visible = view.visible || (seen.holds(column, row) && seen.inverse_depth.at(column, row) <= nearest_allowed);
  return view;
}

SurfaceGroundTruthReader read_surface_ground_truth(const std::string& path) {
  for (const char* below : {"", "/truth", "/mav0/truth"}) {
    std::error_code error;
    if (std::filesystem::is_regular_file(path + below + "/camera.csv", error))
      return SurfaceGroundTruthReader(path + below);
  }
  throw Error("has no surface ground truth (mav0/truth/camera.csv)", path,
              "generate it with `rastro simulate`, without --no-ground-truth");
}

}  // namespace rastro
