// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/map/images/pack_images.h"

namespace rastro {
namespace {

constexpr double nearest_m = 0.35, farthest_m = 6.0;
constexpr double margin_px = 8.0;
constexpr double flattest = 0.1;  ///< Cosine between normal and ray; faces at a smaller angle are not measured.
constexpr std::int64_t neighborhood = 3;

/// Pixels per meter at the point, corrected for the viewing angle; 0 if not visible.
double quality(const Map& map, const Keyframe& keyframe, const LengthPosition& position) {
  const Camera& camera = map.cameras[static_cast<std::size_t>(keyframe.camera)].intrinsics;
  const Eigen::Vector3d point = keyframe.world_from_camera.inverse() * position.point;
  if (!(point.z() > nearest_m && point.z() < farthest_m)) return 0.0;
  const auto pixel = camera.project(point);
  if (!pixel || pixel->x() < margin_px || pixel->y() < margin_px || pixel->x() > camera.width - 1 - margin_px ||
      pixel->y() > camera.height - 1 - margin_px) {
    return 0.0;
  }
  double squareness = 1.0;
  if (position.normal) {
    const Eigen::Vector3d normal = keyframe.world_from_camera.rotation().inverse() * *position.normal;
    squareness = std::abs(normal.dot(point)) / point.norm();
    if (squareness < flattest) return 0.0;
  }
  return camera.fx / point.z() * squareness;
}

/// Greedy: the best one, then the best of the rest; those near a selected one lose score.
void choose(std::vector<double> qualities, int count, std::vector<bool>& chosen) {
  for (int taken = 0; taken < count; ++taken) {
    const auto best = std::max_element(qualities.begin(), qualities.end());
    if (best == qualities.end() || *best <= 0.0) return;
    const auto index = std::distance(qualities.begin(), best);
    chosen[static_cast<std::size_t>(index)] = true;
    *best = 0.0;
    for (std::int64_t other = index - neighborhood; other <= index + neighborhood; ++other)
      if (other >= 0 && other < std::ssize(qualities)) qualities[static_cast<std::size_t>(other)] *= 0.8;
  }
}

}  // namespace

std::vector<KeyframeId> choose_views(const Map& map, const LengthPosition& a, const LengthPosition& b, int count) {
  const std::size_t keyframes = map.cameras.empty() ? 0 : map.keyframes.size();
  std::vector<double> sees_a(keyframes), sees_b(keyframes), sees_both(keyframes);
  for (std::size_t i = 0; i < keyframes; ++i) {
    if (map.keyframes[i].submap != 0) continue;
    sees_a[i] = quality(map, map.keyframes[i], a);
    sees_b[i] = quality(map, map.keyframes[i], b);
    sees_both[i] = std::min(sees_a[i], sees_b[i]);
  }
  std::vector<bool> chosen(keyframes, false);
  for (const auto* qualities : {&sees_a, &sees_b, &sees_both}) choose(*qualities, count, chosen);
  std::vector<KeyframeId> ids;
  for (std::size_t i = 0; i < keyframes; ++i)
    if (chosen[i]) ids.push_back(map.keyframes[i].id);
  return ids;
}

LengthView open_view(const Map& map, KeyframeId id) {
  const Keyframe* keyframe = map.find(id);
  const auto images = images_of(map);
  RASTRO_CHECK(images && keyframe && !map.cameras.empty(), "a keyframe with images");
  const MapCamera& camera = map.cameras[static_cast<std::size_t>(keyframe->camera)];
  const std::string where = fmt::format("keyframe {}", id);
  const UnpackedImages unpacked = unpack_images(images->read(id), where);
  if (unpacked.depth.width() != camera.intrinsics.width || unpacked.depth.height() != camera.intrinsics.height)
    throw Error(fmt::format("its images are {} x {}, the map's camera {} x {}", unpacked.depth.width(),
                            unpacked.depth.height(), camera.intrinsics.width, camera.intrinsics.height),
                where, "the map is damaged");
  return {id,
          keyframe->world_from_camera,
          camera.intrinsics,
          gray_from_color(unpacked.color),
          unpacked.depth,
          camera.depth_noise.sigma_m,
          camera.depth_noise.sigma_per_m2};
}

}  // namespace rastro
