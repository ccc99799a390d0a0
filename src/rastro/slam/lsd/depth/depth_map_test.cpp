// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/synthetic/worlds/hall.h"

namespace rastro {
namespace {

/// In the unit that gives them the mean inverse depth 1. Returns what a meter is in it.
double normalize(DepthImage& depth) {
  double sum = 0.0, count = 0.0;
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x)
      if (depth.at(x, y) > 0.0F) sum += 1.0 / static_cast<double>(depth.at(x, y)), count += 1.0;
  const double meter = sum / count;
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) depth.at(x, y) *= static_cast<float>(meter);
  return meter;
}

/// A keyframe of a world, and what stereo with the frames after it makes of its depths with true poses.
struct Observed {
  Observed(const World& world, int first, int last, TaskPool* pool)
      : map(world.render(first, own).gray.view(), world.camera(), {}) {
    const SE3 keyframe_from_world = world.world_from_camera(first).inverse();
    truth = world.render(first, own).depth;
    const double meter = normalize(truth);
    for (int k = first + 1; k <= last; ++k) {
      const SE3 in_meters = (keyframe_from_world * world.world_from_camera(k)).inverse();
      const SE3 image_from_keyframe(in_meters.rotation(), meter * in_meters.translation());
      update += map.observe(world.render(k, own).gray.view(), image_from_keyframe, 1.0, 0.0, pool);
      map.regularize(pool);
    }
  }

  TaskPool own{1};
  DepthMap map;
  DepthImage truth;
  DepthUpdate update;
};

struct DepthErrors {
  int known = 0;
  double within_5_percent = 0.0, median = 0.0, within_2_sigma = 0.0;
};

DepthErrors errors_of(const InverseDepthMap& map, const DepthImage& truth) {
  std::vector<double> errors;
  double inside = 0.0, near = 0.0;
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      if (!map.is_known(x, y) || !(truth.at(x, y) > 0.0F)) continue;
      const double expected = 1.0 / static_cast<double>(truth.at(x, y)), mean = static_cast<double>(map.mean.at(x, y));
      errors.push_back(std::abs(expected / mean - 1.0));
      near += errors.back() < 0.05 ? 1.0 : 0.0;
      inside += std::abs(mean - expected) < 2.0 * std::sqrt(static_cast<double>(map.variance.at(x, y))) ? 1.0 : 0.0;
    }
  DepthErrors result;
  result.known = static_cast<int>(errors.size());
  if (errors.empty()) return result;
  std::sort(errors.begin(), errors.end());
  const auto count = static_cast<double>(errors.size());
  result.median = errors[errors.size() / 2], result.within_5_percent = near / count,
  result.within_2_sigma = inside / count;
  return result;
}

const World& hall() {
  static const World world = make_hall({.seed = 1, .scale = 0.5});
  return world;
}

TEST(DepthMap, DepthsComeFromStereoWithTheFramesAfterTheKeyframe) {
  const Observed observed(hall(), 120, 126, nullptr);
  const DepthErrors errors = errors_of(observed.map.inverse_depth(), observed.truth);
  EXPECT_GT(errors.known, 5000);
  EXPECT_GT(errors.within_5_percent, 0.7);
  EXPECT_LT(errors.median, 0.025);
  EXPECT_GT(errors.within_2_sigma, 0.8);
  EXPECT_GT(observed.update.created, 5000);
  EXPECT_GT(observed.update.updated, observed.update.created);
}

TEST(DepthMap, EqualBytesForAnyNumberOfThreads) {
  TaskPool pool(8);
  const Observed alone(hall(), 120, 125, nullptr), together(hall(), 120, 125, &pool);
  const InverseDepthMap &a = alone.map.inverse_depth(), &b = together.map.inverse_depth();
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) {
      ASSERT_EQ(a.mean.at(x, y), b.mean.at(x, y)) << x << ' ' << y;
      ASSERT_EQ(a.variance.at(x, y), b.variance.at(x, y)) << x << ' ' << y;
    }
}

TEST(DepthMap, ACameraThatStandsStillChangesNothing) {
  TaskPool pool(1);
  const GrayImage image = hall().render(120, pool).gray;
  DepthMap map(image.view(), hall().camera(), {});
  const DepthUpdate update = map.observe(image.view(), SE3(), 1.0, 0.0);
  map.regularize();
  EXPECT_EQ(update.updated + update.created, 0);
  EXPECT_GT(update.by_result[static_cast<std::size_t>(EpipolarResult::short_line)], 10000);
  EXPECT_EQ(errors_of(map.inverse_depth(), hall().render(120, pool).depth).known, 0);
}

