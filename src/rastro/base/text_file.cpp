// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/text_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/base/regular_file.h"
#include "rastro/base/text.h"

namespace rastro {
namespace {

std::string why_not_opened(int error) {
  if (error == EACCES || error == EPERM) return "no permission to read it";
  return fmt::format("cannot be opened ({})", std::strerror(error));
}

}  // namespace

std::string read_text_file(const std::string& path) {
  require_regular_file(path, largest_text_file_bytes);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw Error(why_not_opened(errno), path, "");
  std::string text;
  char block[1 << 16];
  while (const std::size_t count = std::fread(block, 1, sizeof(block), file.get())) text.append(block, count);
  if (std::ferror(file.get())) throw Error("cannot be read to its end", path, "");
  if (text.empty()) throw Error("is empty", path, "");
  return text;
}

std::vector<TextLine> content_lines(std::string_view text) {
  std::vector<TextLine> lines;
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const auto end = std::min(text.find('\n', begin), text.size());
    ++number;
    const auto line = trim(text.substr(begin, end - begin));
    if (!line.empty() && line.front() != '#') lines.push_back({number, line});
    begin = end + 1;
  }
  return lines;
}

std::string at_line(std::string_view where, int line) { return fmt::format("{}:{}", where, line); }

}  // namespace rastro
