#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/devices/icp/icp_test_cell.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::IcpCell;
using test::IcpLine;
using Kind = DriverEvent::Kind;

/// What is done to one byte of one direction.
struct Damage {
  bool host = true;  ///< a byte from the host
  std::size_t place = 0;
  std::uint8_t flip = 0;  ///< 0: the byte is dropped
  int copies = 1;
  Duration late{};
};

IcpLine::Fate damaged(const Damage& damage, std::uint8_t byte) {
  IcpLine::Fate fate{{}, damage.late};
  const bool drop = damage.flip == 0 && damage.copies == 1 && damage.late == Duration::zero();
  for (int i = 0; i < (drop ? 0 : damage.copies); ++i) {
    fate.bytes.push_back(static_cast<std::uint8_t>(byte ^ damage.flip));
  }
  return fate;
}

void arrange(IcpCell& cell, const std::vector<Damage>& damages) {
  for (const bool host : {true, false}) {
    (host ? cell.up : cell.down).fault = [damages, host](std::uint8_t byte, std::size_t place) {
      for (const Damage& damage : damages) {
        if (damage.host == host && damage.place == place) return damaged(damage, byte);
      }
      return IcpLine::Fate{{byte}, {}};
    };
  }
}

constexpr double kCutWay = 2.0 * IcpLegClaim::kPowerCutUnits;

constexpr std::array<std::int64_t, kLegs> kWay{2, -1, 0, 1, 0, -2};

/// A motion of every kind of step, its statuses, a wake-up and one more motion, with `damages` at
/// their bytes. The truth is looked at where anything may have happened.
struct Story {
  explicit Story(const std::vector<Damage>& damages) {
    cell.begin();
    arrange(cell, damages);
    honest(cell.go(kWay).has_value());
    honest(cell.driver.wake(cell.now).has_value());
    up = cell.up.count();
    down = cell.down.count();
    // Whatever was damaged is over: what follows would be off by a reply, if anything were.
    if (cell.driver.fault() && cell.driver.fault()->code != ErrorCode::kDeviceKilled) {
      EXPECT_TRUE(cell.driver.clear_fault(cell.now));
      cell.settle();
    }
    honest(cell.go({-5, 5, -5, 5, 5, 5}).has_value());
  }
  void honest(bool accepted) {
    cell.settle();
    cell.expect_honest();
    if (accepted) ++commands;
    EXPECT_EQ(ended(), commands) << "each command ends once";
  }
  std::size_t ended() const {
    return cell.count(Kind::kDone) + cell.count(Kind::kFailed) + cell.count(Kind::kStopped);
  }

  IcpCell cell;
  std::size_t commands = 0;
  std::size_t up = 0;
  std::size_t down = 0;
};

/// Where the current went and came back, the rotors snap to their home phase.
void expect_rotors_inside(IcpCell& cell) {
  const sim::Truth truth = cell.machine.truth();
  for (std::size_t i = 0; i < kLegs; ++i) {
    const JointPosition& claim = cell.driver.positions()[i];
    EXPECT_GE(truth.joints[i].q, claim.lower) << "leg " << i;
    EXPECT_LE(truth.joints[i].q, claim.upper) << "leg " << i;
  }
}

struct Tally {
  int runs = 0;
  int uncertain = 0;
  int faults = 0;
  int killed = 0;

  void add(const Story& story) {
    ++runs;
    uncertain += story.cell.uncertain() ? 1 : 0;
    faults += story.cell.driver.fault() ? 1 : 0;
    const auto fault = story.cell.driver.fault();
    killed += fault && fault->code == ErrorCode::kDeviceKilled ? 1 : 0;
  }
  /// The damage reached the driver, and what it did not touch stayed certain.
  void expect_told_apart() const {
    EXPECT_GT(uncertain, 0);
    EXPECT_LT(uncertain, runs);
  }
  void print(const char* what) const {
    std::cout << "  " << what << ": " << runs << " runs, " << uncertain << " uncertain, " << faults
              << " faults, " << killed << " killed\n";
  }
};

