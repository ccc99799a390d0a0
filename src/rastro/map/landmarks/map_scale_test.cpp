// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmarks/map_scale.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/map/landmarks/jackknife.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/math/alignment.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

constexpr double height_m = 1.5;

/// A camera that drives along z, one keyframe per unit; landmarks are given relative to the keyframe that observes
/// them.
class Drive {
 public:
  Map map;
  explicit Drive(int keyframes = 10, const SO3& rotation = SO3(), double step = 1.0)
      : layer_(std::make_shared<LandmarkLayer>()) {
    for (int k = 0; k < keyframes; ++k)
      map.keyframes.push_back({k, k, k, 0, SE3(rotation, {0.0, 0.0, step * k}), 0, no_keyframe, 1.0});
  }
  /// `beside`, `below` and `ahead` of the keyframe, in units; world axes where the camera is not rotated.
  void add(double beside, double below, double ahead, KeyframeId keyframe = 4, int copies = 1) {
    for (int i = 0; i < copies; ++i) {
      Landmark& landmark = layer_->landmarks.emplace_back();
      landmark.id = static_cast<std::int64_t>(layer_->landmarks.size());
      landmark.position = map.find(keyframe)->world_from_camera.translation() + Vector3d(beside, below, ahead);
      landmark.observations = {{keyframe, 0}};
    }
  }
  MapScaleFound found() {
    map.layers.put<LandmarkLayer>(layer_);
    return scale_from_camera_height(map, height_m, "here");
  }

 private:
  std::shared_ptr<LandmarkLayer> layer_;
};

/// A point that is 2 units ahead is as many meters ahead as two units are.
TEST(MapScale, SemiDenseDepthIsInMetersToo) {
  Map map;
  map.keyframes.push_back({.id = 2, .world_from_camera = SE3()});
  map.keyframes.push_back({.id = 3, .world_from_camera = SE3(SO3(), {1.0, 0.0, 0.0})});
  auto depths = std::make_shared<SemiDenseLayer>();
  auto depth = std::make_shared<SemiDenseDepth>();
  depth->pixels.push_back({.x = 5, .y = 6, .inverse_depth = 0.5F, .variance = 0.01F, .intensity = 7});
  depths->of[3] = depth;
  map.layers.put<SemiDenseLayer>(std::move(depths));
  MapScaleFound found;
  found.meters_per_unit = 4.0;
  const Map in_meters = scaled(map, found);
  EXPECT_NEAR(in_meters.keyframes[1].world_from_camera.translation().x(), 4.0, 1e-12);
  const SemiDenseDepth::Pixel& pixel = in_meters.layer<SemiDenseLayer>()->of.at(3)->pixels.at(0);
  EXPECT_EQ(pixel.inverse_depth, 0.125F);
  EXPECT_EQ(pixel.variance, 0.01F / 16.0F);
  EXPECT_EQ(map.layer<SemiDenseLayer>()->of.at(3)->pixels[0].inverse_depth, 0.5F) << "the map itself stays";
}

/// What an error costs does not depend on the unit that it is in.
TEST(MapScale, TheInformationOfAConstraintIsInMetersToo) {
  Map map;
  Constraint& known = map.constraints.emplace_back();
  known.from_from_to = Sim3(1.0, SO3(), {1.0, 2.0, 3.0});
  known.information.diagonal() << 9.0, 8.0, 7.0, 6.0, 5.0, 4.0;
  known.information(0, 4) = known.information(4, 0) = 0.5;
  map.constraints.push_back({.from = 1, .to = 2});
  MapScaleFound found;
  found.meters_per_unit = 4.0;
  const Map in_meters = scaled(map, found);
  const Vector6d error = (Vector6d() << 0.1, -0.2, 0.3, 0.04, -0.05, 0.06).finished();
  Vector6d error_in_meters = error;
  error_in_meters.head<3>() *= 4.0;
  EXPECT_NEAR(error_in_meters.dot(in_meters.constraints[0].information * error_in_meters),
              error.dot(map.constraints[0].information * error), 1e-12);
  EXPECT_EQ(in_meters.constraints[0].from_from_to.translation(), Vector3d(4.0, 8.0, 12.0));
  EXPECT_EQ(in_meters.constraints[1].information, Matrix6d::Identity()) << "it was not known";
}

