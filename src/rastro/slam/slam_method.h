// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/options.h"
#include "rastro/base/task_pool.h"
#include "rastro/map/map_archive.h"
#include "rastro/sensor/source.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Told of long work: what it is, and how many steps of how many are done.
using StepsShown = std::function<void(const std::string& what, std::size_t done, std::size_t all)>;

/// What a method may use of the run. Everything in it outlives the method.
struct SlamContext {
  TaskPool* pool = nullptr;                  ///< Null: one thread.
  MapArchive* archive = nullptr;             ///< Where the growing map is saved; null: in memory only.
  bool pipelined = false;                    ///< Mapping may run beside tracking, with the same results.
  std::size_t max_memory_bytes = 0;          ///< Of the whole program; 0: no limit. See map_budget_bytes().
  std::shared_ptr<const Map> map = nullptr;  ///< Localize in this map only; null: make a new one...
  bool extend_map = false;                   ///< ... or continue the given map.
  /// Set from outside (Ctrl-C) when the run must end within two seconds: process() and finish() skip everything
  /// optional. Null: never.
  const std::atomic<bool>* stop = nullptr;
  /// world_from_body at the first frame. For a new map: its world is transformed by it, and so are all poses. For a
  /// given map: where relocalization searches first. make() throws Error for a pose that the method cannot represent.
  std::optional<SE3> initial_pose = std::nullopt;
  /// Of the map alone, by the method's own count (Slam::map_memory()); 0: what max_memory_bytes leaves for it.
  std::size_t map_memory_bytes = 0;
  /// Mapping results are taken when they are ready, and frames are not mapped where mapping falls behind: tracking
  /// never waits, and runs may differ.
  bool live = false;
  /// Called by finish(), where that takes long. May be empty.
  StepsShown on_finishing = nullptr;
};

/// One entry of the generated list of methods: its name, its settings and how to make it.
class SlamMethod {
 public:
  virtual ~SlamMethod() = default;
  virtual std::string name() const = 0;     ///< "hector"
  virtual std::string summary() const = 0;  ///< One line for `rastro methods`.
  virtual std::string needs() const = 0;    ///< "2D laser scans; odometry where there is any".
  /// Points into this object, which must outlive the table.
  virtual OptionTable options() = 0;
  /// Names of sets of values for the settings, beside the defaults, such as those of the publication.
  virtual std::vector<std::string> presets() const { return {}; }
  /// One of presets().
  virtual void set_preset(const std::string& /*name*/) {}
  /// Whether the method wants color images, depth, or the right image of a stereo pair, where the source has them.
  /// Depends on the settings in force.
  virtual bool wants_color() const { return false; }
  virtual bool wants_depth() const { return false; }
  virtual bool wants_right() const { return false; }
  /// Whether the method can localize in an existing map (SlamContext::map), and continue one.
  virtual bool can_localize() const { return false; }
  virtual bool can_extend() const { return false; }
  /// Poses are x, y and yaw; z, roll and pitch are 0.
  virtual bool is_planar() const { return false; }
  /// With the settings in force. Error where the source lacks what the method needs.
  virtual std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const = 0;
};

}  // namespace rastro
