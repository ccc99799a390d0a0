// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/descriptor_extractor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numbers>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <tuple>

#include "rastro/base/error.h"
#include "rastro/feature/descriptor_extractor_surf.h"

namespace rastro {
namespace {

constexpr int least_side = 64;

cv::Mat as_matrix(GrayView image) {
  // OpenCV has no view of constant pixels; detectors do not write to their input.
  return cv::Mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data),
                 static_cast<std::size_t>(image.stride));
}

std::vector<Keypoint> keypoints_of(const std::vector<cv::KeyPoint>& found) {
  std::vector<Keypoint> keypoints;
  for (const cv::KeyPoint& k : found) {
    keypoints.push_back({k.pt.x, k.pt.y, k.size, k.angle * std::numbers::pi_v<float> / 180.0F, k.response});
  }
  return keypoints;
}

class SiftExtractor final : public DescriptorExtractor {
 public:
  explicit SiftExtractor(const DescriptorExtractorOptions& options)
      : sift_(cv::SIFT::create(options.max_keypoints, 3, options.sift_contrast)) {}

 private:
  Features extract_unsorted(GrayView image) override {
    std::vector<cv::KeyPoint> found;
    cv::Mat descriptors;
    sift_->detectAndCompute(as_matrix(image), cv::noArray(), found, descriptors);
    Features result;
    result.keypoints = keypoints_of(found);
    result.length = 128;
    for (int i = 0; i < descriptors.rows; ++i) {
      const float* row = descriptors.ptr<float>(i);
      result.floats.insert(result.floats.end(), row, row + 128);
    }
    return result;
  }
  cv::Ptr<cv::SIFT> sift_;
};

class OrbExtractor final : public DescriptorExtractor {
 public:
  explicit OrbExtractor(const DescriptorExtractorOptions& options)
      : orb_(cv::ORB::create(options.max_keypoints, 1.2F, 8, 31, 0, 2, cv::ORB::HARRIS_SCORE, 31,
                             options.orb_fast_threshold)) {}

 private:
  Features extract_unsorted(GrayView image) override {
    std::vector<cv::KeyPoint> found;
    cv::Mat descriptors;
    orb_->detectAndCompute(as_matrix(image), cv::noArray(), found, descriptors);
    Features result;
    result.keypoints = keypoints_of(found);
    result.descriptors.resize(result.keypoints.size());
    for (int i = 0; i < descriptors.rows; ++i) {
      std::memcpy(result.descriptors[static_cast<std::size_t>(i)].words.data(), descriptors.ptr(i), 32);
    }
    return result;
  }
  cv::Ptr<cv::ORB> orb_;
};

/// Strongest first, in an order that is the same for any two equal sets of keypoints.
Features sorted(const Features& features, std::size_t most) {
  std::vector<std::size_t> order(features.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](std::size_t i) {
    const Keypoint& k = features.keypoints[i];
    return std::tuple(-k.response, k.y, k.x, k.size_px, k.angle_rad);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  order.resize(std::min(order.size(), most));
  Features result;
  result.length = features.length;
  const auto length = static_cast<std::ptrdiff_t>(features.length);
  for (const std::size_t i : order) {
    result.keypoints.push_back(features.keypoints[i]);
    const auto begin = features.floats.begin() + static_cast<std::ptrdiff_t>(i) * length;
    if (length > 0) result.floats.insert(result.floats.end(), begin, begin + length);
    if (length == 0) result.descriptors.push_back(features.descriptors[i]);
  }
  return result;
}

void check(const DescriptorExtractorOptions& options) {
  const auto refuse = [](const char* name, double value, const char* range) {
    throw Error(fmt::format("{} = {} is out of range", name, value), "descriptor options", range);
  };
  if (options.max_keypoints < 1) refuse("max_keypoints", options.max_keypoints, "use 1 or more");
  if (!(options.sift_contrast >= 0.0)) refuse("sift_contrast", options.sift_contrast, "use 0 or more");
  if (!(options.surf_threshold >= 0.0)) refuse("surf_threshold", options.surf_threshold, "use 0 or more");
  if (options.orb_fast_threshold < 1 || options.orb_fast_threshold > 255) {
    refuse("orb_fast_threshold", options.orb_fast_threshold, "use 1 to 255");
  }
}

std::unique_ptr<DescriptorExtractor> make(DescriptorKind kind, const DescriptorExtractorOptions& options) {
  switch (kind) {
    case DescriptorKind::sift:
      return std::make_unique<SiftExtractor>(options);
    case DescriptorKind::orb:
      return std::make_unique<OrbExtractor>(options);
    case DescriptorKind::surf:
      return detail::make_surf_extractor(options);
  }
  RASTRO_CHECK(false, "no such kind of descriptor");
}

}  // namespace

DescriptorKind descriptor_kind(std::string_view name, std::string_view where) {
  if (name == "sift") return DescriptorKind::sift;
  if (name == "orb") return DescriptorKind::orb;
  if (name == "surf") return DescriptorKind::surf;
  throw Error(fmt::format("there is no descriptor '{}'", name), where, "use sift, orb or surf");
}

std::unique_ptr<DescriptorExtractor> DescriptorExtractor::create(DescriptorKind kind,
                                                                 const DescriptorExtractorOptions& options) {
  check(options);
  auto extractor = make(kind, options);
  extractor->max_keypoints_ = static_cast<std::size_t>(options.max_keypoints);
  return extractor;
}

Features DescriptorExtractor::extract(GrayView image) {
  if (image.width < least_side || image.height < least_side) return {};
  return sorted(extract_unsorted(image), max_keypoints_);
}

}  // namespace rastro
