#include "sinew/server/web/web_gate.h"

#include <algorithm>

#include "sinew/server/json/json_rpc.h"

namespace sinew::server {
namespace {

std::unexpected<HttpRefusal> refuse(int status, std::string sentence, std::string extra = {}) {
  return std::unexpected(HttpRefusal{status, std::move(sentence), std::move(extra)});
}

bool reads(const HttpHead& head) {
  return head.method == "GET" || head.method == "HEAD";
}

/// RFC 6455, 4.1: 16 bytes in base64.
bool is_socket_key(std::string_view key) {
  return key.size() == 24 && key.ends_with("==") &&
         std::ranges::all_of(key.substr(0, 22), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '+' || c == '/';
         });
}

/// The bytes that follow the head.
std::expected<std::size_t, HttpRefusal> body_size(const HttpHead& head) {
  const std::size_t lengths = head.count("content-length");
  if (head.count("transfer-encoding") != 0) {
    if (lengths != 0)
      return refuse(400, "Content-Length and Transfer-Encoding contradict each other");
    return refuse(411, "a body comes whole, with its Content-Length");
  }
  if (lengths > 1) return refuse(400, "a request has one Content-Length");
  if (lengths == 0) return 0;
  const std::string& text = *head.find("content-length");
  const bool digits =
      !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
  if (!digits) return refuse(400, "Content-Length is a number");
  std::size_t size = 0;
  for (const char c : text) {
    size = size * 10 + static_cast<std::size_t>(c - '0');
    if (size > kMessageMax) return refuse(413, "a message has at most 1048576 bytes");
  }
  return size;
}

/// What holds for all that has no body.
std::optional<HttpRefusal> check_no_body(const HttpHead& head) {
  const auto size = body_size(head);
  if (!size) return size.error();
  if (*size != 0) return HttpRefusal{400, "this request has no body", {}};
  return std::nullopt;
}

HttpRefusal wrong_method(std::string allowed) {
  return {405, "this address takes " + allowed + " only", "Allow: " + allowed + "\r\n"};
}

}  // namespace

std::string host_text(std::string_view host, std::uint16_t port, bool tls) {
  std::string text = lower_case(host);
  if (text.contains(':')) text = "[" + text + "]";
  return port == (tls ? 443 : 80) ? text : text + ":" + std::to_string(port);
}

WebGate::WebGate(Options options)
    : options_(std::move(options)), tokens_(options_.operator_token, options_.viewer_token) {}

std::string WebGate::origin_of(std::string_view host) const {
  return (options_.tls ? "https://" : "http://") + lower_case(host);
}

std::expected<WebRequest, HttpRefusal> WebGate::decide(std::string_view text,
                                                       const WebCaller& caller, Instant now) {
  auto head = read_head(text);
  if (!head) return std::unexpected(std::move(head.error()));
  if (auto wrong = check_host(*head, caller)) return std::unexpected(std::move(*wrong));
  if (head->target.contains('?') || head->target.contains('#')) {
    return refuse(400,
                  "no address here takes a query: a token in it would end up in logs; it travels "
                  "as Authorization: Bearer TOKEN");
  }
  if (head->find("expect") != nullptr) {
    return refuse(417, "nothing is expected here; send the body with the head");
  }
  const bool is_socket = head->target == "/ws";
  if (is_socket || head->method != "GET") {
    if (auto wrong = check_origin(*head)) return std::unexpected(std::move(*wrong));
  }
  if (is_socket) return socket(std::move(*head), caller, now);
  if (head->target == "/rpc") return rpc(std::move(*head), caller, now);
  if (head->target == "/openrpc.json") return document(std::move(*head), caller, now);
  return page(std::move(*head));
}

