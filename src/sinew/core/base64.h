#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sinew {

/// Bytes as text, RFC 4648 section 4, with its = at the end.
std::string base64(std::string_view bytes);
/// Its inverse; nothing where that is no such text.
std::optional<std::string> from_base64(std::string_view text);

}  // namespace sinew
