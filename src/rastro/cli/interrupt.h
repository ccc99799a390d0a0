// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

namespace rastro::cli {

/// From here on Ctrl-C (SIGINT), SIGTERM and SIGHUP set the flag returned instead of ending the program. The second of
/// them changes nothing: the command is saving its results. The third ends the program.
const std::atomic<bool>& catch_interrupts();

/// How many of these signals came.
int interrupt_signals();

/// As the first of these signals, for a person who asks for the end elsewhere.
void interrupt();

/// Thrown by stop_if_interrupted() to leave the loop of a writer, whose files are complete up to there.
struct Interrupted {};

/// Throws Interrupted where the flag of catch_interrupts() is set.
void stop_if_interrupted();

/// After catch_interrupts(): returns when one of these signals came.
void wait_for_interrupt();

}  // namespace rastro::cli
