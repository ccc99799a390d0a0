// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/session.h"

namespace rastro {

OrbSession::OrbSession(const OrbSlamOptions& settings, const SourceInfo& source, const SlamContext& context,
                       const OrbMethodParts& parts)
    : options(options_for(settings, source, context.map.get())),
      sensor(choose_sensor(options, source)),
      method(parts.method),
      direct{.alignment = parts.direct && sensor.sensor != CameraKind::mono ? parts.direct(sensor) : nullptr},
      graph(sensor.camera, sensor.sensor, sensor.baseline, orb_options(options)),
      archive(context.archive),
      stop(context.stop) {}

}  // namespace rastro
