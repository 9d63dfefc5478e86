#include "sinew/vision/edge_fit.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sinew::vision {
namespace {

constexpr Quad kSquare{Pixel{20, 20}, Pixel{60, 20}, Pixel{60, 60}, Pixel{20, 60}};

/// A dark picture with light stripes of this width, one every 10 px.
Picture striped(int light) {
  Picture picture = black_picture(80, 80);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      std::fill_n(picture.at(x, y), 3, x % 10 < light ? std::uint8_t{220} : std::uint8_t{25});
    }
  }
  return picture;
}

TEST(EdgeFit, light_share_of_a_quad_is_that_of_its_light_area) {
  for (const int light : {0, 2, 5, 7}) {
    const Picture picture = striped(light);
    const LabPicture lab(picture);
    EXPECT_NEAR(light_share(lab, kSquare), light / 10.0, 0.13) << light;
  }
}

TEST(EdgeFit, sides_are_moved_to_the_edges_of_a_square) {
  Picture picture = black_picture(80, 80);
  for (int y = 22; y < 58; ++y) std::fill_n(picture.at(24, y), 3 * 34, std::uint8_t{200});
  const LabPicture lab(picture);
  const Quad fitted = fitted_to_edges(lab, kSquare, 6);
  const Quad expected{Pixel{24, 22}, Pixel{58, 22}, Pixel{58, 58}, Pixel{24, 58}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(length(fitted[i] - expected[i]), 0.6) << i;
  EXPECT_EQ(corners_filled(lab, fitted), 4);
}

}  // namespace
}  // namespace sinew::vision
