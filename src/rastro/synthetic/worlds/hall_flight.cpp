// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "rastro/synthetic/worlds/hall_scene.h"

namespace rastro::hall {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr int channels = 6;
using Pose6 = std::array<double, channels>;  // x y z (meters), yaw pitch roll (degrees).

struct Key {
  double frame;
  Pose6 pose;
};

// The scripted part. The head of the press hangs 0.66 m ahead of the start with its lower edge at 1.71 m: just above
// the view at the start, below the image center when the drone is at its highest.
constexpr Key script[] = {
    {-4, {0.00, 0.00, 1.30, 0.0, 1.0, 0.0}},     {4, {0.00, 0.00, 1.305, 0.0, 1.0, 0.0}},
    {7.5, {0.00, 0.01, 1.39, 0.3, 1.1, 0.4}},    {10, {0.00, 0.02, 1.55, 0.7, 1.2, 0.7}},
    {12.5, {0.00, 0.03, 1.71, 0.9, 1.2, 0.6}},   {16, {0.00, 0.04, 1.80, 0.8, 1.1, 0.2}},
    {19, {0.00, 0.05, 1.71, 0.2, 0.8, -0.4}},    {21.5, {0.00, 0.06, 1.54, -0.3, 0.7, -0.6}},
    {24, {0.00, 0.06, 1.38, -0.8, 0.8, -0.5}},   {27, {0.00, 0.05, 1.32, -1.0, 0.9, -0.3}},
    {35, {-0.02, 0.03, 1.34, -1.5, 1.2, 0.3}},   {42, {-0.06, 0.00, 1.33, -1.2, 1.4, 0.6}},
    {46, {-0.07, -0.02, 1.33, 28.5, 1.0, -1.5}}, {51, {-0.08, -0.04, 1.33, 29.5, 1.0, -1.0}},
    {55, {-0.09, -0.08, 1.33, -0.5, 1.3, 1.5}},  {60, {-0.10, -0.16, 1.34, -1.5, 1.3, 0.8}},
    {66, {-0.08, -0.37, 1.35, -1.8, 1.2, 1.2}},  {76, {-0.04, -0.84, 1.36, -1.5, 1.2, 1.5}},
    {94, {0.00, -1.75, 1.38, -1.0, 1.0, 1.4}},   {112, {-0.05, -2.66, 1.40, -0.5, 0.9, 1.0}},
    {122, {-0.20, -3.08, 1.42, 1.0, 0.8, 0.4}},  {136, {-0.45, -3.45, 1.45, 3.0, 0.8, 0.0}},
};
constexpr double tour_begin = 118.0, tour_whole = 190.0;  // Between them the script changes into the tour.

/// Slope at a key that keeps the curve between its neighbors (Fritsch and Carlson 1980): the drone must not overshoot.
double slope_at(std::span<const Key> keys, std::size_t i, int channel) {
  if (i == 0 || i + 1 == keys.size()) return 0.0;
  const double before = (keys[i].pose[channel] - keys[i - 1].pose[channel]) / (keys[i].frame - keys[i - 1].frame);
  const double after = (keys[i + 1].pose[channel] - keys[i].pose[channel]) / (keys[i + 1].frame - keys[i].frame);
  return before * after <= 0.0 ? 0.0 : 2.0 * before * after / (before + after);
}

Pose6 scripted(double frame) {
  const std::span<const Key> keys(script);
  if (frame <= keys.front().frame) return keys.front().pose;
  if (frame >= keys.back().frame) return keys.back().pose;
  std::size_t i = 0;
  while (keys[i + 1].frame <= frame) ++i;
  const double span = keys[i + 1].frame - keys[i].frame, f = (frame - keys[i].frame) / span;
  Pose6 pose{};
  for (int c = 0; c < channels; ++c) {
    const double a = keys[i].pose[c], b = keys[i + 1].pose[c];
    const double from = span * slope_at(keys, i, c), to = span * slope_at(keys, i + 1, c);
    pose[c] = a + f * (from + f * (3 * (b - a) - 2 * from - to + f * (2 * (a - b) + from + to)));
  }
  return pose;
}

double wave(double seconds, double period_s, double phase) {
  return std::sin(2.0 * std::numbers::pi * seconds / period_s + phase);
}

/// Endless: the periods have no common multiple, so that no view repeats exactly. Stays in the free aisle x < 0.1,
/// |y| < 6.
Pose6 tour(double seconds) {
  return {-2.9 + 1.9 * wave(seconds, 37.1, 0.9) + 0.9 * wave(seconds, 22.3 * std::numbers::sqrt2, 2.0),
          3.6 * wave(seconds, 41.7, 3.6) + 1.7 * wave(seconds, 17.9 * std::numbers::phi, 0.3),
          1.75 + 0.35 * wave(seconds, 13.3, 1.0) + 0.25 * wave(seconds, 29.0 / std::numbers::e, 2.2),
          24.0 * wave(seconds, 27.7, 0.4) + 21.0 * wave(seconds, 53.1, 5.1) + 20.0 * wave(seconds, 91.3, 2.5),
          2.5 + 4.0 * wave(seconds, 11.9, 0.5),
          3.0 * wave(seconds, 9.7, 1.5) + 1.5 * wave(seconds, 4.3, 0.0)};
}

/// Small shake of a hovering drone.
void add_unrest(Pose6& pose, double seconds) {
  pose[0] += 0.004 * wave(seconds, 1.37, 0.0) + 0.003 * wave(seconds, 0.61, 1.0);
  pose[1] += 0.005 * wave(seconds, 1.13, 2.0) + 0.003 * wave(seconds, 0.53, 0.4);
  pose[2] += 0.003 * wave(seconds, 0.97, 0.7);
  pose[3] += 0.20 * wave(seconds, 0.83, 0.2) + 0.12 * wave(seconds, 0.41, 1.9);
  pose[4] += 0.15 * wave(seconds, 0.71, 1.2);
  pose[5] += 0.25 * wave(seconds, 0.89, 2.8) + 0.12 * wave(seconds, 0.37, 0.9);
}

SE3 control(std::int64_t index) {
  const auto frame = static_cast<double>(index);
  const double seconds = frame / rate_hz;
  Pose6 pose = scripted(frame);
  if (frame > tour_begin) {
    const double f = std::min(1.0, (frame - tour_begin) / (tour_whole - tour_begin));
    const double share = f * f * f * (10.0 + f * (6.0 * f - 15.0));
    const Pose6 touring = tour(seconds);
    for (int c = 0; c < channels; ++c) pose[c] += share * (touring[c] - pose[c]);
  }
  add_unrest(pose, seconds);
  return {looking(pose[3] * degree, pose[4] * degree, pose[5] * degree), {pose[0], pose[1], pose[2]}};
}

}  // namespace

CameraPath flight() { return {control, 1.0 / rate_hz}; }

}  // namespace rastro::hall