/// Where the first keyframe is may have been given in meters.
TEST(MapScale, TheFirstKeyframeStaysWhereItIs) {
  Map map;
  map.keyframes.push_back({.id = 3, .world_from_camera = SE3(SO3(), {10.0, -20.0, 0.0})});
  map.keyframes.push_back({.id = 4, .world_from_camera = SE3(SO3(), {10.0, -19.0, 0.5})});
  map.frames = {{0, 3, SE3()}, {1, 4, SE3(SO3(), {0.0, 1.0, 0.0})}};
  auto layer = std::make_shared<LandmarkLayer>();
  layer->landmarks.resize(1);
  layer->landmarks[0].position = {12.0, -20.0, 0.0};
  map.layers.put<LandmarkLayer>(std::move(layer));
  MapScaleFound found;
  found.meters_per_unit = 4.0;
  EXPECT_EQ(fixed_point_of(map), Vector3d(10.0, -20.0, 0.0));
  const Map in_meters = scaled(map, found);
  EXPECT_EQ(in_meters.keyframes[0].world_from_camera.translation(), Vector3d(10.0, -20.0, 0.0));
  EXPECT_EQ(in_meters.keyframes[1].world_from_camera.translation(), Vector3d(10.0, -16.0, 2.0));
  EXPECT_EQ(trajectory_of(in_meters)[1].world_from_body.translation(), Vector3d(10.0, -12.0, 2.0));
  EXPECT_EQ(in_meters.layer<LandmarkLayer>()->landmarks[0].position, Vector3d(18.0, -20.0, 0.0));
  EXPECT_EQ(fixed_point_of(Map()), Vector3d(0.0, 0.0, 0.0));
}

/// Along x for 20 frames, in two sessions with one clock: the second goes twice as far.
Map two_drives() {
  Map map;
  for (int session = 0; session < 2; ++session) {
    map.sessions.push_back({0, session, "", 0, 19'000'000, {}});
    map.keyframes.push_back({session, 0, 0, 0, SE3(), 0, no_keyframe, 1.0});
    for (int k = 0; k < 20; ++k)
      map.frames.push_back({k * 1'000'000, session, SE3(SO3(), {k * (1.0 + session), 0.01 * k * k, 0.0})});
  }
  return map;
}

TEST(MapScale, OfAReferenceIsOfTheSessionThatItIsOf) {
  const Map map = two_drives();
  Trajectory reference;
  for (int k = 0; k < 20; ++k) reference.push_back({k * 1'000'000, SE3(SO3(), {3.0 * k, 0.03 * k * k, 0.0})});
  EXPECT_NEAR(scale_from_reference(map, reference, "here", 0).meters_per_unit, 3.0, 1e-9);
  EXPECT_THROW(scale_from_reference(map, reference, "here"), Error) << "it may be of either";
  EXPECT_EQ(trajectory_for_reference(map, 1, "here").back().world_from_body.translation().x(), 38.0);
  Map one = map;
  one.sessions.resize(1), one.keyframes.resize(1), one.frames.resize(20);
  EXPECT_NEAR(scale_from_reference(one, reference, "here").meters_per_unit, 3.0, 1e-9);
}

