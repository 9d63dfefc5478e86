#pragma once

#include "sinew/server/json/json_rpc.h"

/// What comes back from each method and with each message, as JSON Schema (draft 7). A test holds
/// real answers of a running cell against them, and takes no field that stands in none.
namespace sinew::server {

/// By name; they refer to each other as "#/components/schemas/NAME".
Json result_schemas();

/// The schema of each message that a server sends by itself, as OpenRPC has methods' results.
Json message_schemas();

}  // namespace sinew::server
