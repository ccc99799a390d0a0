// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "rastro/map/grid/occupancy_grid.h"

namespace rastro {

/// The image that ROS's map_server reads: binary PGM, the row of the largest y first; 0 % is white, 100 % black, in
/// between gray; unknown cells are 205, which no percentage is.
std::string map_server_pgm(const OccupancyGrid& grid);
/// The same in pieces, as the image of a large map takes more memory than the map: put() gets one after the other.
void map_server_pgm(const OccupancyGrid& grid, const std::function<void(std::string_view)>& put);

/// The file beside it: image, resolution, origin and the thresholds of map_server's own saver. `image` is a file
/// name.
std::string map_server_yaml(const OccupancyGrid& grid, const std::string& image);

/// Reads what is written above or by map_server, as map_server does in its mode "trinary": cells are 0, 100 or unknown.
/// Error for a file that is none, an image that is no 8-bit binary PGM of the size it says, and for rotated maps.
OccupancyGrid read_map_server(const std::string& yaml_file);

/// The same from text and bytes in memory; `where` and `image_file` name them in messages.
OccupancyGrid parse_map_server(std::string_view yaml, std::string_view where, std::string_view pgm,
                               std::string_view image_file);

}  // namespace rastro
