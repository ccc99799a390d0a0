// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rastro/backend/rgbd/keyframe_graph.h"
#include "rastro/base/random.h"
#include "rastro/map/graph/place_belief.h"
#include "rastro/map/signatures/signature_layer.h"

namespace rastro {

/// Where loops are looked for, and which features stay in memory: the part in which the methods for depth cameras
/// differ. Called by the mapper alone, keyframe by keyframe.
class LoopSearch {
 public:
  struct Candidates {
    std::vector<std::int64_t> nearby;    ///< Keyframes to match the new one with, in this order ...
    std::vector<std::int64_t> places;    ///< ... and those that look like it; a rejection of one is told.
    std::vector<std::int64_t> retrieve;  ///< Keyframes whose features come back to memory beside these.
  };

  virtual ~LoopSearch() = default;
  /// Of keyframe `id`, the newest in the graph, which has only its constraints from tracking yet.
  virtual Candidates candidates(const KeyframeGraph& graph, std::int64_t id) = 0;
  /// What matching with these candidates accepted for it. All of them have their features.
  virtual void on_matched(const KeyframeGraph& /*graph*/, std::int64_t /*id*/, const Candidates& /*candidates*/,
                          std::span<const Constraint> /*accepted*/) {}
  /// Keyframes whose features leave memory next; empty: none need or can. `fill`: of the memory budget, 0 without one.
  virtual std::vector<std::int64_t> transfer(const KeyframeGraph& graph, double fill) = 0;

  // For a method that recognizes places.

  /// The next keyframe of a given map, in their order; its features are in long-term memory.
  virtual void know(const Signature& /*signature*/, double /*weight*/) {}
  /// Of a given map; and each that was found without a new keyframe.
  virtual void know_constraints(std::span<const Constraint> /*constraints*/) {}

  /// In memory, of what places are recognized by.
  virtual std::size_t bytes() const { return 0; }
  /// Of these, what stays when all locations that can are in long-term memory.
  virtual std::size_t lasting_bytes() const { return bytes(); }
  /// Features that left memory can be read again: they are in the map, with their words.
  virtual bool has_long_term_memory() const { return false; }
  /// The visual words of the newest keyframe's first features, one each.
  virtual std::vector<std::int64_t> words_of(std::int64_t /*id*/) const { return {}; }
  /// Weights of keyframes that changed since the last call: how many observations of its location each stands for.
  virtual std::vector<std::pair<std::int64_t, double>> changed_weights() { return {}; }
  /// What it took the newest keyframe for; after on_matched().
  virtual std::optional<PlaceBelief> place_belief() const { return std::nullopt; }
  /// Keyframes that look like an image, best first. Changes nothing.
  virtual std::vector<std::int64_t> similar(const ImageFeatures& /*seen*/) const { return {}; }
};

/// By the poses of keyframes, their neighborhood in the graph and at random (Endres et al. 2014).
class GraphSearch : public LoopSearch {
 public:
  explicit GraphSearch(const RgbdSlamOptions& options) : options_(options) {}
  Candidates candidates(const KeyframeGraph& graph, std::int64_t id) override;
  /// From 90 % of the budget on features that others have as well, beyond 100 % those of the oldest.
  std::vector<std::int64_t> transfer(const KeyframeGraph& graph, double fill) override;

 private:
  RgbdSlamOptions options_;
};

}  // namespace rastro
