#include "sinew/runtime/running_cell.h"

#include <algorithm>
#include <thread>

#include "sinew/core/assert.h"

namespace sinew::runtime {
namespace {

StationOptions options_of(const CellRobot& robot, const CellFolders& folders) {
  StationOptions options;
  options.name = robot.name;
  options.port = robot.port;
  options.simulated.variant = {.profile = robot.profile, .seed = robot.seed};
  options.journal = robot.journal;
  // What behind a pseudo-terminal begins anew each time has nothing to remember.
  if (!options.journal && !may_be_simulated(robot.port)) options.journal = robot.name;
  options.journal_folder = folders.journal;
  options.flight_folder = folders.flight;
  options.record_folder = folders.record;
  options.records_jobs = folders.records_jobs || !folders.record.empty();
  return options;
}

}  // namespace

std::string results_file(const CellFolders& folders, const Station& station) {
  if (folders.commissioning.empty()) return {};
  return folders.commissioning + "/" + station.name() +
         (may_be_simulated(station.options().port) ? ".simulated.json" : ".json");
}

io::IoResult<std::unique_ptr<RunningCell>> RunningCell::start(
    Cell cell, std::vector<RobotModel> robots, const CellFolders& folders,
    const std::function<void(StationOptions&)>& adjust) {
  SINEW_ASSERT(robots.size() == cell.robots.size());
  std::unique_ptr<RunningCell> running(new RunningCell(std::move(cell), folders));
  running->space_ = std::make_unique<CellSpace>(running->cell_, robots);
  running->baskets_ = std::make_unique<CellBaskets>(running->cell_.baskets);
  if (!folders.baskets.empty()) {
    if (const auto kept = running->baskets_->keep_in(folders.baskets); !kept) {
      return std::unexpected(kept.error());
    }
  }
  running->cameras_.resize(running->cell_.cameras.size());
  running->beside_.resize(running->cell_.cameras.size());
  running->newest_eyes_ = std::vector<std::atomic<CubeEyes*>>(robots.size());
  if (running->cell_.simulated_camera() != nullptr) {
    running->table_ = std::make_unique<SimulatedTable>(running->cell_, running->baskets_->all());
  }
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const CellRobot& place = running->cell_.robots[i];
    StationOptions options = options_of(place, folders);
    options.space = running->space_.get();
    options.place = i;
    options.simulated.table = running->table_.get();
    options.simulated.place = i;
    if (adjust) adjust(options);
    running->clocks_.push_back(std::make_unique<io::Clock>(
        clock_for(place.port, place.time_scale.value_or(running->cell_.time_scale))));
    const io::Clock& clock = *running->clocks_.back();
    auto station = Station::start(std::move(robots[i]), std::move(options), clock);
    if (!station) {
      return std::unexpected(io::IoError{place.name + ": " + station.error().sentence});
    }
    running->stations_.push_back(std::move(*station));
    Station& started = *running->stations_.back();
    running->jobs_.push_back(std::make_unique<JobRunner>(started, clock));
    running->procedures_.push_back(std::make_unique<ProcedureRunner>(
        started, clock, ResultsPlace{results_file(folders, started), place.settings.value_or("")}));
  }
  return running;
}

RunningCell::~RunningCell() {
  // Each comes to rest in its own time; together they take as long as the slowest.
  const auto together = [&](const auto& end) {
    std::vector<std::thread> ends;
    ends.reserve(stations_.size());
    for (std::size_t i = 0; i < stations_.size(); ++i) ends.emplace_back(end, i);
    for (std::thread& one : ends) one.join();
  };
  together([this](std::size_t i) {
    if (i < jobs_.size()) jobs_[i].reset();
    if (i < procedures_.size()) procedures_[i].reset();
  });
  // Jobs look through cameras, and these at stations.
  cameras_.clear();
  together([this](std::size_t i) { stations_[i].reset(); });
}

void RunningCell::stands_beside(std::size_t i, HandEyeFile measured) {
  beside_[i] = std::move(measured);
}

void RunningCell::open_camera(std::size_t i, Camera::Settings settings, CameraSource source,
                              CameraSource glances, std::optional<CameraMount> mount) {
  settings.watch = settings.watch && cell_.cameras[i].watch;
  if (beside_[i] && settings.calibration) {
    place_beside(*beside_[i], cell_.cameras[i].robot, *settings.calibration);
  }
  Camera::Watch watch{
      .robots = [this] { return robots_in_view(Stand::kBelieved); },
      .table = [this, i](const auto& by) { return table_of(cell_, cell_.cameras[i], &by); },
      .hangs = {},
      .glances = std::move(glances)};
  if (mount) watch.hangs = [this, on = *mount] { return hangs(on, Stand::kBelieved); };
  cameras_[i] = std::make_unique<Camera>(std::move(settings), std::move(source), std::move(watch));
  look_with_calibrated();
}

