// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/constraint_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <cstdlib>

#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/tracking/view_correlation.h"

namespace rastro {
namespace {

constexpr std::int64_t consecutive = 10;  // keyframes between which nothing has drifted much

}  // namespace

std::vector<Constraint> ConstraintSearch::find(std::int64_t id, const BagOfWords& words) {
  std::vector<Candidate> candidates;
  const auto is_earlier = [id](std::int64_t other) { return other < id; };
  std::vector<std::int64_t> near = graph_.near(id, options_.near_keyframes, is_earlier);
  for (const std::int64_t other : near) candidates.push_back({other, graph_.pose(other).inverse() * graph_.pose(id)});
  const auto is_elsewhere = [&](std::int64_t other) {
    return std::abs(other - id) > consecutive && std::find(near.begin(), near.end(), other) == near.end();
  };
  // Where drift or another submap says nothing of the relative pose, what looks alike is seen from nearby.
  for (const std::int64_t other : graph_.similar(words, options_.similar_keyframes, is_elsewhere))
    candidates.push_back({other, Sim3()});
  return align_all(candidates, id);
}

/// In the order of the candidates, for any number of threads.
std::vector<Constraint> ConstraintSearch::align_all(const std::vector<Candidate>& candidates, std::int64_t id) {
  std::vector<std::optional<Constraint>> aligned(candidates.size());
  const auto align_some = [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      aligned[i] = align(candidates[i].id, id, candidates[i].other_from_id);
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
std::optional<Constraint> ConstraintSearch::align(std::int64_t other, std::int64_t id, const Sim3& other_from_id) {
  const ConstraintKind kind = kind_between(other, id);
  const auto of_other = prepared(other), of_id = prepared(id);
  const SimilarityAlignment forward = align_to(*of_other, *of_id, other_from_id);
  if (!fits(forward, kind) || !shows_the_same(*of_other, *of_id, forward.b_from_a)) return std::nullopt;
  const SimilarityAlignment backward = align_to(*of_id, *of_other, forward.b_from_a.inverse());
  if (!fits(backward, kind)) return std::nullopt;
  const auto error = reciprocal_error(forward, backward);
  if (!error || *error > options_.max_reciprocal_error) return std::nullopt;
  const Matrix7d covariance = forward.information.inverse();
  Matrix6d of_motion = covariance.topLeftCorner<6, 6>();
  of_motion += common_covariance(graph_.keyframe(id).mean_inverse_depth);
  Constraint edge{other, id, forward.b_from_a, of_motion.inverse(), kind};
  edge.information = (0.5 * (edge.information + edge.information.transpose())).eval();
  edge.inliers = forward.points;
  return edge;
}

SimilarityAlignment ConstraintSearch::align_to(const Prepared& b, const Prepared& a, const Sim3& b_from_a) const {
  SimilarityAlignmentOptions options;
  options.coarsest_level = options_.levels - 1;
  options.min_overlap = options_.min_constraint_overlap;
  options.fix_scale = sensor_.is_metric();
  return align_similarity(a.reference, {b.pyramid, b.reference.depth()}, b_from_a, options);
}

bool ConstraintSearch::shows_the_same(const Prepared& b, const Prepared& a, const Sim3& b_from_a) const {
  const SimilarityAlignmentOptions alignment;
  const ImageAlignmentOptions tracking;
  const int level = std::min(alignment.finest_level, options_.levels - 1);
  const SE3 in_unit_of_a(b_from_a.rotation(), b_from_a.translation() / b_from_a.scale());
  return correlated_share(a.reference.level(level), b.pyramid.level(level), in_unit_of_a, alignment.noise,
                          tracking.min_correlation) >= options_.trusted_alike;
}

/// Another house with windows like these lets most pixels fit too, but not nearly all.
bool ConstraintSearch::fits(const SimilarityAlignment& alignment, ConstraintKind kind) const {
  const double least = kind == ConstraintKind::proximity ? 0.0 : options_.loop_share;
  return alignment.ok() && alignment.inlier_share >= least && alignment.information.determinant() > 0.0;
}

ConstraintKind ConstraintSearch::kind_between(std::int64_t other, std::int64_t id) const {
  if (graph_.submap(other) != graph_.submap(id)) return ConstraintKind::merge;
  return std::abs(other - id) > consecutive ? ConstraintKind::loop : ConstraintKind::proximity;
}

}  // namespace rastro
