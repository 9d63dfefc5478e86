#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/server/api/api.h"

namespace sinew::server {

/// What a cell's robots can do, shown by a client of its own: each plays its demonstration program
/// again and again, or a ride where its file has none. The first thing that anybody else asks of a
/// robot that moves it, or a stop, ends it: every robot of it comes to rest first (Api::yield).
class Demonstration {
 public:
  /// One robot's part of it.
  struct Part {
    std::string robot;
    double time_scale = 1;
    bool plays = false;
    int rounds = 0;         ///< played to their end
    int failures = 0;       ///< in a row
    double progress = 0;    ///< of the round under way, [0, 1]
    double duration = 0;    ///< s of the machine's own time, predicted
    std::string trouble{};  ///< why the last round failed; empty where it did not
    Instant due{};          ///< when it may begin its next round
    std::uint32_t job = 0;  ///< the last one that was looked at
    bool rides = false;     ///< there is no program that suits it
    Instant pauses{};       ///< since when, where its camera paused it
    std::string sorts{};    ///< rows that sort a simulated table's cubes; empty: it does not
  };
  /// A robot that has failed so often in a row is left alone.
  static constexpr int kFailuresMax = 3;

  /// @param api, cell  outlive this
  Demonstration(Api& api, const runtime::RunningCell& cell);

  /// Goes on with it; each few milliseconds. @param now  real time, as of Api::poll()
  void poll(Instant now);
  /// Ends it as a visitor would.
  void end();

  /// Somebody moves the robots, and this does not any more.
  bool over() const { return !session_ || !api_.knows(*session_); }
  /// Each robot has played a round to its end, or has failed too often.
  bool shown() const;
  const std::vector<Part>& parts() const { return parts_; }

 private:
  void begin_round(std::size_t robot, Instant now);
  void take_picture();
  void take_answers();
  void look_at(std::size_t robot, Instant now);
  void go_on(std::size_t robot, const runtime::JobView& job, Instant now);

  Api& api_;
  const runtime::RunningCell& cell_;
  std::optional<SessionId> session_;
  std::vector<Part> parts_;
  Instant next_{};
};

}  // namespace sinew::server
