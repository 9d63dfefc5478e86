#pragma once

#include <cstdint>

namespace sinew::io {

/// Sets any baud rate on an open serial device (250000 has no constant of its own); 0 or an errno.
int set_baud_rate(int descriptor, std::uint32_t baud);

/// The rate that the device's driver made of it; 0 where it does not tell.
std::uint32_t baud_rate(int descriptor);

}  // namespace sinew::io
