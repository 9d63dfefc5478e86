#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

/// JSON-RPC 2.0 messages as texts: https://www.jsonrpc.org/specification. Batches are not taken.
namespace sinew::server {

using Json = nlohmann::ordered_json;

/// Codes below -32000 are the specification's.
enum class RpcCode : int {
  kParseError = -32700,
  kInvalidRequest = -32600,
  kMethodNotFound = -32601,
  kInvalidParams = -32602,
  kRefused = 1,  ///< understood, and not done: data says why
  kFailed = 2,   ///< begun, and not finished
  kStopped = 3,  ///< begun, and ended by a stop
  kBusy = 4,     ///< too much of it at once
};

struct RpcError {
  RpcCode code = RpcCode::kRefused;
  std::string message;  ///< one sentence for people
  Json data = nullptr;  ///< for machines; null where there is nothing more
};

/// Params that do not fit.
inline RpcError invalid(std::string message) {
  return {RpcCode::kInvalidParams, std::move(message), nullptr};
}

struct RpcRequest {
  Json id = nullptr;  ///< null: a notification, to which nobody answers
  bool answered = false;
  std::string method;
  Json params = Json::object();

  /// @name Params that may be left out, of types that check() has looked at
  /// @{
  bool flag(const char* name) const { return params.value(name, false); }
  std::uint64_t whole(const char* name, std::uint64_t usual) const {
    return params.value(name, usual);
  }
  double number(const char* name, double usual) const { return params.value(name, usual); }
  std::string text(const char* name) const { return params.value(name, std::string()); }
  /// @}
};

/// What could be read of a message that is none.
struct BadRequest {
  Json id = nullptr;
  RpcError error;
};

inline constexpr std::size_t kMessageMax = std::size_t{1} << 20;  ///< bytes
inline constexpr int kDepthMax = 24;                              ///< of nesting

/// Reads one message, whatever its bytes are.
/// @error  no JSON (also: not UTF-8, too long, too deep), or no request
std::expected<RpcRequest, BadRequest> read_request(std::string_view text);

/// One line; bytes that are no UTF-8 are replaced.
std::string text_of(const Json& json);
/// Of brackets outside of strings; the reader itself is not asked for more.
bool too_deep(std::string_view text);

/// As texts without a line break.
std::string result_text(const Json& id, const Json& result);
/// @param result  JSON already
std::string result_of_text(const Json& id, std::string_view result);
std::string error_text(const Json& id, const RpcError& error);
/// @param params  JSON already
std::string notification_of_text(std::string_view method, std::string_view params);
std::string notification_text(std::string_view method, const Json& params);
std::string request_text(std::uint64_t id, std::string_view method, const Json& params);

}  // namespace sinew::server
