// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <string>
#include <vector>

namespace rastro::cli {

/// One YAML map of known keys. Every Error names file and line.
class YamlFields {
 public:
  /// Error if the node is no map, or has a key that is not in `keys`.
  YamlFields(const YAML::Node& node, std::string file, const std::vector<std::string>& keys);

  bool has(const char* key) const { return node_[key].IsDefined(); }
  YAML::Node node(const char* key) const { return node_[key]; }
  /// Scalar as text; `if_missing` where the key is not there.
  std::string text(const char* key, const std::string& if_missing = "") const;
  /// A scalar as a list of one, or a list of scalars; empty where the key is not there.
  std::vector<std::string> texts(const char* key) const;
  /// Scalar split at spaces, or a list of scalars.
  std::vector<std::string> words(const char* key) const;
  /// A map of scalars as "key=value".
  std::vector<std::string> assignments(const char* key) const;
  /// Number of at least `least`.
  double number(const char* key, double if_missing, double least) const;
  bool flag(const char* key, bool if_missing) const;
  /// "1, 5" as a list, or "1:21", of which the last is not included.
  std::vector<std::uint64_t> numbers(const char* key) const;

  [[noreturn]] void refuse(const char* key, const std::string& what, const std::string& remedy) const;
  std::string at(const YAML::Node& node) const;

 private:
  YAML::Node node_;
  std::string file_;
};

/// Parses text; Error with file and line where it is no YAML.
YAML::Node parse_yaml(const std::string& yaml, const std::string& file);

}  // namespace rastro::cli
