#pragma once

#include <functional>
#include <memory>

#include "sinew/core/instant.h"
#include "sinew/server/api/api.h"

namespace boost::asio {
class io_context;
}

namespace sinew::server {

/// The one thread in which an Api is served, whichever doors lead to it. Doors are made before
/// run() and end before this does.
class ServerLoop {
 public:
  /// @param api  outlives this
  explicit ServerLoop(Api& api);
  ~ServerLoop();
  ServerLoop(const ServerLoop&) = delete;
  ServerLoop& operator=(const ServerLoop&) = delete;

  /// Serves in this thread until `stop`, asked each few milliseconds, says so.
  void run(const std::function<bool()>& stop);

  /// @name For doors
  /// @{
  Api& api();
  /// A message of a session: Api::receive(), and soon what it asks for.
  void receive(SessionId session, std::string_view text);
  Instant now() const;
  boost::asio::io_context& context();
  /// Called behind each poll of the Api, each few milliseconds: sessions may have something to say.
  void each_turn(std::function<void()> turn);
  /// Lets what doors have ended run out.
  void drain();
  /// @}

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sinew::server
