// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <yaml-cpp/yaml.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace rastro::calibration {

using Names = std::initializer_list<const char*>;  ///< Of one key; the first is the one named in messages.

/// A YAML map of a calibration file. Its accessors report anything unusable in one line with file, line and key.
class YamlFields {
 public:
  YamlFields(YAML::Node map, std::string where, int line);

  /// The document's root. Skips OpenCV's "%YAML:1.0" line, which YAML does not know.
  static YamlFields parse(std::string_view text, std::string_view where);

  bool has(Names names) const { return find(names).has_value(); }
  /// Whether the value of this key is a map.
  bool has_map(Names names) const;
  YamlFields map(Names names) const;
  std::string text(Names names) const;
  double number(Names names) const;
  /// A whole number, also if written as 640.0; within +-1e9.
  int integer(Names names) const;
  /// A list of numbers, or a matrix in any of its forms, row by row.
  std::vector<double> numbers(Names names) const;
  std::vector<double> numbers(Names names, std::size_t count) const;
  /// `rows` x `columns` as {rows, cols, data}, a list of rows, or a flat list.
  Eigen::MatrixXd matrix(Names names, int rows, int columns) const;

  /// "file:line" of the key, or of this map without it.
  std::string at(Names names) const;
  std::string at() const;
  /// Throws: no such key; names the nearest existing one.
  [[noreturn]] void fail_missing(Names names) const;
  [[noreturn]] void fail(Names names, std::string_view what_is_wrong, std::string_view remedy) const;

 private:
  struct Field {
    YAML::Node value;
    int line = 0;  ///< Of the key.
  };
  std::optional<Field> find(Names names) const;
  YAML::Node require(Names names) const;
  void append(const YAML::Node& node, Names names, int depth, std::vector<double>& values) const;

  YAML::Node map_;
  std::string where_;
  int line_;
};

}  // namespace rastro::calibration
