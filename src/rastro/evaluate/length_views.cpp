// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/map/keyframe/pack_pictures.h"

namespace rastro {
namespace {

constexpr double nearest_m = 0.35, farthest_m = 6.0;
constexpr double margin_px = 8.0;
constexpr double flattest = 0.1;  ///< Cosine between normal and ray; flatter faces are not measured.
constexpr std::int64_t neighbourhood = 3;

/// Pixels per metre of the place, seen squarely; 0 where it is not seen.
double quality(const RgbdMap& map, std::size_t keyframe, const LengthPlace& place) {
  const Eigen::Vector3d point = map.poses[keyframe].world_from_camera.inverse() * place.point;
  if (!(point.z() > nearest_m && point.z() < farthest_m)) return 0.0;
  const auto pixel = map.camera.project(point);
  if (!pixel || pixel->x() < margin_px || pixel->y() < margin_px || pixel->x() > map.camera.width - 1 - margin_px ||
      pixel->y() > map.camera.height - 1 - margin_px) {
    return 0.0;
  }
  double squareness = 1.0;
  if (place.normal) {
    const Eigen::Vector3d normal = map.poses[keyframe].world_from_camera.rotation().inverse() * *place.normal;
    squareness = std::abs(normal.dot(point)) / point.norm();
    if (squareness < flattest) return 0.0;
  }
  return map.camera.fx / point.z() * squareness;
}

/// Greedy: the best one, then the best of the rest, those near a chosen one losing with each.
void choose(std::vector<double> qualities, int count, std::vector<bool>& chosen) {
  for (int taken = 0; taken < count; ++taken) {
    const auto best = std::max_element(qualities.begin(), qualities.end());
    if (best == qualities.end() || *best <= 0.0) return;
    const auto index = std::distance(qualities.begin(), best);
    chosen[static_cast<std::size_t>(index)] = true;
    *best = 0.0;
    for (std::int64_t other = index - neighbourhood; other <= index + neighbourhood; ++other)
      if (other >= 0 && other < std::ssize(qualities)) qualities[static_cast<std::size_t>(other)] *= 0.8;
  }
}

}  // namespace

std::vector<std::int64_t> choose_views(const RgbdMap& map, const LengthPlace& a, const LengthPlace& b, int count) {
  const std::size_t keyframes = std::min(map.keyframes.size(), map.poses.size());
  std::vector<double> sees_a(keyframes), sees_b(keyframes), sees_both(keyframes);
  for (std::size_t i = 0; i < keyframes; ++i) {
    if (map.poses[i].submap != 0) continue;
    sees_a[i] = quality(map, i, a);
    sees_b[i] = quality(map, i, b);
    sees_both[i] = std::min(sees_a[i], sees_b[i]);
  }
  std::vector<bool> chosen(keyframes, false);
  for (const auto* qualities : {&sees_a, &sees_b, &sees_both}) choose(*qualities, count, chosen);
  std::vector<std::int64_t> numbers;
  for (std::size_t i = 0; i < keyframes; ++i)
    if (chosen[i]) numbers.push_back(static_cast<std::int64_t>(i));
  return numbers;
}

LengthView open_view(const RgbdMap& map, std::int64_t keyframe) {
  const auto index = static_cast<std::size_t>(keyframe);
  RASTRO_CHECK(map.pictures && index < map.poses.size() && index < map.keyframes.size(), "a keyframe of the map");
  const std::string where = fmt::format("keyframe {}", keyframe);
  const UnpackedPictures pictures = unpack_pictures(map.pictures->pictures(keyframe), where);
  if (pictures.depth.width() != map.camera.width || pictures.depth.height() != map.camera.height)
    throw Error(fmt::format("its pictures are {} x {}, the map's camera {} x {}", pictures.depth.width(),
                            pictures.depth.height(), map.camera.width, map.camera.height),
                where, "the map is damaged");
  return {keyframe,
          map.poses[index].world_from_camera,
          map.camera,
          grey_from_colour(pictures.colour),
          pictures.depth,
          map.depth_sigma_m,
          map.depth_sigma_per_m2};
}

}  // namespace rastro
