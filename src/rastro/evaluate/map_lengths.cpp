// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/map_lengths.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/base/random.h"
#include "rastro/evaluate/length_combine.h"
#include "rastro/evaluate/length_edge.h"
#include "rastro/evaluate/length_face.h"
#include "rastro/evaluate/length_feature.h"
#include "rastro/evaluate/length_views.h"

namespace rastro {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double vote_width_m = 0.006;  ///< Of one candidate: about the error of keyframe poses.
constexpr double agree_widths = 3.5;    ///< Candidates within this many widths of the chosen offset are selected.
constexpr double unsure_share = 0.3;    ///< Share of the radius: possible error of an edge seen in very few keyframes.
constexpr double clear_rivalry = 0.75;  ///< A competing offset that fits this well is reported.
constexpr double shared_px = 0.35;      ///< Light, blur and the surroundings shift an edge equally in all images.
constexpr double height_sigma_m = 0.015;  ///< Of a rough face that has no depth in a map with depth.
constexpr double height_step_m = 0.005;
constexpr int triangulated_views = 2;       ///< So many times the views, where edges are triangulated.
constexpr double weak_height_share = 0.25;  ///< Share of its prior: above, the views do not tell a distance.
constexpr double spot_sigma_share = 0.4;    ///< Standard deviation of a rough point as share of its radius.
constexpr double weak_support = 0.5;        ///< Below, depth is reported as missing or behind.
constexpr std::size_t few_keyframes = 3;

/// One view's candidate for the feature; world frame.
struct Candidate {
  Vector3d point = Vector3d::Zero();
  Vector3d direction = Vector3d::Zero();  ///< Of the edge, or the normal of the face.
  Matrix3d covariance = Matrix3d::Zero();
  double score = 0.0;
  int points = 0;
  double support = 0.0;
  double shared_m = 0.0;  ///< Standard deviation of the error common to all views.
  /// Derivative of the point by the height of the face, where that is not measured.
  Vector3d lever = Vector3d::Zero();
  std::array<Vector2d, 2> pixels{};
};

/// One view's candidates for the features of an object.
struct ViewFinding {
  std::int64_t keyframe = 0;
  bool has_depth = false;
  std::vector<std::vector<Candidate>> candidates;  ///< Per feature.
};

/// A feature and the views that agree on it.
struct Found {
  std::vector<std::pair<std::size_t, Candidate>> observations;      ///< With the index of the finding.
  Vector3d point = Vector3d::Zero(), direction = Vector3d::Zero();  ///< Means.
  double height_m = 0.0;                                            ///< Of the face above the rough one, without depth.
  double wrong_position_variance = 0.0;                             ///< For the risk of a wrong edge.
  double rivalry = 0.0;  ///< Relative votes of the best competing offset, 0 .. 1.
};

Candidate face_candidate(const LengthView& view, const LengthFace& face, const Vector3d& spot) {
  Candidate found;
  const Vector3d foot = face.foot(spot), normal = face.normal();
  const Vector3d ray = foot / foot.z();
  const double sigma = std::abs(normal.dot(ray)) * face.depth_sigma_at(ray);
  const Matrix3d rotation = view.world_from_camera.rotation().matrix();
  found.point = view.world_from_camera * foot;
  found.direction = rotation * normal;
  found.covariance = sigma * sigma * found.direction * found.direction.transpose();
  found.score = std::sqrt(static_cast<double>(face.points)) * face.support;
  const auto pixel = view.camera.project(foot);
  if (pixel) found.pixels = {*pixel, *pixel};
  return found;
}

std::vector<Candidate> edge_candidates(const LengthView& view, const LengthFace& face, const LengthEdgeSearch& search) {
  std::vector<Candidate> found;
  const Matrix3d rotation = view.world_from_camera.rotation().matrix();
  for (const LengthEdge& edge : find_edges(view, face, search)) {
    Candidate one;
    one.point = view.world_from_camera * edge.point;
    one.direction = rotation * edge.direction;
    one.covariance = rotation * edge.covariance * rotation.transpose();
    one.score = edge.score;
    one.shared_m = shared_px * edge.pixel_m;
    one.pixels = edge.pixels;
    found.push_back(one);
  }
  return found;
}

/// The face through the given points, for objects without depth.
LengthFace rough_face(const LengthView& view, const LengthFeature& feature) {
  const SE3 camera_from_world = view.world_from_camera.inverse();
  const Vector3d normal = camera_from_world.rotation() * feature.normal();
  const double distance = normal.dot(camera_from_world * feature.spot);
  LengthFace face;
  if (std::abs(distance) > 0.02) face.inverse = normal / distance;
  return face;
}

std::optional<LengthFace> measured_face(const LengthView& view, const LengthFeature& feature, double radius_m,
                                        const MapLengthOptions& options) {
  const SE3 camera_from_world = view.world_from_camera.inverse();
  LengthRegion region = length_region(feature, radius_m, options);
  region.center = camera_from_world * region.center;
  region.axes = camera_from_world.rotation().matrix() * region.axes;
  return find_face(view, region, seed_for(options.seed, static_cast<std::uint64_t>(view.keyframe)));
}

std::vector<Candidate> candidates_in(const LengthView& view, const LengthFeature& feature, double radius_m,
                                     const MapLengthOptions& options, bool by_depth) {
  const auto face = by_depth ? measured_face(view, feature, radius_m, options) : rough_face(view, feature);
  if (!face || face->inverse.isZero()) return {};
  const SE3 camera_from_world = view.world_from_camera.inverse();
  const Matrix3d rotation = camera_from_world.rotation().matrix();
  const Vector3d spot = camera_from_world * feature.spot;
  std::vector<Candidate> found;
  if (feature.is_edge) {
    found = edge_candidates(
        view, *face, {spot, rotation * feature.along, rotation * feature.inwards, radius_m, options.half_length_m});
  } else {
    found.push_back(face_candidate(view, *face, spot));
  }
  for (Candidate& one : found) {
    one.points = face->points;
    one.support = face->support;
    if (by_depth) continue;
    const Vector3d ray = one.point - view.world_from_camera.translation();
    one.lever = ray / ray.dot(feature.normal());
  }
  return found;
}

/// Offset of a candidate from the rough point, along the search direction.
double offset_of(const LengthFeature& feature, const Candidate& candidate, double height_m) {
  const Vector3d axis = feature.is_edge ? feature.inwards : candidate.direction;
  return axis.dot(candidate.point + height_m * candidate.lever - feature.spot);
}

double vote(double distance_m, double width_m) { return std::exp(-0.5 * std::pow(distance_m / width_m, 2)); }

/// Maximum of the views' votes: the offset from the rough point with the most votes, and their number.
struct VotedOffset {
  double offset_m = 0.0, votes = 0.0;
  double height_m = 0.0;  ///< Height of the face, for candidates with a lever.
};

/// How far the points of a feature may be from the given ones.
struct SearchPrior {
  double radius_m = 0.06;
  double height_sigma_m = 0.0;  ///< Of the face above the rough one; 0: depth tells its height.
};

/// The offset with the most votes, near the rough point rather than far from it. A view has one vote per offset, that
/// of its best candidate there.
VotedOffset most_voted_at(double height_m, const std::vector<std::vector<Candidate>>& views,
                          const LengthFeature& feature, const SearchPrior& prior) {
  std::vector<std::vector<std::pair<double, double>>> ballots;  // offsets with scores
  for (const auto& view : views) {
    ballots.emplace_back();
    for (const Candidate& one : view) ballots.back().emplace_back(offset_of(feature, one, height_m), one.score);
  }
  VotedOffset best;
  for (const auto& proposer : ballots) {
    for (const auto& [offset, ignored] : proposer) {
      double votes = 0.0;
      for (const auto& voter : ballots) {
        double strongest = 0.0;
        for (const auto& [other, score] : voter)
          strongest = std::max(strongest, score * vote(other - offset, vote_width_m));
        votes += strongest;
      }
      votes *= vote(offset, spot_sigma_share * prior.radius_m);
      if (prior.height_sigma_m > 0.0) votes *= vote(height_m, prior.height_sigma_m);
      if (votes > best.votes) best = {offset, votes, height_m};
    }
  }
  return best;
}

/// The same over all possible heights of the face, without depth.
VotedOffset most_voted(const std::vector<std::vector<Candidate>>& views, const LengthFeature& feature,
                       const SearchPrior& prior) {
  VotedOffset best = most_voted_at(0.0, views, feature, prior);
  const auto steps = static_cast<int>(std::lround(2.0 * prior.height_sigma_m / height_step_m));
  for (int step = -steps; step <= steps; ++step) {
    const VotedOffset other = most_voted_at(step * height_step_m, views, feature, prior);
    if (other.votes > best.votes) best = other;
  }
  return best;
}

/// Selects the candidate of a view that matches the offset; nullopt if it has none.
std::optional<Candidate> taken_at(std::vector<Candidate>& candidates, const LengthFeature& feature,
                                  const VotedOffset& voted) {
  auto best = candidates.end();
  double most = 0.0;
  for (auto one = candidates.begin(); one != candidates.end(); ++one) {
    const double distance = offset_of(feature, *one, voted.height_m) - voted.offset_m;
    const double score = one->score * vote(distance, vote_width_m);
    if (std::abs(distance) < agree_widths * vote_width_m && score > most) most = score, best = one;
  }
  if (best == candidates.end()) return std::nullopt;
  const Candidate taken = *best;
  candidates.erase(best);
  return taken;
}

std::vector<std::vector<Candidate>> candidates_for(const std::vector<ViewFinding>& findings, std::size_t which) {
  std::vector<std::vector<Candidate>> views;
  for (const ViewFinding& finding : findings) views.push_back(finding.candidates[which]);
  return views;
}

Found agreed(const std::vector<ViewFinding>& findings, std::size_t which, const LengthFeature& feature,
             const SearchPrior& prior) {
  Found found;
  std::vector<std::vector<Candidate>> views = candidates_for(findings, which);
  const VotedOffset chosen = most_voted(views, feature, prior);
  if (!(chosen.votes > 0.0)) return found;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto taken = taken_at(views[i], feature, chosen);
    if (!taken) continue;
    found.observations.emplace_back(i, *taken);
    found.observations.back().second.point += chosen.height_m * taken->lever;
  }
  const VotedOffset rival = most_voted(views, feature, prior);
  found.rivalry = rival.votes / chosen.votes;
  found.height_m = chosen.height_m;
  // Votes are no probabilities: an offset with half of them is hardly ever the right one.
  const double odds = std::pow(found.rivalry, 4), share = odds / (1.0 + odds);
  found.wrong_position_variance = share * (1.0 - share) * std::pow(rival.offset_m - chosen.offset_m, 2);
  for (auto& [finding, one] : found.observations) {
    if (one.direction.dot(found.observations.front().second.direction) < 0.0) one.direction = -one.direction;
    found.point += one.point / static_cast<double>(found.observations.size());
    found.direction += one.direction;
  }
  found.direction.normalize();
  return found;
}

