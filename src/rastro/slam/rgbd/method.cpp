// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/method.h"

#include "rastro/backend/rgbd/options.h"
#include "rastro/backend/rgbd/rgbd_slam.h"
#include "rastro/base/error.h"
#include "rastro/slam/initial_pose.h"

namespace rastro {
namespace {

class RgbdMethod : public SlamMethod {
 public:
  std::string name() const override { return "rgbd"; }
  std::string summary() const override {
    return "RGB-D SLAM: pose graph of keyframes with loop closing and dense maps, after Endres et al. 2014";
  }
  std::string needs() const override { return "calibrated images with depth"; }
  OptionTable options() override { return option_table(options_); }
  bool wants_color() const override { return true; }
  bool wants_depth() const override { return true; }
  bool can_localize() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (!source.has_depth)
      throw Error("has no depth images", source.path,
                  "'--method rgbd' needs a recording of a depth camera, such as a TUM RGB-D folder");
    if (source.cameras.empty() || !source.cameras.front().camera)
      throw Error("has no calibration", source.path, "give one with --calibration FILE");
    return make_with_initial_pose(context, [&](const SlamContext& own_context) {
      return std::make_unique<RgbdSlam>(name(), options_, *source.cameras.front().camera, own_context);
    });
  }

 private:
  RgbdSlamOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> rgbd_slam_method() { return std::make_unique<RgbdMethod>(); }

}  // namespace rastro
