// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/parse_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro::cli {
namespace {

/// The command the user meant: the innermost one that was parsed.
const CLI::App& innermost(const CLI::App& app) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  return *command;
}

std::string full_name(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent ? full_name(*parent) + " " + command.get_name() : command.get_name();
}

std::vector<std::string> flags_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::string unknown_flag(const CLI::App& command, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  return fmt::format("unknown option '{}' of '{}'; {}", name, full_name(command),
                     did_you_mean(name, flags_of(command), fmt::format("see '{} --help'", full_name(command))));
}

std::string without_line_breaks(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text;
}

}  // namespace

void refuse_unknown_command(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  const std::vector<std::string> names = commands_of(app);
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return;
  throw Error(fmt::format("'{}' is not a command", argv[1]), "command line",
              did_you_mean(argv[1], names, "see 'rastro --help'"));
}

void refuse_empty_values(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "--") return;
    if (word.size() < 4 || !word.starts_with("--") || word.find('=') != word.size() - 1) continue;
    // CLI11 would take the next word for its value, be that a flag.
    throw Error("has no value", word, "write the value right after the '='");
  }
}

std::string parse_error_line(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = innermost(app);
  // A mistyped flag often shows first as a missing argument: name the flag, it is the cause.
  for (const std::string& word : app.remaining(true)) {
    if (word.size() > 1 && word[0] == '-' && !parse_double(word)) return unknown_flag(command, word);
  }
  return fmt::format("{}; see '{} --help'", without_line_breaks(error.what()), full_name(command));
}

}  // namespace rastro::cli
