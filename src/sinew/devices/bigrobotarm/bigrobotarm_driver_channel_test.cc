#include "sinew/devices/bigrobotarm/bigrobotarm_driver_channel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string_view>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_device.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace bigrobotarm;
using namespace std::chrono_literals;
using Channel = BigRobotArmChannel;

BigRobotArmDevice arm(BigRobotArmWire wire = BigRobotArmWire::kByte) {
  BigRobotArmDevice device;
  constexpr std::array<double, kJoints> kStepsPerQuarter{6500, -2500, -10000, -2000, 3000};
  constexpr std::array<double, kJoints> kStepsPerRev{3200, 400, 3200, 3200, 3200};
  for (std::size_t i = 0; i < kJoints; ++i) {
    device.joints[i].steps_per_rad = kStepsPerQuarter[i] / (kPi / 2);
    device.joints[i].steps_per_motor_rev = kStepsPerRev[i];
  }
  device.joints[0].multiplier_boot = 200;
  device.wire = wire;
  return device;
}

/// The link between the two ends; tests break it.
struct Link {
  bool cut = false;                  ///< nothing arrives at either end
  int flip_reply_byte = -1;          ///< counts down the bytes of replies; 0 is hit
  std::vector<std::uint8_t> to_arm;  ///< all that the host sent
};

/// Channel and firmware back to back in virtual time.
class Cell {
 public:
  explicit Cell(const BigRobotArmDevice& device = arm(), bool opened = true)
      : device_(device), channel(device), firmware(device, Instant{}) {
    if (!opened) return;
    channel.open(now);
    run_for(200ms);
    EXPECT_EQ(channel.state(), Channel::State::kIdle);
    events.clear();
    link.to_arm.clear();
  }

  BigRobotArmAngles q_of(const Words& steps) const {
    BigRobotArmAngles q{};
    for (std::size_t i = 0; i < kJoints; ++i) q[i] = steps[i] / device_.joints[i].steps_per_rad;
    return q;
  }

  /// Lets time jump from one event to the next until `duration` is over.
  void run_for(Duration duration) {
    const Instant end = now + duration;
    exchange();
    for (int round = 0; round < 10'000; ++round) {
      Instant next = end;
      if (const auto event = firmware.next_event()) next = std::min(next, *event);
      if (const auto due = channel.next_deadline()) next = std::min(next, *due);
      now = std::max(now, next);
      firmware.advance(now);
      exchange();
      channel.poll(now);
      exchange();
      if (now == end) return;
    }
    FAIL() << "driver and firmware keep each other awake at one instant";
  }

  template <class Kind>
  const Kind* last() const {
    return events.empty() ? nullptr : std::get_if<Kind>(&events.back());
  }
  ErrorCode failure() const {
    for (const auto& event : events) {
      if (const auto* failed = std::get_if<Channel::Failed>(&event)) return failed->error.code;
    }
    ADD_FAILURE() << "nothing failed";
    return {};
  }

  BigRobotArmDevice device_;
  Channel channel;
  BigRobotArmFirmware firmware;
  Link link;
  Instant now{};
  std::vector<Channel::Event> events;
  std::vector<Instant> times;

 private:
  void exchange() {
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t count = channel.take_output(piece)) {
      const std::span bytes(piece.data(), count);
      link.to_arm.insert(link.to_arm.end(), bytes.begin(), bytes.end());
      if (!link.cut) firmware.receive(bytes, now);
    }
    while (const std::size_t count = firmware.take_output(piece)) {
      for (std::size_t i = 0; i < count; ++i) {
        if (link.flip_reply_byte-- == 0) piece[i] ^= 0x20;
      }
      if (!link.cut) channel.receive(std::span(piece.data(), count), now);
    }
    while (const auto event = channel.take_event()) {
      events.push_back(*event);
      times.push_back(now);
    }
  }
};

const Words kDocumented{-2400, 600, -5000, 800, -1000};

