#include "sinew/server/open_rpc.h"

#include "sinew/server/methods.h"

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

Json method_json(const Method& method) {
  Json params = Json::array();
  for (const Param& param : method.params) {
    params.push_back(
        {{"name", param.name},
         {"summary", std::string(type_name(param.type)) + ": " + std::string(param.meaning)},
         {"required", param.required},
         {"schema", schema_of(param.type)}});
  }
  // What comes back is told in words: each answer is an object, or a value that these name.
  return {{"name", method.name},
          {"summary", method.meaning},
          {"paramStructure", "by-name"},
          {"params", params},
          {"result",
           {{"name", "result"}, {"summary", method.result}, {"schema", {{"type", "object"}}}}},
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
          {"methods", list}};
}

std::string open_rpc_text(const std::string& version) {
  return open_rpc(version).dump(2) + "\n";
}

}  // namespace sinew::server
