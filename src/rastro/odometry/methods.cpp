// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/methods.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/odometry/features/features_odometry.h"
#include "rastro/odometry/hybrid/hybrid_odometry.h"
#include "rastro/odometry/profiles/profiles_odometry.h"
#include "rastro/odometry/rgbd/rgbd_odometry.h"

namespace rastro {
namespace {

Error unknown_method(const std::string& method) {
  return Error(fmt::format("'{}' is no odometry", method), "--method",
               fmt::format("did you mean '{}'?", nearest_name(method, odometry_methods())));
}

}  // namespace

const std::vector<std::string>& odometry_methods() {
  static const std::vector<std::string> names = {"features", "profiles", "hybrid", "rgbd"};
  return names;
}

std::string odometry_summary(const std::string& method) {
  if (method == "features") return "points in space from features, every pose from the points it sees";
  if (method == "profiles") return "turns from the sums of the image's columns and rows, constant speed";
  if (method == "hybrid") return "turns from profiles, the way from two points at a time";
  if (method == "rgbd") return "a depth camera's features and surfaces against its last reference frames, in metres";
  throw unknown_method(method);
}

bool odometry_needs_depth(const std::string& method) { return method == "rgbd"; }

OptionTable OdometrySettings::table(const std::string& method) {
  if (method == "features") return option_table(features);
  if (method == "profiles") return option_table(profiles);
  if (method == "hybrid") return option_table(hybrid);
  if (method == "rgbd") return option_table(rgbd);
  throw unknown_method(method);
}

std::unique_ptr<Odometry> OdometrySettings::make(const std::string& method, const Camera& camera,
                                                 TaskPool* pool) const {
  if (method == "features") return std::make_unique<FeaturesOdometry>(features, camera, pool);
  if (method == "profiles") return std::make_unique<ProfilesOdometry>(profiles, camera);
  if (method == "hybrid") return std::make_unique<HybridOdometry>(hybrid, camera, pool);
  if (method == "rgbd") return std::make_unique<RgbdOdometry>(rgbd, camera, pool);
  throw unknown_method(method);
}

}  // namespace rastro
