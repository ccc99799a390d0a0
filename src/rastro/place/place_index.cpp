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
    holders_[word].push_back(slot);
  }
}

void PlaceIndex::remove(std::int64_t id) {
  const auto entry = entries_.find(id);
  if (entry == entries_.end()) return;
  for (const auto& [word, share] : entry->second.words.words) std::erase(holders_[word], entry->second.slot);
  free_slots_.push_back(entry->second.slot);
  entries_.erase(entry);
}

const BagOfWords* PlaceIndex::find_words(std::int64_t id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() ? nullptr : &entry->second.words;
}

std::vector<PlaceMatch> PlaceIndex::find(const BagOfWords& words, double least_share,
                                         const std::function<bool(std::int64_t)>& allowed) const {
  std::vector<int> shared(ids_.size());
  for (const auto& [word, share] : words.words) {
    if (word >= holders_.size()) continue;
    for (const std::uint32_t slot : holders_[word]) ++shared[slot];
  }
  std::vector<PlaceMatch> matches;
  int most = 0;
  for (std::size_t slot = 0; slot < ids_.size(); ++slot) {
    if (shared[slot] == 0 || (allowed && !allowed(ids_[slot]))) continue;
    matches.push_back({ids_[slot], shared[slot], 0.0});
    most = std::max(most, shared[slot]);
  }
  std::erase_if(matches, [&](const PlaceMatch& match) { return match.shared_words < least_share * most; });
  for (PlaceMatch& match : matches) match.score = similarity(words, entries_.at(match.id).words);
  std::sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
    return a.score != b.score ? a.score > b.score : a.id < b.id;
  });
  return matches;
}

}  // namespace rastro
