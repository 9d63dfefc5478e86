#include "SinewMaxArm.h"

#include <math.h>

using sinew_maxarm::Frame;
using sinew_maxarm::Function;
using sinew_maxarm::kDegPerPulse;

namespace {

constexpr int32_t kTimeMinMs = 20;     // below, the arm's Arduino program divides by zero
constexpr int32_t kTimeMaxMs = 30000;  // limit of the servos
constexpr float kServoMinDeg[3] = {0, 0, 119};
constexpr float kServoMaxDeg[3] = {240, 211, 240};
constexpr int16_t kServoMinPulse[3] = {1, 1, 496};
constexpr int16_t kServoMaxPulse[3] = {1000, 879, 1000};

constexpr uint16_t kFrameGapMs = 20;
constexpr uint16_t kQuestionGapMs = 125;
constexpr uint16_t kReplyTimeMs = 700;  // measured 18..541 ms with the reply's own time
constexpr uint8_t kTries = 3;
constexpr uint8_t kZeros = 16;  // they end a frame that the MicroPython program has cut
constexpr uint16_t kZerosTimeMs = 150;
constexpr uint16_t kDropMax = 256;
constexpr int16_t kCoordinateMaxMm = 400;
constexpr float kNozzleMinUs = 500;
constexpr float kNozzleUsPerDeg = 2000.0F / 180.0F;

uint32_t now_ms() {
  return static_cast<uint32_t>(millis());
}

/// Correct across an overflow of millis().
void wait_since(uint32_t start_ms, uint16_t time_ms) {
  while (now_ms() - start_ms < time_ms) delay(1);
}

/// 10 bits a byte at 9600 baud, rounded up.
uint16_t wire_time_ms(uint8_t bytes) {
  return static_cast<uint16_t>(bytes + bytes / 24 + 1);
}

MaxArmResult check_time(int32_t time_ms) {
  const bool low = time_ms < kTimeMinMs;
  if (!low && time_ms <= kTimeMaxMs) return MaxArmResult();
  return MaxArmResult(MaxArmError::kTimeRange, static_cast<float>(time_ms),
                      static_cast<float>(low ? kTimeMinMs : kTimeMaxMs));
}

/// The arm cuts pulses and would set a servo to 0, which ends its MicroPython program.
MaxArmResult check_cut_pulses(const float* joints_deg, const float* pulses) {
  constexpr float kSafe = 1.02F;
  constexpr float kLimitDeg[2] = {kDegPerPulse, 210.0F - kDegPerPulse};
  for (uint8_t i = 0; i < 2; ++i) {
    if (pulses[i] >= kSafe) continue;
    return MaxArmResult(MaxArmError::kJointLimit, joints_deg[i], kLimitDeg[i],
                        static_cast<uint8_t>(i + 1));
  }
  return MaxArmResult();
}

}  // namespace

MaxArmResult SinewMaxArm::set_angles(const float* angles_deg, int32_t time_ms) {
  int16_t pulses[3];
  for (uint8_t i = 0; i < 3; ++i) {
    const float angle = angles_deg[i];
    const uint8_t joint = static_cast<uint8_t>(i + 1);
    if (!isfinite(angle)) return MaxArmResult(MaxArmError::kNotANumber, 0, 0, joint);
    const bool low = angle < kServoMinDeg[i];
    if (low || angle > kServoMaxDeg[i]) {
      const float limit = low ? kServoMinDeg[i] : kServoMaxDeg[i];
      return MaxArmResult(MaxArmError::kServoRange, angle, limit, joint);
    }
    pulses[i] = sinew_maxarm::nearest_pulse(angle / kDegPerPulse);
  }
  return send_pulses(pulses, time_ms);
}

MaxArmResult SinewMaxArm::set_angles(const int16_t* angles_deg, int32_t time_ms) {
  const float angles[3] = {static_cast<float>(angles_deg[0]), static_cast<float>(angles_deg[1]),
                           static_cast<float>(angles_deg[2])};
  return set_angles(angles, time_ms);
}

MaxArmResult SinewMaxArm::set_angles(const uint8_t* angles_deg, int32_t time_ms) {
  const int16_t angles[3] = {angles_deg[0], angles_deg[1], angles_deg[2]};
  return set_angles(angles, time_ms);
}

MaxArmResult SinewMaxArm::set_pulses(const int16_t* pulses, int32_t time_ms) {
  for (uint8_t i = 0; i < 3; ++i) {
    const bool low = pulses[i] < kServoMinPulse[i];
    if (!low && pulses[i] <= kServoMaxPulse[i]) continue;
    const int16_t limit = low ? kServoMinPulse[i] : kServoMaxPulse[i];
    return MaxArmResult(MaxArmError::kPulseRange, pulses[i], limit, static_cast<uint8_t>(i + 1));
  }
  return send_pulses(pulses, time_ms);
}

