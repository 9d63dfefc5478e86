#include <gtest/gtest.h>

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "cubes/campaign.h"
#include "cubes/cube_cell.h"
#include "sinew/core/error_code.h"

namespace sinew::cubes {
namespace {

using sim::CubePlace;
using Kind = sim::CubeEvent::Kind;

/// The arm stands aside while the camera looks.
const std::string kStand = "joint base=-60deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg\n";

/// The robot's own pick_and_place.sinew in cells of 1 to 4 cubes.
void expect_in_the_basket(const std::vector<std::uint64_t>& seeds, const std::string& robot) {
  std::size_t all = 0, placed = 0, pauses = 0;
  for (const std::uint64_t seed : seeds) {
    CubeCell cell({.seed = seed,
                   .cubes = 1 + seed % 4,
                   .robot = robot,
                   .surroundings = robot == "maxarm" ? seed : 1});
    cell.stand_aside();
    // Time runs 20 times faster here, and a camera's look does not: on a loaded computer an arm may
    // be gone from where it was thought to be. A person looks, and has it go on.
    bool was_paused = false;
    const Ended ended = cell.run_own_program([&] {
      const runtime::JobView job = cell.cell().jobs(0).view();
      pauses += job.paused && !was_paused ? 1 : 0;
      was_paused = job.paused;
      if (job.paused) cell.cell().jobs(0).resume(job.id);
    });
    SCOPED_TRACE("cell " + std::to_string(seed) + "\n" + ended.text());
    EXPECT_EQ(ended.job.phase, program::Run::Phase::kDone);
    EXPECT_EQ(ended.count(Kind::kThrown), 0U);
    EXPECT_EQ(ended.count(Kind::kCrash), 0U);
    EXPECT_EQ(ended.count(Kind::kFell), 0U);
    all += ended.cubes.size();
    placed += ended.count(CubePlace::kBasket);
  }
  std::printf("  %zu of %zu cubes are in the basket, %zu pauses\n", placed, all, pauses);
  EXPECT_LE(pauses, 3U) << "nothing came into view";
  EXPECT_GE(static_cast<double>(placed), 0.98 * static_cast<double>(all));
}

TEST(Cubes, all_that_are_seen_come_into_the_basket) {
  expect_in_the_basket({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, "learm");
}

TEST(Cubes, a_cup_takes_all_that_are_seen_into_the_basket) {
  expect_in_the_basket({1, 2, 3, 4, 5}, "maxarm");
}

TEST(Cubes, an_arm_with_six_joints_and_jaws_takes_all_that_are_seen_into_the_basket) {
  expect_in_the_basket({1, 2, 3, 4}, "six-axis");
}

TEST(Cubes, an_so_101_takes_all_that_are_seen_into_the_basket) {
  expect_in_the_basket({1, 2, 3, 4}, "so-101");
}

TEST(Cubes, a_camera_on_the_arm_sees_them_from_where_the_arm_stands) {
  std::size_t seen = 0, placed = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    CubeCell cell({.seed = seed, .cubes = 1 + seed % 3, .on_arm = true});
    cell.stand_aside();
    ASSERT_EQ(cell.run(kLookFromArm + "look\n").job.phase, program::Run::Phase::kDone);
    seen += cell.cell().camera(0)->newest()->seen.cubes.size();
    const Ended ended = cell.run(kLookFromArm + "repeat while seen\n  pick\n  place basket\nend\n");
    SCOPED_TRACE("cell " + std::to_string(seed) + "\n" + ended.text());
    EXPECT_EQ(ended.job.phase, program::Run::Phase::kDone);
    EXPECT_EQ(ended.count(Kind::kThrown), 0U);
    EXPECT_EQ(ended.count(Kind::kCrash), 0U);
    placed += ended.count(CubePlace::kBasket);
  }
  std::printf("  %zu of %zu cubes are in the basket\n", placed, seen);
  EXPECT_GE(seen, 6U) << "of 8, some beside the picture or behind the jaws";
  EXPECT_EQ(placed, seen);
}

TEST(Cubes, a_camera_on_an_arm_that_moves_says_so_and_sees_where_it_went_then) {
  CubeCell cell({.seed = 1, .cubes = 2, .pace = 2, .on_arm = true});
  ASSERT_EQ(cell.run(kLookFromArm + "look\n").job.phase, program::Run::Phase::kDone);
  runtime::Camera& camera = *cell.cell().camera(0);
  const auto first = camera.newest();
  ASSERT_FALSE(first->fault);
  ASSERT_FALSE(first->seen.cubes.empty());
  cell.begin("joint base=-70deg speed=15%\n");
  std::optional<Error> fault;
  cell.finish(std::chrono::minutes(1), [&] {
    camera.refresh();
    if (!fault) fault = camera.newest()->fault;
  });
  ASSERT_TRUE(fault);
  EXPECT_EQ(info(fault->code).name, "camera_in_motion");
  ASSERT_EQ(cell.run("joint base=-12deg\nlook\n").job.phase, program::Run::Phase::kDone);
  const auto then = camera.newest();
  EXPECT_GT(norm(then->X_TC.p - first->X_TC.p), 0.02);
  // The same cubes, seen from elsewhere.
  std::size_t same = 0;
  for (const vision::SeenCube& now : then->seen.cubes) {
    for (const vision::SeenCube& before : first->seen.cubes) {
      if (!now.position || !before.position) continue;
      same += norm(now.position->top_W - before.position->top_W) < 3e-3 ? 1 : 0;
    }
  }
  EXPECT_GT(same, 0U);
}

/// `make campaign PARTS=cubes` runs more of them; SINEW_FIRST is the first one's seed.
TEST(CubeCampaign, cubes_in_reach_come_into_the_basket_and_nothing_else_is_touched) {
  const auto number = [](const char* name, std::uint64_t usual) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::strtoull(text, nullptr, 10) : usual;
  };
  const std::uint64_t cells = number("SINEW_CELLS", 0), first = number("SINEW_FIRST", 1);
  if (cells == 0) GTEST_SKIP() << "SINEW_CELLS says how many";
  Tally tally;
  for (std::uint64_t seed = first; seed < first + cells; ++seed) {
    const std::size_t told = tally.findings.size();
    run_cell(seed, tally);
    std::printf("  seed %" PRIu64 ": %zu of %zu so far\n", seed, tally.placed, tally.reachable);
    for (std::size_t i = told; i < tally.findings.size(); ++i) {
      std::printf("    %s\n", tally.findings[i].c_str());
    }
    std::fflush(stdout);
  }
  std::printf("%s", tally.table().c_str());
  EXPECT_GE(static_cast<double>(tally.placed), 0.98 * static_cast<double>(tally.reachable));
  EXPECT_EQ(tally.thrown, 0U);
  EXPECT_EQ(tally.contacts, 0U);
  EXPECT_EQ(tally.outside, 0U);
  EXPECT_EQ(tally.refused_wrongly, 0U);
  EXPECT_EQ(tally.knocked_refused, tally.knocked);
}

/// Single cubes and towers of two, in turn.
TEST(Cubes, what_is_seen_is_where_it_lies) {
  constexpr double kSame = 0.01;  // m
  std::size_t tops = 0, found = 0, wrong = 0;
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CubeCell cell({.seed = seed, .cubes = 4, .towers = seed % 2 == 0});
    const Ended ended = cell.run(kStand + "look\n");
    ASSERT_EQ(ended.job.phase, program::Run::Phase::kDone) << ended.text();
    const auto shot = cell.cell().camera(0)->newest();
    for (const vision::SeenCube& seen : shot->seen.cubes) {
      double nearest = 1;
      for (const sim::CubeState& cube : ended.cubes) {
        const Vec3 top = cube.X_WO.p + Vec3{0, 0, cube.edge / 2};
        nearest = std::min(nearest, norm(top - seen.position->top_W));
      }
      ++(nearest > kSame ? wrong : found);
      if (nearest <= kSame) squares += nearest * nearest;
    }
    tops += seed % 2 == 0 ? ended.cubes.size() / 2 : ended.cubes.size();
  }
  const double rms = std::sqrt(squares / static_cast<double>(found));
  std::printf("  %zu of %zu seen, %zu elsewhere, %.2f mm rms\n", found, tops, wrong, 1e3 * rms);
  EXPECT_GE(found, tops - tops / 20);
  EXPECT_LE(wrong, tops / 20);
  EXPECT_LT(rms, 2e-3);
}

