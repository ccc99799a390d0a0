// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <sstream>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"

namespace rastro {
namespace {

constexpr std::uintmax_t largest_file_bytes = 1 << 20;

template <typename... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <typename... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;  // clang before 17 needs it spelled out

bool has_range(const Option& option) { return option.minimum != option.maximum; }

std::string range_text(const Option& option) { return fmt::format("{} .. {}", option.minimum, option.maximum); }

std::string allowed_text(const Option& option) {
  if (std::holds_alternative<bool*>(option.target)) return "true | false";
  if (std::holds_alternative<std::string*>(option.target)) return fmt::format("{}", fmt::join(option.choices, " | "));
  return has_range(option) ? range_text(option) : std::string();
}

std::string value_text(const Option& option) {
  return std::visit([](const auto* value) { return fmt::format("{}", *value); }, option.target);
}

[[noreturn]] void refuse(const Option& option, std::string_view value, std::string_view where,
                         std::string_view wanted) {
  const std::string allowed = allowed_text(option);
  throw Error(fmt::format("{} is not a value of '{}'", in_quotes(value), option.name), where,
              fmt::format("give {}{}{}{}", wanted, allowed.empty() ? "" : ", ", allowed,
                          option.unit.empty() ? "" : " " + option.unit));
}

std::optional<bool> parse_bool(std::string_view text) {
  constexpr std::array<std::string_view, 4> yes = {"true", "yes", "on", "1"};
  constexpr std::array<std::string_view, 4> no = {"false", "no", "off", "0"};
  if (std::find(yes.begin(), yes.end(), text) != yes.end()) return true;
  if (std::find(no.begin(), no.end(), text) != no.end()) return false;
  return std::nullopt;
}

std::optional<int> parse_int(std::string_view text) {
  const auto number = parse_int64(text);
  if (!number || *number < std::numeric_limits<int>::min() || *number > std::numeric_limits<int>::max()) return {};
  return static_cast<int>(*number);
}

/// One line of valid UTF-8: only such text survives a YAML round trip unchanged.
bool is_one_line_of_text(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const auto first = static_cast<unsigned char>(text.front());
    if (length == 0 || first < 0x20 || first == 0x7F) return false;
    text.remove_prefix(length);
  }
  return true;
}

template <typename Number>
void set_number(const Option& option, Number* target, std::optional<Number> number, std::string_view value,
                std::string_view where, std::string_view wanted) {
  if (!number) refuse(option, value, where, wanted);
  const auto as_double = static_cast<double>(*number);
  if (has_range(option) && (as_double < option.minimum || as_double > option.maximum)) {
    refuse(option, value, where, wanted);
  }
  *target = *number;
}

void set_string(const Option& option, std::string* target, std::string_view value, std::string_view where) {
  const auto& choices = option.choices;
  if (!choices.empty() && std::find(choices.begin(), choices.end(), value) == choices.end()) {
    refuse(option, value, where, "one of");
  }
  if (!is_one_line_of_text(value)) refuse(option, value, where, "one line of UTF-8 text");
  *target = value;
}

void set_value(const Option& option, std::string_view value, std::string_view where) {
  std::visit(
      Overloaded{
          [&](bool* target) {
            const auto flag = parse_bool(trim(value));
            if (!flag) refuse(option, value, where, "one of");
            *target = *flag;
          },
          [&](int* target) { set_number(option, target, parse_int(value), value, where, "a whole number"); },
          [&](std::int64_t* target) { set_number(option, target, parse_int64(value), value, where, "a whole number"); },
          [&](std::uint64_t* target) {
            set_number(option, target, parse_uint64(value), value, where, "a whole number from 0");
          },
          [&](double* target) { set_number(option, target, parse_finite(value), value, where, "a number"); },
          [&](std::string* target) { set_string(option, target, value, where); },
      },
      option.target);
}

void warn_of_former(std::string_view former, std::string_view now, std::string_view where) {
  log_warning(fmt::format("{}: '{}' is now '{}'; the next release will not accept the old name", where, former, now));
}

std::string read_text_file(const std::filesystem::path& file) {
  std::error_code code;
  const auto status = std::filesystem::status(file, code);
  if (!std::filesystem::exists(status))
    throw Error("no such file", file.string(), "check the path given with --options");
  if (!std::filesystem::is_regular_file(status))
    throw Error("not a file", file.string(), "give a YAML file of options");
  if (std::filesystem::file_size(file, code) > largest_file_bytes) {
    throw Error("larger than 1 MiB", file.string(), "give a YAML file of options");
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw Error("cannot be read", file.string(), "check its permissions");
  return text;
}

/// Files written by OpenCV start with "%YAML:1.0", which is not valid YAML.
std::string without_opencv_header(std::string text) {
  if (text.starts_with("%YAML:")) text.erase(0, std::min(text.find('\n'), text.size()));
  return text;
}

/// Parses a YAML document without storing anything.
class DeafHandler : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

/// YAML::Load ignores everything after the first document, and YAML::LoadAll never ends on some input.
bool holds_more_than_a_document(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DeafHandler handler;
  parser.HandleNextDocument(handler);
  return static_cast<bool>(parser);
}

YAML::Node parse_document(const std::string& text, std::string_view where) {
  try {
    if (holds_more_than_a_document(text)) {
      throw Error("holds more than one YAML document", where, "keep one map of options");
    }
    return YAML::Load(text);
  } catch (const YAML::Exception& problem) {
    throw Error(fmt::format("not YAML ({})", one_line(problem.msg)), fmt::format("{}:{}", where, problem.mark.line + 1),
                "write one 'key: value' per line");
  }
}

std::string yaml_scalar(const Option& option) {
  const auto* text = std::get_if<std::string*>(&option.target);
  if (text == nullptr || !option.choices.empty()) return value_text(option);
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << **text;
  return emitter.c_str();
}

}  // namespace

void OptionTable::add(Option option) {
  RASTRO_CHECK(!option.name.empty() && option.why.find('\n') == std::string::npos, "an option has a name and one line");
  for (const Option& other : options_) RASTRO_CHECK(other.name != option.name, "option names are given once");
  const std::string value = value_text(option);
  set_value(option, value, "the default");
  defaults_.push_back(value);
  options_.push_back(std::move(option));
}

void OptionTable::add_former_name(std::string former, std::string name) {
  const auto is_option = [&](const std::string& wanted) {
    return std::any_of(options_.begin(), options_.end(), [&](const Option& option) { return option.name == wanted; });
  };
  RASTRO_CHECK(is_option(name) && !is_option(former), "a former name stands for an option and is none itself");
  former_names_.emplace_back(std::move(former), std::move(name));
}

void OptionTable::add_former_choice(std::string name, std::string former, std::string choice) {
  const auto& choices = find(name, "").choices;
  RASTRO_CHECK(std::count(choices.begin(), choices.end(), choice) == 1, "a former choice stands for one of today");
  former_choices_.push_back({std::move(name), std::move(former), std::move(choice)});
}

std::string_view OptionTable::current_name(std::string_view name, std::string_view where) const {
  for (const auto& [former, now] : former_names_) {
    if (former != name) continue;
    warn_of_former(former, now, where);
    return now;
  }
  return name;
}

std::string_view OptionTable::current_choice(const Option& option, std::string_view choice,
                                             std::string_view where) const {
  for (const FormerChoice& each : former_choices_) {
    if (each.option != option.name || each.former != choice) continue;
    warn_of_former(each.former, each.now, where);
    return each.now;
  }
  return choice;
}

Option& OptionTable::find(std::string_view given, std::string_view where) {
  const std::string_view name = current_name(given, where);
  const auto found = std::find_if(options_.begin(), options_.end(), [&](const Option& o) { return o.name == name; });
  if (found != options_.end()) return *found;
  std::vector<std::string> names;
  for (const Option& option : options_) names.push_back(option.name);
  const std::string_view otherwise = names.empty() ? "there are no options here" : "'rastro options' lists the options";
  throw Error(fmt::format("unknown option {}", in_quotes(name)), where, did_you_mean(name, names, otherwise));
}

void OptionTable::set(std::string_view name, std::string_view value, std::string_view where) {
  const Option& option = find(name, where);
  set_value(option, current_choice(option, value, where), where);
}

void OptionTable::set_assignment(std::string_view assignment, std::string_view where) {
  const auto equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    throw Error(fmt::format("{} is not a setting", in_quotes(assignment)), where, "write key=value");
  }
  set(trim(assignment.substr(0, equals)), trim(assignment.substr(equals + 1)), where);
}

