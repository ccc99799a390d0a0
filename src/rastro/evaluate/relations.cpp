// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/relations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

constexpr std::size_t columns = 8;
constexpr const char* form = "write 'stamp_a stamp_b x y z roll pitch yaw'";

TimeNs stamp_in(std::string_view word, const std::string& where) {
  const auto stamp = parse_stamp(word, StampUnit::seconds);
  if (!stamp || *stamp < -largest_stamp || *stamp > largest_stamp)
    throw Error(fmt::format("the stamp {} is not a number of seconds", in_quotes(word)), where, form);
  return *stamp;
}

double number_in(std::string_view word, const std::string& where) {
  const auto number = parse_finite(word);
  if (!number || std::abs(*number) > 1e9)
    throw Error(fmt::format("{} is not a plausible number", in_quotes(word)), where, form);
  return *number;
}

SO3 rotation_of(double roll, double pitch, double yaw) {
  using Eigen::Vector3d;
  return SO3::exp(yaw * Vector3d::UnitZ()) * SO3::exp(pitch * Vector3d::UnitY()) * SO3::exp(roll * Vector3d::UnitX());
}

Relation relation_of(const std::vector<std::string_view>& words, const std::string& where) {
  if (words.size() != columns) throw Error(fmt::format("{} columns instead of {}", words.size(), columns), where, form);
  double value[6];
  for (std::size_t k = 0; k < 6; ++k) value[k] = number_in(words[k + 2], where);
  return {stamp_in(words[0], where), stamp_in(words[1], where),
          SE3(rotation_of(value[3], value[4], value[5]), {value[0], value[1], value[2]})};
}

/// The pose nearest in time; null if none is within `max_difference`.
const StampedPose* pose_near(const Trajectory& trajectory, TimeNs stamp, TimeNs max_difference) {
  const auto difference = [stamp](const StampedPose& pose) { return std::abs(pose.stamp - stamp); };
  const auto earlier = [](const StampedPose& pose, TimeNs time) { return pose.stamp < time; };
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp, earlier);
  const StampedPose* nearest = after == trajectory.end() ? nullptr : &*after;
  if (after != trajectory.begin()) {
    const StampedPose& before = *std::prev(after);
    if (nearest == nullptr || difference(before) < difference(*nearest)) nearest = &before;
  }
  return nearest != nullptr && difference(*nearest) <= max_difference ? nearest : nullptr;
}

struct Sum {
  std::vector<double> values;

  double mean() const {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
  }
  double sigma() const {
    const double middle = mean();
    double sum = 0.0;
    for (const double value : values) sum += (value - middle) * (value - middle);
    return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
  }
  double largest() const { return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end()); }
};

}  // namespace

std::vector<Relation> parse_relations(std::string_view text, std::string_view where) {
  std::vector<Relation> relations;
  for (const TextLine& line : content_lines(text))
    relations.push_back(relation_of(split_words(line.text), at_line(where, line.number)));
  if (relations.empty()) throw Error("has no relations", where, form);
  return relations;
}

RelationScores score_relations(const std::vector<Relation>& relations, const Trajectory& trajectory,
                               TimeNs max_difference) {
  RelationScores scores;
  Sum translation, rotation;
  for (const Relation& relation : relations) {
    const StampedPose* a = pose_near(trajectory, relation.stamp_a, max_difference);
    const StampedPose* b = pose_near(trajectory, relation.stamp_b, max_difference);
    if (a == nullptr || b == nullptr) {
      ++scores.skipped;
      continue;
    }
    const SE3 error = relation.a_from_b.inverse() * (a->world_from_body.inverse() * b->world_from_body);
    translation.values.push_back(error.translation().norm());
    rotation.values.push_back(error.rotation().log().norm() * 180.0 / std::numbers::pi);
    scores.worst_dt =
        std::max({scores.worst_dt, std::abs(a->stamp - relation.stamp_a), std::abs(b->stamp - relation.stamp_b)});
  }
  scores.relations = static_cast<std::int64_t>(translation.values.size());
  scores.trans_mean_m = translation.mean();
  scores.trans_sigma_m = translation.sigma();
  scores.rot_mean_deg = rotation.mean();
  scores.rot_sigma_deg = rotation.sigma();
  scores.worst_trans_m = translation.largest();
  return scores;
}

}  // namespace rastro
