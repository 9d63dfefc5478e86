#pragma once

#include <optional>
#include <string>

#include "sinew/runtime/procedure_runner.h"
#include "sinew/server/json/json_rpc.h"

/// A procedure as the API tells it, and as a client reads it.
namespace sinew::server {

Json procedure_json(const std::string& robot, const runtime::ProcedureStatus& status);

/// The same read back. @return  nothing where it is none
std::optional<runtime::ProcedureStatus> read_procedure(const Json& json);

}  // namespace sinew::server
