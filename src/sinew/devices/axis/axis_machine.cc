#include "sinew/devices/axis/axis_machine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/core/split_mix.h"
#include "sinew/devices/axis/axis_device_setup_model.h"
#include "sinew/devices/axis/axis_machine_node.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"

namespace sinew::sim {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr double kEndMargin = from_deg(5);  // ASSUMED: from limit or switch to the mechanical end
constexpr double kLoadResolution = from_deg(0.1);  // torque changes by 0.2 % of its maximum
constexpr double kMovingSpeed = 1e-4;              // rad/s
/// Hz: half of the 8 MHz on which the first firmware leaves its processor.
constexpr std::uint32_t kAsBuiltClockMax = 4'000'000;

bool is_first_firmware(AxisWire wire) {
  return wire == AxisWire::kRegistersAsBuilt || wire == AxisWire::kRegistersAsCommitted;
}

template <class Settings>
Settings device_settings(const RobotModel& model) {
  if (const auto* settings = model.device.settings.as<Settings>()) return *settings;
  Settings defaults;
  for (const Joint& joint : model.joints) defaults.boards.push_back({.zero = joint.lower});
  return defaults;
}

}  // namespace

AxisPlantSettings axis_plant_settings(const RobotModel& model, std::size_t joint,
                                      const AxisSettings& axis) {
  AxisPlantSettings settings;
  settings.drive = model.dynamics.drives[joint];
  settings.switch_angle = axis.homing.end_stop_angle;
  settings.switch_direction = axis.homing.direction;
  settings.end_lower = std::min(axis.lower, axis.homing.end_stop_angle) - kEndMargin;
  settings.end_upper = std::max(axis.upper, axis.homing.end_stop_angle) + kEndMargin;
  settings.joint_as5600 = axis.encoders.joint == JointEncoder::kAs5600;
  return settings;
}

/// The flash of a simulated board, as long as its machine lives.
class BoardMemory : public SetupMemory {
 public:
  BoardMemory() {
    for (auto& place : places_) place.fill(0xFF);
  }
  std::span<const std::uint8_t> place(int which) const override { return places_[which]; }
  bool erase(int which) override {
    places_[which].fill(0xFF);
    return true;
  }
  bool append(int which, std::span<const std::uint8_t> bytes) override {
    std::ranges::copy(bytes, places_[which].begin());
    return true;
  }

 private:
  std::array<std::array<std::uint8_t, 512>, 2> places_{};
};

/// One axis: physics, controller, and the wire's end on it.
class StepperArm::Board : public SpiSlave {
 public:
  Board(const RobotModel& model, std::size_t joint, const Settings& settings, double q,
        std::uint64_t seed, Instant boot)
      : axis_(axis_settings(model, joint)),
        plant_(axis_plant_settings(model, joint, axis_), q, seed),
        controller_(axis_),
        notices_select_(settings.wire != AxisWire::kRegistersAsCommitted) {
    if (axis_.encoders.joint_node) joint_node_.emplace(plant_.joint_sensor(), boot);
    if (settings.wire == AxisWire::kLink) {
      SetupStore(memory_).keep(axis_setup(model, joint));
      start_node();
      return;
    }
    const auto profile = settings.wire == AxisWire::kRegisters ? AxisRegisterProfile::kDocument
                                                               : AxisRegisterProfile::kAsBuilt;
    const auto device = device_settings<AxisRegistersDevice>(model);
    slave_.emplace(axis_register_slave_settings(device, joint), profile, controller_);
  }

  void select(bool selected) override {
    selected_ = selected;
    if (slave_ && notices_select_) slave_->select(selected);
    if (node_) node_->select(selected);
  }
  std::uint8_t shift(std::uint8_t mosi) override {
    return slave_ ? slave_->shift(mosi) : node_->shift(mosi);
  }
  bool ready_pin() const { return slave_ && slave_->ready_pin(); }

