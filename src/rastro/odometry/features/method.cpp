// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/method.h"

#include "rastro/odometry/features/features_odometry.h"
#include "rastro/odometry/features/options.h"

namespace rastro {
namespace {

class FeaturesMethod : public OdometryMethod {
 public:
  std::string name() const override { return "features"; }
  std::string summary() const override {
    return "visual odometry from point features: local map, PnP and local bundle adjustment";
  }
  std::string needs() const override { return "one calibrated camera"; }
  OptionTable options() override { return option_table(options_); }
  std::unique_ptr<Odometry> make(const SourceInfo& source, const OdometryContext& context) const override {
    return std::make_unique<FeaturesOdometry>(options_, calibrated_camera(source), context.pool);
  }

 private:
  FeaturesOptions options_;
};

}  // namespace

std::unique_ptr<OdometryMethod> features_odometry_method() { return std::make_unique<FeaturesMethod>(); }

}  // namespace rastro
