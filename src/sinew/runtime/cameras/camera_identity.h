#pragma once

#include <string>

namespace sinew::runtime {

/// Which camera the text of a device means: of a camera at this computer the name that its driver
/// gives it, with its serial number; of one in the network its address, without a password; else
/// the text itself. Empty where that cannot be told: it is not plugged in.
std::string camera_identity(const std::string& device);

}  // namespace sinew::runtime
