// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/contrast_area.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace rastro {
namespace {

/// Between the darkest and the brightest around, gray levels: more than noise of a usual image.
constexpr int least_contrast = 25;

}  // namespace

cv::Mat ContrastArea::dark(double level) const {
  // One pass that compilers vectorize: OpenCV's operators take six, a quarter of the time of a search for tags.
  const int share = cvRound(65536.0 * level);
  cv::Mat mask(image.size(), CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    const auto *gray = image.ptr<std::uint8_t>(y), *low = darkest.ptr<std::uint8_t>(y),
               *high = brightest.ptr<std::uint8_t>(y);
    auto* out = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < image.cols; ++x) {
      const int contrast = std::max(0, high[x] - low[x]);
      const int threshold = low[x] + ((contrast * share + 32768) >> 16);
      out[x] = contrast > least_contrast && gray[x] < threshold ? 255 : 0;
    }
  }
  return mask;
}

cv::Point2f ContrastArea::in_image(const cv::Point2f& in_area) const {
  const cv::Point2f half(0.5F, 0.5F);
  return (in_area + half) / scale - half + origin;
}

std::optional<ContrastArea> contrast_area(const cv::Mat& image, float largest_scale, int largest_side) {
  ContrastArea area;
  const int side = (std::max(image.cols, image.rows) / 20) | 1;
  const cv::Mat around = cv::getStructuringElement(cv::MORPH_RECT, {side, side});
  cv::erode(image, area.darkest, around);
  cv::dilate(image, area.brightest, around);
  const cv::Rect part = cv::boundingRect(cv::Mat(area.brightest - area.darkest > least_contrast));
  if (part.empty()) return std::nullopt;
  area.origin = part.tl();
  area.scale =
      std::min(largest_scale, static_cast<float>(largest_side) / static_cast<float>(std::max(part.width, part.height)));
  area.scale = std::max(area.scale, 1.0F);
  const auto enlarged = [&](const cv::Mat& whole) {
    cv::Mat result;
    cv::resize(whole(part), result, {}, static_cast<double>(area.scale), static_cast<double>(area.scale),
               cv::INTER_LINEAR);
    return result;
  };
  area.image = enlarged(image);
  area.darkest = enlarged(area.darkest);
  area.brightest = enlarged(area.brightest);
  return area;
}

}  // namespace rastro
