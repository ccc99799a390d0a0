// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/incremental_vocabulary.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/feature/hamming.h"

namespace rastro {
namespace {

constexpr std::size_t searched_buckets = 8;

}  // namespace

void WordDistance<Descriptor>::between(const Descriptor& query, std::span<const Descriptor> words,
                                       std::span<Type> distances) {
  hamming_distances(query, words, distances);
}

void WordDistance<RealDescriptor>::between(const RealDescriptor& query, std::span<const RealDescriptor> words,
                                           std::span<Type> distances) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    constexpr std::size_t lanes = 8;  // sums of their own, in an order that does not depend on the compiler
    std::array<float, lanes> sums{};
    for (std::size_t k = 0; k < query.size(); k += lanes)
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const float difference = query[k + lane] - words[i][k + lane];
        sums[lane] += difference * difference;
      }
    distances[i] = std::sqrt(((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7])));
  }
}

template <typename Value>
void IncrementalVocabularyOf<Value>::compare(Nearest& nearest, std::int64_t word, Distance distance) {
  const bool nearer = distance < nearest.distance || (distance == nearest.distance && word < nearest.word);
  if (nearest.word < 0 ? distance <= nearest.distance : nearer) {
    if (nearest.word >= 0) nearest.second = nearest.distance;
    nearest.word = word;
    nearest.distance = distance;
  } else {
    nearest.second = std::min(nearest.second, distance);
  }
}

template <typename Value>
bool IncrementalVocabularyOf<Value>::fits(const Nearest& nearest) const {
  return nearest.word >= 0 && static_cast<double>(nearest.distance) <= distance_ratio_ * nearest.second;
}

template <typename Value>
std::vector<std::size_t> IncrementalVocabularyOf<Value>::Partition::buckets_near(const Value& descriptor,
                                                                                 std::size_t most) const {
  if (centers.empty()) return {0};
  std::vector<Distance> distances(centers.size());
  WordDistance<Value>::between(descriptor, centers, distances);
  std::vector<std::pair<Distance, std::size_t>> near;
  for (std::size_t bucket = 0; bucket < distances.size(); ++bucket) near.emplace_back(distances[bucket], bucket);
  const std::size_t count = std::min(most, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
  std::vector<std::size_t> nearest;
  for (std::size_t i = 0; i < count; ++i) nearest.push_back(near[i].second);
  return nearest;
}

template <typename Value>
std::size_t IncrementalVocabularyOf<Value>::Partition::comparisons() const {
  if (centers.empty()) return size;
  return centers.size() + std::min(searched_buckets, centers.size()) * size / centers.size();
}

template <typename Value>
void IncrementalVocabularyOf<Value>::search(const Partition& partition, const Value& descriptor,
                                            std::vector<Distance>& distances, Nearest& found) {
  if (partition.size == 0) return;
  for (const std::size_t index : partition.buckets_near(descriptor, searched_buckets)) {
    const Bucket& bucket = partition.buckets[index];
    distances.resize(bucket.values.size());
    WordDistance<Value>::between(descriptor, bucket.values, distances);
    for (std::size_t slot = 0; slot < distances.size(); ++slot)
      if (distances[slot] <= found.second) compare(found, bucket.ids[slot], distances[slot]);
  }
}

template <typename Value>
auto IncrementalVocabularyOf<Value>::nearest(const Value& descriptor, std::vector<Distance>& distances) const
    -> Nearest {
  Nearest found;
  for (const Partition& partition : partitions_) search(partition, descriptor, distances, found);
  return found;
}

template <typename Value>
auto IncrementalVocabularyOf<Value>::nearest(std::span<const Value> descriptors, TaskPool* pool) const
    -> std::vector<Nearest> {
  std::vector<Nearest> found(descriptors.size());
  const auto search = [&](int begin, int end) {
    std::vector<Distance> distances;
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      found[i] = nearest(descriptors[i], distances);
  };
  constexpr int grain = 16;
  const auto count = static_cast<int>(descriptors.size());
  pool == nullptr ? search(0, count) : pool->for_chunks(0, count, grain, search);
  return found;
}

template <typename Value>
std::vector<std::int64_t> IncrementalVocabularyOf<Value>::add(std::span<const Value> descriptors, TaskPool* pool) {
  std::vector<Nearest> found = nearest(descriptors, pool);
  std::vector<Value> made;  // by this image
  std::vector<Distance> distances;
  const std::int64_t first_new = next_id_;
  std::vector<std::int64_t> words;
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    distances.resize(made.size());
    WordDistance<Value>::between(descriptors[i], made, distances);
    for (std::size_t k = 0; k < made.size(); ++k)
      compare(found[i], first_new + static_cast<std::int64_t>(k), distances[k]);
    if (!fits(found[i])) {
      insert(next_id_, descriptors[i], 0);
      made.push_back(descriptors[i]);
      words.push_back(next_id_++);
    } else {
      words.push_back(found[i].word);
    }
    use(words.back());
  }
  rebalance(words.size());
  return words;
}

