// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/descriptor_extractor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/feature/descriptor_matching.h"

namespace rastro {
namespace {

constexpr int width = 500, height = 400;
constexpr int middle_x = width / 2, middle_y = height / 2;

/// Soft random blobs of many sizes on a plane that can be sampled anywhere.
class Blots {
 public:
  explicit Blots(std::uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < 1200; ++i) {
      blots_.push_back(
          {random.uniform(-100, 600), random.uniform(-100, 500), random.uniform(2, 8), random.uniform(-90, 90)});
    }
  }
  /// Its image with a shift and a rotation about the center.
  GrayImage image(double dx, double dy, double angle_rad) const {
    GrayImage result(width, height);
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    std::vector<double> values(width * height, 128.0);
    for (const Blot& blot : blots_) {
      const double x = c * (blot.x - middle_x) - s * (blot.y - middle_y) + middle_x + dx,
                   y = s * (blot.x - middle_x) + c * (blot.y - middle_y) + middle_y + dy;
      const int reach = static_cast<int>(3.0 * blot.size);
      for (int v = std::max(0, static_cast<int>(y) - reach); v <= std::min(height - 1, static_cast<int>(y) + reach);
           ++v) {
        for (int u = std::max(0, static_cast<int>(x) - reach); u <= std::min(width - 1, static_cast<int>(x) + reach);
             ++u) {
          const double squared = (u - x) * (u - x) + (v - y) * (v - y);
          values[static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u)] +=
              blot.gray * std::exp(-0.5 * squared / (blot.size * blot.size));
        }
      }
    }
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        result.at(u, v) = static_cast<std::uint8_t>(
            std::clamp(values[static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u)], 0.0, 255.0));
      }
    }
    return result;
  }

 private:
  struct Blot {
    double x, y, size, gray;
  };
  std::vector<Blot> blots_;
};

class DescriptorExtractorTest : public ::testing::TestWithParam<DescriptorKind> {
 protected:
  void SetUp() override {
    if (GetParam() == DescriptorKind::surf && !has_surf()) GTEST_SKIP() << "this build has no SURF";
  }
  static std::unique_ptr<DescriptorExtractor> extractor() { return DescriptorExtractor::create(GetParam(), {}); }
};

TEST_P(DescriptorExtractorTest, MatchesAShiftedAndRotatedImage) {
  const Blots blots(1);
  const auto reference = extractor()->extract(blots.image(0, 0, 0));
  ASSERT_GE(reference.size(), 60U);
  struct View {
    double dx, dy, angle;
  };
  for (const View& view : {View{12.3, -7.6, 0.0}, View{3.0, 5.0, 0.35}}) {
    const auto rotated = extractor()->extract(blots.image(view.dx, view.dy, view.angle));
    const auto matches = match_descriptors(reference, rotated, {});
    const double c = std::cos(view.angle), s = std::sin(view.angle);
    int right = 0;
    for (const DescriptorMatch& match : matches) {
      const Keypoint &a = reference.keypoints[match.first], &b = rotated.keypoints[match.second];
      const double x = c * (a.x - middle_x) - s * (a.y - middle_y) + middle_x + view.dx,
                   y = s * (a.x - middle_x) + c * (a.y - middle_y) + middle_y + view.dy;
      right += std::hypot(b.x - x, b.y - y) < std::max(3.0F, 0.1F * b.size_px);
    }
    EXPECT_GE(matches.size(), 40U) << view.angle;
    EXPECT_GT(right, 0.9 * static_cast<double>(matches.size())) << view.angle;
  }
}

TEST_P(DescriptorExtractorTest, GivesTheStrongestFirstAndIsRepeatable) {
  const GrayImage image = Blots(2).image(0, 0, 0);
  const auto first = extractor()->extract(image), second = extractor()->extract(image);
  EXPECT_EQ(first.floats, second.floats);
  EXPECT_EQ(first.descriptors, second.descriptors);
  for (std::size_t i = 1; i < first.size(); ++i) {
    EXPECT_GE(first.keypoints[i - 1].response, first.keypoints[i].response);
  }
  if (first.binary()) {
    EXPECT_EQ(first.descriptors.size(), first.size());
  } else {
    EXPECT_EQ(first.floats.size(), first.size() * static_cast<std::size_t>(first.length));
  }
  EXPECT_LE(DescriptorExtractor::create(GetParam(), {.max_keypoints = 20})->extract(image).size(), 20U);
}

TEST_P(DescriptorExtractorTest, ABlankImageHasNoKeypoints) {
  for (const auto& [columns, rows] : {std::pair(0, 0), {1, 1}, {63, 400}, {64, 64}, {400, 300}}) {
    EXPECT_EQ(extractor()->extract(GrayImage(columns, rows)).size(), 0U) << columns;
  }
}

TEST_P(DescriptorExtractorTest, RefusesOptionsOutOfRange) {
  EXPECT_THROW(DescriptorExtractor::create(GetParam(), {.max_keypoints = 0}), Error);
  EXPECT_THROW(DescriptorExtractor::create(GetParam(), {.orb_fast_threshold = 0}), Error);
}

std::string name_of(const ::testing::TestParamInfo<DescriptorKind>& kind) {
  constexpr std::array<const char*, 3> names{"sift", "orb", "surf"};
  return names[static_cast<std::size_t>(kind.param)];
}
INSTANTIATE_TEST_SUITE_P(Kinds, DescriptorExtractorTest,
                         ::testing::Values(DescriptorKind::sift, DescriptorKind::orb, DescriptorKind::surf), name_of);

TEST(DescriptorKind, IsParsedFromItsName) {
  EXPECT_EQ(descriptor_kind("sift", "--descriptor"), DescriptorKind::sift);
  EXPECT_EQ(descriptor_kind("orb", "--descriptor"), DescriptorKind::orb);
  EXPECT_EQ(descriptor_kind("surf", "--descriptor"), DescriptorKind::surf);
  EXPECT_THROW(descriptor_kind("SIFT!", "--descriptor"), Error);
}

}  // namespace
}  // namespace rastro
