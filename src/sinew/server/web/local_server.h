#pragma once

#include <memory>
#include <string>

#include "sinew/io/io_error.h"
#include "sinew/io/local_socket.h"
#include "sinew/server/web/server_loop.h"

namespace sinew::server {

/// Serves an Api on a Unix socket: a JSON-RPC message a line, both ways. Whoever can connect is an
/// operator: the socket is this user's alone.
class LocalServer {
 public:
  /// @param loop  outlives this
  /// @error  the socket cannot be had: another server listens there, no such folder, ..
  static io::IoResult<std::unique_ptr<LocalServer>> listen(const std::string& path,
                                                           ServerLoop& loop);
  ~LocalServer();
  LocalServer(const LocalServer&) = delete;
  LocalServer& operator=(const LocalServer&) = delete;

  const std::string& path() const;

 private:
  class Implementation;
  explicit LocalServer(std::shared_ptr<Implementation> implementation);
  std::shared_ptr<Implementation> implementation_;
};

}  // namespace sinew::server
