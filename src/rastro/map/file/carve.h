// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace rastro {

/// Finds rows in the pages of a map file, and of the log beside it, without SQLite: page by page, by the format of its
/// table leaves (https://www.sqlite.org/fileformat2.html, sections 1.6 and 2.1). Passes on only rows of the `tables`
/// with a valid checksum; of a row found twice, the later one is passed on last. Error where the file cannot be read.
void carve_rows(const std::filesystem::path& file, const std::vector<std::string>& tables,
                const std::function<void(const std::string& table, std::int64_t id, const std::string& body)>& found);

}  // namespace rastro
