#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "sinew/model/device.h"

namespace sinew {

/// What the table [device] of a robot's file has of a kind, whatever the robot.
struct DeviceTable {
  std::string_view protocol;  ///< name of the wire
  /// What it can do stands in the file; else it is the same for each robot, as model/device.h has
  /// it, and what follows here does not count.
  bool capability_in_file = true;
  bool serial_port = false;  ///< it runs over one
  std::size_t joints = 0;    ///< how many it drives; 0: any
  bool slides = false;       ///< it drives an arm's prismatic joint
  std::int64_t segment_ms_min = 1;
  std::int64_t segment_ms_max = 0;  ///< of a streamed motion
  HandDrive hand = HandDrive::kNone;
};

}  // namespace sinew