TEST(BigRobotArmChannel, open_waits_for_quiet_and_reads_the_status_first) {
  Cell cell(arm(), false);
  EXPECT_EQ(cell.channel.read_status(cell.now).error().code, ErrorCode::kBusy);
  cell.channel.open(cell.now);
  cell.run_for(99ms);
  EXPECT_TRUE(cell.link.to_arm.empty());
  cell.run_for(1ms);
  EXPECT_EQ(cell.link.to_arm, (std::vector<std::uint8_t>{8, 0x0D}));
  const auto* status = cell.last<Channel::StatusRead>();
  ASSERT_NE(status, nullptr);
  EXPECT_TRUE(status->after_doubt);
  EXPECT_EQ(cell.channel.start_in(status->status), BigRobotArmStart::kAnew);
}

TEST(BigRobotArmChannel, documented_goto_sends_its_bytes_and_ends_with_its_positions) {
  for (const auto wire : {BigRobotArmWire::kByte, BigRobotArmWire::kText}) {
    Cell cell(arm(wire));
    const Instant start = cell.now;
    ASSERT_TRUE(cell.channel.move_to(cell.q_of(kDocumented), 2562500us, cell.now));
    cell.run_for(10s);
    ASSERT_EQ(cell.events.size(), 2U);
    EXPECT_TRUE(std::holds_alternative<Channel::Started>(cell.events[0]));
    const auto* done = cell.last<Channel::Done>();
    ASSERT_NE(done, nullptr);
    EXPECT_EQ(cell.times.back() - start, 2562500us);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(done->q[i], cell.q_of(kDocumented)[i], 1e-12);
      EXPECT_EQ(cell.firmware.rotor_steps(cell.now)[i], kDocumented[i]);
    }
    if (wire == BigRobotArmWire::kText) continue;
    const auto expected = byte::encode_request(Goto{kDocumented});
    ASSERT_EQ(cell.link.to_arm.size(), expected.size() + 1);
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), cell.link.to_arm.begin()));
    EXPECT_EQ(cell.link.to_arm.back(), 0x0D);
  }
}

TEST(BigRobotArmChannel, documented_sequence_runs_on_either_wire) {
  for (const auto wire : {BigRobotArmWire::kByte, BigRobotArmWire::kText}) {
    Cell cell(arm(wire));
    for (int round = 0; round < 5; ++round) {
      for (const Words& target : {Words{100, 200, 300, 400, 300}, Words{0, 50, 5000, 1500, 0}}) {
        ASSERT_TRUE(cell.channel.move_to(cell.q_of(target), 3s, cell.now));
        cell.run_for(4s);
        ASSERT_NE(cell.last<Channel::Done>(), nullptr);
        EXPECT_EQ(cell.firmware.rotor_steps(cell.now)[2], target[2]);
      }
    }
    ASSERT_TRUE(cell.channel.move_to(cell.q_of({}), 3s, cell.now));
    cell.run_for(4s);
    EXPECT_NE(cell.last<Channel::Done>(), nullptr);
    EXPECT_EQ(cell.firmware.rotor_steps(cell.now)[2], 0);
  }
}

TEST(BigRobotArmChannel, every_setting_is_sent_and_its_echo_checked) {
  for (const auto wire : {BigRobotArmWire::kByte, BigRobotArmWire::kText}) {
    Cell cell(arm(wire));
    const auto done = [&](Expected<void> asked) {
      EXPECT_TRUE(asked);
      cell.run_for(1s);
      const bool right = cell.last<Channel::Done>() != nullptr;
      cell.events.clear();
      return right;
    };
    EXPECT_TRUE(done(cell.channel.set_speeds({100, 1, 300, 12, 14}, cell.now)));
    EXPECT_TRUE(done(cell.channel.set_accelerations({270, 268, 3, 4, 5}, cell.now)));
    EXPECT_TRUE(done(cell.channel.set_gripper(true, 180, cell.now)));
    EXPECT_TRUE(done(cell.channel.set_gripper(false, 40, cell.now)));
    EXPECT_EQ(cell.firmware.gripper(), (Gripper{false, 180}));
    ASSERT_TRUE(cell.channel.read_status(cell.now));
    cell.run_for(1s);
    const auto* read = cell.last<Channel::StatusRead>();
    ASSERT_NE(read, nullptr);
    EXPECT_EQ(read->status.speeds, (Words{100, 1, 300, 12, 14}));
    EXPECT_EQ(read->status.accelerations, (Words{270, 268, 3, 4, 5}));
    EXPECT_EQ(cell.channel.start_in(read->status), BigRobotArmStart::kNone);
    EXPECT_FALSE(read->after_doubt);
  }
}

