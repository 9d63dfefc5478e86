#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace sinew {

/// What a device's driver reports beside positions, in words for people: "supply" (V), "wire",
/// "board", and of a joint "axis" (fine, or why not), "servo" ...
class DeviceStatements {
 public:
  void say(std::string_view what, std::string words, std::size_t joint = 0) {
    said_.insert_or_assign(std::pair(std::string(what), joint), std::move(words));
  }
  std::optional<std::string> of(std::string_view what, std::size_t joint) const {
    const auto found = said_.find(std::pair(std::string(what), joint));
    return found != said_.end() ? std::optional(found->second) : std::nullopt;
  }

 private:
  std::map<std::pair<std::string, std::size_t>, std::string> said_;
};

}  // namespace sinew
