// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"

namespace rastro {

/// A profile's unit: 1/64 of an intensity level. Integers, so that sums do not depend on the order of summation.
constexpr int profile_units = 64;
using Profile = std::vector<std::int16_t>;

/// Mean intensity of each column over the rows [first_row, end_row), in profile units; the intensity profile of METHODS
/// 2.2. An empty range gives zeros.
void column_profile(GrayView image, int first_row, int end_row, Profile& profile);
/// Mean intensity of each row over the columns [first_column, end_column), in profile units.
void row_profile(GrayView image, int first_column, int end_column, Profile& profile);

/// The pixels at equal steps of angle along one of a camera's axes. In a pinhole image the pixels are denser in angle
/// farther out, so a rotation moves outer columns by more than inner ones; sampled at equal angles the profile moves as
/// a whole.
class AngleScale {
 public:
  AngleScale() = default;
  /// Steps of 1/fx (horizontally) or 1/fy (vertically) radians over the part of the image that has rays.
  static AngleScale across(const Camera& camera, int width);
  static AngleScale upright(const Camera& camera, int height);

  /// `pixels` interpolated at the steps; one value per step.
  void resample(const Profile& pixels, Profile& angles) const;
  std::size_t size() const { return entries_.size(); }
  /// Angle of step i = (i - zero_step) / focal length.
  int zero_step() const { return zero_step_; }

 private:
  struct Entry {
    std::int32_t pixel;
    std::int32_t fraction;  ///< Of 256.
  };
  static AngleScale along(const Camera& camera, const Eigen::Vector2d& axis, int pixels);

  std::vector<Entry> entries_;
  int zero_step_ = 0;
};

/// Subtracts the mean, so that a change of brightness does not change the profile.
void subtract_mean(Profile& profile);
/// Replaces each value by the difference of the values `reach` on either side; 0 within `reach` of the ends.
void take_gradient(Profile& profile, int reach);

}  // namespace rastro
