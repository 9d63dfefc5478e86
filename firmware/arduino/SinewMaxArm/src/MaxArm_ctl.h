#pragma once

#include <SoftwareSerial.h>

#include "SinewMaxArm.h"

/// SinewMaxArm with the class name, the pins and the spellings of the maker's example, so that a
/// sketch written for it compiles as it is. Not for the Mega: its pin 7 has no interrupt for
/// SoftwareSerial.
namespace sinew_maxarm {

struct ArduinoPins {
  static constexpr uint8_t kRxPin = 7;  ///< from IO33 of the arm
  static constexpr uint8_t kTxPin = 6;  ///< to IO32 of the arm
  SoftwareSerial pins_port{kRxPin, kTxPin};
};

}  // namespace sinew_maxarm

class MaxArm_ctl : private sinew_maxarm::ArduinoPins, public SinewMaxArm {
 public:
  MaxArm_ctl() : SinewMaxArm(pins_port) {}

  void serial_begin() { pins_port.begin(9600); }
  MaxArmResult set_SuctioNnozzle(int function) { return set_SuctionNozzle(function); }
  MaxArmResult set_Suctionnozzle(int function) { return set_SuctionNozzle(function); }
};
