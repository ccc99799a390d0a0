// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/odometry/odometry.h"
#include "rastro/slam/slam.h"
#include "rastro/track/track_frame.h"

namespace rastro::cli {

/// What a person can do about a frame that is weak or lost for this reason; empty where nothing needs to be done.
std::string advice_for(SlamReason reason);
std::string advice_for(OdometryReason reason);
std::string advice_for(TrackHealth health);

}  // namespace rastro::cli
