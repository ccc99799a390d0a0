// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/map_pages.h"

#include <fmt/format.h>

#include <exception>

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
  std::error_code ignored;
  fs::remove(page, ignored);  // of an earlier comparison
  if (!fs::exists(run / "map.rastro", ignored)) return;
  // Whatever is wrong with one map, the report is written.
  try {
    export_html({settings, read_export_input(run.string()), pool, {}});
  } catch (const std::exception& error) {
    fs::remove(page, ignored);
    log_warning(fmt::format("no page of the map in {}: {}", run.string(), error.what()));
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
      write_page(pictured.run->folder, map_page_of(*pictured.run, out), pool);
}

}  // namespace rastro::cli
