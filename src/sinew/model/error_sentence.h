#pragma once

#include <string>

#include "sinew/core/error.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// Whom an error is about, as the robot's file calls it: a joint, or two links that touch; empty
/// where it is about none.
std::string subject_of(const Error& error, const RobotModel& model);

/// What its numbers are: what is an angle of other joints is a length of one that slides.
Quantity quantity_of(const Error& error, const RobotModel& model);

/// The error as people read it, with its numbers in mm and degrees.
std::string sentence_of(const Error& error, const RobotModel& model);

}  // namespace sinew
