// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/regular_file.h"

#include <fmt/format.h>

#include <system_error>

#include "rastro/base/error.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

const char* kind_of(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "is a folder, not a file";
    case fs::file_type::fifo:
      return "is a FIFO (named pipe), not a regular file";
    case fs::file_type::socket:
      return "is a socket, not a regular file";
    case fs::file_type::block:
    case fs::file_type::character:
      return "is a device, not a regular file";
    default:
      return "is not a regular file";
  }
}

}  // namespace

void require_regular_file(const fs::path& path, std::uintmax_t largest_bytes) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (status.type() == fs::file_type::not_found) throw Error("no such file", path.string(), "check the path");
  if (code == std::errc::permission_denied) throw Error("no permission to read it", path.string(), "");
  if (code) throw Error("cannot be read (" + code.message() + ")", path.string(), "");
  if (!fs::is_regular_file(status))
    throw Error(kind_of(status.type()), path.string(), fs::is_directory(status) ? "" : "copy its data to a file");
  const std::uintmax_t bytes = fs::file_size(path, code);
  if (!code && bytes > largest_bytes)
    throw Error(
        fmt::format("has {} MiB, too much for a file of its kind (at most {} MiB)", bytes >> 20, largest_bytes >> 20),
        path.string(), "is it the right file?");
}

}  // namespace rastro
