#pragma once

#include <atomic>

// Kinematics is compiled twice from one source: for every processor of the architecture, and for
// x86-64 processors with 256-bit vectors and fused multiply-add (made since 2013), which take half
// the time. Which one runs is decided where it runs, so one binary serves all. Builds with a
// sanitizer have only the portable version, so that the tests of all presets run both.
//
// Not by `target_clones`: its resolvers run before the sanitizers are ready, and clang does not
// take it together with `flatten`. Not by a source file with other compiler flags either: inline
// functions of such a file may be the copy that the linker keeps for everybody.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SINEW_SANITIZED 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SINEW_SANITIZED 1
#endif
#if defined(__x86_64__) && !defined(SINEW_SANITIZED)
#define SINEW_HAS_WIDE_VERSION 1
#define SINEW_WIDE __attribute__((target("avx2,fma"), flatten))
#else
#define SINEW_HAS_WIDE_VERSION 0
#define SINEW_WIDE
#endif

namespace sinew {

namespace detail {
inline std::atomic<bool> portable_only{false};
}  // namespace detail

/// From now on the whole process takes the portable versions: what a seed does is then the same to
/// the last bit on every processor, and from every compiler.
inline void take_portable_versions() {
  detail::portable_only.store(true, std::memory_order_relaxed);
}

/// Whether this processor has the wide vectors, this build code for them, and nobody asked for the
/// portable versions. @rt
inline bool has_wide_vectors() {
#if SINEW_HAS_WIDE_VERSION
  return !detail::portable_only.load(std::memory_order_relaxed) && __builtin_cpu_supports("avx2") &&
         __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

namespace detail {

template <class Work>
SINEW_WIDE auto with_wide_vectors(const Work& work) {
  return work();
}

}  // namespace detail

/// Runs `work`, with everything in it that the compiler can inline, for the processor at hand; or
/// `wide_work`, where wide vectors want other types. The two versions round differently: results
/// agree to a few ulp of the largest term. @rt
template <class Work, class WideWork>
auto dispatched(const Work& work, const WideWork& wide_work) {
#if SINEW_HAS_WIDE_VERSION
  if (has_wide_vectors()) return detail::with_wide_vectors(wide_work);
#else
  static_cast<void>(wide_work);
#endif
  return work();
}
template <class Work>
auto dispatched(const Work& work) {
  return dispatched(work, work);
}

}  // namespace sinew
