#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

/// Parts of the messages of a record and of their JSON schemas.
namespace sinew::runtime::record {

using Json = nlohmann::ordered_json;

/// Bytes that are no UTF-8 are replaced.
inline std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

inline Json number() {
  return {{"type", "number"}};
}
inline Json text() {
  return {{"type", "string"}};
}
inline Json whole() {
  return {{"type", "integer"}};
}
inline Json object(Json properties) {
  return {{"type", "object"}, {"properties", std::move(properties)}};
}
inline Json list(Json items) {
  return {{"type", "array"}, {"items", std::move(items)}};
}

/// Foxglove's time. @param ns  since 1970
inline Json time_schema() {
  return object({{"sec", whole()}, {"nsec", whole()}});
}
inline Json time_json(std::uint64_t ns) {
  return {{"sec", ns / 1'000'000'000}, {"nsec", ns % 1'000'000'000}};
}

}  // namespace sinew::runtime::record
