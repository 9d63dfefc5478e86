#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

#include "sinew/model/cell.h"
#include "sinew/render/cell_scene.h"
#include "sinew/runtime/cameras/camera_source.h"
#include "sinew/sim/cube_table.h"
#include "sinew/vision/table_camera.h"

namespace sinew::runtime {

/// Cubes for threads.
class LockedCubes : public sim::SharedCubes {
 public:
  explicit LockedCubes(const sim::CubeWorldSettings& settings) : world_(settings) {}
  void with(const std::function<void(sim::CubeWorld&)>& what) override {
    const std::scoped_lock lock(mutex_);
    what(world_);
  }

 private:
  std::mutex mutex_;
  sim::CubeWorld world_;
};

/// Where a simulated camera hangs that no calibration is given for: 640 x 480 px, above its table.
vision::TableCamera usual_camera();

/// The table under a cell's simulated camera: cubes and baskets that its robots work on, and what
/// the camera sees of all that. The cell learns of it through robots' wires and pictures alone.
class SimulatedTable {
 public:
  /// How the robots stand, in the cell.
  using Robots = std::function<std::vector<render::ViewedRobot>()>;
  /// Where a camera on an arm is, in the cell; nothing: the arm stands nowhere.
  using Hangs = std::function<std::optional<Pose<frame::World, frame::Camera>>()>;
  /// What is wrong with the camera, and what else stands on the table.
  struct Trouble {
    bool unplugged = false;
    bool covered = false;
    bool frozen = false;
    Vec3 knocked;                              ///< m, of its own axes, from where it was calibrated
    render::Sensor sensor{};                   ///< exposure: of the automatic one
    std::optional<render::ViewedHand> hand{};  ///< on the table
  };
  /// What a person shows a camera that is calibrated. Cubes are put aside meanwhile, and
  /// the basket too where a sheet is laid.
  struct Shown {
    std::size_t camera = 0;             ///< of the cell's
    vision::TagBoard board;             ///< to hold, or a sheet to lay on the table
    std::optional<std::uint64_t> pose;  ///< of held_board(); nothing: it lies on the table
  };

  /// @param cell     with a simulated camera
  /// @param baskets  where they stand now
  SimulatedTable(const Cell& cell, const std::vector<CellBasket>& baskets);

  /// A robot's machine, its hand on this table. @param which  of the cell's robots
  std::unique_ptr<sim::ByteMachine> under(std::unique_ptr<sim::ByteMachine> machine,
                                          const RobotModel& model, std::size_t which, Instant boot);
  /// Pictures of it; where the camera has a sheet with tags that lies on the table from now on.
  /// @param camera  as it hangs
  /// @param number  of the cell's cameras
  /// @param hangs   of one on an arm
  CameraSource pictures(const vision::TableCamera& camera, Robots robots, std::size_t number = 0,
                        Hangs hangs = {});
  /// Smaller ones of the same, for Camera::Watch.
  CameraSource glances(const vision::TableCamera& camera, Robots robots, std::size_t number = 0);
  /// In pictures from now on; nothing: the person has gone, and has put the cubes back.
  void show(const std::optional<Shown>& shown);
  /// A sheet with tags that lies on the table for good; empty: none does. "a4", "a3", "letter"
  void leave_sheet(std::string_view paper);

  sim::SharedCubes& cubes() { return cubes_; }
  /// All cubes lie where they lay when the cell began.
  void begin_again();
  /// As CubeWorld::move_basket does. @param X_WK  in the cell
  void move_basket(std::size_t basket, const Pose<frame::World, frame::Box>& X_WK);
  void set_trouble(const Trouble& trouble);
  Trouble trouble() const;
  /// A hand that reaches into a camera's picture from across the table, as far from robots as
  /// the picture shows. @param number  of the cell's cameras; one whose pictures are taken here
  render::ViewedHand hand_in_view(std::size_t number) const;
  /// Lamps, table top, things that are no cubes; seed: as render::CellView has it.
  void set_surroundings(const render::CellView& view);

 private:
  Expected<vision::Picture> picture(const vision::TableCamera& camera, const Robots& robots,
                                    std::size_t number, const std::optional<vision::Picture>& last);
  static void put_shown(render::CellView& view, const vision::TableCamera& camera,
                        const Shown& shown, const render::PrintPicture& print);

  std::vector<sim::CubeWorld::NewCube> first_;  ///< cubes as the cell begins
  Pose<frame::World, frame::Table> X_WT_;
  std::vector<Pose<frame::World, frame::Base>> X_TB_;  ///< T as a world of its own
  LockedCubes cubes_;
  mutable std::mutex mutex_;
  std::map<std::size_t, vision::TableCamera> cameras_;  ///< by number, under the mutex
  Trouble trouble_;                                     ///< under the mutex
  render::CellView view_;                               ///< under the mutex
  std::optional<Shown> shown_;                          ///< under the mutex
  render::PrintPicture print_;                          ///< of what is shown, under the mutex
  std::uint64_t taken_ = 0;                             ///< pictures, under the mutex
};

}  // namespace sinew::runtime
