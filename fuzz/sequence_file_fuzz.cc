#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_sequence.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"

// Any text is a program or earns complaints that point into it; a program is written in its one
// spelling, which reads back as the same program, also with CR LF and comments about it.

namespace {

using namespace sinew;

std::string with_crlf_and_comments(std::string_view text) {
  std::string out = "# first\r\n\r\n";
  for (const char character : text) {
    if (character == '\n') out += "\t# more\r";
    out += character;
  }
  return out;
}

void complaints_point_into(std::string_view text, const std::vector<Complaint>& complaints) {
  const auto lines = 1 + std::count(text.begin(), text.end(), '\n');
  SINEW_ASSERT(!complaints.empty() && complaints.size() <= sequence::kComplaintMax);
  int last = 1;
  for (const auto& complaint : complaints) {
    SINEW_ASSERT(complaint.line >= last && complaint.line <= lines);
    SINEW_ASSERT(complaint.column >= 1 &&
                 static_cast<std::size_t>(complaint.column) <= text.size() + 1);
    SINEW_ASSERT(complaint.message.find('\n') == std::string::npos);
    last = complaint.line;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const BigRobotArmDevice device;
  const auto program = sequence::parse(text, "f", device);
  if (!program) {
    complaints_point_into(text, program.error());
    return 0;
  }
  const std::string spelled = sequence::to_text(*program);
  const auto again = sequence::parse(spelled, "f", device);
  SINEW_ASSERT(again && sequence::same(*again, *program));
  SINEW_ASSERT(sequence::to_text(*again) == spelled);
  const auto decorated = sequence::parse(with_crlf_and_comments(spelled), "f", device);
  SINEW_ASSERT(decorated && sequence::same(*decorated, *program));
  return 0;
}
