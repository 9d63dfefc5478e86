#pragma once

#include <optional>
#include <string>

#include "sinew/cli/cells/local_cell.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct FirmwareRequest {
  std::string action;                ///< list, info or flash
  std::string what;                  ///< info: a file, or a port; flash: a board
  RobotOptions robot;                ///< info: whose boards are on that port
  std::string images;                ///< folder; empty: beside this program
  std::optional<std::string> image;  ///< flash: this file instead
  std::optional<std::string> port;
  bool usb = false;
  bool probe = false;
  bool no_backup = false;
};

/// `sinew firmware`: images of boards, and writing one into a board. Nothing moves.
Outcome firmware(const FirmwareRequest& request);

void add_firmware(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
