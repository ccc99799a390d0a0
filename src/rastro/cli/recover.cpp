// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "rastro/base/error.h"
#include "rastro/cli/command.h"
#include "rastro/cli/map_path.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/recover_map.h"

namespace rastro::cli {
namespace {

constexpr const char* footer =
    "Looks through a map file that is cut off, damaged or was left by a run that was killed, takes every row whose\n"
    "checksum holds and writes a sound map of them. A keyframe is kept where its features, its pose and its pictures\n"
    "are; edges to lost keyframes go with them. Keyframes are numbered anew. Of a map of landmarks, keyframes with\n"
    "features and pose and the landmarks that one of them sees are kept, with their numbers. MAP itself is not "
    "touched.\n"
    "\n"
    "Example:\n"
    "  rastro recover run/map.rastro --out saved.rastro";

struct RecoverFlags {
  std::string map, out;
  bool force = false;
};

int recover(const RecoverFlags& flags) {
  const std::filesystem::path file = map_file_of(flags.map), out = flags.out;
  std::error_code code;
  if (std::filesystem::equivalent(file, out, code))
    throw Error("is the damaged map itself", flags.out, "give another file with --out");
  if (std::filesystem::exists(out, code) && !flags.force)
    throw Error("is there already", flags.out, "choose another --out or add --force");
  const RecoveredMap recovered = recover_map(file);
  if (recovered.landmark_map) {
    const LandmarkMap& map = *recovered.landmark_map;
    save_map(map, out);
    fmt::print("{}: {} keyframes, {} landmarks, {} poses of the way\n", flags.out, map.keyframes.size(),
               map.landmarks.size(), map.trajectory.size());
  } else {
    save_map(*recovered.map, out);
    fmt::print("{}: {} keyframes, {} edges, {} poses of the way\n", flags.out, recovered.map->keyframes.size(),
               recovered.map->edges.size(), recovered.map->trajectory.size());
  }
  for (const std::string& lost : recovered.lost) fmt::print("  lost         {}\n", lost);
  if (!recovered.finished)
    fmt::print("  unfinished   the file does not say how much it should hold: what came last may be missing\n");
  if (recovered.lost.empty() && recovered.finished) fmt::print("  lost         nothing\n");
  return done;
}

}  // namespace

void add_recover_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("recover", "Save what can be read of a damaged map");
  const auto flags = std::make_shared<RecoverFlags>();
  command->add_option("MAP", flags->map, "The map file, or the folder of its run")->required();
  command->add_option("--out", flags->out, "File for the map of what is left")->type_name("FILE")->required();
  command->add_flag("--force", flags->force, "Replace the file of --out");
  command->footer(footer);
  command->callback([flags, &context] { context.exit_code = recover(*flags); });
}

}  // namespace rastro::cli
