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
  double score = 0.0;  ///< similarity() to what was asked.
};

/// Pictures by their words (an inverted index, Galvez-Lopez and Tardos 2012 section IV): finds what is like a picture
/// without looking at all of them. One thread at a time.
class PlaceIndex {
 public:
  /// `id` must not be in yet.
  void add(std::int64_t id, const BagOfWords& words);
  /// Nothing happens where it is not in.
  void remove(std::int64_t id);
  bool contains(std::int64_t id) const { return entries_.contains(id); }
  std::size_t size() const { return entries_.size(); }
  /// What was added; nullptr where it is not in.
  const BagOfWords* find_words(std::int64_t id) const;

  /// All pictures that share at least `least_share` times as many words as the one that shares most, of ids that
  /// `allowed` (if any) lets through; likest first, equal ones by id.
  std::vector<PlaceMatch> find(const BagOfWords& words, double least_share = 0.8,
                               const std::function<bool(std::int64_t)>& allowed = {}) const;

 private:
  std::map<std::int64_t, BagOfWords> entries_;
  std::vector<std::vector<std::int64_t>> holders_;  ///< Of each word; ids ascend.
};

}  // namespace rastro
