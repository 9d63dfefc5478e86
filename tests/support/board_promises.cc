#include "support/board_promises.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sinew/core/split_mix.h"
#include "sinew/mcu/bytes.h"

namespace sinew::mcu {

using arm_link::Fault;
using arm_link::Kind;
using arm_link::Reference;
using arm_link::Reply;
using arm_link::Request;

bool TestHost::open(std::uint16_t deadline_ms, double braking) {
  Request hello = {};
  hello.kind = Kind::kHello;
  hello.sequence = sequence_;
  hello.deadline_ms = deadline_ms;
  // The limits of power-up.
  const std::uint16_t brakings[] = {6400, 400, 3200, 3200, 3200};
  for (std::size_t i = 0; i < kArmAxes; ++i) {
    hello.brakings[i] = static_cast<std::uint16_t>(braking * brakings[i]);
  }
  if (!tell(hello)) return false;
  session_ = state_->session;
  return session_ != 0 && state_->sequence == sequence_;
}

Request TestHost::next(Kind kind) {
  Request request = {};
  request.kind = kind;
  request.session = session_;
  if (arm_link::is_numbered(kind)) request.sequence = ++sequence_;
  return request;
}

std::optional<Reply> TestHost::read() {
  Request request = {};
  request.kind = Kind::kRead;
  request.session = session_;
  return tell(request);
}

Request TestHost::segment(const std::array<double, kArmAxes>& targets,
                          const std::array<double, kArmAxes>& velocities) {
  Request request = next(Kind::kSegment);
  request.segment.ms = kSegmentMs;
  request.segment.gripper = kGripperStays;
  for (std::size_t i = 0; i < kArmAxes; ++i) {
    request.segment.targets[i] =
        static_cast<std::int32_t>(std::lround(targets[i] * mcu::kUnitsPerStep));
    request.segment.velocities[i] = static_cast<std::int16_t>(std::lround(velocities[i] * 1024));
  }
  return request;
}

bool TestHost::stream(double seconds, const std::function<double(std::size_t, double)>& at,
                      const std::function<double(std::size_t, double)>& speed) {
  const int segments = static_cast<int>(std::lround(seconds * 1000 / kSegmentMs));
  for (int k = 1; k <= segments; ++k) {
    const double t = k * kSegmentMs / 1000.0;
    std::array<double, kArmAxes> targets{};
    std::array<double, kArmAxes> velocities{};
    for (std::size_t i = 0; i < kArmAxes; ++i) {
      targets[i] = at(i, t);
      velocities[i] = k == segments ? 0 : speed(i, t) / 1000;
    }
    const Request request = segment(targets, velocities);
    // A full queue leaves it with the host.
    for (int tries = 0; tries < 100; ++tries) {
      if (!tell(request) || state_->fault != Fault::kNone) return false;
      if (state_->sequence == request.sequence) break;
    }
  }
  for (int tries = 0; tries < 200; ++tries) {
    if (!read()) return false;
    if (!state_->moving) return state_->fault == Fault::kNone;
    board_.run_ms(5);
  }
  return false;
}

double smooth(double way, double seconds, double t) {
  const double s = std::clamp(t / seconds, 0.0, 1.0);
  return way * s * s * s * (10 + s * (-15 + 6 * s));
}
double smooth_speed(double way, double seconds, double t) {
  const double s = std::clamp(t / seconds, 0.0, 1.0);
  return way / seconds * 30 * s * s * (1 - s) * (1 - s);
}

namespace {

constexpr std::array<double, kArmAxes> kWays{-2400, 600, -1800, 800, -1000};

Bytes words(std::uint8_t id, const std::array<std::int32_t, 5>& values) {
  Bytes bytes{id};
  for (const std::int32_t value : values) {
    for (int shift = 0; shift < 32; shift += 8) {
      bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> shift));
    }
  }
  return bytes;
}
Bytes ended(Bytes bytes) {
  bytes.push_back(0x0D);
  return bytes;
}
Bytes done(const Bytes& head, const std::array<std::int32_t, 5>& values) {
  Bytes bytes = head;
  const Bytes data = words(0, values);
  bytes.insert(bytes.end(), data.begin() + 1, data.end());
  const Bytes end{0x0D, 0x0A, 0xC8, 0x0D, 0x0A};
  bytes.insert(bytes.end(), end.begin(), end.end());
  return bytes;
}

