#pragma once

#include <cstddef>
#include <expected>
#include <string>
#include <string_view>

#include "sinew/core/instant.h"
#include "sinew/server/api/api.h"
#include "sinew/server/json/json_rpc.h"
#include "sinew/server/web/http_head.h"

/// What a connection of the network door decides without its socket.
namespace sinew::server {

inline constexpr const char* kFull =
    "this server has as many clients as it serves; close one, and try again";

/// Where the head at the beginning of what came ends; 0 where more has to come.
/// @error  what cannot become one, as soon as that can be seen
std::expected<std::size_t, HttpRefusal> head_size(std::string_view received);

/// A WebSocket's first message where no token came with its upgrade.
struct SessionOpen {
  Json id;
  std::string token;
};
/// @error  any other message
std::expected<SessionOpen, BadRequest> read_session_open(std::string_view text);

/// Whether an answer will come of this message.
bool is_answered(std::string_view text);

std::string_view role_name(Role role);

/// How much a WebSocket may say: a greedy one waits, so that others are heard. A message costs its
/// bytes and kMessageCost; credit comes back by kPerSecond, up to kCreditMax.
class WebPace {
 public:
  static constexpr double kMessageCost = 1024;         // bytes
  static constexpr double kPerSecond = 512.0 * 1024;   // bytes
  static constexpr double kCreditMax = 1024.0 * 1024;  // bytes

  void pass(Instant now);
  void spend(std::size_t bytes) { credit_ -= kMessageCost + static_cast<double>(bytes); }
  bool may_read() const { return credit_ > 0; }

 private:
  double credit_ = kCreditMax;
  std::optional<Instant> last_;
};

}  // namespace sinew::server
