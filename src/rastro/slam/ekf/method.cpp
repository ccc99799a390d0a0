// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/method.h"

#include "rastro/base/error.h"

namespace rastro {
namespace {

class EkfMethod : public SlamMethod {
 public:
  std::string name() const override { return "ekf"; }
  std::string summary() const override {
    return "EKF-SLAM with landmarks: line corners and spikes of 2D scans, or range and bearing";
  }
  std::string needs() const override { return "wheel odometry, and 2D laser scans or landmark sightings"; }
  OptionTable options() override { return {}; }
  std::unique_ptr<Slam> make(const SourceInfo& source, TaskPool*) const override {
    throw Error("is not built yet", source.path, "wait");
  }
};

}  // namespace

std::unique_ptr<SlamMethod> ekf_method() { return std::make_unique<EkfMethod>(); }

}  // namespace rastro
