#pragma once

#include "sinew/wire/board_image.h"

namespace sinew::stm32 {

/// What runs here, as its bytes in the flash say.
BoardImage own_image();

}  // namespace sinew::stm32
