// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/synthetic/worlds/street.h"
#include "rastro/synthetic/write_euroc.h"
#include "rastro/synthetic/write_kitti.h"

namespace rastro::cli {
namespace {

struct SimulateFlags {
  std::string world;
  std::string out;
  std::string format;
  std::optional<std::int64_t> frames;
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
    "       turns abruptly (42-56), passes behind a pillar (76-112), then tours the hall without end\n"
    "street a drive around a block of houses as in KITTI, 1242x375 at 10 Hz: a turn (frames 6-43), a straight, a "
    "second "
    "turn\n"
    "       (about 210-250) and so on without end; other cars drive, the exposure changes\n";

struct Written {
  std::int64_t frames = 0;
  std::uintmax_t bytes = 0;
  std::string recording;
};

Written write_as_asked(const World& world, const SimulateFlags& flags, std::int64_t frames,
                       const std::function<void(std::int64_t)>& progress) {
  TaskPool pool(flags.threads);
  if (flags.format == "euroc") {
    const EurocOptions options{frames, !flags.no_truth, flags.force};
    const EurocSummary summary = write_euroc(world, flags.out, options, pool, progress);
    return {summary.frames, summary.bytes, flags.out};
  }
  const KittiLayout layout = flags.format == "kitti" ? KittiLayout::odometry : KittiLayout::raw;
  const KittiSummary summary = write_kitti(world, flags.out, {frames, layout, flags.force}, pool, progress);
  return {summary.frames, summary.bytes, summary.recording.string()};
}

void check_flags(const SimulateFlags& flags) {
  const std::vector<std::string> names = {"hall", "street"}, formats = {"euroc", "kitti", "kitti-raw"};
  const auto is_one_of = [](const std::string& name, const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  if (!is_one_of(flags.world, names))
    throw Error("there is no such world", flags.world,
                fmt::format("did you mean '{}'? `rastro simulate` lists the worlds", nearest_name(flags.world, names)));
  if (!flags.format.empty() && !is_one_of(flags.format, formats))
    throw Error(
        "there is no such format", flags.format,
        fmt::format("did you mean '{}'? There are euroc, kitti and kitti-raw", nearest_name(flags.format, formats)));
  if (flags.distortion && flags.world != "hall")
    throw Error("only the hall has a lens with distortion", "--distortion", "leave it out");
  if (flags.out.empty()) throw Error("there is nowhere to write to", "--out", "give a folder with --out DIR");
  if (flags.frames && (*flags.frames < 1 || *flags.frames > 10'000'000))
    throw Error("the number of frames is out of range", "--frames", "use 1 to 10000000");
  if (flags.threads < 0)
    throw Error("the number of threads is negative", "--threads", "use 0 for all of the machine, or 1 and more");
}

World make_world(const SimulateFlags& flags) {
  if (flags.world == "street") return make_street({.seed = flags.seed, .threads = flags.threads});
  return make_hall({.seed = flags.seed, .distortion = flags.distortion, .threads = flags.threads});
}

void simulate(SimulateFlags flags) {
  if (flags.world.empty()) {
    fmt::print("{}", worlds_text);
    return;
  }
  check_flags(flags);
  const bool street = flags.world == "street";
  if (flags.format.empty()) flags.format = street ? "kitti" : "euroc";
  const std::int64_t frames = flags.frames.value_or(street ? 400 : 150);
  const World world = make_world(flags);
  const bool shows = !flags.quiet && isatty(STDERR_FILENO) == 1;
  const Written written = write_as_asked(world, flags, frames, [&](std::int64_t done) {
    if (shows) fmt::print(stderr, "\r{} of {} frames", done, frames);
  });
  if (shows) fmt::print(stderr, "\r{:40}\r", "");
  if (!flags.quiet)
    fmt::print("world      {} (seed {})\nframes     {}, {}x{}, {:g} Hz\nwritten to {} ({:.1f} MB)\n", world.name(),
               flags.seed, written.frames, world.camera().width, world.camera().height, world.rate_hz(),
               written.recording, static_cast<double>(written.bytes) * 1e-6);
}

}  // namespace

void add_simulate_command(CLI::App& app, Context& context) {
  const auto flags = std::make_shared<SimulateFlags>();
  CLI::App* command = app.add_subcommand("simulate", "Generate a recording of a made-up world, with exact truth");
  command->add_option("world", flags->world, "Which world; without it the worlds are listed");
  command->add_option("--out", flags->out, "Folder to write")->type_name("DIR");
  command->add_option("--format", flags->format,
                      "euroc, kitti (odometry) or kitti-raw; default euroc for the hall, "
                      "kitti for the street");
  command->add_option("--frames", flags->frames, "How many frames; default 150 in the hall, 400 in the street");
  command->add_option("--seed", flags->seed, "Of textures, furniture or houses, and noise; the path stays the same")
      ->capture_default_str();
  command->add_option("--threads", flags->threads, "0 = all of the machine; the bytes do not depend on it")
      ->capture_default_str();
  command->add_flag("--distortion", flags->distortion, "The hall with EuRoC's lens distortion; else an ideal pinhole");
  command->add_flag("--no-truth", flags->no_truth,
                    "Leave out the depth and surface pictures that scoring needs (euroc)");
  command->add_flag("--force", flags->force, "Write into a folder that is not empty");
  command->add_flag("--quiet", flags->quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n"
      "  rastro simulate hall --out hall                      150 frames with truth\n"
      "  rastro simulate hall --out long --frames 10000 --no-truth\n"
      "  rastro simulate hall --out bent --distortion --seed 7\n"
      "  rastro simulate street --out street                  400 frames as KITTI odometry, with poses\n"
      "  rastro simulate street --out raw --format kitti-raw  the same drive with GPS/IMU packets");
  command->callback([flags, &context] {
    simulate(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
