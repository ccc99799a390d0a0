// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <string>
#include <vector>

namespace rastro::cli {

/// How a child process ended, and what it used.
struct ChildEnd {
  int exit_code = -1;  ///< -1: it ended by `signal`.
  int signal = 0;      ///< 0: it ended by itself.
  bool timed_out = false;
  bool stopped = false;  ///< `stop` was set: what it left is not a result.
  double wall_s = 0.0;
  double cpu_s = 0.0;           ///< Of all its threads.
  double peak_memory_mb = 0.0;  ///< Resident.
  std::string last_line;        ///< Of its standard error.
};

/// Runs the file `program` with these words, the first of which is the name it goes by, without input and standard
/// output, to its end, or until `stop` is set or `timeout_s` is over. It dies with this process. Error where it cannot
/// be started.
ChildEnd run_child(const std::string& program, const std::vector<std::string>& command, double timeout_s,
                   const std::atomic<bool>& stop);

}  // namespace rastro::cli
