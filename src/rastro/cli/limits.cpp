// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"

namespace rastro::cli {
namespace {

std::optional<double> number_named(const NamedNumbers& numbers, const std::string& name) {
  for (const auto& [each, value] : numbers)
    if (each == name) return value;
  return std::nullopt;
}

}  // namespace

std::vector<ScoreLimit> parse_limits(const std::vector<std::string>& texts, const NamedNumbers& known,
                                     const std::string& example) {
  std::vector<std::string> names;
  for (const auto& [name, value] : known) names.push_back(name);
  std::vector<ScoreLimit> limits;
  for (const std::string& text : texts) {
    limits.push_back(read_limit(text, example));
    const std::string& name = limits.back().name;
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    throw Error(fmt::format("{} is not a value of the result", in_quotes(name)), "--require",
                did_you_mean(name, names));
  }
  return limits;
}

int report_missed(const std::vector<ScoreLimit>& limits, const NamedNumbers& numbers) {
  int code = done;
  for (const ScoreLimit& limit : limits) {
    const auto value = number_named(numbers, limit.name);
    if (keeps_limit(value, limit)) continue;
    fmt::print(stderr, "rastro: --require {}{}{} missed: it is {}\n", limit.name,
               limit.at_least ? ">=" : "<=", limit.value, value ? fmt::format("{:.6g}", *value) : "n/a");
    code = limit_missed;
  }
  return code;
}

std::string as_json(const NamedNumbers& numbers) {
  nlohmann::ordered_json json;
  for (const auto& [name, value] : numbers) {
    if (value == std::floor(value) && std::abs(value) < 1e15) {
      json[name] = static_cast<std::int64_t>(value);
    } else {
      json[name] = std::round(value * 1e6) / 1e6;
    }
  }
  return json.dump(2) + "\n";
}

}  // namespace rastro::cli
