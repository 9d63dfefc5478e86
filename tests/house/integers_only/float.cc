#include "sinew/motion/step_timing.h"

std::int64_t half(const sinew::motion::StepSegment& segment);
std::int64_t half(const sinew::motion::StepSegment& segment) {
  return static_cast<std::int64_t>(0.5 * static_cast<double>(segment.c1));
}
