// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/rotation_options.h"

namespace rastro {
namespace {

void add_profile_options(OptionTable& table, RotationOptions& o) {
  table.add({"max_shift_px", &o.max_shift_px, "px", "maximum shift between frames; 150 as in the paper", 1, 2000, {}});
  table.add({"lambda", &o.lambda, "rad/px", "yaw of a shift of one pixel; 0: 1 / fx of the calibration", 0, 1, {}});
  table.add({"profile",
             &o.profile,
             "",
             "plain: sums of columns, as in the paper; centered: their mean subtracted, against changes of brightness; "
             "gradient: their differences along the image, against changes of light from one side as well",
             0,
             0,
             {"plain", "centered", "gradient"}});
  table.add_former_choice("profile", "centred", "centered");
  table.add({"gradient_reach_px", &o.gradient_reach_px, "px", "half the distance of the differences", 1, 50, {}});
  table.add(
      {"equal_angles",
       &o.equal_angles,
       "",
       "profiles are sampled at equal steps of angle, as a rotation moves the outer columns of a pinhole image by "
       "more than the inner ones; false: as in the paper",
       0,
       1,
       {}});
}

void add_yaw_options(OptionTable& table, RotationOptions& o) {
  table.add(
      {"band_top",
       &o.band_top,
       "",
       "first row of the sums, as share of the height; with band_bottom selects the far scene, as near ground has "
       "its own motion. 0 and 1: all rows, as in the paper",
       0,
       1,
       {}});
  table.add({"band_bottom", &o.band_bottom, "", "end of the rows of the sums, as share of the height", 0, 1, {}});
  table.add({"max_expansion",
             &o.max_expansion,
             "",
             "maximum forward motion between two frames, as share of the lateral distance of passing walls, that is "
             "distinguished from a rotation; 0: the shift alone, as in the paper",
             0,
             1,
             {}});
}

void add_pitch_options(OptionTable& table, RotationOptions& o) {
  table.add({"pitch", &o.pitch, "", "pitch from row profiles; false: none, as in the paper", 0, 1, {}});
  table.add({"pitch_forgetting",
             &o.pitch_forgetting,
             "",
             "share of each frame in the running mean of pitch, which is subtracted: the ground passing below makes "
             "pitch drift, and a road stays level. 0: not subtracted",
             0,
             1,
             {}});
  table.add({"max_pitch_shift_px", &o.max_pitch_shift_px, "px", "as max_shift_px, of row profiles", 1, 2000, {}});
  table.add({"band_left", &o.band_left, "", "first column of the row profiles, as share of the width", 0, 1, {}});
  table.add({"band_right", &o.band_right, "", "end of their columns, as share of the width", 0, 1, {}});
  table.add({"max_pitch_expansion",
             &o.max_pitch_expansion,
             "",
             "as max_expansion, for the ground below and the ceiling above",
             0,
             1,
             {}});
}

void add_judgment_options(OptionTable& table, RotationOptions& o) {
  table.add({"min_confidence",
             &o.min_confidence,
             "",
             "a shift is weak if its difference is not lower by this share than that of the best other one",
             0,
             1,
             {}});
  table.add({"max_still_difference",
             &o.max_still_difference,
             "",
             "the camera is at rest if the unshifted profile differs by at most this share of the mean over all shifts",
             0,
             1,
             {}});
  table.add({"max_rotation_change_deg",
             &o.max_rotation_change_deg,
             "deg",
             "a weak shift is accepted if its rotation differs by at most this from that of the previous frame",
             0,
             180,
             {}});
  table.add_former_name("max_turn_change_deg", "max_rotation_change_deg");
}

}  // namespace

void set_paper_preset(RotationOptions& options) {
  options.profile = "plain";
  options.equal_angles = false;
  options.band_top = 0.0;
  options.band_bottom = 1.0;
  options.max_expansion = 0.0;
  options.pitch = false;
}

void add_options(OptionTable& table, RotationOptions& options) {
  add_profile_options(table, options);
  add_yaw_options(table, options);
  add_pitch_options(table, options);
  add_judgment_options(table, options);
}

}  // namespace rastro
