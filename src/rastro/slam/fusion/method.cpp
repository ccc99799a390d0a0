// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/fusion/method.h"

#include "rastro/base/error.h"
#include "rastro/slam/fusion/options.h"
#include "rastro/slam/fusion/view_alignment.h"
#include "rastro/slam/initial_pose.h"
#include "rastro/slam/orb/orb_slam.h"

namespace rastro {
namespace {

class FusionMethod : public SlamMethod {
 public:
  std::string name() const override { return "fusion"; }
  std::string summary() const override {
    return "stereo or RGB-D SLAM by features, direct alignment and surfaces together: orb, lsd and rgbd in one";
  }
  std::string needs() const override { return "calibrated images with depth, or of a stereo pair"; }
  OptionTable options() override { return option_table(options_); }
  bool wants_depth() const override { return options_.sensor != "stereo"; }
  bool wants_right() const override { return options_.sensor != "rgbd"; }
  bool can_localize() const override { return true; }
  bool can_extend() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (source.cameras.empty() || !source.cameras.front().camera)
      throw Error("has no calibration", source.path, "give one with --calibration FILE");
    FusionOptions options = options_;
    options.orb.sensor = sensor_of(source);
    const OrbMethodParts parts{name(), [options](const SensorChoice& sensor) {
                                 return std::make_shared<const ViewAlignment>(options, sensor);
                               }};
    return make_with_initial_pose(context, [&](const SlamContext& own_context) {
      return std::make_unique<OrbSlam>(options.orb, source, own_context, parts);
    });
  }

 private:
  /// "rgbd" or "stereo"; Error where the source has neither, or not the one asked for.
  std::string sensor_of(const SourceInfo& source) const {
    if (source.has_depth && options_.sensor != "stereo") return "rgbd";
    if (source.has_right && options_.sensor != "rgbd") return "stereo";
    throw Error(options_.sensor == "stereo" ? "has no right images" : "has no depth images", source.path,
                "'--method fusion' needs a depth camera, such as a TUM RGB-D folder, or a stereo pair");
  }

  FusionOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> fusion_slam_method() { return std::make_unique<FusionMethod>(); }

}  // namespace rastro
