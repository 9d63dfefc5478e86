#pragma once

#include <string>

#include "sinew/model/robot_model.h"

namespace sinew::program {

/// "3.2 s"
std::string seconds_text(double seconds);
/// "+2 deg", of a leg "-0.3 mm". @param way  rad, or m
std::string way_text(double way, const Joint& joint);

}  // namespace sinew::program
