// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/mapper.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr double bytes_per_mb = 1e6;

std::size_t bytes_of(const ImageFeatures& keyframe) {
  const Features& features = keyframe.features;
  return sizeof(ImageFeatures) + features.size() * (sizeof(Keypoint) + sizeof(float)) +
         features.floats.size() * sizeof(float) + features.descriptors.size() * sizeof(Descriptor);
}

std::size_t ceiling_of(const RgbdSlamOptions& options, std::size_t max_memory_bytes) {
  if (max_memory_bytes == 0) return 0;
  constexpr double least_mb = 16.0;
  const double left_mb = static_cast<double>(max_memory_bytes) / bytes_per_mb - options.memory_reserve_mb;
  return static_cast<std::size_t>(std::max(least_mb, left_mb) * bytes_per_mb);
}

/// Depth where the mask lets it be.
Frame masked(const Frame& frame) {
  Frame result = frame;
  for (int y = 0; y < std::min(frame.mask.height(), result.depth.height()); ++y) {
    for (int x = 0; x < std::min(frame.mask.width(), result.depth.width()); ++x) {
      if (frame.mask.at(x, y) == 0) result.depth.at(x, y) = 0.0F;
    }
  }
  return result;
}

std::shared_ptr<const PictureStore> pictures_of(const SlamContext& context,
                                                const std::shared_ptr<MemoryPictures>& in_memory) {
  if (context.map) return images_of(*context.map);
  if (context.archive != nullptr) return context.archive->images();
  return in_memory;
}

}  // namespace

Mapper::Mapper(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context)
    : options_(options),
      camera_(camera),
      archive_(context.map ? nullptr : context.archive),
      maps_(context.map == nullptr),
      ceiling_bytes_(ceiling_of(options, context.max_memory_bytes)),
      in_memory_(std::make_shared<MemoryPictures>()),
      pictures_(pictures_of(context, in_memory_)),
      matcher_(options, camera),
      depths_(matcher_.surfaces(), pictures_),
      features_(options),
      graph_(options, context.map ? static_cast<std::int64_t>(context.map->keyframes.size()) : 0) {
  if (!context.map) return;
  const auto features = context.map->layer<FeatureLayer>();
  for (const Keyframe& keyframe : context.map->keyframes)
    graph_.add(features->of.at(keyframe.id), {keyframe.world_from_camera, keyframe.submap}, Matrix6d::Zero());
  for (const Constraint& edge : context.map->constraints) graph_.add_edge(edge);
}

MapRevision Mapper::add(const KeyframeOrder& order) {
  RASTRO_CHECK(order.id == graph_.size(), "keyframes come in their order");
  MapRevision revision;
  ImageFeatures keyframe = features_.extract(order.frame);
  keyframe.id = order.id;
  keep(order, std::move(keyframe));
  for (const Constraint& edge : order.ties) add_edge(edge, revision);
  graph_.settle_covariance(order.id);
  tie(order.id, revision);
  stay_below_ceiling(revision);
  revision.keyframe = graph_.shared_keyframe(order.id);
  revision.covariance = graph_.covariance(order.id);
  revise(revision);
  return revision;
}

/// Where the tracker has it relative to what it is tied to, as the graph has moved since.
void Mapper::keep(const KeyframeOrder& order, ImageFeatures keyframe) {
  KeyframePose pose{order.world_from_camera, order.submap};
  if (!order.ties.empty()) {
    const Constraint& edge = order.ties.front();
    pose = {graph_.pose(edge.from) * edge.rigid(), graph_.submap(edge.from)};
  }
  auto kept = std::make_shared<const ImageFeatures>(std::move(keyframe));
  const Frame shown = masked(order.frame);
  depths_.add(order.id, shown.depth);
  bytes_ += bytes_of(*kept);
  graph_.add(kept, pose, Matrix6d::Zero());
  if (!maps_) return;
  PackedPictures pictures = pack_pictures(shown);
  if (archive_ != nullptr) {
    archive_->add_images(order.id, std::move(pictures));
  } else {
    in_memory_->add(order.id, std::move(pictures));
  }
}

