#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sinew/devices/axis/axis_device_controller.h"
#include "sinew/devices/axis/axis_machine_bus.h"
#include "sinew/devices/axis/axis_machine_plant.h"
#include "sinew/devices/axis_link/axis_link_device.h"
#include "sinew/devices/axis_registers/axis_registers_device.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/arm_load.h"
#include "sinew/sim/machine.h"

namespace sinew::sim {

/// What the boards of a StepperArm speak.
enum class AxisWire : std::uint8_t {
  kRegisters,         ///< the document's protocol, with an axis behind it
  kRegistersAsBuilt,  ///< what the first firmware does with it: nothing moves
  /// The first firmware as it stands in its repository: it waits for its chip select on a pin that
  /// the board uses for MISO, so it answers nothing at all.
  kRegistersAsCommitted,
  kLink,  ///< the axis link
};

/// What an axis of such an arm is built of.
AxisPlantSettings axis_plant_settings(const RobotModel& model, std::size_t joint,
                                      const AxisSettings& axis);

/// robot-arm-2 as a machine: per joint a plant (motor, gear, joint, encoders), an axis controller
/// at 1 kHz and a board on an SPI bus; the arm's weight and inertia join the plants. It starts as a
/// real one does: without current, at a pose that nobody knows, so it must be homed.
///
/// Below its brown-out voltage a board is off: no current, no answer. When the supply comes back it
/// boots, has forgotten where it is, and the motor snaps to the next home phase.
/// docs/simulation.md lists what is simulated and every assumed number. @rt
class StepperArm : public SpiMachine {
 public:
  struct Settings {
    AxisWire wire = AxisWire::kRegisters;
    SelectKind select = SelectKind::kHard;
    std::uint64_t seed = 1;  ///< start pose, sensor mounting and noise
    /// Start pose, rad; random within the limits where it is empty.
    JointVector start;
    std::size_t boards = kMaxJoints;  ///< plugged in, from the first axis on; the rest are silent
    bool ready_high = false;          ///< READY never falls, whatever a board would have it do
  };

  /// @param model  a serial arm with a drive per joint. Where its device does not belong to the
  ///               wire, defaults serve.
  StepperArm(const RobotModel& model, const Settings& settings, Instant boot);
  ~StepperArm() override;

  void advance(Instant now) override;
  /// Boards never speak first, and READY says nothing that a host may rely on.
  std::optional<Instant> next_event() const override { return std::nullopt; }
  Truth truth() const override;
  /// kSupply goes to all boards where no joint is named. kMagnet is the joint's AS5600: on its own
  /// shaft where it has one there, else on the motor's.
  void disturb(const Disturbance& what) override;
  /// Of each axis joint and motor shaft; of boards on the axis link their count of boots.
  LastingState lasting_state() const override;
  bool restore(const LastingState& state) override;
  void select(std::uint8_t mask, Instant now) override;
  void shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
             std::uint32_t clock_hz, Instant now) override;
  bool ready_pin(std::size_t axis) const override;
  /// Of a board: `state`, what the host did wrong (`violations`, then each kind; `early_clocks` are
  /// transfers less than 200 us behind their chip select, `short_pauses` those less than 10 ms
  /// behind the last one, `quick_clocks` those above 4 MHz to the first firmware), `boots`, and its
  /// registers by name. Of the bus: `contended_bytes`.
  Figures figures(std::optional<std::size_t> axis) const override;

  AxisBus& bus() { return bus_; }
  const AxisPlant& plant(std::size_t joint) const;
  /// As its board knows itself.
  AxisStatus status(std::size_t joint) const;

 private:
  class Board;

  void tick(Instant now);
  void update_load();

  ArmLoad load_;
  std::size_t plugged_in_;
  std::uint32_t clock_max_;  ///< Hz that the boards can follow
  std::vector<std::unique_ptr<Board>> boards_;
  AxisBus bus_;
  Instant next_tick_;
  JointVector loaded_at_;  ///< configuration of the last load update
  bool load_changed_ = true;
  bool ready_high_ = false;
};

}  // namespace sinew::sim