/// Both recordings have a frame 5.
TEST(MapScale, FramesAreThoseOfTheFirstSession) {
  Map map = two_drives();
  map.keyframes = {{0, 0, 0, 0, SE3(), 0, no_keyframe, 1.0},
                   {1, 19, 19'000'000, 0, SE3(), 0, no_keyframe, 1.0},
                   {2, 0, 0, 0, SE3(), 0, no_keyframe, 1.0},
                   {3, 30, 19'000'000, 0, SE3(), 0, no_keyframe, 1.0}};
  for (MapFrame& frame : map.frames) frame.keyframe_from_camera = SE3(SO3(), {to_seconds(frame.stamp) * 1e3, 0.0, 0.0});
  const KnownLength length{5, 15, true, 20.0};
  EXPECT_NEAR(scale_from_lengths(map, std::array{length}, "here").meters_per_unit, 2.0, 1e-9);
  EXPECT_THROW(scale_from_lengths(map, std::array{KnownLength{5, 25, true, 20.0}}, "here"), Error);
}

TEST(CameraHeight, UsesLandmarksAheadBelowAndNotFarAside) {
  const std::pair<Vector3d, bool> landmarks[] = {
      {{0.0, 1.0, 0.5}, true},   {{0.0, 1.0, 0.499}, false}, {{0.0, 1.0, 12.0}, true}, {{0.0, 1.0, 12.01}, false},
      {{2.0, 1.0, 4.0}, true},   {{2.01, 1.0, 4.0}, false},  {{-2.0, 1.0, 4.0}, true}, {{-2.01, 1.0, 4.0}, false},
      {{0.0, -1.0, 4.0}, false}, {{0.0, 1.0, -4.0}, false},  {{0.0, 0.0, 4.0}, false},
  };
  for (const auto& [position, counts] : landmarks) {
    Drive drive;
    drive.add(0.5, 1.0, 3.0, 4, 60);
    drive.add(position.x(), position.y(), position.z());
    const MapScaleFound found = drive.found();
    EXPECT_EQ(found.measurements, counts ? 61 : 60) << position.transpose();
    EXPECT_NEAR(found.meters_per_unit, height_m, 1e-12);
    EXPECT_EQ(found.from, "a camera height of 1.5 m");
  }
}

TEST(CameraHeight, NeedsFiftyObservations) {
  Drive few, enough;
  few.add(0.5, 1.0, 3.0, 4, 49);
  enough.add(0.5, 1.0, 3.0, 4, 50);
  EXPECT_THROW(few.found(), Error);
  EXPECT_EQ(enough.found().measurements, 50);
  EXPECT_THROW(scale_from_camera_height(Map(), height_m, "here"), Error) << "a map without landmarks";
}

TEST(CameraHeight, NeedsAShareOfTheCandidatesAtOneHeight) {
  for (const int alike : {15, 14}) {
    Drive drive;
    drive.add(0.0, 1.0, 2.0, 4, alike);
    for (int i = 0; i < 100 - alike; ++i) {  // the others at various heights
      const double below = std::exp(1.0 + 0.05 * i);
      drive.add(0.0, below, 2.0 * below);
    }
    if (alike == 15) {
      EXPECT_EQ(drive.found().measurements, 15);
    } else {
      EXPECT_THROW(drive.found(), Error);
    }
  }
}

TEST(CameraHeight, HeightsNearTheModeCountAsMeasurements) {
  for (const double off : {0.119, 0.121}) {  // twice the kernel of 6 %
    Drive drive;
    drive.add(0.0, 1.0, 3.0, 4, 60);
    for (const double sign : {-1.0, 1.0}) drive.add(0.0, std::exp(sign * off), 3.0 * std::exp(sign * off));
    EXPECT_EQ(drive.found().measurements, off < 0.12 ? 62 : 60);
    EXPECT_NEAR(drive.found().meters_per_unit, height_m, 1e-9);
  }
}

TEST(CameraHeight, DistantLandmarksWeighLess) {
  Drive drive;
  drive.add(0.0, 1.0, 1.0, 4, 30);
  drive.add(0.0, 2.0, 20.0, 4, 60);  // twice as many, with a tenth of the weight
  EXPECT_NEAR(drive.found().meters_per_unit, height_m, 1e-9);
}

