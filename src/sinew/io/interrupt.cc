#include "sinew/io/interrupt.h"

#include <array>
#include <csignal>
#include <ctime>

namespace sinew::io {
namespace {

volatile std::sig_atomic_t count = 0;
volatile std::sig_atomic_t status_count = 0;

/// Ctrl-C in a shell, and `timeout`, may reach a process twice at once; only a second wish hurries.
constexpr long kTogether_ms = 300;

long milliseconds_now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);  // allowed in a signal handler
  return now.tv_sec * 1000 + now.tv_nsec / 1'000'000;
}

volatile long last_ms = 0;

extern "C" void note_interrupt(int signal) {
  const long now_ms = milliseconds_now();
  const bool again = count > 0;
  if (!again || (signal == SIGINT && now_ms - last_ms > kTogether_ms)) count = count + 1;
  last_ms = now_ms;
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
