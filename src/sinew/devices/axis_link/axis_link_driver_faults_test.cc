#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/devices/axis_link/axis_link_test_cell.h"
#include "sinew/wire/crc32c.h"
#include "support/property.h"

// What the line and the axes can do to AxisLinkDriver, and what must hold then.

namespace sinew {
namespace {

using namespace std::chrono_literals;
using Kind = DriverEvent::Kind;
using test::LinkCell;
using test::LinkFault;

void check_always(const LinkCell& cell) {
  cell.expect_truth_inside();
}

TEST(AxisLinkFaults, no_flipped_bit_of_any_frame_in_motion_moves_anything_wrong) {
  LinkCell cell(2);
  cell.open_at(0);
  int number = 0;
  int bits = 0;
  cell.disturb = [&](const spi::Transfer&) {
    LinkFault fault;
    // Every third frame; requests first, then answers.
    if (++number % 3 != 0 || bits >= 256) return fault;
    (bits < 128 ? fault.mosi_bit : fault.miso_bit) = bits % 128;
    ++bits;
    return fault;
  };
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  ASSERT_TRUE(cell.run_until(
      [&] {
        check_always(cell);
        return cell.count(Kind::kDone) > 0;
      },
      2s));
  EXPECT_EQ(bits, 256);
  EXPECT_EQ(cell.events.size(), 1U);
  EXPECT_EQ(cell.nodes[0]->bad_frames() + cell.nodes[1]->bad_frames(), 128U)
      << "no request with a flipped bit was taken";
  // A request that was hit leaves a good answer to the one before it, which is late and no more.
  EXPECT_EQ(cell.driver->health().unexpected, 128U);
  cell.expect_only_sent_targets();
  EXPECT_NEAR(cell.axes[0]->q(), from_deg(60), 1e-7);
}

TEST(AxisLinkFaults, no_flipped_bit_while_opening_or_clearing_does_more_than_cost_a_frame) {
  for (int frame = 0; frame < 8; ++frame) {
    for (int bit = 0; bit < 256; ++bit) {
      LinkCell cell(1);
      cell.axes[0]->place(0.25);
      cell.axes[0]->told().fault = AxisFault::kStalled;
      int number = 0;
      cell.disturb = [&](const spi::Transfer&) {
        LinkFault fault;
        if (number++ == frame) (bit < 128 ? fault.mosi_bit : fault.miso_bit) = bit % 128;
        return fault;
      };
      cell.driver->open(cell.now);
      cell.run_for(15ms);
      ASSERT_EQ(cell.failure(), (Error{ErrorCode::kStalled, 0})) << frame << " " << bit;
      number = 0;
      ASSERT_TRUE(cell.driver->clear_fault(cell.now));
      cell.run_for(20ms);
      ASSERT_EQ(cell.driver->state(), DriverState::kReady) << frame << " " << bit;
      ASSERT_EQ(cell.axes[0]->clears, 1) << "exactly once, " << frame << " " << bit;
      ASSERT_EQ(cell.axes[0]->releases, 1);
      ASSERT_NEAR(cell.driver->positions()[0].q, 0.25, 1e-7);
    }
  }
}

TEST(AxisLinkFaults, a_stop_to_all_with_any_bit_flipped_still_stops_all) {
  for (int bit = 0; bit < 128; ++bit) {
    LinkCell cell(3);
    cell.keep_record = false;
    cell.open_at(0);
    ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
    cell.run_for(100ms);
    cell.disturb = [&](const spi::Transfer& transfer) {
      LinkFault fault;
      if (transfer.select == 7) fault.mosi_bit = bit;
      return fault;
    };
    cell.driver->stop(cell.now);
    const Instant asked = cell.now;
    ASSERT_TRUE(cell.run_until([&] { return cell.axes[0]->stops + cell.axes[1]->stops > 1; }, 1s));
    ASSERT_LE(cell.now - asked, 2ms) << "the frames to each axis follow at once";
    ASSERT_TRUE(cell.run_to_event(Kind::kStopped, 1s));
    for (const auto& axis : cell.axes) ASSERT_FALSE(axis->status().moving);
  }
}

// A cable that was unplugged at rest left the driver ready and wanting nothing: a program waited
// for ever.
TEST(AxisLinkFaults, a_cable_unplugged_at_rest_is_a_fault_and_no_endless_wait) {
  LinkCell cell(3);
  cell.open_at(0);
  cell.disturb = [](const spi::Transfer&) {
    LinkFault fault;
    fault.lost = true;
    return fault;
  };
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 1s));
  EXPECT_EQ(cell.driver->state(), DriverState::kFault);
  ASSERT_TRUE(cell.driver->fault());
  cell.disturb = {};
  cell.run_for(1s);
  EXPECT_EQ(cell.driver->state(), DriverState::kFault) << "nobody has acknowledged it";
  const auto refused = cell.driver->move(cell.move_to(from_deg(10), 1s), cell.now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, cell.driver->fault()->code);
  cell.events.clear();
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 1s));
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  EXPECT_TRUE(cell.driver->wants_move(cell.now));
}

