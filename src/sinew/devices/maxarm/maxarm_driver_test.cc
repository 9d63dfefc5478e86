#include "sinew/devices/maxarm/maxarm_driver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <string>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/maxarm/maxarm_test_cell.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace maxarm;
using namespace std::chrono_literals;
using Cell = test::MaxArmCell;
using Kind = DriverEvent::Kind;
using DisturbanceKind = sim::Disturbance::Kind;
using enum MaxArmVariant;

const std::array<double, 3> kFar{359, 317, 674};
const std::array<double, 3> kOther{641, 420, 600};

std::vector<Request> requests_in(std::span<const std::uint8_t> bytes) {
  RequestDecoder decoder;
  std::vector<Request> requests;
  for (const std::uint8_t byte : bytes) {
    if (const auto request = decoder.push(byte)) requests.push_back(*request);
  }
  return requests;
}

template <class T>
std::vector<T> sent(const Cell& cell) {
  std::vector<T> found;
  for (const Request& request : requests_in(cell.sent)) {
    if (const auto* one = std::get_if<T>(&request)) found.push_back(*one);
  }
  return found;
}

/// Joints whose truth lies outside of what is claimed, as text; empty where none does.
std::string lies(const Cell& cell) {
  std::string text;
  const auto truth = cell.machine.truth();
  for (std::size_t i = 0; i < 3; ++i) {
    const JointPosition& p = cell.driver.positions()[i];
    const double q = truth.joints[i].q;
    constexpr double kRounding = 1e-9;
    if (p.quality == PositionQuality::kLost) continue;
    if (q >= p.lower - kRounding && q <= p.upper + kRounding) continue;
    text += "J" + std::to_string(i + 1) + " is at " + std::to_string(q) + ", claimed " +
            std::to_string(p.lower) + ".." + std::to_string(p.upper) + "; ";
  }
  return text;
}

void expect_at(const Cell& cell, const std::array<double, 3>& pulses, double tolerance = 6) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(cell.true_pulse(i), pulses[i], tolerance) << i;
}

TEST(MaxArmDriver, opens_with_a_mark_and_two_readings_and_sends_nothing_that_moves) {
  for (const auto variant : {kArduino, kMicroPython}) {
    Cell cell({.variant = variant, .opened = false});
    EXPECT_EQ(cell.driver.state(), DriverState::kClosed);
    cell.driver.open(cell.now);
    EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
    EXPECT_EQ(cell.driver.move(cell.to(kFar, 1s), cell.now).error().code, ErrorCode::kBusy);
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 5s));
    const auto requests = requests_in(cell.sent);
    EXPECT_EQ(requests, (std::vector<Request>{ReadXyz{}, ReadAngle{}, ReadAngle{}}));
    ASSERT_EQ(cell.events.size(), 1U);
    EXPECT_EQ(cell.events[0].kind, Kind::kReady);
    EXPECT_EQ(lies(cell), "");
    for (const JointPosition& p : cell.driver.positions()) {
      EXPECT_EQ(p.quality, PositionQuality::kMeasured);
    }
  }
}

TEST(MaxArmDriver, moves_with_one_set_and_tells_where_it_really_is) {
  for (const auto variant : {kArduino, kMicroPython}) {
    for (const auto checksum : {MaxArmChecksum::kSpec, MaxArmChecksum::kWithHeader}) {
      Cell cell({.checksum = checksum, .variant = variant});
      cell.each_step = [&] { ASSERT_EQ(lies(cell), ""); };
      ASSERT_TRUE(cell.driver.move(cell.to(kFar, 1s), cell.now));
      EXPECT_FALSE(cell.driver.wants_move(cell.now));
      const auto end = cell.run_to_end(10s);
      ASSERT_TRUE(end);
      EXPECT_EQ(end->kind, Kind::kDone);
      expect_at(cell, kFar);
      const auto sets = sent<SetAngle>(cell);
      // 1000 ms would have made the sum one of the data bytes, or not; a little later is allowed.
      // A board that takes it soon takes as much longer for it.
      const std::uint16_t longer = variant == kArduino ? 0 : 120;
      ASSERT_EQ(sets.size(), 1U);
      EXPECT_EQ(sets[0].pulses, (std::array<std::uint16_t, 3>{359, 317, 674}));
      EXPECT_GE(sets[0].time_ms, 1000);
      EXPECT_LE(sets[0].time_ms, 1015 + longer);
      const bool spec = checksum == MaxArmChecksum::kSpec;
      EXPECT_EQ(cell.driver.checksum(), spec ? Checksum::kSpec : Checksum::kWithHeader);
    }
  }
}

