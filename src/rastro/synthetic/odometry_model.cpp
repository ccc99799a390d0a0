// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/odometry_model.h"

#include <cmath>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr double eighth = 0.25 * std::numbers::pi;

double drawn_sign(Random& random) { return random.uniform() < 0.5 ? -1.0 : 1.0; }

}  // namespace

WheelOdometry::WheelOdometry(const OdometryModel& model, std::uint64_t seed) : model_(model), random_(seed) {
  if (!(model.factor >= 0.0 && model.factor <= 100.0))
    throw Error("the odometry's error is out of range", "odometry error", "use a factor of 0 to 100");
  const double constant = model.factor * model.constant_share;
  meter_scale_ = constant * drawn_sign(random_) * model.error_per_meter;
  rotation_scale_ = constant * drawn_sign(random_) * model.error_per_eighth / eighth;
}

const SE2& WheelOdometry::move(const SE2& before_from_body) {
  const Eigen::Vector3d motion = before_from_body.log();
  const double distance = motion.head<2>().norm(), rotation = std::abs(motion.z());
  // Variances add up along the path; the rate gives the remaining part of the model's size after a unit.
  const double rest = model_.factor * std::sqrt(1.0 - model_.constant_share * model_.constant_share);
  const double longer =
      meter_scale_ * distance + rest * model_.error_per_meter * std::sqrt(distance) * random_.normal();
  const double more =
      rotation_scale_ * motion.z() + rest * model_.error_per_eighth * std::sqrt(rotation / eighth) * random_.normal();
  Eigen::Vector3d counted = motion;
  if (distance > 0.0) counted.head<2>() *= 1.0 + longer / distance;
  counted.z() += more;
  odometry_from_body_ = odometry_from_body_ * SE2::exp(counted);
  return odometry_from_body_;
}

}  // namespace rastro
