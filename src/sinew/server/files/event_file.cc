#include "sinew/server/files/event_file.h"

#include <algorithm>
#include <filesystem>

#include "sinew/server/files/event_log.h"

namespace sinew::server {
namespace {

constexpr std::int64_t kTimeMax = 8'640'000'000'000'000;  // ms; no later day has a date

/// As clients can show it: a date that they know.
bool is_event(const Json& json) {
  if (!json.is_object()) return false;
  const auto kind = json.find("kind");
  const auto robot = json.find("robot");
  const auto at = json.find("at_ms");
  const bool named = kind != json.end() && kind->is_string() && robot != json.end() &&
                     robot->is_string() && at != json.end() && at->is_number_integer();
  return named && at->get<std::int64_t>() >= 0 && at->get<std::int64_t>() < kTimeMax;
}

/// The last whole lines that are events.
std::vector<Json> events_of(std::string_view text) {
  std::vector<Json> events;
  while (!text.empty() && events.size() < EventLog::kMax) {
    if (text.ends_with('\n')) text.remove_suffix(1);
    const std::size_t begin = text.rfind('\n') + 1;
    const std::string_view line = text.substr(begin);
    if (!too_deep(line)) {
      Json event = Json::parse(line, nullptr, false);
      if (is_event(event)) events.push_back(std::move(event));
    }
    text = text.substr(0, begin);
  }
  std::ranges::reverse(events);
  return events;
}

struct CutBack {
  io::LineFile file;
  std::uint64_t size = 0;
  std::vector<Json> events;
};

/// Leaves the last events only, and goes on behind them.
io::IoResult<CutBack> cut_back(const std::string& path) {
  std::string text;
  if (io::exists(path)) {
    const auto size = io::file_size(path);
    if (!size) return std::unexpected(size.error());
    const std::uint64_t most = EventFile::kSizeMax + EventFile::kSizeMax / 4;
    auto last = io::read_part(path, *size > most ? *size - most : 0, most);
    if (!last) return std::unexpected(last.error());
    text = std::move(*last);
  }
  std::vector<Json> events = events_of(text);
  text.clear();
  for (const Json& event : events) text += text_of(event) + "\n";
  if (auto kept = io::replace_file(path, text); !kept) return std::unexpected(kept.error());
  auto file = io::LineFile::append(path);
  if (!file) return std::unexpected(file.error());
  return CutBack{std::move(*file), text.size(), std::move(events)};
}

}  // namespace

io::IoResult<EventFile::Opened> EventFile::open(const std::string& path) {
  const std::filesystem::path place(path);
  auto folder = io::DiskFolder::open_folder(place.parent_path());
  if (!folder) return std::unexpected(folder.error());
  const std::string lock = place.filename().string() + ".lock";
  if (const auto locked = folder->lock(lock); !locked) {
    return std::unexpected(io::disk_error(path, locked.error()));
  }
  auto kept = cut_back(path);
  if (!kept) return std::unexpected(kept.error());
  return Opened{EventFile(std::move(*folder), path, std::move(kept->file), kept->size),
                std::move(kept->events)};
}

void EventFile::add(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    file_.add(line);
    size_ += line.size() + 1;
  }
  if (size_ <= kSizeMax && !file_.failure()) return;
  if (auto kept = cut_back(path_)) {
    file_ = std::move(kept->file);
    size_ = kept->size;
  }
}

}  // namespace sinew::server