void answers_the_documents_bytes(BoardUnderTest& board) {
  const std::array<std::int32_t, 5> speeds{200, 100, 110, 120, 269};
  EXPECT_EQ(board.ask(ended(words(4, speeds))), done({4, 0x0D, 0x0A}, speeds));
  EXPECT_EQ(board.ask(ended(words(5, speeds))), done({5, 0x0D, 0x0A}, speeds));
  EXPECT_EQ(board.ask(Bytes{6, 0, 0x28, 0x0D}),
            (Bytes{6, 0x0D, 0x0A, 0, 0x5A, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A}));
  EXPECT_EQ(board.ask(Bytes{6, 1, 0x28, 0x0D}),
            (Bytes{6, 0x0D, 0x0A, 1, 0x28, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A}));
  EXPECT_EQ(board.ask(Bytes{7, 1, 0x0D}), (Bytes{7, 0x0D, 0x0A, 1, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A}));
  EXPECT_EQ(board.ask(Bytes{7, 0, 0x0D}), (Bytes{7, 0x0D, 0x0A, 0, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A}));
  EXPECT_EQ(board.ask(Bytes{3, 0x0D}), done({3, 0x0D, 0x0A}, {}));
  EXPECT_EQ(board.ask(Bytes{9, 1, 2, 3, 0x0D}), (Bytes{0xC9, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A}));
  EXPECT_EQ(board.ask(Bytes{0x0D}), (Bytes{0xC9, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A}));
  Bytes status{0xCA, 0x0D, 0x0A};
  for (const auto& part : {std::array<std::int32_t, 5>{}, speeds, speeds}) {
    const Bytes data = words(0, part);
    status.insert(status.end(), data.begin() + 1, data.end());
  }
  const Bytes end{1, 0x28, 0, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A};
  status.insert(status.end(), end.begin(), end.end());
  EXPECT_EQ(board.ask(Bytes{8, 0x0D}), status);
}

void goes_where_a_byte_goto_says(BoardUnderTest& board) {
  // 269 and 13 hold a 0D, which cut requests of the maker's firmware.
  const std::array<std::int32_t, 5> targets{-240, 60, 269, 13, -100};
  EXPECT_EQ(board.ask(ended(words(1, targets))), (Bytes{1, 0x0D, 0x0A}));
  board.run_ms(1500);
  EXPECT_EQ(board.take_output(), done({}, targets));
  for (std::size_t i = 0; i < kArmAxes; ++i) EXPECT_EQ(board.steps(i), targets[i]) << i;
  EXPECT_EQ(board.ask(Bytes{2, 0x0D}), (Bytes{2, 0x0D, 0x0A}));
  board.run_ms(1500);
  EXPECT_EQ(board.take_output(), done({}, {}));
  for (std::size_t i = 0; i < kArmAxes; ++i) EXPECT_EQ(board.steps(i), 0) << i;
}

void answers_and_stops_in_a_motion(BoardUnderTest& board) {
  EXPECT_EQ(board.ask(ended(words(1, {-6000, 500, 3000, 0, 0}))), (Bytes{1, 0x0D, 0x0A}));
  board.run_ms(400);
  const Bytes status = board.ask(Bytes{8, 0x0D});
  ASSERT_EQ(status.size(), 71U);
  const auto reported = static_cast<std::int32_t>(get_u32(status.data() + 3));
  EXPECT_LT(reported, -300);
  EXPECT_NEAR(reported, static_cast<double>(board.steps(0)), 60);
  Bytes replies = board.ask(Bytes{ByteReader::kStopId, 0x0D}, 1000);
  const std::int64_t stopped = board.steps(0);
  EXPECT_GT(stopped, -2000);
  board.run_ms(300);
  EXPECT_EQ(board.steps(0), stopped);
  // The goto's reply with the positions where it ended, then that of the stop.
  std::array<std::int32_t, 5> where{};
  for (std::size_t i = 0; i < kArmAxes; ++i) where[i] = static_cast<std::int32_t>(board.steps(i));
  Bytes both = done({}, where);
  const Bytes second = done({ByteReader::kStopId, 0x0D, 0x0A}, where);
  both.insert(both.end(), second.begin(), second.end());
  EXPECT_EQ(replies, both);
  EXPECT_EQ(board.ask(ended(words(1, where)), 200).size(), 28U);
}

