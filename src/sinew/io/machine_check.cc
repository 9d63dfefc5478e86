#include "sinew/io/machine_check.h"

#include <fcntl.h>
#include <grp.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
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

/// Names in that folder that begin so, sorted.
std::vector<std::string> device_files(const std::string& folder,
                                      std::initializer_list<std::string_view> prefixes) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename();
    const bool wanted = std::ranges::any_of(
        prefixes, [&](std::string_view prefix) { return name.starts_with(prefix); });
    if (wanted) paths.push_back(entry.path());
  }
  std::ranges::sort(paths);
  return paths;
}

/// Whether there is a UART behind a ttyS: the driver of an empty place says type 0.
bool has_uart(const std::string& path, const DeviceFolders& folders) {
  const fs::path shown = fs::path(folders.terminals) / fs::path(path).filename() / "type";
  int type = 0;
  return static_cast<bool>(std::ifstream(shown) >> type) && type != 0;
}

std::vector<std::string> serial_ports(const DeviceFolders& folders) {
  auto ports = device_files(folders.files, {"ttyUSB", "ttyACM", "ttyAMA", "ttyTHS", "ttyS"});
  std::erase_if(ports, [&](const std::string& path) {
    return fs::path(path).filename().string().starts_with("ttyS") && !has_uart(path, folders);
  });
  return ports;
}

/// The LeArm's classic board: bus 3 is USB, 0483:5750 is what it calls itself there.
bool has_learm_hid(const DeviceFolders& folders) {
  return !device_files(folders.hid, {"0003:0483:5750."}).empty();
}

/// The adapter's own name, from the links that udev makes.
std::string serial_name(const std::string& path, const DeviceFolders& folders) {
  std::error_code error;
  const fs::path device = fs::canonical(path, error);
  for (const auto& entry : fs::directory_iterator(folders.files + "/serial/by-id", error)) {
    // Not fs::equivalent: this library's refuses device files.
    std::error_code ignored;
    if (fs::canonical(entry.path(), ignored) == device) return entry.path().filename();
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

std::vector<FoundDevice> find_devices(const DeviceFolders& folders) {
  using Kind = FoundDevice::Kind;
  std::vector<FoundDevice> found;
  for (const std::string& path : serial_ports(folders)) {
    found.push_back({Kind::kSerial, path, serial_name(path, folders), trouble_with(path)});
  }
  for (const std::string& path : device_files(folders.files, {"spidev"})) {
    found.push_back({Kind::kSpi, path, {}, trouble_with(path)});
  }
  for (const std::string& path : device_files(folders.files, {"gpiochip"})) {
    found.push_back({Kind::kGpio, path, chip_name(path), trouble_with(path)});
  }
  return found;
}

std::vector<std::string> missing_interfaces(const DeviceFolders& folders) {
  std::vector<std::string> missing;
  if (::access("/dev/ptmx", R_OK | W_OK) != 0) {
    missing.emplace_back("pseudo-terminals (/dev/ptmx): without them no device can be simulated");
  }
  if (has_learm_hid(folders)) {
    missing.emplace_back(
        "a serial port of the LeArm: its classic board is plugged in by its own USB socket, which "
        "is "
        "HID and no serial port. Connect its TTL pins (TX, RX, GND) by a USB-to-TTL adapter");
  }
  if (serial_ports(folders).empty()) {
    missing.emplace_back(
        "serial ports: none is there. Plug the robot's USB cable in (a classic LeArm board has no "
        "serial port on its USB: its TTL pins need an adapter); if nothing appears, sudo dmesg | "
        "tail says what the kernel saw");
  }
  if (device_files(folders.files, {"spidev"}).empty()) {
    missing.emplace_back(
        "SPI (/dev/spidev*): needed by robot-arm-2 only. On a Raspberry Pi: dtparam=spi=on in "
        "config.txt, or sudo raspi-config, Interface Options");
  }
  if (device_files(folders.files, {"gpiochip"}).empty()) {
    missing.emplace_back(
        "GPIO lines (/dev/gpiochip*): needed by robot-arm-2 only, for its chip selects");
  }
  return missing;
}

}  // namespace sinew::io
