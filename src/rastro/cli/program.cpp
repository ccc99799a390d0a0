// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/program.h"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <opencv2/core/utils/logger.hpp>
#include <system_error>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/library_output.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/base/version.h"
#include "rastro/cli/command.h"
#include "rastro/cli/former_flags.h"
#include "rastro/cli/parse_error.h"

namespace rastro::cli {
namespace {

constexpr const char* program_footer = R"(Exit codes:
  0  success; also when stopped with Ctrl-C, which keeps the results so far
  1  success, but a limit given with --require was missed
  2  wrong usage or unusable input; one line on standard error says what and where
  3  internal error; please report it
Results go to standard output, log and progress bar to standard error.

Examples:
  rastro simulate hall --out hall                   generate a recording with exact ground truth
  rastro track hall --out tracks --images           track its features, draw every frame
  rastro evaluate tracks tracks --ground-truth hall re-identification recall and precision
  rastro odometry kitti/00 --out vo                 trajectory of one camera
  rastro slam MH_01_easy --method orb --out run     trajectory and map
  rastro view run                                   trajectory and map in a browser
  rastro evaluate trajectory MH_01_easy run         ATE and RPE
  rastro localize MH_02_easy --map run --out found  trajectory in that map
  rastro check my_recording                         gaps, timestamps, calibration, broken frames
  rastro options orb                                options of a method: default, unit, range

`rastro COMMAND --help` describes a command.)";

std::string& stored_command_line() {
  static std::string line;
  return line;
}

/// The words as they may be written into files: without the secret of --token.
std::vector<std::string> words_to_show(int argc, const char* const* argv) {
  std::vector<std::string> words(argv, argv + argc);
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--token" && i + 1 < words.size()) words[i + 1] = "...";
    if (words[i].starts_with("--token=")) words[i] = "--token=...";
  }
  return words;
}

std::string as_typed(int argc, const char* const* argv) {
  std::string line;
  const std::vector<std::string> words = words_to_show(argc, argv);
  for (std::size_t i = 0; i < words.size(); ++i) {
    line += (i == 0 ? "" : " ") + as_shell_word(words[i]);
  }
  return line;
}

std::string version_text() {
  const Version& is = version();
  std::string text = fmt::format("rastro {}\ncommit    {}\ncompiler  {}\n", is.number, is.commit, is.compiler);
  for (const OptionalPart& part : is.optional_parts) {
    text += fmt::format("{}  {}\n", part.included ? "with    " : "without ", part.name);
  }
  text.pop_back();
  return text;
}

void send_log_to_stderr() {
  const auto logger = spdlog::stderr_color_mt("rastro");
  // On a terminal a progress bar may stand in the line.
  logger->set_pattern(isatty(STDERR_FILENO) != 0 ? "\r\033[K%n: %^%l%$: %v" : "%n: %l: %v");
  set_log_sink([logger](LogLevel level, const std::string& line) {
    if (level == LogLevel::warning) {
      logger->warn(line);
    } else if (level == LogLevel::info) {
      logger->info(line);
    } else {
      logger->debug(line);
    }
  });
}

void add_commands(CLI::App& app, Context& context) {
  add_track_command(app, context);
  add_odometry_command(app, context);
  add_slam_command(app, context);
  add_localize_command(app, context);
  add_record_command(app, context);
  add_devices_command(app, context);
  add_evaluate_command(app, context);
  add_view_command(app, context);
  add_export_command(app, context);
  add_measure_command(app, context);
  add_scale_command(app, context);
  add_recover_command(app, context);
  add_info_command(app, context);
  add_check_command(app, context);
  add_convert_command(app, context);
  add_simulate_command(app, context);
  add_occlude_command(app, context);
  add_calibrate_command(app, context);
  add_vocabulary_command(app, context);
  add_benchmark_command(app, context);
  add_compare_command(app, context);
  add_methods_command(app, context);
  add_options_command(app, context);
}

int say(int code, std::string line) {
  // File names may hold line breaks; what goes wrong is one line all the same.
  for (char& c : line) c = static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  std::fflush(stdout);
  fmt::print(stderr, "rastro: {}\n", line);
  return code;
}

void parse(CLI::App& app, const std::vector<std::string>& words) {
  std::vector<const char*> pointers;
  for (const std::string& word : words) pointers.push_back(word.c_str());
  app.parse(static_cast<int>(pointers.size()), pointers.data());
}

int dispatch(int argc, const char* const* argv) {
  CLI::App app("Turns camera and laser recordings into feature tracks, trajectories and maps, and evaluates them.",
               "rastro");
  app.set_version_flag("--version", version_text(), "Print version, commit, compiler and optional features");
  app.footer(program_footer);
  app.require_subcommand(1);
  app.get_formatter()->column_width(32);
  Context context;
  add_commands(app, context);
  try {
    refuse_unknown_command(app, argc, argv);
    const std::vector<std::string> words = with_current_flags(argc, argv);
    refuse_empty_values(words);
    parse(app, words);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
    return say(unusable, parse_error_line(app, error));
  }
  return context.exit_code;
}

std::string output_fault(int number) {
  return fmt::format("standard output: cannot be written ({}); send it elsewhere",
                     std::error_code(number, std::generic_category()).message());
}

int say_fault(const std::exception& error) {
  return say(fault, fmt::format("internal error: {}; please report it with this line, the command '{}' and the output "
                                "of 'rastro --version'",
                                error.what(), command_line()));
}

}  // namespace

const std::string& command_line() { return stored_command_line(); }

int run_program(int argc, const char* const* argv) {
  // OpenCV and FFmpeg print on their own; everything they have to say comes back as one line of ours.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  stored_command_line() = as_typed(argc, argv);
  try {
    send_log_to_stderr();
    divert_library_output();
    std::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files is an error of the write that reaches it
    const int code = dispatch(argc, argv);
    return std::fflush(stdout) == 0 && std::ferror(stdout) == 0 ? code : say(unusable, output_fault(errno));
  } catch (const Error& error) {
    return say(unusable, error.what());
  } catch (const std::bad_alloc&) {
    return say(unusable, "memory: there is not enough of it; raise its limit, or use smaller images or fewer frames");
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) != 0) return say(unusable, output_fault(error.code().value()));
    if (error.code() != std::errc::resource_unavailable_try_again) return say_fault(error);
    return say(unusable, "threads: none can be started; raise the limits on memory and processes or add --threads 1");
  } catch (const std::exception& error) {
    return say_fault(error);
  }
}

}  // namespace rastro::cli
