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
#include "rastro/cli/run_flags.h"
#include "rastro/methods/methods.h"
#include "rastro/track/options.h"

namespace rastro::cli {
namespace {

constexpr std::size_t text_width = 100;

constexpr const char* options_footer =
    R"(Values are taken in this order: default, --preset, --options FILE, --set KEY=VALUE, flags of the command. The values in use are
written to options.yaml of every run.

Examples:
  rastro options                                  options of the tracker
  rastro options features                         of an odometry method
  rastro options hector                           of a SLAM method
  rastro options odometry/rgbd                    where odometry and SLAM have a method of the same name (default: SLAM)
  rastro options track --preset paper             values of the front-end paper
  rastro options --yaml > mine.yaml               a file to edit; omitted options keep their defaults
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
    text += fmt::format("{} = {}{}", option.name, table.value_of(i), option.unit.empty() ? "" : " " + option.unit);
    if (const std::string allowed = table.allowed_of(i); !allowed.empty()) text += fmt::format("   ({})", allowed);
    text += "\n" + wrapped(option.why, "    ");
  }
  return text;
}

/// The option tables, and what they point into.
class Settings {
 public:
  Settings() {
    entries_.push_back({"track", option_table(track_), track_presets(),
                        [this](const std::string& /*name*/) { set_paper_preset(track_); }});
    add("slam/", slam_);
    add("odometry/", odometry_);
  }

  /// Of a method by its name, or by kind and name: "odometry/rgbd"; with the values of a preset. Error for an unknown
  /// name, naming the nearest.
  const OptionTable& table(const std::string& wanted, const std::string& preset) {
    std::vector<std::string> names;
    for (Entry& entry : entries_) {
      const std::string alone = entry.name.substr(entry.name.find('/') + 1);
      if (wanted == alone || wanted == entry.name) {
        if (is_preset(preset, fmt::format("'{}'", alone), entry.presets)) entry.set_preset(preset);
        return entry.table;
      }
      names.push_back(wanted.find('/') == std::string::npos ? alone : entry.name);
    }
    throw Error(fmt::format("'{}' is not a method", wanted), "rastro options", did_you_mean(wanted, names));
  }

 private:
  struct Entry {
    std::string name;
    OptionTable table;
    std::vector<std::string> presets;
    std::function<void(const std::string&)> set_preset;
  };

  template <typename Method>
  void add(const std::string& kind, const std::vector<std::unique_ptr<Method>>& methods) {
    for (const auto& method : methods)
      entries_.push_back({kind + method->name(), method->options(), method->presets(),
                          [&method](const std::string& name) { method->set_preset(name); }});
  }

  TrackOptions track_;
  std::vector<std::unique_ptr<SlamMethod>> slam_ = selectable_slam_methods();
  std::vector<std::unique_ptr<OdometryMethod>> odometry_ = odometry_methods();
  std::vector<Entry> entries_;
};

void print_options(const std::string& method, const std::string& preset, bool yaml) {
  Settings settings;
  const OptionTable& table = settings.table(method, preset);
  fmt::print("{}", yaml ? table.to_yaml() : described(table));
}

}  // namespace

void add_options_command(CLI::App& app, Context&) {
  CLI::App* command =
      app.add_subcommand("options", "Lists the options of a method: name, default, unit, range and meaning");
  const auto method = std::make_shared<std::string>("track");
  const auto yaml = std::make_shared<bool>(false);
  const auto preset = std::make_shared<std::string>();
  command->add_option("METHOD", *method, "Method, see 'rastro methods' (default: track, the tracker)")->type_name("");
  command->add_option("--preset", *preset, "Values of a preset of the method, such as paper (default: default)")
      ->type_name("NAME");
  command->add_flag("--yaml", *yaml, "Print a file for --options");
  command->footer(options_footer);
  command->callback([method, preset, yaml] { print_options(*method, *preset, *yaml); });
}

}  // namespace rastro::cli