TEST(MaxArmDriver, ends_and_is_told_at_the_same_instants_whenever_it_was_asked) {
  for (const auto variant : {kArduino, kMicroPython}) {
    ASSERT_EQ(kMaxArmSetTime,
              static_cast<int>(encode_request(SetAngle{}).size()) * MaxArmTiming().byte_time);
    const MaxArmPace pace = pace_of(variant);
    test::for_random_cases(100, [&](test::Random& random) {
      Cell cell({.variant = variant, .seed = random.bits()});
      const Duration move = std::chrono::milliseconds(random.integer(500, 2000));
      // Clear of the readings at rest.
      cell.run_for(std::chrono::milliseconds(random.integer(0, 200)));
      ASSERT_TRUE(cell.driver.wants_move(cell.now));
      const Instant asked = cell.now;
      ASSERT_TRUE(cell.driver.move(cell.to(kFar, move), asked));
      // As long as its ramps run: a little less than all of it, and a little more.
      const Duration ramps = pace.begins + move;
      cell.run_for(ramps - 40ms);
      EXPECT_GT(std::abs(cell.true_pulse(0) - kFar[0]), 1) << "not sooner than it was said";
      cell.run_for(40ms + MaxArmPace::settles);
      expect_at(cell, kFar, 2.5);
      const auto end = cell.run_to_end(10s);
      ASSERT_TRUE(end);
      EXPECT_EQ(end->kind, Kind::kDone);
      EXPECT_EQ(sent<SetAngle>(cell).size(), 1U) << "no look fell into it";
      // One in some hundred answers comes later still.
      const double late = to_seconds(cell.now - asked - move - pace.told());
      EXPECT_GE(late, -1e-3);
      EXPECT_LE(late, 0.1);
    });
  }
}

TEST(MaxArmDriver, a_host_that_was_told_the_other_board_only_loses_time) {
  for (const auto variant : {kArduino, kMicroPython}) {
    const auto other = variant == kArduino ? kMicroPython : kArduino;
    test::for_random_cases(50, [&](test::Random& random) {
      Cell cell({.variant = variant, .seed = random.bits(), .taken_for = other});
      cell.each_step = [&] { ASSERT_EQ(lies(cell), ""); };
      cell.run_for(std::chrono::milliseconds(random.integer(0, 2000)));
      for (const auto& target : {kFar, kOther}) {
        ASSERT_TRUE(cell.run_until(DriverState::kReady, 5s));
        ASSERT_TRUE(cell.driver.move(cell.to(target, 1s), cell.now));
        const auto end = cell.run_to_end(20s);
        ASSERT_TRUE(end);
        EXPECT_EQ(end->kind, Kind::kDone);
        expect_at(cell, target);
      }
    });
  }
}

TEST(MaxArmDriver, keeps_frames_apart_and_asks_at_most_eight_times_a_second) {
  Cell cell;
  ASSERT_TRUE(cell.driver.move(cell.to(kFar, 5s), cell.now));
  cell.run_for(6s);
  std::vector<Instant> reads;
  for (std::size_t i = 1; i < cell.sent.size(); ++i) {
    if (cell.sent[i - 1] != 0xAA || cell.sent[i] != 0x55) continue;
    if (i >= 2) {
      EXPECT_GE(cell.sent_at[i - 1] - cell.sent_at[i - 2], 20ms);
    }
    if (cell.sent[i + 1] == 0x11) reads.push_back(cell.sent_at[i]);
  }
  ASSERT_GT(reads.size(), 10U);
  for (std::size_t i = 1; i < reads.size(); ++i) EXPECT_GE(reads[i] - reads[i - 1], 125ms);
}

