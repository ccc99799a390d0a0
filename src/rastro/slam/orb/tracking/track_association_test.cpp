// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/track_association.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

constexpr int image_width = 320, image_height = 240;
/// Landmark ids descend along the image.
constexpr std::int64_t first_landmark = 1000000;

Camera image_camera() {
  Camera camera;
  camera.width = image_width;
  camera.height = image_height;
  camera.fx = 250.0;
  camera.fy = 260.0;
  camera.cx = 159.5;
  camera.cy = 119.5;
  return camera;
}

/// Blurred noise with many corners; the content at (x, y) is at (x + dx, y + dy) when shifted.
Frame shifted_image(std::int64_t index, int dx, int dy) {
  static const GrayImage noise = testing::noise_image(image_width + 80, image_height + 80, 7);
  Frame frame;
  frame.index = index;
  frame.stamp = 100000000 * (index + 1);
  frame.image = GrayImage(image_width, image_height);
  for (int y = 0; y < image_height; ++y) {
    for (int x = 0; x < image_width; ++x) {
      int sum = 0;
      for (int v = -3; v <= 3; ++v) {
        for (int u = -3; u <= 3; ++u) sum += noise.at(x - dx + u + 40, y - dy + v + 40);
      }
      frame.image.at(x, y) = static_cast<std::uint8_t>(std::clamp((sum / 49 - 128) * 4 + 128, 0, 255));
    }
  }
  return frame;
}

Frame blank_image(std::int64_t index) {
  Frame frame = shifted_image(index, 0, 0);
  frame.image = GrayImage(image_width, image_height);
  return frame;
}

/// A feature on every pixel of the image, row by row.
const FeatureFrame& feature_everywhere() {
  static const FeatureFrame frame = [] {
    auto data = std::make_shared<ImageFeatures>();
    for (int y = 0; y < image_height; ++y) {
      for (int x = 0; x < image_width; ++x)
        data->features.keypoints.push_back({static_cast<float>(x), static_cast<float>(y), 31, 0, 1});
    }
    data->features.levels.assign(data->features.keypoints.size(), 0);
    data->features.descriptors.resize(data->features.keypoints.size());
    return FeatureFrame(std::move(data), image_camera(), 0.0);
  }();
  return frame;
}

Eigen::Vector2d pixel_of_landmark(std::int64_t landmark) {
  const std::int64_t feature = first_landmark - landmark;
  return {static_cast<double>(feature % image_width), static_cast<double>(feature / image_width)};
}

/// A landmark of its own on each pixel with from <= x < to.
std::vector<TrackedPoint> landmark_everywhere(int from, int to) {
  std::vector<TrackedPoint> points;
  for (std::uint32_t feature = 0; feature < feature_everywhere().size(); ++feature) {
    const int x = static_cast<int>(feature % image_width);
    if (x < from || x >= to) continue;
    TrackedPoint point;
    point.feature = feature;
    point.landmark = first_landmark - static_cast<std::int64_t>(feature);
    points.push_back(point);
  }
  return points;
}

/// Each is where the image's shift moves it, within half a pixel, since features are on whole ones, plus the tracking
/// error.
void expect_shifted(const std::vector<LandmarkTrack>& followed, double dx, double dy) {
  const Camera camera = image_camera();
  for (const LandmarkTrack& one : followed) {
    const Eigen::Vector2d was = pixel_of_landmark(one.landmark);
    EXPECT_NEAR(camera.fx * one.ray.x() + camera.cx, was.x() + dx, 0.65) << one.landmark;
    EXPECT_NEAR(camera.fy * one.ray.y() + camera.cy, was.y() + dy, 0.65) << one.landmark;
  }
}

/// Ready to track: it has processed the image, and has landmarks on the pixels with from <= x < to.
TrackAssociation association(int from, int to, const OrbSlamOptions& options = {}) {
  TrackAssociation tracks(options, image_camera(), nullptr);
  EXPECT_TRUE(tracks.follow(shifted_image(0, 0, 0)).empty()) << "nothing was learned yet";
  tracks.learn(feature_everywhere(), landmark_everywhere(from, to));
  return tracks;
}

TEST(TrackAssociation, LandmarksAreTrackedToTheShiftOfTheImage) {
  TrackAssociation tracks = association(0, image_width);
  std::size_t before = 150;
  for (const auto& [dx, dy] : {std::pair{3, -2}, std::pair{7, 1}, std::pair{1, 4}}) {
    const auto followed = tracks.follow(shifted_image(1, dx, dy));
    EXPECT_GT(followed.size(), before * 3 / 4);
    before = followed.size();
    expect_shifted(followed, dx, dy);
    EXPECT_TRUE(std::is_sorted(followed.begin(), followed.end(),
                               [](const auto& a, const auto& b) { return a.landmark < b.landmark; }));
  }
}

