#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace CLI {
class App;
}

namespace sinew::cli {

struct CameraRequest {
  std::string action;                ///< board, sheet, tags, calibrate, touch or hand-eye
  std::vector<std::string> images;   ///< of tags, calibrate, hand-eye: JPEG or PNG files
  std::string paper = "a4";          ///< of board and sheet
  std::string form = "svg";          ///< svg or pdf
  std::optional<std::string> table;  ///< calibrate: image of the sheet on the table
  std::optional<std::string> out;    ///< calibrate, hand-eye: file to write
  std::string name = "camera";       ///< calibrate: of the camera

  // touch, hand-eye
  std::optional<std::string> robot;
  std::optional<std::string> cell;  ///< the cell's file
  std::string points = "points.toml";
  bool points_given = false;
  std::vector<std::string> marks;         ///< "POINT=MARK"
  std::vector<std::string> touches;       ///< "MARK=JOINTS"
  std::optional<std::string> gripper_mm;  ///< width between the jaws while they touch
  std::string pin_mm = "0";               ///< that stands out of the tool
  std::string limit_mm = "5";             ///< touch: of the rms

  // hand-eye
  std::optional<std::string> camera;  ///< file of `sinew camera calibrate`
  std::optional<std::string> mount;   ///< "arm" or "table"
  std::string target = "board";       ///< "board", "sheet" or "FAMILY:ID:SIDE"
  std::string zeros_deg = "0";        ///< standard deviation of the joints' zeros
};

/// --paper names none that there is.
Outcome wrong_paper(const CameraRequest& request);

/// `sinew camera`: printed boards, the tags that images show, and calibration with them.
Outcome camera(const CameraRequest& request);

void add_camera(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
