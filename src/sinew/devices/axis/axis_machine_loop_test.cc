#include "sinew/devices/axis/axis_machine_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "sinew/devices/axis/axis_device_controller.h"
#include "sinew/devices/axis/axis_machine.h"
#include "sinew/motion/rest_to_rest.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::sim {
namespace {

constexpr std::size_t kAxes = 6;
constexpr double kPayload = 0.5;  // kg, what the gains are chosen for
/// The greatest following error that supervision tolerates: the loop must bear to take it out.
constexpr double kLargeStep = from_deg(1.5);
/// What the motor's encoder cannot see: half the play, the gear's give under weight and friction
/// (0.1 deg at stall torque, of which the arm takes half), and a step of dead band.
constexpr double kUnseen = from_deg(0.1 + 0.06 + 0.007);

/// A few counts of the motor's encoder and its noise, at the joint.
constexpr double kNoise = from_deg(0.02);

const RobotModel& model() {
  return test::robot("robot-arm-2");
}

/// Arm far out to one side and to the other, so that the weight pulls both ways, and folded.
std::vector<JointVector> poses() {
  std::vector<JointVector> result;
  for (const auto& degrees :
       {std::array{0.0, 60.0, -60.0, 0.0, 0.0, 0.0}, std::array{0.0, -60.0, 60.0, 0.0, 40.0, 0.0},
        std::array{40.0, 65.0, 90.0, 90.0, -60.0, 0.0},
        std::array{0.0, -65.0, -90.0, 20.0, 90.0, 0.0}}) {
    JointVector q;
    for (const double angle : degrees) q.push_back(from_deg(angle));
    result.push_back(q);
  }
  return result;
}

struct Promise {
  double settling = 0;   ///< s
  double overshoot = 0;  ///< rad beyond what the joint is off by anyway
  double tracking = 0;   ///< rad
};

/// What each axis is held to.
constexpr std::array<Promise, kAxes> kPromises{{
    {0.95, from_deg(0.05), from_deg(0.18)},
    {0.85, from_deg(0.05), from_deg(0.22)},
    {0.40, from_deg(0.05), from_deg(0.18)},
    {0.25, from_deg(0.02), from_deg(0.15)},
    {0.25, from_deg(0.02), from_deg(0.15)},
    {0.25, from_deg(0.02), from_deg(0.15)},
}};

/// How an axis fails its promise, over all poses and both directions; empty where it keeps it.
std::string broken_promise(std::size_t joint, const AxisSettings& settings) {
  const Promise& promise = kPromises[joint];
  for (const JointVector& pose : poses()) {
    for (const double sign : {1.0, -1.0}) {
      LoopTrial trial{.pose = pose, .payload = kPayload, .step = sign * kLargeStep};
      const LoopRecord step = step_trial(model(), joint, settings, trial);
      const StepFigures figures = step_figures(step);
      if (step.stalled) return "step: loses steps";
      if (figures.settling > promise.settling) return "step: settles late";
      if (figures.overshoot > kUnseen + promise.overshoot) return "step: overshoots";
      if (figures.steady > kUnseen) return "step: ends elsewhere";
      if (figures.ripple > kNoise) return "step: does not come to rest";

      trial.step = sign * from_deg(20);
      const LoopRecord track = tracking_trial(model(), joint, settings, trial);
      if (track.stalled) return "track: loses steps";
      if (tracking_error(track) > promise.tracking) return "track: follows badly";
    }
  }
  return "";
}

class EveryAxis : public testing::TestWithParam<std::size_t> {
 protected:
  std::size_t joint() const { return GetParam(); }
  AxisSettings settings() const { return axis_settings(model(), joint()); }
};

TEST_P(EveryAxis, settles_and_follows_with_its_load_whichever_way_it_pulls) {
  EXPECT_EQ(broken_promise(joint(), settings()), "");
}

TEST_P(EveryAxis, would_fail_with_a_slack_loop) {
  AxisSettings slack = settings();
  slack.cascade.position_gain /= 4;
  EXPECT_EQ(broken_promise(joint(), slack), "step: settles late");
}

TEST_P(EveryAxis, would_fail_with_a_loop_that_is_too_stiff) {
  AxisSettings stiff = settings();
  stiff.cascade.position_gain *= 120;  // the wrist bears what 1 kHz can, 2000/s
  EXPECT_NE(broken_promise(joint(), stiff), "");
}

TEST_P(EveryAxis, would_fail_without_feed_forward) {
  AxisSettings blind = settings();
  blind.cascade.feed_forward = 0;
  EXPECT_EQ(broken_promise(joint(), blind), "track: follows badly");
}

TEST_P(EveryAxis, lags_by_speed_over_gain_without_feed_forward) {
  const LoopTrial trial{
      .pose = poses()[0], .payload = kPayload, .step = from_deg(-40), .feed_forward = false};
  const AxisSettings axis = settings();
  const double lag = tracking_error(tracking_trial(model(), joint(), axis, trial));
  const double speed = motion::plan_axis(-trial.step, axis.limits).velocity();
  // The velocity gain answers for its share: rate = (1 + Kv) Kp e - Kv qd.
  EXPECT_NEAR(lag, speed / axis.cascade.position_gain, kUnseen + from_deg(0.05));
}

INSTANTIATE_TEST_SUITE_P(RobotArm2, EveryAxis, testing::Range<std::size_t>(0, kAxes),
                         [](const auto& axis) { return "J" + std::to_string(axis.param + 1); });

TEST(AxisLoop, gains_come_from_the_robots_file) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const AxisGains& gains = model().dynamics.gains[i];
    const motion::CascadeSettings cascade = axis_settings(model(), i).cascade;
    EXPECT_EQ(cascade.position_gain, gains.position_gain);
    EXPECT_EQ(cascade.velocity_gain, gains.velocity_gain);
    EXPECT_EQ(cascade.integral_gain, gains.integral_gain);
    EXPECT_EQ(cascade.feed_forward, 1);
  }
  RobotModel bare = model();
  bare.dynamics.gains = {};
  EXPECT_EQ(axis_settings(bare, 0).cascade.position_gain, motion::CascadeSettings().position_gain);
}