TEST(IcpDriverFaults, any_one_flipped_bit_makes_no_wrong_move_that_is_not_admitted) {
  const Story clean({});
  ASSERT_FALSE(clean.cell.uncertain());
  // 6 moves, 6 statuses, a wake-up between 6 and 6 statuses: 2 or 3 bytes up; 2 or 15 down.
  ASSERT_EQ(clean.up, 6U * 2 + 6 * 3 + 6 * 3 + 2 + 6 * 3);
  ASSERT_EQ(clean.down, 6U * 2 + 6 * 15 + 6 * 15 + 2 + 6 * 15);
  for (const bool host : {true, false}) {
    Tally tally;
    for (std::size_t place = 0; place < (host ? clean.up : clean.down); ++place) {
      for (unsigned bit = 0; bit < 8; ++bit) {
        const auto flip = static_cast<std::uint8_t>(1U << bit);
        SCOPED_TRACE(::testing::Message()
                     << (host ? "host" : "device") << " byte " << place << " bit " << bit);
        tally.add(Story({{.host = host, .place = place, .flip = flip}}));
        if (HasFailure()) return;
      }
    }
    tally.print(host ? "flips from the host" : "flips from the device");
    tally.expect_told_apart();
  }
}

TEST(IcpDriverFaults, any_one_dropped_doubled_or_late_byte_is_admitted) {
  const Story clean({});
  for (const bool host : {true, false}) {
    Tally tally;
    for (std::size_t place = 0; place < (host ? clean.up : clean.down); ++place) {
      for (const Damage& kind :
           {Damage{.copies = 1}, Damage{.copies = 2}, Damage{.copies = 3}, Damage{.late = 10ms},
            Damage{.late = 51ms}, Damage{.late = 60ms}, Damage{.late = 140ms},
            Damage{.late = 170ms}, Damage{.late = 400ms}}) {
        Damage damage = kind;
        damage.host = host;
        damage.place = place;
        SCOPED_TRACE(::testing::Message() << (host ? "host" : "device") << " byte " << place << ", "
                                          << kind.copies << " copies, " << to_seconds(kind.late));
        tally.add(Story({damage}));
        if (HasFailure()) return;
      }
    }
    tally.print(host ? "drops, copies, delays from the host" : "the same from the device");
    tally.expect_told_apart();
  }
}

TEST(IcpDriverFaults, one_more_flipped_bit_anywhere_in_the_recovery_is_admitted_too) {
  const Story clean({});
  Tally tally;
  // The ACK of FF, of a step, of F0, of a selector, and a byte of a block, each lost.
  for (const std::size_t lost : {0U, 1U, 4U, 5U, 12U, 13U, 14U, 15U, 20U}) {
    const Damage first{.host = false, .place = lost};
    const Story once({first});
    for (const bool host : {true, false}) {
      const std::size_t begin = host ? lost / 2 : lost + 1;
      for (std::size_t place = begin; place < begin + 24; ++place) {
        for (unsigned bit = 0; bit < 8; ++bit) {
          const auto flip = static_cast<std::uint8_t>(1U << bit);
          SCOPED_TRACE(::testing::Message()
                       << "lost " << lost << ", then " << (host ? "host" : "device") << " byte "
                       << place << " bit " << bit);
          tally.add(Story({first, {.host = host, .place = place, .flip = flip}}));
          if (HasFailure()) return;
        }
      }
    }
  }
  tally.print("a lost reply, then a flip");
  tally.expect_told_apart();
}

TEST(IcpDriverFaults, opening_inside_an_exchange_moves_nothing_whatever_befalls_its_first_bytes) {
  // The host that died had said FF, or FF and F0.
  const std::vector<std::vector<std::uint8_t>> exchanges{{icp::kInit}, {icp::kInit, icp::kRequest}};
  for (const auto& said : exchanges) {
    for (std::size_t place = 0; place < 2; ++place) {
      for (unsigned bit = 0; bit < 8; ++bit) {
        IcpCell cell;
        cell.run_for(100ms);
        cell.driver.declare_positions(IcpCell::at_home());
        cell.machine.receive(said, cell.now);
        std::array<std::uint8_t, 4> gone{};
        cell.machine.take_output(gone);
        // One flipped bit, and an answer gets lost as well.
        const auto flip = static_cast<std::uint8_t>(1U << bit);
        arrange(cell,
                {{.host = true, .place = place, .flip = flip}, {.host = false, .place = place}});
        cell.driver.open(cell.now);
        cell.settle();
        cell.expect_honest();
        // With the lost answer of before, that may be three in a row.
        EXPECT_TRUE(cell.driver.clear_fault(cell.now));
        cell.settle();
        EXPECT_EQ(cell.driver.state(), DriverState::kReady) << place << ' ' << bit;
        EXPECT_FALSE(cell.uncertain()) << place << ' ' << bit;
        cell.expect_honest();
      }
    }
  }
}

