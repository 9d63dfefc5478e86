#pragma once

#include <cstddef>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/server/web/http_head.h"
#include "sinew/server/web/web_assets.h"
#include "sinew/server/web/web_tokens.h"

namespace sinew::server {

/// What WebSockets here speak: each text frame one JSON-RPC message.
inline constexpr std::string_view kSubprotocol = "sinew.v1";
/// In front of a token that travels as a subprotocol, where browsers can set no header.
inline constexpr std::string_view kBearerSubprotocol = "bearer.";

/// Who sends a request, as the connection knows.
struct WebCaller {
  std::string address;  ///< its own, without port
  std::string reached;  ///< HOST:PORT on this side: by an address nobody can be led astray
};

/// A request that may be served.
struct WebRequest {
  enum class Kind : std::uint8_t {
    kAsset,     ///< a file of the panel
    kNoPanel,   ///< `/` in a build without one
    kDocument,  ///< the OpenRPC document
    kRpc,       ///< a message in the body
    kSocket,    ///< a WebSocket
  };
  Kind kind = Kind::kAsset;
  const Asset* asset = nullptr;
  std::optional<Role> role;  ///< kSocket: nothing where the first message has to bring the token
  std::size_t body = 0;      ///< bytes that follow
  bool head_only = false;
  bool not_modified = false;
  bool close = false;        ///< the connection ends behind the answer
  bool subprotocol = false;  ///< was offered, and is agreed to
  HttpHead head;
};

/// Decides on each request of the network door by its head alone, before anything else of it is
/// read. Nothing in here has a socket or a clock. docs/web.md says what is protected against what.
class WebGate {
 public:
  struct Options {
    bool tls = false;
    /// HOST:PORT as clients may call this server, in lower case; without the port where it is the
    /// scheme's own.
    std::vector<std::string> hosts = {};
    std::string operator_token = {};
    std::string viewer_token = {};
    std::span<const Asset> assets = {};
  };

  explicit WebGate(Options options);

  /// @param head  with its empty line
  std::expected<WebRequest, HttpRefusal> decide(std::string_view head, const WebCaller& caller,
                                                Instant now);
  /// A token by itself: of a WebSocket's first message.
  std::expected<Role, HttpRefusal> admit(std::string_view token, const WebCaller& caller,
                                         Instant now);
  /// `http://HOST` or `https://HOST`.
  std::string origin_of(std::string_view host) const;

 private:
  std::optional<HttpRefusal> check_host(const HttpHead& head, const WebCaller& caller) const;
  std::optional<HttpRefusal> check_origin(const HttpHead& head) const;
  std::expected<Role, HttpRefusal> bearer(const HttpHead& head, const WebCaller& caller,
                                          Instant now);
  std::expected<WebRequest, HttpRefusal> page(HttpHead head) const;
  std::expected<WebRequest, HttpRefusal> document(HttpHead head, const WebCaller& caller,
                                                  Instant now);
  std::expected<WebRequest, HttpRefusal> rpc(HttpHead head, const WebCaller& caller, Instant now);
  std::expected<WebRequest, HttpRefusal> socket(HttpHead head, const WebCaller& caller,
                                                Instant now);

  Options options_;
  WebTokens tokens_;
};

/// HOST:PORT as it stands in addresses and in the Host field: without the scheme's own port.
std::string host_text(std::string_view host, std::uint16_t port, bool tls);

}  // namespace sinew::server
