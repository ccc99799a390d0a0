// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/cli/compare/report_tables.h"

namespace rastro::cli {

/// The whole report as one page that needs no network: advice, tables, curves, maps and pictures of failures, light or
/// dark as the reader's system is. `folder`: where it will lie; links to run folders are relative to it.
std::string report_as_html(const Report& report, const std::filesystem::path& folder);

/// A table with a class per column, for pages.
std::string html_table(const TextRows& rows);

}  // namespace rastro::cli
