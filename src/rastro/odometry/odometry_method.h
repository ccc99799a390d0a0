// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rastro/base/options.h"
#include "rastro/base/task_pool.h"
#include "rastro/odometry/odometry.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// Context of an odometry: what it may use of its run. Everything outlives the odometry.
struct OdometryContext {
  TaskPool* pool = nullptr;  ///< Null: one thread.
};

/// One entry of the generated list of odometries: its name, its settings and its factory.
class OdometryMethod {
 public:
  virtual ~OdometryMethod() = default;
  virtual std::string name() const = 0;     ///< "features"
  virtual std::string summary() const = 0;  ///< One line for `rastro methods`.
  virtual std::string needs() const = 0;    ///< "images, calibrated".
  /// Points into this object, which must outlive the table.
  virtual OptionTable options() = 0;
  /// Names of sets of values for the settings, beside the defaults, such as those of the publication.
  virtual std::vector<std::string> presets() const { return {}; }
  /// One of presets().
  virtual void set_preset(const std::string& /*name*/) {}
  /// Whether the method uses depth or the right image of a pair, where the source has them. Depends on the current
  /// settings.
  virtual bool wants_depth() const { return false; }
  virtual bool wants_right() const { return false; }
  /// Whether poses are metric; else they are up to scale unless a source of scale is given.
  virtual bool is_metric() const { return false; }
  /// Uses the current settings. Throws Error where the source lacks what the method needs.
  virtual std::unique_ptr<Odometry> make(const SourceInfo& source, const OdometryContext& context) const = 0;
};

/// The first camera of a source of images. Throws Error where the source has no images or no calibration.
const Camera& calibrated_camera(const SourceInfo& source);

}  // namespace rastro
