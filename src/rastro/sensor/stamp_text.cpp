// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/stamp_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>

#include "rastro/base/text.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr std::array all_units = {StampUnit::seconds, StampUnit::milliseconds, StampUnit::microseconds,
                                  StampUnit::nanoseconds};

int decimals_below_unit(StampUnit unit) { return 9 - 3 * static_cast<int>(unit); }
double seconds_per(StampUnit unit) { return std::pow(10.0, -3 * static_cast<int>(unit)); }

struct Decimal {
  bool negative = false;
  std::string digits;
  std::int64_t exponent = 0;  ///< Value = digits * 10^exponent.
};

/// Splits "[+-]digits[.digits][e[+-]digits]"; nullopt for anything else.
std::optional<Decimal> split_decimal(std::string_view text) {
  text = trim(text);
  Decimal decimal;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    decimal.negative = text.front() == '-';
    text.remove_prefix(1);
  }
  const auto e = text.find_first_of("eE");
  if (e != std::string_view::npos) {
    const auto exponent = parse_int64(text.substr(e + 1));
    if (!exponent || *exponent < -1000 || *exponent > 1000) return std::nullopt;
    decimal.exponent = *exponent;
    text = text.substr(0, e);
  }
  const auto dot = text.find('.');
  if (dot != std::string_view::npos) decimal.exponent -= static_cast<std::int64_t>(text.size() - dot - 1);
  decimal.digits = std::string(text.substr(0, dot));
  if (dot != std::string_view::npos) decimal.digits += text.substr(dot + 1);
  const bool only_digits =
      std::all_of(decimal.digits.begin(), decimal.digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (decimal.digits.empty() || !only_digits) return std::nullopt;
  return decimal;
}

/// Rounds half away from zero to a whole number.
std::optional<std::int64_t> whole(const Decimal& decimal) {
  std::string digits = decimal.digits;
  bool round_up = false;
  if (decimal.exponent < 0) {
    const auto cut = static_cast<std::size_t>(-decimal.exponent);
    if (cut > digits.size()) return 0;
    round_up = digits[digits.size() - cut] >= '5';
    digits.erase(digits.size() - cut);
  }
  std::int64_t value = 0;
  const auto append = [&](int digit) {
    if (value > (largest_stamp - digit) / 10) return false;
    value = value * 10 + digit;
    return true;
  };
  for (const char c : digits)
    if (!append(c - '0')) return std::nullopt;
  for (std::int64_t k = 0; k < decimal.exponent && value != 0; ++k)
    if (!append(0)) return std::nullopt;
  if (round_up && value == largest_stamp) return std::nullopt;
  value += round_up ? 1 : 0;
  return decimal.negative ? -value : value;
}

double median_step(std::span<const double> stamps) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) steps.push_back(std::abs(stamps[i] - stamps[i - 1]));
  return upper_median_or(std::move(steps), 0.0);
}

bool is_recent_date(double seconds) { return seconds > 3.2e8 && seconds < 4.1e9; }

}  // namespace

std::string_view unit_name(StampUnit unit) {
  constexpr std::array<std::string_view, 4> names = {"s", "ms", "us", "ns"};
  return names[static_cast<std::size_t>(unit)];
}

std::optional<TimeNs> parse_stamp(std::string_view text, StampUnit unit) {
  auto decimal = split_decimal(text);
  if (!decimal) return std::nullopt;
  decimal->exponent += decimals_below_unit(unit);
  return whole(*decimal);
}

std::string seconds_text(TimeNs stamp) {
  // Unsigned, because the least TimeNs has no positive counterpart.
  const auto all = static_cast<std::uint64_t>(stamp);
  const std::uint64_t size = stamp < 0 ? 0 - all : all;
  constexpr auto second = static_cast<std::uint64_t>(ns_per_second);
  return fmt::format("{}{}.{:09}", stamp < 0 ? "-" : "", size / second, size % second);
}

std::optional<TimeNs> parse_date_stamp(std::string_view text) {
  const auto words = split_words(text);
  if (words.size() != 2) return std::nullopt;
  const auto date = split(words[0], '-');
  const auto time = split(words[1], ':');
  if (date.size() != 3 || time.size() != 3) return std::nullopt;
  const auto year = parse_int64(date[0]), month = parse_int64(date[1]), day = parse_int64(date[2]);
  const auto hour = parse_int64(time[0]), minute = parse_int64(time[1]);
  const auto second = parse_stamp(time[2], StampUnit::seconds);
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  if (*year < 1900 || *year > 2100 || *month < 1 || *month > 12 || *day < 1 || *day > 31) return std::nullopt;
  if (*hour < 0 || *hour > 23 || *minute < 0 || *minute > 59 || *second < 0 || *second >= 61 * ns_per_second)
    return std::nullopt;
  const std::chrono::year_month_day calendar{std::chrono::year(static_cast<int>(*year)),
                                             std::chrono::month(static_cast<unsigned>(*month)),
                                             std::chrono::day(static_cast<unsigned>(*day))};
  if (!calendar.ok()) return std::nullopt;
  const std::int64_t days = std::chrono::sys_days(calendar).time_since_epoch().count();
  return ((days * 24 + *hour) * 60 + *minute) * 60 * ns_per_second + *second;
}

StampUnit guess_stamp_unit(std::span<const double> stamps, StampUnit native) {
  const double step = median_step(stamps);
  if (step <= 0.0) return native;
  const auto step_fits = [&](StampUnit unit, double longest_s) {
    const double step_s = step * seconds_per(unit);
    return step_s >= 0.0005 && step_s <= longest_s;
  };
  for (const auto unit : all_units)
    if (is_recent_date(stamps.front() * seconds_per(unit)) && step_fits(unit, 86400.0)) return unit;
  if (step_fits(native, 20.0)) return native;
  for (const auto unit : all_units)
    if (step_fits(unit, 20.0)) return unit;
  return native;
}

}  // namespace rastro
