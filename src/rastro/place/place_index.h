// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "rastro/place/vocabulary.h"

namespace rastro {

struct PlaceMatch {
  std::int64_t id = 0;
  int shared_words = 0;
  double score = 0.0;  ///< similarity() to the query.
};

/// Database of images by their visual words (an inverted index, Galvez-Lopez and Tardos 2012 section IV): finds similar
/// images without comparing all of them. Not thread-safe.
class PlaceIndex {
 public:
  /// `id` must not be present yet.
  void add(std::int64_t id, const BagOfWords& words);
  /// Does nothing if it is not present.
  void remove(std::int64_t id);
  bool contains(std::int64_t id) const { return entries_.contains(id); }
  std::size_t size() const { return entries_.size(); }
  /// The bag added for this id; nullptr if there is none.
  const BagOfWords* find_words(std::int64_t id) const;

  /// All images that share at least `least_share` times as many words as the one that shares most, with ids that
  /// `allowed` (if any) accepts; highest score first, equal ones by id.
  std::vector<PlaceMatch> find(const BagOfWords& words, double least_share = 0.8,
                               const std::function<bool(std::int64_t)>& allowed = {}) const;

 private:
  std::map<std::int64_t, BagOfWords> entries_;
  std::vector<std::vector<std::int64_t>> holders_;  ///< Ids per word, ascending.
};

}  // namespace rastro
