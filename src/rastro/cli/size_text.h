// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace rastro::cli {

/// Bytes from "600MB", "1.5 GB", "512MiB" or a plain number; kB, MB and GB count in thousands, KiB, MiB and GiB in
/// 1024. Error naming `flag` for anything else, with what was probably meant.
std::size_t parse_size(const std::string& text, const std::string& flag);

}  // namespace rastro::cli
