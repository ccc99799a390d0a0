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

  /// Number of images with this word.
  std::size_t images_with(std::uint32_t word) const { return word < holders_.size() ? holders_[word].size() : 0; }

  /// All images that share at least `least_share` times as many words as the one that shares most, with ids that
  /// `allowed` (if any) accepts; highest score first, equal ones by id.
  std::vector<PlaceMatch> find(const BagOfWords& words, double least_share = 0.8,
                               const std::function<bool(std::int64_t)>& allowed = {}) const;

 private:
  struct Entry {
    BagOfWords words;
    std::uint32_t slot = 0;
  };
  struct Holder {
    std::uint32_t slot = 0;
    float share = 0.0F;  ///< Of the word in this image.
  };
  struct Sum {
    int shared = 0;       ///< Words.
    double common = 0.0;  ///< Of the smaller shares of these.
  };
  std::vector<Sum> sums_with(const BagOfWords& words) const;

  std::map<std::int64_t, Entry> entries_;
  std::vector<std::vector<Holder>> holders_;  ///< The images with each word.
  std::vector<std::uint32_t> free_slots_;
  std::vector<std::int64_t> ids_;  ///< By slot.
};

}  // namespace rastro
