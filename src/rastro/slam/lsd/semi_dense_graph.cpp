// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/semi_dense_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/optimize/pose_graph.h"
#include "rastro/slam/lsd/map_depths.h"
#include "rastro/slam/lsd/scale_uncertainty.h"

namespace rastro {
namespace {

constexpr double alignment_scale_sigma = 0.01;  // of the logarithm, what all alignments have in common
constexpr double least_weight = 0.5;            // of an edge that was not switched off

SE3 rigid(const Sim3& pose) { return {pose.rotation(), pose.translation()}; }

}  // namespace

Matrix6d common_covariance(double mean_inverse_depth) {
  constexpr double sigma = 1e-3;
  Vector6d variances = Vector6d::Constant(sigma * sigma);
  if (mean_inverse_depth > 0.0) variances.head<3>() /= mean_inverse_depth * mean_inverse_depth;
  return variances.asDiagonal();
}

void SemiDenseGraph::add(std::shared_ptr<const SemiDenseKeyframe> keyframe, const Sim3& world_from_keyframe,
                         int submap) {
  RASTRO_CHECK(keyframe->id == size(), "keyframes are numbered as they come");
  keyframes_.push_back(std::move(keyframe));
  poses_.push_back(world_from_keyframe);
  submaps_.push_back(submap);
  links_.push_back({{}, false, std::numeric_limits<std::size_t>::max()});
  links_.back().bytes_in_map = rastro::bytes_in_map(*keyframes_.back(), options_);
  ++revision_;
}

void SemiDenseGraph::add_edge(const Constraint& edge) {
  Links &from = links_[static_cast<std::size_t>(edge.from)], &to = links_[static_cast<std::size_t>(edge.to)];
  if (edge.kind == ConstraintKind::odometry) {
    from.odometry.push_back(edge.to);
    to.odometry.push_back(edge.from);
    to.step = edges_.size();
    if (has_scale_errors_) to.scale_variance = from.scale_variance + beyond_drift(edge.scale_variance);
  } else if (edge.kind != ConstraintKind::proximity) {
    to.closes_loop = true;
  }
  edges_.push_back(edge);
}

double SemiDenseGraph::step_variance(std::int64_t id) const {
  const std::size_t step = links_[static_cast<std::size_t>(id)].step;
  return step < edges_.size() ? edges_[step].scale_variance : 0.0;
}

void SemiDenseGraph::know_scale(std::int64_t id, double scale_variance_of_new) {
  Links& links = links_[static_cast<std::size_t>(id)];
  if (!has_scale_errors_ || step_variance(id) <= scale_variance_of_new) return;
  Constraint& step = edges_[links.step];
  step.scale_variance = scale_variance_of_new;
  const double along = links_[static_cast<std::size_t>(step.from)].scale_variance + beyond_drift(scale_variance_of_new);
  links.scale_variance = std::min(links.scale_variance, along);
}

double SemiDenseGraph::beyond_drift(double scale_variance) const {
  constexpr double sigmas = 2.0;
  return std::max(0.0, scale_variance - std::pow(sigmas * options_.scale_drift_share, 2));
}

/// Shortest paths from the first keyframe of each submap.
void SemiDenseGraph::update_scale_errors() {
  std::set<int> begun;
  for (std::size_t k = 0; k < links_.size(); ++k)
    links_[k].scale_variance = begun.insert(submaps_[k]).second ? 0.0 : std::numeric_limits<double>::infinity();
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (const Constraint& edge : edges_) {
      if (edge.weight < least_weight) continue;
      double &from = links_[static_cast<std::size_t>(edge.from)].scale_variance,
             &to = links_[static_cast<std::size_t>(edge.to)].scale_variance;
      const double along = beyond_drift(edge.scale_variance);
      is_changed |= from + along < to || to + along < from;
      to = std::min(to, from + along);
      from = std::min(from, to + along);
    }
  }
}

/// Of the logarithm of each keyframe's scale relative to the mean of the map: the scale drifts from keyframe to
/// keyframe, and loops end that. Constraints between neighbors do not, as they compare the same images.
std::vector<double> SemiDenseGraph::map_scale_variances() const {
  const double drift = options_.scale_drift_share;
  if (metric_) return std::vector<double>(keyframes_.size(), 0.0);
  std::vector<ScaleLink> links;
  for (const Constraint& edge : edges_) {
    const bool is_step = edge.kind == ConstraintKind::odometry;
    if (!(drift > 0.0) || edge.kind == ConstraintKind::proximity || edge.weight < least_weight) continue;
    const double variance =
        is_step ? drift * drift : alignment_scale_sigma * alignment_scale_sigma + edge.scale_variance;
    links.push_back({static_cast<std::size_t>(edge.from), static_cast<std::size_t>(edge.to), variance});
  }
  std::vector<double> variances = scale_variances(keyframes_.size(), links);
  for (std::size_t k = 0; k < variances.size(); ++k)
    variances[k] += std::pow(scale_error(static_cast<std::int64_t>(k)), 2);  // in fast turns
  return variances;
}

