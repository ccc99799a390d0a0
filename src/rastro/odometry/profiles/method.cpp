// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/profiles/method.h"

#include "rastro/odometry/profiles/options.h"
#include "rastro/odometry/profiles/profiles_odometry.h"

namespace rastro {
namespace {

class ProfilesMethod : public OdometryMethod {
 public:
  std::string name() const override { return "profiles"; }
  std::string summary() const override {
    return "rotation from intensity profiles (column and row sums of the image), constant speed";
  }
  std::string needs() const override { return "one calibrated camera"; }
  OptionTable options() override { return option_table(options_); }
  std::vector<std::string> presets() const override { return {"paper"}; }
  void set_preset(const std::string& /*name*/) override { set_paper_preset(options_.rotation); }
  std::unique_ptr<Odometry> make(const SourceInfo& source, const OdometryContext& /*context*/) const override {
    return std::make_unique<ProfilesOdometry>(options_, calibrated_camera(source));
  }

 private:
  ProfilesOptions options_;
};

}  // namespace

std::unique_ptr<OdometryMethod> profiles_odometry_method() { return std::make_unique<ProfilesMethod>(); }

}  // namespace rastro