TEST(BigRobotArmChannel, reset_moves_the_device_zero_and_keeps_the_model_position) {
  Cell cell;
  ASSERT_TRUE(cell.channel.move_to(cell.q_of(kDocumented), 3s, cell.now));
  cell.run_for(4s);
  ASSERT_TRUE(cell.channel.reset_positions(cell.now));
  cell.run_for(1s);
  const auto* done = cell.last<Channel::Done>();
  ASSERT_NE(done, nullptr);
  EXPECT_NEAR(done->q[2], cell.q_of(kDocumented)[2], 1e-12);
  ASSERT_TRUE(cell.channel.move_to({}, 3s, cell.now));
  cell.run_for(4s);
  ASSERT_NE(cell.last<Channel::Done>(), nullptr);
  for (const double steps : cell.firmware.rotor_steps(cell.now)) EXPECT_EQ(steps, 0);
}

TEST(BigRobotArmChannel, unsendable_target_goes_to_its_neighbour_or_is_refused) {
  for (const auto& [wanted, sent] : std::vector<std::array<double, 2>>{{13, 14},
                                                                       {12.7, 12},
                                                                       {13.4, 14},
                                                                       {269, 270},
                                                                       {-243, -242},
                                                                       {3328, 3327},
                                                                       {3583, 3584}}) {
    Cell cell;
    BigRobotArmAngles q{};
    q[0] = wanted / cell.device_.joints[0].steps_per_rad;
    // A whole step sits on a tie that rounding decides; both neighbours are right there.
    ASSERT_TRUE(cell.channel.move_to(q, 3s, cell.now)) << wanted;
    cell.run_for(10s);
    const auto* done = cell.last<Channel::Done>();
    ASSERT_NE(done, nullptr) << wanted;
    const double steps = std::round(done->q[0] * cell.device_.joints[0].steps_per_rad);
    EXPECT_TRUE(byte::sendable(static_cast<std::int32_t>(steps)));
    EXPECT_LE(std::abs(steps - wanted), 1);
    if (wanted == std::round(wanted) && wanted < 3000) continue;
    EXPECT_EQ(steps, sent) << wanted;
    EXPECT_EQ(cell.firmware.rotor_steps(cell.now)[0], steps);
  }
  for (const double wanted : {3329.0, 3400.0, 3582.0}) {
    Cell cell;
    BigRobotArmAngles q{};
    q[4] = wanted / cell.device_.joints[4].steps_per_rad;
    const auto asked = cell.channel.move_to(q, 3s, cell.now);
    ASSERT_FALSE(asked);
    EXPECT_EQ(asked.error(), (Error{ErrorCode::kUnsendable, 4, wanted, 0}));
    cell.run_for(1s);
    EXPECT_TRUE(cell.link.to_arm.empty());
    Cell text(arm(BigRobotArmWire::kText));
    EXPECT_TRUE(text.channel.move_to(q, 3s, text.now)) << "text has no such gap";
  }
}

TEST(BigRobotArmChannel, values_out_of_range_never_leave) {
  Cell cell;
  const auto code = [](const Expected<void>& result) {
    EXPECT_FALSE(result);
    return result ? ErrorCode{} : result.error().code;
  };
  for (const std::int32_t value : {0, -1, 301, 3000}) {
    EXPECT_EQ(code(cell.channel.set_speeds({1, 1, value, 1, 1}, cell.now)),
              ErrorCode::kMultiplierRange);
    EXPECT_EQ(code(cell.channel.set_accelerations({value, 1, 1, 1, 1}, cell.now)),
              ErrorCode::kMultiplierRange);
  }
  for (const std::int32_t value : {13, 269}) {
    EXPECT_EQ(code(cell.channel.set_speeds({1, 1, 1, 1, value}, cell.now)), ErrorCode::kUnsendable);
  }
  EXPECT_EQ(code(cell.channel.set_gripper(true, 181, cell.now)), ErrorCode::kGripperRange);
  EXPECT_EQ(code(cell.channel.set_gripper(true, -1, cell.now)), ErrorCode::kGripperRange);
  EXPECT_EQ(code(cell.channel.set_gripper(true, 13, cell.now)), ErrorCode::kUnsendable);
  for (const double q : {std::nan(""), 1e12, -50000.0, HUGE_VAL}) {
    EXPECT_EQ(code(cell.channel.move_to({0, q, 0, 0, 0}, 1s, cell.now)), ErrorCode::kStepRange);
  }
  cell.run_for(5s);
  EXPECT_TRUE(cell.link.to_arm.empty());
  EXPECT_EQ(cell.channel.state(), Channel::State::kIdle);
}