/// Exact depths of one keyframe, propagated to a view 10 cm ahead.
TEST(DepthMap, AnotherKeyframeSeesTheSameSurfaces) {
  TaskPool pool(1);
  const RenderedFrame first = hall().render(120, pool), second = hall().render(123, pool);
  InverseDepthMap exact(first.depth.width(), first.depth.height());
  for (int y = 0; y < exact.height(); ++y)
    for (int x = 0; x < exact.width(); ++x) {
      if (!(first.depth.at(x, y) > 0.0F)) continue;
      exact.mean.at(x, y) = 1.0F / first.depth.at(x, y);
      exact.variance.at(x, y) = 1e-6F;
    }
  DepthMap map(first.gray.view(), hall().camera(), {});
  map.start_from(exact);
  map.regularize();
  const SE3 second_from_first = hall().world_from_camera(123).inverse() * hall().world_from_camera(120);
  DepthMap propagated = map.propagate(second.gray.view(), second_from_first, 1.0, 0.0);
  propagated.regularize();
  const DepthErrors errors = errors_of(propagated.inverse_depth(), second.depth);
  EXPECT_GT(errors.known, errors_of(map.inverse_depth(), first.depth).known * 6 / 10);
  EXPECT_LT(errors.median, 0.005);
  EXPECT_GT(errors.within_5_percent, 0.93);
  propagated.rescale(2.0);
  EXPECT_NEAR(errors_of(propagated.inverse_depth(), second.depth).median, 0.5, 0.01) << "another unit";
}

/// Something dark has come into a part of the view, with the same texture.
TEST(DepthMap, AnotherKeyframeGetsNoDepthsOfWhatItDoesNotShow) {
  constexpr int width = 160, height = 120;
  Camera camera;
  camera.width = width, camera.height = height, camera.fx = camera.fy = 140.0, camera.cx = 79.5, camera.cy = 59.5;
  const auto is_hidden = [](int x, int y, int inside) {
    return x >= 40 + inside && x < 90 - inside && y >= 30 + inside && y < 80 - inside;
  };
  GrayImage image(width, height), later(width, height), brighter(width, height);
  InverseDepthMap exact(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(128.0 + 40.0 * std::sin(0.25 * x)));
      later.at(x, y) = static_cast<std::uint8_t>(image.at(x, y) - (is_hidden(x, y, 0) ? 80 : 0));
      brighter.at(x, y) = static_cast<std::uint8_t>(image.at(x, y) + 60);
      exact.mean.at(x, y) = 1.0F, exact.variance.at(x, y) = 1e-6F;
    }
  DepthMap map(image.view(), camera, {});
  map.start_from(exact);
  map.regularize();
  const auto known_in = [&](GrayView view, double offset, bool hidden) {
    DepthMap propagated = map.propagate(view, SE3(), 1.0, offset);
    propagated.regularize();
    int known = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (is_hidden(x, y, 6) == hidden && (hidden || !is_hidden(x, y, -6)))
          known += propagated.inverse_depth().is_known(x, y) ? 1 : 0;
    return known;
  };
  ASSERT_GT(known_in(image.view(), 0.0, true), 500);
  EXPECT_EQ(known_in(later.view(), 0.0, true), 0);
  EXPECT_EQ(known_in(later.view(), 0.0, false), known_in(image.view(), 0.0, false));
  EXPECT_EQ(known_in(brighter.view(), 60.0, false), known_in(image.view(), 0.0, false)) << "an exposure";
}

/// Neither of the keyframe nor of the images after it.
TEST(DepthMap, MaskedPixelsGiveNoDepth) {
  TaskPool pool(1);
  const RenderedFrame keyframe = hall().render(120, pool), later = hall().render(126, pool);
  GrayImage mask(keyframe.gray.width(), keyframe.gray.height());
  const int middle = mask.width() / 2;
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) mask.at(x, y) = x < middle ? 255 : 0;
  const SE3 motion = (hall().world_from_camera(120).inverse() * hall().world_from_camera(126)).inverse();
  const auto created = [&](GrayView of_keyframe, GrayView of_image) {
    DepthMap map(keyframe.gray.view(), hall().camera(), {}, of_keyframe);
    const DepthUpdate update = map.observe(later.gray.view(), motion, 1.0, 0.0, nullptr, of_image);
    return update.created;
  };
  const int all = created({}, {}), keyframe_half = created(mask.view(), {}), image_half = created({}, mask.view());
  ASSERT_GT(all, 2000);
  EXPECT_GT(keyframe_half, all / 5);
  EXPECT_LT(keyframe_half, all * 4 / 5);
  EXPECT_GT(image_half, all / 5);
  EXPECT_LT(image_half, all * 4 / 5);
  GrayImage nothing(mask.width(), mask.height());
  EXPECT_EQ(created(nothing.view(), {}), 0);
  EXPECT_EQ(created({}, nothing.view()), 0);
}

