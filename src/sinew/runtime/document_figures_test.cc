#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/device/lsc_jog.h"
#include "sinew/driver/icp_test_cell.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/wire/axis_registers.h"
#include "sinew/wire/spi.h"
#include "support/robots.h"

// Numbers that the robots' documents work out, against what our models make of the same question.

namespace sinew {
namespace {

using namespace std::chrono_literals;

TEST(DocumentFigures, learm_at_rest_has_the_servos_where_its_makers_firmware_puts_them) {
  // The built-in arm with the firmware's lengths: x 150 mm, z 20 mm above its turntable, the hand
  // 53 deg below the horizon.
  RobotModel model = test::robot("learm");
  auto& geometry = std::get<SerialGeometry>(model.geometry);
  geometry.rows[0].d = from_mm(Esp32Links::kBase);
  geometry.rows[1].a = from_mm(Esp32Links::kUpper);
  geometry.rows[2].a = from_mm(Esp32Links::kFore);
  geometry.rows[4].d = from_mm(Esp32Links::kHand);
  geometry.gripper.reset();
  const kinematics::SerialArm arm(geometry, model.joints, kinematics::tool_pose(geometry));
  const auto branches = arm.inverse_at_pitch({from_mm(150), 0, from_mm(20)}, from_deg(90 + 53));
  ASSERT_TRUE(branches);
  ASSERT_TRUE((*branches)[0].within_limits);
  const auto& servos = std::get<LscDevice>(model.device.settings).servos;
  const auto pulse = [&](std::size_t i) {
    return servos[i].centre + servos[i].trim + servos[i].units_per_rad * (*branches)[0].q[i];
  };
  EXPECT_NEAR(pulse(0), 1500, 1e-6);
  // The chain's own figures, to the microsecond, and the firmware's table within one degree.
  const std::array<std::array<double, 2>, 3> told{{{1261, 1255}, {522, 511}, {651, 644}}};
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_NEAR(pulse(i + 1), told[i][0], 0.6) << i;
    EXPECT_NEAR(pulse(i + 1), told[i][1], 11.5) << i;
  }
}

/// How far the nozzle strays from the straight line while the three servos go evenly: from the line
/// itself, and from where an even motion on it would be; mm.
std::array<double, 2> bow(const Vec3& from, const Vec3& to) {
  const RobotModel& model = test::robot("maxarm");
  const auto& geometry = std::get<PalletizerGeometry>(model.geometry);
  const Vec3 a = 1e-3 * from;
  const Vec3 b = 1e-3 * to;
  const auto start = kinematics::inverse(geometry, model.joints, a);
  const auto end = kinematics::inverse(geometry, model.joints, b);
  EXPECT_TRUE(start && end);
  std::array<double, 2> worst{};
  for (int k = 0; k <= 1000; ++k) {
    const double share = k / 1000.0;
    JointVector q = *start;
    // Pulses are a straight function of the angles, so even in the one is even in the other.
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += share * ((*end)[i] - (*start)[i]);
    const Vec3 p = kinematics::forward(geometry, {q.data(), q.size()}).p - a;
    const Vec3 line = b - a;
    const double along = dot(p, line) / dot(line, line);
    worst[0] = std::max(worst[0], 1e3 * norm(p - along * line));
    worst[1] = std::max(worst[1], 1e3 * norm(p - share * line));
  }
  return worst;
}

TEST(DocumentFigures, maxarm_bows_by_as_much_as_was_measured_where_nobody_gives_it_waypoints) {
  EXPECT_NEAR(bow({120, -180, 85}, {-120, -180, 85})[0], 36.3, 0.05);
  const auto out = bow({0, -160, 100}, {0, -250, 100});
  EXPECT_NEAR(out[0], 2.4, 0.05);
  EXPECT_NEAR(out[1], 5.6, 0.05);
}

/// s that driver and simulated controller take for so many units of one leg.
double seconds_for(std::int64_t units, Duration processing) {
  IcpQuirks quirks;
  quirks.processing = processing;
  test::IcpCell cell(quirks);
  cell.begin();
  const Instant start = cell.now;
  EXPECT_TRUE(cell.go({units, 0, 0, 0, 0, 0}));
  cell.settle();
  EXPECT_EQ(cell.truth(0), units);
  return to_seconds(cell.now - start);
}

/// Of one unit on the way: what a motion costs once, status and sync, does not count.
double seconds_per_unit(Duration processing) {
  return (seconds_for(1200, processing) - seconds_for(200, processing)) / 1000;
}

TEST(DocumentFigures, hexapod_takes_the_hours_that_its_document_tells) {
  struct Row {
    Duration processing;
    double millimetre_s, stroke_h, six_strokes_h;
  };
  // The document rounds to three digits.
  for (const Row& row :
       {Row{0ms, 19.0, 47.6 / 60, 4.76}, Row{5ms, 41.9, 1.75, 10.5}, Row{10ms, 64.8, 2.70, 16.2}}) {
    const double unit_s = seconds_per_unit(row.processing);
    const double per_mm = test::kIcpUnitsPerM / 1000;
    EXPECT_NEAR(unit_s * per_mm, row.millimetre_s, 0.005 * row.millimetre_s);
    EXPECT_NEAR(unit_s * per_mm * 150 / 3600, row.stroke_h, 0.005 * row.stroke_h);
    EXPECT_NEAR(unit_s * per_mm * 900 / 3600, row.six_strokes_h, 0.005 * row.six_strokes_h);
  }
  EXPECT_NEAR(1 / seconds_per_unit(0ms), 240, 1.2) << "moves a second, as the wire carries";
}

/// One transaction of the register protocol: seven transfers, each with its select and its pause.
double transaction_s(std::size_t size, bool last_pause = true) {
  using namespace axis_registers;
  Duration time{};
  const std::array<std::size_t, 7> sizes{1, 1, 1, kHeaderSize, 1, size + kCrcSize, kCommitSize};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    spi::Transfer transfer;
    transfer.clock_hz = 500'000;
    transfer.mosi.resize(sizes[i]);
    time += kSelectSetup + spi::wire_time(transfer);
    if (i == 4) time += kValidationPause;
    if (i != 4 && (last_pause || i + 1 < sizes.size())) time += kStepPause;
  }
  return to_seconds(time);
}

