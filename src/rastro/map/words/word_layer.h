// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/map/keyframe_layer.h"
#include "rastro/place/vocabulary.h"

namespace rastro {

/// The visual words of each keyframe, for place recognition.
struct WordLayer : KeyframeLayer<BagOfWords> {
  static constexpr const char* layer_name = "words";
  std::string vocabulary;  ///< SHA-256 of the vocabulary that the words belong to.
};

std::unique_ptr<LayerType> words_layer_type();

}  // namespace rastro
