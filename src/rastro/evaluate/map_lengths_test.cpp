// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/map_lengths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/evaluate/length_combine.h"
#include "rastro/evaluate/length_report.h"
#include "rastro/evaluate/length_room_testing.h"
#include "rastro/evaluate/length_scale.h"
#include "rastro/map/cloud/build_cloud.h"

namespace rastro {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

const LengthRoom& room() {
  static const LengthRoom room;
  return room;
}

/// Rough points have errors up to 2 cm, as clicked by a person.
const char* const objects_yaml = R"(
radius_m: 0.06
objects:
  - name: box width
    length_m: 0.32
    kind: edges
    a: {point: [2.01, -0.15, 1.01], direction: [0.02, 0, 1]}
    b: {point: [1.99, 0.17, 1.0], direction: [0, 0, 1]}
  - name: box height
    length_m: 0.25
    kind: edges
    a: {point: [2.0, 0.01, 0.89], direction: [0, 1, 0]}
    b: {point: [2.01, 0.0, 1.12], direction: [0, 1, 0]}
  - name: bed length
    length_m: 2
    kind: edges
    a: {point: [1.6, -1.01, 0.41], direction: [1, 0, 0]}
    b: {point: [1.58, 1.02, 0.4], direction: [1, 0, 0]}
  - name: box to wall
    length_m: 1.0
    kind: planes
    a: {point: [2.01, 0.0, 1.01], normal: [1, 0, 0]}
    b: {point: [2.98, 0.3, 1.3], normal: [-1, 0, 0.05]}
  - name: box diagonal
    length_m: 0.406079
    kind: points
    a: {point: [2.0, -0.15, 0.89], edges: [[0, 0, 1], [0, 1, 0]], face: [2, 0, 1]}
    b: {point: [2.0, 0.15, 1.12], edges: [[0, 0, 1], [0, 1, 0]]}
)";

std::vector<LengthObject> objects() { return parse_length_objects(objects_yaml, "objects.yaml").objects; }

MeasuredLength box_width(const Map& map) { return measure_lengths(map, {objects()[0]}, {}, room().pool()).front(); }

std::vector<MeasuredLength> measured(const Map& map) { return measure_lengths(map, objects(), {}, room().pool()); }

std::string refused(const std::string& yaml) {
  try {
    parse_length_objects(yaml, "some.yaml");
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

std::string with_object(const std::string& lines) { return "objects:\n  - {name: n, " + lines + "}\n"; }

TEST(MapLengths, AreCorrectWithCorrectKeyframePoses) {
  for (const MeasuredLength& one : measured(room().map(1, 0.0))) {
    ASSERT_TRUE(one.length_m) << one.name << ": " << one.note;
    EXPECT_LT(std::abs(*one.error_m()), 0.004) << one.name;
    EXPECT_LT(one.sigma_m, 0.010) << one.name;
    EXPECT_GE(one.keyframes_a, 3) << one.name;
    EXPECT_GE(one.image.keyframe, 0) << one.name;
  }
}

TEST(MapLengths, HaveErrorsWithinTheirSigmas) {
  double squares = 0.0, largest = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const MeasuredLength& one : measured(room().map(seed, 0.008))) {
      ASSERT_TRUE(one.length_m) << one.name << ": " << one.note;
      const double ratio = *one.error_m() / one.sigma_m;
      squares += ratio * ratio, ++count;
      largest = std::max(largest, std::abs(ratio));
    }
  }
  EXPECT_LT(squares / count, 1.5) << "sigmas are too small";
  EXPECT_GT(squares / count, 0.05) << "sigmas are too large";
  EXPECT_LT(largest, 3.5);
}

TEST(MapLengths, DoNotDependOnThreads) {
  const Map map = room().map(3, 0.004);
  const std::vector<LengthObject> box = {objects()[0], objects()[3]};
  const auto with_threads = [&](int threads) {
    TaskPool pool(threads);
    return lengths_as_json({{"m", measure_lengths(map, box, {}, pool)}});
  };
  EXPECT_EQ(with_threads(1), with_threads(3));
}

