// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/stopwatch.h"
#include "rastro/base/text.h"

namespace rastro::cli {
namespace {

constexpr int look_every_ms = 100;          ///< How often `stop`, the time limit and the memory are looked at.
constexpr int not_started = 127;            ///< As of a shell.
constexpr std::size_t most_kept = 1 << 16;  ///< Bytes of standard error.

/// Closes what it holds.
struct Descriptor {
  int number = -1;
  ~Descriptor() { close_now(); }
  void close_now() {
    if (number >= 0) ::close(number);
    number = -1;
  }
};

/// Its ends are closed by exec.
struct Pipe {
  explicit Pipe(const std::string& program) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
      throw Error(fmt::format("no pipe for a child process: {}", std::strerror(errno)), program,
                  "close other programs");
    reading.number = ends[0], writing.number = ends[1];
  }
  Descriptor reading, writing;
};

/// Returns when the child is the other program.
void wait_for_exec(Pipe& start) {
  start.writing.close_now();
  char nothing = 0;
  while (::read(start.reading.number, &nothing, 1) < 0 && errno == EINTR) {
  }
}

/// Between fork and exec: nothing but system calls.
[[noreturn]] void become(const char* program, char* const* words, int error_pipe, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(not_started);
  const int nothing = ::open("/dev/null", O_RDWR);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(nothing, STDOUT_FILENO);
  ::dup2(error_pipe, STDERR_FILENO);
  ::execv(program, words);
  ::_exit(not_started);
}

std::string last_line_of(const std::string& text) {
  const std::size_t end = text.find_last_not_of("\n ");
  if (end == std::string::npos) return "";
  const std::size_t line_end = text.find_last_of('\n', end);
  const std::size_t begin = line_end == std::string::npos ? 0 : line_end + 1;
  return one_line(text.substr(begin, end - begin + 1), 500);
}

constexpr double mb_per_kb = 1024.0 * 1e-6;

/// "VmHWM" or another amount of /proc/PID/status; nullopt where it is not there, as of a process that has ended.
std::optional<double> memory_mb(const std::string& process, const std::string& key) {
  std::ifstream status("/proc/" + process + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(key + ":")) return mb_per_kb * std::strtod(line.c_str() + key.size() + 1, nullptr);
  return std::nullopt;
}

/// The largest resident memory of a child, though the system's count begins before its exec, when it is a copy of this
/// process.
class ChildMemory {
 public:
  void look(pid_t child) { sampled_mb_ = std::max(sampled_mb_, memory_mb(std::to_string(child), "VmHWM")); }

  double peak_mb(const rusage& usage) const {
    constexpr double growth = 1.02;  // of this process, until the fork
    const double counted_mb = mb_per_kb * static_cast<double>(usage.ru_maxrss);
    return sampled_mb_ && counted_mb <= growth * before_mb_ ? *sampled_mb_ : counted_mb;
  }

 private:
  double before_mb_ = memory_mb("self", "VmRSS").value_or(0.0);
  std::optional<double> sampled_mb_;
};

/// Reads standard error until the child closes it, which it does when it ends.
std::string read_to_end(int pipe, pid_t child, double timeout_s, const std::atomic<bool>& stop, ChildMemory& memory,
                        ChildEnd& end) {
  Stopwatch watch;
  double passed_s = 0.0;
  std::string text;
  std::array<char, 4096> bytes{};
  for (;;) {
    pollfd poll_one{pipe, POLLIN, 0};
    const int ready = ::poll(&poll_one, 1, look_every_ms);
    passed_s += 1e-3 * watch.lap_ms();
    if (stop && !end.stopped) {
      end.stopped = true;
      ::kill(child, SIGTERM);
    } else if (!end.timed_out && passed_s > timeout_s) {
      end.timed_out = true;
      ::kill(child, SIGKILL);
    }
    memory.look(child);
    if (ready <= 0) continue;
    const ssize_t count = ::read(pipe, bytes.data(), bytes.size());
    if (count == 0 || (count < 0 && errno != EINTR)) return text;
    if (count > 0) text.append(bytes.data(), static_cast<std::size_t>(count));
    if (text.size() > 2 * most_kept) text.erase(0, text.size() - most_kept);
  }
}

void note_usage(pid_t child, const ChildMemory& memory, ChildEnd& end) {
  int status = 0;
  rusage usage{};
  while (::wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  end.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  end.peak_memory_mb = memory.peak_mb(usage);
}

}  // namespace

ChildEnd run_child(const std::string& program, const std::vector<std::string>& command, double timeout_s,
                   const std::atomic<bool>& stop) {
  std::vector<std::string> words = command;
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  Pipe errors(program), start(program);
  const pid_t parent = ::getpid();
  Stopwatch watch;
  ChildMemory memory;
  const pid_t child = ::fork();
  if (child == 0) become(program.c_str(), pointers.data(), errors.writing.number, parent);
  if (child < 0)
    throw Error(fmt::format("cannot be started: {}", std::strerror(errno)), program, "free memory or lower --jobs");
  errors.writing.close_now();
  wait_for_exec(start);
  ChildEnd end;
  end.last_line = last_line_of(read_to_end(errors.reading.number, child, timeout_s, stop, memory, end));
  note_usage(child, memory, end);
  end.wall_s = 1e-3 * watch.lap_ms();
  return end;
}

}  // namespace rastro::cli