TEST(BigRobotArmChannel, second_command_is_busy_until_the_first_is_done) {
  Cell cell;
  ASSERT_TRUE(cell.channel.move_to(cell.q_of(kDocumented), 3s, cell.now));
  EXPECT_EQ(cell.channel.move_to(cell.q_of({}), 3s, cell.now).error().code, ErrorCode::kBusy);
  cell.run_for(1s);
  EXPECT_EQ(cell.channel.state(), Channel::State::kMoving);
  EXPECT_EQ(cell.channel.read_status(cell.now).error().code, ErrorCode::kBusy);
  cell.run_for(3s);
  EXPECT_TRUE(cell.channel.read_status(cell.now));
}

TEST(BigRobotArmChannel, silent_device_is_told_after_the_reply_timeout) {
  Cell cell;
  cell.link.cut = true;
  const Instant asked = cell.now;
  ASSERT_TRUE(cell.channel.move_to(cell.q_of(kDocumented), 3s, cell.now));
  cell.run_for(20s);
  EXPECT_EQ(cell.failure(), ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.events.size(), 1U) << "told once, however often it asks again";
  EXPECT_EQ(cell.times.back() - asked, 500ms);
  cell.link.cut = false;
  cell.run_for(1s);
  ASSERT_NE(cell.last<Channel::StatusRead>(), nullptr);
  EXPECT_EQ(cell.channel.state(), Channel::State::kIdle);
}

TEST(BigRobotArmChannel, motion_that_does_not_end_is_told_after_its_time) {
  Cell cell;
  const Instant asked = cell.now;
  ASSERT_TRUE(cell.channel.move_to(cell.q_of({0, 0, 343, 0, 0}), 200ms, cell.now));
  cell.run_for(100ms);
  cell.link.cut = true;
  cell.run_for(3s);
  EXPECT_EQ(cell.failure(), ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.times.back() - asked, 300ms + 2s);
}

TEST(BigRobotArmChannel, time_for_a_motion_is_what_the_boards_processor_needs) {
  // 14000 steps alone at 3430 a second, and five joints sharing 5000 a second.
  for (const auto& [steps, seconds] :
       std::vector<std::pair<Words, double>>{{{0, 0, 14000, 0, 0}, 14000 / 3430.0},
                                             {{6000, 2000, 6000, 2000, 3000}, 19000 / 5000.0}}) {
    Cell cell;
    const Instant asked = cell.now;
    ASSERT_TRUE(cell.channel.move_to(cell.q_of(steps), 1ms, cell.now));
    cell.run_for(100ms);
    cell.link.cut = true;
    cell.run_for(20s);
    EXPECT_EQ(cell.failure(), ErrorCode::kDeviceSilent);
    EXPECT_NEAR(to_seconds(cell.times.back() - asked), 1.5 * seconds + 2, 1e-6);
  }
}

TEST(BigRobotArmChannel, late_replies_of_a_deaf_device_are_drained_before_the_next_command) {
  Cell cell;
  // A quarter of a motor turn a second, which the prediction does not know.
  ASSERT_TRUE(cell.channel.set_speeds({25, 25, 25, 25, 25}, cell.now));
  cell.run_for(1s);
  ASSERT_TRUE(cell.channel.move_to(cell.q_of({0, 0, 14000, 0, 0}), 100ms, cell.now));
  // 17.75 s for the device, 8.1 s for the driver: it asks again and again into deaf ears.
  cell.run_for(30s);
  EXPECT_EQ(cell.failure(), ErrorCode::kDeviceSilent);
  ASSERT_NE(cell.last<Channel::StatusRead>(), nullptr);
  EXPECT_NEAR(cell.last<Channel::StatusRead>()->q[2], cell.q_of({0, 0, 14000, 0, 0})[2], 1e-12);
  ASSERT_TRUE(cell.channel.set_gripper(true, 40, cell.now));
  cell.run_for(1s);
  EXPECT_NE(cell.last<Channel::Done>(), nullptr) << "off by one reply";
}

