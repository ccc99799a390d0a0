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
#endif
  return rastro::cli::run_program(argc, argv);
}
