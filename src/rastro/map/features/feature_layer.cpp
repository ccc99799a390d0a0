// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/features/feature_layer.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/map/file/bytes.h"
#include "rastro/map/file/feature_bytes.h"

namespace rastro {
namespace {

bool is_described(const Features& features) {
  const std::size_t count = features.size();
  const bool descriptors = features.descriptors.size() == (features.binary() ? count : 0);
  const bool levels = features.levels.empty() || features.levels.size() == count;
  return descriptors && levels && features.floats.size() == count * static_cast<std::size_t>(features.length);
}

/// One per feature, or none.
bool fits(const std::vector<float>& values, std::size_t features) {
  return values.empty() || values.size() == features;
}

class FeatureLayerType : public KeyframeLayerType<FeatureLayer, ImageFeatures> {
 public:
  std::string header(const Layer& layer) const override {
    ByteWriter bytes;
    put(bytes, typed(layer).extraction);
    return bytes.take();
  }
  std::shared_ptr<Layer> make(std::string_view header, const std::string& where) const override {
    ByteReader bytes(header, where);
    auto layer = std::make_shared<FeatureLayer>();
    layer->extraction = get_orb_options(bytes);
    bytes.finish();
    return layer;
  }

  std::string body_of(const ImageFeatures& image) const override {
    ByteWriter bytes;
    put(bytes, image);
    return bytes.take();
  }
  std::shared_ptr<const ImageFeatures> thing_of(KeyframeId id, std::string_view body,
                                                const std::string& where) const override {
    ByteReader bytes(body, where);
    const auto image = get_image_features(bytes);
    image->id = id;
    bytes.finish();
    return image;
  }

  std::string contradiction(const Map& map, const Layer& layer) const override {
    const int levels = typed(layer).extraction.levels;
    for (const auto& [id, image] : typed(layer).of) {
      if (!is_described(image->features)) return "has a keyframe whose features are not all described";
      const std::size_t count = image->features.size();
      if (!fits(image->right_x, count) || !fits(image->depths, count))
        return "has a keyframe with depths for some of its features only";
      const auto& of = image->features.levels;
      if (std::any_of(of.begin(), of.end(), [&](int level) { return level >= levels; }))
        return "has a feature of a level that there is not";
    }
    return KeyframeLayerType::contradiction(map, layer);
  }
  std::shared_ptr<const Layer> repaired(const Map& map, const std::shared_ptr<const Layer>& layer) const override {
    const int levels = typed(*layer).extraction.levels;
    auto kept = std::make_shared<FeatureLayer>(typed(*layer));
    std::erase_if(kept->of, [&](const auto& each) {
      const ImageFeatures& image = *each.second;
      const auto& of = image.features.levels;
      return !map.index_of(each.first) || !is_described(image.features) ||
             !fits(image.right_x, image.features.size()) || !fits(image.depths, image.features.size()) ||
             std::any_of(of.begin(), of.end(), [&](int level) { return level >= levels; });
    });
    return kept;
  }

  std::shared_ptr<const ImageFeatures> with_id(const std::shared_ptr<const ImageFeatures>& image,
                                               KeyframeId id) const override {
    return rastro::with_id(*image, id);
  }

  LayerDescription describe(const Map&, const Layer& layer) const override {
    std::size_t count = 0;
    for (const auto& [id, image] : typed(layer).of) count += image->features.size();
    return {fmt::format("{} features in {} keyframes", count, typed(layer).of.size()),
            {{"features", static_cast<double>(count)}}};
  }
};

}  // namespace

std::shared_ptr<const ImageFeatures> with_id(const ImageFeatures& image, KeyframeId id) {
  auto copy = std::make_shared<ImageFeatures>(image);
  copy->id = id;
  return copy;
}

std::unique_ptr<LayerType> features_layer_type() { return std::make_unique<FeatureLayerType>(); }

}  // namespace rastro
