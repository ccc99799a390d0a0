// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "rastro/backend/guided_search.h"
#include "rastro/feature/brief.h"
#include "rastro/place/vocabulary.h"

namespace rastro {

/// Features of an image and their words. The caller owns all members.
struct WordedFeatures {
  std::span<const Descriptor> descriptors;
  const BagOfWords& words;                 ///< With its nodes, one per feature.
  std::span<const std::uint8_t> use = {};  ///< Empty, or one per feature: zero skips it.
};

/// Mutual best matches of two images among features under the same node of the vocabulary; pairs ascend. Needs no pose
/// prior and is far cheaper than brute force: the first step of verification (Galvez-Lopez and Tardos 2012, section
/// V.D: direct index).
std::vector<std::pair<std::uint32_t, std::uint32_t>> match_by_words(const WordedFeatures& first,
                                                                    const WordedFeatures& second,
                                                                    const MatchLimits& limits);

}  // namespace rastro