TEST(TrackAssociation, TracksWithoutALandmarkGiveNothing) {
  TrackAssociation tracks = association(0, image_width / 2);
  for (int k = 1; k < 4; ++k) {
    const auto followed = tracks.follow(shifted_image(k, 4 * k, 0));
    EXPECT_GT(followed.size(), 60U);
    // Tracks of the other half observe none, except those next to a landmark.
    for (const LandmarkTrack& one : followed) {
      const double x = image_camera().fx * one.ray.x() + image_camera().cx;
      EXPECT_LT(x - 4 * k, image_width / 2 + OrbSlamOptions{}.tracks_near_px);
    }
  }
}

TEST(TrackAssociation, PointsThatAreNoLandmarksYetAreNotLearned) {
  TrackAssociation tracks(OrbSlamOptions{}, image_camera(), nullptr);
  tracks.follow(shifted_image(0, 0, 0));
  std::vector<TrackedPoint> points = landmark_everywhere(0, image_width);
  for (TrackedPoint& point : points) point.landmark = -1;
  tracks.learn(feature_everywhere(), points);
  EXPECT_TRUE(tracks.follow(shifted_image(1, 1, 1)).empty());
}

TEST(TrackAssociation, ALostViewGivesNothingAndItsReturnTheSameLandmarks) {
  TrackAssociation tracks = association(0, image_width);
  const std::size_t before = tracks.follow(shifted_image(1, 1, 0)).size();
  EXPECT_TRUE(tracks.follow(blank_image(2)).empty());
  tracks.learn(feature_everywhere(), landmark_everywhere(0, image_width));
  EXPECT_TRUE(tracks.follow(blank_image(3)).empty()) << "there was nothing to learn from";
  const auto followed = tracks.follow(shifted_image(4, 2, 1));
  EXPECT_GT(followed.size(), before / 3);
  expect_shifted(followed, 2.0, 1.0);
}

TEST(TrackAssociation, AnImageOfAnotherSizeGivesNothingAndHarmsNothing) {
  TrackAssociation tracks = association(0, image_width);
  Frame other = shifted_image(1, 0, 0);
  other.image = GrayImage(image_width / 2, image_height / 2);
  EXPECT_TRUE(tracks.follow(other).empty());
  const auto followed = tracks.follow(shifted_image(2, 2, 2));
  EXPECT_GT(followed.size(), 100U);
  expect_shifted(followed, 2.0, 2.0);
}

TEST(TrackAssociation, NothingIsTrackedIntoTheMask) {
  TrackAssociation tracks = association(0, image_width);
  Frame frame = shifted_image(1, 3, 0);
  frame.mask = GrayImage(image_width, image_height);
  for (int y = 0; y < image_height; ++y) std::fill_n(frame.mask.row(y), image_width / 2, std::uint8_t{255});
  const auto followed = tracks.follow(frame);
  EXPECT_GT(followed.size(), 60U);
  for (const LandmarkTrack& one : followed) EXPECT_LT(pixel_of_landmark(one.landmark).x() + 3, image_width / 2);
}

TEST(TrackAssociation, ATrackGetsTheLandmarkItObservedLast) {
  TrackAssociation tracks = association(0, image_width);
  std::set<std::int64_t> before;
  for (const LandmarkTrack& one : tracks.follow(shifted_image(1, 0, 0))) before.insert(one.landmark);
  std::vector<TrackedPoint> renamed = landmark_everywhere(0, image_width);
  for (TrackedPoint& point : renamed) point.landmark += first_landmark;
  tracks.learn(feature_everywhere(), renamed);
  const auto followed = tracks.follow(shifted_image(2, 0, 0));
  ASSERT_GT(followed.size(), 100U);
  std::size_t same = 0;
  for (const LandmarkTrack& one : followed) {
    EXPECT_GT(one.landmark, first_landmark);
    same += before.count(one.landmark - first_landmark);
  }
  EXPECT_GT(same, followed.size() / 2);
}

TEST(TrackAssociation, OldTracksAreForgotten) {
  OrbSlamOptions options;
  options.tracks_kept = 20;
  TrackAssociation tracks = association(0, image_width, options);
  const auto followed = tracks.follow(shifted_image(1, 1, 0));
  EXPECT_GT(followed.size(), 10U);
  EXPECT_LE(followed.size(), 21U);
}

}  // namespace
}  // namespace rastro
