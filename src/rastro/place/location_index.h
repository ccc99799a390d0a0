// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace rastro {

/// Share of the words that two images have in common: each word in the number that both have, over the larger number of
/// words (Labbe and Michaud 2013, equation 1). 0 where one has none. Words in any order.
double shared_word_ratio(std::span<const std::int64_t> a, std::span<const std::int64_t> b);

struct LocationScore {
  std::int64_t location = 0;
  double score = 0.0;
};

/// Which locations contain which visual words: an inverted index with tf-idf scores (Sivic and Zisserman 2003), for a
/// vocabulary that grows. Not thread-safe.
class LocationIndex {
 public:
  /// The words of its features, in any order, repeated as often as features have them. `location` must be new.
  void add(std::int64_t location, std::span<const std::int64_t> words);
  /// Does nothing if it is not present.
  void remove(std::int64_t location);
  bool contains(std::int64_t location) const { return words_of_.contains(location); }
  std::size_t size() const { return words_of_.size(); }

  /// Score of every location, ids ascending: the sum over each of these words, once for each time it is repeated, of
  /// n_wi / n_i log(N / n_w), with n_wi of the location's n_i features and n_w of the N locations having the word.
  std::vector<LocationScore> scores(std::span<const std::int64_t> words) const;

 private:
  struct Holder {
    std::int64_t location = 0;
    int count = 0;
  };
  std::unordered_map<std::int64_t, std::vector<Holder>> holders_;         ///< By word; locations ascend.
  std::unordered_map<std::int64_t, std::vector<std::int64_t>> words_of_;  ///< Words of each location.
  std::vector<Holder> sizes_;  ///< Their number for each location; these ascend.
};

}  // namespace rastro
