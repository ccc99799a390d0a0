// SPDX-License-Identifier: Apache-2.0
// Vocabularies of places: own form and the text forms of DBoW2 and DBoW3. Own bytes are also tried with the checksum
// put right, as no mutation gets past it.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/base/hash.h"
#include "rastro/place/vocabulary.h"

namespace {

void try_bytes(std::string_view bytes) {
  try {
    const auto vocabulary = rastro::Vocabulary::parse(bytes, "vocabulary");
    if (vocabulary.words() == 0 || vocabulary.words() > vocabulary.nodes()) __builtin_trap();
    std::vector<rastro::Descriptor> descriptors(3);
    descriptors[1].words.fill(~std::uint64_t{0});
    descriptors[2].words[0] = 0x5555;
    for (const auto& [word, share] : vocabulary.words_of(descriptors, 1).words)
      if (word >= vocabulary.words() || !(share >= 0.0F && share <= 1.0F)) __builtin_trap();
    const std::string own = vocabulary.bytes();
    if (rastro::Vocabulary::parse(own, "own").bytes() != own) __builtin_trap();
  } catch (const rastro::Error& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) __builtin_trap();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string bytes(reinterpret_cast<const char*>(data), size);
  try_bytes(bytes);
  if (size > 4 && bytes.starts_with("RASTROVOC")) {
    rastro::Sha256 hash;
    hash.add(std::string_view(bytes).substr(0, size - 4));
    const auto sum = static_cast<std::uint32_t>(std::stoul(hash.finish().substr(0, 8), nullptr, 16));
    std::memcpy(bytes.data() + size - 4, &sum, 4);
    try_bytes(bytes);
  }
  return 0;
}
