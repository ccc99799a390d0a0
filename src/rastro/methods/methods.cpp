// SPDX-License-Identifier: Apache-2.0
#include "rastro/methods/methods.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro {

std::unique_ptr<SlamMethod> slam_method(const std::string& name) {
  std::vector<std::string> names;
  for (auto& method : slam_methods()) {
    if (method->name() == name) return std::move(method);
    names.push_back(method->name());
  }
  throw Error(fmt::format("'{}' is no SLAM method", name), "--method",
              fmt::format("did you mean '{}'? 'rastro methods' lists them all", nearest_name(name, names)));
}

}  // namespace rastro
