#pragma once

#include <cstdint>
#include <expected>
#include <string>

namespace sinew::runtime {

/// Where a camera's pictures are in the network.
struct HttpAddress {
  std::string host;  ///< a name, or a number without brackets
  std::uint16_t port = 80;
  std::string target;         ///< path and query, begins with '/'
  std::string authorization;  ///< "Basic ..."; empty where no user is given

  /// What a GET of it sends. The reply is to end with the connection.
  std::string request() const;
  /// Without user and password.
  std::string shown() const;
};

/// Reads http://[USER:PASSWORD@]HOST[:PORT][/PATH]; user and password may hold %XX.
/// @error  a sentence: https, no host, a port out of range, blanks and control characters
std::expected<HttpAddress, std::string> read_http_address(const std::string& text);

}  // namespace sinew::runtime
