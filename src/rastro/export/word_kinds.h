// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro {

/// What a visual word is in the image of a location, as Labbe and Michaud 2013 color them. The first that applies, from
/// the last to the first: a word that both matched images share is `shared` whatever else it is, one that the previous
/// location has too is `previous` even if it is there several times, and one that is there several times is `repeated`
/// even if no earlier location has it.
enum class WordKind : std::uint8_t {
  known,     ///< An earlier location has it: in the vocabulary; red.
  fresh,     ///< No earlier location has it: new; green.
  repeated,  ///< More than one feature of this image has it; yellow.
  previous,  ///< The location before has it; blue.
  shared,    ///< The matched earlier location has it; pink.
};
constexpr std::size_t word_kinds = 5;
constexpr std::size_t index_of(WordKind kind) { return static_cast<std::size_t>(kind); }

/// A location: a keyframe with its visual words, and the loop closure with an earlier one, if any.
struct LocationWords {
  KeyframeId location = no_keyframe;
  /// Of its features with words, one each, in the order of the signature; nullopt: a feature without a word.
  std::vector<std::optional<WordKind>> kinds;
  KeyframeId matched = no_keyframe;   ///< The earlier location.
  std::optional<Constraint> closure;  ///< The constraint between them, of keyframes of both; nullopt: none.

  std::array<int, word_kinds> counts() const;  ///< Features of each kind.
};

/// The locations of a map in the order in which they were made, from its signatures: every keyframe with a signature
/// but those that only added to the weight of the location before. The match of a location is the loop closure (or
/// merge of submaps) with the most inliers between one of its keyframes and one of an earlier location, of equals the
/// one found first. Empty where the map has no signatures. Error for a signature that cannot be read.
std::vector<LocationWords> words_of_locations(const Map& map);

/// The words of an earlier location as a later one sees them: `shared` where it has them too, `known` otherwise.
std::vector<std::optional<WordKind>> kinds_seen_from(std::span<const std::int64_t> later,
                                                     std::span<const std::int64_t> earlier);

}  // namespace rastro
