// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/file/yaml_fields.h"

#include <fmt/format.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"

namespace rastro::calibration {
namespace {

/// More numbers than the matrix of any calibration.
constexpr std::size_t largest_list = 4096;

int line_of(const YAML::Node& node, int otherwise) {
  const YAML::Mark mark = node.Mark();
  return mark.is_null() ? otherwise : mark.line + 1;
}

/// The text with its "%YAML..." line blanked (not removed: line numbers stay correct).
std::string without_directive(std::string_view text) {
  std::string result(text);
  if (result.starts_with("\xEF\xBB\xBF")) result.erase(0, 3);
  if (result.starts_with("%YAML")) result.erase(0, result.find('\n'));
  return result;
}

std::optional<double> number_in(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  const std::string& text = node.Scalar();
  return parse_finite(text.starts_with('+') ? std::string_view(text).substr(1) : std::string_view(text));
}

}  // namespace

YamlFields::YamlFields(YAML::Node map, std::string where, int line)
    : map_(std::move(map)), where_(std::move(where)), line_(line) {}

YamlFields YamlFields::parse(std::string_view text, std::string_view where) {
  try {
    YAML::Node root = YAML::Load(without_directive(text));
    if (!root.IsMap())
      throw Error("not a calibration: no 'key: value' lines", where,
                  "expected a file of EuRoC, KITTI, OpenCV, ROS or Kalibr");
    return {root, std::string(where), line_of(root, 1)};
  } catch (const YAML::Exception& error) {
    throw Error(fmt::format("not valid YAML: {}", one_line(error.msg)), at_line(where, error.mark.line + 1), "");
  }
}

std::optional<YamlFields::Field> YamlFields::find(Names names) const {
  for (const auto& item : map_)
    for (const char* name : names)
      if (item.first.IsScalar() && item.first.Scalar() == name) return Field{item.second, line_of(item.first, line_)};
  return std::nullopt;
}

YAML::Node YamlFields::require(Names names) const {
  const auto field = find(names);
  if (!field) fail_missing(names);
  return field->value;
}

void YamlFields::fail_missing(Names names) const {
  std::vector<std::string> present;
  for (const auto& item : map_)
    if (item.first.IsScalar()) present.push_back(item.first.Scalar());
  const std::string nearest = nearest_name(*names.begin(), present);
  throw Error(fmt::format("no key '{}'", *names.begin()), at(),
              nearest.empty() ? "it is needed" : fmt::format("did you mean '{}' to be it?", one_line(nearest, 40)));
}

void YamlFields::fail(Names names, std::string_view what_is_wrong, std::string_view remedy) const {
  throw Error(fmt::format("{} {}", *names.begin(), what_is_wrong), at(names), remedy);
}

std::string YamlFields::at() const { return at_line(where_, line_); }

std::string YamlFields::at(Names names) const {
  const auto field = find(names);
  return field ? at_line(where_, field->line) : at();
}

bool YamlFields::has_map(Names names) const {
  const auto field = find(names);
  return field && field->value.IsMap();
}

YamlFields YamlFields::map(Names names) const {
  const YAML::Node node = require(names);
  if (!node.IsMap()) fail(names, "has no keys below it", "");
  return {node, where_, line_of(node, line_)};
}

std::string YamlFields::text(Names names) const {
  const YAML::Node node = require(names);
  if (!node.IsScalar()) fail(names, "is not a single word", "");
  return node.Scalar();
}

double YamlFields::number(Names names) const {
  const auto value = number_in(require(names));
  if (!value) fail(names, "is not a finite number", "");
  return *value;
}

int YamlFields::integer(Names names) const {
  const double value = number(names);
  if (value != std::floor(value) || std::abs(value) > 1e9) fail(names, "is not a whole number", "");
  return static_cast<int>(value);
}

void YamlFields::append(const YAML::Node& node, Names names, int depth, std::vector<double>& values) const {
  if (node.IsSequence() && depth < 2) {
    for (const auto& item : node) append(item, names, depth + 1, values);
    return;
  }
  const auto value = number_in(node);
  if (!value)
    throw Error(fmt::format("{} holds {}, not a finite number", *names.begin(),
                            node.IsScalar() ? fmt::format("'{}'", one_line(node.Scalar(), 40)) : "a nested value"),
                at_line(where_, line_of(node, line_)), "");
  if (values.size() == largest_list) fail(names, "has far too many values", "");
  values.push_back(*value);
}

std::vector<double> YamlFields::numbers(Names names) const {
  YAML::Node node = require(names);
  if (node.IsMap()) {
    const YamlFields inner(node, where_, line_of(node, line_));
    std::vector<double> values = inner.numbers({"data"});
    if (inner.has({"rows"}) && inner.has({"cols"}) &&
        static_cast<double>(inner.integer({"rows"})) * inner.integer({"cols"}) != static_cast<double>(values.size()))
      fail(names, fmt::format("has {} values, not rows times cols", values.size()), "is the file complete?");
    return values;
  }
  if (!node.IsSequence()) fail(names, "is not a list of numbers", "");
  std::vector<double> values;
  append(node, names, 0, values);
  return values;
}

std::vector<double> YamlFields::numbers(Names names, std::size_t count) const {
  auto values = numbers(names);
  if (values.size() != count) fail(names, fmt::format("has {} values, expected {}", values.size(), count), "");
  return values;
}

Eigen::MatrixXd YamlFields::matrix(Names names, int rows, int columns) const {
  const auto values = numbers(names, static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(values.data(), rows, columns);
}

}  // namespace rastro::calibration
