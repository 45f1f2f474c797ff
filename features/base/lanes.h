// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

// GCC compiles a leaf kernel once per instruction set and picks at load time, when the sanitizers are not
// ready yet. No fused multiply-add among them: all versions give the same bits.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) &&     \
    !defined(__SANITIZE_THREAD__)
#define FACETLOC_MULTIVERSION __attribute__((target_clones("avx2", "default")))
#else
#define FACETLOC_MULTIVERSION
#endif

namespace facetloc::internal {

/** \brief Neighbouring pixels of a row as one value: eight on x86-64, whose widest registers hold them, and
 * elsewhere four, since GCC compares larger vectors element by element. Four where sums have to be exact. */
#ifdef __x86_64__
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif
constexpr int kDoubleLanes = 4;
typedef float Floats __attribute__((vector_size(4 * kLanes)));
typedef std::int32_t Ints __attribute__((vector_size(4 * kLanes)));
typedef std::int16_t Shorts __attribute__((vector_size(2 * kLanes)));
typedef signed char Chars __attribute__((vector_size(kLanes)));
typedef float FloatQuad __attribute__((vector_size(4 * kDoubleLanes)));
typedef std::int32_t IntQuad __attribute__((vector_size(4 * kDoubleLanes)));
typedef double Doubles __attribute__((vector_size(8 * kDoubleLanes)));

constexpr IntQuad kQuadLane = {0, 1, 2, 3};
constexpr FloatQuad kQuadOffset = {0, 1, 2, 3};
#ifdef __x86_64__
constexpr Ints kLane = {0, 1, 2, 3, 4, 5, 6, 7};
constexpr Floats kLaneOffset = {0, 1, 2, 3, 4, 5, 6, 7};
#else
constexpr Ints kLane = kQuadLane;
constexpr Floats kLaneOffset = kQuadOffset;
#endif
constexpr Doubles kDoubleOffset = {0, 1, 2, 3};

#define FACETLOC_ALWAYS_INLINE inline __attribute__((always_inline))

/** \brief The values from p on; 0 from end on. Results go through references, since vectors are passed in
 * registers that not every processor has. */
template <typename T, typename Lanes>
FACETLOC_ALWAYS_INLINE void load(const T* p, const T* end, Lanes& out) {
  constexpr int n = sizeof(Lanes) / sizeof(T);
  if (__builtin_expect(end - p >= n, 1)) {
    std::memcpy(&out, p, sizeof out);
    return;
  }
  out = Lanes{};
  for (int k = 0; k < end - p; ++k) out[k] = p[k];
}

/** \brief The other way round. */
template <typename T, typename Lanes>
FACETLOC_ALWAYS_INLINE void store(const Lanes& x, T* p, const T* end) {
  constexpr int n = sizeof(Lanes) / sizeof(T);
  if (__builtin_expect(end - p >= n, 1)) {
    std::memcpy(p, &x, sizeof x);
    return;
  }
  for (int k = 0; k < end - p; ++k) p[k] = x[k];
}

/** \brief The bits of a float. Floats that are not negative order like their bits, so that one comparison of
 * integers orders by such a float and, behind it, an index. */
inline std::uint64_t bitsOf(float x) {
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

/** \brief Sums in memory that any allocator may give: vectors want more alignment than that. */
struct LaneSums {
  double lane[kDoubleLanes] = {};

  FACETLOC_ALWAYS_INLINE void operator+=(const Doubles& x) {
    Doubles sum;
    std::memcpy(&sum, lane, sizeof sum);
    sum += x;
    std::memcpy(lane, &sum, sizeof sum);
  }
};

FACETLOC_ALWAYS_INLINE double total(const Doubles& x) { return (x[0] + x[1]) + (x[2] + x[3]); }
FACETLOC_ALWAYS_INLINE double total(const LaneSums& x) {
  return (x.lane[0] + x.lane[1]) + (x.lane[2] + x.lane[3]);
}

}  // namespace facetloc::internal