/// The largest inertia and weight that a joint can meet, over many poses.
struct Worst {
  double inertia = 0;
  double torque = 0;
};

Worst worst_load(std::size_t joint) {
  Worst worst;
  ArmLoad load(std::get<SerialGeometry>(model().geometry), model().dynamics);
  load.set_payload(kPayload);
  test::Random random(1);
  for (int i = 0; i < 20'000; ++i) {
    JointVector q;
    for (const Joint& each : model().joints) q.push_back(random.uniform(each.lower, each.upper));
    load.update({q.data(), q.size()});
    worst.inertia = std::max(worst.inertia, load.inertia(joint));
    worst.torque = std::max(worst.torque, std::abs(load.torque(joint)));
  }
  return worst;
}

TEST_P(EveryAxis, corrects_its_largest_error_at_half_the_speed_that_its_motor_can_jump_to) {
  // docs/closed_loop.md, equation (2).
  const StepperDrive& drive = model().dynamics.drives[joint()];
  const Worst worst = worst_load(joint());
  const double torque = drive.holding_torque * drive.motors * drive.gear_ratio;
  const double bent = std::asin(worst.torque / torque);
  const double energy = torque / (drive.steps_per_turn / 4 * drive.gear_ratio) *
                        (2 * std::cos(bent) - (kPi - 2 * bent) * std::sin(bent));
  const double rotor = drive.rotor_inertia * drive.motors * drive.gear_ratio * drive.gear_ratio;
  const double jump = std::sqrt(2 * energy / (rotor + worst.inertia));
  const AxisSettings axis = settings();
  const double answer = (1 + axis.cascade.velocity_gain) * axis.cascade.position_gain *
                        axis.supervision.following_error;
  EXPECT_LT(answer, jump / 2);
}

