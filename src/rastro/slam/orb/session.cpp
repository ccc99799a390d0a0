// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/session.h"

namespace rastro {

OrbSession::OrbSession(const OrbSlamOptions& settings, const SourceInfo& source, const SlamContext& context)
    : options(options_for(settings, source, context.map.get())),
      sensor(choose_sensor(options, source)),
      graph(sensor.camera, sensor.sensor, sensor.baseline, orb_options(options)),
      archive(context.archive),
      stop(context.stop) {}

}  // namespace rastro
