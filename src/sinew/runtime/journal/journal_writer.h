#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>

#include "sinew/runtime/journal/journal_files.h"

namespace sinew::runtime {

/// Between the control side, which hands in records and asks how far they are safe, and the side
/// that waits for a disk. One thread each; in virtual time both are the same one.
class JournalPump {
 public:
  /// More than a PositionJournal ever has on its way.
  static constexpr std::size_t kQueue = 2 * PositionJournal::kUnsyncedMax;

  /// @param files  locked, and told what to continue after
  explicit JournalPump(JournalFiles& files) : files_(&files) {}

  /// Control side, never waits. False where the queue is full; the record is not taken then. @rt
  bool offer(const JournalRecord& record);
  /// Control side. @rt
  std::uint64_t durable_sequence() const { return durable_.load(std::memory_order_acquire); }
  /// Control side: nothing is written any more. Let no motion begin, and bring the one under way to
  /// rest. @rt
  bool failed() const { return failed_.load(std::memory_order_acquire); }
  /// What failed; nothing before failed() says so.
  std::optional<DiskError> failure() const { return failed() ? files_->failure() : std::nullopt; }

  /// Disk side: writes all that waits and syncs it once; whether there was anything. What came of
  /// it shows on the control side with publish(), which virtual time calls when the disk's time
  /// is over.
  bool work();
  void publish();

  /// Disk side: waits until something is offered, or wake() was called since the last wait.
  void wait();
  void wake();

 private:
  JournalFiles* files_;
  std::array<JournalRecord, kQueue> ring_;
  std::atomic<std::uint32_t> offered_ = 0;  ///< records, ever
  std::atomic<std::uint32_t> taken_ = 0;    ///< of these, by the disk side
  std::atomic<std::uint32_t> calls_ = 0;    ///< offers and wakes; what wait() looks at
  std::uint32_t answered_ = 0;              ///< of these
  std::atomic<std::uint64_t> durable_ = 0;
  std::atomic<bool> failed_ = false;
};

/// The disk side in a thread of its own. What was offered before the end is written and synced.
class JournalWriter {
 public:
  /// @param files  as above; nobody else uses them while this lives
  explicit JournalWriter(JournalFiles& files);
  ~JournalWriter();
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;

  /// The control side of it.
  JournalPump& pump() { return pump_; }
  /// @rt
  bool offer(const JournalRecord& record) { return pump_.offer(record); }
  /// @rt
  std::uint64_t durable_sequence() const { return pump_.durable_sequence(); }
  /// @rt
  bool failed() const { return pump_.failed(); }
  std::optional<DiskError> failure() const { return pump_.failure(); }

 private:
  void run();

  JournalPump pump_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace sinew::runtime
