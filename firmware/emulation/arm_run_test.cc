#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <span>
#include <vector>

#include "cli/process.h"
#include "cli/small_arm.h"
#include "firmware/emulation/arm_socket.h"
#include "sinew/config/robot_file.h"
#include "sinew/core/number_text.h"
#include "sinew/kinematics/serial_arm.h"
#include "support/scratch_folder.h"

// The built program and six boards that run the image that is flashed.

namespace sinew::emulation {
namespace {

using test::Ended;

/// Close to the end stops, so that homing is short.
JointVector near_home(const RobotModel& model) {
  JointVector q;
  for (const Joint& joint : model.joints) q.push_back(joint.lower + from_deg(3));
  return q;
}

double distance_to_line(const Vec3& point, const Vec3& from, const Vec3& to) {
  const Vec3 along = to - from;
  const double share = std::clamp(dot(point - from, along) / dot(along, along), 0.0, 1.0);
  return norm(from + share * along - point);
}

class EmulatedArmRun : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("XDG_STATE_HOME", folder_.at("state").c_str(), 1);
    setenv("XDG_RUNTIME_DIR", folder_.at("").c_str(), 1);
    auto read = read_robot(test::text_of(file_), "small.toml");
    ASSERT_TRUE(read);
    model_ = std::move(*read);
  }

  /// Where the pulses say that the tool is; they end where the program does, at q_end.
  std::vector<Vec3> tool_path(std::span<const ArmSocket::Steps> all, const JointVector& q_end,
                              const kinematics::SerialArm& tool) const {
    std::vector<Vec3> path;
    for (const ArmSocket::Steps& steps : all) {
      JointVector q = q_end;
      for (std::size_t i = 0; i < q.size(); ++i) {
        const double per_rad = model_.dynamics.drives[i].steps_per_rad();
        q[i] += static_cast<double>(steps[i] - all.back()[i]) / per_rad;
      }
      path.push_back(tool.forward({q.data(), q.size()}).p);
    }
    return path;
  }

  test::ScratchFolder folder_;
  std::string file_ = test::small_robot_arm_2(folder_, true);
  RobotModel model_;
};

TEST_F(EmulatedArmRun, six_boards_run_a_program_draw_its_lines_by_their_pulses_and_stop) {
  const auto& geometry = std::get<SerialGeometry>(model_.geometry);
  const kinematics::SerialArm tool(geometry, model_.joints, kinematics::tool_pose(geometry));
  const std::array start{0.0, 0.0, from_deg(-2), 0.0, from_deg(3), 0.0};
  auto pose = tool.forward(start);
  const Vec3 begin = pose.p;
  const Vec3 corner = begin + Vec3{0, 0, -0.012};
  const Vec3 end = corner + Vec3{0.006, 0, 0};
  pose.p = end;
  auto branches = tool.inverse(pose, start);
  ASSERT_TRUE(branches);
  kinematics::sort_by_distance(*branches, start);
  const JointVector q_end = (*branches)[0].q;

  EmulatedArm arm(Stm32Chip::kF401, model_, near_home(model_), 5);
  ArmSocket socket(arm, model_, folder_.at("boards"));
  const std::string program = folder_.file(
      "p.sinew", "home\njoint elbow=-2deg wrist_bend=3deg\nline z=" + number_text(corner.z * 1e3) +
                     "mm speed=20mm/s\nline x=" + number_text(end.x * 1e3) + "mm speed=20mm/s\n");
  const Ended ran =
      test::sinew({"run", program, "--robot", file_, "--port", socket.port(), "--json"});
  const std::size_t end_of_program = socket.ticks();
  // The next program is stopped on its path.
  const std::int64_t before = socket.first_axis();
  test::Process next({"run", folder_.file("n.sinew", "joint base=5deg\n"), "--robot", file_,
                      "--port", socket.port(), "--json"});
  const double per_degree = from_deg(model_.dynamics.drives[0].steps_per_rad());
  while (std::abs(static_cast<double>(socket.first_axis() - before)) < per_degree) {
    next.let_run(std::chrono::milliseconds(5));
    ASSERT_LT(socket.ticks(), end_of_program + 20'000);
  }
  next.signal(SIGINT);
  const Ended stopped = next.end();
  socket.end();
  ASSERT_EQ(ran.exit, 0) << ran.err << ran.out;
  ASSERT_FALSE(arm.broken()) << *arm.broken();
  EXPECT_NE(stopped.exit, 0);
  const double moved = static_cast<double>(socket.steps().back()[0] - before) / per_degree;
  EXPECT_LT(std::abs(moved), 4.5) << "it was stopped before its end";
  EXPECT_NEAR(stopped.json()["positions"][0]["q_deg"].get<double>(), moved, 0.5);
  // Nothing moves behind the stop.
  const auto& all = socket.steps();
  for (std::size_t axis = 0; axis < 6; ++axis) {
    EXPECT_NEAR(static_cast<double>(all.back()[axis]),
                static_cast<double>(all[all.size() - 20][axis]), 3)
        << axis;
  }

  const auto path = tool_path({socket.steps().data(), end_of_program}, q_end, tool);
  // The lines begin when the tool leaves their first point.
  const auto leaves = std::ranges::find_if(path.rbegin(), path.rend(), [&](const Vec3& point) {
                        return norm(point - begin) < 1e-4;
                      }).base();
  ASSERT_NE(leaves, path.begin());
  double worst = 0, nearest_corner = 1;
  for (auto point = leaves; point != path.end(); ++point) {
    worst = std::max(worst, std::min(distance_to_line(*point, begin, corner),
                                     distance_to_line(*point, corner, end)));
    nearest_corner = std::min(nearest_corner, norm(*point - corner));
  }
  std::printf("  %.1f s of %.1f s on the lines; %.3f mm off at most, %.3f mm at the corner\n",
              1e-3 * static_cast<double>(path.end() - leaves),
              1e-3 * static_cast<double>(path.size()), worst * 1e3, nearest_corner * 1e3);
  EXPECT_LT(worst, 0.1e-3);
  EXPECT_LT(nearest_corner, 0.1e-3);
}

}  // namespace
}  // namespace sinew::emulation
