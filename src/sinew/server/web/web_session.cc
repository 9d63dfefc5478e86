#include "sinew/server/web/web_session.h"

#include <algorithm>

namespace sinew::server {

std::expected<std::size_t, HttpRefusal> head_size(std::string_view received) {
  const auto refuse = [](int status, const char* sentence) {
    return std::unexpected(HttpRefusal{status, sentence, {}});
  };
  if (received.empty()) return 0;
  if (received.front() < 'A' || received.front() > 'Z') {
    return refuse(400, "a request begins with METHOD /PATH HTTP/1.1");
  }
  const std::size_t end = received.find("\r\n\r\n");
  const std::string_view head =
      received.substr(0, end == std::string_view::npos ? received.size() : end + 4);
  if (head.size() > kHeadMax) return refuse(431, "the head of a request has at most 16 KiB");
  for (std::size_t k = head.find('\n'); k != std::string_view::npos; k = head.find('\n', k + 1)) {
    if (k == 0 || head[k - 1] != '\r') return refuse(400, "lines of a head end with CR LF");
  }
  return end == std::string_view::npos ? 0 : head.size();
}

std::expected<SessionOpen, BadRequest> read_session_open(std::string_view text) {
  constexpr const char* kWanted =
      "the first message here is session.open with the token: "
      "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"session.open\",\"params\":{\"token\":\"...\"}}";
  auto request = read_request(text);
  if (!request) return std::unexpected(std::move(request.error()));
  const auto token = request->params.find("token");
  if (request->method != "session.open" || !request->answered || request->params.size() != 1 ||
      token == request->params.end() || !token->is_string()) {
    return std::unexpected(BadRequest{request->id, RpcError{RpcCode::kRefused, kWanted, nullptr}});
  }
  return SessionOpen{request->id, token->get<std::string>()};
}

bool is_answered(std::string_view text) {
  const auto request = read_request(text);
  return !request || request->answered;
}

std::string_view role_name(Role role) {
  return role == Role::kOperator ? "operator" : "viewer";
}

void WebPace::pass(Instant now) {
  if (last_) credit_ += kPerSecond * to_seconds(now - *last_);
  credit_ = std::min(credit_, kCreditMax);
  last_ = now;
}

}  // namespace sinew::server
