#include <cstdint>

#include "firmware/stm32/registers.h"

// Begin and end of what the linker script lays out.
extern "C" {
extern std::uint32_t stack_top, data_begin, data_end, data_stored, bss_begin, bss_end;
using Constructor = void (*)();
extern Constructor init_begin, init_end;

void external_interrupt_4();
void external_interrupts_15_to_10();
void supply_low();
void timer_4();
void usart_2();
[[noreturn]] int main();
[[noreturn]] void reset();
}

namespace {

/// An unexpected interrupt, or a fault of the processor. Timers would go on with the
/// pulses that they made last.
[[noreturn]] void unexpected() {
  sinew::stm32::restart();
}

}  // namespace

void reset() {
  const std::uint32_t* stored = &data_stored;
  for (std::uint32_t* word = &data_begin; word != &data_end; ++word) *word = *stored++;
  for (std::uint32_t* word = &bss_begin; word != &bss_end; ++word) *word = 0;
  for (Constructor* construct = &init_begin; construct != &init_end; ++construct) (*construct)();
  main();
}

namespace {

using Vector = void (*)();
struct Vectors {
  std::uint32_t* stack;
  Vector core[15];
  Vector lines[68];
};

constexpr Vectors make_vectors() {
  Vectors vectors{&stack_top, {}, {}};
  for (Vector& vector : vectors.core) vector = unexpected;
  for (Vector& vector : vectors.lines) vector = unexpected;
  vectors.core[0] = reset;
  using sinew::stm32::Line;
  vectors.lines[static_cast<int>(Line::kSupply)] = supply_low;
  vectors.lines[static_cast<int>(Line::kExti4)] = external_interrupt_4;
  vectors.lines[static_cast<int>(Line::kTim4)] = timer_4;
  vectors.lines[static_cast<int>(Line::kUsart2)] = usart_2;
  vectors.lines[static_cast<int>(Line::kExti15To10)] = external_interrupts_15_to_10;
  return vectors;
}

[[gnu::used, gnu::section(".vectors")]] constinit const Vectors vectors = make_vectors();

}  // namespace
