// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/backend/rgbd/appearance_check.h"
#include "rastro/backend/rgbd/depth_store.h"
#include "rastro/backend/rgbd/keyframe_features.h"
#include "rastro/backend/rgbd/keyframe_graph.h"
#include "rastro/backend/rgbd/keyframe_matcher.h"
#include "rastro/backend/rgbd/loop_confirmation.h"
#include "rastro/backend/rgbd/loop_search.h"
#include "rastro/backend/rgbd/options.h"
#include "rastro/base/random.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/map/map_archive.h"
#include "rastro/map/signatures/signature_layer.h"
#include "rastro/slam/map_budget.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// Keyframes over which tracking may know better than a match.
constexpr int most_tracked_steps = 40;

/// The input from which the mapper makes a keyframe.
struct KeyframeOrder {
  std::int64_t id = 0;
  Frame frame;                           ///< Only image, color, depth and mask are read.
  SE3 world_from_camera;                 ///< As the tracker estimated it.
  int submap = 0;                        ///< As far as the tracker knows.
  std::optional<Constraint> constraint;  ///< To this keyframe: from odometry or from relocalization.
  std::size_t frames = 0;                ///< Number with a pose so far; they take memory as well.
};

/// What the tracker has to know of mapping.
struct MappingState {
  MapMemory memory;
  double spacing = 1.0;          ///< For future keyframes: factor on the usual motion between them.
  double variance_factor = 1.0;  ///< Of the covariances of tracked motions, see KeyframeGraph.
};

/// The new keyframe and the changes to the map.
struct MapRevision {
  std::shared_ptr<const ImageFeatures> keyframe;
  GraphChanges graph;  ///< Includes the new keyframe and the weights of the new edges.
  std::vector<Constraint> new_edges;
  Matrix6d covariance = Matrix6d::Zero();  ///< Of the keyframe's pose, see KeyframeGraph.
  std::vector<std::int64_t> forgotten;     ///< Keyframes whose features were dropped or transferred.
  std::vector<std::shared_ptr<const ImageFeatures>> retrieved;    ///< Keyframes whose features came back.
  std::vector<std::pair<std::int64_t, double>> keyframe_weights;  ///< Those that changed.
  std::optional<PlaceBelief> belief;                              ///< About the keyframe, where places are recognized.
  std::vector<SlamEvent> events;
  MappingState state;
};

/// Builds the map: features of each keyframe, matching to other keyframes, pose graph, archive. Runs beside the
/// tracker, one job after the other; its results depend on its inputs alone. Where loops are looked for, and what stays
/// in memory, is the search's.
class Mapper {
 public:
  /// `search`: null for a GraphSearch.
  Mapper(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context,
         std::unique_ptr<LoopSearch> search = nullptr);
  MappingState state() const;
  MapRevision add(const KeyframeOrder& order);
  /// One more edge between keyframes; the keyframe of the result stays null.
  MapRevision connect(Constraint edge);
  /// Optimizes all keyframes over all constraints once more, unless the run was stopped (SlamContext::stop); the
  /// keyframe of the result stays null.
  MapRevision settle();
  /// Keyframes that look like an image, with their features, best first; none if the search recognizes no places. While
  /// no job runs.
  std::vector<std::shared_ptr<const ImageFeatures>> similar(const ImageFeatures& seen) const;
  bool recognizes_places() const { return search_->has_long_term_memory(); }

  const std::shared_ptr<const ImageStore>& images() const { return images_; }
  /// Null without long-term memory.
  const std::shared_ptr<const SignatureStore>& signatures() const { return signatures_; }
  /// Thread-safe.
  DepthStore& depths() { return depths_; }
  /// Thread-safe.
  AppearanceStore& appearances() { return proof_.appearances; }

 private:
  void keep(const KeyframeOrder& order, ImageFeatures keyframe);
  /// Candidates, verification, acceptance, correction.
  std::vector<Constraint> compare(std::int64_t id, LoopSearch::Candidates& candidates, MapRevision& revision);
  void constrain(std::int64_t id, MapRevision& revision);
  bool is_beside_a_look_alike(std::int64_t place) const;
  struct Verified {
    std::optional<Constraint> edge;
    Rejection rejection = Rejection::none;
    bool alone = false;                                  ///< Has to be confirmed: nothing else supports it.
    Eigen::Vector3d evidence = Eigen::Vector3d::Zero();  ///< See LoopHypothesis.
  };
  Verified verify(std::int64_t other, std::int64_t id);
  bool is_stopped() const { return stop_ && stop_->load(); }
  ConstraintKind kind_between(std::int64_t other, std::int64_t id) const;
  int inliers_for(ConstraintKind kind) const;
  Verified match(std::int64_t other, std::int64_t id, MatchScope scope);
  bool needs_proof(const Constraint& edge) const;
  bool corrects_map(const Constraint& edge) const;
  bool contradicts_path(const Constraint& edge, GraphPaths& paths) const;
  void judge_appearance(Verified& found);
  Rejection take(const Verified& found, std::vector<Constraint>& accepted);
  void accept(const Constraint& edge, MapRevision& revision);
  void correct(std::int64_t id, const std::vector<Constraint>& accepted, MapRevision& revision);
  void add_edge(const Constraint& edge, MapRevision& revision);
  std::size_t map_bytes() const;
  std::size_t lasting_bytes() const;
  std::size_t passing_bytes() const;
  double feature_share() const;
  std::string measures() const;
  void stay_within_budget(MapRevision& revision);
  void give_up_features(std::int64_t id, MapRevision& revision);
  void take_over(const std::shared_ptr<const Map>& map);
  void store_continued();
  void keep_images(KeyframeId id, PackedImages images);
  void store_signature(std::int64_t id, const Signature& signature);
  void retrieve(std::int64_t id, MapRevision& revision);
  void revise(MapRevision& revision);

  RgbdSlamOptions options_;
  Camera camera_;
  MapArchive* archive_;
  const std::atomic<bool>* stop_;  ///< May be null.
  bool maps_;                      ///< False: the given map is only read.
  MapBudget budget_;
  std::size_t feature_bytes_ = 0, image_bytes_ = 0;  ///< In memory.
  std::size_t frames_ = 0;                           ///< As in the last input.
  std::int64_t given_up_ = 0;                        ///< Keyframes without their features.
  std::shared_ptr<const Map> continued_;             ///< Until it is in the archive.
  /// Where there is no archive.
  struct InMemory {
    std::shared_ptr<MemoryImages> images;
    std::shared_ptr<MemorySignatures> signatures = {};
  };
  InMemory in_memory_;
  std::shared_ptr<const ImageStore> images_;
  std::shared_ptr<const SignatureStore> signatures_;
  KeyframeMatcher matcher_;
  DepthStore depths_;
  /// Features and surfaces fit, and yet `place` is not where `keyframe` is.
  struct LookAlike {
    std::int64_t keyframe = 0, place = 0;
  };
  struct Proof {
    AppearanceCheck check;
    AppearanceStore appearances;
    LoopConfirmation confirmation = {};
    std::optional<GraphPaths> graph_paths = {};  ///< From the newest keyframe, before it has any edge but of tracking.
    std::deque<LookAlike> look_alikes = {};      ///< Of the last keyframes.
  };
  Proof proof_;  ///< What a loop closure needs beside matches.
  KeyframeFeatures features_;
  KeyframeGraph graph_;
  std::unique_ptr<LoopSearch> search_;
};

}  // namespace rastro