  /// One control cycle: what was told moved the plant since the last one.
  void tick(Instant now) {
    plant_.advance(outputs_, to_seconds(kTick));
    const bool on = !plant_.browned_out();
    if (on && !on_) boot();
    on_ = on;
    AxisInputs inputs = plant_.inputs();
    if (joint_node_) joint_node_->read(inputs, now);
    outputs_ = on ? controller_.tick(inputs, now) : AxisOutputs{};
    if (on && node_) node_->advance(now);
    if (node_ && node_->restart_due()) boot();
  }

  /// The host selected it, or let it go, at that moment.
  void note_select(Instant now) {
    if (selected_ == noted_) return;
    noted_ = selected_;
    if (selected_) {
      selected_at_ = now;
      clocked_ = false;
    }
  }
  /// The first of some clocks comes at `begin`, the last one is over at `end`.
  void note_clocks(Instant begin, Instant end, bool too_quick) {
    if (!selected_ || !slave_ || !on_) return;
    if (too_quick) ++quick_clocks_;
    if (!clocked_) {
      if (begin - selected_at_ < axis_registers::kSelectSetup) ++early_clocks_;
      if (transferred_ && selected_at_ - *transferred_ < axis_registers::kStepPause) {
        ++short_pauses_;
      }
    }
    clocked_ = true;
    transferred_ = end;
  }
  Figures figures() const;

  /// Of the axis link; a board of the register wire counts none.
  std::optional<std::uint16_t> boots() const {
    return node_ ? std::optional(boots_) : std::nullopt;
  }
  void set_boots(std::uint16_t boots) { boots_ = boots; }

  bool on() const { return on_; }
  AxisPlant& plant() { return plant_; }
  const AxisPlant& plant() const { return plant_; }
  AxisStatus status() const { return controller_.status(); }

 private:
  /// What a processor forgets, it forgets here.
  void boot() {
    plant_.reboot();
    ++starts_;
    early_clocks_ = 0;
    short_pauses_ = 0;
    quick_clocks_ = 0;
    transferred_.reset();
    if (node_) axis_ = SetupStore(memory_).setup().value_or(AxisSetup{0, axis_, {}}).axis;
    controller_ = AxisController(axis_);
    outputs_ = {};
    if (slave_) slave_->power_up();
    if (node_) start_node();
  }
  void start_node() {
    store_.emplace(memory_);
    node_.emplace(controller_, axis_link_node_settings(store_->setup(), boots_), &*store_);
    ++boots_;
  }

  AxisSettings axis_;
  BoardMemory memory_;
  std::optional<SetupStore> store_;
  AxisPlant plant_;
  std::optional<JointNode> joint_node_;
  AxisController controller_;
  bool notices_select_;
  AxisOutputs outputs_;
  std::optional<AxisRegisterSlave> slave_;
  std::optional<AxisLinkNode> node_;
  std::uint16_t boots_ = 0;
  std::uint64_t starts_ = 1;
  bool on_ = true;
  bool selected_ = false;
  bool noted_ = false;    ///< the last level of `selected_` that came with its moment
  bool clocked_ = false;  ///< since it was selected
  Instant selected_at_{};
  std::optional<Instant> transferred_;  ///< when its last transfer ended
  std::uint64_t early_clocks_ = 0;
  std::uint64_t short_pauses_ = 0;
  std::uint64_t quick_clocks_ = 0;
};

namespace {

std::string_view name_of(axis_registers::Register name) {
  constexpr std::string_view kNames[] = {"homing",         "move_angle",     "diag_control",
                                         "diag_status",    "emergency_stop", "enable_motor",
                                         "firmware_update"};
  return kNames[static_cast<std::size_t>(name)];
}

}  // namespace

