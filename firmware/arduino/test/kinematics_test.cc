#include <gtest/gtest.h>
#include <maxarm_kinematics.h>

#include <array>
#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/maxarm/maxarm_test_model.h"
#include "sinew/kinematics/palletizer.h"
#include "support/property.h"

namespace sinew {
namespace {

using Three = std::array<float, 3>;

struct Vector {
  Three xyz_mm;
  Three joints_deg;
  Three pulses;
  std::array<std::int16_t, 3> cut;
  Three cut_xyz_mm;  ///< where the cut pulses are
};

const std::vector<Vector> kVectors{{{0, -163, 212},
                                    {120, 90.0278F, 0.3321F},
                                    {500, 499.884F, 501.384F},
                                    {500, 499, 501},
                                    {0, -163.477F, 212.221F}},
                                   {{120, -180, 85},
                                    {86.3099F, 133.7099F, 41.9294F},
                                    {359.625F, 317.875F, 674.706F},
                                    {359, 317, 674},
                                    {120.811F, -180.194F, 84.978F}},
                                   {{-120, -180, 85},
                                    {153.6901F, 133.7099F, 41.9294F},
                                    {640.375F, 317.875F, 674.706F},
                                    {640, 317, 674},
                                    {-120.056F, -180.698F, 84.978F}},
                                   {{0, -280, 75},
                                    {120, 164.8336F, 18.1520F},
                                    {500, 188.193F, 575.634F},
                                    {500, 188, 575},
                                    {0, -280.141F, 75.248F}},
                                   {{160, 0, 200},
                                    {30, 88.9526F, 5.3131F},
                                    {125, 504.364F, 522.138F},
                                    {125, 504, 522},
                                    {160.203F, 0, 200.083F}},
                                   {{150, -35, 90},
                                    {43.134F, 112.7352F, 54.8414F},
                                    {179.725F, 405.270F, 728.506F},
                                    {179, 405, 728},
                                    {150.469F, -34.628F, 90.112F}},
                                   {{0, -200, 120},
                                    {120, 118.2898F, 34.1481F},
                                    {500, 382.126F, 642.284F},
                                    {500, 382, 642},
                                    {0, -200.152F, 120.104F}}};

MaxArmResult inverse(const Three& xyz_mm, Three& joints_deg) {
  return sinew_maxarm::inverse(xyz_mm.data(), joints_deg.data());
}

MaxArmResult inverse(const Three& xyz_mm) {
  Three joints{};
  return inverse(xyz_mm, joints);
}

TEST(ArduinoKinematics, documented_points_become_their_angles_and_pulses_and_back) {
  for (const Vector& vector : kVectors) {
    Three joints{};
    Three pulses{};
    Three back{};
    ASSERT_TRUE(inverse(vector.xyz_mm, joints));
    sinew_maxarm::pulses_of(joints.data(), pulses.data());
    sinew_maxarm::forward(joints.data(), back.data());
    Three cut_joints{};
    Three cut_xyz{};
    sinew_maxarm::joints_of(vector.cut.data(), cut_joints.data());
    sinew_maxarm::forward(cut_joints.data(), cut_xyz.data());
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(joints[i], vector.joints_deg[i], 0.001) << vector.xyz_mm[0];
      EXPECT_NEAR(pulses[i], vector.pulses[i], 0.004);
      EXPECT_NEAR(back[i], vector.xyz_mm[i], 0.001);
      EXPECT_NEAR(cut_xyz[i], vector.cut_xyz_mm[i], 0.001);
    }
  }
}

TEST(ArduinoKinematics, home_on_the_limit_of_the_forearm_is_accepted) {
  Three joints{};
  ASSERT_TRUE(inverse({0, -162.94F, 212.8F}, joints));
  EXPECT_GE(joints[2], 0);
  EXPECT_NEAR(joints[2], 0, 0.001);
}

TEST(ArduinoKinematics, points_on_a_limit_are_accepted_and_a_tenth_of_a_degree_beyond_refused) {
  test::for_random_cases(20000, [](test::Random& random) {
    const std::array<std::pair<float, float>, 3> limits{{{0, 240}, {0, 210}, {0, 120}}};
    const auto a2 = static_cast<float>(random.uniform(70, 150));
    Three joints{static_cast<float>(random.uniform(0, 240)), a2,
                 static_cast<float>(random.uniform(0, a2 - 60))};
    const auto joint = static_cast<std::size_t>(random.integer(0, 1) * 2);  // base or forearm
    const bool upper = joint == 0 && random.chance(0.5);
    joints[joint] = upper ? limits[joint].second : limits[joint].first;
    Three point{};
    sinew_maxarm::forward(joints.data(), point.data());
    EXPECT_TRUE(inverse(point)) << joints[0] << " " << joints[1] << " " << joints[2];
    joints[joint] += upper ? 0.1F : -0.1F;
    sinew_maxarm::forward(joints.data(), point.data());
    const MaxArmResult beyond = inverse(point);
    EXPECT_EQ(beyond.error, MaxArmError::kJointLimit);
    EXPECT_EQ(beyond.joint, joint + 1);
    EXPECT_NEAR(beyond.value, joints[joint], 0.02);
  });
}

TEST(ArduinoKinematics, refusals_name_the_joint_and_both_numbers) {
  const MaxArmResult high = inverse({0, -100, 240});
  EXPECT_EQ(high.error, MaxArmError::kJointLimit);
  EXPECT_EQ(high.joint, 3);
  EXPECT_NEAR(high.value, -17.0579, 0.001);
  EXPECT_EQ(high.limit, 0);
  const MaxArmResult behind = inverse({100, 100, 100});
  EXPECT_EQ(behind.error, MaxArmError::kJointLimit);
  EXPECT_EQ(behind.joint, 1);
  EXPECT_NEAR(behind.value, -15, 0.001);
  const MaxArmResult left = inverse({-100, 100, 100});
  EXPECT_EQ(left.joint, 1);
  EXPECT_NEAR(left.value, 255, 0.001);
  EXPECT_EQ(left.limit, 240);
  const MaxArmResult far = inverse({0, -400, 100});
  EXPECT_EQ(far.error, MaxArmError::kOutOfReach);
  EXPECT_NEAR(far.limit, 266.4, 1e-4);
  const MaxArmResult close = inverse({0, -49.9F, 100});
  EXPECT_EQ(close.error, MaxArmError::kTooClose);
  EXPECT_NEAR(close.value, 49.9, 1e-4);
  EXPECT_EQ(close.limit, 50);
  EXPECT_NE(inverse({0, -50, 100}).error, MaxArmError::kTooClose) << "inclusive";
}

TEST(ArduinoKinematics, nan_infinity_and_enormous_numbers_are_refused) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    for (const float bad : {kNan, kInfinity, -kInfinity}) {
      Three point{0, -200, 120};
      point[i] = bad;
      EXPECT_EQ(inverse(point).error, MaxArmError::kNotANumber);
    }
    Three point{0, -200, 120};
    point[i] = 1e30F;
    EXPECT_EQ(inverse(point).error, MaxArmError::kOutOfReach);
  }
}

