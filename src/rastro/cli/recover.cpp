// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "rastro/base/error.h"
#include "rastro/cli/command.h"
#include "rastro/cli/map_path.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/layer_type.h"

namespace rastro::cli {
namespace {

constexpr const char* recover_footer =
    R"(Reads every row with a valid checksum of a map file that is truncated, damaged or of a killed run, and writes them as
a new map. Keyframes keep their ids; constraints and layer data of lost keyframes are dropped. MAP is not changed.

Example:
  rastro recover run/map.rastro --out recovered.rastro)";

struct RecoverFlags {
  std::string map, out;
  bool force = false;
};

int recover(const RecoverFlags& flags) {
  const std::filesystem::path file = map_file_of(flags.map), out = flags.out;
  std::error_code code;
  if (std::filesystem::equivalent(file, out, code))
    throw Error("is the damaged map", flags.out, "give another file with --out");
  if (std::filesystem::exists(out, code) && !flags.force)
    throw Error("already exists", flags.out, "choose another --out or add --force");
  const RecoveredMap recovered = recover_map(file);
  const Map& map = *recovered.map;
  if (map.keyframes.empty() && map.frames.empty())
    throw Error("holds no keyframe and no pose that could be read", file.string(), "there is nothing to recover");
  save_map(map, out);
  fmt::print("{}: {} keyframes, {} constraints, {} poses of the trajectory\n", flags.out, map.keyframes.size(),
             map.constraints.size(), map.frames.size());
  for (const auto& [name, layer] : map.layers.all())
    if (const LayerType* type = layer_type(name)) fmt::print("  {:<12} {}\n", name, type->describe(map, *layer).text);
  for (const std::string& lost : recovered.lost) fmt::print("  lost         {}\n", lost);
  if (!recovered.finished) fmt::print("  unfinished   the run did not end regularly: its last data may be missing\n");
  if (recovered.lost.empty() && recovered.finished) fmt::print("  lost         nothing\n");
  return done;
}

}  // namespace

void add_recover_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("recover", "Recovers what can be read of a damaged map");
  const auto flags = std::make_shared<RecoverFlags>();
  command->add_option("MAP", flags->map, "Map file or run folder")->type_name("")->required();
  command->add_option("--out", flags->out, "Map file to write")->type_name("FILE")->required();
  command->add_flag("--force", flags->force, "Overwrite --out");
  command->footer(recover_footer);
  command->callback([flags, &context] { context.exit_code = recover(*flags); });
}

}  // namespace rastro::cli
