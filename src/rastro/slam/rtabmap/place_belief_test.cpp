// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "rastro/base/random.h"
#include "rastro/slam/rtabmap/appearance_search.h"

namespace rastro {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

/// Only by what they look like.
RtabmapOptions by_appearance() {
  RtabmapOptions options;
  options.rgbd.near_candidates = options.rgbd.graph_candidates = options.rgbd.last_candidates = 0;
  return options;
}

/// A camera that sees places, each with features of its own and some of the place before it; it is lost in between, so
/// that each leaves short-term memory at once.
class Places {
 public:
  Places() : options_(by_appearance()), graph_(options_.rgbd, 0), search_(options_, {}) {}

  /// The next keyframe sees a place; `matches`: keyframes that it is then matched with.
  PlaceBelief see(std::uint64_t place, const std::vector<std::int64_t>& matches = {}) {
    const std::int64_t id = graph_.size();
    auto image = std::make_shared<ImageFeatures>();
    image->id = id;
    add_features(place, 40, *image);
    add_features(place - 1, 8, *image);
    graph_.add(std::move(image), {}, Matrix6d::Identity());
    const auto candidates = search_.candidates(graph_, id);
    std::vector<Constraint> accepted;
    for (const std::int64_t other : matches)
      accepted.push_back({other, id, {}, Matrix6d::Identity(), ConstraintKind::loop});
    search_.on_matched(graph_, id, candidates, accepted);
    return search_.place_belief().value();
  }
  const AppearanceSearch& search() const { return search_; }

 private:
  /// The first features of a place, which are the same whenever it is seen.
  static void add_features(std::uint64_t place, int count, ImageFeatures& image) {
    Random random(place);
    for (int k = 0; k < count; ++k) {
      Descriptor descriptor;
      for (auto& word : descriptor.words) word = random.next();
      image.features.keypoints.emplace_back();
      image.features.descriptors.push_back(descriptor);
    }
  }

  RtabmapOptions options_;
  KeyframeGraph graph_;
  AppearanceSearch search_;
};

TEST(PlaceBelief, OfAPlaceThatIsSeenAgain) {
  Places places;
  PlaceBelief belief = places.see(100);
  EXPECT_EQ(belief.keyframe, 0);
  EXPECT_EQ(belief.new_place, 1.0);
  EXPECT_EQ(belief.likely, no_keyframe);
  EXPECT_EQ(belief.threshold, RtabmapOptions().loop_probability);
  for (std::uint64_t place = 101; place < 108; ++place) belief = places.see(place);
  EXPECT_THAT(belief.accepted, IsEmpty());

  belief = places.see(102);
  EXPECT_EQ(belief.keyframe, 8);
  const LocationFilter::Belief& filtered = places.search().belief();
  EXPECT_EQ(belief.new_place, filtered.new_place);
  EXPECT_EQ(belief.likely, filtered.best()->location);
  EXPECT_EQ(belief.probability, filtered.best()->score);
  EXPECT_GT(belief.probability, 0.0);
  EXPECT_THAT(belief.rejected, Contains(2)) << "compared, and no match was told of";
  EXPECT_THAT(belief.accepted, IsEmpty());

  belief = places.see(102, {2});
  EXPECT_THAT(belief.accepted, ElementsAre(2));
  EXPECT_THAT(belief.rejected, Not(Contains(2)));
}

TEST(PlaceBelief, IsThereOnceAKeyframeWasMatched) {
  const AppearanceSearch search({}, {});
  EXPECT_FALSE(search.place_belief());
}

}  // namespace
}  // namespace rastro
