// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/pose_search.h"

#include <algorithm>
#include <utility>

#include "rastro/slam/lsd/tracking/rotation_search.h"

namespace rastro {
namespace {

bool is_better(const JudgedAlignment& a, const JudgedAlignment& b) {
  if (a.verdict.grade != b.verdict.grade) return a.verdict.grade > b.verdict.grade;
  return a.alignment.inlier_share > b.alignment.inlier_share;
}

/// On coarser levels a crowd that fills much of the view takes the pose along.
constexpr int fine_level = 1;

/// To the last bit: an alignment that starts there ends at the same pose.
bool is_same(const SE3& a, const SE3& b) {
  return a.translation() == b.translation() && a.rotation().quaternion().coeffs() == b.rotation().quaternion().coeffs();
}

/// Of the two cameras' positions.
double distance_between(const SE3& a_from_keyframe, const SE3& b_from_keyframe) {
  return (a_from_keyframe.inverse().translation() - b_from_keyframe.inverse().translation()).norm();
}

}  // namespace

/// The finest level that is not wider than this: a shift by one of its pixels is about a degree or two. All shifts of
/// 128 x 96 pixels take 0.2 s, and sixteen times as long for twice the width.
PoseSearch::SmallImage PoseSearch::small_of(const Pyramid& image) {
  constexpr int most = 48, most_where_levels_end = 128, least_height = 16;
  int level = 0;
  while (level + 1 < image.levels() && image.level(level).width() > most) ++level;
  SmallImage small{image.level(level), level};
  while (small.image.width() > most_where_levels_end && small.image.height() >= least_height) {
    PaddedImage halved;
    halve(small.image, halved);
    small = {std::move(halved), small.level + 1};
  }
  return small;
}

SE3 PoseSearch::rotation_between(const SmallImage& a, const SmallImage& b) const {
  const RotationGuess found = find_rotation(a.image.view(), b.image.view(), LevelCamera(camera_, b.level));
  return {found.b_from_a, Eigen::Vector3d::Zero()};
}

JudgedAlignment PoseSearch::aligned_from(const SE3& guess, int coarsest_level, const CurrentKeyframe& keyframe,
                                         const Pyramid& image, const ExpectedMotion& expected) const {
  const double inverse_depth = keyframe.mean_inverse_depth();
  JudgedAlignment tried;
  tried.alignment = keyframe.track(image, guess, coarsest_level);
  const SE3& found = tried.alignment.image_from_reference;
  tried.jump_deg = std::min(view_change_deg(found * expected.camera_from_keyframe.inverse(), inverse_depth),
                            view_change_deg(found * expected.going_on().inverse(), inverse_depth)) /
                   (1.0 + expected.missed);
  tried.verdict = judge_pose(tried.alignment, inverse_depth, tried.jump_deg, options_);
  return tried;
}

JudgedAlignment PoseSearch::track(const CurrentKeyframe& keyframe, const Pyramid& image,
                                  const ExpectedMotion& expected) const {
  const SE3 &still = expected.camera_from_keyframe, going_on = expected.going_on();
  const int coarsest = options_.levels - 1;
  JudgedAlignment best = aligned_from(going_on, coarsest, keyframe, image, expected);
  const auto is_doubtful = [&] { return best.verdict.grade != PoseGrade::tracking; };
  const auto improve_from = [&](const SE3& guess, int coarsest_level) {
    const JudgedAlignment other = aligned_from(guess, coarsest_level, keyframe, image, expected);
    if (is_better(other, best)) best = other;
  };
  if (is_doubtful() && !is_same(still, going_on)) improve_from(still, coarsest);
  if (is_doubtful() && last_) {
    const SE3 rotated = rotation_between(*last_, small_of(image)) * still;
    if (!is_same(rotated, going_on) && !is_same(rotated, still)) improve_from(rotated, coarsest);
  }
  if (is_doubtful() || distance_between(best.alignment.image_from_reference, going_on) > expected.max_step)
    improve_from(going_on, fine_level);
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
