#include "sinew/devices/axis/axis_machine_bus.h"

#include <gtest/gtest.h>

#include <deque>
#include <vector>

#include "sinew/devices/axis/axis_device_test_fake.h"
#include "sinew/devices/axis_registers/axis_registers_device.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "support/allocation_guard.h"

namespace sinew::sim {
namespace {

/// Says its name while it is clocked and remembers what it heard.
class Parrot : public SpiSlave {
 public:
  explicit Parrot(std::uint8_t name) : name_(name) {}
  void select(bool selected) override { edges.push_back(selected); }
  std::uint8_t shift(std::uint8_t mosi) override {
    heard.push_back(mosi);
    return name_;
  }

  std::vector<std::uint8_t> heard;
  std::vector<bool> edges;

 private:
  std::uint8_t name_;
};

class ParrotBus : public testing::Test {
 protected:
  void build(SelectKind kind, bool own_buses = false) {
    parrots_ = {Parrot(0xC1), Parrot(0xC2), Parrot(0xC4), Parrot(0xC2)};
    for (std::size_t i = 0; i < parrots_.size(); ++i) {
      bus_.attach(parrots_[i], kind, static_cast<std::uint8_t>(own_buses ? i : 0));
    }
  }
  std::uint8_t say(std::uint8_t select, std::uint8_t mosi) {
    bus_.select(select);
    const std::uint8_t miso = bus_.shift(mosi);
    bus_.select(0);
    return miso;
  }

  std::vector<Parrot> parrots_;
  AxisBus bus_;
};

TEST_F(ParrotBus, only_the_selected_board_hears_and_speaks) {
  build(SelectKind::kHard);
  EXPECT_EQ(say(0b0010, 0x11), 0xC2);
  EXPECT_EQ(parrots_[1].heard, std::vector<std::uint8_t>{0x11});
  EXPECT_EQ(parrots_[1].edges, (std::vector<bool>{true, false}));
  for (const std::size_t other : {0U, 2U, 3U}) {
    EXPECT_TRUE(parrots_[other].heard.empty());
    EXPECT_TRUE(parrots_[other].edges.empty());
  }
  EXPECT_EQ(bus_.contended_bytes(), 0U);
}

TEST_F(ParrotBus, without_a_select_nobody_speaks) {
  build(SelectKind::kHard);
  EXPECT_EQ(say(0, 0x11), AxisBus::kIdle);
}

TEST_F(ParrotBus, broadcast_reaches_all_and_only_different_answers_collide) {
  build(SelectKind::kHard);
  EXPECT_EQ(say(0b1010, 0x22), 0xC2);  // two that say the same
  EXPECT_EQ(bus_.contended_bytes(), 0U);
  EXPECT_EQ(say(0b1111, 0x33), 0xC0);
  EXPECT_EQ(bus_.contended_bytes(), 1U);
  for (const Parrot& parrot : parrots_) EXPECT_EQ(parrot.heard.back(), 0x33);
}

TEST_F(ParrotBus, soft_select_lets_everybody_hear_and_speak_at_once) {
  build(SelectKind::kSoft);
  EXPECT_EQ(say(0b0001, 0x44), 0xC0);
  EXPECT_EQ(bus_.contended_bytes(), 1U);
  for (const Parrot& parrot : parrots_) EXPECT_EQ(parrot.heard, std::vector<std::uint8_t>{0x44});
  EXPECT_EQ(parrots_[0].edges.size(), 2U);
  EXPECT_TRUE(parrots_[1].edges.empty());
}

TEST_F(ParrotBus, soft_select_on_buses_of_their_own_harms_nobody) {
  build(SelectKind::kSoft, true);
  EXPECT_EQ(say(0b0100, 0x55), 0xC4);
  EXPECT_EQ(bus_.contended_bytes(), 0U);
  EXPECT_TRUE(parrots_[0].heard.empty());
}

TEST_F(ParrotBus, wrong_chip_select_reaches_the_wrong_board) {
  build(SelectKind::kHard);
  bus_.wire_select(0, 0b0100);
  EXPECT_EQ(say(0b0001, 0x66), 0xC4);
  EXPECT_TRUE(parrots_[0].heard.empty());
  bus_.wire_select(0, 0b0101);  // a short between two of them
  EXPECT_EQ(say(0b0001, 0x77), 0xC0);
  EXPECT_EQ(bus_.contended_bytes(), 1U);
}

TEST_F(ParrotBus, clocks_without_a_select_reach_boards_with_soft_selects_only) {
  build(SelectKind::kSoft);
  bus_.shift(0x5A);
  for (const Parrot& parrot : parrots_) EXPECT_EQ(parrot.heard, std::vector<std::uint8_t>{0x5A});
}

TEST_F(ParrotBus, select_that_stays_makes_no_edge) {
  build(SelectKind::kHard);
  bus_.select(0b0011);
  bus_.select(0b0010);
  EXPECT_EQ(parrots_[0].edges, (std::vector<bool>{true, false}));
  EXPECT_EQ(parrots_[1].edges, std::vector<bool>{true});
}

TEST_F(ParrotBus, board_without_supply_is_not_there) {
  build(SelectKind::kHard);
  bus_.set_powered(1, false);
  EXPECT_EQ(say(0b0010, 0x11), AxisBus::kIdle);
  EXPECT_TRUE(parrots_[1].heard.empty());
  bus_.set_powered(1, true);
  EXPECT_EQ(say(0b0010, 0x11), 0xC2);
}

/// Six register boards on one bus, as robot-arm-2 has them.
class RegisterBoard : public SpiSlave {
 public:
  RegisterBoard(const AxisRegistersDevice& device, std::size_t joint)
      : slave_(axis_register_slave_settings(device, joint), AxisRegisterProfile::kAsBuilt, axis_) {}
  void select(bool selected) override { slave_.select(selected); }
  std::uint8_t shift(std::uint8_t mosi) override { return slave_.shift(mosi); }
  const AxisRegisterSlave& slave() const { return slave_; }

