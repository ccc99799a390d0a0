// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "rastro/backend/rgbd/loop_search.h"
#include "rastro/base/stopwatch.h"
#include "rastro/base/task_pool.h"
#include "rastro/place/location_filter.h"
#include "rastro/place/location_index.h"
#include "rastro/place/place_index.h"
#include "rastro/place/visual_words.h"
#include "rastro/slam/rtabmap/location_memory.h"
#include "rastro/slam/rtabmap/options.h"

namespace rastro {

/// Recognizes places by their visual words, and decides which locations stay in working memory so that the time per
/// location stays bounded (Labbe and Michaud 2013). Offline it counts work instead of time, so that every run does the
/// same.
class AppearanceSearch : public LoopSearch {
 public:
  struct Means {
    TaskPool* pool = nullptr;
    bool live = false;  ///< By the clock.
  };
  AppearanceSearch(const RtabmapOptions& options, const Means& means);

  Candidates candidates(const KeyframeGraph& graph, std::int64_t id) override;
  void on_matched(const KeyframeGraph& graph, std::int64_t id, const Candidates& candidates,
                  std::span<const Constraint> accepted) override;
  std::vector<std::int64_t> transfer(const KeyframeGraph& graph, double fill) override;
  std::size_t bytes() const override;
  std::size_t lasting_bytes() const override;
  bool has_long_term_memory() const override { return true; }
  void know(const Signature& signature, double weight) override;
  void know_constraints(std::span<const Constraint> constraints) override;
  std::vector<std::int64_t> words_of(std::int64_t id) const override;
  std::vector<std::pair<std::int64_t, double>> changed_weights() override;
  std::optional<PlaceBelief> place_belief() const override { return place_; }
  std::vector<std::int64_t> similar(const ImageFeatures& seen) const override;

  const LocationMemory& memory() const { return memory_; }
  const LocationFilter::Belief& belief() const { return filter_.belief(); }
  /// Of the last keyframe, by the count that decides about transfer: words and Bayes filter.
  double work_ms() const { return work_ms_; }

 private:
  bool is_bad(const ImageFeatures& image) const;
  double rare_similarity(const BagOfWords& a, const BagOfWords& b) const;
  void remember(const KeyframeGraph& graph, std::int64_t id);
  void shorten_short_term(int most);
  std::optional<std::int64_t> leave_early();
  std::vector<std::int64_t> likely_locations();
  std::vector<std::int64_t> similar_locations(const KeyframeGraph& graph, const BagOfWords& words,
                                              std::int64_t own) const;
  void recall(std::int64_t location, Candidates& candidates);
  void retrieve(const KeyframeGraph& graph, std::int64_t location);
  PlaceBelief belief_about(std::int64_t id, const Candidates& candidates, std::span<const Constraint> accepted) const;

  RtabmapOptions options_;
  Means means_;
  VisualWords vocabulary_;
  LocationMemory memory_;
  LocationIndex index_;  ///< Of working memory, by the words of vocabulary_.
  LocationFilter filter_;
  /// Of all locations out of short-term memory, by the words of the standard vocabulary, which never change.
  PlaceIndex places_;
  std::map<std::int64_t, BagOfWords> waiting_;  ///< Of short-term memory.
  std::vector<std::int64_t> words_;             ///< Of the newest keyframe.
  std::set<std::int64_t> immune_;               ///< Against transfer, for one keyframe.
  std::set<std::int64_t> tried_;                ///< In long-term memory, but compared with the newest keyframe.
  double features_per_image_ = 0.0;             ///< Mean.
  std::int64_t images_ = 0;
  std::size_t words_added_ = 0, words_transferred_ = 0;  ///< With the newest keyframe.
  std::optional<PlaceBelief> place_;                     ///< About the newest keyframe.
  double work_ms_ = 0.0;
  Stopwatch clock_;
};

}  // namespace rastro
