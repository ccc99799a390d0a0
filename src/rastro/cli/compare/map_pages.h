// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rastro/cli/compare/report_tables.h"

namespace rastro::cli {

/// Where the map of a run has a page that opens in a browser without a server; in `out`, the folder of the reports.
std::filesystem::path map_page_of(const FinishedRun& run, const std::filesystem::path& out);

/// Writes these pages for the maps that the report shows, as `rastro export --to html` does. A map that cannot be read
/// has none.
void write_map_pages(const Report& report, const std::filesystem::path& out);

}  // namespace rastro::cli
