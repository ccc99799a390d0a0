// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/method.h"

#include "rastro/base/error.h"
#include "rastro/slam/initial_pose.h"
#include "rastro/slam/lsd/lsd_slam.h"
#include "rastro/slam/lsd/options.h"

namespace rastro {
namespace {

class LsdMethod : public SlamMethod {
 public:
  std::string name() const override { return "lsd"; }
  std::string summary() const override {
    return "direct semi-dense mono, stereo or RGB-D SLAM, after LSD-SLAM (Engel et al. 2013, 2014, 2015)";
  }
  std::string needs() const override { return "calibrated images; right images or depth if available"; }
  OptionTable options() override { return option_table(options_); }
  std::vector<std::string> presets() const override { return {"paper"}; }
  void set_preset(const std::string&) override { set_paper_preset(options_); }
  bool wants_depth() const override { return options_.sensor == "auto" || options_.sensor == "rgbd"; }
  bool wants_right() const override { return options_.sensor == "auto" || options_.sensor == "stereo"; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (!source.has_image) throw Error("has no images", source.path, "'--method lsd' needs a recording of a camera");
    if (source.cameras.empty() || !source.cameras.front().camera)
      throw Error("has no calibration", source.path, "give one with --calibration FILE");
    return make_with_initial_pose(context, [&](const SlamContext& own_context) {
      return std::make_unique<LsdSlam>(options_, choose_lsd_sensor(options_, source), own_context);
    });
  }

 private:
  LsdOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> lsd_slam_method() { return std::make_unique<LsdMethod>(); }

}  // namespace rastro
