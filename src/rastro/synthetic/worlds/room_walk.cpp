// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/room_walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"

namespace rastro::room {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr double knots_hz = 30.0;
constexpr double swing_time_s = 0.4, swing_rest_s = 0.15;

using Pose6 = std::array<double, 6>;

double wave(double seconds, double period_s, double phase) {
  return std::sin(2.0 * std::numbers::pi * seconds / period_s + phase);
}

double smooth_step(double f) {
  f = std::clamp(f, 0.0, 1.0);
  return f * f * (3.0 - 2.0 * f);
}

double slope_between(const WalkKey& before, const WalkKey& after, std::size_t channel) {
  return (after.pose[channel] - before.pose[channel]) / (after.time_s - before.time_s);
}

/// Slope from the keys before and after (Catmull and Rom 1974), across the end of a round too.
double slope_at(const std::vector<WalkKey>& keys, std::size_t i, std::size_t channel) {
  const std::size_t last = keys.size() - 1;
  if (i > 0 && i < last) return slope_between(keys[i - 1], keys[i + 1], channel);
  const WalkKey &before = keys[last - 1], &after = keys[1];
  return (after.pose[channel] - before.pose[channel]) / (after.time_s + keys[last].time_s - before.time_s);
}

Pose6 along_keys(const std::vector<WalkKey>& keys, double time_s) {
  std::size_t i = 0;
  while (i + 2 < keys.size() && keys[i + 1].time_s <= time_s) ++i;
  const double span = keys[i + 1].time_s - keys[i].time_s, f = (time_s - keys[i].time_s) / span;
  Pose6 pose{};
  for (std::size_t c = 0; c < pose.size(); ++c) {
    const double a = keys[i].pose[c], b = keys[i + 1].pose[c];
    const double from = span * slope_at(keys, i, c), to = span * slope_at(keys, i + 1, c);
    pose[c] = a + f * (from + f * (3 * (b - a) - 2 * from - to + f * (2 * (a - b) + from + to)));
  }
  return pose;
}

/// Steps and a trembling hand.
void add_unrest(Pose6& pose, double t) {
  pose[0] += 0.006 * wave(t, 1.31, 0.0) + 0.0022 * wave(t, 0.47, 1.0);
  pose[1] += 0.008 * wave(t, 1.09, 2.0) + 0.0025 * wave(t, 0.39, 0.4);
  pose[2] += 0.009 * wave(t, 0.55, 0.7) + 0.0015 * wave(t, 0.23, 2.1);
  pose[3] += 0.60 * wave(t, 1.23, 0.2) + 0.25 * wave(t, 0.37, 1.9) + 0.05 * wave(t, 0.13, 0.3);
  pose[4] += 0.50 * wave(t, 0.91, 1.2) + 0.25 * wave(t, 0.31, 0.6) + 0.05 * wave(t, 0.117, 1.3);
  pose[5] += 0.70 * wave(t, 1.57, 2.8) + 0.25 * wave(t, 0.43, 0.9);
}

void wander(Pose6& pose, const Walk& walk, double t, double round_s) {
  // Nothing in the first round, so that its content is fixed.
  const double share = smooth_step(t / round_s - 1.0 + 0.05);
  const double reach = share * walk.wander_m;
  pose[0] += reach * (wave(t, 23.1, 0.4) + 0.6 * wave(t, 11.7, 1.0));
  pose[1] += reach * (wave(t, 19.7, 2.4) + 0.6 * wave(t, 9.1, 3.0));
  pose[2] += reach * wave(t, 17.3, 1.4);
  pose[3] += share * (2.5 * wave(t, 13.9, 0.3) + 1.5 * wave(t, 29.3, 1.7));
  pose[4] += share * 2.0 * wave(t, 15.1, 2.3);
}

double swing(const Walk& walk, double time_s) {
  const double out = (time_s - walk.swing_s) / swing_time_s;
  const double back = (time_s - walk.swing_s - swing_time_s - swing_rest_s) / swing_time_s;
  return walk.swing_degrees * (smooth_step(out) - smooth_step(back));
}

}  // namespace

CameraPath walk_path(const Walk& walk) {
  RASTRO_CHECK(walk.keys.size() >= 3 && walk.keys.front().time_s == 0.0, "a walk needs a beginning and an end");
  const auto control = [walk](std::int64_t index) {
    const double time_s = static_cast<double>(index) / knots_hz, round_s = walk.keys.back().time_s;
    Pose6 pose = along_keys(walk.keys, time_s - round_s * std::floor(time_s / round_s));
    wander(pose, walk, time_s, round_s);
    add_unrest(pose, time_s);
    const double yaw = pose[3] + swing(walk, time_s);
    return SE3(looking(yaw * degree, pose[4] * degree, pose[5] * degree), {pose[0], pose[1], pose[2]});
  };
  return {control, 1.0 / knots_hz};
}

}  // namespace rastro::room
