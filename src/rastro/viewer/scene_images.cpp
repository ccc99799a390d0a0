// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "rastro/map/images/image_layer.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/viewer/scene_parts.h"

namespace rastro::detail {
namespace {

constexpr int longest_side_px = 240;

/// Means over squares of `factor` x `factor` pixels.
ColorImage reduced(const ColorImage& color, int factor) {
  ColorImage small;
  small.rgb = Image<std::uint8_t>(3 * (color.width() / factor), color.height() / factor);
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.rgb.width(); ++x) {
      int sum = factor * factor / 2;
      for (int row = 0; row < factor; ++row)
        for (int column = 0; column < factor; ++column)
          sum += color.rgb.at(3 * (x / 3 * factor + column) + x % 3, y * factor + row);
      small.rgb.at(x, y) = static_cast<std::uint8_t>(sum / (factor * factor));
    }
  }
  return small;
}

SceneImage small_image(const PackedImages& packed, std::uint32_t row) {
  Frame frame;
  const ColorImage color = unpack_images({packed.color, {}}, "images of the map").color;
  frame.color = reduced(color, 1 + (std::max(color.width(), color.height()) - 1) / longest_side_px);
  return {row, frame.color.width(), frame.color.height(), pack_images(frame).color};
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
      scene.images[k] = small_image(layer->store->read(id), row);
    }
  });
}

}  // namespace rastro::detail
