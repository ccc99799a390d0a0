// SPDX-License-Identifier: Apache-2.0
#include "rastro/methods/methods.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/methods/auto_slam.h"

namespace rastro {
namespace {

/// The method with that name; `kind` is for the error.
template <typename Method>
std::unique_ptr<Method> named(std::vector<std::unique_ptr<Method>> methods, const std::string& name, const char* kind) {
  std::vector<std::string> names;
  for (std::unique_ptr<Method>& method : methods) {
    if (method->name() == name) return std::move(method);
    names.push_back(method->name());
  }
  throw Error(fmt::format("there is no {} '{}'", kind, name), "--method",
              did_you_mean(name, names, "'rastro methods' lists them"));
}

}  // namespace

std::unique_ptr<OdometryMethod> odometry_method(const std::string& name) {
  return named(odometry_methods(), name, "odometry method");
}

std::vector<std::unique_ptr<SlamMethod>> selectable_slam_methods() {
  std::vector<std::unique_ptr<SlamMethod>> methods = slam_methods();
  methods.insert(methods.begin(), auto_slam_method(slam_method));
  return methods;
}

std::unique_ptr<SlamMethod> slam_method(const std::string& name) {
  return named(selectable_slam_methods(), name, "SLAM method");
}

}  // namespace rastro
