// SPDX-License-Identifier: Apache-2.0
// The trajectory of one camera by any odometry, with the state of every frame.
//   example_02_odometry                    frames of the generated world `street`
//   example_02_odometry DATA [METHOD]      a calibrated recording, a folder of images or a video
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>

#include "rastro/base/error.h"
#include "rastro/dataset/open.h"
#include "rastro/methods/methods.h"
#include "rastro/synthetic/worlds/street.h"

namespace {

constexpr int frames_of_street = 24;

void print_update(const rastro::OdometryUpdate& update) {
  const Eigen::Vector3d position = update.world_from_camera.translation();
  fmt::print("frame {:3}: {:12} {:20} {:3} inliers, at ({:.2f}, {:.2f}, {:.2f})\n", update.index,
             rastro::name_of(update.state), rastro::name_of(update.reason), update.inliers, position.x(), position.y(),
             position.z());
}

void estimate(rastro::Source& source, const std::string& method_name) {
  rastro::TaskPool pool(0);  // as many threads as the machine has; the result does not depend on it
  const auto method = rastro::odometry_method(method_name);
  const auto odometry = method->make(source.info(), {&pool});
  while (const auto frame = source.next()) print_update(odometry->process(*frame));

  // Poses as known at the end: those before initialization are given now, later ones are improved.
  const rastro::Trajectory trajectory = odometry->trajectory();
  double path_length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    path_length +=
        (trajectory[i].world_from_body.translation() - trajectory[i - 1].world_from_body.translation()).norm();
  }
  fmt::print("{} poses, path length {:.2f} {}\n", trajectory.size(), path_length,
             method->is_metric() ? "m" : "(arbitrary scale)");
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string method = argc > 2 ? argv[2] : "features";
  if (argc > 1) {
    rastro::OpenOptions open;
    open.want_depth = rastro::odometry_method(method)->wants_depth();
    estimate(*rastro::open(argv[1], open), method);
  } else {
    const rastro::World street = rastro::make_street({.scale = 0.5});
    estimate(*rastro::synthetic_source(street, frames_of_street), method);
  }
  return 0;
} catch (const rastro::Error& error) {  // bad input: one plain line
  fmt::print(stderr, "{}\n", error.what());
  return 2;
} catch (const std::exception& fault) {
  fmt::print(stderr, "a fault: {}\n", fault.what());
  return 3;
}
