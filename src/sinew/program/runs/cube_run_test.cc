#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/planning/paths/tool_space.h"
#include "sinew/program/runs/plain_cell_test_support.h"

/// Runs of programs that look, pick and place.
namespace sinew::program {
namespace {

constexpr double kEdge = 25e-3;

grasping::Cube cube_at(double x, double y, vision::ColorName color) {
  return {{x, y, kEdge / 2}, 0.3, kEdge, static_cast<int>(color)};
}

/// A table in front of a LeArm with a driver that does as told. What closed jaws are around, and
/// only that, is held; what they let go is gone from the table.
class Table : public Eyes {
 public:
  explicit Table(PlainCell& cell) : cell_(cell) {
    cell_.run.see_by(*this);
    cell_.run.measure_by([this] { return DriverHealth{.jaws_width = jaws()}; });
  }

  void look(std::string_view camera) override {
    looked_with.emplace_back(camera);
    ++looks;
    asked_ = true;
  }
  std::optional<Expected<Sighting>> seen() override {
    if (!asked_ || wait-- > 0) return std::nullopt;
    asked_ = false;
    if (fault) return std::unexpected(*fault);
    return Sighting{cubes};
  }

  void watch(bool on, bool anew) override {
    watched = on;
    watches_anew += on && anew ? 1 : 0;
    watches += on ? 1 : 0;
    came = came && on;
  }
  std::optional<Error> disturbed() const override {
    return watched && came ? std::optional(Error{ErrorCode::kViewDisturbed}) : std::nullopt;
  }

  /// After each instant of the run: what the jaws did to the cubes.
  void follow() {
    const auto* to = std::get_if<JawsTo>(&cell_.driver.tool_);
    if (cell_.driver.tools_ == tools_ || to == nullptr) return;
    tools_ = cell_.driver.tools_;
    if (to->width > kEdge) {
      if (held_) ++let_go;
      held_ = false;
      return;
    }
    ++grasps;
    if (grasps <= slips) return;
    JointVector q;
    for (const JointPosition& position : cell_.driver.positions_) q.push_back(position.q);
    const planning::ToolSpace space(cell_.robot, to->width);
    const Vec3 tips = space.forward({q.data(), q.size()}, space.home())->p;
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      const Vec3 d = tips - cubes[i].p_BO;
      if (std::hypot(d.x, d.y) > 2e-3 || std::abs(d.z) > kEdge / 2) continue;
      taken.push_back(static_cast<vision::ColorName>(cubes[i].color));
      cubes.erase(cubes.begin() + static_cast<std::ptrdiff_t>(i));
      held_ = true;
      return;
    }
  }
  void go(Duration limit = 1h) {
    if (cell_.run.phase() == Phase::kOpening) cell_.run.start(cell_.now);
    while (!cell_.run.finished() && cell_.now < Instant{} + limit) {
      cell_.driver.poll(cell_.now);
      cell_.step();
      follow();
      cell_.now += 1ms;
    }
  }

  std::vector<grasping::Cube> cubes;
  std::vector<vision::ColorName> taken;
  std::vector<std::string> looked_with;
  std::optional<Error> fault;
  int looks = 0, grasps = 0, let_go = 0, wait = 0;
  int slips = 0;  ///< so many grasps hold nothing
  bool watched = false;
  bool came = false;  ///< something into view
  int watches = 0;
  int watches_anew = 0;

 private:
  std::optional<double> jaws() const {
    if (held_) return kEdge;
    const auto* to = std::get_if<JawsTo>(&cell_.driver.tool_);
    return to != nullptr ? std::optional(to->width) : std::nullopt;
  }

