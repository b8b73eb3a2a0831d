/* What translated kernels call: Python's integer arithmetic, its min and max, and three instructions. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#if defined(__GNUC__)
#define GM_INLINE static inline __attribute__((always_inline, unused))
#define GM_APART static __attribute__((noinline, unused))
#define GM_STATIC static __attribute__((unused))
#else
#define GM_INLINE static inline
#define GM_APART static
#define GM_STATIC static
#endif
#if defined(__GNUC__) && !defined(GM_FLOAT)
#define gm_fma __builtin_fma
#elif defined(GM_FLOAT)
#define gm_fma fmaf
#else
#define gm_fma fma
#endif
/* The functions of math.h in the precision of a real. */
#if defined(GM_FLOAT)
#define GM_OF(name) name##f
#else
#define GM_OF(name) name
#endif
#define gm_sqrt GM_OF(sqrt)
#define gm_exp GM_OF(exp)
#define gm_log GM_OF(log)
#define gm_sin GM_OF(sin)
#define gm_cos GM_OF(cos)
#define gm_tan GM_OF(tan)
#define gm_atan GM_OF(atan)
#define gm_tanh GM_OF(tanh)
#define gm_sinh GM_OF(sinh)
#define gm_cosh GM_OF(cosh)
#define gm_asin GM_OF(asin)
#define gm_acos GM_OF(acos)
#define gm_expm1 GM_OF(expm1)
#define gm_log1p GM_OF(log1p)
#define gm_fabs GM_OF(fabs)
#define gm_floor GM_OF(floor)
#define gm_ceil GM_OF(ceil)
#define gm_atan2 GM_OF(atan2)
#define gm_hypot GM_OF(hypot)
#define gm_pow GM_OF(pow)
#define gm_copysign GM_OF(copysign)
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
/* a 2^k and (-1)^k a, where t is k + 1.5 2^52: see elementary. */
GM_INLINE double gm_times_power(double a, double t)
{ uint64_t x, y; memcpy(&x, &a, 8); memcpy(&y, &t, 8); x += y << 52; memcpy(&a, &x, 8); return a; }
GM_INLINE double gm_signed(double a, double t)
{ uint64_t x, y; memcpy(&x, &a, 8); memcpy(&y, &t, 8); x ^= y << 63; memcpy(&a, &x, 8); return a; }
#if !defined(GM_FLOAT)
/* A user's function in Python: its numbers, its parameters, the torques it returns. */
GM_STATIC void gm_called(double *out, int64_t address, double t, double x1, double x2, double x3,
                         double x4, double u, double tau_k, double *theta, int64_t n)
{
    const double numbers[7] = {t, x1, x2, x3, x4, u, tau_k};
    ((void (*)(const double *, double *, int64_t, double *))(intptr_t)address)(
        numbers, theta, n, out);
}
#endif
