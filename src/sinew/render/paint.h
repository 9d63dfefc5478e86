#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/split_mix.h"
#include "sinew/render/prints.h"
#include "sinew/render/scene.h"
#include "sinew/vision/color_names.h"

namespace sinew::render {

/// sRGB of tables and of people's skins.
std::span<const unsigned> table_swatches();
std::span<const unsigned> skin_swatches();
/// sRGB of things that people call by this name.
std::span<const unsigned> swatches_of(vision::ColorName color);

/// About one of these sRGB colours, in the light and dark that things of one colour have.
Rgb near_one_of(SplitMix64& random, std::span<const unsigned> swatches);
Rgb any_color(SplitMix64& random);

/// With a random gloss.
Material plastic(SplitMix64& random, Rgb color);

/// How the surface of a block is made. Others than these: plain.
enum class BlockStyle : std::uint8_t {
  kPlain,
  kLayers,  ///< of a 3D print
  kGrain,   ///< of painted wood
  kClouds,
  kFramed,
  kScrew,
};

/// The surface of a block. @param color  nothing: white or grey  @param edge  m
Material painted_block(SplitMix64& random, std::optional<vision::ColorName> color, BlockStyle style,
                       double edge);

/// A print of `size` (m) on a surface.
void print_on(Material& material, PrintPicture picture, double size, bool single = false);

}  // namespace sinew::render
