// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace rastro {

/// Where the numbers of a pose stand in a line of a trajectory file.
struct TrajectoryColumns {
  std::array<std::size_t, 3> position;     ///< x, y, z
  std::array<std::size_t, 4> orientation;  ///< x, y, z, w
  std::size_t last() const;
};

/// As a line of names before the first pose says, commented out or not: "timestamp tx ty tz qw qx qy qz",
/// "#timestamp, p_RS_R_x [m], ..., q_RS_z []" or "time,pose.position.x,...,pose.orientation.w". Nothing where no line
/// names all seven.
std::optional<TrajectoryColumns> named_columns(std::string_view text);

/// The same text with a line of names that is no comment made one.
std::string with_commented_names(std::string text);

}  // namespace rastro
