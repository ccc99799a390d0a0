// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/stereo_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/feature/descriptor_matching.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr OrbOptions few_features{.features = 500, .levels = 3};
constexpr int least_matches = 50;
constexpr double clear_disparity_px = 2.0, vertical_tolerance_px = 4.0;
constexpr std::size_t least_samples = 3, least_timed_samples = 4;
// Swapped: most of the clear disparities are negative, and these are not the false matches of a distant scene.
constexpr double most_positive = 0.2, least_negative = 0.3;
// Of another time: the vertical disparities are large, and much smaller against the frame before or after.
constexpr double least_untimed_px = 1.0, timed_share = 0.5, least_untimed_samples = 0.6;
constexpr double most_vertical_px = 3.0, least_unrectified_samples = 0.8;
constexpr double shortest_baseline_m = 0.002, longest_baseline_m = 1.0;

/// Orientation of both rectified cameras in the left one: x along the baseline, z between both viewing directions.
SO3 rectified_axes(const SE3& left_from_right) {
  const Eigen::Vector3d x = left_from_right.translation().normalized();
  const Eigen::Vector3d forward =
      Eigen::Vector3d::UnitZ() + left_from_right.rotation().matrix() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = forward.cross(x).normalized();
  Eigen::Matrix3d axes;
  axes << x, y, x.cross(y);
  return SO3::from_matrix(axes);
}

bool is_side_by_side(const SE3& left_from_right) {
  const Eigen::Vector3d& aside = left_from_right.translation();
  return aside.norm() > 0.0 && aside.x() > 0.8 * aside.norm();
}

}  // namespace

StereoCheck::StereoCheck(const SourceInfo& info) : schedule_(1, 3.0, 1.2, 100.0), extractor_(few_features) {
  if (!info.has_right || !info.left_from_right || info.cameras.size() < 2 || !info.cameras[0].camera ||
      !info.cameras[1].camera || !is_side_by_side(*info.left_from_right))
    return;
  left_ = info.cameras[0].camera;
  right_ = info.cameras[1].camera;
  baseline_m_ = info.left_from_right->translation().norm();
  left_from_rectified_ = rectified_axes(*info.left_from_right);
  right_from_rectified_ = info.left_from_right->rotation().inverse() * left_from_rectified_;
}

void StereoCheck::add(const Frame& frame, InputWarnings& found) {
  if (!left_ || frame.image.empty() || frame.right.empty()) return;
  if (!baseline_judged_) judge_baseline(found);
  const std::int64_t number = number_++;
  const bool due = schedule_.is_due(number), before = schedule_.is_due(number + 1);
  if (said_ || (!due && !before)) return;
  Pair pair{view_of(frame.image, *left_, left_from_rectified_), view_of(frame.right, *right_, right_from_rectified_)};
  if (due && last_) {
    schedule_.taken(number);
    const Sample sample{compare(pair.left, pair.right), compare(last_->left, pair.right),
                        compare(pair.left, last_->right)};
    if (sample.same.matches >= least_matches) samples_.push_back(sample);
    judge(found);
  }
  last_ = std::move(pair);
}