/// A page that has led its visitor's browser here by a name of its own (DNS rebinding) calls this
/// server by that name.
std::optional<HttpRefusal> WebGate::check_host(const HttpHead& head,
                                               const WebCaller& caller) const {
  if (head.count("host") != 1) return HttpRefusal{400, "a request has one Host", {}};
  const std::string host = lower_case(*head.find("host"));
  if (host == caller.reached || std::ranges::find(options_.hosts, host) != options_.hosts.end()) {
    return std::nullopt;
  }
  std::string names;
  for (const std::string& one : options_.hosts) names += (names.empty() ? "" : ", ") + one;
  return HttpRefusal{421,
                     "this server is not called so; it answers to " + names +
                         "; sinew serve --host NAME:PORT adds a name",
                     {}};
}

/// Browsers say which page sends a request; programs that are none say nothing.
std::optional<HttpRefusal> WebGate::check_origin(const HttpHead& head) const {
  const std::size_t count = head.count("origin");
  if (count == 0) return std::nullopt;
  if (count > 1) return HttpRefusal{400, "a request has one Origin", {}};
  if (*head.find("origin") == origin_of(*head.find("host"))) return std::nullopt;
  return HttpRefusal{403, "pages of other origins are not served", {}};
}

std::expected<Role, HttpRefusal> WebGate::admit(std::string_view token, const WebCaller& caller,
                                                Instant now) {
  switch (tokens_.judge(token, caller.address, now)) {
    case WebTokens::Verdict::kViewer:
      return Role::kViewer;
    case WebTokens::Verdict::kOperator:
      return Role::kOperator;
    case WebTokens::Verdict::kWrong:
      return refuse(401, "this token is not the one of this server",
                    "WWW-Authenticate: Bearer realm=\"sinew\", error=\"invalid_token\"\r\n");
    case WebTokens::Verdict::kTooManyWrong:
      break;
  }
  const auto wait = std::chrono::ceil<std::chrono::seconds>(tokens_.wait(caller.address, now));
  return refuse(429, "too many wrong tokens came from this address; wait a minute",
                "Retry-After: " + std::to_string(wait.count()) + "\r\n");
}

std::expected<Role, HttpRefusal> WebGate::bearer(const HttpHead& head, const WebCaller& caller,
                                                 Instant now) {
  constexpr std::string_view kScheme = "bearer ";
  if (head.count("authorization") > 1) return refuse(400, "a request has one Authorization");
  const std::string* value = head.find("authorization");
  if (value == nullptr) {
    return refuse(401, "this needs a token: Authorization: Bearer TOKEN",
                  "WWW-Authenticate: Bearer realm=\"sinew\"\r\n");
  }
  if (!lower_case(*value).starts_with(kScheme)) {
    return refuse(401, "Authorization here is Bearer TOKEN",
                  "WWW-Authenticate: Bearer realm=\"sinew\"\r\n");
  }
  return admit(std::string_view(*value).substr(kScheme.size()), caller, now);
}

std::expected<WebRequest, HttpRefusal> WebGate::page(HttpHead head) const {
  const std::string_view path = head.target == "/" ? "/index.html" : std::string_view(head.target);
  const auto found = std::ranges::find(options_.assets, path, &Asset::path);
  WebRequest request;
  if (found != options_.assets.end()) {
    request.asset = &*found;
  } else if (head.target == "/" && options_.assets.empty()) {
    request.kind = WebRequest::Kind::kNoPanel;
  } else {
    return refuse(404, "nothing has this address");
  }
  if (!reads(head)) return std::unexpected(wrong_method("GET, HEAD"));
  if (auto wrong = check_no_body(head)) return std::unexpected(std::move(*wrong));
  if (request.asset != nullptr) {
    if (!head.lists("accept-encoding", "gzip") && !head.lists("accept-encoding", "*")) {
      return refuse(406, "this file is kept compressed; ask with Accept-Encoding: gzip");
    }
    request.not_modified = head.lists("if-none-match", request.asset->etag);
  }
  request.head_only = head.method == "HEAD";
  request.close = head.lists("connection", "close");
  request.head = std::move(head);
  return request;
}