TEST(AxisLinkFaults, frames_that_arrive_twice_or_late_move_nothing_twice) {
  LinkCell cell(2);
  cell.open_at(0);
  cell.disturb = [&](const spi::Transfer&) {
    LinkFault fault;
    fault.twice = fault.old_request = true;
    return fault;
  };
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 2s));
  EXPECT_TRUE(std::ranges::is_sorted(cell.axes[0]->targets)) << "an old target is never taken up";
  EXPECT_NEAR(cell.axes[0]->q(), from_deg(60), 1e-7);
  cell.events.clear();
  ASSERT_TRUE(cell.driver->home(cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 60s));
  EXPECT_EQ(cell.axes[0]->homings, 1);
  EXPECT_EQ(cell.axes[1]->homings, 1);
}

TEST(AxisLinkFaults, an_old_answer_is_never_taken_for_a_position) {
  LinkCell cell(1);
  cell.open_at(0);
  bool stale = false;
  cell.disturb = [&](const spi::Transfer&) {
    LinkFault fault;
    fault.old_reply = stale;
    return fault;
  };
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(500ms);
  stale = true;  // the same answer with its good checksum, for ever
  const double seen = cell.driver->positions()[0].q;
  // For 8 ms it may be a board whose loop is slow; the claim grows meanwhile.
  for (int i = 0; i < 6; ++i) {
    cell.run_for(1ms);
    EXPECT_EQ(cell.driver->positions()[0].q, seen);
    EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kMeasured);
    cell.expect_truth_inside();
  }
  cell.run_for(5ms);
  EXPECT_EQ(cell.driver->positions()[0].q, seen);
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kUncertain);
  cell.expect_truth_inside();
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 20ms));
  EXPECT_EQ(cell.failure()->code, ErrorCode::kUnexpectedReply);
  for (int i = 0; i < 300; ++i) {
    cell.run_for(3ms);
    cell.expect_truth_inside();
  }
  // Its deadline and 0.7 s in which it may have braked are over.
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kLost);
}

/// A board with a loop of 4 ms that computes for most of it: it takes frames only then.
TEST(AxisLinkFaults, a_board_whose_answers_are_late_is_served_like_any_other) {
  LinkCell cell(1);
  cell.open_at(0);
  int frame = 0;
  cell.disturb = [&](const spi::Transfer&) {
    LinkFault fault;
    // Three answers of four are older ones.
    fault.old_reply = frame++ % 4 != 0;
    return fault;
  };
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  ASSERT_TRUE(cell.run_until(
      [&] {
        cell.expect_truth_inside();
        EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kMeasured);
        return cell.count(Kind::kDone) > 0;
      },
      2s));
  EXPECT_EQ(cell.driver->health().unexpected, 0U);
  EXPECT_NEAR(cell.axes[0]->q(), from_deg(60), 1e-7);
}

