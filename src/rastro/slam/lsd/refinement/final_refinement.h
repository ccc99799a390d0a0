// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/lsd/refinement/photometric_bundle.h"
#include "rastro/slam/lsd/semi_dense_graph.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// Refines the map at the end of a run: photometric bundle adjustment of all keyframes over selected
/// pixels. What the depth filter made of one keyframe after the other fits all of them together then.
class FinalRefinement {
 public:
  /// Options and graph outlive this.
  FinalRefinement(const LsdOptions& options, const SemiDenseGraph& graph, const LsdSensor& sensor);

  /// Of fewer keyframes little has accumulated, and two of them hardly tell what moves from what stands still.
  static constexpr std::int64_t least_keyframes = 5;

  /// Changes no map. Ends early once `stopped`; `shown` may be empty. Returns a summary for the log.
  std::string run(TaskPool* pool, const std::function<bool()>& stopped, const StepsShown& shown);
  /// Whether run() gained anything: poses() are better than those of the map.
  bool is_better() const { return better_; }
  /// world_from_keyframe by keyframe, with the scales that their depths in the map need.
  std::vector<Sim3> poses() const;

 private:
  void choose_points(std::int64_t id);
  void choose_targets();
  std::vector<DepthRatio> ratios_of(std::int64_t id) const;
  void scale_by_sensor();
  std::optional<double> scale_of(std::int64_t id) const;

  const LsdOptions& options_;
  const SemiDenseGraph& graph_;
  Camera camera_;
  bool is_metric_;
  std::vector<PhotometricKeyframe> keyframes_;
  bool better_ = false;
};

}  // namespace rastro
