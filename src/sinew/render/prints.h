#pragma once

#include <cstdint>
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
/// Rectangles, discs, rings and lines in all colors on a shaded background: a poster, or a room
/// that is far away and out of focus.
PrintPicture collage(SplitMix64& random);
/// Colored noise of several sizes, as carpets, stone and cloth have it.
/// @param depth  0 to 1, of the darkest  @param tint  0: grey, 1: any color
PrintPicture mottled(SplitMix64& random, double depth, double tint);
/// What is on the face of a block.
enum class FacePrint : std::uint8_t { kLetter, kPips, kTag, kLabel, kScratches, kScrew };
/// A face in this sRGB color with a print in another one. @param rgb  0 to 1
PrintPicture printed_face(SplitMix64& random, const double (&rgb)[3], FacePrint print);
/// A dark edge around white. @param share  of the picture's width
PrintPicture framed(double share);
/// A dark round hole or screw on white. @param share  its diameter, of the picture's width
PrintPicture screw(SplitMix64& random, double share);

}  // namespace sinew::render