void speaks_the_text_of_2026(BoardUnderTest& board) {
  const auto ask = [&](std::string_view line, int ms = 40) {
    const Bytes reply = board.ask(std::string(line) + "\r", ms);
    std::string text(reply.begin(), reply.end());
    if (text.starts_with("Free mem: ")) text.erase(0, text.find('\n') + 1);
    return text;
  };
  EXPECT_EQ(ask("M203 B150 S9999"),
            "Process command: M203 B150 S9999\r\n"
            "BigRobotArm::SPEED: B150 S500 E100 WR100 W100\r\nBigRobotArm::READY\r\n");
  EXPECT_EQ(ask("M0201 B150 S110"),
            "Process command: M0201 B150 S110\r\n"
            "BigRobotArm::ACCELERATION: B150 S110 E100 WR100 W100\r\nBigRobotArm::READY\r\n");
  EXPECT_EQ(ask("nonsense"), "BigRobotArm::INVALID-COMMAND\r\nBigRobotArm::READY\r\n");
  EXPECT_EQ(ask("END"),
            "Process command: END\r\nBigRobotArm::INVALID-COMMAND\r\nBigRobotArm::READY\r\n");
  EXPECT_EQ(ask("G1 E1 P60"),
            "Process command: G1 E1 P60\r\nBigRobotArm::GRIPPER: E1 P60\r\n"
            "BigRobotArm::READY\r\n");
  board.run_ms(45);
  EXPECT_NEAR(board.gripper_us(), 545 + 60 * 1856 / 180, 2);
  EXPECT_EQ(ask("G0 B100 S20 E300 WR40 W30"), "Process command: G0 B100 S20 E300 WR40 W30\r\n");
  EXPECT_TRUE(ask("M503").ends_with("SYNC-MOTORS: 0\r\nBigRobotArm::READY\r\n"));
  board.run_ms(900);
  const Bytes arrived = board.take_output();
  EXPECT_EQ(std::string(arrived.begin(), arrived.end()),
            "BigRobotArm::MOVING-TO\r\n"
            "BigRobotArm::POSITION: B100 S20 E300 WR40 W30\r\nBigRobotArm::READY\r\n");
  EXPECT_EQ(board.steps(2), 300);
  // The document's sequence, with its numbers made small.
  for (const char* line : {"BEGIN I2", "G0 B10 S20 E30 WR40 W30", "G0 B0 S5 E50 WR15 W0"}) {
    EXPECT_EQ(ask(line), "Process command: " + std::string(line) + "\r\nBigRobotArm::READY\r\n");
  }
  const std::string end = ask("END", 2500);
  EXPECT_NE(end.find("POSITION: B0 S5 E50 WR15 W0\r\n"), std::string::npos) << end;
  for (std::size_t i = 0; i < kArmAxes; ++i) {
    EXPECT_EQ(board.steps(i), (std::array{0, 5, 50, 15, 0})[i]) << i;
  }
}

void queues_and_stops_by_text(BoardUnderTest& board) {
  const auto text = [&](std::string_view line, int ms = 40) {
    const Bytes reply = board.ask(std::string(line) + "\r", ms);
    return std::string(reply.begin(), reply.end());
  };
  for (int i = 0; i < 5; ++i) {
    EXPECT_NE(text("Q0 B" + std::to_string(300 * (i + 1))).find("QUEUED-TO"), std::string::npos);
  }
  EXPECT_NE(text("Q0 B9").find("QUEUE-FULL"), std::string::npos);
  EXPECT_NE(text("QCLEAR").find("QUEUE-CLEARED"), std::string::npos);
  EXPECT_NE(text("QFLUSH", 900).find("QUEUE-DRAINED"), std::string::npos);
  EXPECT_EQ(board.steps(0), 300);
  EXPECT_EQ(text("G0 B6000").find("READY"), std::string::npos);
  const std::string stopped = text("M410", 1200);
  EXPECT_NE(stopped.find("MOVING-TO"), std::string::npos) << stopped;
  EXPECT_NE(stopped.find("Process command: M410"), std::string::npos) << stopped;
  EXPECT_LT(board.steps(0), 2500);
}

