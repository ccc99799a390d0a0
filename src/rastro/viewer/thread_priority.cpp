// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/thread_priority.h"

#include <sys/resource.h>
#include <unistd.h>

namespace rastro::detail {

void lower_priority_of_this_thread() {
  constexpr int nice = 10;
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), nice);
}

}  // namespace rastro::detail
