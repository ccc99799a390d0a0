// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/mapper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <set>

#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/base/error.h"

namespace rastro {
namespace {

using testing::edge_of;
using testing::looking;
using testing::pose_near;
using testing::room_frame;
using testing::unknown_frame;

/// An archive that records the calls.
class RecordingArchive : public MapArchive {
 public:
  bool wants_map() const override { return true; }
  void keep(std::shared_ptr<const Map> map) override { maps.push_back(std::move(map)); }
  void add_images(KeyframeId keyframe, PackedImages images) override {
    keyframes.push_back(keyframe);
    kept->add(keyframe, std::move(images));
  }
  std::shared_ptr<const ImageStore> images() const override { return kept; }

  std::vector<KeyframeId> keyframes;
  std::vector<std::shared_ptr<const Map>> maps;
  std::shared_ptr<MemoryImages> kept = std::make_shared<MemoryImages>();
};

KeyframeOrder order_of(std::int64_t id, const SE3& world_from_camera, const SE3& shown_from,
                       const std::optional<Constraint>& constraint = {}, int submap = 0) {
  return {id, room_frame(shown_from, 10 * id), world_from_camera, submap, constraint};
}

/// Of those that a revision tells.
const SE3& pose_in(const MapRevision& revision, std::int64_t keyframe) {
  return revision.graph.poses.at(static_cast<std::size_t>(keyframe - revision.graph.first_pose)).world_from_camera;
}

bool has_event(const MapRevision& revision, const std::string& kind) {
  return std::any_of(revision.events.begin(), revision.events.end(),
                     [&](const SlamEvent& event) { return event.kind == kind; });
}

int edges_of_kind(const MapRevision& revision, ConstraintKind kind) {
  return static_cast<int>(std::count_if(revision.new_edges.begin(), revision.new_edges.end(),
                                        [&](const Constraint& edge) { return edge.kind == kind; }));
}

/// In front of the wall at x = 2, facing it and the floor, `step` decimeters to the side.
SE3 beside(int step) { return looking({-0.8, -0.4 + 0.1 * step, 1.2}, 0.15 - 0.03 * step); }

TEST(Mapper, TheFirstKeyframeHasTheTrackersPose) {
  Mapper mapper({}, test_room::camera(), {});
  const MapRevision revision = mapper.add(order_of(0, beside(0), beside(0)));
  ASSERT_TRUE(revision.keyframe);
  EXPECT_EQ(revision.keyframe->id, 0);
  EXPECT_GT(revision.keyframe->features.size(), 100U);
  ASSERT_EQ(revision.graph.poses.size(), 1U);
  EXPECT_THAT(pose_in(revision, 0), pose_near(beside(0), 0.0, 0.0));
  EXPECT_TRUE(revision.new_edges.empty());
  EXPECT_TRUE(revision.events.empty());
  EXPECT_EQ(revision.covariance.norm(), 0.0);
  EXPECT_THROW(mapper.add(order_of(2, beside(0), beside(0))), std::exception) << "one is left out";
}

/// Odometry with an error of 8 cm and a matching covariance: matches with earlier keyframes correct it.
TEST(Mapper, MatchesCorrectOdometryErrors) {
  RgbdSlamOptions options;
  Mapper mapper(options, test_room::camera(), {});
  MapRevision revision = mapper.add(order_of(0, beside(0), beside(0)));
  SE3 tracked = beside(0);
  for (int k = 1; k < 4; ++k) {
    const SE3 measured = beside(k - 1).inverse() * beside(k) * SE3(SO3::exp({0.0, 0.02, 0.0}), {0.06, 0.0, 0.05});
    tracked = tracked * measured;
    revision =
        mapper.add(order_of(k, tracked, beside(k), edge_of(k - 1, k, measured, ConstraintKind::odometry, 0.1, 0.05)));
    EXPECT_EQ(edges_of_kind(revision, ConstraintKind::odometry), 1);
    EXPECT_GE(edges_of_kind(revision, ConstraintKind::proximity), 1) << k;
    EXPECT_EQ(edges_of_kind(revision, ConstraintKind::loop), 0);
    EXPECT_TRUE(revision.events.empty()) << "no loop, so the map behind the last keyframes stays";
  }
  EXPECT_GT((tracked.translation() - beside(3).translation()).norm(), 0.15);
  for (int k = 0; k < 4; ++k) EXPECT_THAT(pose_in(revision, k), pose_near(beside(k), 0.03, 0.012)) << k;
  EXPECT_GT(revision.covariance.trace(), 0.0);
  EXPECT_LT(revision.covariance.diagonal().head(3).sum(), 3.0 * 0.1 * 0.1) << "surer than by odometry alone";
}

TEST(Mapper, MatchesThatContradictSureTrackingAreRefused) {
  for (const double sigma_m : {0.002, 0.1}) {
    Mapper mapper({}, test_room::camera(), {});
    mapper.add(order_of(0, beside(0), beside(0)));
    // Tracking says that the camera stands still; what it sees moves.
    const MapRevision revision = mapper.add(
        order_of(1, beside(0), beside(2), edge_of(0, 1, SE3(), ConstraintKind::odometry, sigma_m, 0.5 * sigma_m)));
    const SE3& pose = pose_in(revision, 1);
    if (sigma_m < 0.01) {
      EXPECT_EQ(edges_of_kind(revision, ConstraintKind::proximity), 0);
      EXPECT_THAT(pose, pose_near(beside(0), 1e-9, 1e-9));
    } else {
      EXPECT_EQ(edges_of_kind(revision, ConstraintKind::proximity), 1);
      EXPECT_THAT(pose, pose_near(beside(2), 0.03, 0.012));
    }
  }
}

/// Whether a keyframe that no odometry connects is matched where it is placed so far beside where it is.
bool matched_beside(double off_m) {
  RgbdSlamOptions options;
  options.loop_drift_share = options.loop_drift_rad_per_m = 0.05;
  options.loop_max_sigmas = 3.0;
  Mapper mapper(options, test_room::camera(), {});
  mapper.add(order_of(0, beside(0), beside(0)));
  SE3 moved = beside(0).inverse() * beside(1);
  moved = SE3(moved.rotation(), moved.translation() + off_m * moved.translation().normalized());
  const MapRevision revision =
      mapper.add(order_of(1, beside(1), beside(1), edge_of(0, 1, moved, ConstraintKind::loop, 0.1, 0.05)));
  return edges_of_kind(revision, ConstraintKind::proximity) == 1;
}

/// Three sigmas of 5 % of the path, 0.13 m with its rotation, and of a meter more over which tracking may slip.
TEST(Mapper, WithoutOdometryAMatchMayBeAsFarOffAsTheDriftOfThePathAndAMeter) {
  EXPECT_TRUE(matched_beside(0.185));
  EXPECT_FALSE(matched_beside(0.215));
}

/// What happens when the camera comes back to a room. Views of another scene lie between: only odometry connects them.
/// Which of the four is compared is random, so it comes back with up to 30 seeds.
MapRevision way_back(RgbdSlamOptions options, const SlamContext& context = {}) {
  options.loop_steps = 4;
  options.last_candidates = options.graph_candidates = options.near_candidates = 0;
  options.random_candidates = 1;
  MapRevision revision;
  for (std::uint64_t seed = 1; seed < 30 && !has_event(revision, "loop_closed"); ++seed) {
    options.follow.seed = seed;
    Mapper mapper(options, test_room::camera(), context);
    mapper.add(order_of(0, beside(0), beside(0)));
    SE3 tracked = beside(0);
    for (int k = 1; k < 5; ++k) {
      EXPECT_FALSE(has_event(revision, "loop_closed"));
      const SE3 moved(SO3::exp({0.0, 0.02, 0.0}), {0.03, 0.0, 0.0});
      tracked = tracked * moved;
      KeyframeOrder order =
          order_of(k, tracked, beside(1), edge_of(k - 1, k, moved, ConstraintKind::odometry, 0.05, 0.03));
      if (k < 4) order.frame = unknown_frame(static_cast<std::uint64_t>(k));
      revision = mapper.add(order);
    }
  }
  return revision;
}

TEST(Mapper, ALoopNeedsInliersOfItsOwnNumber) {
  RgbdSlamOptions options;
  options.few_features = "refuse";
  options.loop_inliers = 5000;
  EXPECT_EQ(edges_of_kind(way_back(options), ConstraintKind::loop), 0);
  std::swap(options.min_inliers, options.loop_inliers);
  EXPECT_EQ(edges_of_kind(way_back(options), ConstraintKind::loop), 1);
}

TEST(Mapper, AMatchFarAlongTheGraphIsALoopAndMovesAll) {
  const MapRevision revision = way_back({});
  ASSERT_TRUE(has_event(revision, "loop_closed"));
  EXPECT_TRUE(has_event(revision, "map_revised"));
  ASSERT_EQ(edges_of_kind(revision, ConstraintKind::loop), 1);
  EXPECT_THAT(pose_in(revision, 0).inverse() * pose_in(revision, 4),
              pose_near(beside(0).inverse() * beside(1), 0.04, 0.02));
  const SE3 between = pose_in(revision, 1).inverse() * pose_in(revision, 2);
  EXPECT_GT((between.translation() - Eigen::Vector3d(0.03, 0.0, 0.0)).norm(), 1e-4) << "the others share the error";
}

TEST(Mapper, AStoppedRunKeepsALoopWithoutMovingAll) {
  const std::atomic<bool> stop = true;
  SlamContext context;
  context.stop = &stop;
  const MapRevision revision = way_back({}, context);
  EXPECT_EQ(edges_of_kind(revision, ConstraintKind::loop), 1);
  EXPECT_FALSE(has_event(revision, "map_revised"));
}

TEST(Mapper, TwoSubmapsOfTheSamePlaceAreMerged) {
  RgbdSlamOptions options;
  Mapper mapper(options, test_room::camera(), {});
  mapper.add(order_of(0, beside(0), beside(0)));
  const SE3 guess(SO3::exp({0.0, 0.0, 1.0}), {7.0, 3.0, 0.0});
  KeyframeOrder elsewhere = order_of(1, guess, beside(0), {}, 1);
  elsewhere.frame = unknown_frame(4);
  MapRevision revision = mapper.add(elsewhere);
  EXPECT_EQ(revision.graph.poses.back().submap, 1);
  EXPECT_TRUE(revision.events.empty());
  // From there the camera moves to a view of the first submap.
  const SE3 step(SO3::exp({0.0, 0.3, 0.0}), {0.2, 0.0, 0.1});
  revision = mapper.add(order_of(2, guess * step, beside(1), edge_of(1, 2, step), 1));
  EXPECT_TRUE(has_event(revision, "joined"));
  ASSERT_EQ(edges_of_kind(revision, ConstraintKind::merge), 1);
  for (const KeyframePose& pose : revision.graph.poses) EXPECT_EQ(pose.submap, 0) << "the smallest number wins";
  EXPECT_THAT(pose_in(revision, 0), pose_near(beside(0), 0.0, 1e-12)) << "the first stays";
  EXPECT_THAT(pose_in(revision, 2), pose_near(beside(1), 0.02, 0.01)) << "in the frame of the first";
  EXPECT_THAT(pose_in(revision, 1).inverse() * pose_in(revision, 2), pose_near(step, 0.005, 0.003))
      << "connected keyframes are transformed with it";
}

TEST(Mapper, MaskedPixelsAreNeitherMatchedNorKept) {
  Mapper mapper({}, test_room::camera(), {});
  KeyframeOrder order = order_of(0, beside(0), beside(0));
  order.frame.mask = GrayImage(320, 240);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) order.frame.mask.at(x, y) = x < 160 ? 255 : 0;
  const MapRevision revision = mapper.add(order);
  for (const Keypoint& point : revision.keyframe->features.keypoints) EXPECT_LT(std::lround(point.x), 160);
  const UnpackedImages kept = unpack_images(mapper.images()->read(0), "test");
  for (int y = 0; y < 240; y += 7) {
    EXPECT_EQ(kept.depth.at(200, y), 0.0F);
    EXPECT_NEAR(kept.depth.at(100, y), order.frame.depth.at(100, y), 2e-4F);
  }
}

TEST(Mapper, ImagesOfALocalizationsOwnKeyframesAreKeptBesideThoseOfTheMap) {
  SlamContext context;
  context.map = std::make_shared<const Map>(make_test_map(2));
  Mapper mapper({}, test_room::camera(), context);
  const KeyframeOrder order = order_of(2, beside(0), beside(0));
  mapper.add(order);
  const UnpackedImages kept = unpack_images(mapper.images()->read(2), "test");
  EXPECT_NEAR(kept.depth.at(100, 100), order.frame.depth.at(100, 100), 2e-4F);
  EXPECT_EQ(mapper.images()->read(1), images_of(*context.map)->read(1));
}

TEST(Mapper, TheArchiveGetsTheImagesAndEachRevisionHasTheNewEdges) {
  RecordingArchive archive;
  SlamContext context;
  context.archive = &archive;
  RgbdSlamOptions options;
  options.graph_window = 2;
  Mapper mapper(options, test_room::camera(), context);
  MapRevision revision = mapper.add(order_of(0, beside(0), beside(0)));
  std::size_t edges = 0;
  for (int k = 1; k < 3; ++k) {
    revision = mapper.add(order_of(k, beside(k), beside(k), edge_of(k - 1, k, beside(k - 1).inverse() * beside(k))));
    edges += revision.new_edges.size();
    EXPECT_GE(revision.graph.weights.size(), revision.new_edges.size());
    EXPECT_EQ(revision.graph.weights.back().edge, edges - 1) << "the newest, and those beside it";
    EXPECT_EQ(revision.graph.first_pose, k - 1) << "so many are optimized";
    EXPECT_EQ(revision.graph.poses.size(), 2U);
  }
  EXPECT_EQ(archive.keyframes, (std::vector<KeyframeId>{0, 1, 2}));
  EXPECT_EQ(mapper.images(), archive.kept) << "images are there, not in memory";
  EXPECT_TRUE(archive.maps.empty()) << "the map is the tracker's to hand over";
  revision = mapper.settle();
  EXPECT_FALSE(revision.keyframe);
  EXPECT_TRUE(has_event(revision, "map_revised"));
  EXPECT_EQ(revision.graph.poses.size(), 3U);
  EXPECT_EQ(revision.graph.weights.size(), edges);
}

TEST(Mapper, AStoppedRunIsNotOptimizedAtItsEnd) {
  std::atomic<bool> stop = false;
  SlamContext context;
  context.stop = &stop;
  Mapper mapper({}, test_room::camera(), context);
  mapper.add(order_of(0, beside(0), beside(0)));
  mapper.add(order_of(1, beside(1), beside(1), edge_of(0, 1, beside(0).inverse() * beside(1))));
  stop = true;
  const MapRevision revision = mapper.settle();
  EXPECT_FALSE(has_event(revision, "map_revised"));
  EXPECT_EQ(revision.graph.first_pose, 2);
  EXPECT_TRUE(revision.graph.poses.empty()) << "nothing moved";
}

TEST(Mapper, AGivenMapStaysUnchanged) {
  const auto map = std::make_shared<const Map>(make_test_map(4));
  const std::vector<Keyframe>& before = map->keyframes;
  RecordingArchive archive;
  SlamContext context;
  context.map = map;
  context.archive = &archive;
  RgbdSlamOptions options;
  Mapper mapper(options, test_room::camera(), context);
  const SE3 seen_from = before[1].world_from_camera * SE3(SO3::exp({0.0, 0.05, 0.0}), {0.05, 0.0, 0.0});
  // Its relocalized pose is 6 cm off.
  const SE3 found = before[1].world_from_camera.inverse() * seen_from * SE3(SO3(), {0.06, 0.0, 0.0});
  const MapRevision revision = mapper.add(order_of(4, before[1].world_from_camera * found, seen_from,
                                                   edge_of(1, 4, found, ConstraintKind::proximity, 0.1, 0.05)));
  ASSERT_EQ(revision.graph.poses.size(), 5U);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(pose_in(revision, k).matrix(), before[k].world_from_camera.matrix());
  EXPECT_GT(revision.new_edges.size(), 1U) << "it is held against the map's";
  EXPECT_THAT(pose_in(revision, 4), pose_near(seen_from, 0.03, 0.015));
  EXPECT_TRUE(archive.keyframes.empty()) << "nothing is mapped";
  EXPECT_TRUE(archive.maps.empty());
  EXPECT_GT(edges_of_kind(revision, ConstraintKind::loop), 0);
  EXPECT_FALSE(has_event(revision, "loop_closed")) << "no loop of its own is closed";
  EXPECT_FALSE(has_event(revision, "map_revised"));
}

/// The keyframe before `end` with the most neighbors among those that still have features, the first of equals.
std::int64_t most_connected(const std::vector<Constraint>& edges, std::int64_t end,
                            const std::set<std::int64_t>& bare) {
  std::map<std::int64_t, std::set<std::int64_t>> neighbors;
  for (const Constraint& edge : edges) {
    const auto from = static_cast<std::int64_t>(edge.from), to = static_cast<std::int64_t>(edge.to);
    if (bare.contains(from) || bare.contains(to)) continue;
    neighbors[from].insert(to);
    neighbors[to].insert(from);
  }
  std::int64_t best = -1;
  for (const auto& [id, others] : neighbors)
    if (id < end && (best < 0 || others.size() > neighbors.at(best).size())) best = id;
  return best;
}

TEST(Mapper, GivesUpFeaturesOfTheMostRedundantFirst) {
  RgbdSlamOptions options;
  options.graph_window = 2;
  RecordingArchive archive;  // for the images
  SlamContext context;
  context.archive = &archive;
  context.map_memory_bytes = 300'000;
  Mapper mapper(options, test_room::camera(), context);
  std::vector<Constraint> edges;
  std::set<std::int64_t> bare;
  for (std::int64_t k = 0; k < 40 && bare.size() < 3; ++k) {
    const auto side = [](std::int64_t id) { return beside(static_cast<int>(id % 5)); };
    std::optional<Constraint> path;
    if (k > 0) path = edge_of(k - 1, k, side(k - 1).inverse() * side(k));
    const MapRevision revision = mapper.add(order_of(k, side(k), side(k), path));
    edges.insert(edges.end(), revision.new_edges.begin(), revision.new_edges.end());
    for (const std::int64_t id : revision.forgotten) {
      EXPECT_EQ(id, most_connected(edges, k + 1 - options.graph_window, bare));
      bare.insert(id);
    }
    EXPECT_TRUE(revision.forgotten.empty() || has_event(revision, "memory")) << k;
    EXPECT_LE(revision.state.memory.bytes, context.map_memory_bytes / 10 * 9) << k;
  }
  EXPECT_GE(bare.size(), 3U);
}

/// SIFT features take half a kilobyte each; the smallest budget is 16 MB.
TEST(Mapper, FeaturesOfTheOldestAreDroppedIfNoneAreRedundant) {
  RgbdSlamOptions options;
  options.descriptor = "sift";
  options.keyframe_features = 5000;
  options.graph_window = 2;
  options.last_candidates = options.near_candidates = options.graph_candidates = 0;
  options.random_candidates = options.join_candidates = 0;
  RecordingArchive archive;  // for the images
  SlamContext context;
  context.archive = &archive;
  context.max_memory_bytes = 1;
  Mapper mapper(options, test_room::camera(), context);
  const Frame frame = unknown_frame(3);
  std::vector<std::size_t> bytes;
  std::int64_t forgotten = 0;
  for (std::int64_t k = 0; k < 60 && forgotten < 3; ++k) {
    KeyframeOrder order = order_of(k, beside(0), beside(0));
    order.frame = frame;
    const MapRevision revision = mapper.add(order);
    bytes.push_back(revision.keyframe->features.size() * (128 * sizeof(float) + sizeof(Keypoint) + sizeof(float)));
    for (const std::int64_t id : revision.forgotten) EXPECT_EQ(id, forgotten++) << "the oldest first";
    if (!revision.forgotten.empty()) {
      EXPECT_TRUE(has_event(revision, "memory"));
    }
    EXPECT_LE(revision.state.memory.bytes, revision.state.memory.budget_bytes);
    std::size_t held = 0;
    for (auto id = static_cast<std::size_t>(forgotten); id < bytes.size(); ++id) held += bytes[id];
    EXPECT_LT(held, 16'000'000U + 100'000U);
    if (forgotten == 0) continue;
    EXPECT_GT(held + bytes[0] + 100'000U, 16'000'000U) << "and no more than that is given up";
    EXPECT_LT(bytes.back(), bytes.front());
    EXPECT_NEAR(static_cast<double>(revision.keyframe->features.size()), 0.35 * options.keyframe_features,
                0.01 * options.keyframe_features)
        << "fewer features as the budget fills up";
    EXPECT_GT(revision.state.spacing, 2.0);
  }
  EXPECT_GE(forgotten, 3);
}

}  // namespace
}  // namespace rastro
