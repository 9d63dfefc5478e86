#include "sinew/control/machine_state.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>

namespace sinew::control {
namespace {

constexpr MachineState state_of(std::size_t i) {
  return static_cast<MachineState>(i);
}

TEST(MachineState, every_row_stands_once_and_leads_somewhere_else) {
  std::set<std::pair<MachineState, Signal>> seen;
  for (const Transition& row : kTransitions) {
    EXPECT_TRUE(seen.insert({row.from, row.signal}).second) << name(row.from) << name(row.signal);
    EXPECT_NE(row.from, row.to) << name(row.from) << name(row.signal);
  }
}

TEST(MachineState, nothing_begins_to_move_but_from_ready_and_held) {
  for (const Transition& row : kTransitions) {
    if (!may_move(row.to) || may_move(row.from)) continue;
    EXPECT_TRUE(row.from == MachineState::kReady || row.from == MachineState::kHeld)
        << name(row.from);
    EXPECT_NE(row.signal, Signal::kAcknowledge);
  }
}

TEST(MachineState, a_stop_ends_every_motion_and_begins_none) {
  for (std::size_t i = 0; i < kMachineStates; ++i) {
    const auto to = next_state(state_of(i), Signal::kStop);
    if (state_of(i) == MachineState::kMoving || state_of(i) == MachineState::kRecovering) {
      EXPECT_EQ(to, MachineState::kStopping);
    } else if (to) {
      EXPECT_FALSE(may_move(*to)) << name(state_of(i));
    }
  }
}

TEST(MachineState, out_of_a_fault_leads_only_an_acknowledgement_and_only_to_off) {
  for (std::size_t i = 0; i < kSignals; ++i) {
    const auto to = next_state(MachineState::kFault, static_cast<Signal>(i));
    if (static_cast<Signal>(i) == Signal::kAcknowledge) {
      EXPECT_EQ(to, MachineState::kOff);
    } else {
      EXPECT_FALSE(to) << name(static_cast<Signal>(i));
    }
  }
}

TEST(MachineState, every_state_can_be_reached_and_left) {
  std::set<MachineState> reached{MachineState::kOff};
  for (std::size_t round = 0; round < kMachineStates; ++round) {
    for (const Transition& row : kTransitions) {
      if (reached.contains(row.from)) reached.insert(row.to);
    }
  }
  EXPECT_EQ(reached.size(), kMachineStates);
  // And from each of them there is a way back to off.
  std::set<MachineState> returns{MachineState::kOff};
  for (std::size_t round = 0; round < kMachineStates; ++round) {
    for (const Transition& row : kTransitions) {
      if (returns.contains(row.to)) returns.insert(row.from);
    }
  }
  EXPECT_EQ(returns.size(), kMachineStates);
}

TEST(MachineState, table_of_the_documentation_is_the_one_in_the_code) {
  std::ifstream file(SINEW_DOCS_DIR "/control.md");
  ASSERT_TRUE(file);
  std::set<std::string> documented;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("| `")) continue;
    documented.insert(line.substr(0, line.rfind('|', line.rfind('|') - 1) + 1));
  }
  std::set<std::string> coded;
  for (const Transition& row : kTransitions) {
    coded.insert("| `" + std::string(name(row.from)) + "` | " + std::string(name(row.signal)) +
                 " | `" + std::string(name(row.to)) + "` |");
  }
  EXPECT_EQ(documented, coded);
}

}  // namespace
}  // namespace sinew::control
