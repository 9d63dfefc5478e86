#pragma once

#include <deque>
#include <optional>
#include <string>
#include <variant>

#include "sinew/core/instant.h"
#include "sinew/io/port.h"
#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// A client of a server on a Unix socket, for one thread. Each of its waits is bounded.
class RpcClient {
 public:
  /// @error  nobody listens there
  static io::IoResult<RpcClient> connect(const std::string& path);

  /// Sends a request and waits for its answer; messages that come meanwhile are kept.
  /// @error  the server's, or kFailed where the connection broke or the answer took too long
  std::expected<Json, RpcError> call(std::string_view method, const Json& params = Json::object(),
                                     Duration patience = std::chrono::seconds(60));
  /// Sends a request whose answer nobody waits for.
  bool send(std::string_view method, const Json& params = Json::object());

  /// The next message that is no answer: {"method", "params"}; nothing after `patience`, or where
  /// the connection broke.
  std::optional<Json> next(Duration patience);
  bool broken() const { return broken_; }

 private:
  explicit RpcClient(io::Port port) : port_(std::move(port)) {}
  /// The next line as JSON.
  std::optional<Json> read(Duration patience);

  io::Port port_;
  std::string received_;
  std::deque<Json> kept_;
  std::uint64_t last_id_ = 0;
  bool broken_ = false;
};

}  // namespace sinew::server
