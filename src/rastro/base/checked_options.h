// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include "rastro/base/options.h"

namespace rastro {

/// The same options, after each value has gone through their table, which knows every range; Error for one that it
/// refuses. `where` says whose options they are.
template <typename Options>
Options checked(const Options& options, std::string_view where) {
  Options copy = options;
  OptionTable table = option_table(copy);
  for (std::size_t i = 0; i < table.options().size(); ++i) table.set(table.options()[i].name, table.value_of(i), where);
  return options;
}

}  // namespace rastro
