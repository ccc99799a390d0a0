// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/method.h"

#include "rastro/base/error.h"
#include "rastro/slam/initial_pose.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/orb_slam.h"

namespace rastro {
namespace {

class OrbMethod : public SlamMethod {
 public:
  std::string name() const override { return "orb"; }
  std::string summary() const override {
    return "mono, stereo or RGB-D SLAM with keyframes and bundle adjustment, after ORB-SLAM (Mur-Artal et al. 2015, "
           "2017)";
  }
  std::string needs() const override { return "calibrated images; right images or depth if available"; }
  OptionTable options() override { return option_table(options_); }
  bool wants_depth() const override { return options_.sensor == "auto" || options_.sensor == "rgbd"; }
  bool wants_right() const override { return options_.sensor == "auto" || options_.sensor == "stereo"; }
  bool can_localize() const override { return true; }
  bool can_extend() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (!source.has_image) throw Error("has no images", source.path, "'--method orb' needs a recording of a camera");
    if (source.cameras.empty() || !source.cameras.front().camera)
      throw Error("has no calibration", source.path, "give one with --calibration FILE");
    return make_with_initial_pose(context, [&](const SlamContext& own_context) {
      return std::make_unique<OrbSlam>(options_, source, own_context);
    });
  }

 private:
  OrbSlamOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> orb_slam_method() { return std::make_unique<OrbMethod>(); }

}  // namespace rastro
