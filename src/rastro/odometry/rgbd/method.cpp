// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd/method.h"

#include "rastro/base/error.h"
#include "rastro/odometry/rgbd/rgbd_odometry.h"
#include "rastro/odometry/rgbd_tracking/options.h"

namespace rastro {
namespace {

class RgbdOdometryMethod : public OdometryMethod {
 public:
  std::string name() const override { return "rgbd"; }
  std::string summary() const override {
    return "RGB-D odometry: features and surfaces aligned with the last reference frames; metric";
  }
  std::string needs() const override { return "calibrated images with depth"; }
  OptionTable options() override { return option_table(options_); }
  bool wants_depth() const override { return true; }
  bool is_metric() const override { return true; }
  std::unique_ptr<Odometry> make(const SourceInfo& source, const OdometryContext& context) const override {
    const Camera& camera = calibrated_camera(source);
    if (!source.has_depth)
      throw Error("has no depth, which this method needs", source.path,
                  "use a method for one camera; 'rastro methods' lists them");
    return std::make_unique<RgbdOdometry>(options_, camera, context.pool);
  }

 private:
  RgbdOptions options_;
};

}  // namespace

std::unique_ptr<OdometryMethod> rgbd_odometry_method() { return std::make_unique<RgbdOdometryMethod>(); }

}  // namespace rastro
