#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sinew/model/cell.h"
#include "sinew/render/robot_body.h"
#include "sinew/runtime/cameras/camera_source.h"
#include "sinew/vision/cube_detection.h"
#include "sinew/vision/table_camera.h"
#include "sinew/vision/view_watch.h"

namespace sinew::runtime {

/// A camera of a cell. A thread of its own takes a picture where one is asked for, and looks for
/// cubes in it; no control thread waits for it.
class Camera {
 public:
  struct Settings {
    std::string name;
    /// Nothing: pictures are shown, and it is not known where things are.
    std::optional<vision::TableCamera> calibration;
    double edge = 0.025;             ///< m, of the cubes on its table
    std::string identity{};          ///< as camera_identity() has it
    std::string calibration_file{};  ///< where a calibration is kept; empty: nowhere
    /// Why what is kept there does not count, in a sentence; empty: it counts, or there is none.
    std::string calibration_refused{};
    bool watch = true;  ///< as CellCamera::watch
  };
  /// The robots of the cell as they are believed to stand, in the cell. From any thread.
  using Robots = std::function<std::vector<render::ViewedRobot>()>;
  /// Where the table of a calibration is in the cell. From any thread.
  using Table = std::function<Pose<frame::World, frame::Table>(const vision::TableCamera&)>;
  /// Where a camera on an arm is in the cell, as the arm is believed to stand; nothing where that
  /// is not known. From any thread.
  using Hangs = std::function<std::optional<Pose<frame::World, frame::Camera>>()>;
  /// What else it knows of its cell, and how it is watched what comes into view.
  struct Watch {
    Robots robots{};         ///< nothing: it is not watched
    Table table{};           ///< nothing: the table is the cell's frame
    Hangs hangs{};           ///< nothing: it hangs where its calibration says
    CameraSource glances{};  ///< smaller pictures of the same; nothing: the camera has one size
  };
  /// What became of one picture.
  struct Shot {
    std::uint64_t number = 0;  ///< the last that ask() gave before it was taken
    /// Why it says nothing: kCameraLost, kCameraBlind, kCameraFrozen, kCameraChanged,
    /// kCameraMoved, kCameraTagsHidden; of one on an arm kCameraInMotion, kPositionUnknown.
    std::optional<Error> fault;
    vision::Picture picture;  ///< of no size where none came
    vision::Detection seen;   ///< with positions on the table where it is calibrated
    Pose<frame::World, frame::Table> X_WT{};  ///< of this table in the cell
    /// Of the camera over its table, where it was taken. @pre it is calibrated
    Pose<frame::World, frame::Camera> X_TC{};
  };

  Camera(Settings settings, CameraSource source, Watch watch);
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  const std::string& name() const { return settings_.name; }
  const std::string& identity() const { return settings_.identity; }
  const std::string& calibration_file() const { return settings_.calibration_file; }
  double edge() const { return settings_.edge; }
  bool is_on_arm() const { return watch_.hangs != nullptr; }
  /// Where it is in the cell, by its calibration; nothing where it is not known how its arm stands.
  std::optional<Pose<frame::World, frame::Camera>> pose(
      const vision::TableCamera& calibration) const;

  /// @name From any thread
  /// @{
  /// Null: none.
  std::shared_ptr<const vision::TableCamera> calibration() const;
  std::string calibration_refused() const;
  /// Counts from the next picture on.
  void calibrate(const vision::TableCamera& calibration);
  /// A picture is wanted that is taken from now on: of a shot with this number or a higher one.
  std::uint64_t ask();
  /// A picture is taken, where none is under way.
  void refresh();
  /// Null before the first.
  std::shared_ptr<const Shot> newest() const;
  /// Between both, what comes into view beside the robots is looked for, several times a second.
  /// @param anew  things are as they are seen next, unless another one watches already
  void begin_watch(bool anew);
  void end_watch();
  /// So many times something has come into view while it was watched, or it saw nothing any more.
  std::uint64_t disturbances() const;
  /// The last one, where there are more than so many: kViewDisturbed, kCameraLost, kCameraFrozen.
  std::optional<Error> disturbed_since(std::uint64_t count) const;
  /// @}

 private:
  using Time = std::chrono::steady_clock::time_point;

  void work(const std::stop_token& ending);
  void heed(std::shared_ptr<const vision::TableCamera> calibration);
  /// As they are believed to stand on its table; none where that is not known.
  std::vector<render::ViewedRobot> robots() const;
  Shot take(const std::stop_token& ending);
  /// A picture in which the camera was at rest; that of one on an arm may take several.
  /// @param by     the calibration; its pose becomes that of the picture
  /// @param stood  becomes how the robots stood before it was taken
  Expected<vision::Picture> at_rest(const std::stop_token& ending,
                                    std::optional<vision::TableCamera>& by,
                                    std::vector<render::ViewedRobot>& stood);
  void note_stand();
  std::optional<Error> disturbance(const std::stop_token& ending);
  std::optional<Error> fault_of(const vision::Picture& picture);
  std::optional<Error> moved(const vision::Picture& picture);

  const Settings settings_;  ///< its calibration: as it began
  CameraSource source_;
  // Of the thread.
  std::shared_ptr<const vision::TableCamera> heeded_;  ///< the calibration of its shots
  Pose<frame::World, frame::Table> X_WT_;              ///< of its table in the cell
  std::optional<vision::TagBoard> sheet_;              ///< on its table
  std::optional<vision::TagFinder> tags_;
  std::shared_ptr<const Shot> last_;       ///< with a picture
  std::optional<vision::ViewWatch> view_;  ///< nothing: it cannot be watched
  vision::Picture glance_;                 ///< the last one
  int glances_alike_ = 0;                  ///< in a row, bit by bit
  /// Robots as they stood from the last glance on.
  std::vector<std::vector<render::ViewedRobot>> stands_;
  mutable std::mutex mutex_;
  std::condition_variable_any asked_for_;
  std::uint64_t asked_ = 0;                                 ///< under the mutex
  int watchers_ = 0;                                        ///< under the mutex
  bool watches_anew_ = false;                               ///< under the mutex
  std::chrono::steady_clock::time_point unwatched_since_;   ///< under the mutex
  std::uint64_t disturbances_ = 0;                          ///< under the mutex
  std::optional<Error> last_disturbance_;                   ///< under the mutex
  std::shared_ptr<const Shot> newest_;                      ///< under the mutex
  std::shared_ptr<const vision::TableCamera> calibration_;  ///< under the mutex
  bool is_refused_ = false;                                 ///< under the mutex
  const Watch watch_;
  std::jthread thread_;  ///< the last: it ends before what it uses
};

}  // namespace sinew::runtime
