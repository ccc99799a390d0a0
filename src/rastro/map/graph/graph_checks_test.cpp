// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <tuple>

#include "rastro/base/error.h"
#include "rastro/map/graph/covisibility.h"
#include "rastro/map/graph/edit.h"
#include "rastro/map/graph/planar.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Keyframes 0, 1, ..., each the child of the previous one.
Map chain(int keyframes) {
  Map map;
  for (int k = 0; k < keyframes; ++k)
    map.keyframes.push_back({k, k, k, 0, SE3(SO3(), {1.0 * k, 0.0, 0.0}), 0, k - 1, 1.0});
  return map;
}

Constraint constraint_of(KeyframeId from, KeyframeId to, ConstraintKind kind = ConstraintKind::loop, int inliers = 0) {
  Constraint constraint;
  constraint.from = from, constraint.to = to, constraint.kind = kind, constraint.inliers = inliers;
  return constraint;
}

TEST(ContradictionIn, AConstraintThatIsNotFinite) {
  const std::function<void(Constraint&)> damages[] = {
      [](Constraint& each) {
        each.from_from_to = Sim3(1.0, SO3(), {0.0, infinite, 0.0});
      },
      [](Constraint& each) {
        each.from_from_to = Sim3(infinite, SO3(), {0.0, 0.0, 0.0});
      },
      [](Constraint& each) { each.information(5, 2) = infinite; },
      [](Constraint& each) { each.weight = infinite; },
  };
  Map map = chain(3);
  map.constraints = {constraint_of(0, 1), constraint_of(1, 2)};
  EXPECT_EQ(contradiction_in(map), "");
  for (const auto& damage : damages) {
    Map damaged = map;
    damage(damaged.constraints[1]);
    EXPECT_EQ(contradiction_in(damaged), "has a constraint whose numbers are not finite");
  }
}

/// All that a pose graph refuses.
TEST(ContradictionIn, AConstraintThatCannotBeOptimized) {
  const auto fault_after = [](const std::function<void(Constraint&)>& damage) {
    Map map = chain(3);
    map.constraints = {constraint_of(0, 1), constraint_of(1, 2)};
    damage(map.constraints[1]);
    return contradiction_in(map);
  };
  const char* const not_positive = "has a constraint whose information is not positive definite";
  EXPECT_EQ(fault_after([](Constraint& each) { each.information(5, 5) = -1.0; }), not_positive);
  EXPECT_EQ(fault_after([](Constraint& each) { each.information(0, 0) = 0.0; }), not_positive);
  EXPECT_EQ(fault_after([](Constraint& each) { each.information.setZero(); }), not_positive);
  EXPECT_EQ(fault_after([](Constraint& each) { each.information(0, 4) = each.information(4, 0) = 1.0; }), not_positive);
  EXPECT_EQ(fault_after([](Constraint& each) { each.information *= std::numeric_limits<double>::max(); }), not_positive)
      << "its root is not finite";
  EXPECT_EQ(fault_after([](Constraint& each) { each.information(0, 4) = 1.9; }), "") << "half of it on either side";
  EXPECT_EQ(fault_after([](Constraint& each) { each.information *= 1e-12; }), "") << "little, but of every direction";
  EXPECT_EQ(fault_after([](Constraint& each) { each.to = each.from; }), "has a constraint of a keyframe to itself");
}

TEST(ContradictionIn, ACycleWithoutARootIsFoundFromAnyKeyframe) {
  for (const auto& [child, parent] : {std::pair{2, 4}, {3, 3}, {1, 5}, {4, 5}}) {
    Map map = chain(6);
    map.keyframes[static_cast<std::size_t>(child)].parent = parent;
    EXPECT_EQ(contradiction_in(map), "has a spanning tree with a ring in it") << child;
  }
  Map map = chain(6);
  map.keyframes[2].parent = 0;  // two branches that join
  map.keyframes[5].parent = 1;
  EXPECT_EQ(contradiction_in(map), "");
}

