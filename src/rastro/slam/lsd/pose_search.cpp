// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/pose_search.h"

#include <algorithm>
#include <vector>

#include "rastro/slam/lsd/tracking/rotation_search.h"

namespace rastro {
namespace {

bool is_better(const JudgedAlignment& a, const JudgedAlignment& b) {
  if (a.verdict.grade != b.verdict.grade) return a.verdict.grade > b.verdict.grade;
  return a.alignment.inlier_share > b.alignment.inlier_share;
}

/// To the last bit: an alignment that starts there ends at the same pose.
bool is_same(const SE3& a, const SE3& b) {
  return a.translation() == b.translation() && a.rotation().quaternion().coeffs() == b.rotation().quaternion().coeffs();
}

}  // namespace

/// The finest level that is not wider than this: a shift by one of its pixels is about a degree or two.
PoseSearch::SmallImage PoseSearch::small_of(const Pyramid& image) {
  constexpr int most = 48;
  int level = 0;
  while (level + 1 < image.levels() && image.level(level).width() > most) ++level;
  return {image.level(level), level};
}

SE3 PoseSearch::rotation_between(const SmallImage& a, const SmallImage& b) const {
  const RotationGuess found = find_rotation(a.image.view(), b.image.view(), LevelCamera(camera_, b.level));
  return {found.b_from_a, Eigen::Vector3d::Zero()};
}

JudgedAlignment PoseSearch::track(const CurrentKeyframe& keyframe, const Pyramid& image,
                                  const ExpectedMotion& expected) const {
  const double inverse_depth = keyframe.mean_inverse_depth();
  const SE3 &still = expected.camera_from_keyframe, going_on = expected.velocity * still;
  const auto try_from = [&](const SE3& guess) {
    JudgedAlignment tried;
    tried.alignment = keyframe.track(image, guess);
    const SE3& found = tried.alignment.image_from_reference;
    tried.jump_deg = std::min(view_change_deg(found * still.inverse(), inverse_depth),
                              view_change_deg(found * going_on.inverse(), inverse_depth)) /
                     (1.0 + expected.missed);
    tried.verdict = judge_pose(tried.alignment, inverse_depth, tried.jump_deg, options_);
    return tried;
  };
  JudgedAlignment best = try_from(going_on);
  std::vector<SE3> tried{going_on};
  const auto improve_from = [&](const SE3& guess) {
    if (std::any_of(tried.begin(), tried.end(), [&](const SE3& other) { return is_same(other, guess); })) return;
    tried.push_back(guess);
    const JudgedAlignment other = try_from(guess);
    if (is_better(other, best)) best = other;
  };
  if (best.verdict.grade != PoseGrade::tracking) improve_from(still);
  if (best.verdict.grade != PoseGrade::tracking && last_)
    improve_from(rotation_between(*last_, small_of(image)) * still);
  return best;
}

JudgedAlignment PoseSearch::find(const CurrentKeyframe& keyframe, const Pyramid& image) const {
  const auto try_from = [&](const SE3& guess) {
    JudgedAlignment tried{keyframe.track(image, guess), {}, 0.0};
    tried.verdict = judge_pose(tried.alignment, keyframe.mean_inverse_depth(), 0.0, options_);
    return tried;
  };
  JudgedAlignment best = try_from(SE3());
  if (best.verdict.grade == PoseGrade::tracking) return best;
  const SE3 rotation = rotation_between(small_of(keyframe.pyramid()), small_of(image));
  if (is_same(rotation, SE3())) return best;
  const JudgedAlignment rotated = try_from(rotation);
  return is_better(rotated, best) ? rotated : best;
}

}  // namespace rastro
