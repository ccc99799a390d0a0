// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "rastro/map/images/pack_images.h"
#include "rastro/map/signatures/signature_layer.h"

namespace rastro {

/// Makes a map of locations with the words given, image by image; feature k is at pixel (20 + 30 k, 40 + 10 id).
class WordMap {
 public:
  static constexpr int width = 640, height = 200;

  WordMap() {
    MapCamera camera;
    camera.intrinsics.width = width;
    camera.intrinsics.height = height;
    map_.cameras.push_back(camera);
  }

  WordMap& add(std::vector<std::int64_t> words, double weight = 1.0) {
    const auto id = static_cast<KeyframeId>(map_.keyframes.size());
    Keyframe keyframe;
    keyframe.id = id, keyframe.frame = 10 * id, keyframe.stamp = 1'500'000'000 * id, keyframe.weight = weight;
    map_.keyframes.push_back(keyframe);
    auto image = std::make_shared<ImageFeatures>();
    for (std::size_t k = 0; k < words.size() + 1; ++k)
      image->features.keypoints.push_back(
          {20.0F + 30.0F * static_cast<float>(k), 40.0F + 10.0F * static_cast<float>(id)});
    signatures_->add(id, {std::move(image), std::move(words)});
    return *this;
  }
  WordMap& close(KeyframeId from, KeyframeId to, int inliers, ConstraintKind kind = ConstraintKind::loop) {
    Constraint edge;
    edge.from = from, edge.to = to, edge.inliers = inliers, edge.kind = kind;
    map_.constraints.push_back(edge);
    return *this;
  }
  /// A gray image of one value.
  WordMap& show(KeyframeId id, std::uint8_t value) {
    Frame frame;
    frame.image = GrayImage(width, height);
    for (int y = 0; y < height; ++y) std::fill_n(frame.image.row(y), width, value);
    images_->add(id, pack_images(frame));
    shown_.push_back(id);
    return *this;
  }
  Map made() const {
    Map map = map_;
    auto signatures = std::make_shared<SignatureLayer>();
    signatures->store = signatures_;
    for (const Keyframe& keyframe : map.keyframes) signatures->keyframes.push_back(keyframe.id);
    map.layers.put<SignatureLayer>(std::move(signatures));
    if (shown_.empty()) return map;
    auto images = std::make_shared<ImageLayer>();
    images->store = images_;
    images->keyframes = shown_;
    map.layers.put<ImageLayer>(std::move(images));
    return map;
  }

 private:
  Map map_;
  std::shared_ptr<MemorySignatures> signatures_ = std::make_shared<MemorySignatures>();
  std::shared_ptr<MemoryImages> images_ = std::make_shared<MemoryImages>();
  std::vector<KeyframeId> shown_;
};

}  // namespace rastro
