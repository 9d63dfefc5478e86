#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// CIE L*a*b*, D65: lightness 0 to 100, a from green to red, b from blue to yellow.
struct Lab {
  float L = 0;
  float a = 0;
  float b = 0;
};
/// How far two colours are apart (CIE76).
float distance(const Lab& one, const Lab& other);
/// How far a colour is from grey.
float chroma(const Lab& colour);
/// From red over yellow and green to blue, 0 to 2 pi. rad
float hue(const Lab& colour);

/// One number a pixel.
struct Plane {
  int width = 0;
  int height = 0;
  std::vector<float> values;

  float at(int x, int y) const {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

struct LabPicture {
  Plane L;
  Plane a;
  Plane b;

  int width() const { return L.width; }
  int height() const { return L.height; }
  Lab at(int x, int y) const { return {L.at(x, y), a.at(x, y), b.at(x, y)}; }
};

/// The gains of red, green and blue by which what is grey in the picture becomes grey: the mean of
/// its pale pixels, since tables, boards and walls are pale more often than not. 0.6 to 1.6; 1
/// where hardly anything is pale.
std::array<float, 3> white_balance(const Picture& picture);

/// @param gains  of linear red, green and blue
LabPicture to_lab(const Picture& picture, const std::array<float, 3>& gains);

/// Each value is the mean of its neighbourhood, with weights of a bell of about `sigma` 0.9 px.
Plane smoothed(const Plane& plane);

}  // namespace sinew::vision