TEST(DocumentFigures, register_transactions_cost_what_the_document_adds_up) {
  EXPECT_NEAR(transaction_s(1), 81.832e-3, 1e-9);
  EXPECT_NEAR(transaction_s(4), 81.880e-3, 1e-9);
  EXPECT_NEAR(transaction_s(4, false), 71.88e-3, 1e-9);
  struct Row {
    double transactions, one_hz, six_hz;
  };
  for (const Row& row : {Row{1, 12.21, 2.035}, Row{2, 6.11, 1.018}, Row{3, 4.07, 0.678}}) {
    const double time = row.transactions * transaction_s(4);
    EXPECT_NEAR(1 / time, row.one_hz, 0.006);
    EXPECT_NEAR(1 / (6 * time), row.six_hz, 0.0006);
  }
  EXPECT_NEAR(6 * transaction_s(4), 0.4913, 5e-5) << "an emergency stop to six, one by one";
}

TEST(DocumentFigures, one_frame_a_cycle_reaches_the_rates_of_the_documents_table) {
  struct Row {
    std::size_t bytes;
    int overhead_us;
    std::array<std::array<int, 3>, 3> at;  ///< us, Hz of six in a row, Hz of six at once
  };
  constexpr std::array<std::uint32_t, 3> kClocks{500'000, 4'000'000, 18'000'000};
  const std::array rows{Row{12, 200, {{{392, 425, 2551}, {224, 744, 4464}, {205, 812, 4870}}}},
                        Row{12, 50, {{{242, 689, 4132}, {74, 2252, 13514}, {55, 3012, 18072}}}},
                        Row{16, 200, {{{456, 365, 2193}, {232, 718, 4310}, {207, 805, 4828}}}},
                        Row{16, 50, {{{306, 545, 3268}, {82, 2032, 12195}, {57, 2918, 17510}}}},
                        Row{24, 50, {{{434, 384, 2304}, {98, 1701, 10204}, {61, 2747, 16484}}}}};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < kClocks.size(); ++i) {
      spi::Transfer transfer;
      transfer.clock_hz = kClocks[i];
      transfer.setup = std::chrono::microseconds(row.overhead_us);
      transfer.mosi.resize(row.bytes);
      const double time = to_seconds(transfer.setup + spi::wire_time(transfer));
      EXPECT_NEAR(time * 1e6, row.at[i][0], 0.5) << row.bytes << " at " << kClocks[i];
      EXPECT_NEAR(1 / (6 * time), row.at[i][1], 0.6) << row.bytes << " at " << kClocks[i];
      EXPECT_NEAR(1 / time, row.at[i][2], 1) << row.bytes << " at " << kClocks[i];
    }
  }
}

}  // namespace
}  // namespace sinew
