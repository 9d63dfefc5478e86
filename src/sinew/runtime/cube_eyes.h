#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "sinew/program/eyes.h"
#include "sinew/vision/cube_detection.h"
#include "sinew/vision/picture.h"
#include "sinew/vision/table_camera.h"

namespace sinew::runtime {

/// Cubes on a robot's table by a calibrated camera. A thread of its own takes pictures and looks at
/// them; no control thread waits for it.
class CubeEyes : public program::Eyes {
 public:
  struct Place {
    vision::TableCamera camera;
    Pose<frame::Base, frame::World> X_BW;  ///< of the camera's table in the robot's base
    double edge = 0.025;                   ///< m, of the cubes
  };
  /// The next picture that is taken from now on; may take its time, and gives up where the end is
  /// asked for. Called in the eyes' own thread.
  using Source = std::function<Expected<vision::Picture>(const std::stop_token& ending)>;

  CubeEyes(const Place& place, Source source);
  ~CubeEyes() override;
  CubeEyes(const CubeEyes&) = delete;
  CubeEyes& operator=(const CubeEyes&) = delete;

  void look() override;
  std::optional<Expected<program::Sighting>> seen() override;

 private:
  void work(const std::stop_token& ending);

  Place place_;
  Source source_;
  std::mutex mutex_;
  std::condition_variable_any wanted_;
  std::uint64_t asked_ = 0;     ///< looks, under the mutex
  std::uint64_t answered_ = 0;  ///< the look that `answer_` is of
  std::optional<Expected<program::Sighting>> answer_;
  std::jthread thread_;  ///< the last: it ends before what it uses
};

/// What a picture's cubes are in front of a robot.
program::Sighting sighting_of(const vision::Detection& seen, const CubeEyes::Place& place);

}  // namespace sinew::runtime