TEST(MapLengths, OfObjectsWithoutDepthHaveLargerSigmas) {
  // The box is transparent: no depth at all on it, or that of the wall.
  const auto on_box = [](const Vector3d& point) {
    return point.x() < 2.25 && std::abs(point.y()) < 0.17 && point.z() > 0.87;
  };
  const double seen = box_width(room().map(2, 0.003)).sigma_m;
  const MeasuredLength glass = box_width(room().map(2, 0.003, on_box));
  ASSERT_TRUE(glass.length_m) << glass.note;
  EXPECT_GT(glass.sigma_m, 1.5 * seen);
  EXPECT_LT(std::abs(*glass.error_m()), 3.0 * glass.sigma_m);
  EXPECT_THAT(glass.note, HasSubstr("depth is missing"));
}

TEST(MapLengths, AreTriangulatedInMapsWithoutDepth) {
  double squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto lengths = measured(room().map(seed, 0.002, [](const Vector3d&) { return true; }));
    for (const std::size_t k : {0, 1, 4}) {
      ASSERT_TRUE(lengths[k].length_m) << lengths[k].name << ": " << lengths[k].note;
      EXPECT_LT(std::abs(*lengths[k].error_m()), 0.012) << lengths[k].name;
      EXPECT_LT(lengths[k].sigma_m, 0.015) << lengths[k].name;
      squares += std::pow(*lengths[k].error_m() / lengths[k].sigma_m, 2), ++count;
    }
    EXPECT_THAT(lengths[3].note, HasSubstr("only edges"));
  }
  EXPECT_LT(squares / count, 2.0);
}

/// What is given as 5 cm too near is found where it is.
TEST(MapLengths, WithoutDepthDoNotFollowFromTheGivenPoints) {
  LengthObject wrong = objects()[0];
  for (LengthPoint* end : {&wrong.a, &wrong.b}) end->point.x() -= 0.05;
  const Map map = room().map(2, 0.001, [](const Vector3d&) { return true; });
  const MeasuredLength box = measure_lengths(map, {wrong}, {}, room().pool()).front();
  ASSERT_TRUE(box.length_m) << box.note;
  EXPECT_NEAR(*box.length_m, 0.32, 0.004) << "0.312 where it was given";
}

TEST(MapLengths, SeenFromOneSideAloneSayThatNothingTellsTheDistance) {
  Map map = room().map(2, 0.0, [](const Vector3d&) { return true; });
  map.keyframes.resize(2);
  for (Keyframe& keyframe : map.keyframes) keyframe.world_from_camera = LengthRoom::true_pose(keyframe.id);
  const MeasuredLength box = box_width(map);
  if (box.length_m) {
    EXPECT_THAT(box.note, HasSubstr("nearly one direction"));
    EXPECT_GT(box.sigma_m, 0.005);
  }
}

TEST(MapLengths, AreNotMeasuredWithoutEvidence) {
  const auto far = parse_length_objects(
      "objects:\n"
      "  - {name: behind, kind: planes, a: {point: [-3, 0, 1]}, b: {point: [-4, 0, 1]}}\n"
      "  - {name: bare wall, kind: edges, a: {point: [3, -0.9, 1.7], direction: [0, 0, 1]},"
      " b: {point: [3, -0.6, 1.7], direction: [0, 0, 1]}}\n",
      "far.yaml");
  const auto lengths = measure_lengths(room().map(1, 0.0), far.objects, {}, room().pool());
  EXPECT_FALSE(lengths[0].length_m);
  EXPECT_EQ(lengths[0].note, "no keyframe shows it");
  EXPECT_FALSE(lengths[1].length_m) << *lengths[1].length_m;
}

TEST(MapLengths, OfACloudEndWhereItsPointsEnd) {
  const PointCloud cloud = build_cloud(room().map(1, 0.0), {}, nullptr);
  for (const MeasuredLength& one : measure_lengths(cloud, objects(), {})) {
    ASSERT_TRUE(one.length_m) << one.name << ": " << one.note;
    EXPECT_LT(std::abs(*one.error_m()), 3.0 * one.sigma_m) << one.name;
    EXPECT_LT(one.sigma_m, 0.03) << one.name;
  }
}