TEST(MaxArmDriver, refuses_what_it_may_not_send_and_sends_nothing) {
  Cell cell;
  cell.run_for(200ms);
  const std::size_t before = sent<SetAngle>(cell).size();
  const auto refused = [&](JointMove move) { return cell.driver.move(move, cell.now).error(); };
  JointMove nan = cell.to(kFar, 1s);
  nan.q[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refused(nan).code, ErrorCode::kJointLimit);
  EXPECT_EQ(refused(nan).index, 1);
  EXPECT_EQ(refused(cell.to({1001, 500, 500}, 1s)).code, ErrorCode::kJointLimit);
  EXPECT_EQ(refused(cell.to({500, 500, 499}, 1s)).code, ErrorCode::kJointLimit);
  const Error zero = refused(cell.to({0, 500, 500}, 5s));
  EXPECT_EQ(zero.code, ErrorCode::kPulseRange) << "a servo at 0 kills the MicroPython program";
  EXPECT_EQ(zero.index, 0);
  EXPECT_EQ(zero.limit, 1);
  EXPECT_EQ(refused(cell.to({500, 500, 505}, 19ms)).code, ErrorCode::kSegmentTime);
  EXPECT_EQ(refused(cell.to({500, 500, 505}, 31s)).code, ErrorCode::kSegmentTime);
  const Error fast = refused(cell.to({1000, 500, 505}, 600ms));
  EXPECT_EQ(fast.code, ErrorCode::kSegmentTime) << "120 deg in 0.6 s is faster than the joint may";
  EXPECT_NEAR(fast.limit, 120.0 / 180, 0.01);
  JointMove two = cell.to(kFar, 1s);
  two.q.pop_back();
  EXPECT_EQ(refused(two).code, ErrorCode::kTaskNotSupported);
  cell.run_for(2s);
  EXPECT_EQ(sent<SetAngle>(cell).size(), before);
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
}

