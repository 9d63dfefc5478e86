#include "sinew/sim/cube_table.h"

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew::sim {
namespace {

/// Jaws at full speed close by 1 mm meanwhile.
constexpr Duration kSlice = std::chrono::milliseconds(4);

}  // namespace

CubeTable::CubeTable(std::unique_ptr<ByteMachine> machine, const RobotModel& model,
                     const Pose<frame::World, frame::Base>& X_WB, SharedCubes& cubes,
                     std::size_t which, Instant boot)
    : machine_(std::move(machine)),
      model_(model),
      X_WB_(X_WB),
      cubes_(cubes),
      which_(which),
      now_(boot) {
  SINEW_ASSERT(machine_ != nullptr);
  move_hand();
}

void CubeTable::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  while (now_ < now) {
    now_ = std::min(now, now_ + kSlice);
    machine_->advance(now_);
    move_hand();
  }
}

void CubeTable::move_hand() {
  const auto hand = hand_of(model_, machine_->truth(), X_WB_);
  if (!hand) return;
  std::optional<double> blocked;
  double payload = 0;
  const auto step = [&](CubeWorld& world) {
    world.advance(now_, *hand, which_);
    blocked = world.blocked_width(which_);
    payload = world.held_mass(which_);
  };
  cubes_.with(std::ref(step));
  feel(blocked, payload);
}

void CubeTable::feel(std::optional<double> blocked, double payload) {
  using Kind = Disturbance::Kind;
  if (blocked != blocked_) {
    const auto jaws = static_cast<std::int8_t>(model_.joints.size());
    machine_->disturb({Kind::kUnblock, jaws, 0});
    if (blocked) machine_->disturb({Kind::kBlock, jaws, *blocked});
    blocked_ = blocked;
  }
  if (payload != payload_) machine_->disturb({Kind::kPayload, -1, payload});
  payload_ = payload;
}

bool CubeTable::restore(const LastingState& state) {
  if (!machine_->restore(state)) return false;
  cubes_.with([&](CubeWorld& world) { world.lift_hand(which_); });
  move_hand();
  return true;
}

void CubeTable::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  machine_->receive(bytes, now);
}

}  // namespace sinew::sim
