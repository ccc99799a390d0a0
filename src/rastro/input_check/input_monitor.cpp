// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/input_monitor.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "rastro/input_check/depth_check.h"
#include "rastro/input_check/depth_delay_check.h"
#include "rastro/input_check/depth_scale_check.h"
#include "rastro/input_check/focal_check.h"
#include "rastro/input_check/landmark_check.h"
#include "rastro/input_check/laser_check.h"
#include "rastro/input_check/odometry_check.h"
#include "rastro/input_check/stamp_check.h"
#include "rastro/input_check/stereo_check.h"
#include "rastro/input_check/tracked_window.h"

namespace rastro {

struct InputMonitor::Checks {
  explicit Checks(const SourceInfo& info)
      : camera(info.cameras.empty() ? std::nullopt : info.cameras.front().camera),
        stereo(info),
        depth_scale(camera),
        tracker(PairDepth::of(info)),
        focal(camera) {}

  void look(const Frame& frame, InputWarnings& found) {
    stamps.add(frame, found);
    laser.add(frame, found);
    landmarks.add(frame, found);
    odometry.add(frame, found);
    stereo.add(frame, found);
    depth.add(frame, found);
    depth_scale.add(frame, found);
    if (!depth.is_wrong()) depth_delay.add(frame, found);
    if (!camera || !tracker.add(frame)) return;
    depth.add(tracker.window(), *camera, found);
    focal.add(tracker.window(), !is_depth_doubted(found), found);
  }

  /// By an earlier warning or one of `found`: depth that is not what it seems would be blamed on the focal length.
  bool is_depth_doubted(const InputWarnings& found) const {
    const auto doubts = [](const InputWarning& warning) {
      return warning.kind.starts_with("stereo_") ||
             (warning.kind.starts_with("depth_") && warning.kind != "depth_scale");
    };
    return std::any_of(warnings.begin(), warnings.end(), doubts) || std::any_of(found.begin(), found.end(), doubts);
  }

  std::optional<Camera> camera;

  StampCheck stamps;
  LaserCheck laser;
  LandmarkCheck landmarks;
  OdometryCheck odometry;
  StereoCheck stereo;
  DepthCheck depth;
  DepthScaleCheck depth_scale;
  DepthDelayCheck depth_delay;
  WindowTracker tracker;
  FocalCheck focal;
  InputWarnings warnings;
};

InputMonitor::InputMonitor(const SourceInfo& info) : checks_(std::make_unique<Checks>(info)) {}
InputMonitor::~InputMonitor() = default;

InputWarnings InputMonitor::add(const Frame& frame) {
  InputWarnings found;
  checks_->look(frame, found);
  std::copy(found.begin(), found.end(), std::back_inserter(checks_->warnings));
  return found;
}

const InputWarnings& InputMonitor::warnings() const { return checks_->warnings; }

}  // namespace rastro
