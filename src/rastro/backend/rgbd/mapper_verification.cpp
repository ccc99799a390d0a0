// SPDX-License-Identifier: Apache-2.0
// When a match of two keyframes becomes a constraint.
#include <cmath>

#include "rastro/backend/acceptance.h"
#include "rastro/backend/rgbd/mapper.h"

namespace rastro {

ConstraintKind Mapper::kind_between(std::int64_t other, std::int64_t id) const {
  if (graph_.submap(other) != graph_.submap(id)) return ConstraintKind::merge;
  const int steps = options_.loop_steps;
  const bool far = other < graph_.frozen() || graph_.steps_between(other, id, steps) >= steps;
  return far ? ConstraintKind::loop : ConstraintKind::proximity;
}

int Mapper::inliers_for(ConstraintKind kind) const {
  if (kind == ConstraintKind::merge) return options_.relocalize_inliers;
  return kind == ConstraintKind::loop ? options_.loop_inliers : options_.min_inliers;
}

Mapper::Verified Mapper::match(std::int64_t other, std::int64_t id, MatchScope scope) {
  const auto view = [this](std::int64_t k) {
    return ViewOfKeyframe{&graph_.keyframe(k), [this, k] { return depths_.depth(k); }};
  };
  const ConstraintKind kind = kind_between(other, id);
  std::optional<SE3> guess;
  if (kind != ConstraintKind::merge) guess = graph_.pose(other).inverse() * graph_.pose(id);
  const auto tracked = graph_.tracked_motion(other, id, most_tracked_steps);
  if (tracked) guess = tracked->from_from_to;
  const std::uint64_t seed =
      seed_for(seed_for(options_.follow.seed, static_cast<std::uint64_t>(id)), static_cast<std::uint64_t>(other));
  Rejection why = Rejection::none;
  MatchRequest request{inliers_for(kind), seed, guess, scope};
  if (!tracked) {
    request.far = options_.match_far;
    request.max_sigma_m = most_revisit_sigma_m;
  }
  const auto match = matcher_.match(view(other), view(id), request, &why);
  if (!match) return {std::nullopt, why};
  return {Constraint{other, id, Sim3(match->a_from_b), match->information, kind, 1.0, match->inliers}};
}

/// What most features agree with may be a crowd that walks by: where tracking knows better, what agrees with it counts.
Mapper::Verified Mapper::verify(std::int64_t other, std::int64_t id) {
  Verified found = match(other, id, MatchScope::anywhere);
  GraphPaths& paths = *proof_.graph_paths;
  if (found.edge && found.edge->kind != ConstraintKind::merge && contradicts_path(*found.edge, paths)) {
    found = match(other, id, MatchScope::near_guess);
    if (!found.edge || contradicts_path(*found.edge, paths)) return {std::nullopt, Rejection::contradicts_graph};
  }
  if (found.edge && options_.min_alike > 0.0 && needs_proof(*found.edge)) judge_appearance(found);
  return found;
}

/// What tracking connects needs none, nor does what a few other edges connect where these predict it.
bool Mapper::needs_proof(const Constraint& edge) const {
  if (edge.kind != ConstraintKind::proximity) return true;
  return !graph_.tracked_motion(edge.from, edge.to, most_tracked_steps) && corrects_map(edge);
}

/// By more than the map can be off where all is well. A given map stays.
bool Mapper::corrects_map(const Constraint& edge) const {
  if (edge.from < graph_.frozen()) return false;
  return !agrees_with_map(graph_.pose(edge.from).inverse() * graph_.pose(edge.to), edge.rigid());
}

/// One place may have the same shape and furniture as another. A loop after a long path changes much, and one that the
/// map does not predict may be off by one of the things that repeat there, within what the camera can have drifted: it
/// needs a second one. So does a merge of submaps, but for a wide view that looks alike.
void Mapper::judge_appearance(Verified& found) {
  constexpr int wide_cells = 30;
  constexpr double long_way_m = 8.0;
  const Constraint& edge = *found.edge;
  const AppearanceAgreement agreement = proof_.check.compare(*proof_.appearances.appearance(edge.from),
                                                             *proof_.appearances.appearance(edge.to), edge.rigid());
  const bool merges = edge.kind == ConstraintKind::merge;
  const auto is_doubtful = [&] { return proof_.graph_paths->to(edge.from) >= long_way_m || corrects_map(edge); };
  found.alone = merges ? agreement.cells < wide_cells : is_doubtful();
  found.evidence = agreement.center;
  found.rejection = judge(agreement.evidence(), {.min_alike_share = options_.min_alike});
  if (found.rejection != Rejection::none) found.edge.reset();
}

/// Why not, if not yet.
Rejection Mapper::take(const Verified& found, std::vector<Constraint>& accepted) {
  if (!found.edge) return found.rejection;
  if (!found.alone) {
    accepted.push_back(*found.edge);
    return Rejection::none;
  }
  // Loops that were closed since may have shortened the path that an earlier one was judged by.
  const auto still_fits = [this](const Constraint& earlier) {
    GraphPaths paths = graph_.graph_paths_from(earlier.to);
    return graph_.submap(earlier.from) != graph_.submap(earlier.to) || !contradicts_path(earlier, paths);
  };
  const std::vector<Constraint> confirmed = proof_.confirmation.next(graph_, {*found.edge, found.evidence}, still_fits);
  accepted.insert(accepted.end(), confirmed.begin(), confirmed.end());
  return confirmed.empty() ? Rejection::not_confirmed : Rejection::none;
}

/// Whether a match is farther from the relative pose in the graph than the camera can have drifted on the path between.
/// `paths`: from edge.to.
bool Mapper::contradicts_path(const Constraint& edge, GraphPaths& paths) const {
  if (edge.from < graph_.frozen()) return false;
  Evidence evidence;
  if (const auto tracked = graph_.tracked_motion(edge.from, edge.to, most_tracked_steps)) {
    const OdometryDrift drift{options_.tracked_drift_share, options_.tracked_drift_share};
    // Without the inflation: what is common to all matches does not make a wrong one right.
    const Matrix6d of_match = edge.information.inverse() / match_covariance_factor;
    const Matrix6d covariance =
        tracked->covariance + of_match + drift.covariance(graph_.path_between(edge.from, edge.to));
    evidence.graph_sigmas = graph_sigmas(tracked->from_from_to, edge.rigid(), covariance);
  } else {
    constexpr double least_path_m = 1.0;  // over which tracking may slip without a path
    const OdometryDrift drift{options_.loop_drift_share, options_.loop_drift_rad_per_m};
    const SE3 predicted = graph_.pose(edge.from).inverse() * graph_.pose(edge.to);
    const double shortest_m = paths.to(edge.from);
    const double drifted_m = std::isfinite(shortest_m) ? shortest_m : graph_.path_between(edge.from, edge.to);
    evidence.graph_sigmas = graph_sigmas(predicted, edge.rigid(), drift.covariance(least_path_m + drifted_m));
  }
  return judge(evidence, {.max_graph_sigmas = options_.loop_max_sigmas}) != Rejection::none;
}

}  // namespace rastro
