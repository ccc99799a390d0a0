// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/semi_dense/semi_dense_layer.h"

#include <fmt/format.h>

#include <cmath>

#include "rastro/map/file/bytes.h"

namespace rastro {
namespace {

class SemiDenseLayerType : public KeyframeLayerType<SemiDenseLayer, SemiDenseDepth> {
 public:
  std::string body_of(const SemiDenseDepth& depth) const override {
    ByteWriter bytes;
    bytes.put(static_cast<std::uint32_t>(depth.pixels.size()));
    for (const SemiDenseDepth::Pixel& pixel : depth.pixels) {
      bytes.put(pixel.x);
      bytes.put(pixel.y);
      bytes.put(pixel.inverse_depth);
      bytes.put(pixel.variance);
      bytes.put(pixel.intensity);
    }
    return bytes.take();
  }
  std::shared_ptr<const SemiDenseDepth> thing_of(KeyframeId, std::string_view body,
                                                 const std::string& where) const override {
    constexpr std::size_t pixel_size = 2 * sizeof(std::uint16_t) + 2 * sizeof(float) + 1;
    ByteReader bytes(body, where);
    auto depth = std::make_shared<SemiDenseDepth>();
    depth->pixels.resize(bytes.count(pixel_size));
    for (SemiDenseDepth::Pixel& pixel : depth->pixels) {
      pixel.x = bytes.get<std::uint16_t>();
      pixel.y = bytes.get<std::uint16_t>();
      pixel.inverse_depth = bytes.get<float>();
      pixel.variance = bytes.get<float>();
      pixel.intensity = bytes.get<std::uint8_t>();
      bytes.check(pixel.inverse_depth > 0.0F && pixel.variance >= 0.0F);
    }
    bytes.finish();
    return depth;
  }

  LayerDescription describe(const Map&, const Layer& layer) const override {
    std::size_t count = 0;
    for (const auto& [id, depth] : typed(layer).of) count += depth->pixels.size();
    return {fmt::format("semi-dense depth of {} pixels in {} keyframes", count, typed(layer).of.size()),
            {{"semi_dense_pixels", static_cast<double>(count)}}};
  }

  void add_points(const Map& map, const Layer& layer, int submap, std::size_t most, PointCloud& cloud) const override {
    const auto keyframe_of = [&](KeyframeId id) {
      const Keyframe* keyframe = map.cameras.empty() ? nullptr : map.find(id);
      return keyframe && (submap < 0 || keyframe->submap == submap) ? keyframe : nullptr;
    };
    std::size_t pixels = 0;
    for (const auto& [id, depth] : typed(layer).of) pixels += keyframe_of(id) ? depth->pixels.size() : 0;
    const std::size_t step = 1 + (pixels > 0 ? (pixels - 1) / std::max<std::size_t>(1, most) : 0);
    for (const auto& [id, depth] : typed(layer).of) {
      const Keyframe* keyframe = keyframe_of(id);
      if (!keyframe) continue;
      const Camera& camera = map.cameras[static_cast<std::size_t>(keyframe->camera)].intrinsics;
      for (std::size_t k = 0; k < depth->pixels.size(); k += step) {
        const SemiDenseDepth::Pixel& pixel = depth->pixels[k];
        constexpr float most_relative_sigma = 0.1F;
        const float most = most_relative_sigma * pixel.inverse_depth;
        const auto ray = camera.unproject({pixel.x, pixel.y});
        if (!ray || pixel.variance > most * most) continue;
        const double z = 1.0 / static_cast<double>(pixel.inverse_depth);
        CloudPoint point;
        point.position = (keyframe->world_from_camera * Eigen::Vector3d(z * ray->x(), z * ray->y(), z)).cast<float>();
        point.color = {pixel.intensity, pixel.intensity, pixel.intensity};
        point.count = 1;
        point.sigma = static_cast<float>(z * z * std::sqrt(static_cast<double>(pixel.variance)));
        cloud.points.push_back(point);
      }
    }
  }
};

}  // namespace

std::unique_ptr<LayerType> semi_dense_layer_type() { return std::make_unique<SemiDenseLayerType>(); }

}  // namespace rastro
