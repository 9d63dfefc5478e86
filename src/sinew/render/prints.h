#pragma once

#include <memory>

#include "sinew/core/split_mix.h"
#include "sinew/vision/picture.h"

namespace sinew::render {

/// Pictures for surfaces, drawn from nothing. All are bright, so that they can be multiplied with
/// a surface's colour, unless they say otherwise.
using PrintPicture = std::shared_ptr<const vision::Picture>;

/// Clouds of grey. @param depth  0 to 1, of the darkest
PrintPicture clouds(SplitMix64& random, double depth);
/// Fibres along the picture.
PrintPicture grain(SplitMix64& random, double depth);
/// Layers of a 3D print.
PrintPicture layers(SplitMix64& random, double depth);
/// Thin lines, `count` across and down, light or dark on white.
PrintPicture grid(SplitMix64& random, int count, double depth);
/// Black and white, `count` stripes aslant.
PrintPicture stripes(int count);
/// Fields of a chess board.
PrintPicture checkers(int count);
/// Black squares in a black frame on white, as tags and 2D codes have them.
PrintPicture tag(SplitMix64& random);
/// Black rings on white.
PrintPicture rings();
/// Lines of strokes like writing, dark on white.
PrintPicture writing(SplitMix64& random);
/// A few large fields in strong colours.
PrintPicture fields(SplitMix64& random);
/// Blots of all sizes in all colours, as a printed photo has them.
PrintPicture blots(SplitMix64& random);
/// A dark edge around white. @param share  of the picture's width
PrintPicture framed(double share);
/// A dark round hole or screw on white. @param share  its diameter, of the picture's width
PrintPicture screw(SplitMix64& random, double share);

}  // namespace sinew::render
