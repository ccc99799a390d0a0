// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/two_view.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/random.h"
#include "rastro/math/median.h"
#include "rastro/multiview/competing_motions.h"
#include "rastro/multiview/essential.h"
#include "rastro/multiview/homography.h"
#include "rastro/multiview/homography_motion.h"
#include "rastro/multiview/rotation.h"
#include "rastro/multiview/triangulation.h"

namespace rastro {
namespace {

/// Score of a model over the pairs: the sum, in both views, of the bound minus the squared standardised error.
struct Scored {
  double score = 0.0;
  std::vector<std::uint8_t> is_inlier;
  int inliers = 0;
};

/// `errors(pair)` gives squared standardised errors in the first and second view.
template <typename Errors>
Scored scored(std::span<const TwoViewPair> pairs, double limit, double most, const Errors& errors) {
  Scored result;
  for (const TwoViewPair& pair : pairs) {
    const Eigen::Vector2d squared = errors(pair);
    for (int view = 0; view < 2; ++view) result.score += squared[view] <= limit ? most - squared[view] : 0.0;
    result.is_inlier.push_back(squared[0] <= limit && squared[1] <= limit ? 1 : 0);
    result.inliers += result.is_inlier.back();
  }
  return result;
}

Scored score_homography(std::span<const TwoViewPair> pairs, const Eigen::Matrix3d& second_from_first,
                        const TwoViewOptions& options) {
  const Eigen::Matrix3d first_from_second = second_from_first.inverse();
  const auto error = [&](const Eigen::Matrix3d& h, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                         double sigma_px) {
    const Eigen::Vector3d there = h * from.homogeneous();
    return std::pow(options.focal_px / sigma_px, 2) * (there.hnormalized() - to).squaredNorm();
  };
  return scored(pairs, options.homography_chi2, options.homography_chi2, [&](const TwoViewPair& pair) {
    return Eigen::Vector2d(error(first_from_second, pair.second, pair.first, pair.first_sigma_px),
                           error(second_from_first, pair.first, pair.second, pair.second_sigma_px));
  });
}

Scored score_essential(std::span<const TwoViewPair> pairs, const Eigen::Matrix3d& essential,
                       const TwoViewOptions& options) {
  const auto error = [&](const Eigen::Vector3d& line, const Eigen::Vector2d& point, double sigma_px) {
    const double off = line.dot(point.homogeneous());
    return std::pow(options.focal_px / sigma_px, 2) * off * off / (line.head<2>().squaredNorm() + 1e-30);
  };
  // The bound of the homography is also the score of a perfect pair, which makes both scores comparable.
  return scored(pairs, options.fundamental_chi2, options.homography_chi2, [&](const TwoViewPair& pair) {
    return Eigen::Vector2d(error(essential.transpose() * pair.second.homogeneous(), pair.first, pair.first_sigma_px),
                           error(essential * pair.first.homogeneous(), pair.second, pair.second_sigma_px));
  });
}

/// Homography between normalized points, of the sign that keeps most points in front.
std::optional<Eigen::Matrix3d> find_homography(std::span<const TwoViewPair> pairs, const TwoViewOptions& options) {
  // In pixels near the center of an image of usual size, for which its solver is well conditioned.
  constexpr double middle = 300.0;
  PointPairs pixels;
  const auto pixel = [&](const Eigen::Vector2d& ray) -> Eigen::Vector2f {
    return (options.focal_px * ray + Eigen::Vector2d(middle, middle)).cast<float>();
  };
  for (const TwoViewPair& pair : pairs) pixels.add(pixel(pair.first), pixel(pair.second));
  const auto fit =
      estimate_homography(pixels, {std::sqrt(options.homography_chi2), 0.999, options.max_iterations, options.seed});
  if (!fit) return std::nullopt;
  Eigen::Matrix3d intrinsics;
  intrinsics << options.focal_px, 0.0, middle, 0.0, options.focal_px, middle, 0.0, 0.0, 1.0;
  Eigen::Matrix3d h = intrinsics.inverse() * fit->model * intrinsics;
  int in_front = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    in_front += pairs[i].second.homogeneous().dot(h * pairs[i].first.homogeneous()) > 0.0 ? 1 : -1;
  if (in_front < 0) h = -h;
  return h.allFinite() && std::abs(h.determinant()) > 1e-12 ? std::optional(h) : std::nullopt;
}

/// The pairs as lists of both views' points.
struct Points {
  std::vector<Eigen::Vector2d> first, second;