/// Answers that are always so many frames behind: each is as old as the frame that it names.
TEST(AxisLinkFaults, an_answer_of_long_ago_is_never_fresh) {
  for (const std::size_t behind : {1U, 7U, 30U, 31U, 32U, 33U, 40U}) {
    SCOPED_TRACE(behind);
    LinkCell cell(1);
    cell.open_at(0);
    cell.late_by = behind;
    ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
    for (int i = 0; i < 400; ++i) {
      cell.run_for(1ms);
      cell.expect_truth_inside();
    }
  }
}

TEST(AxisLinkFaults, a_failed_frame_makes_a_claim_wider) {
  LinkCell cell(1);
  cell.open_at(0);
  bool damaged = false;
  cell.disturb = [&](const spi::Transfer&) {
    LinkFault fault;
    if (damaged) fault.miso_bit = 7;
    return fault;
  };
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(500ms);
  const auto width = [&] {
    const JointPosition claim = cell.driver->positions()[0];
    return claim.upper - claim.lower;
  };
  const double before = width();
  damaged = true;
  cell.run_for(1ms);
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kUncertain);
  EXPECT_GT(width(), before);
}

TEST(AxisLinkFaults, a_failed_frame_does_not_keep_a_motion_from_its_begin) {
  LinkCell cell(2);
  cell.open_at(0);
  cell.run_for(20ms);
  bool damaged = true;
  cell.disturb = [&](const spi::Transfer&) {
    LinkFault fault;
    if (damaged) fault.miso_bit = 7;
    return fault;
  };
  cell.run_for(2ms);
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kUncertain);
  EXPECT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  damaged = false;
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 2s));
}

TEST(AxisLinkFaults, a_cut_frame_changes_nothing_at_any_length) {
  LinkCell cell(1);
  cell.open_at(0);
  std::size_t number = 0;
  cell.disturb = [&](const spi::Transfer&) {
    LinkFault fault;
    if (++number % 3 == 0) fault.bytes = number / 3 % 16;
    return fault;
  };
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  ASSERT_TRUE(cell.run_to_event(Kind::kDone, 2s));
  cell.expect_only_sent_targets();
}

TEST(AxisLinkFaults, an_axis_that_restarts_in_motion_is_noticed_and_all_stop) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(300ms);
  cell.reboot(3);
  const double there = cell.axes[3]->q();
  const Instant then = cell.now;
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 1s));
  EXPECT_LE(cell.now - then, 10ms);
  EXPECT_EQ(cell.failure()->code, ErrorCode::kPositionUnknown);
  EXPECT_EQ(cell.failure()->index, 3);
  EXPECT_EQ(cell.driver->positions()[3].quality, PositionQuality::kLost);
  cell.run_for(2s);
  for (const auto& axis : cell.axes) EXPECT_FALSE(axis->status().moving);
  EXPECT_EQ(cell.axes[3]->q(), there) << "what follows is of a session that it does not know";
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  cell.run_for(50ms);
  EXPECT_EQ(cell.driver->move(cell.move_to(0, 3s), cell.now).error(),
            (Error{ErrorCode::kPositionUnknown, 3}))
      << "a session is no position: it must be homed";
}

TEST(AxisLinkFaults, an_axis_that_restarts_at_rest_is_a_notice_and_the_others_go_on) {
  LinkCell cell;
  cell.open_at(0);
  cell.reboot(1);
  cell.run_for(20ms);
  EXPECT_EQ(cell.count(Kind::kNotice), 1U);
  EXPECT_EQ(cell.driver->axis_fault(1)->code, ErrorCode::kPositionUnknown);
  JointMove move = cell.move_to(from_deg(10), 1s);
  move.q[1] = 0;
  ASSERT_TRUE(cell.driver->move(move, cell.now));
  EXPECT_TRUE(cell.run_to_event(Kind::kDone, 2s));
}

