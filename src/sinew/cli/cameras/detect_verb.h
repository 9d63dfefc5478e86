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

struct DetectRequest {
  std::vector<std::string> images;    ///< JPEG or PNG files
  std::vector<std::string> colors;    ///< these only; all of them where empty
  std::optional<std::string> debug;   ///< PNG file: what was seen, and what was refused
  std::optional<std::string> camera;  ///< file of `sinew camera calibrate`: positions in mm
  std::optional<double> cube_mm;      ///< edge of the cubes, with a camera
};

/// `sinew detect`: the coloured cubes in pictures of a table from above.
Outcome detect(const DetectRequest& request);

void add_detect(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
