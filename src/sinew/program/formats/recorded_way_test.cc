#include "sinew/program/formats/recorded_way.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/program_plan.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

using test::for_random_cases;
using test::Random;

const RobotModel& learm() {
  return test::robot("learm");
}

JointVector middle() {
  JointVector q;
  for (const double deg : {0, 20, 40, 40, 0}) q.push_back(from_deg(deg));
  return q;
}

/// A wandering arm: three bends, a stand of 2 s after the first third, 50 samples a second.
std::vector<WaySample> wandering(Random& random) {
  std::vector<WaySample> way;
  JointVector q = middle();
  double t = 0;
  for (int part = 0; part < 3; ++part) {
    JointVector to = middle();
    for (double& one : to) one += random.uniform(-0.25, 0.25);
    const double time = random.uniform(1.5, 3);
    const double bend = random.uniform(-0.1, 0.1);
    const int steps = static_cast<int>(time * 50);
    for (int k = 1; k <= steps; ++k) {
      const double u = static_cast<double>(k) / steps;
      const double smooth = u * u * (3 - 2 * u);
      JointVector here = q;
      for (std::size_t j = 0; j < here.size(); ++j) here[j] += smooth * (to[j] - q[j]);
      here[1] += bend * std::sin(3.14159 * smooth);
      way.push_back({t += 0.02, here});
    }
    q = way.back().q;
    for (int k = 0; part == 0 && k < 100; ++k) way.push_back({t += 0.02, q});
  }
  return way;
}

/// The worst joint between two places, rad.
double apart(const JointVector& a, const JointVector& b) {
  double worst = 0;
  for (std::size_t j = 0; j < a.size(); ++j) worst = std::max(worst, std::abs(a[j] - b[j]));
  return worst;
}

/// Places of the plan, every 10 ms.
std::vector<JointVector> places_of(const Plan& plan) {
  RowPlanner planner(learm());
  std::vector<JointVector> places;
  for (const Order& order : plan.orders) {
    const auto* move = std::get_if<MoveOrder>(&order.what);
    if (move == nullptr) continue;
    if (!planner.plan(*move->q_start, move->tool, move->rows)) return {};
    const auto& motion = planner.motion();
    planning::JointMotion now;
    for (double t = 0; t < motion.law.duration(); t += 0.01) {
      motion.trajectory().sample(t, now);
      JointVector q;
      for (std::size_t j = 0; j < learm().joints.size(); ++j) q.push_back(now.q[j]);
      places.push_back(q);
    }
    places.push_back(move->q);
  }
  return places;
}

double nearest(const JointVector& q, std::span<const JointVector> places) {
  double best = std::numeric_limits<double>::infinity();
  for (const JointVector& place : places) best = std::min(best, apart(q, place));
  return best;
}

TEST(RecordedWay, is_gone_again_within_its_tolerance_and_about_its_time) {
  for_random_cases(40, [](Random& random) {
    const auto way = wandering(random);
    const std::string rows = rows_of_way(way, learm()).text;
    const auto program = parse(rows, "way", learm());
    ASSERT_TRUE(program) << rows;
    const auto plan = make_plan(*program, learm(), way.front().q);
    ASSERT_TRUE(plan) << describe(plan.error().error) << rows;
    const auto places = places_of(*plan);
    ASSERT_FALSE(places.empty());
    std::vector<JointVector> recorded;
    for (const WaySample& sample : way) recorded.push_back(sample.q);
    // Samples of either are up to this far from the next one: half of it may lie between them.
    const double grain = 0.006;
    for (const JointVector& q : recorded) EXPECT_LE(nearest(q, places), 0.01 + grain) << rows;
    for (const JointVector& q : places) EXPECT_LE(nearest(q, recorded), 0.01 + grain) << rows;
    const double time = way.back().t - way.front().t;
    EXPECT_GT(plan->duration, 0.6 * time) << rows;
    EXPECT_LT(plan->duration, 1.6 * time) << rows;
    EXPECT_NE(rows.find("wait "), std::string::npos) << "it stood for 2 s";
    EXPECT_LT(std::ranges::count(rows, '\n'), 60) << "corners only";
  });
}

TEST(RecordedWay, an_arm_that_stood_still_has_no_rows_whatever_its_sensors_say) {
  Random random(5);
  std::vector<WaySample> way;
  for (int k = 0; k < 500; ++k) {
    JointVector q = middle();
    for (double& one : q) one += random.uniform(-0.4, 0.4) * kWayStill;
    way.push_back({0.02 * k, q});
  }
  EXPECT_EQ(rows_of_way(way, learm()).text, "");
  EXPECT_EQ(rows_of_way({}, learm()).text, "");
  EXPECT_EQ(rows_of_way(std::span(way).first(1), learm()).text, "");
}

TEST(RecordedWay, a_place_outside_the_limits_is_moved_to_them) {
  std::vector<WaySample> way;
  for (int k = 0; k <= 50; ++k) {
    JointVector q = middle();
    q[0] = learm().joints[0].upper + 0.005 - 0.02 * (50 - k);
    way.push_back({0.02 * k, q});
  }
  const auto [rows, outside, outside_max] = rows_of_way(way, learm());
  EXPECT_EQ(outside, 1U) << rows;
  EXPECT_NEAR(outside_max, 0.005, 1e-12);
  ASSERT_TRUE(parse(rows, "way", learm())) << rows;
  EXPECT_TRUE(make_plan(*parse(rows, "way", learm()), learm(), middle())) << rows;
}

TEST(RecordedWay, legs_are_written_as_lengths) {
  const RobotModel& robot = test::robot("hexapod");
  std::vector<WaySample> way;
  for (int k = 0; k <= 50; ++k) {
    JointVector q = home_joints(robot);
    for (double& one : q) one += 1e-5 * k;
    way.push_back({10.0 * k, q});
  }
  const std::string rows = rows_of_way(way, robot).text;
  EXPECT_NE(rows.find("mm"), std::string::npos) << rows;
  EXPECT_TRUE(parse(rows, "way", robot)) << rows;
}

}  // namespace
}  // namespace sinew::program
