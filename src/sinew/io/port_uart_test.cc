#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <filesystem>
#include <optional>
#include <vector>

#include "sinew/io/port.h"

// What a port asks of a UART's driver, on a computer that has none. A terminal that is no
// pseudo-terminal's slave takes the way of a UART: its master (/dev/ptmx), which keeps TIOCEXCL
// like every other terminal. That a second open of the same UART fails then cannot be seen on it,
// since each open of /dev/ptmx is another terminal; what the flag does is seen on a slave, where
// the test sets it. TIOCGSERIAL and TIOCSSERIAL no pseudo-terminal knows: here they are answered in
// its place. What an adapter makes of the flag, 1 ms instead of 16, no test without one can show.

namespace {

/// Stands in for the driver's two calls while it is set.
struct UartDriver {
  serial_struct settings{};
  std::vector<serial_struct> written;
  bool refuses_writing = false;
};
UartDriver* uart_driver = nullptr;

}  // namespace

/// Every ioctl of this program comes by here, and all but those two go on to the kernel.
extern "C" int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  if (uart_driver != nullptr && request == TIOCGSERIAL) {
    *static_cast<serial_struct*>(argument) = uart_driver->settings;
    return 0;
  }
  if (uart_driver != nullptr && request == TIOCSSERIAL) {
    uart_driver->written.push_back(*static_cast<serial_struct*>(argument));
    errno = EPERM;
    return uart_driver->refuses_writing ? -1 : 0;
  }
  return static_cast<int>(syscall(SYS_ioctl, descriptor, request, argument));
}

namespace sinew::io {
namespace {

namespace fs = std::filesystem;

/// Whether the terminal that this process has open under that name is closed to others.
std::optional<bool> is_exclusive(const std::string& path) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd", ignored)) {
    if (fs::read_symlink(entry.path(), ignored) != path) continue;
    int exclusive = -1;
    if (::ioctl(std::stoi(entry.path().filename()), TIOCGEXCL, &exclusive) == 0) {
      return exclusive != 0;
    }
  }
  return std::nullopt;
}

TEST(PortUart, it_is_closed_to_others_by_the_kernel) {
  EXPECT_EQ(is_exclusive("/dev/ptmx"), std::nullopt);
  const auto port = Port::open_serial("/dev/ptmx", 9600);
  ASSERT_TRUE(port) << port.error().sentence;
  EXPECT_EQ(is_exclusive("/dev/ptmx"), true);
}

TEST(PortUart, a_pseudo_terminal_stays_open_to_the_next_host) {
  const auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  const auto host = Port::open_serial(device->path(), 9600);
  ASSERT_TRUE(host);
  EXPECT_EQ(is_exclusive(device->path()), false) << "its lock keeps others out, and ends with it";
}

TEST(PortUart, one_that_another_program_closed_to_us_is_told_as_in_use) {
  const auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  const int other = ::open(device->path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(other, 0);
  ASSERT_EQ(::ioctl(other, TIOCEXCL, nullptr), 0);
  // The kernel lets root in all the same.
  const pid_t child = ::fork();
  if (child == 0) {
    if (::getuid() == 0 && (::chmod(device->path().c_str(), 0666) != 0 || ::setuid(65'534) != 0)) {
      ::_exit(2);
    }
    const auto port = Port::open_serial(device->path(), 9600);
    const bool told =
        !port && port.error().sentence == device->path() + ": another program is using this port";
    ::_exit(told ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  ::close(other);
}

TEST(PortUart, it_asks_for_prompt_bytes_and_changes_nothing_else_of_its_driver) {
  UartDriver driver;
  driver.settings.type = 4;
  driver.settings.flags = ASYNC_SKIP_TEST;
  driver.settings.baud_base = 115'200;
  driver.settings.xmit_fifo_size = 16;
  for (const bool refuses : {false, true}) {
    driver.written.clear();
    driver.refuses_writing = refuses;
    uart_driver = &driver;
    const auto port = Port::open_serial("/dev/ptmx", 9600);
    uart_driver = nullptr;
    ASSERT_TRUE(port) << "a driver that refuses costs promptness and nothing else";
    ASSERT_EQ(driver.written.size(), 1U);
    const serial_struct& asked = driver.written[0];
    EXPECT_EQ(asked.flags, ASYNC_SKIP_TEST | ASYNC_LOW_LATENCY);
    EXPECT_EQ(asked.type, driver.settings.type);
    EXPECT_EQ(asked.baud_base, driver.settings.baud_base);
    EXPECT_EQ(asked.xmit_fifo_size, driver.settings.xmit_fifo_size);
  }
}

TEST(PortUart, a_terminal_whose_driver_knows_no_such_setting_opens_all_the_same) {
  serial_struct settings{};
  const auto device = Port::open_pseudo_terminal();
  ASSERT_TRUE(device);
  const int descriptor = ::open(device->path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  EXPECT_NE(::ioctl(descriptor, TIOCGSERIAL, &settings), 0) << "no pseudo-terminal does";
  ::close(descriptor);
  EXPECT_TRUE(Port::open_serial(device->path(), 9600));
}

}  // namespace
}  // namespace sinew::io