void follows_a_stream(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open());
  std::array<std::vector<std::pair<std::int64_t, double>>, kArmAxes> made;
  board.on_step = [&](const BoardUnderTest::Step& step) {
    made[step.axis].emplace_back(step.position, step.at);
  };
  const double seconds = 1.5;
  ASSERT_TRUE(host.stream(
      seconds, [&](std::size_t i, double t) { return smooth(kWays[i], seconds, t); },
      [&](std::size_t i, double t) { return smooth_speed(kWays[i], seconds, t); }));
  board.on_step = {};
  // When each step was due: as the plan passes the middle between two positions.
  double start = 0;
  double worst = 0;
  for (const bool measures : {false, true}) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < kArmAxes; ++i) {
      EXPECT_EQ(board.steps(i), std::lround(kWays[i])) << i;
      EXPECT_EQ(made[i].size(), static_cast<std::size_t>(std::abs(kWays[i]))) << i;
      for (const auto& [position, at] : made[i]) {
        const double middle = static_cast<double>(position) - std::copysign(0.5, kWays[i]);
        double low = 0;
        double high = seconds;
        for (int n = 0; n < 50; ++n) {
          const double t = (low + high) / 2;
          (std::abs(smooth(kWays[i], seconds, t)) < std::abs(middle) ? low : high) = t;
        }
        // Where it is slow, a step is late by little way and much time: as the way.
        const double speed = std::abs(smooth_speed(kWays[i], seconds, low));
        if (speed < 200) continue;
        if (measures) worst = std::max(worst, std::abs(at - low - start));
        sum += at - low;
        ++count;
      }
    }
    start = sum / static_cast<double>(count);
  }
  std::printf("  worst step: %.0f us beside its time\n", worst * 1e6);
  EXPECT_LT(worst, 400e-6);
}

void carries_a_gripper_along(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  Request one = host.segment({10, 0, 0, 0, 0}, {});
  one.segment.ms = 50;
  one.segment.begin = true;
  one.segment.gripper = 120 * mcu::kServoUnitsPerDegree;
  ASSERT_TRUE(host.tell(one));
  board.run_ms(80);
  EXPECT_NEAR(board.gripper_us(), 545 + 120 * 1856 / 180, 2);
  Request slow = host.next(Kind::kGripper);
  slow.gripper_on = true;
  slow.gripper = 30 * mcu::kServoUnitsPerDegree;
  slow.gripper_ms = 400;
  ASSERT_TRUE(host.tell(slow));
  board.run_ms(100);
  const auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_TRUE(state->gripper_moves);
  EXPECT_GT(state->gripper, 60 * mcu::kServoUnitsPerDegree);
  EXPECT_LT(state->gripper, 115 * mcu::kServoUnitsPerDegree);
}

/// In motion at 1000 steps/s of the base; false where it never was.
bool is_moving(BoardUnderTest& board, TestHost& host) {
  for (int k = 1; k <= 20; ++k) {
    const double t = k * TestHost::kSegmentMs / 1000.0;
    const double speed = std::min(1.0, t / 0.2);
    const double way = t < 0.2 ? 500 * t * t / 0.2 : 100 + 1000 * (t - 0.2);
    const double due = board.seconds() + TestHost::kSegmentMs / 1000.0;
    if (!host.tell(host.segment({way, 0, 0, 0, 0}, {speed, 0, 0, 0, 0}))) return false;
    while (board.seconds() < due) board.run_ms(1);
  }
  return board.steps(0) > 100;
}

