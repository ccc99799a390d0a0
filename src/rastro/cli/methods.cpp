// SPDX-License-Identifier: Apache-2.0
#include "rastro/methods/methods.h"

#include <fmt/format.h>

#include "rastro/cli/command.h"
#include "rastro/odometry/methods.h"

namespace rastro::cli {
namespace {

constexpr const char* footer = R"(Examples:
  rastro methods
  rastro options hector          every setting of one of them
  rastro slam intel.clf.gz --method hector --out run)";

void print_line(const std::string& name, const std::string& summary, const std::string& needs) {
  fmt::print("  {:<10} {}\n  {:<10}   needs {}\n", name, summary, "", needs);
}

void print_methods() {
  fmt::print("Odometry (the way, without a map): rastro odometry DATA --method NAME\n");
  for (const std::string& name : odometry_methods()) print_line(name, odometry_summary(name), "one calibrated camera");
  fmt::print("SLAM (the way and a map): rastro slam DATA --method NAME\n");
  for (const auto& method : slam_methods()) print_line(method->name(), method->summary(), method->needs());
}

}  // namespace

void add_methods_command(CLI::App& app, Context&) {
  CLI::App* command = app.add_subcommand("methods", "Every odometry and SLAM method, and what it needs");
  command->footer(footer);
  command->callback(print_methods);
}

}  // namespace rastro::cli
