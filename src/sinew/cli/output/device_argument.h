#pragma once

#include <cstdint>
#include <expected>
#include <span>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/driver/driver.h"
#include "sinew/model/robot_model.h"

namespace sinew::cli {

/// What to look at where nobody answers, or only what fits nothing, or another kind of board;
/// begins with "; ". Empty where the trouble is of another sort.
std::string silence_hint(const RobotModel& model, const Error& trouble, const DriverHealth& health);

/// Its boards hang on SPI; else its device hangs on a serial port.
bool is_on_spi(const RobotModel& model);

/// A seed is a whole number from 0.
std::expected<void, Outcome> check_seed(std::int64_t seed);

/// Time scales that a simulation can keep up with: 0.01 to 100.
std::expected<void, Outcome> check_time_scale(double scale);

}  // namespace sinew::cli
