// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/colmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <system_error>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/images/pack_images.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;
constexpr double half_px = 0.5;  ///< COLMAP's upper left pixel has its center at (0.5, 0.5).

std::string image_name(std::size_t keyframe) { return fmt::format("{:06}.jpg", keyframe); }

/// Of a submap, those with an image: a map that was recovered may lack some.
std::vector<std::size_t> keyframes_of(const Map& map, int submap) {
  const auto images = map.layer<ImageLayer>();
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    const bool shown = !images || std::binary_search(images->keyframes.begin(), images->keyframes.end(), keyframe.id);
    if (shown && (submap < 0 || keyframe.submap == submap)) chosen.push_back(k);
  }
  return chosen;
}

/// Of a keyframe; none where the map has no features of it.
std::vector<Keypoint> keypoints_of(const FeatureLayer* features, KeyframeId id) {
  const ImageFeatures* image = features ? features->find(id) : nullptr;
  return image ? image->features.keypoints : std::vector<Keypoint>();
}

/// Colors of the features that show a point first, keyframe by keyframe, so that each image is read once.
std::vector<std::array<std::uint8_t, 3>> colors_of(const Map& map, const std::vector<FeaturePoint>& points) {
  const auto images = images_of(map);
  const auto features = map.layer<FeatureLayer>();
  std::map<std::size_t, std::vector<std::size_t>> by_keyframe;
  for (std::size_t k = 0; k < points.size(); ++k) by_keyframe[points[k].views.front().keyframe].push_back(k);
  std::vector<std::array<std::uint8_t, 3>> colors(points.size());
  for (const auto& [keyframe, shown] : by_keyframe) {
    const KeyframeId id = map.keyframes[keyframe].id;
    const ColorImage color = unpack_images(images->read(id), fmt::format("keyframe {}", id)).color;
    const std::vector<Keypoint> keypoints = keypoints_of(features.get(), id);
    for (const std::size_t k : shown) {
      const Keypoint& at = keypoints[points[k].views.front().feature];
      const int x = std::clamp(static_cast<int>(std::lround(at.x)), 0, color.width() - 1);
      const int y = std::clamp(static_cast<int>(std::lround(at.y)), 0, color.height() - 1);
      const std::uint8_t* rgb = color.rgb.row(y) + 3 * static_cast<std::ptrdiff_t>(x);
      colors[k] = {rgb[0], rgb[1], rgb[2]};
    }
  }
  return colors;
}

}  // namespace

ColmapModel colmap_model(const Camera& camera) {
  const auto& k = camera.coefficients;
  ColmapModel model{"PINHOLE", 1, {camera.fx, camera.fy, camera.cx + half_px, camera.cy + half_px}};
  if (camera.distortion == Distortion::none) return model;
  model.parameters.insert(model.parameters.end(), k.begin(), k.begin() + 4);
  if (camera.distortion == Distortion::equidistant) {
    model.name = "OPENCV_FISHEYE", model.id = 5;
  } else if (camera.coefficient_count() == 4) {
    model.name = "OPENCV", model.id = 4;
  } else {
    model.name = "FULL_OPENCV", model.id = 6;
    model.parameters.insert(model.parameters.end(), {k[4], k[5], k[6], k[7]});
  }
  return model;
}

std::string colmap_cameras(const std::vector<MapCamera>& cameras, int width, int height) {
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    const Camera& camera = cameras[k].intrinsics;
    const ColmapModel model = colmap_model(camera);
    const bool sized = camera.width > 0;
    text += fmt::format("{} {} {} {}", k + 1, model.name, sized ? camera.width : width, sized ? camera.height : height);
    for (const double value : model.parameters) text += fmt::format(" {:.9g}", value);
    text += '\n';
  }
  return text;
}

std::string colmap_images(const Map& map, const std::vector<FeaturePoint>& points, int submap) {
  const auto layer = map.layer<FeatureLayer>();
  std::vector<std::map<std::size_t, std::size_t>> point_of(map.keyframes.size());
  for (std::size_t k = 0; k < points.size(); ++k)
    for (const FeatureView& view : points[k].views) point_of[view.keyframe][view.feature] = k + 1;
  std::string text = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (const std::size_t k : keyframes_of(map, submap)) {
    const SE3 pose = map.keyframes[k].world_from_camera.inverse();
    const Eigen::Quaterniond& q = pose.rotation().quaternion();
    const Eigen::Vector3d& t = pose.translation();
    fmt::format_to(std::back_inserter(text), "{} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {} {}\n", k + 1,
                   q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z(), map.keyframes[k].camera + 1, image_name(k));
    const std::vector<Keypoint> features = keypoints_of(layer.get(), map.keyframes[k].id);
    for (std::size_t f = 0; f < features.size(); ++f) {
      const auto point = point_of[k].find(f);
      const std::int64_t id = point == point_of[k].end() ? -1 : static_cast<std::int64_t>(point->second);
      fmt::format_to(std::back_inserter(text), "{}{:.2f} {:.2f} {}", f == 0 ? "" : " ",
                     static_cast<double>(features[f].x) + half_px, static_cast<double>(features[f].y) + half_px, id);
    }
    text += '\n';
  }
  return text;
}

std::string colmap_points(const Map& map, const std::vector<FeaturePoint>& points) {
  const auto colors = colors_of(map, points);
  std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (std::size_t k = 0; k < points.size(); ++k) {
    const FeaturePoint& point = points[k];
    const Eigen::Vector3d& p = point.position;
    fmt::format_to(std::back_inserter(text), "{} {:.9g} {:.9g} {:.9g} {} {} {} {:.3f}", k + 1, p.x(), p.y(), p.z(),
                   colors[k][0], colors[k][1], colors[k][2], point.error_px);
    for (const FeatureView& view : point.views)
      fmt::format_to(std::back_inserter(text), " {} {}", view.keyframe + 1, view.feature);
    text += '\n';
  }
  return text;
}

std::size_t write_colmap(const Map& map, const fs::path& folder, int submap) {
  std::error_code code;
  fs::create_directories(folder / "images", code);
  if (code) throw Error("the folder cannot be made (" + code.message() + ")", folder.string(), "choose another --out");
  const auto images = images_of(map);
  RASTRO_CHECK(images, "a map with images");
  int width = camera_of(map, "colmap").intrinsics.width, height = map.cameras.front().intrinsics.height;
  const std::vector<std::size_t> keyframes = keyframes_of(map, submap);
  for (const std::size_t k : keyframes) {
    const PackedImages packed = images->read(map.keyframes[k].id);
    if (width == 0) {
      const DepthImage depth = unpack_depth(packed, fmt::format("keyframe {}", k));
      width = depth.width(), height = depth.height();
    }
    write_whole_file(folder / "images" / image_name(k),
                     {reinterpret_cast<const char*>(packed.color.data()), packed.color.size()});
  }
  const std::vector<FeaturePoint> points = feature_points(map, submap);
  write_whole_file(folder / "cameras.txt", colmap_cameras(map.cameras, width, height));
  write_whole_file(folder / "images.txt", colmap_images(map, points, submap));
  write_whole_file(folder / "points3D.txt", colmap_points(map, points));
  return keyframes.size();
}

}  // namespace rastro