Figures StepperArm::Board::figures() const {
  Figures out;
  if (node_) {
    out.push_back({"state", on_ ? (node_->session() != 0 ? "OPEN" : "NO_SESSION") : "OFF"});
    out.push_back({"violations", node_->bad_frames()});
    out.push_back({"good_frames", node_->good_frames()});
    out.push_back({"boots", starts_});
    return out;
  }
  const AxisRegisterSlave::Violations& wrong = slave_->violations();
  const bool away = slave_->in_boot_loader();
  const std::string_view state = away ? "BOOT_LOADER" : AxisRegisterSlave::name_of(slave_->state());
  out.push_back({"state", on_ ? state : "OFF"});
  out.push_back({"violations", wrong.sum() + early_clocks_ + short_pauses_ + quick_clocks_});
  out.push_back({"broken_transfers", wrong.broken_transfers});
  out.push_back({"surplus_bytes", wrong.surplus_bytes});
  out.push_back({"stray_bytes", wrong.stray_bytes});
  out.push_back({"refused_headers", wrong.refused_headers});
  out.push_back({"bad_data", wrong.bad_data});
  out.push_back({"early_clocks", early_clocks_});
  out.push_back({"short_pauses", short_pauses_});
  out.push_back({"quick_clocks", quick_clocks_});
  out.push_back({"changes", std::uint64_t{slave_->changes()}});
  out.push_back({"boots", starts_});
  for (const axis_registers::RegisterRow& row : slave_->registers()) {
    out.push_back({name_of(row.name), slave_->register_value(row.name)});
  }
  return out;
}

StepperArm::StepperArm(const RobotModel& model, const Settings& settings, Instant boot)
    : load_(std::get<SerialGeometry>(model.geometry), model.dynamics),
      plugged_in_(settings.boards),
      clock_max_(is_first_firmware(settings.wire) ? kAsBuiltClockMax
                                                  : std::numeric_limits<std::uint32_t>::max()),
      next_tick_(boot + kTick) {
  SINEW_ASSERT(model.dynamics.drives.size() == model.joints.size());
  ready_high_ = settings.ready_high;
  SplitMix64 random(settings.seed);
  const auto bus_of = [&](std::size_t joint) -> std::uint8_t {
    const auto registers = device_settings<AxisRegistersDevice>(model).boards;
    const auto link = device_settings<AxisLinkDevice>(model).boards;
    return settings.wire == AxisWire::kLink ? link[joint].spi_bus : registers[joint].spi_bus;
  };
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const double drawn = random.uniform(joint.lower, joint.upper);
    const double q = settings.start.empty() ? drawn : settings.start[i];
    boards_.push_back(std::make_unique<Board>(model, i, settings, q, random.bits(), boot));
    bus_.attach(*boards_.back(), settings.select, bus_of(i));
    loaded_at_.push_back(q);
  }
  update_load();
}

StepperArm::~StepperArm() = default;

void StepperArm::update_load() {
  double moved = 0;
  JointVector q;
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    q.push_back(boards_[i]->plant().q());
    moved = std::max(moved, std::abs(q[i] - loaded_at_[i]));
  }
  if (!load_changed_ && moved < kLoadResolution) return;
  load_changed_ = false;
  loaded_at_ = q;
  load_.update({q.data(), q.size()});
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    boards_[i]->plant().set_load(load_.torque(i), load_.inertia(i));
  }
}

void StepperArm::tick(Instant now) {
  update_load();
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    boards_[i]->tick(now);
    bus_.set_powered(i, i < plugged_in_ && boards_[i]->on());
  }
}

void StepperArm::advance(Instant now) {
  for (; next_tick_ <= now; next_tick_ += kTick) tick(next_tick_);
}

void StepperArm::select(std::uint8_t mask, Instant now) {
  advance(now);
  bus_.select(mask);
  for (const std::unique_ptr<Board>& board : boards_) board->note_select(now);
}

