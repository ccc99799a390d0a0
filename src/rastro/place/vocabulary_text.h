// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/feature/brief.h"

namespace rastro {

/// Weights are logarithms of frequency ratios; a value far above is invalid, and sums of it would overflow.
constexpr float max_word_weight = 1e6F;

/// The text formats of DBoW2 and DBoW3: either lines of numbers (first "branching depth scoring weighting", then for
/// each node its parent, whether it is a word, 32 bytes and its weight; nodes count from 1) or YAML as OpenCV writes
/// it.
struct VocabularyText {
  struct Entry {
    std::uint32_t id = 0, parent = 0;
    float weight = 0.0F;
    Descriptor descriptor;
  };
  int branching = 0, depth = 0;
  std::vector<Entry> entries;  ///< By parent, then id.

  /// Throws Error if it is neither, or a node is incomplete or occurs twice.
  static VocabularyText parse(std::string_view text, const std::string& where);
  std::span<const Entry> children_of(std::uint32_t id) const;
};

}  // namespace rastro
