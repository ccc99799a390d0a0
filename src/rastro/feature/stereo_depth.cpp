// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/stereo_depth.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/feature/disparity_refinement.h"

namespace rastro {
namespace {

constexpr int disparity_step =
    16;                      ///< OpenCV searches multiples of this, and gives disparities in this part of a pixel.
constexpr int half = 2;      ///< Semi-global matching at this part of the size: an eighth of the time.
constexpr int block_px = 5;  ///< Width of the blocks compared there.
constexpr int unique_percent = 8;    ///< By which the best match must be better than any other.
constexpr int most_difference = 1;   ///< Of the disparities from left to right and back, pixels.
constexpr int speckle_pixels = 100;  ///< Smaller regions of one depth are chance.

cv::Mat as_matrix(GrayView image) {
  return cv::Mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data),
                 static_cast<std::size_t>(image.stride));
}

/// At half the size, with `left_border` more columns on the left: the matcher gives none to the first ones.
cv::Mat halved(GrayView image, int left_border) {
  cv::Mat small, bordered;
  cv::resize(as_matrix(image), small, {}, 1.0 / half, 1.0 / half, cv::INTER_AREA);
  cv::copyMakeBorder(small, bordered, 0, 0, left_border, 0, cv::BORDER_REPLICATE);
  return bordered;
}

/// Disparities of an image twice as large: linear between pixels of one surface, else the nearest.
Image<float> doubled(const cv::Mat1s& small, int width, int height) {
  constexpr int one_surface = disparity_step;  // difference of its disparities, at most
  constexpr float to_pixels = static_cast<float>(half) / disparity_step;
  Image<float> result(width, height);
  for (int y = 0; y < height; ++y) {
    const int middle = std::min(y / half, small.rows - 1);
    const short* near = small[middle];
    const short* far = small[std::clamp(y % half == 0 ? middle - 1 : middle + 1, 0, small.rows - 1)];
    for (int x = 0; x < width; ++x) {
      const int k = std::min(x / half, small.cols - 1);
      const int beside = std::clamp(x % half == 0 ? k - 1 : k + 1, 0, small.cols - 1);
      const auto [least, most] = std::minmax({near[k], near[beside], far[k], far[beside]});
      // The center of a pixel is a quarter of a small one away from that of the nearest small one.
      const int sum = 9 * near[k] + 3 * (near[beside] + far[k]) + far[beside];
      const bool linear = least > 0 && most - least <= one_surface;
      const float sixteenths = linear ? static_cast<float>(sum) / 16.0F : static_cast<float>(near[k]);
      result.at(x, y) = std::max(0.0F, to_pixels * sixteenths);
    }
  }
  return result;
}

}  // namespace

class StereoDepth::Matcher {
 public:
  explicit Matcher(const StereoDepthOptions& options) {
    const int most = (options.max_disparity_px + half - 1) / half;
    range_ = (most + disparity_step - 1) / disparity_step * disparity_step;
    // Costs of a change of the disparity by one, and by more (Hirschmueller 2008), as OpenCV advises for one channel.
    constexpr int small_change = 2 * block_px * block_px, change = 4 * small_change;
    blocks_ = cv::StereoSGBM::create(0, range_, block_px, small_change, change, most_difference, 31, unique_percent,
                                     speckle_pixels, 2, cv::StereoSGBM::MODE_SGBM_3WAY);
  }

  /// Pixels of the whole image; 0 where there is none.
  Image<float> disparity(GrayView left, GrayView right) const {
    cv::Mat1s found;
    blocks_->compute(halved(left, range_), halved(right, range_), found);
    Image<float> result = doubled(found.colRange(range_, found.cols), left.width, left.height);
    refine_disparity(left, right, {}, result);
    return result;
  }

 private:
  int range_ = 0;  ///< Disparities searched, in pixels of the half size.
  cv::Ptr<cv::StereoSGBM> blocks_;
};

StereoDepth::StereoDepth(const StereoDepthOptions& options)
    : options_(options), matcher_(std::make_unique<Matcher>(options)) {}
StereoDepth::~StereoDepth() = default;

DepthImage StereoDepth::depth(GrayView left, GrayView right) const {
  constexpr int least_size = 8 * block_px;
  if (left.width != right.width || left.height != right.height) return {};
  DepthImage depth(left.width, left.height);
  for (int y = 0; y < left.height; ++y) std::fill_n(depth.row(y), left.width, 0.0F);
  if (left.width < least_size || left.height < least_size) return depth;
  const Image<float> disparity = matcher_->disparity(left, right);
  const auto least = static_cast<float>(options_.min_disparity_px),
             most = static_cast<float>(options_.max_disparity_px);
  for (int y = 0; y < left.height; ++y) {
    const float* from = disparity.row(y);
    float* to = depth.row(y);
    for (int x = 0; x < left.width; ++x)
      if (from[x] >= least && from[x] <= most) to[x] = static_cast<float>(options_.focal_times_baseline) / from[x];
  }
  return depth;
}

}  // namespace rastro