void StepperArm::shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
                       std::uint32_t clock_hz, Instant now) {
  SINEW_ASSERT(clock_hz > 0 && mosi.size() == miso.size());
  advance(now);
  for (std::size_t i = 0; i < mosi.size(); ++i) {
    // What a chip makes of clocks that it cannot follow nobody has measured; here it misses them.
    miso[i] = clock_hz <= clock_max_ ? bus_.shift(mosi[i]) : AxisBus::kIdle;
    const auto bits = static_cast<std::int64_t>(8 * (i + 1));
    advance(now + Duration{bits * 1'000'000'000 / clock_hz});
  }
  const auto all_bits = static_cast<std::int64_t>(8 * mosi.size());
  const Instant end = now + Duration{all_bits * 1'000'000'000 / clock_hz};
  const bool too_quick = clock_hz > clock_max_;
  for (const std::unique_ptr<Board>& board : boards_) board->note_clocks(now, end, too_quick);
}

Figures StepperArm::figures(std::optional<std::size_t> axis) const {
  if (axis) return *axis < boards_.size() ? boards_[*axis]->figures() : Figures{};
  Figures bus;
  bus.push_back({"contended_bytes", bus_.contended_bytes()});
  return bus;
}

Truth StepperArm::truth() const {
  Truth truth;
  for (const std::unique_ptr<Board>& board : boards_) {
    const AxisPlant& plant = board->plant();
    truth.joints.push_back({.q = plant.q(),
                            .qd = plant.qd(),
                            .believed = board->status().q,
                            .at_end_stop = plant.at_end(),
                            .lost_steps = plant.stalled()});
    truth.moving = truth.moving || std::abs(plant.qd()) > kMovingSpeed;
  }
  if (!boards_.empty()) truth.supply_volts = boards_[0]->plant().inputs().supply_volts;
  return truth;
}

void StepperArm::disturb(const Disturbance& what) {
  using Kind = Disturbance::Kind;
  if (what.kind == Kind::kPayload) {
    load_.set_payload(what.value);
    load_changed_ = true;
    return;
  }
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    const bool all = what.kind == Kind::kSupply && what.joint < 0;
    if (!all && static_cast<int>(i) != what.joint) continue;
    AxisPlant& plant = boards_[i]->plant();
    if (what.kind == Kind::kSupply) plant.set_supply(what.value);
    if (what.kind == Kind::kBlock) plant.block(what.value);
    if (what.kind == Kind::kUnblock) plant.unblock();
    if (what.kind == Kind::kMagnet) plant.set_field(what.value);
    if (what.kind == Kind::kCoupling) plant.set_coupling(what.value != 0);
    if (what.kind == Kind::kLoad) plant.set_extra_load(what.value);
  }
}

LastingState StepperArm::lasting_state() const {
  LastingState state;
  for (const std::unique_ptr<Board>& board : boards_) {
    const AxisPlant& plant = board->plant();
    state.bodies.push_back({plant.q(), plant.qd()});
    state.bodies.push_back({plant.motor_angle(), plant.motor_speed()});
    if (const auto boots = board->boots()) {
      state.memory.push_back(static_cast<std::uint8_t>(*boots & 0xFF));
      state.memory.push_back(static_cast<std::uint8_t>(*boots >> 8));
    }
  }
  return state;
}

/// The same arm may have been driven over the other wire before; then no boots were counted.
bool StepperArm::restore(const LastingState& state) {
  const bool counted = state.memory.size() == 2 * boards_.size();
  if (state.bodies.size() != 2 * boards_.size() || (!counted && !state.memory.empty()))
    return false;
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    const LastingState::Body& joint = state.bodies[2 * i];
    const LastingState::Body& rotor = state.bodies[2 * i + 1];
    boards_[i]->plant().place(joint.angle, joint.speed, rotor.angle, rotor.speed);
    const auto* boots = state.memory.data() + 2 * i;
    if (counted) boards_[i]->set_boots(static_cast<std::uint16_t>(boots[0] | boots[1] << 8));
  }
  load_changed_ = true;
  return true;
}

bool StepperArm::ready_pin(std::size_t axis) const {
  SINEW_ASSERT(axis < boards_.size());
  return ready_high_ || boards_[axis]->ready_pin();
}

const AxisPlant& StepperArm::plant(std::size_t joint) const {
  SINEW_ASSERT(joint < boards_.size());
  return boards_[joint]->plant();
}

AxisStatus StepperArm::status(std::size_t joint) const {
  SINEW_ASSERT(joint < boards_.size());
  return boards_[joint]->status();
}

}  // namespace sinew::sim