TEST(LengthScale, IsSetByTheKnownOne) {
  std::vector<MeasuredLength> lengths(3);
  lengths[0].name = "door", lengths[0].true_length_m = 2.0, lengths[0].length_m = 4.0, lengths[0].sigma_m = 0.04;
  lengths[1].name = "table", lengths[1].length_m = 1.0, lengths[1].sigma_m = 0.0;
  lengths[2].name = "hidden";
  EXPECT_EQ(scale_by_known_length(lengths, "door"), 0.5);
  ASSERT_EQ(lengths.size(), 2U) << "the known one is no result";
  EXPECT_DOUBLE_EQ(*lengths[0].length_m, 0.5);
  EXPECT_DOUBLE_EQ(lengths[0].sigma_m, 0.005) << "1 %, that of the door";
  EXPECT_FALSE(lengths[1].length_m);
  lengths[1].true_length_m = 1.0;
  EXPECT_FALSE(scale_by_known_length(lengths, "hidden"));
  EXPECT_EQ(lengths.size(), 2U);
}

TEST(CombinedLengths, KeyframesThatObserveBothDoNotNeedTheirPoses) {
  // The true length is 1; every keyframe has an error of up to 10 cm, the same for both ends.
  LengthObservations a, b;
  for (int k = 0; k < 9; ++k) {
    const double off = 0.1 * std::sin(2.0 * k);
    a.all.push_back({k, off, 0.001, 0.0, 0.0});
    b.all.push_back({k, 1.0 + off, 0.001, 0.0, 0.0});
  }
  const auto together = combine_lengths(a, b);
  ASSERT_TRUE(together);
  EXPECT_NEAR(together->length_m, 1.0, 1e-9);
  EXPECT_LT(together->sigma_m, 0.003);
  EXPECT_EQ(together->together, 9);
  for (LengthObservation& one : b.all) one.keyframe += 100;
  const auto combined = combine_lengths(a, b);
  ASSERT_TRUE(combined);
  EXPECT_GT(combined->sigma_m, 0.05) << "their poses scatter by 7 cm";
}

TEST(CombinedLengths, EstimatesHeightsOfFacesFromDifferentSides) {
  // A face 2 cm higher than assumed: from the two sides its edge has errors of opposite sign.
  LengthObservations a, b;
  a.height_sigma_m = b.height_sigma_m = 0.015;
  for (int k = 0; k < 8; ++k) {
    const double lever = k % 2 == 0 ? 1.0 : -0.5;
    a.all.push_back({k, 0.02 * lever, 0.001, 0.0, lever});
    b.all.push_back({k, 1.0, 0.001, 0.0, 0.0});
  }
  const auto length = combine_lengths(a, b);
  ASSERT_TRUE(length);
  EXPECT_NEAR(length->length_m, 1.0, 0.002);
  a.all.resize(1);
  EXPECT_GT(combine_lengths(a, b)->sigma_m, 0.014) << "one side does not determine it";
}

TEST(CombinedLengths, OutliersAreLeftOut) {
  LengthObservations a, b;
  for (int k = 0; k < 8; ++k) {
    a.all.push_back({k, 0.0005 * (k % 3), 0.001, 0.0, 0.0});
    b.all.push_back({k, k == 4 ? 1.05 : 1.0, 0.001, 0.0, 0.0});
  }
  const auto length = combine_lengths(a, b);
  EXPECT_NEAR(length->length_m, 0.9995, 0.0006);
  EXPECT_EQ(length->seen_b, 7);
  EXPECT_FALSE(combine_lengths(a, {}));
}