  PlainCell& cell_;
  int tools_ = 0;
  bool held_ = false;
  bool asked_ = false;
};

constexpr const char* kReady = "joint base=-50deg shoulder=20deg elbow=40deg wrist=40deg\n";
using vision::ColorName;

TEST(CubeRun, all_cubes_in_reach_are_put_away_the_nearest_first) {
  PlainCell cell("learm", std::string(kReady) +
                              "repeat while seen\n pick\n place x=60mm y=180mm z=80mm\nend\n");
  Table table(cell);
  table.cubes = {cube_at(0.20, 0.02, ColorName::kRed), cube_at(0.14, -0.02, ColorName::kBlue),
                 cube_at(0.17, 0.06, ColorName::kGreen)};
  table.wait = 5;
  table.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone)
      << (cell.run.failure() ? describe(cell.run.failure()->error) : "");
  EXPECT_EQ(table.taken,
            (std::vector<ColorName>{ColorName::kBlue, ColorName::kGreen, ColorName::kRed}));
  EXPECT_EQ(table.let_go, 3);
  EXPECT_EQ(table.grasps, 3);
  EXPECT_EQ(table.looks, 4) << "once a round, and once more to see that there is none left";
  const auto& picked = cell.run.records()[2];
  ASSERT_TRUE(picked.cube);
  EXPECT_EQ(picked.cube->color, static_cast<int>(ColorName::kBlue));
  const JointVector ready{from_deg(-50), from_deg(20), from_deg(40), from_deg(40), 0};
  for (std::size_t i = 0; i < ready.size(); ++i) {
    EXPECT_NEAR(cell.driver.positions_[i].q, ready[i], 1e-9);
  }
}

TEST(CubeRun, colors_decide) {
  PlainCell cell("learm", std::string(kReady) +
                              "if seen color=yellow\n pick color=yellow\nelse\n pick color=green\n"
                              "end\nplace x=60mm y=180mm z=80mm\n");
  Table table(cell);
  table.cubes = {cube_at(0.14, 0, ColorName::kRed), cube_at(0.20, 0.02, ColorName::kGreen)};
  table.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(table.taken, std::vector<ColorName>{ColorName::kGreen});
  EXPECT_EQ(table.cubes.size(), 1U);
}

TEST(CubeRun, what_slips_is_looked_for_anew_and_grasped_three_times_at_most) {
  for (const int slips : {2, 3}) {
    PlainCell cell("learm", std::string(kReady) + "pick\n");
    Table table(cell);
    table.cubes = {cube_at(0.17, 0, ColorName::kRed)};
    table.slips = slips;
    table.go();
    EXPECT_EQ(table.grasps, 3);
    EXPECT_EQ(table.looks, slips == 2 ? 3 : 4) << "then for another one";
    if (slips == 2) {
      EXPECT_EQ(cell.run.phase(), Phase::kDone);
      continue;
    }
    ASSERT_EQ(cell.run.phase(), Phase::kFailed);
    EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kNotHeld);
    EXPECT_EQ(cell.run.failure()->error.measured, 3);
    EXPECT_EQ(cell.run.failure()->line, 2);
  }
}

TEST(CubeRun, what_is_never_held_is_left_where_it_lies_and_others_are_taken) {
  PlainCell cell("learm", std::string(kReady) +
                              "repeat while seen\n pick\n place x=60mm y=180mm z=80mm\nend\n");
  Table table(cell);
  table.cubes = {cube_at(0.14, -0.02, ColorName::kBlue), cube_at(0.20, 0.02, ColorName::kRed)};
  table.slips = 3;
  table.go();
  EXPECT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(table.taken, std::vector<ColorName>{ColorName::kRed});
  EXPECT_EQ(table.grasps, 4);
  ASSERT_EQ(cell.run.notices().size(), 1U);
  EXPECT_EQ(cell.run.notices()[0].error.code, ErrorCode::kNotHeld);
  EXPECT_EQ(cell.run.notices()[0].line, 3);
}

TEST(CubeRun, a_tool_that_holds_nothing_gives_up_three_cubes_and_ends) {
  for (const bool measures : {true, false}) {
    PlainCell cell("learm", std::string(kReady) + "pick\n");
    Table table(cell);
    if (!measures) cell.run.measure_by([] { return DriverHealth{}; });
    table.cubes = {cube_at(0.14, -0.04, ColorName::kBlue), cube_at(0.20, 0.02, ColorName::kRed),
                   cube_at(0.15, 0.05, ColorName::kRed), cube_at(0.17, -0.01, ColorName::kGreen)};
    table.slips = 100;
    table.go();
    ASSERT_EQ(cell.run.phase(), Phase::kFailed);
    EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kNotHeld);
    EXPECT_EQ(table.grasps, 9);
    EXPECT_EQ(cell.run.notices().size(), 2U);
  }
}

