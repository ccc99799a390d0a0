// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/options.h"

namespace rastro {
namespace {

void add_odometry_options(OptionTable& table, EkfOptions& o) {
  table.add({"odometry_error_m_per_m",
             &o.odometry_error_m_per_m,
             "m",
             "standard deviation of odometry's way after one metre; 0.02 is the paper's bound for usable odometry",
             1e-6,
             1,
             {}});
  table.add({"odometry_error_deg_per_45_deg",
             &o.odometry_error_deg_per_45_deg,
             "deg",
             "standard deviation of odometry's angle after a turn of 45 deg; 2 is the paper's bound",
             1e-6,
             45,
             {}});
  table.add({"heading_error_deg_per_m",
             &o.heading_error_deg_per_m,
             "deg",
             "standard deviation of odometry's angle after one metre straight on: wheels are never quite alike",
             0,
             45,
             {}});
}

void add_jump_options(OptionTable& table, EkfOptions& o) {
  table.add({"max_speed_m_per_s",
             &o.max_speed_m_per_s,
             "m/s",
             "odometry that says more has jumped and is not used for this frame",
             0.01,
             100,
             {}});
  table.add({"max_turn_deg_per_s", &o.max_turn_deg_per_s, "deg/s", "as max_speed_m_per_s, for turns", 1, 3600, {}});
  table.add({"jump_m",
             &o.jump_m,
             "m",
             "added to what max_speed_m_per_s allows between two frames: stamps of logs are rough",
             0,
             100,
             {}});
  table.add({"jump_deg", &o.jump_deg, "deg", "as jump_m, for turns", 0, 180, {}});
  table.add({"unknown_speed_m_per_s",
             &o.unknown_speed_m_per_s,
             "m/s",
             "standard deviation of the speed where odometry is missing or has jumped",
             0.001,
             100,
             {}});
  table.add({"unknown_turn_deg_per_s",
             &o.unknown_turn_deg_per_s,
             "deg/s",
             "as unknown_speed_m_per_s, for turns",
             0.1,
             3600,
             {}});
  table.add({"max_blind_m",
             &o.max_blind_m,
             "m",
             "way without a recognised landmark after which a pose is called weak",
             0,
             1e6,
             {}});
}

void add_sighting_options(OptionTable& table, EkfOptions& o) {
  table.add(
      {"range_noise_m", &o.range_noise_m, "m", "standard deviation of the range of a given landmark", 1e-6, 100, {}});
  table.add(
      {"range_noise_share", &o.range_noise_share, "", "and what is added to it, as share of the range", 0, 1, {}});
  table.add({"bearing_noise_deg",
             &o.bearing_noise_deg,
             "deg",
             "standard deviation of the bearing of a given landmark",
             1e-6,
             45,
             {}});
  table.add({"max_sighting_m", &o.max_sighting_m, "m", "given landmarks farther away are not used", 0.1, 1e5, {}});
}

void add_association_options(OptionTable& table, EkfOptions& o) {
  table.add(
      {"gate",
       &o.gate,
       "",
       "largest squared Mahalanobis distance (2 degrees of freedom) of a sighting to its landmark; 9.21 holds 99 % "
       "of the true pairs",
       0.1,
       1000,
       {}});
  table.add({"named_gate",
             &o.named_gate,
             "",
             "as gate, where the sensor names the landmark; 27.6 holds all but one of a million",
             0.1,
             1e6,
             {}});
  table.add({"new_gate",
             &o.new_gate,
             "",
             "a sighting nearer than this to a landmark is not taken for another one",
             0.1,
             1e6,
             {}});
  table.add(
      {"ambiguity",
       &o.ambiguity,
       "",
       "squared distance by which the second nearest landmark must be farther, if it is inside the gate; else the "
       "sighting is not used; 3 makes the nearest more than four times as likely",
       0,
       1000,
       {}});
}

void add_unsure_options(OptionTable& table, EkfOptions& o) {
  table.add({"unsure_m",
             &o.unsure_m,
             "m",
             "a landmark without a name whose place in front of the body is less certain than this is recognised only "
             "together with companions",
             0,
             1e6,
             {}});
  table.add({"companions",
             &o.companions,
             "",
             "other landmarks recognised in the same frame, at the distances the map says, that unsure_m asks for",
             0,
             100,
             {}});
  table.add({"max_direction_deg",
             &o.max_direction_deg,
             "deg",
             "corners that look to directions farther apart are not the same",
             1,
             180,
             {}});
}

void add_candidate_options(OptionTable& table, EkfOptions& o) {
  table.add(
      {"observations", &o.observations, "", "frames in which a thing must be seen to become a landmark", 1, 1000, {}});
  table.add({"candidate_frames",
             &o.candidate_frames,
             "frames",
             "a thing not seen again within so many is forgotten before it becomes a landmark",
             1,
             10000,
             {}});
  table.add({"max_landmarks",
             &o.max_landmarks,
             "",
             "no more are added: the time of an update grows with their square",
             1,
             20000,
             {}});
}

void add_line_options(OptionTable& table, EkfOptions& o) {
  table.add({"seed", &o.seed, "", "of every random draw: RANSAC samples", 0, 9.0e15, {}});
  table.add({"min_returns", &o.min_returns, "beams", "a scan with fewer returns is not used", 2, 10000, {}});
  table.add({"beam_noise_m", &o.beam_noise_m, "m", "standard deviation of a beam's range", 1e-5, 1, {}});
  table.add(
      {"max_beam_m", &o.max_beam_m, "m", "returns from farther are not used for lines and spikes", 0.5, 1000, {}});
  table.add({"beam_gap_m",
             &o.beam_gap_m,
             "m",
             "neighbouring returns farther apart than this, and than beam_gap_share of their range, are of different "
             "things",
             0.01,
             10,
             {}});
  table.add(
      {"beam_gap_share", &o.beam_gap_share, "", "see beam_gap_m: far returns lie apart on the same wall", 0, 1, {}});
  table.add({"ransac_iterations", &o.ransac_iterations, "", "samples drawn for one line", 1, 10000, {}});
  table.add({"ransac_reach_deg",
             &o.ransac_reach_deg,
             "deg",
             "the two returns of a sample are at most so far apart, as seen from the scanner",
             0.1,
             180,
             {}});
  table.add({"line_tolerance_m", &o.line_tolerance_m, "m", "returns farther from a line are not on it", 0.001, 1, {}});
  table.add({"min_line_beams", &o.min_line_beams, "beams", "a line with fewer returns is not used", 3, 1000, {}});
  table.add({"min_line_m", &o.min_line_m, "m", "a shorter line is not used", 0.05, 100, {}});
}

void add_feature_options(OptionTable& table, EkfOptions& o) {
  table.add({"corners", &o.corners, "", "corners of lines as landmarks", 0, 1, {}});
  table.add({"min_corner_deg",
             &o.min_corner_deg,
             "deg",
             "lines that turn by less, or turn back by less, do not make a corner",
             5,
             90,
             {}});
  table.add({"corner_gap_m", &o.corner_gap_m, "m", "how far from the corner both lines may end", 0.01, 5, {}});
  table.add({"corner_error_m",
             &o.corner_error_m,
             "m",
             "standard deviation of a corner's place besides what the beams' noise gives: walls are not lines",
             1e-4,
             1,
             {}});
  table.add({"spikes", &o.spikes, "", "poles as landmarks", 0, 1, {}});
  table.add(
      {"min_spike_beams", &o.min_spike_beams, "beams", "a pole takes no fewer: one alone may be noise", 1, 100, {}});
  table.add({"max_spike_beams", &o.max_spike_beams, "beams", "a pole takes no more", 1, 100, {}});
  table.add({"max_spike_m", &o.max_spike_m, "m", "a pole is no wider", 0.01, 5, {}});
  table.add({"spike_depth_m", &o.spike_depth_m, "m", "what is beside a pole is farther away by this", 0.05, 50, {}});
  table.add({"max_spike_range_m",
             &o.max_spike_range_m,
             "m",
             "a farther pole is not used: few beams hit it, and much looks like it",
             0.5,
             1000,
             {}});
  table.add({"spike_error_m",
             &o.spike_error_m,
             "m",
             "standard deviation of a pole's place besides what the beams' noise gives",
             1e-4,
             1,
             {}});
}

void add_map_options(OptionTable& table, EkfOptions& o) {
  table.add({"keyframe_m", &o.keyframe_m, "m", "way between two poses shown as keyframes", 0.01, 1000, {}});
  table.add({"keyframe_deg", &o.keyframe_deg, "deg", "turn between two poses shown as keyframes", 1, 360, {}});
  table.add({"grid", &o.grid, "", "draw the scans into an occupancy grid, for the eye only", 0, 1, {}});
  table.add({"cell_m", &o.cell_m, "m", "side of its cells", 0.005, 1, {}});
}

}  // namespace

OptionTable option_table(EkfOptions& options) {
  OptionTable table;
  add_odometry_options(table, options);
  add_jump_options(table, options);
  add_sighting_options(table, options);
  add_association_options(table, options);
  add_unsure_options(table, options);
  add_candidate_options(table, options);
  add_line_options(table, options);
  add_feature_options(table, options);
  add_map_options(table, options);
  return table;
}

}  // namespace rastro
