#include "sinew/devices/lsc/lsc_device.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace lsc;
using namespace std::chrono_literals;
using Step = GroupStep;

constexpr std::array kProfiles{LscProfile::kLsc6, LscProfile::kBus, LscProfile::kEsp32};

/// A board at a bench, with the replies that it gave.
struct Bench {
  explicit Bench(LscProfile profile) : board(profile, Instant{}) { drain(); }

  void tell(const Request& request) {
    board.receive(encode(request), now);
    drain();
  }
  void wait(Duration duration) {
    now += duration;
    board.advance(now);
    drain();
  }
  void drain() {
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t count = board.take_output(piece)) {
      for (std::size_t i = 0; i < count; ++i) {
        text += static_cast<char>(piece[i]);
        if (const auto frame = decoder.push(piece[i])) replies.push_back(*decode_reply(*frame));
      }
    }
  }
  /// What came since the last call.
  std::vector<Reply> said() { return std::exchange(replies, {}); }
  double at(std::uint8_t id) const { return board.commanded(id); }

  /// Two actions of half a second on servo 6: to 700 and to 900.
  void store_group(std::uint8_t group) {
    if (esp32) {
      Move all{500, {}};
      for (std::uint8_t id = 1; id <= 6; ++id) all.servos.push_back({id, 700});
      tell(StoreAction{group, 2, 0, all});
      for (ServoValue& servo : all.servos) servo.value = 900;
      tell(StoreAction{group, 2, 1, all});
    } else {
      tell(Step{Step::Kind::kBegin, group, 0, 0, {}});
      tell(Step{Step::Kind::kCount, 2, 0, 0, {}});
      tell(Step{Step::Kind::kBlocks, 1, 0, 0, {}});
      tell(Step{Step::Kind::kAction, 0, 0, 0, {500, {{6, 700}}}});
      tell(Step{Step::Kind::kAction, 0, 0, 1, {500, {{6, 900}}}});
      tell(Step{Step::Kind::kEnd, 0, 0, 0, {}});
    }
  }

  LscBoard board;
  bool esp32 = false;
  Instant now{};
  FrameDecoder decoder;
  std::vector<Reply> replies;
  std::string text;
};

TEST(LscBoard, a_servo_gets_nothing_before_its_first_move_and_goes_evenly_after) {
  Bench bench(LscProfile::kLsc6);
  EXPECT_FALSE(bench.board.command(6).driven);
  bench.tell(Move{1000, {{6, 2000}}});
  EXPECT_TRUE(bench.board.command(6).driven);
  EXPECT_FALSE(bench.board.command(5).driven);
  EXPECT_EQ(bench.at(6), 1500) << "the board's idea of a servo that it never drove";
  bench.wait(250ms);
  EXPECT_NEAR(bench.at(6), 1625, 1e-9);
  EXPECT_TRUE(bench.board.moving());
  bench.wait(800ms);
  EXPECT_EQ(bench.at(6), 2000);
  EXPECT_FALSE(bench.board.moving());
  EXPECT_TRUE(bench.said().empty()) << "a move has no answer";
}

TEST(LscBoard, a_new_target_takes_over_where_the_servo_is) {
  Bench bench(LscProfile::kLsc6);
  bench.tell(Move{1000, {{6, 2500}, {5, 500}}});
  bench.wait(500ms);
  bench.tell(Move{100, {{6, 1500}}});
  EXPECT_NEAR(bench.at(6), 2000, 1e-9);
  bench.wait(50ms);
  EXPECT_NEAR(bench.at(6), 1750, 1e-9);
  EXPECT_NEAR(bench.at(5), 950, 1e-9) << "the other one goes on";
}