TEST(CameraHeight, IsTheMeanOfTheHeightsNearTheMode) {
  Drive drive;
  double sum = 0.0;
  for (int i = 0; i < 61; ++i) {
    const double log_height = 0.001 * (i - 30) + 0.0003 * (i % 5);
    sum += log_height;
    drive.add(0.0, std::exp(log_height), 3.0 * std::exp(log_height));
  }
  drive.add(0.0, 8.0, 24.0, 4, 10);  // elsewhere
  EXPECT_NEAR(std::log(height_m / drive.found().meters_per_unit), sum / 61.0, 5e-4);
  EXPECT_EQ(drive.found().measurements, 61);
}

TEST(CameraHeight, TheCameraMayBePitchedOrFaceBackward) {
  Drive pitched(10, SO3::exp({0.3, 0.0, 0.0}));
  pitched.add(0.5, 1.0, 3.0, 4, 60);
  EXPECT_NEAR(pitched.found().meters_per_unit, height_m, 1e-12);
  Drive backward(10, SO3(), -1.0);
  backward.add(0.5, 1.0, 3.0, 4, 60);
  EXPECT_NEAR(backward.found().meters_per_unit, height_m, 1e-12);
}

TEST(CameraHeight, TheCameraMustFaceAboutItsDirectionOfTravel) {
  constexpr double degree = std::numbers::pi / 180.0;
  for (const double yaw_deg : {45.0, 46.0, -45.0, 90.0}) {  // the cosine of 45.6 is 0.7
    Drive drive(10, SO3::exp({0.0, yaw_deg * degree, 0.0}));
    drive.add(3.0 * std::sin(yaw_deg * degree), 1.0, 3.0 * std::cos(yaw_deg * degree), 4, 60);
    if (std::abs(yaw_deg) < 45.5) {
      EXPECT_NEAR(drive.found().meters_per_unit, height_m, 1e-9) << yaw_deg;
    } else {
      EXPECT_THROW(drive.found(), Error) << yaw_deg;
    }
  }
}

TEST(CameraHeight, OnlySubmapZeroCountsInTheOrderOfItsFrames) {
  Drive drive(24);
  for (int k = 0; k < 24; ++k) {  // a circle, driven in an order other than that of the ids
    Keyframe& keyframe = drive.map.keyframes[static_cast<std::size_t>(k)];
    keyframe.frame = k * 7 % 24;
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(keyframe.frame) / 24.0;
    keyframe.world_from_camera =
        SE3(SO3::exp({0.0, angle, 0.0}), {-20.0 * std::cos(angle), 0.0, 20.0 * std::sin(angle)});
    drive.add(2.0 * std::sin(angle), 1.0, 2.0 * std::cos(angle), k, 4);
  }
  EXPECT_EQ(drive.found().measurements, 96);
  drive.map.keyframes[3].submap = 1;
  EXPECT_EQ(drive.found().measurements, 92);
}

/// Each recording numbers its frames from 0: the next frame of one is no neighbor of those of the other.
TEST(CameraHeight, TheDirectionOfTravelIsThatOfTheSession) {
  Drive drive;
  drive.map.sessions.resize(2);
  drive.map.sessions[1].session = 1;
  const SO3 along_x = SO3::exp({0.0, 0.5 * std::numbers::pi, 0.0});
  for (std::int64_t k = 0; k < 10; ++k) {
    Keyframe& keyframe = drive.map.keyframes.emplace_back();
    keyframe.id = keyframe_id({0, 1, k}), keyframe.frame = k;
    keyframe.world_from_camera = SE3(along_x, {static_cast<double>(k), 0.0, 50.0});
  }
  drive.add(0.5, 1.0, 3.0, 4, 60);
  drive.add(3.0, 1.0, -0.5, keyframe_id({0, 1, 4}), 60);
  EXPECT_EQ(drive.found().measurements, 120);
  EXPECT_NEAR(drive.found().meters_per_unit, height_m, 1e-9);
}

