#include "sinew/runtime/cameras/camera_identity.h"

#include <filesystem>

#include "sinew/io/file.h"

namespace sinew::runtime {
namespace {

/// The first line of a file of the system; empty where there is none.
std::string line_of(const std::string& path) {
  const auto text = io::read_file(path);
  return text ? text->substr(0, text->find('\n')) : std::string();
}

std::string of_device_file(const std::string& device) {
  std::error_code error;
  const auto file = std::filesystem::weakly_canonical(device, error);
  if (error) return {};
  const std::string about = "/sys/class/video4linux/" + file.filename().string();
  const std::string name = line_of(about + "/name");
  const std::string serial = line_of(about + "/device/../serial");
  return serial.empty() ? name : name + " (serial number " + serial + ")";
}

}  // namespace

std::string camera_identity(const std::string& device) {
  if (device.starts_with("/dev/")) return of_device_file(device);
  const std::size_t scheme = device.find("://");
  if (scheme == std::string::npos) return device;
  const std::size_t host = scheme + 3;
  const std::size_t end = device.find('/', host);
  const std::size_t password = device.rfind('@', end);
  if (password == std::string::npos || password < host) return device;
  return device.substr(0, host) + device.substr(password + 1);
}

}  // namespace sinew::runtime
