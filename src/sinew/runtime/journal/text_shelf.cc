#include "sinew/runtime/journal/text_shelf.h"

#include <algorithm>

namespace sinew::runtime {
namespace {

std::unexpected<ShelfRefusal> refuse(ShelfRefusal::Code code, std::uint64_t revision = 0) {
  return std::unexpected(ShelfRefusal{code, revision, {}});
}

std::unexpected<ShelfRefusal> of_disk(const DiskError& error) {
  const bool missing = error.code == DiskErrorCode::kMissing;
  const auto code = missing ? ShelfRefusal::Code::kMissing : ShelfRefusal::Code::kDisk;
  return std::unexpected(ShelfRefusal{code, 0, error});
}

}  // namespace

/// FNV-1a, folded to what a number of JavaScript holds exactly.
std::uint64_t revision_of(std::string_view text) {
  std::uint64_t hash = 0xCBF2'9CE4'8422'2325;
  for (const char c : text) {
    hash ^= static_cast<std::uint8_t>(c);
    hash *= 0x0000'0100'0000'01B3;
  }
  constexpr std::uint64_t kBits = (std::uint64_t{1} << 52) - 1;
  return std::max<std::uint64_t>((hash ^ (hash >> 52)) & kBits, 1);
}

ShelfResult<TextShelf::Text> TextShelf::read(std::string_view file) {
  const auto stamp = disk_.stamp(file);
  if (!stamp) return of_disk(stamp.error());
  if (stamp->size > kTextMax) return refuse(ShelfRefusal::Code::kTooLarge);
  std::string bytes(kTextMax + 1, '\0');
  const auto size = disk_.read(file, {reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()});
  if (!size) return of_disk(size.error());
  bytes.resize(*size);
  const std::uint64_t revision = revision_of(bytes);
  return Text{std::move(bytes), revision};
}

ShelfResult<std::vector<TextShelf::Entry>> TextShelf::list(std::string_view ending) {
  const auto names = disk_.list();
  if (!names) return of_disk(names.error());
  std::vector<Entry> entries;
  for (const std::string& name : *names) {
    if (!name.ends_with(ending)) continue;
    const auto text = read(name);
    const auto stamp = disk_.stamp(name);
    if (!text || !stamp) continue;  // too large for anybody here, or gone meanwhile
    entries.push_back({name, text->revision, text->text.size(), stamp->changed_ns});
  }
  return entries;
}

/// What stands there is what the client knows.
ShelfResult<void> TextShelf::expect(std::string_view file, std::uint64_t revision) {
  const auto now = read(file);
  if (!now && now.error().code != ShelfRefusal::Code::kMissing) {
    return std::unexpected(now.error());
  }
  const std::uint64_t there = now ? now->revision : 0;
  if (there == revision) return {};
  return refuse(ShelfRefusal::Code::kConflict, there);
}

ShelfResult<std::uint64_t> TextShelf::save(std::string_view file, std::string_view text,
                                           std::uint64_t revision) {
  if (text.size() > kTextMax) return refuse(ShelfRefusal::Code::kTooLarge);
  if (const auto known = expect(file, revision); !known) return std::unexpected(known.error());
  if (revision == 0) {
    const auto names = disk_.list();
    if (!names) return of_disk(names.error());
    if (names->size() >= kTextsMax) return refuse(ShelfRefusal::Code::kTooMany);
  }
  if (const auto done = replace(file, text); !done) return of_disk(done.error());
  return revision_of(text);
}

ShelfResult<void> TextShelf::remove(std::string_view file, std::uint64_t revision) {
  if (const auto known = expect(file, revision); !known) return std::unexpected(known.error());
  if (revision == 0) return refuse(ShelfRefusal::Code::kMissing);
  auto done = disk_.remove(file);
  if (done) done = disk_.sync_folder();
  if (!done) return of_disk(done.error());
  return {};
}

/// Beside its place first: whoever reads, or whenever the power goes, there is the old text or the
/// new one.
DiskResult<void> TextShelf::replace(std::string_view file, std::string_view text) {
  const std::string beside = std::string(file) + ".new";
  const auto made = disk_.create(beside);
  if (!made) return std::unexpected(made.error());
  auto done =
      disk_.append(*made, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  if (done) done = disk_.sync(*made);
  disk_.close(*made);
  if (done) done = disk_.rename(beside, file);
  if (done) return disk_.sync_folder();
  static_cast<void>(disk_.remove(beside));
  return done;
}

}  // namespace sinew::runtime
