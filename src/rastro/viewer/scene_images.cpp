// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "rastro/map/images/image_layer.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/viewer/scene_parts.h"
#include "rastro/viewer/small_image.h"

namespace rastro::detail {
namespace {

constexpr int longest_side_px = 240;

SceneImage image_of(const PackedImages& packed, std::uint32_t row) {
  Frame frame;
  frame.color = unpack_images({packed.color, {}}, "images of the map").color;
  SceneImage image = small_image(frame, longest_side_px);
  image.keyframe = row;
  return image;
}

}  // namespace

void add_images(const SceneJob& job, ViewScene& scene) {
  const auto layer = job.map.layer<ImageLayer>();
  if (!layer || job.options.max_images == 0) return;
  std::vector<std::pair<KeyframeId, std::uint32_t>> there;
  for (const KeyframeId id : layer->keyframes)
    if (const auto row = job.rows.row_of(job.map, id)) there.emplace_back(id, *row);
  const std::vector<std::size_t> chosen = evenly(there.size(), job.options.max_images);
  scene.images.resize(chosen.size());
  job.pool.for_chunks(0, static_cast<int>(chosen.size()), 1, [&](int begin, int end) {
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
      const auto& [id, row] = there[chosen[k]];
      scene.images[k] = image_of(layer->store->read(id), row);
    }
  });
}

}  // namespace rastro::detail
