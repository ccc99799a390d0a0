// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/yaml_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"

namespace rastro::cli {
namespace {

constexpr std::uint64_t most_seeds = 10'000;

}  // namespace

YamlFields::YamlFields(const YAML::Node& node, std::string file, const std::vector<std::string>& keys)
    : node_(node), file_(std::move(file)) {
  if (!node_.IsMap()) throw Error("is not a map of keys and values", at(node_), "write 'key: value' lines");
  for (const auto& field : node_) {
    const std::string key = field.first.IsScalar() ? field.first.Scalar() : "";
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    throw Error("unknown key " + in_quotes(key), at(field.first), did_you_mean(key, keys));
  }
}

std::string YamlFields::text(const char* key, const std::string& if_missing) const {
  const YAML::Node value = node_[key];
  if (!value.IsDefined()) return if_missing;
  if (!value.IsScalar()) refuse(key, "is not one value", "give text or a number");
  return value.Scalar();
}

std::vector<std::string> YamlFields::texts(const char* key) const {
  const YAML::Node value = node_[key];
  if (!value.IsDefined()) return {};
  if (value.IsScalar()) return {value.Scalar()};
  if (!value.IsSequence() || value.size() == 0) refuse(key, "is neither a value nor a list", "give a value or [A, B]");
  std::vector<std::string> all;
  for (const YAML::Node& each : value) {
    if (!each.IsScalar()) refuse(key, "is not a list of values", "give [A, B]");
    all.push_back(each.Scalar());
  }
  return all;
}

std::vector<std::string> YamlFields::words(const char* key) const {
  if (!has(key) || !node_[key].IsScalar()) return texts(key);
  std::vector<std::string> all;
  for (const std::string_view word : split_words(node_[key].Scalar())) all.emplace_back(word);
  return all;
}

std::vector<std::string> YamlFields::assignments(const char* key) const {
  const YAML::Node value = node_[key];
  if (!value.IsDefined()) return {};
  if (!value.IsMap()) refuse(key, "is not a map", "give {option: value}");
  std::vector<std::string> all;
  for (const auto& field : value) {
    if (!field.first.IsScalar() || !field.second.IsScalar())
      refuse(key, "is not a map of values", "give {option: value}");
    all.push_back(field.first.Scalar() + "=" + field.second.Scalar());
  }
  return all;
}

double YamlFields::number(const char* key, double if_missing, double least) const {
  if (!has(key)) return if_missing;
  const auto value = parse_finite(text(key));
  if (!value || *value < least) refuse(key, "is not a number from " + fmt::format("{:g}", least), "give such a number");
  return *value;
}

bool YamlFields::flag(const char* key, bool if_missing) const {
  const std::string value = text(key, if_missing ? "yes" : "no");
  if (value == "yes" || value == "true") return true;
  if (value != "no" && value != "false") refuse(key, "is neither yes nor no", "give one of them");
  return false;
}

std::vector<std::uint64_t> YamlFields::numbers(const char* key) const {
  std::vector<std::uint64_t> all;
  for (const std::string& piece : texts(key)) {
    const auto ends = split(piece, ':');
    const auto first = parse_uint64(ends.front());
    const auto end = ends.size() == 1 && first ? std::optional(*first + 1) : parse_uint64(ends.back());
    if (ends.size() > 2 || !first || !end || *end <= *first || *end - *first > most_seeds)
      refuse(key, "has " + in_quotes(piece), "give numbers such as [1, 5], or 1:21 for 1 to 20");
    for (std::uint64_t k = *first; k < *end; ++k) all.push_back(k);
  }
  return all;
}

void YamlFields::refuse(const char* key, const std::string& what, const std::string& remedy) const {
  throw Error(fmt::format("'{}' {}", key, what), at(has(key) ? node_[key] : node_), remedy);
}

std::string YamlFields::at(const YAML::Node& node) const { return at_line(file_, node.Mark().line + 1); }

YAML::Node parse_yaml(const std::string& yaml, const std::string& file) {
  try {
    return YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw Error("is not YAML: " + one_line(error.msg), at_line(file, error.mark.line + 1), "correct this line");
  }
}

}  // namespace rastro::cli
