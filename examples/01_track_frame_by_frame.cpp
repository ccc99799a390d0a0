// SPDX-License-Identifier: Apache-2.0
// Use of rastro by a SLAM back end: pass one image at a time, get features with persistent ids.
//   example_01_track_frame_by_frame           frames of the generated world `hall`
//   example_01_track_frame_by_frame DATA      a recording, a folder of images or a video
#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "rastro/base/error.h"
#include "rastro/dataset/open.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/track/tracker.h"

namespace {

constexpr int frames_of_hall = 30;

void print_frame(const rastro::TrackFrame& frame) {
  fmt::print("frame {:3} at {:.3f} s: {:3} tracked, {:2} new, {:2} re-identified, {:2} lost\n", frame.index,
             rastro::to_seconds(frame.stamp), frame.tracked, frame.fresh, frame.reidentified, frame.lost);
  for (const rastro::TrackedFeature& feature : frame.features) {
    if (feature.state != rastro::TrackState::reidentified) continue;
    // A back end would add this observation to the landmark that it created from the same id long ago.
    fmt::print("  feature {} re-identified after {} frames, ray ({:.3f}, {:.3f})\n", feature.id,
               frame.index - feature.last_seen, feature.ray.x(), feature.ray.y());
  }
}

void track(rastro::Source& source) {
  const auto& camera = source.info().cameras.front().camera;  // without a calibration the rays are NaN
  rastro::TaskPool pool(0);
  rastro::Tracker tracker(rastro::TrackOptions{}, camera, &pool);
  while (const auto frame = source.next()) print_frame(tracker.process(frame->image, frame->stamp));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc > 1) {
    track(*rastro::open(argv[1]));
  } else {
    const rastro::World hall = rastro::make_hall();
    track(*rastro::synthetic_source(hall, frames_of_hall));
  }
  return 0;
} catch (const rastro::Error& error) {  // bad input: one plain line
  fmt::print(stderr, "{}\n", error.what());
  return 2;
} catch (const std::exception& fault) {
  fmt::print(stderr, "a fault: {}\n", fault.what());
  return 3;
}
