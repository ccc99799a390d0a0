// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rastro/map/features/feature_layer.h"
#include "rastro/map/stored_layer.h"

namespace rastro {

/// What recognizes a location (Labbe and Michaud 2013, section III-A): the features of its image, with depths, and the
/// visual words of the strongest.
struct Signature {
  std::shared_ptr<const ImageFeatures> image;
  std::vector<std::int64_t> words;  ///< Of the first features, one each; -1: none.
};

using SignatureStore = ItemStore<Signature>;
using MemorySignatures = MemoryItems<Signature>;

/// Long-term memory: the signatures of all locations, in the map file. Those of working memory are in RAM as well.
struct SignatureLayer : StoredLayer<Signature> {
  static constexpr const char* layer_name = "signatures";
};

std::string body_of(const Signature& signature);
/// The signatures among these rows of a map file.
std::shared_ptr<const SignatureStore> signatures_in(std::shared_ptr<const RowStore> rows);

std::unique_ptr<LayerType> signatures_layer_type();

}  // namespace rastro
