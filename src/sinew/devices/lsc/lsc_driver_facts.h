#pragma once

#include "sinew/devices/lsc/lsc_wire.h"
#include "sinew/driver/device_facts.h"

namespace sinew {

/// The LeArm's servo board.
struct LscFacts {
  LastHeard<lsc::Move> told;  ///< the host's last frame of targets
  LastHeard<lsc::Battery> battery;
  LastHeard<lsc::Version> version;
  LastHeard<lsc::ServoValues> positions;  ///< bus: measured; ESP32: where its pulses are
  LastHeard<lsc::GroupStarted> group_started;
  LastHeard<lsc::GroupFinished> group_finished;
  LastHeard<lsc::GroupStopped> group_stopped;
};

}  // namespace sinew
