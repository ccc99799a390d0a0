// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace rastro {

/// Whether a sanitizer replaces the allocator, so that what is freed does not go back to the system. GCC defines a
/// macro, clang has a feature.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitizes_memory = true;
#elif defined(__has_feature)
inline constexpr bool sanitizes_memory = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool sanitizes_memory = false;
#endif

}  // namespace rastro
