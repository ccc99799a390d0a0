// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace rastro {

/// Two-sided p-value of the signed-rank test that paired differences have no preferred sign: Wilcoxon 1945, "Individual
/// comparisons by ranking methods". Differences of zero are left out, equal sizes get their mean rank. Exact up to 60
/// differences by counting all signs, beyond that the normal approximation with correction for ties. 1 without
/// differences.
double signed_rank_p_value(const std::vector<double>& differences);

/// p-values of several tests so that one below a level is a false alarm with at most that probability over all of
/// them: Holm 1979, "A simple sequentially rejective multiple test procedure". In the order given.
std::vector<double> holm_adjusted(const std::vector<double>& p_values);

}  // namespace rastro
