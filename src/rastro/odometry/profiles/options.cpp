// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/profiles/options.h"

namespace rastro {

OptionTable option_table(ProfilesOptions& options) {
  OptionTable table;
  add_options(table, options.rotation);
  table.add({"forward_step",
             &options.forward_step,
             "frame steps",
             "distance that each frame moves ahead, as profiles give no speed: 1 gives the path's shape at constant "
             "speed, 0 the rotation alone",
             0,
             1e6,
             {}});
  table.add({"max_bridged_frames",
             &options.max_bridged_frames,
             "frames",
             "over so many rejected frames the last motion is repeated; further ones count as lost",
             0,
             1000,
             {}});
  add_options(table, options.check);
  return table;
}

}  // namespace rastro
