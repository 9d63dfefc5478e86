#include "sinew/devices/axis/axis_machine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/devices/axis_registers/axis_registers_driver.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "support/allocation_guard.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::sim {
namespace {

using axis_link::Mode;
using std::chrono::milliseconds;

constexpr std::size_t kAxes = 6;
/// Backlash 0.2, windup 0.1, half a count of the joint's encoder and the switch's own
/// repeatability.
constexpr double kPlay = from_deg(0.5);

const RobotModel& model() {
  return test::robot("robot-arm-2");
}

/// Some degrees above the lower limits, so that homing takes seconds and not minutes.
JointVector near_home(double degrees = 4) {
  JointVector q;
  for (const Joint& joint : model().joints) q.push_back(joint.lower + from_deg(degrees));
  return q;
}

TEST(StepperArm, axes_carry_the_joint_encoders_of_the_robots_file) {
  const RobotModel& robot = model();
  // The author's list: axes 1 to 3 incremental, 4 to 6 absolute.
  for (std::size_t i = 0; i < kAxes; ++i) {
    const auto due = i < 3 ? JointEncoder::kQuadrature : JointEncoder::kAs5600;
    EXPECT_EQ(robot.dynamics.drives[i].joint_encoder, due) << i;
  }
  // A magnet that falls off is the motor's on the first three, the joint's own on the others.
  StepperArm arm(robot, {AxisWire::kLink, SelectKind::kHard, 1, near_home()}, Instant{});
  for (std::size_t i = 0; i < kAxes; ++i) {
    arm.disturb({Disturbance::Kind::kMagnet, static_cast<std::int8_t>(i), 0});
  }
  arm.advance(Instant{} + milliseconds(100));
  for (std::size_t i = 0; i < kAxes; ++i) {
    const AxisInputs inputs = arm.plant(i).inputs();
    EXPECT_EQ(inputs.motor_encoder_ok, i >= 3) << i;
    EXPECT_EQ(inputs.joint_encoder_ok, i < 3) << i;
    const AxisFault fault = i < 3 ? AxisFault::kMotorEncoder : AxisFault::kJointEncoder;
    EXPECT_EQ(arm.status(i).fault, fault) << i;
  }
}

/// A host on the axis link that knows just enough to talk: one frame to each axis every 10 ms.
class Cell {
 public:
  explicit Cell(const JointVector& start = near_home(), std::uint64_t seed = 1,
                const RobotModel& robot = model())
      : arm_(robot, {AxisWire::kLink, SelectKind::kHard, seed, start}, Instant{}) {
    run(0.3);
    for (std::size_t i = 0; i < kAxes; ++i) greet(i);
  }

  /// @return  what the axis was when the frame began; nothing where it did not answer.
  std::optional<axis_link::State> send(std::size_t axis, Mode mode, double q = 0) {
    axis_link::Request request;
    request.axis = static_cast<std::uint8_t>(axis);
    request.mode = mode;
    request.sequence = ++sequence_[axis];
    request.target = axis_link::to_units(q).value();
    request.session = session_[axis];
    const auto reply = exchange(static_cast<std::uint8_t>(1 << axis), request);
    if (!reply) return std::nullopt;
    const auto* state = std::get_if<axis_link::State>(&reply->body);
    return state == nullptr ? std::nullopt : std::optional(*state);
  }
  void greet(std::size_t axis) {
    const AxisLinkNodeSettings settings =
        axis_link_node_settings(model().joints[axis], static_cast<std::uint8_t>(axis));
    exchange(static_cast<std::uint8_t>(1 << axis),
             axis_link::hello(static_cast<std::uint8_t>(axis), ++sequence_[axis],
                              axis_link::model_hash(settings.model), milliseconds(500)));
    advance(milliseconds(2));
    axis_link::Request read;
    read.axis = static_cast<std::uint8_t>(axis);
    const auto reply = exchange(static_cast<std::uint8_t>(1 << axis), read);
    if (reply) session_[axis] = reply->session;
  }
  void stop_all(Mode mode) {
    axis_link::Request request;
    request.to_all = true;
    request.mode = mode;
    exchange(0b11'1111, request);
  }
  void advance(Duration time) {
    now_ += time;
    arm_.advance(now_);
  }
  void run(double seconds) {
    for (int k = 0; k * 0.01 < seconds; ++k) {
      for (std::size_t i = 0; i < kAxes; ++i) state_[i] = send(i, Mode::kRead);
      advance(milliseconds(10) - kAxes * kFrameTime);
    }
  }
  /// Until all stand still, at most `seconds`.
  bool settle(double seconds) {
    for (int i = 0; i * 0.1 < seconds; ++i) {
      run(0.1);
      bool busy = false;
      for (const auto& state : state_) busy = busy || (state && (state->moving || state->homing));
      if (!busy) return true;
    }
    return false;
  }
  bool home() {
    for (std::size_t i = 0; i < kAxes; ++i) send(i, Mode::kHome);
    settle(60);
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (!status(i).homed) return false;
    }
    return true;
  }
  AxisStatus status(std::size_t axis) const { return arm_.status(axis); }
  JointTruth truth(std::size_t axis) const { return arm_.truth().joints[axis]; }
  double lower(std::size_t axis) const { return model().joints[axis].lower; }

