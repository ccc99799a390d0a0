// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/method.h"

#include "rastro/base/error.h"

namespace rastro {
namespace {

class HectorMethod : public SlamMethod {
 public:
  std::string name() const override { return "hector"; }
  std::string summary() const override { return "2D scan matching with loop closing, after Kohlbrecher et al. 2011"; }
  std::string needs() const override { return "2D laser scans; wheel odometry where there is any"; }
  OptionTable options() override { return {}; }
  std::unique_ptr<Slam> make(const SourceInfo& source, TaskPool*) const override {
    throw Error("is not built yet", source.path, "wait");
  }
};

}  // namespace

std::unique_ptr<SlamMethod> hector_method() { return std::make_unique<HectorMethod>(); }

}  // namespace rastro
