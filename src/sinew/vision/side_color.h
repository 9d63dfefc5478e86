#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sinew/vision/color_names.h"
#include "sinew/vision/picture.h"
#include "sinew/vision/table_camera.h"
#include "sinew/vision/white_balance.h"

namespace sinew::vision {

/// The color of a cube by its side faces, for one whose top is burnt out or shines: by the face
/// that the camera sees best, in white balanced bytes. Nothing where it sees none, a robot or
/// something as high as a cube is before it, or it is white or grey as well.
/// @param edge    m
/// @param others  m, middles of the tops of what may stand before it
/// @param hidden  as place_on_table() has it
std::optional<ColorName> side_color(const Picture& picture, const WhiteBalance& balance,
                                    const TableCamera& camera, const CubePosition& cube,
                                    double edge, std::span<const Vec3> others,
                                    const std::vector<bool>& hidden = {});

/// What a colour is called by its hue: black where it is very dark, nothing where it is white or
/// grey.
/// @param rgb  0 to 255, white balanced
std::optional<ColorName> name_by_hue(const std::array<double, 3>& rgb);

}  // namespace sinew::vision
