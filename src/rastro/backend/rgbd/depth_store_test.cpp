// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/depth_store.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "rastro/backend/rgbd/keyframe_matcher.h"
#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/base/error.h"

namespace rastro {
namespace {

using testing::CountingImages;

constexpr int held_at_most = 64;

/// A wall seen by a small camera; its distance encodes the keyframe.
Frame wall_of(std::int64_t id) {
  Frame frame;
  frame.image = GrayImage(80, 60);
  frame.depth = DepthImage(80, 60);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) frame.depth.at(x, y) = 1.0F + 0.0101F * static_cast<float>(id);
  }
  return frame;
}

class DepthStoreTest : public ::testing::Test {
 protected:
  static Camera camera() {
    Camera camera = test_room::camera().scaled(0.25);
    camera.width = 80, camera.height = 60;
    return camera;
  }
  void add(std::int64_t id) {
    images_->add(id, wall_of(id));
    store_.add(id, wall_of(id).depth);
  }

  SurfaceCheck check_{camera(), surface_options(RgbdSlamOptions())};
  std::shared_ptr<CountingImages> images_ = std::make_shared<CountingImages>();
  DepthStore store_{check_, images_};
};

TEST_F(DepthStoreTest, WhatWasJustAddedIsNotReadAgain) {
  for (int id = 0; id < held_at_most; ++id) add(id);
  for (int id = 0; id < held_at_most; ++id) {
    EXPECT_EQ(store_.depth(id)->blocks.depth, check_.surface_of(wall_of(id).depth).blocks.depth) << id;
  }
  EXPECT_EQ(images_->asked(), 0);
}

TEST_F(DepthStoreTest, HoldsNoMoreThanItsBoundAndGivesTheSameContentAgain) {
  constexpr int keyframes = held_at_most + 20;
  std::vector<std::weak_ptr<const KeyframeSurface>> given;
  std::vector<std::vector<float>> blocks;
  std::vector<BlockPlane> planes_of_first;
  for (int id = 0; id < keyframes; ++id) {
    add(id);
    const auto surface = store_.depth(id);
    if (id == 0) planes_of_first = surface->planes;
    given.push_back(surface);
    blocks.push_back(surface->blocks.depth);
  }
  int alive = 0;
  for (const auto& surface : given) alive += surface.expired() ? 0 : 1;
  EXPECT_EQ(alive, held_at_most) << "of those that nobody else holds";
  EXPECT_EQ(images_->asked(), 0);
  for (int id = 0; id < 20; ++id) EXPECT_EQ(store_.depth(id)->blocks.depth, blocks[static_cast<std::size_t>(id)]);
  EXPECT_EQ(images_->asked(), 20) << "each was made again from its images";
  const auto first = store_.depth(0);
  ASSERT_EQ(first->planes.size(), planes_of_first.size());
  for (std::size_t k = 0; k < first->planes.size(); ++k) {
    EXPECT_EQ(first->planes[k].normal, planes_of_first[k].normal);
    EXPECT_EQ(first->planes[k].distance, planes_of_first[k].distance);
  }
}

TEST_F(DepthStoreTest, TheLeastRecentlyUsedIsDroppedFirst) {
  for (int id = 0; id < held_at_most; ++id) add(id);
  store_.depth(0);
  add(held_at_most);
  store_.depth(0);
  EXPECT_EQ(images_->asked(), 0) << "asked for last, so it stays";
  store_.depth(1);
  EXPECT_EQ(images_->asked(), 1) << "the oldest was given up for the new one";
  store_.depth(1);
  EXPECT_EQ(images_->asked(), 1) << "and is held again";
  store_.depth(2);
  EXPECT_EQ(images_->asked(), 2) << "the next oldest had to go for it";
}

TEST_F(DepthStoreTest, ASurfaceInUseOutlivesItsCacheEntry) {
  add(0);
  const auto surface = store_.depth(0);
  const std::vector<float> before = surface->blocks.depth;
  for (int id = 1; id < 2 * held_at_most; ++id) add(id);
  EXPECT_EQ(surface->blocks.depth, before);
  EXPECT_EQ(surface.use_count(), 1) << "the store gave it up";
}

TEST_F(DepthStoreTest, AMissingKeyframeIsAnError) { EXPECT_THROW(store_.depth(5), Error); }

TEST_F(DepthStoreTest, SeveralThreadsGetTheSame) {
  constexpr int keyframes = 100;
  for (int id = 0; id < keyframes; ++id) images_->add(id, wall_of(id));
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < wrong.size(); ++t) {
    threads.emplace_back([&, t] {
      for (int k = 0; k < 2 * keyframes; ++k) {
        const int id = static_cast<int>((17 * static_cast<std::size_t>(k) + 31 * t) % keyframes);
        const float expected = 1.0F + 0.0101F * static_cast<float>(id);
        const auto surface = store_.depth(id);
        if (std::abs(surface->blocks.depth[150] - expected) > 1e-3F) ++wrong[t];
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

}  // namespace
}  // namespace rastro
