// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/feature/brief.h"

namespace rastro {

/// A real-valued descriptor of unit length; shorter ones end in zeros.
using RealDescriptor = std::array<float, 128>;

/// How words of a kind are compared.
template <typename Value>
struct WordDistance;

template <>
struct WordDistance<Descriptor> {
  using Type = std::uint16_t;             ///< Hamming, bits.
  static constexpr Type unrelated = 128;  ///< Of unrelated ones: what counts as second where there is no second word.
  static void between(const Descriptor& query, std::span<const Descriptor> words, std::span<Type> distances);
};

template <>
struct WordDistance<RealDescriptor> {
  using Type = float;  ///< Euclidean.
  static constexpr Type unrelated = 1.0F;
  static void between(const RealDescriptor& query, std::span<const RealDescriptor> words, std::span<Type> distances);
};

/// Visual words that are made from the images as they come (Labbe and Michaud 2013, section III-A), for places that no
/// training has seen. A word is a descriptor, with the number of features that use it; one without uses is forgotten.
/// Ids ascend and are never given twice. Not thread-safe.
///
/// Many words are searched approximately: each is in the bucket of its nearest center (an inverted file, Sivic and
/// Zisserman 2003), and only the buckets nearest to a feature are searched. Words become the centers of new buckets
/// whenever their number has doubled or become a quarter, so that the time grows with the square root of the number.
/// The words move there little by little with the calls that follow, at least 512 with each, so that none takes long.
template <typename Value>
class IncrementalVocabularyOf {
 public:
  using Distance = typename WordDistance<Value>::Type;
  static constexpr std::size_t most_in_one_bucket = 2048;  ///< Up to here the search is exact, unless words move.

  /// `distance_ratio`, 0..1: a feature is the nearest word where its distance is at most this share of that to the
  /// second nearest one (nearest-neighbor distance ratio).
  explicit IncrementalVocabularyOf(double distance_ratio = 0.8) : distance_ratio_(distance_ratio) {}

  /// The word of each descriptor; one that no word fits becomes a new word, which later ones of the same image may be.
  /// Each is used once more. The result does not depend on the pool.
  std::vector<std::int64_t> add(std::span<const Value> descriptors, TaskPool* pool = nullptr);
  /// The word of each descriptor, -1 where no word fits; nothing changes.
  std::vector<std::int64_t> find(std::span<const Value> descriptors, TaskPool* pool = nullptr) const;
  /// Takes back one use for each; ids below 0 are skipped. All others must exist.
  void release(std::span<const std::int64_t> words);
  /// Words of a location that comes back, with their descriptors as they were. One use for each; ids below 0 are
  /// skipped.
  void restore(std::span<const std::int64_t> words, std::span<const Value> descriptors);

  std::size_t size() const { return places_.size(); }
  bool contains(std::int64_t word) const { return places_.contains(word); }
  const Value& descriptor(std::int64_t word) const;
  int uses(std::int64_t word) const;
  /// Smallest id never given.
  std::int64_t next_id() const { return next_id_; }
  /// Comparisons that the search for one descriptor takes.
  std::size_t comparisons() const;
  /// Words that have yet to move to new buckets.
  std::size_t moving() const { return former().size; }

 private:
  /// The two words nearest to a descriptor: by distance, then by id.
  struct Nearest {
    std::int64_t word = -1;
    Distance distance = WordDistance<Value>::unrelated, second = WordDistance<Value>::unrelated;
  };
  /// One element for each word, in no order.
  struct Bucket {
    std::vector<Value> values;
    std::vector<std::int64_t> ids;
    std::vector<int> uses;
  };
  struct Partition {
    std::vector<Value> centers;  ///< Of the buckets; none while there is one bucket.
    std::vector<Bucket> buckets = std::vector<Bucket>(1);
    std::size_t size = 0;  ///< Words.

    std::vector<std::size_t> buckets_near(const Value& descriptor, std::size_t most) const;
    std::size_t comparisons() const;
  };
  struct Place {
    std::uint32_t bucket = 0, slot = 0;
    std::uint8_t partition = 0;  ///< Of partitions_.
  };
  std::vector<Nearest> nearest(std::span<const Value> descriptors, TaskPool* pool) const;
  Nearest nearest(const Value& descriptor, std::vector<Distance>& distances) const;
  static void search(const Partition& partition, const Value& descriptor, std::vector<Distance>& distances,
                     Nearest& found);
  static void compare(Nearest& nearest, std::int64_t word, Distance distance);
  bool fits(const Nearest& nearest) const;
  Partition& now() { return partitions_[now_]; }
  const Partition& now() const { return partitions_[now_]; }
  Partition& former() { return partitions_[1U - now_]; }
  const Partition& former() const { return partitions_[1U - now_]; }
  const Bucket& bucket_of(const Place& place) const { return partitions_[place.partition].buckets[place.bucket]; }
  Bucket& bucket_of(const Place& place) { return partitions_[place.partition].buckets[place.bucket]; }
  void use(std::int64_t word);
  void insert(std::int64_t word, const Value& descriptor, int uses);
  void remove(std::int64_t word);
  void rebalance(std::size_t words);
  void begin_new_buckets();
  void move_to_new_buckets(std::size_t most);

  double distance_ratio_;
  /// One for new words, and one for those that have not moved yet: most often there are none.
  std::array<Partition, 2> partitions_;
  std::uint8_t now_ = 0;                            ///< That for new words.
  std::unordered_map<std::int64_t, Place> places_;  ///< By id.
  std::size_t balanced_size_ = 0;                   ///< When the buckets were made.
  std::int64_t next_id_ = 0;
};

extern template class IncrementalVocabularyOf<Descriptor>;
extern template class IncrementalVocabularyOf<RealDescriptor>;
using IncrementalVocabulary = IncrementalVocabularyOf<Descriptor>;

}  // namespace rastro
