#include "sinew/server/event_file.h"

#include <algorithm>
#include <filesystem>

#include "sinew/io/disk_folder.h"
#include "sinew/server/event_log.h"

namespace sinew::server {
namespace {

/// The last whole lines that are events.
std::vector<Json> events_of(std::string_view text) {
  std::vector<Json> events;
  while (!text.empty() && events.size() < EventLog::kMax) {
    if (text.ends_with('\n')) text.remove_suffix(1);
    const std::size_t begin = text.rfind('\n') + 1;
    Json event = Json::parse(text.substr(begin), nullptr, false);
    const bool fits = event.is_object() && event.contains("kind") && event["kind"].is_string() &&
                      event.contains("robot") && event["robot"].is_string() &&
                      event.contains("at_ms") && event["at_ms"].is_number_integer();
    if (fits) events.push_back(std::move(event));
    text = text.substr(0, begin);
  }
  std::ranges::reverse(events);
  return events;
}

}  // namespace

io::IoResult<EventFile::Opened> EventFile::open(const std::string& path) {
  const auto folder = io::DiskFolder::open_folder(std::filesystem::path(path).parent_path());
  if (!folder) return std::unexpected(folder.error());
  std::string text;
  if (io::exists(path)) {
    const auto size = io::file_size(path);
    if (!size) return std::unexpected(size.error());
    auto last = io::read_part(path, *size > kSizeMax ? *size - kSizeMax : 0, kSizeMax);
    if (!last) return std::unexpected(last.error());
    text = std::move(*last);
  }
  std::vector<Json> events = events_of(text);
  text.clear();
  for (const Json& event : events) text += event.dump() + "\n";
  if (auto kept = io::replace_file(path, text); !kept) return std::unexpected(kept.error());
  auto file = io::LineFile::append(path);
  if (!file) return std::unexpected(file.error());
  return Opened{EventFile(path, std::move(*file), text.size()), std::move(events)};
}

void EventFile::add(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    file_.add(line);
    size_ += line.size() + 1;
  }
  if (size_ <= kSizeMax && !file_.failure()) return;
  if (auto anew = open(path_)) *this = std::move(anew->file);
}

}  // namespace sinew::server
