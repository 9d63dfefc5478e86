#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sinew/core/split_mix.h"
#include "sinew/runtime/running_cell.h"

/// A simulated arm, a camera over its table, and cubes by chance.
namespace sinew::cubes {

/// Something that lies on the table and is no cube.
using Thing = render::ViewedThing;

/// A mistake of a calibration along its table.
struct PlanarError {
  double x = 0, y = 0;  ///< m
  double turn = 0;      ///< rad, about the table's middle
};

struct CubeCellSettings {
  std::uint64_t seed = 1;
  std::size_t cubes = 3;
  bool towers = false;             ///< each cube stands on another one
  bool sheet = false;              ///< with tags lies on the table
  double pace = 20;                ///< so much faster time runs
  PlanarError calibration = {};    ///< how the camera hangs beside where it is believed to
  std::string robot = "learm";     ///< built in, or the name of a file in robots/examples
  bool on_arm = false;             ///< the camera is, of a LeArm
  bool anywhere = false;           ///< also where the arm has no reach, pink and black too
  std::array<double, 5> lens{};    ///< of the camera, as its calibration has it, too
  std::vector<Thing> clutter{};    ///< in the camera's table
  std::uint64_t surroundings = 1;  ///< shades, grain, lamps
  double brightness = 1;
  int lamps = 2;
};

/// Where a camera on a LeArm looks at the table in front of it.
inline const std::string kLookFromArm =
    "joint base=0deg shoulder=-20deg elbow=80deg wrist=90deg roll=0deg\n";

/// How a program ended.
struct Ended {
  runtime::JobView job;
  std::vector<sim::CubeState> cubes;
  std::vector<sim::CubeEvent> events;

  std::size_t count(sim::CubePlace where) const;
  std::size_t count(sim::CubeEvent::Kind kind) const;
  /// What happened, for people.
  std::string text() const;
};

/// In real threads.
class CubeCell {
 public:
  explicit CubeCell(const CubeCellSettings& settings);
  /// To its end, or `patience` of real time.
  Ended run(const std::string& program, Duration patience = std::chrono::minutes(4));
  /// The first rows of the robot's own program, as it lies anywhere when it begins; what happened
  /// meanwhile is forgotten.
  void stand_aside();
  /// pick_and_place.sinew, of the robot's folder in robots/.
  Ended run_own_program(const std::function<void()>& look = {});
  /// Begins it; finish() is its end.
  void begin(const std::string& program);
  /// @param look  called every few milliseconds meanwhile
  Ended finish(Duration patience = std::chrono::minutes(4), const std::function<void()>& look = {});
  /// Has to be called all along while a program runs; finish() does.
  void keep_lease();

  runtime::SimulatedTable& table() { return *cell_->table(); }
  runtime::RunningCell& cell() { return *cell_; }
  const RobotModel& robot() const { return cell_->station(0).robot(); }
  /// As they really are. @pre the robot has begun
  JointVector joints() const;

 private:
  std::string own_program() const;

  io::Clock clock_;
  std::unique_ptr<runtime::RunningCell> cell_;
  std::unique_ptr<runtime::StationClient> client_;  ///< whose lease the programs run under
};

}  // namespace sinew::cubes
