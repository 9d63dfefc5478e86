#pragma once

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

LabPicture to_lab(const Picture& picture);

}  // namespace sinew::vision
