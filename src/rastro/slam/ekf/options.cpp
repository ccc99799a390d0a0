// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/options.h"

namespace rastro {
namespace {

void add_odometry_options(OptionTable& table, EkfOptions& o) {
  table.add(
      {"odometry_error_m_per_m",
       &o.odometry_error_m_per_m,
       "m",
       "standard deviation of the odometry's translation per meter; 0.02 is the paper's bound for usable odometry",
       1e-6,
       1,
       {}});
  table.add({"odometry_error_deg_per_45_deg",
             &o.odometry_error_deg_per_45_deg,
             "deg",
             "standard deviation of the odometry's yaw per 45 deg of rotation; 2 is the paper's bound",
             1e-6,
             45,
             {}});
  table.add({"heading_error_deg_per_m",
             &o.heading_error_deg_per_m,
             "deg",
             "standard deviation of the odometry's yaw per meter of straight motion: wheels are never identical",
             0,
             45,
             {}});
}

void add_scale_options(OptionTable& table, EkfOptions& o) {
  table.add({"translation_scale_error",
             &o.translation_scale_error,
             "",
             "standard deviation of the share by which the odometry's translations are wrong for the whole drive "
             "(wheels of another size), which the filter estimates; 0: not estimated",
             0,
             1,
             {}});
  table.add({"rotation_scale_error",
             &o.rotation_scale_error,
             "",
             "as translation_scale_error, for rotations (axle track)",
             0,
             1,
             {}});
}

void add_jump_options(OptionTable& table, EkfOptions& o) {
  table.add({"max_speed_m_per_s",
             &o.max_speed_m_per_s,
             "m/s",
             "faster odometry has jumped and is not used for this frame",
             0.01,
             100,
             {}});
  table.add({"max_yaw_rate_deg_per_s",
             &o.max_yaw_rate_deg_per_s,
             "deg/s",
             "as max_speed_m_per_s, for rotations",
             1,
             3600,
             {}});
  table.add({"jump_m",
             &o.jump_m,
             "m",
             "tolerance of max_speed_m_per_s between two frames, since timestamps of logs are inexact",
             0,
             100,
             {}});
  table.add({"jump_deg", &o.jump_deg, "deg", "as jump_m, for rotations", 0, 180, {}});
  table.add(
      {"unknown_speed_m_per_s",
       &o.unknown_speed_m_per_s,
       "m/s",
       "standard deviation of the speed where odometry is missing or has jumped, by one error that lasts for 10 s",
       0.001,
       100,
       {}});
  table.add({"unknown_yaw_rate_deg_per_s",
             &o.unknown_yaw_rate_deg_per_s,
             "deg/s",
             "as unknown_speed_m_per_s, for rotations",
             0.1,
             3600,
             {}});
  table.add({"max_blind_m",
             &o.max_blind_m,
             "m",
             "distance without an observed landmark after which a pose is weak",
             0,
             1e6,
             {}});
  table.add_former_name("max_turn_deg_per_s", "max_yaw_rate_deg_per_s");
  table.add_former_name("unknown_turn_deg_per_s", "unknown_yaw_rate_deg_per_s");
}

void add_observation_options(OptionTable& table, EkfOptions& o) {
  table.add(
      {"range_noise_m", &o.range_noise_m, "m", "standard deviation of the range of a given landmark", 1e-6, 100, {}});
  table.add({"range_noise_share",
             &o.range_noise_share,
             "",
             "part of that standard deviation that grows with the range, as share of it",
             0,
             1,
             {}});
  table.add({"bearing_noise_deg",
             &o.bearing_noise_deg,
             "deg",
             "standard deviation of the bearing of a given landmark",
             1e-6,
             45,
             {}});
  table.add(
      {"max_observation_m", &o.max_observation_m, "m", "given landmarks farther away are not used", 0.1, 1e5, {}});
  table.add_former_name("max_sighting_m", "max_observation_m");
}

void add_association_options(OptionTable& table, EkfOptions& o) {
  table.add({"gate",
             &o.gate,
             "",
             "gate of data association: maximum squared Mahalanobis distance of an observation to its landmark (2 "
             "degrees of freedom); 9.21 accepts 99 % of the correct ones",
             0.1,
             1000,
             {}});
  table.add({"named_gate",
             &o.named_gate,
             "",
             "as gate, for landmarks that the sensor identifies; 27.6 accepts all but one in a million",
             0.1,
             1e6,
             {}});
  table.add({"new_gate",
             &o.new_gate,
             "",
             "an observation nearer than this to a landmark does not make a new one",
             0.1,
             1e6,
             {}});
  table.add({"ambiguity",
             &o.ambiguity,
             "",
             "minimum difference of the squared distances to the nearest and second nearest landmark within the gate; "
             "below, the observation is not used; 3 makes the nearest more than four times as likely",
             0,
             1000,
             {}});
}

void add_unsure_options(OptionTable& table, EkfOptions& o) {
  table.add(
      {"unsure_m",
       &o.unsure_m,
       "m",
       "an unidentified landmark whose position relative to the body is less certain than this is recognized only with "
       "companions",
       0,
       1e6,
       {}});
  table.add({"companions",
             &o.companions,
             "",
             "other landmarks that must be recognized with it, all at the distances of the map, see unsure_m",
             0,
             100,
             {}});
  table.add({"max_direction_deg",
             &o.max_direction_deg,
             "deg",
             "maximum difference in orientation of matching corners",
             1,
             180,
             {}});
}

void add_candidate_options(OptionTable& table, EkfOptions& o) {
  table.add({"observations",
             &o.observations,
             "",
             "frames in which a candidate must be observed to become a landmark",
             1,
             1000,
             {}});
  table.add({"candidate_frames",
             &o.candidate_frames,
             "frames",
             "a candidate not observed again within this many frames is dropped",
             1,
             10000,
             {}});
  table.add({"max_landmarks",
             &o.max_landmarks,
             "",
             "maximum number of landmarks, a twentieth of it for candidates alone: the time of an update grows with "
             "its square",
             1,
             20000,
             {}});
}

void add_line_options(OptionTable& table, EkfOptions& o) {
  table.add({"seed", &o.seed, "", "seed of the random numbers: RANSAC samples", 0, 9.0e15, {}});
  table.add({"min_returns", &o.min_returns, "beams", "returns that a scan needs", 2, 10000, {}});
  table.add({"beam_noise_m", &o.beam_noise_m, "m", "standard deviation of a beam's range", 1e-5, 1, {}});
  table.add({"max_beam_m", &o.max_beam_m, "m", "farther returns are not used for lines and poles", 0.5, 1000, {}});
  table.add(
      {"beam_gap_m",
       &o.beam_gap_m,
       "m",
       "neighboring returns farther apart than this, and than beam_gap_share of their range, are of different objects",
       0.01,
       10,
       {}});
  table.add(
      {"beam_gap_share", &o.beam_gap_share, "", "see beam_gap_m: far returns on a wall are farther apart", 0, 1, {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "RANSAC iterations per line", 1, 10000, {}});
  table.add({"ransac_reach_deg",
             &o.ransac_reach_deg,
             "deg",
             "maximum angle between the two returns of a sample, seen from the scanner",
             0.1,
             180,
             {}});
  table.add({"line_tolerance_m", &o.line_tolerance_m, "m", "maximum distance of an inlier to its line", 0.001, 1, {}});
  table.add({"min_line_beams", &o.min_line_beams, "beams", "returns that a line needs", 3, 1000, {}});
  table.add({"min_line_m", &o.min_line_m, "m", "minimum length of a line", 0.05, 100, {}});
}

void add_feature_options(OptionTable& table, EkfOptions& o) {
  table.add({"corners", &o.corners, "", "corners of lines are landmarks", 0, 1, {}});
  table.add({"min_corner_deg", &o.min_corner_deg, "deg", "minimum angle between the two lines of a corner", 5, 90, {}});
  table.add(
      {"corner_gap_m", &o.corner_gap_m, "m", "maximum distance from a corner to the ends of its lines", 0.01, 5, {}});
  table.add({"corner_error_m",
             &o.corner_error_m,
             "m",
             "standard deviation of a corner's position in addition to beam noise: walls are not exact lines",
             1e-4,
             1,
             {}});
  table.add({"spikes", &o.spikes, "", "poles are landmarks", 0, 1, {}});
  table.add({"min_spike_beams",
             &o.min_spike_beams,
             "beams",
             "minimum number of returns of a pole: a single one may be noise",
             1,
             100,
             {}});
  table.add({"max_spike_beams", &o.max_spike_beams, "beams", "maximum number of returns of a pole", 1, 100, {}});
  table.add({"max_spike_m", &o.max_spike_m, "m", "maximum width of a pole", 0.01, 5, {}});
  table.add({"spike_depth_m", &o.spike_depth_m, "m", "minimum distance of a pole to what is behind it", 0.05, 50, {}});
  table.add({"max_spike_range_m",
             &o.max_spike_range_m,
             "m",
             "maximum range of a pole: farther ones have few returns and are ambiguous",
             0.5,
             1000,
             {}});
  table.add({"spike_error_m",
             &o.spike_error_m,
             "m",
             "standard deviation of a pole's position in addition to beam noise",
             1e-4,
             1,
             {}});
}

void add_map_options(OptionTable& table, EkfOptions& o) {
  table.add({"keyframe_m", &o.keyframe_m, "m", "translation between keyframes", 0.01, 1000, {}});
  table.add({"keyframe_deg", &o.keyframe_deg, "deg", "rotation between keyframes", 1, 360, {}});
  table.add({"grid", &o.grid, "", "make an occupancy grid of the scans, for display only", 0, 1, {}});
  table.add({"cell_m", &o.cell_m, "m", "cell size of the grid", 0.005, 1, {}});
}

}  // namespace

OptionTable option_table(EkfOptions& options) {
  OptionTable table;
  add_odometry_options(table, options);
  add_scale_options(table, options);
  add_jump_options(table, options);
  add_observation_options(table, options);
  add_association_options(table, options);
  add_unsure_options(table, options);
  add_candidate_options(table, options);
  add_line_options(table, options);
  add_feature_options(table, options);
  add_map_options(table, options);
  return table;
}

}  // namespace rastro
