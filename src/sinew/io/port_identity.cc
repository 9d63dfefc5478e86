#include "sinew/io/port_identity.h"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace sinew::io {
namespace fs = std::filesystem;

std::vector<std::string> port_identities(const std::string& port, const DeviceFolders& folders) {
  std::error_code error;
  const fs::path device = fs::canonical(port, error);
  if (error) return {port};
  std::vector<std::string> names;
  struct stat status{};
  if (device.string().starts_with("/dev/pts/") && ::stat(device.c_str(), &status) == 0) {
    const fs::path given = fs::absolute(port, error).lexically_normal();
    if (given != device) names.push_back(given);
    names.push_back(device.string() + "@" + std::to_string(status.st_ctim.tv_sec) + "." +
                    std::to_string(status.st_ctim.tv_nsec));
    return names;
  }
  for (const char* kind : {"/serial/by-id", "/serial/by-path"}) {
    for (const auto& entry : fs::directory_iterator(folders.files + kind, error)) {
      std::error_code ignored;  // not fs::equivalent: it refuses device files
      if (fs::canonical(entry.path(), ignored) == device) names.push_back(entry.path());
    }
  }
  std::ranges::sort(names);
  if (names.empty()) names.push_back(device);
  return names;
}

}  // namespace sinew::io
