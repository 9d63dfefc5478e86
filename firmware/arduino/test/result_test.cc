#include <gtest/gtest.h>
#include <maxarm_result.h>

#include <string>

namespace sinew {
namespace {

class Text : public Print {
 public:
  size_t write(uint8_t byte) override {
    text += static_cast<char>(byte);
    return 1;
  }
  std::string text;
};

std::string printed(const MaxArmResult& result) {
  Text out;
  const size_t count = result.printTo(out);
  EXPECT_EQ(count, out.text.size());
  return out.text;
}

TEST(ArduinoResult, is_true_where_nothing_went_wrong) {
  EXPECT_TRUE(MaxArmResult());
  EXPECT_FALSE(MaxArmResult(MaxArmError::kNoReply));
}

TEST(ArduinoResult, each_error_is_a_sentence_with_numbers) {
  using E = MaxArmError;
  EXPECT_EQ(printed(MaxArmResult()), "done");
  EXPECT_EQ(printed(MaxArmResult(E::kNotANumber)), "not a number");
  EXPECT_EQ(printed(MaxArmResult(E::kTimeRange, 5, 20)), "time 5 ms, limit 20 ms");
  EXPECT_EQ(printed(MaxArmResult(E::kServoRange, 90, 119, 3)),
            "servo 3 at 90.0 deg, limit 119.0 deg");
  EXPECT_EQ(printed(MaxArmResult(E::kPulseRange, 0, 1, 2)), "servo 2 pulse 0, limit 1");
  EXPECT_EQ(printed(MaxArmResult(E::kNozzleRange, -5, 0)), "nozzle at -5.0 deg, limit 0.0 deg");
  EXPECT_EQ(printed(MaxArmResult(E::kSuctionRange, 4, 3)), "suction function 4, limit 3");
  EXPECT_EQ(printed(MaxArmResult(E::kOutOfReach, 375.4F, 266.4F)),
            "out of reach: shoulder axis to wrist 375.4 mm, limit 266.4 mm");
  EXPECT_EQ(printed(MaxArmResult(E::kTooClose, 40, 50)),
            "too close to the base axis: 40.0 mm, limit 50.0 mm");
  EXPECT_EQ(printed(MaxArmResult(E::kJointLimit, -17.06F, 0, 3)),
            "forearm would need -17.1 deg, limit 0.0 deg");
  EXPECT_EQ(printed(MaxArmResult(E::kJointLimit, 255, 240, 1)),
            "base would need 255.0 deg, limit 240.0 deg");
  EXPECT_EQ(printed(MaxArmResult(E::kJointLimit, 211, 210, 2)),
            "shoulder would need 211.0 deg, limit 210.0 deg");
  EXPECT_EQ(printed(MaxArmResult(E::kWriteFailed, 3, 13)), "bytes written 3, limit 13");
  EXPECT_EQ(printed(MaxArmResult(E::kNoReply)),
            "no reply: check wiring, power and the slave program of the arm");
  EXPECT_EQ(printed(MaxArmResult(E::kBadReply)), "no valid reply: check GND, levels and 9600 baud");
  EXPECT_EQ(printed(MaxArmResult(E::kServoFault, -1, 0, 2)), "servo 2 reported -1, limit 0");
  EXPECT_EQ(printed(MaxArmResult(E::kMissedTarget, 130, 168, 1)),
            "servo 1 at 130.0 deg, target 168.0 deg");
}

}  // namespace
}  // namespace sinew
