#include "sinew/calibration/projection.h"

#include <algorithm>

namespace sinew::calibration {

CameraVector parameters_of(const vision::CameraModel& camera) {
  CameraVector v;
  v << camera.fx, camera.fy, camera.center.x, camera.center.y, camera.lens[0], camera.lens[1],
      camera.lens[2], camera.lens[3], camera.lens[4];
  return v;
}

vision::CameraModel with_parameters(vision::CameraModel camera, const CameraVector& parameters) {
  camera.fx = parameters[0];
  camera.fy = parameters[1];
  camera.center = {parameters[2], parameters[3]};
  std::copy_n(parameters.data() + 4, camera.lens.size(), camera.lens.begin());
  return camera;
}

std::optional<Projection> projection(const vision::CameraModel& camera, const Vec3& p_CQ) {
  constexpr double kNearest = 1e-6;  // m, as in CameraModel::project()
  if (!(p_CQ.z >= kNearest)) return std::nullopt;
  const auto& [k1, k2, p1, p2, k3] = camera.lens;
  const double x = p_CQ.x / p_CQ.z;
  const double y = p_CQ.y / p_CQ.z;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // d radial / d r2
  const double bent_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;

  Projection out;
  out.pixel << camera.center.x + camera.fx * bent_x, camera.center.y + camera.fy * bent_y;

  const double mixed = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  const double xx = camera.fx * (radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x);
  const double xy = camera.fx * mixed;
  const double yx = camera.fy * mixed;
  const double yy = camera.fy * (radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x);
  out.by_point << xx, xy, -(xx * x + xy * y), yx, yy, -(yx * x + yy * y);
  out.by_point /= p_CQ.z;

  const double fx = camera.fx;
  const double fy = camera.fy;
  const double r4 = r2 * r2;
  out.by_camera << bent_x, 0, 1, 0, fx * x * r2, fx * x * r4, fx * 2 * x * y, fx * (r2 + 2 * x * x),
      fx * x * r4 * r2,  //
      0, bent_y, 0, 1, fy * y * r2, fy * y * r4, fy * (r2 + 2 * y * y), fy * 2 * x * y,
      fy * y * r4 * r2;
  return out;
}

}  // namespace sinew::calibration