// A million faults, seed 20261121, case 697: in the fault the device still waited for a command,
// clear_fault() began with a sync byte, a bit made a step of leg 4 of it, and its ACK got lost.
TEST(IcpDriverFaults, clearing_a_fault_inside_an_exchange_moves_nothing) {
  for (unsigned bit = 0; bit < 8; ++bit) {
    IcpCell cell;
    cell.begin();
    cell.down.fault = [](std::uint8_t, std::size_t) { return IcpLine::Fate{}; };
    ASSERT_TRUE(cell.go({1, 0, 0, 0, 0, 0}));
    cell.settle();
    ASSERT_EQ(cell.driver.state(), DriverState::kFault);
    const auto flip = static_cast<std::uint8_t>(1U << bit);
    cell.up.restart_count();
    cell.down.restart_count();
    arrange(cell, {{.host = true, .place = 0, .flip = flip}, {.host = false, .place = 0}});
    ASSERT_TRUE(cell.driver.clear_fault(cell.now));
    cell.settle();
    EXPECT_EQ(cell.driver.state(), DriverState::kReady) << bit;
    cell.expect_honest();
    EXPECT_FALSE(cell.uncertain()) << bit;
  }
}

TEST(IcpDriverFaults, unknown_step_is_never_sent_again_blindly) {
  IcpCell cell;
  cell.begin();
  std::vector<std::uint8_t> sent;
  cell.up.record = &sent;
  arrange(cell, {{.host = false, .place = 3}});  // the ACK of the second step
  ASSERT_TRUE(cell.go({4, 0, 0, 0, 0, 0}));
  cell.settle();
  EXPECT_EQ(std::count(sent.begin(), sent.end(), 0x11), 4);
  EXPECT_EQ(cell.truth(0), 4);
  const JointPosition& claim = cell.driver.positions()[0];
  EXPECT_EQ(claim.quality, PositionQuality::kUncertain);
  EXPECT_NEAR(claim.upper - claim.lower, 1 / test::kIcpUnitsPerM, 1e-12);
  EXPECT_EQ(cell.driver.health().timeouts, 1U);
}

TEST(IcpDriverFaults, refused_step_is_sent_again_and_arrives) {
  for (const std::uint8_t flip : std::array<std::uint8_t, 2>{0x01, 0x80}) {  // 11 and 22
    IcpCell cell;
    cell.begin();
    arrange(cell, {{.host = true, .place = 3, .flip = flip}});
    ASSERT_TRUE(cell.go({0, 4, 0, 0, 0, 0}));
    cell.settle();
    EXPECT_EQ(cell.count(Kind::kDone), 1U);
    EXPECT_EQ(cell.truth(1), 4);
    EXPECT_FALSE(cell.uncertain());
    EXPECT_EQ(cell.driver.health().retries, 1U);
  }
}

TEST(IcpDriverFaults, legs_that_have_become_too_uncertain_are_not_moved_on) {
  IcpCell cell;
  cell.begin();
  // Every third step's ACK is lost.
  cell.down.fault = [&](std::uint8_t byte, std::size_t) {
    static_cast<void>(byte);
    return IcpLine::Fate{{byte}, {}};
  };
  std::size_t steps = 0;
  cell.up.fault = [&](std::uint8_t byte, std::size_t) {
    const bool lost = byte == 0x11 && ++steps % 3 == 0;
    return lost ? IcpLine::Fate{} : IcpLine::Fate{{byte}, {}};
  };
  ASSERT_TRUE(cell.go({100, 0, 0, 0, 0, 0}));
  cell.settle();
  ASSERT_EQ(cell.count(Kind::kFailed), 1U);
  EXPECT_EQ(cell.events[0].error, (Error{ErrorCode::kPositionUnknown, 0}));
  cell.expect_honest();
  EXPECT_EQ(cell.go({}).error().code, ErrorCode::kPositionUnknown);
  cell.driver.declare_positions(IcpCell::at_home());
  EXPECT_TRUE(cell.go({}));
}

TEST(IcpDriverFaults, flip_of_f0_into_e0_is_told_as_killed) {
  IcpCell cell;
  cell.begin();
  arrange(cell, {{.host = true, .place = 3, .flip = 0x10}});
  ASSERT_TRUE(cell.go({1, 0, 0, 0, 0, 0}));
  cell.settle();
  ASSERT_EQ(cell.count(Kind::kFailed), 1U);
  EXPECT_EQ(cell.events[0].error.code, ErrorCode::kDeviceKilled);
  cell.expect_honest();
}

