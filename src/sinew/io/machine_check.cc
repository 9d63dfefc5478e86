#include "sinew/io/machine_check.h"

#include <fcntl.h>
#include <grp.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace sinew::io {
namespace {

namespace fs = std::filesystem;

std::string group_name(gid_t group) {
  const struct group* entry = ::getgrgid(group);
  return entry == nullptr ? std::to_string(group) : entry->gr_name;
}

/// Empty where this user may read and write.
std::string trouble_with(const std::string& path) {
  if (::access(path.c_str(), R_OK | W_OK) == 0) return {};
  struct stat status{};
  if (::stat(path.c_str(), &status) != 0) return "went away while it was looked at";
  const std::string group = group_name(status.st_gid);
  return "no permission; the group '" + group + "' may use it: sudo adduser $USER " + group +
         ", then log in again";
}

/// Names below /dev that begin so, sorted.
std::vector<std::string> device_files(std::initializer_list<std::string_view> prefixes) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/dev", error)) {
    const std::string name = entry.path().filename();
    const bool wanted = std::ranges::any_of(
        prefixes, [&](std::string_view prefix) { return name.starts_with(prefix); });
    if (wanted) paths.push_back(entry.path());
  }
  std::ranges::sort(paths);
  return paths;
}

/// The adapter's own name, from the links that udev makes.
std::string serial_name(const std::string& path) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/dev/serial/by-id", error)) {
    std::error_code ignored;
    if (fs::equivalent(entry.path(), path, ignored)) return entry.path().filename();
  }
  return {};
}

std::string chip_name(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return {};
  gpiochip_info info{};
  const bool known = ::ioctl(descriptor, GPIO_GET_CHIPINFO_IOCTL, &info) == 0;
  ::close(descriptor);
  return known ? std::string(info.label) + ", " + std::to_string(info.lines) + " lines"
               : std::string();
}

}  // namespace

std::vector<FoundDevice> find_devices() {
  using Kind = FoundDevice::Kind;
  std::vector<FoundDevice> found;
  for (const std::string& path : device_files({"ttyUSB", "ttyACM", "ttyAMA", "ttyTHS"})) {
    found.push_back({Kind::kSerial, path, serial_name(path), trouble_with(path)});
  }
  for (const std::string& path : device_files({"spidev"})) {
    found.push_back({Kind::kSpi, path, {}, trouble_with(path)});
  }
  for (const std::string& path : device_files({"gpiochip"})) {
    found.push_back({Kind::kGpio, path, chip_name(path), trouble_with(path)});
  }
  return found;
}

std::vector<std::string> missing_interfaces() {
  std::vector<std::string> missing;
  if (::access("/dev/ptmx", R_OK | W_OK) != 0) {
    missing.emplace_back("pseudo-terminals (/dev/ptmx): without them no device can be simulated");
  }
  if (device_files({"ttyUSB", "ttyACM", "ttyAMA", "ttyTHS"}).empty()) {
    missing.emplace_back(
        "serial ports: none is there. Plug the robot's USB cable in; if nothing appears, sudo "
        "dmesg | tail says what the kernel saw");
  }
  if (device_files({"spidev"}).empty()) {
    missing.emplace_back(
        "SPI (/dev/spidev*): needed by robot-arm-2 only. On a Raspberry Pi: dtparam=spi=on in "
        "config.txt, or sudo raspi-config, Interface Options");
  }
  if (device_files({"gpiochip"}).empty()) {
    missing.emplace_back(
        "GPIO lines (/dev/gpiochip*): needed by robot-arm-2 only, for its chip selects");
  }
  return missing;
}

}  // namespace sinew::io
