// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/word_kinds.h"

#include <algorithm>
#include <map>
#include <set>

#include "rastro/map/signatures/signature_layer.h"

namespace rastro {
namespace {

using Words = std::vector<std::int64_t>;

/// By keyframe, the location that it belongs to.
using LocationOf = std::map<KeyframeId, KeyframeId>;

/// The words of an image, each once, with the number of features that have it.
std::map<std::int64_t, int> uses_of(const Words& words) {
  std::map<std::int64_t, int> uses;
  for (const std::int64_t word : words)
    if (word >= 0) ++uses[word];
  return uses;
}

std::set<std::int64_t> distinct(std::span<const std::int64_t> words) { return {words.begin(), words.end()}; }

bool closes_loop(const Constraint& constraint) {
  return constraint.kind == ConstraintKind::loop || constraint.kind == ConstraintKind::merge ||
         constraint.kind == ConstraintKind::inter_robot;
}

/// What the words of one location are told apart by.
struct Known {
  std::set<std::int64_t> earlier, previous, matched;
};

WordKind kind_of(std::int64_t word, int uses, const Known& known) {
  if (known.matched.contains(word)) return WordKind::shared;
  if (known.previous.contains(word)) return WordKind::previous;
  if (uses > 1) return WordKind::repeated;
  return known.earlier.contains(word) ? WordKind::known : WordKind::fresh;
}

std::vector<std::optional<WordKind>> kinds_of(const Words& words, const Known& known) {
  const auto uses = uses_of(words);
  std::vector<std::optional<WordKind>> kinds;
  for (const std::int64_t word : words)
    kinds.push_back(word < 0 ? std::nullopt : std::optional(kind_of(word, uses.at(word), known)));
  return kinds;
}

/// A keyframe that looked like the location before has no words and stands for no observation.
bool is_location(const Keyframe& keyframe, const Words& words, bool first) {
  return first || !words.empty() || keyframe.weight > 0.0;
}

void note_closure(const Constraint& constraint, const LocationOf& location_of,
                  std::map<KeyframeId, LocationWords*>& locations) {
  const auto from = location_of.find(constraint.from), to = location_of.find(constraint.to);
  if (!closes_loop(constraint) || from == location_of.end() || to == location_of.end()) return;
  const auto [earlier, later] = std::minmax(from->second, to->second);
  LocationWords& own = *locations.at(later);
  if (earlier == later || (own.closure && own.closure->inliers >= constraint.inliers)) return;
  own.matched = earlier;
  own.closure = constraint;
}

void find_closures(const Map& map, const LocationOf& location_of, std::vector<LocationWords>& all) {
  std::map<KeyframeId, LocationWords*> locations;
  for (LocationWords& each : all) locations[each.location] = &each;
  for (const Constraint& constraint : map.constraints) note_closure(constraint, location_of, locations);
}

}  // namespace

std::array<int, word_kinds> LocationWords::counts() const {
  std::array<int, word_kinds> counts{};
  for (const auto& kind : kinds)
    if (kind) ++counts[index_of(*kind)];
  return counts;
}

std::vector<LocationWords> words_of_locations(const Map& map) {
  const auto layer = map.layer<SignatureLayer>();
  std::vector<LocationWords> all;
  if (!layer) return all;
  LocationOf location_of;
  for (const KeyframeId id : layer->keyframes) {
    const Keyframe* keyframe = map.find(id);
    if (!keyframe) continue;
    if (is_location(*keyframe, layer->store->read(id).words, all.empty())) all.push_back({id, {}, no_keyframe, {}});
    location_of[id] = all.back().location;
  }
  find_closures(map, location_of, all);
  Known known;
  for (LocationWords& location : all) {
    const Words words = layer->store->read(location.location).words;
    known.matched.clear();
    if (location.closure) known.matched = distinct(layer->store->read(location.matched).words);
    location.kinds = kinds_of(words, known);
    known.previous = distinct(words);
    known.earlier.insert(words.begin(), words.end());
  }
  return all;
}

std::vector<std::optional<WordKind>> kinds_seen_from(std::span<const std::int64_t> later,
                                                     std::span<const std::int64_t> earlier) {
  const std::set<std::int64_t> there = distinct(later);
  std::vector<std::optional<WordKind>> kinds;
  for (const std::int64_t word : earlier) {
    const WordKind kind = there.contains(word) ? WordKind::shared : WordKind::known;
    kinds.push_back(word < 0 ? std::nullopt : std::optional(kind));
  }
  return kinds;
}

}  // namespace rastro
