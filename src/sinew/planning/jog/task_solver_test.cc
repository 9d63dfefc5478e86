#include "sinew/planning/jog/task_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "sinew/planning/jog/twist_ramp.h"
#include "support/property.h"

namespace sinew::planning {
namespace {

using Matrix = Eigen::Matrix<double, 6, Eigen::Dynamic>;

TaskJacobian jacobian(const Matrix& M) {
  TaskJacobian J;
  J.joints = static_cast<std::size_t>(M.cols());
  for (std::size_t j = 0; j < J.joints; ++j) {
    for (std::size_t k = 0; k < kTasksMax; ++k) {
      J.column[j][k] = M(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j));
    }
  }
  return J;
}

Matrix random_matrix(test::Random& random, int joints) {
  Matrix M(6, joints);
  for (int j = 0; j < joints; ++j) {
    for (int k = 0; k < 6; ++k) M(k, j) = random.uniform(-1, 1);
  }
  return M;
}

TaskArray random_task(test::Random& random) {
  TaskArray task;
  for (double& number : task) number = random.uniform(-1, 1);
  return task;
}

double smallest_value(const Matrix& M) {
  return Eigen::JacobiSVD<Matrix>(M).singularValues().minCoeff();
}

TEST(TaskSolver, gives_the_least_squares_answer_away_from_singularities) {
  TaskSolver solver;
  test::for_random_cases(5000, [&](test::Random& random) {
    const int joints = static_cast<int>(random.integer(6, 8));
    const Matrix M = random_matrix(random, joints);
    if (smallest_value(M) < TaskSolver::kNearSingular) return random.discard();
    const bool holds = joints > 6 && random.chance(0.3);
    const auto held = static_cast<unsigned>(holds ? 1U << random.integer(0, 2) : 0);
    Matrix free = M;
    for (int j = 0; j < joints; ++j) {
      if ((held >> j & 1U) != 0) free.col(j).setZero();
    }
    const auto task = random_task(random);
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> wanted(task.data());
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(free, Eigen::ComputeThinU | Eigen::ComputeThinV);
    if (svd.singularValues()(5) < TaskSolver::kNearSingular) return random.discard();
    const Eigen::VectorXd expected = svd.solve(wanted);
    solver.factor(jacobian(M), held);
    const JointArray u = solver.solve(task);
    for (int j = 0; j < joints; ++j) {
      EXPECT_NEAR(u[static_cast<std::size_t>(j)], expected(j), 1e-6 * (1 + expected.norm()));
    }
  });
}

TEST(TaskSolver, leaves_out_turns_for_the_direction_that_a_singularity_takes) {
  TaskSolver solver;
  int turned = 0;
  int slowed = 0;
  test::for_random_cases(3000, [&](test::Random& random) {
    // From made up directions: the last one is lost, more or less, down to 0.
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(random_matrix(random, 6),
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::VectorXd values(6);
    for (int k = 0; k < 5; ++k) values(k) = random.uniform(0.1, 1);
    values(5) = random.chance(0.3) ? 0 : TaskSolver::kNearSingular * random.uniform(0, 1);
    const Matrix M = svd.matrixU() * values.asDiagonal() * svd.matrixV().transpose();
    const TaskJacobian J = jacobian(M);
    const auto task = random_task(random);
    solver.factor(J, 0);
    const JointArray u = solver.solve(task);
    const TaskArray done = J.times(u);
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> wanted(task.data());
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> made(done.data());
    const Eigen::Matrix<double, 6, 1> left = wanted - made;
    const Eigen::Matrix<double, 6, 1> lost = svd.matrixU().col(5);
    // Out of the turns; where they are not enough, the tip slows down and stays on its line.
    const double missed = std::abs(left.dot(lost));
    const auto tip = left.head<3>();
    if (missed < 0.99 * lost.tail<3>().norm() * wanted.norm()) {
      ++turned;
      EXPECT_LT(tip.norm(), 2e-3 * wanted.norm());
    } else if (lost.head<3>().dot(wanted.head<3>()) * lost.dot(wanted) > 0) {
      ++slowed;
      EXPECT_LE(left.norm(), 2 * wanted.norm());
    }
    // Never more than was asked for, never the other way.
    EXPECT_GE(made.dot(lost) * wanted.dot(lost), -1e-9);
    EXPECT_LE(std::abs(made.dot(lost)), std::abs(wanted.dot(lost)) + 1e-9);
    double speed = 0;
    for (const double number : u) speed += number * number;
    EXPECT_LT(std::sqrt(speed), 5 / 0.1 + 2.5 / TaskSolver::kNearSingular);
    EXPECT_NEAR(solver.lost_share(task), missed / wanted.norm(), 1e-6);
  });
  EXPECT_GT(turned, 500);
  EXPECT_GT(slowed, 100);
}

/// Whichever direction is lost: no part of a turn becomes a way of the tip's, nor is a translation
/// bent aside.
TEST(TaskSolver, pure_turns_keep_the_tip_and_pure_translations_their_line) {
  TaskSolver solver;
  int slower = 0;
  test::for_random_cases(3000, [&](test::Random& random) {
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(random_matrix(random, 6),
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::VectorXd values(6);
    for (int k = 0; k < 5; ++k) values(k) = random.uniform(0.1, 1);
    values(5) = random.chance(0.3) ? 0 : TaskSolver::kNearSingular * random.uniform(0, 1);
    const Matrix M = svd.matrixU() * values.asDiagonal() * svd.matrixV().transpose();
    const TaskJacobian J = jacobian(M);
    auto task = random_task(random);
    const bool turn = random.chance(0.5);
    std::fill_n(task.begin() + (turn ? 0 : 3), 3, 0.0);
    solver.factor(J, 0);
    const TaskArray done = J.times(solver.solve(task));
    const Eigen::Map<const Eigen::Vector3d> tip(done.data());
    if (turn) {
      EXPECT_LT(tip.norm(), 2e-3);
      return;
    }
    const Eigen::Vector3d asked(task.data());
    const double along = tip.dot(asked) / asked.norm();
    EXPECT_GE(along, -2e-3);
    EXPECT_LE(along, asked.norm() * (1 + 1e-6));
    slower += along < 0.9 * asked.norm() ? 1 : 0;
    EXPECT_LT((tip - along * asked.normalized()).norm(), 0.01 * asked.norm());
  });
  EXPECT_GT(slower, 50);
}

TEST(TaskSolver, limit_holds_one_direction_back_at_the_cost_of_turns) {
  TaskSolver solver;
  int paid = 0;
  test::for_random_cases(1000, [&](test::Random& random) {
    const Matrix M = random_matrix(random, 6);
    if (smallest_value(M) < 0.1) return random.discard();
    const TaskJacobian J = jacobian(M);
    const auto task = random_task(random);
    solver.factor(J, 0);
    const JointArray before = solver.solve(task);
    EXPECT_FALSE(solver.limited(task));
    const JointArray& along = solver.joints_along(2);
    const auto speed = [&](const JointArray& u) {
      double sum = 0;
      for (std::size_t j = 0; j < 6; ++j) sum += u[j] * along[j];
      return sum / solver.singular_value(2);
    };
    const double most = 0.5 * std::abs(speed(before));
    solver.limit(2, -most, most);
    const JointArray after = solver.solve(task);
    EXPECT_TRUE(solver.limited(task));
    EXPECT_NEAR(std::abs(speed(after)), most, 1e-7);
    EXPECT_GT(speed(after) * speed(before), 0);
    // What it costs comes out of the turns, where they can pay for it.
    const TaskArray change = J.times([&] {
      JointArray u = after;
      for (std::size_t j = 0; j < 6; ++j) u[j] -= before[j];
      return u;
    }());
    double missed = 0;
    double turns = 0;
    for (std::size_t i = 0; i < kTasksMax; ++i) {
      missed += change[i] * solver.direction(2)[i];
      if (i >= 3) turns += solver.direction(2)[i] * solver.direction(2)[i];
    }
    double size = 0;
    for (const double number : task) size += number * number;
    if (missed * missed > 0.98 * turns * size) return;
    ++paid;
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(change[i], 0, 2e-3 * std::sqrt(size));
  });
  EXPECT_GT(paid, 100);
}

TEST(TaskSolver, nothing_at_all_can_be_done_without_a_jacobian) {
  TaskSolver solver;
  solver.factor({6, {}}, 0);
  for (const double number : solver.solve({1, 2, 3, 4, 5, 6})) EXPECT_EQ(number, 0);
  EXPECT_NEAR(solver.lost_share({1, 2, 3, 4, 5, 6}), 1, 1e-12);
}

TEST(TaskSolver, directions_stay_orthogonal_through_a_hundred_thousand_calls) {
  TaskSolver solver;
  test::Random random(3);
  Matrix M = random_matrix(random, 6);
  for (int call = 0; call < 100000; ++call) {
    M(call % 6, call / 6 % 6) += 0.01 * random.uniform(-1, 1);
    solver.factor(jacobian(M), 0);
  }
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    for (std::size_t l = 0; l <= k; ++l) {
      double sum = 0;
      for (std::size_t i = 0; i < kTasksMax; ++i) {
        sum += solver.direction(k)[i] * solver.direction(l)[i];
      }
      EXPECT_NEAR(sum, k == l ? 1 : 0, 1e-12);
    }
  }
}

TEST(TwistRamp, keeps_its_direction_from_rest_and_arrives_inside_its_limits) {
  test::for_random_cases(1000, [](test::Random& random) {
    TwistRamp ramp;
    ramp.begin({}, {});
    const auto target = random_task(random);
    const double acceleration = std::pow(10, random.uniform(-1, 1));
    const double jerk = acceleration * std::pow(10, random.uniform(-1, 2));
    double size = 0;
    for (const double number : target) size += number * number;
    size = std::sqrt(size);
    const double dt = random.uniform(1e-3, 2e-2);
    double last = 0;
    double last_gain = 0;
    const double longest =
        2 * (size / acceleration + 2 * acceleration / jerk + 2 * std::sqrt(size / jerk)) + 1;
    for (double t = 0; t < longest; t += dt) {
      ramp.step(target, acceleration, jerk, dt);
      const TaskArray& V = ramp.velocity();
      double along = 0;
      for (std::size_t k = 0; k < kTasksMax; ++k) along += V[k] * target[k] / size;
      for (std::size_t k = 0; k < kTasksMax; ++k) {
        EXPECT_NEAR(V[k], along * target[k] / size, 1e-9 * size);
      }
      EXPECT_LE(along, size * (1 + 1e-9));
      const double gain = (along - last) / dt;
      EXPECT_LE(std::abs(gain), acceleration * (1 + 1e-6));
      EXPECT_LE(std::abs(gain - last_gain), jerk * dt * (1 + 1e-6) + 1e-9 * acceleration);
      last = along;
      last_gain = gain;
    }
    EXPECT_NEAR(last, size, 1e-12 * size);
  });
}

TEST(TwistRamp, narrower_limits_under_way_do_not_send_it_beyond_its_target) {
  test::for_random_cases(1000, [](test::Random& random) {
    TwistRamp ramp;
    ramp.begin({}, {});
    const TaskArray target{1, 0, 0, 0, 0, 0};
    const double when = random.uniform(0.1, 1);
    for (double t = 0; t < 20; t += 0.005) {
      const bool narrow = ramp.velocity()[0] > when;
      ramp.step(target, narrow ? 0.01 : 2, narrow ? 0.01 : 10, 0.005);
      EXPECT_LE(ramp.velocity()[0], 1 + 1e-9);
      EXPECT_GE(ramp.velocity()[0], 0);
    }
  });
}

}  // namespace
}  // namespace sinew::planning