TEST(AxisLinkFaults, another_model_or_version_is_out_before_anything_moves) {
  LinkCell cell(2);
  Joint other = cell.joints[1];
  other.upper = from_deg(95);
  cell.nodes[1] = std::make_unique<AxisLinkNode>(*cell.axes[1], axis_link_node_settings(other, 1));
  cell.axes[0]->place(0);
  cell.axes[1]->place(0);
  cell.driver->open(cell.now);
  cell.run_for(20ms);
  EXPECT_EQ(cell.driver->axis_fault(1), (Error{ErrorCode::kModelMismatch, 1}));
  EXPECT_EQ(cell.driver->move(cell.move_to(from_deg(1), 1s), cell.now).error().code,
            ErrorCode::kModelMismatch);
  EXPECT_TRUE(cell.axes[1]->targets.empty());
  EXPECT_EQ(cell.nodes[1]->session(), 0);

  LinkCell newer(1);
  axis_link::Frame frame = axis_link::encode(axis_link::Reply{.body = axis_link::Identity{}});
  frame[0] = 2 << 5;
  const std::uint32_t crc = crc32c(std::span(frame).first<12>());
  for (unsigned k = 0; k < 4; ++k) frame[12 + k] = static_cast<std::uint8_t>(crc >> (8 * k));
  newer.driver->open(newer.now);
  for (int i = 0; i < 2; ++i) {
    newer.now += 1ms;
    ASSERT_TRUE(newer.driver->take_transfer(newer.now));
    newer.driver->exchanged(frame, newer.now);
  }
  EXPECT_EQ(newer.driver->axis_fault(0), (Error{ErrorCode::kVersionMismatch, 0, 2, 1}));
  EXPECT_EQ(newer.driver->state(), DriverState::kFault);
}

TEST(AxisLinkFaults, swapped_boards_are_found_before_anything_moves) {
  LinkCell cell(2);
  std::swap(cell.nodes[0], cell.nodes[1]);
  cell.axes[0]->place(0);
  cell.axes[1]->place(0);
  cell.driver->open(cell.now);
  cell.run_for(2s);
  EXPECT_EQ(cell.failure()->code, ErrorCode::kUnexpectedReply);
  EXPECT_EQ(cell.driver->state(), DriverState::kFault);
  EXPECT_FALSE(cell.driver->move(cell.move_to(from_deg(1), 1s), cell.now));
}

TEST(AxisLinkFaults, nothing_is_homed_where_a_board_is_silent) {
  LinkCell cell;
  cell.disturb = [](const spi::Transfer& transfer) {
    LinkFault fault;
    fault.lost = transfer.select >= 8;
    return fault;
  };
  cell.driver->open(cell.now);
  ASSERT_TRUE(cell.run_to_event(Kind::kReady, 2s));
  const auto refused = cell.driver->home(cell.now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(refused.error().index, 3);
  cell.run_for(1s);
  for (const auto& axis : cell.axes) EXPECT_FALSE(axis->status().homing);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
}

TEST(AxisLinkFaults, words_of_an_axis_are_told_without_numbers_that_nobody_measured) {
  for (std::uint8_t fault = 1; fault <= 12; ++fault) {
    const axis_link::State state{.fault = fault};
    const std::string sentence = describe(*axis_link::trouble_of(state), "the base");
    EXPECT_EQ(sentence.find_first_of("0123456789"), std::string::npos) << sentence;
  }
  const axis_link::State state{.verdict = axis_link::Verdict::kOutOfLimits};
  const std::string sentence = describe(*axis_link::refusal_of(state), "the base");
  EXPECT_EQ(sentence.find_first_of("0123456789"), std::string::npos) << sentence;
}

TEST(AxisLinkFaults, a_pause_of_the_host_sends_no_setpoint_ahead_and_back) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 5s, from_deg(20)), cell.now));
  cell.run_for(2s);
  for (int i = 0; i < 10; ++i) {
    cell.now += 40ms;
    cell.run_for(50ms);
  }
  const std::vector<double>& targets = cell.axes[0]->targets;
  EXPECT_GT(targets.size(), 2000U);
  EXPECT_TRUE(std::ranges::is_sorted(targets));
}

