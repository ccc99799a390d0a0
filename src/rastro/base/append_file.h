// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace rastro {

/// A file that grows by whole pieces. Each append() is one write to the system without buffering, so a program killed
/// at any moment leaves all pieces appended so far. Throws Error naming the file on failure (disk full, no permission).
class AppendFile {
 public:
  enum class Former { dropped, kept };
  /// Creates the file; drops the content of an existing one, or keeps it and appends.
  explicit AppendFile(std::filesystem::path path, Former former = Former::dropped);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  void append(std::string_view piece);
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// Replaces a small file atomically: readers see the old one or the new one, never a part, and a failed write leaves
/// the old one alone. A device, a pipe or what a link leads to is written as it stands instead; a pipe that nobody
/// reads is an Error.
void write_whole_file(const std::filesystem::path& path, std::string_view text);

/// The same for a large file that is made in pieces: make(put) calls put(piece) with one after the other.
using PutPiece = std::function<void(std::string_view)>;
void write_whole_file(const std::filesystem::path& path, const std::function<void(const PutPiece&)>& make);

/// The text of a file; Error when it cannot be read.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace rastro
