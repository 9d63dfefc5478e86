#include "sinew/devices/axis/axis_device_spi.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "sinew/devices/axis/axis_device_test_fake.h"
#include "support/property.h"

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Wire = AxisSpiSlave::Wire;

AxisLinkNodeSettings link_settings() {
  return {.model = {.axis = 3,
                    .lower = -1,
                    .upper = 1,
                    .velocity_max = 1,
                    .acceleration_max = 1,
                    .jerk_max = 1}};
}

struct Bench {
  /// A transfer as a board's DMA has it: what goes out was laid in before.
  Bytes exchange(const Bytes& mosi) {
    Bytes miso(mosi.size());
    slave.next_answer(miso);
    slave.transfer(mosi);
    return miso;
  }

  test::FakeAxis axis;
  AxisSpiSlave slave{axis, link_settings(), {}};
};

/// The header of a WRITE to MOVE_ANGLE with everything before it.
std::vector<Bytes> opening(std::uint16_t id) {
  using namespace axis_registers;
  const HeaderBytes header =
      encode_header({1, id, static_cast<std::uint8_t>(Operation::kWrite), 1, 4});
  return {{kSyn}, {0xFF}, {kAck}, Bytes(header.begin(), header.end()), {0xFF}};
}

TEST(AxisSpiSlave, the_first_good_frame_decides_which_wire_it_speaks) {
  Bench link;
  const axis_link::Frame frame = axis_link::encode(
      axis_link::Request{.axis = 3, .mode = axis_link::Mode::kRead, .sequence = 1});
  axis_link::Frame damaged = frame;
  damaged[5] ^= 1;
  link.exchange(Bytes(damaged.begin(), damaged.end()));
  EXPECT_EQ(link.slave.wire(), Wire::kUndecided);
  link.exchange(Bytes(frame.begin(), frame.end()));
  EXPECT_EQ(link.slave.wire(), Wire::kLink);
  // From now on a whole transaction of the other one is noise.
  for (const Bytes& bytes : opening(1)) link.exchange(bytes);
  EXPECT_EQ(link.slave.wire(), Wire::kLink);

  Bench registers;
  const auto transfers = opening(1);
  for (std::size_t i = 0; i < transfers.size(); ++i) {
    EXPECT_EQ(registers.slave.wire(), Wire::kUndecided) << i;
    registers.exchange(transfers[i]);
  }
  EXPECT_EQ(registers.slave.wire(), Wire::kRegisters);
  registers.exchange(Bytes(frame.begin(), frame.end()));
  EXPECT_EQ(registers.slave.wire(), Wire::kRegisters);
}

TEST(AxisSpiSlave, a_frame_for_another_axis_decides_nothing) {
  Bench bench;
  const axis_link::Frame frame = axis_link::encode(
      axis_link::Request{.axis = 2, .mode = axis_link::Mode::kRead, .sequence = 1});
  bench.exchange(Bytes(frame.begin(), frame.end()));
  EXPECT_EQ(bench.slave.wire(), Wire::kUndecided);
}

TEST(AxisSpiSlave, speaks_registers_byte_for_byte_as_a_board_that_shifts_them) {
  test::for_random_cases(300, [](test::Random& random) {
    Bench bench;
    test::FakeAxis axis;
    AxisRegisterSlave plain({}, AxisRegisterProfile::kDocument, axis);
    bool decided = false;
    std::uint16_t id = 0;
    for (int turn = 0; turn < 6; ++turn) {
      std::vector<Bytes> transfers = opening(++id);
      Bytes data(8);
      for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random.bits());
      transfers.push_back(data);
      transfers.push_back({0, 0, 0, 0});
      for (Bytes& mosi : transfers) {
        // A host may break off, or go on for too long.
        if (random.chance(0.05)) mosi.resize(static_cast<std::size_t>(random.integer(0, 16)));
        Bytes expected(mosi.size());
        plain.exchange(mosi, expected);
        const Bytes got = bench.exchange(mosi);
        if (decided) {
          ASSERT_EQ(got, expected);
        }
        decided = decided || bench.slave.wire() == Wire::kRegisters;
      }
    }
    ASSERT_TRUE(decided);
  });
}

}  // namespace
}  // namespace sinew
