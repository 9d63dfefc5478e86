#pragma once

#include <array>
#include <optional>

#include "sinew/core/pose.h"
#include "sinew/vision/picture.h"

namespace sinew::frame {
struct Camera;  ///< x to the right of the picture, y down, z out of the lens
struct Board;   ///< a printed board or tag: x to its right, y up its page, z out of the paper
}  // namespace sinew::frame

namespace sinew::vision {

/// How a camera maps a direction to a pixel: a pinhole and a lens.
///
/// Source: D. C. Brown, Close-Range Camera Calibration, 1971; the coefficients are those of
/// OpenCV's k1, k2, p1, p2, k3, so that figures can be exchanged. Pixels as in vision/picture.h:
/// OpenCV's principal point is half a pixel less.
struct CameraModel {
  int width = 0;                 ///< px, of the pictures that this is true for
  int height = 0;                ///< px
  double fx = 0;                 ///< px, focal length across
  double fy = 0;                 ///< px, down
  Pixel center;                  ///< principal point
  std::array<double, 5> lens{};  ///< k1, k2, p1, p2, k3

  /// Where a point at p_CQ (m, in the camera's frame) is seen; nothing behind the lens, or so far
  /// out that the lens model folds back.
  std::optional<Pixel> project(const Vec3& p_CQ) const;

  /// Unit vector in C towards what is seen at a pixel. Inverse of project() within 1e-9 rad where
  /// the lens model can be inverted.
  Vec3 direction(Pixel p) const;

  /// The same camera with pictures whose longer side has about `longest` px.
  CameraModel shrunk(int longest) const;
};

/// A camera without lens errors, of this horizontal field of view. rad, 0 < view < pi
CameraModel pinhole(int width, int height, double view_rad);

}  // namespace sinew::vision
