// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace rastro {

/// The lines of a text file, plain or packed by gzip, one at a time in constant memory.
class LogLines {
 public:
  /// Error where the file cannot be opened.
  explicit LogLines(const std::string& path);
  ~LogLines();
  LogLines(LogLines&&) noexcept;
  LogLines& operator=(LogLines&&) noexcept;

  /// The next line without its end, valid until the next call; nullopt at the end. Error for a line of more than 4 MiB:
  /// that is no text. Lines with control characters are skipped and counted. What follows the last newline of a damaged
  /// packed file is a part of a line and is omitted.
  std::optional<std::string_view> next();
  /// Of the line that next() gave last, from 1.
  std::int64_t number() const;
  /// Whether the packed data broke off or is damaged; known when next() has given nullopt.
  bool damaged() const;
  /// How many lines were skipped so far, and the number of the first of them.
  std::int64_t skipped() const;
  std::int64_t first_skipped() const;

 private:
  std::optional<std::string_view> any_line();
  struct State;
  std::unique_ptr<State> state_;
};

/// The first 64 KiB of text in a file, plain or packed, without a byte order mark; empty where it cannot be read or
/// more than one byte in a hundred is no text.
std::string text_at_front(const std::string& path);

}  // namespace rastro
