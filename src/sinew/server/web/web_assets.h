#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace sinew::server {

/// A file of the panel, as it stands in the program.
struct Asset {
  std::string_view path;  ///< in its address: "/index.html", "/assets/..."
  std::string_view type;  ///< "text/html; charset=utf-8"
  std::string_view etag;  ///< its hash, in double quotes
  std::span<const std::uint8_t> gzip;
};

/// All of them; none in a build without a panel. "/index.html" is what `/` shows.
std::span<const Asset> web_assets();

}  // namespace sinew::server
