// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/mapper.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <span>
#include <utility>

#include "rastro/backend/acceptance.h"
#include "rastro/backend/rgbd/given_map.h"
#include "rastro/base/error.h"
#include "rastro/base/memory.h"
#include "rastro/optimize/pose_graph.h"

namespace rastro {
namespace {

std::size_t bytes_of(const ImageFeatures& keyframe) {
  const Features& features = keyframe.features;
  return sizeof(ImageFeatures) + features.size() * (sizeof(Keypoint) + sizeof(float)) +
         features.floats.size() * sizeof(float) + features.descriptors.size() * sizeof(Descriptor);
}

bool makes_map(const SlamContext& context) { return !context.map || context.extend_map; }

/// Where the camera is, is known by then: comparing with further places would take time and say little.
bool closes_enough(const std::vector<Constraint>& accepted) {
  constexpr std::ptrdiff_t enough = 3;
  return std::count_if(accepted.begin(), accepted.end(),
                       [](const Constraint& edge) { return edge.to - edge.from > most_tracked_steps; }) >= enough;
}

/// Features and surfaces fit, and yet it is not there.
bool is_of_another_place(Rejection rejection) {
  return rejection == Rejection::contradicts_graph || rejection == Rejection::looks_different;
}

/// Depth where the mask allows it.
Frame masked(const Frame& frame) {
  Frame result = frame;
  for (int y = 0; y < std::min(frame.mask.height(), result.depth.height()); ++y) {
    for (int x = 0; x < std::min(frame.mask.width(), result.depth.width()); ++x) {
      if (frame.mask.at(x, y) == 0) result.depth.at(x, y) = 0.0F;
    }
  }
  return result;
}

/// Of a given map, and of the keyframes that localization made beside it, which are in no map.
class LocalizationImages : public ImageStore {
 public:
  LocalizationImages(const Map& given, std::shared_ptr<const ImageStore> made)
      : given_(images_of(given)), of_given_(static_cast<KeyframeId>(given.keyframes.size())), made_(std::move(made)) {}
  PackedImages read(KeyframeId keyframe) const override {
    return (keyframe < of_given_ ? given_ : made_)->read(keyframe);
  }

