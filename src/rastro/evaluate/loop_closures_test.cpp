// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/loop_closures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/error.h"

namespace rastro {
namespace {

/// Keyframe k at second 10 k, at x = k; 4 and 5 are back where 0 and 1 were. Ground truth is the same.
struct Case {
  Map map;
  Trajectory ground_truth;
  std::vector<Revisit> revisits;

  Case() {
    const double x[] = {0, 1, 2, 3, 0, 1};
    for (int k = 0; k < 6; ++k) {
      Keyframe keyframe;
      keyframe.id = k;
      keyframe.stamp = from_seconds(10.0 * k);
      keyframe.world_from_camera = SE3(SO3(), {x[k], 0, 0});
      map.keyframes.push_back(keyframe);
      ground_truth.push_back({keyframe.stamp, keyframe.world_from_camera});
      if (k > 3) revisits.push_back({keyframe.stamp, from_seconds(10.0 * (k - 4))});
    }
  }
  void close(KeyframeId from, KeyframeId to, double x) {
    Constraint constraint;
    constraint.from = from, constraint.to = to;
    constraint.from_from_to = Sim3(SE3(SO3(), {x, 0, 0}));
    map.constraints.push_back(constraint);
  }
  LoopClosureScores score(const LoopClosureLimits& limits = {}) const {
    LoopClosureLimits wide = limits;
    wide.max_ground_truth_gap_s = 10.0;
    return score_loop_closures(map, revisits, ground_truth, wide);
  }
};

TEST(LoopClosureScores, CountRightAndWrongOnesAndTheRevisitsFound) {
  Case test;
  test.close(0, 1, 1.0);   // Too near in time to count.
  test.close(0, 4, 0.1);   // Right.
  test.close(5, 1, -0.1);  // Right, the later one first.
  test.close(2, 5, 1.0);   // Wrong: it is at -1.
  const LoopClosureScores scores = test.score();
  EXPECT_EQ(scores.accepted, 3);
  EXPECT_EQ(scores.wrong, 1);
  EXPECT_EQ(scores.revisits, 2);
  EXPECT_EQ(scores.found, 2);
  EXPECT_NEAR(scores.precision(), 2.0 / 3.0, 1e-12);
  EXPECT_EQ(scores.recall(), 1.0);
}

TEST(LoopClosureScores, GroundTruthOfTheBodyBecomesThatOfTheCamera) {
  const SE3 body_from_camera(SO3::exp({0.0, 1.5, 0.0}), {0.0, 0.1, 0.2}), world_from_body(SO3(), {4.0, 5.0, 6.0});
  SourceInfo info;
  info.ground_truth.push_back({from_seconds(1.0), world_from_body});
  info.ground_truth_frame = "body";
  const auto error = [&](const SE3& expected) {
    return (camera_ground_truth(info).front().world_from_body.inverse() * expected).log().norm();
  };
  EXPECT_LT(error(world_from_body), 1e-12) << "no camera is known";
  info.cameras.emplace_back();
  EXPECT_LT(error(world_from_body), 1e-12) << "nor where it is on the body";
  info.cameras.front().body_from_camera = body_from_camera;
  EXPECT_LT(error(world_from_body * body_from_camera), 1e-12);
  info.ground_truth_frame = "camera";
  EXPECT_LT(error(world_from_body), 1e-12);
}

/// One camera: the same in units of a quarter of a meter.
TEST(LoopClosureScores, TheUnitOfAMapUpToScaleIsThatOfItsKeyframes) {
  Case test;
  test.map.sessions.push_back({0, 0, "", 0, 0, {false, 0.0, "arbitrary"}});
  for (Keyframe& keyframe : test.map.keyframes)
    keyframe.world_from_camera = SE3(SO3(), 4.0 * keyframe.world_from_camera.translation());
  test.close(0, 4, 0.4);
  test.close(1, 4, -4.0);  // Right, 1 m.
  test.close(3, 5, -8.0);  // Right, 2 m.
  test.close(2, 5, -1.0);  // Wrong: 0.25 m for 1 m.
  EXPECT_EQ(test.score().accepted, 4);
  EXPECT_EQ(test.score().wrong, 1);
  test.map.sessions.front().scale.metric = true;
  EXPECT_EQ(test.score().wrong, 2);
}

TEST(LoopClosureScores, AWrongOneFindsNothing) {
  Case test;
  test.close(0, 4, 0.6);
  EXPECT_EQ(test.score().found, 0);
  ASSERT_EQ(test.score().wrong_ones.size(), 1U);
  EXPECT_EQ(test.score().wrong_ones.front().from, 0);
  EXPECT_EQ(test.score().wrong_ones.front().to, 4);
  EXPECT_NEAR(test.score().wrong_ones.front().error_m, 0.6, 1e-9);
  ASSERT_EQ(test.score().missed.size(), test.revisits.size());
  EXPECT_EQ(test.score().missed.front().stamp, test.revisits.front().stamp);
  EXPECT_EQ(test.score({.max_error_m = 0.7}).found, 1);
  EXPECT_EQ(test.score({.max_error_m = 0.7}).missed.size(), test.revisits.size() - 1);
  EXPECT_EQ(test.score({.gap_s = 41.0}).accepted, 0);
}

TEST(LoopClosureScores, AFrameInAnOldKeyframeIsFound) {
  Case test;
  test.map.frames.push_back({from_seconds(40.0), 0, SE3()});
  test.map.frames.push_back({from_seconds(50.0), 5, SE3()});
  const LoopClosureScores scores = test.score();
  EXPECT_EQ(scores.accepted, 0);
  EXPECT_EQ(scores.found, 1);
}

/// Its keyframe may be seconds old where the camera moves slowly.
TEST(LoopClosureScores, AFrameInAKeyframeThatClosesALoopIsFound) {
  Case test;
  test.close(0, 4, 0.1);
  test.revisits = {{from_seconds(45.0), from_seconds(5.0)}, {from_seconds(50.0), from_seconds(10.0)}};
  test.map.frames.push_back({from_seconds(45.0), 4, SE3(SO3(), {0.5, 0, 0})});
  test.map.frames.push_back({from_seconds(50.0), 4, SE3(SO3(), {3.0, 0, 0})});  // Wrong: 1 m from it.
  EXPECT_EQ(test.score().found, 1);
  test.map.constraints.clear();
  EXPECT_EQ(test.score().found, 0);
}

TEST(LoopClosureScores, ErrorsOfTheLoopAndOfTheFrameAddUp) {
  for (const bool same_way : {true, false}) {
    Case test;
    test.close(0, 4, 0.3);
    test.revisits = {{from_seconds(45.0), from_seconds(5.0)}};
    test.map.frames.push_back({from_seconds(45.0), 4, SE3(SO3(), {same_way ? 0.8 : 0.2, 0, 0})});  // Half a meter.
    EXPECT_EQ(test.score().found, same_way ? 0 : 1);
  }
}

TEST(LoopClosureScores, WithoutGroundTruthNothingIsJudged) {
  Case test;
  test.close(0, 4, 0.0);
  test.ground_truth.resize(3);
  const LoopClosureScores scores = test.score();
  EXPECT_EQ(scores.accepted, 0);
  EXPECT_EQ(scores.unknown, 1);
}

std::string error_of(const std::string& text) {
  try {
    parse_revisits(text, "closures.yaml");
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

TEST(ParseRevisits, ReadsTheListAndRefusesAnythingElse) {
  const auto revisits = parse_revisits("closures:\n  - {frame: 3, stamp: 30, earlier_stamp: 10, overlap: 0.5}\n", "f");
  ASSERT_EQ(revisits.size(), 1U);
  EXPECT_EQ(revisits[0].stamp, 30);
  EXPECT_EQ(revisits[0].earlier_stamp, 10);
  EXPECT_TRUE(parse_revisits("closures:\n", "f").empty());
  EXPECT_THAT(error_of("closures: [{stamp: x}]"), testing::HasSubstr("closures.yaml:1"));
  EXPECT_THAT(error_of("closures: [3]"), testing::HasSubstr("is not a closure"));
  EXPECT_THAT(error_of("{[}"), testing::HasSubstr("not YAML"));
  EXPECT_THAT(error_of("a: 1"), testing::HasSubstr("no list"));
}

}  // namespace
}  // namespace rastro
