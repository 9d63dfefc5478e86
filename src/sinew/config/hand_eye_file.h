#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/core/pose.h"
#include "sinew/vision/camera_model.h"

namespace sinew::frame {
struct CameraMount;  ///< what carries the camera, flange or base
struct BoardMount;   ///< what carries the target, base or flange
}  // namespace sinew::frame

namespace sinew {

/// Where a camera is on an arm or beside it: what `sinew camera hand-eye` has measured.
struct HandEyeFile {
  bool on_arm = true;  ///< the camera is on the flange and the target in the base; else vice versa
  std::string robot;   ///< its id
  std::string lens;    ///< the camera's name in its own file
  std::string target;
  Pose<frame::CameraMount, frame::Camera> X_MC{};
  Pose<frame::BoardMount, frame::Board> X_NB{};               ///< of the target
  std::vector<std::pair<std::string, double>> joint_zeros{};  ///< rad, to add, by the joint's name
  int views = 0;
  double reprojection = 0;  ///< px, rms
  double held_back = 0;     ///< m at the target, 95 %, of views held back
  double table = 0;         ///< m, 95 %, of the table or the target in the base
};

/// @param file_name  as complaints shall show it
/// @error  all complaints, with line and column
std::expected<HandEyeFile, std::vector<Complaint>> read_hand_eye(std::string_view toml,
                                                                 std::string_view file_name);

/// Such a file's text; read_hand_eye() gives the same back, to 1e-9 mm or deg.
std::string hand_eye_text(const HandEyeFile& file);

}  // namespace sinew
