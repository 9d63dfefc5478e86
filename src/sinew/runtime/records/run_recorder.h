#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "sinew/io/disk_folder.h"
#include "sinew/runtime/records/record_encoder.h"
#include "sinew/runtime/records/run_look.h"

namespace sinew::runtime {

struct RecorderOptions {
  std::string robot;    ///< as files and channels call it
  std::string library;  ///< what writes them
  /// Where the last seconds before each fault are kept; empty: nowhere.
  std::string flight_folder;
};

/// A file that was made, or could not be.
struct RecordTold {
  std::string path;
  std::optional<control::StopCause> fault;  ///< of a flight record
  std::string trouble;                      ///< why it is not whole, for people; empty: it is
  std::uint64_t lost = 0;                   ///< samples and events that are not in it
  bool full = false;                        ///< it has come to the size that it may have
};

/// Whose file it is: a program's own, from its begin to its end, or one that somebody wants
/// meanwhile.
enum class RecordSlot : std::uint8_t { kJob, kWanted };

/// What a file is called, and how large it may become. One that has come to that ends by itself.
struct RecordPlace {
  std::string folder;
  std::string name;
  std::string program;  ///< for people
  std::uint64_t size_max = ~std::uint64_t{0};
  /// One of those that every run leaves; the newest RunRecorder::kRunFilesMax of its folder stay.
  bool of_every_run = false;
};

/// Where a run leaves its record that nobody gave a place. @param wall_ns  of its begin
RecordPlace run_place(const std::string& folder, const std::string& robot,
                      const std::string& program, std::int64_t wall_ns);

/// A file that somebody wants, and that is being written.
struct RecordUnderWay {
  std::string name;
  double length = 0;       ///< s
  std::uint64_t size = 0;  ///< bytes that the disk has taken
};

/// Writes what happens to one machine, in a thread of its own: to files from begin() to end(), one
/// of each slot, and of each fault the ten seconds before it and one behind it. Between it and the
/// control side is a ring of fixed size; what the disk is too slow for is not in the file, and
/// counted there.
class RunRecorder {
 public:
  static constexpr std::size_t kRing = 1024;
  static constexpr Duration kPeriod = std::chrono::milliseconds(10);
  static constexpr Duration kBeforeFault = std::chrono::seconds(10);
  static constexpr Duration kBehindFault = std::chrono::seconds(1);
  /// Samples of eleven seconds, and as many events as ever come with them.
  static constexpr std::size_t kFlightMax = 1600;
  static constexpr std::size_t kLooksMax = 8;
  /// Of all robots together; the oldest go first.
  static constexpr std::size_t kFlightFilesMax = 50;
  /// The same of the records that every run leaves, and how large one of them gets: some four
  /// minutes of a five-joint arm at full rate.
  static constexpr std::size_t kRunFilesMax = 20;
  static constexpr std::uint64_t kRunSizeMax = std::uint64_t{32} << 20;

  /// @param robot  outlives this. @param now, wall_ns  the same instant on both clocks
  RunRecorder(const RobotModel& robot, RecorderOptions options, Instant now, std::int64_t wall_ns);
  /// What was offered is written, and the file ended.
  ~RunRecorder();
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  /// @name Control side: one thread, never waits, no heap. @rt
  /// @{
  bool due(Instant now) const { return now >= next_; }
  void offer(const RunSample& sample);
  void offer(const control::ControlEvent& event, Instant now);
  /// @}

  /// @name From any other thread
  /// @{
  /// From now on into this file, instead of the one before it in its slot.
  /// @error  a sentence: the file cannot be made
  io::IoResult<void> begin(const RecordPlace& place, RecordSlot slot = RecordSlot::kJob);
  /// The file is whole; nothing where none was begun. It is told by take_told() too.
  std::optional<RecordTold> end(RecordSlot slot = RecordSlot::kJob);
  /// The file of RecordSlot::kWanted; nothing while there is none.
  std::optional<RecordUnderWay> under_way() const;
  std::optional<RecordTold> take_told();
  /// Into the files that are being written, and into that of a fault.
  void add(const RunLook& look);
  /// The run is over: what is kept of a fault is written now, however little is behind it.
  void end_flight();
  /// Samples and events that the ring had no room for, ever.
  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }
  /// What was offered before is written. For tests.
  void settle();
  /// @}

 private:
  using Entry = std::variant<RunSample, RunEvent>;
  class File;

  bool push(const Entry& entry);
  void run();
  // All below under the work's mutex.
  bool work();
  void take(const Entry& entry);
  void show_wanted();
  void keep(const Entry& entry);
  void write_flight();
  void tell(RecordTold told);
  RecordTitle title(const std::string& program) const;

  const RobotModel& robot_;
  const RecorderOptions options_;
  const Instant start_;
  const std::int64_t wall_ns_;

  Instant next_{};  ///< of the control side
  std::vector<Entry> ring_;
  std::atomic<std::uint64_t> offered_ = 0;
  std::atomic<std::uint64_t> taken_ = 0;
  std::atomic<std::uint64_t> lost_ = 0;
  std::atomic<std::uint32_t> calls_ = 0;
  std::atomic<bool> stop_ = false;

  std::mutex work_;
  std::array<std::unique_ptr<File>, 2> files_;  ///< by slot
  std::uint64_t lost_told_ = 0;
  Instant last_{};
  std::vector<Entry> flight_;  ///< a ring: the oldest stands at flight_next_ once it is full
  std::size_t flight_next_ = 0;
  std::deque<RunLook> looks_;  ///< the newest
  std::optional<RunEvent> fault_;

  mutable std::mutex told_mutex_;
  std::deque<RecordTold> told_;
  std::optional<RecordUnderWay> under_way_;

  std::thread thread_;
};

/// "learm_pick-and-place_20261122T004512.345Z.mcap": only letters, digits, - and _ of the parts.
std::string record_name(const std::string& robot, const std::string& what, std::int64_t wall_ns);

}  // namespace sinew::runtime
