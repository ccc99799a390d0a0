// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/hybrid/method.h"

#include "rastro/odometry/hybrid/hybrid_odometry.h"
#include "rastro/odometry/hybrid/options.h"

namespace rastro {
namespace {

class HybridMethod : public OdometryMethod {
 public:
  std::string name() const override { return "hybrid"; }
  std::string summary() const override {
    return "rotation from intensity profiles, translation from point features (two-point RANSAC)";
  }
  std::string needs() const override { return "one calibrated camera"; }
  OptionTable options() override { return option_table(options_); }
  std::vector<std::string> presets() const override { return {"paper"}; }
  void set_preset(const std::string& /*name*/) override { set_paper_preset(options_); }
  std::unique_ptr<Odometry> make(const SourceInfo& source, const OdometryContext& context) const override {
    return std::make_unique<HybridOdometry>(options_, calibrated_camera(source), context.pool);
  }

 private:
  HybridOptions options_;
};

}  // namespace

std::unique_ptr<OdometryMethod> hybrid_odometry_method() { return std::make_unique<HybridMethod>(); }

}  // namespace rastro