void brakes_when_its_host_is_silent(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(50));
  ASSERT_TRUE(is_moving(board, host));
  // As much ahead as the deadline and more.
  for (int k = 1; k <= 10; ++k) {
    ASSERT_TRUE(host.tell(host.segment({300 + 20.0 * k, 0, 0, 0, 0}, {1, 0, 0, 0, 0})));
  }
  double last = 0;
  const double silent = board.seconds();
  board.on_step = [&](const BoardUnderTest::Step& step) { last = step.at; };
  board.run_ms(800);
  board.on_step = {};
  // The deadline, and 1000 steps/s at 6400 steps/s^2.
  EXPECT_LT(last - silent, 0.05 + 0.157 + 0.01);
  const auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kHostSilent);
  EXPECT_EQ(state->session, 0);
  EXPECT_FALSE(state->moving);
  EXPECT_EQ((state->positions[0] + 128) >> 8, board.steps(0));
  // It latches: a new session moves nothing before the release.
  ASSERT_TRUE(host.open(500));
  const std::int64_t before = board.steps(0);
  ASSERT_TRUE(host.tell(host.segment({static_cast<double>(before + 50), 0, 0, 0, 0}, {})));
  board.run_ms(100);
  EXPECT_EQ(board.steps(0), before);
  const auto released = host.tell(Kind::kRelease);
  ASSERT_TRUE(released);
  EXPECT_EQ(released->fault, Fault::kNone);
  ASSERT_TRUE(host.tell(host.segment({static_cast<double>(before + 5), 0, 0, 0, 0}, {})));
  board.run_ms(100);
  EXPECT_EQ(board.steps(0), before + 5);
}

void brakes_where_the_stream_ends_in_motion(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  ASSERT_TRUE(is_moving(board, host));
  board.run_ms(400);
  const auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kUnderrun);
  EXPECT_FALSE(state->moving);
  EXPECT_EQ((state->positions[0] + 128) >> 8, board.steps(0));
}

void stops_when_it_is_asked_to(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  ASSERT_TRUE(is_moving(board, host));
  double last = 0;
  const double asked = board.seconds();
  board.on_step = [&](const BoardUnderTest::Step& step) { last = step.at; };
  const auto state = host.tell(Kind::kStop);
  ASSERT_TRUE(state);
  EXPECT_TRUE(state->stopping);
  board.run_ms(400);
  board.on_step = {};
  EXPECT_LT(last - asked, 0.002 + 1000.0 / 6400 + 0.005);
  EXPECT_GT(last - asked, 0.1);
  const auto after = host.read();
  ASSERT_TRUE(after);
  EXPECT_EQ(after->fault, Fault::kStopAsked);
  EXPECT_EQ((after->positions[0] + 128) >> 8, board.steps(0));
}

void its_stop_line_ends_pulses_within_a_millisecond(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  ASSERT_TRUE(is_moving(board, host));
  double last = 0;
  board.on_step = [&](const BoardUnderTest::Step& step) { last = step.at; };
  const double pressed = board.seconds();
  board.set_stop_line(true);
  board.run_ms(100);
  board.on_step = {};
  EXPECT_LT(last - pressed, 1.1e-3);
  std::printf("  stop line to last step: %.2f ms\n", std::max(0.0, last - pressed) * 1e3);
  auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kStopLine);
  EXPECT_TRUE(state->stop_line);
  EXPECT_EQ(state->positions[0], board.steps(0) * mcu::kUnitsPerStep);
  state = host.tell(Kind::kRelease);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kStopLine);
  board.set_stop_line(false);
  board.run_ms(3);
  state = host.tell(Kind::kRelease);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kNone);
}

void keeps_positions_over_a_restart(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open());
  auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->reference, Reference::kPowerUp);
  ASSERT_TRUE(host.stream(
      0.5, [](std::size_t i, double t) { return smooth(kWays[i] / 10, 0.5, t); },
      [](std::size_t i, double t) { return smooth_speed(kWays[i] / 10, 0.5, t); }));
  board.restart();
  board.run_ms(600);
  TestHost second(board);
  ASSERT_TRUE(second.open());
  state = second.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->reference, Reference::kKept);
  EXPECT_EQ(state->fault, Fault::kNone);
  for (std::size_t i = 0; i < kArmAxes; ++i) {
    EXPECT_EQ(state->positions[i], board.steps(i) * mcu::kUnitsPerStep) << i;
  }
  board.power_cycle();
  board.run_ms(600);
  TestHost third(board);
  ASSERT_TRUE(third.open());
  state = third.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->reference, Reference::kPowerUp);
  EXPECT_EQ(state->positions[0], 0);
}