void Mapper::add_edge(const Constraint& edge, MapRevision& revision) {
  graph_.add_edge(edge);
  revision.new_edges.push_back(edge);
}

std::optional<Constraint> Mapper::compare(std::int64_t other, std::int64_t id) {
  const auto view = [this](std::int64_t k) {
    return ViewOfKeyframe{&graph_.keyframe(k), [this, k] { return depths_.depth(k); }};
  };
  const bool joins = graph_.submap(other) != graph_.submap(id);
  std::optional<SE3> guess;
  if (!joins) guess = graph_.pose(other).inverse() * graph_.pose(id);
  const std::uint64_t seed =
      seed_for(seed_for(options_.follow.seed, static_cast<std::uint64_t>(id)), static_cast<std::uint64_t>(other));
  const auto tie =
      matcher_.match(view(other), view(id), joins ? options_.relocalise_inliers : options_.min_inliers, seed, guess);
  if (!tie) return std::nullopt;
  Constraint edge{other, id, Sim3(tie->a_from_b), tie->information, ConstraintKind::proximity, 1.0, tie->inliers};
  if (joins) {
    edge.kind = ConstraintKind::merge;
  } else if (other < graph_.frozen() || graph_.steps_between(other, id, options_.loop_steps) >= options_.loop_steps) {
    edge.kind = ConstraintKind::loop;
  }
  return edge;
}

void Mapper::tie(std::int64_t id, MapRevision& revision) {
  Random random(seed_for(options_.follow.seed, static_cast<std::uint64_t>(id)));
  std::vector<Constraint> found;
  for (const std::int64_t other : graph_.candidates(id, random)) {
    if (auto edge = compare(other, id)) found.push_back(*edge);
  }
  int loops = 0, joins = 0;
  for (const Constraint& edge : found) {
    if (edge.kind == ConstraintKind::merge && maps_) {
      ++joins;
      revision.events.push_back(
          {"joined", fmt::format("submaps {} and {} by keyframes {} and {}", graph_.submap(edge.from),
                                 graph_.submap(edge.to), edge.from, edge.to)});
      graph_.join(edge);
    }
    loops += edge.kind == ConstraintKind::loop ? 1 : 0;
    add_edge(edge, revision);
  }
  if (found.empty() || id == 0) return;
  const bool all = maps_ && (loops > 0 || joins > 0);
  const PoseGraphResult result = graph_.optimize(all);
  graph_.settle_covariance(id);
  if (loops > 0 && maps_)
    revision.events.push_back(
        {"loop_closed", fmt::format("keyframe {} found again in {} seen long before", id, loops)});
  if (all)
    revision.events.push_back({"map_revised", fmt::format("{} keyframes, cost {:.1f} to {:.1f}", graph_.size(),
                                                          result.first_cost, result.last_cost)});
}

/// By what the map is known to take, not by what the system says, which differs from run to run.
void Mapper::stay_below_ceiling(MapRevision& revision) {
  if (ceiling_bytes_ == 0) return;
  while (bytes_ > ceiling_bytes_ && next_forgotten_ < graph_.size() - options_.graph_window) {
    bytes_ -= bytes_of(graph_.keyframe(next_forgotten_));
    graph_.forget_features(next_forgotten_);
    revision.forgotten.push_back(next_forgotten_++);
  }
  if (!revision.forgotten.empty())
    revision.events.push_back(
        {"memory", fmt::format("features of keyframes up to {} given up to stay below {:.0f} MB",
                               revision.forgotten.back(), static_cast<double>(ceiling_bytes_) / bytes_per_mb)});
}

void Mapper::revise(MapRevision& revision) const {
  revision.poses = graph_.keyframe_poses();
  for (const Constraint& edge : graph_.edges()) revision.weights.push_back(edge.weight);
}

MapRevision Mapper::settle() {
  MapRevision revision;
  if (maps_ && graph_.size() > 1) {
    const PoseGraphResult result = graph_.optimize(true);
    revision.events.push_back({"map_revised", fmt::format("{} keyframes at the end, cost {:.1f} to {:.1f}",
                                                          graph_.size(), result.first_cost, result.last_cost)});
  }
  revise(revision);
  return revision;
}

}  // namespace rastro