TEST(BigRobotArmChannel, any_flipped_reply_byte_is_survived) {
  int doubts = 0;
  for (int place = 0; place < 28; ++place) {
    Cell cell;
    cell.link.flip_reply_byte = place;
    ASSERT_TRUE(cell.channel.move_to(cell.q_of(kDocumented), 3s, cell.now));
    cell.run_for(20s);
    // Every byte of a goto's reply is checked, so no flip passes.
    EXPECT_TRUE(std::holds_alternative<Channel::Failed>(cell.events[place < 3 ? 0 : 1])) << place;
    const auto* status = cell.last<Channel::StatusRead>();
    ASSERT_NE(status, nullptr) << place;
    EXPECT_EQ(status->status.positions, kDocumented);
    doubts += status->after_doubt ? 1 : 0;
    ASSERT_TRUE(cell.channel.move_to(cell.q_of({}), 3s, cell.now));
    cell.run_for(10s);
    EXPECT_NE(cell.last<Channel::Done>(), nullptr);
  }
  EXPECT_EQ(doubts, 28);
}

TEST(BigRobotArmChannel, echo_may_be_one_less_but_not_two) {
  for (const auto& [echo, right] : std::vector<std::pair<int, bool>>{
           {117, true}, {116, true}, {118, true}, {115, false}, {119, false}}) {
    Cell cell;
    cell.link.cut = true;
    ASSERT_TRUE(cell.channel.set_speeds({100, 117, 100, 100, 100}, cell.now));
    cell.run_for(1ms);
    const auto reply = byte::encode_reply(Speeds{{100, echo, 100, 100, 100}});
    cell.channel.receive(reply, cell.now);
    cell.run_for(1ms);
    ASSERT_EQ(cell.events.size(), 1U);
    EXPECT_EQ(cell.last<Channel::Done>() != nullptr, right) << echo;
    if (right) continue;
    ASSERT_NE(cell.last<Channel::Failed>(), nullptr);
    EXPECT_EQ(cell.last<Channel::Failed>()->error,
              (Error{ErrorCode::kReplyMismatch, 1, 1.0 * echo, 117}));
  }
}

TEST(BigRobotArmChannel, position_echo_must_be_exact) {
  Cell cell;
  cell.link.cut = true;
  ASSERT_TRUE(cell.channel.move_to(cell.q_of(kDocumented), 3s, cell.now));
  cell.run_for(1ms);
  Words off = kDocumented;
  off[3] += 1;
  for (const Reply& reply : {Reply{MotionStarted{}}, Reply{GotoDone{off}}}) {
    cell.channel.receive(byte::encode_reply(reply), cell.now);
  }
  cell.run_for(1ms);
  ASSERT_NE(cell.last<Channel::Failed>(), nullptr);
  EXPECT_EQ(cell.last<Channel::Failed>()->error,
            (Error{ErrorCode::kReplyMismatch, 3, 1.0 * off[3], 1.0 * kDocumented[3]}));
}

TEST(BigRobotArmChannel, refusal_and_unasked_bytes_end_in_a_status) {
  Cell cell;
  cell.channel.receive(std::array<std::uint8_t, 1>{0xC9}, cell.now);
  cell.run_for(1s);
  EXPECT_EQ(cell.failure(), ErrorCode::kUnaskedReply);
  EXPECT_NE(cell.last<Channel::StatusRead>(), nullptr);
  cell.events.clear();
  cell.link.cut = true;
  ASSERT_TRUE(cell.channel.read_status(cell.now));
  cell.run_for(1ms);
  cell.channel.receive(byte::encode_reply(Invalid{}), cell.now);
  cell.link.cut = false;
  cell.run_for(1s);
  EXPECT_EQ(cell.failure(), ErrorCode::kDeviceRefused);
  EXPECT_NE(cell.last<Channel::StatusRead>(), nullptr);
}

TEST(BigRobotArmChannel, reply_after_its_deadline_counts_as_silence) {
  Cell cell;
  cell.link.cut = true;
  ASSERT_TRUE(cell.channel.set_gripper(true, 40, cell.now));
  cell.run_for(1ms);
  cell.channel.receive(byte::encode_reply(Gripper{true, 40}), cell.now + 1s);
  const auto event = cell.channel.take_event();
  ASSERT_TRUE(event && std::holds_alternative<Channel::Failed>(*event));
  EXPECT_EQ(std::get<Channel::Failed>(*event).error.code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.channel.state(), Channel::State::kQuiet);
}

