// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/occluder/occluder_masks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/library_output.h"
#include "rastro/image/image_header.h"

namespace rastro {
namespace {

constexpr std::size_t masks_kept = 128;  // a few windows of frames

std::filesystem::path masks_of(const std::filesystem::path& folder) { return folder / "mav0" / "occluder"; }

GrayImage read_mask(const std::filesystem::path& file) {
  // Reads the file itself: OpenCV's reader prints if a file is missing.
  const std::string bytes = read_whole_file(file);
  const std::vector<std::uint8_t> buffer(bytes.begin(), bytes.end());
  cv::Mat read;
  const LibraryOutput output;
  try {
    if (!bytes.empty() && why_too_large(buffer).empty()) read = cv::imdecode(buffer, cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception&) {
    read.release();
  }
  if (read.empty())
    throw Error("there is no readable occluder mask", file.string(), "write the data again with `rastro occlude`");
  GrayImage mask(read.cols, read.rows);
  for (int y = 0; y < read.rows; ++y) std::copy_n(read.ptr<std::uint8_t>(y), read.cols, mask.row(y));
  return mask;
}

}  // namespace

bool OccluderMasks::present(const std::filesystem::path& data_folder) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(masks_of(data_folder) / "occluder.yaml", ignored);
}

const GrayImage& OccluderMasks::mask(TimeNs stamp) const {
  const auto found =
      std::find_if(recent_.begin(), recent_.end(), [&](const auto& item) { return item.first == stamp; });
  if (found != recent_.end()) {
    recent_.splice(recent_.begin(), recent_, found);
  } else {
    recent_.emplace_front(stamp, read_mask(masks_of(folder_) / (std::to_string(stamp) + ".png")));
    if (recent_.size() > masks_kept) recent_.pop_back();
  }
  return recent_.front().second;
}

bool OccluderMasks::covered(TimeNs stamp, const Eigen::Vector2d& pixel, double radius_px) const {
  const GrayImage& image = mask(stamp);
  // At radius 0 the pixel that contains the position counts.
  const double reach = std::max(radius_px, 0.5);
  const auto limit = [](double value, int size) {
    return static_cast<int>(std::clamp(value, -1.0, static_cast<double>(size)));
  };
  const int left = std::max(0, limit(std::ceil(pixel.x() - reach), image.width()));
  const int right = std::min(image.width() - 1, limit(std::floor(pixel.x() + reach), image.width()));
  const int top = std::max(0, limit(std::ceil(pixel.y() - reach), image.height()));
  const int bottom = std::min(image.height() - 1, limit(std::floor(pixel.y() + reach), image.height()));
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const bool near = radius_px <= 0.5 || (Eigen::Vector2d(x, y) - pixel).squaredNorm() <= radius_px * radius_px;
      if (near && image.at(x, y) != 0) return true;
    }
  }
  return false;
}

}  // namespace rastro
