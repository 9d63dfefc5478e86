#pragma once

#include <array>
#include <optional>
#include <span>

#include "sinew/vision/color_names.h"
#include "sinew/vision/picture.h"
#include "sinew/vision/table_camera.h"
#include "sinew/vision/white_balance.h"

namespace sinew::vision {

/// The color of a cube by its side faces, for one whose top is burnt out or shines: by the face
/// that the camera sees best, in white balanced bytes. Nothing where it sees none, another cube is
/// before it, or it is white or grey as well.
/// @param edge  m. @param cubes  others on the table
std::optional<ColorName> side_color(const Picture& picture, const WhiteBalance& balance,
                                    const TableCamera& camera, const CubePosition& cube,
                                    double edge, std::span<const SeenCube> cubes);

/// What a colour is called by its hue: black where it is dark, nothing where it is white or grey.
/// @param rgb  0 to 255, white balanced
std::optional<ColorName> name_by_hue(const std::array<double, 3>& rgb);

}  // namespace sinew::vision
