#pragma once

#include <cstddef>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/io/clock.h"
#include "sinew/io/local_socket.h"

namespace sinew::runtime {

/// Hosts that connect to boards which another one is using. Nobody shall wait for ever: each gets
/// one ERR line for its first request, and its connection is closed.
class SimwireGuests {
 public:
  static constexpr std::size_t kWaitingMax = 8;
  /// A guest that says nothing is told all the same, after so long.
  static constexpr Duration kPatience = std::chrono::seconds(1);

  /// @param listener, clock  outlive the guests
  SimwireGuests(io::LocalListener& listener, const io::Clock& clock)
      : listener_(listener), clock_(clock) {}

  /// Takes new ones in and turns those away that have spoken; never waits.
  /// @return  how many were turned away
  std::size_t look();

 private:
  struct Guest {
    io::Port port;
    Instant since;
  };

  io::LocalListener& listener_;
  const io::Clock& clock_;
  std::vector<Guest> waiting_;
};

}  // namespace sinew::runtime