TEST(IcpDriverFaults, unplugged_line_is_told_as_silent_and_found_again) {
  IcpCell cell;
  cell.begin();
  cell.up.fault = [](std::uint8_t, std::size_t) { return IcpLine::Fate{}; };
  ASSERT_TRUE(cell.go({1, 0, 0, 0, 0, 0}));
  cell.settle();
  // Three times 52.1 ms, rounded up; with the silences in between, and once more behind a second.
  ASSERT_EQ(cell.driver.fault()->code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(cell.driver.fault()->limit, 0.2);
  EXPECT_NEAR(cell.driver.fault()->measured, 1.408, 0.005);
  for (const JointPosition& claim : cell.driver.positions()) {
    EXPECT_EQ(claim.quality, PositionQuality::kUncertain) << "the power may be away as well";
    EXPECT_NEAR(claim.upper - claim.lower, kCutWay / test::kIcpUnitsPerM, 1e-12);
  }
  cell.up.fault = nullptr;
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.settle();
  EXPECT_FALSE(cell.uncertain()) << "no step was sent, and no module has forgotten anything";
  ASSERT_TRUE(cell.go({1, 0, 0, 0, 0, 0}));
  cell.settle();
  EXPECT_EQ(cell.truth(0), 1);
}

TEST(IcpDriverFaults, who_never_was_heard_at_opening_has_taken_nothing_away) {
  IcpCell cell;
  cell.run_for(100ms);
  cell.up.fault = [](std::uint8_t, std::size_t) { return IcpLine::Fate{}; };
  cell.driver.declare_positions(IcpCell::at_home());
  cell.driver.open(cell.now);
  cell.settle();
  ASSERT_EQ(cell.driver.fault()->code, ErrorCode::kDeviceSilent);
  EXPECT_FALSE(cell.uncertain()) << "its flags will tell";
}

TEST(IcpDriverFaults, line_that_talks_on_for_ever_is_told) {
  IcpCell cell;
  cell.begin();
  for (int i = 0; i < 100; ++i) {
    cell.driver.receive(std::array<std::uint8_t, 1>{0x55}, cell.now);
    cell.run_for(90ms);
  }
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kUnaskedReply);
  EXPECT_EQ(cell.driver.fault()->measured, 0x55);
  EXPECT_EQ(cell.count(Kind::kNotice), 1U);
}

TEST(IcpDriverFaults, zeros_that_nobody_asked_for_are_not_called_a_wrong_zero) {
  IcpCell cell;
  cell.begin();
  for (int i = 0; i < 100; ++i) {
    cell.driver.receive(std::array<std::uint8_t, 1>{0}, cell.now);
    cell.run_for(90ms);
  }
  EXPECT_EQ(cell.driver.fault(), (Error{ErrorCode::kUnaskedReply, -1, 0}));
}

TEST(IcpDriverFaults, module_that_lost_its_power_is_found_at_the_next_rest_and_admitted) {
  IcpCell cell;
  cell.begin();
  ASSERT_TRUE(cell.go({0, 0, 60, 0, 0, 0}));
  cell.run_for(100ms);
  // Below what the modules need, not below what the controller needs.
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 4.5});
  cell.run_for(20ms);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 12});
  cell.settle();
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  ASSERT_EQ(cell.count(Kind::kFailed), 1U);
  expect_rotors_inside(cell);
  EXPECT_TRUE(cell.uncertain());
  // The modules have no parameters: only the controller's boot gives them back.
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.settle();
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kSupplyFlag);
  cell.machine.power_cycle();
  cell.run_for(100ms);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.settle();
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(cell.go({}).error().code, ErrorCode::kPositionUnknown);
}

TEST(IcpDriverFaults, whole_power_cycle_in_or_after_a_motion_is_found_and_admitted) {
  for (int at = 50; at < 300; at += 7) {
    IcpCell cell;
    cell.begin();
    ASSERT_TRUE(cell.go({20, -20, 7, 0, 0, 0}));
    cell.run_for(std::chrono::milliseconds(at));
    cell.machine.power_cycle();
    cell.run_for(600ms);
    cell.settle();
    // Where it came between two motions, the next one looks before it steps.
    (void)cell.go({21, -21, 8, 1, 1, 1});
    cell.settle();
    EXPECT_EQ(cell.driver.state(), DriverState::kFault) << at;
    expect_rotors_inside(cell);
  }
}