TEST(AxisLinkFaults, a_dead_axis_is_out_and_the_rest_stop_and_go_on) {
  LinkCell cell;
  cell.open_at(0);
  bool dead = false;
  cell.disturb = [&](const spi::Transfer& transfer) {
    LinkFault fault;
    fault.lost = dead && transfer.select == 4;
    return fault;
  };
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(300ms);
  dead = true;
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 20ms));
  EXPECT_EQ(cell.failure()->code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.failure()->index, 2);
  for (int i = 0; i < 300; ++i) {
    cell.run_for(3ms);
    cell.expect_truth_inside();
  }
  EXPECT_EQ(cell.driver->state(), DriverState::kFault);
  EXPECT_EQ(cell.axes[2]->status().fault, AxisFault::kNone) << "it heard the stop to all";
  EXPECT_EQ(cell.nodes[2]->session(), 0) << "and closed the session at its deadline";
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  cell.run_for(1100ms);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  EXPECT_EQ(cell.driver->axis_fault(2)->code, ErrorCode::kDeviceSilent);
  dead = false;
  ASSERT_TRUE(cell.driver->clear_fault(cell.now));
  cell.run_for(50ms);
  EXPECT_FALSE(cell.driver->axis_fault(2));
  EXPECT_EQ(cell.driver->positions()[2].quality, PositionQuality::kMeasured);
}

/// Two axes as slow as robot-arm-2 documents them: 3 s and 45 degrees from full speed to rest.
void make_slow(LinkCell& cell) {
  for (std::size_t i = 0; i < cell.axes.size(); ++i) {
    Joint& joint = cell.joints[i];
    joint.velocity_max = from_deg(30);
    joint.acceleration_max = joint.jerk_max = from_deg(10);
    cell.axes[i] = std::make_unique<test::LinkTestAxis>(joint);
    cell.nodes[i] = cell.node(i, 1);
  }
  cell.driver = std::make_unique<AxisLinkDriver>(cell.device, cell.joints);
}

bool any_moves(const LinkCell& cell) {
  return std::ranges::any_of(cell.axes, [](const auto& axis) { return axis->status().moving; });
}

// Once counted as stopped after 100 ms, with 3 s of braking still ahead.
TEST(AxisLinkFaults, a_silent_axis_counts_as_stopped_only_once_it_had_the_time_to_brake) {
  LinkCell cell(2);
  make_slow(cell);
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 3200ms), cell.now));
  cell.run_for(1600ms);
  bool dead = true;
  cell.disturb = [&](const spi::Transfer&) {
    LinkFault fault;
    fault.lost = dead;
    return fault;
  };
  // The worst that an axis may do until its deadline: go on at full speed.
  for (auto& axis : cell.axes) ASSERT_EQ(axis->move_to(from_deg(85)), AxisVerdict::kAccepted);
  cell.driver->stop(cell.now);
  const Instant asked = cell.now;
  std::optional<Duration> stood;
  ASSERT_TRUE(cell.run_until(
      [&] {
        cell.expect_truth_inside();
        if (!any_moves(cell) && !stood) stood = cell.now - asked;
        for (const JointPosition& claim : cell.driver->positions()) {
          if (!stood && cell.now - asked > 2ms) {
            EXPECT_EQ(claim.quality, PositionQuality::kUncertain);
          }
        }
        return cell.count(Kind::kStopped) > 0 || testing::Test::HasFailure();
      },
      10s));
  ASSERT_TRUE(stood) << "kStopped while an axis still brakes";
  EXPECT_GT(*stood, 2900ms) << "the test means a slow axis";
  EXPECT_GT(cell.axes[0]->q(), from_deg(70));
  EXPECT_LT(cell.now - asked, 5200ms) << "deadline, 3 s, and 2 s for the jerk";
  cell.run_for(10ms);
  EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kLost);
  // What was silent for so long before the stop needs no such wait.
  cell.run_for(2s);
  cell.events.clear();
  cell.driver->stop(cell.now);
  EXPECT_TRUE(cell.run_to_event(Kind::kStopped, 150ms));
}

