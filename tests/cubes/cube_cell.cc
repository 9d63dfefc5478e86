#include "cubes/cube_cell.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "sinew/config/robot_file.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/program/language/program_file.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"

namespace sinew::cubes {
namespace {

using vision::ColorName;

constexpr double kEdge = 0.025;  // m
constexpr control::ClientId kClient = 1;

constexpr double kClear = 0.045;  // m, that cubes begin away from what stands on the table
const Vec3 kTable_W{0.15, 0.04, 0};
const Vec3 kBasket_W{0.06, 0.18, 0};

bool is_beside(const Thing& thing, const Vec3& p_W) {
  constexpr double kFlat = 1e-3;  // m; cubes may lie on what is flatter
  if (2 * thing.half.z < kFlat) return true;
  const Vec3 p = thing.X_WS.inverse() * (p_W - kTable_W);
  const double out_x = std::abs(p.x) - thing.half.x, out_y = std::abs(p.y) - thing.half.y;
  return std::hypot(std::max(0.0, out_x), std::max(0.0, out_y)) > kClear;
}

/// As it is believed to hang.
vision::TableCamera camera_of(const CubeCellSettings& settings) {
  vision::TableCamera camera = runtime::usual_camera();
  camera.model.lens = settings.lens;
  if (settings.sheet) camera.sheet = "a4";
  return camera;
}

/// Whether the camera sees all of a cube's top there, however it is turned.
bool is_in_picture(const vision::TableCamera& camera, const Vec3& p_W) {
  const double far = kEdge / std::sqrt(2.0);
  const Vec3 p = p_W - kTable_W;
  for (const double x : {-far, far}) {
    for (const double y : {-far, far}) {
      const Vec3 corner{p.x + x, p.y + y, p.z + kEdge};
      const auto px = camera.model.project(camera.X_WC.inverse() * corner);
      const bool inside =
          px && px->x > 0 && px->y > 0 && px->x < camera.model.width && px->y < camera.model.height;
      if (!inside) return false;
    }
  }
  return true;
}

/// In the picture, beside the basket, a hand's breadth of each other or less; in reach of the arm
/// or anywhere in front of it.
std::vector<CellCube> cubes_of(const CubeCellSettings& settings) {
  SplitMix64 random(settings.seed);
  const vision::TableCamera camera = camera_of(settings);
  const auto colors = settings.anywhere ? ColorName::kWood : ColorName::kPink;  // those before it
  std::vector<CellCube> cubes;
  for (int tries = 0; cubes.size() < settings.cubes && tries < 1000; ++tries) {
    const double reach = settings.anywhere ? random.uniform(0.09, 0.26) : random.uniform(0.14, 0.2);
    const double widest = from_deg(settings.anywhere ? 40 : 30);
    const double turn = random.uniform(-widest, widest);
    const CellCube cube{
        .color = static_cast<int>(random.bits() % static_cast<std::uint64_t>(colors)),
        .p_W = {reach * std::cos(turn), reach * std::sin(turn), 0},
        .turn = random.uniform(0, kPi / 2)};
    const double apart = settings.anywhere ? 1.42 * kEdge : 1.5 * kEdge;
    bool free = std::ranges::all_of(cubes, [&](const CellCube& other) {
      return std::hypot(other.p_W.x - cube.p_W.x, other.p_W.y - cube.p_W.y) > apart;
    });
    free = free && (!settings.anywhere || is_in_picture(camera, cube.p_W));
    for (const Thing& thing : settings.clutter) free = free && is_beside(thing, cube.p_W);
    // Its own half diagonal beside the basket's wall, or a finger's room.
    const Vec3 beside = cube.p_W - kBasket_W;
    free = free && std::max(std::abs(beside.x), std::abs(beside.y)) > 0.063 + 0.03;
    if (!free) continue;
    cubes.push_back(cube);
    if (!settings.towers) continue;
    cubes.push_back(cube);
    cubes.back().p_W.z += kEdge;
    cubes.back().color = (cube.color + 2) % 6;
  }
  return cubes;
}

/// The arms of the examples are longer than the LeArm.
constexpr double kBehind = -0.11;  // m

std::string example_file(const std::string& robot) {
  return SINEW_SOURCE_DIR "/robots/examples/" + robot + ".toml";
}
bool is_example(const std::string& robot) {
  return std::filesystem::exists(example_file(robot));
}

std::string text_of(const std::string& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

RobotModel model_of(const CellRobot& robot) {
  const RobotModel model = is_example(robot.robot)
                               ? *read_robot(text_of(example_file(robot.robot)), robot.robot)
                               : test::robot(robot.robot);
  return *runtime::variant_of(model, robot.profile, std::nullopt);
}

Cell cell_of(const CubeCellSettings& settings) {
  Cell cell;
  cell.title = "cubes";
  cell.time_scale = settings.pace;
  CellRobot& robot = cell.robots.emplace_back();
  robot.name = "arm";
  robot.robot = settings.robot;
  robot.seed = 7;  // it begins clear of its table
  if (settings.robot == "learm") robot.profile = "bus";
  if (settings.robot == "maxarm") robot.X_WB.R = rotation_z(kPi / 2);  // its front is -y
  if (is_example(settings.robot)) robot.X_WB.p.x = kBehind;
  CellCamera& camera = cell.cameras.emplace_back();
  camera.name = "top";
  camera.device = kSimulatedCamera;
  camera.cube = kEdge;
  camera.X_WT.p = kTable_W;
  cell.baskets.emplace_back();
  cell.baskets[0].name = "basket";
  cell.baskets[0].X_WK.p = kBasket_W;
  cell.cubes = cubes_of(settings);
  return cell;
}

/// Beside the jaws of a LeArm, turned towards the middle of the cubes.
runtime::CameraMount mount_on(const RobotModel& learm) {
  const JointVector look{0, from_deg(-20), from_deg(80), from_deg(90), 0};
  const kinematics::SerialChain chain(std::get<SerialGeometry>(learm.geometry));
  const auto X_WC = render::looking_at({0.097, 0.06, 0.161}, {0.175, 0, 0});
  const auto X_BC = relabel<frame::Base, frame::Camera>(X_WC);  // its base is the cell's frame
  return {0, chain.forward(look).inverse() * X_BC, {}};
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
    text += fmt::format("line {}: {}\n", job.failure->line, describe(job.failure->error));
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
  const RobotModel model = model_of(cell.robots.front());
  auto running = runtime::RunningCell::start(std::move(cell), {model}, {});
  if (!running) {
    ADD_FAILURE() << running.error().sentence;
    return;
  }
  cell_ = std::move(*running);
  client_ = *runtime::StationClient::make(cell_->station(0), kClient);
  vision::TableCamera believed = camera_of(settings);
  vision::TableCamera real = believed;
  const PlanarError& off = settings.calibration;
  real.X_WC.p = rotation_z(off.turn) * real.X_WC.p + Vec3{off.x, off.y, 0};
  real.X_WC.R = rotation_z(off.turn) * real.X_WC.R;
  render::CellView around;
  around.seed = settings.surroundings;
  around.reach = 0.25;
  around.clutter = settings.clutter;
  around.brightness = settings.brightness;
  around.lamps = settings.lamps;
  cell_->table()->set_surroundings(around);
  const auto robots = [this] { return cell_->robots_in_view(runtime::RunningCell::Stand::kTrue); };
  if (settings.on_arm) {
    believed.model = real.model = vision::pinhole(640, 480, from_deg(60));
    const runtime::CameraMount mount = mount_on(robot());
    const auto hangs = [this, mount] {
      return cell_->hangs(mount, runtime::RunningCell::Stand::kTrue);
    };
    cell_->open_camera(0, {"arm", believed, kEdge},
                       cell_->table()->pictures(real, robots, 0, hangs), {}, mount);
    return;
  }
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
  parsed->table = cell_->table_top(0);
  order.program = std::move(*parsed);
  order.take_over = true;
  // A test's thread may wait for a core longer than a lease lasts at this pace.
  order.on_client_loss = ClientLoss::kContinue;
  ASSERT_TRUE(cell_->jobs(0).start(std::move(order), kClient));
}

void CubeCell::keep_lease() {
  client_->refresh();
  while (client_->take_event()) {
  }
  client_->act_for(kClient);  // under the lease that the job has taken
  client_->keep_lease(clock_.now());
}

std::string CubeCell::own_program() const {
  if (is_example(robot().id)) {
    return "joint J1=-70deg\nrepeat while seen\n  pick\n  place basket\nend\n";
  }
  return text_of(SINEW_SOURCE_DIR "/robots/" + robot().id + "/pick_and_place.sinew");
}

void CubeCell::stand_aside() {
  const std::string rows = own_program();
  const Ended ended = run(rows.substr(0, rows.find("\nrepeat") + 1));
  EXPECT_EQ(ended.job.phase, program::Run::Phase::kDone) << ended.text();
  table().cubes().with([](sim::CubeWorld& world) { world.clear_events(); });
}

Ended CubeCell::run_own_program(const std::function<void()>& look) {
  begin(own_program());
  return finish(std::chrono::minutes(10), look);
}

JointVector CubeCell::joints() const {
  JointVector q;
  const runtime::StationView view = cell_->station(0).view();
  for (const sim::JointTruth& joint : view.truth->joints) q.push_back(joint.q);
  return q;
}

Ended CubeCell::finish(Duration patience, const std::function<void()>& look) {
  const Instant end = clock_.now() + patience;
  while (!cell_->jobs(0).view().over && clock_.now() < end) {
    keep_lease();
    if (look) look();
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