TEST(ContradictionIn, TheLastCameraIsThereAndTheNextOneIsNot) {
  Map map = chain(2);
  map.cameras.resize(2);
  map.keyframes[1].camera = 1;
  EXPECT_EQ(contradiction_in(map), "");
  map.keyframes[1].camera = 2;
  EXPECT_EQ(contradiction_in(map), "has a keyframe of a camera that is not there");
}

TEST(InsertKeyframe, OfAMapWithoutCamerasIsOfCameraZero) {
  Map map;
  Keyframe keyframe;
  keyframe.id = 5;
  insert_keyframe(map, keyframe);
  keyframe.id = 6, keyframe.camera = 1;
  EXPECT_THROW(insert_keyframe(map, keyframe), Error);
  keyframe.camera = 0, keyframe.parent = 5;
  insert_keyframe(map, keyframe);
  EXPECT_EQ(map.find(6)->parent, 5);
}

TEST(RestoreKeyframe, AChildThatHasAnotherParentMeanwhileKeepsIt) {
  Map map = chain(4);
  const RemovedKeyframe removed = remove_keyframe(map, 1);
  EXPECT_EQ(map.find(2)->parent, 0);
  Keyframe& child = map.keyframes[*map.index_of(2)];
  child.parent = no_keyframe;
  restore_keyframe(map, removed);
  EXPECT_EQ(map.find(2)->parent, no_keyframe);
  EXPECT_EQ(map.find(1)->parent, 0);
}

TEST(RestoreKeyframe, ConstraintsAndFramesReturnToTheirIndices) {
  Map map = chain(4);
  for (const auto& [from, to] : {std::pair{0, 1}, {2, 3}, {1, 3}, {3, 0}, {2, 1}})
    map.constraints.push_back(constraint_of(from, to));
  for (const int keyframe : {1, 0, 1, 2, 1})
    map.frames.push_back({static_cast<TimeNs>(map.frames.size()), keyframe, {}});
  const Map before = map;
  const RemovedKeyframe removed = remove_keyframe(map, 1);
  EXPECT_EQ(map.constraints.size(), 2U);
  EXPECT_EQ(map.frames.size(), 2U);
  restore_keyframe(map, removed);
  ASSERT_EQ(map.constraints.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(map.constraints[i].from, before.constraints[i].from) << i;
    EXPECT_EQ(map.constraints[i].to, before.constraints[i].to) << i;
    EXPECT_EQ(map.frames[i].stamp, before.frames[i].stamp) << i;
  }
}

/// A landmark for each pair of observers, `shared` times.
void share(Map& map, KeyframeId a, KeyframeId b, int shared) {
  auto layer = std::make_shared<LandmarkLayer>();
  if (map.layer<LandmarkLayer>()) *layer = *map.layer<LandmarkLayer>();
  for (int i = 0; i < shared; ++i) {
    Landmark& landmark = layer->landmarks.emplace_back();
    landmark.id = static_cast<std::int64_t>(layer->landmarks.size());
    landmark.observations = {{a, 0}, {b, 0}};
  }
  map.layers.put<LandmarkLayer>(std::move(layer));
}

using Edge = std::tuple<std::uint32_t, std::uint32_t, EssentialKind, int>;

std::vector<Edge> edges_of(const Map& map, int strong) {
  std::vector<Edge> edges;
  for (const EssentialEdge& edge : essential_graph(map, strong))
    edges.emplace_back(edge.first, edge.second, edge.kind, edge.shared);
  return edges;
}

TEST(EssentialGraph, HasEachPairOnceAsItsStrongestKind) {
  Map map = chain(5);
  share(map, 0, 1, 3);   // also a tree edge
  share(map, 1, 3, 12);  // only covisible
  share(map, 0, 2, 9);   // too weak
  share(map, 0, 4, 10);  // also a loop closure
  map.constraints = {constraint_of(4, 0, ConstraintKind::loop, 33), constraint_of(0, 1, ConstraintKind::odometry, 44),
                     constraint_of(1, 4, ConstraintKind::merge, 55), constraint_of(2, 4, ConstraintKind::proximity, 66),
                     constraint_of(4, 77, ConstraintKind::loop, 88)};
  using enum EssentialKind;
  const std::vector<Edge> expected = {{0, 1, tree, 3},       {0, 4, constraint, 33}, {1, 2, tree, 0},
                                      {1, 3, covisible, 12}, {1, 4, constraint, 55}, {2, 3, tree, 0},
                                      {3, 4, tree, 0}};
  EXPECT_EQ(edges_of(map, 10), expected);
}