TEST(ArduinoKinematics, reach_of_each_height_is_that_of_the_table) {
  struct Row {
    float z, min, max;
  };
  for (const Row row :
       {Row{-100, 68.4F, 203.9F}, Row{-50, 83.5F, 254.9F}, Row{0, 79.5F, 277.6F}, Row{60, 50, 290},
        Row{84, 50, 291.34F}, Row{140, 50, 279}, Row{170, 67.2F, 259}, Row{190, 90, 236},
        Row{204, 116, 210}, Row{210, 136, 190}}) {
    const float mm = row.z == 84 ? 0.02F : 1.0F;
    EXPECT_TRUE(inverse({0, -row.min - 1, row.z})) << row.z;
    EXPECT_FALSE(inverse({0, -row.min + 1, row.z})) << row.z;
    EXPECT_TRUE(inverse({0, -row.max + mm, row.z})) << row.z;
    EXPECT_FALSE(inverse({0, -row.max - mm, row.z})) << row.z;
  }
  EXPECT_FALSE(inverse({0, -163, 214}));
}

TEST(ArduinoKinematics, random_points_agree_with_the_product_in_double) {
  const RobotModel model = test::maxarm_model();
  const auto& geometry = std::get<PalletizerGeometry>(model.geometry);
  int reached = 0;
  test::for_random_cases(20000, [&](test::Random& random) {
    const Three point{static_cast<float>(random.uniform(-300, 300)),
                      static_cast<float>(random.uniform(-300, 300)),
                      static_cast<float>(random.uniform(-150, 250))};
    Three joints{};
    const MaxArmResult mine = inverse(point, joints);
    const auto exact = kinematics::inverse(
        geometry, model.joints, Vec3{from_mm(point[0]), from_mm(point[1]), from_mm(point[2])});
    const bool on_reach = !exact && exact.error().code == ErrorCode::kOutOfReach &&
                          exact.error().measured - exact.error().limit < from_mm(0.01);
    if (mine && !exact) {
      // Within the tolerance of a limit both verdicts are right.
      EXPECT_TRUE(on_reach || exact.error().code == ErrorCode::kJointLimit);
      EXPECT_NEAR(exact.error().measured, exact.error().limit, from_deg(0.02));
      return;
    }
    EXPECT_EQ(bool(mine), exact.has_value()) << point[0] << " " << point[1] << " " << point[2];
    if (!mine || !exact) {
      EXPECT_TRUE(on_reach || (mine.error == MaxArmError::kJointLimit) ==
                                  (exact.error().code == ErrorCode::kJointLimit));
      return;
    }
    ++reached;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(joints[i], to_deg((*exact)[i]), 0.05) << point[0] << " " << point[1];
    }
    Three back{};
    sinew_maxarm::forward(joints.data(), back.data());
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(back[i], point[i], 0.05);
  });
  EXPECT_GT(reached, 3000);
}

TEST(ArduinoKinematics, nearest_pulse_is_never_0_and_rounds) {
  EXPECT_EQ(sinew_maxarm::nearest_pulse(416.67F), 417);
  EXPECT_EQ(sinew_maxarm::nearest_pulse(416.4F), 416);
  EXPECT_EQ(sinew_maxarm::nearest_pulse(0), 1);
  EXPECT_EQ(sinew_maxarm::nearest_pulse(-5), 1);
  EXPECT_EQ(sinew_maxarm::nearest_pulse(1000.2F), 1000);
  EXPECT_EQ(sinew_maxarm::nearest_pulse(std::numeric_limits<float>::quiet_NaN()), 1);
}

}  // namespace
}  // namespace sinew
