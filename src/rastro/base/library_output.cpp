// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/library_output.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace rastro {
namespace {

thread_local std::string* collected_text = nullptr;

#ifdef __GLIBC__
ssize_t write_or_collect(void*, const char* text, std::size_t size) {
  if (!collected_text) return std::max<ssize_t>(0, ::write(STDERR_FILENO, text, size));
  constexpr std::size_t most = 4096;  // A damaged image may bring a line per row.
  if (collected_text->size() < most) collected_text->append(text, size);
  return static_cast<ssize_t>(size);
}
#endif

}  // namespace

LibraryOutput::LibraryOutput() : outer_(collected_text) { collected_text = &text_; }
LibraryOutput::~LibraryOutput() { collected_text = outer_; }

void divert_library_output() {
#ifdef __GLIBC__  // whose stderr may be set like any variable
  cookie_io_functions_t functions{};
  functions.write = write_or_collect;
  std::FILE* const stream = fopencookie(nullptr, "w", functions);
  if (!stream) return;
  std::setvbuf(stream, nullptr, _IONBF, 0);
  stderr = stream;
#endif
}

}  // namespace rastro
