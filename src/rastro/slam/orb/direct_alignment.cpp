// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/direct_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <utility>

namespace rastro {
namespace {

Vector6d difference(const RelativePose& a, const RelativePose& b) {
  return (b.camera_from_keyframe * a.camera_from_keyframe.inverse()).log();
}

}  // namespace

double contradiction(const RelativePose& a, const RelativePose& b) {
  const Vector6d off = difference(a, b);
  return off.dot((a.covariance + b.covariance).ldlt().solve(off)) / 6.0;
}

RelativePose fused(const RelativePose& a, const RelativePose& b) {
  const Matrix6d gain = a.covariance * (a.covariance + b.covariance).inverse();
  RelativePose mean{SE3::exp(gain * difference(a, b)) * a.camera_from_keyframe, a.covariance - gain * a.covariance};
  mean.covariance = 0.5 * std::max(1.0, contradiction(a, b)) * (mean.covariance + mean.covariance.transpose()).eval();
  return mean;
}

void DirectKeyframes::add(std::int64_t id, std::shared_ptr<const DirectView> keyframe) {
  if (!keyframe) return;
  keyframes_[id] = std::move(keyframe);
  if (keyframes_.size() > most_) keyframes_.erase(keyframes_.begin());
}

const DirectView* DirectKeyframes::find(std::int64_t id) const {
  const auto at = keyframes_.find(id);
  return at == keyframes_.end() ? nullptr : at->second.get();
}

std::size_t DirectKeyframes::bytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, keyframe] : keyframes_) bytes += keyframe->bytes();
  return bytes;
}

}  // namespace rastro
