#include "sinew/devices/axis/axis_device_setup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "sinew/devices/axis/axis_device_controller.h"
#include "sinew/devices/axis/axis_device_setup_model.h"
#include "sinew/wire/crc32c.h"
#include "sinew/wire/little_words.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew {
namespace {

/// Two places, and a supply that fails in the middle of an operation.
class FakeMemory : public SetupMemory {
 public:
  FakeMemory() {
    for (auto& place : places_) place.assign(1024, 0xFF);
  }
  std::span<const std::uint8_t> place(int which) const override { return places_[which]; }
  bool erase(int which) override {
    auto& bytes = places_[which];
    const std::size_t size = fails() ? bytes.size() / 2 : bytes.size();
    std::fill_n(bytes.begin(), size, 0xFF);
    return !off_;
  }
  bool append(int which, std::span<const std::uint8_t> bytes) override {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (fails()) return false;
      places_[which][i] = bytes[i];
    }
    return true;
  }
  /// At that operation, counted from now; a byte is one.
  void fail_at(int operation) { left_ = operation, off_ = false; }

 private:
  bool fails() {
    off_ = off_ || left_-- == 0;
    return off_;
  }
  std::vector<std::uint8_t> places_[2];
  int left_ = -1;
  bool off_ = false;
};

void write(SetupStore& store, const SetupBytes& bytes) {
  for (std::size_t i = 0; i < kSetupWords; ++i) {
    ASSERT_TRUE(store.set_word(i, little_word(bytes, i)));
  }
}

void seal(SetupBytes& bytes) {
  const std::uint32_t sum = crc32c(std::span(bytes).first<kSetupSize - 4>());
  for (std::size_t k = 0; k < 4; ++k) {
    bytes[kSetupSize - 4 + k] = static_cast<std::uint8_t>(sum >> 8 * k);
  }
}

TEST(AxisSetup, comes_back_from_its_bytes_for_every_joint_of_every_board) {
  for (const char* id : {"robot-arm-2", "ar4-axis-link"}) {
    const RobotModel& model = test::robot(id);
    for (std::size_t i = 0; i < model.joints.size(); ++i) {
      SCOPED_TRACE(id + std::to_string(i));
      const AxisSetup setup = axis_setup(model, i);
      const SetupBytes bytes = encode_setup(setup);
      const auto back = decode_setup(bytes);
      ASSERT_TRUE(back);
      EXPECT_EQ(encode_setup(*back), bytes);
      EXPECT_EQ(back->axis_number, i);
      EXPECT_EQ(back->axis.upper, setup.axis.upper);
      EXPECT_EQ(back->axis.position_tolerance, setup.axis.position_tolerance);
      EXPECT_EQ(back->registers.zero, setup.registers.zero);
    }
  }
}

TEST(AxisSetup, no_bytes_make_one_that_an_axis_cannot_work_with) {
  const SetupBytes good = encode_setup(axis_setup(test::robot("robot-arm-2"), 0));
  SetupBytes bytes = good;
  bytes[100] ^= 1;
  EXPECT_FALSE(decode_setup(bytes));  // the sum
  bytes = good;
  ++bytes[0];
  seal(bytes);
  EXPECT_FALSE(decode_setup(bytes));  // the version
  int taken = 0;
  test::for_random_cases(20'000, [&](test::Random& random) {
    SetupBytes wild = good;
    for (std::int64_t n = random.integer(1, 12); n > 0; --n) {
      wild[static_cast<std::size_t>(random.integer(1, kSetupSize - 5))] =
          static_cast<std::uint8_t>(random.bits());
    }
    seal(wild);
    const auto setup = decode_setup(wild);
    ASSERT_TRUE(!setup || setup->axis.lower < setup->axis.upper);
    if (!setup) return;
    ++taken;
    // Its assertions hold, and a tick later too.
    AxisController controller(setup->axis);
    static_cast<void>(controller.tick({}, Instant{}));
    static_cast<void>(controller.tick({}, Instant{} + std::chrono::milliseconds(4)));
  });
  EXPECT_GT(taken, 100);
}

TEST(SetupStore, a_power_cut_at_any_byte_leaves_the_old_setup_or_the_new_one) {
  AxisSetup old = axis_setup(test::robot("robot-arm-2"), 0);
  FakeMemory memory;
  {
    SetupStore store(memory);
    EXPECT_FALSE(store.setup());
    EXPECT_FALSE(store.store());
    write(store, encode_setup(old));
    ASSERT_TRUE(store.store());
  }
  AxisSetup fresh = old;
  fresh.axis.upper -= 0.1;
  constexpr int kOperations = 1 + static_cast<int>(kSetupSize) + 8;
  for (int cut = 0; cut <= kOperations; ++cut) {
    SetupStore store(memory);
    write(store, encode_setup(fresh));
    memory.fail_at(cut);
    EXPECT_EQ(store.store(), cut == kOperations);
    memory.fail_at(-1);
    const SetupStore after(memory);
    ASSERT_TRUE(after.setup()) << cut;
    ASSERT_EQ(after.setup()->axis.upper, cut == kOperations ? fresh.axis.upper : old.axis.upper)
        << cut;
  }
  // And again: the place of the older one is taken each time.
  for (int i = 0; i < 5; ++i) {
    SetupStore store(memory);
    fresh.axis.upper -= 0.01;
    write(store, encode_setup(fresh));
    ASSERT_TRUE(store.store());
    ASSERT_EQ(SetupStore(memory).setup()->axis.upper, fresh.axis.upper);
  }
}

TEST(SetupStore, words_beyond_the_setup_are_none) {
  FakeMemory memory;
  SetupStore store(memory);
  EXPECT_EQ(store.word(0), 0xFFFF'FFFF);
  EXPECT_FALSE(store.word(kSetupWords));
  EXPECT_FALSE(store.set_word(kSetupWords, 0));
}

}  // namespace
}  // namespace sinew
