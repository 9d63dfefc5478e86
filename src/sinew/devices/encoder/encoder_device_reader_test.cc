#include "sinew/devices/encoder/encoder_device_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/encoder/encoder_machine.h"
#include "support/property.h"

namespace sinew {
namespace {

using std::chrono::milliseconds;

/// A reader with a control cycle of 4 ms, and a node on its line.
class Line {
 public:
  explicit Line(double speed = 0) : speed_(speed) {}

  /// One cycle. @return  a position that arrived
  std::optional<EncoderReader::Position> cycle() {
    for (int i = 0; i < 4; ++i) {
      now_ += milliseconds(1);
      chip_.turn_to(angle_at(now_), 1e-3);
      node_.advance(now_);
    }
    reader_.receive(arriving_, now_);
    arriving_.clear();
    const auto position = reader_.take_position();
    if (const auto request = reader_.poll(now_)) {
      ++requests_;
      if (connected_ && !(no_status_ && (*request)[1] == 4)) node_.receive(*request, now_);
      std::array<std::uint8_t, 20> bytes{};
      const std::size_t size = node_.take_output(bytes);
      arriving_.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    }
    return position;
  }
  double angle_at(Instant now) const { return 1 + speed_ * to_seconds(now.time_since_epoch()); }
  double ticks_at(Instant now) const { return angle_at(now) / (2 * kPi) * 4096; }

  Instant now_{};
  double speed_;
  sim::As5600 chip_{1, 3};
  sim::As5600Bus bus_{chip_};
  sim::EncoderBoard node_{bus_, Instant{}};
  EncoderReader reader_;
  std::vector<std::uint8_t> arriving_;
  bool connected_ = true;
  bool no_status_ = false;  ///< it knows only the document's registers
  int requests_ = 0;
};

TEST(EncoderReader, has_a_position_nearly_each_cycle_and_knows_when_it_was_asked) {
  Line line(1.0);
  for (int i = 0; i < 10; ++i) line.cycle();
  EXPECT_EQ(line.reader_.magnet(), Magnet::kGood);
  int positions = 0;
  for (int i = 0; i < 250; ++i) {
    const auto position = line.cycle();
    if (!position) continue;
    ++positions;
    EXPECT_NEAR(position->ticks, line.ticks_at(position->asked_at), 3);
    EXPECT_EQ(line.now_ - position->asked_at, milliseconds(4));
  }
  // The others asked for STATUS.
  EXPECT_NEAR(positions, 240, 1);
}

TEST(EncoderReader, a_lost_reply_costs_a_few_cycles_and_no_wrong_position) {
  test::for_random_cases(200, [](test::Random& random) {
    Line line(random.uniform(-3, 3));
    for (int i = 0; i < 10; ++i) line.cycle();
    int since = 0;
    for (int i = 0; i < 200; ++i) {
      const bool lost = since == 0 && random.chance(0.2);
      // Bytes of a reply that are lost, from the front or the back.
      if (lost && !line.arriving_.empty()) {
        const bool front = random.chance(0.5);
        const auto many = random.integer(1, 5);
        front ? line.arriving_.erase(line.arriving_.begin(), line.arriving_.begin() + many)
              : line.arriving_.erase(line.arriving_.end() - many, line.arriving_.end());
      }
      const auto position = line.cycle();
      since = position ? 0 : since + 1;
      ASSERT_LE(since, 5);
      if (!position) continue;
      ASSERT_NEAR(std::remainder(position->ticks - line.ticks_at(position->asked_at), 4096), 0, 5);
    }
  });
}

TEST(EncoderReader, knows_why_there_is_no_position) {
  Line line;
  for (int i = 0; i < 10; ++i) line.cycle();
  line.chip_.set_field(0.4);
  for (int i = 0; i < 60; ++i) line.cycle();
  EXPECT_EQ(line.reader_.magnet(), Magnet::kTooWeak);
  line.chip_.set_field(3);
  for (int i = 0; i < 60; ++i) line.cycle();
  EXPECT_EQ(line.reader_.magnet(), Magnet::kTooStrong);
  line.chip_.set_field(0);
  for (int i = 0; i < 10; ++i) line.cycle();
  EXPECT_EQ(line.reader_.magnet(), Magnet::kMissing);
  EXPECT_FALSE(line.cycle());
  line.bus_.set_stuck(true);
  for (int i = 0; i < 10; ++i) line.cycle();
  EXPECT_EQ(line.reader_.magnet(), Magnet::kNoReply);
  line.bus_.set_stuck(false);
  line.chip_.set_field(1);
  for (int i = 0; i < 20; ++i) line.cycle();
  EXPECT_EQ(line.reader_.magnet(), Magnet::kGood);
  EXPECT_TRUE(line.cycle());
}

TEST(EncoderReader, an_unplugged_node_is_no_reply_and_is_asked_again) {
  Line line;
  for (int i = 0; i < 10; ++i) line.cycle();
  line.connected_ = false;
  line.cycle();  // the reply that was on its way
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(line.cycle());
  EXPECT_EQ(line.reader_.magnet(), Magnet::kNoReply);
  EXPECT_GT(line.requests_, 12);
  line.connected_ = true;
  for (int i = 0; i < 5; ++i) line.cycle();
  EXPECT_EQ(line.reader_.magnet(), Magnet::kGood);
}

TEST(EncoderReader, a_node_without_status_serves_too) {
  Line line;
  line.no_status_ = true;
  int positions = 0;
  for (int i = 0; i < 250; ++i) positions += line.cycle() ? 1 : 0;
  EXPECT_GT(positions, 210);
  EXPECT_EQ(line.reader_.magnet(), Magnet::kUnknown);
}

TEST(EncoderReader, a_line_that_is_never_quiet_is_no_reply) {
  Line line;
  for (int i = 0; i < 30; ++i) line.cycle();
  for (int i = 0; i < 60; ++i) {
    line.arriving_.assign(10, 0x33);
    EXPECT_FALSE(line.cycle());
  }
  EXPECT_EQ(line.reader_.magnet(), Magnet::kNoReply);
  for (int i = 0; i < 10; ++i) line.cycle();
  EXPECT_EQ(line.reader_.magnet(), Magnet::kGood);
}

}  // namespace
}  // namespace sinew