MaxArmResult SinewMaxArm::set_xyz(const int16_t* xyz_mm, int32_t time_ms) {
  const float point[3] = {static_cast<float>(xyz_mm[0]), static_cast<float>(xyz_mm[1]),
                          static_cast<float>(xyz_mm[2])};
  float joints[3];
  float pulses[3];
  MaxArmResult result = sinew_maxarm::inverse(point, joints);
  if (!result) return result;
  sinew_maxarm::pulses_of(joints, pulses);
  result = check_cut_pulses(joints, pulses);
  if (result) result = check_time(time_ms);
  if (!result) return result;
  for (uint8_t i = 0; i < 3; ++i) target_[i] = static_cast<int16_t>(pulses[i]);
  has_target_ = true;
  return send(sinew_maxarm::set_xyz_frame(xyz_mm, static_cast<uint16_t>(time_ms)));
}

MaxArmResult SinewMaxArm::move_to(float x_mm, float y_mm, float z_mm, int32_t time_ms) {
  const float point[3] = {x_mm, y_mm, z_mm};
  float joints[3];
  float exact[3];
  const MaxArmResult result = sinew_maxarm::inverse(point, joints);
  if (!result) return result;
  sinew_maxarm::pulses_of(joints, exact);
  int16_t pulses[3];
  for (uint8_t i = 0; i < 3; ++i) pulses[i] = sinew_maxarm::nearest_pulse(exact[i]);
  return send_pulses(pulses, time_ms);
}

MaxArmResult SinewMaxArm::set_pwmservo(float angle_deg, int32_t time_ms) {
  if (!isfinite(angle_deg)) return MaxArmResult(MaxArmError::kNotANumber);
  const bool low = angle_deg < 0;
  if (low || angle_deg > 180) {
    return MaxArmResult(MaxArmError::kNozzleRange, angle_deg, low ? 0.0F : 180.0F);
  }
  MaxArmResult result = check_time(time_ms);
  if (!result) return result;
  const float pulse_us = floorf(kNozzleMinUs + angle_deg * kNozzleUsPerDeg + 0.5F);
  const uint16_t time = static_cast<uint16_t>(time_ms);
  const uint32_t left = nozzle_time_left();
  result = send(sinew_maxarm::set_pwm_servo_frame(static_cast<uint16_t>(pulse_us), time));
  // The arm's Arduino program starts a turn after the one before.
  const uint32_t busy = left + time;
  nozzle_start_ms_ = now_ms();
  nozzle_time_ms_ = static_cast<uint16_t>(busy < kTimeMaxMs ? busy : kTimeMaxMs);
  return result;
}

MaxArmResult SinewMaxArm::set_SuctionNozzle(int function) {
  const bool low = function < kSuctionOn;
  if (low || function > kSuctionOff) {
    return MaxArmResult(MaxArmError::kSuctionRange, static_cast<float>(function),
                        static_cast<float>(low ? kSuctionOn : kSuctionOff));
  }
  return send(sinew_maxarm::set_suction_frame(static_cast<uint8_t>(function)));
}

MaxArmResult SinewMaxArm::read_pulses(int16_t* pulses) {
  return read(sinew_maxarm::kReadAngle, pulses);
}

MaxArmResult SinewMaxArm::read_angles(float* angles_deg) {
  int16_t pulses[3];
  const MaxArmResult result = read_pulses(pulses);
  if (!result) return result;
  for (uint8_t i = 0; i < 3; ++i) angles_deg[i] = pulses[i] * kDegPerPulse;
  return result;
}

MaxArmResult SinewMaxArm::read_angles(int16_t* angles_deg) {
  float angles[3];
  const MaxArmResult result = read_angles(angles);
  if (!result) return result;
  for (uint8_t i = 0; i < 3; ++i) angles_deg[i] = static_cast<int16_t>(angles[i] + 0.5F);
  return result;
}

MaxArmResult SinewMaxArm::read_xyz(int16_t* xyz_mm) {
  return read(sinew_maxarm::kReadXyz, xyz_mm);
}

MaxArmResult SinewMaxArm::at_target(int16_t tolerance_pulses) {
  int16_t pulses[3];
  const MaxArmResult result = read_pulses(pulses);
  if (!result || !has_target_) return result;
  for (uint8_t i = 0; i < 3; ++i) {
    const int16_t off = static_cast<int16_t>(pulses[i] - target_[i]);
    if (off >= -tolerance_pulses && off <= tolerance_pulses) continue;
    return MaxArmResult(MaxArmError::kMissedTarget, pulses[i] * kDegPerPulse,
                        target_[i] * kDegPerPulse, static_cast<uint8_t>(i + 1));
  }
  return result;
}

MaxArmResult SinewMaxArm::halt(int32_t time_ms) {
  MaxArmResult result = check_time(time_ms);
  if (!result) return result;
  int16_t pulses[3];
  result = read_pulses(pulses);
  if (!result) return result;
  // Joint limits do not apply: the arm is there. Only pulse 0 is never sent.
  for (uint8_t i = 0; i < 3; ++i) pulses[i] = sinew_maxarm::nearest_pulse(pulses[i]);
  return send_pulses(pulses, time_ms);
}

