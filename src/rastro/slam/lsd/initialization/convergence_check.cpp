// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/initialization/convergence_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace rastro {
namespace {

constexpr std::size_t fewest_depths = 100;
constexpr double converged = 0.1;

GrayImage copy_of(GrayView view) {
  GrayImage image(view.width, view.height);
  for (int y = 0; y < view.height; ++y) std::copy_n(view.row(y), view.width, image.row(y));
  return image;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

ConvergenceCheck::ConvergenceCheck(const TwoViewStartOptions& options, const Camera& camera, TaskPool* pool)
    : camera_(camera), two_views_(options, camera, pool) {}

void ConvergenceCheck::forget_views() {
  two_views_.reset();
  compared_.reset();
}

void ConvergenceCheck::reset() {
  forget_views();
  last_stamp_ = 0;
  agreements_ = 0;
}

void ConvergenceCheck::begin_with(const CurrentKeyframe& keyframe, TimeNs stamp) {
  forget_views();
  compared_ = keyframe;
  two_views_.take(0, stamp, copy_of(keyframe.pyramid().level(0).view()));
}

void ConvergenceCheck::take(const LsdFrame& frame, const CurrentKeyframe& keyframe) {
  constexpr TimeNs about_a_frame = 33'000'000;
  if (!compared_) begin_with(keyframe, last_stamp_ > 0 ? last_stamp_ : frame.stamp - about_a_frame);
  if (keyframe.id() == compared_->id()) compared_ = keyframe;  // with better depths
  last_stamp_ = frame.stamp;
  const std::size_t before = two_views_.frames().size();
  const auto found = two_views_.take(frame.index, frame.stamp, frame.image, frame.mask);
  const bool is_forgotten = two_views_.frames().size() == before;  // the oldest view, that of the keyframe
  if (!found && !is_forgotten) return;
  if (found && found->first == 0 && !is_forgotten) compare(found->depth);
  forget_views();
}

void ConvergenceCheck::compare(const InverseDepthMap& two_views) {
  const AlignmentPoints& points = compared_->reference().level(0);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
    const auto x = static_cast<int>(std::lround(static_cast<double>(points.x[i]) * camera_.fx + camera_.cx));
    const auto y = static_cast<int>(std::lround(static_cast<double>(points.y[i]) * camera_.fy + camera_.cy));
    if (x < 0 || y < 0 || x >= two_views.width() || y >= two_views.height() || !two_views.is_known(x, y)) continue;
    ratios.push_back(static_cast<double>(two_views.mean.at(x, y) / points.inverse_depth[i]));
  }
  if (ratios.size() < fewest_depths) return;
  const double unit = median(ratios);
  for (double& ratio : ratios) ratio = std::abs(ratio / unit - 1.0);
  difference_ = median(ratios);
  agreements_ = difference_ <= converged ? agreements_ + 1 : 0;
}

}  // namespace rastro
