#pragma once

#include <stdbool.h>
#include <stdint.h>

// The encoder node: readings of an AS5600 in, answers on the encoder link out. C11, since the STM8
// has no C++ compiler; docs/wires/encoder_link.md has the bytes. No pins, no clock: its board reads
// the chip each millisecond and moves the bytes.

#ifdef __cplusplus
extern "C" {
#endif
// NOLINTBEGIN(modernize-use-using,performance-enum-size): this is C

enum {
  kEncoderNodeStale = 5,     // ms without a good reading until there is no position
  kEncoderNodeByteGap = 3,   // ms of silence that end a request; more than a byte at 9600 baud
  kEncoderNodeSettle = 128,  // good readings, eight times the memory of the filter
  kEncoderNodeReplySize = 5,
};

/// Bytes, registers and STATUS bits of the encoder link; encoder_wire.h says what they mean.
enum {
  kEncoderStart = 0xAA,
  kEncoderEnd = 0x55,
  kEncoderPosition = 1,
  kEncoderVelocity = 2,
  kEncoderAcceleration = 3,
  kEncoderStatus = 4,
  kEncoderFresh = 1 << 0,
  kEncoderMagnet = 1 << 1,
  kEncoderTooWeak = 1 << 2,
  kEncoderTooStrong = 1 << 3,
  kEncoderBusError = 1 << 4,
  kEncoderRestarted = 1 << 5,
  kEncoderHasSpeed = 1 << 6,
};

/// Position, speed and acceleration of a shaft from its 12-bit angle, one reading a millisecond.
///
/// A fading-memory filter of second order with theta = 15/16 (three equal poles): alpha 721/4096,
/// beta 93/8192, gamma/T^2 1/4096, in 32-bit whole numbers. It follows constant acceleration
/// without lag. Speed is 3 dB down at 17 Hz and acceleration at 5.5 Hz, their noise below
/// 10 ticks/s and 210 ticks/s^2 rms. Source: N. Morrison, Introduction to Sequential Smoothing and
/// Prediction, 1969, ch. 13.
typedef struct {
  uint32_t angle;        // 2^-20 ticks: a whole turn is 2^32, so that it wraps by itself
  int32_t speed;         // 2^-20 ticks/ms
  int32_t acceleration;  // 2^-20 ticks/ms^2
} ShaftFilter;

void shaft_filter_restart(ShaftFilter* filter, uint16_t position);
void shaft_filter_update(ShaftFilter* filter, uint16_t position);
/// A millisecond without a reading.
void shaft_filter_coast(ShaftFilter* filter);
int16_t shaft_filter_speed(const ShaftFilter* filter);         ///< ticks/s, within +-32767
int16_t shaft_filter_acceleration(const ShaftFilter* filter);  ///< ticks/s^2, within +-32767

/// kBlind: no position. kSettling: position only. kSettled: speed and acceleration too.
typedef enum { kEncoderBlind, kEncoderSettling, kEncoderSettled } EncoderNodeState;

///   state     | event                              | next; what registers 1..3 answer
///   ----------+------------------------------------+----------------------------------
///   kBlind    | good reading                       | kSettling; silence until then
///   kSettling | kEncoderNodeSettle good readings   | kSettled; position only until then
///   kSettled  | fewer than kEncoderNodeStale ms    | kSettled; all three, coasting
///             | without a good reading             |
///   any       | longer without a good reading      | kBlind
///
/// A good reading: the chip acknowledged and sees its magnet. The document has no way to say that a
/// value is none, so a value that is none is not sent; STATUS (ours) is always answered and says
/// why. POSITION is the latest reading itself, not filtered.
typedef struct {
  ShaftFilter filter;
  uint16_t position;     // of the last good reading
  uint8_t state;         // EncoderNodeState
  uint8_t good_samples;  // while settling
  uint8_t since_good;    // ms, up to 255
  uint8_t since_byte;    // ms, up to 255
  uint8_t held[2];       // the last two bytes of the line, older one first
  uint8_t chip_status;   // as it last answered
  uint8_t bus_errors;    // up to 255
  bool bus_error;        // the last reading
  bool restarted;        // since STATUS was last read
} EncoderNode;

void encoder_node_start(EncoderNode* node);
/// @param chip     kAs5600Size bytes from kAs5600First; a null pointer: the chip did not answer
/// @param elapsed  ms since the last sample, 1 where none was missed
void encoder_node_sample(EncoderNode* node, const uint8_t* chip, uint8_t elapsed);
/// A byte of the line. True where it completes a request that has an answer: five bytes in `reply`.
/// A request is the last three bytes on the line, so nothing that was lost or added before it can
/// hide it.
bool encoder_node_receive(EncoderNode* node, uint8_t byte, uint8_t* reply);

// NOLINTEND(modernize-use-using,performance-enum-size)
#ifdef __cplusplus
}
#endif
