// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/base/options.h"
#include "rastro/base/task_pool.h"
#include "rastro/odometry/odometry.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// What an odometry may use of the run it is part of. Everything outlives it.
struct OdometryContext {
  TaskPool* pool = nullptr;  ///< Null: one thread.
};

/// One entry of the generated list of odometries: its name, its settings and how to make it.
class OdometryMethod {
 public:
  virtual ~OdometryMethod() = default;
  virtual std::string name() const = 0;     ///< "features"
  virtual std::string summary() const = 0;  ///< One line for `rastro methods`.
  virtual std::string needs() const = 0;    ///< "images, calibrated".
  /// Points into this object, which must outlive the table.
  virtual OptionTable options() = 0;
  /// Whether depth or the right image of a pair is wanted, where the source has them. Asked with the settings in force.
  virtual bool wants_depth() const { return false; }
  virtual bool wants_right() const { return false; }
  /// Whether poses are in meters; else lengths are relative until a source of scale is given.
  virtual bool is_metric() const { return false; }
  /// With the settings in force. Error where the source lacks what the method needs.
  virtual std::unique_ptr<Odometry> make(const SourceInfo& source, const OdometryContext& context) const = 0;
};

/// The first camera of a source of images. Error where the source has no images or no calibration.
const Camera& calibrated_camera(const SourceInfo& source);

}  // namespace rastro
