#include "sinew/io/interrupt.h"

#include <array>
#include <csignal>

namespace sinew::io {
namespace {

volatile std::sig_atomic_t count = 0;

extern "C" void note_interrupt(int) {
  count = count + 1;
}

}  // namespace

void catch_interrupts() {
  struct sigaction action{};
  action.sa_handler = note_interrupt;
  sigemptyset(&action.sa_mask);
  for (const int signal : std::array{SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

int interrupts() {
  return count;
}

}  // namespace sinew::io