  StepperArm arm_;
  Instant now_{};

 private:
  static constexpr Duration kFrameTime =
      std::chrono::microseconds(82);  // 16 bytes at 4 MHz + 50 us

  std::optional<axis_link::Reply> exchange(std::uint8_t select, const axis_link::Request& request) {
    spi::Transfer transfer;
    transfer.select = select;
    transfer.clock_hz = 4'000'000;
    transfer.setup = std::chrono::microseconds(50);
    for (const std::uint8_t byte : axis_link::encode(request)) transfer.mosi.push_back(byte);
    const spi::Bytes miso = arm_.exchange(transfer, now_);
    now_ += kFrameTime;
    axis_link::Frame frame{};
    std::copy(miso.begin(), miso.end(), frame.begin());
    const auto reply = axis_link::decode_reply(frame);
    if (!reply) return std::nullopt;
    return *reply;
  }

  std::array<std::uint16_t, kAxes> sequence_{};
  std::array<std::uint8_t, kAxes> session_{};
  std::array<std::optional<axis_link::State>, kAxes> state_{};
};

TEST(StepperArm, starts_as_a_real_arm_does_not_knowing_where_it_is) {
  test::for_random_cases(20, [](test::Random& random) {
    Cell cell(JointVector{}, random.bits());
    for (std::size_t i = 0; i < kAxes; ++i) {
      EXPECT_FALSE(cell.status(i).homed);
      EXPECT_FALSE(cell.status(i).position_ok);
      const double before = cell.truth(i).q;
      cell.send(i, Mode::kMove, before + 0.3);
      cell.run(0.2);
      EXPECT_NEAR(cell.truth(i).q, before, from_deg(0.5)) << "joint " << i;
    }
  });
}

TEST(StepperArm, homed_and_moved_the_truth_is_within_the_play_of_the_command) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  for (const double degrees : {15.0, 25.0, 8.0}) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      cell.send(i, Mode::kMove, cell.lower(i) + from_deg(degrees));
    }
    ASSERT_TRUE(cell.settle(30));
    for (std::size_t i = 0; i < kAxes; ++i) {
      EXPECT_NEAR(cell.truth(i).q, cell.lower(i) + from_deg(degrees), kPlay) << "joint " << i;
      EXPECT_NEAR(cell.truth(i).believed, cell.truth(i).q, kPlay) << "joint " << i;
      EXPECT_FALSE(cell.truth(i).lost_steps) << "joint " << i;
    }
  }
}

/// robot-arm-2 with an encoder node at each joint that has an AS5600.
RobotModel with_nodes() {
  RobotModel robot = model();
  AxisBoards& boards = *robot.device.settings->own_boards();
  for (std::size_t i = 3; i < kAxes; ++i) boards[i].encoder_node = true;
  return robot;
}

TEST(StepperArm, joint_sensors_on_encoder_nodes_serve_as_those_on_i2c_do) {
  const RobotModel robot = with_nodes();
  Cell cell(near_home(), 1, robot);
  ASSERT_TRUE(cell.home());
  for (std::size_t i = 0; i < kAxes; ++i) {
    cell.send(i, Mode::kMove, cell.lower(i) + from_deg(15));
  }
  ASSERT_TRUE(cell.settle(30));
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(cell.truth(i).q, cell.lower(i) + from_deg(15), kPlay) << "joint " << i;
    EXPECT_EQ(cell.status(i).fault, AxisFault::kNone) << "joint " << i;
    EXPECT_EQ(cell.status(i).motor_magnet, Magnet::kGood) << "joint " << i;
    EXPECT_EQ(cell.status(i).joint_magnet, i < 3 ? Magnet::kUnknown : Magnet::kGood);
  }
  // Its encoder comes off the joint: the joint goes on, and what it says does not.
  cell.arm_.disturb({Disturbance::Kind::kCoupling, 4, 0});
  cell.send(4, Mode::kMove, cell.lower(4) + from_deg(25));
  cell.settle(30);
  EXPECT_EQ(cell.status(4).fault, AxisFault::kEncodersDisagree);
  cell.arm_.disturb({Disturbance::Kind::kMagnet, 5, 0});
  cell.run(0.3);
  EXPECT_EQ(cell.status(5).fault, AxisFault::kJointEncoder);
  EXPECT_EQ(cell.status(5).joint_magnet, Magnet::kMissing);
}

