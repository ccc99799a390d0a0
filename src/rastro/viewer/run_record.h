// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "rastro/sensor/trajectory.h"
#include "rastro/viewer/scene.h"

namespace rastro {

/// What a run noted of its frames, beside the map. Any part may be empty. Stamps connect the parts.
struct RunRecord {
  struct Frame {
    std::int64_t frame = 0;  ///< Index in the recording.
    TimeNs stamp = 0;
    std::string state;  ///< Of scene_state_names(); any other counts as unknown.
    double milliseconds = 0.0;
  };
  struct Uncertainty {
    TimeNs stamp = 0;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of the position, world, the map's unit squared.
  };
  struct Event {
    std::int64_t frame = 0;  ///< Index in the recording.
    std::string kind, detail;
  };
  /// Ground truth of a frame.
  struct Truth {
    TimeNs stamp = 0;                                    ///< Of the frame.
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Aligned with the map, in its unit.
  };

  Trajectory trajectory;  ///< Final poses.
  Trajectory online;      ///< As first estimated.
  std::vector<Frame> frames;
  std::vector<Uncertainty> uncertainties;
  std::vector<Truth> truth;
  std::vector<Event> events;  ///< Those of `frames` count.
};

/// Adds it to the scene of the run's map (or an empty one). The frames of the map stay where they are as many as the
/// run's; else the run's trajectory is shown.
void add_run(const RunRecord& record, ViewScene& scene);

}  // namespace rastro
