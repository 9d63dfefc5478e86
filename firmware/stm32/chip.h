#pragma once

#if defined(SINEW_STM32F401)
#include "firmware/stm32/chip_f401.h"
#elif defined(SINEW_STM32F103)
#include "firmware/stm32/chip_f103.h"
#else
#error "no chip is chosen"
#endif
