// SPDX-License-Identifier: Apache-2.0
// A map of map_server: the yaml up to the first zero byte, the image behind it. Whatever they hold, they are read or
// refused with rastro::Error; what is read is valid and can be written and compared with itself.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/evaluate/grid_agreement.h"
#include "rastro/export/grid_map_server.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(input.find('\0'), input.size());
  const std::string_view image = end < input.size() ? input.substr(end + 1) : std::string_view();
  try {
    const rastro::OccupancyGrid grid = rastro::parse_map_server(input.substr(0, end), "yaml", image, "picture");
    const auto cells = static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
    grid.percent.for_each([&](int x, int y, std::int8_t percent) {
      if (percent != rastro::OccupancyGrid::unknown && !grid.holds(x, y)) __builtin_trap();
    });
    if (rastro::map_server_pgm(grid).size() < cells) __builtin_trap();
    rastro::GridAgreementOptions options;
    options.align = cells < 100;
    const double precision = rastro::grid_agreement(grid, grid, options).precision;
    if (!(precision >= 0.0 && precision <= 1.0)) __builtin_trap();
  } catch (const rastro::Error&) {
  }
  return 0;
}