TEST(IcpDriverFaults, what_is_declared_where_the_current_came_back_holds_the_fall_from_its_hill) {
  int fell = 0;
  for (const std::int64_t at : {31, 32, 33, 47, 64}) {
    IcpCell cell;
    cell.begin();
    ASSERT_TRUE(cell.go({at, -at, at, -at, at, -at}));
    cell.settle();
    cell.machine.power_cycle();
    cell.run_for(600ms);
    (void)cell.driver.wake(cell.now);
    cell.settle();
    for (int i = 0; i < 3 && cell.driver.fault(); ++i) {
      ASSERT_TRUE(cell.driver.clear_fault(cell.now));
      cell.settle();
    }
    ASSERT_EQ(cell.driver.state(), DriverState::kReady);
    std::array<JointPosition, kLegs> stand;
    const sim::Truth before = cell.machine.truth();
    for (std::size_t i = 0; i < kLegs; ++i) {
      const double q = before.joints[i].q;
      stand[i] = {PositionQuality::kCommanded, q, q, q};
    }
    cell.driver.declare_positions(stand);
    EXPECT_FALSE(cell.uncertain());
    ASSERT_TRUE(cell.go({at + 1, -at + 1, at + 1, -at + 1, at + 1, -at + 1}));
    cell.run_until([&] {
      expect_rotors_inside(cell);
      return testing::Test::HasFailure() || cell.driver.state() == DriverState::kReady;
    });
    const sim::Truth behind = cell.machine.truth();
    for (std::size_t i = 0; i < kLegs; ++i) {
      const double moved = std::abs(behind.joints[i].q - cell.driver.positions()[i].q);
      fell += moved * test::kIcpUnitsPerM > 16 ? 1 : 0;
      const JointPosition now{PositionQuality::kCommanded, behind.joints[i].q, behind.joints[i].q,
                              behind.joints[i].q};
      stand[i] = now;
    }
    cell.driver.declare_positions(stand);
    const JointPosition& first = cell.driver.positions()[0];
    EXPECT_NEAR(first.upper - first.lower, 2 / test::kIcpUnitsPerM, 1e-12)
        << "it has stepped since";
  }
  EXPECT_GT(fell, 0) << "no rotor has rested on its hill";
}

TEST(IcpDriverFaults, under_voltage_blocks_the_weaker_modules_and_is_found) {
  IcpCell cell;
  cell.begin();
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 7.5});
  ASSERT_TRUE(cell.go({6, 6, 6, 6, 6, 6}));
  cell.settle();
  int moved = 0;
  for (std::size_t i = 0; i < kLegs; ++i) moved += cell.truth(i) == 6 ? 1 : 0;
  EXPECT_GT(moved, 0) << "not all motors spin";
  EXPECT_LT(moved, 6);
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kSupplyFlag) << "its module says so";
  cell.expect_honest();
}

/// What a module's own flags tell of while its leg is on its way: the claim is withdrawn to all
/// that may have happened since its last good status, and the truth is in it.
TEST(IcpDriverFaults, hot_module_and_broken_coil_are_found_named_and_admitted) {
  struct Case {
    const char* name;
    void (*befall)(Tmc222& module, Instant now);
    ErrorCode code;
  };
  constexpr Case kCases[] = {
      {"hot", [](Tmc222& module, Instant now) { module.set_temperature(160, now); },
       ErrorCode::kOverheated},
      {"coil", [](Tmc222& module, Instant now) { module.set_coil_fault(true, now); },
       ErrorCode::kMotionIgnored}};
  for (const Case& one : kCases) {
    for (int at = 0; at < 400; at += 23) {
      IcpCell cell;
      cell.begin();
      ASSERT_TRUE(cell.go({40, 40, 40, -40, -40, -40}));
      cell.run_for(std::chrono::milliseconds(at));
      one.befall(cell.machine.module(2), cell.now);
      cell.settle();
      // Where it came behind the last step, the next motion's look finds it.
      if (cell.driver.state() == DriverState::kReady) {
        (void)cell.go({0, 0, 0, 0, 0, 0});
        cell.settle();
      }
      ASSERT_EQ(cell.driver.state(), DriverState::kFault) << one.name << " at " << at;
      EXPECT_EQ(cell.driver.fault()->code, one.code) << one.name << " at " << at;
      EXPECT_EQ(cell.driver.fault()->index, 2) << one.name << " at " << at;
      EXPECT_EQ(cell.driver.positions()[2].quality, PositionQuality::kUncertain) << one.name;
      expect_rotors_inside(cell);
    }
  }
}

