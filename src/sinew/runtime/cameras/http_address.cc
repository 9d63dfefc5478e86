#include "sinew/runtime/cameras/http_address.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "sinew/core/base64.h"

namespace sinew::runtime {
namespace {

constexpr std::string_view kAddressForm = "; write http://HOST:PORT/PATH";

/// Letters that were written as %XX.
std::string without_escapes(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned value = 0;
    if (text[i] == '%' && i + 2 < text.size()) {
      const auto end = std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16);
      if (end.ec == std::errc{} && end.ptr == text.data() + i + 3) {
        result += static_cast<char>(value);
        i += 2;
        continue;
      }
    }
    result += text[i];
  }
  return result;
}

std::optional<std::uint16_t> port_in(std::string_view digits) {
  std::uint16_t port = 0;
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  const bool is_whole = end.ec == std::errc{} && end.ptr == digits.data() + digits.size();
  return is_whole && port > 0 ? std::optional(port) : std::nullopt;
}

}  // namespace

std::string HttpAddress::request() const {
  const bool is_number_6 = host.contains(':');
  std::string text = "GET " + target + " HTTP/1.1\r\nHost: ";
  text += is_number_6 ? "[" + host + "]" : host;
  if (port != 80) text += ":" + std::to_string(port);
  text += "\r\nUser-Agent: sinew\r\nAccept: multipart/x-mixed-replace, image/jpeg, */*\r\n";
  if (!authorization.empty()) text += "Authorization: " + authorization + "\r\n";
  return text + "Connection: close\r\n\r\n";
}

std::string HttpAddress::shown() const {
  const std::string where = host.contains(':') ? "[" + host + "]" : host;
  return "http://" + where + (port != 80 ? ":" + std::to_string(port) : "") + target;
}

std::expected<HttpAddress, std::string> read_http_address(const std::string& text) {
  constexpr std::string_view kScheme = "http://";
  if (text.starts_with("https://")) {
    return std::unexpected(
        "https is not read; switch it off in the camera's settings and write "
        "http://HOST:PORT/PATH");
  }
  const bool is_clean = std::ranges::all_of(
      text, [](unsigned char c) { return c > 0x20 && c < 0x7F; });  // else they end up in a request
  if (!text.starts_with(kScheme) || !is_clean) {
    return std::unexpected("no address of a camera" + std::string(kAddressForm));
  }
  std::string_view rest = std::string_view(text).substr(kScheme.size());
  rest = rest.substr(0, std::min(rest.find('#'), rest.size()));
  const std::size_t slash = std::min(rest.find_first_of("/?"), rest.size());
  std::string_view place = rest.substr(0, slash);
  HttpAddress address;
  address.target = rest.substr(slash);
  if (!address.target.starts_with('/')) address.target = "/" + address.target;
  if (const std::size_t at = place.rfind('@'); at != std::string_view::npos) {
    const std::string user = without_escapes(place.substr(0, at));
    address.authorization = "Basic " + base64(user.contains(':') ? user : user + ":");
    place.remove_prefix(at + 1);
  }
  const std::size_t bracket = place.starts_with('[') ? place.find(']') : std::string_view::npos;
  const std::size_t colon =
      bracket != std::string_view::npos ? place.find(':', bracket) : place.find(':');
  address.host = place.substr(0, std::min(colon, place.size()));
  if (bracket != std::string_view::npos) address.host = place.substr(1, bracket - 1);
  if (address.host.empty() || address.host.starts_with('[')) {
    return std::unexpected("an address without a host" + std::string(kAddressForm));
  }
  if (colon != std::string_view::npos) {
    const auto port = port_in(place.substr(colon + 1));
    if (!port)
      return std::unexpected("a port that is no number from 1 to 65535" +
                             std::string(kAddressForm));
    address.port = *port;
  }
  return address;
}

}  // namespace sinew::runtime
