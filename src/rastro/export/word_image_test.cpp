// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/word_image.h"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/export/word_map_testing.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr int right_px = WordMap::width + 6;  ///< Where the matched image begins.

Map three_locations() {
  return WordMap().add({1, 2}).add({1, 3, 3}).add({2, 1, 4, 3}).close(0, 2, 33).show(0, 60).show(2, 120).made();
}

void expect_near(const cv::Vec3b& pixel, const cv::Vec3b& color, const std::string& what) {
  for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(pixel[channel], color[channel], 35) << what << channel;
}

/// Feature k of location `id`.
cv::Vec3b dot(const cv::Mat& drawn, KeyframeId id, int k, int left = 0) {
  return drawn.at<cv::Vec3b>(40 + 10 * static_cast<int>(id), left + 20 + 30 * k);
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Blue, green, red.
const cv::Vec3b red(40, 40, 255), green(60, 230, 60), yellow(0, 230, 255), blue(255, 140, 40), pink(230, 120, 255);

TEST(WordImages, OnePerLocationWithTheWordsInTheirColors) {
  const fs::path folder = scratch_folder("word_images") / "words";
  TaskPool pool(2);
  const WordImageCounts counts = write_word_images(three_locations(), folder, pool);
  EXPECT_EQ(counts.locations, 3U);
  EXPECT_EQ(counts.loop_closures, 1U);
  const cv::Mat second = cv::imread((folder / "000001.jpg").string());
  ASSERT_EQ(second.cols, right_px + WordMap::width);
  ASSERT_GT(second.rows, WordMap::height);
  expect_near(dot(second, 1, 0), blue, "in the previous image");
  expect_near(dot(second, 1, 1), yellow, "twice");
  expect_near(dot(second, 1, 3), {110, 110, 110}, "a feature without a word, in an image that is missing");
  expect_near(second.at<cv::Vec3b>(10, right_px + 20), {32, 32, 32}, "no match");
  const cv::Mat third = cv::imread((folder / "000002.jpg").string());
  expect_near(dot(third, 2, 0), pink, "shared");
  expect_near(dot(third, 2, 1), pink, "shared, although in the previous image");
  expect_near(dot(third, 2, 2), green, "new");
  expect_near(dot(third, 2, 3), blue, "in the previous image");
  expect_near(third.at<cv::Vec3b>(150, 300), {120, 120, 120}, "its image");
  expect_near(dot(third, 0, 0, right_px), pink, "shared in the match");
  expect_near(third.at<cv::Vec3b>(150, right_px + 300), {60, 60, 60}, "the image of the match");
}

TEST(WordImages, WordsOfTheMatchThatAreNotSharedAreRed) {
  const fs::path folder = scratch_folder("word_images_match");
  TaskPool pool(1);
  write_word_images(WordMap().add({5, 1}).add({}).add({1}).close(0, 2, 9).made(), folder, pool);
  const cv::Mat drawn = cv::imread((folder / "000002.jpg").string());
  expect_near(dot(drawn, 0, 0, right_px), red, "not shared");
  expect_near(dot(drawn, 0, 1, right_px), pink, "shared");
}

TEST(WordImages, BytesDoNotDependOnThePool) {
  const fs::path folder = scratch_folder("word_images_pool");
  TaskPool one(1), four(4);
  std::vector<std::size_t> reports;
  write_word_images(three_locations(), folder / "one", one);
  write_word_images(three_locations(), folder / "four", four,
                    [&](std::size_t done, std::size_t) { reports.push_back(done); });
  for (const char* name : {"000000.jpg", "000001.jpg", "000002.jpg"}) {
    EXPECT_FALSE(bytes_of(folder / "one" / name).empty());
    EXPECT_EQ(bytes_of(folder / "one" / name), bytes_of(folder / "four" / name)) << name;
  }
  EXPECT_THAT(reports, testing::ElementsAre(3U));
}

TEST(WordImages, AMapWithoutLocationsIsRefused) {
  const fs::path folder = scratch_folder("word_images_none") / "words";
  TaskPool pool(1);
  try {
    write_word_images(Map(), folder, pool);
    FAIL() << "there is nothing to draw";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("--method rtabmap"));
  }
  EXPECT_FALSE(fs::exists(folder));
}

TEST(WordImages, AFolderThatCannotBeMadeIsRefused) {
  const fs::path file = scratch_folder("word_images_file") / "file";
  std::ofstream(file) << "here";
  TaskPool pool(1);
  EXPECT_THROW(write_word_images(three_locations(), file / "words", pool), Error);
}

}  // namespace
}  // namespace rastro
