#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/model/taught_points.h"

namespace sinew {

/// Reads a file of taught points strictly; docs/programs.md has its form.
///
///   [points.above_bin]
///   robot = "learm"
///   joints_deg = [20, 20, 40, 40, 0]      | or legs_mm, joints = ["20deg", "5mm"] of a SCARA, or
///   source = "taught by hand"             | x_mm, y_mm, z_mm and, where it counts, rx_deg, ry_deg,
///                                         | rz_deg together, or pitch_deg, roll_deg
///
/// Whether a point suits a robot is for whoever uses it there: a file may serve several.
/// @param file_name  as complaints shall show it
/// @return points in the order of the file
/// @error  all complaints, with line and column
std::expected<TaughtPoints, std::vector<Complaint>> read_points(std::string_view toml,
                                                                std::string_view file_name);

/// The same for programs: a point that cannot be read has a name and what is `wrong` with it, so
/// that it refuses only the rows that use it. Of a file that is no TOML at all there is one such
/// point, without a name.
TaughtPoints usable_points(std::string_view toml, std::string_view file_name);

/// The one spelling of such a file; read_points() gives the same points back, to 1e-9 mm or deg.
/// Put it in place with io::replace_file.
std::string points_text(const TaughtPoints& points);

/// A file's text with this point behind the others, or in the place of the one of its name; what
/// else stands there, remarks included, stays as it is.
/// @param file_name  as complaints shall show it
/// @error  what is wrong with the text, or that the point's table is written in a form which only
///         its author can change
std::expected<std::string, std::vector<Complaint>> with_point(std::string_view toml,
                                                              std::string_view file_name,
                                                              const TaughtPoint& point);

/// A file's text without this point, or with another name of it. As with_point().
/// @error  also: it is not there, or another point has the name already
std::expected<std::string, std::vector<Complaint>> without_point(std::string_view toml,
                                                                 std::string_view file_name,
                                                                 std::string_view name);
std::expected<std::string, std::vector<Complaint>> with_point_renamed(std::string_view toml,
                                                                      std::string_view file_name,
                                                                      std::string_view name,
                                                                      std::string_view to);

/// "above_bin": what a point or a program may be called.
bool is_point_name(std::string_view name);

}  // namespace sinew