TEST(Cubes, a_camera_that_cannot_be_trusted_ends_the_program_and_nothing_moves) {
  CubeCell cell({.seed = 7, .cubes = 2, .sheet = true});
  EXPECT_EQ(cell.run(kStand + "look\n").job.phase, program::Run::Phase::kDone);
  const JointVector before = cell.joints();
  using Trouble = runtime::SimulatedTable::Trouble;
  Trouble unplugged, covered, frozen, knocked;
  unplugged.unplugged = covered.covered = frozen.frozen = true;
  knocked.knocked = {0.012, 0, 0};
  const std::pair<Trouble, ErrorCode> kCases[] = {{unplugged, ErrorCode::kCameraLost},
                                                  {covered, ErrorCode::kCameraBlind},
                                                  {frozen, ErrorCode::kCameraFrozen},
                                                  {knocked, ErrorCode::kCameraMoved}};
  for (const auto& [trouble, code] : kCases) {
    cell.table().set_trouble(trouble);
    const Ended ended = cell.run("pick\n");
    ASSERT_TRUE(ended.job.failure) << info(code).name;
    EXPECT_EQ(info(ended.job.failure->error.code).name, info(code).name);
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(cell.joints()[i], before[i], 1e-3);
    cell.table().set_trouble({});
    EXPECT_EQ(cell.run("look\n").job.phase, program::Run::Phase::kDone) << "it is there again";
  }
}