/// Intersection of the two edges of a corner, or their closest points, in each view that has both.
Found crossing(const Found& one, const Found& other) {
  Found corner;
  corner.wrong_position_variance = one.wrong_position_variance + other.wrong_position_variance;
  corner.rivalry = std::max(one.rivalry, other.rivalry);
  for (const auto& [finding, first] : one.observations) {
    for (const auto& [same, second] : other.observations) {
      if (finding != same) continue;
      const double cosine = first.direction.dot(second.direction), sine_squared = 1.0 - cosine * cosine;
      if (sine_squared < 0.05) continue;
      const Vector3d between = second.point - first.point;
      const double along = (between.dot(first.direction) - cosine * between.dot(second.direction)) / sine_squared;
      Candidate point = first;
      point.point = first.point + along * first.direction;
      point.covariance = first.covariance + second.covariance;
      point.pixels = {first.pixels[0], second.pixels[0]};
      corner.observations.emplace_back(finding, point);
      corner.point += point.point;
    }
  }
  if (!corner.observations.empty()) corner.point /= static_cast<double>(corner.observations.size());
  return corner;
}

/// The measured direction; nullopt if the two features coincide.
std::optional<Vector3d> measured_direction(LengthKind kind, const Found& a, const Found& b) {
  Vector3d direction = b.point - a.point;
  if (kind != LengthKind::points) {
    const Vector3d common = a.direction + (a.direction.dot(b.direction) < 0.0 ? -1.0 : 1.0) * b.direction;
    const Vector3d axis = common.normalized();
    direction = kind == LengthKind::edges ? Vector3d(direction - direction.dot(axis) * axis)
                                          : Vector3d(direction.dot(axis) * axis);
  }
  if (!(direction.norm() > 1e-4)) return std::nullopt;
  return direction.normalized();
}

