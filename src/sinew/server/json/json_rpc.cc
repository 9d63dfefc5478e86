#include "sinew/server/json/json_rpc.h"

#include <algorithm>

namespace sinew::server {
namespace {

constexpr std::size_t kIdMax = 128;  // bytes of a string that serves as id
constexpr std::size_t kMethodNameMax = 64;

std::unexpected<BadRequest> bad(const Json& id, RpcCode code, std::string message) {
  return std::unexpected(BadRequest{id, {code, std::move(message), nullptr}});
}

bool fits_id(const Json& id) {
  if (id.is_null() || id.is_number_integer()) return true;
  return id.is_string() && id.get_ref<const std::string&>().size() <= kIdMax;
}

}  // namespace

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool too_deep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if (in_string) {
      if (c == '\\') ++k;
      in_string = c != '"';
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDepthMax) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

std::expected<RpcRequest, BadRequest> read_request(std::string_view text) {
  if (text.size() > kMessageMax) {
    return bad(nullptr, RpcCode::kParseError, "a message has at most 1048576 bytes");
  }
  if (too_deep(text)) {
    return bad(nullptr, RpcCode::kParseError, "a message is nested 24 deep at most");
  }
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) return bad(nullptr, RpcCode::kParseError, "this is no JSON");
  if (json.is_array()) {
    return bad(nullptr, RpcCode::kInvalidRequest,
               "batches are not taken; send one request a message");
  }
  if (!json.is_object()) {
    return bad(nullptr, RpcCode::kInvalidRequest, "a request is an object");
  }
  RpcRequest request;
  const auto id = json.find("id");
  if (id != json.end() && !fits_id(*id)) {
    return bad(nullptr, RpcCode::kInvalidRequest, "an id is a whole number or a short string");
  }
  request.answered = id != json.end();
  if (request.answered) request.id = *id;
  const auto version = json.find("jsonrpc");
  if (version == json.end() || *version != "2.0") {
    return bad(request.id, RpcCode::kInvalidRequest, "jsonrpc has to be \"2.0\"");
  }
  const auto method = json.find("method");
  if (method == json.end() || !method->is_string() ||
      method->get_ref<const std::string&>().size() > kMethodNameMax) {
    return bad(request.id, RpcCode::kInvalidRequest, "method has to be the name of one");
  }
  request.method = method->get<std::string>();
  const auto params = json.find("params");
  if (params != json.end()) {
    if (!params->is_object()) {
      return bad(request.id, RpcCode::kInvalidParams, "params are named: an object");
    }
    request.params = std::move(*params);
  }
  return request;
}

std::string result_text(const Json& id, const Json& result) {
  return text_of({{"jsonrpc", "2.0"}, {"id", id}, {"result", result}});
}

std::string result_of_text(const Json& id, std::string_view result) {
  std::string text = R"({"jsonrpc":"2.0","id":)" + text_of(id) + R"(,"result":)";
  text.reserve(text.size() + result.size() + 1);
  return (text += result) += '}';
}

std::string error_text(const Json& id, const RpcError& error) {
  Json object{{"code", static_cast<int>(error.code)}, {"message", error.message}};
  if (!error.data.is_null()) object["data"] = error.data;
  return text_of({{"jsonrpc", "2.0"}, {"id", id}, {"error", object}});
}

std::string notification_of_text(std::string_view method, std::string_view params) {
  std::string text = R"({"jsonrpc":"2.0","method":")" + std::string(method) + R"(","params":)";
  return (text += params) += '}';
}

std::string notification_text(std::string_view method, const Json& params) {
  return text_of({{"jsonrpc", "2.0"}, {"method", method}, {"params", params}});
}

std::string request_text(std::uint64_t id, std::string_view method, const Json& params) {
  return text_of({{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}});
}

}  // namespace sinew::server
