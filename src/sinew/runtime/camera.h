#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "sinew/runtime/camera_source.h"
#include "sinew/vision/cube_detection.h"
#include "sinew/vision/table_camera.h"

namespace sinew::runtime {

/// A camera of a cell. A thread of its own takes a picture where one is asked for, and looks for
/// cubes in it; no control thread waits for it.
class Camera {
 public:
  struct Settings {
    std::string name;
    /// Nothing: pictures are shown, and it is not known where things are.
    std::optional<vision::TableCamera> calibration;
    double edge = 0.025;  ///< m, of the cubes on its table
  };
  /// What became of one picture.
  struct Shot {
    std::uint64_t number = 0;  ///< the last that ask() gave before it was taken
    /// Why it says nothing: kCameraLost, kCameraBlind, kCameraFrozen, kCameraChanged,
    /// kCameraMoved, kCameraTagsHidden.
    std::optional<Error> fault;
    vision::Picture picture;  ///< of no size where none came
    vision::Detection seen;   ///< with positions on the table where it is calibrated
  };

  Camera(Settings settings, CameraSource source);
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  const Settings& settings() const { return settings_; }

  /// @name From any thread
  /// @{
  /// A picture is wanted that is taken from now on: of a shot with this number or a higher one.
  std::uint64_t ask();
  /// A picture is taken, where none is under way.
  void refresh();
  /// Null before the first.
  std::shared_ptr<const Shot> newest() const;
  /// @}

 private:
  void work(const std::stop_token& ending);
  Shot take(const std::stop_token& ending);
  std::optional<Error> fault_of(const vision::Picture& picture);
  std::optional<Error> moved(const vision::Picture& picture);

  Settings settings_;
  CameraSource source_;
  std::optional<vision::TagBoard> sheet_;  ///< on its table
  std::optional<vision::TagFinder> tags_;  ///< of the thread
  std::shared_ptr<const Shot> last_;       ///< with a picture; of the thread
  mutable std::mutex mutex_;
  std::condition_variable_any asked_for_;
  std::uint64_t asked_ = 0;             ///< under the mutex
  std::shared_ptr<const Shot> newest_;  ///< under the mutex
  std::jthread thread_;                 ///< the last: it ends before what it uses
};

}  // namespace sinew::runtime
