#include "maxarm_frames.h"

namespace sinew_maxarm {
namespace {

class FrameWriter {
 public:
  explicit FrameWriter(Function function) {
    put(kHead);
    put(kSecond);
    put(function);
    put(0);
  }
  void put(uint8_t byte) {
    if (size_ < kFrameMax) frame_.bytes[size_++] = byte;
  }
  void put_word(uint16_t word) {
    put(static_cast<uint8_t>(word & 0xFFU));
    put(static_cast<uint8_t>(word >> 8U));
  }
  void put_three(const int16_t* words) {
    for (uint8_t i = 0; i < 3; ++i) put_word(static_cast<uint16_t>(words[i]));
  }
  Frame finish() {
    frame_.bytes[3] = static_cast<uint8_t>(size_ - 4);
    put(checksum_of(frame_.bytes + 2, static_cast<uint8_t>(size_ - 2)));
    frame_.size = size_;
    return frame_;
  }

 private:
  Frame frame_{};
  uint8_t size_ = 0;
};

}  // namespace

uint8_t checksum_of(const uint8_t* bytes, uint8_t count) {
  uint8_t sum = 0;
  for (uint8_t i = 0; i < count; ++i) sum = static_cast<uint8_t>(sum + bytes[i]);
  return static_cast<uint8_t>(~sum);
}

Frame set_angle_frame(const int16_t* pulses, uint16_t time_ms) {
  FrameWriter writer(kSetAngle);
  writer.put_three(pulses);
  writer.put_word(time_ms);
  return writer.finish();
}

Frame set_xyz_frame(const int16_t* xyz_mm, uint16_t time_ms) {
  FrameWriter writer(kSetXyz);
  writer.put_three(xyz_mm);
  writer.put_word(time_ms);
  return writer.finish();
}

Frame set_pwm_servo_frame(uint16_t pulse_us, uint16_t time_ms) {
  FrameWriter writer(kSetPwmServo);
  writer.put_word(pulse_us);
  writer.put_word(time_ms);
  return writer.finish();
}

Frame set_suction_frame(uint8_t function) {
  FrameWriter writer(kSetSuction);
  writer.put(function);
  return writer.finish();
}

Frame read_frame(Function function) {
  return FrameWriter(function).finish();
}

}  // namespace sinew_maxarm
