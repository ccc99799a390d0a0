// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "rastro/base/options.h"
#include "rastro/base/task_pool.h"
#include "rastro/map/map_archive.h"
#include "rastro/sensor/source.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// What a method may use of the run that it is part of. Everything outlives the method.
struct SlamContext {
  TaskPool* pool = nullptr;                  ///< Null: one thread.
  MapArchive* archive = nullptr;             ///< Where the growing map is kept safe; null: in memory only.
  bool pipelined = false;                    ///< Mapping may run beside tracking, with the same results.
  std::size_t max_memory_bytes = 0;          ///< Of the whole program; 0: no ceiling.
  std::shared_ptr<const Map> map = nullptr;  ///< Only localize in this map; null: make a new one...
  bool extend_map = false;                   ///< ... or continue the map given.
  /// Set from outside (Ctrl-C) when the run is to end within two seconds: process() and finish() leave out what can be
  /// left out. Null: never.
  const std::atomic<bool>* stop = nullptr;
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
  /// Whether pictures are wanted in colour, with depth, and with the right one of a pair, where the source has them.
  /// Asked with the settings in force.
  virtual bool wants_colour() const { return false; }
  virtual bool wants_depth() const { return false; }
  virtual bool wants_right() const { return false; }
  /// Whether the method can localize in a map made before (SlamContext::map), and continue one.
  virtual bool can_localize() const { return false; }
  virtual bool can_extend() const { return false; }
  /// With the settings in force. Error where the source lacks what the method needs.
  virtual std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const = 0;
};

}  // namespace rastro
