// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/method.h"

#include "rastro/base/error.h"
#include "rastro/slam/rgbd/options.h"
#include "rastro/slam/rgbd/rgbd_slam.h"

namespace rastro {
namespace {

class RgbdMethod : public SlamMethod {
 public:
  std::string name() const override { return "rgbd"; }
  std::string summary() const override {
    return "depth camera: keyframes, loops and a map to measure in, after Endres et al. 2014";
  }
  std::string needs() const override { return "images with depth, calibrated"; }
  OptionTable options() override { return option_table(options_); }
  bool wants_colour() const override { return true; }
  bool wants_depth() const override { return true; }
  bool can_localize() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (!source.has_depth)
      throw Error("holds no depth images", source.path,
                  "'--method rgbd' needs a recording of a depth camera, such as one in TUM's layout");
    if (source.cameras.empty() || !source.cameras.front().camera)
      throw Error("has no calibration", source.path, "give one with --calibration FILE");
    return std::make_unique<RgbdSlam>(options_, *source.cameras.front().camera, context);
  }

 private:
  RgbdSlamOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> rgbd_slam_method() { return std::make_unique<RgbdMethod>(); }

}  // namespace rastro