TEST(AxisLinkFaults, an_axis_that_homes_into_a_dead_line_is_waited_for) {
  LinkCell cell(2);
  make_slow(cell);
  cell.driver->open(cell.now);
  cell.run_for(20ms);
  ASSERT_TRUE(cell.driver->home(cell.now));
  cell.run_for(500ms);
  cell.disturb = [](const spi::Transfer&) {
    LinkFault fault;
    fault.lost = true;
    return fault;
  };
  ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 20ms));
  cell.driver->stop(cell.now);
  ASSERT_TRUE(cell.run_to_event(Kind::kStopped, 10s));
  EXPECT_FALSE(any_moves(cell));
  EXPECT_GT(cell.axes[0]->q() - cell.axes[0]->home_angle, from_deg(30))
      << "it did not arrive first";
}

// A host that was away while an axis homed said that nobody knows any more where the axis is,
// which nobody ever knew.
TEST(AxisLinkFaults, a_session_lost_while_homing_is_told_as_a_silent_link) {
  LinkCell cell(1);
  cell.driver->open(cell.now);
  cell.run_for(20ms);
  for (const bool was_homed : {false, true}) {
    if (was_homed) cell.axes[0]->place(0);
    cell.run_for(20ms);
    cell.events.clear();
    ASSERT_TRUE(cell.driver->home(cell.now));
    cell.run_for(100ms);
    ASSERT_TRUE(cell.axes[0]->status().homing);
    for (int i = 0; i < 110; ++i) {
      cell.now += 1ms;
      cell.axes[0]->advance(cell.now);
      cell.nodes[0]->advance(cell.now);
    }
    ASSERT_EQ(cell.nodes[0]->session(), 0);
    ASSERT_TRUE(cell.run_to_event(Kind::kFailed, 50ms));
    EXPECT_EQ(cell.failure(), (Error{ErrorCode::kLinkSilent, 0}));
    EXPECT_EQ(cell.driver->positions()[0].quality, PositionQuality::kLost);
    cell.run_for(1s);
    ASSERT_TRUE(cell.driver->clear_fault(cell.now));
    cell.run_for(50ms);
    ASSERT_EQ(cell.driver->state(), DriverState::kReady);
  }
}

TEST(AxisLinkFaults, a_host_that_dies_leaves_every_axis_stopped_within_the_deadline) {
  for (const Duration deadline : {Duration{20ms}, Duration{100ms}, Duration{500ms}}) {
    LinkCell cell(6, {}, 4'000'000, deadline);
    cell.open_at(0);
    // A point-to-point axis would go on by itself: take one that is far from its last setpoint.
    ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
    cell.run_for(500ms);
    const Instant dead = cell.now;
    while (cell.now < dead + deadline - 2ms) {
      cell.now += 1ms;
      for (auto& node : cell.nodes) node->advance(cell.now);
    }
    for (auto& axis : cell.axes) EXPECT_EQ(axis->stops, 0);
    for (int i = 0; i < 3; ++i) {
      cell.now += 1ms;
      for (auto& node : cell.nodes) node->advance(cell.now);
    }
    for (auto& axis : cell.axes) {
      EXPECT_EQ(axis->stops, 1);
      EXPECT_EQ(axis->status().fault, AxisFault::kLinkSilent);
    }
  }
}

