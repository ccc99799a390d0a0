// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/constraint_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <cstdlib>

#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/pose_uncertainty.h"
#include "rastro/slam/lsd/tracking/view_correlation.h"

namespace rastro {
namespace {

/// Translation in mean distances, rotation and the logarithm of the scale, the largest.
double deviation(const Sim3& found, const Sim3& expected, double mean_inverse_depth) {
  const Vector7d moved = (found * expected.inverse()).log();
  return std::max({moved.head<3>().norm() * mean_inverse_depth, moved.segment<3>(3).norm(), std::abs(moved(6))});
}

bool is_in(const std::vector<std::int64_t>& sorted, std::int64_t id) {
  return std::binary_search(sorted.begin(), sorted.end(), id);
}

}  // namespace

std::vector<Constraint> ConstraintSearch::find(std::int64_t id, const BagOfWords& words) {
  const std::vector<std::int64_t> recent = graph_.within_steps(id, consecutive);
  std::vector<Candidate> candidates = near(id, [&](std::int64_t other) { return is_in(recent, other); });
  // Apart, or the recent ones, always nearest, would leave no room for them.
  const std::vector<Candidate> earlier = revisited(id, recent);
  candidates.insert(candidates.end(), earlier.begin(), earlier.end());
  const auto is_elsewhere = [&](std::int64_t other) {
    return !is_in(recent, other) && std::none_of(candidates.begin(), candidates.end(),
                                                 [&](const Candidate& known) { return known.id == other; });
  };
  // Where drift or another submap says nothing of the relative pose, what looks alike is seen from nearby.
  const std::vector<std::int64_t> alike = graph_.similar(words, options_.similar_keyframes, is_elsewhere);
  for (const std::int64_t other : alike) candidates.push_back({other, Sim3(), kind_beyond(other, id)});
  return align_all(candidates, id);
}

std::vector<Constraint> ConstraintSearch::find_revisited(std::int64_t id) {
  std::vector<Candidate> candidates = revisited(id, graph_.within_steps(id, consecutive));
  for (Candidate& candidate : candidates) candidate.is_predicted = false;
  return align_all(candidates, id);
}

std::vector<ConstraintSearch::Candidate> ConstraintSearch::revisited(std::int64_t id,
                                                                     const std::vector<std::int64_t>& recent) const {
  std::vector<Candidate> candidates = near(id, [&](std::int64_t other) { return other < id && !is_in(recent, other); });
  for (Candidate& candidate : candidates) candidate.kind = kind_beyond(candidate.id, id);
  return candidates;
}

std::vector<ConstraintSearch::Candidate> ConstraintSearch::near(
    std::int64_t id, const std::function<bool(std::int64_t)>& is_wanted) const {
  std::vector<Candidate> candidates;
  for (const std::int64_t other : graph_.near(id, options_.near_keyframes, is_wanted))
    candidates.push_back({other, graph_.pose(other).inverse() * graph_.pose(id), ConstraintKind::proximity, true});
  return candidates;
}

/// In the order of the candidates, for any number of threads.
std::vector<Constraint> ConstraintSearch::align_all(const std::vector<Candidate>& candidates, std::int64_t id) {
  std::vector<std::optional<Constraint>> aligned(candidates.size());
  const auto align_some = [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      aligned[i] = align(candidates[i], id);
  };
  const auto count = static_cast<int>(candidates.size());
  if (count > 0) prepared(id);  // once, for all
  pool_ ? pool_->for_chunks(0, count, 1, align_some) : align_some(0, count);
  std::vector<Constraint> found;
  for (const auto& edge : aligned)
    if (edge) found.push_back(*edge);
  return found;
}

std::shared_ptr<const ConstraintSearch::Prepared> ConstraintSearch::prepared(std::int64_t id) {
  if (auto recent = recent_.find(id)) return recent;
  const SemiDenseKeyframe& keyframe = graph_.keyframe(id);
  Prepared made;
  made.pyramid = target_pyramid(keyframe.image, keyframe.mask, options_.levels, nullptr);
  AlignmentReferenceOptions options;
  options.levels = options_.levels;
  options.max_points = options_.max_points;
  made.reference.build(made.pyramid, keyframe.depth, sensor_.camera, options);
  return recent_.add(id, std::move(made));
}

/// Constraint::from_from_to is other_from_id.
std::optional<Constraint> ConstraintSearch::align(const Candidate& candidate, std::int64_t id) {
  const std::int64_t other = candidate.id;
  const auto of_other = prepared(other), of_id = prepared(id);
  const SimilarityAlignment forward = align_to(*of_other, *of_id, candidate.other_from_id);
  const Limits limits = limits_for(candidate, forward.b_from_a);
  if (!fits(forward, limits.inlier_share) || !shows_the_same(*of_other, *of_id, forward.b_from_a)) return std::nullopt;
  const SimilarityAlignment backward = align_to(*of_id, *of_other, forward.b_from_a.inverse());
  if (!fits(backward, limits.inlier_share)) return std::nullopt;
  const auto error = reciprocal_error(forward, backward);
  if (!error || *error > limits.reciprocal_error) return std::nullopt;
  const Matrix7d covariance = forward.information.inverse();
  Matrix6d of_motion = covariance.topLeftCorner<6, 6>();
  of_motion += common_covariance(graph_.keyframe(id).mean_inverse_depth);
  Constraint edge{other, id, forward.b_from_a, of_motion.inverse(), candidate.kind};
  edge.information = (0.5 * (edge.information + edge.information.transpose())).eval();
  edge.inliers = forward.points;
  edge.scale_variance = depths_alike_of_one_camera * covariance(6, 6);
  return edge;
}

SimilarityAlignment ConstraintSearch::align_to(const Prepared& b, const Prepared& a, const Sim3& b_from_a) const {
  SimilarityAlignmentOptions options;
  options.coarsest_level = options_.levels - 1;
  options.min_overlap = options_.min_constraint_overlap;
  options.noise.intensity_sigma = options_.intensity_sigma;
  options.fix_scale = sensor_.is_metric();
  return align_similarity(a.reference, {b.pyramid, b.reference.depth()}, b_from_a, options);
}

bool ConstraintSearch::shows_the_same(const Prepared& b, const Prepared& a, const Sim3& b_from_a) const {
  SimilarityAlignmentOptions alignment;
  alignment.noise.intensity_sigma = options_.intensity_sigma;
  const ImageAlignmentOptions tracking;
  const int level = std::min(alignment.finest_level, options_.levels - 1);
  const SE3 in_unit_of_a(b_from_a.rotation(), b_from_a.translation() / b_from_a.scale());
  return correlated_share(a.reference.level(level), b.pyramid.level(level), in_unit_of_a, alignment.noise,
                          tracking.min_correlation) >= options_.trusted_alike;
}

/// Another house with windows like these lets most pixels fit too, but not nearly all. What is found where the map has
/// it already is no other house: both alignments may differ by twice as much, as they do where one view is much nearer.
ConstraintSearch::Limits ConstraintSearch::limits_for(const Candidate& candidate, const Sim3& found) const {
  constexpr double as_predicted = 0.05, confirmed_error = 4.0;
  if (candidate.kind == ConstraintKind::proximity) return {0.0, options_.max_reciprocal_error};
  const double mean_inverse_depth = graph_.keyframe(candidate.id).mean_inverse_depth;
  const bool is_confirmed =
      candidate.is_predicted && deviation(found, candidate.other_from_id, mean_inverse_depth) < as_predicted;
  return is_confirmed ? Limits{0.0, confirmed_error * options_.max_reciprocal_error}
                      : Limits{options_.loop_share, options_.max_reciprocal_error};
}

bool ConstraintSearch::fits(const SimilarityAlignment& alignment, double least_share) {
  return alignment.ok() && alignment.inlier_share >= least_share && alignment.information.determinant() > 0.0;
}

/// Of one that is not among the recent ones.
ConstraintKind ConstraintSearch::kind_beyond(std::int64_t other, std::int64_t id) const {
  return graph_.submap(other) != graph_.submap(id) ? ConstraintKind::merge : ConstraintKind::loop;
}

}  // namespace rastro
