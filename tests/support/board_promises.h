#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "support/board_under_test.h"

namespace sinew::mcu {

/// What a board has to do, held against it by `check` (which uses EXPECT_..): the same list for the
/// program on this machine and for the image on an emulated chip.
struct BoardPromise {
  std::string name;
  std::function<void(BoardUnderTest&)> check;
};
std::vector<BoardPromise> board_promises();

/// A host of the arm link, as simple as can be.
class TestHost {
 public:
  explicit TestHost(BoardUnderTest& board) : board_(board) {}

  /// @param deadline_ms  of the session  @param braking  share of what the arm brakes with
  bool open(std::uint16_t deadline_ms = 100, double braking = 1);
  arm_link::Request next(arm_link::Kind kind);
  std::optional<arm_link::Reply> tell(const arm_link::Request& request) {
    return state_ = board_.frame(request);
  }
  std::optional<arm_link::Reply> tell(arm_link::Kind kind) { return tell(next(kind)); }
  std::optional<arm_link::Reply> read();
  /// One segment of kSegment to `targets` (steps) at `velocities` (steps per ms).
  arm_link::Request segment(const std::array<double, kArmAxes>& targets,
                            const std::array<double, kArmAxes>& velocities);
  /// Streams the motion whose position is `at(axis, s)` and speed `speed(axis, s)` per s, for
  /// `seconds`, and waits for its end.
  bool stream(double seconds, const std::function<double(std::size_t, double)>& at,
              const std::function<double(std::size_t, double)>& speed);

  static constexpr int kSegmentMs = 20;

 private:
  BoardUnderTest& board_;
  std::optional<arm_link::Reply> state_;
  std::uint8_t session_ = 0;
  std::uint16_t sequence_ = 65530;
};

/// From 0 to `way` and at rest at either end, with the smoothest start.
double smooth(double way, double seconds, double t);
double smooth_speed(double way, double seconds, double t);

}  // namespace sinew::mcu