TEST(CovisibilityGraph, LeavesOutPairsThatShareNothingForAnyMinimum) {
  Map map = chain(4);
  EXPECT_TRUE(covisibility_graph(map, 1).empty()) << "no landmarks";
  share(map, 0, 2, 1);
  share(map, 1, 2, 2);
  EXPECT_EQ(covisibility_graph(map, 0).size(), 2U);
  EXPECT_EQ(covisibility_graph(map, -3).size(), 2U);
  ASSERT_EQ(covisibility_graph(map, 2).size(), 1U);
  EXPECT_EQ(covisibility_graph(map, 2)[0].first, 1U);
  EXPECT_TRUE(covisibility_graph(map, 3).empty());
}

TEST(Planar, APoseOfThePlaneGoesToSpaceAndBack) {
  for (const double yaw : {0.0, 0.7, -2.5, 3.1}) {
    const SE2 pose(SO2::from_angle(yaw), {1.5, -2.0});
    const SE3 space = in_space(pose);
    EXPECT_EQ(space.translation(), Eigen::Vector3d(1.5, -2.0, 0.0));
    const Eigen::Vector2d moved = pose * Eigen::Vector2d(3.0, 4.0);
    EXPECT_LT(((space * Eigen::Vector3d(3.0, 4.0, 0.5)) - Eigen::Vector3d(moved.x(), moved.y(), 0.5)).norm(), 1e-12);
    const SE2 again = in_plane(space);
    EXPECT_LT((again.inverse() * pose).log().norm(), 1e-12);
  }
}

TEST(Planar, ACovarianceHasItsEntriesInThatOfSpace) {
  Eigen::Matrix3d planar;
  planar << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  Matrix6d expected = Matrix6d::Zero();
  expected(0, 0) = 1.0, expected(1, 1) = 2.0, expected(5, 5) = 3.0;
  expected(0, 1) = expected(1, 0) = 0.1;
  expected(0, 5) = expected(5, 0) = 0.2;
  expected(1, 5) = expected(5, 1) = 0.3;
  EXPECT_EQ(in_space(planar), expected);
}

TEST(Planar, AConstraintCostsWhatTheSameErrorCostsInThePlane) {
  Eigen::Matrix3d information;
  information << 40.0, 3.0, 2.0, 3.0, 90.0, -5.0, 2.0, -5.0, 700.0;
  const SE2 from_from_to(SO2::from_angle(0.8), {1.5, -2.0});
  const Constraint constraint = planar_constraint(3, 7, from_from_to, information, ConstraintKind::proximity);
  EXPECT_EQ(constraint.from, 3);
  EXPECT_EQ(constraint.to, 7);
  EXPECT_EQ(constraint.kind, ConstraintKind::proximity);
  EXPECT_THAT(constraint.rigid().matrix(), testing::matrix_near(in_space(from_from_to).matrix(), 1e-12));
  for (const Eigen::Vector3d& error : {Eigen::Vector3d(1.0, 0.0, 0.0), {0.0, 1.0, 0.0}, {0.3, -0.2, 0.1}}) {
    // The error of `to` in its own axes; seen from `from` its translation is rotated.
    Eigen::Vector3d seen = error;
    seen.head<2>() = from_from_to.rotation() * Eigen::Vector2d(error.head<2>());
    Eigen::Matrix<double, 6, 1> full = Eigen::Matrix<double, 6, 1>::Zero();
    full[0] = error.x(), full[1] = error.y(), full[5] = error.z();
    EXPECT_NEAR(full.dot(constraint.information * full), seen.dot(information * seen), 1e-9);
  }
  for (const int unmoved : {2, 3, 4}) EXPECT_EQ(constraint.information(unmoved, unmoved), 1e6) << unmoved;
  EXPECT_EQ(constraint.information(2, 3), 0.0);
}

}  // namespace
}  // namespace rastro
