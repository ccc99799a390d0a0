// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/place_index.h"

#include <algorithm>

#include "rastro/base/error.h"

namespace rastro {

void PlaceIndex::add(std::int64_t id, const BagOfWords& words) {
  RASTRO_CHECK(!entries_.contains(id), "an image can be added only once");
  if (free_slots_.empty()) {
    free_slots_.push_back(static_cast<std::uint32_t>(ids_.size()));
    ids_.push_back(id);
  }
  const std::uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  ids_[slot] = id;
  entries_.emplace(id, Entry{words, slot});
  for (const auto& [word, share] : words.words) {
    if (word >= holders_.size()) holders_.resize(word + std::size_t{1});
    holders_[word].push_back({slot, share});
  }
}

void PlaceIndex::remove(std::int64_t id) {
  const auto entry = entries_.find(id);
  if (entry == entries_.end()) return;
  const std::uint32_t slot = entry->second.slot;
  for (const auto& [word, share] : entry->second.words.words)
    std::erase_if(holders_[word], [slot](const Holder& holder) { return holder.slot == slot; });
  free_slots_.push_back(slot);
  entries_.erase(entry);
}

const BagOfWords* PlaceIndex::find_words(std::int64_t id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() ? nullptr : &entry->second.words;
}

/// In the order of words, as similarity() adds them, so that scores are the same to the last bit.
std::vector<PlaceIndex::Sum> PlaceIndex::sums_with(const BagOfWords& words) const {
  std::vector<Sum> sums(ids_.size());
  for (const auto& [word, share] : words.words) {
    if (word >= holders_.size()) continue;
    for (const Holder& holder : holders_[word]) {
      Sum& sum = sums[holder.slot];
      ++sum.shared;
      sum.common += static_cast<double>(std::min(share, holder.share));
    }
  }
  return sums;
}

std::vector<PlaceMatch> PlaceIndex::find(const BagOfWords& words, double least_share,
                                         const std::function<bool(std::int64_t)>& allowed) const {
  const std::vector<Sum> sums = sums_with(words);
  const auto counts = [&](std::size_t slot) { return sums[slot].shared > 0 && (!allowed || allowed(ids_[slot])); };
  int most = 0;
  for (std::size_t slot = 0; slot < ids_.size(); ++slot)
    if (sums[slot].shared > most && counts(slot)) most = sums[slot].shared;
  std::vector<PlaceMatch> matches;
  for (std::size_t slot = 0; slot < ids_.size(); ++slot) {
    const auto& [shared, common] = sums[slot];
    if (shared >= least_share * most && counts(slot)) matches.push_back({ids_[slot], shared, std::min(common, 1.0)});
  }
  std::sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
    return a.score != b.score ? a.score > b.score : a.id < b.id;
  });
  return matches;
}

}  // namespace rastro
