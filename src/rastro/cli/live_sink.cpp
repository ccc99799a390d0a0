// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/memory.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/scene_input.h"

namespace rastro::cli {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t most_points = 300'000;  // of a scene that is made anew all the time

ViewServerOptions with_token(ViewServerOptions options) {
  if (options.token.empty()) options.token = random_token();
  return options;
}

ViewSceneOptions live_scene_options() {
  ViewSceneOptions options;
  options.max_points = most_points;
  return options;
}

LiveHello with_commands(LiveHello run, const std::vector<LiveCommand>& more) {
  run.commands = {LiveCommand::pause, LiveCommand::resume, LiveCommand::step, LiveCommand::end};
  run.commands.insert(run.commands.end(), more.begin(), more.end());
  return run;
}

}  // namespace

LiveSink::LiveSink(const ServerFlags& flags, LiveHello run, const std::vector<LiveCommand>& more,
                   std::function<void(LiveCommand)> obey, LiveView::PlaceOf place_of)
    : obey_more_(std::move(obey)),
      view_(with_token(server_options(flags)), with_commands(std::move(run), more), live_scene_options(),
            std::move(place_of)) {
  say("");
  fmt::print(stderr, "view: {}\n", view_.url());
}

void LiveSink::show(LiveFrame frame) {
  frame.rate_hz = static_cast<double>(frame.done) / std::max(1e-3, 1e-3 * since_begin_.elapsed_ms());
  frame.memory_mb = resident_memory_mb();
  view_.show(frame);
}

void LiveSink::idle(const std::string& line) {
  if (!line.empty() && line != status_.line) {
    shows_source_ = true;
    say(line);
  }
  take_commands();
}

void LiveSink::take_commands() {
  constexpr int most_at_once = 64;  // a page that sends without end does not hold up the run
  for (int k = 0; k < most_at_once; ++k) {
    const auto command = view_.next_command(milliseconds(0));
    if (!command) break;
    obey(*command);
  }
}

void LiveSink::obey_pages() {
  if (std::exchange(shows_source_, false)) say("");
  if (std::exchange(steps_, false)) status_.paused = true;
  take_commands();
  while (status_.paused && view_.is_watched() && !catch_interrupts().load())
    if (const auto command = view_.next_command(milliseconds(50))) obey(*command);
  if (!status_.paused || view_.is_watched()) return;
  status_.paused = false;  // a page that pauses a run and is closed leaves it to go on
  say("");
}

void LiveSink::obey(LiveCommand command) {
  switch (command) {
    case LiveCommand::pause:
      status_.paused = true;
      return say("paused");
    case LiveCommand::resume:
      status_.paused = false;
      return say("");
    case LiveCommand::step:
      steps_ = std::exchange(status_.paused, false);
      return;
    case LiveCommand::end:
      status_.paused = false;
      say("ends after this frame");
      return interrupt();
    default:
      if (obey_more_) obey_more_(command);
  }
}

void LiveSink::say(const std::string& line) {
  status_.line = line;
  view_.say(status_);
}

void LiveSink::finish(const std::string& line) {
  status_.paused = false;
  status_.ended = true;
  say(line);
}

void LiveSink::wait_until_closed() {
  if (!view_.is_watched() || interrupt_signals() > 0) return;
  std::fflush(stdout);  // it may be a pipe
  fmt::print(stderr, "view: still open; ends when the page is closed, or with Ctrl-C\n");
  while (view_.is_watched() && interrupt_signals() == 0) view_.next_command(milliseconds(100));
}

std::size_t scene_state_of(const std::string& name) {
  const auto& names = scene_state_names();
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::optional<LiveHello> live_hello(const RunFlags& flags, const std::string& method,
                                    std::optional<std::int64_t> frames) {
  const bool has_server = flags.server.port || !flags.server.listen.empty() || !flags.server.token.empty();
  if (!flags.view && has_server) throw Error("nothing is served", "--port, --listen, --token", "add --view");
  if (!flags.view) return std::nullopt;
  LiveHello hello;
  hello.title = scene_name(flags.out);
  hello.method = method;
  hello.frames = frames;
  return hello;
}

}  // namespace rastro::cli
