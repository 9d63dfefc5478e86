#include "sinew/io/interrupt.h"

#include <array>
#include <csignal>

namespace sinew::io {
namespace {

volatile std::sig_atomic_t count = 0;
volatile std::sig_atomic_t status_count = 0;

extern "C" void note_interrupt(int) {
  count = count + 1;
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
