// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <optional>
#include <system_error>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/export/colmap.h"
#include "rastro/export/landmark_export.h"
#include "rastro/export/landmark_parts.h"
#include "rastro/export/raw_bytes.h"

namespace rastro {
namespace {

using detail::append_raw;
using Eigen::Vector3d;

constexpr double half_px = 0.5;  ///< COLMAP's upper left pixel has its center at (0.5, 0.5).
constexpr std::int64_t no_point = -1;
constexpr std::uint8_t unknown_color = 128;

struct ImagePoint {
  double x = 0.0, y = 0.0;
  std::int64_t point = no_point;
};

struct ModelImage {
  std::int64_t id = 0;
  int camera = 1;
  SE3 camera_from_world;
  std::string name;
  std::vector<ImagePoint> points;
};

struct ModelPoint {
  std::int64_t id = 0;
  Vector3d position = Vector3d::Zero();
  double error_px = 0.0;
  std::vector<std::pair<std::int64_t, std::uint32_t>> track;  ///< Image, and index of its point in there.
};

/// What both forms hold.
struct Model {
  std::vector<ModelImage> images;
  std::vector<ModelPoint> points;
};

/// COLMAP knows images by their names. Each recording numbers its frames from 0, and its files may be numbered another
/// way.
std::string name_of(const Map& map, const Keyframe& keyframe, const ColmapNames& names) {
  const auto given = names.find(keyframe.id);
  if (given != names.end()) return given->second;
  const std::string numbered = fmt::format("{:06}.png", keyframe.frame);
  const bool taken =
      std::any_of(names.begin(), names.end(), [&](const auto& named) { return named.second == numbered; });
  return map.sessions.size() > 1 || taken ? fmt::format("keyframe{}_{}", keyframe.id, numbered) : numbered;
}

/// Numbered on from 1: the id of a keyframe of a later session does not fit COLMAP's 32 bits.
ModelImage image_of(const Map& map, std::size_t index, const ImageFeatures* features, const ColmapNames& names) {
  const Keyframe& keyframe = map.keyframes[index];
  ModelImage image;
  image.id = static_cast<std::int64_t>(index) + 1;
  image.camera = keyframe.camera + 1;
  image.camera_from_world = keyframe.world_from_camera.inverse();
  image.name = name_of(map, keyframe, names);
  if (!features) return image;
  for (const Keypoint& point : features->features.keypoints)
    image.points.push_back({static_cast<double>(point.x) + half_px, static_cast<double>(point.y) + half_px, no_point});
  return image;
}

/// Images of keyframes, and where each keyframe's is.
struct ImageTable {
  std::vector<ModelImage> images;
  std::vector<std::size_t> of_keyframe;
};

ImageTable images_of_part(const Map& map, const LandmarkPart& part, const ColmapNames& names) {
  ImageTable table;
  table.of_keyframe.resize(map.keyframes.size());
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    if (!part.has_keyframe(k)) continue;
    table.of_keyframe[k] = table.images.size();
    table.images.push_back(image_of(map, k, part.features_of(map.keyframes[k].id), names));
  }
  return table;
}

/// A point that one image shows holds nothing that COLMAP could adjust; its bundle adjuster aborts on one.
constexpr std::size_t shortest_track = 2;

/// nullopt where too few images show the landmark.
std::optional<ModelPoint> point_of(const Map& map, const LandmarkPart& part, const Landmark& landmark,
                                   ImageTable& table) {
  ModelPoint point{landmark.id + 1, landmark.position, 0.0, {}};
  for (const LandmarkObservation& observation : landmark.observations) {
    const auto k = part.index_of(observation.keyframe);
    const Keypoint* at = k ? part.keypoint_of(observation) : nullptr;
    if (!at) continue;
    const ModelImage& image = table.images[table.of_keyframe[*k]];
    point.track.emplace_back(image.id, observation.feature);
    const Camera& camera = map.cameras[static_cast<std::size_t>(map.keyframes[*k].camera)].intrinsics;
    if (const auto pixel = camera.project(image.camera_from_world * landmark.position))
      point.error_px += (*pixel - Eigen::Vector2d(at->x, at->y)).norm();
  }
  if (point.track.size() < shortest_track) return std::nullopt;
  for (const LandmarkObservation& observation : landmark.observations)
    if (const auto k = part.index_of(observation.keyframe); k && part.keypoint_of(observation))
      table.images[table.of_keyframe[*k]].points[observation.feature].point = point.id;
  point.error_px /= static_cast<double>(point.track.size());
  return point;
}

Model model_of(const Map& map, int submap, const ColmapNames& names) {
  const LandmarkPart part(map, submap);
  ImageTable table = images_of_part(map, part, names);
  Model model;
  for (const Landmark& landmark : part.landmarks())
    if (auto point = point_of(map, part, landmark, table)) model.points.push_back(std::move(*point));
  model.images = std::move(table.images);
  return model;
}

std::string images_text(const Model& model) {
  std::string text = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (const ModelImage& image : model.images) {
    const Eigen::Quaterniond& q = image.camera_from_world.rotation().quaternion();
    const Vector3d& t = image.camera_from_world.translation();
    fmt::format_to(std::back_inserter(text), "{} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {} {}\n", image.id,
                   q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z(), image.camera, image.name);
    for (const ImagePoint& point : image.points)
      fmt::format_to(std::back_inserter(text), "{}{:.2f} {:.2f} {}", &point == image.points.data() ? "" : " ", point.x,
                     point.y, point.point);
    text += '\n';
  }
  return text;
}

std::string points_text(const Model& model) {
  std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (const ModelPoint& point : model.points) {
    fmt::format_to(std::back_inserter(text), "{} {:.9g} {:.9g} {:.9g} {} {} {} {:.3f}", point.id, point.position.x(),
                   point.position.y(), point.position.z(), unknown_color, unknown_color, unknown_color, point.error_px);
    for (const auto& [image, index] : point.track) fmt::format_to(std::back_inserter(text), " {} {}", image, index);
    text += '\n';
  }
  return text;
}

std::string cameras_bytes(const std::vector<MapCamera>& cameras) {
  std::string bytes;
  append_raw(bytes, static_cast<std::uint64_t>(cameras.size()));
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    const Camera& camera = cameras[k].intrinsics;
    const ColmapModel model = colmap_model(camera);
    append_raw(bytes, static_cast<std::uint32_t>(k + 1));
    append_raw(bytes, static_cast<std::int32_t>(model.id));
    append_raw(bytes, static_cast<std::uint64_t>(camera.width));
    append_raw(bytes, static_cast<std::uint64_t>(camera.height));
    for (const double value : model.parameters) append_raw(bytes, value);
  }
  return bytes;
}

