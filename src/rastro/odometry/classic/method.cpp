// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/classic/method.h"

#include "rastro/odometry/classic/classic_odometry.h"
#include "rastro/odometry/classic/options.h"

namespace rastro {
namespace {

class ClassicMethod : public OdometryMethod {
 public:
  std::string name() const override { return "classic"; }
  std::string summary() const override {
    return "three frames at a time: essential matrix, triangulation, P3P; no map (Mendieta and Moreyra)";
  }
  std::string needs() const override { return "one calibrated camera"; }
  OptionTable options() override { return option_table(options_); }
  std::vector<std::string> presets() const override { return {"paper"}; }
  void set_preset(const std::string& /*name*/) override { set_paper_preset(options_); }
  std::unique_ptr<Odometry> make(const SourceInfo& source, const OdometryContext& context) const override {
    return std::make_unique<ClassicOdometry>(options_, calibrated_camera(source), context.pool);
  }

 private:
  ClassicOptions options_;
};

}  // namespace

std::unique_ptr<OdometryMethod> classic_odometry_method() { return std::make_unique<ClassicMethod>(); }

}  // namespace rastro