  explicit Points(std::span<const TwoViewPair> pairs) {
    for (const TwoViewPair& pair : pairs) first.push_back(pair.first), second.push_back(pair.second);
  }
};

CalibratedRansacOptions ransac_options(const TwoViewOptions& options, double chi2, std::uint64_t stream) {
  CalibratedRansacOptions ransac;
  ransac.max_error_px = std::sqrt(chi2);
  ransac.confidence = 0.999;
  ransac.max_iterations = options.max_iterations;
  ransac.seed = seed_for(options.seed, stream);
  ransac.focal_px = options.focal_px;
  return ransac;
}

std::optional<EssentialFit> find_essential(std::span<const TwoViewPair> pairs, const TwoViewOptions& options) {
  const Points points(pairs);
  CalibratedRansacOptions ransac = ransac_options(options, options.fundamental_chi2, 1);
  ransac.min_iterations = options.min_iterations;
  return estimate_essential(points.first, points.second, ransac);
}

/// Score of a pure rotation, computed as for a homography.
double rotation_score(std::span<const TwoViewPair> pairs, const TwoViewOptions& options) {
  const Points points(pairs);
  const auto rotation =
      rotation_between(points.first, points.second, ransac_options(options, options.homography_chi2, 2));
  return rotation ? score_homography(pairs, rotation->second_from_first.matrix(), options).score : 0.0;
}

/// The best score of a motion in a clearly other direction. Where the views hardly tell directions apart, it is about
/// as good as the best one, and noise decides.
double competing_score(std::span<const TwoViewPair> pairs, const SE3& motion, const Scored& model,
                       const TwoViewOptions& options) {
  const Points points(pairs);
  double best = 0.0;
  for (const SE3& other :
       competing_motions(motion, points.first, points.second, model.is_inlier, options.competing_angle_deg))
    best = std::max(best, score_essential(pairs, essential_of(other), options).score);
  return best;
}

/// The four of an essential matrix (Hartley and Zisserman 2004, result 9.19).
std::vector<SE3> motions_of_essential(const Eigen::Matrix3d& essential) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d quarter;
  quarter << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  std::vector<SE3> motions;
  for (const Eigen::Matrix3d& quarter_rotation : {quarter, Eigen::Matrix3d(quarter.transpose())}) {
    Eigen::Matrix3d rotation = svd.matrixU() * quarter_rotation * svd.matrixV().transpose();
    if (rotation.determinant() < 0.0) rotation = -rotation;
    for (const double sign : {1.0, -1.0}) motions.emplace_back(SO3::from_matrix(rotation), sign * svd.matrixU().col(2));
  }
  return motions;
}

/// Evidence of the points for one motion.
struct Hypothesis {
  SE3 motion;
  int in_front = 0;
  std::vector<std::optional<Eigen::Vector3d>> points;
  int triangulated = 0;
  double median_parallax_deg = 0.0;
};

Hypothesis judged(const SE3& motion, std::span<const TwoViewPair> pairs, const Scored& model,
                  const TwoViewOptions& options) {
  Hypothesis result;
  result.motion = motion;
  result.points.resize(pairs.size());
  std::vector<double> parallaxes;
  TriangulationOptions triangulation;
  triangulation.focal_px = options.focal_px;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (model.is_inlier[i] == 0) continue;
    const TwoViewPair& pair = pairs[i];
    const Eigen::Vector3d rotated = motion.rotation() * pair.first.homogeneous().eval();
    const Eigen::Vector3d ray = pair.second.homogeneous();
    parallaxes.push_back(std::atan2(rotated.cross(ray).norm(), rotated.dot(ray)) * 180.0 / std::numbers::pi);
    triangulation.max_error_px =
        std::sqrt(options.homography_chi2) * std::max(pair.first_sigma_px, pair.second_sigma_px);
    const auto point = triangulate(motion, pair.first, pair.second, triangulation);
    if (!point) continue;
    ++result.in_front;
    if (point->parallax_deg < options.least_point_parallax_deg) continue;
    result.points[i] = point->position;
    ++result.triangulated;
  }
  result.median_parallax_deg = upper_median_or(std::move(parallaxes), 0.0);
  return result;
}

bool better(const Hypothesis& a, const Hypothesis& b) { return a.in_front > b.in_front; }

