#pragma once

#include <string>
#include <string_view>

namespace sinew::cli {

/// Text that terminals and XML show as it stands: control characters other than line feed and tab,
/// and what is no UTF-8, become \xNN.
std::string shown(std::string_view text);

}  // namespace sinew::cli