TEST(Cubes, a_hand_that_comes_into_view_while_the_arm_moves_pauses_it) {
  CubeCell cell({.seed = 3, .cubes = 2, .pace = 2});
  const auto until = [&](const auto& is_so, Duration patience) {
    const io::Clock clock;
    const Instant end = clock.now() + patience;
    while (!is_so(cell.cell().jobs(0).view()) && clock.now() < end) {
      cell.keep_lease();
      clock.pause(std::chrono::milliseconds(5));
    }
    return is_so(cell.cell().jobs(0).view());
  };
  using std::chrono::seconds;
  cell.begin(kStand + "repeat while seen\n  pick\n  place x=60mm y=180mm z=110mm\nend\n");
  // On its way to the first cube.
  ASSERT_TRUE(until([](const auto& job) { return job.over || job.line == 3; }, seconds(60)));
  until([](const auto& job) { return job.over; }, std::chrono::milliseconds(1500));
  ASSERT_FALSE(cell.cell().jobs(0).view().paused) << "an arm in its own view is no reason";
  runtime::SimulatedTable::Trouble hand;
  hand.hand = render::ViewedHand{{0.1, -0.12, 0.03}, -1.6};
  cell.table().set_trouble(hand);
  ASSERT_TRUE(until([](const auto& job) { return job.over || job.paused; }, seconds(20)));
  const runtime::JobView job = cell.cell().jobs(0).view();
  ASSERT_TRUE(job.paused && job.paused_by);
  EXPECT_EQ(info(job.paused_by->code).name, info(ErrorCode::kViewDisturbed).name);
  cell.table().set_trouble({});
  until([](const auto& one) { return one.over; }, seconds(3));
  EXPECT_TRUE(cell.cell().jobs(0).view().paused) << "a person says when it goes on";
  cell.cell().jobs(0).resume(job.id);
  const Ended ended = cell.finish();
  EXPECT_EQ(ended.job.phase, program::Run::Phase::kDone) << ended.text();
  EXPECT_EQ(ended.count(CubePlace::kBasket), 2U) << ended.text();
}

}  // namespace
}  // namespace sinew::cubes
