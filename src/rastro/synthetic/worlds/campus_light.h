// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/renderer.h"

namespace rastro::campus {

/// Lamps and sun: a clear morning, a covered noon and a clear evening, one per lap. Lamps are lit or not for each lap;
/// outside the sun moves and the building casts its shadow. Seeds change lamps and the strength of the sun.
LightField make_light(std::uint64_t seed);

/// The camera's exposure, which follows the light with a delay.
SensorModel sensor_at(double time_s);

}  // namespace rastro::campus
