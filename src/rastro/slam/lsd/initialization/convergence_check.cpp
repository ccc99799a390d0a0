// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/initialization/convergence_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr std::size_t fewest_depths = 100;
constexpr double converged = 0.1;

GrayImage copy_of(GrayView view) {
  GrayImage image(view.width, view.height);
  for (int y = 0; y < view.height; ++y) std::copy_n(view.row(y), view.width, image.row(y));
  return image;
}

}  // namespace

ConvergenceCheck::ConvergenceCheck(const TwoViewStartOptions& options, const Camera& camera, TaskPool* pool)
    : camera_(camera), two_views_(options, camera, pool) {}

void ConvergenceCheck::forget_views() {
  two_views_.reset();
  compared_.reset();
}

void ConvergenceCheck::begin(std::int64_t keyframe) {
  interrupt();
  doubtful_.push_back({keyframe, keyframe + 1});
  is_open_ = true;
  difference_ = 0.0;
}

void ConvergenceCheck::interrupt() {
  forget_views();
  last_stamp_ = 0;
  agreed_.reset();
}

bool ConvergenceCheck::is_doubtful(std::int64_t keyframe) const {
  return std::any_of(doubtful_.begin(), doubtful_.end(),
                     [&](const Doubtful& depths) { return keyframe >= depths.first && keyframe < depths.end; });
}

/// Of the depths that began at random last. A return to earlier ones ends these: new keyframes follow from those.
bool ConvergenceCheck::is_followed(const CurrentKeyframe& keyframe) {
  if (!is_open_) return false;
  is_open_ = keyframe.id() >= doubtful_.back().first;
  if (!is_open_) return false;
  doubtful_.back().end = std::max(doubtful_.back().end, keyframe.id() + 1);
  return true;
}

void ConvergenceCheck::begin_with(const CurrentKeyframe& keyframe, TimeNs stamp) {
  forget_views();
  compared_ = keyframe;
  two_views_.take(0, stamp, copy_of(keyframe.pyramid().level(0).view()));
}

bool ConvergenceCheck::take(const LsdFrame& frame, const CurrentKeyframe& keyframe) {
  constexpr TimeNs about_a_frame = 33'000'000;
  const TimeNs before = last_stamp_ > 0 ? last_stamp_ : frame.stamp - about_a_frame;
  if (!is_followed(keyframe)) return false;
  last_stamp_ = frame.stamp;
  if (!compared_ && agreed_ == keyframe.id()) return false;  // the same depths say nothing new
  if (!compared_) begin_with(keyframe, before);
  if (keyframe.id() == compared_->id()) compared_ = keyframe;  // with better depths
  const std::size_t views = two_views_.frames().size();
  const auto found = two_views_.take(frame.index, frame.stamp, frame.image, frame.mask);
  const bool is_forgotten = two_views_.frames().size() == views;  // the oldest view, that of the keyframe
  if (!found && !is_forgotten) return false;
  const bool has_converged = found && found->first == 0 && !is_forgotten && compare(found->depth);
  forget_views();
  return has_converged;
}

bool ConvergenceCheck::compare(const InverseDepthMap& two_views) {
  const AlignmentPoints& points = compared_->reference().level(0);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
    const auto x = static_cast<int>(std::lround(static_cast<double>(points.x[i]) * camera_.fx + camera_.cx));
    const auto y = static_cast<int>(std::lround(static_cast<double>(points.y[i]) * camera_.fy + camera_.cy));
    if (x < 0 || y < 0 || x >= two_views.width() || y >= two_views.height() || !two_views.is_known(x, y)) continue;
    ratios.push_back(static_cast<double>(two_views.mean.at(x, y) / points.inverse_depth[i]));
  }
  if (ratios.size() < fewest_depths) return false;
  const double unit = median(ratios);
  for (double& ratio : ratios) ratio = std::abs(ratio / unit - 1.0);
  difference_ = median(ratios);
  const std::int64_t keyframe = compared_->id();
  if (difference_ > converged) return agreed_.reset(), false;
  if (!agreed_) return agreed_ = keyframe, false;
  doubtful_.back().end = std::min(*agreed_, keyframe);
  is_open_ = false;
  return true;
}

}  // namespace rastro
