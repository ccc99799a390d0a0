// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/loss_advice.h"

namespace rastro::cli {

std::string advice_for(SlamReason reason) {
  switch (reason) {
    case SlamReason::none:
    case SlamReason::first_frame:
      return "";
    case SlamReason::no_data:
    case SlamReason::gap:
      return "frames are missing: record at a higher rate, or to a faster disk";
    case SlamReason::few_returns:
      return "the sensor measures little here: keep to its range, away from glass, black surfaces and sunlight";
    case SlamReason::poor_match:
      return "what is seen does not fit the map: move slower; check the calibration with 'rastro check'";
    case SlamReason::degenerate:
      return "one direction cannot be measured here: use wheel odometry, or turn the sensor towards more structure";
    case SlamReason::too_few_points:
      return "too little texture: aim at more structure, add light, or lower the detection threshold";
    case SlamReason::few_inliers:
      return "matches disagree: move slower, and keep people and cars from filling the image";
    case SlamReason::no_odometry:
      return "wheel odometry is missing for this frame: check its topic and stamps";
    case SlamReason::dark_or_blank:
      return "the image shows nothing: uncover the camera, add light, or aim at more structure; 16-bit images must use "
             "the whole range";
    case SlamReason::repeated_frame:
      return "the same frame came again: check the recording with 'rastro check'";
    case SlamReason::odometry_jumped:
      return "wheel odometry jumped: check its unit (meters, radians) and source, or raise the limits of speed";
    case SlamReason::blurred:
      return "motion blur: rotate slower, or use a shorter exposure";
    case SlamReason::not_found:
      return "the place is not known: go back to where the map was made, and look the same way";
    case SlamReason::apart:
      return "this part of the map is not connected yet: return to a place seen before";
    case SlamReason::unconfirmed:
      return "keep looking at this place until more frames agree; the detail says what is not confirmed yet";
    case SlamReason::implausible_motion:
      return "the pose jumps: move slower, and look for moving things that fill the image";
    case SlamReason::uncertain_scale:
      return "one camera turned too fast: turn slower and move sideways meanwhile, or go back to a place seen before";
  }
  return "";
}

std::string advice_for(OdometryReason reason) {
  switch (reason) {
    case OdometryReason::none:
    case OdometryReason::first_frame:
    case OdometryReason::no_motion:
      return "";
    case OdometryReason::too_little_parallax:
      return "move the camera sideways: its motion is too small for the distance of what it sees";
    case OdometryReason::pure_rotation:
      return "do not only turn the camera: one camera needs a translation to begin";
    case OdometryReason::calibration_doubtful:
      return "check fx, fy, cx, cy and the distortion: events.jsonl has the values that fit better";
    case OdometryReason::too_few_points:
      return advice_for(SlamReason::too_few_points);
    case OdometryReason::few_inliers:
      return advice_for(SlamReason::few_inliers);
    case OdometryReason::dark_or_blank:
      return advice_for(SlamReason::dark_or_blank);
    case OdometryReason::blurred:
      return advice_for(SlamReason::blurred);
    case OdometryReason::repeated_frame:
      return advice_for(SlamReason::repeated_frame);
    case OdometryReason::gap:
      return advice_for(SlamReason::gap);
  }
  return "";
}

std::string advice_for(TrackHealth health) {
  switch (health) {
    case TrackHealth::good:
      return "";
    case TrackHealth::few_corners:
      return "too little texture: aim at more structure, add light, or ask for fewer --features";
    case TrackHealth::dark_or_blank:
      return advice_for(SlamReason::dark_or_blank);
    case TrackHealth::abrupt_motion:
      return "the image moved too far between two frames: move slower, or record at a higher rate";
  }
  return "";
}

}  // namespace rastro::cli