TEST(LscBoard, a_bus_servo_starts_where_it_is_and_tells_where_it_is) {
  Bench bench(LscProfile::kBus);
  bench.board.sense_position(6, 321);
  bench.board.sense_position(1, 700.4);
  bench.tell(ReadPositions{{6, 1}});
  EXPECT_EQ(bench.said(), (std::vector<Reply>{Positions{{{6, 321}, {1, 700}}}}));
  bench.tell(Move{1000, {{6, 421}, {5, kLeavePosition}}});
  EXPECT_EQ(bench.at(6), 321);
  EXPECT_FALSE(bench.board.command(5).driven);
  bench.wait(2s);
  EXPECT_EQ(bench.at(6), 421);
  bench.tell(Unload{{6}});
  EXPECT_FALSE(bench.board.command(6).driven);
}

TEST(LscBoard, ranges_are_refused_with_a_beep_or_clamped) {
  Bench classic(LscProfile::kLsc6);
  for (const Request& wrong :
       {Request{Move{100, {{6, 1600}, {5, 2501}}}}, Request{Move{100, {{6, 499}}}},
        Request{Move{100, {{7, 1500}}}}, Request{Move{100, {{0, 1500}}}}}) {
    const auto beeps = classic.board.beeps();
    classic.tell(wrong);
    EXPECT_EQ(classic.board.beeps(), beeps + 1);
    EXPECT_FALSE(classic.board.command(6).driven) << "not even the half that was right";
  }
  Bench bus(LscProfile::kBus);
  bus.tell(Move{100, {{6, 1001}}});
  EXPECT_FALSE(bus.board.command(6).driven);
  Bench esp32(LscProfile::kEsp32);
  esp32.tell(Move{0, {{6, 9999}, {1, 2000}, {9, 1500}}});
  EXPECT_EQ(esp32.at(6), 1500) << "no time is 20 ms there";
  esp32.wait(20ms);
  EXPECT_EQ(esp32.at(6), 2500);
  EXPECT_EQ(esp32.at(1), 1500);
  esp32.tell(Move{60'000, {{6, 500}}});
  esp32.wait(30s);
  EXPECT_EQ(esp32.at(6), 500);
}

TEST(LscBoard, each_board_answers_what_it_knows_and_is_silent_otherwise) {
  const std::vector<Request> questions{ReadVersion{}, ReadOffsets{},      ReadCommanded{},
                                       ReadBattery{}, ReadPositions{{1}}, ReadBusOffsets{{1}},
                                       SaveOffsets{}};
  const std::vector<std::vector<std::uint8_t>> expected{{15}, {15, 21, 23}, {1, 2, 13, 11}};
  for (std::size_t i = 0; i < kProfiles.size(); ++i) {
    Bench bench(kProfiles[i]);
    bench.board.sense_supply(7.5);
    std::vector<std::uint8_t> answers;
    for (const Request& question : questions) {
      bench.tell(question);
      for (const Reply& reply : bench.said()) answers.push_back(encode(reply)[3]);
    }
    EXPECT_EQ(answers, expected[i]);
  }
  Bench bench(LscProfile::kLsc6);
  bench.board.sense_supply(7.5);
  bench.tell(ReadBattery{});
  EXPECT_EQ(bench.said(), (std::vector<Reply>{Battery{7500}}));
}

TEST(LscBoard, a_group_runs_as_often_as_asked_and_says_when_it_starts_and_ends) {
  for (const LscProfile profile : kProfiles) {
    Bench bench(profile);
    bench.esp32 = profile == LscProfile::kEsp32;
    bench.store_group(8);
    EXPECT_EQ(bench.said().size(), bench.esp32 ? 2U : 6U);
    bench.tell(RunGroup{8, 2});
    bench.wait(500ms);
    EXPECT_EQ(bench.at(6), 700);
    bench.wait(250ms);
    EXPECT_EQ(bench.at(6), 800);
    bench.wait(1249ms);
    EXPECT_TRUE(bench.board.groups().running());
    bench.wait(1ms);
    EXPECT_FALSE(bench.board.groups().running());
    EXPECT_EQ(bench.at(6), 900);
    const std::vector<Reply> told{GroupStarted{8, 2}, GroupFinished{8, 2}};
    EXPECT_EQ(bench.said(), bench.esp32 ? std::vector<Reply>{} : told);
  }
}

TEST(LscBoard, a_stop_ends_a_group_for_ever_but_not_the_action_under_way) {
  for (const LscProfile profile : kProfiles) {
    Bench bench(profile);
    bench.esp32 = profile == LscProfile::kEsp32;
    bench.store_group(100);
    (void)bench.said();
    bench.board.press_run(true, bench.now);
    bench.wait(100'250ms);
    EXPECT_TRUE(bench.board.groups().running());
    bench.tell(StopGroup{});
    bench.wait(1s);
    EXPECT_EQ(bench.at(6), 700);
    bench.tell(StopGroup{});
    const std::vector<Reply> told{GroupStarted{100, 0}, GroupStopped{}};
    EXPECT_EQ(bench.said(), bench.esp32 ? std::vector<Reply>{} : told);
  }
}

TEST(LscBoard, speed_scales_a_group_until_power_off) {
  Bench bench(LscProfile::kLsc6);
  bench.store_group(8);
  bench.tell(SetGroupSpeed{kAllGroups, 200});
  bench.tell(RunGroup{8, 1});
  bench.wait(250ms);
  EXPECT_EQ(bench.at(6), 700);
  bench.wait(1s);
  EXPECT_FALSE(bench.board.groups().running());
  bench.board.power_cycle(bench.now);
  EXPECT_FALSE(bench.board.command(6).driven);
  bench.tell(RunGroup{8, 1});
  bench.wait(250ms);
  EXPECT_EQ(bench.at(6), 1100) << "from 1500 to 700 in 500 ms again";
}

TEST(LscBoard, erasing_takes_one_group_or_all_and_on_the_esp32_always_all) {
  for (const LscProfile profile : kProfiles) {
    Bench bench(profile);
    bench.esp32 = profile == LscProfile::kEsp32;
    bench.store_group(1);
    bench.store_group(2);
    (void)bench.said();
    bench.tell(EraseGroup{1});
    EXPECT_EQ(bench.said(), (std::vector<Reply>{GroupErased{}}));
    EXPECT_FALSE(bench.board.groups().has(1));
    EXPECT_EQ(bench.board.groups().has(2), !bench.esp32);
    bench.tell(RunGroup{1, 1});
    EXPECT_TRUE(bench.said().empty()) << "there is none to run";
    bench.tell(EraseGroup{kAllGroups});
    EXPECT_FALSE(bench.board.groups().has(2));
  }
}

TEST(LscBoard, groups_that_do_not_fit_are_refused) {
  LscGroups groups;
  const Move action{100, {{1, 1500}}};
  EXPECT_FALSE(groups.store(231, 0, action));
  EXPECT_FALSE(groups.store(1, 1, action)) << "the first action is missing";
  for (std::size_t i = 0; i < LscGroups::kActions; ++i) EXPECT_TRUE(groups.store(1, i, action));
  EXPECT_FALSE(groups.store(1, LscGroups::kActions, action));
  EXPECT_TRUE(groups.store(1, 0, action));
  EXPECT_FALSE(groups.store(1, 2, action)) << "the group began anew";
  for (std::size_t i = 2; i <= LscGroups::kGroups; ++i) {
    EXPECT_TRUE(groups.store(static_cast<std::uint8_t>(i), 0, action));
  }
  EXPECT_FALSE(groups.store(99, 0, action));
}

TEST(LscBoard, offsets_move_the_servo_not_the_report_and_stay_when_saved) {
  Bench bench(LscProfile::kEsp32);
  bench.tell(Move{20, {{3, 1500}}});
  bench.wait(1s);
  bench.tell(SetOffset{{3, -50}});
  EXPECT_EQ(bench.board.command(3).units, 1450);
  bench.tell(ReadCommanded{});
  EXPECT_EQ(std::get<Commanded>(bench.said().at(0)).servos[2], (ServoValue{3, 1500}));
  bench.tell(SetOffset{{3, 126}});
  EXPECT_EQ(bench.board.command(3).units, 1450) << "beyond 125 it is refused";
  bench.board.power_cycle(bench.now);
  EXPECT_EQ(bench.board.command(3).units, 1500);
  bench.tell(SetOffset{{3, 20}});
  bench.tell(SaveOffsets{});
  bench.board.power_cycle(bench.now);
  EXPECT_EQ(bench.board.command(3).units, 1520);
}

TEST(LscBoard, bus_offsets_are_set_read_and_stored) {
  Bench bench(LscProfile::kBus);
  bench.tell(AdjustBusOffset{2, -10, true});
  bench.tell(AdjustBusOffset{3, 12, false});
  bench.tell(AdjustBusOffset{3, 300, true});
  bench.tell(StoreBusOffsets{{2}});
  bench.tell(ReadBusOffsets{{2, 3}});
  EXPECT_EQ(bench.said(), (std::vector<Reply>{BusOffsets{{{2, -10}, {3, 12}}}}));
  bench.board.power_cycle(bench.now);
  bench.tell(ReadBusOffsets{{2, 3}});
  EXPECT_EQ(bench.said(), (std::vector<Reply>{BusOffsets{{{2, -10}, {3, 0}}}}));
}

TEST(LscBoard, esp32_speaks_text_at_boot_and_goes_home_when_told) {
  Bench bench(LscProfile::kEsp32);
  EXPECT_EQ(bench.text, "pwm servo\r\nbegin\r\n");
  bench.tell(Move{20, {{6, 2000}}});
  bench.wait(1s);
  bench.tell(GoHome{});
  bench.wait(1s);
  EXPECT_EQ(bench.at(6), 1500);
}

TEST(LscBoard, low_supply_beeps_once_a_second) {
  Bench bench(LscProfile::kLsc6);
  bench.board.sense_supply(4.9);
  for (int i = 0; i < 35; ++i) bench.wait(100ms);
  EXPECT_EQ(bench.board.beeps(), 4U);
}

TEST(LscBoard, any_bytes_leave_servos_inside_their_range) {
  test::for_random_cases(3000, [](test::Random& random) {
    const auto profile = kProfiles[static_cast<std::size_t>(random.integer(0, 2))];
    Bench bench(profile);
    for (int i = 0; i < 30; ++i) {
      Move move{static_cast<std::uint16_t>(random.integer(0, 300)), {}};
      const auto id = static_cast<std::uint8_t>(random.integer(1, 6));
      move.servos.push_back({id, static_cast<std::uint16_t>(random.integer(0, 3000))});
      Bytes bytes = encode(Request{move});
      const auto last = static_cast<std::int64_t>(bytes.size()) - 1;
      bytes[static_cast<std::size_t>(random.integer(0, last))] ^=
          static_cast<std::uint8_t>(random.integer(0, 255));
      bench.board.receive(bytes, bench.now);
      bench.wait(std::chrono::milliseconds(random.integer(0, 100)));
    }
    for (std::uint8_t id = 1; id <= 6; ++id) {
      if (!bench.board.command(id).driven) continue;
      const bool bus = profile == LscProfile::kBus;
      EXPECT_GE(bench.at(id), bus ? 0 : 500);
      // A PWM servo's pulses start at 1500, the ESP32's jaws end there.
      EXPECT_LE(bench.at(id), bus ? 1000 : 2500);
    }
  });
}

TEST(LscBoard, it_does_not_allocate) {
  LscBoard board(LscProfile::kLsc6, Instant{});
  const Bytes move = encode(Request{Move{100, {{6, 1700}}}});
  const Bytes battery = encode(Request{ReadBattery{}});
  const Bytes begin = encode(Request{Step{Step::Kind::kBegin, 8, 0, 0, {}}});
  const Bytes action = encode(Request{Step{Step::Kind::kAction, 0, 0, 0, {500, {{6, 700}}}}});
  const Bytes run = encode(Request{RunGroup{8, 0}});
  std::array<std::uint8_t, 64> piece{};
  const test::AllocationCounter allocations;
  for (const Bytes* bytes : {&move, &battery, &begin, &action, &run}) {
    board.receive(*bytes, Instant{});
    (void)board.take_output(piece);
  }
  board.advance(Instant{} + 10s);
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_TRUE(board.groups().running());
}

}  // namespace
}  // namespace sinew
