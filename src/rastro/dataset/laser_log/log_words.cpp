// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/laser_log/log_words.h"

#include <fmt/format.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro {
namespace {
constexpr std::string_view blanks = " \t\r\f\v";
}

std::string LinePosition::text() const { return fmt::format("{}:{}", file, line); }

std::optional<std::string_view> LogWords::next() {
  const auto first = rest_.find_first_not_of(blanks);
  if (first == std::string_view::npos) {
    rest_ = {};
    return std::nullopt;
  }
  rest_.remove_prefix(first);
  const auto word = rest_.substr(0, rest_.find_first_of(blanks));
  rest_.remove_prefix(word.size());
  return word;
}

double LogWords::number(std::string_view what) {
  const auto text = word(what);
  const auto number = parse_double(text);
  if (!number) refuse(fmt::format("{} is {}, no number", what, in_quotes(text)));
  return *number;
}

double LogWords::finite(std::string_view what) {
  const auto text = word(what);
  const auto number = parse_finite(text);
  if (!number) refuse(fmt::format("{} is {}, no finite number", what, in_quotes(text)));
  return *number;
}

double LogWords::bounded(std::string_view what, double most) {
  const double number = finite(what);
  if (std::abs(number) > most) refuse(fmt::format("{} is {}, beyond {}", what, number, most));
  return number;
}

std::size_t LogWords::count(std::string_view what, std::size_t most) {
  const auto text = word(what);
  const auto number = parse_uint64(text);
  if (!number || *number > most) refuse(fmt::format("{} is {}, not 0 to {}", what, in_quotes(text), most));
  return static_cast<std::size_t>(*number);
}

SE2 LogWords::pose(std::string_view what) {
  constexpr double most = 1e9;
  const double x = bounded(what, most), y = bounded(what, most), angle = bounded(what, most);
  return {SO2::from_angle(angle), {x, y}};
}

TimeNs LogWords::stamp(std::string_view what, StampUnit unit) {
  const auto text = word(what);
  const auto stamp = parse_stamp(text, unit);
  if (!stamp) refuse(fmt::format("{} is {}, no time in {}", what, in_quotes(text), unit_name(unit)));
  return *stamp;
}

void LogWords::refuse(const std::string& problem) const {
  throw Error("broken line: " + problem, position_.text(), "");
}

std::string_view LogWords::word(std::string_view what) {
  const auto found = next();
  if (!found) refuse(fmt::format("it ends before {}", what));
  return *found;
}

}  // namespace rastro