void RunningCell::calibrate(std::size_t i, const vision::TableCamera& calibration) {
  auto counts = calibration;
  if (beside_[i]) place_beside(*beside_[i], cell_.cameras[i].robot, counts);
  cameras_[i]->calibrate(counts);
  look_with_calibrated();
}

Pose<frame::World, frame::Table> RunningCell::table_at(std::size_t camera) const {
  const auto by = cameras_[camera] ? cameras_[camera]->calibration() : nullptr;
  return table_of(cell_, cell_.cameras[camera], by.get());
}

void RunningCell::look_with_calibrated() {
  std::vector<std::size_t> calibrated;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (cameras_[i] && cameras_[i]->calibration()) calibrated.push_back(i);
  }
  if (calibrated == looks_with_) return;
  looks_with_ = calibrated;
  // A job that runs keeps those that it began with.
  for (std::size_t robot = 0; robot < size(); ++robot) {
    auto eyes = std::make_unique<CubeEyes>(
        cell_.robots[robot].X_WB, *baskets_,
        [&station = *stations_[robot]](const Camera& camera, const auto& shot) {
          station.record(RunPicture{station.clock().now(), camera.name(), shot});
        });
    for (const std::size_t i : calibrated) eyes->add(*cameras_[i]);
    jobs_[robot]->see_by(*eyes);
    newest_eyes_[robot] = eyes.get();
    eyes_.push_back(std::move(eyes));
  }
}

void RunningCell::move_basket(std::size_t basket, const Pose<frame::World, frame::Box>& X_WK) {
  baskets_->move(basket, X_WK);
  if (table_) table_->move_basket(basket, X_WK);
}

std::shared_ptr<const program::TableTop> RunningCell::table_top(std::size_t robot) const {
  auto table = std::make_shared<program::TableTop>();
  const auto X_BW = cell_.robots[robot].X_WB.inverse();
  for (const CellBasket& basket : baskets_->all()) {
    table->baskets.push_back({basket.name, X_BW * basket.X_WK, basket.size});
  }
  const CubeEyes* eyes = newest_eyes_[robot];
  if (eyes == nullptr) return table;
  table->cameras = eyes->names();
  table->seen = eyes->newest();
  return table;
}

std::optional<render::ViewedRobot> RunningCell::robot_in_view(std::size_t i, Stand how,
                                                              PositionQuality least) const {
  const StationView view = stations_[i]->view();
  render::ViewedRobot robot{stations_[i]->robot(), cell_.robots[i].X_WB, {}};
  if (how == Stand::kTrue && view.truth) {
    for (const sim::JointTruth& joint : view.truth->joints) {
      robot.q.push_back(joint.q);
      robot.qd.push_back(joint.qd);
    }
    robot.jaws = view.truth->tool;
  } else {
    // Also on the way.
    for (const JointPosition& joint : view.positions) {
      if (joint.quality >= least) robot.q.push_back(joint.q);
    }
    robot.jaws = view.tool.jaws.value_or(0);
    robot.held = view.tool.held.value_or(0);
  }
  if (robot.q.size() != robot.model.joints.size()) return std::nullopt;
  return robot;
}

std::vector<render::ViewedRobot> RunningCell::robots_in_view(Stand how) const {
  std::vector<render::ViewedRobot> robots;
  for (std::size_t i = 0; i < size(); ++i) {
    if (auto robot = robot_in_view(i, how, PositionQuality::kUncertain))
      robots.push_back(std::move(*robot));
  }
  return robots;
}

std::optional<Pose<frame::World, frame::Camera>> RunningCell::hangs(const CameraMount& mount,
                                                                    Stand how) const {
  auto robot = robot_in_view(mount.robot, how, PositionQuality::kCommanded);
  return robot ? pose_on(mount, std::move(*robot)) : std::nullopt;
}

std::optional<std::size_t> RunningCell::find(std::string_view name) const {
  const auto found = std::ranges::find(cell_.robots, name, &CellRobot::name);
  if (found == cell_.robots.end()) return std::nullopt;
  return static_cast<std::size_t>(found - cell_.robots.begin());
}

}  // namespace sinew::runtime
