#pragma once

#include <vector>

#include "firmware/emulation_stm8/encoder_board.h"

namespace sinew::emulation {

/// What the node's program (mcu/encoder_node.h) answers on this computer, where it is given the
/// readings and bytes that the image had, in the same order.
Bytes replies_on_host(const std::vector<Event>& events);

}  // namespace sinew::emulation
