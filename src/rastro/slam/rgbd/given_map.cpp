// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/given_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/graph/edit.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {
namespace {

/// The rays of its features and the blocks of its surfaces are computed with the camera of this run.
void check_camera(const Camera& other, const Camera& camera) {
  constexpr double most_share = 0.01;  // of the width: calibrations of the same camera differ by less
  const double most_px = most_share * camera.width;
  const double difference_px = std::max({std::abs(other.fx - camera.fx), std::abs(other.fy - camera.fy),
                                         std::abs(other.cx - camera.cx), std::abs(other.cy - camera.cy)});
  if (other.width == camera.width && other.height == camera.height && difference_px <= most_px) return;
  throw Error(fmt::format("was made by another camera ({} x {} pixels, focal length {:.1f} px)", other.width,
                          other.height, other.fx),
              "--map",
              fmt::format("this run has {} x {} pixels, focal length {:.1f} px: give a map of the same camera",
                          camera.width, camera.height, camera.fx));
}

}  // namespace

Map base_map(const RgbdSlamOptions& options, const Camera& camera) {
  Map map;
  map.method = "rgbd";
  const DepthNoise noise{options.follow.depth_sigma_m, options.follow.depth_sigma_per_m2};
  map.cameras.push_back({CameraKind::depth, camera, 0.0, noise, SE3()});
  map.sessions.push_back({0, 0, "", 0, 0, {true, 0.0, "depth camera"}});
  return map;
}

SlamContext with_usable_map(SlamContext context, const Camera& camera) {
  if (!context.map) return context;
  const Map& map = *context.map;
  check_camera(camera_of(map, "--map").intrinsics, camera);
  const auto features = map.layer<FeatureLayer>();
  const auto images = map.layer<ImageLayer>();
  for (const Keyframe& keyframe : map.keyframes) {
    const ImageFeatures* image = features ? features->find(keyframe.id) : nullptr;
    const bool has_images =
        images && std::binary_search(images->keyframes.begin(), images->keyframes.end(), keyframe.id);
    if (!image || !has_images || image->depths.size() != image->features.size())
      throw Error("has keyframes without features, their depths or depth images", "--map",
                  "give a map made by --method rgbd");
  }
  context.map = std::make_shared<const Map>(renumbered(map));
  return context;
}

}  // namespace rastro
