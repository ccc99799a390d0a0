// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/base/options.h"
#include "rastro/base/task_pool.h"
#include "rastro/sensor/source.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// One entry of the generated list of methods: its name, its settings and how to make it.
class SlamMethod {
 public:
  virtual ~SlamMethod() = default;
  virtual std::string name() const = 0;     ///< "hector"
  virtual std::string summary() const = 0;  ///< One line for `rastro methods`.
  virtual std::string needs() const = 0;    ///< "2D laser scans; odometry where there is any".
  /// Points into this object, which must outlive the table.
  virtual OptionTable options() = 0;
  /// With the settings in force. Error where the source lacks what the method needs. `pool` may be null: one thread.
  virtual std::unique_ptr<Slam> make(const SourceInfo& source, TaskPool* pool) const = 0;
};

}  // namespace rastro
