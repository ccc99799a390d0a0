// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/interrupt.h"

#include <semaphore.h>

#include <cerrno>
#include <csignal>

namespace rastro::cli {
namespace {

constexpr int patience = 3;  ///< The signal that ends the program.

std::atomic<bool> interrupted = false;
std::atomic<int> signals = 0;
sem_t interrupts;  // of the few things that a signal handler may touch
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler may only touch lock-free atomics");

extern "C" void note_interrupt(int signal) {
  interrupted.store(true);
  sem_post(&interrupts);
  if (signals.fetch_add(1) + 1 < patience) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

bool is_ignored(int signal) {
  struct sigaction now {};
  return sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

int install_handlers() {
  sem_init(&interrupts, 0, 0);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    // 'nohup rastro ...' is not to be interrupted.
    if (signal != SIGHUP || !is_ignored(signal)) std::signal(signal, note_interrupt);
  // Whoever reads what is printed may be gone ('rastro ... | tee log' and Ctrl-C); the results are written all the
  // same.
  std::signal(SIGPIPE, SIG_IGN);
  return 0;
}

}  // namespace

const std::atomic<bool>& catch_interrupts() {
  [[maybe_unused]] static const int once = install_handlers();
  return interrupted;
}

int interrupt_signals() { return signals.load(); }

void interrupt() {
  interrupted.store(true);
  sem_post(&interrupts);
}

void stop_if_interrupted() {
  if (interrupted.load()) throw Interrupted{};
}

void wait_for_interrupt() {
  while (sem_wait(&interrupts) != 0 && errno == EINTR && !interrupted.load()) {
  }
}

}  // namespace rastro::cli
