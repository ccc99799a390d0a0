// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "rastro/base/time.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {

/// Where a line stands, for messages made only when something is wrong.
struct LinePosition {
  std::string_view file;
  std::int64_t line = 0;

  std::string text() const;
};

/// The words of one line from left to right. Everything asked for is there and sound, or an Error says which thing of
/// the line is not.
class LogWords {
 public:
  LogWords(std::string_view line, const LinePosition& position) : rest_(line), position_(position) {}

  /// nullopt at the end of the line.
  std::optional<std::string_view> next();
  double finite(std::string_view what);
  /// From -most to most: absurd sizes would become infinite later, far from the line that has them.
  double bounded(std::string_view what, double most);
  /// May be nan or inf, as a range may.
  double number(std::string_view what);
  /// From 0 to `most`.
  std::size_t count(std::string_view what, std::size_t most);
  SE2 pose(std::string_view what);
  TimeNs stamp(std::string_view what, StampUnit unit);
  [[noreturn]] void refuse(const std::string& problem) const;

 private:
  std::string_view word(std::string_view what);

  std::string_view rest_;
  LinePosition position_;
};

}  // namespace rastro
