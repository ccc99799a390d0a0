// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/brief.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr int angles = 32;
constexpr std::size_t tests = 256;

std::vector<BriefTest> draw_tests(int patch_px, std::uint64_t seed) {
  Random random(seed);
  const double sigma = patch_px / 5.0;
  const double limit = patch_px / 2.0;
  const auto draw = [&] { return static_cast<float>(std::clamp(sigma * random.normal(), -limit, limit)); };
  std::vector<BriefTest> drawn;
  while (drawn.size() < tests) {
    BriefTest test{};
    test.ax = draw();
    test.ay = draw();
    test.bx = draw();
    test.by = draw();
    // A test whose ends fall on one pixel says nothing.
    if (std::lround(test.ax) != std::lround(test.bx) || std::lround(test.ay) != std::lround(test.by))
      drawn.push_back(test);
  }
  return drawn;
}

}  // namespace

int hamming_distance(const Descriptor& a, const Descriptor& b) {
  int distance = 0;
  for (std::size_t i = 0; i < 4; ++i) distance += std::popcount(a.words[i] ^ b.words[i]);
  return distance;
}

const std::vector<double>& Brief::scales() {
  // The plain pattern first, then steps of about a quarter either way.
  static const std::vector<double> steps = {1.0, 0.8, 1.25, 0.64, 1.5625};
  return steps;
}

Brief::Brief(int patch_px, std::uint64_t seed) {
  RASTRO_CHECK(patch_px >= 8 && patch_px <= 64, "offsets of all scales fit a byte");
  const auto drawn = draw_tests(patch_px, seed);
  for (const double scale : scales()) {
    for (int angle = 0; angle < angles; ++angle) {
      const double turn = 2.0 * std::numbers::pi * angle / angles;
      const double cosine = scale * std::cos(turn), sine = scale * std::sin(turn);
      Pattern pattern{};
      const auto place = [&](std::size_t index, double x, double y) {
        pattern.offsets[index] = {static_cast<std::int8_t>(std::lround(cosine * x - sine * y)),
                                  static_cast<std::int8_t>(std::lround(sine * x + cosine * y))};
        reach_ = std::max({reach_, std::abs(int{pattern.offsets[index].x}), std::abs(int{pattern.offsets[index].y})});
      };
      for (std::size_t t = 0; t < drawn.size(); ++t) {
        place(2 * t, drawn[t].ax, drawn[t].ay);
        place(2 * t + 1, drawn[t].bx, drawn[t].by);
      }
      patterns_.push_back(pattern);
    }
  }
}

Descriptor Brief::describe(const Image<std::uint16_t>& sums, float x, float y, double angle_rad, double scale) const {
  const auto nearest_scale = std::min_element(
      scales().begin(), scales().end(), [&](double a, double b) { return std::abs(a - scale) < std::abs(b - scale); });
  const auto turns = std::lround(angle_rad * angles / (2.0 * std::numbers::pi));
  const auto angle_index = ((turns % angles) + angles) % angles;
  const Pattern& pattern =
      patterns_[static_cast<std::size_t>((nearest_scale - scales().begin()) * angles + angle_index)];
  const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));

  const auto build = [](auto value) {
    Descriptor descriptor;
    for (std::size_t w = 0; w < 4; ++w) {
      std::uint64_t word = 0;
      for (std::size_t t = 0; t < 64; ++t)
        word |= static_cast<std::uint64_t>(value(2 * (64 * w + t)) < value(2 * (64 * w + t) + 1)) << t;
      descriptor.words[w] = word;
    }
    return descriptor;
  };
  if (cx >= reach_ && cy >= reach_ && cx + reach_ < sums.width() && cy + reach_ < sums.height()) {
    const std::uint16_t* centre = sums.row(cy) + cx;
    const std::ptrdiff_t stride = sums.stride();
    // All places first: the tests then are loads and compares alone.
    std::array<std::int32_t, 2 * tests> places;
    for (std::size_t i = 0; i < places.size(); ++i) {
      places[i] = static_cast<std::int32_t>(pattern.offsets[i].y * stride + pattern.offsets[i].x);
    }
    return build([&](std::size_t i) { return centre[places[i]]; });
  }
  return build([&](std::size_t i) {
    const Offset offset = pattern.offsets[i];
    return sums.at(std::clamp(cx + offset.x, 0, sums.width() - 1), std::clamp(cy + offset.y, 0, sums.height() - 1));
  });
}

double intensity_centroid_angle(GreyView image, float x, float y, int radius) {
  const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
  std::int64_t moment_x = 0, moment_y = 0;
  for (int dy = -radius; dy <= radius; ++dy) {
    const std::uint8_t* row = image.row(std::clamp(cy + dy, 0, image.height - 1));
    for (int dx = -radius; dx <= radius; ++dx) {
      if (dx * dx + dy * dy > radius * radius) continue;
      const int intensity = row[std::clamp(cx + dx, 0, image.width - 1)];
      moment_x += dx * intensity;
      moment_y += dy * intensity;
    }
  }
  return std::atan2(static_cast<double>(moment_y), static_cast<double>(moment_x));
}

}  // namespace rastro