void says_so_when_it_restarted_in_motion(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  ASSERT_TRUE(is_moving(board, host));
  board.restart();
  board.run_ms(600);
  TestHost second(board);
  ASSERT_TRUE(second.open());
  auto state = second.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->reference, Reference::kKeptMoving);
  EXPECT_EQ(state->fault, Fault::kRestart);
  EXPECT_NEAR(state->positions[0] / double{mcu::kUnitsPerStep}, static_cast<double>(board.steps(0)),
              8);
  board.restart();
  board.run_ms(600);
  TestHost third(board);
  ASSERT_TRUE(third.open());
  state = third.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->reference, Reference::kKeptMoving);
  Request said = third.next(Kind::kPositions);
  said.positions[0] = 5 * mcu::kUnitsPerStep;
  state = third.tell(said);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->reference, Reference::kSaid);
  EXPECT_EQ(state->positions[0], 5 * mcu::kUnitsPerStep);
}

void carries_out_each_request_once_and_in_order(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  const Request first = host.segment({5, 0, 0, 0, 0}, {});
  const Request second = host.segment({9, 0, 0, 0, 0}, {});
  auto state = host.tell(second);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->queued_ms, 0);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(host.tell(first));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(state = host.tell(second));
  EXPECT_EQ(state->sequence, second.sequence);
  board.run_ms(120);
  EXPECT_EQ(board.steps(0), 9);
  // Another host: the first one's session is over.
  TestHost other(board);
  ASSERT_TRUE(other.open());
  state = host.tell(host.segment({20, 0, 0, 0, 0}, {}));
  ASSERT_TRUE(state);
  board.run_ms(120);
  EXPECT_EQ(board.steps(0), 9);
}

void refuses_what_no_motor_follows(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  // 250 steps in 20 ms, of at most 240.
  auto state = host.tell(host.segment({250, 0, 0, 0, 0}, {}));
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kRefused);
  board.run_ms(60);
  EXPECT_EQ(board.steps(0), 0);
}

void survives_noise(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  SplitMix64 random(11);
  for (int round = 0; round < 20; ++round) {
    Bytes noise(50);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random.bits());
    board.ask(noise, 6);
    ASSERT_TRUE(host.read()) << round;
  }
  for (std::size_t i = 0; i < kArmAxes; ++i) EXPECT_EQ(board.steps(i), 0) << i;
}

void half_a_request_of_a_dead_host_moves_nothing(BoardUnderTest& board) {
  Bytes half = words(1, {100, 100, 100, 100, 100});
  half.resize(15);
  board.ask(half, 150);
  EXPECT_EQ(board.ask(Bytes{8, 0x0D}).size(), 71U);
  board.ask(half, 150);
  TestHost host(board);
  ASSERT_TRUE(host.open());
  ASSERT_TRUE(host.read());
  board.run_ms(200);
  for (std::size_t i = 0; i < kArmAxes; ++i) EXPECT_EQ(board.steps(i), 0) << i;
}

void two_byte_axes_arrive_together(BoardUnderTest& board) {
  board.ask(Bytes{7, 1, 0x0D});
  std::array<double, kArmAxes> last{};
  board.on_step = [&](const BoardUnderTest::Step& step) { last[step.axis] = step.at; };
  board.ask(ended(words(1, {400, 50, -300, 200, 100})), 1500);
  board.on_step = {};
  for (std::size_t i = 0; i < kArmAxes; ++i) EXPECT_NEAR(last[i], last[0], 0.12) << i;
  EXPECT_EQ(board.steps(2), -300);
}

void a_frame_that_comes_into_an_old_motion_brakes_it(BoardUnderTest& board) {
  board.ask(ended(words(1, {6000, 0, 0, 0, 0})), 600);
  const double moving = static_cast<double>(board.steps(0));
  EXPECT_GT(moving, 300);
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  board.run_ms(700);
  const std::int64_t stopped = board.steps(0);
  EXPECT_LT(static_cast<double>(stopped), moving + 1500);
  board.run_ms(300);
  EXPECT_EQ(board.steps(0), stopped);
  const auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kStopAsked);
  EXPECT_EQ((state->positions[0] + 128) >> 8, stopped);
}

