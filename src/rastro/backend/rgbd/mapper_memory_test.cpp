// SPDX-License-Identifier: Apache-2.0
// What the map is said to need, and what a session without room for it does.
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/backend/rgbd/given_map.h"
#include "rastro/backend/rgbd/mapper.h"
#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/optimize/pose_graph.h"

namespace rastro {
namespace {

using testing::edge_of;
using testing::looking;
using testing::room_frame;

/// Two keyframes of a wall, of frames 0 and 7, and the edges found between them.
struct TwoKeyframes {
  TwoKeyframes() {
    const SE3 first = looking({-0.8, -0.4, 1.2}, 0.1), second = looking({-0.8, -0.3, 1.2}, 0.1);
    RgbdSlamOptions options;
    Mapper mapper(options, test_room::camera(), {});
    const KeyframeOrder begin{0, room_frame(first, 0), first, 0, {}, 1};
    const KeyframeOrder next{1, room_frame(second, 7), second, 0, {edge_of(0, 1, first.inverse() * second)}, 8};
    revisions[0] = mapper.add(begin);
    revisions[1] = mapper.add(next);
    for (std::int64_t k = 0; k < 2; ++k) images[k] = mapper.images()->read(k).bytes();
  }
  /// Features with keypoint, descriptor and depth; poses, covariances and edges twice, here and by the tracker; poses,
  /// edges and frames in the map that is being saved, and frames in the trajectory; what optimizing the edges takes.
  std::size_t expected(std::size_t keyframes, std::size_t edges, std::size_t frames) const {
    std::size_t bytes = edges * (3 * sizeof(Constraint) + pose_graph_bytes_per_edge) +
                        frames * 3 * (sizeof(SE3) + 2 * sizeof(std::int64_t));
    for (std::size_t k = 0; k < keyframes; ++k) {
      const std::size_t features = revisions[k].keyframe->features.size();
      bytes += sizeof(ImageFeatures) + features * (sizeof(Keypoint) + sizeof(Descriptor) + sizeof(float)) + images[k] +
               2 * (sizeof(SE3) + sizeof(Matrix6d) + 2 * sizeof(std::shared_ptr<void>)) + sizeof(Keyframe);
    }
    return bytes;
  }