TEST(MaxArmDriver, every_frame_that_moves_survives_a_single_fault_and_a_look_in_its_middle) {
  const Cell ready;
  test::for_random_cases(20'000, [&](test::Random& random) {
    MaxArmDriver driver = ready.driver;
    const auto pulse = [&](int low, int high) {
      return static_cast<double>(random.integer(low, high));
    };
    const std::array<double, 3> to{pulse(1, 1000), pulse(1, 875), pulse(500, 1000)};
    const Duration time = std::chrono::milliseconds(random.integer(1500, 30'000));
    ASSERT_TRUE(driver.move(ready.to(to, time), ready.now));
    Instant now = ready.now;
    std::array<std::uint8_t, 64> piece{};
    std::size_t count = 0;
    const FrameBytes answer = encode_reply(Angles{{500, 500, 501}}, Checksum::kSpec);
    for (int i = 0; i < 40 && count != kFrameMax; ++i) {
      if (count > 0) driver.receive(answer, now);
      driver.poll(now += 20ms);
      count = driver.take_output(piece);
    }
    ASSERT_EQ(count, kFrameMax);
    const FrameBytes frame(std::span<const std::uint8_t>(piece).first(count));
    EXPECT_TRUE(survives_one_fault(frame) && survives_a_look(frame));
    const auto set = std::get<SetAngle>(requests_in(frame).at(0));
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(set.pulses[i], to[i], 1.01);
    EXPECT_GE(set.time_ms, time / 1ms);
    EXPECT_LT(set.time_ms, time / 1ms + 16);
  });
}

TEST(MaxArmDriver, a_lost_set_is_seen_and_sent_again_and_moves_once) {
  for (const auto variant : {kArduino, kMicroPython}) {
    for (std::size_t lost = 0; lost < 13; ++lost) {
      Cell cell({.variant = variant});
      // One byte of the SET vanishes.
      std::optional<std::size_t> set_begins;
      cell.lose = [&](std::size_t n) {
        if (!set_begins && n >= 3 && cell.sent[n] == 0x08 && cell.sent[n - 1] == 0x01) {
          set_begins = n - 3;
        }
        return set_begins ? n == *set_begins + lost && lost >= 3 : lost < 3 && n % 997 == lost;
      };
      ASSERT_TRUE(cell.driver.move(cell.to(kFar, 800ms), cell.now));
      const auto end = cell.run_to_end(30s);
      ASSERT_TRUE(end) << lost;
      EXPECT_EQ(end->kind, Kind::kDone) << lost;
      expect_at(cell, kFar);
      for (const SetAngle& set : sent<SetAngle>(cell)) {
        EXPECT_EQ(set.pulses, (std::array<std::uint16_t, 3>{359, 317, 674}));
      }
      EXPECT_GE(sent<SetAngle>(cell).size(), lost >= 3 ? 2U : 1U) << lost;
    }
  }
}

TEST(MaxArmDriver, a_lost_question_and_a_lost_answer_only_cost_time) {
  for (const char* const fault : {"cut@300ms:400ms", "half-open@300ms:to-host:600ms",
                                  "half-open@300ms:to-device:600ms", "cut@1200ms:2s"}) {
    for (const auto variant : {kArduino, kMicroPython}) {
      Cell cell({.variant = variant});
      auto plan = sim::parse_faults(fault);
      ASSERT_TRUE(plan);
      cell.link = sim::LinkFaults(plan->link, cell.now);
      cell.each_step = [&] { ASSERT_EQ(lies(cell), "") << fault; };
      ASSERT_TRUE(cell.driver.move(cell.to(kFar, 1s), cell.now));
      const auto end = cell.run_to_end(40s);
      ASSERT_TRUE(end) << fault;
      EXPECT_EQ(end->kind, Kind::kDone) << fault;
      EXPECT_GT(cell.driver.health().timeouts, 0U) << fault;
      expect_at(cell, kFar);
    }
  }
}

TEST(MaxArmDriver, silence_ends_in_a_fault_that_clears_when_the_cable_is_back) {
  Cell cell;
  auto plan = sim::parse_faults("cut@100ms:40s");
  ASSERT_TRUE(plan);
  cell.link = sim::LinkFaults(plan->link, cell.now);
  ASSERT_TRUE(cell.driver.move(cell.to(kFar, 1s), cell.now));
  const auto end = cell.run_to_end(60s);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->kind, Kind::kFailed);
  EXPECT_EQ(end->error.code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_EQ(cell.driver.move(cell.to(kOther, 1s), cell.now).error().code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.driver.tool(Suction{}, cell.now).error().code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kUncertain);
  EXPECT_EQ(lies(cell), "");
  EXPECT_FALSE(cell.driver.next_deadline());
  cell.run_for(20s);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 20s));
  expect_at(cell, kFar);  // the SET had left before the cut
  EXPECT_FALSE(cell.driver.fault());
}

TEST(MaxArmDriver, blocked_joint_is_a_missed_target_with_numbers) {
  Cell cell;
  cell.machine.disturb({DisturbanceKind::kBlock, 0, from_deg(100)});
  ASSERT_TRUE(cell.driver.move(cell.to(kFar, 1s), cell.now));
  const auto end = cell.run_to_end(30s);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->kind, Kind::kFailed);
  EXPECT_EQ(end->error.code, ErrorCode::kMissedTarget);
  EXPECT_EQ(end->error.index, 0);
  EXPECT_NEAR(end->error.measured, from_deg(100), from_deg(0.2));
  EXPECT_NEAR(end->error.limit, from_deg(359 * 0.24), 1e-9);
  EXPECT_EQ(sent<SetAngle>(cell).size(), 1U) << "it did arrive; nothing is pushed again";
  EXPECT_EQ(lies(cell), "");
}

