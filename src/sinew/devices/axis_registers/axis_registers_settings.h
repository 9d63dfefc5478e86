#pragma once

#include <cstdint>

#include "sinew/core/angle_encoding.h"
#include "sinew/devices/axis/axis_boards_settings.h"

namespace sinew {

// robot-arm-2: one controller board per axis on an SPI bus.

/// Where the registers of a board stand; the defaults are the document's.
struct AxisRegisterMap {
  std::uint16_t homing = 0;
  std::uint16_t move_angle = 1;
  std::uint16_t diag_control = 2;
  std::uint16_t diag_status = 3;
  std::uint16_t emergency_stop = 4;
  friend bool operator==(const AxisRegisterMap&, const AxisRegisterMap&) = default;
};

struct AxisRegistersDevice final : AxisBoardsOf<AxisRegistersDevice> {
  AngleEncoding encoding = AngleEncoding::kDegU32;
  AxisRegisterMap registers;
  std::uint8_t slave_id = 1;
  std::uint32_t clock_hz = 500'000;
  /// DIAG_STATUS tells something. Boards with the first firmware always answer 0: a move is done
  /// there when its predicted time is over, and positions are `commanded`.
  bool reports_status = true;

  bool shows_power_loss() const override { return reports_status; }
  bool searches_zeros() const override { return reports_status; }
  StopFacts stop_facts() const override {
    return {true, "0.12 s until told, then the boards stop at once", kFalls};
  }
  /// A silent board costs its three tries 0.74 s on this wire.
  Opening opening() const override {
    return {std::chrono::seconds(5), ": each board is asked three times"};
  }
  MotionDelay motion_delay() const override { return {}; }
  std::unique_ptr<SeparateMoves> separate_moves(const RobotModel& robot) const override;
  std::optional<Error> target_refusal(const RobotModel& robot, std::span<const double> q,
                                      std::span<const double> from) const override;
  std::vector<std::string> profiles() const override {
    return {"document", "as-built", "as-committed"};
  }
  std::vector<std::string> wires() const override { return {"registers", "link"}; }
  void use_profile(const std::string& name, Device& device) override;
  void use_wire(const std::string& name, Device& device) override;
};

}  // namespace sinew