std::vector<std::int64_t> SemiDenseGraph::within_steps(std::int64_t id, int steps) const {
  std::set<std::int64_t> reached = {id};
  std::vector<std::int64_t> last = {id};
  for (int step = 0; step < steps; ++step) {
    std::vector<std::int64_t> next;
    for (const std::int64_t at : last)
      for (const std::int64_t other : links_[static_cast<std::size_t>(at)].odometry)
        if (reached.insert(other).second) next.push_back(other);
    last = std::move(next);
  }
  reached.erase(id);
  return {reached.begin(), reached.end()};
}

void SemiDenseGraph::replace(std::shared_ptr<const SemiDenseKeyframe> keyframe) {
  const auto index = static_cast<std::size_t>(keyframe->id);
  links_[index].bytes_in_map = rastro::bytes_in_map(*keyframe, options_);
  keyframes_[index] = std::move(keyframe);
  ++revision_;
}

bool SemiDenseGraph::forget_oldest(std::int64_t kept) {
  for (std::int64_t id = 0; id < size() - kept; ++id) {
    const SemiDenseKeyframe& old = keyframe(id);
    if (old.image.empty()) continue;
    places_.remove(id);
    replace(std::make_shared<const SemiDenseKeyframe>(
        SemiDenseKeyframe{id, old.frame, old.stamp, {}, {}, old.mean_inverse_depth}));
    return true;
  }
  return false;
}

std::size_t SemiDenseGraph::bytes() const {
  constexpr std::size_t a_pixel = sizeof(std::uint8_t) + 2 * sizeof(float);
  std::size_t sum = edges_.size() * sizeof(Constraint) + frames_.size() * sizeof(PlacedFrame) +
                    keyframes_.size() * (sizeof(SemiDenseKeyframe) + sizeof(Sim3));
  for (const auto& keyframe : keyframes_)
    sum += static_cast<std::size_t>(keyframe->image.width()) * static_cast<std::size_t>(keyframe->image.height()) *
               a_pixel +
           keyframe->sensed.size() * sizeof(SensedDepth) +
           static_cast<std::size_t>(keyframe->mask.width()) * static_cast<std::size_t>(keyframe->mask.height()) +
           links_[static_cast<std::size_t>(keyframe->id)].bytes_in_map;
  return sum;
}

int SemiDenseGraph::new_submap() const {
  return submaps_.empty() ? 0 : *std::max_element(submaps_.begin(), submaps_.end()) + 1;
}

void SemiDenseGraph::merge(const Constraint& edge) {
  const int a = submap(edge.from), b = submap(edge.to);
  if (a == b) return;
  const Sim3 a_from_b = pose(edge.from) * edge.from_from_to * pose(edge.to).inverse();
  const int kept = std::min(a, b), moved = std::max(a, b);
  const Sim3 kept_from_moved = kept == a ? a_from_b : a_from_b.inverse();
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    if (submaps_[k] != moved) continue;
    poses_[k] = kept_from_moved * poses_[k];
    submaps_[k] = kept;
  }
}

/// The first keyframe of each submap, and those that are too far from `around`.
std::vector<std::uint8_t> SemiDenseGraph::fixed_poses(const std::optional<std::int64_t>& around) const {
  constexpr std::int64_t large = 150;
  constexpr int steps = 30;
  const bool has_window = around && size() > large;
  std::vector<std::uint8_t> fixed(poses_.size(), has_window ? 1 : 0);
  if (has_window) {
    fixed[static_cast<std::size_t>(*around)] = 0;
    for (const std::int64_t id : within_steps(*around, steps)) fixed[static_cast<std::size_t>(id)] = 0;
  }
  std::vector<int> anchored;
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    if (std::find(anchored.begin(), anchored.end(), submaps_[k]) != anchored.end()) continue;
    anchored.push_back(submaps_[k]);
    fixed[k] = 1;
  }
  return fixed;
}

void SemiDenseGraph::optimize(std::optional<std::int64_t> around) {
  const std::vector<std::uint8_t> fixed = fixed_poses(around);
  PoseGraphOptions options;
  options.iterations = options_.optimize_iterations;
  options.fix_scale = metric_;
  options.scale_information = 1.0 / (alignment_scale_sigma * alignment_scale_sigma);
  optimize_pose_graph(poses_, edges_, fixed, options);
  if (has_scale_errors_) update_scale_errors();
  ++revision_;
}

std::vector<std::int64_t> SemiDenseGraph::near(std::int64_t id, const Sim3& keyframe_from_pose, int most,
                                               const std::function<bool(std::int64_t)>& is_wanted) const {
  constexpr double reach_rad = 0.6, reach = 1.3;  // in mean distances and these, together
  const double per_unit = keyframe(id).mean_inverse_depth;
  const Sim3 pose_from_world = (pose(id) * keyframe_from_pose).inverse();
  std::vector<std::pair<double, std::int64_t>> found;
  for (std::int64_t other = 0; other < size(); ++other) {
    if (other == id || submap(other) != submap(id) || keyframe(other).image.empty()) continue;
    if (is_wanted && !is_wanted(other)) continue;
    const Sim3 pose_from_other = pose_from_world * pose(other);
    const double distance =
        per_unit * pose_from_other.translation().norm() + pose_from_other.rotation().log().norm() / reach_rad;
    if (distance < reach) found.emplace_back(distance, other);
  }
  std::sort(found.begin(), found.end());
  std::vector<std::int64_t> ids;
  for (const auto& [distance, other] : found)
    if (static_cast<int>(ids.size()) < most) ids.push_back(other);
  return ids;
}

