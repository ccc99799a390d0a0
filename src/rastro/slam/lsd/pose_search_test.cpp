// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/pose_search.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

/// What hides much of the view moved on its own by `crowd_m`, in blocks that half of the image lies in.
class CrowdedView {
 public:
  CrowdedView(double crowd_m, const LsdOptions& options) {
    const SE3 crowd_from_camera(SO3(), {crowd_m, 0.0, 0.0});
    const RenderedFrame first = room_.render({});
    GrayImage second = room_.render(camera_from_keyframe().inverse()).gray;
    const GrayImage moved = room_.render(camera_from_keyframe().inverse() * crowd_from_camera).gray;
    for (int y = 0; y < second.height(); ++y) {
      for (int x = 0; x < second.width(); ++x) {
        if ((7 * (x / 20) + 3 * (y / 20)) % 20 < 10) second.at(x, y) = moved.at(x, y);
      }
    }
    image = alignment_pyramid(second, options.levels);
    auto pyramid = std::make_shared<const Pyramid>(alignment_pyramid(first.gray, options.levels));
    auto reference = std::make_shared<AlignmentReference>();
    reference->build(*pyramid, testing::semi_dense_depth(first, 5.0, 0.02, 1), room_.camera(),
                     {options.levels, 5.0, 0});
    keyframe.emplace(options, nullptr, 0, pyramid, reference, 0.3, 10);
  }

  static SE3 camera_from_keyframe() { return {SO3::exp({0.0, 0.01, 0.0}), {-0.03, 0.0, 0.01}}; }
  double error_m(const SE3& found) const {
    return (found.inverse().translation() - camera_from_keyframe().inverse().translation()).norm();
  }
  const Camera& camera() const { return room_.camera(); }

  Pyramid image;
  std::optional<CurrentKeyframe> keyframe;

 private:
  testing::AlignmentRoom room_;
};

/// On coarse levels the crowd takes the pose along; near the motion that goes on, the walls alone fit better.
TEST(PoseSearch, ACrowdDoesNotTakeThePoseWhereNoCameraCouldMoveSo) {
  const LsdOptions options;
  const CrowdedView view(0.06, options);
  const PoseSearch search(options, view.camera());
  const SE3 velocity = CrowdedView::camera_from_keyframe();
  const JudgedAlignment anywhere = search.track(*view.keyframe, view.image, {SE3(), velocity, 0});
  const JudgedAlignment reachable = search.track(*view.keyframe, view.image, {SE3(), velocity, 0, 0.02});
  EXPECT_GT(view.error_m(anywhere.alignment.image_from_reference), 0.03) << "else nothing is tested";
  EXPECT_EQ(reachable.verdict.grade, PoseGrade::tracking);
  EXPECT_LT(view.error_m(reachable.alignment.image_from_reference), 0.006);
  EXPECT_GT(reachable.alignment.inlier_share, anywhere.alignment.inlier_share + 0.05);
}

/// The limit on steps is no prior: what fits elsewhere alone stays.
TEST(PoseSearch, AJumpOfTheWholeViewIsFollowed) {
  const LsdOptions options;
  const CrowdedView view(0.0, options);
  const PoseSearch search(options, view.camera());
  const SE3 away(SO3(), {0.06, 0.0, 0.0});
  const JudgedAlignment found =
      search.track(*view.keyframe, view.image, {away, CrowdedView::camera_from_keyframe(), 0, 0.02});
  EXPECT_LT(view.error_m(found.alignment.image_from_reference), 0.003);
}

/// Else a rotation is searched for among all shifts of a large image, which takes seconds to minutes.
TEST(PoseSearch, RotationsAreSearchedForInASmallImageWhateverTheLevels) {
  const GrayImage image(640, 480);
  for (const int levels : {1, 2, 3, 4, 5}) {
    const PoseSearch::SmallImage small = PoseSearch::small_of(alignment_pyramid(image, levels));
    EXPECT_LE(small.image.width(), 128) << levels;
    EXPECT_EQ(small.image.width(), 640 >> small.level) << levels;
    EXPECT_EQ(small.image.height(), 480 >> small.level) << levels;
  }
  EXPECT_EQ(PoseSearch::small_of(alignment_pyramid(image, 5)).level, 4);
}

}  // namespace
}  // namespace rastro
