// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/method.h"

#include "rastro/base/error.h"
#include "rastro/slam/hector/hector_slam.h"
#include "rastro/slam/hector/options.h"

namespace rastro {
namespace {

class HectorMethod : public SlamMethod {
 public:
  std::string name() const override { return "hector"; }
  std::string summary() const override { return "2D scan matching with loop closing, after Kohlbrecher et al. 2011"; }
  std::string needs() const override { return "2D laser scans; wheel odometry where there is any"; }
  OptionTable options() override { return option_table(options_); }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext& context) const override {
    if (!source.has_scan)
      throw Error("holds no laser scans", source.path, "'rastro convert DATA --to scan' cuts them from depth images");
    return std::make_unique<HectorSlam>(options_, context.pool);
  }

 private:
  HectorOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> hector_slam_method() { return std::make_unique<HectorMethod>(); }

}  // namespace rastro
