// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <string_view>

#include "rastro/place/vocabulary.h"

// The file's bytes in the read-only data of the program: a literal of this size would take compilers minutes.
__asm__(
    ".pushsection .rodata\n"
    ".balign 64\n"
    ".hidden rastro_standard_vocabulary\n"
    ".globl rastro_standard_vocabulary\n"
    "rastro_standard_vocabulary:\n"
    ".incbin \"" RASTRO_VOCABULARY_FILE
    "\"\n"
    ".hidden rastro_standard_vocabulary_end\n"
    ".globl rastro_standard_vocabulary_end\n"
    "rastro_standard_vocabulary_end:\n"
    ".byte 0\n"
    ".popsection\n");

extern "C" const char rastro_standard_vocabulary[], rastro_standard_vocabulary_end[];

namespace rastro {

std::shared_ptr<const Vocabulary> standard_vocabulary() {
  static const auto vocabulary = std::make_shared<const Vocabulary>(
      Vocabulary::parse({rastro_standard_vocabulary,
                         static_cast<std::size_t>(rastro_standard_vocabulary_end - rastro_standard_vocabulary)},
                        "the built-in vocabulary"));
  return vocabulary;
}

}  // namespace rastro
