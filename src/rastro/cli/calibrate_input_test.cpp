// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/calibrate_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/calibration/board_rendering_testing.h"
#include "rastro/dataset/record/recording_writer.h"

namespace rastro::cli {
namespace {

using testing::HasSubstr;

const Board small_board{7, 5, 0.04};

/// Image k of every folder shows the same board at the same place, farther to the right than in image k - 1.
class BoardFolders : public testing::Test {
 protected:
  std::string folder(const std::string& name, int images) const {
    RecordingWriter writer({}, root_ / name);
    for (int k = 0; k < images; ++k) {
      Frame frame;
      frame.stamp = stamp_of(k);
      frame.image = image_of(k);
      writer.write(frame);
    }
    return (root_ / name).string();
  }

  void damage(const std::string& name, int image) const {
    std::ofstream(root_ / name / "mav0/cam0/data" / (std::to_string(stamp_of(image)) + ".png")) << "no image";
  }

  static BoardImages find(const std::string& left, const std::string& right, std::size_t most_views = 100) {
    DataFlags flags;
    flags.path = left;
    BoardSearchOptions search_for;
    search_for.right = right;
    search_for.most_views = most_views;
    ProgressBar bar(false);
    return find_boards(flags, small_board, search_for, bar);
  }

  static std::string refused(const std::string& left, const std::string& right) {
    try {
      find(left, right);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

 private:
  static TimeNs stamp_of(int k) { return 1'700'000'000 * ns_per_second + k * ns_per_second; }

  static GrayImage image_of(int k) {
    static const BoardRenderer renderer(small_board, undistorted_lens(LensModel::pinhole_4, 260.0, {160.0, 120.0}), 320,
                                        240);
    Random random(1);
    return renderer.render({SO3::exp({0.2, 0.1, 0.0}), {-0.25 + 0.05 * k, -0.08, 0.8}}, 0.0, random);
  }

  const std::filesystem::path root_ = scratch_folder("calibrate_input");
};

TEST_F(BoardFolders, ImagesOfOneNumberBelongTogetherAlsoBehindDamagedOnes) {
  const std::string left = folder("left", 7), right = folder("right", 7);
  damage("left", 4);
  damage("right", 2);
  damage("right", 6);
  const BoardImages images = find(left, right);
  std::vector<const BoardView*> left_views(images.input.frames.size());
  int pairs = 0;
  for (const BoardView& view : images.input.views) {
    const BoardView*& left_view = left_views[static_cast<std::size_t>(view.frame)];
    if (view.camera == 0) {
      left_view = &view;
      continue;
    }
    ASSERT_NE(left_view, nullptr);
    EXPECT_EQ(view.pixels, left_view->pixels) << images.input.frames[static_cast<std::size_t>(view.frame)];
    ++pairs;
  }
  EXPECT_EQ(pairs, 4) << "0, 1, 3 and 5";
  EXPECT_EQ(images.input.frames.size(), 6U) << "all but 4";
  EXPECT_EQ(images.images, 10);
  EXPECT_EQ(images.found, 10);
}

TEST_F(BoardFolders, BoardsAreCountedAlsoWhereTheyAreNotKept) {
  const std::string images = folder("images", 6);
  const BoardImages all = find(images, ""), few = find(images, "", 3);
  EXPECT_EQ(all.found, 6);
  EXPECT_EQ(few.found, 6);
  EXPECT_EQ(few.images, 6);
  EXPECT_EQ(few.input.views.size(), 3U);
}

TEST_F(BoardFolders, ARightCameraHasAsManyImages) {
  const std::string three = folder("three", 3), four = folder("four", 4);
  EXPECT_THAT(refused(four, three), HasSubstr("three: has fewer images than DATA"));
  EXPECT_THAT(refused(three, four), HasSubstr("four: has more images than DATA"));
  damage("four", 3);
  EXPECT_THAT(refused(three, four), HasSubstr("four: has more images than DATA"));
}

}  // namespace
}  // namespace rastro::cli
