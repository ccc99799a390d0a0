// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/appearance_search.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/slam/map_budget.h"

namespace rastro {
namespace {

LocationFilterOptions filter_options(const RtabmapOptions& options) {
  LocationFilterOptions filter;
  filter.stays_new = options.stays_new;
  filter.neighbor_sigma = options.neighbor_sigma;
  filter.neighbor_reach = static_cast<int>(std::lround(5.0 * options.neighbor_sigma));
  return filter;
}

// What the parts of an iteration that grow with working memory take on one core of a laptop, so that runs without a
// clock plan alike. Matches do not count: transfer makes none of them shorter.
constexpr double work_of_comparison_ms = 2e-6;  // of two descriptors
constexpr double work_of_location_ms = 3e-4;    // by the Bayes filter
constexpr std::size_t most_similar = 8;         // locations that a lost frame is compared with

/// What a container adds to an element, with its allocation.
constexpr std::size_t bytes_of_node = 40;

/// Without the direct index, which only matching of features needs.
BagOfWords bag_of(const ImageFeatures& image) {
  BagOfWords bag = standard_vocabulary()->words_of(image.features.descriptors);
  bag.nodes = {};
  return bag;
}

bool follows_last(const KeyframeGraph& graph, std::int64_t id) {
  return id > 0 && graph.tracked_motion(id - 1, id, 1).has_value();
}

void add_unless_there(std::vector<std::int64_t>& ids, std::int64_t id) {
  if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
}

}  // namespace

AppearanceSearch::AppearanceSearch(const RtabmapOptions& options, const Means& means)
    : options_(options), means_(means), vocabulary_(options.distance_ratio), filter_(filter_options(options)) {}

/// Words, short-term memory with rehearsal, Bayes filter over working memory, retrieval: one iteration of the method.
LoopSearch::Candidates AppearanceSearch::candidates(const KeyframeGraph& graph, std::int64_t id) {
  clock_.lap_ms();
  immune_.clear();
  words_added_ = words_transferred_ = 0;
  work_ms_ = 0.0;
  // After a loss, where the camera was a moment ago is a place like any other.
  if (!follows_last(graph, id)) shorten_short_term(0);
  remember(graph, id);
  shorten_short_term(options_.short_term_size);
  Random random(seed_for(options_.rgbd.follow.seed, static_cast<std::uint64_t>(id)));
  Candidates candidates{graph.candidates(id, random), {}, {}};
  if (words_.empty()) return candidates;
  const std::vector<std::int64_t> likely = likely_locations();
  if (means_.live) work_ms_ = clock_.lap_ms();
  for (const std::int64_t location : likely) recall(location, candidates);
  const std::int64_t own = memory_.location_of(id);
  for (const std::int64_t location : similar_locations(graph, bag_of(graph.keyframe(id)), own))
    recall(location, candidates);
  return candidates;
}

/// A bad signature has too few features to be recognized by.
bool AppearanceSearch::is_bad(const ImageFeatures& image) const {
  return static_cast<double>(image.features.size()) < options_.bad_signature * features_per_image_;
}

void AppearanceSearch::remember(const KeyframeGraph& graph, std::int64_t id) {
  const ImageFeatures& image = graph.keyframe(id);
  ++images_;
  features_per_image_ +=
      (static_cast<double>(image.features.size()) - features_per_image_) / static_cast<double>(images_);
  words_.clear();
  if (!is_bad(image)) {
    const std::size_t before = vocabulary_.size();
    const std::size_t count = std::min(image.features.size(), static_cast<std::size_t>(options_.words_per_image));
    work_ms_ += work_of_comparison_ms * static_cast<double>(count * vocabulary_.comparisons());
    words_ = vocabulary_.add(image.features, count, means_.pool);
    words_added_ = vocabulary_.size() - before;
  }
  const bool follows = follows_last(graph, id);
  const Location* last = memory_.last();
  if (follows && last && shared_word_ratio(words_, last->words) > options_.rehearsal_similarity) {
    vocabulary_.release(words_);
    words_added_ = 0;
    memory_.rehearse(id);
    return;
  }
  memory_.begin(id, words_, follows);
  waiting_[id] = bag_of(image);
}

void AppearanceSearch::shorten_short_term(int most) {
  while (const auto location = memory_.leave_short_term(most)) {
    const auto& words = memory_.at(*location).words;
    if (!words.empty()) index_.add(*location, words);
    const auto bag = waiting_.find(*location);
    places_.add(*location, bag->second);
    waiting_.erase(bag);
  }
}

/// A budget smaller than short-term memory is kept as well; what was seen last stays for tracking.
std::optional<std::int64_t> AppearanceSearch::leave_early() {
  constexpr int least_size = 1;  // The newest, which tracking and the next match need.
  while (memory_.short_term_size() > least_size) {
    shorten_short_term(memory_.short_term_size() - 1);
    if (const auto least = memory_.least(immune_)) return least;
  }
  return std::nullopt;
}

/// Those of working memory that the Bayes filter believes in, the likeliest first.
std::vector<std::int64_t> AppearanceSearch::likely_locations() {
  const std::vector<LocationScore> scores = index_.scores(words_);
  const auto links = [this](std::int64_t id) { return std::span<const std::int64_t>(memory_.at(id).neighbors); };
  std::vector<LocationScore> likely = filter_.update(scores, links).locations;
  work_ms_ += work_of_location_ms * static_cast<double>(likely.size());
  std::erase_if(likely, [&](const LocationScore& each) { return each.score < options_.loop_probability; });
  std::stable_sort(likely.begin(), likely.end(),
                   [](const LocationScore& a, const LocationScore& b) { return a.score > b.score; });
  std::vector<std::int64_t> ids;
  for (const LocationScore& each : likely)
    if (static_cast<int>(ids.size()) < options_.hypotheses) ids.push_back(each.location);
  return ids;
}

/// By the words that few locations of this map have: where doors and lamps are all of one make, notices tell places
/// apart.
double AppearanceSearch::rare_similarity(const BagOfWords& a, const BagOfWords& b) const {
  const auto rarity = [&](std::uint32_t word) {
    const double share = static_cast<double>(places_.images_with(word) + 1) / static_cast<double>(places_.size() + 1);
    const double bits = std::log(share);
    return bits * bits;
  };
  double of_a = 0.0, of_b = 0.0, shared = 0.0;
  for (const auto& [word, weight] : a.words) of_a += rarity(word);
  for (const auto& [word, weight] : b.words) of_b += rarity(word);
  for (auto i = a.words.begin(), j = b.words.begin(); i != a.words.end() && j != b.words.end();) {
    if (i->first == j->first) shared += rarity(i->first);
    const bool next_a = i->first <= j->first, next_b = j->first <= i->first;
    i += next_a ? 1 : 0, j += next_b ? 1 : 0;
  }
  return std::max(of_a, of_b) > 0.0 ? shared / std::max(of_a, of_b) : 0.0;
}

/// Of all memory, since words that never change find again what was transferred long ago. A score alone has no meaning:
/// the last location says how similar the same place is. The best of the submaps that are not connected yet is always
/// among them: where the camera came often, its own locations are more similar than those of another session.
std::vector<std::int64_t> AppearanceSearch::similar_locations(const KeyframeGraph& graph, const BagOfWords& words,
                                                              std::int64_t own) const {
  if (options_.similar_locations == 0) return {};
  double least = 0.0;
  if (const auto last = waiting_.lower_bound(own); last != waiting_.begin())
    least = options_.least_similarity * similarity(words, std::prev(last)->second);
  constexpr double least_words = 0.5;  // of those shared with the location that shares most
  constexpr std::size_t ranked = 40;
  std::vector<PlaceMatch> matches = places_.find(words, least_words);
  if (matches.size() > ranked) matches.resize(ranked);
  std::erase_if(matches, [&](const PlaceMatch& match) { return match.score < least; });
  for (PlaceMatch& match : matches) match.score = rare_similarity(words, *places_.find_words(match.id));
  std::stable_sort(matches.begin(), matches.end(),
                   [](const PlaceMatch& a, const PlaceMatch& b) { return a.score > b.score; });
  std::vector<std::int64_t> ids;
  for (const PlaceMatch& match : matches)
    if (static_cast<int>(ids.size()) < options_.similar_locations) ids.push_back(match.id);
  if (graph.submap_count() == 1) return ids;
  const auto is_apart = [&](std::int64_t id) { return graph.submap(id) != graph.submap(own); };
  constexpr double least_share = 0.8;  // of the words shared with the best of these
  const auto apart = places_.find(words, least_share, is_apart);
  if (!apart.empty() && apart.front().score >= least) add_unless_there(ids, apart.front().id);
  return ids;
}

/// The location is compared, and neighbors of it come back to working memory: the next images will show them.
void AppearanceSearch::recall(std::int64_t location, Candidates& candidates) {
  auto& nearby = candidates.nearby;
  const bool forgotten = memory_.at(location).stage == MemoryStage::long_term;
  if (forgotten) std::erase(nearby, location);  // only those of places get their features back
  if (std::find(nearby.begin(), nearby.end(), location) == nearby.end()) add_unless_there(candidates.places, location);
  immune_.insert(location);
  if (forgotten) tried_.insert(location);
  constexpr int reach = 2;
  const int most = options_.retrieved_neighbors - static_cast<int>(candidates.retrieve.size());
  for (const std::int64_t id : memory_.forgotten_neighbors(location, reach, std::max(0, most)))
    add_unless_there(candidates.retrieve, id);
}

void AppearanceSearch::on_matched(const KeyframeGraph& graph, std::int64_t id, const Candidates& candidates,
                                  std::span<const Constraint> accepted) {
  const std::int64_t own = memory_.location_of(id);
  std::optional<std::int64_t> closed;
  for (const Constraint& edge : accepted) {
    const std::int64_t other = memory_.location_of(edge.from);
    if (tried_.erase(other) > 0) retrieve(graph, other);
    if (other == own || memory_.at(other).stage == MemoryStage::short_term) continue;
    closed ? memory_.link(own, other) : memory_.close_loop(own, other);
    closed = other;
    immune_.insert(other);
  }
  for (const std::int64_t location : candidates.retrieve) {
    tried_.erase(location);
    retrieve(graph, location);
  }
  place_ = belief_about(id, candidates, accepted);
}

/// Of a bad signature, the filter believes what it did before. Matches with short-term memory say nothing of places.
PlaceBelief AppearanceSearch::belief_about(std::int64_t id, const Candidates& candidates,
                                           std::span<const Constraint> accepted) const {
  PlaceBelief place;
  place.keyframe = id;
  place.new_place = belief().new_place;
  place.threshold = options_.loop_probability;
  if (const LocationScore* best = belief().best()) place.likely = best->location, place.probability = best->score;
  for (const Constraint& edge : accepted) {
    const std::int64_t other = memory_.location_of(edge.from);
    if (other != memory_.location_of(id) && memory_.at(other).stage != MemoryStage::short_term)
      place.accepted.push_back(edge.from);
  }
  for (const std::int64_t location : candidates.places) {
    const bool fits = std::any_of(accepted.begin(), accepted.end(),
                                  [location](const Constraint& edge) { return edge.from == location; });
    if (!fits) place.rejected.push_back(location);
  }
  return place;
}

void AppearanceSearch::retrieve(const KeyframeGraph& graph, std::int64_t location) {
  if (memory_.at(location).stage != MemoryStage::long_term) return;
  const auto& words = memory_.at(location).words;
  const std::size_t before = vocabulary_.size();
  vocabulary_.restore(words, graph.keyframe(location).features);
  words_added_ += vocabulary_.size() - before;
  if (!words.empty()) index_.add(location, words);
  memory_.retrieve(location);
  immune_.insert(location);
}

/// One location a call: what was compared in vain first, then the least of working memory, as many words as were added
/// or came back.
std::vector<std::int64_t> AppearanceSearch::transfer(const KeyframeGraph& /*graph*/, double fill) {
  if (!tried_.empty()) {
    const std::vector<std::int64_t> in_vain(tried_.begin(), tried_.end());
    tried_.clear();
    return in_vain;
  }
  const bool overdue = work_ms_ > options_.time_limit_ms && words_transferred_ <= words_added_;
  const bool full = fill > MapBudget::full_share;
  if (!overdue && !full) return {};
  auto least = memory_.least(immune_);
  if (!least && full) least = leave_early();
  if (!least) return {};
  const std::size_t before = vocabulary_.size();
  vocabulary_.release(memory_.at(*least).words);
  words_transferred_ += std::max<std::size_t>(1, before - vocabulary_.size());
  index_.remove(*least);
  memory_.transfer(*least);
  return memory_.at(*least).keyframes;
}

/// Sizes of the parts. Vectors that grow have half as much again unused.
std::size_t AppearanceSearch::bytes() const {
  // In a bucket of the vocabulary, by its id, and in the index with one or two holders.
  constexpr std::size_t a_word = (sizeof(Descriptor) + sizeof(std::int64_t) + sizeof(int)) * 3 / 2 +
                                 (bytes_of_node + 2 * sizeof(std::int64_t)) +
                                 (bytes_of_node + sizeof(std::vector<int>)) + bytes_of_node;
  const auto words = static_cast<std::size_t>(options_.words_per_image);
  return lasting_bytes() + vocabulary_.size() * a_word + index_.size() * words * sizeof(std::int64_t);
}

/// Of each location its words, its bag of words of the standard vocabulary, and its place in the inverted index of
/// these.
std::size_t AppearanceSearch::lasting_bytes() const {
  const auto words = static_cast<std::size_t>(options_.words_per_image),
             features = static_cast<std::size_t>(options_.rgbd.keyframe_features);
  const std::size_t in_places = features * (sizeof(std::pair<std::uint32_t, float>) * 5 / 2);
  return memory_.size() * (sizeof(Location) + 4 * bytes_of_node + words * sizeof(std::int64_t) + in_places);
}

void AppearanceSearch::know(const Signature& signature, double weight) {
  const ImageFeatures& image = *signature.image;
  if (signature.words.empty() && memory_.last() != nullptr && weight == 0.0) {
    const double whole = memory_.last()->weight;  // as saved, with this keyframe in it
    memory_.rehearse(image.id);
    return memory_.weigh(memory_.location_of(image.id), whole);
  }
  // Ids of words are never given twice.
  vocabulary_.restore(signature.words, image.features);
  vocabulary_.release(signature.words);
  memory_.begin(image.id, signature.words, false);
  memory_.weigh(image.id, weight);
  memory_.leave_short_term(0);
  memory_.transfer(image.id);
  places_.add(image.id, bag_of(image));
}

void AppearanceSearch::know_constraints(std::span<const Constraint> constraints) {
  for (const Constraint& edge : constraints) memory_.link(memory_.location_of(edge.from), memory_.location_of(edge.to));
}

std::vector<std::int64_t> AppearanceSearch::words_of(std::int64_t id) const {
  return memory_.location_of(id) == id ? words_ : std::vector<std::int64_t>{};
}

std::vector<std::pair<std::int64_t, double>> AppearanceSearch::changed_weights() {
  std::vector<std::pair<std::int64_t, double>> weights;
  for (const std::int64_t location : memory_.take_reweighted()) {
    const Location& changed = memory_.at(location);
    weights.emplace_back(location, changed.weight);
    // What looks like a location already adds nothing to it.
    if (changed.keyframes.size() > 1) weights.emplace_back(changed.keyframes.back(), 0.0);
  }
  return weights;
}

/// Of short-term memory too: a camera that was lost is most often where it was a moment ago.
std::vector<std::int64_t> AppearanceSearch::similar(const ImageFeatures& seen) const {
  const BagOfWords words = bag_of(seen);
  std::vector<PlaceMatch> matches = places_.find(words);
  for (const auto& [location, bag] : waiting_)
    if (const double score = similarity(words, bag); score > 0.0) matches.push_back({location, 0, score});
  std::stable_sort(matches.begin(), matches.end(),
                   [](const PlaceMatch& a, const PlaceMatch& b) { return a.score > b.score; });
  std::vector<std::int64_t> ids;
  for (const PlaceMatch& match : matches)
    if (ids.size() < most_similar) ids.push_back(match.id);
  return ids;
}

}  // namespace rastro
