// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/fusion/view_alignment.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "rastro/base/random.h"
#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

using testing::AlignmentRoom;

/// Depth noise of `AlignedRoom`, which is independent from pixel to pixel.
FusionOptions options_of_room() {
  FusionOptions options;
  options.depth_sigma_m = 0.0005, options.depth_sigma_per_m2 = 0.0007;
  options.surface_weight = 0.2;
  return options;
}

/// Pairs of noisy views of a room, with their exact motion.
class AlignedRoom {
 public:
  AlignedRoom() { sensor.sensor = CameraKind::depth, sensor.camera = room_.camera(), sensor.baseline = 0.4; }

  Frame frame(const SE3& world_from_camera, std::uint64_t seed) {
    const RenderedFrame seen = room_.render(world_from_camera);
    Frame frame;
    frame.image = testing::exposed(seen.gray, contrast, 60.0, 2.0, seed);
    frame.depth = seen.depth;
    Random random(seed + 1000);
    for (int y = 0; y < frame.depth.height(); ++y)
      for (int x = 0; x < frame.depth.width(); ++x) {
        float& z = frame.depth.at(x, y);
        z += static_cast<float>((0.0005 + 0.0007 * z * z) * random.normal());
      }
    return frame;
  }

  SensorChoice sensor;
  double contrast = 0.7;

 private:
  AlignmentRoom room_;
};

SE3 random_motion(Random& random, double meters, double radians) {
  Vector6d motion;
  for (int k = 0; k < 6; ++k) motion[k] = (k < 3 ? meters : radians) * random.uniform(-1.0, 1.0);
  return SE3::exp(motion);
}

/// Squared errors of the position, and of all in units of the covariance per direction.
struct Errors {
  double position = 0.0, nees = 0.0;
  int count = 0;

  void add(const RelativePose& estimate, const SE3& truth) {
    const Vector6d off = (truth * estimate.camera_from_keyframe.inverse()).log();
    position += off.head<3>().squaredNorm();
    nees += off.dot(estimate.covariance.inverse() * off) / 6.0;
    ++count;
  }
};

TEST(ViewAlignment, ImagesAndSurfacesTogetherAreBetterThanImagesAndKnowHowGood) {
  AlignedRoom room;
  room.contrast = 0.25;
  FusionOptions options = options_of_room();
  options.common_sigma_m = options.common_sigma_rad = 0.0;
  const ViewAlignment joint(options, room.sensor);
  options.surface_weight = 0.0;
  const ViewAlignment images(options, room.sensor);
  Random random(7);
  Errors of_both, of_images;
  for (std::uint64_t pair = 0; pair < 12; ++pair) {
    const SE3 world_from_keyframe = random_motion(random, 0.2, 0.05), step = random_motion(random, 0.08, 0.04);
    const Frame first = room.frame(world_from_keyframe, pair),
                second = room.frame(world_from_keyframe * step.inverse(), 100 + pair);
    const SE3 guess = random_motion(random, 0.005, 0.003) * step;
    for (const ViewAlignment* alignment : {&joint, &images}) {
      const auto keyframe = alignment->keyframe_of(*alignment->view_of(first, {}));
      ASSERT_TRUE(keyframe);
      const auto found = alignment->align(*keyframe, *alignment->view_of(second, {}), guess);
      ASSERT_TRUE(found) << pair;
      (alignment == &joint ? of_both : of_images).add(*found, step);
    }
  }
  EXPECT_LT(of_both.position, 0.8 * of_images.position);
  EXPECT_LT(std::sqrt(of_both.position / of_both.count), 0.002);
  EXPECT_GT(of_both.nees / of_both.count, 0.1);
  EXPECT_LT(of_both.nees / of_both.count, 2.0);
}

/// Depth that is not that of the image: the pose stays that of the images, and is said to be less certain.
TEST(ViewAlignment, SurfacesThatContradictTheImagesDoNotCount) {
  AlignedRoom room;
  const ViewAlignment alignment(options_of_room(), room.sensor);
  const SE3 step = SE3::exp((Vector6d() << 0.03, 0.01, -0.02, 0.01, -0.02, 0.01).finished());
  const auto keyframe = alignment.keyframe_of(*alignment.view_of(room.frame({}, 1), {}));
  Frame second = room.frame(step.inverse(), 2);
  const auto right = alignment.align(*keyframe, *alignment.view_of(second, {}), step);
  for (int y = 0; y < second.depth.height(); ++y)
    for (int x = 0; x < second.depth.width(); ++x) second.depth.at(x, y) += 0.04F;
  const auto wrong = alignment.align(*keyframe, *alignment.view_of(second, {}), step);
  ASSERT_TRUE(right && wrong);
  EXPECT_LT((wrong->camera_from_keyframe * step.inverse()).translation().norm(), 0.005);
  EXPECT_GT(wrong->covariance.trace(), 4.0 * right->covariance.trace());
}

/// As in a blurred or overexposed image.
TEST(ViewAlignment, SurfacesAlignWhereImagesDoNot) {
  AlignedRoom room;
  const ViewAlignment alignment(options_of_room(), room.sensor);
  const SE3 step = SE3::exp((Vector6d() << 0.03, 0.01, -0.02, 0.01, -0.02, 0.01).finished());
  const auto keyframe = alignment.keyframe_of(*alignment.view_of(room.frame({}, 1), {}));
  Frame second = room.frame(step.inverse(), 2);
  second.image = GrayImage(second.image.width(), second.image.height());
  const SE3 guess = SE3(SO3(), {0.004, 0.004, 0.008}) * step;
  const auto found = alignment.align(*keyframe, *alignment.view_of(second, {}), guess);
  ASSERT_TRUE(found);
  const Vector6d off = (found->camera_from_keyframe * step.inverse()).log();
  EXPECT_LT(std::abs(off.z()), 0.003) << "walls tell the distance";
  EXPECT_LT(off.norm(), 0.02);
  second.depth = {};
  EXPECT_FALSE(alignment.align(*keyframe, *alignment.view_of(second, {}), guess));
}

TEST(ViewAlignment, WithoutTextureOrDepthThereIsNoKeyframe) {
  AlignedRoom room;
  const ViewAlignment alignment({}, room.sensor);
  Frame blank = room.frame({}, 1);
  blank.image = GrayImage(blank.image.width(), blank.image.height());
  EXPECT_EQ(alignment.keyframe_of(*alignment.view_of(blank, {})), nullptr);
  Frame flat = room.frame({}, 1);
  flat.depth = {};
  EXPECT_EQ(alignment.keyframe_of(*alignment.view_of(flat, {})), nullptr);
  flat.image = GrayImage(64, 48);
  EXPECT_EQ(alignment.view_of(flat, {}), nullptr) << "another size";
}

TEST(ViewAlignment, ADifferentViewIsNotAligned) {
  AlignedRoom room;
  const ViewAlignment alignment({}, room.sensor);
  const auto keyframe = alignment.keyframe_of(*alignment.view_of(room.frame({}, 1), {}));
  const Frame elsewhere = room.frame(SE3(SO3::exp({0.0, 0.9, 0.0}), {0.5, 0.0, 0.0}), 2);
  EXPECT_FALSE(alignment.align(*keyframe, *alignment.view_of(elsewhere, {}), SE3()));
}

}  // namespace
}  // namespace rastro