TEST(LengthObjects, AreReadAndTransformed) {
  const LengthObjects read = parse_length_objects(
      "frame: truth\nradius_m: 0.1\nobjects:\n"
      "  - {name: w, kind: planes, length_m: 3.5, radius_m: 0.2, a: {point: [1, 2, 3], normal: [0, 2, 0]}, b: {point: "
      "[0, 0, 0]}}\n",
      "x");
  EXPECT_TRUE(read.in_frame_of_ground_truth);
  const LengthObject& object = read.objects.at(0);
  EXPECT_EQ(object.radius_m, 0.2);
  EXPECT_EQ(object.true_length_m, 3.5);
  EXPECT_EQ(object.a.normal, Vector3d(0, 1, 0));
  const LengthObject there = moved(object, SE3(SO3::exp({0, 0, M_PI / 2}), {1, 0, 0}));
  EXPECT_LT((there.a.point - Vector3d(-1, 1, 3)).norm(), 1e-12);
  EXPECT_LT((*there.a.normal - Vector3d(-1, 0, 0)).norm(), 1e-12);
}

TEST(LengthObjects, ErrorsAreReportedInOneLine) {
  EXPECT_THAT(refused("objects: []"), HasSubstr("some.yaml:1"));
  EXPECT_THAT(refused("frame: moon\nobjects: [1]"), HasSubstr("neither first_camera nor truth"));
  EXPECT_THAT(refused("objects: [1]"), HasSubstr("is not 'key: value' lines"));
  EXPECT_THAT(refused("objects: [{name: n, knid: edges}]"), HasSubstr("did you mean 'kind'?"));
  const std::string a = "kind: edges, a: {point: [0, 0, 1], direction: [1, 0, 0]}, ";
  EXPECT_THAT(refused(with_object(a + "b: {point: [0, 1], direction: [1, 0, 0]}")), HasSubstr("not three numbers"));
  EXPECT_THAT(refused(with_object(a + "b: {point: [0, 1, 1], direction: [0, 0, 0]}")), HasSubstr("not a direction"));
  EXPECT_THAT(refused(with_object(a + "b: {point: [0, 1, 1], direction: [0, 1, 0]}")), HasSubstr("not parallel"));
  EXPECT_THAT(refused(with_object(a + "b: {point: [3, 0, 1], direction: [1, 0, 0]}")), HasSubstr("edge itself"));
  EXPECT_THAT(refused(with_object(a + "b: {point: [0, 0, 1], direction: [1, 0, 0]}")),
              HasSubstr("b is at the same position as a"));
  EXPECT_THAT(refused("objects: [{name: n, kind: edges, a: *b}]"), HasSubstr("not valid YAML"));
  EXPECT_EQ(refused(with_object(a + "b: {point: [0, 1, 1], direction: [1, 0, 0]}")), "taken");
}

TEST(LengthReport, SummarizesSeveralMaps) {
  MeasuredLength one;
  one.name = "a, \"b\"";
  one.true_length_m = 1.0;
  one.length_m = 1.02, one.sigma_m = 0.01;
  MeasuredLength other = one, missing = one;
  other.length_m = 0.99;
  missing.length_m.reset();
  missing.note = "no keyframe shows it";
  const std::vector<MapOfLengths> maps = {{"m1", {one}}, {"m2", {other}}, {"m3", {missing}}};
  const LengthSummary summary = summarize_lengths(maps).at(0);
  EXPECT_EQ(summary.measured, 2);
  EXPECT_NEAR(summary.mean_m, 1.005, 1e-12);
  EXPECT_NEAR(*summary.mean_error_m, 0.015, 1e-12);
  EXPECT_NEAR(*summary.max_error_m, 0.02, 1e-12);
  EXPECT_NEAR(*summary.rms_sigmas, std::sqrt(2.5), 1e-9);
  EXPECT_THAT(lengths_as_text(maps), HasSubstr("not measurable: no keyframe shows it"));
  EXPECT_THAT(lengths_as_csv(maps), HasSubstr("\"m2\",\"a, \"\"b\"\"\",edges,0.990000,0.010000,1.000000,-0.010000"));
  EXPECT_THAT(lengths_as_json(maps), HasSubstr("\"max_error_m\": 0.02"));
  for (const auto& [name, value] : length_figures(maps))
    if (name == "measured") {
      EXPECT_NEAR(value, 2.0 / 3.0, 1e-12);
    }
}

}  // namespace
}  // namespace rastro
