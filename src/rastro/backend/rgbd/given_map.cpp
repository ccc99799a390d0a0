// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/given_map.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/backend/map_camera.h"
#include "rastro/backend/rgbd/keyframe_graph.h"
#include "rastro/base/error.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/graph/edit.h"
#include "rastro/map/images/image_layer.h"

namespace rastro {
namespace {

/// SIFT has 128 numbers, SURF 64; the others have bits.
void check_descriptor(const Features& features, const std::string& descriptor) {
  const int length = descriptor == "sift" ? 128 : descriptor == "surf" ? 64 : 0;
  if (features.size() == 0 || features.length == length) return;
  const std::string made_with = features.length == 128 ? "sift" : features.length == 64 ? "surf" : "orb or even_orb";
  throw Error(fmt::format("has features that cannot be compared with those of descriptor={}", descriptor), "--map",
              fmt::format("give --set descriptor={}, or a map made with descriptor={}", made_with, descriptor));
}

bool has_signatures_of_all(const Map& map) {
  const auto signatures = map.layer<SignatureLayer>();
  return signatures && signatures->keyframes.size() == map.keyframes.size();
}

/// Of a map that has features instead, as one of `rgbd`.
std::shared_ptr<const SignatureLayer> all_signatures(const Map& map) {
  auto layer = std::make_shared<SignatureLayer>();
  auto store = std::make_shared<MemorySignatures>();
  for (const Keyframe& keyframe : map.keyframes) {
    store->add(keyframe.id, signature_of(map, keyframe.id));
    layer->keyframes.push_back(keyframe.id);
  }
  layer->store = std::move(store);
  return layer;
}

}  // namespace

Map base_map(const std::string& method, const RgbdSlamOptions& options, const Camera& camera, double baseline) {
  Map map;
  map.method = method;
  const DepthNoise noise{options.follow.depth_sigma_m, options.follow.depth_sigma_per_m2};
  const bool pair = baseline > 0.0;
  map.cameras.push_back({pair ? CameraKind::stereo : CameraKind::depth, camera, baseline, noise, SE3()});
  map.sessions.push_back({0, 0, "", 0, 0, {true, 0.0, pair ? "stereo baseline" : "depth camera"}});
  return map;
}

SlamContext with_usable_map(SlamContext context, const Camera& camera, const RgbdSlamOptions& options) {
  if (!context.map) return context;
  // The rays of its features and the blocks of its surfaces are computed with the camera of this run.
  require_camera_of_map(camera_of(*context.map, "--map").intrinsics, camera);
  auto map = std::make_shared<Map>(renumbered(*context.map));
  const auto images = map->layer<ImageLayer>();
  auto features = std::make_shared<FeatureLayer>();
  for (const Keyframe& keyframe : map->keyframes) {
    const auto image = signature_of(*map, keyframe.id).image;
    const bool has_images =
        images && std::binary_search(images->keyframes.begin(), images->keyframes.end(), keyframe.id);
    if (!image || !has_images || image->depths.size() != image->features.size())
      throw Error("has keyframes without features, their depths or depth images", "--map",
                  "give a map made by --method rgbd or rtabmap");
    check_descriptor(image->features, options.descriptor);
    features->of[keyframe.id] = context.extend_map ? without_features(*image) : image;
  }
  if (context.extend_map && !has_signatures_of_all(*map)) map->layers.put<SignatureLayer>(all_signatures(*map));
  map->layers.put<FeatureLayer>(std::move(features));
  context.map = std::move(map);
  return context;
}

Signature signature_of(const Map& map, KeyframeId id) {
  const auto signatures = map.layer<SignatureLayer>();
  if (signatures && std::binary_search(signatures->keyframes.begin(), signatures->keyframes.end(), id)) {
    Signature signature = signatures->store->read(id);
    signature.image = with_id(*signature.image, id);
    return signature;
  }
  const auto features = map.layer<FeatureLayer>();
  const auto found = features ? features->of.find(id) : decltype(features->of.end()){};
  if (!features || found == features->of.end()) return {};
  return {found->second, {}};
}

}  // namespace rastro