TEST(AxisLinkFaults, a_new_host_takes_over_a_moving_arm_by_stopping_it) {
  LinkCell cell;
  cell.open_at(0);
  ASSERT_TRUE(cell.driver->move(cell.move_to(from_deg(60), 1s), cell.now));
  cell.run_for(500ms);
  cell.driver = std::make_unique<AxisLinkDriver>(cell.device, cell.joints);
  cell.driver->open(cell.now);
  cell.run_for(10ms);
  EXPECT_EQ(cell.driver->state(), DriverState::kReady);
  for (const auto& axis : cell.axes) EXPECT_EQ(axis->stops, 1);
  cell.run_for(1s);
  for (const auto& axis : cell.axes) EXPECT_FALSE(axis->status().moving);
}

LinkFault random_fault(test::Random& random) {
  LinkFault fault;
  switch (random.integer(0, 6)) {
    case 0:
      fault.lost = true;
      break;
    case 1:
      fault.bytes = static_cast<std::size_t>(random.integer(0, 15));
      break;
    case 2:
      fault.twice = true;
      break;
    case 3:
      fault.mosi_bit = static_cast<int>(random.integer(0, 127));
      break;
    case 4:
      fault.miso_bit = static_cast<int>(random.integer(0, 127));
      break;
    case 5:
      fault.old_reply = true;
      break;
    default:
      fault.old_request = true;
  }
  return fault;
}

TEST(AxisLinkFaults, whatever_the_line_does_no_axis_moves_wrong_and_every_claim_holds) {
  std::size_t arrived = 0;
  std::size_t failed = 0;
  test::for_random_cases(60, [&](test::Random& random) {
    LinkCell cell(3);
    cell.open_at(0);
    const double rate = random.chance(0.3) ? 0.5 : random.uniform(0, 0.3);
    const int hit_axis = static_cast<int>(random.integer(0, 7));
    bool noisy = true;
    cell.disturb = [&](const spi::Transfer& transfer) {
      const bool hit = noisy && (transfer.select & hit_axis) != 0 && random.chance(rate);
      return hit ? random_fault(random) : LinkFault{};
    };
    std::size_t accepted = 0;
    for (int round = 0; round < 3; ++round) {
      const auto ask =
          cell.driver->move(cell.move_to(from_deg(random.uniform(-80, 80)), 3s), cell.now);
      accepted += ask ? 1 : 0;
      const auto kicked = from_seconds(random.uniform(0.05, 1.5));
      const bool stop = random.chance(0.3);
      const bool reboot = random.chance(0.2);
      const Instant when = cell.now + kicked;
      bool done = false;
      cell.run_until(
          [&] {
            cell.expect_truth_inside();
            if (cell.now >= when && !done) {
              done = true;
              if (stop) cell.driver->stop(cell.now);
              if (reboot) cell.reboot(1);
            }
            return testing::Test::HasFailure();
          },
          3500ms);
      if (reboot) cell.axes[1]->place(cell.axes[1]->q());
    }
    noisy = false;
    cell.run_for(2s);
    EXPECT_GE(cell.count(Kind::kDone) + cell.count(Kind::kFailed) + cell.count(Kind::kStopped),
              accepted);
    arrived += cell.count(Kind::kDone);
    failed += cell.count(Kind::kFailed);
    cell.expect_only_sent_targets();
    for (const auto& axis : cell.axes) EXPECT_FALSE(axis->status().moving);
    cell.events.clear();
    ASSERT_TRUE(cell.driver->clear_fault(cell.now));
    cell.run_for(50ms);
    EXPECT_EQ(cell.driver->state(), DriverState::kReady);
    ASSERT_TRUE(cell.driver->move(cell.move_to(0, 5s), cell.now));
    cell.run_for(6s);
    EXPECT_EQ(cell.count(Kind::kDone), 2U);
    for (const auto& axis : cell.axes) EXPECT_NEAR(axis->q(), 0, 1e-7);
  });
  EXPECT_GT(arrived, 0U) << "not every line is hopeless";
  EXPECT_GT(failed, 0U) << "the faults reach the driver";
}

}  // namespace
}  // namespace sinew
