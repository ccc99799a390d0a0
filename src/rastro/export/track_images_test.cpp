// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/track_images.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/export/drawing.h"
#include "rastro/export/match_image.h"
#include "rastro/export/track_frames_testing.h"
#include "rastro/export/video.h"

namespace rastro {
namespace {

using enum TrackState;

GrayImage flat_image(int width, int height, std::uint8_t value = 90) {
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y) std::fill_n(image.row(y), width, value);
  return image;
}

/// Smoothed strokes are never of the pure color, so a hue is told by what dominates.
bool is_green(const cv::Vec3b& p) { return p[1] > p[0] + 50 && p[1] > p[2] + 50; }
bool is_magenta(const cv::Vec3b& p) { return p[0] > p[1] + 50 && p[2] > p[1] + 50; }

int count_of(const cv::Mat& image, bool (*is_hue)(const cv::Vec3b&)) {
  return static_cast<int>(std::count_if(image.begin<cv::Vec3b>(), image.end<cv::Vec3b>(), is_hue));
}

TEST(TrackImages, RedDotStandsOnThePixelAndTheIdBesideIt) {
  const auto folder = scratch_folder("track_images");
  TrackImages images(folder / "images");
  const GrayImage image = flat_image(640, 200);
  images.write(make_frame(12, {make_feature(345, fresh, 100.0F, 80.0F)}), image);
  const cv::Mat drawn = cv::imread((folder / "images" / "000012.png").string());
  ASSERT_FALSE(drawn.empty());
  const int caption = drawn.rows - 200;
  const cv::Vec3b dot = drawn.at<cv::Vec3b>(80 + caption, 100);
  EXPECT_EQ(dot, cv::Vec3b(40, 40, 255));
  EXPECT_GT(count_of(drawn(cv::Rect(104, 65 + caption, 40, 15)), is_green), 5);
}

TEST(TrackImages, IdsAtTheEdgeAreNotClipped) {
  const GrayImage image = flat_image(640, 100);
  // The same label must have the same number of green pixels in the middle and in each corner.
  const auto green_at = [&](float x, float y) {
    const cv::Mat drawn = drawing::overlay(make_frame(0, {make_feature(88888, fresh, x, y)}), image);
    return count_of(drawn(cv::Rect(0, drawn.rows - 100, 640, 100)), is_green);
  };
  const int whole = green_at(300.0F, 50.0F);
  ASSERT_GT(whole, 20);
  EXPECT_EQ(green_at(639.0F, 50.0F), whole);
  EXPECT_EQ(green_at(300.0F, 0.0F), whole);
  EXPECT_EQ(green_at(639.0F, 99.0F), whole);
}

TEST(TrackImages, SmallImagesAreEnlargedAndTheDotStaysInPlace) {
  const cv::Mat drawn = drawing::overlay(make_frame(0, {make_feature(1, fresh, 50.0F, 40.0F)}), flat_image(160, 120));
  const int scale = drawing::scale_for(160);
  EXPECT_GE(drawn.cols, 600);
  EXPECT_EQ(drawn.cols, 160 * scale);
  const int caption = drawn.rows - 120 * scale;
  EXPECT_EQ(drawn.at<cv::Vec3b>(40 * scale + scale / 2 + caption, 50 * scale + scale / 2), cv::Vec3b(40, 40, 255));
}

TEST(MatchImage, CountsFollowedAndReidentified) {
  const auto folder = scratch_folder("match");
  MatchImage match(folder / "m.png", 1, 4);
  const GrayImage image = flat_image(320, 240);
  // 0 followed; 1 lost in frame 2, back in 4; 2 lost for good; 3 re-identified in 3 and tracked in 4; 9 came later.
  match.write(make_frame(0, {make_feature(0, fresh)}), image);
  match.write(
      make_frame(1, {make_feature(0, tracked), make_feature(1, fresh), make_feature(2, fresh), make_feature(3, fresh)}),
      image);
  match.write(make_frame(2, {make_feature(0, tracked)}), image);
  EXPECT_FALSE(match.counts());
  match.write(make_frame(3, {make_feature(0, tracked), make_feature(3, reidentified), make_feature(9, fresh)}), image);
  match.write(make_frame(4, {make_feature(0, tracked), make_feature(1, reidentified), make_feature(3, tracked),
                             make_feature(9, tracked)}),
              image);
  match.write(make_frame(5, {make_feature(0, tracked), make_feature(2, reidentified)}), image);
  match.finish();
  ASSERT_TRUE(match.counts());
  EXPECT_EQ(match.counts()->in_first, 4);
  EXPECT_EQ(match.counts()->followed, 1);
  EXPECT_EQ(match.counts()->reidentified, 2);
  EXPECT_TRUE(std::filesystem::exists(folder / "m.png"));
}

TEST(MatchImage, LinesHaveTheColorsOfTheirKind) {
  const auto folder = scratch_folder("match_colors");
  MatchImage match(folder / "m.png", 0, 2);
  const GrayImage image = flat_image(640, 100);
  match.write(make_frame(0, {make_feature(0, fresh, 50.0F, 20.0F), make_feature(1, fresh, 50.0F, 80.0F)}), image);
  match.write(make_frame(1, {make_feature(0, tracked, 50.0F, 20.0F)}), image);
  match.write(make_frame(2, {make_feature(0, tracked, 50.0F, 20.0F), make_feature(1, reidentified, 50.0F, 80.0F)}),
              image);
  const cv::Mat drawn = cv::imread((folder / "m.png").string());
  const int caption = drawn.rows - 100;
  EXPECT_GT(count_of(drawn.row(20 + caption), is_magenta), 600);
  EXPECT_EQ(count_of(drawn.row(20 + caption), is_green), 0);
  EXPECT_GT(count_of(drawn.row(80 + caption), is_green), 600);
}

TEST(MatchImage, RefusesFramesInTheWrongOrder) {
  EXPECT_THROW(MatchImage("m.png", 5, 5), Error);
  EXPECT_THROW(MatchImage("m.png", -1, 5), Error);
}

TEST(TrackVideo, NeedsAVideoFileName) { EXPECT_THROW(TrackVideo("frames.gif"), Error); }

}  // namespace
}  // namespace rastro