void no_braking_takes_for_ever(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500, 0));
  ASSERT_TRUE(is_moving(board, host));
  ASSERT_TRUE(host.tell(Kind::kStop));
  board.run_ms(5100);
  const auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_FALSE(state->moving);
}

/// Each of them begins with 02, once its first 00 is lost.
void a_frame_without_its_beginning_moves_nothing(BoardUnderTest& board) {
  board.ask(ended(words(1, {50, 0, 0, 0, 0})), 900);
  ASSERT_EQ(board.steps(0), 50);
  for (const Kind kind : {Kind::kRead, Kind::kIdentity, Kind::kHello}) {
    Request request = {};
    request.kind = kind;
    request.deadline_ms = 100;
    std::uint8_t plain[arm_link::kRequestMax];
    std::uint8_t stuffed[kStuffedMax];
    const std::uint8_t size = stuff(plain, arm_link::encode(request, plain), stuffed);
    for (std::uint8_t cut = 1; cut < size; ++cut) {
      board.ask(std::span(stuffed + cut, static_cast<std::size_t>(size - cut - 1)), 3);
    }
  }
  board.run_ms(300);
  EXPECT_EQ(board.steps(0), 50);
  // Without its 0D it is none, and with another byte there neither.
  board.ask(Bytes{0x0D}, 20);
  board.ask(Bytes{2}, 150);
  EXPECT_EQ(board.ask(Bytes{2, 7, 0x0D}), (Bytes{0xC9, 0x0D, 0x0A, 0xC8, 0x0D, 0x0A}));
  board.run_ms(200);
  EXPECT_EQ(board.steps(0), 50);
}

void a_stop_acts_whatever_waits(BoardUnderTest& board) {
  board.ask(ended(words(1, {6000, 0, 0, 0, 0})), 400);
  for (int i = 0; i < 4; ++i) board.ask(Bytes{6, 1, 40, 0x0D}, 5);
  const Bytes stopped = board.ask(Bytes{ByteReader::kStopId, 0x0D}, 1000);
  EXPECT_LT(board.steps(0), 2000);
  EXPECT_GE(stopped.size(), 2U * 6 + 25 + 28);
  EXPECT_EQ(board.ask(Bytes{8, 0x0D}).size(), 71U);
}

void what_waits_is_forgotten_with_its_session(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  Request wait = host.segment({100, 0, 0, 0, 0}, {});
  board.set_stop_line(true);
  ASSERT_TRUE(host.tell(wait));
  board.set_stop_line(false);
  board.run_ms(100);
  EXPECT_EQ(board.steps(0), 0);
  // Another host, while a segment waits for more.
  ASSERT_TRUE(host.tell(Kind::kRelease));
  Request one = host.segment({100, 0, 0, 0, 0}, {});
  ASSERT_TRUE(host.tell(one));
  TestHost other(board);
  ASSERT_TRUE(other.open(20));
  board.run_ms(150);
  EXPECT_LE(std::abs(board.steps(0)), 100);
  const auto state = other.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->queued_ms, 0);
  EXPECT_EQ((state->positions[0] + 128) >> 8, board.steps(0));
}

void positions_are_not_set_while_a_segment_waits(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  ASSERT_TRUE(host.tell(host.segment({100, 0, 0, 0, 0}, {})));
  Request said = host.next(Kind::kPositions);
  said.positions[0] = 1'000'000 * mcu::kUnitsPerStep;
  ASSERT_TRUE(host.tell(said));
  board.run_ms(200);
  auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(board.steps(0), 100);
  EXPECT_EQ(state->positions[0], 100 * mcu::kUnitsPerStep);
  said = host.next(Kind::kPositions);
  said.positions[1] = INT32_MAX;
  ASSERT_TRUE(host.tell(said));
  state = host.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kRefused);
  EXPECT_EQ(state->positions[1], 0);
}

