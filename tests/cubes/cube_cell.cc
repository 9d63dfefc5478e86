#include "cubes/cube_cell.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/model/error_sentence.h"
#include "sinew/program/program_file.h"
#include "sinew/runtime/robot_variant.h"
#include "support/robots.h"

namespace sinew::cubes {
namespace {

constexpr double kEdge = 0.025;  // m
constexpr control::ClientId kClient = 1;

/// In reach of the arm and beside its basket, a hand's breadth of each other or less.
std::vector<CellCube> cubes_of(const CubeCellSettings& settings) {
  SplitMix64 random(settings.seed);
  std::vector<CellCube> cubes;
  for (int tries = 0; cubes.size() < settings.cubes && tries < 1000; ++tries) {
    const double reach = random.uniform(0.14, 0.2);
    const double turn = random.uniform(-from_deg(30), from_deg(30));
    const CellCube cube{.color = static_cast<int>(random.bits() % 6),
                        .p_W = {reach * std::cos(turn), reach * std::sin(turn), 0},
                        .turn = random.uniform(0, kPi / 2)};
    const bool free = std::ranges::all_of(cubes, [&](const CellCube& other) {
      return std::hypot(other.p_W.x - cube.p_W.x, other.p_W.y - cube.p_W.y) > 1.5 * kEdge;
    });
    if (!free) continue;
    cubes.push_back(cube);
    if (!settings.towers) continue;
    cubes.push_back(cube);
    cubes.back().p_W.z += kEdge;
    cubes.back().color = (cube.color + 2) % 6;
  }
  return cubes;
}

Cell cell_of(const CubeCellSettings& settings) {
  Cell cell;
  cell.title = "cubes";
  cell.time_scale = settings.pace;
  CellRobot& robot = cell.robots.emplace_back();
  robot.name = "arm";
  robot.robot = "learm";
  robot.profile = "bus";
  robot.seed = 7;  // it begins clear of its table
  CellCamera& camera = cell.cameras.emplace_back();
  camera.name = "top";
  camera.device = kSimulatedCamera;
  camera.cube = kEdge;
  camera.X_WT.p = {0.15, 0.04, 0};
  cell.basket.emplace();
  cell.basket->name = "basket";
  cell.basket->X_WK.p = {0.06, 0.18, 0};
  cell.cubes = cubes_of(settings);
  return cell;
}

}  // namespace

std::size_t Ended::count(sim::CubePlace where) const {
  return static_cast<std::size_t>(std::ranges::count(cubes, where, &sim::CubeState::where));
}

std::size_t Ended::count(sim::CubeEvent::Kind kind) const {
  return static_cast<std::size_t>(std::ranges::count(events, kind, &sim::CubeEvent::kind));
}

std::string Ended::text() const {
  std::string text;
  if (job.failure) {
    text += fmt::format("line {}: {}\n", job.failure->line,
                        sentence_of(job.failure->error, test::robot("learm")));
  }
  for (const sim::CubeEvent& event : events) {
    text +=
        fmt::format("{:8.2f} s  {} {} {:.4f}\n", to_seconds(event.time.time_since_epoch()),
                    name(event.kind), event.cube ? std::to_string(*event.cube) : "-", event.amount);
  }
  for (const sim::CubeState& cube : cubes) {
    text += fmt::format("cube at {:.3f}, {:.3f}, {:.3f}: place {}\n", cube.X_WO.p.x, cube.X_WO.p.y,
                        cube.X_WO.p.z, static_cast<int>(cube.where));
  }
  return text;
}

CubeCell::CubeCell(const CubeCellSettings& settings) {
  Cell cell = cell_of(settings);
  auto model = runtime::variant_of(test::robot("learm"), "bus", std::nullopt);
  auto running = runtime::RunningCell::start(std::move(cell), {*model}, {});
  if (!running) {
    ADD_FAILURE() << running.error().sentence;
    return;
  }
  cell_ = std::move(*running);
  client_ = *runtime::StationClient::make(cell_->station(0), kClient);
  vision::TableCamera believed = runtime::usual_camera();
  if (settings.sheet) believed.sheet = "a4";
  vision::TableCamera real = believed;
  real.X_WC.p.x += settings.off;
  const auto robots = [this] { return cell_->robots_in_view(runtime::RunningCell::Stand::kTrue); };
  cell_->open_camera(0, {"top", believed, kEdge}, cell_->table()->pictures(real, robots),
                     cell_->table()->glances(real, robots));
}

Ended CubeCell::run(const std::string& program, Duration patience) {
  begin(program);
  return finish(patience);
}

void CubeCell::begin(const std::string& program) {
  auto parsed = program::parse(program, "test.sinew", cell_->station(0).robot());
  ASSERT_TRUE(parsed) << to_text(parsed.error().front());
  runtime::JobOrder order;
  order.title = "test";
  order.program = std::move(*parsed);
  order.take_over = true;
  ASSERT_TRUE(cell_->jobs(0).start(std::move(order), kClient));
}

void CubeCell::keep_lease() {
  client_->refresh();
  while (client_->take_event()) {
  }
  client_->act_for(kClient);  // under the lease that the job has taken
  client_->keep_lease(clock_.now());
}

Ended CubeCell::finish(Duration patience) {
  const Instant end = clock_.now() + patience;
  while (!cell_->jobs(0).view().over && clock_.now() < end) {
    keep_lease();
    clock_.pause(std::chrono::milliseconds(2));
  }
  const runtime::JobView job = cell_->jobs(0).view();
  EXPECT_TRUE(job.over) << "not over after " << to_seconds(patience) << " s";
  Ended ended{.job = job, .cubes = {}, .events = {}};
  table().cubes().with([&](const sim::CubeWorld& world) {
    ended.cubes.assign(world.cubes().begin(), world.cubes().end());
    ended.events.assign(world.events().begin(), world.events().end());
  });
  return ended;
}

}  // namespace sinew::cubes
