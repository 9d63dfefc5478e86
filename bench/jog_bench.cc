#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "bench/inputs.h"
#include "sinew/planning/jog/jog.h"

namespace sinew::bench {
namespace {

using planning::Jog;
using planning::JogCommand;
using planning::JogFrame;

/// A tool being jogged round and round at 1 kHz, each cycle with a new command: every step plans
/// all joints anew.
class Circling {
 public:
  Circling(const RobotModel& model, JogFrame frame, double speed, const std::vector<double>& q,
           bool avoid_contact)
      : jog_(model, {.avoid_contact = avoid_contact}), speed_(speed) {
    command_.frame = frame;
    command_.velocity.resize(frame == JogFrame::kJoint ? q.size() : 3);
    std::vector<motion::AxisState> states;
    for (const double value : q) states.push_back({value, 0, 0});
    fine_ = !jog_.start(states, now_);
  }

  bool step() {
    now_ += std::chrono::milliseconds(1);
    angle_ += 2e-3;
    command_.velocity[0] = speed_ * std::sin(angle_);
    command_.velocity[1] = speed_ * std::cos(angle_);
    fine_ = fine_ && !jog_.command(command_, now_ - std::chrono::milliseconds(1));
    return fine_ && !jog_.step(now_);
  }
  const Jog& jog() const { return jog_; }

 private:
  Jog jog_;
  JogCommand command_;
  double speed_;
  double angle_ = 0;
  Instant now_{};
  bool fine_ = false;
};

void run(benchmark::State& state, const RobotModel& model, JogFrame frame, double speed,
         const std::vector<double>& q, bool avoid_contact) {
  Circling circling(model, frame, speed, q, avoid_contact);
  for (auto _ : state) {
    if (!circling.step()) return state.SkipWithError("refused");
    benchmark::DoNotOptimize(circling.jog().setpoint());
  }
}

const std::vector<double>& bent_arm() {
  static const std::vector<double> q{0, from_deg(30), from_deg(-60), 0, from_deg(40), 0};
  return q;
}

void jog_retarget_tool_6r(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  run(state, in.model, JogFrame::kBase, 0.02, bent_arm(), false);
}
BENCHMARK(jog_retarget_tool_6r);

void jog_retarget_tool_6r_with_contact(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  run(state, in.model, JogFrame::kBase, 0.02, bent_arm(), true);
}
BENCHMARK(jog_retarget_tool_6r_with_contact);

void jog_retarget_joints_6r(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  run(state, in.model, JogFrame::kJoint, 0.1, bent_arm(), false);
}
BENCHMARK(jog_retarget_joints_6r);

}  // namespace
}  // namespace sinew::bench