LengthObservations along(const Found& found, const std::vector<ViewFinding>& findings, const Vector3d& direction,
                         double height_sigma_m) {
  LengthObservations observations;
  for (const auto& [finding, one] : found.observations) {
    observations.all.push_back({findings[finding].keyframe, direction.dot(one.point),
                                std::sqrt(std::max(0.0, direction.dot(one.covariance * direction))), one.shared_m,
                                direction.dot(one.lever)});
  }
  // The points are at the height with the most votes; the remaining height is counted from there.
  observations.height_m = -found.height_m;
  observations.height_sigma_m = height_sigma_m;
  return observations;
}

/// The keyframe with the best view: both features, with high scores.
LengthImage best_image(const Found& a, const Found& b, const std::vector<ViewFinding>& findings) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  LengthImage best;
  double most = 0.0;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    LengthImage image{
        findings[i].keyframe, {Vector2d(nan, nan), Vector2d(nan, nan)}, {Vector2d(nan, nan), Vector2d(nan, nan)}};
    double score = 0.0;
    for (const auto& [finding, one] : a.observations)
      if (finding == i) image.a = one.pixels, score += 1e3 + one.score;
    for (const auto& [finding, one] : b.observations)
      if (finding == i) image.b = one.pixels, score += 1e3 + one.score;
    if (score > most) most = score, best = image;
  }
  return best;
}

