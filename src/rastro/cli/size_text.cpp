// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/size_text.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro::cli {
namespace {

struct Unit {
  const char* name;
  double bytes;
};
constexpr Unit units[] = {{"B", 1.0},      {"kB", 1e3},        {"MB", 1e6},          {"GB", 1e9},
                          {"KiB", 1024.0}, {"MiB", 1048576.0}, {"GiB", 1073741824.0}};

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

}  // namespace

std::size_t parse_size(const std::string& text, const std::string& flag) {
  constexpr double most = 1e15;
  const std::size_t digits = std::min(text.find_first_not_of("0123456789.+- "), text.size());
  const auto number = parse_finite(std::string_view(text).substr(0, digits));
  const std::string unit(trim(std::string_view(text).substr(digits)));
  if (!number) throw Error(in_quotes(text) + " is not a size", flag, "give a number and a unit, such as 600MB");
  for (const Unit& each : units) {
    if (unit != each.name && !(unit.empty() && each.bytes == 1.0)) continue;
    const double bytes = *number * each.bytes;
    if (bytes >= 1.0 && bytes <= most) return static_cast<std::size_t>(bytes);
    throw Error(in_quotes(text) + " is out of range", flag, "give a number and a unit, such as 600MB");
  }
  std::vector<std::string> names;
  for (const Unit& each : units) {
    if (lower(unit) == lower(each.name) || lower(unit) + "b" == lower(each.name))
      throw Error(in_quotes(text) + " has an unknown unit", flag,
                  fmt::format("did you mean {:g}{}?", *number, each.name));
    names.emplace_back(each.name);
  }
  const std::string nearest = nearest_name(unit, names);
  throw Error(in_quotes(text) + " has an unknown unit", flag,
              nearest.empty() ? "give a number and a unit, such as 600MB"
                              : fmt::format("did you mean {:g}{}?", *number, nearest));
}

}  // namespace rastro::cli
