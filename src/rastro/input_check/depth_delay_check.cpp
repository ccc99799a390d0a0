// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/depth_delay_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/input_check/sample_schedule.h"

namespace rastro {
namespace {

constexpr int least_pairs = 40, judged_every = 10;
constexpr double least_correlation = 0.75;
// Without the delay: where motion is that smooth, a delay changes little, and chance moves the highest correlation.
constexpr double most_correlation = 0.85;
constexpr double most_delay_s = 0.45;
constexpr double least_gain = 1.6;  // What the shifts leave unexplained without the delay, of that with it.

}  // namespace

void DepthDelayCheck::Correlation::add(const Eigen::Vector2d& image_shift, const Eigen::Vector2d& depth_shift) {
  ++pairs;
  image += image_shift;
  depth += depth_shift;
  image_square += image_shift.squaredNorm();
  depth_square += depth_shift.squaredNorm();
  product += image_shift.dot(depth_shift);
}

double DepthDelayCheck::Correlation::value() const {
  const double n = std::max(1, pairs);
  const double a = image_square - image.squaredNorm() / n, b = depth_square - depth.squaredNorm() / n;
  return a > 0.0 && b > 0.0 ? (product - image.dot(depth) / n) / std::sqrt(a * b) : 0.0;
}

void DepthDelayCheck::add(const Frame& frame, InputWarnings& found) {
  const std::int64_t number = frames_++;
  if (said_ || frame.depth.empty() || frame.image.empty()) return;
  if (!is_in_burst(number)) {
    recent_.clear();
    return;
  }
  Motion now{frame.stamp, thumbnail_of(frame.image), thumbnail_of(frame.depth), {}, {}};
  if (!recent_.empty()) {
    now.image_shift = shift_between(recent_.back().image, now.image);
    now.depth_shift = shift_between(recent_.back().depth, now.depth);
    frame_s_ = to_seconds(now.stamp - recent_.front().stamp) / static_cast<double>(recent_.size());
  }
  recent_.push_back(std::move(now));
  if (recent_.size() > most_lag + 1) recent_.pop_front();
  const Motion& last = recent_.back();
  for (std::size_t k = 0; k < recent_.size(); ++k) {
    const auto lag = recent_.size() - 1 - k;
    if (!recent_[k].image_shift || !last.image_shift) continue;
    by_lag_[most_lag + lag].add(*recent_[k].image_shift, *last.depth_shift);
    if (lag > 0) by_lag_[most_lag - lag].add(*last.image_shift, *recent_[k].depth_shift);
  }
  if (frames_ % judged_every == 0) judge(found);
}

void DepthDelayCheck::judge(InputWarnings& found) {
  const auto best = std::max_element(by_lag_.begin(), by_lag_.end(),
                                     [](const Correlation& a, const Correlation& b) { return a.value() < b.value(); });
  const int lag = static_cast<int>(best - by_lag_.begin()) - most_lag;
  const double delayed = best->value(), together = by_lag_[most_lag].value();
  if (std::abs(lag) < 2 || std::abs(lag) == most_lag || best->pairs < least_pairs || delayed < least_correlation ||
      together > most_correlation || std::abs(lag) * frame_s_ > most_delay_s ||
      1.0 - together * std::abs(together) < least_gain * (1.0 - delayed * delayed))
    return;
  said_ = true;
  found.push_back(
      {"depth_late",
       fmt::format("the depth seems to be {:.2f} s {} than the image: their motions correlate by {:.2f}, and "
                   "by {:.2f} if it is of {} frames {} ({} frames); check the stamps",
                   std::abs(lag) * frame_s_, lag > 0 ? "later" : "earlier", together, delayed, std::abs(lag),
                   lag > 0 ? "before" : "after", best->pairs)});
}

}  // namespace rastro