/// A module that is stopped hard in the middle of a microstep says step loss; whether the step was
/// made nobody knows.
TEST(IcpDriverFaults, step_loss_of_a_module_is_found_named_and_admitted) {
  int lost = 0;
  for (int at = 0; at < 40; ++at) {
    IcpCell cell;
    cell.begin();
    ASSERT_TRUE(cell.go({40, 40, 40, -40, -40, -40}));
    Tmc222& module = cell.machine.module(3);
    cell.run_for(std::chrono::milliseconds(20 * at));
    cell.run_until([&] { return module.moving(); }, 100ms);
    const bool in_a_step = module.moving();
    const auto hard_stop = tmc222::encode_command(tmc222::HardStop{});
    ASSERT_TRUE(module.write({hard_stop.data(), hard_stop.size()}, cell.now));
    cell.settle();
    if (cell.driver.state() == DriverState::kReady) {
      (void)cell.go({0, 0, 0, 0, 0, 0});
      cell.settle();
    }
    expect_rotors_inside(cell);
    if (!in_a_step) continue;
    ++lost;
    ASSERT_EQ(cell.driver.state(), DriverState::kFault) << at;
    EXPECT_EQ(cell.driver.fault()->index, 3) << at;
    EXPECT_EQ(cell.driver.positions()[3].quality, PositionQuality::kUncertain) << at;
  }
  EXPECT_GT(lost, 20);
}

/// Dips of the supply, each at a moment of its own; the last one may last.
void dip(IcpCell& cell, test::Random& random) {
  const auto dips = random.integer(1, 2);
  for (std::int64_t i = 0; i < dips; ++i) {
    cell.run_for(Duration{random.integer(0, 400'000'000)});
    cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, random.uniform(0, 9)});
    cell.run_for(Duration{random.integer(100'000, 400'000'000)});
    if (random.chance(0.8)) cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 12});
  }
}

TEST(IcpDriverFaults, dip_of_the_supply_at_any_moment_leaves_no_leg_silently_wrong) {
  Tally tally;
  int silent = 0;
  test::for_random_cases(400, [&](test::Random& random) {
    IcpCell cell({}, test::icp_device(), {}, static_cast<std::uint64_t>(random.integer(1, 1000)));
    cell.begin();
    // So that the modules hold something and stand beside their home phase.
    std::array<std::int64_t, kLegs> way{};
    for (auto& units : way) units = random.integer(-60, 60);
    ASSERT_TRUE(cell.go(way));
    cell.settle();
    for (auto& units : way) units += random.chance(0.3) ? 0 : random.integer(-60, 60);
    ASSERT_TRUE(cell.go(way));
    dip(cell, random);
    if (random.chance(0.3)) cell.driver.stop(cell.now);
    cell.settle();
    // Where it came at rest, the next command looks; a step beforehand would not.
    cell.run_for(600ms);
    if (cell.driver.state() != DriverState::kFault) {
      const auto leg = static_cast<std::size_t>(random.integer(0, kLegs - 1));
      way[leg] += 1;
      (void)(random.chance(0.5) ? cell.go(way) : cell.driver.wake(cell.now));
      cell.settle();
    }
    expect_rotors_inside(cell);
    silent += cell.driver.fault() && cell.driver.fault()->code == ErrorCode::kDeviceSilent ? 1 : 0;
    // The supply is back for good: what is restored must be true, what is not is admitted.
    cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 12});
    cell.run_for(100ms);
    for (int i = 0; i < 2 && cell.driver.fault(); ++i) {
      ASSERT_TRUE(cell.driver.clear_fault(cell.now));
      cell.settle();
    }
    cell.run_for(100ms);
    expect_rotors_inside(cell);
    ++tally.runs;
    tally.uncertain += cell.uncertain() ? 1 : 0;
    tally.faults += cell.driver.fault() ? 1 : 0;
  });
  tally.print("dips of the supply");
  EXPECT_GT(silent, tally.runs / 10);
  tally.expect_told_apart();
}

/// The supply goes in the swing of a rotor whose current has just come back, or where it likes.
void dip_in_a_swing(IcpCell& cell, test::Random& random) {
  const auto any_up = [&] {
    bool up = false;
    for (std::size_t i = 0; i < kLegs; ++i) up = up || cell.machine.module(i).powered();
    return up;
  };
  if (!any_up()) cell.run_until(any_up, 300ms);
  // A quarter of the rotor's own oscillation is 1 ms, its ringing over after 15.
  cell.run_for(Duration{random.integer(0, random.chance(0.8) ? 6'000'000 : 60'000'000)});
  const double volts = random.chance(0.5) ? random.uniform(6.5, 8) : random.uniform(0, 6.5);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, volts});
  // Still running on when the current comes back, or at rest.
  cell.run_for(Duration{random.integer(100'000, random.chance(0.5) ? 20'000'000 : 200'000'000)});
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 12});
}

