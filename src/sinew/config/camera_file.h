#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/vision/table_camera.h"

namespace sinew {

/// Reads what `sinew camera calibrate` has written; docs/vision.md has its form.
/// @param file_name  as complaints shall show it
/// @error  all complaints, with line and column
std::expected<vision::TableCamera, std::vector<Complaint>> read_camera(std::string_view toml,
                                                                       std::string_view file_name);

/// Such a file's text; read_camera() gives the same camera back, to 1e-9 px, mm or deg.
std::string camera_text(const vision::TableCamera& camera);

}  // namespace sinew
