#include "sinew/cli/output/outcome.h"

#include <fmt/format.h>

#include <cstdio>
#include <string_view>

#include "sinew/cli/output/shown_text.h"
#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

Outcome failure(ExitCode exit, const std::string& sentence) {
  Outcome outcome;
  outcome.exit = exit;
  outcome.json = Json{{"error", {{"sentence", sentence}}}};
  outcome.complaint = sentence;
  return outcome;
}

void tell(std::string_view complaint) {
  std::fputs(fmt::format("sinew: {}\n", shown(complaint)).c_str(), stderr);
}

}  // namespace

int print(const Outcome& outcome, bool json) {
  std::string text = shown(outcome.text);
  if (json) {
    const int indent = outcome.json_line ? -1 : 2;
    text = outcome.json.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
  }
  const auto written = outcome.silent ? io::IoResult<void>{} : io::write_stdout(text);
  if (!outcome.complaint.empty()) tell(outcome.complaint);
  if (!written) tell(written.error().sentence);
  // Exit 0 promises that the answer arrived.
  if (!written && outcome.exit == ExitCode::kDone) return static_cast<int>(ExitCode::kCouldNot);
  return static_cast<int>(outcome.exit);
}

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
