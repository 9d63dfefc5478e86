#include "sinew/control/lease.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "support/property.h"

namespace sinew::control {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart = Instant{} + 1h;

TEST(Lease, one_has_it_and_the_others_are_told_who) {
  Lease lease;
  const auto mine = lease.take(1, kStart);
  ASSERT_TRUE(mine);
  EXPECT_TRUE(lease.check(*mine, kStart + 999ms));
  const auto theirs = lease.take(2, kStart + 500ms);
  ASSERT_FALSE(theirs);
  EXPECT_EQ(theirs.error(), (Error{ErrorCode::kLeaseHeld, -1, 1}));
}

TEST(Lease, it_ends_after_a_second_unless_it_is_renewed) {
  Lease lease;
  const LeaseToken mine = *lease.take(1, kStart);
  EXPECT_TRUE(lease.renew(mine, kStart + 900ms));
  EXPECT_TRUE(lease.check(mine, kStart + 1800ms));
  EXPECT_FALSE(lease.check(mine, kStart + 1900ms));
  EXPECT_FALSE(lease.renew(mine, kStart + 2s)) << "what has ended is not brought back";
  EXPECT_FALSE(lease.holder(kStart + 2s));
}

TEST(Lease, same_client_keeps_its_token_while_it_has_it_and_gets_a_new_one_later) {
  Lease lease;
  const LeaseToken first = *lease.take(1, kStart);
  EXPECT_EQ(*lease.take(1, kStart + 500ms), first);
  const LeaseToken later = *lease.take(1, kStart + 5s);
  EXPECT_GT(later.epoch, first.epoch);
  EXPECT_FALSE(lease.check(first, kStart + 5s)) << "a command that was under way for 5 s";
}

TEST(Lease, taken_over_it_is_lost_at_once_and_giving_back_the_old_one_changes_nothing) {
  Lease lease;
  const LeaseToken mine = *lease.take(1, kStart);
  const LeaseToken theirs = lease.take_over(2, kStart + 1ms);
  EXPECT_EQ(lease.check(mine, kStart + 1ms).error().code, ErrorCode::kLeaseLost);
  lease.give_back(mine);
  EXPECT_TRUE(lease.check(theirs, kStart + 2ms));
  lease.give_back(theirs);
  EXPECT_FALSE(lease.check(theirs, kStart + 2ms));
}

TEST(Lease, token_that_nobody_gave_is_none) {
  Lease lease;
  EXPECT_FALSE(lease.check({}, kStart));
  const LeaseToken mine = *lease.take(0, kStart);
  EXPECT_FALSE(lease.check({}, kStart));
  EXPECT_FALSE(lease.check({0, mine.epoch + 1}, kStart));
}

TEST(Lease, never_two_have_it_and_epochs_only_rise) {
  test::for_random_cases(2000, [](test::Random& random) {
    Lease lease;
    Instant now = kStart;
    std::vector<LeaseToken> tokens;
    std::uint64_t epoch = 0;
    for (int i = 0; i < 60; ++i) {
      now += std::chrono::milliseconds(random.integer(0, 600));
      const auto client = static_cast<ClientId>(random.integer(0, 3));
      const double dice = random.uniform(0, 1);
      if (dice < 0.5) {
        if (const auto token = lease.take(client, now)) tokens.push_back(*token);
      } else if (dice < 0.6) {
        tokens.push_back(lease.take_over(client, now));
      } else if (!tokens.empty()) {
        const LeaseToken& token = tokens[static_cast<std::size_t>(
            random.integer(0, static_cast<int>(tokens.size()) - 1))];
        if (dice < 0.9) {
          (void)lease.renew(token, now);
        } else {
          lease.give_back(token);
        }
      }
      int valid = 0;
      LeaseToken last;
      for (const LeaseToken& token : tokens) {
        if (token == last || !lease.check(token, now)) continue;
        last = token;
        ++valid;
        ASSERT_GE(token.epoch, epoch);
        epoch = token.epoch;
      }
      ASSERT_LE(valid, 1);
    }
  });
}

}  // namespace
}  // namespace sinew::control
