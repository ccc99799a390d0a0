// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/place_index.h"

#include <algorithm>

#include "rastro/base/error.h"

namespace rastro {

void PlaceIndex::add(std::int64_t id, const BagOfWords& words) {
  RASTRO_CHECK(!entries_.contains(id), "an image can be added only once");
  entries_.emplace(id, words);
  for (const auto& [word, share] : words.words) {
    if (word >= holders_.size()) holders_.resize(word + std::size_t{1});
    auto& holders = holders_[word];
    holders.insert(std::upper_bound(holders.begin(), holders.end(), id), id);
  }
}

void PlaceIndex::remove(std::int64_t id) {
  const auto entry = entries_.find(id);
  if (entry == entries_.end()) return;
  for (const auto& [word, share] : entry->second.words) std::erase(holders_[word], id);
  entries_.erase(entry);
}

const BagOfWords* PlaceIndex::find_words(std::int64_t id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() ? nullptr : &entry->second;
}

std::vector<PlaceMatch> PlaceIndex::find(const BagOfWords& words, double least_share,
                                         const std::function<bool(std::int64_t)>& allowed) const {
  std::vector<std::int64_t> holders;  // One entry per shared word.
  for (const auto& [word, share] : words.words)
    if (word < holders_.size()) holders.insert(holders.end(), holders_[word].begin(), holders_[word].end());
  std::sort(holders.begin(), holders.end());
  std::vector<PlaceMatch> matches;
  for (auto at = holders.begin(); at != holders.end();) {
    const auto end = std::upper_bound(at, holders.end(), *at);
    if (!allowed || allowed(*at)) matches.push_back({*at, static_cast<int>(end - at), 0.0});
    at = end;
  }
  int most = 0;
  for (const PlaceMatch& match : matches) most = std::max(most, match.shared_words);
  std::erase_if(matches, [&](const PlaceMatch& match) { return match.shared_words < least_share * most; });
  for (PlaceMatch& match : matches) match.score = similarity(words, entries_.at(match.id));
  std::sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
    return a.score != b.score ? a.score > b.score : a.id < b.id;
  });
  return matches;
}

}  // namespace rastro
