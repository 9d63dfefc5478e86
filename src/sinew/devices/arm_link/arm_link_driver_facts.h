#pragma once

#include "sinew/driver/device_facts.h"
#include "sinew/mcu/arm_link.h"
#include "sinew/wire/board_image.h"

namespace sinew {

/// A board on the arm link.
struct ArmLinkFacts {
  LastHeard<mcu::arm_link::Reply> state{};
  LastHeard<BoardImage> image{};                 ///< that runs on it
  LastHeard<mcu::arm_link::Reply> statistics{};  ///< its kStatistics
  bool wants_declaration = false;                ///< no move before its position is declared
};

}  // namespace sinew
