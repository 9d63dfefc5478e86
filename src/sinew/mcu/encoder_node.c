#include "sinew/mcu/encoder_node.h"

#include <stddef.h>
#include <string.h>

#include "sinew/mcu/as5600.h"

enum { kLargest = 32767 };

// 2^-20 ticks a ms and ms^2: far beyond what 16 bits of the link say, far below an overflow.
#define SPEED_MAX ((int32_t)1000 << 20)
#define ACCELERATION_MAX ((int32_t)256 << 20)

static int32_t held_within(int32_t value, int32_t most) {
  if (value > most) return most;
  if (value < -most) return -most;
  return value;
}

/// value / 2^shift, to the nearest: shifts of negative numbers are arithmetic in all our compilers.
static int32_t scaled_down(int32_t value, uint8_t shift) {
  return (value + ((int32_t)1 << (shift - 1))) >> shift;
}

static uint8_t sum_held(uint8_t a, uint8_t b) {
  return (uint8_t)(a + b) < a ? 255 : (uint8_t)(a + b);
}

void shaft_filter_restart(ShaftFilter* filter, uint16_t position) {
  filter->angle = (uint32_t)position << 20;
  filter->speed = 0;
  filter->acceleration = 0;
}

void shaft_filter_coast(ShaftFilter* filter) {
  filter->angle += (uint32_t)(filter->speed + filter->acceleration / 2);
  filter->speed = held_within(filter->speed + filter->acceleration, SPEED_MAX);
}

void shaft_filter_update(ShaftFilter* filter, uint16_t position) {
  int32_t error;
  shaft_filter_coast(filter);
  // The difference of two angles in 32 bits is the nearest way round. 2^-12 of it is lost, so that
  // no product needs more than 32 bits: 0.09 ticks/s.
  error = (int32_t)(((uint32_t)position << 20) - filter->angle);
  filter->angle += (uint32_t)(scaled_down(error >> 1, 11) * 721);
  filter->speed = held_within(filter->speed + scaled_down(error >> 1, 12) * 93, SPEED_MAX);
  filter->acceleration =
      held_within(filter->acceleration + scaled_down(error >> 1, 11), ACCELERATION_MAX);
}

int16_t shaft_filter_speed(const ShaftFilter* filter) {
  return (int16_t)held_within(scaled_down(scaled_down(filter->speed, 10) * 1000, 10), kLargest);
}

int16_t shaft_filter_acceleration(const ShaftFilter* filter) {
  // 10^6 / 2^20 = 15625 / 2^14; held first, so that the product fits.
  const int32_t held = held_within(filter->acceleration, 34400);
  return (int16_t)held_within(scaled_down(held * 15625, 14), kLargest);
}

void encoder_node_start(EncoderNode* node) {
  memset(node, 0, sizeof *node);
  node->since_good = 255;
  node->restarted = true;
}

void encoder_node_sample(EncoderNode* node, const uint8_t* chip, uint8_t elapsed) {
  bool good;
  node->since_byte = sum_held(node->since_byte, elapsed);
  node->since_good = sum_held(node->since_good, elapsed);
  // Asked before this reading counts: a reading after a long gap does not mend the gap.
  if (node->since_good > kEncoderNodeStale) node->state = kEncoderBlind;
  node->bus_error = chip == NULL;
  if (node->bus_error) node->bus_errors = sum_held(node->bus_errors, 1);
  if (chip) node->chip_status = chip[0];
  good = chip && (chip[0] & kAs5600MagnetDetected) != 0;
  if (node->state != kEncoderBlind) {
    for (; elapsed > 1; --elapsed) shaft_filter_coast(&node->filter);
    if (!good) shaft_filter_coast(&node->filter);
  }
  if (!good) return;
  node->since_good = 0;
  node->position = as5600_position(chip);
  if (node->state == kEncoderBlind) {
    shaft_filter_restart(&node->filter, node->position);
    node->state = kEncoderSettling;
    node->good_samples = 0;
    node->restarted = true;
    return;
  }
  shaft_filter_update(&node->filter, node->position);
  if (node->state != kEncoderSettling) return;
  if (++node->good_samples >= kEncoderNodeSettle) node->state = kEncoderSettled;
}

static uint16_t status_of(const EncoderNode* node) {
  uint16_t value = (uint16_t)((uint16_t)node->bus_errors << 8);
  if (node->state != kEncoderBlind) value |= kEncoderFresh;
  if (node->state == kEncoderSettled) value |= kEncoderHasSpeed;
  if (node->chip_status & kAs5600MagnetDetected) value |= kEncoderMagnet;
  if (node->chip_status & kAs5600MagnetTooWeak) value |= kEncoderTooWeak;
  if (node->chip_status & kAs5600MagnetTooStrong) value |= kEncoderTooStrong;
  if (node->bus_error) value |= kEncoderBusError;
  if (node->restarted) value |= kEncoderRestarted;
  return value;
}

/// False where the register has no value now, or does not exist.
static bool value_of(EncoderNode* node, uint8_t name, uint16_t* value) {
  if (name == kEncoderStatus) {
    *value = status_of(node);
    node->restarted = false;
    return true;
  }
  if (name == kEncoderPosition) {
    *value = node->position;
    return node->state != kEncoderBlind;
  }
  if (name != kEncoderVelocity && name != kEncoderAcceleration) return false;
  *value = (uint16_t)(name == kEncoderVelocity ? shaft_filter_speed(&node->filter)
                                               : shaft_filter_acceleration(&node->filter));
  return node->state == kEncoderSettled;
}

bool encoder_node_receive(EncoderNode* node, uint8_t byte, uint8_t* reply) {
  uint8_t start, name;
  uint16_t value;
  if (node->since_byte > kEncoderNodeByteGap) node->held[0] = node->held[1] = 0;
  node->since_byte = 0;
  start = node->held[0];
  name = node->held[1];
  node->held[0] = name;
  node->held[1] = byte;
  if (start != kEncoderStart || byte != kEncoderEnd || !value_of(node, name, &value)) return false;
  node->held[0] = node->held[1] = 0;
  reply[0] = kEncoderStart;
  reply[1] = name;
  reply[2] = (uint8_t)(value & 0xFF);
  reply[3] = (uint8_t)(value >> 8);
  reply[4] = kEncoderEnd;
  return true;
}
