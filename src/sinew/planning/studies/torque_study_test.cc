#include "sinew/planning/studies/torque_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "support/property.h"
#include "support/robots.h"

namespace sinew::planning {
namespace {

constexpr double kStepRate = 5000;
constexpr std::size_t kShoulder = 1;

const RobotModel& arm() {
  return test::robot("robot-arm-2");
}
const TorqueStudy& arm_study() {
  static const TorqueStudy study(arm(), kStepRate);
  return study;
}

/// Weight on the shoulder by the masses' levers alone: with the upper arm level, its centre is
/// 315 - 140 mm out; the elbow turns by `elbow` and the wrist by `wrist` from the stretched line.
double shoulder_weight(double payload, double elbow, double wrist) {
  struct Part {
    double mass, x, z;
  };
  const double ce = std::cos(elbow), se = std::sin(elbow);
  const auto fore = [&](double along, double across) {  // of the elbow's frame
    return 0.315 + ce * along - se * across;
  };
  // Hand: from the wrist's centre, turned by the wrist in the same plane.
  const auto hand = [&](double along) {
    return fore(0.265, -0.045) + std::cos(elbow + wrist) * along;
  };
  const double moment = 3.0 * 0.175 + 1.7 * fore(0.03, -0.045) + 1.3 * fore(0.265 - 0.14, -0.045) +
                        0.5 * hand(0.03) + 0.15 * hand(0.07) + payload * hand(0.1);
  return kinematics::kGravity * moment;
}

double largest_shoulder_weight(double payload) {
  double largest = 0;
  for (double elbow = -0.6; elbow < 0.6; elbow += 2e-3) {
    for (double wrist = -0.6; wrist < 0.6; wrist += 2e-3) {
      largest = std::max(largest, shoulder_weight(payload, elbow, wrist));
    }
  }
  return largest;
}

TEST(TorqueStudy, reproduces_the_torque_table_of_the_author) {
  constexpr std::array kTable{15.0, 45.0, 30.0, 15.0, 9.5, 4.8};  // Nm
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    EXPECT_NEAR(arm_study().drive(i).available(0), kTable[i], 0.05) << "axis " << i + 1;
  }
}

TEST(TorqueStudy, largest_weight_on_the_shoulder_agrees_with_levers_by_hand) {
  for (const double payload : {0.0, 1.0, 3.0}) {
    const JointNeed need = arm_study().need(kShoulder, payload);
    EXPECT_NEAR(need.weight, largest_shoulder_weight(payload), 1e-3) << payload << " kg";
  }
}

TEST(TorqueStudy, no_random_pose_needs_more_than_the_worst_that_was_found) {
  for (const char* id : {"robot-arm-2", "learm", "bigrobotarm"}) {
    const RobotModel& model = test::robot(id);
    const TorqueStudy study(model, kStepRate);
    const InverseDynamics dynamics(model, 0.2);
    std::vector<JointNeed> needs;
    for (std::size_t i = 0; i < study.size(); ++i) needs.push_back(study.need(i, 0.2));
    test::for_random_cases(20'000, [&](test::Random& random) {
      JointVector q, qd, qdd;
      for (const Joint& joint : model.joints) {
        q.push_back(random.uniform(joint.lower, joint.upper));
        // At the end of the steady acceleration, in any direction.
        const double peak =
            std::min(joint.acceleration_max, std::sqrt(joint.velocity_max * joint.jerk_max));
        const double top = joint.velocity_max - peak * peak / (2 * joint.jerk_max);
        qd.push_back(random.chance(0.5) ? top : -top);
        qdd.push_back(random.chance(0.5) ? peak : -peak);
      }
      const JointVector torque = *dynamics.torque(q, {qd, qdd});
      for (std::size_t i = 0; i < q.size(); ++i) {
        const double demand = study.drive(i).demand({torque[i], qd[i], qdd[i]});
        // The search may miss the top by 0.3 %.
        ASSERT_LE(demand / study.drive(i).available(qd[i]),
                  1.003 * needs[i].demand / needs[i].available + 1e-9)
            << id << " axis " << i + 1;
      }
    });
  }
}

TEST(TorqueStudy, payload_at_which_the_shoulder_fails_at_rest_is_that_of_the_levers) {
  const auto failing = arm_study().failing_payload_at_rest(kShoulder);
  ASSERT_TRUE(failing.has_value());
  const double holding = arm_study().drive(kShoulder).available(0);
  EXPECT_NEAR(largest_shoulder_weight(*failing), holding, 2e-3 * holding);
}

TEST(TorqueStudy, just_below_the_failing_payload_it_does_and_just_above_it_does_not) {
  for (const char* id : {"robot-arm-2", "bigrobotarm", "maxarm"}) {
    const TorqueStudy study(test::robot(id), kStepRate);
    for (std::size_t i = 0; i < study.size(); ++i) {
      const auto failing = study.failing_payload(i);
      if (!failing || *failing == 0) continue;
      EXPECT_GE(study.need(i, 0.99 * *failing).margin(), 1) << id << " axis " << i + 1;
      EXPECT_LE(study.need(i, 1.01 * *failing).margin(), 1) << id << " axis " << i + 1;
    }
  }
}

