// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace rastro {

/// One setting of an options struct: where it is stored and its documentation.
struct Option {
  /// Where the value is stored. A choice is a string that must be one of `choices`.
  using Target = std::variant<bool*, int*, std::int64_t*, std::uint64_t*, double*, std::string*>;

  std::string name;  ///< As written on the command line and in files: `min_distance_px`.
  Target target;
  std::string unit;  ///< "px", "s", "" for a count or a name.
  /// One line: its effect and the reason for the default, with the publication where there is one.
  std::string why;
  double minimum = 0.0;
  double maximum = 0.0;  ///< Range of numbers, inclusive; no range if both are equal; ignored for other types.
  std::vector<std::string> choices = {};  ///< Allowed values of a choice.
};

/// The option table of one method: used by the parser, --help, the reference page and the checks. It points into an
/// options struct that must outlive it; the values at its construction are the defaults.
class OptionTable {
 public:
  /// The default must be allowed, and each name must be new.
  void add(Option option);
  /// A former name of `name` from an earlier release: still accepted, with a warning in the log that gives the new
  /// name.
  void add_former_name(std::string former, std::string name);
  /// The same for a choice of the option `name`.
  void add_former_choice(std::string name, std::string former, std::string choice);
  const std::vector<Option>& options() const { return options_; }
  /// The default as text, in the form that set() reads.
  const std::string& default_of(std::size_t index) const { return defaults_[index]; }

  /// Sets one value from text. Errors name the nearest known key, the range or the choices; `where` is the origin of
  /// the value.
  void set(std::string_view name, std::string_view value, std::string_view where);
  /// Sets from `key=value`, as after --set.
  void set_assignment(std::string_view assignment, std::string_view where);
  /// Sets values from a flat YAML map; a file needs only the values that differ from the defaults. Errors name file and
  /// line.
  void load_yaml(const std::filesystem::path& file);
  /// The same from text in memory; `where` stands for the file name in errors.
  void load_yaml_text(const std::string& text, std::string_view where);
  /// All values in force as YAML, with unit and reason as comments; load_yaml reads it back.
  std::string to_yaml() const;
  std::string value_of(std::size_t index) const;
  /// The allowed values: "1 .. 500", "klt | vote", "true | false"; empty if any value is allowed.
  std::string allowed_of(std::size_t index) const;

 private:
  Option& find(std::string_view name, std::string_view where);
  std::string_view current_name(std::string_view name, std::string_view where) const;
  std::string_view current_choice(const Option& option, std::string_view choice, std::string_view where) const;

  std::vector<Option> options_;
  std::vector<std::pair<std::string, std::string>> former_names_;  // old name, current name
  struct FormerChoice {
    std::string option, former, now;
  };
  std::vector<FormerChoice> former_choices_;
  std::vector<std::string> defaults_;
};

}  // namespace rastro
