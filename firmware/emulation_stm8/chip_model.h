#pragma once

#include <string>

namespace sinew::emulation {

/// Commands for uCsim's console that add to its STM8S103 what it lacks, the I2C with an AS5600 and
/// the watchdog, and print what an image does (encoder_board.h, Event).
std::string model_commands();
/// Behind each reset, also the first.
std::string model_start_commands();

}  // namespace sinew::emulation