void noise_as_the_port_opens_decides_no_wire(BoardUnderTest& board) {
  board.ask(Bytes{0xFF, 0x0D}, 20);
  board.ask("xyz\r");
  const Bytes reply = board.ask("M503\r", 60);
  const std::string text(reply.begin(), reply.end());
  EXPECT_NE(text.find("SYNC-MOTORS"), std::string::npos) << text;
}

void a_sequence_of_nothing_and_the_stop_line_end(BoardUnderTest& board) {
  for (const char* line : {"BEGIN I127\r", "G92\r", "M203 B100\r", "G0 B9999999\r"})
    board.ask(line);
  const Bytes end = board.ask("END\r", 800);
  const std::string text(end.begin(), end.end());
  EXPECT_NE(text.find("SYNC-MOTORS"), std::string::npos) << text;
  for (const char* line : {"BEGIN I127\r", "G0 B500\r", "G0 B0\r", "END\r"}) board.ask(line);
  board.run_ms(200);
  board.set_stop_line(true);
  board.run_ms(300);
  const std::int64_t stopped = board.steps(0);
  board.set_stop_line(false);
  board.run_ms(500);
  EXPECT_EQ(board.steps(0), stopped);
}

void a_flood_of_bytes_leaves_it_alive(BoardUnderTest& board) {
  TestHost host(board);
  ASSERT_TRUE(host.open(500));
  for (int i = 0; i < 40; ++i) board.ask(Bytes(250, 0x55), 10);
  board.run_ms(60);
  const auto state = host.read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->fault, Fault::kNone);
}

}  // namespace

std::vector<BoardPromise> board_promises() {
  return {
      {"answers_the_documents_bytes", answers_the_documents_bytes},
      {"goes_where_a_byte_goto_says", goes_where_a_byte_goto_says},
      {"answers_and_stops_in_a_motion", answers_and_stops_in_a_motion},
      {"speaks_the_text_of_2026", speaks_the_text_of_2026},
      {"queues_and_stops_by_text", queues_and_stops_by_text},
      {"two_byte_axes_arrive_together", two_byte_axes_arrive_together},
      {"half_a_request_of_a_dead_host_moves_nothing", half_a_request_of_a_dead_host_moves_nothing},
      {"follows_a_stream", follows_a_stream},
      {"carries_a_gripper_along", carries_a_gripper_along},
      {"brakes_when_its_host_is_silent", brakes_when_its_host_is_silent},
      {"brakes_where_the_stream_ends_in_motion", brakes_where_the_stream_ends_in_motion},
      {"stops_when_it_is_asked_to", stops_when_it_is_asked_to},
      {"its_stop_line_ends_pulses_within_a_millisecond",
       its_stop_line_ends_pulses_within_a_millisecond},
      {"keeps_positions_over_a_restart", keeps_positions_over_a_restart},
      {"says_so_when_it_restarted_in_motion", says_so_when_it_restarted_in_motion},
      {"carries_out_each_request_once_and_in_order", carries_out_each_request_once_and_in_order},
      {"refuses_what_no_motor_follows", refuses_what_no_motor_follows},
      {"survives_noise", survives_noise},
      {"a_frame_that_comes_into_an_old_motion_brakes_it",
       a_frame_that_comes_into_an_old_motion_brakes_it},
      {"no_braking_takes_for_ever", no_braking_takes_for_ever},
      {"a_frame_without_its_beginning_moves_nothing", a_frame_without_its_beginning_moves_nothing},
      {"a_stop_acts_whatever_waits", a_stop_acts_whatever_waits},
      {"what_waits_is_forgotten_with_its_session", what_waits_is_forgotten_with_its_session},
      {"positions_are_not_set_while_a_segment_waits", positions_are_not_set_while_a_segment_waits},
      {"noise_as_the_port_opens_decides_no_wire", noise_as_the_port_opens_decides_no_wire},
      {"a_sequence_of_nothing_and_the_stop_line_end", a_sequence_of_nothing_and_the_stop_line_end},
      {"a_flood_of_bytes_leaves_it_alive", a_flood_of_bytes_leaves_it_alive}};
}

}  // namespace sinew::mcu
