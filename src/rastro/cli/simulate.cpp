// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/write_euroc.h"

namespace rastro::cli {
namespace {

struct SimulateFlags {
  std::string world;
  std::string out;
  std::int64_t frames = 150;
  std::uint64_t seed = 1;
  int threads = 0;
  bool distortion = false;
  bool no_truth = false;
  bool force = false;
  bool quiet = false;
};

constexpr const char* worlds_text =
    "hall   a machine hall seen from a drone, 752x480 at 20 Hz: it rises behind a press and sinks again (frames "
    "0-29),\n"
    "       turns abruptly (42-56), passes behind a pillar (76-112), then tours the hall without end\n";

void simulate(const SimulateFlags& flags) {
  if (flags.world.empty()) {
    fmt::print("{}", worlds_text);
    return;
  }
  const std::vector<std::string> names = {"hall"};
  if (flags.world != "hall")
    throw Error("there is no such world", flags.world,
                fmt::format("did you mean '{}'? `rastro simulate` lists the worlds", nearest_name(flags.world, names)));
  if (flags.out.empty()) throw Error("there is nowhere to write to", "--out", "give a folder with --out DIR");
  if (flags.frames < 1 || flags.frames > 10'000'000)
    throw Error("the number of frames is out of range", "--frames", "use 1 to 10000000");
  if (flags.threads < 0)
    throw Error("the number of threads is negative", "--threads", "use 0 for all of the machine, or 1 and more");
  const EurocOptions options{flags.frames, !flags.no_truth, flags.force};
  const World world = make_hall({.seed = flags.seed, .distortion = flags.distortion, .threads = flags.threads});
  TaskPool pool(flags.threads);
  const bool shows = !flags.quiet && isatty(STDERR_FILENO) == 1;
  const EurocSummary summary = write_euroc(world, flags.out, options, pool, [&](std::int64_t done) {
    if (shows) fmt::print(stderr, "\r{} of {} frames", done, flags.frames);
  });
  if (shows) fmt::print(stderr, "\r{:40}\r", "");
  if (!flags.quiet)
    fmt::print("world      {} (seed {})\nframes     {}, {}x{}, {:g} Hz\nwritten to {} ({:.1f} MB)\n", world.name(),
               flags.seed, summary.frames, world.camera().width, world.camera().height, world.rate_hz(), flags.out,
               static_cast<double>(summary.bytes) * 1e-6);
}

}  // namespace

void add_simulate_command(CLI::App& app, Context& context) {
  const auto flags = std::make_shared<SimulateFlags>();
  CLI::App* command = app.add_subcommand("simulate", "Generate a recording of a made-up world, with exact truth");
  command->add_option("world", flags->world, "Which world; without it the worlds are listed");
  command->add_option("--out", flags->out, "Folder to write, in EuRoC layout")->type_name("DIR");
  command->add_option("--frames", flags->frames, "How many frames")->capture_default_str();
  command->add_option("--seed", flags->seed, "Of textures, furniture and noise; the path stays the same")
      ->capture_default_str();
  command->add_option("--threads", flags->threads, "0 = all of the machine; the bytes do not depend on it")
      ->capture_default_str();
  command->add_flag("--distortion", flags->distortion, "With EuRoC's lens distortion; else an ideal pinhole");
  command->add_flag("--no-truth", flags->no_truth, "Leave out the depth and surface pictures that scoring needs");
  command->add_flag("--force", flags->force, "Write into a folder that is not empty");
  command->add_flag("--quiet", flags->quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n"
      "  rastro simulate hall --out hall                      150 frames with truth\n"
      "  rastro simulate hall --out long --frames 10000 --no-truth\n"
      "  rastro simulate hall --out bent --distortion --seed 7");
  command->callback([flags, &context] {
    simulate(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
