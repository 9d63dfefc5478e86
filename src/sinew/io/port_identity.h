#pragma once

#include <string>
#include <vector>

#include "sinew/io/machine_check.h"

namespace sinew::io {

/// What the device behind a port is known by, whatever the port is called today. A serial adapter:
/// its links in /dev/serial/by-id and by-path, else the device's path. A pseudo-terminal: the path
/// of the link to it, if one was given, and its own path with its time of creation, since its
/// number is used again. Anything else, and what is not there: the name as given.
std::vector<std::string> port_identities(const std::string& port,
                                         const DeviceFolders& folders = {});

}  // namespace sinew::io
