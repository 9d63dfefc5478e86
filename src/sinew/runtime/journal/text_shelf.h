#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/disk.h"

namespace sinew::runtime {

/// Of a text, never 0: two texts have the same one only where they are the same, but for one chance
/// in some 10^15. So a file that somebody changes with an editor has another one too.
std::uint64_t revision_of(std::string_view text);

/// Why a text was not read, kept or removed, and nothing has changed.
struct ShelfRefusal {
  enum class Code : std::uint8_t {
    kMissing,   ///< no text of this name
    kConflict,  ///< another one is there than the client knows: `revision`, 0 for none
    kTooLarge,
    kTooMany,
    kDisk,  ///< `disk`
  } code = Code::kMissing;
  std::uint64_t revision = 0;
  DiskError disk{};
};

template <class T>
using ShelfResult = std::expected<T, ShelfRefusal>;

/// Small texts in a folder. Each is replaced whole, and only by somebody who knows what stands
/// there; whoever changes them in another process has the folder's turn (io::FolderTurn).
class TextShelf {
 public:
  static constexpr std::size_t kTextMax = std::size_t{256} << 10;  ///< bytes
  static constexpr std::size_t kTextsMax = 200;

  struct Text {
    std::string text;
    std::uint64_t revision = 0;
  };
  struct Entry {
    std::string name;
    std::uint64_t revision = 0;
    std::uint64_t size = 0;       ///< bytes
    std::int64_t changed_ns = 0;  ///< since 1970
  };

  /// @param disk  outlives this
  explicit TextShelf(Disk& disk) : disk_(disk) {}

  /// @param file  its name in the folder, with its ending
  ShelfResult<Text> read(std::string_view file);
  /// Of this ending, sorted by name.
  ShelfResult<std::vector<Entry>> list(std::string_view ending);
  /// @param revision  of what it replaces; 0: nothing has this name yet
  /// @return  that of the text
  ShelfResult<std::uint64_t> save(std::string_view file, std::string_view text,
                                  std::uint64_t revision);
  ShelfResult<void> remove(std::string_view file, std::uint64_t revision);

 private:
  ShelfResult<void> expect(std::string_view file, std::uint64_t revision);
  DiskResult<void> replace(std::string_view file, std::string_view text);

  Disk& disk_;
};

}  // namespace sinew::runtime