TEST(CubeRun, a_board_that_does_not_measure_leaves_it_to_the_next_picture) {
  for (const int slips : {0, 3}) {
    PlainCell cell("learm", std::string(kReady) + "pick\n");
    Table table(cell);
    cell.run.measure_by([] { return DriverHealth{}; });
    table.cubes = {cube_at(0.17, 0, ColorName::kRed)};
    table.slips = slips;
    table.go();
    EXPECT_EQ(table.looks, slips == 0 ? 2 : 4);
    EXPECT_EQ(cell.run.phase(), slips == 0 ? Phase::kDone : Phase::kFailed);
  }
}

TEST(CubeRun, what_cannot_be_had_is_said_and_nothing_moves) {
  struct Case {
    std::vector<grasping::Cube> cubes;
    ErrorCode why;
  };
  const auto red = ColorName::kRed;
  grasping::Cube upper = cube_at(0.17, 0, red);
  upper.p_BO.z += kEdge;
  upper.p_BO.x += 0.3;  // out of reach, and its lower one is under it
  grasping::Cube lower = cube_at(0.47, 0, red);
  for (const Case& one :
       {Case{{}, ErrorCode::kNothingSeen}, Case{{cube_at(0.45, 0, red)}, ErrorCode::kOutOfReach},
        Case{{lower, upper}, ErrorCode::kOutOfReach}}) {
    PlainCell cell("learm", "pick color=red\n");
    Table table(cell);
    table.cubes = one.cubes;
    table.go();
    ASSERT_EQ(cell.run.phase(), Phase::kFailed);
    EXPECT_EQ(cell.run.failure()->error.code, one.why) << describe(cell.run.failure()->error);
    EXPECT_EQ(cell.driver.tools_, 0);
    EXPECT_TRUE(cell.driver.taken_.empty());
  }
}

TEST(CubeRun, without_a_camera_or_with_a_faulty_one_nothing_moves) {
  for (const char* row : {"look\n", "pick\n", "if seen color=red\n wait 1s\nend\n"}) {
    PlainCell blind("learm", std::string(kReady) + row);
    blind.go();
    ASSERT_EQ(blind.run.phase(), Phase::kFailed);
    EXPECT_EQ(blind.run.failure()->error.code, ErrorCode::kNoCamera);
    EXPECT_EQ(blind.run.failure()->line, 2);
    EXPECT_TRUE(blind.driver.taken_.empty());
  }
  PlainCell cell("learm", "repeat while seen\n pick\nend\n");
  Table table(cell);
  table.fault = Error{ErrorCode::kCameraLost, -1, 5};
  table.go();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kCameraLost);
  EXPECT_TRUE(cell.driver.taken_.empty());
  PlainCell empty("learm", "place x=60mm y=180mm z=80mm\n");
  Table nothing(empty);
  nothing.go();
  ASSERT_EQ(empty.run.phase(), Phase::kFailed);
  EXPECT_EQ(empty.run.failure()->error.code, ErrorCode::kNothingHeld);
}

TEST(CubeRun, a_pause_holds_a_pick_wherever_it_is_and_a_stop_ends_it) {
  int paused = 0;
  for (Duration at = 700ms; at < 12s; at += 350ms) {
    PlainCell cell("learm", std::string(kReady) + "pick\n");
    cell.run.make_changeable();
    Table table(cell);
    table.cubes = {cube_at(0.17, 0, ColorName::kRed)};
    table.go(at);
    if (cell.run.finished()) break;
    cell.run.pause();
    table.go(at + 30s);
    ASSERT_FALSE(cell.run.finished()) << to_seconds(at);
    const auto moves = cell.driver.taken_.size();
    table.go(at + 60s);
    EXPECT_EQ(cell.driver.taken_.size(), moves) << "it stands";
    cell.run.resume();
    table.go(at + 120s);
    EXPECT_EQ(cell.run.phase(), Phase::kDone) << to_seconds(at);
    EXPECT_EQ(table.taken.size(), 1U);
    ++paused;
    PlainCell stopped("learm", std::string(kReady) + "pick\n");
    Table other(stopped);
    other.cubes = {cube_at(0.17, 0, ColorName::kRed)};
    other.go(at);
    stopped.run.stop(stopped.now);
    other.go(at + 10s);
    EXPECT_EQ(stopped.run.phase(), Phase::kStopped) << to_seconds(at);
  }
  EXPECT_GT(paused, 5);
}