 private:
  std::shared_ptr<const ImageStore> given_;
  KeyframeId of_given_;
  std::shared_ptr<const ImageStore> made_;
};

std::shared_ptr<const ImageStore> packed_images_of(const SlamContext& context,
                                                   const std::shared_ptr<MemoryImages>& in_memory) {
  if (!makes_map(context)) return std::make_shared<LocalizationImages>(*context.map, in_memory);
  if (context.archive != nullptr) return context.archive->images();
  return in_memory;
}

std::shared_ptr<const SignatureStore> signatures_of(const SlamContext& context,
                                                    const std::shared_ptr<MemorySignatures>& in_memory) {
  const bool stores = makes_map(context) && context.archive != nullptr;
  const auto rows = stores ? context.archive->rows(SignatureLayer::layer_name) : nullptr;
  if (rows) return signatures_in(rows);
  return in_memory;
}

/// How many of what can be made again are cached: a budget has an eighth for them.
std::size_t cached(std::size_t usual, std::size_t bytes_each, const MapBudget& budget) {
  constexpr std::size_t fewest = 8, share = 8;
  if (!budget.limited() || bytes_each == 0) return usual;
  return std::clamp(budget.bytes() / share / bytes_each, fewest, usual);
}

}  // namespace

Mapper::Mapper(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context,
               std::unique_ptr<LoopSearch> search)
    : options_(options),
      camera_(camera),
      archive_(makes_map(context) ? context.archive : nullptr),
      stop_(context.stop),
      maps_(makes_map(context)),
      budget_(map_budget_bytes(context, options.memory_reserve_mb)),
      in_memory_{std::make_shared<MemoryImages>()},
      images_(packed_images_of(context, in_memory_.images)),
      matcher_(options, camera),
      depths_(matcher_.surfaces(), images_, cached(DepthStore::usual_most, matcher_.surfaces().bytes(), budget_)),
      proof_{
          AppearanceCheck(camera, depth_noise(options)),
          AppearanceStore(proof_.check, images_, cached(AppearanceStore::usual_most, proof_.check.bytes(), budget_))},
      features_(options),
      graph_(options, maps_ ? 0 : static_cast<std::int64_t>(context.map->keyframes.size())),
      search_(search ? std::move(search) : std::make_unique<GraphSearch>(options)) {
  if (search_->has_long_term_memory()) {
    in_memory_.signatures = std::make_shared<MemorySignatures>();
    signatures_ = signatures_of(context, in_memory_.signatures);
  }
  if (context.map) take_over(context.map);
}

void Mapper::take_over(const std::shared_ptr<const Map>& map) {
  const auto features = map->layer<FeatureLayer>();
  for (const Keyframe& keyframe : map->keyframes) {
    graph_.add(features->of.at(keyframe.id), {keyframe.world_from_camera, keyframe.submap}, Matrix6d::Zero());
    if (!signatures_) continue;
    const Signature signature = signature_of(*map, keyframe.id);
    if (!maps_) in_memory_.signatures->add(keyframe.id, signature);
    if (graph_.keyframe(keyframe.id).features.size() < signature.image->features.size()) ++given_up_;
    search_->know(signature, keyframe.weight);
  }
  for (const Constraint& edge : map->constraints) graph_.add_edge(edge);
  graph_.learn_noise();
  search_->know_constraints(map->constraints);
  if (maps_) continued_ = map;
}

/// A map that is continued goes into the new file whole.
void Mapper::store_continued() {
  const auto map = std::exchange(continued_, nullptr);
  if (!map) return;
  const auto images = images_of(*map);
  for (const Keyframe& keyframe : map->keyframes) {
    keep_images(keyframe.id, images->read(keyframe.id));
    if (signatures_) store_signature(keyframe.id, signature_of(*map, keyframe.id));
  }
}

MapRevision Mapper::add(const KeyframeOrder& order) {
  RASTRO_CHECK(order.id == graph_.size(), "keyframes come in their order");
  MapRevision revision;
  store_continued();
  ImageFeatures keyframe = features_.extract(order.frame, feature_share());
  keyframe.id = order.id;
  keep(order, std::move(keyframe));
  if (order.constraint) add_edge(*order.constraint, revision);
  graph_.settle_covariance(order.id);
  constrain(order.id, revision);
  frames_ = order.frames;
  stay_within_budget(revision);
  revision.keyframe = graph_.shared_keyframe(order.id);
  revision.covariance = graph_.covariance(order.id);
  revise(revision);
  return revision;
}

MapRevision Mapper::connect(Constraint edge) {
  MapRevision revision;
  if (graph_.steps_between(edge.from, edge.to, options_.loop_steps) >= options_.loop_steps)
    edge.kind = ConstraintKind::loop;
  accept(edge, revision);
  search_->know_constraints(std::span<const Constraint>(&edge, 1));
  correct(graph_.size() - 1, {edge}, revision);
  revise(revision);
  return revision;
}

/// Its pose from the tracker, relative to the keyframe of its constraint, since the graph may have moved.
void Mapper::keep(const KeyframeOrder& order, ImageFeatures keyframe) {
  KeyframePose pose{order.world_from_camera, order.submap};
  if (order.constraint) {
    const Constraint& edge = *order.constraint;
    pose = {graph_.pose(edge.from) * edge.rigid(), graph_.submap(edge.from)};
  }
  auto kept = std::make_shared<const ImageFeatures>(std::move(keyframe));
  const Frame shown = masked(order.frame);
  depths_.add(order.id, shown.depth);
  feature_bytes_ += bytes_of(*kept);
  graph_.add(kept, pose, Matrix6d::Zero());
  keep_images(order.id, pack_images(shown));
}

void Mapper::keep_images(KeyframeId id, PackedImages images) {
  if (archive_ != nullptr) {
    archive_->add_images(id, std::move(images));
  } else {
    image_bytes_ += images.bytes();
    in_memory_.images->add(id, std::move(images));
  }
}

void Mapper::add_edge(const Constraint& edge, MapRevision& revision) {
  graph_.add_edge(edge);
  revision.new_edges.push_back(edge);
}

/// The constraints found; leaves those candidates that were compared.
std::vector<Constraint> Mapper::compare(std::int64_t id, LoopSearch::Candidates& candidates, MapRevision& revision) {
  std::vector<Constraint> accepted;
  // Where places are recognized, the next ones will connect what this one leaves out.
  for (const std::int64_t other : candidates.nearby)
    if (!(recognizes_places() && closes_enough(accepted))) take(verify(other, id), accepted);
  std::vector<std::int64_t> compared;
  constexpr std::int64_t rest = 3;
  std::erase_if(proof_.look_alikes, [id](const LookAlike& each) { return each.keyframe < id - rest; });
  for (const std::int64_t other : candidates.places) {
    const bool may_be_left = kind_between(other, id) != ConstraintKind::merge;
    if (may_be_left && (closes_enough(accepted) || is_beside_a_look_alike(other))) continue;
    compared.push_back(other);
    retrieve(other, revision);
    const Rejection rejection = take(verify(other, id), accepted);
    if (is_of_another_place(rejection)) proof_.look_alikes.push_back({id, other});
    if (rejection != Rejection::none)
      revision.events.push_back({"rejected", fmt::format("keyframe {} with {}: {}", id, other, name_of(rejection))});
  }
  candidates.places = std::move(compared);
  return accepted;
}

/// What was seen right before or after shows the same place. The next keyframes see what this one does: of 5,522
/// keyframes of a tour that recognized places, 5 would have recognized none in what the three before had refused, and
/// half of such comparisons are spared.
bool Mapper::is_beside_a_look_alike(std::int64_t place) const {
  constexpr std::int64_t reach = 5;
  return std::any_of(proof_.look_alikes.begin(), proof_.look_alikes.end(),
                     [place](const LookAlike& each) { return std::abs(each.place - place) <= reach; });
}

void Mapper::constrain(std::int64_t id, MapRevision& revision) {
  LoopSearch::Candidates candidates = search_->candidates(graph_, id);
  if (signatures_) store_signature(id, {graph_.shared_keyframe(id), search_->words_of(id)});
  for (const std::int64_t other : candidates.retrieve) retrieve(other, revision);
  proof_.graph_paths.emplace(graph_.graph_paths_from(id));
  std::vector<Constraint> accepted = compare(id, candidates, revision);
  for (const Constraint& edge : accepted) accept(edge, revision);
  if (!accepted.empty() && id > 0) correct(id, accepted, revision);
  std::erase_if(accepted, [&](const Constraint& edge) { return edge.to != id; });
  search_->on_matched(graph_, id, candidates, accepted);
  revision.keyframe_weights = search_->changed_weights();
  revision.belief = search_->place_belief();
}

/// Long-term memory has every location from its beginning: a killed run has lost none.
void Mapper::store_signature(std::int64_t id, const Signature& signature) {
  if (archive_ != nullptr && archive_->rows(SignatureLayer::layer_name)) {
    archive_->add_row(SignatureLayer::layer_name, id, body_of(signature));
  } else {
    in_memory_.signatures->add(id, signature);
  }
}

void Mapper::retrieve(std::int64_t id, MapRevision& revision) {
  if (!signatures_ || graph_.keyframe(id).features.size() > 0) return;
  auto image = with_id(*signatures_->read(id).image, id);
  feature_bytes_ += bytes_of(*image) - bytes_of(graph_.keyframe(id));
  if (image->features.size() > 0) --given_up_;
  graph_.restore_features(image);
  revision.retrieved.push_back(std::move(image));
}

std::vector<std::shared_ptr<const ImageFeatures>> Mapper::similar(const ImageFeatures& seen) const {
  std::vector<std::shared_ptr<const ImageFeatures>> found;
  for (const std::int64_t id : search_->similar(seen)) {
    if (graph_.keyframe(id).features.size() > 0) {
      found.push_back(graph_.shared_keyframe(id));
    } else if (signatures_) {
      found.push_back(with_id(*signatures_->read(id).image, id));
    }
  }
  return found;
}

void Mapper::accept(const Constraint& edge, MapRevision& revision) {
  if (edge.kind == ConstraintKind::merge && maps_ && graph_.submap(edge.from) != graph_.submap(edge.to)) {
    revision.events.push_back(
        {"joined", fmt::format("submaps {} and {} by keyframes {} and {}", graph_.submap(edge.from),
                               graph_.submap(edge.to), edge.from, edge.to)});
    graph_.merge(edge);
  }
  add_edge(edge, revision);
}

void Mapper::correct(std::int64_t id, const std::vector<Constraint>& accepted, MapRevision& revision) {
  const auto count = [&](ConstraintKind kind) {
    return std::count_if(accepted.begin(), accepted.end(), [&](const Constraint& edge) { return edge.kind == kind; });
  };
  const auto loops = count(ConstraintKind::loop), merges = count(ConstraintKind::merge);
  const bool all = maps_ && (loops > 0 || merges > 0) && !is_stopped();
  const PoseGraphResult result = graph_.optimize(all);
  graph_.settle_covariance(id);
  if (loops > 0 && maps_)
    revision.events.push_back({"loop_closed", fmt::format("keyframe {} with {} earlier ones", id, loops)});
  if (all)
    revision.events.push_back({"map_revised", fmt::format("{} keyframes, cost {:.1f} to {:.1f}", graph_.size(),
                                                          result.first_cost, result.last_cost)});
}

/// By the known size of the map, not by the system's memory usage, which differs from run to run. Poses, covariances
/// and constraints are stored twice, here and by the tracker, and a third time, without covariances, in the map that is
/// being saved; frames by the tracker, in that map and at the end in the trajectory. At any time all constraints may be
/// optimized.
std::size_t Mapper::map_bytes() const {
  constexpr std::size_t a_keyframe =
      2 * (sizeof(SE3) + sizeof(Matrix6d) + 2 * sizeof(std::shared_ptr<void>)) + sizeof(Keyframe);
  constexpr std::size_t a_constraint = 3 * sizeof(Constraint) + pose_graph_bytes_per_edge;
  constexpr std::size_t a_frame = 3 * sizeof(MapFrame);
  return feature_bytes_ + image_bytes_ + search_->bytes() + static_cast<std::size_t>(graph_.size()) * a_keyframe +
         graph_.edges().size() * a_constraint + frames_ * a_frame;
}

/// Without what can move out to long-term memory.
std::size_t Mapper::lasting_bytes() const {
  if (!recognizes_places()) return map_bytes();
  return map_bytes() - feature_bytes_ - search_->bytes() + search_->lasting_bytes();
}

/// Of these, what is gone with the mapper: no part of its map.
std::size_t Mapper::passing_bytes() const {
  return search_->bytes() + graph_.edges().size() * pose_graph_bytes_per_edge;
}

/// Places are recognized by as many features as ever: they can move out.
double Mapper::feature_share() const { return recognizes_places() ? 1.0 : budget_.share(); }

std::string Mapper::measures() const {
  std::string text;
  if (budget_.stage() > 0) text = fmt::format("keyframes {:g} times as sparse", budget_.spacing());
  if (feature_share() < 1.0) text += fmt::format(", {:g} % of the features", 100.0 * feature_share());
  if (given_up_ == 0) return text;
  if (!text.empty()) text += ", ";
  return text + fmt::format("features of {} keyframes {}", given_up_,
                            search_->has_long_term_memory() ? "in long-term memory alone" : "dropped");
}

void Mapper::stay_within_budget(MapRevision& revision) {
  if (budget_.note(lasting_bytes())) revision.events.push_back(budget_.event(map_bytes(), measures()));
  const auto fill = [this] {
    return budget_.limited() ? static_cast<double>(map_bytes()) / static_cast<double>(budget_.bytes()) : 0.0;
  };
  const bool full = fill() > MapBudget::full_share;
  for (;;) {
    const std::vector<std::int64_t> leaving = search_->transfer(graph_, fill());
    if (leaving.empty()) break;
    for (const std::int64_t id : leaving) give_up_features(id, revision);
  }
  if (full && !revision.forgotten.empty()) revision.events.push_back(budget_.event(map_bytes(), measures()));
}

/// Those of a given map are in memory whole, and not counted.
void Mapper::give_up_features(std::int64_t id, MapRevision& revision) {
  if (id < graph_.frozen()) return;
  if (graph_.keyframe(id).features.size() == 0) return;
  feature_bytes_ -= bytes_of(graph_.keyframe(id));
  graph_.forget_features(id);
  feature_bytes_ += bytes_of(graph_.keyframe(id));
  revision.forgotten.push_back(id);
  ++given_up_;
}

void Mapper::revise(MapRevision& revision) {
  revision.graph = graph_.take_changes();
  revision.state = state();
}

MappingState Mapper::state() const {
  return {{map_bytes(), budget_.bytes(), measures(), passing_bytes()}, budget_.spacing(), graph_.variance_factor()};
}

/// No two keyframes are compared any more: the optimization gets the room of what that needed.
MapRevision Mapper::settle() {
  MapRevision revision;
  depths_.clear();
  proof_.appearances.clear();
  proof_.graph_paths.reset();
  if (budget_.limited()) return_freed_memory();
  if (maps_ && graph_.size() > 1 && !is_stopped()) {
    const PoseGraphResult result = graph_.optimize_until_converged();
    revision.events.push_back({"map_revised", fmt::format("{} keyframes at the end, cost {:.1f} to {:.1f}",
                                                          graph_.size(), result.first_cost, result.last_cost)});
  }
  revise(revision);
  return revision;
}

}  // namespace rastro