TEST(BigRobotArmChannel, half_a_reply_does_not_spoil_the_status_that_follows) {
  Cell cell;
  cell.link.cut = true;
  ASSERT_TRUE(cell.channel.set_gripper(true, 40, cell.now));
  cell.run_for(1ms);
  const auto reply = byte::encode_reply(Gripper{true, 40});
  cell.channel.receive(std::span<const std::uint8_t>(reply).first(5), cell.now);
  cell.run_for(500ms);
  cell.link.cut = false;
  cell.link.to_arm.clear();
  cell.run_for(1s);
  EXPECT_NE(cell.last<Channel::StatusRead>(), nullptr);
  EXPECT_EQ(cell.link.to_arm.size(), 2U) << "one status is enough";
}

TEST(BigRobotArmChannel, answer_to_a_question_that_has_not_left_is_no_answer) {
  Cell cell;
  ASSERT_TRUE(cell.channel.set_gripper(true, 40, cell.now));
  cell.channel.receive(byte::encode_reply(Gripper{true, 40}), cell.now);
  cell.run_for(1s);
  EXPECT_EQ(cell.failure(), ErrorCode::kUnaskedReply);
  EXPECT_EQ(cell.firmware.gripper().position, 90) << "what had not begun to leave was dropped";
}

TEST(BigRobotArmChannel, motion_that_was_never_taken_up_is_not_done) {
  Cell cell(arm(BigRobotArmWire::kText));
  cell.link.cut = true;
  ASSERT_TRUE(cell.channel.move_to({}, 1s, cell.now));
  cell.run_for(1ms);
  // The echo is of another command, so that nothing says that a motion began.
  const std::string_view reply =
      "Free mem: 1\r\nProcess command: G92\r\nBigRobotArm::MOVING-TO\r\n"
      "BigRobotArm::POSITION: B0 S0 E0 WR0 W0\r\nBigRobotArm::READY\r\n";
  cell.channel.receive({reinterpret_cast<const std::uint8_t*>(reply.data()), reply.size()},
                       cell.now);
  cell.run_for(1ms);
  EXPECT_EQ(cell.failure(), ErrorCode::kUnexpectedReply);
}

TEST(BigRobotArmChannel, line_that_never_falls_silent_is_told) {
  Cell cell(arm(), false);
  cell.channel.open(cell.now);
  for (int i = 0; i < 200; ++i) {
    cell.channel.receive(std::array<std::uint8_t, 1>{0x55}, cell.now);
    cell.run_for(50ms);
  }
  EXPECT_TRUE(cell.link.to_arm.empty()) << "it must not talk into the noise";
  EXPECT_EQ(cell.events.size(), 1U);
  EXPECT_EQ(cell.failure(), ErrorCode::kUnaskedReply);
  EXPECT_EQ(cell.channel.unexpected(), 200U) << "every byte of it";
}

TEST(BigRobotArmChannel, begun_request_is_never_cut_short) {
  Channel channel(arm());
  std::array<std::uint8_t, 5> out{};
  Instant now{};
  channel.open(now);
  channel.poll(now += 100ms);
  (void)channel.take_output(out);
  channel.receive(byte::encode_reply(Status{{}, {}, {}, Gripper{}, false}), now);
  ASSERT_TRUE(channel.move_to({}, 1s, now));
  EXPECT_EQ(channel.take_output(out), 5U);
  channel.poll(now += 1s);  // nothing came back: doubt
  EXPECT_EQ(channel.state(), Channel::State::kQuiet);
  std::size_t rest = 0;
  channel.poll(now += 1s);
  while (const std::size_t count = channel.take_output(out)) rest += count;
  EXPECT_EQ(rest, 22U - 5U) << "no status before the goto is out";
  channel.poll(now += 1s);
  EXPECT_EQ(channel.take_output(out), 2U);
}