TEST(AxisLoop, is_what_a_controller_makes_of_its_reference) {
  // A controller is homed and moves; the loop's parts get its reference and must step alike.
  const std::size_t joint = 4;
  const AxisSettings settings = axis_settings(model(), joint);
  JointVector pose(poses()[0]);
  pose[joint] = model().joints[joint].lower + from_deg(0.5);
  AxisPlant plant(axis_plant_settings(model(), joint, settings), pose[joint], 1);
  plant.set_load(0.1, 0.005);
  AxisController controller(settings);
  AxisOutputs outputs;
  Instant now;
  const auto tick = [&] {
    plant.advance(outputs, AxisLoop::kTick);
    outputs = controller.tick(plant.inputs(), now);
    now += from_seconds(AxisLoop::kTick);
  };
  for (int i = 0; i < 300; ++i) tick();
  ASSERT_EQ(controller.home(), AxisVerdict::kAccepted);
  for (int i = 0; i < 60'000 && !controller.status().homed; ++i) tick();
  for (int i = 0; i < 5000; ++i) tick();
  ASSERT_TRUE(controller.status().homed && !controller.status().moving);

  // The same sensors beside it, and the same law.
  const double from = controller.reference().q;
  ASSERT_EQ(controller.move_to(from + from_deg(10)), AxisVerdict::kAccepted);
  AxisEncoders encoders(settings.encoders);
  motion::Cascade cascade(settings.cascade);
  encoders.read(plant.inputs(), AxisLoop::kTick);
  encoders.mark();
  encoders.name_mark(controller.status().q, controller.status().q);
  double steps = static_cast<double>(outputs.steps);
  std::int64_t apart = 0;
  for (int i = 0; i < 4000; ++i) {
    plant.advance(outputs, AxisLoop::kTick);
    const AxisInputs inputs = plant.inputs();
    outputs = controller.tick(inputs, now);
    now += from_seconds(AxisLoop::kTick);
    encoders.read(inputs, AxisLoop::kTick);
    const motion::AxisState& reference = controller.reference();
    steps += cascade.rate(reference.q, reference.qd, encoders.q(), encoders.qd(), AxisLoop::kTick) *
             AxisLoop::kTick * settings.steps_per_rad();
    apart = std::max<std::int64_t>(apart, std::abs(std::llround(steps) - outputs.steps));
  }
  EXPECT_GT(controller.reference().q, from + from_deg(5));
  EXPECT_LE(apart, 1);  // the fraction of a step that the controller had already
}

TEST(AxisLoop, a_record_is_the_same_for_the_same_seed) {
  const LoopTrial trial{.pose = poses()[1], .payload = kPayload, .seconds = 1};
  const AxisSettings settings = axis_settings(model(), 1);
  EXPECT_EQ(step_trial(model(), 1, settings, trial).q, step_trial(model(), 1, settings, trial).q);
}

TEST(StepFigures, are_those_of_a_curve_that_is_known) {
  LoopRecord record;
  // First order with 0.1 s towards 1, from 0: rise 0.2197 s, within 0.02 of the end after 0.391 s.
  for (int i = 1; i <= 3000; ++i) {
    record.t.push_back(i * 1e-3);
    record.reference.push_back(1);
    record.q.push_back(1 - std::exp(-(i - 1) * 1e-3 / 0.1));
    record.measured.push_back(record.q.back());
  }
  const StepFigures figures = step_figures(record, 0.02);
  EXPECT_NEAR(figures.rise, 0.2197, 2e-3);
  EXPECT_NEAR(figures.settling, 0.392, 2e-3);
  EXPECT_EQ(figures.overshoot, 0);
  EXPECT_NEAR(figures.steady, 0, 1e-9);
  EXPECT_NEAR(figures.ripple, 0, 1e-9);
  for (double& q : record.q) q += 0.1;
  record.q.front() = 0;
  EXPECT_NEAR(step_figures(record, 0.02).overshoot, 0.1, 1e-9);
  EXPECT_NEAR(step_figures(record, 0.02).steady, 0.1, 1e-9);
}

}  // namespace
}  // namespace sinew::sim
