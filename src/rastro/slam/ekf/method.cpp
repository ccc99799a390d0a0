// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/method.h"

#include "rastro/base/error.h"
#include "rastro/slam/ekf/ekf_slam.h"
#include "rastro/slam/ekf/options.h"
#include "rastro/slam/initial_pose.h"
#include "rastro/slam/map_budget.h"

namespace rastro {
namespace {

class EkfMethod : public SlamMethod {
 public:
  std::string name() const override { return "ekf"; }
  std::string summary() const override {
    return "EKF-SLAM with landmarks: corners and poles in 2D laser scans, or given range and bearing";
  }
  std::string needs() const override { return "wheel odometry, and 2D laser scans or landmark observations"; }
  OptionTable options() override { return option_table(options_); }
  bool is_planar() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (!source.has_odometry) {
      throw Error("has no wheel odometry, which the method ekf needs", source.path,
                  "use --method hector, which does not need it");
    }
    if (!source.has_scan && !source.has_landmarks) {
      throw Error("has neither laser scans nor landmark observations, and the method ekf needs one of them",
                  source.path, "give a recording with either");
    }
    constexpr double reserve_mb = 50.0;  // for everything except the map
    return std::make_unique<EkfSlam>(options_, source.has_scan, planar_initial_pose(context, name()),
                                     map_budget_bytes(context, reserve_mb));
  }

 private:
  EkfOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> ekf_slam_method() { return std::make_unique<EkfMethod>(); }

}  // namespace rastro
