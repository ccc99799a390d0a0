// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"

namespace rastro {

/// A profile's unit: 1/64 grey level. Integers, so that sums do not depend on the order of summing.
constexpr int profile_units = 64;
using Profile = std::vector<std::int16_t>;

/// Mean grey of each column over the rows [first_row, end_row), in profile units; the intensity profile of METHODS 2.2.
/// An empty range gives zeros.
void column_profile(GreyView image, int first_row, int end_row, Profile& profile);
/// Mean grey of each row over the columns [first_column, end_column), in profile units.
void row_profile(GreyView image, int first_column, int end_column, Profile& profile);

/// Which pixels a camera sees at equal steps of angle along one of its axes. A pinhole's pixels lie the denser in angle
/// the farther out they are, so that a turn moves outer columns by more than inner ones; looked up at equal angles the
/// profile moves as a whole.
class AngleScale {
 public:
  AngleScale() = default;
  /// Steps of 1/fx (across) or 1/fy (upright) radians over as much of the image as has rays.
  static AngleScale across(const Camera& camera, int width);
  static AngleScale upright(const Camera& camera, int height);

  /// `pixels` looked up between its values; as many values as there are steps.
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

/// Takes the mean off, so that a change of brightness is no change of profile.
void subtract_mean(Profile& profile);
/// Differences between values 2 `reach` apart in place of the values; 0 within `reach` of the ends.
void take_gradient(Profile& profile, int reach);

}  // namespace rastro
