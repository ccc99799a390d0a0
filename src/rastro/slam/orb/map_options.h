// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/slam/orb/options.h"

namespace rastro {

/// The options of what makes and corrects the map, by group.
void add_mapping_options(OptionTable& table, OrbSlamOptions& o);
void add_adjustment_options(OptionTable& table, OrbSlamOptions& o);
void add_loss_options(OptionTable& table, OrbSlamOptions& o);
void add_place_options(OptionTable& table, OrbSlamOptions& o);
void add_relocalization_options(OptionTable& table, OrbSlamOptions& o);
void add_loop_options(OptionTable& table, OrbSlamOptions& o);
void add_loop_drift_options(OptionTable& table, OrbSlamOptions& o);
void add_covariance_options(OptionTable& table, OrbSlamOptions& o);

}  // namespace rastro
