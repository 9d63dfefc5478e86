#include "motion/motion_sums.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace sinew::planning {

void MotionSums::add(const MotionSums& other) {
  for (const auto count :
       {&MotionSums::sequences, &MotionSums::commands, &MotionSums::samples, &MotionSums::plans,
        &MotionSums::blends, &MotionSums::jogs, &MotionSums::takeovers, &MotionSums::stops,
        &MotionSums::outside, &MotionSums::ways_in, &MotionSums::contact_looks}) {
    this->*count += other.*count;
  }
  for (std::size_t i = 0; i < refused.size(); ++i) refused[i] += other.refused[i];
  for (const auto worst :
       {&MotionSums::beyond, &MotionSums::velocity, &MotionSums::acceleration, &MotionSums::jerk,
        &MotionSums::tool_speed, &MotionSums::tool_acceleration, &MotionSums::stop_time,
        &MotionSums::jog_inside}) {
    this->*worst = std::max(this->*worst, other.*worst);
  }
}

std::string MotionSums::text() const {
  std::ostringstream out;
  out << sequences << " sequences, " << commands << " commands, " << samples << " samples, "
      << contact_looks << " looked at for contact; " << plans << " plans (" << blends
      << " blends), " << jogs << " jogs (" << takeovers << " out of a motion), " << stops
      << " stops, " << outside << " starts outside (" << ways_in << " plans from there); refused";
  for (const ErrorInfo& row : error_table()) {
    const std::uint64_t count = refused[static_cast<std::uint8_t>(row.code)];
    if (count > 0) out << ' ' << row.name << ' ' << count;
  }
  out << std::setprecision(10) << "; worst shares: velocity " << velocity << ", acceleration "
      << acceleration << ", jerk " << jerk << ", tool speed " << tool_speed
      << ", tool acceleration " << tool_acceleration << ", time to stop " << stop_time
      << std::setprecision(3) << "; outside limits of position by " << beyond
      << ", jogs inside the margin by " << jog_inside << " m";
  return out.str();
}

}  // namespace sinew::planning
