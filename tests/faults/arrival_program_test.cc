#include <gtest/gtest.h>

#include <fstream>
#include <iostream>
#include <iterator>

#include "faults/fault_cell.h"
#include "sinew/devices/kinds.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/runs/program_run.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"

/// Whether a program takes as long as `sinew plan FILE` says: its whole time, with its waits and
/// its tools, on each robot's own bytes against the physics of its simulation.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;

struct Sample {
  const char* file;  ///< below robots/
  const char* robot;
  const char* profile;
  bool at_home = true;      ///< it stands there; somebody says so where it cannot know
  std::uint64_t seeds = 1;  ///< machines whose boards answer at other times
};

void PrintTo(const Sample& sample, std::ostream* out) {
  *out << sample.file << " on " << sample.profile;
}

class ProgramTimes : public testing::TestWithParam<Sample> {};

TEST_P(ProgramTimes, are_as_planned) {
  const Sample& sample = GetParam();
  const RobotModel model = *runtime::variant_of(robot(sample.robot), sample.profile, {});
  std::ifstream file(std::string(SINEW_ROBOTS_DIR "/") + sample.file);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto program = program::parse(text, sample.file, model);
  ASSERT_TRUE(program) << to_text(program.error().front());
  double planned = 0, least = 1e9, most = 0;
  for (std::uint64_t seed = 1; seed <= sample.seeds; ++seed) {
    FaultCell cell(model, {.profile = sample.profile, .seed = seed}, 20s);
    runtime::ControlLoop loop(model, cell.driver(),
                              {.opening_limit = model.device.settings->opening().limit}, {},
                              nullptr);
    program::Run run(*program, loop.machine());
    if (sample.at_home) run.declare({.q = home_joints(model), .has_looked = false});
    run.start(cell.now());
    ASSERT_TRUE(cell.run_to(Instant{} + 1h, 2ms, [&] {
      loop.step(cell.now(), [&] { run.poll(cell.now()); });
      return run.finished();
    }));
    ASSERT_EQ(run.phase(), program::Run::Phase::kDone)
        << (run.failure() ? describe(run.failure()->error) : "");
    const double took = to_seconds(run.records().back().done - run.records().front().asked);
    planned = run.plan().duration;
    EXPECT_NEAR(took, planned, 0.02 * planned) << "seed " << seed;
    if (sample.at_home) {
      // As `sinew plan` makes it, where nothing else is said.
      const auto plan = program::make_plan(*program, model, home_joints(model));
      ASSERT_TRUE(plan);
      EXPECT_NEAR(took, plan->duration, 0.02 * plan->duration) << "seed " << seed;
    }
    least = std::min(least, took);
    most = std::max(most, took);
  }
  std::cout << "  planned " << planned << " s, took " << least << " to " << most << " s ("
            << 100 * (least / planned - 1) << " to " << 100 * (most / planned - 1) << " %)\n";
}

INSTANTIATE_TEST_SUITE_P(
    Samples, ProgramTimes,
    testing::Values(Sample{"maxarm/pick.sinew", "maxarm", "arduino", true, 20},
                    Sample{"maxarm/pick.sinew", "maxarm", "micropython", true, 20},
                    Sample{"maxarm/stack.sinew", "maxarm", "arduino", true, 20},
                    Sample{"maxarm/stack.sinew", "maxarm", "micropython", true, 20},
                    Sample{"bigrobotarm/line.sinew", "bigrobotarm", "document"},
                    Sample{"bigrobotarm/wave.sinew", "bigrobotarm", "document"},
                    Sample{"learm/square.sinew", "learm", "lsc6"},
                    Sample{"learm/wave.sinew", "learm", "lsc6"},
                    Sample{"learm/square.sinew", "learm", "bus", false},
                    Sample{"learm/wave.sinew", "learm", "bus", false}));

}  // namespace
}  // namespace sinew::test
