#include "sinew/runtime/journal/port_claims.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "sinew/control/journal_record.h"

namespace sinew::runtime {
namespace {

DiskResult<std::string> text_of(Disk& disk, const std::string& file) {
  std::array<std::uint8_t, 4096> bytes{};
  const auto size = disk.read(file, bytes);
  if (!size) return std::unexpected(size.error());
  return std::string(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(*size));
}

}  // namespace

std::string PortClaims::file_of(const std::string& name) const {
  return fmt::format("port-{:08x}{:08x}.claim", journal_hash(name),
                     journal_hash(robot_ + "\n" + name));
}

std::vector<std::string> PortClaims::owner_of(const std::string& name) {
  const auto text = text_of(disk_, file_of(name));
  if (!text && text.error().code == DiskErrorCode::kMissing) return {};
  if (!text) return {""};
  const std::string behind = "\n" + robot_ + "\n" + name + "\n";
  return {text->ends_with(behind) ? text->substr(0, text->size() - behind.size()) : ""};
}

std::vector<std::string> PortClaims::owners() {
  std::vector<std::string> all;
  for (const std::string& name : names_) {
    for (std::string& owner : owner_of(name)) all.push_back(std::move(owner));
  }
  std::ranges::sort(all);
  const auto rest = std::ranges::unique(all);
  all.erase(rest.begin(), rest.end());
  return all;
}

DiskResult<void> PortClaims::write(const std::string& name, std::string_view journal) {
  const std::string text = fmt::format("{}\n{}\n{}\n", journal, robot_, name);
  const std::string beside = file_of(name) + ".new";
  const auto file = disk_.create(beside);
  if (!file) return std::unexpected(file.error());
  auto done =
      disk_.append(*file, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  if (done) done = disk_.sync(*file);
  disk_.close(*file);
  if (done) done = disk_.rename(beside, file_of(name));
  return done ? disk_.sync_folder() : done;
}

/// Of other machines of this kind.
DiskResult<void> PortClaims::let_go_of_others(std::string_view journal) {
  const auto files = disk_.list();
  if (!files) return std::unexpected(files.error());
  const std::string begin = std::string(journal) + "\n" + robot_ + "\n";
  for (const std::string& file : *files) {
    if (!file.starts_with("port-") || !file.ends_with(".claim")) continue;
    const auto text = text_of(disk_, file);
    if (!text || !text->starts_with(begin) || !text->ends_with('\n')) continue;
    const std::string name = text->substr(begin.size(), text->size() - begin.size() - 1);
    if (auto written = write(name, ""); !written) return written;
  }
  return {};
}

DiskResult<void> PortClaims::claim(std::string_view journal) {
  const std::vector<std::string> before = owners();
  if (std::ranges::find(before, journal) == before.end()) {
    if (auto done = let_go_of_others(journal); !done) return done;
  }
  for (const std::string& name : names_) {
    const auto owner = owner_of(name);
    if (!owner.empty() && owner.front() == journal) continue;
    if (auto written = write(name, journal); !written) return written;
  }
  return {};
}

DiskResult<void> PortClaims::release() {
  for (const std::string& name : names_) {
    const auto owner = owner_of(name);
    if (owner.empty() || owner.front().empty()) continue;
    if (auto written = write(name, ""); !written) return written;
  }
  return {};
}

}  // namespace sinew::runtime