  MapRevision revisions[2];
  std::size_t images[2];
};

/// Wants the features of keyframe 0 out of memory with every keyframe but the third, which needs them.
class ForgettingSearch : public LoopSearch {
 public:
  explicit ForgettingSearch(bool remembers = false) : remembers_(remembers) {}
  bool has_long_term_memory() const override { return remembers_; }
  std::size_t bytes() const override { return 12'345; }
  Candidates candidates(const KeyframeGraph&, std::int64_t id) override {
    newest_ = id;
    if (id == 2) told_ = id;
    return {{}, {}, id == 2 ? std::vector<std::int64_t>{0} : std::vector<std::int64_t>{}};
  }
  std::vector<std::int64_t> transfer(const KeyframeGraph&, double) override {
    const bool first = std::exchange(told_, newest_) != newest_;
    return first ? std::vector<std::int64_t>{0} : std::vector<std::int64_t>{};
  }

 private:
  bool remembers_;
  std::int64_t newest_ = -1, told_ = -1;
};

TEST(Mapper, FeaturesOfAGivenMapStayInMemory) {
  const auto map = std::make_shared<const Map>(make_test_map(3));
  SlamContext context;
  context.map = map;
  Mapper mapper({}, test_room::camera(), context, std::make_unique<ForgettingSearch>());
  const SE3& view = map->keyframes[0].world_from_camera;
  const MapRevision revision =
      mapper.add({3, room_frame(view, 7), view, 0, edge_of(0, 3, SE3(), ConstraintKind::proximity), 1});
  EXPECT_TRUE(revision.forgotten.empty());
  EXPECT_EQ(revision.state.memory.measures, "");
  EXPECT_LT(revision.state.memory.bytes, 10'000'000U);
}

TEST(Mapper, TheMemoryIncludesWhatPlacesAreRecognizedBy) {
  const Mapper mapper({}, test_room::camera(), {}, std::make_unique<ForgettingSearch>());
  EXPECT_EQ(mapper.state().memory.bytes, 12'345U);
}

/// With long-term memory, of which a part has to stay in RAM.
class LastingSearch : public ForgettingSearch {
 public:
  explicit LastingSearch(std::size_t lasting) : ForgettingSearch(true), lasting_(lasting) {}
  std::size_t bytes() const override { return 9'000'000; }
  std::size_t lasting_bytes() const override { return lasting_; }

 private:
  std::size_t lasting_;
};

TEST(Mapper, KeyframesGetSparserWhereWhatCannotMoveOutFillsTheBudget) {
  const SE3 view = looking({-0.8, -0.4, 1.2}, 0.1);
  const auto second_of = [&](std::size_t lasting) {
    SlamContext context;
    context.map_memory_bytes = 10'000'000;
    Mapper mapper({}, test_room::camera(), context, std::make_unique<LastingSearch>(lasting));
    mapper.add({0, room_frame(view, 0), view, 0, {}, 1});
    return mapper.add({1, room_frame(view, 7), view, 0, edge_of(0, 1, SE3()), 8});
  };
  const MapRevision moves_out = second_of(1'000'000), stays = second_of(6'000'000);
  EXPECT_EQ(moves_out.state.spacing, 1.0);
  EXPECT_EQ(moves_out.state.memory.measures.find("sparse"), std::string::npos);
  EXPECT_EQ(stays.state.spacing, 1.5);
  EXPECT_EQ(stays.state.memory.measures.find("keyframes 1.5 times as sparse"), 0U) << stays.state.memory.measures;
  EXPECT_EQ(stays.keyframe->features.size(), moves_out.keyframe->features.size()) << "they can move out";
}

TEST(Mapper, WhatIsGoneWithTheMethodIsTheSearchAndTheOptimization) {
  Mapper mapper({}, test_room::camera(), {}, std::make_unique<ForgettingSearch>());
  const SE3 view = looking({-0.8, -0.4, 1.2}, 0.1);
  mapper.add({0, room_frame(view, 0), view, 0, {}, 1});
  EXPECT_EQ(mapper.state().memory.passing_bytes, 12'345U);
  const MapRevision second = mapper.add({1, room_frame(view, 7), view, 0, edge_of(0, 1, SE3()), 8});
  EXPECT_EQ(second.state.memory.passing_bytes, 12'345U + second.new_edges.size() * pose_graph_bytes_per_edge);
}

TEST(Mapper, FeaturesThatCameBackAreNoLongerInLongTermMemoryAlone) {
  Mapper mapper({}, test_room::camera(), {}, std::make_unique<ForgettingSearch>(true));
  const SE3 view = looking({-0.8, -0.4, 1.2}, 0.1);
  for (std::int64_t id = 0; id < 4; ++id) {
    std::optional<Constraint> path;
    if (id > 0) path = edge_of(id - 1, id, SE3());
    const MapRevision revision = mapper.add({id, room_frame(view, 7 * id), view, 0, path, 1});
    EXPECT_EQ(revision.state.memory.measures, id == 2 ? "" : "features of 1 keyframes in long-term memory alone") << id;
  }
}

/// With the features of its keyframes in long-term memory.
std::shared_ptr<const Map> map_with_signatures() {
  auto map = std::make_shared<Map>(make_test_map(3));
  auto signatures = std::make_shared<SignatureLayer>();
  const auto store = std::make_shared<MemorySignatures>();
  for (const auto& [id, image] : map->layer<FeatureLayer>()->of) {
    store->add(id, {image, {}});
    signatures->keyframes.push_back(id);
  }
  signatures->store = store;
  map->layers.put<SignatureLayer>(std::move(signatures));
  return map;
}

TEST(Mapper, FeaturesOfAMapThatIsContinuedAreInLongTermMemoryAlone) {
  SlamContext context;
  context.map = map_with_signatures();
  context.extend_map = true;
  const RgbdSlamOptions options;
  context = with_usable_map(context, test_room::camera(), options);
  const Mapper mapper(options, test_room::camera(), context, std::make_unique<ForgettingSearch>(true));
  EXPECT_EQ(mapper.state().memory.measures, "features of 3 keyframes in long-term memory alone");
}

TEST(Mapper, TheMemoryIsThatOfKeyframesImagesEdgesAndFrames) {
  const TwoKeyframes made;
  EXPECT_EQ(made.revisions[0].state.memory.bytes, made.expected(1, 0, 1));
  const std::size_t edges = made.revisions[1].new_edges.size();
  EXPECT_EQ(edges, 2U) << "of the path and of the match";
  EXPECT_EQ(made.revisions[1].state.memory.bytes, made.expected(2, edges, 8));
  for (const MapRevision& revision : made.revisions) {
    EXPECT_EQ(revision.state.memory.budget_bytes, 0U) << "no limit";
    EXPECT_EQ(revision.state.spacing, 1.0);
    EXPECT_EQ(revision.state.memory.measures, "");
  }
}

}  // namespace
}  // namespace rastro
