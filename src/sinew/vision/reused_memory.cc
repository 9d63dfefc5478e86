#include "sinew/vision/reused_memory.h"

#include <algorithm>
#include <vector>

namespace sinew::vision {
namespace {

struct Block {
  void* place;
  std::size_t bytes;
};

struct Spares {
  static constexpr std::size_t kMost = 48U << 20U;  // bytes
  std::vector<Block> blocks;
  std::size_t bytes = 0;

  ~Spares() {
    for (const Block& block : blocks) ::operator delete(block.place);
  }
};
thread_local Spares spares;

}  // namespace

void* reused_block(std::size_t bytes) {
  const auto found = std::ranges::find(spares.blocks, bytes, &Block::bytes);
  if (found == spares.blocks.end()) return ::operator new(bytes);
  void* place = found->place;
  spares.blocks.erase(found);
  spares.bytes -= bytes;
  return place;
}

void give_back_block(void* block, std::size_t bytes) noexcept {
  if (bytes > Spares::kMost) return ::operator delete(block);
  // Free the oldest blocks first: the size of the pictures may have changed.
  while (spares.bytes + bytes > Spares::kMost) {
    ::operator delete(spares.blocks.front().place);
    spares.bytes -= spares.blocks.front().bytes;
    spares.blocks.erase(spares.blocks.begin());
  }
  try {
    spares.blocks.push_back({block, bytes});
    spares.bytes += bytes;
  } catch (...) {
    ::operator delete(block);
  }
}

std::size_t bytes_kept() {
  return spares.bytes;
}

}  // namespace sinew::vision
