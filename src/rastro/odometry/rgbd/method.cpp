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
    return "a depth camera's features and surfaces against its last reference frames, in metres";
  }
  std::string needs() const override { return "images with depth, calibrated"; }
  OptionTable options() override { return option_table(options_); }
  bool wants_depth() const override { return true; }
  bool is_metric() const override { return true; }
  std::unique_ptr<Odometry> make(const SourceInfo& source, const OdometryContext& context) const override {
    const Camera& camera = calibrated_camera(source);
    if (!source.has_depth)
      throw Error("holds no depth, and this method needs it", source.path,
                  "take a method for one camera; 'rastro methods' lists them all");
    return std::make_unique<RgbdOdometry>(options_, camera, context.pool);
  }

 private:
  RgbdOptions options_;
};

}  // namespace

std::unique_ptr<OdometryMethod> rgbd_odometry_method() { return std::make_unique<RgbdOdometryMethod>(); }

}  // namespace rastro