std::expected<WebRequest, HttpRefusal> WebGate::document(HttpHead head, const WebCaller& caller,
                                                         Instant now) {
  if (!reads(head)) return std::unexpected(wrong_method("GET, HEAD"));
  const auto role = bearer(head, caller, now);
  if (!role) return std::unexpected(role.error());
  if (auto wrong = check_no_body(head)) return std::unexpected(std::move(*wrong));
  WebRequest request;
  request.kind = WebRequest::Kind::kDocument;
  request.role = *role;
  request.head_only = head.method == "HEAD";
  request.close = head.lists("connection", "close");
  request.head = std::move(head);
  return request;
}

std::expected<WebRequest, HttpRefusal> WebGate::rpc(HttpHead head, const WebCaller& caller,
                                                    Instant now) {
  if (head.method != "POST") return std::unexpected(wrong_method("POST"));
  const auto role = bearer(head, caller, now);
  if (!role) return std::unexpected(role.error());
  const auto size = body_size(head);
  if (!size) return std::unexpected(size.error());
  if (head.count("content-length") == 0) {
    return refuse(411, "a body comes whole, with its Content-Length");
  }
  const std::string* type = head.find("content-type");
  const std::string kind = type != nullptr ? lower_case(type->substr(0, type->find(';'))) : "";
  if (head.count("content-type") != 1 || kind.substr(0, kind.find(' ')) != "application/json") {
    return refuse(415, "a message is Content-Type: application/json");
  }
  if (head.find("content-encoding") != nullptr) {
    return refuse(415, "a message comes as it is, without Content-Encoding");
  }
  WebRequest request;
  request.kind = WebRequest::Kind::kRpc;
  request.role = *role;
  request.body = *size;
  request.close = head.lists("connection", "close");
  request.head = std::move(head);
  return request;
}

std::expected<WebRequest, HttpRefusal> WebGate::socket(HttpHead head, const WebCaller& caller,
                                                       Instant now) {
  if (head.method != "GET") return std::unexpected(wrong_method("GET"));
  if (auto wrong = check_no_body(head)) return std::unexpected(std::move(*wrong));
  if (!head.lists("upgrade", "websocket") || !head.lists("connection", "upgrade")) {
    return refuse(426, "this address is a WebSocket", "Upgrade: websocket\r\n");
  }
  const std::string* version = head.find("sec-websocket-version");
  if (head.count("sec-websocket-version") != 1 || *version != "13") {
    return refuse(426, "WebSockets here have version 13", "Sec-WebSocket-Version: 13\r\n");
  }
  if (head.count("sec-websocket-key") != 1 || !is_socket_key(*head.find("sec-websocket-key"))) {
    return refuse(400, "Sec-WebSocket-Key is 16 bytes in base64");
  }
  std::vector<std::string_view> tokens;
  bool others = false;
  WebRequest request;
  for (const HttpField& field : head.fields) {
    if (field.name != "sec-websocket-protocol") continue;
    for (const std::string_view word : words_between_commas(field.value)) {
      if (word.starts_with(kBearerSubprotocol)) {
        tokens.push_back(word.substr(kBearerSubprotocol.size()));
      } else if (word == kSubprotocol) {
        request.subprotocol = true;
      } else {
        others = true;
      }
    }
  }
  if ((others || !tokens.empty()) && !request.subprotocol) {
    return refuse(400, "the subprotocol here is sinew.v1");
  }
  const bool has_header = head.find("authorization") != nullptr;
  if (tokens.size() + (has_header ? 1 : 0) > 1) return refuse(400, "one token is enough");
  if (has_header || !tokens.empty()) {
    const auto role = has_header ? bearer(head, caller, now) : admit(tokens[0], caller, now);
    if (!role) return std::unexpected(role.error());
    request.role = *role;
  }
  request.kind = WebRequest::Kind::kSocket;
  request.head = std::move(head);
  return request;
}

}  // namespace sinew::server
