// SPDX-License-Identifier: Apache-2.0
// What a lost session reports, how it is found again and what it makes of it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <tuple>
#include <utility>

#include "rastro/backend/rgbd/rgbd_session.h"
#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/backend/rgbd/variance_factor.h"

namespace rastro {
namespace {

using testing::looking;
using testing::pose_near;
using testing::room_frame;
using testing::unknown_frame;

/// In front of a wall.
SE3 place_at(double aside_m, double turned_rad = 0.0) { return looking({-0.5, aside_m, 1.2}, turned_rad, -0.3); }

/// The first frame's place; two more lead to place_at(0.0).
SE3 first_place() { return place_at(-0.004); }

/// An unknown place without depths: nothing can be followed there, nor begun anew.
Frame unknown_at(std::int64_t index) {
  Frame frame = unknown_frame(7, 0.0F);
  frame.index = index;
  frame.stamp = frame.depth_stamp = room_frame(SE3(), index).stamp;
  return frame;
}

RgbdSlamOptions lost_at_once() {
  RgbdSlamOptions options;
  options.lost_frames = options.relocalize_every = 1;
  options.backend_delay_frames = 1;
  return options;
}

/// Three frames, then some that show nothing known, without depths.
struct LostSession : RgbdSession {
  explicit LostSession(int blind, const RgbdSlamOptions& options = lost_at_once())
      : RgbdSession(options, test_room::camera(), {}) {
    for (int k = 0; k < 3; ++k) show(place_at(0.002 * k - 0.004));
    for (int k = 0; k < blind; ++k) EXPECT_EQ(process(unknown_at(next++)).state, SlamState::lost) << k;
  }
  SlamUpdate show(const SE3& world_from_camera) { return process(room_frame(world_from_camera, next++)); }

