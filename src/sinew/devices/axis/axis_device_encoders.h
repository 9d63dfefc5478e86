#pragma once

#include <cstdint>

#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/axis/axis_device_settings.h"

namespace sinew {

/// One encoder: counts to an angle over many turns. An AS5600 wraps after 4096 positions and is
/// unwrapped at +-2048; a quadrature counter wraps with its 32 bits. A reading that no shaft could
/// have reached since the last good one is a glitch and counts as missing.
class EncoderChannel {
 public:
  EncoderChannel() = default;
  /// @param modulus    positions until it wraps; 0: never
  /// @param speed_max  counts/s. @param gap_max  s without a good reading until it is lost
  /// @param start_max  the same, until the first one
  EncoderChannel(std::int32_t modulus, double speed_max, double gap_max, double start_max)
      : modulus_(modulus), speed_max_(speed_max), gap_max_(gap_max), start_max_(start_max) {}
  EncoderChannel(std::int32_t modulus, double speed_max, double gap_max)
      : EncoderChannel(modulus, speed_max, gap_max, gap_max) {}

  /// @param dt  s since the last call of read() or wait()
  void read(std::int32_t counts, bool ok, double dt);
  /// No reading was due.
  void wait(double dt);
  /// Counts on from here, whatever happened.
  void restart();
  std::int64_t counts() const { return counts_; }  ///< since the first reading
  bool good() const { return good_; }              ///< the last reading
  bool lost() const { return lost_; }              ///< latched: turns may be missing

 private:
  std::int32_t modulus_ = 0;
  double speed_max_ = 0;
  double gap_max_ = 0;
  double start_max_ = 0;
  bool started_ = false;
  bool good_ = false;
  bool lost_ = false;
  double gap_ = 0;     ///< s since the last good reading
  double waited_ = 0;  ///< s since the last reading
  bool has_candidate_ = false;
  std::int32_t candidate_ = 0;  ///< a reading after a gap that waits for a second one
  std::int32_t last_ = 0;
  std::int64_t counts_ = 0;
};

/// The two encoders of an axis as one measurement of its joint, in the model's frame once a place
/// is marked. Position and control come from the motor's, which is 17 times finer and has no
/// backlash in the loop; the joint's own one is held against it. rad of the joint, rad/s. @rt
class AxisEncoders {
 public:
  explicit AxisEncoders(const AxisEncoderSettings& settings);

  void read(const AxisInputs& inputs, double dt);

  double q() const { return q_; }
  double qd() const { return qd_; }
  double joint_q() const;
  /// rad of the motor's shaft since the first reading, for comparison with the steps made.
  double motor_angle() const;

  bool motor_good() const { return motor_.good(); }  ///< the last reading
  bool motor_lost() const { return motor_.lost(); }
  bool joint_lost() const { return fitted_ && joint_.lost(); }
  bool good() const { return motor_.good() && (!fitted_ || joint_.good()); }
  /// What the joint's encoder says beyond what the motor's does, filtered.
  double disagreement() const { return disagreement_; }

  /// Remembers where both stand now, and later names that place, `motor_q` for what comes through
  /// the gear; how far q() jumps by that.
  void mark();
  double name_mark(double joint_q, double motor_q);
  /// After a loss: counts on, both encoders agree where they stand now.
  void restart();

 private:
  double raw_joint() const;

  AxisEncoderSettings settings_;
  bool fitted_;
  EncoderChannel motor_;
  EncoderChannel joint_;
  double motor_offset_ = 0;
  double joint_offset_ = 0;
  double motor_mark_ = 0;  ///< without offset
  double joint_mark_ = 0;
  bool started_ = false;
  double q_ = 0;
  double qd_ = 0;
  double filtered_q_ = 0;
  double disagreement_ = 0;
  double joint_waited_ = 0;  ///< s since the joint's last reading
};

}  // namespace sinew
