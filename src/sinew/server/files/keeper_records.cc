#include <fmt/format.h>

#include <algorithm>

#include "sinew/core/base64.h"
#include "sinew/core/spelling.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/runtime/records/mcap_reader.h"
#include "sinew/runtime/records/record_csv.h"
#include "sinew/server/files/keeper.h"

namespace sinew::server {
namespace {

using runtime::KeptRecord;
using runtime::KeptRecords;

constexpr std::size_t kTitleMax = 32;  // of what a file's name takes

std::unexpected<RpcError> no_record(std::string sentence, const char* code) {
  return std::unexpected(RpcError{RpcCode::kRefused, std::move(sentence), {{"code", code}}});
}

std::expected<void, RpcError> check_name(const std::string& record) {
  if (runtime::is_record_name(record)) return {};
  return std::unexpected(invalid("record is a name of records.list, as left_move_TIME.mcap"));
}

Json record_row(const KeptRecord& record) {
  Json json{{"record", record.name}, {"size_bytes", record.size}, {"fault", record.fault}};
  if (!record.robot.empty()) json["robot"] = record.robot;
  if (!record.title.empty()) json["title"] = record.title;
  if (record.began_ms) json["began_ms"] = *record.began_ms;
  if (record.length) json["length_s"] = *record.length;
  return json;
}

Json part_json(const std::string& record, std::uint64_t offset, std::string_view part,
               std::uint64_t size) {
  return {{"record", record},
          {"offset", offset},
          {"data", base64(part)},
          {"size_bytes", size},
          {"end", offset + part.size() >= size}};
}

}  // namespace

/// The robot that writes this record now; empty: none does.
std::string Keeper::record_being_written(const std::string& name) const {
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    const auto now = cell_.station(i).wanted();
    if (now && now->name == name) return cell_.station(i).name();
  }
  return {};
}

Keeper::Result Keeper::list_records() {
  if (records_.folder().empty()) return Json{{"folder", ""}, {"records", Json::array()}};
  const auto records = records_.list();
  if (!records) return no_record(records.error().sentence, "disk");
  Json rows = Json::array();
  for (const KeptRecord& one : *records) {
    rows.push_back(record_row(one));
    if (!record_being_written(one.name).empty()) rows.back()["under_way"] = true;
  }
  return Json{{"folder", records_.folder()},
              {"size_max_bytes", KeptRecords::kSizeMax},
              {"all_max_bytes", KeptRecords::kAllMax},
              {"records", std::move(rows)}};
}

Keeper::Result Keeper::read_record(const std::string& record, std::uint64_t offset) {
  if (const auto fine = check_name(record); !fine) return std::unexpected(fine.error());
  const std::string path = records_.path(record);
  const auto size = io::file_size(path);
  if (!size) return no_record(size.error().sentence, "missing");
  const auto part = io::read_part(path, offset, kPart);
  if (!part) return no_record(part.error().sentence, "disk");
  return part_json(record, offset, *part, *size);
}

Keeper::Result Keeper::read_csv(const std::string& record, std::uint64_t offset) {
  if (const auto fine = check_name(record); !fine) return std::unexpected(fine.error());
  const std::string path = records_.path(record);
  const auto size = io::file_size(path);
  if (!size) return no_record(size.error().sentence, "missing");
  if (csv_.record != record || csv_.size != *size) {
    const auto bytes = io::read_file(path, KeptRecords::kSizeMax + (std::size_t{8} << 20));
    if (!bytes) return no_record(bytes.error().sentence, "disk");
    const auto content =
        runtime::read_mcap({reinterpret_cast<const std::uint8_t*>(bytes->data()), bytes->size()});
    if (content.trouble && !content.trouble->cut) {
      return no_record(fmt::format("{}: at byte {}: {}", record, content.trouble->offset,
                                   content.trouble->sentence),
                       "damaged");
    }
    auto text = runtime::record_csv(content);
    if (!text) return no_record(record + ": " + text.error(), "empty");
    csv_ = {record, *size, std::move(*text)};
  }
  const std::string_view rest =
      offset < csv_.text.size() ? std::string_view(csv_.text).substr(offset, kPart) : "";
  return part_json(record, offset, rest, csv_.text.size());
}

Keeper::Result Keeper::remove_record(const std::string& record) {
  if (const auto fine = check_name(record); !fine) return std::unexpected(fine.error());
  if (const std::string robot = record_being_written(record); !robot.empty()) {
    return no_record(record + " is being written; record.stop of " + robot + " ends it",
                     "under_way");
  }
  if (const auto removed = records_.remove(record); !removed) {
    return no_record(removed.error().sentence, "missing");
  }
  ++changes_;
  return Json::object();
}

Keeper::Result Keeper::start_record(std::size_t robot, const std::string& title) {
  runtime::Station& station = cell_.station(robot);
  const std::string what = printable(title.substr(0, kTitleMax));
  if (what.starts_with("fault-")) {
    return std::unexpected(invalid("title: records of faults begin with fault-; choose another"));
  }
  if (records_.folder().empty()) return no_record("this cell keeps no records", "none");
  if (const auto now = station.wanted()) {
    return std::unexpected(RpcError{RpcCode::kBusy,
                                    station.name() + " is being recorded already",
                                    {{"code", "under_way"}, {"record", now->name}}});
  }
  if (const auto room = records_.check_room(); !room) {
    return no_record(room.error().sentence, "no_room");
  }
  const std::string name =
      runtime::record_name(station.name(), what.empty() ? "recording" : what, io::wall_time_ns());
  const auto begun = station.begin_wanted({records_.folder(), name, what, KeptRecords::kSizeMax});
  if (!begun) return no_record(begun.error().sentence, "disk");
  ++changes_;
  return Json{{"record", name}, {"path", records_.path(name)}};
}

Keeper::Result Keeper::stop_record(std::size_t robot) {
  const auto told = cell_.station(robot).end_wanted();
  if (!told) return no_record(cell_.station(robot).name() + " is not being recorded", "none");
  ++changes_;
  Json json{{"record", told->path.substr(told->path.rfind('/') + 1)},
            {"path", told->path},
            {"lost", told->lost}};
  if (const auto size = io::file_size(told->path)) json["size_bytes"] = *size;
  if (!told->trouble.empty()) json["trouble"] = told->trouble;
  return json;
}

}  // namespace sinew::server
