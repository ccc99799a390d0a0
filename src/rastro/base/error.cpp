// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/error.h"

#include <fmt/format.h>

namespace rastro {

Error::Error(std::string_view what_is_wrong, std::string_view where, std::string_view remedy)
    : std::runtime_error(remedy.empty() ? fmt::format("{}: {}", where, what_is_wrong)
                                        : fmt::format("{}: {}; {}", where, what_is_wrong, remedy)) {}

void detail::fail_check(const char* condition, std::string_view message, const char* file, int line) {
  throw Fault(fmt::format("{}:{}: promise broken: {} ({})", file, line, message, condition));
}

}  // namespace rastro