  std::int64_t next = 0;
};

/// 0.1 m and 0.1 rad for each frame since, in five at most.
TEST(RgbdSession, NearWhereItWasLostOneFrameRelocalizes) {
  const struct {
    int blind;
    double aside_m, turned_rad;
    bool enough;
  } cases[] = {{1, 0.17, 0.0, true},  {1, 0.23, 0.0, false}, {1, 0.0, 0.17, true},
               {1, 0.0, 0.23, false}, {4, 0.45, 0.0, true},  {4, 0.55, 0.0, false},
               {4, 0.0, 0.45, true},  {4, 0.0, 0.55, false}, {5, 0.0, 0.0, false}};
  for (const auto& [blind, aside_m, turned_rad, enough] : cases) {
    LostSession session(blind);
    const SlamUpdate update = session.show(place_at(aside_m, turned_rad));
    EXPECT_EQ(update.state, enough ? SlamState::relocalized : SlamState::lost) << blind << ' ' << update.detail;
    EXPECT_EQ(update.reason, enough ? SlamReason::none : SlamReason::unconfirmed);
    EXPECT_EQ(session.trajectory().size(), enough ? 4U : 3U) << "one that is not believed has no pose";
    if (!enough) {
      EXPECT_THAT(update.detail, ::testing::HasSubstr("matches; 1 of 3 frames agree"));
    }
  }
}

TEST(RgbdSession, ARelocalizedFrameBecomesAKeyframeWithAnEdgeToTheOneItWasFoundIn) {
  LostSession session(2);
  const SlamUpdate update = session.show(place_at(0.2, 0.05));
  ASSERT_EQ(update.state, SlamState::relocalized);
  const SE3 moved = first_place().inverse() * place_at(0.2, 0.05);
  EXPECT_THAT(update.world_from_body, pose_near(moved, 0.02, 0.01));
  EXPECT_EQ(update.detail, "");
  ASSERT_EQ(update.events.size(), 2U);
  EXPECT_EQ(update.events[0].kind, "keyframe");
  EXPECT_EQ(update.events[0].detail, "1");
  EXPECT_EQ(update.events[1].kind, "relocalized");
  EXPECT_GE(update.used, lost_at_once().relocalize_inliers);
  EXPECT_EQ(update.events[1].detail, fmt::format("in keyframe 0 with {} inliers of {:.0f} matches after 3 frames",
                                                 update.used, update.used / update.score));
  for (const double aside_m : {0.202, 0.204})
    EXPECT_EQ(session.show(place_at(aside_m, 0.05)).state, SlamState::tracking);
  const auto map = session.snapshot();
  ASSERT_EQ(map->keyframes.size(), 2U);
  ASSERT_FALSE(map->constraints.empty());
  const Constraint& edge = map->constraints.front();
  EXPECT_EQ(edge.from, 0);
  EXPECT_EQ(edge.to, 1);
  EXPECT_EQ(edge.kind, ConstraintKind::proximity);
  EXPECT_EQ(edge.inliers, update.used);
  EXPECT_THAT(edge.rigid(), pose_near(moved, 0.02, 0.01));
  EXPECT_THAT(map->keyframes[1].world_from_camera, pose_near(moved, 0.02, 0.01));
  EXPECT_EQ(map->frames.size(), 6U);
  const Eigen::Matrix3d in_keyframe = edge.information.inverse().topLeftCorner<3, 3>();
  const Eigen::Matrix3d said = update.covariance->topLeftCorner<3, 3>();
  const double common = 3.0 * lost_at_once().edge_sigma_m * lost_at_once().edge_sigma_m;
  EXPECT_NEAR(said.trace(), VarianceFactor().value() * (in_keyframe.trace() - common) + common, 1e-9)
      << "as sure as the match with the first";
}

/// Two frames in a row may be 0.3 m and 0.35 rad from each other.
TEST(RgbdSession, FramesOfOnePlaceConfirmEachOther) {
  RgbdSlamOptions options = lost_at_once();
  options.relocalize_frames = 2;
  for (const auto& [aside_m, turned_rad, agrees] :
       {std::tuple{0.26, 0.0, true}, {0.34, 0.0, false}, {0.0, 0.31, true}, {0.0, 0.39, false}}) {
    LostSession session(5, options);
    EXPECT_EQ(session.show(place_at(0.0)).reason, SlamReason::unconfirmed);
    const SlamUpdate update = session.show(place_at(aside_m, turned_rad));
    EXPECT_EQ(update.state == SlamState::relocalized, agrees) << aside_m << ' ' << turned_rad << update.detail;
    EXPECT_EQ(session.trajectory().size(), agrees ? 5U : 3U) << "the first of them has a pose then, too";
    if (agrees) {
      EXPECT_THAT(session.trajectory()[3].world_from_body, pose_near(SE3(), 0.02, 0.01));
    } else {
      EXPECT_THAT(update.detail, ::testing::HasSubstr("; 1 of 2 frames agree")) << "the count begins anew";
    }
  }
}

TEST(RgbdSession, AfterEnoughLostFramesANewSubmapBeginsWhereItWasLost) {
  LostSession session(1);
  const auto show_elsewhere = [&] { return session.show(place_at(0.002 * static_cast<double>(session.next), M_PI)); };
  const SlamUpdate begun = show_elsewhere();
  EXPECT_EQ(begun.state, SlamState::relocalized);
  EXPECT_EQ(begun.reason, SlamReason::apart);
  EXPECT_EQ(begun.detail, "in submap 1, not connected to the first yet: its position is a guess");
  ASSERT_EQ(begun.events.size(), 2U);
  EXPECT_EQ(begun.events[1].kind, "submap");
  EXPECT_EQ(begun.events[1].detail, "1 started, no relocalization in 2 frames");
  EXPECT_THAT(begun.world_from_body, pose_near(SE3(), 0.03, 0.01));
  EXPECT_EQ(begun.covariance->norm(), 0.0);
  for (int k = 0; k < 4; ++k) {
    const SlamUpdate apart = show_elsewhere();
    EXPECT_EQ(apart.state, SlamState::weak) << apart.detail;
    EXPECT_EQ(apart.reason, SlamReason::apart);
  }
  EXPECT_EQ(session.trajectory().size(), 3U) << "of the first submap";
  EXPECT_EQ(session.finish().back().detail, "the largest is now the first");
  EXPECT_EQ(session.trajectory().size(), 5U);
}

/// The follower has just seen that frame, and may not take it for a repeated one.
TEST(RgbdSession, ANewSubmapMayBeginWithTheFrameThatWasLost) {
  LostSession session(0);
  const SlamUpdate begun = session.show(place_at(0.0, M_PI));
  EXPECT_EQ(begun.state, SlamState::relocalized) << begun.detail;
  EXPECT_EQ(begun.reason, SlamReason::apart);
  ASSERT_EQ(begun.events.size(), 2U);
  EXPECT_EQ(begun.events[1].detail, "1 started, no relocalization in 1 frames");
  EXPECT_EQ(session.show(place_at(0.002, M_PI)).state, SlamState::weak) << "followed in its submap";
}

/// Mapping goes on only when it is told to.
class WaitingSearch : public LoopSearch {
 public:
  explicit WaitingSearch(std::shared_future<void> go) : go_(std::move(go)) {}
  Candidates candidates(const KeyframeGraph&, std::int64_t) override {
    go_.wait();
    return {};
  }
  std::vector<std::int64_t> transfer(const KeyframeGraph&, double) override { return {}; }

