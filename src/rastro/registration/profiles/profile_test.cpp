// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/profile.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/base/simd.h"
#include "rastro/image/image_testing.h"
#include "rastro/registration/profiles/expansion.h"
#include "rastro/registration/profiles/shift.h"

namespace rastro {
namespace {

using testing::noise_image;

/// A smooth, irregular profile that can be sampled anywhere.
double texture(double position) {
  return 120.0 + 40.0 * std::sin(0.11 * position) + 30.0 * std::sin(0.047 * position + 1.0) +
         20.0 * std::sin(0.29 * position + 2.0) + 15.0 * std::sin(0.0171 * position + 0.3);
}

template <typename Position>
Profile profile_of(int size, Position&& position) {
  Profile profile;
  for (int i = 0; i < size; ++i) {
    profile.push_back(static_cast<std::int16_t>(std::lround(profile_units * texture(position(i)))));
  }
  return profile;
}

/// The formula of METHODS 2.2, term by term.
int plain_shift(const Profile& previous, const Profile& current, int max_shift) {
  const int size = static_cast<int>(previous.size());
  int best = 0;
  double least = 1e300;
  for (int d = -max_shift; d <= max_shift; ++d) {
    double sum = 0.0;
    for (int n = 0; n < size - std::abs(d); ++n) {
      sum += std::abs(current[static_cast<std::size_t>(n + std::max(d, 0))] -
                      previous[static_cast<std::size_t>(n - std::min(d, 0))]);
    }
    sum /= size - std::abs(d);
    if (sum < least) {
      least = sum;
      best = d;
    }
  }
  return best;
}

TEST(Profile, ColumnsAndRowsAreMeans) {
  const GrayImage image = noise_image(173, 301, 4);
  Profile columns, rows;
  column_profile(image, 10, 290, columns);
  row_profile(image, 20, 160, rows);
  ASSERT_EQ(columns.size(), 173U);
  ASSERT_EQ(rows.size(), 301U);
  for (int x : {0, 31, 172}) {
    double sum = 0.0;
    for (int y = 10; y < 290; ++y) sum += image.at(x, y);
    EXPECT_NEAR(columns[static_cast<std::size_t>(x)], profile_units * sum / 280.0, 0.51);
  }
  for (int y : {0, 77, 300}) {
    double sum = 0.0;
    for (int x = 20; x < 160; ++x) sum += image.at(x, y);
    EXPECT_NEAR(rows[static_cast<std::size_t>(y)], profile_units * sum / 140.0, 0.51);
  }
  column_profile(image, 50, 50, columns);
  EXPECT_EQ(columns, Profile(173, 0));
}

TEST(Profile, AtEqualAnglesARotationIsAShift) {
  const Camera camera{.width = 1242, .height = 375, .fx = 721.5, .fy = 721.5, .cx = 609.6, .cy = 172.9};
  const AngleScale scale = AngleScale::across(camera, camera.width);
  const int turn_steps = 37;  // to the left: all angles increase by this much
  const auto seen_from = [&](double rotation) {
    return profile_of(camera.width,
                      [&](int x) { return camera.fx * (std::atan((x - camera.cx) / camera.fx) - rotation); });
  };
  Profile before, after;
  scale.resample(seen_from(0.0), before);
  scale.resample(seen_from(turn_steps / camera.fx), after);
  for (std::size_t i = 0; i + turn_steps < before.size(); ++i) {
    EXPECT_NEAR(before[i], after[i + turn_steps], 0.3 * profile_units) << i;
  }
}

TEST(Shift, IsThatOfTheFormulaOnNoise) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    Profile previous(300), current(300);
    for (auto& value : previous) value = static_cast<std::int16_t>(random.below(16000));
    const int shift = static_cast<int>(random.below(101)) - 50;
    for (int i = 0; i < 300; ++i) {
      const int from = i - shift;
      current[static_cast<std::size_t>(i)] =
          from >= 0 && from < 300 ? previous[static_cast<std::size_t>(from)] : std::int16_t{500};
    }
    const ProfileShift found = find_shift(previous, current, 60);
    EXPECT_EQ(plain_shift(previous, current, 60), shift);
    EXPECT_NEAR(found.shift, shift, 0.5);
    EXPECT_GT(found.confidence, 0.9);
  }
}

