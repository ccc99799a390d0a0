// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <string>

namespace rastro::detail {

static_assert(std::endian::native == std::endian::little, "binary exports are written little-endian");

template <typename Value>
void append_raw(std::string& bytes, const Value& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline void append_raw(std::string& bytes, const Eigen::Vector3f& vector) {
  bytes.append(reinterpret_cast<const char*>(vector.data()), 3 * sizeof(float));
}

}  // namespace rastro::detail
