// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/stereo_depth.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

namespace rastro {
namespace {

constexpr int disparity_step =
    16;  ///< OpenCV searches multiples of this, and gives disparities in this part of a pixel.
constexpr double unique_percent = 8;     ///< By which the best match must be better than any other.
constexpr double most_difference = 1.0;  ///< Of the disparities from left to right and back, pixels.

cv::Mat as_matrix(GrayView image) {
  return cv::Mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data),
                 static_cast<std::size_t>(image.stride));
}

}  // namespace

class StereoDepth::Matcher {
 public:
  explicit Matcher(const StereoDepthOptions& options) {
    const int range = (options.max_disparity_px + disparity_step - 1) / disparity_step * disparity_step;
    blocks_ = cv::StereoBM::create(range, options.block_px);
    blocks_->setUniquenessRatio(static_cast<int>(unique_percent));
    blocks_->setTextureThreshold(10);
    blocks_->setDisp12MaxDiff(static_cast<int>(most_difference));
    blocks_->setSpeckleWindowSize(60);
    blocks_->setSpeckleRange(1);
  }
  /// In sixteenths of a pixel; negative where there is none.
  cv::Mat1s disparity(GrayView left, GrayView right) const {
    cv::Mat1s found;
    blocks_->compute(as_matrix(left), as_matrix(right), found);
    return found;
  }

 private:
  cv::Ptr<cv::StereoBM> blocks_;
};

StereoDepth::StereoDepth(const StereoDepthOptions& options)
    : options_(options), matcher_(std::make_unique<Matcher>(options)) {}
StereoDepth::~StereoDepth() = default;

DepthImage StereoDepth::depth(GrayView left, GrayView right) const {
  const int least_width = options_.max_disparity_px + 4 * options_.block_px, least_height = 4 * options_.block_px;
  if (left.width != right.width || left.height != right.height) return {};
  DepthImage depth(left.width, left.height);
  for (int y = 0; y < left.height; ++y) std::fill_n(depth.row(y), left.width, 0.0F);
  if (left.width < least_width || left.height < least_height) return depth;
  const cv::Mat1s disparity = matcher_->disparity(left, right);
  for (int y = 0; y < left.height; ++y) {
    const short* from = disparity[y];
    float* to = depth.row(y);
    for (int x = 0; x < left.width; ++x) {
      const double pixels = static_cast<double>(from[x]) / disparity_step;
      if (pixels >= options_.min_disparity_px) to[x] = static_cast<float>(options_.focal_times_baseline / pixels);
    }
  }
  return depth;
}

}  // namespace rastro
