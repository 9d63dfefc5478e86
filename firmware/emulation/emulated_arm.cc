#include "firmware/emulation/emulated_arm.h"

#include <algorithm>

#include "sinew/core/split_mix.h"

namespace sinew::emulation {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr double kMovingSpeed = 1e-4;  // rad/s

}  // namespace

EmulatedArm::EmulatedArm(Stm32Chip chip, const RobotModel& model, const JointVector& start,
                         std::uint64_t seed)
    : load_(std::get<SerialGeometry>(model.geometry), model.dynamics),
      next_tick_(Instant{} + kTick) {
  SplitMix64 random(seed);
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    boards_.push_back(std::make_unique<EmulatedBoard>(chip, model, i, start[i], random.bits()));
    boards_.back()->set_up();
  }
  tick();
}

/// The weight of the arm where it is now, and what the steps of the last millisecond made of it.
void EmulatedArm::tick() {
  JointVector q;
  for (const auto& board : boards_) q.push_back(board->plant.q());
  load_.update({q.data(), q.size()});
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    boards_[i]->plant.set_load(load_.torque(i), load_.inertia(i));
    boards_[i]->advance_plant(to_seconds(kTick));
  }
}

void EmulatedArm::run_board(EmulatedBoard& board, Instant until) {
  const double cycles = to_seconds(until - Instant{}) * board.chip.core().clock_hz();
  const auto broken = board.chip.run_until(static_cast<Cycles>(cycles));
  if (broken && !broken_) broken_ = broken;
}

void EmulatedArm::advance(Instant now) {
  for (; next_tick_ <= now; next_tick_ += kTick) {
    for (const auto& board : boards_) run_board(*board, next_tick_);
    tick();
    on_tick();
  }
}

/// The others' time may wait for the next tick: nothing reaches them before.
void EmulatedArm::advance_selected(Instant now) {
  advance(now);
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    if (is_selected(i)) run_board(*boards_[i], now);
  }
}

void EmulatedArm::select(std::uint8_t mask, Instant now) {
  const std::uint8_t before = selected_;
  selected_ |= mask;
  advance_selected(now);
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    if (((before ^ mask) >> i & 1) == 0) continue;
    boards_[i]->chip.set_input('A', 4, (mask >> i & 1) == 0);
  }
  selected_ = mask;
}

void EmulatedArm::shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
                        std::uint32_t clock_hz, Instant now) {
  advance_selected(now);
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    if (is_selected(i)) boards_[i]->chip.clock_spi(mosi, clock_hz);
  }
  const auto bits = static_cast<std::int64_t>(8 * mosi.size());
  const Instant end = now + Duration{bits * 1'000'000'000 / clock_hz};
  advance_selected(end);
  // A board that was in the middle of an instruction began a little later.
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    Stm32& chip = boards_[i]->chip;
    while (is_selected(i) && chip.miso().size() < mosi.size() && !broken_) {
      broken_ = chip.run_until(chip.core().now() + 1);
    }
  }
  std::ranges::fill(miso, std::uint8_t{0xFF});
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    if (!is_selected(i)) continue;
    const auto said = boards_[i]->chip.miso();
    for (std::size_t k = 0; k < std::min(said.size(), miso.size()); ++k) miso[k] &= said[k];
  }
}

sim::Truth EmulatedArm::truth() const {
  sim::Truth truth;
  for (const auto& board : boards_) {
    const sim::AxisPlant& plant = board->plant;
    truth.joints.push_back({.q = plant.q(), .qd = plant.qd(), .lost_steps = plant.stalled()});
    truth.moving = truth.moving || std::abs(plant.qd()) > kMovingSpeed;
  }
  return truth;
}

void EmulatedArm::disturb(const sim::Disturbance& what) {
  using Kind = sim::Disturbance::Kind;
  if (what.kind == Kind::kPayload) load_.set_payload(what.value);
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    if (what.joint >= 0 && static_cast<int>(i) != what.joint) continue;
    sim::AxisPlant& plant = boards_[i]->plant;
    if (what.kind == Kind::kSupply) plant.set_supply(what.value);
    if (what.kind == Kind::kLoad) plant.set_extra_load(what.value);
    if (what.kind == Kind::kMagnet) plant.set_field(what.value);
  }
}

}  // namespace sinew::emulation
