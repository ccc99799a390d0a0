// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/session.h"

namespace rastro {

OrbSession::OrbSession(const OrbSlamOptions& settings, const SourceInfo& source, const SlamMeans& means)
    : options(options_for(settings, source, means.landmark_map.get())),
      sensor(choose_sensor(options, source)),
      graph(sensor.camera, sensor.sensor, sensor.baseline, orb_options(options)),
      archive(means.archive),
      stop(means.stop) {}

}  // namespace rastro
