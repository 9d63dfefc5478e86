#include "sinew/program/sequence_samples.h"

#include <gtest/gtest.h>

#include "sinew/program/sequence_test_cell.h"

namespace sinew::sequence {
namespace {

constexpr double kPeriod = 0.01;

TEST(SequenceSamples, joints_never_jump_and_velocity_is_their_slope) {
  Cell cell("G0 B100 S200 E300 WR400 W300\nG1 E1 P40\nG0 B0 S50 E5000 WR1500 W0\nG28\n", arm());
  cell.go_on();
  const auto samples = sample(cell.run.records(), kPeriod);
  ASSERT_GT(samples.size(), 500U);
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const Sample& a = samples[k - 1];
    const Sample& b = samples[k];
    const double dt = b.t - a.t;
    ASSERT_GE(dt, 0) << k;
    ASSERT_LE(dt, kPeriod + 1e-9) << k;
    for (std::size_t i = 0; i < a.q.size(); ++i) {
      // The joint's acceleration bounds how far the slope is from the mean of both ends.
      const double bend = cell.model.joints[i].acceleration_max * 1.01 * dt * dt + 1e-9;
      ASSERT_NEAR(b.q[i] - a.q[i], (a.qd[i] + b.qd[i]) / 2 * dt, bend) << k << " joint " << i;
    }
  }
}

TEST(SequenceSamples, motions_begin_and_end_at_rest_where_the_device_says) {
  Cell cell("G0 B100 S200 E300 WR400 W300\nG0 B0 S50 E5000 WR1500 W0\n", arm());
  cell.go_on();
  const auto records = cell.run.records();
  const auto samples = sample(records, kPeriod);
  EXPECT_EQ(samples.front().t, 0);
  EXPECT_EQ(samples.front().q, BigRobotArmAngles{});
  EXPECT_EQ(samples.front().qd, BigRobotArmAngles{});
  EXPECT_TRUE(samples.front().predicted);
  EXPECT_NEAR(samples.back().t, to_seconds(records.back().done - records.front().asked), 1e-12);
  EXPECT_EQ(samples.back().q, records.back().q_reported);
  EXPECT_EQ(samples.back().qd, BigRobotArmAngles{});
  std::size_t reported = 0;
  for (const Sample& sample : samples) {
    if (sample.predicted) continue;
    EXPECT_EQ(sample.q, records[reported].q_reported);
    ++reported;
  }
  EXPECT_EQ(reported, records.size());
}

TEST(SequenceSamples, host_that_heard_late_of_a_start_does_not_turn_time_back) {
  Cell cell("G0 B1000\nG0 B0\n", arm());
  cell.go_on();
  std::vector<Record> records(cell.run.records().begin(), cell.run.records().end());
  for (Record& record : records) record.started += std::chrono::milliseconds(33);
  const auto samples = sample(records, kPeriod);
  for (std::size_t k = 1; k < samples.size(); ++k) ASSERT_GE(samples[k].t, samples[k - 1].t) << k;
}

TEST(SequenceSamples, orders_without_motion_have_one_sample_and_no_orders_none) {
  EXPECT_TRUE(sample({}, kPeriod).empty());
  Cell cell("G1 E1 P40\nM203 B100\n", arm());
  cell.go_on();
  EXPECT_EQ(sample(cell.run.records(), kPeriod).size(), 2U);
}

}  // namespace
}  // namespace sinew::sequence
