// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace rastro {

/// One setting of an options struct: where it lives and what a user must know about it.
struct Option {
  /// Where the value is kept. A choice is a string that must be one of `choices`.
  using Target = std::variant<bool*, int*, std::int64_t*, std::uint64_t*, double*, std::string*>;

  std::string name;  ///< As written on the command line and in files: `min_distance_px`.
  Target target;
  std::string unit;  ///< "px", "s", "" for a count or a name.
  std::string
      why;  ///< One line: what it does and why the default is what it is, with the publication where there is one.
  double minimum = 0.0;
  double maximum = 0.0;  ///< Range of numbers, both ends allowed; no range when both are equal; ignored for others.
  std::vector<std::string> choices = {};  ///< Allowed names of a choice.
};

/// The option table of one method: feeds the parser, --help, the reference page and the checks.
/// It points into an options struct that must outlive it; the values there when the table is made are the defaults.
class OptionTable {
 public:
  /// The default must itself be allowed, and names are given once.
  void add(Option option);
  const std::vector<Option>& options() const { return options_; }
  /// The default as text, in the form that set() reads.
  const std::string& default_of(std::size_t index) const { return defaults_[index]; }

  /// Sets one value from text. Errors name the nearest known key, the range or the choices; `where` says who asked.
  void set(std::string_view name, std::string_view value, std::string_view where);
  /// Sets from `key=value`, as after --set.
  void set_assignment(std::string_view assignment, std::string_view where);
  /// Sets from a flat YAML map; a file needs to list only what differs from the defaults. Errors name file and line.
  void load_yaml(const std::filesystem::path& file);
  /// The same from text in memory; `where` stands for the file name in errors.
  void load_yaml_text(const std::string& text, std::string_view where);
  /// All values in force as YAML, with unit and reason as comments; load_yaml reads it back.
  std::string to_yaml() const;
  std::string value_of(std::size_t index) const;
  /// The allowed values in words: "1 .. 500", "klt | vote", "true | false"; empty where anything goes.
  std::string allowed_of(std::size_t index) const;

 private:
  Option& find(std::string_view name, std::string_view where);

  std::vector<Option> options_;
  std::vector<std::string> defaults_;
};

}  // namespace rastro