std::string images_bytes(const Model& model) {
  std::string bytes;
  append_raw(bytes, static_cast<std::uint64_t>(model.images.size()));
  for (const ModelImage& image : model.images) {
    const Eigen::Quaterniond& q = image.camera_from_world.rotation().quaternion();
    const Vector3d& t = image.camera_from_world.translation();
    append_raw(bytes, static_cast<std::uint32_t>(image.id));
    for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) append_raw(bytes, value);
    append_raw(bytes, static_cast<std::uint32_t>(image.camera));
    bytes.append(image.name.c_str(), image.name.size() + 1);
    append_raw(bytes, static_cast<std::uint64_t>(image.points.size()));
    for (const ImagePoint& point : image.points) {
      append_raw(bytes, point.x);
      append_raw(bytes, point.y);
      append_raw(bytes, point.point);  // -1 in two's complement is COLMAP's mark for none
    }
  }
  return bytes;
}

std::string points_bytes(const Model& model) {
  std::string bytes;
  append_raw(bytes, static_cast<std::uint64_t>(model.points.size()));
  for (const ModelPoint& point : model.points) {
    append_raw(bytes, point.id);
    for (const double value : point.position) append_raw(bytes, value);
    for (int i = 0; i < 3; ++i) append_raw(bytes, unknown_color);
    append_raw(bytes, point.error_px);
    append_raw(bytes, static_cast<std::uint64_t>(point.track.size()));
    for (const auto& [image, index] : point.track) {
      append_raw(bytes, static_cast<std::uint32_t>(image));
      append_raw(bytes, index);
    }
  }
  return bytes;
}

}  // namespace

ColmapSize write_landmark_colmap(const Map& map, const std::filesystem::path& folder, ColmapForm form, int submap,
                                 const ColmapNames& names) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) throw Error("the folder cannot be made (" + code.message() + ")", folder.string(), "choose another --out");
  const Model model = model_of(map, submap, names);
  if (form == ColmapForm::text) {
    write_whole_file(folder / "cameras.txt", colmap_cameras(map.cameras));
    write_whole_file(folder / "images.txt", images_text(model));
    write_whole_file(folder / "points3D.txt", points_text(model));
  } else {
    write_whole_file(folder / "cameras.bin", cameras_bytes(map.cameras));
    write_whole_file(folder / "images.bin", images_bytes(model));
    write_whole_file(folder / "points3D.bin", points_bytes(model));
  }
  return {model.images.size(), model.points.size()};
}

}  // namespace rastro
