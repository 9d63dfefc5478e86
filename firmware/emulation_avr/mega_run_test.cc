#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "faults/fault_cell.h"
#include "firmware/emulation_avr/mega_arm.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/text_form.h"
#include "sinew/program/formats/text_forms.h"
#include "sinew/program/plans/row_planner.h"
#include "sinew/program/runs/program_run.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"

// Programs of the BigRobotArm from their text to the pulses at the pins of an emulated chip, which
// runs the image that is flashed: with its own wire, and with a client of the old ones.

namespace sinew::emulation {
namespace {

using namespace std::chrono_literals;

struct MegaCell {
  MegaCell(const std::string& wire, const std::string& file)
      : model(*runtime::variant_of(test::robot("bigrobotarm"), {}, wire)),
        arm(new MegaArm(big_robot_arm_of(*model.device.settings)->joints)),
        cell(model, RobotMachine{std::unique_ptr<sim::ByteMachine>(arm), nullptr}, 10ms),
        loop(model, cell.driver(), {.opening_limit = model.device.settings->opening().limit}, {},
             nullptr) {
    std::ifstream stream(std::string(SINEW_ROBOTS_DIR "/bigrobotarm/") + file);
    const std::string text(std::istreambuf_iterator<char>(stream), {});
    const program::TextForm* form = program::form_of_text(file, text, model);
    if (form != nullptr) {
      auto read = program::read_form(*form, text, file, model);
      if (read) program = std::move(*read);
    } else if (auto read = program::parse(text, file, model)) {
      program = std::move(*read);
    }
  }

  /// @param look  after each step of the control loop
  void go(const std::function<void()>& look = {}) {
    run.emplace(program, loop.machine());
    run->declare({.q = home_joints(model), .has_looked = false});
    run->start(cell.now());
    ASSERT_TRUE(cell.run_to(Instant{} + 10min, 2ms, [&] {
      loop.step(cell.now(), [&] { run->poll(cell.now()); });
      if (look) look();
      return run->finished();
    }));
    ASSERT_EQ(run->phase(), program::Run::Phase::kDone)
        << (run->failure() ? describe(run->failure()->error) : "");
  }
  /// s, by the program's own records
  double took() const {
    return to_seconds(run->records().back().done - run->records().front().asked);
  }

  RobotModel model;
  MegaArm* arm;  ///< the cell's
  test::FaultCell cell;
  runtime::ControlLoop loop;
  program::Program program;
  std::optional<program::Run> run;
};

/// The motion that an order asked for, and how far the pins have left it.
class Planned {
 public:
  explicit Planned(const RobotModel& model) : model_(model), planner_(model) {}

  /// False where it moves nothing.
  bool begin(const program::Record& record) {
    const auto* order = std::get_if<program::MoveOrder>(&record.order->what);
    if (order == nullptr || !record.q_start) return false;
    const auto motion = planner_.plan(*record.q_start, order->tool, order->rows);
    EXPECT_TRUE(motion);
    ways_.clear();
    const auto trajectory = planner_.motion().trajectory();
    for (double t = 0; t <= motion->duration + kStep; t += kStep) {
      planning::JointMotion at;
      trajectory.sample(t, at);
      ways_.push_back(at.q);
    }
    return true;
  }
  /// Largest distance of a joint, in its steps, at the nearest moment of the plan.
  double steps_aside(const sim::Truth& truth) const {
    const auto& joints = big_robot_arm_of(*model_.device.settings)->joints;
    double least = 1e9;
    for (const planning::JointArray& q : ways_) {
      double most = 0;
      for (std::size_t i = 0; i < joints.size(); ++i) {
        const double aside = std::abs(truth.joints[i].q - q[i]);
        most = std::max(most, aside * std::abs(joints[i].steps_per_rad));
      }
      least = std::min(least, most);
    }
    return least;
  }

 private:
  static constexpr double kStep = 0.5e-3;  // s

  const RobotModel& model_;
  program::RowPlanner planner_;
  std::vector<planning::JointArray> ways_;
};

TEST(MegaRun, a_program_over_the_arm_link_is_made_to_the_step) {
  MegaCell cell("framed", "demonstration.sinew");
  struct Sample {
    const program::Order* order;
    sim::Truth truth;
  };
  std::vector<Sample> samples;
  cell.go([&] {
    const auto& now = cell.run->under_way();
    if (now) samples.push_back({now->order, cell.arm->truth()});
  });
  Planned planned(cell.model);
  double worst = 0;
  int looked = 0;
  for (const program::Record& record : cell.run->records()) {
    if (!planned.begin(record)) continue;
    for (const Sample& sample : samples) {
      if (sample.order != record.order) continue;
      worst = std::max(worst, planned.steps_aside(sample.truth));
      ++looked;
    }
  }
  EXPECT_GT(looked, 1000);
  EXPECT_LE(worst, 1.5);
  std::printf("  %.1f s, %d looks at the pins, %.2f steps beside the plan at most\n", cell.took(),
              looked, worst);
  const auto& joints = big_robot_arm_of(*cell.model.device.settings)->joints;
  const auto positions = cell.cell.driver().positions();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double step = 1 / std::abs(joints[i].steps_per_rad);
    EXPECT_NEAR(cell.arm->truth().joints[i].q, positions[i].q, 0.6 * step) << i;
  }
}

/// The document's own sequence, five rounds.
class MegaSequence : public testing::TestWithParam<const char*> {};

TEST_P(MegaSequence, runs_to_its_last_step) {
  MegaCell cell(GetParam(), "sequence.txt");
  cell.go();
  const std::array<std::int64_t, 5> last{0, 50, 5000, 1500, 0};
  for (std::size_t i = 0; i < last.size(); ++i) EXPECT_EQ(cell.arm->board().steps(i), last[i]) << i;
  EXPECT_EQ(cell.arm->board().watchdog_restarts(), 0);
  std::printf("  %s: %.1f s\n", GetParam(), cell.took());
}

INSTANTIATE_TEST_SUITE_P(Wires, MegaSequence, testing::Values("byte", "framed"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace sinew::emulation
