// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/append_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/regular_file.h"

namespace rastro {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view verb, int code) {
  throw Error(fmt::format("cannot be {} ({})", verb, std::generic_category().message(code)), path.string(),
              "check the path, the permissions and the space left");
}

/// A device, a pipe or a link (such as /dev/stdout): a new file must not take its place.
bool is_written_through(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::symlink_status(path, ignored);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

}  // namespace

AppendFile::AppendFile(std::filesystem::path path, Former former) : path_(std::move(path)) {
  const int emptied = former == Former::dropped ? O_TRUNC : 0;
  // O_NONBLOCK: a pipe that nobody reads is an error, not a wait without end.
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | emptied | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644);
  if (descriptor_ < 0) fail(path_, "created", errno);
  ::fcntl(descriptor_, F_SETFL, ::fcntl(descriptor_, F_GETFL) & ~O_NONBLOCK);
}

AppendFile::~AppendFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void AppendFile::append(std::string_view piece) {
  while (!piece.empty()) {
    const ssize_t written = ::write(descriptor_, piece.data(), piece.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_, "written", errno);
    piece.remove_prefix(static_cast<std::size_t>(written));
  }
}

void write_whole_file(const std::filesystem::path& path, std::string_view text) {
  write_whole_file(path, [text](const PutPiece& put) { put(text); });
}

void write_whole_file(const std::filesystem::path& path, const std::function<void(const PutPiece&)>& make) {
  const auto write = [&make](const std::filesystem::path& to) {
    AppendFile file(to);
    make([&file](std::string_view piece) { file.append(piece); });
  };
  if (is_written_through(path)) return write(path);
  std::filesystem::path partial = path;
  partial += ".partial";
  std::error_code code, ignored;
  try {
    write(partial);
    std::filesystem::rename(partial, path, code);
    if (code) fail(path, "put in place", code.value());
  } catch (...) {
    std::filesystem::remove(partial, ignored);
    throw;
  }
}

std::string read_whole_file(const std::filesystem::path& path) {
  require_regular_file(path, largest_whole_file_bytes);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) fail(path, "read", errno);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) fail(path, "read", EIO);
  return text;
}

}  // namespace rastro
