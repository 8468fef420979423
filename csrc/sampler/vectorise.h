/* Several instruction sets from one source, chosen at run time.
 *
 * ASC_VECTORISE before a function compiles it once for each, chosen when the library is loaded. The functions marked
 * compute with integers, or with floating-point steps that -ffp-contract=off keeps apart, so their bits are the same on
 * each. Sanitizers instrument the choosing function before they are ready, so not under them.
 *
 * ASC_HAS_LEVELS: the compiler can also be switched for part of a file, `#pragma GCC target`. ASC_TAKES_V3, ..._V4:
 * whether the machine has the instructions of x86-64-v3, of -v4; not under sanitizers, so that the tests see what is
 * made without them. */
#ifndef ASC_VECTORISE_H
#define ASC_VECTORISE_H

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ASC_HAS_LEVELS 1
#else
#define ASC_HAS_LEVELS 0
#endif

#if ASC_HAS_LEVELS && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define ASC_VECTORISE __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define ASC_TAKES_V3 __builtin_cpu_supports("x86-64-v3")
#define ASC_TAKES_V4 __builtin_cpu_supports("x86-64-v4")
#else
#define ASC_VECTORISE
#define ASC_TAKES_V3 0
#define ASC_TAKES_V4 0
#endif

/* Before a loop over lanes inside another loop: unrolled, it would leave the other one to be vectorised. */
#if defined(__GNUC__) && !defined(__clang__)
#define ASC_LANES_LOOP _Pragma("GCC unroll 1")
#else
#define ASC_LANES_LOOP
#endif

/* For the parts that marked functions are made of. */
#ifdef __GNUC__
#define ASC_INLINE static inline __attribute__((always_inline))
#else
#define ASC_INLINE static inline
#endif

/* For the long way beside a short one, which then has no registers to save. */
#ifdef __GNUC__
#define ASC_APART static __attribute__((noinline))
#else
#define ASC_APART static
#endif

#endif
