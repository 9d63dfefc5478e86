#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>

#include "firmware/atmega2560/own_image.h"
#include "firmware/atmega2560/pins.h"
#include "firmware/atmega2560/serial_port.h"
#include "firmware/atmega2560/stack_watch.h"
#include "sinew/mcu/arm_board.h"
#include "sinew/mcu/blink_code.h"
#include "sinew/mcu/interrupts.h"

// The BigRobotArm's controller on an ATmega2560: what the simulator runs, with pins instead of
// physics. Timer 1 makes the ticks, timer 5 the slices between them, timer 3 the servo's pulse.

namespace sinew {
namespace atmega {
namespace {

// Left alone by a restart, and filled with anything by power-up.
__attribute__((section(".noinit"))) mcu::KeptPositions kept;
__attribute__((section(".noinit"))) uint8_t reset_cause;

mcu::ArmBoardFacts facts = {{{3200, 200}, {400, 100}, {3200, 100}, {3200, 100}, {3200, 100}}, {}};
mcu::ArmBoard board(facts, kept);
SerialPort port;
volatile uint32_t slices = 0;
volatile uint16_t servo_us = 0;
volatile bool slicing = false;
constexpr uint8_t kBytesAtOnce = 16;
uint8_t steps_due = 0;

uint32_t now_ms() {
  const mcu::InterruptsOff off;
  return slices;
}

void start_timers() {
  const uint16_t servo_period = 40000;  // 20 ms, a count each 0.5 us
  ICR3 = servo_period;
  OCR3C = static_cast<uint16_t>(2 * servo_us);
  TCCR3A = _BV(COM3C1) | _BV(WGM31);
  TCCR3B = _BV(WGM33) | _BV(WGM32) | _BV(CS31);
  // Its interrupt is on only while a slice is due; then it comes at the timer's next turn.
  OCR5A = 128;
  TCCR5B = _BV(WGM52) | _BV(CS50);
  // Free running, a count each 0.5 us: for how long the main loop takes.
  TCCR4B = _BV(CS41);
  OCR1A = F_CPU / (1000UL * mcu::StepPulses::kTicks) - 1;
  TCCR1B = _BV(WGM12) | _BV(CS10);
  TIMSK1 = _BV(OCIE1A);
}

void send_replies() {
  mcu::ReplyBuffer& replies = board.replies();
  while (!replies.empty() && port.has_room()) port.put(replies.take());
}

/// A second on, a second off; or as many flashes as its fault's number.
void show(uint32_t now) {
  const uint8_t fault = static_cast<uint8_t>(board.fault());
  set_led(fault > 0 ? mcu::is_lit(now, fault) : (now >> 10 & 1) != 0);
}

[[noreturn]] void run() {
  mcu::ArmBoardHealth health = {};
  health.reset_cause = reset_cause;
  uint32_t seen = now_ms();
  uint32_t begun_ms = seen;
  uint16_t began = TCNT4;
  for (;;) {
    // Some at a time: a host that never stops does not keep the loop from its other work.
    for (uint8_t left = kBytesAtOnce; left > 0 && port.has_input() && board.takes(); --left) {
      board.receive(port.take(), now_ms());
    }
    const uint32_t now = now_ms();
    board.poll(now);
    send_replies();
    // A slice that does not come is as bad as a loop that hangs.
    if (now != seen) {
      wdt_reset();
      show(now);
    }
    seen = now;
    health.stack_free = unused_stack();
    health.bytes_lost = port.bytes_lost();
    // The timer turns in 33 ms.
    const uint32_t round_ms = now - begun_ms;
    const uint16_t ended = TCNT4;
    uint16_t took = static_cast<uint16_t>(static_cast<uint16_t>(ended - began) / 2);
    if (round_ms > 30) took = round_ms > 60 ? 60000 : static_cast<uint16_t>(round_ms * 1000);
    began = ended;
    begun_ms = now;
    if (took > health.loop_us_max) health.loop_us_max = took;
    board.set_health(health);
    const uint16_t us = board.gripper_us();
    if (us != servo_us) {
      const mcu::InterruptsOff off;
      servo_us = us;
      OCR3C = static_cast<uint16_t>(2 * us);
    }
  }
}

}  // namespace
}  // namespace atmega
}  // namespace sinew

using namespace sinew;
using namespace sinew::atmega;

/// Before memory is cleared: a watchdog that bit is still on.
extern "C" __attribute__((naked, used, section(".init3"))) void read_reset_cause() {
  reset_cause = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

ISR(TIMER1_COMPA_vect) {
  // Those of the tick before, so that pulses begin at the same place of each tick.
  raise_steps(steps_due);
  steps_due = board.pulses().tick();
  if (board.pulses().slice_began()) {
    set_directions(board.pulses().backwards());
    TIMSK5 = _BV(OCIE5A);
  }
  lower_steps();
}

/// Planning the next slice takes longer than a tick: ticks break into it.
ISR(TIMER5_COMPA_vect) {
  TIMSK5 = 0;
  slices = slices + 1;
  // One that takes longer than its time is not begun in itself; the pulses count it as late.
  if (slicing) return;
  slicing = true;
  sei();
  board.slice(stop_line_low());
  cli();
  slicing = false;
}

ISR(USART0_RX_vect) {
  port.on_received();
}

ISR(USART0_UDRE_vect) {
  port.on_ready();
}

int main() {
  start_pins();
  read_own_identity(facts.identity);
  servo_us = board.gripper_us();
  set_directions(0);
  port.start();
  start_timers();
  wdt_enable(WDTO_120MS);
  sei();
  run();
}
