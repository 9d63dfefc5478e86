#include "sinew/motion/step_timing.h"

std::int64_t share(const sinew::motion::StepSegment& segment);
std::int64_t share(const sinew::motion::StepSegment& segment) {
  return segment.c1 / static_cast<std::int64_t>(segment.duration);
}
