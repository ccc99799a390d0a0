// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/simulated_worlds.h"
#include "rastro/synthetic/worlds/corridor.h"
#include "rastro/synthetic/write_euroc.h"
#include "rastro/synthetic/write_kitti.h"
#include "rastro/synthetic/write_laser_log.h"
#include "rastro/synthetic/write_loop_closures.h"
#include "rastro/synthetic/write_tum.h"

namespace rastro::cli {
namespace {

struct SimulateFlags {
  std::string world_name;
  std::string out;
  std::string format;
  std::optional<std::int64_t> frames;
  std::optional<double> odometry_error;
  std::string black;
  WorldFlags world;
  FrameSelection selection;
  bool no_ground_truth = false;
  bool stereo = false;
  bool force = false;
  bool quiet = false;
};

struct Written {
  std::int64_t frames = 0;
  std::uintmax_t bytes = 0;
  std::string recording;
};

bool is_room(const std::string& world) { return world == "bedroom" || world == "study"; }

/// "8:9" as two times in seconds; nullopt where the flag is not given.
std::optional<std::pair<double, double>> black_of(const SimulateFlags& flags) {
  if (flags.black.empty()) return std::nullopt;
  const std::size_t colon = flags.black.find(':');
  if (colon != std::string::npos) {
    const auto from = parse_finite(flags.black.substr(0, colon)), to = parse_finite(flags.black.substr(colon + 1));
    if (from && to && *from >= 0.0 && *to > *from) return std::pair(*from, *to);
  }
  throw Error("this is not an interval of time", "--black " + flags.black, "give two times in seconds, such as 8:9");
}

Written write_as_asked(const World& world, const SimulateFlags& flags, std::int64_t frames,
                       const std::function<void(std::int64_t)>& progress) {
  TaskPool pool(flags.world.threads);
  if (flags.format == "euroc") {
    const EurocOptions options{frames, !flags.no_ground_truth, flags.force, flags.stereo, flags.selection};
    const EurocSummary summary = write_euroc(world, flags.out, options, pool, progress);
    return {summary.frames, summary.bytes, flags.out};
  }
  if (flags.format == "tum") {
    const TumOptions options{frames, DepthModel{}, flags.force, black_of(flags), flags.selection};
    const TumSummary summary = write_tum(world, flags.out, options, pool, progress);
    return {summary.frames, summary.bytes, flags.out};
  }
  const KittiLayout layout = flags.format == "kitti" ? KittiLayout::odometry : KittiLayout::raw;
  const KittiSummary summary =
      write_kitti(world, flags.out, {frames, layout, flags.force, flags.stereo, flags.selection}, pool, progress);
  return {summary.frames, summary.bytes, summary.recording.string()};
}

void check_flags(const SimulateFlags& flags) {
  const SimulatedWorld& world = simulated_world(flags.world_name);
  const std::vector<std::string> formats = {"euroc", "kitti", "kitti-raw", "tum", "carmen"};
  if (!flags.format.empty() && std::find(formats.begin(), formats.end(), flags.format) == formats.end())
    throw Error("there is no such format", flags.format, did_you_mean(flags.format, formats));
  if (flags.world.distortion && flags.world_name != "hall")
    throw Error("only the hall has a lens with distortion", "--distortion", "omit it");
  if (!flags.black.empty() && flags.format != "tum" && !(flags.format.empty() && is_room(flags.world_name)))
    throw Error("only recordings with depth can have black images", "--black", "omit it or add --format tum");
  black_of(flags);
  const bool has_two = flags.format.empty() || flags.format == "euroc" || flags.format == "kitti";
  if (flags.stereo && !(world.has_stereo && has_two))
    throw Error("only loop and campus have a stereo camera, and only formats euroc and kitti", "--stereo", "omit it");
  const bool drives = flags.world_name == "corridor";
  if (flags.format == "carmen" && !drives)
    throw Error("only the corridor has a laser", "--format carmen", "simulate the corridor or choose another format");
  const bool laser = flags.format == "carmen" || (flags.format.empty() && drives);
  if (flags.odometry_error && !laser)
    throw Error("only a laser log has wheel odometry", "--odometry-error", "omit it or simulate the corridor");
  if (flags.odometry_error && !(*flags.odometry_error >= 0.0 && *flags.odometry_error <= 100.0))
    throw Error("the error factor is out of range", "--odometry-error", "give 0 to 100");
  if (flags.out.empty()) throw Error("is required", "--out", "give a folder: --out DIR");
  if (flags.frames && (*flags.frames < 1 || *flags.frames > 10'000'000))
    throw Error("the number of frames is out of range", "--frames", "give 1 to 10000000");
  if (flags.selection.every < 1 || flags.selection.every > 100'000)
    throw Error("this is not a step between frames", "--every", "give 1 to 100000");
  if (flags.selection.first < 0 || flags.selection.first > 10'000'000)
    throw Error("there is no such frame", "--first", "give 0 to 10000000");
  if ((flags.selection.first > 0 || flags.selection.every > 1) && laser)
    throw Error("a laser log has every scan", flags.selection.first > 0 ? "--first" : "--every",
                "omit it; 'rastro slam --frames' takes a part");
  if (flags.world.threads < 0)
    throw Error("the number of threads is negative", "--threads", "give 1 or more, or 0 for all cores");
}

/// Progress on standard error, if that is a terminal.
class Progress {
 public:
  Progress(const SimulateFlags& flags, std::int64_t frames)
      : frames_(frames), shows_(!flags.quiet && isatty(STDERR_FILENO) == 1) {}
  ~Progress() {
    if (shows_) fmt::print(stderr, "\r{:40}\r", "");
  }
  /// Throws Interrupted after Ctrl-C: what is listed in the recording is complete.
  void operator()(std::int64_t done) {
    done_ = done;
    if (shows_) fmt::print(stderr, "\r{} of {} frames", done, frames_);
    if (done < frames_) stop_if_interrupted();
  }
  std::string complete() const { return fmt::format("{} of {}", done_, frames_); }

 private:
  std::int64_t frames_, done_ = 0;
  bool shows_;
};

void say_interrupted(const SimulateFlags& flags, const Progress& progress, const char* what, const char* missing) {
  if (!flags.quiet)
    fmt::print("interrupted: {} {} are complete in {}{}\n", progress.complete(), what, flags.out, missing);
}

void simulate_laser(const SimulateFlags& flags) {
  const LaserWorld world = make_corridor_floor({.seed = flags.world.seed});
  TaskPool pool(flags.world.threads);
  const LaserLogOptions options{flags.frames, {.factor = flags.odometry_error.value_or(1.0)}, flags.force};
  LaserLogSummary summary;
  {
    Progress progress(flags, std::min(world.scan_count(), flags.frames.value_or(world.scan_count())));
    try {
      summary = write_laser_log(world, flags.out, options, pool, std::ref(progress));
    } catch (const Interrupted&) {
      return say_interrupted(flags, progress, "scans", "; relations and floor plan are missing");
    }
  }
  if (!flags.quiet)
    fmt::print(
        "world      {} (seed {})\nscans      {}, {} beams, {:g} Hz\npath       {:.2f} m, wheel odometry error up to "
        "{:.2f} m\nrelations  {}\nwritten to {} ({:.1f} MB)\n",
        world.name, flags.world.seed, summary.scans, world.laser.beams, world.rate_hz, summary.path_m,
        summary.odometry_off_m, summary.relations, flags.out, static_cast<double>(summary.bytes) * 1e-6);
}

/// Of a world at its full rate, those that are left after the first in steps of --every.
std::int64_t frames_of(const SimulateFlags& flags, const SimulatedWorld& world) {
  const std::int64_t left = std::max<std::int64_t>(1, world.default_frames - flags.selection.first);
  return flags.frames.value_or((left + flags.selection.every - 1) / flags.selection.every);
}

void simulate_camera(const SimulateFlags& flags) {
  const SimulatedWorld& simulated = simulated_world(flags.world_name);
  const std::int64_t frames = frames_of(flags, simulated);
  const World world = simulated.make(flags.world);
  Written written;
  {
    Progress progress(flags, frames);
    try {
      stop_if_interrupted();  // making the world takes time, too
      written = write_as_asked(world, flags, frames, std::ref(progress));
    } catch (const Interrupted&) {
      return say_interrupted(flags, progress, "frames", simulated.has_closures ? "; closures.yaml is missing" : "");
    }
    if (simulated.has_closures) {
      TaskPool pool(flags.world.threads);
      write_loop_closures(world, frames, flags.selection, written.recording, pool);
    }
  }
  if (!flags.quiet)
    fmt::print("world      {} (seed {})\nframes     {}, {}x{}, {:g} Hz\nwritten to {} ({:.1f} MB)\n", world.name(),
               flags.world.seed, written.frames, world.camera().width, world.camera().height,
               world.rate_hz() / static_cast<double>(flags.selection.every), written.recording,
               static_cast<double>(written.bytes) * 1e-6);
}

constexpr const char* examples_text = R"(Examples:
  rastro simulate hall --out hall                      150 frames with ground truth
  rastro simulate hall --out long --frames 10000 --no-ground-truth
  rastro simulate hall --out distorted --distortion --seed 7
  rastro simulate street --out street                  400 frames as KITTI odometry, with poses
  rastro simulate street --out raw --format kitti-raw  the same drive with GPS/IMU packets
  rastro simulate corridor --out office                2D laser with odometry, poses, relations and floor plan
  rastro simulate corridor --out rgbd --format tum --frames 1750   the same drive with a depth camera
  rastro simulate bedroom --out bedroom                one round with a Kinect, ground truth and lengths to measure
  rastro simulate study --out dark --seed 3 --black 10:11   with one second of black images
  rastro simulate loop --out loop                      walk with two loop closures, one camera
  rastro simulate loop --out pair --stereo             the same with a stereo camera
  rastro simulate campus --out tour --format tum --every 10   30 minutes at 2 Hz, in color and depth
  rastro simulate campus --out part --stereo --first 6000 --frames 1200   a minute at the full rate)";

void simulate(SimulateFlags flags) {
  if (flags.world_name.empty()) {
    fmt::print("{}", simulated_worlds_text());
    return;
  }
  check_flags(flags);
  if (flags.format.empty()) flags.format = simulated_world(flags.world_name).default_format;
  catch_interrupts();
  if (flags.format == "carmen")
    simulate_laser(flags);
  else
    simulate_camera(flags);
}

}  // namespace

void add_simulate_command(CLI::App& app, Context& context) {
  const auto flags = std::make_shared<SimulateFlags>();
  CLI::App* command =
      app.add_subcommand("simulate", "Generates a recording of a synthetic world with exact ground truth");
  command
      ->add_option("WORLD", flags->world_name,
                   "hall, street, corridor, bedroom, study, loop or campus; omit it to list them")
      ->type_name("");
  command->add_option("--out", flags->out, "Output folder")->type_name("DIR");
  command
      ->add_option("--format", flags->format,
                   "euroc, kitti (odometry), kitti-raw, tum (with depth) or carmen (2D laser, corridor only); default: "
                   "euroc for hall, loop and campus, kitti for street, carmen for corridor, tum for bedroom and study")
      ->type_name("FORMAT");
  command
      ->add_option("--frames", flags->frames,
                   "Number of frames; default: hall 150, street 400, bedroom and study 1156 (one round), loop 1541, "
                   "campus 36000, corridor the whole drive; fewer with --every")
      ->type_name("N");
  command->add_option("--every", flags->selection.every, "Only every N-th frame of the camera (default: 1)")
      ->type_name("N");
  command->add_option("--first", flags->selection.first, "The first frame to write (default: 0)")->type_name("N");
  command
      ->add_option("--odometry-error", flags->odometry_error,
                   "Wheel odometry error of the corridor; 1: 2 cm per meter and 2 degrees per 45 (default: 1)")
      ->type_name("FACTOR");
  command
      ->add_option("--black", flags->black,
                   "Black images without depth between two times, in seconds from the start (format tum)")
      ->type_name("FROM:TO");
  command
      ->add_option("--seed", flags->world.seed,
                   "Seed of textures, furniture or houses, and noise; the trajectory stays the same")
      ->capture_default_str();
  command
      ->add_option("--threads", flags->world.threads, "Number of threads, 0: all cores; the bytes do not depend on it")
      ->capture_default_str();
  command->add_flag("--distortion", flags->world.distortion,
                    "hall: EuRoC's lens distortion (default: a pinhole camera)");
  command->add_flag("--no-ground-truth", flags->no_ground_truth,
                    "Omit the depth and surface images, which `rastro evaluate tracks` needs (euroc)");
  command->add_flag("--stereo", flags->stereo, "loop and campus: with the right camera (euroc, kitti)");
  command->add_flag("--force", flags->force,
                    "Write into a folder that is not empty; a recording of that format there is replaced");
  command->add_flag("--quiet", flags->quiet, "Print errors only");
  command->footer(examples_text);
  command->callback([flags, &context] {
    simulate(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