TEST(MaxArmDriver, stop_holds_the_arm_on_its_way_from_any_moment) {
  for (const auto variant : {kArduino, kMicroPython}) {
    for (Duration after = 0ms; after <= 3200ms; after += 200ms) {
      Cell cell({.variant = variant});
      cell.each_step = [&] { ASSERT_EQ(lies(cell), "") << to_seconds(after); };
      ASSERT_TRUE(cell.driver.move(cell.to({100, 500, 502}, 3s), cell.now));
      cell.run_for(after);
      if (cell.driver.state() != DriverState::kMoving) continue;
      const double at_stop = cell.true_pulse(0);
      cell.driver.stop(cell.now);
      // Twice is once, while it is under way.
      if (cell.driver.state() == DriverState::kStopping) cell.driver.stop(cell.now);
      const bool stops = cell.driver.state() == DriverState::kStopping;
      EXPECT_EQ(cell.driver.goes_on_until().has_value(), stops);
      const auto end = cell.run_to_end(10s);
      ASSERT_TRUE(end);
      EXPECT_EQ(end->kind, Kind::kStopped);
      EXPECT_FALSE(cell.driver.goes_on_until());
      const double stopped = cell.true_pulse(0);
      cell.run_for(3s);
      EXPECT_NEAR(cell.true_pulse(0), stopped, 1) << "nothing moves on";
      EXPECT_EQ(std::ranges::count_if(
                    cell.events, [](const DriverEvent& e) { return e.kind == Kind::kStopped; }),
                1);
      // 400 pulses in 3 s; an answer, a SET, and the board's latency: at most 0.8 s of way.
      EXPECT_LE(at_stop - stopped, 110) << to_seconds(after);
      EXPECT_TRUE(cell.driver.wants_move(cell.now));
    }
  }
}

TEST(MaxArmDriver, stop_is_accepted_in_every_state) {
  Cell closed({.opened = false});
  closed.driver.stop(closed.now);
  ASSERT_EQ(closed.driver.take_event()->kind, Kind::kStopped);
  Cell ready;
  ready.driver.stop(ready.now);
  ASSERT_EQ(ready.driver.take_event()->kind, Kind::kStopped);
  ready.run_for(2s);
  EXPECT_TRUE(sent<SetAngle>(ready).empty());
  // While the line is dead: it waits, and holds the arm as soon as it can.
  Cell deaf;
  auto plan = sim::parse_faults("cut@300ms:2s");
  ASSERT_TRUE(plan);
  deaf.link = sim::LinkFaults(plan->link, deaf.now);
  ASSERT_TRUE(deaf.driver.move(deaf.to({20, 500, 502}, 10s), deaf.now));
  deaf.run_for(500ms);
  deaf.driver.stop(deaf.now);
  const auto end = deaf.run_to_end(20s);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->kind, Kind::kStopped);
  EXPECT_GT(deaf.true_pulse(0), 200);
}

TEST(MaxArmDriver, close_fails_the_command_and_open_finds_the_arm_again) {
  Cell cell;
  ASSERT_TRUE(cell.driver.move(cell.to(kFar, 2s), cell.now));
  cell.run_for(1s);
  cell.driver.close(cell.now);
  const auto event = cell.driver.take_event();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, Kind::kFailed);
  EXPECT_EQ(event->error.code, ErrorCode::kPortClosed);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kUncertain);
  cell.run_for(300ms);
  EXPECT_EQ(cell.driver.state(), DriverState::kClosed);
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 10s));
  expect_at(cell, kFar);
  EXPECT_EQ(lies(cell), "");
}

TEST(MaxArmDriver, suction_is_sent_twice_and_the_nozzle_once) {
  Cell cell;
  ASSERT_TRUE(cell.driver.tool(Suction{Suction::State::kOn}, cell.now));
  EXPECT_EQ(cell.run_to_end(5s)->kind, Kind::kDone);
  EXPECT_TRUE(cell.machine.truth().suction);
  EXPECT_EQ(sent<SetSuction>(cell), (std::vector<SetSuction>{{1}, {1}}));
  ASSERT_TRUE(cell.driver.tool(Suction{Suction::State::kRelease}, cell.now));
  EXPECT_EQ(cell.run_to_end(5s)->kind, Kind::kDone);
  ASSERT_TRUE(cell.driver.tool(Suction{Suction::State::kOff}, cell.now));
  EXPECT_EQ(cell.run_to_end(5s)->kind, Kind::kDone);
  EXPECT_EQ(sent<SetSuction>(cell), (std::vector<SetSuction>{{1}, {1}, {2}, {2}, {3}, {3}}));
  const Instant asked = cell.now;
  ASSERT_TRUE(cell.driver.tool(NozzleTo{from_deg(45), 1s}, cell.now));
  EXPECT_EQ(cell.driver.move(cell.to(kFar, 1s), cell.now).error().code, ErrorCode::kBusy);
  EXPECT_EQ(cell.run_to_end(5s)->kind, Kind::kDone);
  EXPECT_GE(cell.now - asked, 1s) << "the Arduino program is deaf while the nozzle turns";
  EXPECT_NEAR(cell.machine.truth().tool, from_deg(45), 1e-9);
  ASSERT_EQ(sent<SetPwmServo>(cell).size(), 1U);
  EXPECT_EQ(sent<SetPwmServo>(cell)[0].pulse_us, 1000) << "the document's scale";
  EXPECT_EQ(cell.machine.firmware().restarts(), 0U);
}

