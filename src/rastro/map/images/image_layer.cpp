// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/image_layer.h"

#include <fmt/format.h>

#include "rastro/map/file/bytes.h"
#include "rastro/map/file/image_bytes.h"

namespace rastro {
namespace {

class ImageLayerType : public StoredLayerType<ImageLayer, PackedImages> {
 public:
  std::string body_of(const PackedImages& images) const override { return rastro::body_of(images); }
  PackedImages item_of(std::string_view body, const std::string& where) const override {
    return read_images(body, where);
  }
  LayerDescription describe(const Map&, const Layer& layer) const override {
    const std::size_t count = typed(layer).keyframes.size();
    return {fmt::format("color and depth of {} keyframes", count), {{"images", static_cast<double>(count)}}};
  }
};

std::vector<std::uint8_t> get_bytes(ByteReader& bytes) {
  const std::string_view piece = bytes.text();
  return {piece.begin(), piece.end()};
}

}  // namespace

std::string body_of(const PackedImages& images) {
  ByteWriter bytes;
  for (const auto* image : {&images.color, &images.depth})
    bytes.put_text({reinterpret_cast<const char*>(image->data()), image->size()});
  return bytes.take();
}

PackedImages read_images(std::string_view body, const std::string& where) {
  ByteReader bytes(body, where);
  PackedImages images;
  images.color = get_bytes(bytes);
  images.depth = get_bytes(bytes);
  bytes.finish();
  return images;
}

std::shared_ptr<const ImageStore> images_of(const Map& map) {
  const auto layer = map.layer<ImageLayer>();
  return layer ? layer->store : nullptr;
}

std::unique_ptr<LayerType> images_layer_type() { return std::make_unique<ImageLayerType>(); }

}  // namespace rastro
