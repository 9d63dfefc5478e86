#include "sinew/server/json/open_rpc.h"

#include "sinew/server/json/methods.h"
#include "sinew/server/json/result_schemas.h"
#include "sinew/server/json/schema_words.h"

namespace sinew::server {
namespace {

/// JSON Schema (draft 7) of what methods.cc lets through.
Json schema_of(ParamType type) {
  switch (type) {
    case ParamType::kRobot:
    case ParamType::kText:
      return {{"type", "string"}};
    case ParamType::kNumber:
      return {{"type", "number"}};
    case ParamType::kWhole:
      return {{"type", "integer"}, {"minimum", 0}};
    case ParamType::kFlag:
      return {{"type", "boolean"}};
    case ParamType::kNumbers:
      return {{"type", "array"}, {"items", {{"type", "number"}}}, {"maxItems", kNumbersMax}};
    case ParamType::kTexts:
      return {{"type", "object"},
              {"additionalProperties", {{"type", "string"}}},
              {"maxProperties", kTextsMax}};
    case ParamType::kNames:
      return {{"type", "array"}, {"items", {{"type", "string"}}}, {"maxItems", kTextsMax}};
  }
  return true;
}

struct Failure {
  const char* name;
  RpcCode code;
  const char* message;
};

/// Any method may answer with any of them.
constexpr Failure kFailures[] = {
    {"InvalidRequest", RpcCode::kInvalidRequest, "no request"},
    {"MethodNotFound", RpcCode::kMethodNotFound, "no method of this name"},
    {"InvalidParams", RpcCode::kInvalidParams, "params that do not fit; nothing has happened"},
    {"Refused", RpcCode::kRefused, "understood, and not done; data is a Refusal"},
    {"Failed", RpcCode::kFailed, "begun, and not finished; data is a Refusal"},
    {"Stopped", RpcCode::kStopped, "stopped"},
    {"Busy", RpcCode::kBusy, "too much of it at once"},
};

Json errors_json() {
  Json errors = Json::object();
  for (const Failure& one : kFailures) {
    errors[one.name] = {{"code", static_cast<int>(one.code)}, {"message", one.message}};
  }
  return errors;
}

Json error_refs() {
  Json refs = Json::array();
  for (const Failure& one : kFailures) {
    refs.push_back({{"$ref", std::string("#/components/errors/") + one.name}});
  }
  return refs;
}

Json method_json(const Method& method) {
  Json params = Json::array();
  for (const Param& param : method.params) {
    params.push_back(
        {{"name", param.name},
         {"summary", std::string(type_name(param.type)) + ": " + std::string(param.meaning)},
         {"required", param.required},
         {"schema", schema_of(param.type)}});
  }
  return {{"name", method.name},
          {"summary", method.meaning},
          {"paramStructure", "by-name"},
          {"params", params},
          {"result",
           {{"name", "result"},
            {"summary", method.result},
            {"schema", schema::schema_ref(std::string(method.schema))}}},
          {"errors", error_refs()},
          {"x-role", method.moves ? "operator" : "viewer"}};
}

}  // namespace

Json open_rpc(const std::string& version) {
  Json list = Json::array();
  for (const Method& method : methods()) list.push_back(method_json(method));
  return {{"openrpc", "1.2.6"},
          {"info",
           {{"title", "Sinew: a running cell"},
            {"version", version},
            {"description",
             "JSON-RPC 2.0 over a WebSocket (/ws), HTTP (POST /rpc) and a Unix socket. Numbers are "
             "SI and radians, as their names say. Methods with x-role operator move machines."}}},
          {"methods", list},
          {"x-messages", message_schemas()},
          {"components", {{"schemas", result_schemas()}, {"errors", errors_json()}}}};
}

std::string open_rpc_text(const std::string& version) {
  return open_rpc(version).dump(2) + "\n";
}

}  // namespace sinew::server
