// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/place_plot.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"

namespace rastro {
namespace {

using testing::HasSubstr;

std::vector<PlaceBelief> some_places() {
  return {{0, 1.0, no_keyframe, 0.0, 0.11, {}, {}},
          {1, 0.9, 0, 0.1, 0.11, {}, {}},
          {2, 0.4, 0, 0.6, 0.11, {}, {0, 1}},
          {3, 0.2, 1, 0.8, 0.11, {1}, {}},
          {4, 0.1, 2, 0.9, 0.11, {2, 1}, {0}}};
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::size_t count_of(const std::string& text, const std::string& piece) {
  std::size_t count = 0;
  for (auto at = text.find(piece); at != std::string::npos; at = text.find(piece, at + 1)) ++count;
  return count;
}

constexpr const char *green = "fill=\"#149628\"/>", *red = "fill=\"#dc2828\"/>", *light_blue = "fill=\"#afcde8\"/>";
constexpr std::size_t in_legend = 1;

TEST(PlacePlot, HasADotForEveryDecision) {
  const auto file = scratch_folder("place_plot") / "places.svg";
  write_place_plot(some_places(), file.string());
  const std::string drawn = text_of(file);
  EXPECT_THAT(drawn, HasSubstr("Places: 5 keyframes, 3 matches with earlier places, 3 rejected"));
  EXPECT_THAT(drawn, HasSubstr("threshold 0.11"));
  EXPECT_EQ(count_of(drawn, green), 2U + 3U + in_legend) << "two keyframes above, three matches below";
  EXPECT_EQ(count_of(drawn, red), 1U + 3U + in_legend) << "above, a keyframe with a match is green alone";
  EXPECT_EQ(count_of(drawn, light_blue), 1U + in_legend);
}

TEST(PlacePlot, DotsStandWhereTheAxesSay) {
  const auto file = scratch_folder("place_plot_axes") / "places.svg";
  write_place_plot(some_places(), file.string());
  const std::string drawn = text_of(file);
  // Above: keyframes 0 to 4 over 1285 pixels from 80, probabilities 0 to 1 over 300 pixels up to 100.
  EXPECT_THAT(drawn, HasSubstr("<circle cx=\"1043.8\" cy=\"160.0\" r=\"3\"")) << "keyframe 3, probability 0.8";
  // Below: locations 0 to 4 over 530 pixels up to 450.
  EXPECT_THAT(drawn, HasSubstr("<circle cx=\"1043.8\" cy=\"847.5\" r=\"3\"")) << "keyframe 3 with location 1";
}

TEST(PlacePlot, IsTheSamePngEveryTime) {
  const auto folder = scratch_folder("place_plot_png");
  for (const char* name : {"a.png", "b.png"}) write_place_plot(some_places(), (folder / name).string());
  EXPECT_EQ(text_of(folder / "a.png"), text_of(folder / "b.png"));
  const cv::Mat drawn = cv::imread((folder / "a.png").string());
  ASSERT_FALSE(drawn.empty());
  EXPECT_EQ(drawn.at<cv::Vec3b>(160, 1044), cv::Vec3b(40, 150, 20)) << "keyframe 3, probability 0.8";
}

TEST(PlacePlot, OneKeyframeOrLocationsOfEarlierRunsCanBePlotted) {
  const auto file = scratch_folder("place_plot_few") / "places.png";
  write_place_plot({{7, 1.0, no_keyframe, 0.0, 0.11, {}, {}}}, file.string());
  EXPECT_FALSE(cv::imread(file.string()).empty());
  write_place_plot({{7, 0.5, 3, 0.5, 0.11, {2}, {}}}, file.string());
  EXPECT_FALSE(cv::imread(file.string()).empty());
}

TEST(PlacePlot, AboveOnlyTheMostLikelyLocationIsRed) {
  const auto file = scratch_folder("place_plot_likely") / "places.svg";
  write_place_plot({{5, 0.5, 3, 0.5, 0.11, {}, {2}}}, file.string());
  EXPECT_EQ(count_of(text_of(file), red), 1U + in_legend) << "location 2 is below alone";
  EXPECT_THAT(text_of(file), testing::Not(HasSubstr("no place was left")));
  write_place_plot({{5, 1.0, no_keyframe, 0.0, 0.11, {}, {}}}, file.string());
  EXPECT_THAT(text_of(file), HasSubstr("no place was left long enough ago"));
}

TEST(PlacePlot, WithoutPlacesOrUnderAnotherNameIsRefused) {
  const auto folder = scratch_folder("place_plot_refused");
  EXPECT_THROW(write_place_plot({}, (folder / "places.png").string()), Error);
  EXPECT_THROW(write_place_plot(some_places(), (folder / "places.pdf").string()), Error);
}

}  // namespace
}  // namespace rastro