/// Sixteen keyframes whose ground is at slightly different heights; those from `begin` to `end` observe nothing.
Drive uneven_drive(KeyframeId begin = 0, KeyframeId end = 0) {
  Drive drive(16);
  for (KeyframeId k = 0; k < 16; ++k) {
    const double height = 1.0 + 0.002 * static_cast<double>(k * k % 11);
    if (k < begin || k >= end) drive.add(0.5, height, 3.0 * height, k, 10);
  }
  return drive;
}

TEST(CameraHeight, ItsSigmaIsThatOfEightBlocksOfKeyframesLeftOut) {
  const auto height_without = [](std::size_t begin, std::size_t end) {
    return std::optional(
        height_m / uneven_drive(static_cast<KeyframeId>(begin), static_cast<KeyframeId>(end)).found().meters_per_unit);
  };
  const MapScaleFound found = uneven_drive().found();
  EXPECT_NEAR(found.relative_sigma, jackknife_sigma(16, height_without) * found.meters_per_unit / height_m, 1e-12);
  EXPECT_GT(found.relative_sigma, 1e-4);
}

TEST(CameraHeight, AStandingCameraHasNoHeight) {
  Drive drive(10, SO3(), 0.0);
  drive.add(0.5, 1.0, 3.0, 4, 60);
  EXPECT_THROW(drive.found(), Error);
}

TEST(Jackknife, LeavesOutEightBlocksOneAfterTheOther) {
  std::vector<double> values;
  for (int i = 0; i < 20; ++i) values.push_back(i * i % 7 + 0.1 * i);
  std::vector<std::pair<std::size_t, std::size_t>> asked;
  const auto mean_without = [&](std::size_t begin, std::size_t end) -> std::optional<double> {
    asked.emplace_back(begin, end);
    double sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += i >= begin && i < end ? 0.0 : values[i];
    return sum / static_cast<double>(values.size() - (end - begin));
  };
  const double sigma = jackknife_sigma(values.size(), mean_without);
  const std::vector<std::pair<std::size_t, std::size_t>> blocks = {{0, 2},   {2, 5},   {5, 7},   {7, 10},
                                                                   {10, 12}, {12, 15}, {15, 17}, {17, 20}};
  EXPECT_EQ(asked, blocks);
  std::vector<double> means;
  for (const auto& [begin, end] : blocks) means.push_back(*mean_without(begin, end));
  const double middle = std::accumulate(means.begin(), means.end(), 0.0) / 8.0;
  double squares = 0.0;
  for (const double mean : means) squares += (mean - middle) * (mean - middle);
  EXPECT_NEAR(sigma, std::sqrt(7.0 / 8.0 * squares), 1e-12);
}

TEST(Jackknife, IsUnknownWithFewerThanTwoEstimates) {
  const auto only_first = [](std::size_t begin, std::size_t) { return begin == 0 ? std::optional(5.0) : std::nullopt; };
  EXPECT_EQ(jackknife_sigma(16, only_first), 0.0);
  const auto first_two = [](std::size_t begin, std::size_t) {
    return begin < 4 ? std::optional(static_cast<double>(begin)) : std::nullopt;
  };
  EXPECT_DOUBLE_EQ(jackknife_sigma(16, first_two), 1.0) << "of 0 and 2: sqrt(1/2 * 2)";
}

