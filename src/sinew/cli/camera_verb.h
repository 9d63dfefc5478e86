#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/outcome.h"

namespace CLI {
class App;
}

namespace sinew::cli {

struct CameraRequest {
  std::string action;                ///< board, sheet, tags or calibrate
  std::vector<std::string> images;   ///< of tags, calibrate: JPEG or PNG files
  std::string paper = "a4";          ///< of board and sheet
  std::string form = "svg";          ///< svg or pdf
  std::optional<std::string> table;  ///< calibrate: image of the sheet on the table
  std::optional<std::string> out;    ///< calibrate: file to write
  std::string name = "camera";       ///< calibrate: of the camera
};

void declare_options(CLI::App& verb, CameraRequest& request);

/// `sinew camera`: printed boards, the tags that images show, and calibration with them.
Outcome camera(const CameraRequest& request);

}  // namespace sinew::cli
