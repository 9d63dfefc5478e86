#pragma once

#include <cstddef>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/calibration/robot_tip.h"
#include "sinew/calibration/touch_points.h"
#include "sinew/model/robot_model.h"
#include "sinew/vision/tag_board.h"

namespace sinew::calibration {

/// A mark of a sheet that the tool's tip was on.
struct TouchedMark {
  std::string mark;   ///< "cross1", "tag580", or "120,40" of a mark that is not on the sheet
  Vec3 p_S;           ///< m, of the mark on its sheet
  std::string point;  ///< taught point that it comes from; empty: none
  JointVector q;
  Vec3 p_BT;  ///< m, of the tip
};

/// Marks of one sheet that the tip of one robot was on.
struct SheetTouches {
  RobotModel model;
  std::string robot;  ///< its name
  Vec3 up{0, 0, 1};   ///< unit vector in its base
  TouchTool tool{};
  double limit = 5e-3;  ///< m, of the rms
  vision::TagBoard sheet;
  std::vector<TouchedMark> marks;

  std::vector<TouchedPoint> points() const;
};

/// Where the sheet lies.
struct TouchedSheet {
  TableFrame frame;  ///< its world is the sheet
  Vec3 far_S;        ///< m, the corner of the sheet that is known least
  double error = 0;  ///< m, there, 95 %
};

/// Why touches do not say where the sheet lies.
struct TouchRefusal {
  enum class Kind : std::uint8_t { kTooFew, kOnLine, kSamePlace, kMirrored, kMisfit };
  Kind kind{};
  std::string sentence;              ///< what to do, last
  std::optional<std::size_t> again;  ///< the one to touch again
};

/// m, standard deviation of a coordinate of a touch at best: steps of the joints' devices, and
/// eyes.
double least_touch_sigma(const RobotModel& model, std::span<const TouchedMark> marks,
                         const TouchTool& tool);

/// Two marks that the tool was at one position for.
std::optional<TouchRefusal> same_place(std::span<const TouchedMark> marks);

std::expected<TouchedSheet, TouchRefusal> touched_sheet(const SheetTouches& touches);

/// "cross3 is off by 3.1 mm (...); the others agree to 0.4 mm rms. Touch it again"
std::string wrong_touch_sentence(const SheetTouches& touches, const WrongTouch& wrong);

/// Names of its marks that were not touched.
std::vector<std::string> marks_left(const SheetTouches& touches);

/// A mark to touch next: the one that leaves the least error at the sheet's far corner, in reach.
struct NextTouch {
  vision::BoardMark mark;
  JointVector q;
  double error = 0;  ///< m, then, 95 %
};
std::optional<NextTouch> next_touch(const SheetTouches& touches, const TouchedSheet& sheet);

}  // namespace sinew::calibration