template <typename Value>
std::vector<std::int64_t> IncrementalVocabularyOf<Value>::find(std::span<const Value> descriptors,
                                                               TaskPool* pool) const {
  std::vector<std::int64_t> words;
  for (const Nearest& each : nearest(descriptors, pool)) words.push_back(fits(each) ? each.word : -1);
  return words;
}

template <typename Value>
void IncrementalVocabularyOf<Value>::release(std::span<const std::int64_t> words) {
  for (const std::int64_t word : words) {
    if (word < 0) continue;
    RASTRO_CHECK(contains(word), "a word in use exists");
    const Place place = places_.at(word);
    if (--bucket_of(place).uses[place.slot] == 0) remove(word);
  }
  rebalance(words.size());
}

template <typename Value>
void IncrementalVocabularyOf<Value>::restore(std::span<const std::int64_t> words, std::span<const Value> descriptors) {
  RASTRO_CHECK(words.size() == descriptors.size(), "one descriptor for each word");
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] < 0) continue;
    if (!contains(words[i])) insert(words[i], descriptors[i], 0);
    use(words[i]);
    next_id_ = std::max(next_id_, words[i] + 1);
  }
  rebalance(words.size());
}

template <typename Value>
const Value& IncrementalVocabularyOf<Value>::descriptor(std::int64_t word) const {
  const Place& place = places_.at(word);
  return bucket_of(place).values[place.slot];
}

template <typename Value>
int IncrementalVocabularyOf<Value>::uses(std::int64_t word) const {
  const Place& place = places_.at(word);
  return bucket_of(place).uses[place.slot];
}

template <typename Value>
std::size_t IncrementalVocabularyOf<Value>::comparisons() const {
  return now().comparisons() + former().comparisons();
}

template <typename Value>
void IncrementalVocabularyOf<Value>::use(std::int64_t word) {
  const Place& place = places_.at(word);
  ++bucket_of(place).uses[place.slot];
}

template <typename Value>
void IncrementalVocabularyOf<Value>::insert(std::int64_t word, const Value& descriptor, int uses) {
  const std::size_t index = now().buckets_near(descriptor, 1).front();
  Bucket& bucket = now().buckets[index];
  places_[word] = {static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(bucket.ids.size()), now_};
  bucket.ids.push_back(word);
  bucket.values.push_back(descriptor);
  bucket.uses.push_back(uses);
  ++now().size;
}

/// The last of the bucket takes its slot.
template <typename Value>
void IncrementalVocabularyOf<Value>::remove(std::int64_t word) {
  const Place place = places_.at(word);
  Bucket& bucket = bucket_of(place);
  places_.at(bucket.ids.back()) = place;
  places_.erase(word);
  bucket.values[place.slot] = bucket.values.back();
  bucket.ids[place.slot] = bucket.ids.back();
  bucket.uses[place.slot] = bucket.uses.back();
  bucket.values.pop_back();
  bucket.ids.pop_back();
  bucket.uses.pop_back();
  --partitions_[place.partition].size;
}

/// More words move than are added, so that they have moved before the number has doubled once more.
template <typename Value>
void IncrementalVocabularyOf<Value>::rebalance(std::size_t words) {
  constexpr std::size_t least_moved = 512;
  const bool grown = size() > std::max(most_in_one_bucket, 2 * balanced_size_), shrunk = 4 * size() < balanced_size_;
  if (moving() == 0 && (grown || shrunk)) begin_new_buckets();
  move_to_new_buckets(std::max(least_moved, 2 * words));
}

/// Words at regular steps of their ids become the centers.
template <typename Value>
void IncrementalVocabularyOf<Value>::begin_new_buckets() {
  balanced_size_ = size() > most_in_one_bucket ? size() : 0;
  std::vector<std::int64_t> ids;
  for (const Bucket& bucket : now().buckets) ids.insert(ids.end(), bucket.ids.begin(), bucket.ids.end());
  std::sort(ids.begin(), ids.end());
  const auto count = balanced_size_ == 0 ? 0 : static_cast<std::size_t>(std::sqrt(static_cast<double>(size())));
  Partition made;
  made.buckets.resize(std::max<std::size_t>(1, count));
  for (std::size_t i = 0; i < count; ++i) made.centers.push_back(descriptor(ids[i * ids.size() / count]));
  former() = std::move(made);
  now_ = static_cast<std::uint8_t>(1U - now_);
}

/// From the last bucket on, each of which leaves with its words.
template <typename Value>
void IncrementalVocabularyOf<Value>::move_to_new_buckets(std::size_t most) {
  Partition& from = former();
  for (; most > 0 && from.size > 0; --most) {
    while (from.buckets.back().ids.empty()) {
      from.buckets.pop_back();
      from.centers.pop_back();
    }
    const Bucket& bucket = from.buckets.back();
    const std::int64_t word = bucket.ids.back();
    const Value value = bucket.values.back();
    const int uses = bucket.uses.back();
    remove(word);
    insert(word, value, uses);
  }
  if (from.size == 0) from = {};
}

template class IncrementalVocabularyOf<Descriptor>;
template class IncrementalVocabularyOf<RealDescriptor>;

}  // namespace rastro