TEST(MaxArmDriver, tool_refuses_what_would_restart_the_board) {
  Cell cell;
  const auto refused = [&](const ToolAction& a) { return cell.driver.tool(a, cell.now).error(); };
  EXPECT_EQ(refused(NozzleTo{0, 19ms}).code, ErrorCode::kSegmentTime);
  EXPECT_EQ(refused(NozzleTo{0, 31s}).code, ErrorCode::kSegmentTime);
  EXPECT_EQ(refused(NozzleTo{from_deg(181), 1s}).code, ErrorCode::kGripperRange);
  EXPECT_EQ(refused(NozzleTo{from_deg(-1), 1s}).code, ErrorCode::kGripperRange);
  EXPECT_EQ(refused(NozzleTo{std::numeric_limits<double>::quiet_NaN(), 1s}).code,
            ErrorCode::kGripperRange);
  EXPECT_EQ(refused(JawsTo{0.01}).code, ErrorCode::kToolNotFitted);
  EXPECT_EQ(refused(GripperTo{}).code, ErrorCode::kToolNotFitted);
  EXPECT_EQ(cell.driver.home(cell.now).error().code, ErrorCode::kTaskNotSupported);
}

TEST(MaxArmDriver, dead_servo_is_a_fault_and_its_position_lost) {
  Cell cell;
  cell.machine.disturb({DisturbanceKind::kMagnet, 1, 0});
  ASSERT_TRUE(cell.run_until(DriverState::kFault, 5s));
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kEncoderLost);
  EXPECT_EQ(cell.driver.fault()->index, 1);
  EXPECT_EQ(cell.driver.positions()[1].quality, PositionQuality::kLost);
  cell.machine.disturb({DisturbanceKind::kMagnet, 1, 1});
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  EXPECT_TRUE(cell.run_until(DriverState::kReady, 10s));
}

TEST(MaxArmDriver, board_that_restarts_and_homes_by_itself_is_noticed) {
  for (const auto variant : {kArduino, kMicroPython}) {
    Cell cell({.variant = variant});
    ASSERT_TRUE(cell.driver.move(cell.to(kFar, 1s), cell.now));
    ASSERT_TRUE(cell.run_to_end(10s));
    cell.machine.disturb({DisturbanceKind::kSupply, -1, 0});
    cell.run_for(1s);
    cell.machine.disturb({DisturbanceKind::kSupply, -1, 12});
    cell.run_for(5s);
    EXPECT_EQ(cell.driver.positions()[0].quality,
              variant == kArduino ? PositionQuality::kMeasured : PositionQuality::kUncertain);
    EXPECT_TRUE(cell.run_until(DriverState::kReady, 25s));
    expect_at(cell, {500, 500, 500});
    EXPECT_EQ(lies(cell), "");
  }
}

TEST(MaxArmDriver, an_arm_that_is_found_elsewhere_is_told_once_a_place) {
  Cell cell;
  ASSERT_TRUE(cell.driver.move(cell.to(kFar, 1s), cell.now));
  ASSERT_TRUE(cell.run_to_end(10s));
  cell.events.clear();
  cell.run_for(5s);
  EXPECT_TRUE(cell.events.empty()) << "it stands where it was sent";
  // Its servos let go, the board stays awake.
  cell.machine.disturb({DisturbanceKind::kSupply, -1, 5.5});
  cell.run_for(5s);
  ASSERT_EQ(cell.events.size(), 1U);
  EXPECT_EQ(cell.events[0].kind, Kind::kNotice);
  EXPECT_EQ(cell.events[0].error.code, ErrorCode::kMovedUnasked);
  const auto joint = static_cast<std::size_t>(cell.events[0].error.index);
  EXPECT_NEAR(cell.events[0].error.measured, cell.machine.truth().joints[joint].q, from_deg(2));
  EXPECT_NEAR(cell.events[0].error.limit, cell.to(kFar, 1s).q[joint], from_deg(1.5));
  cell.machine.disturb({DisturbanceKind::kSupply, -1, 7.5});
  cell.run_for(5s);
  ASSERT_EQ(cell.events.size(), 2U) << "and that it came back";
  EXPECT_NEAR(cell.events[1].error.measured, cell.to(kFar, 1s).q[joint], from_deg(1.5));
}