/// Keyframes of frames 5, 10 and 30, a second apart at x = 0, 1 and 4; landmarks 1 and 2 of submap 0, 3 of another one,
/// 4 of none.
Map map_of_lengths(TimeNs gap = 1'000'000'000) {
  Map map;
  const double x[] = {0.0, 1.0, 4.0};
  const std::int64_t frame[] = {5, 10, 30};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto id = static_cast<KeyframeId>(k);
    map.keyframes.push_back({id, frame[k], id * gap, 0, SE3(SO3(), {x[k], 0.0, 0.0}), 0, no_keyframe, 1.0});
    map.frames.push_back({id * gap, id, SE3()});
  }
  map.keyframes.push_back({9, 40, 9 * gap, 0, SE3(), 1, no_keyframe, 1.0});
  auto layer = std::make_shared<LandmarkLayer>();
  for (const std::int64_t id : {1, 2, 3, 4}) {
    Landmark& landmark = layer->landmarks.emplace_back();
    landmark.id = id;
    landmark.position = {0.0, 3.0 * static_cast<double>(id), 4.0};
    if (id < 4) landmark.observations = {{id == 3 ? 9 : 1, 0}};
  }
  map.layers.put<LandmarkLayer>(std::move(layer));
  return map;
}

double scale_of_frames(const Map& map, std::int64_t from, std::int64_t to, double meters) {
  return scale_from_lengths(map, std::array{KnownLength{from, to, true, meters}}, "here").meters_per_unit;
}