std::vector<std::int64_t> SemiDenseGraph::similar(const BagOfWords& words, int most,
                                                  const std::function<bool(std::int64_t)>& is_wanted) const {
  constexpr double least_share = 0.8;  // of the words shared with the most similar one
  std::vector<std::int64_t> ids;
  for (const PlaceMatch& match : places_.find(words, least_share, is_wanted))
    if (static_cast<int>(ids.size()) < most) ids.push_back(match.id);
  return ids;
}

SE3 SemiDenseGraph::pose_of(const PlacedFrame& frame) const {
  return rigid(pose(frame.keyframe) * Sim3(frame.keyframe_from_camera));
}

double SemiDenseGraph::reach_from(std::int64_t id, double drift, int missed) const {
  constexpr double faster = 5.0;  // than on average
  double whole = 0.0, since = 0.0;
  int steps = 0;
  for (std::size_t k = 1; k < frames_.size(); ++k) {
    if (submap(frames_[k].keyframe) != submap(frames_[k - 1].keyframe)) continue;
    const double step = (pose_of(frames_[k]).translation() - pose_of(frames_[k - 1]).translation()).norm();
    whole += step, ++steps;
    if (frames_[k].index > keyframe(id).frame) since += step;
  }
  return drift * since + faster * whole / std::max(1, steps) * missed;
}

int SemiDenseGraph::largest_submap() const {
  std::map<int, std::size_t> frames;
  for (const PlacedFrame& frame : frames_) ++frames[submap(frame.keyframe)];
  int largest = 0;
  for (const auto& [submap, count] : frames)
    if (count > frames[largest]) largest = submap;
  return largest;
}

/// The submap with most frames is renumbered to 0.
int SemiDenseGraph::public_submap(int submap, int largest) const {
  return submap == largest ? 0 : submap < largest ? submap + 1 : submap;
}

Trajectory SemiDenseGraph::trajectory() const {
  const int largest = largest_submap();
  Trajectory trajectory;
  for (const PlacedFrame& frame : frames_)
    if (submap(frame.keyframe) == largest) trajectory.push_back({frame.stamp, pose_of(frame)});
  return trajectory;
}

/// In the world's unit, with the scale that is left between both.
Constraint SemiDenseGraph::public_form(const Constraint& edge) const {
  const double from_unit = pose(edge.from).scale(), to_unit = pose(edge.to).scale();
  Constraint result = edge;
  result.from_from_to = Sim3(edge.from_from_to.scale() * from_unit / to_unit, edge.from_from_to.rotation(),
                             from_unit * edge.from_from_to.translation());
  result.information.topLeftCorner<3, 3>() /= to_unit * to_unit;
  result.information.topRightCorner<3, 3>() /= to_unit;
  result.information.bottomLeftCorner<3, 3>() /= to_unit;
  return result;
}

std::shared_ptr<const Map> SemiDenseGraph::snapshot(const LsdSensor& sensor, KnownMapDepths* known) const {
  auto map = std::make_shared<Map>();
  map->method = "lsd";
  map->revision = revision_;
  map->cameras.push_back({sensor.kind, sensor.camera, sensor.baseline, sensor.depth_noise(options_), SE3()});
  const int largest = largest_submap();
  auto depths = std::make_shared<SemiDenseLayer>();
  const std::vector<double> scale_variances = map_scale_variances();
  std::map<int, KeyframeId> last_of;
  for (std::int64_t id = 0; id < size(); ++id) {
    const SemiDenseKeyframe& kept = keyframe(id);
    const auto before = last_of.find(submap(id));
    map->keyframes.push_back({id, kept.frame, kept.stamp, 0, rigid(pose(id)), public_submap(submap(id), largest),
                              before == last_of.end() ? no_keyframe : before->second, 1.0});
    last_of[submap(id)] = id;
    if (kept.image.empty()) continue;
    const KeyframeScale scale{pose(id).scale(), scale_variances[static_cast<std::size_t>(id)]};
    depths->of[id] = known ? known->of(keyframes_[static_cast<std::size_t>(id)], scale, options_)
                           : depths_in_map(kept, scale, options_);
  }
  map->layers.put<SemiDenseLayer>(std::move(depths));
  for (const Constraint& edge : edges_) map->constraints.push_back(public_form(edge));
  for (const PlacedFrame& frame : frames_) {
    const double unit = pose(frame.keyframe).scale();
    map->frames.push_back(
        {frame.stamp, frame.keyframe,
         SE3(frame.keyframe_from_camera.rotation(), unit * frame.keyframe_from_camera.translation())});
  }
  if (!frames_.empty())
    map->sessions.push_back({0, 0, "", frames_.front().stamp, frames_.back().stamp, sensor.scale()});
  return map;
}

}  // namespace rastro
