#include "virtual_clock.h"

#include "Arduino.h"

namespace sinew::arduino {
namespace {

Instant g_now{};
Instant g_start{};
std::uint32_t g_start_millis = 0;

}  // namespace

Instant now() {
  return g_now;
}

void pass(Duration time) {
  g_now += time;
}

void set_clock(Instant now, std::uint32_t millis_now) {
  g_now = now;
  g_start = now;
  g_start_millis = millis_now;
}

}  // namespace sinew::arduino

unsigned long millis() {
  using namespace sinew::arduino;
  const auto passed = std::chrono::duration_cast<std::chrono::milliseconds>(g_now - g_start);
  return g_start_millis + static_cast<std::uint32_t>(passed.count());
}

void delay(unsigned long time_ms) {
  sinew::arduino::pass(std::chrono::milliseconds(time_ms));
}