TEST(KnownLengths, FramesBetweenKeyframesAreInterpolated) {
  const Map map = map_of_lengths();
  EXPECT_NEAR(scale_of_frames(map, 5, 30, 8.0), 2.0, 1e-12);
  EXPECT_NEAR(scale_of_frames(map, 10, 30, 6.0), 2.0, 1e-12);
  EXPECT_NEAR(scale_of_frames(map, 7, 15, 2.7), 2.0, 1e-9) << "from x = 0.4 to x = 1.75";
  for (const std::int64_t outside : {4, 41}) EXPECT_THROW(scale_of_frames(map, 10, outside, 1.0), Error) << outside;
  EXPECT_THROW(scale_of_frames(Map(), 0, 1, 1.0), Error);
  EXPECT_THROW(scale_of_frames(map, 10, 10, 1.0), Error) << "no length";
  EXPECT_THROW(scale_of_frames(map_of_lengths(1'000'000'001), 7, 15, 1.0), Error) << "too long between two poses";
}

TEST(KnownLengths, LandmarksMustBeOfTheFirstSubmap) {
  const Map map = map_of_lengths();
  const auto scale = [&](std::int64_t from, std::int64_t to) {
    return scale_from_lengths(map, std::array{KnownLength{from, to, false, 6.0}}, "here").meters_per_unit;
  };
  EXPECT_NEAR(scale(1, 2), 2.0, 1e-12);
  EXPECT_THROW(scale(1, 3), Error) << "of another submap";
  EXPECT_THROW(scale(4, 1), Error) << "nobody observed it";
  EXPECT_THROW(scale(1, 7), Error) << "not there";
  EXPECT_THROW(scale(1, 1), Error);
}

TEST(KnownLengths, SeveralAreFittedByLeastSquaresWithTheirSigma) {
  const Map map = map_of_lengths();
  const std::array lengths = {KnownLength{5, 10, true, 2.1}, KnownLength{10, 30, true, 5.7},
                              KnownLength{1, 2, false, 6.2}};
  const double units[] = {1.0, 3.0, 3.0}, meters[] = {2.1, 5.7, 6.2};
  double products = 0.0, squares = 0.0, rest = 0.0;
  for (int i = 0; i < 3; ++i) products += units[i] * meters[i], squares += units[i] * units[i];
  for (int i = 0; i < 3; ++i) rest += std::pow(meters[i] - products / squares * units[i], 2);
  const MapScaleFound found = scale_from_lengths(map, lengths, "here");
  EXPECT_NEAR(found.meters_per_unit, products / squares, 1e-12);
  EXPECT_NEAR(found.relative_sigma, std::sqrt(rest / 2.0 / squares) / (products / squares), 1e-12);
  EXPECT_EQ(found.measurements, 3);
  EXPECT_EQ(found.from, "3 known lengths");
}

TEST(KnownLengths, OneBetweenLandmarksHasTheSigmaOfTheirPositions) {
  const Map map = make_landmark_test_map();
  const Landmark &a = map.layer<LandmarkLayer>()->landmarks[5], &b = map.layer<LandmarkLayer>()->landmarks[200];
  const MapScaleFound found = scale_from_lengths(map, std::array{KnownLength{a.id, b.id, false, 3.0}}, "here");
  const Vector3d between = b.position - a.position, along = between.normalized();
  const Eigen::Matrix3d covariance = landmark_covariance(map, a).value() + landmark_covariance(map, b).value();
  EXPECT_NEAR(found.relative_sigma, std::sqrt(along.dot(covariance * along)) / between.norm(), 1e-12);
  EXPECT_EQ(found.measurements, 1);
  EXPECT_EQ(found.from, "a known length");
}

/// A curve of `count` poses, in the map with errors and in a reference of 2.5 m for each unit.
std::pair<Map, Trajectory> map_and_reference(int count) {
  Map map;
  Trajectory reference;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d position(std::cos(0.3 * k), std::sin(0.5 * k), 0.1 * k);
    const Eigen::Vector3d error(0.02 * (k * k % 7), -0.015 * (k % 4), 0.01 * (k * k % 5));
    map.keyframes.push_back({k, k, k * ns_per_second, 0, SE3(SO3(), position + error), 0, no_keyframe, 1.0});
    map.frames.push_back({k * ns_per_second, k, SE3()});
    reference.push_back({k * ns_per_second, SE3(SO3(), 2.5 * position)});
  }
  return {map, reference};
}

TEST(ScaleFromReference, NeedsTenPosesWithinIt) {
  for (const int count : {9, 10}) {
    const auto [map, reference] = map_and_reference(count);
    if (count < 10) {
      EXPECT_THROW(scale_from_reference(map, reference, "here"), Error);
    } else {
      EXPECT_NEAR(scale_from_reference(map, reference, "here").meters_per_unit, 2.5, 0.15);
    }
  }
}

TEST(ScaleFromReference, ItsSigmaIsThatOfEightBlocksLeftOut) {
  const auto [map, reference] = map_and_reference(24);
  const auto scale_without = [&, &map = map, &reference = reference](std::size_t begin,
                                                                     std::size_t end) -> std::optional<double> {
    std::vector<Eigen::Vector3d> to, from;
    for (std::size_t k = 0; k < 24; ++k) {
      if (k >= begin && k < end) continue;
      to.push_back(reference[k].world_from_body.translation());
      from.push_back(map.keyframes[k].world_from_camera.translation());
    }
    return align_points(to, from, AlignmentKind::similarity)->target_from_source.scale();
  };
  const MapScaleFound found = scale_from_reference(map, reference, "here");
  EXPECT_NEAR(found.meters_per_unit, *scale_without(0, 0), 1e-12);
  EXPECT_NEAR(found.relative_sigma, jackknife_sigma(24, scale_without) / *scale_without(0, 0), 1e-12);
  EXPECT_EQ(found.measurements, 24);
}

TEST(ScaleFromReference, AReferenceOfAnotherWalkFitsBadly) {
  auto [map, reference] = map_and_reference(24);
  const MapScaleFound right = scale_from_reference(map, reference, "here");
  EXPECT_LT(right.position_misfit, 0.2);
  EXPECT_LT(right.turn_misfit_deg, 1e-6);
  for (std::size_t k = 0; k < reference.size(); ++k) {
    const double angle = 0.02 * static_cast<double>(k);
    reference[k].world_from_body = SE3(SO3::exp({0.0, angle, 0.0}), {std::sin(3.0 * angle), 0.0, angle});
  }
  const MapScaleFound wrong = scale_from_reference(map, reference, "here");
  EXPECT_GT(wrong.position_misfit, 0.3);
  EXPECT_GT(wrong.turn_misfit_deg, 5.0);
}

}  // namespace
}  // namespace rastro
