// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/map_pages.h"

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/task_pool.h"
#include "rastro/cli/compare/report_pictures.h"
#include "rastro/cli/export_formats.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

void write_page(const fs::path& run, const fs::path& page, TaskPool& pool) {
  constexpr std::int64_t most_points = 100'000;  // of each layer: some megabytes a page
  ExportSettings settings;
  settings.out = page.string();
  settings.scene.points = most_points;
  try {
    export_html({settings, read_export_input(run.string()), pool, {}});
  } catch (const Error& error) {
    log_warning(error.what());
  }
}

}  // namespace

fs::path map_page_of(const FinishedRun& run, const fs::path& out) {
  return out / "maps" / (run.folder.filename().string() + ".html");
}

void write_map_pages(const Report& report, const fs::path& out) {
  TaskPool pool(0);
  for (std::size_t input = 0; input < report.comparison.inputs.size(); ++input)
    for (const PicturedRun& pictured : pictured_runs(report, input))
      if (fs::exists(pictured.run->folder / "map.rastro"))
        write_page(pictured.run->folder, map_page_of(*pictured.run, out), pool);
}

}  // namespace rastro::cli
