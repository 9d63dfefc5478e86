#pragma once

#include <atomic>
#include <cstdint>

// Kinematics is compiled twice from one source: for every processor of the architecture, and for
// x86-64 processors with 256-bit vectors and fused multiply-add (made since 2013), which take half
// the time. Loops over long arrays may have a third version, for 512-bit vectors. Which one runs is
// decided where it runs, so one binary serves all. Builds with a sanitizer have only the portable
// version, so that the tests of all presets run both.
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
#define SINEW_WIDEST __attribute__((target("avx512f,avx512vl,avx512dq,avx512bw,avx2,fma"), flatten))
#else
#define SINEW_HAS_WIDE_VERSION 0
#define SINEW_WIDE
#define SINEW_WIDEST
#endif

namespace sinew {

/// Versions of one source, by the vectors of the processors that they are for.
enum class Vectors : std::uint8_t { kPortable, kWide, kWidest };

namespace detail {
inline std::atomic<Vectors> widest_taken{Vectors::kWidest};
}  // namespace detail

/// From now on the whole process takes no wider versions. With the portable ones, what a seed does
/// is the same to the last bit on every processor, and from every compiler.
inline void take_vectors(Vectors widest) {
  detail::widest_taken.store(widest, std::memory_order_relaxed);
}

/// The widest that this processor has and this build has code for, and that may be taken. @rt
inline Vectors vectors() {
#if SINEW_HAS_WIDE_VERSION
  const Vectors taken = detail::widest_taken.load(std::memory_order_relaxed);
  if (taken == Vectors::kPortable) return Vectors::kPortable;
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return Vectors::kPortable;
  const bool has_widest = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                          __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
  return taken == Vectors::kWidest && has_widest ? Vectors::kWidest : Vectors::kWide;
#else
  return Vectors::kPortable;
#endif
}

namespace detail {

template <class Work>
SINEW_WIDE auto with_wide_vectors(const Work& work) {
  return work();
}
template <class Work>
SINEW_WIDEST auto with_widest_vectors(const Work& work) {
  return work();
}

}  // namespace detail

/// Runs `work`, with everything in it that the compiler can inline, for the processor at hand; or
/// `wide_work`, where wide vectors want other types. The two versions round differently: results
/// agree to a few ulp of the largest term. @rt
template <class Work, class WideWork>
auto dispatched(const Work& work, const WideWork& wide_work) {
#if SINEW_HAS_WIDE_VERSION
  if (vectors() != Vectors::kPortable) return detail::with_wide_vectors(wide_work);
#else
  static_cast<void>(wide_work);
#endif
  return work();
}
template <class Work>
auto dispatched(const Work& work) {
  return dispatched(work, work);
}
/// The same with a version for the widest vectors.
template <class Work, class WideWork, class WidestWork>
auto dispatched(const Work& work, const WideWork& wide_work, const WidestWork& widest_work) {
#if SINEW_HAS_WIDE_VERSION
  if (vectors() == Vectors::kWidest) return detail::with_widest_vectors(widest_work);
#else
  static_cast<void>(widest_work);
#endif
  return dispatched(work, wide_work);
}

}  // namespace sinew
