// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_scale.h"

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"

namespace rastro {

std::optional<double> scale_by_known_length(std::vector<MeasuredLength>& lengths, const std::string& name) {
  const auto known =
      std::find_if(lengths.begin(), lengths.end(), [&](const MeasuredLength& one) { return one.name == name; });
  RASTRO_CHECK(known != lengths.end() && known->true_length_m, "a known length");
  if (!known->length_m || !(*known->length_m > 0.0)) return std::nullopt;
  const double factor = *known->true_length_m / *known->length_m;
  const double relative_sigma = known->sigma_m / *known->length_m;
  lengths.erase(known);
  for (MeasuredLength& one : lengths) {
    one.a *= factor, one.b *= factor, one.scatter_m *= factor;
    if (!one.length_m) continue;
    one.sigma_m = factor * std::hypot(one.sigma_m, *one.length_m * relative_sigma);
    *one.length_m *= factor;
  }
  return factor;
}

}  // namespace rastro
