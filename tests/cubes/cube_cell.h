#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sinew/core/split_mix.h"
#include "sinew/runtime/running_cell.h"

/// A simulated LeArm, a camera over its table, and cubes by chance.
namespace sinew::cubes {

struct CubeCellSettings {
  std::uint64_t seed = 1;
  std::size_t cubes = 3;
  bool towers = false;  ///< each cube stands on another one
  bool sheet = false;   ///< with tags lies on the table
  double pace = 20;     ///< so much faster time runs
  double off = 0;       ///< m, that the camera hangs aside of where its calibration says
};

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
  /// Begins it; finish() is its end.
  void begin(const std::string& program);
  Ended finish(Duration patience = std::chrono::minutes(4));
  /// Has to be called all along while a program runs; finish() does.
  void keep_lease();

  runtime::SimulatedTable& table() { return *cell_->table(); }
  runtime::RunningCell& cell() { return *cell_; }

 private:
  io::Clock clock_;
  std::unique_ptr<runtime::RunningCell> cell_;
  std::unique_ptr<runtime::StationClient> client_;  ///< whose lease the programs run under
};

}  // namespace sinew::cubes
