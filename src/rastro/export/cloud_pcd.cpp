// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/cloud_pcd.h"

#include <fmt/format.h>

#include <limits>

#include "rastro/base/text.h"
#include "rastro/export/raw_bytes.h"

namespace rastro {

std::string cloud_pcd(const PointCloud& cloud, const std::string& frame, const CloudTerms& terms) {
  std::string bytes = fmt::format(
      "# .PCD v0.7 - written by rastro; lengths in {}; {}\n"
      "# count: {}; sigma: standard deviation of {}; nan: unknown\nVERSION 0.7\n"
      "FIELDS x y z normal_x normal_y normal_z rgb count sigma\nSIZE 4 4 4 4 4 4 4 4 4\nTYPE F F F F F F F U F\n"
      "COUNT 1 1 1 1 1 1 1 1 1\nWIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      terms.unit, one_line(frame), terms.count, terms.sigma, cloud.points.size(), cloud.points.size());
  bytes.reserve(bytes.size() + 36 * cloud.points.size());
  for (const CloudPoint& point : cloud.points) {
    detail::append_raw(bytes, point.position);
    detail::append_raw(bytes, point.normal);
    // The bits of 0x00RRGGBB stand in a field of type float.
    const auto& rgb = point.color;
    detail::append_raw(bytes, static_cast<std::uint32_t>(rgb[0] << 16 | rgb[1] << 8 | rgb[2]));
    detail::append_raw(bytes, point.count);
    detail::append_raw(bytes, point.sigma > 0.0F ? point.sigma : std::numeric_limits<float>::quiet_NaN());
  }
  return bytes;
}

}  // namespace rastro