TEST(MaxArmDriver, a_move_that_was_planned_from_elsewhere_is_refused_with_both_places) {
  Cell cell;
  ASSERT_TRUE(cell.driver.move(cell.to(kFar, 1s), cell.now));
  ASSERT_TRUE(cell.run_to_end(10s));
  cell.machine.disturb({DisturbanceKind::kSupply, -1, 5.5});
  cell.run_for(5s);
  cell.sent.clear();
  JointMove move = cell.to(kOther, 2s);
  move.q_start = cell.to(kFar, 1s).q;
  const auto refused = cell.driver.move(move, cell.now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kMovedUnasked);
  const auto joint = static_cast<std::size_t>(refused.error().index);
  EXPECT_EQ(refused.error().limit, move.q_start[joint]);
  EXPECT_NEAR(refused.error().measured, cell.machine.truth().joints[joint].q, from_deg(2));
  cell.run_for(1s);
  EXPECT_TRUE(sent<SetAngle>(cell).empty());
  // Who plans from where it is may go on.
  for (std::size_t i = 0; i < 3; ++i) move.q_start[i] = cell.driver.positions()[i].q;
  EXPECT_TRUE(cell.driver.move(move, cell.now));
}

TEST(MaxArmDriver, an_answer_with_the_other_sum_is_noise_until_it_is_all_that_comes) {
  Cell cell;
  // The board is exchanged for one with the other sum.
  const auto reply = [&](Checksum checksum) {
    cell.driver.receive(encode_reply(Angles{{700, 500, 500}}, checksum), cell.now);
  };
  while (cell.sent.empty() || cell.sent.back() != 0xEE) cell.run_for(1ms);
  const JointPosition before = cell.driver.positions()[0];
  reply(Checksum::kWithHeader);
  EXPECT_EQ(cell.driver.positions()[0].q, before.q) << "one flipped bit looks just like this";
  reply(Checksum::kWithHeader);
  reply(Checksum::kWithHeader);
  while (const auto event = cell.driver.take_event()) cell.events.push_back(*event);
  ASSERT_FALSE(cell.events.empty());
  EXPECT_EQ(cell.events.back().kind, Kind::kNotice);
  EXPECT_EQ(cell.events.back().error.code, ErrorCode::kChecksum);
  reply(Checksum::kWithHeader);
  EXPECT_EQ(cell.driver.checksum(), Checksum::kWithHeader);
}

TEST(MaxArmDriver, works_without_allocating) {
  const RobotModel robot = test::maxarm_model();
  MaxArmDriver driver(robot.device.settings.get<MaxArmDevice>(), robot.joints);
  std::array<std::uint8_t, 64> piece{};
  Instant now{};
  const test::AllocationCounter allocations;
  driver.open(now);
  const JointMove move{.q = {2.0, 1.5, 0.1}, .qd = {0, 0, 0}, .duration = 1s};
  for (int i = 0; i < 3000; ++i) {
    now += 5ms;
    driver.poll(now);
    while (const std::size_t n = driver.take_output(piece)) {
      for (const auto& request : {piece[2]}) {
        if (n != 5) continue;
        const Reply reply = request == 0x11 ? Reply{Angles{{500, 500, 500}}} : Reply{Position{}};
        driver.receive(encode_reply(reply, Checksum::kSpec), now);
      }
    }
    if (driver.wants_move(now)) (void)driver.move(move, now);
    if (i == 1500) driver.stop(now);
    while (driver.take_event()) {
    }
  }
  EXPECT_GT(driver.health().requests, 20U);
  EXPECT_EQ(allocations.count(), 0U);
}

