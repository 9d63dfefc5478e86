#pragma once

#include <string>

#include "support/scratch_folder.h"

namespace sinew::test {

/// With joints that turn little: searching the end stops of the whole arm takes some minutes.
inline std::string small_robot_arm_2(const ScratchFolder& folder, bool link) {
  std::string text = text_of(std::string(SINEW_SOURCE_DIR) + "/robots/robot-arm-2.toml");
  const auto replace = [&](const std::string& key, const std::string& value) {
    for (std::size_t at = 0; (at = text.find("\n" + key + " = ", at)) != std::string::npos; ++at) {
      const std::size_t begin = at + key.size() + 4;
      text.replace(begin, text.find('\n', begin) - begin, value);
    }
  };
  replace("lower_deg", "-6");
  replace("upper_deg", "6");
  replace("  zero_deg", "-6");
  if (!link) return folder.file("small.toml", text);
  // With our own boards, which stop when they hear nothing for so long: as long as they allow,
  // since on this clock a busy computer's pauses are longer.
  const std::size_t begin = text.find("protocol = ");
  const std::size_t end = text.find("\n\n", begin);
  text.replace(begin, end - begin,
               "protocol = \"axis_link\"\nmotion = \"stream\"\nfeedback = \"measured\"\n"
               "segment_ms = 50\nclock_hz = 4000000\ndeadline_ms = 500\n"
               "source.rest = \"for this test\"");
  // Angles on that wire are the joint's own.
  for (const std::string key : {"  zero_deg = ", "  source.zero_deg = "}) {
    for (std::size_t at = 0; (at = text.find("\n" + key)) != std::string::npos;) {
      text.erase(at, text.find('\n', at + 1) - at);
    }
  }
  return folder.file("small.toml", text);
}

}  // namespace sinew::test