TEST(CubeRun, what_was_seen_before_a_pause_counts_no_more) {
  PlainCell cell("learm", std::string(kReady) + "look\npick\n");
  cell.run.single_step(true);
  Table table(cell);
  table.cubes = {cube_at(0.17, 0, ColorName::kRed)};
  table.go(1s);
  while (table.looks == 0) {
    cell.run.resume();
    table.go(cell.now - Instant{} + 5s);
  }
  ASSERT_TRUE(cell.run.paused());
  table.cubes = {cube_at(0.14, 0.05, ColorName::kBlue)};
  cell.run.single_step(false);
  cell.run.resume();
  table.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(table.looks, 2);
  EXPECT_EQ(table.taken.size(), 1U) << "the one that lies there now";
}

TEST(CubeRun, what_comes_into_view_while_the_arm_moves_pauses_it_and_the_table_is_looked_at_anew) {
  PlainCell cell("learm", std::string(kReady) +
                              "repeat while seen\n pick\n place x=60mm y=180mm z=80mm\nend\n");
  cell.run.make_changeable();
  Table table(cell);
  table.cubes = {cube_at(0.17, 0, ColorName::kRed), cube_at(0.14, 0.05, ColorName::kBlue)};
  table.go(500ms);
  EXPECT_FALSE(table.watched) << "nothing was looked at yet";
  while (!table.watched && cell.now < Instant{} + 30s) table.go(cell.now - Instant{} + 1ms);
  ASSERT_TRUE(table.watched);
  table.go(cell.now - Instant{} + 700ms);
  table.came = true;
  table.go(cell.now - Instant{} + 20s);
  ASSERT_TRUE(cell.run.paused());
  EXPECT_FALSE(table.watched) << "who clears the table is no reason for another pause";
  ASSERT_EQ(cell.run.notices().size(), 1U);
  EXPECT_EQ(cell.run.notices()[0].error.code, ErrorCode::kViewDisturbed);
  const auto moves = cell.driver.taken_.size();
  table.go(cell.now - Instant{} + 20s);
  EXPECT_EQ(cell.driver.taken_.size(), moves) << "it stands until it is resumed";
  const int looks = table.looks;
  table.came = false;
  EXPECT_EQ(table.watches_anew, 1) << "at first";
  cell.run.resume();
  table.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(table.watches_anew, 2) << "a person has looked; else it goes on from how it was";
  EXPECT_GT(table.watches, 2);
  EXPECT_FALSE(table.watched);
  EXPECT_EQ(table.taken.size(), 2U);
  EXPECT_GT(table.looks, looks);
}

TEST(CubeRun, who_resumes_before_the_next_poll_is_not_paused_by_the_same_again) {
  PlainCell cell("learm", std::string(kReady) + "pick\n place x=60mm y=180mm z=80mm\n");
  cell.run.make_changeable();
  Table table(cell);
  table.cubes = {cube_at(0.17, 0, ColorName::kRed)};
  while (!table.watched && cell.now < Instant{} + 30s) table.go(cell.now - Instant{} + 1ms);
  ASSERT_TRUE(table.watched);
  table.came = true;
  while (!cell.run.paused() && cell.now < Instant{} + 30s) table.go(cell.now - Instant{} + 1ms);
  ASSERT_TRUE(cell.run.paused());
  cell.run.resume();
  table.go();
  ASSERT_EQ(cell.run.phase(), Phase::kDone);
  EXPECT_EQ(cell.run.notices().size(), 1U);
}

}  // namespace
}  // namespace sinew::program
