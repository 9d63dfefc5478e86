#pragma once

#include <string>
#include <string_view>

namespace sinew {

/// Bytes as text, RFC 4648 section 4, with its = at the end.
std::string base64(std::string_view bytes);

}  // namespace sinew
