#include "sinew/runtime/journal/journal_writer.h"

namespace sinew::runtime {

bool JournalPump::offer(const JournalRecord& record) {
  const std::uint32_t offered = offered_.load(std::memory_order_relaxed);
  if (offered - taken_.load(std::memory_order_acquire) >= kQueue) return false;
  ring_[offered % kQueue] = record;
  offered_.store(offered + 1, std::memory_order_release);
  wake();
  return true;
}

void JournalPump::wake() {
  calls_.fetch_add(1, std::memory_order_release);
  calls_.notify_one();
}

void JournalPump::wait() {
  calls_.wait(answered_, std::memory_order_acquire);
  answered_ = calls_.load(std::memory_order_acquire);
}

bool JournalPump::work() {
  const std::uint32_t offered = offered_.load(std::memory_order_acquire);
  std::uint32_t taken = taken_.load(std::memory_order_relaxed);
  if (taken == offered) return false;
  // Behind an error records are thrown away: the files refuse them all, and control is told.
  while (taken != offered) {
    static_cast<void>(files_->write(ring_[taken % kQueue]));
    taken_.store(++taken, std::memory_order_release);
  }
  static_cast<void>(files_->sync());
  return true;
}

void JournalPump::publish() {
  durable_.store(files_->durable_sequence(), std::memory_order_release);
  if (files_->failure()) failed_.store(true, std::memory_order_release);
}

JournalWriter::JournalWriter(JournalFiles& files) : pump_(files), thread_([this] { run(); }) {}

JournalWriter::~JournalWriter() {
  stop_ = true;
  pump_.wake();
  thread_.join();
}

void JournalWriter::run() {
  while (true) {
    // Read first: what was offered before the end is still found by the work behind it.
    const bool stop = stop_;
    if (pump_.work()) {
      pump_.publish();
    } else if (stop) {
      return;
    } else {
      pump_.wait();
    }
  }
}

}  // namespace sinew::runtime