TEST(StepperArm, homing_finds_the_same_place_again) {
  std::array<double, kAxes> first{};
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Cell cell(near_home(static_cast<double>(seed) * 3), seed);
    ASSERT_TRUE(cell.home());
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double error = cell.truth(i).believed - cell.truth(i).q;
      if (seed == 1) first[i] = error;
      EXPECT_NEAR(error, first[i], from_deg(0.25)) << "joint " << i << " seed " << seed;
    }
  }
}

TEST(StepperArm, thing_in_the_way_stalls_the_motor_and_the_board_says_so) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  cell.arm_.disturb({Disturbance::Kind::kBlock, 0, cell.lower(0) + from_deg(10)});
  cell.send(0, Mode::kMove, cell.lower(0) + from_deg(30));
  cell.run(15);
  EXPECT_LT(cell.truth(0).q, cell.lower(0) + from_deg(10.5));
  EXPECT_NE(cell.status(0).fault, AxisFault::kNone);
  EXPECT_NEAR(cell.truth(0).believed, cell.truth(0).q, kPlay) << "or it must say that it is lost";
  cell.arm_.disturb({Disturbance::Kind::kUnblock, 0, 0});
  EXPECT_EQ(cell.status(1).fault, AxisFault::kNone) << "the others are none of its business";
}

TEST(StepperArm, payload_beyond_the_shoulders_torque_stops_it_and_less_does_not) {
  // Level upper arm and forearm: 0.68 m from the shoulder to the tool, 22 Nm without payload.
  for (const double payload : {0.5, 6.0}) {
    JointVector start = near_home();
    start[2] = from_deg(90);
    Cell cell(start);
    cell.send(1, Mode::kHome);
    cell.settle(60);
    ASSERT_TRUE(cell.status(1).homed);
    cell.arm_.disturb({Disturbance::Kind::kPayload, -1, payload});
    cell.send(1, Mode::kMove, cell.lower(1) + from_deg(30));
    cell.run(15);
    const bool arrived = std::abs(cell.truth(1).q - cell.lower(1) - from_deg(30)) < from_deg(1);
    EXPECT_EQ(arrived, payload < 1) << payload << " kg";
    EXPECT_EQ(cell.status(1).fault == AxisFault::kNone, payload < 1) << payload << " kg";
  }
}

TEST(StepperArm, brown_out_reboots_the_boards_and_the_homing_is_gone) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  const double before = cell.truth(3).q;
  cell.arm_.disturb({Disturbance::Kind::kSupply, -1, 4});
  cell.advance(milliseconds(50));
  EXPECT_FALSE(cell.send(3, Mode::kRead)) << "a board without supply answers nothing";
  cell.arm_.disturb({Disturbance::Kind::kSupply, -1, 24});
  cell.advance(milliseconds(500));
  EXPECT_FALSE(cell.status(3).homed);
  EXPECT_NEAR(cell.truth(3).q, before, from_deg(1)) << "two full steps, and what gravity took";
  const auto refused = cell.send(3, Mode::kMove, cell.lower(3) + 0.5);
  cell.advance(milliseconds(500));
  EXPECT_TRUE(refused);
  EXPECT_NEAR(cell.truth(3).q, before, from_deg(1));
}

TEST(StepperArm, supply_dip_of_one_board_leaves_the_others_homed) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  cell.arm_.disturb({Disturbance::Kind::kSupply, 5, 4});
  cell.advance(milliseconds(20));
  cell.arm_.disturb({Disturbance::Kind::kSupply, 5, 24});
  cell.run(0.3);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_EQ(cell.status(i).homed, i != 5) << i;
}

