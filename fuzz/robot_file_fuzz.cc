#include <cstddef>
#include <cstdint>
#include <string_view>

#include "sinew/config/robot_file.h"
#include "sinew/core/assert.h"
#include "support/robot_promises.h"

// Any bytes are a robot that keeps every promise of its model, or earn complaints with a place.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto robot = sinew::read_robot(text, "f");
  if (robot) {
    SINEW_ASSERT(sinew::test::broken_promise(*robot).empty());
    return 0;
  }
  SINEW_ASSERT(!robot.error().empty());
  for (const sinew::Complaint& complaint : robot.error()) {
    SINEW_ASSERT(complaint.line >= 1 && complaint.column >= 1 && !complaint.message.empty());
  }
  return 0;
}
