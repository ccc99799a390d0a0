// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include "rastro/base/options.h"

namespace rastro {

/// A copy of the options after each value was checked by their table, which has all ranges; Error for an invalid value.
/// `where` names the owner of the options.
template <typename Options>
Options checked(const Options& options, std::string_view where) {
  Options copy = options;
  OptionTable table = option_table(copy);
  for (std::size_t i = 0; i < table.options().size(); ++i) table.set(table.options()[i].name, table.value_of(i), where);
  return options;
}

}  // namespace rastro
