#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sinew/core/complaint.h"

namespace sinew::cli {

using Json = nlohmann::ordered_json;

/// What the process tells its caller.
enum class ExitCode : std::uint8_t {
  kDone = 0,
  kCouldNot = 1,  ///< the request is understood and cannot be met
  kBadInput = 2,  ///< the request makes no sense as it stands
};

/// What one verb answers, for both kinds of readers. Verbs make it, main prints it.
struct Outcome {
  ExitCode exit = ExitCode::kDone;
  Json json = Json::object();  ///< with --json, on stdout
  std::string text;            ///< without --json, on stdout
  std::string complaint;       ///< a sentence for stderr, in both cases
  bool silent = false;         ///< nothing on stdout: it belongs to a protocol
  bool json_line = false;      ///< not the first document on stdout: one line, as the others
  bool at_once = false;        ///< the process ends without waiting for what is under way
};

/// Prints an outcome for one of both kinds of readers and gives the exit code. Whatever bytes a
/// user or a file brought in, the terminal gets no control characters and JSON is valid.
int print(const Outcome& outcome, bool json);

/// Bad input: the sentence goes to stderr, and to JSON as {"error":{"sentence":..}}.
Outcome bad_input(const std::string& sentence);

/// A request that cannot be met for a reason outside of the robot (a port, a file).
Outcome could_not(const std::string& sentence);

/// Everything that is wrong with a file, a line each, and as {"error":{"complaints":[..]}}.
Outcome complaints_outcome(const std::vector<Complaint>& complaints);

}  // namespace sinew::cli