TEST(IcpDriverFaults, power_cuts_in_the_swing_of_the_one_before_stay_inside_the_claim) {
  std::int64_t farthest = 0;
  int beyond_one_cut = 0;
  test::for_random_cases(600, [&](test::Random& random) {
    IcpCell cell({}, test::icp_device(), {}, static_cast<std::uint64_t>(random.integer(1, 1000)));
    cell.begin();
    std::array<std::int64_t, kLegs> way{};
    // Half an electrical turn beside the home phase is where a rotor has most to swing with.
    for (auto& units : way) units = random.integer(24, 48) * (random.chance(0.5) ? 1 : -1);
    ASSERT_TRUE(cell.go(way));
    cell.settle();
    // Nobody looks for up to the half second that the host trusts its modules; a command then does.
    const bool commanded = random.chance(0.5);
    if (commanded) {
      for (auto& units : way) units += random.integer(-20, 20);
      ASSERT_TRUE(cell.go(way));
    }
    for (int round = 0; round < 3; ++round) {
      const auto cuts = random.integer(1, 2);
      for (std::int64_t i = 0; i < cuts; ++i) dip_in_a_swing(cell, random);
      cell.run_for(600ms);
      cell.settle();
      if (!cell.driver.fault()) (void)cell.driver.wake(cell.now);
      cell.settle();
      expect_rotors_inside(cell);
      if (cell.driver.fault() && random.chance(0.7)) {
        ASSERT_TRUE(cell.driver.clear_fault(cell.now));
      }
    }
    cell.settle();
    cell.run_for(200ms);
    expect_rotors_inside(cell);
    const sim::Truth truth = cell.machine.truth();
    for (std::size_t i = 0; i < kLegs; ++i) {
      const double off = truth.joints[i].q - cell.driver.positions()[i].q;
      const auto units = std::llround(std::abs(off) * test::kIcpUnitsPerM);
      farthest = std::max<std::int64_t>(farthest, units);
      beyond_one_cut += units > 96 ? 1 : 0;
    }
  });
  std::cout << "  farthest " << farthest << " units from the best guess, of "
            << IcpLegClaim::kPowerCutUnits << " for two cuts\n";
  EXPECT_GT(beyond_one_cut, 0) << "the second cut meets rotors in their swing";
}

TEST(IcpDriverFaults, supply_loss_that_one_module_shows_withdraws_all_six) {
  IcpCell cell;
  cell.begin();
  ASSERT_TRUE(cell.go({9, 9, 9, 9, 9, 9}));
  cell.settle();
  ASSERT_FALSE(cell.uncertain());
  // Leg 5 alone: the others have been read in the same round, and are good.
  cell.machine.module(4).set_supply(6, cell.now);
  ASSERT_TRUE(cell.go({10, 10, 10, 10, 10, 10}));
  cell.settle();
  ASSERT_EQ(cell.driver.fault()->code, ErrorCode::kSupplyFlag);
  EXPECT_EQ(cell.driver.fault()->index, 4);
  for (const JointPosition& claim : cell.driver.positions()) {
    EXPECT_EQ(claim.quality, PositionQuality::kUncertain);
    EXPECT_NEAR(claim.upper - claim.lower, (kCutWay + 1) / test::kIcpUnitsPerM, 1e-12);
  }
  // Six good answers: five legs are where they were sent, whatever one module went through.
  cell.machine.module(4).set_supply(12, cell.now);
  for (int i = 0; i < 2 && cell.driver.fault(); ++i) {
    ASSERT_TRUE(cell.driver.clear_fault(cell.now));
    cell.settle();
  }
  ASSERT_FALSE(cell.driver.fault());
  for (std::size_t i = 0; i < kLegs; ++i) {
    const auto due = i == 4 ? PositionQuality::kUncertain : PositionQuality::kCommanded;
    EXPECT_EQ(cell.driver.positions()[i].quality, due) << i;
  }
  expect_rotors_inside(cell);
}

