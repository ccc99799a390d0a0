// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/incremental_vocabulary.h"

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/feature/hamming.h"

namespace rastro {

void IncrementalVocabulary::compare(Nearest& nearest, std::int64_t word, int distance) {
  const bool nearer = distance < nearest.distance || (distance == nearest.distance && word < nearest.word);
  if (nearest.word < 0 ? distance <= nearest.distance : nearer) {
    if (nearest.word >= 0) nearest.second = nearest.distance;
    nearest.word = word;
    nearest.distance = distance;
  } else {
    nearest.second = std::min(nearest.second, distance);
  }
}

bool IncrementalVocabulary::fits(const Nearest& nearest) const {
  return nearest.word >= 0 && nearest.distance <= distance_ratio_ * nearest.second;
}

std::vector<IncrementalVocabulary::Nearest> IncrementalVocabulary::nearest(std::span<const Descriptor> descriptors,
                                                                           TaskPool* pool) const {
  std::vector<Nearest> found(descriptors.size());
  const auto search = [&](int begin, int end) {
    std::vector<std::uint16_t> distances(descriptors_.size());
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      hamming_distances(descriptors[i], descriptors_, distances);
      for (std::size_t slot = 0; slot < distances.size(); ++slot)
        if (distances[slot] <= found[i].second) compare(found[i], ids_[slot], distances[slot]);
    }
  };
  constexpr int grain = 16;
  const auto count = static_cast<int>(descriptors.size());
  pool == nullptr ? search(0, count) : pool->for_chunks(0, count, grain, search);
  return found;
}

std::vector<std::int64_t> IncrementalVocabulary::add(std::span<const Descriptor> descriptors, TaskPool* pool) {
  std::vector<Nearest> found = nearest(descriptors, pool);
  const std::int64_t first_new = next_id_;
  std::vector<std::int64_t> words;
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    for (std::int64_t word = first_new; word < next_id_; ++word)
      compare(found[i], word, hamming_distance(descriptors[i], descriptor(word)));
    if (!fits(found[i])) {
      insert(next_id_, descriptors[i]);
      words.push_back(next_id_++);
    } else {
      words.push_back(found[i].word);
    }
    ++uses_[slots_.at(words.back())];
  }
  return words;
}

std::vector<std::int64_t> IncrementalVocabulary::find(std::span<const Descriptor> descriptors, TaskPool* pool) const {
  std::vector<std::int64_t> words;
  for (const Nearest& each : nearest(descriptors, pool)) words.push_back(fits(each) ? each.word : -1);
  return words;
}

void IncrementalVocabulary::release(std::span<const std::int64_t> words) {
  for (const std::int64_t word : words) {
    if (word < 0) continue;
    RASTRO_CHECK(contains(word), "a word in use exists");
    const std::size_t slot = slots_.at(word);
    if (--uses_[slot] > 0) continue;
    slots_[ids_.back()] = slot;
    slots_.erase(word);
    descriptors_[slot] = descriptors_.back();
    ids_[slot] = ids_.back();
    uses_[slot] = uses_.back();
    descriptors_.pop_back();
    ids_.pop_back();
    uses_.pop_back();
  }
}

void IncrementalVocabulary::restore(std::span<const std::int64_t> words, std::span<const Descriptor> descriptors) {
  RASTRO_CHECK(words.size() == descriptors.size(), "one descriptor for each word");
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] < 0) continue;
    if (!contains(words[i])) insert(words[i], descriptors[i]);
    ++uses_[slots_.at(words[i])];
    next_id_ = std::max(next_id_, words[i] + 1);
  }
}

void IncrementalVocabulary::insert(std::int64_t word, const Descriptor& descriptor) {
  slots_[word] = ids_.size();
  ids_.push_back(word);
  descriptors_.push_back(descriptor);
  uses_.push_back(0);
}

}  // namespace rastro
