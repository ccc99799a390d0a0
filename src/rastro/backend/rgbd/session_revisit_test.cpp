// SPDX-License-Identifier: Apache-2.0
// A place that the map has: the frame is matched with its keyframe, and both together give the pose.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "rastro/backend/rgbd/rgbd_session.h"
#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/backend/rgbd/variance_factor.h"

namespace rastro {
namespace {

using testing::looking;
using testing::pose_near;
using testing::room_frame;

/// The common error of all matches and paths, which is most of any edge's.
constexpr double common_sigma = 0.1;

RgbdSlamOptions revisiting() {
  RgbdSlamOptions options;
  options.keyframe_frames = 4;
  options.dense_keyframes = 1;
  options.backend_delay_frames = 1;
  options.edge_sigma_m = options.edge_sigma_rad = common_sigma;
  return options;
}

SE3 shown_aside(double meters) { return looking({-0.5, meters, 1.2}, 0.0, -0.3); }

/// In shares of the common error's variance, as long as no residuals have changed it: of the position, of the rotation.
std::pair<double, double> variances_of(const SlamUpdate& update) {
  const Vector6d variances = update.covariance->diagonal() / (VarianceFactor().value() * common_sigma * common_sigma);
  return {variances.head<3>().mean(), variances.tail<3>().mean()};
}

/// In frame 4 the path from the keyframe and the match with it are as sure as each other.
TEST(RgbdSession, ARevisitedPlaceMakesThePoseSurerThanPathOrMatchAlone) {
  RgbdSession session(revisiting(), test_room::camera(), {});
  SlamUpdate update;
  for (int k = 0; k <= 6; ++k) {
    update = session.process(room_frame(shown_aside(0.004 * k), k));
    EXPECT_EQ(update.events.empty(), k != 0) << "one keyframe, at the beginning";
    EXPECT_THAT(update.world_from_body, pose_near(shown_aside(0.0).inverse() * shown_aside(0.004 * k), 0.02, 0.003))
        << k;
    const auto [of_position, of_rotation] = variances_of(update);
    if (k < 4) {
      EXPECT_LT(of_position, 0.1) << "of a frame on the path only what is not common";
    } else {
      EXPECT_NEAR(of_position, 0.5, 0.05) << k;
      EXPECT_NEAR(of_rotation, 0.5, 0.05) << k;
    }
  }
  const auto map = session.snapshot();
  EXPECT_EQ(map->keyframes.size(), 1U);
  EXPECT_TRUE(map->constraints.empty()) << "an edge leads to another keyframe";
  EXPECT_EQ(session.trajectory().size(), 7U);
}

/// Recognizes nothing; the features of each keyframe leave memory at once.
class Forgetful : public LoopSearch {
 public:
  bool has_long_term_memory() const override { return true; }
  Candidates candidates(const KeyframeGraph&, std::int64_t id) override {
    leaving_ = {id};
    return {};
  }
  std::vector<std::int64_t> transfer(const KeyframeGraph&, double) override { return std::exchange(leaving_, {}); }

 private:
  std::vector<std::int64_t> leaving_;
};

/// Else the map grows with the time wherever locations were transferred.
TEST(RgbdSession, APlaceWhoseFeaturesAreInLongTermMemoryAloneIsRevisitedToo) {
  RgbdSession session(revisiting(), test_room::camera(), {}, {"rtabmap", std::make_unique<Forgetful>(), 0.0});
  for (int k = 0; k <= 6; ++k) session.process(room_frame(shown_aside(0.004 * k), k));
  session.finish();
  EXPECT_EQ(session.snapshot()->keyframes.size(), 1U);
  EXPECT_EQ(session.map_memory().measures, "features of 1 keyframes in long-term memory alone");
}

/// No patch looks as alike as that.
RgbdSlamOptions nothing_looks_alike() {
  RgbdSlamOptions options = revisiting();
  options.min_alike = 1.0;
  return options;
}

TEST(RgbdSession, AMatchThatLooksDifferentIsNoPlaceRevisited) {
  RgbdSession session(nothing_looks_alike(), test_room::camera(), {});
  for (int k = 0; k <= 4; ++k) session.process(room_frame(shown_aside(0.004 * k), k));
  session.finish();
  EXPECT_EQ(session.snapshot()->keyframes.size(), 2U);
}

TEST(RgbdSession, WithoutMappingAMatchThatLooksDifferentIsNotBelieved) {
  for (const bool alike : {true, false}) {
    RgbdSlamOptions options = alike ? revisiting() : nothing_looks_alike();
    options.relocalize_every = 1;
    options.keyframe_frames = 2;
    options.dense_keyframes = 1000;
    RgbdSession session(options, test_room::camera(), {});
    std::int64_t index = 0;
    for (; index < 6; ++index) session.process(room_frame(shown_aside(0.03 * static_cast<double>(index)), index));
    ASSERT_TRUE(session.set_mapping(false));
    const std::size_t mapped = session.snapshot()->frames.size();
    for (; index < 11; ++index) session.process(room_frame(shown_aside(0.03 * static_cast<double>(10 - index)), index));
    const auto map = session.snapshot();
    std::set<KeyframeId> keyframes;
    for (std::size_t i = mapped; i < map->frames.size(); ++i) keyframes.insert(map->frames[i].keyframe);
    EXPECT_EQ(keyframes.size() > 1, alike) << keyframes.size();
  }
}

/// Two places 0.3 m from each other; back at the first, the path since is an edge between their keyframes.
TEST(RgbdSession, APathBackToAKeyframeIsAnEdgeFromTheOneItBeganAt) {
  RgbdSlamOptions options = revisiting();
  options.keyframe_frames = 1000;
  options.keyframe_distance_m = 0.12;
  options.last_candidates = options.near_candidates = options.graph_candidates = options.random_candidates = 0;
  RgbdSession session(options, test_room::camera(), {});
  std::size_t made = 0;
  const double stops_m[] = {0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.25, 0.2, 0.15, 0.1, 0.05, 0.0, 0.05, 0.1};
  std::int64_t index = 0;
  for (const double meters : stops_m) made += session.process(room_frame(shown_aside(meters), index++)).events.size();
  session.finish();
  const auto map = session.snapshot();
  ASSERT_EQ(map->keyframes.size(), 3U) << "one every 0.15 m on the way there, none on the way back";
  EXPECT_EQ(made, 3U);
  ASSERT_EQ(map->constraints.size(), 2U) << "both are connected by the way there";
  for (const Constraint& edge : map->constraints) EXPECT_EQ(edge.kind, ConstraintKind::odometry);
  for (std::size_t k = 1; k < 3; ++k)
    EXPECT_THAT(map->keyframes[k].world_from_camera,
                pose_near(shown_aside(0.0).inverse() * shown_aside(0.15 * k), 0.01, 0.005));
}

}  // namespace
}  // namespace rastro
