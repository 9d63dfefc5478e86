#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/io/io_error.h"
#include "sinew/model/cell.h"

namespace sinew::runtime {

/// Where the baskets of a running cell stand: as its file says, or where a person has moved them
/// since. What was moved is kept in a file of its own; the cell's file is never written. For
/// threads.
class CellBaskets {
 public:
  explicit CellBaskets(std::vector<CellBasket> of_file)
      : of_file_(std::move(of_file)), now_(of_file_) {}

  /// Moves are kept in this file from now on; those that it has count. A basket that the cell's
  /// file has elsewhere than when it was moved stands where the cell's file says.
  /// @error  it cannot be read, or is no such file
  io::IoResult<void> keep_in(const std::string& file);

  std::vector<CellBasket> all() const;
  std::optional<std::size_t> find(std::string_view name) const;
  /// Goes up with each move.
  std::uint64_t revision() const;
  /// @param X_WK  upright  @pre there is such a basket
  void move(std::size_t basket, const Pose<frame::World, frame::Box>& X_WK);
  /// Writes down where they stand. @error  it could not be written; they stand there nevertheless
  io::IoResult<void> keep() const;

 private:
  const std::vector<CellBasket> of_file_;
  std::string file_;  ///< empty: not kept
  mutable std::mutex mutex_;
  std::vector<CellBasket> now_;  ///< under the mutex
  std::uint64_t revision_ = 0;   ///< under the mutex
};

}  // namespace sinew::runtime
