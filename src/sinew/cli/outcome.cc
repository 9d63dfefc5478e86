#include "sinew/cli/outcome.h"

namespace sinew::cli {
namespace {

Outcome failure(ExitCode exit, const std::string& sentence) {
  return {exit, Json{{"error", {{"sentence", sentence}}}}, "", sentence};
}

}  // namespace

Outcome bad_input(const std::string& sentence) {
  return failure(ExitCode::kBadInput, sentence);
}
Outcome could_not(const std::string& sentence) {
  return failure(ExitCode::kCouldNot, sentence);
}

}  // namespace sinew::cli
