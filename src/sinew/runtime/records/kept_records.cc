#include "sinew/runtime/records/kept_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>

#include "sinew/io/disk_folder.h"
#include "sinew/io/file.h"
#include "sinew/runtime/journal/position_record.h"
#include "sinew/runtime/records/mcap_reader.h"

namespace sinew::runtime {
namespace {

constexpr std::string_view kEnding = ".mcap";

std::optional<int> number_in(std::string_view digits) {
  int value = 0;
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool all = end.ec == std::errc{} && end.ptr == digits.data() + digits.size();
  return all ? std::optional(value) : std::nullopt;
}

/// Of "20261122T004512.345Z", as record_name() writes it.
std::optional<std::int64_t> time_in(std::string_view text) {
  using namespace std::chrono;
  if (text.size() < 20 || text[8] != 'T' || text[15] != '.' || text[19] != 'Z') return std::nullopt;
  constexpr std::pair<std::size_t, std::size_t> kParts[] = {{0, 4},  {4, 2},  {6, 2}, {9, 2},
                                                            {11, 2}, {13, 2}, {16, 3}};
  int parts[7];
  for (std::size_t i = 0; i < 7; ++i) {
    const auto part = number_in(text.substr(kParts[i].first, kParts[i].second));
    if (!part) return std::nullopt;
    parts[i] = *part;
  }
  const year_month_day date(year(parts[0]), month(static_cast<unsigned>(parts[1])),
                            day(static_cast<unsigned>(parts[2])));
  if (!date.ok()) return std::nullopt;
  const auto at = sys_days(date) + hours(parts[3]) + minutes(parts[4]) + seconds(parts[5]) +
                  milliseconds(parts[6]);
  return duration_cast<milliseconds>(at.time_since_epoch()).count();
}

/// What record_name() has put into it.
KeptRecord read_name(const std::string& name) {
  KeptRecord record;
  record.name = name;
  const std::string_view stem = std::string_view(name).substr(0, name.size() - kEnding.size());
  const std::size_t first = stem.find('_');
  const std::size_t last = stem.rfind('_');
  if (first == std::string_view::npos || last == first) return record;
  record.began_ms = time_in(stem.substr(last + 1));
  if (!record.began_ms) return record;
  record.robot = stem.substr(0, first);
  record.title = stem.substr(first + 1, last - first - 1);
  record.fault = record.title.starts_with("fault-");
  return record;
}

}  // namespace

bool is_record_name(std::string_view name) {
  const auto fine = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.';
  };
  return name.size() > kEnding.size() && name.size() <= Disk::kNameMax && name.ends_with(kEnding) &&
         name.front() != '.' && std::ranges::all_of(name, fine);
}

io::IoResult<std::vector<KeptRecord>> KeptRecords::list() {
  auto disk = io::DiskFolder::open_folder(folder_);
  if (!disk) return std::unexpected(disk.error());
  const auto names = disk->list();
  if (!names) return std::unexpected(io::disk_error(folder_, names.error()));
  std::vector<KeptRecord> records;
  std::map<std::string, Known> known;
  for (const std::string& name : *names) {
    if (!is_record_name(name)) continue;
    const auto stamp = disk->stamp(name);
    if (!stamp) continue;  // gone meanwhile
    KeptRecord record = read_name(name);
    record.size = stamp->size;
    const auto before = known_.find(name);
    if (before != known_.end() && before->second.changed_ns == stamp->changed_ns) {
      record.length = before->second.length;
    } else {
      record.length = mcap_length(stamp->size, [&](std::uint64_t offset, std::size_t size) {
        return io::read_part(path(name), offset, size).value_or("");
      });
    }
    known[name] = {stamp->changed_ns, record.length};
    records.push_back(std::move(record));
  }
  known_.swap(known);
  std::ranges::sort(records, [](const KeptRecord& one, const KeptRecord& other) {
    const auto begun = one.began_ms.value_or(0), other_begun = other.began_ms.value_or(0);
    return begun != other_begun ? begun > other_begun : one.name < other.name;
  });
  return records;
}

io::IoResult<void> KeptRecords::check_room() {
  const auto records = list();
  if (!records) return std::unexpected(records.error());
  std::uint64_t all = 0;
  for (const KeptRecord& one : *records) all += one.size;
  if (records->size() < kFilesMax && all < kAllMax) return {};
  return std::unexpected(io::IoError{
      fmt::format("{} holds {} records of {} MB together, and no more than {} or {} MB are kept; "
                  "remove some of them",
                  folder_, records->size(), all >> 20, kFilesMax, kAllMax >> 20)});
}

io::IoResult<void> KeptRecords::remove(const std::string& name) {
  auto disk = io::DiskFolder::open_folder(folder_);
  if (!disk) return std::unexpected(disk.error());
  auto removed = disk->remove(name);
  if (removed) removed = disk->sync_folder();
  if (!removed) return std::unexpected(io::disk_error(path(name), removed.error()));
  return {};
}

}  // namespace sinew::runtime
