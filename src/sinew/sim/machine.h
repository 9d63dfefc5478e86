#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/model/robot_model.h"
#include "sinew/wire/spi.h"

/// The physical truth under a device. Nothing here reads a clock: time is handed in, and all
/// chance comes from one seed.
namespace sinew::sim {

/// One joint as it really is, which no device is ever told; rad, or m for a leg, model's frame.
struct JointTruth {
  double q = 0;              ///< the joint itself, behind gear and backlash
  double qd = 0;             ///< per s
  double believed = 0;       ///< where the device thinks it is, in the same frame
  bool stalled = false;      ///< its servo pushes now and does not turn
  bool at_end_stop = false;  ///< it leans against a mechanical end
  bool lost_steps = false;   ///< its stepper did since power-up; says nothing of now
};

/// A machine at one instant.
struct Truth {
  FixedVector<JointTruth, kMaxJoints> joints;
  double supply_volts = 0;
  bool moving = false;   ///< something turns, whatever the device believes
  bool deaf = false;     ///< the device hears nothing until a motion of its own is over, if ever
  double tool = 0;       ///< jaw width in m, nozzle or gripper angle in rad; 0 without a tool
  bool suction = false;  ///< pump on
  std::uint64_t bytes_lost = 0;  ///< bytes that the device had no room for
};

/// Things that happen to a machine from outside. They change physics, never a value.
struct Disturbance {
  enum class Kind : std::uint8_t {
    kSupply,    ///< volts from now on; a dip is two of them
    kPayload,   ///< kg at the tool
    kBlock,     ///< joint cannot pass `value` (rad or m; m between jaws) from now on
    kUnblock,   ///< joint is free again
    kMagnet,    ///< joint's encoder magnet: 0 falls off, 1 is put back
    kLoad,      ///< extra torque on the joint, Nm (force on a leg, N)
    kCoupling,  ///< of the joint's encoder: 0 slips, so that the encoder stands still; 1 holds
                ///< again
    kProbe,     ///< joint closes its board's probe input at `value` (rad or m) and beyond it
    kLead,      ///< of the joint's stepper, to its module: 0 hangs loose, so that its contact goes
                ///< with the next motion; 1 is fast again
  } kind = Kind::kSupply;
  std::int8_t joint = -1;  ///< behind the last one: the jaws
  double value = 0;
};

/// What outlives a loss of power.
struct LastingState {
  struct Body {
    double angle = 0;  ///< rad
    double speed = 0;  ///< rad/s
    friend bool operator==(const Body&, const Body&) = default;
  };
  /// Motor shafts, horns and joints, in an order of the machine's own.
  FixedVector<Body, 2 * kMaxJoints> bodies;
  std::vector<std::uint8_t> memory;  ///< flash and EEPROM of boards and servos
  friend bool operator==(const LastingState&, const LastingState&) = default;
};

/// A device together with the machine under it. @rt apart from its construction and LastingState.
class Machine {
 public:
  virtual ~Machine() = default;
  /// Lets time pass up to `now`, which never runs back.
  virtual void advance(Instant now) = 0;
  /// When something will happen by itself that the wire shows; nothing: it waits for bytes.
  virtual std::optional<Instant> next_event() const = 0;
  /// At the last advance().
  virtual Truth truth() const = 0;
  virtual void disturb(const Disturbance& what) = 0;

  /// At the last advance().
  virtual LastingState lasting_state() const { return {}; }
  /// Puts the mechanics there and fills the boards' memory, as power_up_from() does at the start.
  /// False where this is not the state of such a machine.
  virtual bool restore(const LastingState& /*state*/) { return false; }
};

/// A machine that lost its power in this state and gets it back at `boot`. Its time has come to
/// `boot - kPowerOffTime` before; without power it sinks meanwhile as far as its weight takes it.
/// False, and nothing has changed, where this is not the state of such a machine.
inline constexpr Duration kPowerOffTime = std::chrono::seconds(5);
bool power_up_from(const LastingState& state, Machine& machine, Instant boot);

/// A machine behind a stream of bytes.
class ByteMachine : public Machine {
 public:
  /// Bytes that arrive at `now`; advances first.
  virtual void receive(std::span<const std::uint8_t> bytes, Instant now) = 0;
  /// Moves the device's answers out; how many bytes.
  virtual std::size_t take_output(std::span<std::uint8_t> out) = 0;
};

/// One thing that a board can be asked for when it is being looked at: a count, a word, or bytes.
struct Figure {
  std::string_view name;
  std::variant<std::uint64_t, std::string_view, FixedVector<std::uint8_t, 16>> value;
};
using Figures = FixedVector<Figure, 24>;

/// A machine of several boards on an SPI bus, as its pins see it.
class SpiMachine : public Machine {
 public:
  /// The chip selects from now on: bit i is axis i, 1 selects it (its line goes low). Advances.
  virtual void select(std::uint8_t mask, Instant now) = 0;

  /// Clocks bytes through, whoever is selected; a host that drives its pins badly may do so with
  /// nobody selected. Mode 0, most significant bit first.
  /// @param miso  as long as `mosi`
  /// @param now   of the first clock edge. The time of the transfer passes inside.
  virtual void shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
                     std::uint32_t clock_hz, Instant now) = 0;

  /// What a board (or, without an axis, their bus) says of itself to whoever looks on.
  virtual Figures figures(std::optional<std::size_t> /*axis*/) const { return {}; }

  /// Level of the READY line of an axis.
  virtual bool ready_pin(std::size_t axis) const = 0;

  /// One framed exchange: select, setup, bytes, select off.
  spi::Bytes exchange(const spi::Transfer& transfer, Instant now) {
    spi::Bytes miso;
    miso.resize(transfer.mosi.size());
    select(transfer.select, now);
    const Instant first_edge = now + transfer.setup;
    shift({transfer.mosi.data(), transfer.mosi.size()}, {miso.data(), miso.size()},
          transfer.clock_hz, first_edge);
    select(0, first_edge + spi::wire_time(transfer));
    return miso;
  }
};

}  // namespace sinew::sim