/// One run with random faults. The claims are held against the truth all the time, except where the
/// board took a SET that nobody sent (two faults in one frame that fit the sum).
struct Campaign {
  std::uint64_t moves = 0;
  std::uint64_t done = 0;
  std::uint64_t failed = 0;
  std::uint64_t stopped = 0;
  std::uint64_t mistaken = 0;

  void run(test::Random& random) {
    const auto chance = [&](double p) { return random.chance(0.4) ? random.uniform(0, p) : 0.0; };
    sim::LinkFaultSpec faults;
    for (auto& way : faults.bytes) {
      way = {chance(0.01), chance(0.01), chance(0.01), chance(0.005),
             std::chrono::milliseconds(random.integer(1, 400))};
    }
    faults.seed = random.bits();
    Cell cell({.checksum = random.chance(0.5) ? MaxArmChecksum::kSpec : MaxArmChecksum::kWithHeader,
               .variant = random.chance(0.5) ? kArduino : kMicroPython,
               .seed = random.bits()});
    if (random.chance(0.3)) {
      faults.cuts.push_back({std::chrono::milliseconds(random.integer(0, 20'000)),
                             std::chrono::milliseconds(random.integer(1, 3000)), std::nullopt});
    }
    cell.link = sim::LinkFaults(faults, cell.now);
    bool mistake = false;
    std::uint64_t seen = cell.machine.firmware().requests_taken();
    cell.each_step = [&] {
      const auto& board = cell.machine.firmware();
      if (board.requests_taken() != seen) {
        seen = board.requests_taken();
        const Request& last = board.last_taken();
        const auto asked = requests_in(cell.sent);
        mistake = mistake || std::ranges::find(asked, last) == asked.end();
      }
      ASSERT_EQ(mistake ? "" : lies(cell), "");
    };
    for (int k = 0; k < 4 && !mistake; ++k) {
      if (!cell.run_until(DriverState::kReady, 60s)) {
        ASSERT_EQ(cell.driver.state(), DriverState::kFault) << "neither ready nor given up";
        ASSERT_TRUE(cell.driver.clear_fault(cell.now));
        continue;
      }
      const auto pulse = [&](int low, int high) {
        return static_cast<double>(random.integer(low, high));
      };
      const auto to = cell.to({pulse(1, 1000), pulse(150, 800), pulse(500, 800)},
                              std::chrono::milliseconds(random.integer(1500, 4000)));
      if (!cell.driver.move(to, cell.now)) {
        cell.run_for(200ms);
        continue;
      }
      ++moves;
      cell.events.clear();
      if (random.chance(0.3)) {
        cell.run_for(std::chrono::milliseconds(random.integer(0, 2000)));
        cell.driver.stop(cell.now);
      }
      const auto end = cell.events.empty() ? cell.run_to_end(200s) : cell.run_to_end(1ms);
      count(cell, end);
    }
    mistaken += mistake ? 1 : 0;
  }

 private:
  void count(const Cell& cell, const std::optional<DriverEvent>& last) {
    int ends = 0;
    for (const DriverEvent& event : cell.events) {
      done += event.kind == Kind::kDone ? 1 : 0;
      failed += event.kind == Kind::kFailed ? 1 : 0;
      stopped += event.kind == Kind::kStopped ? 1 : 0;
      ends += event.kind != Kind::kReady && event.kind != Kind::kNotice ? 1 : 0;
    }
    ASSERT_TRUE(last || ends > 0) << "a command never ended";
  }
};

TEST(MaxArmDriver, truth_lies_in_what_is_claimed_whatever_happens_on_the_line) {
  Campaign campaign;
  test::for_random_cases(200, [&](test::Random& random) { campaign.run(random); });
  std::cout << "  " << campaign.moves << " moves: " << campaign.done << " done, " << campaign.failed
            << " failed, " << campaign.stopped << " stopped; " << campaign.mistaken
            << " runs with a SET that nobody sent\n";
  EXPECT_GT(campaign.done, campaign.moves / 3);
}

}  // namespace
}  // namespace sinew
