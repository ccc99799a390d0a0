// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/rotation_options.h"

namespace rastro {
namespace {

void add_profile_options(OptionTable& table, RotationOptions& o) {
  table.add({"max_shift_px",
             &o.max_shift_px,
             "px",
             "largest shift between frames looked for; 150 as in the paper",
             1,
             2000,
             {}});
  table.add({"lambda", &o.lambda, "rad/px", "yaw of a shift of one pixel; 0: 1 / fx of the calibration", 0, 1, {}});
  table.add({"profile",
             &o.profile,
             "",
             "plain: sums of columns, the paper's; centred: their mean taken off, against changes of brightness; "
             "gradient: their differences along the image, against changes of light from one side as well",
             0,
             0,
             {"plain", "centred", "gradient"}});
  table.add({"gradient_reach_px", &o.gradient_reach_px, "px", "half the distance of the differences", 1, 50, {}});
  table.add({"equal_angles",
             &o.equal_angles,
             "",
             "profiles are looked up at equal steps of angle, as a turn moves the outer columns of a pinhole image by "
             "more than the inner ones; false: the paper's way",
             0,
             1,
             {}});
}

void add_yaw_options(OptionTable& table, RotationOptions& o) {
  table.add({"band_top",
             &o.band_top,
             "",
             "first row summed up, as share of the height; with band_bottom the far scene, as near ground moves by "
             "itself. 0 and 1: all rows, the paper's way",
             0,
             1,
             {}});
  table.add({"band_bottom", &o.band_bottom, "", "end of the rows summed up, as share of the height", 0, 1, {}});
  table.add({"max_expansion",
             &o.max_expansion,
             "",
             "largest motion forward between two frames, as share of the distance of what stands at the sides, that "
             "is told from a turn; 0: the shift alone is sought, the paper's way",
             0,
             1,
             {}});
}

void add_pitch_options(OptionTable& table, RotationOptions& o) {
  table.add({"pitch", &o.pitch, "", "pitch from row profiles; false: none, the paper's way", 0, 1, {}});
  table.add({"pitch_forgetting",
             &o.pitch_forgetting,
             "",
             "share of each frame in the running mean of pitch, which is taken off: the ground that passes below makes "
             "pitch drift, and a road stays level. 0: nothing is taken off",
             0,
             1,
             {}});
  table.add({"max_pitch_shift_px", &o.max_pitch_shift_px, "px", "as max_shift_px, of row profiles", 1, 2000, {}});
  table.add({"band_left", &o.band_left, "", "first column of the row profiles, as share of the width", 0, 1, {}});
  table.add({"band_right", &o.band_right, "", "end of their columns, as share of the width", 0, 1, {}});
  table.add({"max_pitch_expansion",
             &o.max_pitch_expansion,
             "",
             "as max_expansion, for the ground below and what is above",
             0,
             1,
             {}});
}

void add_judgement_options(OptionTable& table, RotationOptions& o) {
  table.add({"min_confidence",
             &o.min_confidence,
             "",
             "a shift whose difference is not lower by this share than the best other one is a weak one",
             0,
             1,
             {}});
  table.add({"max_still_difference",
             &o.max_still_difference,
             "",
             "a profile that differs by no more than this share of the mean over all shifts, unshifted, has not moved",
             0,
             1,
             {}});
  table.add({"max_turn_change_deg",
             &o.max_turn_change_deg,
             "deg",
             "a weak shift is believed if the turn differs by no more from that of the frame before",
             0,
             180,
             {}});
}

}  // namespace

void add_options(OptionTable& table, RotationOptions& options) {
  add_profile_options(table, options);
  add_yaw_options(table, options);
  add_pitch_options(table, options);
  add_judgement_options(table, options);
}

}  // namespace rastro
