#pragma once

#include <chrono>
#include <cstdint>

#include "sinew/devices/axis/axis_boards_settings.h"

namespace sinew {

/// robot-arm-2 with axis boards that run Sinew's own firmware.
struct AxisLinkDevice final : AxisBoardsOf<AxisLinkDevice> {
  std::uint32_t clock_hz = 4'000'000;
  Duration deadline = std::chrono::milliseconds(100);  ///< silence that stops an axis; 20..500 ms

  bool searches_zeros() const override { return true; }
  StopFacts stop_facts() const override {
    return {true, "one frame until told, then the boards brake: up to 4 s at full speed", kFalls};
  }
  Opening opening() const override {
    return {std::chrono::seconds(2), ": every axis has a second to answer"};
  }
  /// The loop is that far behind its setpoint; the driver knows when the setpoint has arrived.
  MotionDelay motion_delay() const override {
    return {std::chrono::milliseconds(34), std::chrono::milliseconds(2)};
  }
  std::vector<std::string> wires() const override { return {"link"}; }
};

}  // namespace sinew
