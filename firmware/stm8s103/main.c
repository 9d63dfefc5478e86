#include <stddef.h>

#include "firmware/stm8s103/i2c_master.h"
#include "firmware/stm8s103/registers.h"
#include "firmware/stm8s103/serial_line.h"
#include "sinew/mcu/as5600.h"
#include "sinew/mcu/encoder_node.h"

// Encoder node on an STM8S103F3 (docs/firmware/encoder_node.md): one reading of the AS5600 each
// millisecond, answers in between.

enum {
  kLamp = 1 << 3,  // of port A; low is lit
  kLampHalf = 250  // ms
};

static volatile uint8_t ticks;  // ms, wraps
static EncoderNode node;

void count_tick(void) __interrupt(kVectorTick) {
  TIM4_SR = 0;
  ++ticks;
}

static void start_pins_and_clock(void) {
  CLK_CKDIVR = 0;  // the internal oscillator undivided: 16 MHz
  PA_ODR |= kLamp;
  PA_CR1 |= kLamp;
  PA_DDR |= kLamp;
  // Pins without a purpose: pull-ups. PD1 (SWIM) has one.
  PA_CR1 |= 0x06;
  PC_CR1 |= 0xF8;
  PD_CR1 |= 0x0C;
  TIM4_PSCR = 6;  // 16 MHz / 64
  TIM4_ARR = 249;
  TIM4_EGR = 1;  // takes the prescaler over
  TIM4_SR = 0;
  TIM4_IER = 1;
  TIM4_CR1 = 1;
}

/// 64 ms of an oscillator of 128 kHz, 56 to 74 ms over its tolerance of 110 to 146 kHz:
/// RM0016 14.2.
static void start_watchdog(void) {
  IWDG_KR = 0xCC;
  IWDG_KR = 0x55;
  IWDG_PR = 2;
  IWDG_RLR = 0xFF;
  IWDG_KR = 0xAA;
}

static void answer_requests(void) {
  uint8_t byte;
  uint8_t reply[kEncoderNodeReplySize];
  while (!line_is_sending() && line_take(&byte)) {
    if (encoder_node_receive(&node, byte, reply)) line_send(reply);
  }
}

/// Lit while there is a position, else two flashes a second.
static void show(uint8_t elapsed) {
  static uint16_t phase;  // ms
  phase += elapsed;
  if (phase >= 2 * kLampHalf) phase -= 2 * kLampHalf;
  if (node.state != kEncoderBlind || phase < kLampHalf) {
    PA_ODR &= (uint8_t)~kLamp;
  } else {
    PA_ODR |= kLamp;
  }
}

void main(void) {
  uint8_t chip[kAs5600Size];
  uint8_t seen = 0;
  start_pins_and_clock();
  start_watchdog();
  line_start();
  i2c_start();
  encoder_node_start(&node);
  __asm__("rim");
  for (;;) {
    uint8_t elapsed;
    answer_requests();
    elapsed = (uint8_t)(ticks - seen);
    if (elapsed == 0) continue;
    seen += elapsed;
    encoder_node_sample(&node, i2c_read(kAs5600Address, kAs5600First, chip) ? chip : NULL, elapsed);
    show(elapsed);
    IWDG_KR = 0xAA;
  }
}
