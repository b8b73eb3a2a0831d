/* What the kernels of a filter need beside + - * /: correctly rounded as in the node, without a
 * library. An instruction does it where the processor has one. */
#define GM_FIRMWARE
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-variable"
#if defined(__clang__)
#pragma clang diagnostic ignored "-Wparentheses-equality"
#endif
#define isfinite __builtin_isfinite
#define NAN __builtin_nanf("")
#define INFINITY __builtin_inff()
#define GM_BUILTIN(name) __builtin_##name
#else
#include <math.h>
#define GM_BUILTIN(name) name
#endif

typedef union { double x; uint64_t bits; } gm_double;

#if defined(__SSE2__) || defined(__aarch64__) || (defined(__ARM_FP) && __ARM_FP & 8)
#define GM_ROOT_DOUBLE
#endif
#if defined(__FMA__) || defined(__aarch64__) || (defined(__ARM_FEATURE_FMA) && __ARM_FP & 8)
#define GM_FMA_DOUBLE
#endif

/* The square root of x, digit by digit. */
static inline double gm_root(double x)
{
#if defined(GM_ROOT_DOUBLE)
    double root;
#if defined(__SSE2__)
    __asm__("sqrtsd %1, %0" : "=x"(root) : "x"(x));
#elif defined(__aarch64__)
    __asm__("fsqrt %d0, %d1" : "=w"(root) : "w"(x));
#else
    __asm__("vsqrt.f64 %P0, %P1" : "=w"(root) : "w"(x));
#endif
    return root;
#else
    gm_double v = {x};
    uint64_t rest, root = 0, sum = 0, bit = UINT64_C(1) << 53;
    int exponent;
    if (!(x > 0.0) || !isfinite(x))
        return x < 0.0 ? (double)NAN : x; /* 0, -0, infinity, NaN */
    if (v.bits >> 52 == 0) {
        v.x = x * 18014398509481984.0; /* 2^54: denormal */
        exponent = (int)(v.bits >> 52) - 1023 - 54;
    } else {
        exponent = (int)(v.bits >> 52) - 1023;
    }
    rest = (v.bits & ((UINT64_C(1) << 52) - 1)) | UINT64_C(1) << 52;
    if (exponent & 1)
        rest <<= 1, exponent--;
    for (rest <<= 1; bit != 0; bit >>= 1, rest <<= 1)
        if (sum + bit <= rest) {
            sum += bit;
            rest -= sum;
            sum += bit;
            root += bit;
        }
    root += root & 1; /* never a tie */
    v.bits = (root >> 1) + ((uint64_t)(exponent / 2 + 1022) << 52);
    return v.x;
#endif
}

#if !defined(GM_FMA_DOUBLE)
/* The exact a + b as s, rounded, and *rest. */
static inline double gm_two(double a, double b, double *rest)
{
    const double s = a + b, of_b = s - a;
    *rest = (a - (s - of_b)) + (b - of_b);
    return s;
}

/* The nearest number to a with half as many bits. */
static inline double gm_upper(double a)
{
    gm_double v = {a};
    v.bits += UINT64_C(1) << 26;
    v.bits &= ~((UINT64_C(1) << 27) - 1);
    return v.x;
}
#endif

/* a b + c, rounded once: the exact product and sums, the least of them rounded to odd (Boldo and
 * Melquiond 2008). Numbers are those of drives: no part of them under- or overflows. */
static double gm_fma_double(double a, double b, double c)
{
#if defined(GM_FMA_DOUBLE) && defined(__arm__) /* clang calls a library for the builtin */
    __asm__("vfma.f64 %P0, %P1, %P2" : "+w"(c) : "w"(a), "w"(b));
    return c;
#elif defined(GM_FMA_DOUBLE)
    return GM_BUILTIN(fma)(a, b, c);
#else
    const double product = a * b, a1 = gm_upper(a), b1 = gm_upper(b), a2 = a - a1, b2 = b - b1;
    double least, middle, low, large, high;
    gm_double odd;
    if (!isfinite(product + c))
        return product + c;
    least = ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
    middle = gm_two(c, least, &low);
    large = gm_two(product, middle, &high);
    odd.x = gm_two(low, high, &least);
    if (least != 0.0 && !(odd.bits & 1))
        odd.bits += (least > 0.0) == (odd.x > 0.0) ? 1 : UINT64_MAX;
    return large + odd.x;
#endif
}

#if defined(GM_FLOAT)
static inline float gm_sqrt(float x)
{
#if defined(__ARM_FP) && __ARM_FP & 4 && !defined(__aarch64__)
    float root;
    __asm__("vsqrt.f32 %0, %1" : "=t"(root) : "t"(x));
    return root;
#else
    return (float)gm_root((double)x);
#endif
}
static inline float gm_fma(float a, float b, float c)
{
#if defined(__ARM_FEATURE_FMA) && defined(__arm__)
    __asm__("vfma.f32 %0, %1, %2" : "+t"(c) : "t"(a), "t"(b));
    return c;
#elif defined(GM_FMA_DOUBLE) || defined(__ARM_FEATURE_FMA)
    return GM_BUILTIN(fmaf)(a, b, c);
#else
    return a * b + c;
#endif
}
#define gm_fabs GM_BUILTIN(fabsf)
#define gm_copysign GM_BUILTIN(copysignf)
#else
#define gm_sqrt gm_root
#define gm_fma gm_fma_double
#define gm_fabs GM_BUILTIN(fabs)
#define gm_copysign GM_BUILTIN(copysign)
#endif

/* Of a number of steps. */
static inline gm_real gm_ceil(gm_real x)
{
    const gm_real whole = (gm_real)(int32_t)x;
    return whole < x ? whole + 1 : whole;
}
