/* What translated kernels call: Python's integer arithmetic, its min and max, and three instructions. */
#include <stdbool.h>
#include <stdint.h>
#if defined(GM_FIRMWARE) /* small, and without a library: see simulators/firmware */
#define GM_INLINE static inline
#define GM_APART static
#define GM_STATIC static
#else
#include <math.h>
#if defined(__GNUC__) && !defined(__clang__)
#define GM_UNROLLED _Pragma("GCC unroll 8")
#endif
#if defined(__GNUC__)
#define GM_INLINE static inline __attribute__((always_inline, unused))
#define GM_APART static __attribute__((noinline, unused))
#define GM_STATIC static __attribute__((unused))
#define gm_fma __builtin_fma
#else
#define GM_INLINE static inline
#define GM_APART static
#define GM_STATIC static
#define gm_fma fma
#endif
#define gm_sqrt sqrt
#define gm_exp exp
#define gm_log log
#define gm_sin sin
#define gm_cos cos
#define gm_tan tan
#define gm_atan atan
#define gm_tanh tanh
#define gm_sinh sinh
#define gm_cosh cosh
#define gm_asin asin
#define gm_acos acos
#define gm_expm1 expm1
#define gm_log1p log1p
#define gm_fabs fabs
#define gm_floor floor
#define gm_ceil ceil
#define gm_atan2 atan2
#define gm_hypot hypot
#define gm_pow pow
#define gm_copysign copysign
#endif
#ifndef GM_UNROLLED
#define GM_UNROLLED
#endif
typedef union { int64_t i; double d; void *p; } gm_slot;
/* An index as Python counts it, and a bound of a slice. */
GM_INLINE int64_t gm_at(int64_t i, int64_t n) { return i < 0 ? i + n : i; }
GM_INLINE int64_t gm_bound(int64_t i, int64_t n)
{ i = i < 0 ? i + n : i; return i < 0 ? 0 : i > n ? n : i; }
GM_INLINE int64_t gm_span(int64_t low, int64_t high) { return high > low ? high - low : 0; }
/* Divisors are not 0 in kernels; -1 is apart, as INT64_MIN / -1 traps. */
GM_INLINE int64_t gm_div(int64_t a, int64_t b)
{
    if (b == -1) return (int64_t)(0 - (uint64_t)a);
    int64_t q = a / b;
    return (a % b != 0 && (a < 0) != (b < 0)) ? q - 1 : q;
}
GM_INLINE int64_t gm_mod(int64_t a, int64_t b)
{
    if (b == -1) return 0;
    int64_t r = a % b;
    return (r != 0 && (r < 0) != (b < 0)) ? r + b : r;
}
GM_INLINE int64_t gm_min_i(int64_t a, int64_t b) { return b < a ? b : a; }
GM_INLINE int64_t gm_max_i(int64_t a, int64_t b) { return b > a ? b : a; }
GM_INLINE int64_t gm_abs_i(int64_t a) { return a < 0 ? -a : a; }
GM_INLINE real gm_min_f(real a, real b) { return b < a ? b : a; }
GM_INLINE real gm_max_f(real a, real b) { return b > a ? b : a; }
/* a 2^k and (-1)^k a, where t is k + gm_rounding(): see elementary. */
#if defined(GM_FLOAT)
typedef union { float x; uint32_t bits; } gm_bits;
#define gm_rounding() 12582912.0f
#define GM_MANTISSA 23
#else
typedef union { double x; uint64_t bits; } gm_bits;
#define gm_rounding() 6755399441055744.0
#define GM_MANTISSA 52
#endif
GM_INLINE real gm_times_power(real a, real t)
{
    gm_bits x = {a}, k = {t};
    x.bits += k.bits << GM_MANTISSA;
    return x.x;
}
GM_INLINE real gm_signed(real a, real t)
{
    gm_bits x = {a}, k = {t};
    x.bits ^= k.bits << (8 * sizeof x.bits - 1);
    return x.x;
}
#if !defined(GM_FIRMWARE)
/* A user's function in Python: its numbers, its parameters, the torques it returns. */
GM_STATIC void gm_called(double *out, int64_t address, double t, double x1, double x2, double x3,
                         double x4, double u, double tau_k, double *theta, int64_t n)
{
    const double numbers[7] = {t, x1, x2, x3, x4, u, tau_k};
    ((void (*)(const double *, double *, int64_t, double *))(intptr_t)address)(
        numbers, theta, n, out);
}
#endif
