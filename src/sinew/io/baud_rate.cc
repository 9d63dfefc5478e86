// Apart from everything else: the kernel's termios2 and the C library's termios do not go together
// in one translation unit.
#include "sinew/io/baud_rate.h"

#include <asm/termbits.h>
#include <sys/ioctl.h>

#include <cerrno>

namespace sinew::io {

int set_baud_rate(int descriptor, std::uint32_t baud) {
  termios2 settings{};
  if (ioctl(descriptor, TCGETS2, &settings) != 0) return errno;
  settings.c_cflag &= ~static_cast<tcflag_t>(CBAUD | (CBAUD << IBSHIFT));
  settings.c_cflag |= BOTHER | (BOTHER << IBSHIFT);
  settings.c_ispeed = baud;
  settings.c_ospeed = baud;
  return ioctl(descriptor, TCSETS2, &settings) == 0 ? 0 : errno;
}

std::uint32_t baud_rate(int descriptor) {
  termios2 settings{};
  return ioctl(descriptor, TCGETS2, &settings) == 0 ? settings.c_ospeed : 0;
}

}  // namespace sinew::io
