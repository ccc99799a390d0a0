// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/method.h"

#include "rastro/backend/rgbd/rgbd_slam.h"
#include "rastro/base/error.h"
#include "rastro/slam/initial_pose.h"
#include "rastro/slam/rtabmap/appearance_search.h"
#include "rastro/slam/rtabmap/options.h"

namespace rastro {
namespace {

class RtabmapMethod : public SlamMethod {
 public:
  std::string name() const override { return "rtabmap"; }
  std::string summary() const override {
    return "appearance-based SLAM with memory management, after RTAB-Map (Labbe and Michaud 2013, 2014)";
  }
  std::string needs() const override { return "calibrated images with depth"; }
  OptionTable options() override { return option_table(options_); }
  bool wants_color() const override { return true; }
  bool wants_depth() const override { return true; }
  bool can_localize() const override { return true; }
  bool can_extend() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (!source.has_depth)
      throw Error("has no depth images", source.path,
                  "'--method rtabmap' needs a recording of a depth camera, such as a TUM RGB-D folder");
    if (source.cameras.empty() || !source.cameras.front().camera)
      throw Error("has no calibration", source.path, "give one with --calibration FILE");
    return make_with_initial_pose(context, [&](const SlamContext& own_context) {
      const auto search = [options = options_, means = AppearanceSearch::Means{own_context.pool, own_context.live}] {
        return std::make_unique<AppearanceSearch>(options, means);
      };
      return std::make_unique<RgbdSlam>("rtabmap", options_.rgbd, *source.cameras.front().camera, own_context, search);
    });
  }

 private:
  RtabmapOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> rtabmap_slam_method() { return std::make_unique<RtabmapMethod>(); }

}  // namespace rastro
