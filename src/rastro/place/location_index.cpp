// SPDX-License-Identifier: Apache-2.0
#include "rastro/place/location_index.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "rastro/base/error.h"

namespace rastro {
namespace {

std::vector<std::int64_t> sorted(std::span<const std::int64_t> words) {
  std::vector<std::int64_t> ascending(words.begin(), words.end());
  std::sort(ascending.begin(), ascending.end());
  return ascending;
}

/// Calls f(word, count) for each word, ascending.
template <typename F>
void for_each_word(const std::vector<std::int64_t>& ascending, const F& f) {
  for (auto at = ascending.begin(); at != ascending.end();) {
    const auto end = std::upper_bound(at, ascending.end(), *at);
    f(*at, static_cast<int>(end - at));
    at = end;
  }
}

}  // namespace

double shared_word_ratio(std::span<const std::int64_t> a, std::span<const std::int64_t> b) {
  if (a.empty() || b.empty()) return 0.0;
  const std::vector<std::int64_t> of_a = sorted(a), of_b = sorted(b);
  std::vector<std::int64_t> both;
  std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(both));
  return static_cast<double>(both.size()) / static_cast<double>(std::max(a.size(), b.size()));
}

void LocationIndex::add(std::int64_t location, std::span<const std::int64_t> words) {
  RASTRO_CHECK(!contains(location), "a location can be added only once");
  std::vector<std::int64_t>& kept = words_of_[location] = sorted(words);
  const auto insert = [location](std::vector<Holder>& holders, int count) {
    const auto at = std::upper_bound(holders.begin(), holders.end(), location,
                                     [](std::int64_t id, const Holder& holder) { return id < holder.location; });
    holders.insert(at, {location, count});
  };
  for_each_word(kept, [&](std::int64_t word, int count) { insert(holders_[word], count); });
  insert(sizes_, static_cast<int>(kept.size()));
}

void LocationIndex::remove(std::int64_t location) {
  const auto found = words_of_.find(location);
  if (found == words_of_.end()) return;
  for_each_word(found->second, [&](std::int64_t word, int) {
    const auto holders = holders_.find(word);
    std::erase_if(holders->second, [&](const Holder& holder) { return holder.location == location; });
    if (holders->second.empty()) holders_.erase(holders);
  });
  words_of_.erase(found);
  std::erase_if(sizes_, [&](const Holder& each) { return each.location == location; });
}

std::vector<LocationScore> LocationIndex::scores(std::span<const std::int64_t> words) const {
  std::vector<LocationScore> scores;
  if (sizes_.empty()) return scores;
  const std::int64_t first = sizes_.front().location;
  std::vector<double> sums(static_cast<std::size_t>(sizes_.back().location - first + 1));
  const auto sum_of = [&](std::int64_t location) -> double& {
    return sums[static_cast<std::size_t>(location - first)];
  };
  const auto locations = static_cast<double>(size());
  for_each_word(sorted(words), [&](std::int64_t word, int repeated) {
    const auto holders = holders_.find(word);
    if (holders == holders_.end()) return;
    const double rarity = std::log(locations / static_cast<double>(holders->second.size()));
    for (const Holder& holder : holders->second) sum_of(holder.location) += repeated * holder.count * rarity;
  });
  scores.reserve(sizes_.size());
  for (const auto& [location, words_in] : sizes_)
    scores.push_back({location, words_in == 0 ? 0.0 : sum_of(location) / words_in});
  return scores;
}

}  // namespace rastro
