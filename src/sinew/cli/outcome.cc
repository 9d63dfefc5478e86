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

Outcome complaints_outcome(const std::vector<Complaint>& complaints) {
  Json list = Json::array();
  std::string sentences;
  for (const Complaint& complaint : complaints) {
    list.push_back({{"file", complaint.file},
                    {"line", complaint.line},
                    {"column", complaint.column},
                    {"key", complaint.key},
                    {"sentence", complaint.message}});
    sentences += (sentences.empty() ? "" : "\n") + to_text(complaint);
  }
  Outcome outcome = bad_input(sentences);
  outcome.json["error"]["complaints"] = list;
  return outcome;
}

}  // namespace sinew::cli
