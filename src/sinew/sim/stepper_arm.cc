#include "sinew/sim/stepper_arm.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/split_mix.h"

namespace sinew::sim {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr double kEndMargin = from_deg(5);  // ASSUMED: from limit or switch to the mechanical end
constexpr double kLoadResolution = from_deg(0.1);  // torque changes by 0.2 % of its maximum
constexpr double kMovingSpeed = 1e-4;              // rad/s

template <class Settings>
Settings device_settings(const RobotModel& model) {
  if (const auto* settings = std::get_if<Settings>(&model.device.settings)) return *settings;
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

/// One axis: physics, controller, and the wire's end on it.
class StepperArm::Board : public SpiSlave {
 public:
  Board(const RobotModel& model, std::size_t joint, const Settings& settings, double q,
        std::uint64_t seed)
      : axis_(axis_settings(model, joint)),
        joint_(joint),
        joint_limits_(model.joints[joint]),
        plant_(axis_plant_settings(model, joint, axis_), q, seed),
        controller_(axis_) {
    if (settings.wire == AxisWire::kLink) {
      start_node();
      return;
    }
    const auto profile = settings.wire == AxisWire::kRegisters ? AxisRegisterProfile::kDocument
                                                               : AxisRegisterProfile::kAsBuilt;
    slave_.emplace(device_settings<AxisRegistersDevice>(model), joint, profile, controller_);
  }

  void select(bool selected) override {
    if (slave_) slave_->select(selected);
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
    outputs_ = on ? controller_.tick(plant_.inputs(), now) : AxisOutputs{};
    if (on && node_) node_->advance(now);
  }

  bool on() const { return on_; }
  AxisPlant& plant() { return plant_; }
  const AxisPlant& plant() const { return plant_; }
  AxisStatus status() const { return controller_.status(); }

 private:
  /// What a processor forgets, it forgets here.
  void boot() {
    plant_.reboot();
    controller_ = AxisController(axis_);
    outputs_ = {};
    if (slave_) slave_->power_up();
    if (node_) start_node();
  }
  void start_node() {
    auto settings =
        axis_link_node_settings(joint_limits_, static_cast<std::uint8_t>(joint_), boots_);
    settings.uncertainty = axis_.uncertainty();
    node_.emplace(controller_, settings);
    ++boots_;
  }

  AxisSettings axis_;
  std::size_t joint_;
  Joint joint_limits_;
  AxisPlant plant_;
  AxisController controller_;
  AxisOutputs outputs_;
  std::optional<AxisRegisterSlave> slave_;
  std::optional<AxisLinkNode> node_;
  std::uint16_t boots_ = 0;
  bool on_ = true;
};

StepperArm::StepperArm(const RobotModel& model, const Settings& settings, Instant boot)
    : load_(std::get<SerialGeometry>(model.geometry), model.dynamics),
      plugged_in_(settings.boards),
      next_tick_(boot + kTick) {
  SINEW_ASSERT(model.dynamics.drives.size() == model.joints.size());
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
    boards_.push_back(std::make_unique<Board>(model, i, settings, q, random.bits()));
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
}

void StepperArm::shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
                       std::uint32_t clock_hz, Instant now) {
  SINEW_ASSERT(clock_hz > 0 && mosi.size() == miso.size());
  advance(now);
  for (std::size_t i = 0; i < mosi.size(); ++i) {
    miso[i] = bus_.shift(mosi[i]);
    const auto bits = static_cast<std::int64_t>(8 * (i + 1));
    advance(now + Duration{bits * 1'000'000'000 / clock_hz});
  }
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
    if (what.kind == Kind::kLoad) plant.set_extra_load(what.value);
  }
}

bool StepperArm::ready_pin(std::size_t axis) const {
  SINEW_ASSERT(axis < boards_.size());
  return boards_[axis]->ready_pin();
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
