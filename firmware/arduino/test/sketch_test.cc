#include <gtest/gtest.h>

#include <iostream>

#include "sinew/core/units.h"
#include "sinew/devices/maxarm/maxarm_wire.h"
#include "sketch_bench.h"
#include "support/golden.h"

/// The examples as they would be flashed, on an emulated chip with a simulated arm.
namespace sinew::arduino {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kRamLeft = 1000;  // of the 2048 bytes of an Uno
constexpr double kMm = 3;               // cut pulses and the arm's weight

/// RAM that neither variables nor stack ever used.
void expect_free_ram(const SketchBench& bench, const char* sketch) {
  EXPECT_GE(bench.board.untouched_ram(), kRamLeft);
  std::cout << "  " << sketch << ": " << bench.board.untouched_ram()
            << " bytes of RAM never used\n";
}

void expect_at(const SketchBench& bench, double x, double y, double z) {
  const auto point = bench.point_mm();
  EXPECT_NEAR(point[0], x, kMm);
  EXPECT_NEAR(point[1], y, kMm);
  EXPECT_NEAR(point[2], z, kMm);
}

TEST(Sketch, move_goes_where_it_sends_the_arm_and_prints_refusals) {
  SketchBench bench("Move-uno");
  ASSERT_TRUE(bench.run_until_printed("angles: done", 1s));
  bench.run_for(1400ms);
  EXPECT_NEAR(bench.pulse(0), 500, 1);
  EXPECT_NEAR(bench.pulse(1), 417, 4);
  EXPECT_NEAR(bench.pulse(2), 500, 4);
  ASSERT_TRUE(bench.run_until_printed("right: done", 1s));
  bench.run_for(1400ms);
  expect_at(bench, 120, -180, 85);
  ASSERT_TRUE(bench.run_until_printed("left: done", 1s));
  bench.run_for(2s);
  expect_at(bench, -120, -180, 85.5);
  EXPECT_EQ(bench.lines(),
            (std::vector<std::string>{"angles: done", "right: done", "left: done",
                                      "too high: forearm would need -17.1 deg, limit 0.0 deg",
                                      "too fast: time 5 ms, limit 20 ms"}));
  EXPECT_EQ(bench.machine.firmware().requests_taken(), 3U);
  expect_free_ram(bench, "Move");
}

TEST(Sketch, pins_carry_9600_baud_and_the_documents_frame) {
  SketchBench bench("Nozzle-uno");
  ASSERT_TRUE(bench.run_until_printed("done", 1s));
  bench.run_for(10ms);
  EXPECT_EQ(bench.sent, test::from_hex("AA 55 05 04 DC 05 E8 03 2A"));
  EXPECT_EQ(bench.pins()->framing_errors(), 0U);
  EXPECT_LT(bench.pins()->edge_error_max(), 0.1) << "bits";
  std::cout << "  edges of SoftwareSerial beside their time: " << bench.pins()->edge_error_max()
            << " bits at most\n";
}

TEST(Sketch, nozzle_turns_to_each_angle) {
  SketchBench bench("Nozzle-uno");
  const std::array<std::pair<const char*, double>, 3> turns{
      {{"90.00 deg: done", 90}, {"45.00 deg: done", 45}, {"135.00 deg: done", 135}}};
  for (const auto& [text, deg] : turns) {
    ASSERT_TRUE(bench.run_until_printed(text, 2s));
    bench.run_for(1200ms);
    EXPECT_NEAR(bench.machine.truth().tool, from_deg(deg), 0.002);
  }
  ASSERT_TRUE(bench.run_until_printed("-5.00 deg: nozzle at -5.0 deg, limit 0.0 deg", 2s));
  EXPECT_EQ(bench.machine.firmware().requests_taken(), 3U);
  EXPECT_EQ(bench.machine.firmware().restarts(), 0U);
}

TEST(Sketch, read_back_reads_both_programs_with_both_checksums) {
  for (const auto variant : {MaxArmVariant::kArduino, MaxArmVariant::kMicroPython}) {
    for (const auto checksum : {MaxArmChecksum::kSpec, MaxArmChecksum::kWithHeader}) {
      SketchBench bench("ReadBack-uno", variant, checksum);
      ASSERT_TRUE(bench.run_until_printed("checksum ", 6s));
      bench.run_for(100ms);
      expect_at(bench, 0, -200, 120);
      const auto lines = bench.lines();
      ASSERT_GE(lines.size(), 5U);
      EXPECT_EQ(lines[0], "done");
      EXPECT_EQ(lines[1], "done") << "at_target";
      const auto xyz = bench.numbers_behind("xyz mm");
      const auto point = bench.point_mm();
      ASSERT_EQ(xyz.size(), 3U);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(xyz[i], point[i], 2);
      const auto servos = bench.numbers_behind("servos deg");
      ASSERT_EQ(servos.size(), 3U);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(servos[i], bench.pulse(i) * 0.24, 0.25);
      EXPECT_EQ(lines[4],
                checksum == MaxArmChecksum::kSpec ? "checksum spec" : "checksum with header");
      expect_free_ram(bench, "ReadBack");
    }
  }
}

TEST(Sketch, read_back_without_an_arm_reports_it_and_recovers) {
  SketchBench bench("ReadBack-uno");
  bench.connected = false;
  ASSERT_TRUE(bench.run_until_printed("checksum unknown", 20s));
  const auto lines = bench.lines();
  const std::string help = "no reply: check wiring, power and the slave program of the arm";
  EXPECT_EQ(lines, (std::vector<std::string>{"done", help, help, "checksum unknown"}));
  bench.connected = true;
  ASSERT_TRUE(bench.run_until_printed("checksum spec", 20s)) << "the arm was connected meanwhile";
}

TEST(Sketch, pick_and_place_carries_an_object) {
  SketchBench bench("PickAndPlace-uno");
  ASSERT_TRUE(bench.run_until_printed("picked", 10s));
  expect_at(bench, 100, -160, 60);
  bench.machine.disturb({sim::Disturbance::Kind::kPayload, -1, 0.05});
  EXPECT_EQ(bench.machine.carried(), 0.05);
  ASSERT_TRUE(bench.run_until_printed("placed", 10s));
  expect_at(bench, -100, -160, 60);
  EXPECT_EQ(bench.machine.carried(), 0) << "released";
  ASSERT_TRUE(bench.run_until_printed("done", 5s));
  expect_at(bench, -100, -160, 120);
  EXPECT_FALSE(bench.machine.truth().suction);
  EXPECT_EQ(bench.lines(), (std::vector<std::string>{"picked", "placed", "done"}));
  expect_free_ram(bench, "PickAndPlace");
}

TEST(Sketch, pick_and_place_ends_where_the_arm_is_blocked) {
  SketchBench bench("PickAndPlace-uno");
  bench.machine.disturb({sim::Disturbance::Kind::kBlock, 0, from_deg(110)});
  ASSERT_TRUE(bench.run_until_printed("failed", 10s));
  const auto lines = bench.lines();
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0], "servo 1 at 109.9 deg, target 88.1 deg");
  EXPECT_FALSE(bench.machine.truth().suction);
}

