#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/model/device.h"

/// The BigRobotArm's own program format: moves in motor steps, and blocks that repeat.
///
///   # a comment
///   BEGIN I5
///   G0 B100 S200 E300 WR400 W300
///   G0 B0 S50 E5000 WR1500 W0
///   END
///
/// The firmware reads words by their place and forgives everything; here a letter out of place, a
/// number out of range or an unknown word is a complaint, because the arm would have moved.
namespace sinew::sequence {

using Words = std::array<std::int32_t, kBigRobotArmJoints>;

/// How many of the five words a line gave; the joints behind keep what they have.
struct GivenWords {
  Words words{};
  std::size_t count = kBigRobotArmJoints;
  friend bool operator==(const GivenWords&, const GivenWords&) = default;
};

struct Move {
  GivenWords steps;  ///< G0: motor microsteps as the firmware counts them
  friend bool operator==(const Move&, const Move&) = default;
};
struct Home {  ///< G28
  friend bool operator==(const Home&, const Home&) = default;
};
struct Reset {  ///< G92: here is zero
  friend bool operator==(const Reset&, const Reset&) = default;
};
struct Speeds {  ///< M203: hundredths of a motor revolution per s
  GivenWords multipliers;
  friend bool operator==(const Speeds&, const Speeds&) = default;
};
struct Accelerations {  ///< M201: hundredths of a motor revolution per s^2
  GivenWords multipliers;
  friend bool operator==(const Accelerations&, const Accelerations&) = default;
};
struct Gripper {  ///< G1: degrees of its servo, taken only when enabled
  bool enabled = false;
  std::int32_t position = 0;
  friend bool operator==(const Gripper&, const Gripper&) = default;
};
/// S0, S1: from here on the joints arrive together. The host sees to it by scaling speeds; the
/// device's own sync mode counts positions in a frame of its own and is not used.
struct Synchronise {
  bool on = false;
  friend bool operator==(const Synchronise&, const Synchronise&) = default;
};

using Command = std::variant<Move, Home, Reset, Speeds, Accelerations, Gripper, Synchronise>;

struct Step {
  int line = 0;  ///< from 1
  Command command;
};

inline constexpr int kRepeatsMax = 127;            ///< the firmware counts rounds in 8 bits
inline constexpr std::size_t kBlockMax = 20;       ///< commands that the firmware has room for
inline constexpr std::size_t kComplaintMax = 100;  ///< more than that nobody reads

/// A BEGIN .. END block, or a single command outside of one (repeats 1).
struct Section {
  bool block = false;
  int line = 0;
  int repeats = 1;
  std::vector<Step> steps;
};

struct Program {
  std::vector<Section> sections;
};

/// Reads a whole file; lines end with LF or CR LF.
/// @param file_name  as complaints shall show it
/// @return every complaint that the file earns, up to kComplaintMax, in the order of the lines;
///         columns count bytes.
std::expected<Program, std::vector<Complaint>> parse(std::string_view text,
                                                     std::string_view file_name,
                                                     const BigRobotArmDevice& device);

/// The program's one spelling; parse() gives the same sections back, lines counted anew.
std::string to_text(const Program& program);

/// Same sections and commands, wherever they stood.
bool same(const Program& a, const Program& b);

}  // namespace sinew::sequence