TEST(BigRobotArmChannel, port_that_closes_fails_the_command_under_way) {
  Cell cell;
  ASSERT_TRUE(cell.channel.move_to(cell.q_of(kDocumented), 3s, cell.now));
  cell.run_for(1s);
  cell.channel.close();
  cell.run_for(1s);
  EXPECT_EQ(cell.failure(), ErrorCode::kPortClosed);
  EXPECT_EQ(cell.channel.read_status(cell.now).error().code, ErrorCode::kBusy);
}

TEST(BigRobotArmChannel, any_noise_on_the_line_ends_in_a_driver_that_works) {
  test::for_random_cases(2'000, [](test::Random& random) {
    const auto wire = random.chance(0.5) ? BigRobotArmWire::kByte : BigRobotArmWire::kText;
    Cell cell(arm(wire));
    for (int i = 0; i < 10; ++i) {
      std::array<std::uint8_t, 30> noise{};
      for (auto& byte : noise) byte = static_cast<std::uint8_t>(random.bits() & 0xFF);
      const auto count = static_cast<std::size_t>(random.integer(0, 30));
      (void)cell.channel.move_to(cell.q_of({0, 0, 100 * i, 0, 0}), 2s, cell.now);
      cell.channel.receive(std::span(noise).first(count), cell.now);
      cell.run_for(Duration{random.integer(0, 1'000'000'000)});
    }
    cell.run_for(10s);
    ASSERT_EQ(cell.channel.state(), Channel::State::kIdle);
    cell.events.clear();
    ASSERT_TRUE(cell.channel.move_to(cell.q_of({}), 2s, cell.now));
    cell.run_for(10s);
    ASSERT_NE(cell.last<Channel::Done>(), nullptr);
  });
}

TEST(BigRobotArmChannel, exchange_does_not_allocate) {
  const BigRobotArmDevice device = arm();
  Channel channel(device);
  BigRobotArmFirmware firmware(device, Instant{});
  std::array<std::uint8_t, 128> bytes{};
  int events = 0;
  const test::AllocationCounter allocations;
  Instant now{};
  channel.open(now);
  for (int i = 0; i < 1000; ++i, now += 10ms) {
    firmware.advance(now);
    channel.receive(std::span(bytes).first(firmware.take_output(bytes)), now);
    channel.poll(now);
    if (i == 20) (void)channel.move_to({0.1, 0.2, 0.3, 0.4, 0.5}, 2s, now);
    firmware.receive(std::span(bytes).first(channel.take_output(bytes)), now);
    while (channel.take_event()) ++events;
  }
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_EQ(events, 3);
}

TEST(BigRobotArmMultipliers, joints_arrive_together_and_none_is_faster_than_asked) {
  const BigRobotArmDevice device = arm();
  const BigRobotArmMultipliers base{{200, 100, 100, 100, 100}, {200, 100, 100, 100, 100}};
  const auto result = synchronised_multipliers(device, kDocumented, base);
  ASSERT_TRUE(result);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(
        motion_time(device.joints[i], kDocumented[i], result->speeds[i], result->accelerations[i]),
        2.5625, 0.03 * 2.5625)
        << i;
  }
  EXPECT_EQ(result->speeds[2], 100);
}

/// Arrival of every joint beside the slowest one's, as a part of it, and the values' own limits.
std::array<double, kJoints> arrival_errors(const BigRobotArmDevice& device, const Words& deltas,
                                           const BigRobotArmMultipliers& base,
                                           const BigRobotArmMultipliers& chosen) {
  std::array<double, kJoints> times{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_LE(chosen.speeds[i], base.speeds[i]);
    EXPECT_LE(chosen.accelerations[i], base.accelerations[i]);
    times[i] = motion_time(device.joints[i], deltas[i], chosen.speeds[i], chosen.accelerations[i]);
  }
  EXPECT_TRUE(check_multipliers(device, chosen.speeds));
  EXPECT_TRUE(check_multipliers(device, chosen.accelerations));
  double slowest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    slowest = std::max(
        slowest, motion_time(device.joints[i], deltas[i], base.speeds[i], base.accelerations[i]));
  }
  std::array<double, kJoints> errors{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (deltas[i] != 0) errors[i] = std::abs(times[i] - slowest) / slowest;
  }
  return errors;
}