/// Measures this depth, whatever is known.
DepthMap::DepthSearch sensor_of(const DepthImage& truth, float variance = 1e-6F) {
  return [&truth, variance](const EpipolarQueries& queries, EpipolarMatches& matches) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(queries.count); ++i) {
      const float depth = truth.at(static_cast<int>(queries.x[i]), static_cast<int>(queries.y[i]));
      matches.result[i] = static_cast<int>(depth > 0.0F ? EpipolarResult::matched : EpipolarResult::outside);
      matches.mean[i] = 1.0F / depth, matches.variance[i] = variance;
    }
  };
}

/// A sensor of its own is believed at once.
TEST(DepthMap, WhatASensorMeasuresIsShownAtOnce) {
  TaskPool pool(1);
  const RenderedFrame frame = hall().render(120, pool);
  DepthMap map(frame.gray.view(), hall().camera(), {});
  const DepthMap::DepthSearch sensor = sensor_of(frame.depth);
  const DepthUpdate update = map.measure(sensor);
  map.regularize();
  const DepthErrors errors = errors_of(map.inverse_depth(), frame.depth);
  EXPECT_GT(update.created, 5000);
  EXPECT_GT(errors.known, update.created / 2);
  EXPECT_GT(errors.within_5_percent, 0.95);
  EXPECT_EQ(map.measure(sensor).created, 0);
}

TEST(DepthMap, WhatASensorMeasuresReplacesWhatItContradicts) {
  TaskPool pool(1);
  const RenderedFrame frame = hall().render(120, pool);
  InverseDepthMap wrong(frame.depth.width(), frame.depth.height());
  for (int y = 0; y < wrong.height(); ++y)
    for (int x = 0; x < wrong.width(); ++x)
      if (frame.depth.at(x, y) > 0.0F)
        wrong.mean.at(x, y) = 2.0F / frame.depth.at(x, y), wrong.variance.at(x, y) = 1e-6F;
  DepthMap map(frame.gray.view(), hall().camera(), {});
  map.start_from(wrong);
  const DepthUpdate update = map.measure(sensor_of(frame.depth));
  map.regularize();
  const DepthErrors errors = errors_of(map.inverse_depth(), frame.depth);
  EXPECT_GT(update.contradicted, 5000);
  EXPECT_GT(errors.known, update.contradicted / 2);
  EXPECT_GT(errors.within_5_percent, 0.95);
}

/// What nothing confirms is forgotten.
TEST(DepthMap, WrongDepthsAreDropped) {
  TaskPool pool(1);
  const RenderedFrame keyframe = hall().render(120, pool);
  InverseDepthMap wrong(keyframe.depth.width(), keyframe.depth.height());
  for (int y = 0; y < wrong.height(); ++y)
    for (int x = 0; x < wrong.width(); ++x)
      if (keyframe.depth.at(x, y) > 0.0F)
        wrong.mean.at(x, y) = 2.0F / keyframe.depth.at(x, y), wrong.variance.at(x, y) = 1e-6F;
  DepthMap map(keyframe.gray.view(), hall().camera(), {});
  map.start_from(wrong);
  map.regularize();
  const int before = errors_of(map.inverse_depth(), keyframe.depth).known;
  const SE3 keyframe_from_world = hall().world_from_camera(120).inverse();
  for (int k = 124; k <= 144; ++k)
    map.observe(hall().render(k, pool).gray.view(), (keyframe_from_world * hall().world_from_camera(k)).inverse(), 1.0,
                0.0);
  map.regularize();
  const DepthErrors after = errors_of(map.inverse_depth(), keyframe.depth);
  EXPECT_GT((1.0 - after.within_5_percent) * after.known, 0.0);
  EXPECT_LT((1.0 - after.within_5_percent) * after.known, 0.5 * before);
}

}  // namespace
}  // namespace rastro
