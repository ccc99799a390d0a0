// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/keyframe_matcher.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

#include "rastro/backend/rgbd/edge_covariance.h"
#include "rastro/feature/descriptor_matching.h"

namespace rastro {
namespace {

/// Size of the finest features; the position error of those from coarser levels grows in proportion.
float finest_size(const Features& features) {
  float finest = std::numeric_limits<float>::infinity();
  for (const Keypoint& keypoint : features.keypoints) finest = std::min(finest, keypoint.size_px);
  return finest;
}

double pixel_sigma(const Keypoint& keypoint, float finest, double sigma) {
  constexpr float most = 2.0F;
  const float scale = finest > 0.0F ? keypoint.size_px / finest : 1.0F;
  return sigma * static_cast<double>(std::clamp(scale, 1.0F, most));
}

/// Neighboring depth blocks have correlated errors.
constexpr double surface_weight = 0.05;

/// Surfaces that still move the pose have not found it; those that moved it this far are not those that were within
/// reach at first. Of 106 slides in kitchen_rgbd and the clips of tum_fr1_rpy the right ones went up to 0.24 m and
/// 0.12 rad and came to rest within 0.003, a wrong one went on. What fits of the few features says less: they are off
/// by up to 0.22 m, and where surfaces had the better pose none of them fitted any more.
bool came_to_rest(const SE3& start_from_end, double last_step) {
  constexpr double farthest_m = 0.3, farthest_rad = 0.2, at_rest = 0.01;
  return last_step <= at_rest && start_from_end.translation().norm() <= farthest_m &&
         start_from_end.rotation().log().norm() <= farthest_rad;
}

/// Aligns the surfaces, starting at the pose from features; nullopt where they leave a direction unconstrained, or
/// slide away.
std::optional<MatchedViews> slide(const SurfaceCheck& check, const KeyframeSurface& a, const KeyframeSurface& b,
                                  const MatchedViews& start) {
  constexpr double reaches_m[] = {0.2, 0.2, 0.2, 0.1, 0.1, 0.1, 0.05, 0.05, 0.05};
  constexpr double least_information = 1.0 / (0.02 * 0.02);
  MatchedViews slid = start;
  double last_step = 0.0;
  for (const double reach_m : reaches_m) {
    const SurfaceFit fit = check.fit(a, b, slid.a_from_b, reach_m);
    slid.information = surface_weight * fit.information;
    const Eigen::LDLT<Matrix6d> solver(slid.information);
    if (!(Eigen::SelfAdjointEigenSolver<Matrix6d>(slid.information).eigenvalues().minCoeff() > least_information))
      return std::nullopt;
    const Vector6d step = solver.solve(surface_weight * fit.gradient);
    last_step = step.norm();
    if (!step.allFinite() || last_step > 0.5) return std::nullopt;
    slid.a_from_b = slid.a_from_b * SE3::exp(step);
  }
  if (!came_to_rest(start.a_from_b.inverse() * slid.a_from_b, last_step)) return std::nullopt;
  return slid;
}

/// False also where the covariance is none, from an information close to singular.
bool knows_position(const Matrix6d& covariance, double max_sigma_m) {
  const Eigen::Matrix3d of_position = covariance.topLeftCorner<3, 3>();
  const Eigen::Vector3d squared = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(of_position).eigenvalues();
  return squared.minCoeff() > 0.0 && squared.maxCoeff() <= max_sigma_m * max_sigma_m;
}

/// For features alone, and for surfaces: the environment measurement check. With fewer feature inliers, the surfaces
/// must give more evidence.
AcceptanceOptions feature_acceptance(const RgbdSlamOptions& options) {
  return {.min_inlier_share = options.min_inlier_share};
}
AcceptanceOptions surface_acceptance(const RgbdSlamOptions& options, bool few_features) {
  if (!few_features) return {.min_overlap = options.agreement_overlap, .min_observed_share = options.agreement};
  return {.min_overlap = 3.0 * options.agreement_overlap, .min_observed_share = 0.5 * (1.0 + options.agreement)};
}

}  // namespace

Evidence KeyframeConstraint::evidence() const {
  Evidence evidence = agreement.evidence();
  evidence.matches = matches;
  evidence.inliers = inliers;
  return evidence;
}

DepthNoise depth_noise(const RgbdSlamOptions& options) {
  return {options.follow.depth_sigma_m, options.follow.depth_sigma_per_m2};
}

SurfaceOptions surface_options(const RgbdSlamOptions& options) {
  return {options.follow.depth_sigma_m, options.follow.depth_sigma_per_m2, options.follow.min_depth_m,
          options.follow.max_depth_m};
}

KeyframeMatcher::KeyframeMatcher(const RgbdSlamOptions& options, const Camera& camera)
    : options_(options), camera_(camera), check_(camera, surface_options(options)) {}

std::vector<PointMatch> KeyframeMatcher::matches_of(const ImageFeatures& a, const ImageFeatures& b, bool far) const {
  DescriptorMatchOptions matching;
  matching.max_ratio = options_.max_ratio;
  const float finest_a = finest_size(a.features), finest_b = finest_size(b.features);
  std::vector<PointMatch> matches;
  for (const DescriptorMatch& match : match_descriptors(b.features, a.features, matching)) {
    const Keypoint &in_a = a.features.keypoints[match.second], &in_b = b.features.keypoints[match.first];
    const auto ray_a = camera_.unproject(Eigen::Vector2d(Eigen::Vector2f(in_a.x, in_a.y).cast<double>()));
    const auto ray_b = camera_.unproject(Eigen::Vector2d(Eigen::Vector2f(in_b.x, in_b.y).cast<double>()));
    const auto depth_a = static_cast<double>(a.depths[match.second]),
               depth_b = static_cast<double>(b.depths[match.first]);
    if (!ray_a || !ray_b || (!far && depth_a <= 0.0 && depth_b <= 0.0)) continue;
    matches.push_back({*ray_a, *ray_b, depth_a, depth_b, pixel_sigma(in_a, finest_a, options_.pixel_sigma),
                       pixel_sigma(in_b, finest_b, options_.pixel_sigma)});
  }
  return matches;
}

std::optional<KeyframeConstraint> KeyframeMatcher::match(const ViewOfKeyframe& a, const ViewOfKeyframe& b,
                                                         const MatchRequest& request, Rejection* why) const {
  Rejection own;
  Rejection& rejection = why ? *why : own;
  rejection = Rejection::few_inliers;
  const std::vector<PointMatch> matches = matches_of(*a.keyframe, *b.keyframe, request.far);
  PointMatchOptions fitting;
  fitting.noise = depth_noise(options_);
  fitting.focal_px = camera_.fx;
  fitting.iterations = request.scope == MatchScope::anywhere ? options_.ransac_iterations : 0;
  const int least = options_.few_features == "icp" ? options_.few_inliers : request.min_inliers;
  fitting.min_inliers = std::min(request.min_inliers, least);
  fitting.min_depth_m = options_.follow.min_depth_m;
  fitting.seed = request.seed;
  std::optional<MatchedViews> views = estimate_views(matches, fitting, request.guess);
  if (!views) return std::nullopt;
  rejection =
      judge({.matches = static_cast<int>(matches.size()), .inliers = views->inliers}, feature_acceptance(options_));
  if (rejection != Rejection::none) return std::nullopt;
  const auto surface_a = a.depth(), surface_b = b.depth();
  const bool few = views->inliers < request.min_inliers;
  if (few) views = slide(check_, *surface_a, *surface_b, *views);
  rejection = Rejection::few_inliers;
  if (!views) return std::nullopt;
  KeyframeConstraint constraint{
      views->a_from_b, Matrix6d::Identity(), static_cast<int>(matches.size()), views->inliers, {}};
  constraint.agreement = check_.compare(*surface_a, *surface_b, constraint.a_from_b);
  rejection = judge(constraint.evidence(), surface_acceptance(options_, few));
  if (rejection != Rejection::none) return std::nullopt;
  const Matrix6d covariance = with_common_errors(match_covariance_factor * views->information.inverse(), options_);
  rejection = Rejection::few_inliers;
  if (!knows_position(covariance, request.max_sigma_m)) return std::nullopt;
  rejection = Rejection::none;
  constraint.information = covariance.inverse();
  constraint.information = (0.5 * (constraint.information + constraint.information.transpose())).eval();
  return constraint;
}

}  // namespace rastro
