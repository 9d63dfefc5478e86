#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/core/error.h"
#include "sinew/core/instant.h"
#include "sinew/core/units.h"
#include "sinew/model/axis_board.h"
#include "sinew/model/separate_moves.h"
#include "sinew/model/tool_action.h"

namespace sinew {

/// Everything in one text, whose hash is taken. Numbers as they are, to the last bit.
class IdentityText {
 public:
  void add(double number) {
    const auto bytes = std::bit_cast<std::array<char, sizeof number>>(number);
    text_.append(bytes.data(), bytes.size());
  }
  void add(bool flag) { text_ += flag ? "1;" : "0;"; }
  void add(std::string_view word) {
    text_ += word;
    text_ += ';';
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// What a robot's wire and device make of a stop, from the moment at which it is asked for.
struct StopFacts {
  bool ends_motion = true;      ///< false: the motion under way is finished
  std::string_view standstill;  ///< until it stands, for people; Driver::goes_on_until() has each
  std::string_view falls;       ///< what gravity does: held, and without power
  bool together = false;        ///< it brakes all joints in one time, along the way that they go
};

/// How long a host waits for the first good answer behind an opened port, and what for.
struct Opening {
  Duration limit{};
  std::string_view waits_for;  ///< for people; behind "the device"
};
/// Opening a port resets many boards, which a host cannot see: an Arduino's boot loader then
/// listens for some 2 s, an ESP32 needs as long to start.
inline constexpr Opening kBoots{std::chrono::seconds(5),
                                ", which may be starting: opening a port resets many boards"};

/// What a wire and its device add to a motion's own time, undisturbed; a device whose joints are
/// commanded one by one has SeparateMoves instead. Commands take their time on
/// the wire, boards look at their port now and then, and a driver looks before it says that a
/// motion is done. docs/motion/arrival.md has where the numbers come from.
struct MotionDelay {
  Duration arrival{};  ///< from the motion's own end until the joints are there
  Duration report{};   ///< from the motion's own end until the driver says so
};

/// How positions are recorded that rest on a device's own counts (the hexapod); m or rad.
struct CountGrain {
  double block = 0;      ///< JournalJoint's
  double lead = 0;       ///< likewise
  double slack = 0;      ///< likewise
  double forgotten = 0;  ///< what a cut of its power may move it by
};

struct Device;
struct JawGripper;
struct RobotModel;

/// Share of their stroke that jaws travel to a width (m); all of it where `jaws`, their width, is
/// not known.
double jaws_share(const JawGripper& gripper, double width, std::optional<double> jaws);

/// A setting that commissioning finds, or a cell's file gives: `joint.base.turn = other`.
struct DeviceSetting {
  std::string_view what;
  std::optional<std::size_t> joint{};
  std::string_view value;
  std::optional<double> number{};  ///< the value, where it is one

  bool turns_joint() const { return joint && what == "turn" && value == "other"; }
};

/// What a kind of device is set up with, and what the rules above its driver ask of the kind. The
/// default answers are those of the ideal device. A kind derives from SettingsOf and overrides what
/// is different.
class DeviceSettings {
 public:
  virtual ~DeviceSettings() = default;
  virtual std::unique_ptr<DeviceSettings> copy() const = 0;

  /// Adds what ties its units to joints: with another value recorded positions mean other places.
  virtual void identify(IdentityText& out) const = 0;
  /// It shows at opening whether it kept its power: by counts, target positions, a homed flag.
  virtual bool shows_power_loss() const { return false; }
  /// Its motors have no sensors: it counts from where it was powered up. A simulated one starts at
  /// the robot's home, with that position declared.
  virtual bool counts_from_power_up() const { return false; }
  /// `home` looks for end stops: only axis boards have them, and only those that report can say
  /// that they were found. On other machines it is a joint move.
  virtual bool searches_zeros() const { return false; }
  /// One per joint, of a device that hangs on SPI. They live in this.
  virtual std::span<const AxisBoard> axis_boards() const { return {}; }

  virtual StopFacts stop_facts() const = 0;
  virtual Opening opening() const { return kBoots; }
  /// How it is recorded; nothing: by its speed and what it measures.
  virtual std::optional<CountGrain> count_grain() const { return std::nullopt; }

  /// The smallest way that a joint can be told, rad or m; 0 where it says with each position how
  /// fine it is.
  virtual double resolution(std::size_t /*joint*/) const { return 1e-6; }
  /// How fast its firmware makes a joint where it is asked for more than the robot's file proves:
  /// rad/s, and rad/s^2. 0: no more than that.
  virtual double firmware_reach(std::size_t /*joint*/) const { return 0; }
  /// Of a device whose joints do not go together; nullptr of others.
  /// @param robot  the one that has these settings; outlives what is returned
  virtual std::unique_ptr<SeparateMoves> separate_moves(const RobotModel& /*robot*/) const {
    return nullptr;
  }
  /// Why its wire cannot say a position, asked before anything moves and of the very functions by
  /// which its driver says it. Nothing where a move may end at q (rad or m, one a joint), or a
  /// streamed path pass it.
  /// @param from  where the motion begins; beyond a limit positions on the way back can be said too
  /// @return kStepRange, kUnsendable (index, steps), kPulseRange (index, pulses), kJointLimit
  ///         (index: nothing inside the limits is near enough)
  virtual std::optional<Error> target_refusal(const RobotModel& /*robot*/,
                                              std::span<const double> /*q*/,
                                              std::span<const double> /*from*/) const {
    return std::nullopt;
  }
  /// Why its gripper cannot be sent to an angle; nothing where it can.
  /// @return kToolAngle (rad), kUnsendable
  virtual std::optional<Error> gripper_refusal(const GripperTo& /*gripper*/) const {
    return std::nullopt;
  }
  /// A device that makes its motions itself can be told their accelerations.
  virtual bool takes_acceleration() const { return false; }
  /// A driver of the ideal device asks it every 10 ms how far it is.
  virtual MotionDelay motion_delay() const {
    return {std::chrono::milliseconds(2), std::chrono::milliseconds(8)};
  }
  /// From a tool action's order until the driver reports that it is done; zero where that is no
  /// more than a question and its answer.
  /// @param jaws  m: how wide they were commanded last since the port was opened, where they were
  virtual Duration tool_time(const RobotModel& robot, const ToolAction& action,
                             std::optional<double> jaws) const;
  /// The shortest and the longest point-to-point move that its wire can say.
  virtual std::pair<Duration, Duration> move_times() const {
    return {Duration::zero(), std::chrono::hours(24)};
  }

  /// Its joints' sensors hang on magnets, or on what can fail like one.
  virtual bool has_magnets() const { return false; }
  /// How far commissioning may correct a joint's zero, rad; 0: not here.
  virtual double trim_max() const { return 0; }
  /// It watches the leads of its motors.
  virtual bool watches_leads() const { return false; }

  /// The names of a simulated one's variants (`--profile`), its default first; none where it has
  /// but one.
  virtual std::vector<std::string> profiles() const { return {}; }
  /// The names of the wires that it is spoken to over (`--wire`), its file's first.
  virtual std::vector<std::string> wires() const { return {}; }
  /// Turns the device that has these settings into the variant of that name.
  /// @param name  one of profiles()
  virtual void use_profile(const std::string& /*name*/, Device& /*device*/) {}
  /// @param name  one of wires(). These settings may be no more afterwards.
  virtual void use_wire(const std::string& /*name*/, Device& /*device*/) {}
  /// axis_boards(), to be changed; nullptr of a device with one controller for all joints.
  virtual AxisBoards* own_boards() { return nullptr; }
  /// What commissioning has found; false: this is no such setting, or no value of it.
  virtual bool use_setting(const DeviceSetting& /*setting*/, Device& /*device*/) { return false; }
  /// Why two of its settings cannot both be, for people; empty where all can.
  virtual std::string contradiction(const RobotModel& /*robot*/) const { return {}; }
};

/// @tparam Kind  derives from this
template <class Kind>
// Kinds are aggregates, which a private constructor would end.
// NOLINTNEXTLINE(bugprone-crtp-constructor-accessibility)
class SettingsOf : public DeviceSettings {
 public:
  std::unique_ptr<DeviceSettings> copy() const override {
    return std::make_unique<Kind>(static_cast<const Kind&>(*this));
  }
};

/// The device of a robot whose file names none: it does exactly what it is told, within the file's
/// limits.
struct IdealDevice final : SettingsOf<IdealDevice> {
  static constexpr Duration kJawsStroke = std::chrono::milliseconds(800);  ///< from open to closed

  void identify(IdentityText& out) const override { out.add(std::string_view("ideal")); }
  StopFacts stop_facts() const override {
    return {true, "a line until told, then as its joints brake", "it has no weight: nothing falls"};
  }
};

/// Settings of one kind or another. A value: its copy is another one.
class SomeSettings {
 public:
  SomeSettings() : held_(std::make_unique<IdealDevice>()) {}
  template <class Kind>
    requires std::derived_from<Kind, DeviceSettings>
  SomeSettings(Kind kind) : held_(std::make_unique<Kind>(std::move(kind))) {}
  SomeSettings(const SomeSettings& other) : held_(other.held_->copy()) {}
  SomeSettings(SomeSettings&& other) noexcept = default;
  SomeSettings& operator=(const SomeSettings& other) {
    held_ = other.held_->copy();
    return *this;
  }
  SomeSettings& operator=(SomeSettings&& other) noexcept = default;
  ~SomeSettings() = default;

  DeviceSettings* operator->() { return held_.get(); }
  const DeviceSettings* operator->() const { return held_.get(); }
  const DeviceSettings& operator*() const { return *held_; }

  /// nullptr where they are of another kind.
  template <class Kind>
  const Kind* as() const {
    return dynamic_cast<const Kind*>(held_.get());
  }
  template <class Kind>
  Kind* as() {
    return dynamic_cast<Kind*>(held_.get());
  }
  template <class Kind>
  bool is() const {
    return as<Kind>() != nullptr;
  }
  /// @pre they are of that kind
  template <class Kind>
  const Kind& get() const {
    SINEW_ASSERT(is<Kind>());
    return *as<Kind>();
  }
  template <class Kind>
  Kind& get() {
    SINEW_ASSERT(is<Kind>());
    return *as<Kind>();
  }
  template <class Kind>
  Kind& emplace() {
    held_ = std::make_unique<Kind>();
    return get<Kind>();
  }

 private:
  std::unique_ptr<DeviceSettings> held_;
};

}  // namespace sinew
