// SPDX-License-Identifier: Apache-2.0
// Learns the binary tests of ORB's descriptor (src/rastro/feature/orb_pattern.cpp) from images:
// rastro_learn_orb_pattern IMAGES... Greedy as Rublee et al. 2011, section 4.3: tests that split features evenly and
// are weakly correlated; beyond the paper, among these the tests least sensitive to small errors of corner, orientation
// and scale.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/feature/fast.h"
#include "rastro/feature/orb.h"
#include "rastro/feature/orb_blur.h"
#include "rastro/feature/orb_describe.h"
#include "rastro/feature/orb_resize.h"

namespace {

using namespace rastro;
using Bits = std::vector<std::uint64_t>;  ///< One per feature.

constexpr std::size_t candidates = 6000, wanted = 256;
constexpr int reach = orb_radius - 1;

struct Test {
  int ax, ay, bx, by;
  Bits bits;
  std::size_t ones = 0, flips = 0;
};

std::vector<Test> draw_tests(Random& random) {
  const auto inside = [&](int& x, int& y) {
    do {
      x = static_cast<int>(random.below(2 * reach + 1)) - reach;
      y = static_cast<int>(random.below(2 * reach + 1)) - reach;
    } while (x * x + y * y > reach * reach);
  };
  std::vector<Test> tests(candidates);
  for (Test& test : tests) {
    do {
      inside(test.ax, test.ay);
      inside(test.bx, test.by);
    } while (std::hypot(test.ax - test.bx, test.ay - test.by) < 3.0);
  }
  return tests;
}

/// A corner with position, orientation and scale.
struct OrientedCorner {
  int x, y;
  double cosine, sine;
};

bool is_below(const GrayImage& image, const OrientedCorner& corner, const Test& test) {
  const auto value = [&](int x, int y) {
    const auto to_x = corner.x + std::lround(corner.cosine * x - corner.sine * y);
    const auto to_y = corner.y + std::lround(corner.sine * x + corner.cosine * y);
    return image.at(std::clamp(static_cast<int>(to_x), 0, image.width() - 1),
                    std::clamp(static_cast<int>(to_y), 0, image.height() - 1));
  };
  return value(test.ax, test.ay) < value(test.bx, test.by);
}

class Samples {
 public:
  void add(const GrayImage& image, OrientedCorner corner, Random& random, std::vector<Test>& tests) {
    if (count_ % 64 == 0)
      for (Test& test : tests) test.bits.push_back(0);
    const double angle = random.uniform(-0.2, 0.2), scale = random.uniform(0.88, 1.12);
    const OrientedCorner off{corner.x + static_cast<int>(random.below(3)) - 1,
                             corner.y + static_cast<int>(random.below(3)) - 1,
                             scale * (corner.cosine * std::cos(angle) - corner.sine * std::sin(angle)),
                             scale * (corner.sine * std::cos(angle) + corner.cosine * std::sin(angle))};
    for (Test& test : tests) {
      const bool bit = is_below(image, corner, test);
      test.bits.back() |= static_cast<std::uint64_t>(bit) << (count_ % 64);
      test.ones += bit ? 1 : 0;
      test.flips += bit != is_below(image, off, test) ? 1 : 0;
    }
    ++count_;
  }
  std::size_t count() const { return count_; }

 private:
  std::size_t count_ = 0;
};

void add_image(const cv::Mat& image, Random& random, Samples& samples, std::vector<Test>& tests) {
  const OrbOptions options;
  const auto features = OrbExtractor(options).extract({image.data, image.cols, image.rows, image.cols});
  const auto scales = orb_level_scales(options);
  PaddedImage level;
  level.reset(image.cols, image.rows, fast_padding);
  for (int y = 0; y < image.rows; ++y) std::copy_n(image.ptr(y), image.cols, level.row(y));
  for (std::size_t index = 0; index < scales.size(); ++index) {
    level.fill_padding();
    GrayImage blurred(level.width(), level.height());
    orb_blur(level, blurred, 0, level.height());
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (features.levels[i] != index || random.uniform() > 0.25) continue;
      const int x = static_cast<int>(std::lround((features.keypoints[i].x + 0.5) / scales[index] - 0.5));
      const int y = static_cast<int>(std::lround((features.keypoints[i].y + 0.5) / scales[index] - 0.5));
      const OrbDirection direction = orb_direction(level.row(y) + x, level.stride());
      samples.add(blurred, {x, y, std::cos(direction.angle_rad), std::sin(direction.angle_rad)}, random, tests);
    }
    const OrbResize next(level.width(), level.height(), options.scale_factor);
    PaddedImage coarser;
    coarser.reset(next.width(), next.height(), fast_padding);
    next.run(level, coarser, 0, next.height());
    std::swap(level, coarser);
  }
}

double correlation(const Test& a, const Test& b, std::size_t count) {
  std::size_t both = 0;
  for (std::size_t i = 0; i < a.bits.size(); ++i)
    both += static_cast<std::size_t>(std::popcount(a.bits[i] & b.bits[i]));
  const double n = static_cast<double>(count), p = static_cast<double>(a.ones) / n, q = static_cast<double>(b.ones) / n;
  return std::abs(static_cast<double>(both) / n - p * q) / std::sqrt(p * (1 - p) * q * (1 - q) + 1e-12);
}

std::vector<const Test*> choose(const std::vector<Test>& tests, std::size_t count) {
  for (double limit = 0.2;; limit += 0.02) {
    std::vector<const Test*> chosen;
    for (const Test& test : tests) {
      const bool is_new = std::all_of(chosen.begin(), chosen.end(),
                                      [&](const Test* other) { return correlation(test, *other, count) < limit; });
      if (is_new) chosen.push_back(&test);
      if (chosen.size() == wanted) {
        fmt::print(stderr, "{} features, correlations below {:.2f}\n", count, limit);
        return chosen;
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  Random random(1);
  std::vector<Test> tests = draw_tests(random);
  Samples samples;
  for (int i = 1; i < argc; ++i) {
    const cv::Mat image = cv::imread(argv[i], cv::IMREAD_GRAYSCALE);
    if (!image.empty()) add_image(image.clone(), random, samples, tests);
  }
  const auto count = static_cast<double>(samples.count());
  const auto cost = [&](const Test& test) {
    return std::abs(static_cast<double>(test.ones) / count - 0.5) + static_cast<double>(test.flips) / count;
  };
  std::stable_sort(tests.begin(), tests.end(), [&](const Test& a, const Test& b) { return cost(a) < cost(b); });
  for (const Test* test : choose(tests, samples.count()))
    fmt::print("{{{},{},{},{}}},\n", test->ax, test->ay, test->bx, test->by);
}
