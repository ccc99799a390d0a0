// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/program.h"

int main(int argc, char** argv) { return rastro::cli::run_program(argc, argv); }
