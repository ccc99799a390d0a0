// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/hash.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <iterator>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {

struct Sha256::Context {
  EVP_MD_CTX* handle = EVP_MD_CTX_new();
  ~Context() { EVP_MD_CTX_free(handle); }
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  RASTRO_CHECK(EVP_DigestInit_ex(context_->handle, EVP_sha256(), nullptr) == 1, "libcrypto has SHA-256");
}

Sha256::~Sha256() = default;

void Sha256::add(std::string_view bytes) {
  RASTRO_CHECK(!finished_, "nothing is added to a finished digest");
  EVP_DigestUpdate(context_->handle, bytes.data(), bytes.size());
}

std::string Sha256::finish() {
  std::array<unsigned char, 32> digest{};
  RASTRO_CHECK(!std::exchange(finished_, true), "a digest is finished once");
  RASTRO_CHECK(EVP_DigestFinal_ex(context_->handle, digest.data(), nullptr) == 1, "libcrypto gives a digest");
  std::string text;
  for (const unsigned char byte : digest) fmt::format_to(std::back_inserter(text), "{:02x}", byte);
  return text;
}

}  // namespace rastro
