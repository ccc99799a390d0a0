// SPDX-License-Identifier: Apache-2.0
// Map files of versions 1 and 2, written by the program as it was then from the generated worlds `study` and `loop`.
#include <gtest/gtest.h>

#include <cstdlib>

#include "rastro/base/scratch_testing.h"
#include "rastro/base/text_file.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {
namespace {

std::filesystem::path golden(const char* name) {
  const char* source = std::getenv("RASTRO_SOURCE_DIR");
  return std::filesystem::path(source ? source : ".") / "tests/golden" / name;
}

TEST(OldMapFile, OfADepthCameraIsReadWhole) {
  const MapFileReport report = check_map_file(golden("map_version_1.rastro"));
  ASSERT_TRUE(report.map) << report.damage;
  EXPECT_EQ(report.version, 1U);
  EXPECT_TRUE(report.finished);
  const Map& map = *report.map;
  EXPECT_EQ(map.method, "rgbd");
  ASSERT_EQ(map.cameras.size(), 1U);
  EXPECT_EQ(map.cameras[0].kind, CameraKind::depth);
  EXPECT_EQ(map.cameras[0].intrinsics.fx, 525.0);
  EXPECT_TRUE(scale_of(map).metric);
  ASSERT_EQ(map.keyframes.size(), 2U);
  ASSERT_EQ(map.constraints.size(), 2U);
  EXPECT_EQ(map.constraints[0].kind, ConstraintKind::odometry);
  EXPECT_EQ(map.constraints[1].kind, ConstraintKind::proximity);
  EXPECT_EQ(map.layer<FeatureLayer>()->find(1)->features.size(), 40U);
  const UnpackedImages images = unpack_images(images_of(map)->read(1), "keyframe 1");
  EXPECT_EQ(images.depth.width(), 640);
  const Trajectory trajectory = trajectory_of(map);
  ASSERT_EQ(trajectory.size(), 8U);
  EXPECT_EQ(trajectory.back().stamp, 1'606'800'000'233'333'333);
  // From the trajectory.txt of the run that made it.
  EXPECT_LT((trajectory.back().world_from_body.translation() - Eigen::Vector3d(-0.001193219, 0.008460057, -0.000379092))
                .norm(),
            1e-9);
}

TEST(OldMapFile, OfLandmarksIsReadWhole) {
  const MapFileReport report = check_map_file(golden("map_version_2.rastro"));
  ASSERT_TRUE(report.map) << report.damage;
  EXPECT_EQ(report.version, 2U);
  const Map& map = *report.map;
  EXPECT_EQ(map.method, "orb");
  EXPECT_EQ(map.cameras[0].kind, CameraKind::mono);
  EXPECT_FALSE(scale_of(map).metric);
  EXPECT_EQ(map.keyframes.size(), 11U);
  EXPECT_EQ(map.layer<LandmarkLayer>()->landmarks.size(), 231U);
  EXPECT_EQ(map.layer<FeatureLayer>()->extraction.features, 250);
  EXPECT_EQ(trajectory_of(map).size(), 45U);
  int roots = 0;
  for (const Keyframe& keyframe : map.keyframes) roots += keyframe.parent == no_keyframe ? 1 : 0;
  EXPECT_EQ(roots, 1);
}

TEST(OldMapFile, IsWrittenInTheCurrentVersionAndStaysTheSame) {
  for (const char* name : {"map_version_1.rastro", "map_version_2.rastro"}) {
    const auto once = scratch_path("once.rastro"), twice = scratch_path("twice.rastro");
    save_map(*load_map(golden(name)), once);
    EXPECT_EQ(check_map_file(once).version, 4U);
    save_map(*load_map(once), twice);
    EXPECT_EQ(read_text_file(once.string()), read_text_file(twice.string())) << name;
  }
}

TEST(OldMapFile, IsRecoveredRowByRow) {
  for (const char* name : {"map_version_1.rastro", "map_version_2.rastro"}) {
    const auto map = load_map(golden(name));
    const RecoveredMap recovered = recover_map(golden(name));
    EXPECT_TRUE(recovered.finished);
    EXPECT_TRUE(recovered.lost.empty()) << recovered.lost.front();
    EXPECT_EQ(recovered.map->keyframes.size(), map->keyframes.size());
    EXPECT_EQ(recovered.map->frames.size(), map->frames.size());
    EXPECT_EQ(recovered.map->constraints.size(), map->constraints.size());
    EXPECT_EQ(recovered.map->layers.all().size(), map->layers.all().size());
  }
}

}  // namespace
}  // namespace rastro