/// Fills in the result of the best hypothesis, or why none is accepted.
void decide(std::vector<Hypothesis> hypotheses, const TwoViewOptions& options, TwoViewFit& fit) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(), better);
  Hypothesis& best = hypotheses.front();
  fit.median_parallax_deg = best.median_parallax_deg;
  fit.triangulated = best.triangulated;
  fit.second_from_first = best.motion;
  fit.points = std::move(best.points);
  const int runner_up = hypotheses.size() > 1 ? hypotheses[1].in_front : 0;
  const auto refuse = [&](TwoViewStatus status, std::string detail) {
    fit.status = status;
    fit.detail = std::move(detail);
  };
  if (fit.median_parallax_deg < options.min_parallax_deg) {
    return refuse(TwoViewStatus::little_motion, fmt::format("median parallax {:.1f} deg, need {:.1f}",
                                                            fit.median_parallax_deg, options.min_parallax_deg));
  }
  if (best.in_front < options.min_inlier_share * fit.inliers) {
    return refuse(TwoViewStatus::no_model,
                  fmt::format("{} of {} matches are in front of both views, need {:.0f}", best.in_front, fit.inliers,
                              std::ceil(options.min_inlier_share * fit.inliers)));
  }
  if (runner_up > options.max_runner_up * best.in_front) {
    return refuse(TwoViewStatus::ambiguous,
                  fmt::format("two motions fit {} and {} matches, need one clearly best", best.in_front, runner_up));
  }
  if (best.triangulated < options.min_points) {
    return refuse(TwoViewStatus::too_few_points,
                  fmt::format("{} points, need {}", best.triangulated, options.min_points));
  }
  fit.status = TwoViewStatus::found;
}

/// Refuses a motion that another explains about as well.
void refuse_doubtful(std::span<const TwoViewPair> pairs, const Scored& model, const TwoViewOptions& options,
                     TwoViewFit& fit) {
  // The error of a rotation estimated as a motion gives points parallax.
  const double rotation_share = rotation_score(pairs, options) / model.score;
  if (rotation_share > options.max_rotation_score) {
    fit.status = TwoViewStatus::little_motion;
    fit.detail = fmt::format("a pure rotation has {:.0f} % of the score, need at most {:.0f} %", 100.0 * rotation_share,
                             100.0 * options.max_rotation_score);
    return;
  }
  if (fit.planar) return;
  const double competing_share = competing_score(pairs, fit.second_from_first, model, options) / model.score;
  if (competing_share > options.max_competing_score) {
    fit.status = TwoViewStatus::ambiguous;
    fit.detail = fmt::format("a motion in another direction has {:.0f} % of the score, need at most {:.0f} %",
                             100.0 * competing_share, 100.0 * options.max_competing_score);
  }
}

}  // namespace

const char* name_of(TwoViewStatus status) {
  switch (status) {
    case TwoViewStatus::found:
      return "found";
    case TwoViewStatus::too_few_pairs:
      return "too few matches";
    case TwoViewStatus::no_model:
      return "no motion fits";
    case TwoViewStatus::little_motion:
      return "little motion";
    case TwoViewStatus::ambiguous:
      return "ambiguous";
    case TwoViewStatus::too_few_points:
      return "too few points";
  }
  return "";
}

TwoViewFit find_two_view_motion(std::span<const TwoViewPair> pairs, const TwoViewOptions& options) {
  TwoViewFit fit;
  fit.points.resize(pairs.size());
  const int least = std::max(8, options.min_points);
  if (static_cast<int>(pairs.size()) < least) {
    fit.detail = fmt::format("{} matches, need {}", pairs.size(), least);
    return fit;
  }
  const auto homography = find_homography(pairs, options);
  const auto essential = find_essential(pairs, options);
  const Scored plane = homography ? score_homography(pairs, *homography, options) : Scored{};
  const Scored scene = essential ? score_essential(pairs, essential->essential, options) : Scored{};
  fit.homography_score = plane.score;
  fit.fundamental_score = scene.score;
  const double sum = plane.score + scene.score;
  fit.share = sum > 0.0 ? plane.score / sum : 0.0;
  fit.planar = fit.share > options.homography_share;
  const Scored& model = fit.planar ? plane : scene;
  fit.inliers = model.inliers;
  std::vector<SE3> motions;
  // For a plane with many wrong matches the fundamental matrix, which a plane does not determine, fits a little more.
  const bool may_be_plane = !fit.planar && fit.share > options.near_plane_share;
  const double least_share = may_be_plane ? options.near_plane_model_share : options.min_model_share;
  const int needed = std::max(options.min_points, static_cast<int>(least_share * double(pairs.size())));
  if (model.inliers > 0)
    motions = fit.planar ? motions_of_homography(*homography) : motions_of_essential(essential->essential);
  if (motions.empty() || fit.inliers < needed) {
    fit.status = TwoViewStatus::no_model;
    fit.detail = fmt::format("{} of {} matches fit one motion, need {}", fit.inliers, pairs.size(), needed);
    return fit;
  }
  std::vector<Hypothesis> hypotheses;
  hypotheses.reserve(motions.size());
  for (const SE3& motion : motions) hypotheses.push_back(judged(motion, pairs, model, options));
  decide(std::move(hypotheses), options, fit);
  if (fit.status == TwoViewStatus::found) refuse_doubtful(pairs, model, options, fit);
  return fit;
}

}  // namespace rastro
