// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace rastro::cli {

/// How a run ended; main() returns it. Documented in `rastro --help`.
enum ExitCode { done = 0, limit_missed = 1, unusable = 2, fault = 3 };

/// What a subcommand leaves for main().
struct Context {
  int exit_code = done;
};

// One file per subcommand: each adds its subcommand with flags, help and examples, and runs it in the callback.
// A callback throws rastro::Error for bad input; main() prints the line and returns `unusable`.
void add_track_command(CLI::App& app, Context& context);
void add_odometry_command(CLI::App& app, Context& context);
void add_slam_command(CLI::App& app, Context& context);
void add_localize_command(CLI::App& app, Context& context);
void add_record_command(CLI::App& app, Context& context);
void add_devices_command(CLI::App& app, Context& context);
void add_recover_command(CLI::App& app, Context& context);
void add_scale_command(CLI::App& app, Context& context);
void add_export_command(CLI::App& app, Context& context);
void add_view_command(CLI::App& app, Context& context);
void add_measure_command(CLI::App& app, Context& context);
void add_methods_command(CLI::App& app, Context& context);
void add_evaluate_command(CLI::App& app, Context& context);
void add_simulate_command(CLI::App& app, Context& context);
void add_occlude_command(CLI::App& app, Context& context);
void add_convert_command(CLI::App& app, Context& context);
void add_info_command(CLI::App& app, Context& context);
void add_check_command(CLI::App& app, Context& context);
void add_calibrate_command(CLI::App& app, Context& context);
void add_vocabulary_command(CLI::App& app, Context& context);
void add_benchmark_command(CLI::App& app, Context& context);
void add_compare_command(CLI::App& app, Context& context);
void add_options_command(CLI::App& app, Context& context);

}  // namespace rastro::cli
