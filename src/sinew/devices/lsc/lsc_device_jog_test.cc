#include "sinew/devices/lsc/lsc_device_jog.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/devices/lsc/lsc_device.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/kinematics/serial_chain.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;

/// The table of learm.toml with the lengths of the ESP32's firmware: an independent way to its
/// tips.
kinematics::SerialChain firmware_chain() {
  SerialGeometry geometry;
  geometry.rows = {{Esp32Links::kBase / 1000, 0, -kPi / 2, 0},
                   {0, Esp32Links::kUpper / 1000, 0, -kPi / 2},
                   {0, Esp32Links::kFore / 1000, 0, 0},
                   {0, 0, -kPi / 2, -kPi / 2},
                   {Esp32Links::kHand / 1000, 0, 0, kPi}};
  return kinematics::SerialChain(geometry);
}

Vec3 tips_mm(const JogPulses& pulses) {
  constexpr JogPulses kSigns{1, 1, -1, -1};
  std::array<double, 5> q{};
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    q[i] = kSigns[i] * (pulses[i] - 1500) * kPi / 2000;
  }
  return 1000 * firmware_chain().forward(q).p;
}

TEST(LscJog, the_tips_go_by_as_much_as_was_asked) {
  int moved = 0;
  test::for_random_cases(2000, [&](test::Random& random) {
    JogPulses now{};
    for (double& pulse : now) pulse = random.uniform(700, 2300);
    const auto mm = [&] { return static_cast<std::int8_t>(random.integer(-30, 30)); };
    const lsc::Jog by{mm(), mm(), mm()};
    const auto target = jogged(now, by);
    if (!target) return random.discard();
    const Vec3 before = tips_mm(now);
    // The firmware turns the base to the tips; behind the axis it would turn around.
    if (std::hypot(before.x, before.y) < 1) return random.discard();
    const Vec3 after = tips_mm(*target);
    EXPECT_NEAR(after.x - before.x, by.dx_mm, 1e-6);
    EXPECT_NEAR(after.y - before.y, by.dy_mm, 1e-6);
    EXPECT_NEAR(after.z - before.z, by.dz_mm, 1e-6);
    for (const double pulse : *target) {
      EXPECT_GE(pulse, 500 - 1e-3);
      EXPECT_LE(pulse, 2500 + 1e-3);
    }
    ++moved;
  });
  EXPECT_GT(moved, 500);
}

/// The pose that the ESP32's firmware starts from, as it has been published: x 150 mm, z 20 mm.
constexpr std::array<lsc::ServoValue, 4> kRest{{{6, 1500}, {5, 1255}, {4, 511}, {3, 644}}};

LscBoard resting_board() {
  LscBoard board(LscProfile::kEsp32, Instant{});
  lsc::Move rest{20, {}};
  for (const lsc::ServoValue& servo : kRest) rest.servos.push_back(servo);
  board.receive(lsc::encode(lsc::Request{rest}), Instant{});
  board.advance(Instant{} + 1s);
  return board;
}

JogPulses pulses_of(const LscBoard& board) {
  JogPulses pulses{};
  for (std::size_t i = 0; i < pulses.size(); ++i) pulses[i] = board.commanded(kJogServos[i]);
  return pulses;
}

TEST(LscJog, the_board_moves_evenly_says_nothing_and_leaves_roll_and_jaws) {
  LscBoard board = resting_board();
  const Vec3 before = tips_mm(pulses_of(board));
  std::array<std::uint8_t, 64> piece{};
  (void)board.take_output(piece);
  board.receive(lsc::encode(lsc::Request{lsc::Jog{-10, 20, 15}}), Instant{} + 1s);
  EXPECT_EQ(board.take_output(piece), 0U);
  EXPECT_TRUE(board.moving());
  EXPECT_FALSE(board.command(2).driven);
  EXPECT_FALSE(board.command(1).driven);
  board.advance(Instant{} + 3s);
  const Vec3 after = tips_mm(pulses_of(board));
  EXPECT_NEAR(after.x - before.x, -10, 0.5) << "half a pulse on four servos";
  EXPECT_NEAR(after.y - before.y, 20, 0.5);
  EXPECT_NEAR(after.z - before.z, 15, 0.5);
  EXPECT_EQ(board.beeps(), 0U);
}

TEST(LscJog, a_point_out_of_reach_beeps_and_moves_nothing) {
  LscBoard board = resting_board();
  Instant now = Instant{} + 1s;
  while (board.beeps() == 0 && now < Instant{} + 60s) {
    board.receive(lsc::encode(lsc::Request{lsc::Jog{100, 0, 0}}), now);
    now += 2s;
    board.advance(now);
  }
  EXPECT_EQ(board.beeps(), 1U);
  EXPECT_FALSE(board.moving());
  const JogPulses before = pulses_of(board);
  board.receive(lsc::encode(lsc::Request{lsc::Jog{100, 0, 0}}), now);
  board.advance(now + 2s);
  EXPECT_EQ(pulses_of(board), before);
}

}  // namespace
}  // namespace sinew
