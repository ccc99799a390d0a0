// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

namespace rastro {

/// Where a location is (Labbe and Michaud 2013, figure 1).
enum class MemoryStage : std::uint8_t {
  short_term,  ///< The latest ones: no loop is looked for in them, since they look alike.
  working,     ///< Loops are looked for in them.
  long_term,   ///< In the map file only.
};

/// One place as it was seen: consecutive keyframes that look alike, represented by the first.
struct Location {
  std::vector<std::int64_t> keyframes;
  std::vector<std::int64_t> words;  ///< Visual words of the first keyframe, one per feature quantized.
  double weight = 1.0;              ///< Number of observations that it stands for.
  MemoryStage stage = MemoryStage::short_term;
  std::int64_t entered = 0;             ///< When it entered working memory last, counted in locations.
  std::vector<std::int64_t> neighbors;  ///< Consecutive locations, and those of loops; in the order found.
};

/// The memory of locations by stage, with the rules by which they move: rehearsal, transfer, retrieval (Labbe and
/// Michaud 2013, sections III-B and III-F). Knows no features. The id of a location is that of its first keyframe.
class LocationMemory {
 public:
  /// Begins a location with a keyframe, linked to the last one unless the camera was lost in between.
  void begin(std::int64_t keyframe, std::vector<std::int64_t> words, bool linked);
  /// Rehearsal: the keyframe is one more observation of the last location.
  void rehearse(std::int64_t keyframe);
  /// The oldest location of a short-term memory that is longer than `most` enters working memory; nullopt: none.
  std::optional<std::int64_t> leave_short_term(int most);
  /// A loop was closed: links both, and the newer one takes over the weight of the earlier one.
  void close_loop(std::int64_t newer, std::int64_t earlier);
  void link(std::int64_t a, std::int64_t b);
  void weigh(std::int64_t location, double weight) { own(location).weight = weight; }
  void transfer(std::int64_t location);
  void retrieve(std::int64_t location);

  /// The location in working memory with the smallest weight, of these the one that entered it first; none of
  /// `immune`. nullopt: there is no other.
  std::optional<std::int64_t> least(const std::set<std::int64_t>& immune) const;
  /// Locations in long-term memory linked to one over at most `reach` links, the nearest first, at most `most`.
  std::vector<std::int64_t> forgotten_neighbors(std::int64_t location, int reach, int most) const;

  const Location& at(std::int64_t location) const { return locations_.at(location); }
  bool contains(std::int64_t location) const { return locations_.contains(location); }
  /// Of a keyframe.
  std::int64_t location_of(std::int64_t keyframe) const { return location_of_.at(keyframe); }
  /// Null before the first.
  const Location* last() const { return locations_.empty() ? nullptr : &locations_.at(last_); }
  std::size_t size() const { return locations_.size(); }
  int short_term_size() const { return static_cast<int>(short_term_.size()); }
  const std::set<std::int64_t>& working() const { return working_; }
  /// Locations whose weight changed since the last call, ascending.
  std::vector<std::int64_t> take_reweighted();

 private:
  Location& own(std::int64_t location) { return locations_.at(location); }

  std::unordered_map<std::int64_t, Location> locations_;
  std::int64_t last_ = 0;                                       ///< The newest.
  std::unordered_map<std::int64_t, std::int64_t> location_of_;  ///< By keyframe.
  std::deque<std::int64_t> short_term_;
  std::set<std::int64_t> working_;
  std::set<std::int64_t> reweighted_;
  std::int64_t entries_ = 0;  ///< Into working memory, so far.
};

}  // namespace rastro
