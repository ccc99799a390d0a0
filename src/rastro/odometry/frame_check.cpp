// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/frame_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "rastro/base/error.h"
#include "rastro/image/equalize.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

// Fewer values give no reliable median.
constexpr std::size_t least_known = 3;
// Differences across two pixels have a better signal-to-noise ratio than across one.
constexpr int gradient_reach = 2;
constexpr int row_step = 4;

/// Ratio of `value` to the median of `known`, to which it is then added; 1 while too few are known.
double ratio_to_median(std::deque<double>& known, double value, int memory) {
  double ratio = 1.0;
  if (known.size() >= least_known) {
    const double median = upper_median(std::vector<double>(known.begin(), known.end()));
    if (median > 0.0) ratio = value / median;
  }
  known.push_back(value);
  if (known.size() > static_cast<std::size_t>(memory)) known.pop_front();
  return ratio;
}

std::int64_t sum_of_differences(const std::uint8_t* a, const std::uint8_t* b, int count) {
  std::int32_t sum = 0;
  for (int i = 0; i < count; ++i) sum += std::abs(a[i] - b[i]);
  return sum;
}

}  // namespace

void add_options(OptionTable& table, FrameCheckOptions& o) {
  table.add({"min_deviation",
             &o.min_deviation,
             "intensity",
             "minimum standard deviation of the intensities; an image below is dark or blank and rejected",
             0,
             128,
             {}});
  table.add(
      {"max_repeat_difference",
       &o.max_repeat_difference,
       "intensity",
       "an image whose mean absolute intensity difference to the previous one is not larger is a repeat; noise alone "
       "gives about 1",
       0,
       255,
       {}});
  table.add({"min_sharpness",
             &o.min_sharpness,
             "",
             "an image whose gradients along x or y are smaller than this share of their running median is blurred and "
             "rejected; 0 disables the check",
             0,
             1,
             {}});
  table.add({"max_step_ratio",
             &o.max_step_ratio,
             "",
             "a stamp step longer than this times the running median is a gap in the recording; 0 disables the check",
             0,
             1e6,
             {}});
  table.add(
      {"check_memory", &o.memory, "frames", "length of the running medians of stamp step and sharpness", 3, 1000, {}});
}

FrameCheckResult FrameCheck::check(GrayView image, TimeNs stamp) {
  check_size(image);
  FrameCheckResult result;
  const std::optional<TimeNs> before = last_stamp_;
  last_stamp_ = stamp;
  if (before && stamp <= *before) {
    result.reason = OdometryReason::repeated_frame;
    result.detail = fmt::format("stamp {:.3f} s after the previous one", to_seconds(stamp - *before));
    return result;
  }
  if (before) result.step_ratio = step_ratio(stamp - *before);
  result.deviation = brightness(image).deviation;
  if (result.deviation < options_.min_deviation || image.empty()) {
    result.reason = OdometryReason::dark_or_blank;
    result.detail = fmt::format("intensity deviation {:.1f}, need {:.1f}", result.deviation, options_.min_deviation);
    return result;
  }
  result.difference = difference_to_last(image);
  if (result.difference >= 0.0 && result.difference <= options_.max_repeat_difference) {
    result.reason = OdometryReason::repeated_frame;
    result.detail = fmt::format("mean intensity differs by {:.2f} from the previous image", result.difference);
    return result;
  }
  result.sharpness = sharpness(image);
  if (result.sharpness < options_.min_sharpness) {
    result.reason = OdometryReason::blurred;
    result.detail =
        fmt::format("gradient {:.2f} times the median, need {:.2f}", result.sharpness, options_.min_sharpness);
  } else if (options_.max_step_ratio > 0.0 && result.step_ratio > options_.max_step_ratio) {
    result.reason = OdometryReason::gap;
    result.detail =
        fmt::format("step {:.1f} times the median, at most {:.1f}", result.step_ratio, options_.max_step_ratio);
  }
  return result;
}

void FrameCheck::forget_last() {
  last_stamp_.reset();
  last_.clear();
}

void FrameCheck::check_size(GrayView image) {
  if (image.empty()) return;
  if (width_ == 0) {
    width_ = image.width;
    height_ = image.height;
  }
  if (image.width != width_ || image.height != height_) {
    throw Error(
        fmt::format("image of {} x {} pixels after images of {} x {}", image.width, image.height, width_, height_),
        "odometry", "give images of one size");
  }
}

double FrameCheck::step_ratio(TimeNs step) { return ratio_to_median(steps_, to_seconds(step), options_.memory); }

double FrameCheck::difference_to_last(GrayView image) {
  current_.clear();
  for (int y = 0; y < image.height; y += row_step) {
    const std::uint8_t* row = image.row(y);
    for (int x = 0; x < image.width; x += row_step) current_.push_back(row[x]);
  }
  double difference = -1.0;
  if (last_.size() == current_.size()) {
    difference =
        static_cast<double>(sum_of_differences(last_.data(), current_.data(), static_cast<int>(last_.size()))) /
        static_cast<double>(last_.size());
  }
  last_.swap(current_);
  return difference;
}

double FrameCheck::sharpness(GrayView image) {
  if (image.width <= gradient_reach || image.height <= gradient_reach) return 1.0;
  std::int64_t across = 0, upright = 0;
  int rows = 0;
  for (int y = 0; y + gradient_reach < image.height; y += row_step, ++rows) {
    const std::uint8_t* row = image.row(y);
    across += sum_of_differences(row, row + gradient_reach, image.width - gradient_reach);
    upright += sum_of_differences(row, image.row(y + gradient_reach), image.width);
  }
  const double ratio_across = ratio_to_median(across_, static_cast<double>(across) / rows, options_.memory);
  const double ratio_upright = ratio_to_median(upright_, static_cast<double>(upright) / rows, options_.memory);
  return std::min(ratio_across, ratio_upright);
}

}  // namespace rastro
