// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/score_limit.h"

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro {

ScoreLimit read_limit(const std::string& text, const std::string& examples) {
  const std::size_t sign = text.find_first_of("<>");
  const bool has_sign = sign != std::string::npos && sign + 1 < text.size() && text[sign + 1] == '=';
  const auto value = has_sign ? parse_finite(text.substr(sign + 2)) : std::nullopt;
  if (!value) throw Error(in_quotes(text) + " is not a limit", "--require", "write it like " + examples);
  return {std::string(trim(text.substr(0, sign))), text[sign] == '>', *value};
}

bool keeps_limit(const std::optional<double>& score, const ScoreLimit& limit) {
  if (!score) return false;
  return limit.at_least ? *score >= limit.value : *score <= limit.value;
}

}  // namespace rastro
