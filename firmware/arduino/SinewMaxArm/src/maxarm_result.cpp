#include "maxarm_result.h"

namespace {

size_t print_pair(Print& out, const __FlashStringHelper* name, float value, float limit,
                  const __FlashStringHelper* unit, int decimals) {
  size_t count = out.print(name);
  count += out.print(value, decimals);
  count += out.print(unit);
  count += out.print(F(", limit "));
  count += out.print(limit, decimals);
  return count + out.print(unit);
}

size_t print_servo(Print& out, uint8_t joint) {
  size_t count = out.print(F("servo "));
  count += out.print(static_cast<int>(joint));
  return count + out.print(' ');
}

const __FlashStringHelper* joint_name(uint8_t joint) {
  if (joint == 1) return F("base");
  return joint == 2 ? F("shoulder") : F("forearm");
}

}  // namespace

size_t MaxArmResult::printTo(Print& out) const {
  switch (error) {
    case MaxArmError::kNone:
      return out.print(F("done"));
    case MaxArmError::kNotANumber:
      return out.print(F("not a number"));
    case MaxArmError::kTimeRange:
      return print_pair(out, F("time "), value, limit, F(" ms"), 0);
    case MaxArmError::kServoRange:
      return print_servo(out, joint) + print_pair(out, F("at "), value, limit, F(" deg"), 1);
    case MaxArmError::kPulseRange:
      return print_servo(out, joint) + print_pair(out, F("pulse "), value, limit, F(""), 0);
    case MaxArmError::kNozzleRange:
      return print_pair(out, F("nozzle at "), value, limit, F(" deg"), 1);
    case MaxArmError::kSuctionRange:
      return print_pair(out, F("suction function "), value, limit, F(""), 0);
    case MaxArmError::kOutOfReach:
      return print_pair(out, F("out of reach: shoulder axis to wrist "), value, limit, F(" mm"), 1);
    case MaxArmError::kTooClose:
      return print_pair(out, F("too close to the base axis: "), value, limit, F(" mm"), 1);
    case MaxArmError::kJointLimit:
      return out.print(joint_name(joint)) +
             print_pair(out, F(" would need "), value, limit, F(" deg"), 1);
    case MaxArmError::kWriteFailed:
      return print_pair(out, F("bytes written "), value, limit, F(""), 0);
    case MaxArmError::kNoReply:
      return out.print(F("no reply: check wiring, power and the slave program of the arm"));
    case MaxArmError::kBadReply:
      return out.print(F("no valid reply: check GND, levels and 9600 baud"));
    case MaxArmError::kServoFault:
      return print_servo(out, joint) + print_pair(out, F("reported "), value, limit, F(""), 0);
    case MaxArmError::kMissedTarget:
      break;
  }
  size_t count = print_servo(out, joint) + out.print(F("at "));
  count += out.print(value, 1) + out.print(F(" deg, target "));
  return count + out.print(limit, 1) + out.print(F(" deg"));
}
