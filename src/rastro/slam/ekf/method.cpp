// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/method.h"

#include "rastro/base/error.h"
#include "rastro/slam/ekf/ekf_slam.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {
namespace {

class EkfMethod : public SlamMethod {
 public:
  std::string name() const override { return "ekf"; }
  std::string summary() const override {
    return "EKF-SLAM with landmarks: line corners and spikes of 2D scans, or range and bearing";
  }
  std::string needs() const override { return "wheel odometry, and 2D laser scans or landmark sightings"; }
  OptionTable options() override { return option_table(options_); }
  std::unique_ptr<Slam> make(const SourceInfo& source, const SlamContext&) const override {
    if (!source.has_odometry) {
      throw Error("has no wheel odometry, which the method ekf needs", source.path,
                  "use --method hector, which does without");
    }
    if (!source.has_scan && !source.has_landmarks) {
      throw Error("has neither laser scans nor landmark sightings, and the method ekf needs one of them", source.path,
                  "give a recording that has");
    }
    return std::make_unique<EkfSlam>(options_, source.has_scan);
  }

 private:
  EkfOptions options_;
};

}  // namespace

std::unique_ptr<SlamMethod> ekf_slam_method() { return std::make_unique<EkfMethod>(); }

}  // namespace rastro
