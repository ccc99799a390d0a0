// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/grid_map_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/export/landmarks_csv.h"

namespace rastro {
namespace {

using testing::HasSubstr;

constexpr const char* sound_yaml =
    "image: a.pgm\nresolution: 0.05\norigin: [-1, -2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

OccupancyGrid every_percentage() {
  OccupancyGrid grid;
  grid.cell_m = 0.05;
  grid.origin = {-12.35, 3.1};
  grid.width = 17;
  grid.height = 6;
  for (int k = 0; k < 102; ++k) grid.percent.set(k % 17, k / 17, static_cast<std::int8_t>(k - 1));
  return grid;
}

std::string message_of(const std::string& yaml, const std::string& pgm) {
  try {
    parse_map_server(yaml, "m.yaml", pgm, "a.pgm");
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(GridMapServer, ReadsBackWhatItWrites) {
  const OccupancyGrid grid = every_percentage();
  const OccupancyGrid back = parse_map_server(map_server_yaml(grid, "a.pgm"), "m", map_server_pgm(grid), "a.pgm");
  EXPECT_EQ(back.width, grid.width);
  EXPECT_EQ(back.height, grid.height);
  EXPECT_DOUBLE_EQ(back.cell_m, grid.cell_m);
  EXPECT_TRUE(back.origin.isApprox(grid.origin));
  for (int k = 0; k < 102; ++k) {
    const int percent = k - 1;
    const int expected = percent >= 65 ? 100 : percent >= 0 && percent < 20 ? 0 : OccupancyGrid::unknown;
    EXPECT_EQ(back.at(k % 17, k / 17), expected) << percent;
  }
}

TEST(GridMapServer, ReadsBackTheImageOfAnyName) {
  const OccupancyGrid grid = every_percentage();
  EXPECT_THAT(map_server_yaml(grid, "a_1-b.pgm"), testing::StartsWith("image: a_1-b.pgm\n"));
  EXPECT_THAT(map_server_yaml(grid, "floor #1.pgm"), testing::StartsWith("image: 'floor #1.pgm'\n"));
  EXPECT_THAT(map_server_yaml(grid, "it's.pgm"), testing::StartsWith("image: 'it''s.pgm'\n"));
  const auto folder = scratch_folder("names");
  for (const std::string name : {"floor #1", "a: b", "it's", "[x]", "\"q\"", "- y", "caf\xc3\xa9"}) {
    write_whole_file(folder / (name + ".pgm"), map_server_pgm(grid));
    write_whole_file(folder / (name + ".yaml"), map_server_yaml(grid, name + ".pgm"));
    EXPECT_EQ(read_map_server((folder / (name + ".yaml")).string()).width, grid.width) << name;
  }
}

TEST(GridMapServer, GivesEveryPercentageItsOwnGrayAndTheTopRowFirst) {
  const std::string bytes = map_server_pgm(every_percentage());
  ASSERT_THAT(bytes, testing::StartsWith("P5\n17 6\n255\n"));
  const std::string pixels = bytes.substr(bytes.size() - 102);
  EXPECT_EQ(std::set<char>(pixels.begin(), pixels.end()).size(), 102U);
  EXPECT_EQ(static_cast<unsigned char>(pixels[5 * 17]), 205) << "cell (0, 0) is unknown";
  EXPECT_EQ(static_cast<unsigned char>(pixels[5 * 17 + 1]), 255);
  EXPECT_EQ(static_cast<unsigned char>(pixels[16]), 0);
}

TEST(GridMapServer, ReadsWhatOthersWrite) {
  const std::string pgm = std::string("P5\n# CREATOR: map_saver 0.050 m/pix\n3 1\n255\n") + '\xCD' + '\xFE' + '\x00';
  const std::string three = pgm + std::string(1, '\0');
  const OccupancyGrid grid = parse_map_server(
      "image: a.pgm\nmode: trinary\nresolution: 0.1\norigin:\n  - -1.0\n  - 2\n  - 0.0\nnegate: 0\n", "m", three, "a");
  EXPECT_THAT(grid.row(0), testing::ElementsAre(OccupancyGrid::unknown, 0, 100));
  EXPECT_DOUBLE_EQ(grid.origin.y(), 2.0);
  const OccupancyGrid negative =
      parse_map_server("image: a.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 1\n", "m", three, "a");
  EXPECT_EQ(negative.at(1, 0), 100);
  EXPECT_EQ(negative.at(2, 0), 0);
}

TEST(GridMapServer, RefusesWhatIsNoMapInOneLine) {
  const std::string sound = "P5 2 1 255 ab";
  EXPECT_EQ(message_of(sound_yaml, sound), "taken");
  EXPECT_THAT(message_of(sound_yaml, "P5 2 2 255 abc"), HasSubstr("3 of 4 cells"));
  EXPECT_THAT(message_of(sound_yaml, "P2 2 1 255 0 0"), HasSubstr("a.pgm"));
  EXPECT_THAT(message_of(sound_yaml, "P5 2 1 65535 abcd"), HasSubstr("256 grays"));
  EXPECT_THAT(message_of(sound_yaml, "P5 99999999 99999999 255 a"), HasSubstr("too large"));
  EXPECT_THAT(message_of(sound_yaml, "P5 -2 1 255 a"), HasSubstr("valid width"));
  EXPECT_THAT(message_of(sound_yaml, "P5"), HasSubstr("valid width"));
  EXPECT_THAT(message_of(sound_yaml, "P5 2 1 255"), HasSubstr("0 of 2 cells"));
  EXPECT_THAT(message_of("resolution: 0\norigin: [0, 0, 0]\n", sound), HasSubstr("resolution"));
  EXPECT_THAT(message_of("resolution: 0.05\n", sound), HasSubstr("origin"));
  EXPECT_THAT(message_of("resolution: 0.05\norigin: [0, 0, 1.5]\n", sound), HasSubstr("has a rotation"));
  EXPECT_THAT(message_of("resolution: 0.05\norigin: [0, 1e300, 0]\n", sound), HasSubstr("too large"));
  EXPECT_THAT(message_of("mode: raw\nresolution: 0.05\norigin: [0, 0, 0]\n", sound), HasSubstr("trinary"));
  EXPECT_THAT(message_of("resolution: 900\norigin: [0, 0, 0]\n", "P5 1 200 255 " + std::string(200, 'a')),
              HasSubstr("too large"));
  EXPECT_THAT(message_of("P5 2 1 255 ab", sound), HasSubstr(".yaml"));
  EXPECT_THAT(message_of("just words", sound), HasSubstr("not a map"));
}

TEST(GridMapServer, GivesALargeImageInPieces) {
  OccupancyGrid grid;
  grid.width = 3000;
  grid.height = 1000;
  grid.percent.set(2999, 0, 100);
  std::string bytes;
  map_server_pgm(grid, [&bytes](std::string_view piece) {
    EXPECT_LT(piece.size(), 1'100'000U);
    bytes += piece;
  });
  EXPECT_EQ(bytes.size(), std::string("P5\n3000 1000\n255\n").size() + 3'000'000U);
  EXPECT_EQ(static_cast<unsigned char>(bytes.back()), 0) << "the last cell of the lowest row";
  EXPECT_EQ(std::count(bytes.begin(), bytes.end(), static_cast<char>(205)), 2'999'999);
  EXPECT_EQ(map_server_pgm(grid), bytes);
}

TEST(GridMapServer, ReadsTheFileBesideTheYaml) {
  const auto folder = scratch_folder("map_server");
  const OccupancyGrid grid = every_percentage();
  write_whole_file(folder / "floor.pgm", map_server_pgm(grid));
  write_whole_file(folder / "floor.yaml", map_server_yaml(grid, "floor.pgm"));
  EXPECT_EQ(read_map_server((folder / "floor.yaml").string()).width, 17);
  write_whole_file(folder / "lost.yaml", map_server_yaml(grid, "nowhere.pgm"));
  EXPECT_THROW(read_map_server((folder / "lost.yaml").string()), Error);
}

TEST(LandmarksCsv, HasARowForEach) {
  LandmarkLayer layer;
  layer.landmarks.resize(1);
  layer.landmarks[0].id = 4;
  layer.landmarks[0].position = {1.5, -2.25, 0.0};
  layer.estimates.resize(1);
  layer.estimates[0].covariance.topLeftCorner<2, 2>() << 0.01, 0.002, 0.002, 0.04;
  layer.estimates[0].observations = 9;
  EXPECT_EQ(landmarks_csv(layer),
            "id,sensor_id,x,y,cov_xx,cov_xy,cov_yy,observations\n4,-1,1.500000,-2.250000,0.01,0.002,0.04,9\n");
}

}  // namespace
}  // namespace rastro
