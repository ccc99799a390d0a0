// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/profiles/options.h"

namespace rastro {

OptionTable option_table(ProfilesOptions& options) {
  OptionTable table;
  add_options(table, options.rotation);
  table.add({"forward_step",
             &options.forward_step,
             "frame steps",
             "how far each frame goes ahead, as profiles tell no speed: 1 gives the shape of the path at constant "
             "speed, 0 the turning alone",
             0,
             1e6,
             {}});
  table.add({"max_bridged_frames",
             &options.max_bridged_frames,
             "frames",
             "over so many frames without a use the last motion is carried on; then none is",
             0,
             1000,
             {}});
  add_options(table, options.check);
  return table;
}

}  // namespace rastro
