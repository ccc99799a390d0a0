// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/rotation_meter.h"

#include <cmath>

#include "rastro/base/error.h"

namespace rastro {
namespace {

// About a twentieth of a driving camera's profiles: finer blocks cost time, coarser ones blur the expansion.
constexpr int column_block = 64, row_block = 16;
constexpr double expansion_step = 0.01;
// Measurement noise of the profile shift of a camera at rest; a creeping motion adds up, because the reference stays.
constexpr double still_shift_px = 0.5;

int expansions_up_to(double most) { return static_cast<int>(std::lround(most / expansion_step)); }

}  // namespace

SO3 rotation_of(double yaw, double pitch) { return SO3::exp({0.0, -yaw, 0.0}) * SO3::exp({pitch, 0.0, 0.0}); }

RotationMeter::RotationMeter(const RotationOptions& options, const Camera& camera)
    : options_(options), camera_(camera) {
  if (!(options.band_top < options.band_bottom)) {
    throw Error("no rows between band_top and band_bottom", "band_top", "give a band_bottom greater than band_top");
  }
  if (!(options.band_left < options.band_right)) {
    throw Error("no columns between band_left and band_right", "band_left", "give a band_right greater than band_left");
  }
  if (!(camera.fx > 0.0 && camera.fy > 0.0)) {
    throw Error("the camera has no focal length", "calibration", "give one with fx and fy greater than 0");
  }
}

void RotationMeter::prepare(GrayView image) {
  columns_.scale = AngleScale::across(camera_, image.width);
  rows_.scale = AngleScale::upright(camera_, image.height);
  columns_.model = {camera_.fx, columns_.scale.zero_step(), options_.max_expansion,
                    expansions_up_to(options_.max_expansion), column_block};
  rows_.model = {camera_.fy, rows_.scale.zero_step(), options_.max_pitch_expansion,
                 expansions_up_to(options_.max_pitch_expansion), row_block};
  prepared_ = true;
}

void RotationMeter::shape(Axis& axis) const {
  if (options_.equal_angles) {
    axis.scale.resample(axis.raw, axis.current);
  } else {
    axis.current = axis.raw;
  }
  if (options_.profile == "centered") subtract_mean(axis.current);
  if (options_.profile == "gradient") take_gradient(axis.current, options_.gradient_reach_px);
}

ExpandingShift RotationMeter::measure(Axis& axis, int max_shift) {
  // Without equal angles a step is a pixel, and the model of passing walls does not hold.
  if (options_.equal_angles && axis.model.expansions > 0) {
    return finder_.find(axis.reference, axis.current, max_shift, axis.model);
  }
  return {find_shift(axis.reference, axis.current, max_shift)};
}

std::optional<ProfileRotation> RotationMeter::measure(GrayView image) {
  if (!prepared_) prepare(image);
  column_profile(image, static_cast<int>(options_.band_top * image.height),
                 static_cast<int>(options_.band_bottom * image.height), columns_.raw);
  shape(columns_);
  if (options_.pitch) {
    row_profile(image, static_cast<int>(options_.band_left * image.width),
                static_cast<int>(options_.band_right * image.width), rows_.raw);
    shape(rows_);
  }
  if (!has_reference_) return std::nullopt;
  ProfileRotation rotation;
  rotation.columns = measure(columns_, options_.max_shift_px);
  if (options_.pitch) rotation.rows = measure(rows_, options_.max_pitch_shift_px);
  rotation.yaw = rotation.columns.shift * (options_.lambda > 0.0 ? options_.lambda : 1.0 / camera_.fx);
  rotation.pitch = rotation.rows.shift / camera_.fy;
  rotation.still = std::abs(rotation.columns.shift) <= still_shift_px &&
                   std::abs(rotation.rows.shift) <= still_shift_px &&
                   rotation.columns.at_zero <= options_.max_still_difference * rotation.columns.mean;
  rotation.weak = rotation.columns.confidence < options_.min_confidence;
  return rotation;
}

void RotationMeter::keep_as_reference() {
  columns_.reference.swap(columns_.current);
  rows_.reference.swap(rows_.current);
  has_reference_ = true;
}

}  // namespace rastro
