// SPDX-License-Identifier: Apache-2.0
// The assembler copies the page's bytes into the object: a megabyte as an array of numbers would take the compiler
// seconds, and this holds for every compiler and machine that rastro builds on.
#include "rastro/viewer/page.h"

#ifndef RASTRO_VIEWER_PAGE
#error "CMakeLists.txt defines RASTRO_VIEWER_PAGE as the page's path"
#endif

__asm__(
    ".section .rodata\n"
    ".globl rastro_viewer_page_begin\n"
    ".globl rastro_viewer_page_end\n"
    "rastro_viewer_page_begin:\n"
    ".incbin \"" RASTRO_VIEWER_PAGE
    "\"\n"
    "rastro_viewer_page_end:\n"
    ".byte 0\n"
    ".previous\n");

extern "C" {
extern const char rastro_viewer_page_begin[];
extern const char rastro_viewer_page_end[];
}

namespace rastro {

std::string_view viewer_page() {
  return {rastro_viewer_page_begin, static_cast<std::size_t>(rastro_viewer_page_end - rastro_viewer_page_begin)};
}

}  // namespace rastro
