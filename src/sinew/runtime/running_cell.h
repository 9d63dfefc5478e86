#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/model/cell.h"
#include "sinew/program/language/table_top.h"
#include "sinew/runtime/cameras/camera.h"
#include "sinew/runtime/cameras/camera_place.h"
#include "sinew/runtime/cameras/cell_baskets.h"
#include "sinew/runtime/cameras/cube_eyes.h"
#include "sinew/runtime/cameras/simulated_table.h"
#include "sinew/runtime/job.h"
#include "sinew/runtime/procedure_runner.h"
#include "sinew/runtime/station.h"

namespace sinew::runtime {

/// Where a cell keeps what it writes down; empty: that is not kept.
struct CellFolders {
  std::string journal;  ///< positions of robots with a journal
  std::string flight;   ///< the last seconds before each fault, and what somebody records
  std::string record;   ///< a record of each job; empty: the newest of them in `flight`
  bool records_jobs = false;
  std::string commissioning{};  ///< what commissioning finds
  std::string programs{};       ///< programs and points, a folder for each kind of robot
  std::string baskets{};        ///< a file: where baskets were moved to
};

/// Where commissioning leaves what it finds of this robot; empty: nowhere. A simulated device is
/// not the one on the bench.
std::string results_file(const CellFolders& folders, const Station& station);

/// A cell that runs: each robot in its thread, with what runs its programs.
class RunningCell {
 public:
  /// @param robots  one for each of the cell's, as variant_of() made them
  /// @param adjust  what a cell's file does not say of its stations
  /// @error  a sentence that names the robot
  static io::IoResult<std::unique_ptr<RunningCell>> start(
      Cell cell, std::vector<RobotModel> robots, const CellFolders& folders,
      const std::function<void(StationOptions&)>& adjust = {});
  ~RunningCell();

  CellSpace& space() const { return *space_; }
  const Cell& cell() const { return cell_; }
  const CellFolders& folders() const { return folders_; }
  std::size_t size() const { return stations_.size(); }
  Station& station(std::size_t i) const { return *stations_[i]; }
  JobRunner& jobs(std::size_t i) const { return *jobs_[i]; }
  /// For one thread only.
  ProcedureRunner& procedures(std::size_t i) const { return *procedures_[i]; }
  /// Where the cell's robot of this name is; nothing where there is none.
  std::optional<std::size_t> find(std::string_view name) const;
  /// The camera of the cell's file with this number gives pictures from now on; programs look with
  /// calibrated ones, the first where they name none. Before the first job.
  /// @param glances  as Camera::Watch has them
  /// @param mount    on an arm; nothing: it hangs where its calibration says
  void open_camera(std::size_t i, Camera::Settings settings, CameraSource source,
                   CameraSource glances = {}, std::optional<CameraMount> mount = {});
  /// Hand-eye has measured where this camera stands beside its CellCamera::robot: so its table is
  /// known, where no marks were touched. Before it is opened.
  void stands_beside(std::size_t i, HandEyeFile measured);
  /// Counts from the next picture on, also for programs. For one thread only. @pre it was opened
  void calibrate(std::size_t i, const vision::TableCamera& calibration);
  /// Null where it was not opened.
  Camera* camera(std::size_t i) const { return cameras_[i].get(); }
  /// Where the table of a camera is.
  Pose<frame::World, frame::Table> table_at(std::size_t camera) const;
  /// Where its baskets stand.
  const CellBaskets& baskets() const { return *baskets_; }
  /// A person has put it there. @param X_WK  upright
  void move_basket(std::size_t basket, const Pose<frame::World, frame::Box>& X_WK);
  /// What lies in front of a robot, for a program that is read now.
  std::shared_ptr<const program::TableTop> table_top(std::size_t robot) const;
  /// What simulated cameras see; null where the cell's file has none.
  SimulatedTable* table() const { return table_.get(); }
  enum class Stand : std::uint8_t { kBelieved, kTrue };
  /// How its robots stand, as far as that is known; kTrue: simulated ones as they really do.
  std::vector<render::ViewedRobot> robots_in_view(Stand how) const;
  /// Where a camera on an arm is; nothing where it is not known how that stands.
  std::optional<Pose<frame::World, frame::Camera>> hangs(const CameraMount& mount, Stand how) const;

 private:
  RunningCell(Cell cell, CellFolders folders)
      : cell_(std::move(cell)), folders_(std::move(folders)) {}

  void look_with_calibrated();
  /// Nothing where a joint is known less well than that.
  std::optional<render::ViewedRobot> robot_in_view(std::size_t i, Stand how,
                                                   PositionQuality least) const;

  Cell cell_;
  CellFolders folders_;
  std::vector<std::unique_ptr<io::Clock>> clocks_;  ///< each robot's
  std::unique_ptr<CellSpace> space_;
  std::unique_ptr<CellBaskets> baskets_;
  std::unique_ptr<SimulatedTable> table_;  ///< of the stations, which end first
  std::vector<std::unique_ptr<Station>> stations_;
  std::vector<std::unique_ptr<Camera>> cameras_;     ///< they look at the stations
  std::vector<std::optional<HandEyeFile>> beside_;   ///< of each camera
  std::vector<std::unique_ptr<CubeEyes>> eyes_;      ///< of the jobs, which end first
  std::vector<std::atomic<CubeEyes*>> newest_eyes_;  ///< each robot's
  std::vector<std::size_t> looks_with_;              ///< cameras that these have
  std::vector<std::unique_ptr<JobRunner>> jobs_;
  std::vector<std::unique_ptr<ProcedureRunner>> procedures_;
};

}  // namespace sinew::runtime
