#include "sinew/devices/axis_registers/axis_registers_driver_times.h"

#include <algorithm>

#include "sinew/core/assert.h"
#include "sinew/devices/axis_registers/axis_registers_driver_units.h"

namespace sinew {
namespace {

// One frame, from its SYN on: the document's pauses, and its bytes at 500 kHz.
constexpr double kFree = 0.010;     // s behind the frame before it
constexpr double kSampled = 0.041;  // what a READ tells is of then
constexpr double kTakenUp = 0.064;  // what a WRITE says is done from then on
constexpr double kEnd = 0.072;
constexpr double kFrame = 0.082;

enum class Phase { kWrite, kPoll, kReadBack, kDone };

}  // namespace

AxisRegisterTimes::Move AxisRegisterTimes::next(std::span<const double> own) {
  SINEW_ASSERT(own.size() <= kMaxJoints && own.size() == device_.boards.size());
  std::array<Phase, kMaxJoints> phases{};
  std::array<double, kMaxJoints> arrives{};
  const Phase idle = device_.reports_status ? Phase::kPoll : Phase::kDone;
  for (std::size_t i = 0; i < own.size(); ++i) phases[i] = own[i] > 0 ? Phase::kWrite : idle;
  Move move;
  // Boards that tell nothing are waited for, so that no frame lies right before an order.
  const double begin = device_.reports_status ? kFree : 0;
  for (double t = begin;; t += kFrame) {
    // Orders before questions, as AxisRegistersDriver::next_axis() has it.
    std::size_t best = own.size();
    for (std::size_t k = 0; k < own.size(); ++k) {
      const std::size_t i = (cursor_ + k) % own.size();
      if (phases[i] == Phase::kDone) continue;
      const bool first = best == own.size();
      if (first || (phases[i] == Phase::kWrite && phases[best] != Phase::kWrite)) best = i;
    }
    if (best == own.size()) break;
    cursor_ = (best + 1) % own.size();
    move.report = t + kEnd;
    if (phases[best] == Phase::kWrite) {
      move.start[best] = t + kTakenUp;
      arrives[best] = move.start[best] + own[best];
      move.arrival = std::max(move.arrival, arrives[best]);
      phases[best] = idle;
    } else if (phases[best] == Phase::kReadBack) {
      phases[best] = Phase::kDone;
    } else if (own[best] == 0) {
      phases[best] = Phase::kDone;
    } else if (t + kSampled >= arrives[best]) {
      phases[best] = Phase::kReadBack;
    }
  }
  move.own = std::max(0.0, move.arrival - begin - kTakenUp);
  if (!device_.reports_status) move.report += move.own;
  return move;
}

double AxisRegisterTimes::target(std::size_t joint, double q) const {
  const auto told =
      axis_registers::tell_angle(device_.encoding, device_.boards[joint].zero, joints_[joint], q);
  return told ? told->q : q;
}

std::unique_ptr<SeparateMoves> AxisRegistersDevice::separate_moves(const RobotModel& robot) const {
  return std::make_unique<AxisRegisterTimes>(*this, robot.joints);
}

}  // namespace sinew
