// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/method.h"

#include "rastro/base/error.h"
#include "rastro/slam/hector/hector_slam.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/initial_pose.h"
#include "rastro/slam/map_budget.h"

namespace rastro {
namespace {

class HectorMethod : public SlamMethod {
 public:
  std::string name() const override { return "hector"; }
  std::string summary() const override {
    return "2D laser SLAM: scan matching with submaps and loop closing, after Hector SLAM (Kohlbrecher et al. 2011)";
  }
  std::string needs() const override { return "2D laser scans; wheel odometry if available"; }
  OptionTable options() override { return option_table(options_); }
  bool is_planar() const override { return true; }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (!source.has_scan)
      throw Error("has no laser scans", source.path, "'rastro convert DATA --to scan' cuts them from depth images");
    planar_initial_pose(context, name());
    return make_with_initial_pose(context, [this](const SlamContext& own_context) {
      constexpr double reserve_mb = 50.0;  // for everything except the map
      return std::make_unique<HectorSlam>(options_, own_context.pool, map_budget_bytes(own_context, reserve_mb),
                                          own_context.stop);
    });
  }

 private:
  HectorOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> hector_slam_method() { return std::make_unique<HectorMethod>(); }

}  // namespace rastro
