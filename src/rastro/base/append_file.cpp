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

}  // namespace

AppendFile::AppendFile(std::filesystem::path path, Former former) : path_(std::move(path)) {
  const int emptied = former == Former::dropped ? O_TRUNC : 0;
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | emptied | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor_ < 0) fail(path_, "created", errno);
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
  std::filesystem::path partial = path;
  partial += ".partial";
  {
    AppendFile file(partial);
    make([&file](std::string_view piece) { file.append(piece); });
  }
  std::error_code code;
  std::filesystem::rename(partial, path, code);
  if (code) fail(path, "put in place", code.value());
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
