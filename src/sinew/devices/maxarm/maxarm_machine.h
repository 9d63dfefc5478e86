#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/maxarm/maxarm_device.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/machine.h"
#include "sinew/sim/servo_motor.h"

namespace sinew::sim {

/// A MaxArm: its board, three bus servos under the weight of the linkage, pump and nozzle.
///
/// The board is told what the servos' sensors read (truth, rounded to a pulse); it believes what
/// it commanded. An object at the nozzle (Disturbance::kPayload) is carried only while the pump is
/// on and falls when it goes off. Below 5 V the board stops; when power comes back it starts and
/// homes by itself. A servo without its magnet neither answers nor holds.
///
/// Masses, supply and friction are assumed; the maker gives none. @rt
class MaxArmMachine : public ByteMachine {
 public:
  /// @param robot     with PalletizerGeometry and MaxArmDevice settings
  /// @param checksum  @param variant  what its board runs, whatever the settings say
  MaxArmMachine(const RobotModel& robot, MaxArmChecksum checksum, MaxArmVariant variant,
                std::uint64_t seed, Instant boot);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override;
  Truth truth() const override;
  void disturb(const Disturbance& what) override;
  /// Horns of the three servos; the board has nothing that lasts.
  LastingState lasting_state() const override;
  bool restore(const LastingState& state) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

  const MaxArmFirmware& firmware() const { return firmware_; }
  /// kg that hang on the nozzle now.
  double carried() const;

 private:
  static constexpr std::size_t kJoints = 3;

  void step_physics(Instant until);
  void sense();
  double gravity(std::size_t joint) const;
  double angle_of(std::size_t joint, double pulse) const;
  bool powered() const;
  bool rests() const;

  PalletizerGeometry geometry_;
  MaxArmDevice device_;
  MaxArmFirmware firmware_;
  std::array<ServoMotor, kJoints> servos_;
  std::array<double, kJoints> extra_load_{};
  std::array<bool, kJoints> sensor_ok_{true, true, true};
  Instant now_;
  double supply_volts_;
  double object_kg_ = 0;
  bool held_ = false;  ///< the object hung on the nozzle a tick ago
  double nozzle_ = 0;
};

}  // namespace sinew::sim