StereoCheck::View StereoCheck::view_of(const GrayImage& image, const Camera& camera, const SO3& camera_from_rectified) {
  View view{extractor_.extract(image), {}};
  const SO3 rectified_from_camera = camera_from_rectified.inverse();
  for (const Keypoint& keypoint : view.features.keypoints) {
    const auto ray = camera.unproject({static_cast<double>(keypoint.x), static_cast<double>(keypoint.y)});
    const Eigen::Vector3d direction =
        ray ? Eigen::Vector3d(rectified_from_camera * Eigen::Vector3d(ray->x(), ray->y(), 1.0))
            : Eigen::Vector3d::Zero();
    const bool ahead = direction.z() > 0.1;
    view.rectified.push_back(ahead ? Eigen::Vector2d(left_->fx * direction.head<2>() / direction.z())
                                   : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return view;
}

StereoCheck::Comparison StereoCheck::compare(const View& left, const View& right) {
  std::vector<Eigen::Vector2d> disparities;
  std::vector<double> vertical, sizes;
  for (const DescriptorMatch& match : match_descriptors(left.features, right.features, {.max_ratio = 0.8})) {
    const Eigen::Vector2d disparity = left.rectified[match.first] - right.rectified[match.second];
    if (!disparity.allFinite()) continue;
    disparities.push_back(disparity);
    vertical.push_back(disparity.y());
    sizes.push_back(std::abs(disparity.y()));
  }
  Comparison result;
  result.matches = static_cast<int>(disparities.size());
  if (disparities.empty()) return result;
  result.shift_px = median(vertical);
  result.vertical_px = median(sizes);
  for (const Eigen::Vector2d& disparity : disparities) {
    if (std::abs(disparity.y() - result.shift_px) > vertical_tolerance_px) continue;
    result.positive += disparity.x() > clear_disparity_px ? 1 : 0;
    result.negative += disparity.x() < -clear_disparity_px ? 1 : 0;
  }
  return result;
}

void StereoCheck::judge(InputWarnings& found) {
  if (samples_.size() < least_samples) return;
  said_ = judge_order(found);
  if (said_ || samples_.size() < least_timed_samples) return;
  said_ = judge_time(found);
  if (!said_) judge_rectification(found);
}

bool StereoCheck::judge_order(InputWarnings& found) {
  int matches = 0, positive = 0, negative = 0;
  std::size_t clear = 0;
  for (const Sample& sample : samples_) {
    const Comparison& same = sample.same;
    matches += same.matches, positive += same.positive, negative += same.negative;
    clear += same.negative >= least_negative * same.matches && same.positive <= most_positive * same.negative ? 1 : 0;
  }
  if (negative < least_negative * matches || positive > most_positive * negative || 3 * clear < 2 * samples_.size())
    return false;
  found.push_back({"stereo_swapped",
                   fmt::format("the right image seems to be the left one: {:.0f} % of the {} matches with a clear "
                               "disparity have a negative one; swap the images, or check the calibration of the pair",
                               100.0 * negative / (negative + positive), negative + positive)});
  return true;
}

bool StereoCheck::judge_time(InputWarnings& found) {
  std::vector<double> together, late, early;
  std::size_t is_late = 0, is_early = 0;
  for (const Sample& sample : samples_) {
    const double now = sample.same.vertical_px;
    together.push_back(now);
    late.push_back(sample.right_late.vertical_px);
    early.push_back(sample.right_early.vertical_px);
    if (now < least_untimed_px) continue;
    is_late += sample.right_late.matches >= least_matches && late.back() < timed_share * now ? 1 : 0;
    is_early += sample.right_early.matches >= least_matches && early.back() < timed_share * now ? 1 : 0;
  }
  const std::size_t wrong = std::max(is_late, is_early);
  if (wrong < least_samples ||
      static_cast<double>(wrong) < least_untimed_samples * static_cast<double>(samples_.size()))
    return false;
  const bool lags = is_late >= is_early;
  found.push_back(
      {"stereo_unsynchronized",
       fmt::format("the right image seems to be of {} moment: vertical disparities of {:.1f} px (median) "
                   "fall to {:.1f} px against the {} left image; check the stamps or the trigger of the pair",
                   lags ? "an earlier" : "a later", median(together), median(lags ? late : early),
                   lags ? "previous" : "next")});
  return true;
}

void StereoCheck::judge_rectification(InputWarnings& found) {
  std::vector<double> sizes;
  std::size_t off = 0;
  for (const Sample& sample : samples_) {
    sizes.push_back(sample.same.vertical_px);
    off += sample.same.vertical_px > most_vertical_px ? 1 : 0;
  }
  if (static_cast<double>(off) < least_unrectified_samples * static_cast<double>(samples_.size())) return;
  said_ = true;
  found.push_back(
      {"stereo_not_rectified",
       fmt::format("matches between the images of a pair miss the calibration's epipolar lines by {:.1f} px "
                   "(median over {} pairs): check the order of the images, intrinsics and pose of the "
                   "cameras, whether the images are rectified, and whether both are of the same moment",
                   median(sizes), samples_.size())});
}

void StereoCheck::judge_baseline(InputWarnings& found) {
  baseline_judged_ = true;
  if (baseline_m_ >= shortest_baseline_m && baseline_m_ <= longest_baseline_m) return;
  found.push_back(
      {"baseline",
       fmt::format("the baseline is {:.4g} m, and stereo cameras have {:g} to {:g} m: all lengths scale with "
                   "it; check the unit of the calibration",
                   baseline_m_, shortest_baseline_m, longest_baseline_m)});
}

}  // namespace rastro
