#include "sinew/io/interrupt.h"

#include <array>
#include <csignal>

namespace sinew::io {
namespace {

volatile std::sig_atomic_t count = 0;
volatile std::sig_atomic_t status_count = 0;

volatile std::sig_atomic_t last = 0;

/// `timeout` and service managers may send the same signal to a process and to its group: a second
/// SIGTERM is no second wish. A second Ctrl-C is one.
extern "C" void note_interrupt(int signal) {
  if (signal != last || signal == SIGINT) count = count + 1;
  last = signal;
}

extern "C" void note_status_request(int) {
  status_count = status_count + 1;
}

}  // namespace

void catch_interrupts() {
  struct sigaction action{};
  action.sa_handler = note_interrupt;
  sigemptyset(&action.sa_mask);
  for (const int signal : std::array{SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  action.sa_handler = note_status_request;
  sigaction(SIGUSR1, &action, nullptr);
}

int interrupts() {
  return count;
}

int status_requests() {
  return status_count;
}

}  // namespace sinew::io
