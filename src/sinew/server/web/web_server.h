#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sinew/io/io_error.h"
#include "sinew/server/web/server_loop.h"
#include "sinew/server/web/web_assets.h"

namespace sinew::server {

struct WebOptions {
  std::string listen = "127.0.0.1:8700";  ///< HOST:PORT; a free port where it is 0
  std::vector<std::string> hosts = {};    ///< HOST:PORT by which it may be called besides
  std::string operator_token = {};
  std::string viewer_token = {};
  std::string tls_certificate = {};  ///< a file, PEM; empty: no TLS
  std::string tls_key = {};
  bool insecure_network = false;  ///< may be heard beyond this machine without TLS
  std::span<const Asset> assets = {};
};

/// The network door of an Api: files of the panel, POST /rpc, and a WebSocket, on one port. What is
/// served to whom is web_gate's; this bounds what it costs.
class WebServer {
 public:
  /// WebSockets that are let in, and connections that have posted a message and are still open.
  static constexpr std::size_t kSocketsMax = 50;
  static constexpr std::size_t kPostersMax = 4;
  /// Connections that have not shown a token. Where one more comes, the oldest of them goes: who
  /// dawdles cannot keep others out.
  static constexpr std::size_t kStrangersMax = 64;

  /// @param loop  outlives this
  /// @error  no such address, it is taken, it is beyond this machine and neither TLS nor
  ///         insecure_network is there, the files of TLS
  static io::IoResult<std::unique_ptr<WebServer>> listen(WebOptions options, ServerLoop& loop);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// `http://127.0.0.1:8700/`
  const std::string& url() const;
  std::uint16_t port() const;
  /// Nobody beyond this machine can reach it.
  bool loopback() const;

 private:
  class Implementation;
  explicit WebServer(std::shared_ptr<Implementation> implementation);
  std::shared_ptr<Implementation> implementation_;
};

}  // namespace sinew::server
