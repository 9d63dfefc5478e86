#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <optional>

#include "motion/random_sequence.h"
#include "support/how_many.h"

namespace sinew::planning {
namespace {

/// Sequences that are run with the same plans: planning costs more than following.
constexpr std::uint64_t kBatch = 64;

/// Of all robots together: SINEW_SEQUENCES where it is set.
std::uint64_t sequences_wanted() {
  return test::how_many("SINEW_SEQUENCES", 6000);
}

/// SINEW_SEQUENCE_CASE: that one only.
std::optional<std::uint64_t> only_case() {
  return test::number_of("SINEW_SEQUENCE_CASE");
}

std::uint64_t mixed(std::uint64_t first, std::uint64_t second) {
  return SplitMix64(first ^ (second * 0xD1342543DE82EF95ULL)).bits();
}

/// The random sequences of one robot, each by its number: whatever ran before it.
class Campaign {
 public:
  explicit Campaign(std::string_view robot) : bench_(robot), seed_(test::seed()) {
    for (const char letter : robot) seed_ = mixed(seed_, static_cast<unsigned char>(letter));
  }

  std::string run(std::uint64_t number, MotionSums& sums) {
    const std::uint64_t batch = number / kBatch;
    if (batch != batch_) {
      test::Random random(mixed(~seed_, batch));
      const std::string wrong = bench_.deal_plans(random, sums);
      if (!wrong.empty()) return wrong;
      batch_ = batch;
    }
    RandomSequence sequence(bench_, mixed(seed_, number), sums);
    std::string wrong = sequence.run();
    digest_ = sequence.digest();
    return wrong;
  }
  std::uint64_t digest() const { return digest_; }

 private:
  MotionBench bench_;
  std::uint64_t seed_;
  std::optional<std::uint64_t> batch_;
  std::uint64_t digest_ = 0;
};

class Sequences : public testing::TestWithParam<const char*> {
 public:
  static void TearDownTestSuite() { std::cout << "  " << all_.text() << '\n'; }

 protected:
  static inline MotionSums all_;
};
INSTANTIATE_TEST_SUITE_P(Robots, Sequences, testing::ValuesIn(kJogRobots), jog_robot_name);

TEST_P(Sequences, of_plan_jog_override_pause_and_stop_keep_every_limit_in_every_sample) {
  Campaign campaign(GetParam());
  MotionSums sums;
  const std::uint64_t wanted = (sequences_wanted() + kJogRobots.size() - 1) / kJogRobots.size();
  const std::uint64_t first = only_case().value_or(0);
  const std::uint64_t last = only_case() ? first + 1 : wanted;
  for (std::uint64_t k = first; k < last; ++k) {
    const std::string wrong = campaign.run(k, sums);
    if (wrong.empty()) continue;
    ADD_FAILURE() << wrong << "\nreplay with SINEW_SEED=" << test::seed()
                  << " SINEW_SEQUENCE_CASE=" << k;
    break;
  }
  RecordProperty("cases", std::to_string(sums.sequences));
  std::cout << "  seed " << test::seed() << ", " << sums.text() << '\n';
  all_.add(sums);
}

/// What a failure says it can be replayed with is all that a sequence is made of.
TEST_P(Sequences, one_of_them_alone_is_the_same_as_in_its_row) {
  MotionSums sums;
  Campaign row(GetParam());
  for (std::uint64_t k = 0; k < kBatch + 3; ++k) row.run(k, sums);
  Campaign alone(GetParam());
  alone.run(kBatch + 2, sums);
  EXPECT_NE(alone.digest(), 0U);
  EXPECT_EQ(alone.digest(), row.digest());
}

}  // namespace
}  // namespace sinew::planning