TEST(IcpDriverFaults, status_is_asked_for_only_where_it_may_be_and_not_for_ever) {
  IcpCell cell;
  cell.driver.allow_looks(false);
  cell.run_for(100ms);
  cell.driver.declare_positions(IcpCell::at_home());
  cell.driver.open(cell.now);
  cell.run_for(1s);
  EXPECT_EQ(cell.driver.state(), DriverState::kOpening);
  EXPECT_TRUE(cell.driver.looks());
  EXPECT_EQ(cell.driver.health().requests, 0U);
  cell.driver.allow_looks(true);
  cell.settle();
  ASSERT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_FALSE(cell.driver.looks());

  // A motion's steps need no leave, its statuses do; where that never comes nobody has looked.
  cell.driver.allow_looks(false);
  cell.events.clear();
  ASSERT_TRUE(cell.go({20, 0, 0, -20, 0, 0}));
  cell.run_for(1s);
  EXPECT_EQ(cell.driver.steps_left(), 0);
  EXPECT_TRUE(cell.events.empty());
  EXPECT_TRUE(cell.driver.looks());
  cell.settle();
  ASSERT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kNotRecorded);
  EXPECT_EQ(cell.count(Kind::kFailed), 1U);
  EXPECT_TRUE(cell.uncertain());
  EXPECT_FALSE(cell.driver.looks());
  cell.expect_honest();

  // Once it may, six good answers settle it.
  cell.driver.allow_looks(true);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.settle();
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_FALSE(cell.uncertain());
  cell.expect_honest();
}

TEST(IcpDriverFaults, silence_after_a_stop_ends_it_once_and_says_why) {
  IcpCell cell;
  cell.begin();
  ASSERT_TRUE(cell.go({50, 0, 0, -50, 0, 0}));
  cell.run_for(20ms);
  cell.driver.stop(cell.now);
  cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 3});
  cell.settle();
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  ASSERT_EQ(cell.events.size(), 2U);
  EXPECT_EQ(cell.events[0].kind, Kind::kStopped);
  EXPECT_EQ(cell.events[1].kind, Kind::kNotice);
  EXPECT_EQ(cell.events[1].error.code, ErrorCode::kDeviceSilent);
  expect_rotors_inside(cell);
}

TEST(IcpDriverFaults, close_in_a_motion_or_in_its_statuses_admits_what_nobody_has_looked_at) {
  for (int at = 1; at < 160; ++at) {
    IcpCell cell;
    cell.begin();
    ASSERT_TRUE(cell.go({3, 0, 0, -3, 0, 0}));
    cell.run_for(std::chrono::milliseconds(at));
    const bool ended = cell.count(Kind::kDone) == 1;
    cell.driver.close(cell.now);
    cell.run_for(10ms);
    EXPECT_EQ(cell.uncertain(), !ended && at > 2) << at;
    EXPECT_TRUE(ended || at < 150) << at;
    cell.expect_honest();
  }
}

TEST(IcpDriverFaults, random_faults_never_make_a_position_silently_wrong) {
  // Named in docs/wires/icp.md as what remains: two flips in one byte make another step of it.
  // Here one byte in a hundred is hit, once.
  Tally tally;
  test::for_random_cases(400, [&](test::Random& random) {
    IcpQuirks quirks;
    quirks.processing = random.integer(0, 2) * 5ms;
    IcpCell cell(quirks);
    cell.begin();
    std::uint64_t calm = 0;  // bytes until the next fault may come: one an exchange
    const auto fault = [&](std::uint8_t byte, std::size_t) {
      const bool hit = calm == 0 && random.chance(0.01);
      if (!hit) {
        calm -= calm > 0 ? 1 : 0;
        return IcpLine::Fate{{byte}, {}};
      }
      calm = 40;
      Damage damage;
      const std::int64_t kind = random.integer(0, 4);
      if (kind == 0) damage.flip = static_cast<std::uint8_t>(1U << random.integer(0, 7));
      if (kind == 2) damage.copies = 2;
      if (kind == 3) damage.late = Duration{random.integer(0, 400'000'000)};
      if (kind == 4) damage.flip = 0x10;
      return damaged(damage, byte);
    };
    cell.up.fault = fault;
    cell.down.fault = fault;
    for (int i = 0; i < 8; ++i) {
      std::array<std::int64_t, kLegs> way{};
      for (auto& units : way) units = random.integer(-6, 6);
      const auto gone = cell.go(way);
      if (gone && random.chance(0.2)) {
        cell.run_for(Duration{random.integer(0, 100'000'000)});
        cell.driver.stop(cell.now);
      }
      cell.settle();
      cell.expect_honest();
      if (cell.driver.state() == DriverState::kFault) (void)cell.driver.clear_fault(cell.now);
      cell.settle();
      cell.expect_honest();
    }
    ++tally.runs;
    tally.uncertain += cell.uncertain() ? 1 : 0;
    tally.faults += cell.driver.fault() ? 1 : 0;
  });
  tally.print("random faults");
  EXPECT_GT(tally.uncertain, tally.runs / 2) << "the faults reach the driver";
}

}  // namespace
}  // namespace sinew
