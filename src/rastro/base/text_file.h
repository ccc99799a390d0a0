// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rastro {

/// Reads the whole file. Error (naming it) if it does not exist, is a folder, cannot be read, or is empty.
std::string read_text_file(const std::string& path);

/// One line of a text file with its number, from 1.
struct TextLine {
  int number = 0;
  std::string_view text;  ///< Trimmed; points into the original text.
};

/// The lines with content: neither blank nor a comment starting with '#'.
std::vector<TextLine> content_lines(std::string_view text);

/// "file:12", for messages.
std::string at_line(std::string_view where, int line);

}  // namespace rastro
