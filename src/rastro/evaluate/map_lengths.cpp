// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/map_lengths.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/evaluate/length_combine.h"
#include "rastro/evaluate/length_feature.h"
#include "rastro/evaluate/length_views.h"
#include "rastro/evaluate/length_vote.h"

namespace rastro {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double unsure_share = 0.3;    ///< Share of the radius: possible error of an edge seen in very few keyframes.
constexpr double clear_rivalry = 0.75;  ///< A competing offset that fits this well is reported.
constexpr double height_sigma_m = 0.015;    ///< Of a rough face that has no depth in a map with depth.
constexpr int triangulated_views = 2;       ///< So many times the views, where edges are triangulated.
constexpr double weak_height_share = 0.25;  ///< Share of its prior: above, the views do not tell a distance.
constexpr double weak_support = 0.5;        ///< Below, depth is reported as missing or behind.
constexpr std::size_t few_keyframes = 3;

/// The measured direction; nullopt if the two features coincide.
std::optional<Vector3d> measured_direction(LengthKind kind, const FoundFeature& a, const FoundFeature& b) {
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

LengthObservations along(const FoundFeature& found, const std::vector<LengthFinding>& findings,
                         const Vector3d& direction, double height_sigma_m) {
  LengthObservations observations;
  for (const auto& [finding, one] : found.observations) {
    observations.all.push_back({findings[finding].keyframe, direction.dot(one.point),
                                std::sqrt(std::max(0.0, direction.dot(one.covariance * direction))), one.shared_m,
                                direction.dot(one.lever)});
  }
  // The points are where they would be at the height with the most votes. What is solved for is by how much that is too
  // high: as much as it is above the rough face, as far as the prior knows.
  observations.height_m = found.height_m;
  observations.height_sigma_m = height_sigma_m;
  return observations;
}

/// The keyframe with the best view: both features, with high scores.
LengthImage best_image(const FoundFeature& a, const FoundFeature& b, const std::vector<LengthFinding>& findings) {
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

double mean_support(const FoundFeature& a, const FoundFeature& b) {
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
    FoundFeature a = found(a_, 0), b = found(b_, a_.size());
    if (object_.kind == LengthKind::edges && std::min(a.observations.size(), b.observations.size()) < few_keyframes &&
        !without_depth_) {
      prior_.height_sigma_m = height_sigma_m;
      find_in_views(pool);
      a = found(a_, 0), b = found(b_, a_.size());
    }
    if (a.observations.empty() || b.observations.empty()) {
      const char* what =
          a.observations.empty() ? (b.observations.empty() ? "neither end was" : "a was not") : "b was not";
      return not_measured(object_, fmt::format("{} found in {} keyframes", what, findings_.size()));
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
    prior_.height_sigma_m = LengthPrior::spot_sigma_share * object_.radius_m;
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
        LengthFinding& finding = findings_[static_cast<std::size_t>(i)];
        finding = {view.keyframe, view.has_depth(), {}};
        for (const auto* features : {&a_, &b_})
          for (const LengthFeature& feature : *features)
            finding.candidates.push_back(length_candidates(view, feature, object_.radius_m, options_, by_depth()));
      }
    });
    without_depth_ = std::none_of(findings_.begin(), findings_.end(),
                                  [](const LengthFinding& finding) { return finding.has_depth; });
  }

  FoundFeature found(const std::vector<LengthFeature>& features, std::size_t first) const {
    const FoundFeature one = agreed_feature(findings_, first, features[0], prior_);
    if (features.size() == 1) return one;
    return crossing_of(one, agreed_feature(findings_, first + 1, features[1], prior_));
  }

  MeasuredLength combined(const FoundFeature& a, const FoundFeature& b) const {
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
  LengthPrior prior_;           ///< Without depth of the object, its faces are those through the given points.
  bool without_depth_ = false;  ///< No view has any depth.
  std::vector<LengthFinding> findings_;
};

}  // namespace

std::vector<MeasuredLength> measure_lengths(const Map& map, const std::vector<LengthObject>& objects,
                                            const MapLengthOptions& options, TaskPool& pool) {
  std::vector<MeasuredLength> measured;
  for (const LengthObject& object : objects) measured.push_back(LengthSearch(map, object, options).measure(pool));
  return measured;
}

}  // namespace rastro
