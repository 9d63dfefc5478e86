#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sinew/devices/lsc/lsc_device.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/arm_load.h"
#include "sinew/sim/machine.h"
#include "sinew/sim/servo_motor.h"

namespace sinew::sim {

/// A LeArm: servo board, one servo per joint and one for the jaws, weight on the joints, and a
/// battery that sags. Nobody knows where it stands when it is switched on, itself least of all.
///
/// A Disturbance means: kSupply the battery's open voltage, kPayload kg at the tips, kBlock and
/// kUnblock a joint or, with the number behind the last joint, a thing of so many m between the
/// jaws, kLoad Nm on a joint; kMagnet means nothing here. @rt apart from its construction.
class LscMachine : public ByteMachine {
 public:
  static constexpr double kBrownOutVolts = 4.0;  ///< assumed: below, the board's processor stops
  static constexpr double kPowerUpVolts = 4.5;   ///< assumed: above, it starts anew

  /// @param model    a serial arm with LscDevice settings, asserted.
  /// @param profile  which board it has; the units are those of the settings.
  /// @param seed     of the pose at power-up.
  LscMachine(const RobotModel& model, LscProfile profile, std::uint64_t seed, Instant boot);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override;
  Truth truth() const override;
  void disturb(const Disturbance& what) override;
  /// Horns of the joints' servos and the jaws'; the board's memory.
  LastingState lasting_state() const override;
  bool restore(const LastingState& state) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

  LscBoard& board() { return board_; }
  const LscBoard& board() const { return board_; }
  /// False while the supply is too low for the board.
  bool powered() const { return powered_; }

 private:
  void step(Instant to);
  void sense();
  void update_load();
  double horn_of(std::size_t i, double units) const;
  double units_of(std::size_t i, double horn) const;
  std::uint8_t id_of(std::size_t i) const;
  bool is_jaws(std::size_t i) const { return i == joints_; }

  LscDevice device_;
  std::size_t joints_;
  double width_max_ = 0;
  double jaw_span_ = 0;  ///< rad of the jaws' horn from open to closed
  LscBoard board_;
  std::vector<ServoMotor> servos_;  ///< joints, then the jaws; as many as at construction
  ArmLoad load_;
  std::array<double, kMaxJoints> extra_load_{};  ///< Nm
  double battery_volts_;
  double supply_volts_;
  bool powered_ = true;
  std::uint64_t bytes_lost_ = 0;
  Instant now_;
  Instant load_due_;
};

}  // namespace sinew::sim