MaxArmResult SinewMaxArm::send_pulses(const int16_t* pulses, int32_t time_ms) {
  const MaxArmResult result = check_time(time_ms);
  if (!result) return result;
  for (uint8_t i = 0; i < 3; ++i) target_[i] = pulses[i];
  has_target_ = true;
  return send(sinew_maxarm::set_angle_frame(pulses, static_cast<uint16_t>(time_ms)));
}

MaxArmResult SinewMaxArm::send(const Frame& frame) {
  return write(frame.bytes, frame.size);
}

MaxArmResult SinewMaxArm::write(const uint8_t* bytes, uint8_t count) {
  wait_since(last_write_ms_, write_gap_ms_);
  last_write_ms_ = now_ms();
  const size_t written = port_.write(bytes, count);
  // A blocking port has spent the time of its bytes already.
  const uint16_t wire = wire_time_ms(count);
  const uint32_t used = now_ms() - last_write_ms_;
  write_gap_ms_ = static_cast<uint16_t>((used > wire ? used : wire) + kFrameGapMs + 1);
  if (written == count) return MaxArmResult();
  return MaxArmResult(MaxArmError::kWriteFailed, static_cast<float>(written), count);
}

MaxArmResult SinewMaxArm::read(Function function, int16_t* values) {
  MaxArmResult result;
  for (uint8_t attempt = 0; attempt < kTries; ++attempt) {
    result = reply_may_be_late_ ? recover(function) : MaxArmResult();
    if (result) result = ask(function, values);
    if (result) return result;
  }
  return result;
}

/// After a missed deadline. The arm replies in order: once it has replied to the other question,
/// the late reply is out, and cannot be mistaken for the next one.
MaxArmResult SinewMaxArm::recover(Function wanted) {
  const uint8_t zeros[kZeros] = {};
  MaxArmResult result = write(zeros, kZeros);
  if (!result) return result;
  wait_since(last_write_ms_, static_cast<uint16_t>(wire_time_ms(kZeros) + kZerosTimeMs));
  int16_t ignored[3];
  const bool angles = wanted == sinew_maxarm::kReadAngle;
  result = ask(angles ? sinew_maxarm::kReadXyz : sinew_maxarm::kReadAngle, ignored);
  // A reply with impossible values has proved the order, too.
  if (!reply_may_be_late_) return MaxArmResult();
  return result;
}

MaxArmResult SinewMaxArm::ask(Function function, int16_t* values) {
  if (asked_) wait_since(last_question_ms_, kQuestionGapMs);
  wait_since(last_write_ms_, write_gap_ms_);
  drop_input();
  const MaxArmResult sent = send(sinew_maxarm::read_frame(function));
  last_question_ms_ = last_write_ms_;
  asked_ = true;
  if (!sent) return sent;
  reply_may_be_late_ = true;

  // The arm's Arduino program replies after the nozzle has turned.
  const uint32_t deadline_ms = kReplyTimeMs + nozzle_time_left();
  bool heard = false;
  while (now_ms() - last_question_ms_ < deadline_ms) {
    const int received = port_.read();
    if (received < 0) {
      delay(1);
      continue;
    }
    heard = true;
    sinew_maxarm::Reply reply;
    if (!parser_.push(static_cast<uint8_t>(received), reply)) continue;
    if (reply.function != function || !checksums_.accept(reply.checksum)) continue;
    reply_may_be_late_ = false;
    const bool angles = function == sinew_maxarm::kReadAngle;
    for (uint8_t i = 0; i < 3; ++i) {
      const int16_t value = reply.values[i];
      const int16_t low = angles ? 0 : -kCoordinateMaxMm;
      const int16_t high = angles ? sinew_maxarm::kPulseMax : kCoordinateMaxMm;
      if (value < low || value > high) {
        const MaxArmError error = angles ? MaxArmError::kServoFault : MaxArmError::kBadReply;
        return MaxArmResult(error, value, value < low ? low : high, static_cast<uint8_t>(i + 1));
      }
    }
    for (uint8_t i = 0; i < 3; ++i) values[i] = reply.values[i];
    return MaxArmResult();
  }
  return MaxArmResult(heard ? MaxArmError::kBadReply : MaxArmError::kNoReply);
}

void SinewMaxArm::drop_input() {
  for (uint16_t i = 0; i < kDropMax && port_.read() >= 0; ++i) {
  }
  parser_.reset();
}

uint32_t SinewMaxArm::nozzle_time_left() {
  const uint32_t passed = now_ms() - nozzle_start_ms_;
  if (passed >= nozzle_time_ms_) nozzle_time_ms_ = 0;
  return nozzle_time_ms_ == 0 ? 0 : nozzle_time_ms_ - passed;
}
