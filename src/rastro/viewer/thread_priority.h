// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

namespace rastro::detail {

/// The run comes first where cores are few. Where the system refuses, all threads are equal.
void lower_priority_of_this_thread();

}  // namespace rastro::detail
