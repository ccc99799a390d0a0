// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace rastro {

/// Bad input from outside: a file, a setting, an argument. Its text is one line: what is wrong, where, and what to do.
/// The program prints it and exits with code 2.
class Error : public std::runtime_error {
 public:
  /// `what_is_wrong` and `remedy` are clauses without a final period; `where` is a file, file:line, key or argument.
  Error(std::string_view what_is_wrong, std::string_view where, std::string_view remedy);
  explicit Error(const std::string& line) : std::runtime_error(line) {}
};

/// A violated invariant inside the program (exit code 3); thrown by RASTRO_CHECK.
class Fault : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

namespace detail {
[[noreturn]] void fail_check(const char* condition, std::string_view message, const char* file, int line);
}  // namespace detail
}  // namespace rastro

/// Also active in release builds. For invariants between rastro's own parts, never for input from outside.
#define RASTRO_CHECK(condition, message)                                       \
  do {                                                                         \
    if (!(condition)) [[unlikely]]                                             \
      ::rastro::detail::fail_check(#condition, (message), __FILE__, __LINE__); \
  } while (false)
