#include "firmware/stm8s103/serial_line.h"

#include "sinew/mcu/encoder_node.h"

enum {
  kDriver = 1 << 4,  // of port D
  kSent = 1 << 5,
  kIncoming = 1 << 6,
  // CR2
  kReceiverOn = 1 << 2,
  kTransmitterOn = 1 << 3,
  kReceivedInterrupt = 1 << 5,
  kSentInterrupt = 1 << 6,
  kRoom = 16,  // a power of two
};

static volatile uint8_t received[kRoom];
static volatile uint8_t received_end;    // written by the interrupt only
static volatile uint8_t received_begin;  // written by the loop only
static volatile uint8_t reply[kEncoderNodeReplySize];
static volatile uint8_t unsent;  // bytes of `reply`

void line_start(void) {
  // High while the transmitter is off: the line's idle level. The transceiver leaves PD6 open while
  // it drives the line, so that needs its pull-up.
  PD_ODR = (PD_ODR | kSent) & (uint8_t)~kDriver;
  PD_CR1 |= kDriver | kSent | kIncoming;
  PD_DDR |= kDriver | kSent;
  // 16 MHz / 139 = 115108 baud. BRR2 first: BRR1 takes both over (RM0016 22.7.3).
  UART1_BRR2 = 0x0B;
  UART1_BRR1 = 0x08;
  UART1_CR2 = kTransmitterOn | kReceiverOn | kReceivedInterrupt;
}

bool line_take(uint8_t* byte) {
  if (received_begin == received_end) return false;
  *byte = received[received_begin];
  received_begin = (uint8_t)(received_begin + 1) & (kRoom - 1);
  return true;
}

bool line_is_sending(void) {
  return (PD_ODR & kDriver) != 0;
}

void line_send(const uint8_t* bytes) {
  uint8_t i;
  for (i = 0; i < kEncoderNodeReplySize; ++i) reply[i] = bytes[i];
  unsent = kEncoderNodeReplySize;
  PD_ODR |= kDriver;
  // Turning the transmitter on sends an idle frame (RM0016 22.3.2): who asked has a byte's time to
  // release the line.
  UART1_CR2 &= (uint8_t)~kTransmitterOn;
  UART1_CR2 |= kTransmitterOn;
  UART1_CR2 |= kSentInterrupt;
}

/// Transmission complete: at the beginning, and behind the stop bit of each byte.
void line_sent(void) __interrupt(kVectorUartSent) {
  (void)UART1_SR;  // this and the write to DR take the flag back
  if (unsent != 0) {
    UART1_DR = reply[kEncoderNodeReplySize - unsent];
    --unsent;
    return;
  }
  UART1_CR2 &= (uint8_t)~kSentInterrupt;
  (void)UART1_DR;  // the echo of the last byte, where there is one
  PD_ODR &= (uint8_t)~kDriver;
}

void line_received(void) __interrupt(kVectorUartReceived) {
  const uint8_t end = received_end;
  const uint8_t next = (uint8_t)(end + 1) & (kRoom - 1);
  uint8_t byte;
  (void)UART1_SR;  // before DR: an overrun is taken back with it
  byte = UART1_DR;
  if ((PD_ODR & kDriver) || next == received_begin) return;
  received[end] = byte;
  received_end = next;
}
