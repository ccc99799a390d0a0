// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/program.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Tracking frees what mapping's thread allocated and the other way round: with an arena for each thread the holes
  // grow by 3 MB in 1000 frames of one place.
  ::mallopt(M_ARENA_MAX, 2);
  // Images and depth are made and freed with each frame: mapped anew each time, the system zeroes their pages each
  // time. Twice as fast with the memory kept, up to this much of it.
  constexpr int kept_bytes = 64 << 20, mapped_from_bytes = 32 << 20;
  ::mallopt(M_TRIM_THRESHOLD, kept_bytes);
  ::mallopt(M_MMAP_THRESHOLD, mapped_from_bytes);
#endif
  return rastro::cli::run_program(argc, argv);
}
