#pragma once

#include <Arduino.h>

/// Why a call of SinewMaxArm failed.
enum class MaxArmError : uint8_t {
  kNone,
  kNotANumber,    ///< a coordinate or angle is NaN or infinite
  kTimeRange,     ///< ms
  kServoRange,    ///< servo degrees of set_angles
  kPulseRange,    ///< pulses of set_pulses
  kNozzleRange,   ///< degrees of set_pwmservo
  kSuctionRange,  ///< function of set_SuctionNozzle
  kOutOfReach,    ///< mm from the shoulder axis
  kTooClose,      ///< mm from the base axis
  kJointLimit,    ///< joint degrees that a point needs
  kWriteFailed,   ///< the port took fewer bytes than the frame has
  kNoReply,       ///< no byte before the deadline
  kBadReply,      ///< bytes, but no valid reply before the deadline
  kServoFault,    ///< a servo reported a pulse outside 0..1000; a dead one reports -1
  kMissedTarget,  ///< degrees of the servo, and of its target
};

/// Result of a call. True in a condition if the call succeeded.
/// `Serial.println(result)` prints it as a sentence with numbers.
class MaxArmResult : public Printable {
 public:
  MaxArmResult() {}
  explicit MaxArmResult(MaxArmError why, float is = 0, float allowed = 0, uint8_t which = 0)
      : error(why), joint(which), value(is), limit(allowed) {}

  explicit operator bool() const { return error == MaxArmError::kNone; }
  size_t printTo(Print& out) const override;

  MaxArmError error = MaxArmError::kNone;
  uint8_t joint = 0;  ///< 1 base, 2 shoulder, 3 forearm; 0: concerns none
  float value = 0;    ///< in the unit that the error names
  float limit = 0;    ///< the limit that `value` breaks
};