TEST(Sketch, halt_stops_a_swing_by_button) {
  SketchBench bench("Halt-uno");
  bench.board.set_pin('D', 2, true);
  ASSERT_TRUE(bench.run_until_printed("done", 1s));
  bench.run_for(2s);
  EXPECT_TRUE(bench.machine.truth().moving);
  bench.board.set_pin('D', 2, false);
  const Duration pressed = bench.board.now();
  ASSERT_TRUE(bench.run_until_printed("halt: done", 1s));
  EXPECT_LE(bench.board.now() - pressed, 400ms);
  bench.run_for(500ms);
  const double at = bench.pulse(0);
  EXPECT_GT(at, 315) << "the target was 312";
  EXPECT_LT(at, 480);
  EXPECT_FALSE(bench.machine.truth().moving);
  bench.run_for(5s);
  EXPECT_NEAR(bench.pulse(0), at, 0.5);
}

TEST(Sketch, sketch_for_the_makers_library_runs_unchanged) {
  SketchBench bench("DocumentSketch-uno", MaxArmVariant::kMicroPython, MaxArmChecksum::kWithHeader);
  ASSERT_TRUE(bench.run_until_printed("xyz", 20s));
  bench.run_for(20ms);
  const auto xyz = bench.numbers_behind("xyz");
  ASSERT_EQ(xyz.size(), 3U);
  EXPECT_NEAR(xyz[0], -120, kMm);
  EXPECT_NEAR(xyz[1], -180, kMm);
  EXPECT_NEAR(xyz[2], 85, kMm);
  expect_at(bench, -120, -180, 85);
  const auto angles = bench.numbers_behind("angles");
  ASSERT_EQ(angles.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(angles[i], bench.pulse(i) * 0.24, 0.8);
  EXPECT_NEAR(bench.machine.truth().tool, from_deg(135), 0.002);
  EXPECT_EQ(bench.machine.firmware().suction(), 3);
  expect_free_ram(bench, "DocumentSketch");
}

TEST(Sketch, mega_drives_the_arm_at_its_second_port) {
  for (const auto variant : {MaxArmVariant::kArduino, MaxArmVariant::kMicroPython}) {
    SketchBench bench("Mega-mega", variant);
    ASSERT_TRUE(bench.run_until_printed("xyz mm", 5s));
    bench.run_for(20ms);
    expect_at(bench, 0, -200, 120);
    const auto lines = bench.lines();
    EXPECT_EQ(lines[0], "done");
    EXPECT_EQ(lines[1], "done");
    const auto xyz = bench.numbers_behind("xyz mm");
    ASSERT_EQ(xyz.size(), 3U);
    EXPECT_NEAR(xyz[1], -200, kMm);
    EXPECT_NEAR(xyz[2], 120, kMm);
  }
}

}  // namespace
}  // namespace sinew::arduino