void OptionTable::load_yaml(const std::filesystem::path& file) { load_yaml_text(read_text_file(file), file.string()); }

void OptionTable::load_yaml_text(const std::string& text, std::string_view where) {
  const YAML::Node root = parse_document(without_opencv_header(text), where);
  if (root.IsNull()) return;
  if (!root.IsMap()) throw Error("not a map of options", where, "write one 'key: value' per line");
  std::set<std::string> seen;
  for (const auto& entry : root) {
    const std::string position = fmt::format("{}:{}", where, entry.first.Mark().line + 1);
    if (!entry.first.IsScalar()) throw Error("a key is not a word", position, "write one 'key: value' per line");
    const std::string& key = entry.first.Scalar();
    const Option& option = find(key, position);
    if (!seen.insert(option.name).second)
      throw Error(fmt::format("'{}' is given twice", key), position, "keep one of the two");
    if (!entry.second.IsScalar()) {
      throw Error(fmt::format("'{}' has no single value", key), position, "write one 'key: value' per line");
    }
    set_value(option, current_choice(option, entry.second.Scalar(), position), position);
  }
}

std::string OptionTable::to_yaml() const {
  std::string text;
  for (std::size_t i = 0; i < options_.size(); ++i) {
    const Option& option = options_[i];
    std::string comment = option.unit;
    for (const std::string& part : {allowed_of(i), option.why}) {
      if (!part.empty()) comment += (comment.empty() ? "" : "; ") + part;
    }
    text += fmt::format("{}: {}{}{}\n", option.name, yaml_scalar(option), comment.empty() ? "" : "  # ", comment);
  }
  return text;
}

std::string OptionTable::value_of(std::size_t index) const { return value_text(options_.at(index)); }

std::string OptionTable::allowed_of(std::size_t index) const { return allowed_text(options_.at(index)); }

}  // namespace rastro
