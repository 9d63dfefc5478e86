#pragma once

#include <Arduino.h>

/// Frames of the MaxArm: `AA 55 function length data sum`, numbers little-endian, 9600 baud.
/// The sum is the complement of the bytes from function to the end of the data.
namespace sinew_maxarm {

constexpr uint8_t kHead = 0xAA;
constexpr uint8_t kSecond = 0x55;
constexpr uint8_t kFrameMax = 13;

enum Function : uint8_t {
  kSetAngle = 0x01,
  kSetXyz = 0x03,
  kSetPwmServo = 0x05,
  kSetSuction = 0x07,
  kReadAngle = 0x11,
  kReadXyz = 0x13,
};

struct Frame {
  uint8_t bytes[kFrameMax];
  uint8_t size;
};

// Encoders only: limits are checked by SinewMaxArm.
Frame set_angle_frame(const int16_t* pulses, uint16_t time_ms);
Frame set_xyz_frame(const int16_t* xyz_mm, uint16_t time_ms);
Frame set_pwm_servo_frame(uint16_t pulse_us, uint16_t time_ms);
Frame set_suction_frame(uint8_t function);
Frame read_frame(Function function);

/// The complement of the sum of `count` bytes.
uint8_t checksum_of(const uint8_t* bytes, uint8_t count);

}  // namespace sinew_maxarm
