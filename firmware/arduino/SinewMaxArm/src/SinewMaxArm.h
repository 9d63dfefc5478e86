#pragma once

#include <Arduino.h>

#include "maxarm_frames.h"
#include "maxarm_kinematics.h"
#include "maxarm_replies.h"
#include "maxarm_result.h"

/// Functions of the suction.
enum MaxArmSuction {
  kSuctionOn = 1,
  kSuctionRelease = 2,  ///< pump off, valve open
  kSuctionOff = 3,      ///< pump off, valve closed
};

/// A MaxArm on a serial port of 9600 baud. The arm must run the maker's slave program.
///
/// Units: mm, degrees, ms. Frame: z up from the table, front of the arm -y, +x to its right.
/// Every call checks its values before it sends a byte; a refusal has a reason. The arm confirms
/// nothing: at_target() reads back. Every call returns: a send within 50 ms, a read within 4.5 s
/// plus the time that the nozzle still turns.
class SinewMaxArm {
 public:
  /// @param port  opened with 9600 baud by the sketch: SoftwareSerial, HardwareSerial, any Stream
  explicit SinewMaxArm(Stream& port) : port_(port) {}

  // Times: 20..30000 ms.

  /// Servo angles: 0..240, 0..211, 119..240 degrees (a degree beyond the joints' limits, so that
  /// angles that were read under load can be sent).
  MaxArmResult set_angles(const float* angles_deg, int32_t time_ms);
  MaxArmResult set_angles(const int16_t* angles_deg, int32_t time_ms);
  MaxArmResult set_angles(const uint8_t* angles_deg, int32_t time_ms);
  /// The same in pulses of 0.24 degrees: 1..1000, 1..879, 496..1000.
  MaxArmResult set_pulses(const int16_t* pulses, int32_t time_ms);
  /// Nozzle to a point. Checked here, then computed by the arm, which cuts its pulses.
  MaxArmResult set_xyz(const int16_t* xyz_mm, int32_t time_ms);
  /// Nozzle to a point, computed here: nearest pulse, fractions of a mm.
  MaxArmResult move_to(float x_mm, float y_mm, float z_mm, int32_t time_ms);
  /// Nozzle servo, 0..180 degrees. The arm's Arduino program handles nothing else until its end.
  MaxArmResult set_pwmservo(float angle_deg, int32_t time_ms);
  /// @param function  1..3, see MaxArmSuction
  MaxArmResult set_SuctionNozzle(int function);

  MaxArmResult read_pulses(int16_t* pulses);
  MaxArmResult read_angles(float* angles_deg);
  MaxArmResult read_angles(int16_t* angles_deg);  ///< rounded
  MaxArmResult read_xyz(int16_t* xyz_mm);

  /// Reads the pulses and compares them with the last target. Call it after the move's time.
  /// @param tolerance_pulses  a servo under load rests up to 4 pulses beside its target
  MaxArmResult at_target(int16_t tolerance_pulses = 6);

  /// Stops the arm: reads its pulses and sends it there. The arm keeps moving until it has
  /// replied (0.1 to 0.6 s). Nozzle and suction do not change.
  MaxArmResult halt(int32_t time_ms = 100);

  /// The checksum of the last reply that was accepted.
  ReplyChecksum checksum() const { return checksums_.checksum(); }
  /// How often it changed. Above 0: another program in the arm, or a noisy line.
  uint8_t checksum_changes() const { return checksums_.changes(); }

 private:
  MaxArmResult send(const sinew_maxarm::Frame& frame);
  MaxArmResult send_pulses(const int16_t* pulses, int32_t time_ms);
  MaxArmResult write(const uint8_t* bytes, uint8_t count);
  MaxArmResult read(sinew_maxarm::Function function, int16_t* values);
  MaxArmResult recover(sinew_maxarm::Function wanted);
  MaxArmResult ask(sinew_maxarm::Function function, int16_t* values);
  void drop_input();
  uint32_t nozzle_time_left();

  Stream& port_;
  sinew_maxarm::ReplyParser parser_;
  sinew_maxarm::ChecksumWatch checksums_;
  uint32_t last_write_ms_ = 0;
  uint32_t last_question_ms_ = 0;
  uint32_t nozzle_start_ms_ = 0;
  uint16_t nozzle_time_ms_ = 0;
  uint16_t write_gap_ms_ = 0;  ///< from the last write to the next
  bool asked_ = false;
  bool reply_may_be_late_ = false;
  bool has_target_ = false;
  int16_t target_[3] = {0, 0, 0};  ///< pulses
};
