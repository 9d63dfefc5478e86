#pragma once

#include <array>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/devices/bigrobotarm/bigrobotarm_wire.h"
#include "support/golden.h"

/// What the vectors of the BigRobotArm's two wires mean.
namespace sinew::test {

inline bigrobotarm::Words words_of(const std::string& text, std::size_t count = 5) {
  std::stringstream stream(text);
  bigrobotarm::Words words{};
  for (std::size_t i = 0; i < count; ++i) {
    if (!(stream >> words[i])) throw std::runtime_error("too few words: " + text);
  }
  if (std::string more; stream >> more) throw std::runtime_error("too many words: " + text);
  return words;
}

inline bool flag_of(const std::string& text) {
  if (text != "on" && text != "off") throw std::runtime_error("neither on nor off: " + text);
  return text == "on";
}

inline bigrobotarm::Gripper gripper_of(const std::string& text) {
  const auto parts = split(text, ' ');
  return {flag_of(parts.at(0)), static_cast<std::uint8_t>(std::stoi(parts.at(1)))};
}

/// "goto 1 2 3 4 5" -> {"goto", "1 2 3 4 5"}.
inline std::array<std::string, 2> name_and_rest(const std::string& meaning) {
  const auto space = meaning.find(' ');
  if (space == std::string::npos) return {meaning, ""};
  return {meaning.substr(0, space), meaning.substr(space + 1)};
}

inline bigrobotarm::Request request_of(const std::string& meaning) {
  using namespace bigrobotarm;
  const auto [name, rest] = name_and_rest(meaning);
  if (name == "goto") return Goto{words_of(rest)};
  if (name == "home") return Home{};
  if (name == "reset") return Reset{};
  if (name == "speeds") return SetSpeeds{words_of(rest)};
  if (name == "accelerations") return SetAccelerations{words_of(rest)};
  if (name == "gripper") return SetGripper{gripper_of(rest).enabled, gripper_of(rest).position};
  if (name == "sync") return SetSync{flag_of(rest)};
  if (name == "status") return ReadStatus{};
  throw std::runtime_error("no such request: " + meaning);
}

inline bigrobotarm::Reply reply_of(const std::string& meaning) {
  using namespace bigrobotarm;
  const auto [name, rest] = name_and_rest(meaning);
  if (name == "started") return MotionStarted{rest == "home" ? RequestId::kHome : RequestId::kGoto};
  if (name == "goto-done") return GotoDone{words_of(rest)};
  if (name == "home-done") return HomeDone{words_of(rest)};
  if (name == "reset-done") return ResetDone{words_of(rest)};
  if (name == "speeds") return Speeds{words_of(rest)};
  if (name == "accelerations") return Accelerations{words_of(rest)};
  if (name == "gripper") return gripper_of(rest);
  if (name == "sync") return Sync{flag_of(rest)};
  if (name == "invalid") return Invalid{};
  if (name == "status") {
    const auto parts = split(rest, '/');
    return Status{words_of(parts.at(0)), words_of(parts.at(1)), words_of(parts.at(2)),
                  gripper_of(parts.at(3)), flag_of(parts.at(4))};
  }
  throw std::runtime_error("no such reply: " + meaning);
}

}  // namespace sinew::test
