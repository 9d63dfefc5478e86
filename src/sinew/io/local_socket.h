#pragma once

#include <optional>
#include <string>

#include "sinew/io/port.h"

namespace sinew::io {

/// A Unix socket that this user's programs may connect to (mode 0600). Its file goes away with it.
class LocalListener {
 public:
  LocalListener(LocalListener&& other) noexcept;
  LocalListener& operator=(LocalListener&&) = delete;
  ~LocalListener();

  /// @error  the name is too long, in a folder that is not there, or taken: by a file, or by a
  ///         program that listens. A socket that nobody listens to any more is replaced.
  /// @param waiting  how many clients may wait to be let in
  static IoResult<LocalListener> create(const std::string& path, int waiting = 1);

  /// The next client, or nothing after `timeout`.
  IoResult<std::optional<Port>> accept(Duration timeout);

  const std::string& path() const { return path_; }
  /// For whoever waits for clients by other means; stays with this.
  int descriptor() const { return descriptor_; }
  /// The next client's descriptor, which is the caller's from now on; -1 where there is none.
  int accept_descriptor() const;

 private:
  LocalListener(std::string path, int descriptor)
      : path_(std::move(path)), descriptor_(descriptor) {}

  std::string path_;
  int descriptor_ = -1;
};

/// Where this user's servers have their sockets: a folder of its own (mode 0700) in
/// runtime_folder(), made where it is not there.
/// @error  it cannot be made, or is somebody else's
IoResult<std::string> socket_folder();

/// Connects to one. @error nobody listens there
IoResult<Port> connect_local(const std::string& path);

/// Connects to HOST:PORT. @error  no such host, nobody listens there
IoResult<Port> connect_tcp(const std::string& host_and_port);

/// This process' own stdin and stdout as one port.
IoResult<Port> standard_port();

}  // namespace sinew::io
