#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "firmware/stm8s103/registers.h"

// RS-485 line: UART1 with 115200 baud, 8N1, on PD5 (sent) and PD6 (received); PD4 is high while the
// transceiver drives the line.

void line_start(void);
/// False where nothing has come.
bool line_take(uint8_t* byte);
bool line_is_sending(void);
/// Sends kEncoderNodeReplySize bytes and returns at once. @pre not sending
void line_send(const uint8_t* reply);

// sdcc makes the vectors from what it sees in the file of main().
void line_sent(void) __interrupt(kVectorUartSent);
void line_received(void) __interrupt(kVectorUartReceived);
