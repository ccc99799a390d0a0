// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/image_layer.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/map/file/bytes.h"
#include "rastro/map/file/image_bytes.h"
#include "rastro/map/images/pack_images.h"

namespace rastro {
namespace {

const ImageLayer& typed(const Layer& layer) { return static_cast<const ImageLayer&>(layer); }

/// Images that stay in a map file.
class StoredImages : public ImageStore {
 public:
  explicit StoredImages(std::shared_ptr<const RowStore> rows) : rows_(std::move(rows)) {}
  PackedImages images(KeyframeId keyframe) const override {
    return read_images(rows_->row(keyframe), fmt::format("images of keyframe {}", keyframe));
  }

 private:
  std::shared_ptr<const RowStore> rows_;
};

/// The same images under other ids.
class RenumberedImages : public ImageStore {
 public:
  RenumberedImages(std::shared_ptr<const ImageStore> images, std::map<KeyframeId, KeyframeId> old_id)
      : images_(std::move(images)), old_id_(std::move(old_id)) {}
  PackedImages images(KeyframeId keyframe) const override { return images_->images(old_id_.at(keyframe)); }

 private:
  std::shared_ptr<const ImageStore> images_;
  std::map<KeyframeId, KeyframeId> old_id_;
};

/// A store with the images of one additional keyframe.
class ImagesAndOne : public ImageStore {
 public:
  ImagesAndOne(std::shared_ptr<const ImageStore> others, KeyframeId id, PackedImages own)
      : others_(std::move(others)), id_(id), own_(std::move(own)) {}
  PackedImages images(KeyframeId keyframe) const override {
    return keyframe == id_ || !others_ ? own_ : others_->images(keyframe);
  }

 private:
  std::shared_ptr<const ImageStore> others_;
  KeyframeId id_;
  PackedImages own_;
};

class ImageLayerType : public LayerType {
 public:
  std::string name() const override { return ImageLayer::layer_name; }
  std::vector<std::int64_t> rows(const Map&, const Layer& layer) const override { return typed(layer).keyframes; }
  std::string row(const Layer& layer, std::int64_t id) const override {
    return body_of(typed(layer).store->images(id));
  }
  bool same_row(const Layer&, const Layer&, std::int64_t) const override { return true; }
  bool stays_in_file() const override { return true; }

  std::shared_ptr<Layer> make(std::string_view, const std::string&) const override {
    auto layer = std::make_shared<ImageLayer>();
    layer->store = std::make_shared<MemoryImages>();
    return layer;
  }
  void attach(Layer& layer, std::shared_ptr<const RowStore> rows) const override {
    static_cast<ImageLayer&>(layer).store = std::make_shared<StoredImages>(std::move(rows));
  }
  /// With an attached file, only the id is used.
  void read(Layer& layer, std::int64_t id, std::string_view body, const std::string& where) const override {
    auto& images = static_cast<ImageLayer&>(layer);
    images.keyframes.push_back(id);
    if (body.empty()) return;
    const auto memory = std::dynamic_pointer_cast<const MemoryImages>(images.store);
    if (memory) std::const_pointer_cast<MemoryImages>(memory)->add(id, read_images(body, where));
  }

  std::string contradiction(const Map& map, const Layer& layer) const override {
    const std::vector<KeyframeId>& keyframes = typed(layer).keyframes;
    if (!std::is_sorted(keyframes.begin(), keyframes.end())) return "has images out of order";
    for (const KeyframeId id : keyframes)
      if (!map.index_of(id)) return "has images of a keyframe that is not there";
    return {};
  }
  std::shared_ptr<const Layer> repaired(const Map& map, const std::shared_ptr<const Layer>& layer) const override {
    auto kept = std::make_shared<ImageLayer>(typed(*layer));
    std::erase_if(kept->keyframes, [&](KeyframeId id) { return !map.index_of(id); });
    return kept;
  }
  LayerDescription describe(const Map&, const Layer& layer) const override {
    const std::size_t count = typed(layer).keyframes.size();
    return {fmt::format("color and depth of {} keyframes", count), {{"images", static_cast<double>(count)}}};
  }

  LayerCut cut(const Layer& layer, KeyframeId id) const override {
    auto rest = std::make_shared<ImageLayer>(typed(layer));
    const bool there = std::erase(rest->keyframes, id) > 0;
    return {std::move(rest), there ? row(layer, id) : std::string()};
  }
  std::shared_ptr<const Layer> paste(const Layer& layer, KeyframeId id, std::string_view bytes) const override {
    auto whole = std::make_shared<ImageLayer>(typed(layer));
    if (bytes.empty()) return whole;
    whole->store = std::make_shared<ImagesAndOne>(whole->store, id, read_images(bytes, name()));
    const auto at = std::lower_bound(whole->keyframes.begin(), whole->keyframes.end(), id);
    if (at == whole->keyframes.end() || *at != id) whole->keyframes.insert(at, id);
    return whole;
  }

  std::shared_ptr<const Layer> renumbered(const std::shared_ptr<const Layer>& layer,
                                          const std::map<KeyframeId, KeyframeId>& new_id) const override {
    auto result = std::make_shared<ImageLayer>(typed(*layer));
    std::map<KeyframeId, KeyframeId> old_id;
    for (KeyframeId& id : result->keyframes) {
      old_id[new_id.at(id)] = id;
      id = new_id.at(id);
    }
    result->store = std::make_shared<RenumberedImages>(result->store, std::move(old_id));
    return result;
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
