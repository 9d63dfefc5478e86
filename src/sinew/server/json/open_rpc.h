#pragma once

#include <string>

#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// The table of methods as an OpenRPC document (https://spec.open-rpc.org, 1.2.6): what may be
/// asked, with which params, who may, and what comes back, in words.
/// @param version  of the program
Json open_rpc(const std::string& version);
/// The same as text.
std::string open_rpc_text(const std::string& version);

}  // namespace sinew::server
