// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/track_run_input.h"

#include <nlohmann/json.hpp>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

void read_about(const fs::path& file, TrackRunInput& input) {
  const auto json = nlohmann::json::parse(read_whole_file(file), nullptr, false);
  try {
    const auto& described = json.at("input");
    input.data_path = described.at("path").get<std::string>();
    const auto size = described.at("cameras").at(0).find("size_px");
    if (size == described["cameras"][0].end()) return;
    input.image_width = size->at(0).get<int>();
    input.image_height = size->at(1).get<int>();
  } catch (const nlohmann::json::exception&) {
    if (input.data_path.empty())
      throw Error("does not name the recording of the run", file.string(), "run `rastro track` again");
  }
}

}  // namespace

TrackRunInput read_run_input(const fs::path& run) {
  TrackRunInput input;
  std::error_code ignored;
  const fs::path folder = fs::is_directory(run, ignored) ? run : run.parent_path();
  if (fs::is_regular_file(folder / "about.json", ignored)) read_about(folder / "about.json", input);
  if (fs::is_regular_file(folder / "options.yaml", ignored)) {
    OptionTable table = option_table(input.options);
    table.load_yaml(folder / "options.yaml");
  }
  return input;
}

}  // namespace rastro::cli
