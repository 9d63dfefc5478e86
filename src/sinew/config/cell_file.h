#pragma once

#include <expected>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/model/cell.h"

namespace sinew {

/// Reads a cell's file, strictly, as robots' files are read; the schema: cells/README.md. Whether
/// its robots exist is not looked at here.
/// @error  all complaints in the order of the file
std::expected<Cell, std::vector<Complaint>> read_cell(std::string_view toml,
                                                      std::string_view file_name);

/// The cell that runs where nobody names one: all robots of this build that have a device,
/// simulated, side by side. cells/five.toml as it stood when the program was built.
std::string_view builtin_cell();

}  // namespace sinew
