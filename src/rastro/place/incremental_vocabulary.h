// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/feature/brief.h"

namespace rastro {

/// Visual words that are made from the images as they come (Labbe and Michaud 2013, section III-A), for places that no
/// training has seen. A word is a descriptor, with the number of features that use it; one without uses is forgotten.
/// Ids ascend and are never given twice. Not thread-safe.
class IncrementalVocabulary {
 public:
  /// Bits by which unrelated descriptors differ: what counts as second where there is no second word.
  static constexpr int unrelated_distance = 128;

  /// `distance_ratio`, 0..1: a feature is the nearest word where its distance is at most this share of that to the
  /// second nearest one (nearest-neighbor distance ratio).
  explicit IncrementalVocabulary(double distance_ratio = 0.8) : distance_ratio_(distance_ratio) {}

  /// The word of each descriptor; one that no word fits becomes a new word, which later ones of the same image may be.
  /// Each is used once more. The result does not depend on the pool.
  std::vector<std::int64_t> add(std::span<const Descriptor> descriptors, TaskPool* pool = nullptr);
  /// The word of each descriptor, -1 where no word fits; nothing changes.
  std::vector<std::int64_t> find(std::span<const Descriptor> descriptors, TaskPool* pool = nullptr) const;
  /// Takes back one use for each; ids below 0 are skipped. All others must exist.
  void release(std::span<const std::int64_t> words);
  /// Words of a location that comes back, with their descriptors as they were. One use for each; ids below 0 are
  /// skipped.
  void restore(std::span<const std::int64_t> words, std::span<const Descriptor> descriptors);

  std::size_t size() const { return ids_.size(); }
  bool contains(std::int64_t word) const { return slots_.contains(word); }
  const Descriptor& descriptor(std::int64_t word) const { return descriptors_[slots_.at(word)]; }
  int uses(std::int64_t word) const { return uses_[slots_.at(word)]; }
  /// Smallest id never given.
  std::int64_t next_id() const { return next_id_; }

 private:
  /// The two words nearest to a descriptor: by distance, then by id.
  struct Nearest {
    std::int64_t word = -1;
    int distance = unrelated_distance, second = unrelated_distance;
  };
  std::vector<Nearest> nearest(std::span<const Descriptor> descriptors, TaskPool* pool) const;
  static void compare(Nearest& nearest, std::int64_t word, int distance);
  bool fits(const Nearest& nearest) const;
  void insert(std::int64_t word, const Descriptor& descriptor);

  double distance_ratio_;
  // One element for each word, in no order.
  std::vector<Descriptor> descriptors_;
  std::vector<std::int64_t> ids_;
  std::vector<int> uses_;
  std::map<std::int64_t, std::size_t> slots_;  ///< By id.
  std::int64_t next_id_ = 0;
};

}  // namespace rastro
