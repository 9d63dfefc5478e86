#pragma once

#include <initializer_list>
#include <string>
#include <utility>

#include "sinew/server/json/json_rpc.h"

/// What JSON Schemas are written with.
namespace sinew::server::schema {

/// To one of result_schemas(), from within an OpenRPC document.
inline Json schema_ref(const std::string& name) {
  return {{"$ref", "#/components/schemas/" + name}};
}

using Fields = std::initializer_list<std::pair<std::string, Json>>;

/// A pattern of names that end with a joint's unit: what slides has metres, and a list of both has
/// both.
inline std::string of_joint(const std::string& heads, const std::string& tail = "") {
  return "^(" + heads + ")_(rad|m|rad_m)" + tail + "$";
}

inline Json number() {
  return {{"type", "number"}};
}
inline Json text() {
  return {{"type", "string"}};
}
inline Json flag() {
  return {{"type", "boolean"}};
}
inline Json whole() {
  return {{"type", "integer"}, {"minimum", 0}};
}
inline Json integer() {
  return {{"type", "integer"}};
}
inline Json one_of(std::initializer_list<const char*> words) {
  Json list = Json::array();
  for (const char* word : words) list.push_back(word);
  return {{"type", "string"}, {"enum", std::move(list)}};
}
inline Json list(Json items) {
  return {{"type", "array"}, {"items", std::move(items)}};
}
inline Json numbers(int count) {
  return {{"type", "array"}, {"items", number()}, {"minItems", count}, {"maxItems", count}};
}
/// By names that differ from cell to cell.
inline Json table(Json values) {
  return {{"type", "object"}, {"additionalProperties", std::move(values)}};
}
inline Json ref(const char* name) {
  return schema_ref(name);
}
inline Json or_null(const char* type) {
  return {{"type", Json::array({type, "null"})}};
}

/// @param always  are there; @param perhaps  may be; @param patterns  of names that may be
inline Json object(Fields always, Fields perhaps = {}, Fields patterns = {}) {
  Json json{{"type", "object"}, {"properties", Json::object()}};
  Json required = Json::array();
  for (const auto& [name, schema] : always) {
    json["properties"][name] = schema;
    required.push_back(name);
  }
  for (const auto& [name, schema] : perhaps) json["properties"][name] = schema;
  for (const auto& [name, schema] : patterns) json["patternProperties"][name] = schema;
  if (!required.empty()) json["required"] = std::move(required);
  return json;
}

inline Json told(const char* description, Json schema) {
  schema["description"] = description;
  return schema;
}

/// Of a stop, after IEC 60204-1.
inline Json category() {
  return {{"type", "integer"}, {"minimum", 0}, {"maximum", 2}};
}

}  // namespace sinew::server::schema
