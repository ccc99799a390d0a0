// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/cloud/voxel_table.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "rastro/base/random.h"

namespace rastro::detail {
namespace {

WorldSample sample_at(const Eigen::Vector3d& point, float sigma = 0.01F) {
  WorldSample sample;
  sample.point = point;
  sample.normal = {0.0F, 0.6F, 0.8F};
  sample.ray = {0.1F, 0.2F, 1.0F};
  sample.sigma = sigma;
  sample.color = {10, 20, 30};
  return sample;
}

Eigen::Vector3d random_position(Random& random, double reach) {
  const double x = random.uniform(-reach, reach), y = random.uniform(-reach, reach), z = random.uniform(-reach, reach);
  return {x, y, z};
}

std::array<long, 3> cube_of(const Eigen::Vector3d& position, double side) {
  return {std::lround(std::floor(position.x() / side)), std::lround(std::floor(position.y() / side)),
          std::lround(std::floor(position.z() / side))};
}

TEST(VoxelTableKeys, AreOnePerCubeAndGiveItsCorner) {
  Random random(1);
  const VoxelTable table(0.05);
  std::map<std::array<long, 3>, std::uint64_t> keys;
  std::set<std::uint64_t> distinct;
  for (int k = 0; k < 20000; ++k) {
    const Eigen::Vector3d position = random_position(random, 0.8);
    const std::uint64_t key = table.key_of(position);
    ASSERT_NE(key, 0U);
    const auto [found, is_new] = keys.emplace(cube_of(position, 0.05), key);
    EXPECT_EQ(found->second, key);
    distinct.insert(key);
    const Eigen::Vector3d inside = position - table.corner_of(key);
    EXPECT_GE(inside.minCoeff(), -1e-9);
    EXPECT_LE(inside.maxCoeff(), 0.05 + 1e-9);
  }
  EXPECT_EQ(distinct.size(), keys.size());
}

TEST(VoxelTableKeys, AreZeroForPositionsOutOfRange) {
  const VoxelTable table(0.01);
  const double nan = std::nan(""), far = 0.01 * (1 << 20);
  for (const Eigen::Vector3d& position : {Eigen::Vector3d(far, 0.0, 0.0), Eigen::Vector3d(0.0, -far, 0.0),
                                          Eigen::Vector3d(0.0, nan, 0.0), Eigen::Vector3d(0.0, 0.0, INFINITY)})
    EXPECT_EQ(table.key_of(position), 0U);
  const Eigen::Vector3d last(0.99 * far, -0.99 * far, 0.99 * far);
  ASSERT_NE(table.key_of(last), 0U);
  EXPECT_LT((table.corner_of(table.key_of(last)) - last).norm(), 0.02);
}

/// Thousands of samples, with many growths of the table, against a map of the standard library.
TEST(VoxelTableSums, AreThoseOfAPlainMap) {
  Random random(2);
  struct Plain {
    double weight = 0.0, along = 0.0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    std::uint32_t count = 0;
    std::set<int> views;
  };
  VoxelTable table(0.1);
  std::map<std::array<long, 3>, Plain> plain;
  for (int view = 0; view < 6; ++view) {
    for (int k = 0; k < 4000; ++k) {
      const WorldSample sample =
          sample_at(random_position(random, 1.5), static_cast<float>(random.uniform(0.005, 0.02)));
      const std::uint64_t key = table.key_of(sample.point);
      table.add(key, sample, view);
      Plain& sums = plain[cube_of(sample.point, 0.1)];
      const double w = 1.0 / (static_cast<double>(sample.sigma) * static_cast<double>(sample.sigma));
      const Eigen::Vector3d inside = sample.point - table.corner_of(key);
      sums.weight += w;
      sums.along += w * (0.6 * inside.y() + 0.8 * inside.z());
      sums.position += w * inside;
      ++sums.count;
      sums.views.insert(view);
    }
  }
  EXPECT_EQ(table.size(), plain.size());
  for (const auto& [cube, sums] : plain) {
    const Eigen::Vector3d middle = 0.1 * (Eigen::Vector3d(static_cast<double>(cube[0]), static_cast<double>(cube[1]),
                                                          static_cast<double>(cube[2])) +
                                          Eigen::Vector3d::Constant(0.5));
    const Voxel* voxel = table.find(table.key_of(middle));
    ASSERT_NE(voxel, nullptr);
    EXPECT_EQ(voxel->count, sums.count);
    EXPECT_EQ(voxel->views, sums.views.size());
    EXPECT_NEAR(static_cast<double>(voxel->weight) / sums.weight, 1.0, 1e-4);
    EXPECT_LT((voxel->position.cast<double>() - sums.position).norm() / sums.weight, 1e-5);
    EXPECT_NEAR(static_cast<double>(voxel->along) / sums.weight, sums.along / sums.weight, 1e-5);
  }
  EXPECT_EQ(table.find(table.key_of({5.0, 5.0, 5.0})), nullptr);
}

/// Coarsening gives the same as adding to voxels of twice the side.
TEST(VoxelTableCoarsen, EqualsACoarseTableFromTheStart) {
  Random random(3);
  VoxelTable fine(0.05), coarse(0.1);
  for (int k = 0; k < 5000; ++k) {
    const WorldSample sample = sample_at(random_position(random, 0.6));
    fine.add(fine.key_of(sample.point), sample, k % 3);
    coarse.add(coarse.key_of(sample.point), sample, k % 3);
  }
  const std::size_t before = fine.size();
  fine.coarsen();
  EXPECT_EQ(fine.side_m(), 0.1);
  EXPECT_LT(fine.size(), before);
  ASSERT_EQ(fine.size(), coarse.size());
  std::size_t compared = 0;
  for (int shard = 0; shard < VoxelTable::shard_count; ++shard) {
    for (const Voxel& expected : coarse.shard(shard)) {
      EXPECT_EQ(VoxelTable::shard_of(expected.key), shard);
      const Voxel* voxel = fine.find(expected.key);
      ASSERT_NE(voxel, nullptr);
      ++compared;
      EXPECT_EQ(voxel->count, expected.count);
      EXPECT_NEAR(voxel->weight / expected.weight, 1.0F, 1e-4F);
      EXPECT_LT((voxel->position - expected.position).norm() / expected.weight, 1e-5F);
      EXPECT_NEAR(voxel->along / expected.weight, expected.along / expected.weight, 1e-5F);
      EXPECT_NEAR(voxel->along2 / expected.weight, expected.along2 / expected.weight, 1e-5F);
      EXPECT_NEAR(voxel->variance / expected.variance, 1.0F, 1e-3F);
      EXPECT_LT((voxel->normal - expected.normal).norm() / expected.weight, 1e-4F);
    }
  }
  EXPECT_EQ(compared, coarse.size());
}

TEST(VoxelTableSums, WithoutANormalTheRayReplacesIt) {
  VoxelTable table(0.1);
  WorldSample sample = sample_at({0.05, 0.05, 0.08});
  sample.normal.setZero();
  sample.ray = {0.0F, 0.0F, 1.0F};
  const std::uint64_t key = table.key_of(sample.point);
  table.add(key, sample, 0);
  const Voxel* voxel = table.find(key);
  ASSERT_NE(voxel, nullptr);
  EXPECT_TRUE(voxel->normal.isZero()) << "no normal is made up";
  EXPECT_NEAR(voxel->along / voxel->weight, -0.08F, 1e-5F) << "towards the camera";
  EXPECT_NEAR(voxel->variance / (voxel->weight * voxel->weight), 1e-4F, 1e-8F) << "all of the depth's noise";
}

}  // namespace
}  // namespace rastro::detail
