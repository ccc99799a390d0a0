// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace rastro {

/// Which landmark each one was fused into: of the last fused ones, `least` to twice as many, in memory that does not
/// grow.
class FusedLandmarks {
 public:
  explicit FusedLandmarks(std::size_t least) : least_(least) {}
  void add(std::int64_t gone, std::int64_t kept);
  /// -1: not fused, or too long ago.
  std::int64_t kept_of(std::int64_t gone) const;

 private:
  using Fused = std::pair<std::int64_t, std::int64_t>;  ///< (gone, kept)
  static const Fused* find(const std::vector<Fused>& fused, std::int64_t gone);

  std::size_t least_;
  std::vector<Fused> latest_, before_;  ///< By the landmark gone.
};

}  // namespace rastro