TEST(Shift, IsTheSameWithAndWithoutSimd) {
  Random random(9);
  Profile a(1021), b(1021);
  for (auto* profile : {&a, &b}) {
    for (auto& value : *profile) value = static_cast<std::int16_t>(static_cast<int>(random.below(32641)) - 16320);
  }
  const auto fast = sum_of_differences(a.data(), b.data(), 1021);
  limit_simd_level(SimdLevel::plain);
  EXPECT_EQ(sum_of_differences(a.data(), b.data(), 1021), fast);
  limit_simd_level(SimdLevel::avx2);
}

TEST(Shift, IsSubPixel) {
  for (const double shift : {-41.3, -0.25, 0.0, 0.4, 77.75}) {
    const auto previous = profile_of(1200, [](int i) { return i; });
    const auto current = profile_of(1200, [&](int i) { return i - shift; });
    EXPECT_NEAR(find_shift(previous, current, 150).shift, shift, 0.25) << shift;
  }
}

TEST(Shift, FlatAndPeriodicProfilesGetNoConfidence) {
  EXPECT_EQ(find_shift(Profile(500, 900), Profile(500, 900), 100).confidence, 0.0);
  Profile waves;
  for (int i = 0; i < 500; ++i) waves.push_back(static_cast<std::int16_t>(i % 20 < 10 ? 1000 : 3000));
  EXPECT_LT(find_shift(waves, waves, 100).confidence, 0.01);
  EXPECT_EQ(find_shift(waves, waves, 100).shift, 0.0);
  EXPECT_EQ(find_shift({}, {}, 100).confidence, 0.0);
}

TEST(Shift, MeanAndGradientIgnoreBrightness) {
  const auto previous = profile_of(1200, [](int i) { return i; });
  auto current = profile_of(1200, [](int i) { return i - 30; });
  for (auto& value : current) value = static_cast<std::int16_t>(value + 40 * profile_units);
  Profile a = previous, b = current;
  subtract_mean(a);
  subtract_mean(b);
  EXPECT_NEAR(find_shift(a, b, 150).shift, 30.0, 0.1);
  a = previous, b = current;
  take_gradient(a, 3);
  take_gradient(b, 3);
  EXPECT_NEAR(find_shift(a, b, 150).shift, 30.0, 0.1);
}

/// Walls on both sides move outwards while the camera rotates: the plain shift is wrong, this one is not.
TEST(ExpandingShift, DistinguishesPassingWallsFromARotation) {
  const ExpansionModel model{.focal_px = 720.0, .zero_step = 500};
  for (const double rotation : {-25.0, 0.0, 8.5}) {
    for (const std::pair<double, double>& walls : {std::pair{0.0, 0.0}, {0.12, 0.03}, {0.02, 0.16}}) {
      const double low = walls.first, high = walls.second;
      const auto previous = profile_of(1000, [](int i) { return i; });
      const auto current = profile_of(1000, [&](int i) {
        // The point at i now was at `before`: found by iterating the forward motion.
        double before = i - rotation;
        for (int iteration = 0; iteration < 50; ++iteration) {
          const double sine = std::sin((before - model.zero_step) / model.focal_px);
          before = i - rotation - model.focal_px * (sine < 0.0 ? low : high) * sine * std::abs(sine);
        }
        return before;
      });
      const auto found = ExpandingShiftFinder().find(previous, current, 150, model);
      EXPECT_NEAR(found.shift, rotation, 0.4) << low << ' ' << high;
      EXPECT_NEAR(found.low_expansion, low, 0.021) << rotation;
      EXPECT_NEAR(found.high_expansion, high, 0.021) << rotation;
      EXPECT_GT(found.confidence, 0.4);
    }
  }
}

TEST(ExpandingShift, TooShortProfilesGetNoConfidence) {
  EXPECT_EQ(ExpandingShiftFinder().find(Profile(80, 1), Profile(80, 1), 30, ExpansionModel{}).confidence, 0.0);
}

}  // namespace
}  // namespace rastro
