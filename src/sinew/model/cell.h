#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/pose.h"

namespace sinew::frame {
struct Table;  ///< of the sheet with tags that a camera was calibrated on
}

/// A cell: robots that stand together, and what stands around them. World W is the cell's own
/// frame, z up.
namespace sinew {

/// One robot of a cell: which one, where it stands, and what its device hangs on.
/// What a program does when the client that runs it is gone.
enum class ClientLoss : std::uint8_t {
  kPause,     ///< comes to rest on its path; whoever takes control can resume it
  kContinue,  ///< runs to its end
};

struct CellRobot {
  std::string name;   ///< unique in the cell: lower-case letters, digits, -
  std::string robot;  ///< a built-in id, or a .toml file beside the cell's
  std::optional<std::string> profile;
  std::optional<std::string> wire;
  /// Joints whose boards are missing: model/left_out.h.
  std::vector<std::string> without;
  /// A file of what commissioning found, beside the cell's; nothing: as the robot's file says.
  std::optional<std::string> settings;
  /// A device of this computer; nothing: simulated.
  std::optional<std::string> port;
  /// Of its position journal. A robot on a real port has one of its own name where this is empty, a
  /// simulated one none.
  std::optional<std::string> journal;
  std::uint64_t seed = 1;  ///< of the simulated device
  /// Of the simulated device alone, in place of the cell's.
  std::optional<double> time_scale;
  ClientLoss on_client_loss = ClientLoss::kPause;
  Pose<frame::World, frame::Base> X_WB;
};

/// Something solid that does not move.
struct CellObject {
  std::string name;
  Pose<frame::World, frame::Box> X_WX;  ///< its middle, along its edges
  Vec3 half;                            ///< half of each edge, m, > 0
};

/// A camera that looks at the cell.
struct CellCamera {
  std::string name;
  /// As runtime/cameras/open_camera.h has them: /dev/video0, http://, an image that another program
  /// keeps writing, a movie, a folder; beside the cell's file or by the whole path.
  /// kSimulatedCamera: none.
  std::string device;
  /// What `sinew camera calibrate` has written, beside the cell's file; without it nothing is known
  /// of where things are. A simulated one hangs where this says, or else above its table.
  std::optional<std::string> calibration;
  /// What `sinew camera hand-eye` has written, beside the cell's file, and the robot that it was
  /// measured on, which carries the camera or stands beside it; without it the camera hangs where
  /// its calibration says.
  std::optional<std::string> hand_eye{};
  std::string robot{};
  double cube = 0.025;  ///< m, edge of the cubes on its table
  /// Programs that look through it pause where something comes into view while the arm moves.
  bool watch = true;
  /// Of the table that it was calibrated on: middle of the sheet with the tags.
  Pose<frame::World, frame::Table> X_WT;
};

/// CellCamera::device of one that looks at simulated cubes.
inline constexpr std::string_view kSimulatedCamera = "simulated";

/// A cube on the table of a simulated camera, as it lies when the cell begins.
struct CellCube {
  int color = 0;    ///< a vision::ColorName
  Vec3 p_W;         ///< m; z of its bottom, in the cell
  double turn = 0;  ///< rad, of its edges about z
};

/// A box without a lid: cubes in it are done with, so no camera looks for them there.
struct CellBasket {
  std::string name;
  Pose<frame::World, frame::Box> X_WK;  ///< middle of its floor, upright
  Vec3 size{0.12, 0.12, 0.05};          ///< m, inside: along x, along y, and its walls' height
};

inline constexpr std::size_t kCellRobotsMax = 16;
inline constexpr std::size_t kCellCubesMax = 64;
inline constexpr std::size_t kCellBasketsMax = 8;

struct Cell {
  std::string title;
  double time_scale = 1;          ///< of simulated devices; 1 where any robot is real
  std::vector<CellRobot> robots;  ///< at least one, at most kCellRobotsMax
  std::vector<CellObject> objects;
  std::vector<CellCamera> cameras;
  std::vector<CellBasket> baskets;  ///< at most kCellBasketsMax
  std::vector<CellCube> cubes;

  /// The first simulated one; null where there is none.
  const CellCamera* simulated_camera() const {
    const auto found = std::ranges::find(cameras, kSimulatedCamera, &CellCamera::device);
    return found != cameras.end() ? &*found : nullptr;
  }
};

}  // namespace sinew
