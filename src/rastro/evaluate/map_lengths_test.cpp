// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/map_lengths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/evaluate/length_room_testing.h"

namespace rastro {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

const LengthRoom& room() {
  static const LengthRoom room;
  return room;
}

/// Spots are off by up to 2 cm, as clicked by a person.
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
    a: {point: [2.0, -0.15, 0.89], edges: [[0, 0, 1], [0, 1, 0]]}
    b: {point: [2.0, 0.15, 1.12], edges: [[0, 0, 1], [0, 1, 0]]}
)";

std::vector<MeasuredLength> measured(const RgbdMap& map) {
  return measure_lengths(map, parse_length_objects(objects_yaml, "objects.yaml").objects, {}, room().pool());
}

TEST(MapLengths, AreTrueWhereKeyframesStandRight) {
  for (const MeasuredLength& one : measured(room().map(1, 0.0))) {
    ASSERT_TRUE(one.length_m) << one.name << ": " << one.note;
    printf("%s %.4f +- %.4f (%.4f) %d %d %d %.2f %s\n", one.name.c_str(), *one.length_m, one.sigma_m, *one.error_m(),
           one.keyframes_a, one.keyframes_b, one.together, one.support, one.note.c_str());
    EXPECT_LT(std::abs(*one.error_m()), 0.006) << one.name;
    EXPECT_LT(one.sigma_m, 0.012) << one.name;
  }
}

TEST(MapLengths, ErrWithinTheirSigmas) {
  double squares = 0.0, most = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    for (const MeasuredLength& one : measured(room().map(seed, 0.008))) {
      ASSERT_TRUE(one.length_m) << one.name << ": " << one.note;
      printf("%s %.4f +- %.4f (%.4f) %d %d %d %.2f %s\n", one.name.c_str(), *one.length_m, one.sigma_m, *one.error_m(),
             one.keyframes_a, one.keyframes_b, one.together, one.support, one.note.c_str());
      const double ratio = *one.error_m() / one.sigma_m;
      squares += ratio * ratio, ++count;
      most = std::max(most, std::abs(ratio));
    }
  }
  printf("%f %f\n", squares / count, most);
}

}  // namespace
}  // namespace rastro