TEST(StepperArm, emergency_stop_in_motion_stands_within_half_a_second) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  for (std::size_t i = 0; i < kAxes; ++i) {
    cell.send(i, Mode::kMove, cell.lower(i) + from_deg(60));
  }
  cell.run(2);
  std::array<double, kAxes> at_stop{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    at_stop[i] = cell.truth(i).q;
    EXPECT_GT(cell.truth(i).qd, from_deg(3)) << "joint " << i;
  }
  cell.stop_all(Mode::kEmergencyStop);
  cell.advance(milliseconds(500));
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_TRUE(cell.status(i).emergency_stopped);
    EXPECT_NEAR(cell.truth(i).q, at_stop[i], from_deg(1)) << "joint " << i;
    EXPECT_NEAR(cell.truth(i).qd, 0, from_deg(0.1)) << "joint " << i;
  }
}

TEST(StepperArm, silent_host_stops_the_arm) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  cell.send(0, Mode::kMove, cell.lower(0) + from_deg(300));
  cell.run(2);
  EXPECT_GT(cell.truth(0).qd, from_deg(10));
  cell.advance(milliseconds(8000));  // 10 deg/s^3 takes its time
  EXPECT_EQ(cell.status(0).fault, AxisFault::kLinkSilent);
  EXPECT_NEAR(cell.truth(0).qd, 0, 1e-3);
  EXPECT_LT(cell.truth(0).q, cell.lower(0) + from_deg(120));
}

TEST(StepperArm, lost_magnet_costs_the_position_and_never_silently) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  cell.arm_.disturb({Disturbance::Kind::kMagnet, 2, 0});
  cell.run(0.5);
  EXPECT_FALSE(cell.status(2).position_ok);
  EXPECT_NE(cell.status(2).fault, AxisFault::kNone);
  cell.arm_.disturb({Disturbance::Kind::kMagnet, 2, 1});
  cell.run(0.5);
  EXPECT_FALSE(cell.status(2).position_ok) << "coming back does not bring the turns back";
}

TEST(StepperArm, extra_load_sags_by_the_gears_give_and_no_more) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  const double before = cell.truth(1).q;
  cell.arm_.disturb({Disturbance::Kind::kLoad, 1, -15});
  cell.run(1);
  EXPECT_LT(cell.truth(1).q, before);
  EXPECT_NEAR(cell.truth(1).q, before, from_deg(0.2 + 0.1 + 0.2));
}