TEST(TorqueStudy, acceleration_that_fails_is_what_torque_and_inertia_say) {
  // Stretched out: weight + friction + (inertia + rotors) a = what the motors give.
  const double payload = 1;
  const auto failing = arm_study().failing_acceleration(kShoulder, payload);
  ASSERT_TRUE(failing.has_value());
  const InverseDynamics dynamics(arm(), payload);
  const StepperDrive& drive = arm().dynamics.drives[kShoulder];
  const double rotors = drive.rotor_inertia * drive.motors * drive.gear_ratio * drive.gear_ratio;
  double least = 1e9;
  for (double elbow = 0; elbow < 2.4; elbow += 0.01) {
    for (double wrist = -0.6; wrist < 0.6; wrist += 0.01) {
      const auto parts = *dynamics.parts(JointVector{0, -kPi / 2, elbow, 0, wrist, 0});
      const double left = arm_study().drive(kShoulder).available(0) - drive.coulomb_friction -
                          std::abs(parts.weight[kShoulder]);
      const double inertia = parts.inertia[kShoulder][kShoulder] + rotors * drive.gear_efficiency;
      least = std::min(least, left / inertia);
    }
  }
  // The grid holds the shoulder level; the true worst may be a little aside.
  EXPECT_LE(*failing, least * 1.0001);
  EXPECT_GE(*failing, least * 0.98);
}

TEST(TorqueStudy, reach_at_which_it_fails_shrinks_as_the_payload_grows) {
  EXPECT_FALSE(arm_study().failing_reach(kShoulder, 1).has_value());
  double last = arm_study().reach_max();
  EXPECT_NEAR(last, 0.315 + std::hypot(0.265, 0.045) + 0.1, 1e-4);
  for (const double payload : {3.5, 4.0, 5.0, 8.0}) {
    const auto reach = arm_study().failing_reach(kShoulder, payload);
    ASSERT_TRUE(reach.has_value()) << payload;
    EXPECT_LT(*reach, last);
    last = *reach;
  }
}

TEST(TorqueStudy, reach_at_which_it_fails_is_not_above_that_of_a_grid) {
  // All poses in the arm's plane, in steps of 3 degrees, with the same motion.
  const double payload = 5;
  const auto reach = arm_study().failing_reach(kShoulder, payload);
  ASSERT_TRUE(reach.has_value());
  const InverseDynamics dynamics(arm(), payload);
  const double limit = arm_study().drive(kShoulder).available(from_deg(29.5));
  const StepperDrive& drive = arm().dynamics.drives[kShoulder];
  const double friction =
      drive.coulomb_friction + drive.viscous_friction * arm().joints[kShoulder].velocity_max;
  double nearest = 10;
  for (double shoulder = -90; shoulder <= 90; shoulder += 3) {
    for (double elbow = -135; elbow <= 135; elbow += 3) {
      for (double wrist = -120; wrist <= 120; wrist += 3) {
        const JointVector q{0, from_deg(shoulder), from_deg(elbow), 0, from_deg(wrist), 0};
        const double weight = std::abs(dynamics.parts(q)->weight[kShoulder]);
        if (weight + friction <= limit)
          continue;  // without acceleration: a little less than moving
        const Vec3 p = *dynamics.payload_point(q);
        nearest = std::min(nearest, std::hypot(p.x, p.y));
      }
    }
  }
  EXPECT_LE(*reach, nearest + 0.003);
  EXPECT_GE(*reach, nearest - 0.05);
}

TEST(TorqueStudy, advised_ratio_just_does_where_the_present_one_fails) {
  RobotModel model = arm();
  const double payload = 5;
  const JointNeed before = arm_study().need(kShoulder, payload);
  ASSERT_LT(before.margin(), 1);
  ASSERT_TRUE(before.ratio && before.ratio->lowest);
  EXPECT_GT(*before.ratio->lowest, 17);
  model.dynamics.drives[kShoulder].gear_ratio = *before.ratio->lowest;
  EXPECT_NEAR(TorqueStudy(model, kStepRate).need(kShoulder, payload).margin(), 1, 3e-3);
  ASSERT_TRUE(before.ratio_with_reserve && before.ratio_with_reserve->lowest);
  model.dynamics.drives[kShoulder].gear_ratio = *before.ratio_with_reserve->lowest;
  EXPECT_NEAR(TorqueStudy(model, kStepRate).need(kShoulder, payload).margin(), kTorqueReserve,
              6e-3);
}

TEST(TorqueStudy, same_question_has_the_same_answer) {
  const TorqueStudy again(arm(), kStepRate);
  const JointNeed a = arm_study().need(2, 0.7), b = again.need(2, 0.7);
  EXPECT_EQ(a.demand, b.demand);
  EXPECT_EQ(a.q_demand, b.q_demand);
}

TEST(PoseSearch, finds_the_top_of_a_hill_and_leaves_other_joints_at_home) {
  const PoseSearch search(arm());
  const auto found = search.best([](const JointVector& q, std::size_t) {
    return -std::abs(q[2] - 0.7) - (q[4] + 0.2) * (q[4] + 0.2);
  });
  EXPECT_NEAR(found.q[2], 0.7, 1e-4);
  EXPECT_NEAR(found.q[4], -0.2, 1e-2);
  EXPECT_EQ(found.q[0], arm().joints[0].home);
  EXPECT_EQ(found.q[5], arm().joints[5].home);
}

TEST(PoseSearch, finds_corners_of_the_joint_limits) {
  const PoseSearch search(arm());
  const auto found =
      search.best([](const JointVector& q, std::size_t) { return q[1] - q[2] + q[3]; });
  EXPECT_NEAR(found.q[1], arm().joints[1].upper, 1e-4);
  EXPECT_NEAR(found.q[2], arm().joints[2].lower, 1e-4);
  EXPECT_NEAR(found.q[3], arm().joints[3].upper, 1e-4);
}

TEST(PoseSearch, says_so_where_no_pose_counts) {
  const PoseSearch search(arm());
  const auto found = search.best([](const JointVector&, std::size_t) { return -HUGE_VAL; });
  EXPECT_EQ(found.score, -HUGE_VAL);
}

}  // namespace
}  // namespace sinew::planning
