// SPDX-License-Identifier: Apache-2.0
#include "rastro/methods/methods.h"

#include <fmt/format.h>

#include "rastro/cli/command.h"
#include "rastro/cli/method_text.h"

namespace rastro::cli {
namespace {

constexpr const char* methods_footer = R"(Examples:
  rastro methods
  rastro options hector          options of a method
  rastro slam intel.clf.gz --method hector --out run)";

void print_methods() {
  fmt::print("Odometry (trajectory without a map): rastro odometry DATA --method NAME\n{}",
             methods_text(odometry_methods()));
  fmt::print("SLAM (trajectory and map): rastro slam DATA --method NAME\n{}", methods_text(selectable_slam_methods()));
}

}  // namespace

void add_methods_command(CLI::App& app, Context&) {
  CLI::App* command = app.add_subcommand("methods", "Lists the odometry and SLAM methods and the input of each");
  command->footer(methods_footer);
  command->callback(print_methods);
}

}  // namespace rastro::cli
