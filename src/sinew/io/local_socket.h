#pragma once

#include <optional>
#include <string>

#include "sinew/io/port.h"

namespace sinew::io {

/// A Unix socket that one client at a time may connect to. Its file goes away with it.
class LocalListener {
 public:
  LocalListener(LocalListener&& other) noexcept;
  LocalListener& operator=(LocalListener&&) = delete;
  ~LocalListener();

  /// @error  the name is too long, in a folder that is not there, or taken: by a file, or by a
  ///         program that listens. A socket that nobody listens to any more is replaced.
  static IoResult<LocalListener> create(const std::string& path);

  /// The next client, or nothing after `timeout`.
  IoResult<std::optional<Port>> accept(Duration timeout);

  const std::string& path() const { return path_; }

 private:
  LocalListener(std::string path, int descriptor)
      : path_(std::move(path)), descriptor_(descriptor) {}

  std::string path_;
  int descriptor_ = -1;
};

/// Connects to one. @error nobody listens there
IoResult<Port> connect_local(const std::string& path);

/// Connects to HOST:PORT. @error  no such host, nobody listens there
IoResult<Port> connect_tcp(const std::string& host_and_port);

/// This process' own stdin and stdout as one port.
IoResult<Port> standard_port();

}  // namespace sinew::io