TEST(StepperArm, as_built_boards_store_what_they_are_told_and_move_nothing) {
  StepperArm arm(model(), {AxisWire::kRegistersAsBuilt, SelectKind::kHard, 1, near_home()},
                 Instant{});
  arm.advance(Instant{milliseconds(500)});
  const double before = arm.truth().joints[0].q;
  const auto frame = [&](Instant now, std::initializer_list<std::uint8_t> bytes) {
    spi::Transfer transfer{1, {}, std::chrono::microseconds(200), 500'000};
    for (const std::uint8_t byte : bytes) transfer.mosi.push_back(byte);
    return arm.exchange(transfer, now);
  };
  Instant now{milliseconds(600)};
  const auto next = [&] { return now += milliseconds(20); };
  frame(next(), {0x97});
  EXPECT_EQ(frame(next(), {0xFF})[0], 0x98);
  frame(next(), {0x99});
  frame(next(), {0x55, 1, 0, 2, 2, 0, 1, 0, 4, 0xA7, 0x08, 0x38, 0xBB, 0xAA});
  EXPECT_EQ(frame(next(), {0xFF})[0], 0x00);
  frame(next(), {0, 0, 0, 0x5A, 0xA4, 0xF3, 0xD0, 0x5E});
  EXPECT_EQ(frame(next(), {0, 0, 0, 0})[2], 0x00);
  arm.advance(now + milliseconds(5000));
  EXPECT_NEAR(arm.truth().joints[0].q, before, 1e-3);
}

/// SYN, then the answer to it; 98 is right.
std::uint8_t greeted(StepperArm& arm, std::uint32_t clock_hz, Instant now) {
  const auto frame = [&](std::uint8_t byte, Instant at) {
    spi::Transfer transfer{1, {}, std::chrono::microseconds(200), clock_hz};
    transfer.mosi.push_back(byte);
    return arm.exchange(transfer, at)[0];
  };
  frame(0x97, now);
  return frame(0xFF, now + milliseconds(20));
}

TEST(StepperArm, first_firmware_follows_a_clock_of_4_MHz_and_no_quicker_one) {
  StepperArm arm(model(), {AxisWire::kRegistersAsBuilt, SelectKind::kHard, 1, near_home()},
                 Instant{});
  EXPECT_EQ(greeted(arm, 4'000'001, Instant{milliseconds(100)}), 0xFF);
  const auto quick = [&] {
    for (const Figure& figure : arm.figures(0)) {
      if (figure.name == "quick_clocks") return std::get<std::uint64_t>(figure.value);
    }
    return std::uint64_t{99};
  };
  EXPECT_EQ(quick(), 2U);
  EXPECT_EQ(greeted(arm, 4'000'000, Instant{milliseconds(200)}), 0x98);
  EXPECT_EQ(quick(), 2U);
  StepperArm ours(model(), {AxisWire::kRegisters, SelectKind::kHard, 1, near_home()}, Instant{});
  EXPECT_EQ(greeted(ours, 18'000'000, Instant{milliseconds(100)}), 0x98);
}

TEST(StepperArm, first_firmware_as_it_was_committed_never_answers) {
  StepperArm arm(model(), {AxisWire::kRegistersAsCommitted, SelectKind::kHard, 1, near_home()},
                 Instant{});
  for (int i = 1; i < 5; ++i) {
    EXPECT_EQ(greeted(arm, 500'000, Instant{milliseconds(100 * i)}), 0x00);
  }
}

/// The driver of the document's protocol against the whole arm.
class RegisterCell {
 public:
  RegisterCell()
      : device_(model().device.settings.get<AxisRegistersDevice>()),
        arm_(model(), {AxisWire::kRegisters, SelectKind::kHard, 3, near_home()}, Instant{}),
        driver_(device_, model().joints) {}

  /// Until the next event, at most `seconds`.
  std::optional<DriverEvent> run(double seconds) {
    const Instant end = now_ + from_seconds(seconds);
    while (now_ < end) {
      driver_.poll(now_);
      if (const auto event = driver_.take_event()) return event;
      if (const auto transfer = driver_.take_transfer(now_)) {
        const spi::Bytes miso = arm_.exchange(*transfer, now_);
        now_ += transfer->setup + spi::wire_time(*transfer);
        driver_.exchanged({miso.data(), miso.size()}, now_);
        continue;
      }
      now_ = std::max(now_ + std::chrono::microseconds(100),
                      std::min(end, driver_.next_deadline().value_or(end)));
      arm_.advance(now_);
    }
    return std::nullopt;
  }

  AxisRegistersDevice device_;
  StepperArm arm_;
  AxisRegistersDriver driver_;
  Instant now_{milliseconds(500)};
};

TEST(StepperArm, homes_moves_and_stops_over_the_documents_protocol) {
  RegisterCell cell;
  cell.driver_.open(cell.now_);
  auto event = cell.run(30);
  ASSERT_TRUE(event);
  ASSERT_EQ(event->kind, DriverEvent::Kind::kReady);
  ASSERT_TRUE(cell.driver_.home(cell.now_));
  event = cell.run(300);
  ASSERT_TRUE(event);
  ASSERT_EQ(event->kind, DriverEvent::Kind::kDone) << describe(event->error);

  JointMove move;
  for (const Joint& joint : model().joints) {
    move.q.push_back(joint.lower + from_deg(20));
    move.qd.push_back(0);
  }
  move.duration = std::chrono::seconds(5);
  ASSERT_TRUE(cell.driver_.move(move, cell.now_));
  event = cell.run(60);
  ASSERT_TRUE(event);
  ASSERT_EQ(event->kind, DriverEvent::Kind::kDone) << describe(event->error);
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(cell.arm_.truth().joints[i].q, move.q[i], kPlay) << "joint " << i;
    EXPECT_NEAR(cell.driver_.positions()[i].q, move.q[i], from_deg(0.5)) << "joint " << i;
  }

  for (double& q : move.q) q += from_deg(60);
  ASSERT_TRUE(cell.driver_.move(move, cell.now_));
  EXPECT_FALSE(cell.run(2.5));
  cell.driver_.stop(cell.now_);
  event = cell.run(10);
  ASSERT_TRUE(event);
  cell.run(1);
  EXPECT_FALSE(cell.arm_.truth().moving);
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_LT(cell.arm_.truth().joints[i].q, move.q[i] - from_deg(5)) << "joint " << i;
    const JointPosition& claimed = cell.driver_.positions()[i];
    if (claimed.quality == PositionQuality::kLost) continue;
    EXPECT_GE(cell.arm_.truth().joints[i].q, claimed.lower - kPlay) << "joint " << i;
    EXPECT_LE(cell.arm_.truth().joints[i].q, claimed.upper + kPlay) << "joint " << i;
  }
}

TEST(StepperArm, position_that_a_board_vouches_for_is_true_whatever_happens_to_the_arm) {
  int vouched = 0, silent = 0;  // of the joint that something happened to
  test::for_random_cases(12, [&](test::Random& random) {
    Cell cell(near_home(), random.bits());
    ASSERT_TRUE(cell.home());
    using Kind = Disturbance::Kind;
    for (int event = 0; event < 4; ++event) {
      const auto joint = static_cast<std::size_t>(random.integer(0, kAxes - 1));
      const auto index = static_cast<std::int8_t>(joint);
      cell.send(joint, Mode::kClearFaults);
      cell.send(joint, Mode::kMove, cell.lower(joint) + from_deg(random.uniform(2, 60)));
      cell.run(random.uniform(0, 3));
      const double q = cell.truth(joint).q;
      switch (random.integer(0, 4)) {
        case 0:
          cell.arm_.disturb({Kind::kBlock, index, q + from_deg(random.uniform(-4, 4))});
          break;
        case 1:
          cell.arm_.disturb({Kind::kLoad, index, random.uniform(-80, 80)});
          break;
        case 2:
          cell.arm_.disturb({Kind::kSupply, -1, random.uniform(0, 24)});
          break;
        case 3:
          cell.arm_.disturb({Kind::kMagnet, index, random.uniform(0, 1)});
          break;
        default:
          cell.arm_.disturb({Kind::kPayload, -1, random.uniform(0, 10)});
          break;
      }
      cell.run(random.uniform(0.05, 1));
      for (const Kind kind : {Kind::kUnblock, Kind::kLoad, Kind::kPayload}) {
        cell.arm_.disturb({kind, index, 0});
      }
      cell.arm_.disturb({Kind::kSupply, -1, 24});
      cell.arm_.disturb({Kind::kMagnet, index, 1});
      cell.run(3);
      for (std::size_t i = 0; i < kAxes; ++i) {
        const AxisStatus status = cell.status(i);
        const bool known = status.homed && status.position_ok;
        if (i == joint) ++(known ? vouched : silent);
        if (!known) continue;
        EXPECT_NEAR(status.q, cell.truth(i).q, kPlay) << "joint " << i << " event " << event;
      }
    }
  });
  EXPECT_GT(vouched, 5);
  EXPECT_GT(silent, 5);
}

TEST(StepperArm, same_seed_gives_the_same_run) {
  Cell first(JointVector{}, 42), second(JointVector{}, 42), other(JointVector{}, 43);
  for (Cell* cell : {&first, &second, &other}) {
    cell->send(0, Mode::kHome);
    cell->run(3);
  }
  EXPECT_EQ(first.truth(0).q, second.truth(0).q);
  EXPECT_NE(first.truth(0).q, other.truth(0).q);
}

TEST(StepperArm, never_allocates) {
  Cell cell;
  const test::AllocationCounter allocations;
  cell.send(0, Mode::kHome);
  cell.run(1);
  cell.arm_.disturb({Disturbance::Kind::kSupply, -1, 4});
  cell.advance(milliseconds(50));
  cell.arm_.disturb({Disturbance::Kind::kSupply, -1, 24});
  cell.advance(milliseconds(200));
  EXPECT_EQ(allocations.count(), 0U);
}

TEST(StepperArm, joint_encoder_whose_coupling_slips_is_found_by_its_board_alone) {
  Cell cell;
  ASSERT_TRUE(cell.home());
  const std::array slips{1, 4};  // quadrature, AS5600
  for (const int joint : slips) {
    cell.arm_.disturb({Disturbance::Kind::kCoupling, static_cast<std::int8_t>(joint), 0});
  }
  for (std::size_t i = 0; i < kAxes; ++i) cell.send(i, Mode::kMove, cell.lower(i) + from_deg(12));
  cell.settle(20);
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool spoiled = i == 1 || i == 4;
    EXPECT_EQ(cell.status(i).fault, spoiled ? AxisFault::kEncodersDisagree : AxisFault::kNone) << i;
    EXPECT_EQ(cell.status(i).position_ok, !spoiled) << i;
  }
}

}  // namespace
}  // namespace sinew::sim