 private:
  std::shared_future<void> go_;
};

/// Live, mapping takes no more than a few keyframes at once; the one of a relocalized frame must be among those.
TEST(RgbdSession, AFrameFoundWhileMappingIsBehindBecomesAKeyframeToo) {
  TaskPool pool(2);
  SlamContext context;
  context.pool = &pool;
  context.live = context.pipelined = true;
  RgbdSlamOptions options = lost_at_once();
  options.keyframe_frames = 1;
  std::promise<void> go;
  RgbdSession session(options, test_room::camera(), context,
                      {.search = std::make_unique<WaitingSearch>(go.get_future().share())});
  std::int64_t next = 0;
  std::size_t made = 0;
  const auto show = [&](const Frame& frame) {
    const SlamUpdate update = session.process(frame);
    for (const SlamEvent& event : update.events) made += event.kind == "keyframe" ? 1 : 0;
    return update.state;
  };
  for (; next < 6; ++next) show(room_frame(place_at(0.002 * static_cast<double>(next)), next));
  EXPECT_GT(session.dropped_frames(), 0) << "no more keyframes were taken";
  const std::jthread later([&go] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    go.set_value();
  });
  EXPECT_EQ(show(unknown_at(next++)), SlamState::lost);
  for (; next < 11; ++next)
    EXPECT_NE(show(room_frame(place_at(0.002 * static_cast<double>(next)), next)), SlamState::lost) << next;
  session.finish();
  EXPECT_EQ(session.snapshot()->keyframes.size(), made);
}

TEST(RgbdSession, WithoutImageOrDepthALostFrameSaysSoUnlessTheFollowerKnowsBetter) {
  SlamContext context;
  context.map = std::make_shared<const Map>(make_test_map(2));
  RgbdSession localized({}, test_room::camera(), context);
  for (const bool image : {true, false}) {
    Frame frame = room_frame(place_at(0.0), image ? 1 : 2);
    image ? void(frame.depth = {}) : void(frame.image = {});
    const SlamUpdate update = localized.process(frame);
    EXPECT_EQ(update.state, SlamState::lost);
    EXPECT_EQ(update.reason, SlamReason::no_data);
  }
  LostSession session(0);
  Frame without_depth = unknown_at(session.next++);
  without_depth.depth = {};
  const SlamUpdate update = session.process(without_depth);
  EXPECT_EQ(update.state, SlamState::lost);
  EXPECT_EQ(update.reason, SlamReason::blurred);
}

}  // namespace
}  // namespace rastro