double mean_support(const Found& a, const Found& b) {
  double sum = 0.0;
  for (const auto* found : {&a, &b})
    for (const auto& [finding, one] : found->observations) sum += one.support;
  return sum / std::max<double>(1.0, static_cast<double>(a.observations.size() + b.observations.size()));
}

std::string doubts(const MeasuredLength& measured, double rivalry, bool triangulated) {
  if (measured.points == 0 && !triangulated)
    return "depth is missing or behind: measured in the images alone, on the face through the given points";
  if (measured.support < weak_support && !triangulated)
    return fmt::format("depth is missing or behind over {:.0f} % of the face", 100.0 * (1.0 - measured.support));
  if (std::min(measured.keyframes_a, measured.keyframes_b) < static_cast<int>(few_keyframes))
    return "few keyframes show it";
  if (rivalry > clear_rivalry)
    return measured.kind == LengthKind::edges ? "another edge near it fits about as well"
                                              : "another surface near it fits about as well";
  return "";
}

/// State of one object's measurement, to keep parameter lists short.
class LengthSearch {
 public:
  LengthSearch(const Map& map, const LengthObject& object, const MapLengthOptions& options)
      : map_(map), object_(object), options_(options) {
    a_ = length_features(object, object.a, options);
    b_ = length_features(object, object.b, options);
    prior_.radius_m = object.radius_m;
  }

  MeasuredLength measure(TaskPool& pool) {
    find_in_views(pool);
    if (findings_.empty()) return not_measured(object_, "no keyframe shows it");
    if (without_depth_ && !triangulate(pool))
      return not_measured(object_, "needs depth: without it, only edges are measured");
    Found a = found(a_, 0), b = found(b_, a_.size());
    if (object_.kind == LengthKind::edges && std::min(a.observations.size(), b.observations.size()) < few_keyframes &&
        !without_depth_) {
      prior_.height_sigma_m = height_sigma_m;
      find_in_views(pool);
      a = found(a_, 0), b = found(b_, a_.size());
    }
    if (a.observations.empty() || b.observations.empty()) {
      const char* end = a.observations.empty() ? (b.observations.empty() ? "neither end" : "a") : "b";
      return not_measured(object_, fmt::format("{} was not found in {} keyframes", end, findings_.size()));
    }
    return combined(a, b);
  }

 private:
  LengthPosition position_of(const LengthFeature& feature) const {
    return {feature.spot, feature.normal_known ? std::optional<Vector3d>(feature.normal()) : std::nullopt};
  }

