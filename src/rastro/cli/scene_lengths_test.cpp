// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/scene_lengths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/evaluate/length_room_testing.h"

namespace rastro::cli {
namespace {

using ::testing::HasSubstr;

const LengthRoom& room() {
  static const LengthRoom room;
  return room;
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

TEST(SceneLengths, AClickedEdgeIsMeasuredInTheImages) {
  const Map map = room().map(1, 0.002);
  // As a browser writes it.
  const std::string query =
      "kind=edges&a=2.01%2C-0.15%2C1.01&a_direction=0.02%2C0%2C1&a_face=2%2C0%2C1"
      "&b=1.99%2C0.17%2C1.0&b_direction=0%2C0%2C-1&b_face=2%2C0.1%2C1";
  const auto answer = nlohmann::json::parse(measured_as_json(map, query, room().pool()));
  ASSERT_TRUE(answer.contains("length")) << answer;
  const double sigma = answer["sigma"];
  EXPECT_LT(sigma, 0.01);
  EXPECT_NEAR(answer["length"].get<double>(), 0.32, 3.0 * sigma);
  const auto a = answer["a"].get<std::array<double, 3>>(), b = answer["b"].get<std::array<double, 3>>();
  EXPECT_NEAR(distance(a, b), answer["length"].get<double>(), 1e-9) << "the line is as long as the length";
}

TEST(SceneLengths, WhatIsNoLengthIsAProblemInWords) {
  const Map map = room().map(1, 0.002);
  for (const char* query : {"", "kind=edges", "kind=points&a=0,0,0&b=1,0,0", "kind=planes&a=1,2&b=3", "%2C%2",
                            "a=&b=&kind=", "kind=planes&a=0,0,0&a_direction=0,0,0&b=1,0,0&b_direction=1,0,0",
                            "kind=planes&a=nan,0,0&a_direction=1,0,0&b=1,0,0&b_direction=1,0,0",
                            "kind=planes&a=9,9,9&a_direction=1,0,0&b=9,9,8&b_direction=1,0,0"})
    EXPECT_TRUE(nlohmann::json::parse(measured_as_json(map, query, room().pool())).contains("problem")) << query;
}

TEST(SceneLengths, NamedLengthsComeFromObjectsAndFromTheResultInTheRun) {
  const std::filesystem::path folder = scratch_folder("named_lengths");
  std::ofstream(folder / "objects.yaml") << R"(objects:
  - {name: box to wall, kind: planes, a: {point: [2, 0, 1], normal: [1, 0, 0]}, b: {point: [3, 0.3, 1.3], normal: [1, 0, 0]}})";
  std::ofstream(folder / "lengths.json") << R"({"maps": [{"map": "run", "lengths": [
    {"name": "table", "length_m": 0.8, "sigma_m": 0.004, "a": [0, 0.1, 0], "b": [0.8, -0.1, 0], "direction": [1, 0, 0]},
    {"name": "glass", "length_m": null, "sigma_m": null, "a": [0, 0, 0], "b": [0, 0, 0]}]}]})";
  const ExportInput input{folder.string(), std::make_shared<const Map>(room().map(1, 0.002)), {}};
  const auto lengths = lengths_of(input, (folder / "objects.yaml").string(), room().pool());
  ASSERT_EQ(lengths.size(), 2U);
  EXPECT_EQ(lengths[0].name, "box to wall");
  EXPECT_NEAR(lengths[0].length, 1.0, 3.0 * lengths[0].sigma);
  EXPECT_EQ(lengths[1].name, "table");
  EXPECT_NEAR(lengths[1].a[1], 0.0, 1e-12) << "along the direction of the measurement";
  EXPECT_NEAR(distance(lengths[1].a, lengths[1].b), 0.8, 1e-12);
}

TEST(SceneLengths, ADamagedResultIsRefused) {
  const std::filesystem::path folder = scratch_folder("damaged_lengths");
  for (const char* text : {"", "{", "[]", R"({"maps": 1})", R"({"maps": [{}]})", R"({"maps": [{"lengths": [1]}]})",
                           R"({"maps": [{"lengths": [{"name": "x", "length_m": 1}]}]})"}) {
    std::ofstream(folder / "lengths.json") << text;
    EXPECT_THROW(lengths_of({folder.string(), nullptr, {}}, "", room().pool()), Error) << text;
  }
}

}  // namespace
}  // namespace rastro::cli