 private:
  test::FakeAxis axis_;
  AxisRegisterSlave slave_;
};

struct SixBoards {
  explicit SixBoards(SelectKind kind) {
    device.boards.resize(6);
    for (std::size_t i = 0; i < 6; ++i) boards.emplace_back(device, i);
    for (RegisterBoard& board : boards) bus.attach(board, kind, 0);
  }
  std::vector<std::uint8_t> frame(std::uint8_t select, const std::vector<std::uint8_t>& mosi) {
    std::vector<std::uint8_t> miso;
    miso.reserve(mosi.size());
    bus.select(select);
    for (const std::uint8_t byte : mosi) miso.push_back(bus.shift(byte));
    bus.select(0);
    return miso;
  }
  /// WRITE of 1 to EMERGENCY_STOP, frame id 5: a vector of the document.
  bool emergency_stop(std::uint8_t select) {
    frame(select, {0x97});
    if (frame(select, {0xFF}).at(0) != 0x98) return false;
    frame(select, {0x99});
    frame(select, {0x55, 0x01, 0, 0x05, 0x02, 0, 0x04, 0, 0x01, 0x78, 0xC8, 0x0B, 0xBC, 0xAA});
    if (frame(select, {0xFF}).at(0) != 0x00) return false;
    frame(select, {0x01, 0xC3, 0xC5, 0xC0, 0xCC});
    return frame(select, {0, 0, 0, 0}) == std::vector<std::uint8_t>{0x55, 0x9A, 0x00, 0xAA};
  }
  int stopped() const {
    int count = 0;
    for (const RegisterBoard& board : boards) {
      const auto value = board.slave().register_value(axis_registers::Register::kEmergencyStop);
      count += !value.empty() && value.back() == 1 ? 1 : 0;
    }
    return count;
  }

  AxisRegistersDevice device;
  std::deque<RegisterBoard> boards;
  AxisBus bus;
};

TEST(AxisBus, broadcast_emergency_stop_sets_six_of_six_without_a_contended_byte) {
  for (const SelectKind kind : {SelectKind::kHard, SelectKind::kSoft}) {
    SixBoards six(kind);
    EXPECT_TRUE(six.emergency_stop(0b11'1111));
    EXPECT_EQ(six.stopped(), 6);
    EXPECT_EQ(six.bus.contended_bytes(), 0U);
  }
}

TEST(AxisBus, boards_with_soft_selects_collide_when_only_one_is_meant) {
  SixBoards hard(SelectKind::kHard);
  EXPECT_TRUE(hard.emergency_stop(0b00'0001));
  EXPECT_EQ(hard.stopped(), 1);
  EXPECT_EQ(hard.bus.contended_bytes(), 0U);

  // The five others hold MISO at their last byte, 00, so the host never sees SYN_ACK.
  SixBoards soft(SelectKind::kSoft);
  EXPECT_FALSE(soft.emergency_stop(0b00'0001));
  EXPECT_EQ(soft.stopped(), 0);
  EXPECT_GT(soft.bus.contended_bytes(), 0U);
}

TEST(AxisBus, never_allocates) {
  SixBoards six(SelectKind::kHard);
  const test::AllocationCounter allocations;
  for (int i = 0; i < 1000; ++i) {
    six.bus.select(static_cast<std::uint8_t>(1 << (i % 6)));
    six.bus.shift(static_cast<std::uint8_t>(i));
    six.bus.select(0);
  }
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::sim
