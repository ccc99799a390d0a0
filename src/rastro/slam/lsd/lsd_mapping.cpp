// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_mapping.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "rastro/base/stopwatch.h"
#include "rastro/slam/map_budget.h"

namespace rastro {
namespace {

constexpr double memory_reserve_mb = 100.0;  // for everything except the map

/// Of the new keyframe relative to the one before, in the new one's unit.
Constraint edge_to_new(std::int64_t before, std::int64_t id, const Sim3& before_from_new, double mean_inverse_depth,
                       const ImageAlignment& tracked) {
  const double unit = before_from_new.scale();
  const Matrix6d to_new = tracked.image_from_reference.adjoint();
  Matrix6d covariance = to_new * tracked.covariance * to_new.transpose();
  covariance.topLeftCorner<3, 3>() /= unit * unit;
  covariance.topRightCorner<3, 3>() /= unit;
  covariance.bottomLeftCorner<3, 3>() /= unit;
  covariance += common_covariance(mean_inverse_depth);
  Constraint edge{before, id, before_from_new, covariance.inverse()};
  edge.inliers = tracked.points;
  return edge;
}

}  // namespace

LsdMapping::LsdMapping(const LsdOptions& options, const LsdSensor& sensor, const LsdFrameMaker& frames,
                       const SlamContext& context)
    : options_(options),
      sensor_(sensor),
      frames_(frames),
      pool_(context.pool),
      graph_(options, sensor.is_metric()),
      constraints_(options, sensor, graph_),
      features_(OrbOptions{}),
      budget_bytes_(map_budget_bytes(context, memory_reserve_mb)) {}

void LsdMapping::begin_map(CurrentKeyframe first, SlamUpdate& update) {
  if (current_) finish_keyframe(update);
  const std::int64_t id = first.id();
  const int submap = graph_.new_submap();
  current_.emplace(std::move(first));
  graph_.add(current_->published(), Sim3(), submap);
  uncertainty_.set_known(id, Eigen::Vector3d::Zero());
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  if (submap > 0) update.events.push_back({"submap", fmt::format("{} begins with keyframe {}", submap, id)});
}

bool LsdMapping::needs_keyframe(const ImageAlignment& tracked) const {
  const double distance = tracked.image_from_reference.inverse().translation().norm();
  // Depths are shown once two frames saw them: a keyframe that ends before that has fewer than the one before it.
  const bool is_new = current_->frames() < options_.keyframe_frames;
  const double overlap = is_new ? 0.5 * (options_.keyframe_overlap + options_.min_overlap) : options_.keyframe_overlap;
  return tracked.rms < options_.keyframe_residual &&
         (distance * current_->mean_inverse_depth() > options_.keyframe_distance || tracked.overlap < overlap);
}

double LsdMapping::change_keyframe(const LsdFrame& frame, const ImageAlignment& tracked, const SE3& depth_from_color,
                                   SlamUpdate& update) {
  finish_keyframe(update);
  const std::int64_t before = current_->id(), id = graph_.size();
  const Sim3 before_from_new = current_->change_to(id, frame, tracked, depth_from_color);
  graph_.add(current_->published(), graph_.pose(before) * before_from_new, graph_.submap(before));
  graph_.add_edge(edge_to_new(before, id, before_from_new, current_->mean_inverse_depth(), tracked));
  if (update.covariance) uncertainty_.set(id, graph_.pose(id).translation(), *update.covariance);
  stay_within_budget(update);
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  return before_from_new.scale();
}

void LsdMapping::return_to(CurrentKeyframe earlier, SlamUpdate& update) {
  finish_keyframe(update);
  current_.emplace(std::move(earlier));
}

void LsdMapping::finish_keyframe(SlamUpdate& update) {
  Stopwatch stage;
  const auto finished = current_->published();
  graph_.replace(finished);
  const BagOfWords words = words_of(finished->image.view(), finished->mask.view());
  connect(finished->id, words, update);
  graph_.add_words(finished->id, words);
  update.times.push_back({"constraints", stage.lap_ms()});
}

void LsdMapping::connect(std::int64_t id, const BagOfWords& words, SlamUpdate& update) {
  const std::vector<Constraint> found = constraints_.find(id, words);
  for (const Constraint& edge : found) {
    if (graph_.submap(edge.from) != graph_.submap(id)) {
      update.events.push_back({"joined", fmt::format("submaps {} and {} by keyframes {} and {}",
                                                     graph_.submap(edge.from), graph_.submap(id), edge.from, id)});
      graph_.merge(edge);
    }
    if (edge.kind == ConstraintKind::loop)
      update.events.push_back({"loop_closed", fmt::format("keyframe {} with {}", id, edge.from)});
    graph_.add_edge(edge);
  }
  if (!found.empty()) graph_.optimize();
}

CurrentKeyframe LsdMapping::restored_keyframe(std::int64_t id) const {
  const SemiDenseKeyframe& known = graph_.keyframe(id);
  return {options_,    sensor_, pool_, id, frames_.from_image(known.frame, known.stamp, known.image, known.mask),
          &known.depth};
}

SE3 LsdMapping::pose_of(const SE3& camera_from_keyframe) const {
  return graph_.pose_of({0, 0, current_->id(), camera_from_keyframe.inverse()});
}

std::optional<Matrix6d> LsdMapping::covariance_of(const ImageAlignment& tracked, const SE3& world_from_camera) const {
  const std::int64_t id = current_->id();
  if (graph_.submap(id) != 0) return std::nullopt;
  return uncertainty_.of_frame(id, graph_.pose(id).scale(), current_->mean_inverse_depth(), world_from_camera, tracked);
}

void LsdMapping::doubt(SlamUpdate& update) const {
  constexpr std::int64_t until_converged = 5;  // keyframes
  const std::int64_t id = current_->id();
  if (graph_.submap(id) != 0) {
    update.reason = SlamReason::apart;
    update.detail = fmt::format("in submap {}, not connected to the first yet", graph_.submap(id));
  } else if (options_.start == "random" && id < until_converged) {
    update.reason = SlamReason::unconfirmed;
    update.detail = "depths that began at random have not converged yet";
  } else {
    return;
  }
  update.state = SlamState::weak;
}

/// The oldest keyframes keep their poses only.
void LsdMapping::stay_within_budget(SlamUpdate& update) {
  constexpr std::int64_t kept = 3;
  if (budget_bytes_ == 0) return;
  const std::int64_t before = forgotten_;
  const auto most = static_cast<std::size_t>(MapBudget::full_share * static_cast<double>(budget_bytes_));
  while (graph_.bytes() > most && graph_.forget_oldest(kept)) ++forgotten_;
  if (forgotten_ > before) update.events.push_back({"memory", memory().measures});
}

MapMemory LsdMapping::memory() const {
  return {graph_.bytes(), budget_bytes_,
          forgotten_ == 0 ? std::string() : fmt::format("depths of the {} oldest keyframes dropped", forgotten_)};
}

BagOfWords LsdMapping::words_of(GrayView image, GrayView mask) {
  BagOfWords words = standard_vocabulary()->words_of(features_.extract(image, mask, pool_).descriptors);
  words.nodes = {};
  return words;
}

}  // namespace rastro
