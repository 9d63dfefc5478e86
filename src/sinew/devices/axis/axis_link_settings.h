#pragma once

#include <chrono>
#include <cstdint>

#include "sinew/model/device_settings.h"

namespace sinew {

/// robot-arm-2 with axis boards that run Sinew's own firmware.
struct AxisLinkDevice final : SettingsOf<AxisLinkDevice> {
  std::uint32_t clock_hz = 4'000'000;
  Duration deadline = std::chrono::milliseconds(100);  ///< silence that stops an axis; 20..500 ms
  AxisBoards boards;

  void identify(IdentityText& out) const override {
    for (const AxisBoard& board : boards) out.add(board.zero);
  }
  bool searches_zeros() const override { return true; }
  std::span<const AxisBoard> axis_boards() const override { return {boards.data(), boards.size()}; }
  StopFacts stop_facts() const override {
    return {true, "one frame until told, then the boards brake: up to 4 s at full speed",
            "steppers hold; without power the arm drops: its gears do not hold it"};
  }
  Opening opening() const override {
    return {std::chrono::seconds(2), ": every axis has a second to answer"};
  }
  double resolution(std::size_t /*joint*/) const override { return 0; }
  /// The loop is that far behind its setpoint; the driver knows when the setpoint has arrived.
  MotionDelay motion_delay() const override {
    return {std::chrono::milliseconds(34), std::chrono::milliseconds(2)};
  }
  bool has_magnets() const override { return true; }
  std::vector<std::string> wires() const override { return {"link"}; }
  AxisBoards* own_boards() override { return &boards; }
};

}  // namespace sinew