  bool by_depth() const { return prior_.height_sigma_m == 0.0; }

  /// Views from several sides tell the distance of an edge instead. False: the object has other features than edges.
  bool triangulate(TaskPool& pool) {
    for (const auto* features : {&a_, &b_})
      for (const LengthFeature& feature : *features)
        if (!feature.is_edge) return false;
    prior_.height_sigma_m = spot_sigma_share * object_.radius_m;
    find_in_views(pool);
    return true;
  }

  void find_in_views(TaskPool& pool) {
    const int count = without_depth_ ? triangulated_views * options_.views : options_.views;
    const std::vector<KeyframeId> views = choose_views(map_, position_of(a_.front()), position_of(b_.front()), count);
    findings_.assign(views.size(), {});
    pool.for_chunks(0, static_cast<int>(views.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const LengthView view = open_view(map_, views[static_cast<std::size_t>(i)]);
        ViewFinding& finding = findings_[static_cast<std::size_t>(i)];
        finding = {view.keyframe, view.has_depth(), {}};
        for (const auto* features : {&a_, &b_})
          for (const LengthFeature& feature : *features)
            finding.candidates.push_back(candidates_in(view, feature, object_.radius_m, options_, by_depth()));
      }
    });
    without_depth_ =
        std::none_of(findings_.begin(), findings_.end(), [](const ViewFinding& finding) { return finding.has_depth; });
  }

  Found found(const std::vector<LengthFeature>& features, std::size_t first) const {
    const Found one = agreed(findings_, first, features[0], prior_);
    if (features.size() == 1) return one;
    return crossing(one, agreed(findings_, first + 1, features[1], prior_));
  }

  MeasuredLength combined(const Found& a, const Found& b) const {
    const auto direction = measured_direction(object_.kind, a, b);
    if (!direction) return not_measured(object_, "both ends were found at the same position");
    // What is told by the views alone shall not be pulled to the given points.
    const double height_prior_m = without_depth_ ? object_.radius_m : height_sigma_m;
    const auto length = combine_lengths(along(a, findings_, *direction, height_prior_m),
                                        along(b, findings_, *direction, height_prior_m));
    if (!length) return not_measured(object_, "the keyframes contradict each other");
    MeasuredLength measured = not_measured(object_, "");
    measured.length_m = length->length_m;
    double variance = std::pow(length->sigma_m, 2) + a.wrong_position_variance + b.wrong_position_variance;
    // Without others that agree, a keyframe may well have selected another edge.
    if (std::min(length->seen_a, length->seen_b) < static_cast<int>(few_keyframes))
      variance += std::pow(unsure_share * object_.radius_m, 2);
    measured.sigma_m = std::sqrt(variance);
    measured.a = a.point;
    measured.b = b.point;
    measured.direction = *direction;
    measured.keyframes_a = length->seen_a;
    measured.keyframes_b = length->seen_b;
    measured.together = length->together;
    measured.scatter_m = length->scatter_m;
    for (const auto* found : {&a, &b})
      for (const auto& [finding, one] : found->observations) measured.points += one.points;
    measured.support = mean_support(a, b);
    measured.image = best_image(a, b, findings_);
    measured.note = doubts(measured, std::max(a.rivalry, b.rivalry), without_depth_);
    if (without_depth_ && length->height_sigma_m > weak_height_share * height_prior_m)
      measured.note = "seen from nearly one direction: its distance follows from the given points";
    return measured;
  }

  const Map& map_;
  const LengthObject& object_;
  const MapLengthOptions& options_;
  std::vector<LengthFeature> a_, b_;
  SearchPrior prior_;           ///< Without depth of the object, its faces are those through the given points.
  bool without_depth_ = false;  ///< No view has any depth.
  std::vector<ViewFinding> findings_;
};

}  // namespace

std::vector<MeasuredLength> measure_lengths(const Map& map, const std::vector<LengthObject>& objects,
                                            const MapLengthOptions& options, TaskPool& pool) {
  std::vector<MeasuredLength> measured;
  for (const LengthObject& object : objects) measured.push_back(LengthSearch(map, object, options).measure(pool));
  return measured;
}

}  // namespace rastro
