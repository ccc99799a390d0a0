// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/methods/methods.h"
#include "rastro/odometry/methods.h"
#include "rastro/track/options.h"

namespace rastro::cli {
namespace {

constexpr std::size_t text_width = 100;

std::vector<std::string> methods() {
  std::vector<std::string> names = {"track"};
  names.insert(names.end(), odometry_methods().begin(), odometry_methods().end());
  for (const auto& method : slam_methods()) names.push_back(method->name());
  return names;
}

constexpr const char* footer =
    R"(Settings are taken in this order: default, --options FILE, --set KEY=VALUE and the flags of the command.
The values in force are written to options.yaml in the folder of each run.

Examples:
  rastro options                                  every setting of the tracker
  rastro options features                         of an odometry
  rastro options hector                           and of a SLAM method
  rastro options --yaml > mine.yaml               a file to edit; it may be cut down to what differs
  rastro track hall --out run --options mine.yaml --set window=60)";

/// Words of `text` in lines that begin with `indent`.
std::string wrapped(const std::string& text, const std::string& indent) {
  std::string lines, line = indent;
  for (const std::string_view word : split_words(text)) {
    if (line.size() > indent.size() && line.size() + 1 + word.size() > text_width) {
      lines += line + "\n";
      line = indent;
    }
    line += (line.size() > indent.size() ? " " : "") + std::string(word);
  }
  return lines + line + "\n";
}

std::string described(const OptionTable& table) {
  std::string text;
  for (std::size_t i = 0; i < table.options().size(); ++i) {
    const Option& option = table.options()[i];
    text += fmt::format("{} = {}{}", option.name, table.default_of(i), option.unit.empty() ? "" : " " + option.unit);
    if (const std::string allowed = table.allowed_of(i); !allowed.empty()) text += fmt::format("   ({})", allowed);
    text += "\n" + wrapped(option.why, "    ");
  }
  return text;
}

/// Whatever the tables of all methods point into.
struct Settings {
  TrackOptions track;
  OdometrySettings odometry;
  std::vector<std::unique_ptr<SlamMethod>> slam = slam_methods();

  OptionTable table(const std::string& method) {
    if (method == "track") return option_table(track);
    for (const auto& each : slam)
      if (each->name() == method) return each->options();
    return odometry.table(method);
  }
};

void print_options(const std::string& method, bool yaml) {
  const std::vector<std::string> known = methods();
  if (std::find(known.begin(), known.end(), method) == known.end()) {
    throw Error(fmt::format("'{}' has no options", method), "rastro options",
                fmt::format("did you mean '{}'?", nearest_name(method, known)));
  }
  Settings settings;
  const OptionTable table = settings.table(method);
  fmt::print("{}", yaml ? table.to_yaml() : described(table));
}

}  // namespace

void add_options_command(CLI::App& app, Context&) {
  CLI::App* command = app.add_subcommand("options", "Every setting: name, default, unit, range and reason");
  const auto method = std::make_shared<std::string>("track");
  const auto yaml = std::make_shared<bool>(false);
  command->add_option("method", *method, "Whose settings (default: track)")->type_name("METHOD");
  command->add_flag("--yaml", *yaml, "As a file for --options");
  command->footer(footer);
  command->callback([method, yaml] { print_options(*method, *yaml); });
}

}  // namespace rastro::cli
