#include "sinew/cli/cells/record_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include "sinew/cli/output/table.h"
#include "sinew/io/disk_folder.h"
#include "sinew/io/file.h"
#include "sinew/runtime/records/mcap_reader.h"
#include "sinew/runtime/records/record_csv.h"
#include "sinew/runtime/records/record_pictures.h"

namespace sinew::cli {
namespace {

constexpr std::size_t kFileMax = std::size_t{1} << 30;

using runtime::McapContent;
using runtime::McapMessage;

std::string complaint_of(const std::string& file, const runtime::McapTrouble& trouble) {
  return fmt::format("{}: at byte {}: {}", file, trouble.offset, trouble.sentence);
}

Outcome content_outcome(const std::string& file, const McapContent& content) {
  Outcome outcome;
  Table table({"channel", "schema", "messages"});
  table.left(0).left(1);
  Json channels = Json::array();
  std::map<std::uint16_t, std::size_t> counts;
  for (const McapMessage& message : content.messages) ++counts[message.channel];
  for (const auto& [id, channel] : content.channels) {
    const auto schema = content.schemas.find(channel.schema);
    const std::string name = schema != content.schemas.end() ? schema->second.name : "";
    table.add({channel.topic, name, fmt::format("{}", counts[id])});
    channels.push_back({{"topic", channel.topic}, {"schema", name}, {"messages", counts[id]}});
  }
  const auto by_time = [](const McapMessage& message) { return message.time; };
  double duration = 0;
  if (!content.messages.empty()) {
    const auto [first, last] = std::ranges::minmax_element(content.messages, {}, by_time);
    duration = runtime::seconds_between(first->time, last->time);
  }
  outcome.json = {{"file", file},
                  {"library", content.library},
                  {"duration_s", duration},
                  {"channels", channels},
                  {"metadata", content.metadata},
                  {"whole", !content.trouble.has_value()}};
  outcome.text = fmt::format("{}\n  {:.2f} s, written by {}\n", table.text(), duration,
                             content.library.empty() ? "nobody it names" : content.library);
  return outcome;
}

/// Pictures and decisions.csv into a folder. @return why not
std::optional<Outcome> write_pictures(const std::string& folder, const std::string& file,
                                      const McapContent& content, Outcome& outcome) {
  const auto pictures = runtime::record_pictures(content);
  if (!pictures) return bad_input(file + ": " + pictures.error());
  const auto decisions = runtime::decisions_csv(content);
  if (!decisions) return bad_input(file + ": " + decisions.error());
  if (pictures->empty()) {
    return bad_input(file +
                     ": there is no picture in it; programs with look, pick or seen leave "
                     "some");
  }
  if (const auto made = io::DiskFolder::open_folder(folder); !made) {
    return could_not("--pictures: " + made.error().sentence);
  }
  const auto write = [&](const std::string& name, const std::string& text) {
    return io::replace_file(folder + "/" + name, text);
  };
  auto written = write("decisions.csv", *decisions);
  for (const runtime::RecordedPicture& picture : *pictures) {
    if (written) written = write(picture.name, picture.jpeg);
  }
  if (!written) return could_not("--pictures: " + written.error().sentence);
  outcome.text += fmt::format("  {}: {} pictures and decisions.csv\n", folder, pictures->size());
  outcome.json["pictures"] = {{"folder", folder}, {"count", pictures->size()}};
  return std::nullopt;
}

}  // namespace

Outcome show_record(const RecordRequest& request) {
  if (request.csv) {
    if (const auto fine = io::check_place(*request.csv); !fine) {
      return bad_input("--csv: " + fine.error().sentence);
    }
    if (io::same_file(*request.csv, request.file)) {
      return bad_input("--csv: " + *request.csv + " is the record; choose another name");
    }
  }
  const auto text = io::read_file(request.file, kFileMax);
  if (!text) return bad_input(text.error().sentence);
  const McapContent content =
      runtime::read_mcap({reinterpret_cast<const std::uint8_t*>(text->data()), text->size()});
  if (content.trouble && (!content.trouble->cut || content.channels.empty())) {
    return bad_input(complaint_of(request.file, *content.trouble));
  }
  Outcome outcome = content_outcome(request.file, content);
  if (content.trouble) {
    outcome.text += "  note: it was cut off, this is what there is: " +
                    complaint_of(request.file, *content.trouble) + "\n";
    outcome.json["trouble"] = complaint_of(request.file, *content.trouble);
  }
  if (request.pictures) {
    if (auto failed = write_pictures(*request.pictures, request.file, content, outcome)) {
      return std::move(*failed);
    }
  }
  if (!request.csv) return outcome;
  const auto csv = runtime::record_csv(content);
  if (!csv) return bad_input(request.file + ": " + csv.error());
  if (const auto written = io::replace_file(*request.csv, *csv); !written) {
    return could_not("--csv: " + written.error().sentence);
  }
  outcome.text += "  " + *request.csv + "\n";
  outcome.json["csv"] = *request.csv;
  return outcome;
}

void add_record(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<RecordRequest>();
  RecordRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "record", "what is in the record of a run",
                            "sinew record run.mcap --csv run.csv");
  verb->add_option("FILE", request.file, "NAME.mcap")->required();
  verb->add_option("--csv", request.csv, "the same as a table: a row for each sample");
  verb->add_option("--pictures", request.pictures,
                   "a folder for what a program looked at, and what it decided by that");
  verb->callback([&call, own] { call.verb = [own] { return show_record(*own); }; });
}

}  // namespace sinew::cli