TEST(MotionShare, goes_as_the_trapezoid_does) {
  const BigRobotArmDevice device = arm();
  const BigRobotArmJoint& joint = device.joints[0];
  for (const double steps : {40.0, -300.0, 6000.0}) {
    const double whole = motion_time(joint, steps, 100, 150);
    const double unit = joint.steps_per_motor_rev / 100;
    double share = 0, speed = 0;
    constexpr int kParts = 10'000;
    for (int k = 0; k < kParts; ++k) {
      const double t = whole * k / kParts;
      EXPECT_NEAR(motion_share(joint, steps, 100, 150, t), share, 1e-3) << steps << " at " << t;
      speed = std::min({150 * unit * t, 100 * unit, 150 * unit * (whole - t)});
      share += speed * whole / kParts / std::abs(steps);
    }
    EXPECT_EQ(motion_share(joint, steps, 100, 150, 0), 0);
    EXPECT_EQ(motion_share(joint, steps, 100, 150, whole), 1);
  }
}

TEST(BigRobotArmMultipliers, ordinary_moves_arrive_within_three_percent) {
  const BigRobotArmDevice device = arm();
  double worst = 0;
  test::for_random_cases(5'000, [&](test::Random& random) {
    Words deltas{};
    BigRobotArmMultipliers base;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double revolutions = random.chance(0.1) ? 0 : random.uniform(0.5, 5);
      deltas[i] = static_cast<std::int32_t>(revolutions * device.joints[i].steps_per_motor_rev);
      base.speeds[i] = static_cast<std::int32_t>(random.integer(100, 300));
      base.accelerations[i] = static_cast<std::int32_t>(random.integer(100, 300));
      // Values that are stepped over would change the slowest time that errors are counted from.
      while (!byte::sendable(base.speeds[i])) ++base.speeds[i];
      while (!byte::sendable(base.accelerations[i])) ++base.accelerations[i];
    }
    const auto result = synchronised_multipliers(device, deltas, base);
    ASSERT_TRUE(result);
    for (const double error : arrival_errors(device, deltas, base, *result)) {
      worst = std::max(worst, error);
    }
  });
  EXPECT_LT(worst, 0.03);
  std::cout << "  worst difference of arrival " << 100 * worst << " %\n";
}

TEST(BigRobotArmMultipliers, no_other_whole_numbers_would_arrive_much_nearer) {
  const BigRobotArmDevice device = arm();
  test::for_random_cases(60, [&](test::Random& random) {
    Words deltas{};
    BigRobotArmMultipliers base;
    for (std::size_t i = 0; i < kJoints; ++i) {
      deltas[i] = static_cast<std::int32_t>(random.integer(-6000, 6000));
      base.speeds[i] = static_cast<std::int32_t>(random.integer(1, 12));
      base.accelerations[i] = static_cast<std::int32_t>(random.integer(1, 12));
    }
    const auto result = synchronised_multipliers(device, deltas, base);
    ASSERT_TRUE(result);
    const auto errors = arrival_errors(device, deltas, base, *result);
    for (std::size_t i = 0; i < kJoints; ++i) {
      double least = errors[i];
      BigRobotArmMultipliers other = *result;
      for (std::int32_t speed = 1; speed <= base.speeds[i]; ++speed) {
        for (std::int32_t ramp = 1; ramp <= base.accelerations[i]; ++ramp) {
          other.speeds[i] = speed;
          other.accelerations[i] = ramp;
          least = std::min(least, arrival_errors(device, deltas, base, other)[i]);
        }
      }
      // The shape of the profile counts for a hundredth: up to 12 times its even value.
      EXPECT_LE(errors[i], least + 0.12);
    }
  });
}

TEST(BigRobotArmMultipliers, base_values_that_cannot_be_sent_are_stepped_over) {
  const BigRobotArmDevice device = arm();
  const auto result =
      synchronised_multipliers(device, {}, {{13, 269, 300, 1, 14}, {13, 13, 269, 12, 1}});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->speeds, (Words{12, 268, 300, 1, 14}));
  EXPECT_EQ(result->accelerations, (Words{12, 12, 268, 12, 1}));
  EXPECT_FALSE(synchronised_multipliers(device, {}, {{0, 1, 1, 1, 1}, {1, 1, 1, 1, 1}}));
  EXPECT_FALSE(synchronised_multipliers(device, {}, {{1, 1, 1, 1, 1}, {1, 1, 1, 1, 301}}));
}

}  // namespace
}  // namespace sinew
