// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rastro/feature/features.h"
#include "rastro/place/incremental_vocabulary.h"

namespace rastro {

/// The incremental vocabulary for features of either kind, binary (BRIEF, ORB) or real-valued (SIFT, SURF); all of one
/// vocabulary are of the same kind. Not thread-safe.
class VisualWords {
 public:
  explicit VisualWords(double distance_ratio) : binary_(distance_ratio), real_(distance_ratio) {}

  /// The words of the first `count` features: see IncrementalVocabularyOf::add().
  std::vector<std::int64_t> add(const Features& features, std::size_t count, TaskPool* pool = nullptr);
  void release(std::span<const std::int64_t> words);
  /// The words of the first features, one each.
  void restore(std::span<const std::int64_t> words, const Features& features);
  std::size_t size() const { return binary_.size() + real_.size(); }
  std::size_t comparisons() const { return is_real_ ? real_.comparisons() : binary_.comparisons(); }

 private:
  bool is_real_ = false;
  IncrementalVocabularyOf<Descriptor> binary_;
  IncrementalVocabularyOf<RealDescriptor> real_;
};

}  // namespace rastro
