typedef double real;
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

typedef struct { int64_t n_; bool loaded_; int64_t curve_; bool law_; } Layout;
typedef struct { real *p; int64_t n[1]; } array1_f8;
typedef struct { array1_f8 z_; array1_f8 P_; array1_f8 memory_; } Belief;
typedef struct { real *p; int64_t n[2]; } array2_f8;
typedef struct { array2_f8 vectors_; array2_f8 matrices_; } Scratch;
typedef struct { int64_t number_; array1_f8 s_; array1_f8 lanes_; } Companions;
typedef struct { Belief f0; array1_f8 f1; Scratch f2; array1_f8 f3; Companions f4; array1_f8 f5; } tuple;
typedef struct { real dt_; real u_; real load_; real y1_; real y2_; } Reading;
typedef struct { int64_t v[9]; } tuple_2;
typedef struct { real v[2]; } tuple_3;
typedef struct { real v[5]; } tuple_4;
typedef struct { real v[4]; } tuple_5;
typedef struct { real f0; tuple_5 f1; } tuple_6;
typedef struct { real f0; tuple_4 f1; } tuple_7;
typedef struct { tuple_4 v[4]; } tuple_8;
typedef struct { tuple_3 v[4]; } tuple_9;
typedef struct { tuple_5 slopes_; tuple_5 shares_; tuple_9 arms_; tuple_8 bends_; real h_; bool first_; } Stages;
typedef struct { real v[11]; } tuple_10;
typedef struct { real v[7]; } tuple_11;
typedef struct { real v[3]; } tuple_12;
typedef struct { array2_f8 z_; array2_f8 P_; int64_t n_theta_; } BeliefSensitivity;
typedef struct { int64_t f0; tuple_3 f1; } tuple_13;
typedef struct { array1_f8 f0; real f1; } tuple_14;
typedef struct { real v[27]; } tuple_15;
typedef struct { real f0; tuple_15 f1; } tuple_16;
typedef struct { int64_t v[4]; } tuple_17;
typedef struct { real time_; real noise_; real torque_noise_; real eigenvalue_; real inertia_; } DescribedLoad;
typedef struct { int64_t max_gap_; int64_t delay_; int64_t lag_; bool load_measured_; bool narrow_; DescribedLoad described_; } LoopSettings;
typedef struct { int64_t *p; int64_t n[1]; } array1_i8;
typedef struct { array1_i8 stamps_; array2_f8 inputs_; array2_f8 outputs_; } Stream;
typedef struct { array1_i8 gate_; array1_i8 counts_; array1_f8 clock_; array2_f8 efforts_; array2_f8 ring_; array1_i8 ring_stamps_; array1_f8 saved_; Companions companions_; } LoopState;
typedef struct { array1_i8 codes_; array2_f8 estimates_; array1_i8 smoothed_stamps_; array2_f8 smoothed_; } Output;
typedef struct { int64_t v[2]; } tuple_18;
typedef struct { int64_t f0; real f1; } tuple_19;
typedef struct { int64_t newest_; int64_t oldest_; int64_t keep_until_; } Span;


/* estimation/step_record.py:18 record_size */
GM_STATIC int64_t step_record_record_size(int64_t n_, int64_t considered_)
{
    return ((((4 * n_) + ((3 * n_) * n_)) + 9) + ((3 * n_) * considered_));
}

/* estimation/filter.py:36 _parts */
GM_INLINE tuple filter_parts(Layout layout_, int64_t n_vectors_, int64_t n_matrices_, array1_f8 room_)
{
    int64_t n_;
    int64_t count_;
    int64_t m_;
    int64_t at_P_;
    int64_t at_p_;
    int64_t at_vectors_;
    int64_t at_matrices_;
    int64_t at_record_;
    int64_t at_lanes_;
    int64_t at_s_;
    int64_t at_before_;
    int64_t at_memory_;
    int64_t t1 = (int64_t)(room_.p[0]);
    n_ = layout_.n_;
    count_ = t1;
    m_ = (n_ * n_);
    at_P_ = (1 + n_);
    at_p_ = (at_P_ + m_);
    at_vectors_ = (at_p_ + 74);
    at_matrices_ = (at_vectors_ + (n_vectors_ * n_));
    at_record_ = (at_matrices_ + (n_matrices_ * m_));
    int64_t t2 = step_record_record_size(n_, count_);
    at_lanes_ = (at_record_ + t2);
    at_s_ = (at_lanes_ + (((n_ + 21) + 10) * 16));
    at_before_ = ((at_s_ + (n_ * count_)) + 1);
    at_memory_ = (at_before_ + n_);
    int64_t t3 = gm_bound(1, room_.n[0]);
    int64_t t4 = gm_bound(at_P_, room_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = gm_bound(at_P_, room_.n[0]);
    int64_t t7 = gm_bound(at_p_, room_.n[0]);
    int64_t t8 = gm_span(t6, t7);
    int64_t t9 = gm_bound(at_memory_, room_.n[0]);
    int64_t t10 = gm_span(t9, room_.n[0]);
    int64_t t11 = gm_bound(at_p_, room_.n[0]);
    int64_t t12 = gm_bound(at_vectors_, room_.n[0]);
    int64_t t13 = gm_span(t11, t12);
    int64_t t14 = gm_bound(at_vectors_, room_.n[0]);
    int64_t t15 = gm_bound(at_matrices_, room_.n[0]);
    int64_t t16 = gm_span(t14, t15);
    int64_t t17 = gm_bound(at_matrices_, room_.n[0]);
    int64_t t18 = gm_bound(at_record_, room_.n[0]);
    int64_t t19 = gm_span(t17, t18);
    int64_t t20 = gm_bound(at_record_, room_.n[0]);
    int64_t t21 = gm_bound(at_lanes_, room_.n[0]);
    int64_t t22 = gm_span(t20, t21);
    int64_t t23 = gm_bound(at_s_, room_.n[0]);
    int64_t t24 = gm_bound(at_before_, room_.n[0]);
    int64_t t25 = gm_span(t23, t24);
    int64_t t26 = gm_bound(at_lanes_, room_.n[0]);
    int64_t t27 = gm_bound(at_s_, room_.n[0]);
    int64_t t28 = gm_span(t26, t27);
    int64_t t29 = gm_bound(at_before_, room_.n[0]);
    int64_t t30 = gm_bound(at_memory_, room_.n[0]);
    int64_t t31 = gm_span(t29, t30);
    return (tuple){(Belief){(array1_f8){room_.p + t3 * (1), {t5}}, (array1_f8){room_.p + t6 * (1), {t8}}, (array1_f8){room_.p + t9 * (1), {t10}}}, (array1_f8){room_.p + t11 * (1), {t13}}, (Scratch){(array2_f8){room_.p + t14 * (1), {n_vectors_, n_}}, (array2_f8){room_.p + t17 * (1), {n_matrices_, m_}}}, (array1_f8){room_.p + t20 * (1), {t22}}, (Companions){count_, (array1_f8){room_.p + t23 * (1), {t25}}, (array1_f8){room_.p + t26 * (1), {t28}}}, (array1_f8){room_.p + t29 * (1), {t31}}};
}

/* estimation/sample_loop.py:421 first_speed */
GM_INLINE real sample_loop_first_speed(real moved_, real dt_, real variance_, real prior_)
{
    if ((!(bool)isfinite(moved_))) {
        return (real)0.0;
    }
    return (((prior_ / (prior_ + (variance_ / (dt_ * dt_)))) * moved_) / dt_);
}

/* estimation/sample_loop.py:441 aim */
GM_INLINE void sample_loop_aim(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_)
{
    int64_t n_;
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    n_ = layout_.n_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    real t1 = sample_loop_first_speed((reading_.y1_ - z_.p[0]), dt_, (P_.p[(((0 * n_) + 0))] + p_.p[31]), P_.p[(((2 * n_) + 2))]);
    z_.p[2] = t1;
    real t2 = sample_loop_first_speed((reading_.y2_ - z_.p[1]), dt_, (P_.p[(((1 * n_) + 1))] + p_.p[32]), P_.p[(((3 * n_) + 3))]);
    z_.p[3] = t2;
    return;
}

/* estimation/step_record.py:39 places */
GM_INLINE tuple_2 step_record_places(int64_t n_)
{
    int64_t m_;
    int64_t begin_;
    m_ = (n_ * n_);
    begin_ = ((2 * n_) + (3 * m_));
    return (tuple_2){{0, n_, (n_ + m_), (n_ + (2 * m_)), ((2 * n_) + (2 * m_)), begin_, (begin_ + 2), (begin_ + 5), ((begin_ + 5) + (2 * n_))}};
}

/* estimation/process_model.py:399 tau_k_noise */
GM_INLINE real process_model_tau_k_noise(real constant_, real of_speed_, real x3_)
{
    return (constant_ + ((of_speed_ * x3_) * x3_));
}

/* estimation/process_model.py:381 noise */
GM_INLINE real process_model_noise(array1_f8 z_, array1_f8 p_, int64_t i_)
{
    if (((i_ == 4))) {
        real t1 = process_model_tau_k_noise(p_.p[56], p_.p[35], z_.p[2]);
        return t1;
    }
    return p_.p[((52 + i_))];
}

/* plant/drive.py:752 substeps */
GM_STATIC int64_t drive_substeps(real dt_, real eigenvalue_)
{
    real n_;
    n_ = ((dt_ * eigenvalue_) / (real)2.7);
    if ((!((n_ < (real)100000.0)))) {
        return 100000;
    }
    return gm_max_i(1, (int64_t)gm_ceil(n_));
}

/* estimation/process_model.py:445 softened_sharpness */
GM_STATIC real process_model_softened_sharpness(real sharpness_, real variance_)
{
    return ((real)1.0 / gm_sqrt((((real)1.0 / (sharpness_ * sharpness_)) + (variance_ / (real)1.5707963267948966))));
}

/* estimation/process_model.py:204 curve_count */
GM_INLINE int64_t process_model_curve_count(int64_t curve_)
{
    return gm_max_i(curve_, 0);
}

/* estimation/process_model.py:456 decay */
GM_INLINE tuple_4 process_model_decay(real error_, real half_, real h_, array1_f8 p_)
{
    real rate_;
    real second_;
    real third_;
    real fourth_;
    rate_ = ((real)(-1.0) / p_.p[27]);
    second_ = (error_ + ((half_ * rate_) * error_));
    third_ = (error_ + ((half_ * rate_) * second_));
    fourth_ = (error_ + ((h_ * rate_) * third_));
    return (tuple_4){{error_, second_, third_, fourth_, (error_ + (((h_ / (real)6.0) * rate_) * ((error_ + ((real)2.0 * (second_ + third_))) + fourth_)))}};
}

/* estimation/process_model.py:210 _curve */
GM_INLINE tuple_5 process_model_curve(int64_t curve_, array1_f8 z_, int64_t width_, int64_t i_, int64_t at_, array1_f8 p_)
{
    int64_t count_;
    if (((curve_ < 0))) {
        return (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    }
    int64_t t1 = process_model_curve_count(curve_);
    count_ = t1;
    if (((count_ > 1))) {
        return (tuple_5){{z_.p[gm_at((((at_ + 1) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 2) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 3) * width_) + i_), z_.n[0])], p_.p[12]}};
    }
    return (tuple_5){{p_.p[9], (p_.p[9] * p_.p[10]), (((count_ > 0)) ? (p_.p[9] * p_.p[11]) : (real)0.0), p_.p[12]}};
}

/* estimation/process_model.py:223 _memory */
GM_INLINE real process_model_memory(int64_t curve_, array1_f8 z_, int64_t at_, real otherwise_)
{
    if (((curve_ < 0))) {
        return otherwise_;
    }
    int64_t t1 = process_model_curve_count(curve_);
    if (((t1 > 0))) {
        return z_.p[gm_at(at_, z_.n[0])];
    }
    return otherwise_;
}

/* plant/transmission.py:90 dead_zone_torque */
GM_INLINE tuple_7 transmission_dead_zone_torque(real twist_, real stiffness_, real offset_)
{
    real stretched_;
    real torque_;
    real side_;
    stretched_ = (stiffness_ * twist_);
    torque_ = (stretched_ - gm_min_f(gm_max_f(stretched_, (-offset_)), offset_));
    side_ = (((torque_ != (real)0.0)) ? gm_copysign((real)1.0, torque_) : (real)0.0);
    return (tuple_7){torque_, (tuple_4){{(stiffness_ * gm_fabs(side_)), (real)0.0, (gm_fabs(side_) * twist_), (-side_), (real)0.0}}};
}

/* plant/transmission.py:70 play */
GM_INLINE tuple_3 transmission_play(real twist_, real memory_, real width_)
{
    if ((((twist_ - memory_) > width_))) {
        return (tuple_3){{(twist_ - width_), (real)1.0}};
    }
    if ((((memory_ - twist_) > width_))) {
        return (tuple_3){{(twist_ + width_), (real)(-1.0)}};
    }
    return (tuple_3){{memory_, (real)0.0}};
}

/* plant/transmission.py:20 dead_zone */
GM_INLINE real transmission_dead_zone(real twist_, real half_gap_)
{
    if (((twist_ > half_gap_))) {
        return (twist_ - half_gap_);
    }
    if (((twist_ < (-half_gap_)))) {
        return (twist_ + half_gap_);
    }
    return (real)0.0;
}

/* plant/transmission.py:109 elastic_torque */
GM_INLINE tuple_7 transmission_elastic_torque(real twist_, real memory_, tuple_5 curve_)
{
    real stiffness_;
    real offset_;
    real shift_;
    real added_;
    real width_;
    real end_;
    real sign_;
    real free_;
    real stretch_;
    real share_;
    real shifted_;
    real torque_;
    real side_;
    real slope_;
    real of_stretch_;
    real of_width_;
    stiffness_ = curve_.v[0];
    offset_ = curve_.v[1];
    shift_ = curve_.v[2];
    added_ = curve_.v[3];
    width_ = (gm_fabs(shift_) / stiffness_);
    tuple_3 t1 = transmission_play(twist_, memory_, width_);
    end_ = t1.v[1];
    sign_ = (((shift_ >= (real)0.0)) ? (real)1.0 : (real)(-1.0));
    free_ = ((((end_ == (real)0.0)) && ((width_ != (real)0.0))) ? (real)1.0 : (real)0.0);
    stretch_ = ((end_ * width_) + (free_ * (twist_ - memory_)));
    share_ = (((added_ > (real)0.0)) ? (real)0.0 : sign_);
    shifted_ = (twist_ - (share_ * stretch_));
    real t2 = transmission_dead_zone((stiffness_ * shifted_), offset_);
    torque_ = t2;
    side_ = (((torque_ > (real)0.0)) ? (real)1.0 : (((torque_ < (real)0.0)) ? (real)(-1.0) : (real)0.0));
    slope_ = (stiffness_ * gm_fabs(side_));
    of_stretch_ = (added_ - (share_ * slope_));
    of_width_ = ((of_stretch_ * end_) / stiffness_);
    return (tuple_7){(torque_ + (added_ * stretch_)), (tuple_4){{(slope_ + (of_stretch_ * free_)), ((-of_stretch_) * free_), ((gm_fabs(side_) * shifted_) - (of_width_ * width_)), (-side_), (of_width_ * sign_)}}};
}

/* estimation/process_model.py:233 _total */
GM_INLINE tuple_7 process_model_total(int64_t curve_, real twist_, real memory_, tuple_5 law_, real tau_k_)
{
    real torque_;
    tuple_4 slopes_;
    if (((curve_ < 0))) {
        return (tuple_7){tau_k_, (tuple_4){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}}};
    }
    int64_t t1 = process_model_curve_count(curve_);
    if (((t1 == 0))) {
        tuple_7 t2 = transmission_dead_zone_torque(twist_, law_.v[0], law_.v[1]);
        torque_ = t2.f0;
        slopes_ = t2.f1;
    } else {
        tuple_7 t3 = transmission_elastic_torque(twist_, memory_, law_);
        torque_ = t3.f0;
        slopes_ = t3.f1;
    }
    return (tuple_7){(tau_k_ + torque_), slopes_};
}

/* estimation/process_model.py:547 _bearing */
GM_INLINE tuple_4 process_model_bearing(Layout layout_, tuple_4 x_, tuple_6 elastic_)
{
    real tau_k_;
    tuple_7 t1 = process_model_total(layout_.curve_, (x_.v[0] - x_.v[1]), elastic_.f0, elastic_.f1, x_.v[4]);
    tau_k_ = t1.f0;
    return (tuple_4){{x_.v[0], x_.v[1], x_.v[2], x_.v[3], tau_k_}};
}

/* plant/drive.py:959 steady_arm_load */
GM_INLINE real drive_steady_arm_load(real x4_, array1_f8 p_)
{
    return ((p_.p[13] * x4_) + p_.p[18]);
}

/* kernels/elementary.py:87 exponential */
GM_INLINE real elementary_exponential(real x_)
{
    real t_;
    real k_;
    real r_;
    real r2_;
    real r4_;
    real low_;
    real mid_;
    real high_;
    if (((x_ < (real)(-100.0)))) {
        x_ = (real)(-100.0);
    }
    t_ = gm_fma(x_, (real)1.4426950408889634, (real)6755399441055744.0);
    k_ = (t_ - (real)6755399441055744.0);
    r_ = gm_fma(k_, (real)(-2.3190468138462996e-17), gm_fma(k_, (real)(-0.6931471805599453), x_));
    r2_ = (r_ * r_);
    r4_ = (r2_ * r2_);
    low_ = gm_fma(r2_, gm_fma((real)0.16666666666666669, r_, (real)0.5), r_);
    mid_ = gm_fma(r2_, gm_fma((real)0.0001984126986317156, r_, (real)0.0013888888917367081), gm_fma((real)0.008333333333330039, r_, (real)0.041666666666623824));
    high_ = gm_fma(r2_, gm_fma((real)2.5100472505694996e-08, r_, (real)2.762020159103155e-07), gm_fma((real)2.7557268276905696e-06, r_, (real)2.4801521057868204e-05));
    return gm_times_power(((real)1.0 + gm_fma(r4_, gm_fma(r4_, high_, mid_), low_)), t_);
}

/* kernels/elementary.py:52 arctan */
GM_INLINE real elementary_arctan(real x_)
{
    real a_;
    real over_;
    real under_;
    real offset_;
    real t_;
    real z_;
    real z2_;
    real z4_;
    real low_;
    real mid_;
    real high_;
    real q_;
    a_ = gm_fabs(x_);
    over_ = a_;
    under_ = (real)1.0;
    offset_ = (real)0.0;
    if (((a_ > (real)0.41421356237309503))) {
        real t1 = (a_ - (real)1.0);
        real t2 = (a_ + (real)1.0);
        over_ = t1;
        under_ = t2;
        offset_ = (real)0.7853981633974483;
    }
    if (((a_ > (real)2.414213562373095))) {
        over_ = (real)(-1.0);
        under_ = a_;
        offset_ = (real)1.5707963267948966;
    }
    t_ = (over_ / under_);
    z_ = (t_ * t_);
    z2_ = (z_ * z_);
    z4_ = (z2_ * z2_);
    low_ = gm_fma(z2_, gm_fma((real)0.11111111105155447, z_, (real)(-0.14285714285659828)), gm_fma((real)0.19999999999999804, z_, (real)(-0.3333333333333333)));
    mid_ = gm_fma(z2_, gm_fma((real)0.058789289978203436, z_, (real)(-0.06666424885737)), gm_fma((real)0.07692296375032072, z_, (real)(-0.09090908753500875)));
    high_ = gm_fma(z2_, gm_fma((real)0.016285756841402314, z_, (real)(-0.034570561968958594)), gm_fma((real)0.045515932201417086, z_, (real)(-0.052304542705439556)));
    q_ = gm_fma(z4_, gm_fma(z4_, high_, mid_), low_);
    return gm_copysign((offset_ + gm_fma((t_ * z_), q_, t_)), x_);
}

/* plant/friction_law.py:77 side */
GM_INLINE real friction_law_side(real v_, real law_)
{
    if (((law_ == (real)1.0))) {
        real t1 = elementary_exponential(((real)2.0 * gm_min_f(gm_max_f(v_, (real)(-20.0)), (real)20.0)));
        return ((real)1.0 - ((real)2.0 / ((real)1.0 + t1)));
    }
    real t2 = elementary_arctan(v_);
    return ((real)0.6366197723675814 * t2);
}

/* kernels/elementary.py:109 sine */
GM_INLINE real elementary_sine(real x_)
{
    real t_;
    real k_;
    real r_;
    real z_;
    real z2_;
    real low_;
    real high_;
    t_ = gm_fma(x_, (real)0.3183098861837907, (real)6755399441055744.0);
    k_ = (t_ - (real)6755399441055744.0);
    r_ = gm_fma(k_, (real)(-1.2246467991473532e-16), gm_fma(k_, (real)(-3.141592653589793), x_));
    z_ = (r_ * r_);
    z2_ = (z_ * z_);
    low_ = gm_fma(z2_, gm_fma((real)2.7557319219115013e-06, z_, (real)(-0.00019841269841254795)), gm_fma((real)0.008333333333333316, z_, (real)(-0.16666666666666666)));
    high_ = gm_fma(z2_, gm_fma((real)2.7312868913092307e-15, z_, (real)(-7.643957622560617e-13)), gm_fma((real)1.6058976915095007e-10, z_, (real)(-2.505210761086116e-08)));
    return gm_signed(gm_fma((r_ * z_), gm_fma((z2_ * z2_), high_, low_), r_), t_);
}

/* plant/drive.py:987 gravity */
GM_INLINE real drive_gravity(real x2_, array1_f8 p_)
{
    real t2 = p_.p[16];
    real t1 = elementary_sine((x2_ + p_.p[17]));
    return (t2 * t1);
}

/* plant/drive.py:965 arm_load */
GM_STATIC real drive_arm_load(real x2_, real x4_, array1_f8 p_)
{
    real torque_;
    real t1 = drive_steady_arm_load(x4_, p_);
    torque_ = t1;
    if ((((p_.p[14] != (real)0.0)) && ((p_.p[20] <= (real)1.0)))) {
        real t4 = torque_;
        real t3 = p_.p[14];
        real t2 = friction_law_side((p_.p[15] * x4_), p_.p[20]);
        torque_ = (t4 + (t3 * t2));
    }
    if (((p_.p[16] != (real)0.0))) {
        real t6 = torque_;
        real t5 = drive_gravity(x2_, p_);
        torque_ = (t6 + t5);
    }
    return torque_;
}

/* plant/friction_law.py:113 holding */
GM_INLINE real friction_law_holding(real torque_, real moving_, real limit_, real softness_, real static_)
{
    real needed_;
    needed_ = ((torque_ + moving_) / ((real)1.0 + softness_));
    return (((gm_fabs(needed_) <= (static_ * limit_))) ? needed_ : gm_copysign(limit_, needed_));
}

/* plant/drive.py:920 arm_constraint */
GM_STATIC real drive_arm_constraint(real x3_, real x4_, real tau_k_, real tau_arm_, array1_f8 p_)
{
    if ((((p_.p[20] <= (real)1.0)) || ((p_.p[14] == (real)0.0)))) {
        return (real)0.0;
    }
    real t1 = friction_law_holding((((p_.p[2] * (x3_ - x4_)) + tau_k_) - tau_arm_), ((p_.p[22] * x4_) / p_.p[1]), p_.p[14], p_.p[21], p_.p[23]);
    return t1;
}

/* plant/drive.py:811 motor_friction */
GM_INLINE real drive_motor_friction(real x3_, real tau_k_, array1_f8 p_)
{
    real t3 = (p_.p[3] * x3_);
    real t2 = ((p_.p[4] + (p_.p[19] * gm_fabs(tau_k_))) * (real)0.6366197723675814);
    real t1 = elementary_arctan((p_.p[5] * x3_));
    return (t3 + (t2 * t1));
}

/* plant/drive.py:871 motor_acceleration */
GM_INLINE real drive_motor_acceleration(real x1_, real x3_, real x4_, real u_, real tau_k_, array1_f8 p_)
{
    real t2 = ((((u_ + p_.p[7]) - (p_.p[2] * (x3_ - x4_))) - tau_k_) - (p_.p[6] * x1_));
    real t1 = drive_motor_friction(x3_, tau_k_, p_);
    return ((t2 - t1) * p_.p[0]);
}

/* plant/drive.py:892 motor_acceleration_by_law */
GM_STATIC real drive_motor_acceleration_by_law(real x1_, real x3_, real x4_, real u_, real tau_k_, array1_f8 p_)
{
    real torque_;
    real level_;
    if (((p_.p[20] == (real)0.0))) {
        real t1 = drive_motor_acceleration(x1_, x3_, x4_, u_, tau_k_, p_);
        return t1;
    }
    torque_ = (((((u_ + p_.p[7]) - (p_.p[2] * (x3_ - x4_))) - tau_k_) - (p_.p[6] * x1_)) - (p_.p[3] * x3_));
    level_ = ((p_.p[4] + p_.p[24]) + (p_.p[19] * gm_fabs(tau_k_)));
    if (((p_.p[20] == (real)1.0))) {
        real t3 = torque_;
        real t2 = friction_law_side((p_.p[5] * x3_), p_.p[20]);
        torque_ = (t3 - (level_ * t2));
    } else {
        real t5 = torque_;
        real t4 = friction_law_holding(torque_, ((p_.p[22] * x3_) / p_.p[0]), level_, p_.p[21], p_.p[23]);
        torque_ = (t5 - t4);
    }
    return (torque_ * p_.p[0]);
}

/* plant/drive.py:941 arm_acceleration */
GM_INLINE real drive_arm_acceleration(real x3_, real x4_, real tau_k_, real tau_arm_, array1_f8 p_)
{
    return ((((p_.p[2] * (x3_ - x4_)) + tau_k_) - tau_arm_) * p_.p[1]);
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_3 process_model_accelerations(Layout layout_, tuple_4 x_, real u_, real load_, array1_f8 p_)
{
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    real tau_k_;
    x1_ = x_.v[0];
    x2_ = x_.v[1];
    x3_ = x_.v[2];
    x4_ = x_.v[3];
    tau_k_ = x_.v[4];
    if (layout_.loaded_) {
        real t2 = load_;
        real t1 = drive_arm_load(x2_, x4_, p_);
        load_ = (t2 + t1);
    }
    if (layout_.law_) {
        real t4 = load_;
        real t3 = drive_arm_constraint(x3_, x4_, tau_k_, load_, p_);
        load_ = (t4 + t3);
        real t5 = drive_motor_acceleration_by_law(x1_, x3_, x4_, u_, tau_k_, p_);
        real t6 = drive_arm_acceleration(x3_, x4_, tau_k_, load_, p_);
        return (tuple_3){{t5, t6}};
    }
    real t7 = drive_motor_acceleration(x1_, x3_, x4_, u_, tau_k_, p_);
    real t8 = drive_arm_acceleration(x3_, x4_, tau_k_, load_, p_);
    return (tuple_3){{t7, t8}};
}

/* estimation/process_model.py:520 _advanced */
GM_INLINE tuple_4 process_model_advanced(Layout layout_, tuple_4 x_, tuple_6 elastic_, tuple_5 error_, tuple_3 torques_, real h_, array1_f8 p_)
{
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    real tau_k_;
    real u_;
    real load_;
    real half_;
    real sixth_;
    real f1_;
    real g1_;
    real b3_;
    real b4_;
    tuple_4 y_;
    real f2_;
    real g2_;
    real c3_;
    real c4_;
    real f3_;
    real g3_;
    real d3_;
    real d4_;
    real f4_;
    real g4_;
    real moved1_;
    real moved2_;
    x1_ = x_.v[0];
    x2_ = x_.v[1];
    x3_ = x_.v[2];
    x4_ = x_.v[3];
    tau_k_ = x_.v[4];
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    real t1 = ((real)0.5 * h_);
    real t2 = (h_ / (real)6.0);
    half_ = t1;
    sixth_ = t2;
    tuple_4 t3 = process_model_bearing(layout_, x_, elastic_);
    tuple_3 t4 = process_model_accelerations(layout_, t3, (u_ - error_.v[0]), load_, p_);
    f1_ = t4.v[0];
    g1_ = t4.v[1];
    real t5 = (x3_ + (half_ * f1_));
    real t6 = (x4_ + (half_ * g1_));
    b3_ = t5;
    b4_ = t6;
    y_ = (tuple_4){{(x1_ + (half_ * x3_)), (x2_ + (half_ * x4_)), b3_, b4_, (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)))}};
    tuple_4 t7 = process_model_bearing(layout_, y_, elastic_);
    tuple_3 t8 = process_model_accelerations(layout_, t7, (u_ - error_.v[1]), load_, p_);
    f2_ = t8.v[0];
    g2_ = t8.v[1];
    real t9 = (x3_ + (half_ * f2_));
    real t10 = (x4_ + (half_ * g2_));
    c3_ = t9;
    c4_ = t10;
    y_ = (tuple_4){{(x1_ + (half_ * b3_)), (x2_ + (half_ * b4_)), c3_, c4_, (tau_k_ + ((half_ * p_.p[26]) * (b3_ - b4_)))}};
    tuple_4 t11 = process_model_bearing(layout_, y_, elastic_);
    tuple_3 t12 = process_model_accelerations(layout_, t11, (u_ - error_.v[2]), load_, p_);
    f3_ = t12.v[0];
    g3_ = t12.v[1];
    real t13 = (x3_ + (h_ * f3_));
    real t14 = (x4_ + (h_ * g3_));
    d3_ = t13;
    d4_ = t14;
    y_ = (tuple_4){{(x1_ + (h_ * c3_)), (x2_ + (h_ * c4_)), d3_, d4_, (tau_k_ + ((h_ * p_.p[26]) * (c3_ - c4_)))}};
    tuple_4 t15 = process_model_bearing(layout_, y_, elastic_);
    tuple_3 t16 = process_model_accelerations(layout_, t15, (u_ - error_.v[3]), load_, p_);
    f4_ = t16.v[0];
    g4_ = t16.v[1];
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (b3_ + c3_))) + d3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (b4_ + c4_))) + d4_));
    return (tuple_4){{(x1_ + moved1_), (x2_ + moved2_), (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_))), (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_))), (tau_k_ + (p_.p[26] * (moved1_ - moved2_)))}};
}

/* estimation/process_model.py:499 _advance_one */
GM_INLINE void process_model_advance_one(Layout layout_, array1_f8 z_, tuple_3 torques_, real h_, array1_f8 p_)
{
    real u_;
    real load_;
    int64_t curve_;
    int64_t at_curve_;
    tuple_4 error_;
    tuple_4 x_;
    tuple_5 law_;
    real memory_;
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    curve_ = layout_.curve_;
    int64_t t1 = process_model_curve_count(curve_);
    at_curve_ = (layout_.n_ - t1);
    error_ = (tuple_4){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_4 t2 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], ((real)0.5 * h_), h_, p_);
        error_ = t2;
        z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])] = error_.v[4];
    }
    x_ = (tuple_4){{z_.p[0], z_.p[1], z_.p[2], z_.p[3], z_.p[4]}};
    tuple_5 t3 = process_model_curve(curve_, z_, 1, 0, at_curve_, p_);
    law_ = t3;
    real t4 = process_model_memory(curve_, z_, at_curve_, (x_.v[0] - x_.v[1]));
    memory_ = t4;
    tuple_4 t5 = process_model_advanced(layout_, x_, (tuple_6){memory_, law_}, (tuple_5){{error_.v[0], error_.v[1], error_.v[2], error_.v[3]}}, (tuple_3){{u_, load_}}, h_, p_);
    x_ = t5;
    int64_t t6 = process_model_curve_count(curve_);
    if (((t6 > 0))) {
        tuple_3 t7 = transmission_play((x_.v[0] - x_.v[1]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
        z_.p[gm_at(at_curve_, z_.n[0])] = t7.v[0];
    }
    z_.p[0] = x_.v[0];
    z_.p[1] = x_.v[1];
    z_.p[2] = x_.v[2];
    z_.p[3] = x_.v[3];
    z_.p[4] = x_.v[4];
    return;
}

/* estimation/process_model.py:479 advance */
GM_STATIC void process_model_advance(Layout layout_, array1_f8 z_, tuple_3 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (dt_ / (real)(n_substeps_));
    for (int64_t k1 = 0; k1 < n_substeps_; k1 += 1) {
        process_model_advance_one(layout_, z_, torques_, h_, p_);
    }
    return;
}

/* estimation/process_model.py:1044 propagate_numeric */
GM_STATIC void process_model_propagate_numeric(Layout layout_, array1_f8 z_, array1_f8 phi_, tuple_3 torques_, real dt_, int64_t n_substeps_, array1_f8 p_, array1_f8 start_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    array1_f8 moved_;
    real step_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        start_.p[(i_)] = z_.p[(i_)];
    }
    process_model_advance(layout_, z_, torques_, dt_, n_substeps_, p_);
    for (int64_t k2 = 0; k2 < n_; k2 += 1) {
        j_ = k2;
        int64_t t3 = (j_ * n_);
        int64_t t4 = ((j_ + 1) * n_);
        int64_t t5 = gm_bound(t3, phi_.n[0]);
        int64_t t6 = gm_bound(t4, phi_.n[0]);
        int64_t t7 = gm_span(t5, t6);
        moved_ = (array1_f8){phi_.p + t5 * (1), {t7}};
        for (int64_t k8 = 0; k8 < n_; k8 += 1) {
            i_ = k8;
            moved_.p[(i_)] = start_.p[(i_)];
        }
        moved_.p[(j_)] = (moved_.p[(j_)] + ((real)1e-06 * gm_max_f((real)1.0, gm_fabs(start_.p[(j_)]))));
        step_ = (moved_.p[(j_)] - start_.p[(j_)]);
        process_model_advance(layout_, moved_, torques_, dt_, n_substeps_, p_);
        for (int64_t k9 = 0; k9 < n_; k9 += 1) {
            i_ = k9;
            moved_.p[(i_)] = ((moved_.p[(i_)] - z_.p[(i_)]) / step_);
        }
    }
    for (int64_t k10 = 0; k10 < n_; k10 += 1) {
        i_ = k10;
        int64_t t11 = i_;
        for (int64_t k12 = 0; k12 < t11; k12 += 1) {
            j_ = k12;
            real t13 = phi_.p[(((j_ * n_) + i_))];
            real t14 = phi_.p[(((i_ * n_) + j_))];
            phi_.p[(((i_ * n_) + j_))] = t13;
            phi_.p[(((j_ * n_) + i_))] = t14;
        }
    }
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row(Layout layout_, array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t n_;
    int64_t count_;
    int64_t t1 = process_model_curve_count(layout_.curve_);
    n_ = layout_.n_;
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (n_ - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((n_ - count_) * n_) + j_), phi_.n[0])];
}

/* estimation/process_model.py:791 _begin */
GM_INLINE tuple_4 process_model_begin(int64_t n_, array1_f8 phi_, int64_t j_, bool first_)
{
    if (first_) {
        return (tuple_4){{(((j_ == 0)) ? (real)1.0 : (real)0.0), (((j_ == 2)) ? (real)1.0 : (real)0.0), (((j_ == 3)) ? (real)1.0 : (real)0.0), (((j_ == 4)) ? (real)1.0 : (real)0.0), (((j_ == 1)) ? (real)1.0 : (real)0.0)}};
    }
    return (tuple_4){{phi_.p[(((0 * n_) + j_))], phi_.p[(((2 * n_) + j_))], phi_.p[(((3 * n_) + j_))], phi_.p[(((4 * n_) + j_))], phi_.p[(((1 * n_) + j_))]}};
}

/* plant/friction_law.py:95 side_slope */
GM_INLINE real friction_law_side_slope(real v_, real law_)
{
    real share_;
    if (((law_ == (real)1.0))) {
        real t1 = friction_law_side(v_, law_);
        share_ = t1;
        return ((real)1.0 - (share_ * share_));
    }
    return ((real)0.6366197723675814 / ((real)1.0 + (v_ * v_)));
}

/* plant/drive.py:844 motor_friction_slope_by_law */
GM_STATIC real drive_motor_friction_slope_by_law(real x3_, real tau_k_, array1_f8 p_)
{
    if (((p_.p[20] > (real)1.0))) {
        return (p_.p[3] + (p_.p[22] / (p_.p[0] * ((real)1.0 + p_.p[21]))));
    }
    real t3 = p_.p[3];
    real t2 = ((p_.p[4] + (p_.p[19] * gm_fabs(tau_k_))) * p_.p[5]);
    real t1 = friction_law_side_slope((p_.p[5] * x3_), p_.p[20]);
    return (t3 + (t2 * t1));
}

/* plant/drive.py:852 motor_friction_load_slope */
GM_STATIC real drive_motor_friction_load_slope(real x3_, real tau_k_, array1_f8 p_)
{
    real sign_;
    if (((p_.p[19] == (real)0.0))) {
        return (real)0.0;
    }
    sign_ = (((tau_k_ > (real)0.0)) ? (real)1.0 : (((tau_k_ < (real)0.0)) ? (real)(-1.0) : (real)0.0));
    real t2 = (p_.p[19] * sign_);
    real t1 = friction_law_side((p_.p[5] * x3_), p_.p[20]);
    return (t2 * t1);
}

/* plant/drive.py:827 motor_friction_slope */
GM_STATIC real drive_motor_friction_slope(real x3_, real tau_k_, array1_f8 p_)
{
    real v_;
    v_ = (p_.p[5] * x3_);
    return (p_.p[3] + ((((p_.p[4] + (p_.p[19] * gm_fabs(tau_k_))) * (real)0.6366197723675814) * p_.p[5]) / ((real)1.0 + (v_ * v_))));
}

/* estimation/process_model.py:875 _slopes */
GM_INLINE tuple_3 process_model_slopes(bool law_, real x3_, real tau_k_, array1_f8 p_)
{
    if (law_) {
        real t1 = drive_motor_friction_slope_by_law(x3_, tau_k_, p_);
        real t2 = drive_motor_friction_load_slope(x3_, tau_k_, p_);
        return (tuple_3){{t1, ((real)1.0 + t2)}};
    }
    real t3 = drive_motor_friction_slope(x3_, tau_k_, p_);
    real t4 = drive_motor_friction_load_slope(x3_, tau_k_, p_);
    return (tuple_3){{t3, ((real)1.0 + t4)}};
}

/* plant/drive.py:993 arm_load_slopes */
GM_STATIC tuple_3 drive_arm_load_slopes(real x2_, real x4_, array1_f8 p_)
{
    real slope_;
    real on_speed_;
    if (((p_.p[20] > (real)1.0))) {
        slope_ = (((p_.p[14] != (real)0.0)) ? (p_.p[22] / (p_.p[1] * ((real)1.0 + p_.p[21]))) : (real)0.0);
    } else {
        real t2 = (p_.p[14] * p_.p[15]);
        real t1 = friction_law_side_slope((p_.p[15] * x4_), p_.p[20]);
        slope_ = (t2 * t1);
    }
    on_speed_ = (p_.p[13] + slope_);
    return (tuple_3){{(((p_.p[16] != (real)0.0)) ? (p_.p[16] * gm_cos((x2_ + p_.p[17]))) : (real)0.0), on_speed_}};
}

/* estimation/process_model.py:687 _load_slopes */
GM_INLINE tuple_3 process_model_load_slopes(bool loaded_, real x2_, real x4_, array1_f8 p_)
{
    if ((!loaded_)) {
        return (tuple_3){{(real)0.0, (real)0.0}};
    }
    tuple_3 t1 = drive_arm_load_slopes(x2_, x4_, p_);
    return t1;
}

/* estimation/process_model.py:748 _bent */
GM_INLINE tuple_4 process_model_bent(int64_t curve_, tuple_4 bend_, real source_, tuple_4 m_)
{
    if (((curve_ < 0))) {
        return m_;
    }
    return (tuple_4){{m_.v[0], m_.v[1], m_.v[2], gm_fma(bend_.v[0], (m_.v[0] - m_.v[4]), (m_.v[3] + source_)), m_.v[4]}};
}

/* estimation/process_model.py:756 _four_bent */
GM_INLINE tuple_8 process_model_four_bent(int64_t curve_, tuple_4 bend_, tuple_5 memory_, tuple_8 m_)
{
    if (((curve_ < 0))) {
        return m_;
    }
    tuple_4 t1 = process_model_bent(curve_, bend_, (bend_.v[1] * memory_.v[0]), m_.v[0]);
    tuple_4 t2 = process_model_bent(curve_, bend_, (bend_.v[1] * memory_.v[1]), m_.v[1]);
    tuple_4 t3 = process_model_bent(curve_, bend_, (bend_.v[1] * memory_.v[2]), m_.v[2]);
    tuple_4 t4 = process_model_bent(curve_, bend_, (bend_.v[1] * memory_.v[3]), m_.v[3]);
    return (tuple_8){{t1, t2, t3, t4}};
}

/* estimation/process_model.py:694 answer */
GM_INLINE real process_model_answer(bool loaded_, tuple_3 arm_, real load_, tuple_4 m_)
{
    if ((!loaded_)) {
        return load_;
    }
    return ((load_ + (arm_.v[0] * m_.v[4])) + (arm_.v[1] * m_.v[2]));
}

/* estimation/process_model.py:711 rates */
GM_INLINE tuple_3 process_model_rates(tuple_4 m_, real slope_, real share_, real error_, real load_, array1_f8 p_)
{
    real twist_rate_;
    real on_motor_;
    twist_rate_ = (m_.v[1] - m_.v[2]);
    on_motor_ = gm_fma(share_, m_.v[3], gm_fma(slope_, m_.v[1], gm_fma(p_.p[6], m_.v[0], error_)));
    return (tuple_3){{((-p_.p[0]) * gm_fma(p_.p[2], twist_rate_, on_motor_)), (p_.p[1] * gm_fma(p_.p[2], twist_rate_, (m_.v[3] - load_)))}};
}

/* estimation/process_model.py:776 _four_rates */
GM_INLINE tuple_9 process_model_four_rates(bool loaded_, tuple_8 m_, real slope_, real share_, tuple_3 arm_, array1_f8 p_)
{
    real t1 = process_model_answer(loaded_, arm_, (real)0.0, m_.v[0]);
    tuple_3 t2 = process_model_rates(m_.v[0], slope_, share_, (real)0.0, t1, p_);
    real t3 = process_model_answer(loaded_, arm_, (real)0.0, m_.v[1]);
    tuple_3 t4 = process_model_rates(m_.v[1], slope_, share_, (real)0.0, t3, p_);
    real t5 = process_model_answer(loaded_, arm_, (real)0.0, m_.v[2]);
    tuple_3 t6 = process_model_rates(m_.v[2], slope_, share_, (real)0.0, t5, p_);
    real t7 = process_model_answer(loaded_, arm_, (real)0.0, m_.v[3]);
    tuple_3 t8 = process_model_rates(m_.v[3], slope_, share_, (real)0.0, t7, p_);
    return (tuple_9){{t2, t4, t6, t8}};
}

/* estimation/process_model.py:731 along */
GM_INLINE tuple_4 process_model_along(tuple_4 start_, real a_, tuple_4 m_, tuple_3 r_, array1_f8 p_)
{
    return (tuple_4){{gm_fma(a_, m_.v[1], start_.v[0]), gm_fma(a_, r_.v[0], start_.v[1]), gm_fma(a_, r_.v[1], start_.v[2]), gm_fma((a_ * p_.p[26]), (m_.v[1] - m_.v[2]), start_.v[3]), gm_fma(a_, m_.v[2], start_.v[4])}};
}

/* estimation/process_model.py:785 _four_along */
GM_INLINE tuple_8 process_model_four_along(tuple_8 start_, real a_, tuple_8 m_, tuple_9 r_, array1_f8 p_)
{
    tuple_4 t1 = process_model_along(start_.v[0], a_, m_.v[0], r_.v[0], p_);
    tuple_4 t2 = process_model_along(start_.v[1], a_, m_.v[1], r_.v[1], p_);
    tuple_4 t3 = process_model_along(start_.v[2], a_, m_.v[2], r_.v[2], p_);
    tuple_4 t4 = process_model_along(start_.v[3], a_, m_.v[3], r_.v[3], p_);
    return (tuple_8){{t1, t2, t3, t4}};
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end(Layout layout_, array1_f8 phi_, int64_t j_, real h_, tuple_8 m_, tuple_9 r_, array1_f8 p_)
{
    int64_t n_;
    bool loaded_;
    real moved1_;
    real moved2_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[(((0 * n_) + j_))] = (m_.v[0].v[0] + moved1_);
    phi_.p[(((1 * n_) + j_))] = (m_.v[0].v[4] + moved2_);
    phi_.p[(((2 * n_) + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[(((3 * n_) + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[(((4 * n_) + j_))] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:854 _source */
GM_INLINE real process_model_source(tuple_4 bend_, real memory_, int64_t own_)
{
    return ((((bend_.v[1] * memory_) + (((own_ == 2)) ? bend_.v[2] : (real)0.0)) + (((own_ == 3)) ? bend_.v[3] : (real)0.0)) + (((own_ == 4)) ? bend_.v[4] : (real)0.0));
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column(Layout layout_, array1_f8 phi_, int64_t j_, Stages stages_, tuple_5 errors_, tuple_3 sources_, array1_f8 p_)
{
    bool loaded_;
    int64_t curve_;
    tuple_5 slopes_;
    tuple_5 shares_;
    tuple_9 arms_;
    tuple_8 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_4 m1_;
    tuple_4 c1_;
    tuple_3 r1_;
    tuple_4 m2_;
    tuple_4 c2_;
    tuple_3 r2_;
    tuple_4 m3_;
    tuple_4 c3_;
    tuple_3 r3_;
    tuple_4 m4_;
    tuple_4 c4_;
    tuple_3 r4_;
    loaded_ = layout_.loaded_;
    curve_ = layout_.curve_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row(layout_, phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_4 t3 = process_model_begin(layout_.n_, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_4 t5 = process_model_bent(curve_, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(loaded_, arms_.v[0], load_, m1_);
    tuple_3 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_4 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_4 t10 = process_model_bent(curve_, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(loaded_, arms_.v[1], load_, m2_);
    tuple_3 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_4 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_4 t15 = process_model_bent(curve_, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(loaded_, arms_.v[2], load_, m3_);
    tuple_3 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_4 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_4 t20 = process_model_bent(curve_, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(loaded_, arms_.v[3], load_, m4_);
    tuple_3 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end(layout_, phi_, j_, h_, (tuple_8){{m1_, m2_, m3_, m4_}}, (tuple_9){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2(Layout layout_, array1_f8 phi_, Stages stages_, array1_f8 p_)
{
    int64_t n_;
    int64_t i_;
    n_ = layout_.n_;
    if ((layout_.loaded_ || ((layout_.curve_ >= 0)))) {
        process_model_column(layout_, phi_, 1, stages_, (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}}, (tuple_3){{(real)0.0, (real)0.0}}, p_);
    } else {
        if (stages_.first_) {
            for (int64_t k1 = 0; k1 < n_; k1 += 1) {
                i_ = k1;
                phi_.p[(((i_ * n_) + 1))] = (((i_ == 1)) ? (real)1.0 : (real)0.0);
            }
        }
    }
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row_2(Layout layout_, array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t n_;
    int64_t count_;
    int64_t t1 = process_model_curve_count(layout_.curve_);
    n_ = layout_.n_;
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (n_ - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((n_ - count_) * n_) + j_), phi_.n[0])];
}

/* estimation/process_model.py:791 _begin */
GM_INLINE tuple_4 process_model_begin_2(int64_t n_, array1_f8 phi_, int64_t j_, bool first_)
{
    if (first_) {
        return (tuple_4){{(((j_ == 0)) ? (real)1.0 : (real)0.0), (((j_ == 2)) ? (real)1.0 : (real)0.0), (((j_ == 3)) ? (real)1.0 : (real)0.0), (((j_ == 4)) ? (real)1.0 : (real)0.0), (((j_ == 1)) ? (real)1.0 : (real)0.0)}};
    }
    return (tuple_4){{phi_.p[gm_at(((0 * n_) + j_), phi_.n[0])], phi_.p[gm_at(((2 * n_) + j_), phi_.n[0])], phi_.p[gm_at(((3 * n_) + j_), phi_.n[0])], phi_.p[gm_at(((4 * n_) + j_), phi_.n[0])], phi_.p[gm_at(((1 * n_) + j_), phi_.n[0])]}};
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_2(Layout layout_, array1_f8 phi_, int64_t j_, real h_, tuple_8 m_, tuple_9 r_, array1_f8 p_)
{
    int64_t n_;
    bool loaded_;
    real moved1_;
    real moved2_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[gm_at(((0 * n_) + j_), phi_.n[0])] = (m_.v[0].v[0] + moved1_);
    phi_.p[gm_at(((1 * n_) + j_), phi_.n[0])] = (m_.v[0].v[4] + moved2_);
    phi_.p[gm_at(((2 * n_) + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[gm_at(((3 * n_) + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[gm_at(((4 * n_) + j_), phi_.n[0])] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_2(Layout layout_, array1_f8 phi_, int64_t j_, Stages stages_, tuple_5 errors_, tuple_3 sources_, array1_f8 p_)
{
    bool loaded_;
    int64_t curve_;
    tuple_5 slopes_;
    tuple_5 shares_;
    tuple_9 arms_;
    tuple_8 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_4 m1_;
    tuple_4 c1_;
    tuple_3 r1_;
    tuple_4 m2_;
    tuple_4 c2_;
    tuple_3 r2_;
    tuple_4 m3_;
    tuple_4 c3_;
    tuple_3 r3_;
    tuple_4 m4_;
    tuple_4 c4_;
    tuple_3 r4_;
    loaded_ = layout_.loaded_;
    curve_ = layout_.curve_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_2(layout_, phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_4 t3 = process_model_begin_2(layout_.n_, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_4 t5 = process_model_bent(curve_, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(loaded_, arms_.v[0], load_, m1_);
    tuple_3 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_4 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_4 t10 = process_model_bent(curve_, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(loaded_, arms_.v[1], load_, m2_);
    tuple_3 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_4 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_4 t15 = process_model_bent(curve_, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(loaded_, arms_.v[2], load_, m3_);
    tuple_3 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_4 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_4 t20 = process_model_bent(curve_, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(loaded_, arms_.v[3], load_, m4_);
    tuple_3 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_2(layout_, phi_, j_, h_, (tuple_8){{m1_, m2_, m3_, m4_}}, (tuple_9){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:995 _columns_of_curve */
GM_INLINE void process_model_columns_of_curve(Layout layout_, array1_f8 z_, array1_f8 phi_, real memory_, tuple_5 law_, Stages stages_, array1_f8 p_)
{
    int64_t n_;
    int64_t count_;
    int64_t at_;
    tuple_5 none_;
    real width_;
    real end_;
    int64_t j_;
    int64_t t1 = process_model_curve_count(layout_.curve_);
    n_ = layout_.n_;
    count_ = t1;
    int64_t t2 = (n_ - count_);
    at_ = t2;
    none_ = (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((count_ > 0))) {
        process_model_column_2(layout_, phi_, (at_ + 0), stages_, none_, (tuple_3){{(real)0.0, (real)0.0}}, p_);
    }
    if (((count_ > 1))) {
        process_model_column_2(layout_, phi_, (at_ + 1), stages_, none_, (tuple_3){{(real)0.0, (real)2.0}}, p_);
        process_model_column_2(layout_, phi_, (at_ + 2), stages_, none_, (tuple_3){{(real)0.0, (real)3.0}}, p_);
        process_model_column_2(layout_, phi_, (at_ + 3), stages_, none_, (tuple_3){{(real)0.0, (real)4.0}}, p_);
    }
    if (((count_ > 0))) {
        width_ = (gm_fabs(law_.v[2]) / law_.v[0]);
        tuple_3 t3 = transmission_play((z_.p[0] - z_.p[1]), memory_, width_);
        z_.p[gm_at((at_ + 0), z_.n[0])] = t3.v[0];
        end_ = t3.v[1];
        if (((end_ != (real)0.0))) {
            for (int64_t k4 = 0; k4 < n_; k4 += 1) {
                j_ = k4;
                phi_.p[gm_at((((at_ + 0) * n_) + j_), phi_.n[0])] = (phi_.p[(((0 * n_) + j_))] - phi_.p[(((1 * n_) + j_))]);
            }
            if (((count_ > 1))) {
                phi_.p[gm_at(((((at_ + 0) * n_) + at_) + 1), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * n_) + at_) + 1), phi_.n[0])] + ((end_ * width_) / law_.v[0]));
                phi_.p[gm_at(((((at_ + 0) * n_) + at_) + 3), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * n_) + at_) + 3), phi_.n[0])] - ((((law_.v[2] >= (real)0.0)) ? end_ : (-end_)) / law_.v[0]));
            }
        }
    }
    return;
}

/* estimation/process_model.py:883 rk4 */
GM_INLINE void process_model_rk4(Layout layout_, array1_f8 z_, array1_f8 phi_, bool first_, tuple_3 torques_, real h_, array1_f8 p_)
{
    int64_t n_;
    bool loaded_;
    int64_t curve_;
    real u_;
    real load_;
    real half_;
    real sixth_;
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    real tau_k_;
    int64_t at_curve_;
    tuple_5 law_;
    real memory_;
    tuple_5 rows_;
    tuple_4 error_;
    tuple_8 m1_;
    real total_;
    tuple_4 bend1_;
    real slope1_;
    real share1_;
    tuple_3 arm1_;
    real f1_;
    real g1_;
    tuple_9 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_4 bend2_;
    real slope2_;
    real share2_;
    tuple_3 arm2_;
    real f2_;
    real g2_;
    tuple_8 m2_;
    tuple_9 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_4 bend3_;
    real slope3_;
    real share3_;
    tuple_3 arm3_;
    real f3_;
    real g3_;
    tuple_8 m3_;
    tuple_9 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_4 bend4_;
    real slope4_;
    real share4_;
    tuple_3 arm4_;
    real f4_;
    real g4_;
    tuple_8 m4_;
    tuple_9 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
    int64_t i_;
    int64_t j_;
    tuple_5 none_;
    tuple_4 fades_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    curve_ = layout_.curve_;
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    real t1 = ((real)0.5 * h_);
    real t2 = (h_ / (real)6.0);
    half_ = t1;
    sixth_ = t2;
    real t3 = z_.p[0];
    real t4 = z_.p[1];
    real t5 = z_.p[2];
    real t6 = z_.p[3];
    real t7 = z_.p[4];
    x1_ = t3;
    x2_ = t4;
    x3_ = t5;
    x4_ = t6;
    tau_k_ = t7;
    int64_t t8 = process_model_curve_count(curve_);
    at_curve_ = (n_ - t8);
    tuple_5 t9 = process_model_curve(curve_, z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory(curve_, z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row(layout_, phi_, 0, first_);
    real t12 = process_model_memory_row(layout_, phi_, 2, first_);
    real t13 = process_model_memory_row(layout_, phi_, 3, first_);
    real t14 = process_model_memory_row(layout_, phi_, 4, first_);
    rows_ = (tuple_5){{t11, t12, t13, t14}};
    error_ = (tuple_4){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((n_ > 5))) {
        if (((p_.p[28] > (real)0.0))) {
            load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
        }
        if (((p_.p[29] > (real)0.0))) {
            tuple_4 t15 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], half_, h_, p_);
            error_ = t15;
        }
    }
    tuple_4 t16 = process_model_begin(n_, phi_, 0, first_);
    tuple_4 t17 = process_model_begin(n_, phi_, 2, first_);
    tuple_4 t18 = process_model_begin(n_, phi_, 3, first_);
    tuple_4 t19 = process_model_begin(n_, phi_, 4, first_);
    m1_ = (tuple_8){{t16, t17, t18, t19}};
    tuple_7 t20 = process_model_total(curve_, (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t20.f0;
    bend1_ = t20.f1;
    tuple_3 t21 = process_model_slopes(layout_.law_, x3_, total_, p_);
    slope1_ = t21.v[0];
    share1_ = t21.v[1];
    tuple_3 t22 = process_model_load_slopes(loaded_, x2_, x4_, p_);
    arm1_ = t22;
    tuple_3 t23 = process_model_accelerations(layout_, (tuple_4){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t23.v[0];
    g1_ = t23.v[1];
    tuple_8 t24 = process_model_four_bent(curve_, bend1_, rows_, m1_);
    tuple_9 t25 = process_model_four_rates(loaded_, t24, slope1_, share1_, arm1_, p_);
    r1_ = t25;
    real t26 = (x2_ + (half_ * x4_));
    real t27 = (x3_ + (half_ * f1_));
    real t28 = (x4_ + (half_ * g1_));
    y2_ = t26;
    y3_ = t27;
    y4_ = t28;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_7 t29 = process_model_total(curve_, ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t29.f0;
    bend2_ = t29.f1;
    tuple_3 t30 = process_model_slopes(layout_.law_, y3_, total_, p_);
    slope2_ = t30.v[0];
    share2_ = t30.v[1];
    tuple_3 t31 = process_model_load_slopes(loaded_, y2_, y4_, p_);
    arm2_ = t31;
    tuple_3 t32 = process_model_accelerations(layout_, (tuple_4){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t32.v[0];
    g2_ = t32.v[1];
    tuple_8 t33 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t33;
    tuple_8 t34 = process_model_four_bent(curve_, bend2_, rows_, m2_);
    tuple_9 t35 = process_model_four_rates(loaded_, t34, slope2_, share2_, arm2_, p_);
    r2_ = t35;
    real t36 = (x2_ + (half_ * y4_));
    real t37 = (x3_ + (half_ * f2_));
    real t38 = (x4_ + (half_ * g2_));
    v2_ = t36;
    v3_ = t37;
    v4_ = t38;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_7 t39 = process_model_total(curve_, ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t39.f0;
    bend3_ = t39.f1;
    tuple_3 t40 = process_model_slopes(layout_.law_, v3_, total_, p_);
    slope3_ = t40.v[0];
    share3_ = t40.v[1];
    tuple_3 t41 = process_model_load_slopes(loaded_, v2_, v4_, p_);
    arm3_ = t41;
    tuple_3 t42 = process_model_accelerations(layout_, (tuple_4){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t42.v[0];
    g3_ = t42.v[1];
    tuple_8 t43 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t43;
    tuple_8 t44 = process_model_four_bent(curve_, bend3_, rows_, m3_);
    tuple_9 t45 = process_model_four_rates(loaded_, t44, slope3_, share3_, arm3_, p_);
    r3_ = t45;
    real t46 = (x2_ + (h_ * v4_));
    real t47 = (x3_ + (h_ * f3_));
    real t48 = (x4_ + (h_ * g3_));
    w2_ = t46;
    w3_ = t47;
    w4_ = t48;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_7 t49 = process_model_total(curve_, ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t49.f0;
    bend4_ = t49.f1;
    tuple_3 t50 = process_model_slopes(layout_.law_, w3_, total_, p_);
    slope4_ = t50.v[0];
    share4_ = t50.v[1];
    tuple_3 t51 = process_model_load_slopes(loaded_, w2_, w4_, p_);
    arm4_ = t51;
    tuple_3 t52 = process_model_accelerations(layout_, (tuple_4){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t52.v[0];
    g4_ = t52.v[1];
    tuple_8 t53 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t53;
    tuple_8 t54 = process_model_four_bent(curve_, bend4_, rows_, m4_);
    tuple_9 t55 = process_model_four_rates(loaded_, t54, slope4_, share4_, arm4_, p_);
    r4_ = t55;
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (y3_ + v3_))) + w3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (y4_ + v4_))) + w4_));
    real t56 = (x1_ + moved1_);
    real t57 = (x2_ + moved2_);
    z_.p[0] = t56;
    z_.p[1] = t57;
    z_.p[2] = (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_)));
    z_.p[3] = (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_)));
    z_.p[4] = (tau_k_ + (p_.p[26] * (moved1_ - moved2_)));
    process_model_end(layout_, phi_, 0, h_, (tuple_8){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_9){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_);
    process_model_end(layout_, phi_, 2, h_, (tuple_8){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_9){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_);
    process_model_end(layout_, phi_, 3, h_, (tuple_8){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_9){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_);
    process_model_end(layout_, phi_, 4, h_, (tuple_8){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_9){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_);
    stages_ = (Stages){(tuple_5){{slope1_, slope2_, slope3_, slope4_}}, (tuple_5){{share1_, share2_, share3_, share4_}}, (tuple_9){{arm1_, arm2_, arm3_, arm4_}}, (tuple_8){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2(layout_, phi_, stages_, p_);
    if (((n_ > 5))) {
        if (first_) {
            for (int64_t k58 = 5; k58 < n_; k58 += 1) {
                i_ = k58;
                for (int64_t k59 = 0; k59 < n_; k59 += 1) {
                    j_ = k59;
                    phi_.p[gm_at(((i_ * n_) + j_), phi_.n[0])] = (((i_ == j_)) ? (real)1.0 : (real)0.0);
                }
            }
        }
        none_ = (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        if (((p_.p[28] > (real)0.0))) {
            process_model_column_2(layout_, phi_, (int64_t)(p_.p[28]), stages_, none_, (tuple_3){{(real)1.0, (real)0.0}}, p_);
        }
        if (((p_.p[29] > (real)0.0))) {
            i_ = (int64_t)(p_.p[29]);
            z_.p[gm_at(i_, z_.n[0])] = error_.v[4];
            tuple_4 t60 = process_model_decay(phi_.p[gm_at(((i_ * n_) + i_), phi_.n[0])], half_, h_, p_);
            fades_ = t60;
            process_model_column_2(layout_, phi_, i_, stages_, (tuple_5){{fades_.v[0], fades_.v[1], fades_.v[2], fades_.v[3]}}, (tuple_3){{(real)0.0, (real)0.0}}, p_);
            phi_.p[gm_at(((i_ * n_) + i_), phi_.n[0])] = fades_.v[4];
        }
        process_model_columns_of_curve(layout_, z_, phi_, memory_, law_, stages_, p_);
    }
    return;
}

/* estimation/process_model.py:1018 propagate */
GM_INLINE void process_model_propagate(Layout layout_, array1_f8 z_, array1_f8 phi_, tuple_3 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (((n_substeps_ > 1)) ? (dt_ / (real)(n_substeps_)) : dt_);
    process_model_rk4(layout_, z_, phi_, true, torques_, h_, p_);
    for (int64_t k1 = 1; k1 < n_substeps_; k1 += 1) {
        process_model_rk4(layout_, z_, phi_, false, torques_, h_, p_);
    }
    return;
}

/* kernels/linalg.py:172 _moves */
GM_INLINE bool linalg_moves(int64_t i_, int64_t memory_)
{
    return (((i_ < 4)) || ((4 < i_) && (i_ <= memory_)));
}

/* kernels/linalg.py:178 _fused */
GM_INLINE tuple_10 linalg_fused(int64_t n_, real v_, array1_f8 b_, int64_t at_, tuple_10 row_)
{
    return (tuple_10){{gm_fma(v_, b_.p[(at_)], row_.v[0]), gm_fma(v_, b_.p[((at_ + 1))], row_.v[1]), gm_fma(v_, b_.p[((at_ + 2))], row_.v[2]), gm_fma(v_, b_.p[((at_ + 3))], row_.v[3]), gm_fma(v_, b_.p[((at_ + 4))], row_.v[4]), (((n_ > 5)) ? gm_fma(v_, b_.p[((at_ + 5))], row_.v[5]) : (real)0.0), (((n_ > 6)) ? gm_fma(v_, b_.p[((at_ + 6))], row_.v[6]) : (real)0.0), (((n_ > 7)) ? gm_fma(v_, b_.p[((at_ + 7))], row_.v[7]) : (real)0.0), (((n_ > 8)) ? gm_fma(v_, b_.p[((at_ + 8))], row_.v[8]) : (real)0.0), (((n_ > 9)) ? gm_fma(v_, b_.p[((at_ + 9))], row_.v[9]) : (real)0.0), (((n_ > 10)) ? gm_fma(v_, b_.p[((at_ + 10))], row_.v[10]) : (real)0.0)}};
}

/* kernels/linalg.py:252 _put */
GM_INLINE void linalg_put(int64_t n_, tuple_10 row_, array1_f8 out_, int64_t at_)
{
    out_.p[(at_)] = row_.v[0];
    out_.p[((at_ + 1))] = row_.v[1];
    out_.p[((at_ + 2))] = row_.v[2];
    out_.p[((at_ + 3))] = row_.v[3];
    out_.p[((at_ + 4))] = row_.v[4];
    if (((n_ > 5))) {
        out_.p[((at_ + 5))] = row_.v[5];
    }
    if (((n_ > 6))) {
        out_.p[((at_ + 6))] = row_.v[6];
    }
    if (((n_ > 7))) {
        out_.p[((at_ + 7))] = row_.v[7];
    }
    if (((n_ > 8))) {
        out_.p[((at_ + 8))] = row_.v[8];
    }
    if (((n_ > 9))) {
        out_.p[((at_ + 9))] = row_.v[9];
    }
    if (((n_ > 10))) {
        out_.p[((at_ + 10))] = row_.v[10];
    }
    return;
}

/* kernels/linalg.py:212 _weighted */
GM_INLINE tuple_10 linalg_weighted(int64_t n_, array1_f8 phi_, int64_t at_, array1_f8 half_, tuple_10 row_)
{
    return (tuple_10){{gm_fma(phi_.p[(at_)], half_.p[0], row_.v[0]), gm_fma(phi_.p[((at_ + 1))], half_.p[1], row_.v[1]), gm_fma(phi_.p[((at_ + 2))], half_.p[2], row_.v[2]), gm_fma(phi_.p[((at_ + 3))], half_.p[3], row_.v[3]), gm_fma(phi_.p[((at_ + 4))], half_.p[4], row_.v[4]), (((n_ > 5)) ? gm_fma(phi_.p[((at_ + 5))], half_.p[5], row_.v[5]) : (real)0.0), (((n_ > 6)) ? gm_fma(phi_.p[((at_ + 6))], half_.p[6], row_.v[6]) : (real)0.0), (((n_ > 7)) ? gm_fma(phi_.p[((at_ + 7))], half_.p[7], row_.v[7]) : (real)0.0), (((n_ > 8)) ? gm_fma(phi_.p[((at_ + 8))], half_.p[8], row_.v[8]) : (real)0.0), (((n_ > 9)) ? gm_fma(phi_.p[((at_ + 9))], half_.p[9], row_.v[9]) : (real)0.0), (((n_ > 10)) ? gm_fma(phi_.p[((at_ + 10))], half_.p[10], row_.v[10]) : (real)0.0)}};
}

/* kernels/linalg.py:229 _product */
GM_INLINE real linalg_product(int64_t n_, tuple_10 row_, array1_f8 b_, int64_t at_)
{
    real value_;
    value_ = (row_.v[0] * b_.p[(at_)]);
    value_ = gm_fma(row_.v[1], b_.p[((at_ + 1))], value_);
    value_ = gm_fma(row_.v[2], b_.p[((at_ + 2))], value_);
    value_ = gm_fma(row_.v[3], b_.p[((at_ + 3))], value_);
    value_ = gm_fma(row_.v[4], b_.p[((at_ + 4))], value_);
    if (((n_ > 5))) {
        value_ = gm_fma(row_.v[5], b_.p[((at_ + 5))], value_);
    }
    if (((n_ > 6))) {
        value_ = gm_fma(row_.v[6], b_.p[((at_ + 6))], value_);
    }
    if (((n_ > 7))) {
        value_ = gm_fma(row_.v[7], b_.p[((at_ + 7))], value_);
    }
    if (((n_ > 8))) {
        value_ = gm_fma(row_.v[8], b_.p[((at_ + 8))], value_);
    }
    if (((n_ > 9))) {
        value_ = gm_fma(row_.v[9], b_.p[((at_ + 9))], value_);
    }
    if (((n_ > 10))) {
        value_ = gm_fma(row_.v[10], b_.p[((at_ + 10))], value_);
    }
    return value_;
}

/* kernels/linalg.py:274 _mirrored */
GM_INLINE void linalg_mirrored(array1_f8 out_, int64_t n_, int64_t i_, int64_t j_, real value_)
{
    if (((j_ <= i_))) {
        out_.p[(((i_ * n_) + j_))] = value_;
        out_.p[(((j_ * n_) + i_))] = value_;
    }
    return;
}

/* kernels/linalg.py:141 _carry_curve */
GM_INLINE void linalg_carry_curve(int64_t curve_, int64_t n_, array1_f8 phi_, array1_f8 P_, array1_f8 half_, array1_f8 cross_, array1_f8 out_)
{
    int64_t memory_;
    int64_t i_;
    int64_t j_;
    int64_t at_;
    tuple_10 row_;
    int64_t k_;
    memory_ = (n_ - curve_);
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        bool t2 = linalg_moves(i_, memory_);
        if ((!t2)) {
            for (int64_t k3 = 0; k3 < n_; k3 += 1) {
                j_ = k3;
                real t4 = P_.p[(((i_ * n_) + j_))];
                cross_.p[(((i_ * n_) + j_))] = t4;
                out_.p[(((i_ * n_) + j_))] = t4;
            }
            out_.p[(((i_ * n_) + i_))] = (out_.p[(((i_ * n_) + i_))] + half_.p[(i_)]);
        }
    }
    for (int64_t k5 = 0; k5 < n_; k5 += 1) {
        i_ = k5;
        bool t6 = linalg_moves(i_, memory_);
        if (t6) {
            at_ = (i_ * n_);
            row_ = (tuple_10){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
            for (int64_t k7 = 0; k7 < n_; k7 += 1) {
                k_ = k7;
                tuple_10 t8 = linalg_fused(n_, phi_.p[((at_ + k_))], P_, (k_ * n_), row_);
                row_ = t8;
            }
            linalg_put(n_, row_, cross_, at_);
            tuple_10 t9 = linalg_weighted(n_, phi_, at_, half_, row_);
            row_ = t9;
            linalg_put(n_, row_, out_, at_);
            for (int64_t k10 = 0; k10 < n_; k10 += 1) {
                j_ = k10;
                bool t11 = linalg_moves(j_, memory_);
                if ((!t11)) {
                    out_.p[(((j_ * n_) + i_))] = out_.p[((at_ + j_))];
                } else {
                    if (((j_ <= i_))) {
                        int64_t t13 = i_;
                        int64_t t14 = j_;
                        real t12 = linalg_product(n_, row_, phi_, (j_ * n_));
                        linalg_mirrored(out_, n_, t13, t14, t12);
                    }
                }
            }
        }
    }
    return;
}

/* kernels/linalg.py:49 _row */
GM_INLINE tuple_11 linalg_row(int64_t n_, int64_t unit_, array1_f8 a_, int64_t i_, array1_f8 b_)
{
    real s0_;
    real s1_;
    real s2_;
    real s3_;
    real s4_;
    real s5_;
    real s6_;
    int64_t k_;
    real v_;
    int64_t at_;
    s0_ = (real)0.0;
    s1_ = (real)0.0;
    s2_ = (real)0.0;
    s3_ = (real)0.0;
    s4_ = (real)0.0;
    s5_ = (real)0.0;
    s6_ = (real)0.0;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        k_ = k1;
        real t2 = a_.p[(((i_ * n_) + k_))];
        int64_t t3 = (k_ * n_);
        v_ = t2;
        at_ = t3;
        if ((((k_ != unit_)) || ((i_ == unit_)))) {
            s0_ = gm_fma(v_, b_.p[(at_)], s0_);
            s1_ = gm_fma(v_, b_.p[((at_ + 1))], s1_);
            s2_ = gm_fma(v_, b_.p[((at_ + 2))], s2_);
            s3_ = gm_fma(v_, b_.p[((at_ + 3))], s3_);
            s4_ = gm_fma(v_, b_.p[((at_ + 4))], s4_);
            if (((n_ > 5))) {
                s5_ = gm_fma(v_, b_.p[((at_ + 5))], s5_);
            }
            if (((n_ > 6))) {
                s6_ = gm_fma(v_, b_.p[((at_ + 6))], s6_);
            }
        }
    }
    return (tuple_11){{s0_, s1_, s2_, s3_, s4_, s5_, s6_}};
}

/* kernels/linalg.py:100 carry */
GM_INLINE void linalg_carry(Layout layout_, array1_f8 phi_, array1_f8 P_, array1_f8 half_, array1_f8 cross_, array1_f8 out_)
{
    int64_t n_;
    bool full_;
    int64_t i_;
    real s0_;
    real s1_;
    real s2_;
    real s3_;
    real s4_;
    real s5_;
    real s6_;
    int64_t at_;
    int64_t j_;
    real value_;
    n_ = layout_.n_;
    if ((((layout_.curve_ >= 0)) && ((n_ > 5)))) {
        linalg_carry_curve(layout_.curve_, n_, phi_, P_, half_, cross_, out_);
        return;
    }
    full_ = (layout_.loaded_ || ((layout_.curve_ >= 0)));
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        tuple_11 t2 = linalg_row(n_, (full_ ? (-1) : 1), phi_, i_, P_);
        s0_ = t2.v[0];
        s1_ = t2.v[1];
        s2_ = t2.v[2];
        s3_ = t2.v[3];
        s4_ = t2.v[4];
        s5_ = t2.v[5];
        s6_ = t2.v[6];
        at_ = (i_ * n_);
        real t3 = s0_;
        real t4 = s1_;
        real t5 = s2_;
        real t6 = s3_;
        cross_.p[(at_)] = t3;
        cross_.p[((at_ + 1))] = t4;
        cross_.p[((at_ + 2))] = t5;
        cross_.p[((at_ + 3))] = t6;
        cross_.p[((at_ + 4))] = s4_;
        real t7 = gm_fma(phi_.p[(at_)], half_.p[0], s0_);
        real t8 = gm_fma(phi_.p[((at_ + 1))], half_.p[1], s1_);
        s0_ = t7;
        s1_ = t8;
        real t9 = gm_fma(phi_.p[((at_ + 2))], half_.p[2], s2_);
        real t10 = gm_fma(phi_.p[((at_ + 3))], half_.p[3], s3_);
        s2_ = t9;
        s3_ = t10;
        s4_ = gm_fma(phi_.p[((at_ + 4))], half_.p[4], s4_);
        if (((n_ > 5))) {
            cross_.p[((at_ + 5))] = s5_;
            s5_ = gm_fma(phi_.p[((at_ + 5))], half_.p[5], s5_);
        }
        if (((n_ > 6))) {
            cross_.p[((at_ + 6))] = s6_;
            s6_ = gm_fma(phi_.p[((at_ + 6))], half_.p[6], s6_);
        }
        for (int64_t k11 = 0; k11 < n_; k11 += 1) {
            j_ = k11;
            at_ = (j_ * n_);
            value_ = (s0_ * phi_.p[(at_)]);
            if ((full_ || ((j_ == 1)))) {
                value_ = gm_fma(s1_, phi_.p[((at_ + 1))], value_);
            }
            value_ = gm_fma(s4_, phi_.p[((at_ + 4))], gm_fma(s3_, phi_.p[((at_ + 3))], gm_fma(s2_, phi_.p[((at_ + 2))], value_)));
            if (((n_ > 5))) {
                value_ = gm_fma(s5_, phi_.p[((at_ + 5))], value_);
            }
            if (((n_ > 6))) {
                value_ = gm_fma(s6_, phi_.p[((at_ + 6))], value_);
            }
            linalg_mirrored(out_, n_, i_, j_, value_);
        }
    }
    return;
}

/* estimation/filters/ekf.py:56 predict */
GM_INLINE void ekf_predict(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    int64_t n_;
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    int64_t at_z_;
    int64_t at_P_;
    int64_t at_cross_;
    array1_f8 phi_;
    array1_f8 cross_;
    array1_f8 P_pred_;
    int64_t i_;
    int64_t counted_;
    real motor_;
    real arm_;
    n_ = layout_.n_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    tuple_2 t1 = step_record_places(n_);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    phi_ = (array1_f8){scratch_.matrices_.p + 0 * (scratch_.matrices_.n[1]), {scratch_.matrices_.n[1]}};
    int64_t t2 = (at_cross_ + (n_ * n_));
    int64_t t3 = gm_bound(at_cross_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = (at_P_ + (n_ * n_));
    int64_t t7 = gm_bound(at_P_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    cross_ = (array1_f8){record_.p + t3 * (1), {t5}};
    P_pred_ = (array1_f8){record_.p + t7 * (1), {t9}};
    for (int64_t k10 = 0; k10 < n_; k10 += 1) {
        i_ = k10;
        real t12 = ((real)0.5 * dt_);
        real t11 = process_model_noise(z_, p_, i_);
        record_.p[((at_z_ + i_))] = (t12 * t11);
    }
    int64_t t13 = drive_substeps(dt_, p_.p[30]);
    counted_ = t13;
    real t14 = p_.p[5];
    real t15 = p_.p[15];
    motor_ = t14;
    arm_ = t15;
    if (((p_.p[37] > (real)0.0))) {
        real t16 = process_model_softened_sharpness(motor_, P_.p[(((2 * n_) + 2))]);
        p_.p[5] = t16;
        real t17 = process_model_softened_sharpness(arm_, P_.p[(((3 * n_) + 3))]);
        p_.p[15] = t17;
    }
    if (((p_.p[36] > (real)0.0))) {
        process_model_propagate_numeric(layout_, z_, phi_, (tuple_3){{reading_.u_, reading_.load_}}, dt_, counted_, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}});
    } else {
        process_model_propagate(layout_, z_, phi_, (tuple_3){{reading_.u_, reading_.load_}}, dt_, counted_, p_);
    }
    if (((p_.p[37] > (real)0.0))) {
        p_.p[5] = motor_;
        p_.p[15] = arm_;
    }
    int64_t t18 = (at_z_ + n_);
    int64_t t19 = gm_bound(at_z_, record_.n[0]);
    int64_t t20 = gm_bound(t18, record_.n[0]);
    int64_t t21 = gm_span(t19, t20);
    linalg_carry(layout_, phi_, P_, (array1_f8){record_.p + t19 * (1), {t21}}, cross_, P_pred_);
    for (int64_t k22 = 0; k22 < n_; k22 += 1) {
        i_ = k22;
        real t25 = P_pred_.p[(((i_ * n_) + i_))];
        real t24 = ((real)0.5 * dt_);
        real t23 = process_model_noise(z_, p_, i_);
        P_pred_.p[(((i_ * n_) + i_))] = (t25 + (t24 * t23));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    return;
}

/* estimation/filters/ekf.py:153 inverse */
GM_INLINE tuple_12 ekf_inverse(real s11_, real s12_, real s22_, real determinant_)
{
    real scale_;
    scale_ = ((real)1.0 / determinant_);
    return (tuple_12){{(s22_ * scale_), ((-s12_) * scale_), (s11_ * scale_)}};
}

/* estimation/filters/ekf.py:160 mahalanobis */
GM_INLINE real ekf_mahalanobis(real e1_, real e2_, real i11_, real i12_, real i22_)
{
    return ((e1_ * ((i11_ * e1_) + (i12_ * e2_))) + (e2_ * ((i12_ * e1_) + (i22_ * e2_))));
}

/* estimation/filters/ekf.py:169 joseph */
GM_INLINE tuple_5 ekf_joseph(int64_t i_, tuple_3 gain_, tuple_3 column_, tuple_12 prior_, tuple_3 r_)
{
    real a_;
    real b_;
    real t1_;
    real t2_;
    real t1 = ((((i_ == 0)) ? (real)1.0 : (real)0.0) - gain_.v[0]);
    real t2 = ((((i_ == 1)) ? (real)1.0 : (real)0.0) - gain_.v[1]);
    a_ = t1;
    b_ = t2;
    t1_ = (((((i_ > 1)) ? column_.v[0] : (real)(-0.0)) + (a_ * prior_.v[0])) + (b_ * prior_.v[1]));
    t2_ = (((((i_ > 1)) ? column_.v[1] : (real)(-0.0)) + (a_ * prior_.v[1])) + (b_ * prior_.v[2]));
    return (tuple_5){{a_, b_, ((gain_.v[0] * r_.v[0]) - t1_), ((gain_.v[1] * r_.v[1]) - t2_)}};
}

/* estimation/filters/ekf.py:191 joseph_element */
GM_INLINE real ekf_joseph_element(int64_t i_, real prior_, tuple_5 row_, tuple_3 column_j_, tuple_3 gain_)
{
    real predicted_;
    predicted_ = gm_fma(row_.v[1], column_j_.v[1], gm_fma(row_.v[0], column_j_.v[0], (((i_ > 1)) ? prior_ : (real)(-0.0))));
    return gm_fma(row_.v[3], gain_.v[1], gm_fma(row_.v[2], gain_.v[0], predicted_));
}

/* estimation/filters/ekf.py:88 update */
GM_INLINE bool ekf_update(Layout layout_, Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
    int64_t n_;
    array1_f8 z_;
    array1_f8 P_;
    int64_t at_prior_;
    int64_t at_z_;
    int64_t at_P_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t at_K_;
    int64_t at_scores_;
    array1_f8 prior_;
    real r1_;
    real r2_;
    bool have1_;
    bool have2_;
    real s11_;
    real s12_;
    real s22_;
    real i11_;
    real i12_;
    real i22_;
    real determinant_;
    real e1_;
    real e2_;
    real dof_;
    real nis_;
    int64_t i_;
    real c1_;
    real c2_;
    real k1_;
    real k2_;
    tuple_5 row_;
    int64_t j_;
    real value_;
    n_ = layout_.n_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_2 t1 = step_record_places(n_);
    at_prior_ = t1.v[1];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    at_K_ = t1.v[7];
    at_scores_ = t1.v[8];
    int64_t t2 = (at_prior_ + (n_ * n_));
    int64_t t3 = gm_bound(at_prior_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    prior_ = (array1_f8){record_.p + t3 * (1), {t5}};
    real t6 = p_.p[31];
    real t7 = p_.p[32];
    r1_ = t6;
    r2_ = t7;
    bool t8 = (bool)isfinite(y1_);
    bool t9 = (bool)isfinite(y2_);
    have1_ = t8;
    have2_ = t9;
    real t10 = (prior_.p[0] + r1_);
    real t11 = prior_.p[1];
    real t12 = (prior_.p[((n_ + 1))] + r2_);
    s11_ = t10;
    s12_ = t11;
    s22_ = t12;
    record_.p[(at_S_)] = s11_;
    record_.p[((at_S_ + 1))] = s12_;
    record_.p[((at_S_ + 2))] = s22_;
    record_.p[(at_innovation_)] = (have1_ ? (y1_ - z_.p[0]) : NAN);
    record_.p[((at_innovation_ + 1))] = (have2_ ? (y2_ - z_.p[1]) : NAN);
    i11_ = (real)0.0;
    i12_ = (real)0.0;
    i22_ = (real)0.0;
    determinant_ = (real)1.0;
    if ((have1_ && have2_)) {
        determinant_ = ((s11_ * s22_) - (s12_ * s12_));
        tuple_12 t13 = ekf_inverse(s11_, s12_, s22_, determinant_);
        i11_ = t13.v[0];
        i12_ = t13.v[1];
        i22_ = t13.v[2];
    } else {
        if (have1_) {
            determinant_ = s11_;
            i11_ = ((real)1.0 / determinant_);
        } else {
            if (have2_) {
                determinant_ = s22_;
                i22_ = ((real)1.0 / determinant_);
            }
        }
    }
    if ((!((determinant_ > (real)0.0)))) {
        return false;
    }
    e1_ = (have1_ ? (y1_ - z_.p[0]) : (real)0.0);
    e2_ = (have2_ ? (y2_ - z_.p[1]) : (real)0.0);
    dof_ = ((have1_ ? (real)1.0 : (real)0.0) + (have2_ ? (real)1.0 : (real)0.0));
    real t14 = ekf_mahalanobis(e1_, e2_, i11_, i12_, i22_);
    nis_ = t14;
    if ((!(bool)isfinite(nis_))) {
        return false;
    }
    record_.p[(at_scores_)] = nis_;
    record_.p[((at_scores_ + 1))] = ((real)(-0.5) * ((nis_ + gm_log(determinant_)) + (dof_ * (real)1.8378770664093453)));
    record_.p[((at_scores_ + 2))] = dof_;
    for (int64_t k15 = 0; k15 < n_; k15 += 1) {
        i_ = k15;
        real t16 = prior_.p[((i_ * n_))];
        real t17 = prior_.p[(((i_ * n_) + 1))];
        c1_ = t16;
        c2_ = t17;
        real t18 = ((c1_ * i11_) + (c2_ * i12_));
        real t19 = ((c1_ * i12_) + (c2_ * i22_));
        k1_ = t18;
        k2_ = t19;
        record_.p[((at_K_ + (2 * i_)))] = k1_;
        record_.p[(((at_K_ + (2 * i_)) + 1))] = k2_;
        z_.p[(i_)] = (z_.p[(i_)] + ((k1_ * e1_) + (k2_ * e2_)));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
        tuple_5 t20 = ekf_joseph(i_, (tuple_3){{k1_, k2_}}, (tuple_3){{c1_, c2_}}, (tuple_12){{prior_.p[0], prior_.p[1], prior_.p[((n_ + 1))]}}, (tuple_3){{r1_, r2_}});
        row_ = t20;
        int64_t t21 = (i_ + 1);
        for (int64_t k22 = 0; k22 < t21; k22 += 1) {
            j_ = k22;
            real t23 = ekf_joseph_element(i_, prior_.p[(((i_ * n_) + j_))], row_, (tuple_3){{prior_.p[(j_)], prior_.p[((n_ + j_))]}}, (tuple_3){{record_.p[((at_K_ + (2 * j_)))], record_.p[(((at_K_ + (2 * j_)) + 1))]}});
            value_ = t23;
            P_.p[(((i_ * n_) + j_))] = value_;
            P_.p[(((j_ * n_) + i_))] = value_;
            record_.p[(((at_P_ + (i_ * n_)) + j_))] = value_;
            record_.p[(((at_P_ + (j_ * n_)) + i_))] = value_;
        }
    }
    return true;
}

/* estimation/process_model.py:356 bound_curve */
GM_INLINE void process_model_bound_curve(Layout layout_, array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count(layout_.curve_);
    count_ = t1;
    if (((count_ > 1))) {
        at_ = (layout_.n_ - count_);
        z_.p[gm_at((at_ + 1), z_.n[0])] = gm_min_f(gm_max_f(z_.p[gm_at((at_ + 1), z_.n[0])], (p_.p[9] / (real)10.0)), (p_.p[9] * (real)10.0));
        z_.p[gm_at((at_ + 2), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 2), z_.n[0])], (real)0.0);
        if (((p_.p[12] > (real)0.0))) {
            z_.p[gm_at((at_ + 3), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 3), z_.n[0])], (real)0.0);
        }
    }
    return;
}

/* estimation/filters/ekf.py:208 healthy */
GM_INLINE bool ekf_healthy(Layout layout_, Belief belief_)
{
    int64_t n_;
    array1_f8 z_;
    array1_f8 P_;
    int64_t i_;
    n_ = layout_.n_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        if ((!(((bool)isfinite(z_.p[(i_)]) && ((P_.p[(((i_ * n_) + i_))] > (real)0.0))) && (bool)isfinite(P_.p[(((i_ * n_) + i_))])))) {
            return false;
        }
    }
    return true;
}

/* estimation/filters/ekf.py:30 step */
GM_APART bool ekf_step(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    ekf_predict(layout_, belief_, reading_, p_, scratch_, record_);
    bool t1 = ekf_update(layout_, belief_, reading_.y1_, reading_.y2_, p_, record_);
    if ((!t1)) {
        return false;
    }
    process_model_bound_curve(layout_, belief_.z_, p_);
    bool t2 = ekf_healthy(layout_, belief_);
    return t2;
}

/* estimation/filters/aekf.py:234 begin */
GM_STATIC void aekf_begin(array1_f8 memory_, array1_f8 p_)
{
    int64_t i_;
    memory_.p[0] = (real)1.0;
    real t1 = p_.p[42];
    memory_.p[2] = (real)1.0;
    memory_.p[3] = t1;
    for (int64_t k2 = 0; k2 < 74; k2 += 1) {
        i_ = k2;
        memory_.p[((41 + i_))] = p_.p[(i_)];
    }
    int64_t t3 = (int64_t)(p_.p[45]);
    for (int64_t k4 = 0; k4 < t3; k4 += 1) {
        i_ = k4;
        memory_.p[((8 + i_))] = gm_log(p_.p[gm_at((int64_t)(p_.p[((46 + i_))]), p_.n[0])]);
        memory_.p[((14 + i_))] = memory_.p[((8 + i_))];
        memory_.p[(((20 + ((i_ * (i_ + 1)) / 2)) + i_))] = (real)1.0;
    }
    return;
}

/* estimation/filters/aekf.py:306 _eigenvalue */
GM_STATIC real aekf_eigenvalue(array1_f8 current_, array1_f8 p_)
{
    real slope_;
    real stiffer_;
    slope_ = ((current_.p[3] - p_.p[3]) + (((real)0.6366197723675814 * p_.p[5]) * (current_.p[4] - p_.p[4])));
    stiffer_ = gm_max_f((current_.p[26] - p_.p[26]), (real)0.0);
    return ((p_.p[30] + (gm_max_f(slope_, (real)0.0) * p_.p[0])) + gm_sqrt((stiffer_ * (p_.p[0] + p_.p[1]))));
}

/* estimation/filters/aekf.py:595 _add_noise */
GM_INLINE void aekf_add_noise(Layout layout_, array1_f8 z_, BeliefSensitivity sensitivity_, real half_, array1_f8 current_, array1_f8 p_)
{
    int64_t n_;
    array2_f8 s_;
    array2_f8 P_s_;
    int64_t count_;
    int64_t i_;
    real q_;
    int64_t at_;
    n_ = layout_.n_;
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    for (int64_t k1 = 0; k1 < count_; k1 += 1) {
        i_ = k1;
        q_ = ((((real)2.0 * current_.p[35]) * z_.p[2]) * s_.p[((i_) * s_.n[1] + 2)]);
        if (((p_.p[((46 + i_))] == (real)56.0))) {
            q_ = (q_ + current_.p[56]);
        }
        P_s_.p[((i_) * P_s_.n[1] + (((4 * n_) + 4)))] = (P_s_.p[((i_) * P_s_.n[1] + (((4 * n_) + 4)))] + (half_ * q_));
        at_ = ((int64_t)(p_.p[((46 + i_))]) - 52);
        if ((((0 <= at_) && (at_ < n_)) && ((at_ != 4)))) {
            P_s_.p[((i_) * P_s_.n[1] + gm_at(((at_ * n_) + at_), P_s_.n[1]))] = (P_s_.p[((i_) * P_s_.n[1] + gm_at(((at_ * n_) + at_), P_s_.n[1]))] + (half_ * current_.p[gm_at((52 + at_), current_.n[0])]));
        }
    }
    return;
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_3(Layout layout_, array1_f8 phi_, int64_t j_, real h_, tuple_8 m_, tuple_9 r_, array1_f8 p_, array2_f8 trace_)
{
    int64_t n_;
    bool loaded_;
    real moved1_;
    real moved2_;
    int64_t q_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[(((0 * n_) + j_))] = (m_.v[0].v[0] + moved1_);
    phi_.p[(((1 * n_) + j_))] = (m_.v[0].v[4] + moved2_);
    phi_.p[(((2 * n_) + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[(((3 * n_) + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[(((4 * n_) + j_))] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    for (int64_t k1 = 0; k1 < 4; k1 += 1) {
        q_ = k1;
        trace_.p[(((0 + q_)) * trace_.n[1] + (j_))] = m_.v[(q_)].v[1];
    }
    if (((p_.p[26] > (real)0.0))) {
        for (int64_t k2 = 0; k2 < 4; k2 += 1) {
            q_ = k2;
            trace_.p[(((4 + q_)) * trace_.n[1] + (j_))] = (m_.v[(q_)].v[1] - m_.v[(q_)].v[2]);
        }
    }
    if (((p_.p[19] > (real)0.0))) {
        for (int64_t k3 = 0; k3 < 4; k3 += 1) {
            q_ = k3;
            trace_.p[(((8 + q_)) * trace_.n[1] + (j_))] = m_.v[(q_)].v[3];
        }
    }
    if (loaded_) {
        for (int64_t k4 = 0; k4 < 4; k4 += 1) {
            q_ = k4;
            real t5 = m_.v[(q_)].v[4];
            real t6 = m_.v[(q_)].v[2];
            trace_.p[(gm_at(((-11) + q_), trace_.n[0]) * trace_.n[1] + (j_))] = t5;
            trace_.p[(gm_at(((-7) + q_), trace_.n[0]) * trace_.n[1] + (j_))] = t6;
        }
    }
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_3(Layout layout_, array1_f8 phi_, int64_t j_, Stages stages_, tuple_5 errors_, tuple_3 sources_, array1_f8 p_, array2_f8 trace_)
{
    bool loaded_;
    int64_t curve_;
    tuple_5 slopes_;
    tuple_5 shares_;
    tuple_9 arms_;
    tuple_8 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_4 m1_;
    tuple_4 c1_;
    tuple_3 r1_;
    tuple_4 m2_;
    tuple_4 c2_;
    tuple_3 r2_;
    tuple_4 m3_;
    tuple_4 c3_;
    tuple_3 r3_;
    tuple_4 m4_;
    tuple_4 c4_;
    tuple_3 r4_;
    loaded_ = layout_.loaded_;
    curve_ = layout_.curve_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row(layout_, phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_4 t3 = process_model_begin(layout_.n_, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_4 t5 = process_model_bent(curve_, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(loaded_, arms_.v[0], load_, m1_);
    tuple_3 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_4 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_4 t10 = process_model_bent(curve_, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(loaded_, arms_.v[1], load_, m2_);
    tuple_3 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_4 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_4 t15 = process_model_bent(curve_, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(loaded_, arms_.v[2], load_, m3_);
    tuple_3 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_4 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_4 t20 = process_model_bent(curve_, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(loaded_, arms_.v[3], load_, m4_);
    tuple_3 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_3(layout_, phi_, j_, h_, (tuple_8){{m1_, m2_, m3_, m4_}}, (tuple_9){{r1_, r2_, r3_, r4_}}, p_, trace_);
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2_2(Layout layout_, array1_f8 phi_, Stages stages_, array1_f8 p_, array2_f8 trace_)
{
    int64_t n_;
    int64_t i_;
    int64_t q_;
    n_ = layout_.n_;
    if ((layout_.loaded_ || ((layout_.curve_ >= 0)))) {
        process_model_column_3(layout_, phi_, 1, stages_, (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}}, (tuple_3){{(real)0.0, (real)0.0}}, p_, trace_);
    } else {
        if (stages_.first_) {
            for (int64_t k1 = 0; k1 < n_; k1 += 1) {
                i_ = k1;
                phi_.p[(((i_ * n_) + 1))] = (((i_ == 1)) ? (real)1.0 : (real)0.0);
            }
        }
        for (int64_t k2 = 0; k2 < 12; k2 += 1) {
            q_ = k2;
            trace_.p[((q_) * trace_.n[1] + 1)] = (real)0.0;
        }
    }
    return;
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_4(Layout layout_, array1_f8 phi_, int64_t j_, real h_, tuple_8 m_, tuple_9 r_, array1_f8 p_, array2_f8 trace_)
{
    int64_t n_;
    bool loaded_;
    real moved1_;
    real moved2_;
    int64_t q_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[gm_at(((0 * n_) + j_), phi_.n[0])] = (m_.v[0].v[0] + moved1_);
    phi_.p[gm_at(((1 * n_) + j_), phi_.n[0])] = (m_.v[0].v[4] + moved2_);
    phi_.p[gm_at(((2 * n_) + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[gm_at(((3 * n_) + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[gm_at(((4 * n_) + j_), phi_.n[0])] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    for (int64_t k1 = 0; k1 < 4; k1 += 1) {
        q_ = k1;
        trace_.p[(((0 + q_)) * trace_.n[1] + gm_at(j_, trace_.n[1]))] = m_.v[(q_)].v[1];
    }
    if (((p_.p[26] > (real)0.0))) {
        for (int64_t k2 = 0; k2 < 4; k2 += 1) {
            q_ = k2;
            trace_.p[(((4 + q_)) * trace_.n[1] + gm_at(j_, trace_.n[1]))] = (m_.v[(q_)].v[1] - m_.v[(q_)].v[2]);
        }
    }
    if (((p_.p[19] > (real)0.0))) {
        for (int64_t k3 = 0; k3 < 4; k3 += 1) {
            q_ = k3;
            trace_.p[(((8 + q_)) * trace_.n[1] + gm_at(j_, trace_.n[1]))] = m_.v[(q_)].v[3];
        }
    }
    if (loaded_) {
        for (int64_t k4 = 0; k4 < 4; k4 += 1) {
            q_ = k4;
            real t5 = m_.v[(q_)].v[4];
            real t6 = m_.v[(q_)].v[2];
            trace_.p[(gm_at(((-11) + q_), trace_.n[0]) * trace_.n[1] + gm_at(j_, trace_.n[1]))] = t5;
            trace_.p[(gm_at(((-7) + q_), trace_.n[0]) * trace_.n[1] + gm_at(j_, trace_.n[1]))] = t6;
        }
    }
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_4(Layout layout_, array1_f8 phi_, int64_t j_, Stages stages_, tuple_5 errors_, tuple_3 sources_, array1_f8 p_, array2_f8 trace_)
{
    bool loaded_;
    int64_t curve_;
    tuple_5 slopes_;
    tuple_5 shares_;
    tuple_9 arms_;
    tuple_8 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_4 m1_;
    tuple_4 c1_;
    tuple_3 r1_;
    tuple_4 m2_;
    tuple_4 c2_;
    tuple_3 r2_;
    tuple_4 m3_;
    tuple_4 c3_;
    tuple_3 r3_;
    tuple_4 m4_;
    tuple_4 c4_;
    tuple_3 r4_;
    loaded_ = layout_.loaded_;
    curve_ = layout_.curve_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_2(layout_, phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_4 t3 = process_model_begin_2(layout_.n_, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_4 t5 = process_model_bent(curve_, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(loaded_, arms_.v[0], load_, m1_);
    tuple_3 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_4 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_4 t10 = process_model_bent(curve_, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(loaded_, arms_.v[1], load_, m2_);
    tuple_3 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_4 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_4 t15 = process_model_bent(curve_, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(loaded_, arms_.v[2], load_, m3_);
    tuple_3 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_4 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_4 t20 = process_model_bent(curve_, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(loaded_, arms_.v[3], load_, m4_);
    tuple_3 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_4(layout_, phi_, j_, h_, (tuple_8){{m1_, m2_, m3_, m4_}}, (tuple_9){{r1_, r2_, r3_, r4_}}, p_, trace_);
    return;
}

/* estimation/process_model.py:995 _columns_of_curve */
GM_INLINE void process_model_columns_of_curve_2(Layout layout_, array1_f8 z_, array1_f8 phi_, real memory_, tuple_5 law_, Stages stages_, array1_f8 p_, array2_f8 trace_)
{
    int64_t n_;
    int64_t count_;
    int64_t at_;
    tuple_5 none_;
    real width_;
    real end_;
    int64_t j_;
    int64_t t1 = process_model_curve_count(layout_.curve_);
    n_ = layout_.n_;
    count_ = t1;
    int64_t t2 = (n_ - count_);
    at_ = t2;
    none_ = (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((count_ > 0))) {
        process_model_column_4(layout_, phi_, (at_ + 0), stages_, none_, (tuple_3){{(real)0.0, (real)0.0}}, p_, trace_);
    }
    if (((count_ > 1))) {
        process_model_column_4(layout_, phi_, (at_ + 1), stages_, none_, (tuple_3){{(real)0.0, (real)2.0}}, p_, trace_);
        process_model_column_4(layout_, phi_, (at_ + 2), stages_, none_, (tuple_3){{(real)0.0, (real)3.0}}, p_, trace_);
        process_model_column_4(layout_, phi_, (at_ + 3), stages_, none_, (tuple_3){{(real)0.0, (real)4.0}}, p_, trace_);
    }
    if (((count_ > 0))) {
        width_ = (gm_fabs(law_.v[2]) / law_.v[0]);
        tuple_3 t3 = transmission_play((z_.p[0] - z_.p[1]), memory_, width_);
        z_.p[gm_at((at_ + 0), z_.n[0])] = t3.v[0];
        end_ = t3.v[1];
        if (((end_ != (real)0.0))) {
            for (int64_t k4 = 0; k4 < n_; k4 += 1) {
                j_ = k4;
                phi_.p[gm_at((((at_ + 0) * n_) + j_), phi_.n[0])] = (phi_.p[(((0 * n_) + j_))] - phi_.p[(((1 * n_) + j_))]);
            }
            if (((count_ > 1))) {
                phi_.p[gm_at(((((at_ + 0) * n_) + at_) + 1), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * n_) + at_) + 1), phi_.n[0])] + ((end_ * width_) / law_.v[0]));
                phi_.p[gm_at(((((at_ + 0) * n_) + at_) + 3), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * n_) + at_) + 3), phi_.n[0])] - ((((law_.v[2] >= (real)0.0)) ? end_ : (-end_)) / law_.v[0]));
            }
        }
    }
    return;
}

/* estimation/process_model.py:883 rk4 */
GM_INLINE void process_model_rk4_2(Layout layout_, array1_f8 z_, array1_f8 phi_, bool first_, tuple_3 torques_, real h_, array1_f8 p_, array2_f8 trace_)
{
    int64_t n_;
    bool loaded_;
    int64_t curve_;
    real u_;
    real load_;
    real half_;
    real sixth_;
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    real tau_k_;
    int64_t at_curve_;
    tuple_5 law_;
    real memory_;
    tuple_5 rows_;
    tuple_4 error_;
    tuple_8 m1_;
    real total_;
    tuple_4 bend1_;
    real slope1_;
    real share1_;
    tuple_3 arm1_;
    real f1_;
    real g1_;
    tuple_9 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_4 bend2_;
    real slope2_;
    real share2_;
    tuple_3 arm2_;
    real f2_;
    real g2_;
    tuple_8 m2_;
    tuple_9 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_4 bend3_;
    real slope3_;
    real share3_;
    tuple_3 arm3_;
    real f3_;
    real g3_;
    tuple_8 m3_;
    tuple_9 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_4 bend4_;
    real slope4_;
    real share4_;
    tuple_3 arm4_;
    real f4_;
    real g4_;
    tuple_8 m4_;
    tuple_9 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
    int64_t i_;
    int64_t j_;
    tuple_5 none_;
    tuple_4 fades_;
    int64_t q_;
    real value_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    curve_ = layout_.curve_;
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    real t1 = ((real)0.5 * h_);
    real t2 = (h_ / (real)6.0);
    half_ = t1;
    sixth_ = t2;
    real t3 = z_.p[0];
    real t4 = z_.p[1];
    real t5 = z_.p[2];
    real t6 = z_.p[3];
    real t7 = z_.p[4];
    x1_ = t3;
    x2_ = t4;
    x3_ = t5;
    x4_ = t6;
    tau_k_ = t7;
    int64_t t8 = process_model_curve_count(curve_);
    at_curve_ = (n_ - t8);
    tuple_5 t9 = process_model_curve(curve_, z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory(curve_, z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row(layout_, phi_, 0, first_);
    real t12 = process_model_memory_row(layout_, phi_, 2, first_);
    real t13 = process_model_memory_row(layout_, phi_, 3, first_);
    real t14 = process_model_memory_row(layout_, phi_, 4, first_);
    rows_ = (tuple_5){{t11, t12, t13, t14}};
    error_ = (tuple_4){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((n_ > 5))) {
        if (((p_.p[28] > (real)0.0))) {
            load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
        }
        if (((p_.p[29] > (real)0.0))) {
            tuple_4 t15 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], half_, h_, p_);
            error_ = t15;
        }
    }
    tuple_4 t16 = process_model_begin(n_, phi_, 0, first_);
    tuple_4 t17 = process_model_begin(n_, phi_, 2, first_);
    tuple_4 t18 = process_model_begin(n_, phi_, 3, first_);
    tuple_4 t19 = process_model_begin(n_, phi_, 4, first_);
    m1_ = (tuple_8){{t16, t17, t18, t19}};
    tuple_7 t20 = process_model_total(curve_, (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t20.f0;
    bend1_ = t20.f1;
    tuple_3 t21 = process_model_slopes(layout_.law_, x3_, total_, p_);
    slope1_ = t21.v[0];
    share1_ = t21.v[1];
    tuple_3 t22 = process_model_load_slopes(loaded_, x2_, x4_, p_);
    arm1_ = t22;
    tuple_3 t23 = process_model_accelerations(layout_, (tuple_4){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t23.v[0];
    g1_ = t23.v[1];
    tuple_8 t24 = process_model_four_bent(curve_, bend1_, rows_, m1_);
    tuple_9 t25 = process_model_four_rates(loaded_, t24, slope1_, share1_, arm1_, p_);
    r1_ = t25;
    real t26 = (x2_ + (half_ * x4_));
    real t27 = (x3_ + (half_ * f1_));
    real t28 = (x4_ + (half_ * g1_));
    y2_ = t26;
    y3_ = t27;
    y4_ = t28;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_7 t29 = process_model_total(curve_, ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t29.f0;
    bend2_ = t29.f1;
    tuple_3 t30 = process_model_slopes(layout_.law_, y3_, total_, p_);
    slope2_ = t30.v[0];
    share2_ = t30.v[1];
    tuple_3 t31 = process_model_load_slopes(loaded_, y2_, y4_, p_);
    arm2_ = t31;
    tuple_3 t32 = process_model_accelerations(layout_, (tuple_4){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t32.v[0];
    g2_ = t32.v[1];
    tuple_8 t33 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t33;
    tuple_8 t34 = process_model_four_bent(curve_, bend2_, rows_, m2_);
    tuple_9 t35 = process_model_four_rates(loaded_, t34, slope2_, share2_, arm2_, p_);
    r2_ = t35;
    real t36 = (x2_ + (half_ * y4_));
    real t37 = (x3_ + (half_ * f2_));
    real t38 = (x4_ + (half_ * g2_));
    v2_ = t36;
    v3_ = t37;
    v4_ = t38;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_7 t39 = process_model_total(curve_, ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t39.f0;
    bend3_ = t39.f1;
    tuple_3 t40 = process_model_slopes(layout_.law_, v3_, total_, p_);
    slope3_ = t40.v[0];
    share3_ = t40.v[1];
    tuple_3 t41 = process_model_load_slopes(loaded_, v2_, v4_, p_);
    arm3_ = t41;
    tuple_3 t42 = process_model_accelerations(layout_, (tuple_4){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t42.v[0];
    g3_ = t42.v[1];
    tuple_8 t43 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t43;
    tuple_8 t44 = process_model_four_bent(curve_, bend3_, rows_, m3_);
    tuple_9 t45 = process_model_four_rates(loaded_, t44, slope3_, share3_, arm3_, p_);
    r3_ = t45;
    real t46 = (x2_ + (h_ * v4_));
    real t47 = (x3_ + (h_ * f3_));
    real t48 = (x4_ + (h_ * g3_));
    w2_ = t46;
    w3_ = t47;
    w4_ = t48;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_7 t49 = process_model_total(curve_, ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t49.f0;
    bend4_ = t49.f1;
    tuple_3 t50 = process_model_slopes(layout_.law_, w3_, total_, p_);
    slope4_ = t50.v[0];
    share4_ = t50.v[1];
    tuple_3 t51 = process_model_load_slopes(loaded_, w2_, w4_, p_);
    arm4_ = t51;
    tuple_3 t52 = process_model_accelerations(layout_, (tuple_4){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t52.v[0];
    g4_ = t52.v[1];
    tuple_8 t53 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t53;
    tuple_8 t54 = process_model_four_bent(curve_, bend4_, rows_, m4_);
    tuple_9 t55 = process_model_four_rates(loaded_, t54, slope4_, share4_, arm4_, p_);
    r4_ = t55;
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (y3_ + v3_))) + w3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (y4_ + v4_))) + w4_));
    real t56 = (x1_ + moved1_);
    real t57 = (x2_ + moved2_);
    z_.p[0] = t56;
    z_.p[1] = t57;
    z_.p[2] = (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_)));
    z_.p[3] = (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_)));
    z_.p[4] = (tau_k_ + (p_.p[26] * (moved1_ - moved2_)));
    process_model_end_3(layout_, phi_, 0, h_, (tuple_8){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_9){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_, trace_);
    process_model_end_3(layout_, phi_, 2, h_, (tuple_8){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_9){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_, trace_);
    process_model_end_3(layout_, phi_, 3, h_, (tuple_8){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_9){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_, trace_);
    process_model_end_3(layout_, phi_, 4, h_, (tuple_8){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_9){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_, trace_);
    stages_ = (Stages){(tuple_5){{slope1_, slope2_, slope3_, slope4_}}, (tuple_5){{share1_, share2_, share3_, share4_}}, (tuple_9){{arm1_, arm2_, arm3_, arm4_}}, (tuple_8){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2_2(layout_, phi_, stages_, p_, trace_);
    if (((n_ > 5))) {
        if (first_) {
            for (int64_t k58 = 5; k58 < n_; k58 += 1) {
                i_ = k58;
                for (int64_t k59 = 0; k59 < n_; k59 += 1) {
                    j_ = k59;
                    phi_.p[gm_at(((i_ * n_) + j_), phi_.n[0])] = (((i_ == j_)) ? (real)1.0 : (real)0.0);
                }
            }
        }
        none_ = (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        if (((p_.p[28] > (real)0.0))) {
            process_model_column_4(layout_, phi_, (int64_t)(p_.p[28]), stages_, none_, (tuple_3){{(real)1.0, (real)0.0}}, p_, trace_);
        }
        if (((p_.p[29] > (real)0.0))) {
            i_ = (int64_t)(p_.p[29]);
            z_.p[gm_at(i_, z_.n[0])] = error_.v[4];
            tuple_4 t60 = process_model_decay(phi_.p[gm_at(((i_ * n_) + i_), phi_.n[0])], half_, h_, p_);
            fades_ = t60;
            process_model_column_4(layout_, phi_, i_, stages_, (tuple_5){{fades_.v[0], fades_.v[1], fades_.v[2], fades_.v[3]}}, (tuple_3){{(real)0.0, (real)0.0}}, p_, trace_);
            phi_.p[gm_at(((i_ * n_) + i_), phi_.n[0])] = fades_.v[4];
        }
        process_model_columns_of_curve_2(layout_, z_, phi_, memory_, law_, stages_, p_, trace_);
    }
    {
        q_ = 0;
        value_ = x3_;
        trace_.p[(12 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 1;
        value_ = y3_;
        trace_.p[(12 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 2;
        value_ = v3_;
        trace_.p[(12 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 3;
        value_ = w3_;
        trace_.p[(12 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 0;
        value_ = x4_;
        trace_.p[(13 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 1;
        value_ = y4_;
        trace_.p[(13 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 2;
        value_ = v4_;
        trace_.p[(13 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 3;
        value_ = w4_;
        trace_.p[(13 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 0;
        value_ = tau_k_;
        trace_.p[(14 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 1;
        value_ = tau_y_;
        trace_.p[(14 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 2;
        value_ = tau_v_;
        trace_.p[(14 * trace_.n[1] + (q_))] = value_;
    }
    {
        q_ = 3;
        value_ = tau_w_;
        trace_.p[(14 * trace_.n[1] + (q_))] = value_;
    }
    for (int64_t k64 = 0; k64 < 4; k64 += 1) {
        q_ = k64;
        real t65 = stages_.slopes_.v[(q_)];
        real t66 = stages_.shares_.v[(q_)];
        trace_.p[(15 * trace_.n[1] + (q_))] = t65;
        trace_.p[(16 * trace_.n[1] + (q_))] = t66;
    }
    if (loaded_) {
        {
            q_ = 0;
            value_ = x2_;
            trace_.p[((trace_.n[0] - 3) * trace_.n[1] + (q_))] = value_;
        }
        {
            q_ = 1;
            value_ = y2_;
            trace_.p[((trace_.n[0] - 3) * trace_.n[1] + (q_))] = value_;
        }
        {
            q_ = 2;
            value_ = v2_;
            trace_.p[((trace_.n[0] - 3) * trace_.n[1] + (q_))] = value_;
        }
        {
            q_ = 3;
            value_ = w2_;
            trace_.p[((trace_.n[0] - 3) * trace_.n[1] + (q_))] = value_;
        }
        for (int64_t k68 = 0; k68 < 4; k68 += 1) {
            q_ = k68;
            trace_.p[((trace_.n[0] - 2) * trace_.n[1] + (q_))] = stages_.arms_.v[(q_)].v[0];
            trace_.p[((trace_.n[0] - 1) * trace_.n[1] + (q_))] = stages_.arms_.v[(q_)].v[1];
        }
    }
    return;
}

/* estimation/filters/aekf.py:332 _look */
GM_INLINE void aekf_look(bool loaded_, bool with_atan_, array1_f8 current_, array2_f8 vectors_)
{
    int64_t q_;
    real x3_;
    real tau_;
    real v_;
    real flat_;
    real coulomb_;
    real sign_;
    for (int64_t k1 = 0; k1 < 4; k1 += 1) {
        q_ = k1;
        real t2 = vectors_.p[(12 * vectors_.n[1] + (q_))];
        real t3 = vectors_.p[(14 * vectors_.n[1] + (q_))];
        x3_ = t2;
        tau_ = t3;
        v_ = (current_.p[5] * x3_);
        flat_ = ((real)1.0 / ((real)1.0 + (v_ * v_)));
        coulomb_ = (vectors_.p[(15 * vectors_.n[1] + (q_))] - current_.p[3]);
        vectors_.p[(17 * vectors_.n[1] + (q_))] = (((((real)(-2.0) * coulomb_) * current_.p[5]) * v_) * flat_);
        vectors_.p[(21 * vectors_.n[1] + (q_))] = (((real)0.6366197723675814 * current_.p[5]) * flat_);
        sign_ = (((tau_ > (real)0.0)) ? (real)1.0 : (((tau_ < (real)0.0)) ? (real)(-1.0) : (real)0.0));
        vectors_.p[(18 * vectors_.n[1] + (q_))] = ((current_.p[19] * vectors_.p[(21 * vectors_.n[1] + (q_))]) * sign_);
        vectors_.p[(19 * vectors_.n[1] + (q_))] = (x3_ - vectors_.p[(13 * vectors_.n[1] + (q_))]);
        vectors_.p[(20 * vectors_.n[1] + (q_))] = (with_atan_ ? ((real)0.6366197723675814 * gm_atan(v_)) : (real)0.0);
        if (loaded_) {
            v_ = (current_.p[15] * vectors_.p[(13 * vectors_.n[1] + (q_))]);
            coulomb_ = (vectors_.p[((vectors_.n[0] - 1) * vectors_.n[1] + (q_))] - current_.p[13]);
            vectors_.p[(75 * vectors_.n[1] + (q_))] = (((((real)(-2.0) * coulomb_) * current_.p[15]) * v_) / ((real)1.0 + (v_ * v_)));
            vectors_.p[(74 * vectors_.n[1] + (q_))] = ((-current_.p[16]) * gm_sin((vectors_.p[((vectors_.n[0] - 3) * vectors_.n[1] + (q_))] + current_.p[17])));
        }
    }
    return;
}

/* kernels/linalg.py:22 multiply */
GM_INLINE void linalg_multiply(Layout layout_, array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    int64_t k_;
    real v_;
    real s0_;
    real s1_;
    real s2_;
    real s3_;
    real s4_;
    real s5_;
    real s6_;
    int64_t at_;
    n_ = layout_.n_;
    if (((n_ > 7))) {
        for (int64_t k1 = 0; k1 < n_; k1 += 1) {
            i_ = k1;
            for (int64_t k2 = 0; k2 < n_; k2 += 1) {
                j_ = k2;
                out_.p[(((i_ * n_) + j_))] = (real)0.0;
            }
            for (int64_t k3 = 0; k3 < n_; k3 += 1) {
                k_ = k3;
                v_ = a_.p[(((i_ * n_) + k_))];
                for (int64_t k4 = 0; k4 < n_; k4 += 1) {
                    j_ = k4;
                    out_.p[(((i_ * n_) + j_))] = gm_fma(v_, b_.p[(((k_ * n_) + j_))], out_.p[(((i_ * n_) + j_))]);
                }
            }
        }
        return;
    }
    for (int64_t k5 = 0; k5 < n_; k5 += 1) {
        i_ = k5;
        tuple_11 t6 = linalg_row(n_, (-1), a_, i_, b_);
        s0_ = t6.v[0];
        s1_ = t6.v[1];
        s2_ = t6.v[2];
        s3_ = t6.v[3];
        s4_ = t6.v[4];
        s5_ = t6.v[5];
        s6_ = t6.v[6];
        at_ = (i_ * n_);
        out_.p[(at_)] = s0_;
        out_.p[((at_ + 1))] = s1_;
        out_.p[((at_ + 2))] = s2_;
        out_.p[((at_ + 3))] = s3_;
        out_.p[((at_ + 4))] = s4_;
        if (((n_ > 5))) {
            out_.p[((at_ + 5))] = s5_;
        }
        if (((n_ > 6))) {
            out_.p[((at_ + 6))] = s6_;
        }
    }
    return;
}

/* kernels/linalg.py:73 multiply_symmetric */
GM_INLINE void linalg_multiply_symmetric(Layout layout_, array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t n_;
    int64_t i_;
    real s0_;
    real s1_;
    real s2_;
    real s3_;
    real s4_;
    real s5_;
    real s6_;
    int64_t k_;
    real v_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        s0_ = (real)0.0;
        s1_ = (real)0.0;
        s2_ = (real)0.0;
        s3_ = (real)0.0;
        s4_ = (real)0.0;
        s5_ = (real)0.0;
        s6_ = (real)0.0;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            k_ = k2;
            v_ = a_.p[(((i_ * n_) + k_))];
            s0_ = gm_fma(v_, b_.p[(k_)], s0_);
            s1_ = gm_fma(v_, b_.p[((n_ + k_))], s1_);
            s2_ = gm_fma(v_, b_.p[(((2 * n_) + k_))], s2_);
            s3_ = gm_fma(v_, b_.p[(((3 * n_) + k_))], s3_);
            s4_ = gm_fma(v_, b_.p[(((4 * n_) + k_))], s4_);
            if (((n_ > 5))) {
                s5_ = gm_fma(v_, b_.p[(((5 * n_) + k_))], s5_);
            }
            if (((n_ > 6))) {
                s6_ = gm_fma(v_, b_.p[(((6 * n_) + k_))], s6_);
            }
        }
        linalg_mirrored(out_, n_, i_, 0, s0_);
        linalg_mirrored(out_, n_, i_, 1, s1_);
        linalg_mirrored(out_, n_, i_, 2, s2_);
        linalg_mirrored(out_, n_, i_, 3, s3_);
        linalg_mirrored(out_, n_, i_, 4, s4_);
        linalg_mirrored(out_, n_, i_, 5, s5_);
        linalg_mirrored(out_, n_, i_, 6, s6_);
    }
    return;
}

/* estimation/filters/aekf.py:315 _arm */
GM_INLINE tuple_3 aekf_arm(bool loaded_, int64_t q_, array2_f8 vectors_)
{
    if ((!loaded_)) {
        return (tuple_3){{(real)0.0, (real)0.0}};
    }
    return (tuple_3){{vectors_.p[((vectors_.n[0] - 2) * vectors_.n[1] + (q_))], vectors_.p[((vectors_.n[0] - 1) * vectors_.n[1] + (q_))]}};
}

/* estimation/filters/aekf.py:323 _apply */
GM_INLINE tuple_4 aekf_apply(bool loaded_, tuple_4 v_, int64_t stage_, array1_f8 current_, array2_f8 vectors_)
{
    tuple_4 m_;
    real load_;
    tuple_3 r_;
    m_ = (tuple_4){{v_.v[0], v_.v[2], v_.v[3], v_.v[4], v_.v[1]}};
    tuple_3 t1 = aekf_arm(loaded_, stage_, vectors_);
    real t2 = process_model_answer(loaded_, t1, (real)0.0, m_);
    load_ = t2;
    tuple_3 t3 = process_model_rates(m_, vectors_.p[(15 * vectors_.n[1] + (stage_))], vectors_.p[(16 * vectors_.n[1] + (stage_))], (real)0.0, load_, current_);
    r_ = t3;
    return (tuple_4){{v_.v[2], v_.v[3], r_.v[0], r_.v[1], (current_.p[26] * (v_.v[2] - v_.v[3]))}};
}

/* estimation/filters/aekf.py:354 _sum */
GM_INLINE tuple_4 aekf_sum(real a_, tuple_4 v_, real b_, tuple_4 w_)
{
    return (tuple_4){{((a_ * v_.v[0]) + (b_ * w_.v[0])), ((a_ * v_.v[1]) + (b_ * w_.v[1])), ((a_ * v_.v[2]) + (b_ * w_.v[2])), ((a_ * v_.v[3]) + (b_ * w_.v[3])), ((a_ * v_.v[4]) + (b_ * w_.v[4]))}};
}

/* estimation/filters/aekf.py:360 _write */
GM_INLINE void aekf_write(array1_f8 row_, tuple_4 v_, int64_t n_)
{
    int64_t j_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        j_ = k1;
        row_.p[(j_)] = (((j_ < 5)) ? v_.v[(j_)] : (real)0.0);
    }
    return;
}

/* estimation/filters/aekf.py:366 _answers */
GM_INLINE void aekf_answers(Layout layout_, tuple_4 unit_, int64_t g_, real h_, array1_f8 current_, array2_f8 vectors_)
{
    int64_t n_;
    bool loaded_;
    tuple_4 a3_;
    tuple_4 a2_;
    tuple_4 a32_;
    tuple_4 end_;
    tuple_4 a1_;
    tuple_4 a21_;
    tuple_4 a321_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    tuple_4 t1 = aekf_apply(loaded_, unit_, 3, current_, vectors_);
    a3_ = t1;
    tuple_4 t2 = aekf_sum((h_ / (real)3.0), unit_, ((h_ * h_) / (real)6.0), a3_);
    aekf_write((array1_f8){vectors_.p + ((g_ + 2)) * (vectors_.n[1]), {vectors_.n[1]}}, t2, n_);
    tuple_4 t3 = aekf_apply(loaded_, unit_, 2, current_, vectors_);
    a2_ = t3;
    tuple_4 t4 = aekf_apply(loaded_, a2_, 3, current_, vectors_);
    a32_ = t4;
    tuple_4 t5 = aekf_sum((h_ / (real)3.0), a2_, ((h_ * h_) / (real)6.0), a32_);
    end_ = t5;
    tuple_4 t6 = aekf_sum((h_ / (real)3.0), unit_, ((real)0.5 * h_), end_);
    aekf_write((array1_f8){vectors_.p + ((g_ + 1)) * (vectors_.n[1]), {vectors_.n[1]}}, t6, n_);
    tuple_4 t7 = aekf_apply(loaded_, unit_, 1, current_, vectors_);
    a1_ = t7;
    tuple_4 t8 = aekf_apply(loaded_, a1_, 2, current_, vectors_);
    a21_ = t8;
    tuple_4 t9 = aekf_apply(loaded_, a21_, 3, current_, vectors_);
    a321_ = t9;
    tuple_4 t10 = aekf_sum((h_ / (real)3.0), a21_, ((h_ * h_) / (real)6.0), a321_);
    end_ = t10;
    tuple_4 t11 = aekf_sum((h_ / (real)3.0), a1_, ((real)0.5 * h_), end_);
    end_ = t11;
    tuple_4 t12 = aekf_sum((h_ / (real)6.0), unit_, ((real)0.5 * h_), end_);
    aekf_write((array1_f8){vectors_.p + (g_) * (vectors_.n[1]), {vectors_.n[1]}}, t12, n_);
    return;
}

/* estimation/filters/aekf.py:534 _times */
GM_INLINE void aekf_times(Layout layout_, array1_f8 product_, int64_t source_, array1_f8 flat_, int64_t out_)
{
    int64_t n_;
    int64_t a_;
    real v0_;
    real v1_;
    real v2_;
    real v3_;
    int64_t b_;
    real v_;
    int64_t at_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        a_ = k1;
        v0_ = (real)0.0;
        v1_ = (real)0.0;
        v2_ = (real)0.0;
        v3_ = (real)0.0;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            b_ = k2;
            real t3 = product_.p[(((a_ * n_) + b_))];
            int64_t t4 = ((source_ * n_) + b_);
            v_ = t3;
            at_ = t4;
            real t5 = gm_fma(v_, flat_.p[(at_)], v0_);
            real t6 = gm_fma(v_, flat_.p[((at_ + n_))], v1_);
            v0_ = t5;
            v1_ = t6;
            real t7 = gm_fma(v_, flat_.p[((at_ + (2 * n_)))], v2_);
            real t8 = gm_fma(v_, flat_.p[((at_ + (3 * n_)))], v3_);
            v2_ = t7;
            v3_ = t8;
        }
        at_ = ((out_ * n_) + a_);
        real t9 = v0_;
        real t10 = v1_;
        real t11 = v2_;
        real t12 = v3_;
        flat_.p[(at_)] = t9;
        flat_.p[((at_ + n_))] = t10;
        flat_.p[((at_ + (2 * n_)))] = t11;
        flat_.p[((at_ + (3 * n_)))] = t12;
    }
    return;
}

/* estimation/filters/aekf.py:534 _times */
GM_INLINE void aekf_times_2(Layout layout_, array1_f8 product_, int64_t source_, array1_f8 flat_, int64_t out_)
{
    int64_t n_;
    int64_t a_;
    real v0_;
    real v1_;
    real v2_;
    real v3_;
    int64_t b_;
    real v_;
    int64_t at_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        a_ = k1;
        v0_ = (real)0.0;
        v1_ = (real)0.0;
        v2_ = (real)0.0;
        v3_ = (real)0.0;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            b_ = k2;
            real t3 = product_.p[(((a_ * n_) + b_))];
            int64_t t4 = ((source_ * n_) + b_);
            v_ = t3;
            at_ = t4;
            real t5 = gm_fma(v_, flat_.p[gm_at(at_, flat_.n[0])], v0_);
            real t6 = gm_fma(v_, flat_.p[gm_at((at_ + n_), flat_.n[0])], v1_);
            v0_ = t5;
            v1_ = t6;
            real t7 = gm_fma(v_, flat_.p[gm_at((at_ + (2 * n_)), flat_.n[0])], v2_);
            real t8 = gm_fma(v_, flat_.p[gm_at((at_ + (3 * n_)), flat_.n[0])], v3_);
            v2_ = t7;
            v3_ = t8;
        }
        at_ = ((out_ * n_) + a_);
        real t9 = v0_;
        real t10 = v1_;
        real t11 = v2_;
        real t12 = v3_;
        flat_.p[gm_at(at_, flat_.n[0])] = t9;
        flat_.p[gm_at((at_ + n_), flat_.n[0])] = t10;
        flat_.p[gm_at((at_ + (2 * n_)), flat_.n[0])] = t11;
        flat_.p[gm_at((at_ + (3 * n_)), flat_.n[0])] = t12;
    }
    return;
}

/* estimation/filters/aekf.py:389 _sensitivity_rates */
GM_INLINE tuple_3 aekf_sensitivity_rates(bool loaded_, tuple_4 m_, int64_t q_, tuple_13 theta_, real error_, real load_, array1_f8 current_, array2_f8 vectors_)
{
    int64_t slot_;
    real sharper_;
    real arm_sharper_;
    real coulomb_;
    real moved_;
    real c_;
    real x4_;
    slot_ = theta_.f0;
    sharper_ = theta_.f1.v[0];
    arm_sharper_ = theta_.f1.v[1];
    coulomb_ = (sharper_ * (vectors_.p[(15 * vectors_.n[1] + (q_))] - current_.p[3]));
    moved_ = (m_.v[1] + (sharper_ * vectors_.p[(12 * vectors_.n[1] + (q_))]));
    c_ = (((vectors_.p[(17 * vectors_.n[1] + (q_))] * moved_) + (vectors_.p[(18 * vectors_.n[1] + (q_))] * m_.v[3])) + coulomb_);
    error_ = (error_ + (coulomb_ * vectors_.p[(12 * vectors_.n[1] + (q_))]));
    if (((slot_ == 3))) {
        c_ = (c_ + current_.p[3]);
        error_ = (error_ + (current_.p[3] * vectors_.p[(12 * vectors_.n[1] + (q_))]));
    } else {
        if (((slot_ == 4))) {
            c_ = (c_ + (current_.p[4] * vectors_.p[(21 * vectors_.n[1] + (q_))]));
            error_ = (error_ + (current_.p[4] * vectors_.p[(20 * vectors_.n[1] + (q_))]));
        }
    }
    vectors_.p[(24 * vectors_.n[1] + (q_))] = ((-c_) * current_.p[0]);
    vectors_.p[(25 * vectors_.n[1] + (q_))] = (((-vectors_.p[(18 * vectors_.n[1] + (q_))]) * moved_) * current_.p[0]);
    if (loaded_) {
        x4_ = vectors_.p[(13 * vectors_.n[1] + (q_))];
        coulomb_ = (arm_sharper_ * (vectors_.p[((vectors_.n[0] - 1) * vectors_.n[1] + (q_))] - current_.p[13]));
        load_ = (load_ + (coulomb_ * x4_));
        vectors_.p[(76 * vectors_.n[1] + (q_))] = (((-vectors_.p[(74 * vectors_.n[1] + (q_))]) * m_.v[4]) * current_.p[1]);
        vectors_.p[(77 * vectors_.n[1] + (q_))] = ((-((vectors_.p[(75 * vectors_.n[1] + (q_))] * (m_.v[2] + (arm_sharper_ * x4_))) + coulomb_)) * current_.p[1]);
    }
    real t3 = vectors_.p[(15 * vectors_.n[1] + (q_))];
    real t4 = vectors_.p[(16 * vectors_.n[1] + (q_))];
    real t5 = error_;
    tuple_3 t1 = aekf_arm(loaded_, q_, vectors_);
    real t2 = process_model_answer(loaded_, t1, load_, m_);
    tuple_3 t6 = process_model_rates(m_, t3, t4, t5, t2, current_);
    return t6;
}

/* estimation/filters/aekf.py:458 _added */
GM_INLINE tuple_4 aekf_added(tuple_4 m_, real torque_)
{
    return (tuple_4){{m_.v[0], m_.v[1], m_.v[2], (m_.v[3] + torque_), m_.v[4]}};
}

/* estimation/filters/aekf.py:423 _advance_sensitivity */
GM_INLINE void aekf_advance_sensitivity(Layout layout_, array1_f8 s_, tuple_13 theta_, real h_, array1_f8 current_, array2_f8 vectors_)
{
    int64_t n_;
    bool loaded_;
    int64_t slot_;
    real half_;
    real sixth_;
    tuple_4 error_;
    real load_;
    tuple_5 twist_;
    tuple_4 m1_;
    tuple_3 r1_;
    tuple_4 m2_;
    tuple_3 r2_;
    tuple_4 m3_;
    tuple_3 r3_;
    tuple_4 m4_;
    tuple_3 r4_;
    real moved1_;
    real moved2_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    slot_ = theta_.f0;
    real t1 = ((real)0.5 * h_);
    real t2 = (h_ / (real)6.0);
    half_ = t1;
    sixth_ = t2;
    error_ = (tuple_4){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    load_ = (real)0.0;
    if (((n_ > 5))) {
        if (((current_.p[28] > (real)0.0))) {
            load_ = s_.p[gm_at((int64_t)(current_.p[28]), s_.n[0])];
        }
        if (((current_.p[29] > (real)0.0))) {
            tuple_4 t3 = process_model_decay(s_.p[gm_at((int64_t)(current_.p[29]), s_.n[0])], half_, h_, current_);
            error_ = t3;
            s_.p[gm_at((int64_t)(current_.p[29]), s_.n[0])] = error_.v[4];
        }
    }
    twist_ = (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((slot_ == 26))) {
        twist_ = (tuple_5){{(current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 0)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 1)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 2)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 3)])}};
    }
    m1_ = (tuple_4){{s_.p[0], s_.p[2], s_.p[3], s_.p[4], s_.p[1]}};
    tuple_3 t4 = aekf_sensitivity_rates(loaded_, m1_, 0, theta_, error_.v[0], load_, current_, vectors_);
    r1_ = t4;
    tuple_4 t5 = process_model_along(m1_, half_, m1_, r1_, current_);
    tuple_4 t6 = aekf_added(t5, (half_ * twist_.v[0]));
    m2_ = t6;
    tuple_3 t7 = aekf_sensitivity_rates(loaded_, m2_, 1, theta_, error_.v[1], load_, current_, vectors_);
    r2_ = t7;
    tuple_4 t8 = process_model_along(m1_, half_, m2_, r2_, current_);
    tuple_4 t9 = aekf_added(t8, (half_ * twist_.v[1]));
    m3_ = t9;
    tuple_3 t10 = aekf_sensitivity_rates(loaded_, m3_, 2, theta_, error_.v[2], load_, current_, vectors_);
    r3_ = t10;
    tuple_4 t11 = process_model_along(m1_, h_, m3_, r3_, current_);
    tuple_4 t12 = aekf_added(t11, (h_ * twist_.v[2]));
    m4_ = t12;
    tuple_3 t13 = aekf_sensitivity_rates(loaded_, m4_, 3, theta_, error_.v[3], load_, current_, vectors_);
    r4_ = t13;
    moved1_ = (sixth_ * ((m1_.v[1] + ((real)2.0 * (m2_.v[1] + m3_.v[1]))) + m4_.v[1]));
    moved2_ = (sixth_ * ((m1_.v[2] + ((real)2.0 * (m2_.v[2] + m3_.v[2]))) + m4_.v[2]));
    s_.p[0] = (s_.p[0] + moved1_);
    s_.p[1] = (s_.p[1] + moved2_);
    s_.p[2] = (s_.p[2] + (sixth_ * ((r1_.v[0] + ((real)2.0 * (r2_.v[0] + r3_.v[0]))) + r4_.v[0])));
    s_.p[3] = (s_.p[3] + (sixth_ * ((r1_.v[1] + ((real)2.0 * (r2_.v[1] + r3_.v[1]))) + r4_.v[1])));
    s_.p[4] = (s_.p[4] + ((current_.p[26] * (moved1_ - moved2_)) + (sixth_ * ((twist_.v[0] + ((real)2.0 * (twist_.v[1] + twist_.v[2]))) + twist_.v[3]))));
    return;
}

/* estimation/filters/aekf.py:572 _add_products */
GM_INLINE void aekf_add_products(Layout layout_, array1_f8 P_i_, real factor_, int64_t at_, real h_, int64_t g_, int64_t w_, array1_f8 flat_)
{
    int64_t n_;
    int64_t a_;
    int64_t b_;
    real total_;
    int64_t q_;
    real value_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        a_ = k1;
        int64_t t2 = (a_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            b_ = k3;
            total_ = (real)0.0;
            for (int64_t k4 = 0; k4 < 3; k4 += 1) {
                q_ = k4;
                total_ = gm_fma(flat_.p[((((g_ + q_) * n_) + a_))], flat_.p[((((w_ + q_) * n_) + b_))], total_);
                total_ = gm_fma(flat_.p[((((w_ + q_) * n_) + a_))], flat_.p[((((g_ + q_) * n_) + b_))], total_);
            }
            if (((a_ == at_))) {
                total_ = (total_ + ((h_ / (real)6.0) * flat_.p[((((w_ + 3) * n_) + b_))]));
            }
            if (((b_ == at_))) {
                total_ = (total_ + ((h_ / (real)6.0) * flat_.p[((((w_ + 3) * n_) + a_))]));
            }
            value_ = (P_i_.p[(((a_ * n_) + b_))] + (factor_ * total_));
            P_i_.p[(((a_ * n_) + b_))] = value_;
            P_i_.p[(((b_ * n_) + a_))] = value_;
        }
    }
    return;
}

/* estimation/filters/aekf.py:548 _advance_covariance */
GM_INLINE void aekf_advance_covariance(Layout layout_, array1_f8 P_i_, int64_t slot_, real h_, array1_f8 current_, array2_f8 vectors_, array1_f8 flat_)
{
    int64_t n_;
    int64_t q_;
    real c_;
    real d_;
    int64_t a_;
    real w_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < 4; k1 += 1) {
        q_ = k1;
        real t2 = vectors_.p[(24 * vectors_.n[1] + (q_))];
        real t3 = vectors_.p[(25 * vectors_.n[1] + (q_))];
        c_ = t2;
        d_ = t3;
        for (int64_t k4 = 0; k4 < n_; k4 += 1) {
            a_ = k4;
            w_ = (c_ * flat_.p[((((30 + q_) * n_) + a_))]);
            if (((current_.p[19] > (real)0.0))) {
                w_ = (w_ + (d_ * flat_.p[((((34 + q_) * n_) + a_))]));
            }
            flat_.p[((((46 + q_) * n_) + a_))] = w_;
        }
    }
    aekf_add_products(layout_, P_i_, (real)1.0, 2, h_, 26, 46, flat_);
    if (((slot_ == 26))) {
        aekf_add_products(layout_, P_i_, current_.p[26], 4, h_, 38, 42, flat_);
    }
    if (layout_.loaded_) {
        for (int64_t k5 = 0; k5 < 4; k5 += 1) {
            q_ = k5;
            real t6 = vectors_.p[(76 * vectors_.n[1] + (q_))];
            real t7 = vectors_.p[(77 * vectors_.n[1] + (q_))];
            c_ = t6;
            d_ = t7;
            for (int64_t k8 = 0; k8 < n_; k8 += 1) {
                a_ = k8;
                flat_.p[((((46 + q_) * n_) + a_))] = ((c_ * flat_.p[((((66 + q_) * n_) + a_))]) + (d_ * flat_.p[((((70 + q_) * n_) + a_))]));
            }
        }
        aekf_add_products(layout_, P_i_, (real)1.0, 3, h_, 62, 46, flat_);
    }
    return;
}

/* estimation/filters/aekf.py:463 _predict */
GM_INLINE void aekf_predict(Layout layout_, Belief belief_, BeliefSensitivity sensitivity_, Reading reading_, array1_f8 current_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    int64_t n_;
    bool loaded_;
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    tuple_3 torques_;
    array2_f8 s_;
    array2_f8 P_s_;
    int64_t count_;
    array2_f8 vectors_;
    array2_f8 matrices_;
    int64_t at_z_;
    int64_t at_P_;
    int64_t at_cross_;
    array1_f8 product_;
    array1_f8 change_;
    array1_f8 phi_;
    array1_f8 cross_;
    array1_f8 P_pred_;
    array1_f8 flat_;
    bool with_twist_;
    bool with_atan_;
    bool with_viscous_;
    int64_t i_;
    bool stiffer_;
    int64_t counted_;
    real h_;
    real half_;
    real motor_;
    real arm_;
    array1_f8 row_;
    int64_t part_;
    int64_t j_;
    int64_t slot_;
    tuple_3 sharper_;
    n_ = layout_.n_;
    loaded_ = layout_.loaded_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    torques_ = (tuple_3){{reading_.u_, reading_.load_}};
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    vectors_ = scratch_.vectors_;
    matrices_ = scratch_.matrices_;
    tuple_2 t1 = step_record_places(n_);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    product_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    change_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    phi_ = (array1_f8){matrices_.p + 2 * (matrices_.n[1]), {matrices_.n[1]}};
    int64_t t2 = (at_cross_ + (n_ * n_));
    int64_t t3 = gm_bound(at_cross_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = (at_P_ + (n_ * n_));
    int64_t t7 = gm_bound(at_P_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    cross_ = (array1_f8){record_.p + t3 * (1), {t5}};
    P_pred_ = (array1_f8){record_.p + t7 * (1), {t9}};
    int64_t t10 = (95 * n_);
    flat_ = (array1_f8){vectors_.p, {t10}};
    with_twist_ = false;
    with_atan_ = false;
    with_viscous_ = false;
    for (int64_t k11 = 0; k11 < count_; k11 += 1) {
        i_ = k11;
        with_twist_ = (with_twist_ | ((p_.p[((46 + i_))] == (real)26.0)));
        with_atan_ = (with_atan_ | ((p_.p[((46 + i_))] == (real)4.0)));
        with_viscous_ = (with_viscous_ | ((p_.p[((46 + i_))] == (real)3.0)));
    }
    stiffer_ = ((with_twist_ || with_atan_) || with_viscous_);
    real t13;
    if (stiffer_) {
    real t12 = aekf_eigenvalue(current_, p_);
        t13 = t12;
    } else {
        t13 = p_.p[30];
    }
    int64_t t14 = drive_substeps(dt_, t13);
    counted_ = t14;
    h_ = (dt_ / (real)(counted_));
    half_ = ((real)0.5 * dt_);
    real t15 = current_.p[5];
    real t16 = current_.p[15];
    motor_ = t15;
    arm_ = t16;
    if (((p_.p[37] > (real)0.0))) {
        real t17 = process_model_softened_sharpness(motor_, P_.p[(((2 * n_) + 2))]);
        current_.p[5] = t17;
        real t18 = process_model_softened_sharpness(arm_, P_.p[(((3 * n_) + 3))]);
        current_.p[15] = t18;
        for (int64_t k19 = 0; k19 < count_; k19 += 1) {
            i_ = k19;
            row_ = (array1_f8){vectors_.p + ((78 + i_)) * (vectors_.n[1]), {vectors_.n[1]}};
            row_.p[0] = ((((-current_.p[5]) * current_.p[5]) / (real)3.141592653589793) * P_s_.p[((i_) * P_s_.n[1] + (((2 * n_) + 2)))]);
            row_.p[1] = ((((-current_.p[15]) * current_.p[15]) / (real)3.141592653589793) * P_s_.p[((i_) * P_s_.n[1] + (((3 * n_) + 3)))]);
        }
    }
    aekf_add_noise(layout_, z_, sensitivity_, half_, current_, p_);
    for (int64_t k20 = 0; k20 < n_; k20 += 1) {
        i_ = k20;
        real t21 = process_model_noise(z_, current_, i_);
        record_.p[((at_z_ + i_))] = (half_ * t21);
    }
    for (int64_t k22 = 0; k22 < counted_; k22 += 1) {
        part_ = k22;
        process_model_rk4_2(layout_, z_, phi_, true, torques_, h_, current_, vectors_);
        aekf_look(loaded_, with_atan_, current_, vectors_);
        if (((part_ == 0))) {
            linalg_multiply(layout_, phi_, P_, cross_);
            for (int64_t k23 = 0; k23 < n_; k23 += 1) {
                i_ = k23;
                for (int64_t k24 = 0; k24 < n_; k24 += 1) {
                    j_ = k24;
                    product_.p[(((i_ * n_) + j_))] = gm_fma(phi_.p[(((i_ * n_) + j_))], record_.p[((at_z_ + j_))], cross_.p[(((i_ * n_) + j_))]);
                }
            }
        } else {
            linalg_multiply(layout_, phi_, cross_, product_);
            int64_t t25 = (n_ * n_);
            for (int64_t k26 = 0; k26 < t25; k26 += 1) {
                i_ = k26;
                cross_.p[(i_)] = product_.p[(i_)];
            }
            linalg_multiply(layout_, phi_, P_pred_, product_);
        }
        linalg_multiply_symmetric(layout_, product_, phi_, P_pred_);
        aekf_answers(layout_, (tuple_4){{(real)0.0, (real)0.0, (real)1.0, (real)0.0, (real)0.0}}, 26, h_, current_, vectors_);
        aekf_times(layout_, product_, 0, flat_, 30);
        if (((current_.p[19] > (real)0.0))) {
            aekf_times(layout_, product_, 8, flat_, 34);
        }
        if (with_twist_) {
            aekf_answers(layout_, (tuple_4){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)1.0}}, 38, h_, current_, vectors_);
            aekf_times(layout_, product_, 4, flat_, 42);
        }
        if (loaded_) {
            aekf_answers(layout_, (tuple_4){{(real)0.0, (real)0.0, (real)0.0, (real)1.0, (real)0.0}}, 62, h_, current_, vectors_);
            aekf_times_2(layout_, product_, (-11), flat_, 66);
            aekf_times_2(layout_, product_, (-7), flat_, 70);
        }
        for (int64_t k27 = 0; k27 < count_; k27 += 1) {
            i_ = k27;
            slot_ = (int64_t)(p_.p[((46 + i_))]);
            sharper_ = (tuple_3){{vectors_.p[(((78 + i_)) * vectors_.n[1] + 0)], vectors_.p[(((78 + i_)) * vectors_.n[1] + 1)]}};
            aekf_advance_sensitivity(layout_, (array1_f8){s_.p + (i_) * (s_.n[1]), {s_.n[1]}}, (tuple_13){slot_, sharper_}, h_, current_, vectors_);
            linalg_multiply(layout_, phi_, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}}, change_);
            linalg_multiply_symmetric(layout_, change_, phi_, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}});
            aekf_advance_covariance(layout_, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}}, slot_, h_, current_, vectors_, flat_);
        }
    }
    current_.p[5] = motor_;
    current_.p[15] = arm_;
    aekf_add_noise(layout_, z_, sensitivity_, half_, current_, p_);
    for (int64_t k28 = 0; k28 < n_; k28 += 1) {
        i_ = k28;
        real t30 = P_pred_.p[(((i_ * n_) + i_))];
        real t29 = process_model_noise(z_, current_, i_);
        P_pred_.p[(((i_ * n_) + i_))] = (t30 + (half_ * t29));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    return;
}

/* estimation/filters/aekf.py:610 _correct */
GM_INLINE void aekf_correct(Layout layout_, BeliefSensitivity sensitivity_, array1_f8 current_, array1_f8 p_, array2_f8 vectors_, array1_f8 record_)
{
    int64_t n_;
    array2_f8 s_;
    array2_f8 P_s_;
    int64_t count_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t at_K_;
    real e1_;
    real e2_;
    bool have1_;
    bool have2_;
    real big_s11_;
    real big_s12_;
    real big_s22_;
    real j11_;
    real j21_;
    real j22_;
    real root_;
    real root_det_;
    real i11_;
    real i12_;
    real i22_;
    real white1_;
    real white2_;
    array1_f8 w1_;
    array1_f8 w2_;
    int64_t i_;
    int64_t slot_;
    array1_f8 s_i_;
    array1_f8 P_i_;
    real d1_;
    real d2_;
    real s11_;
    real s12_;
    real s22_;
    int64_t a_;
    real c1_;
    real c2_;
    real b1_;
    real b2_;
    real k1_;
    real k2_;
    int64_t b_;
    real value_;
    real f1_;
    real f2_;
    real t1_;
    real t2_;
    real v11_;
    real v12_;
    real v22_;
    array1_f8 row_;
    n_ = layout_.n_;
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    tuple_2 t1 = step_record_places(n_);
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    at_K_ = t1.v[7];
    real t2 = record_.p[(at_innovation_)];
    real t3 = record_.p[((at_innovation_ + 1))];
    e1_ = t2;
    e2_ = t3;
    bool t4 = (bool)isfinite(e1_);
    bool t5 = (bool)isfinite(e2_);
    have1_ = t4;
    have2_ = t5;
    real t6 = (have1_ ? e1_ : (real)0.0);
    real t7 = (have2_ ? e2_ : (real)0.0);
    e1_ = t6;
    e2_ = t7;
    real t8 = record_.p[(at_S_)];
    real t9 = record_.p[((at_S_ + 1))];
    real t10 = record_.p[((at_S_ + 2))];
    big_s11_ = t8;
    big_s12_ = t9;
    big_s22_ = t10;
    j11_ = (real)0.0;
    j21_ = (real)0.0;
    j22_ = (real)0.0;
    if ((have1_ && have2_)) {
        real t11 = gm_sqrt(big_s11_);
        real t12 = gm_sqrt(((big_s11_ * big_s22_) - (big_s12_ * big_s12_)));
        root_ = t11;
        root_det_ = t12;
        real t13 = ((real)1.0 / root_);
        real t14 = ((-big_s12_) / (root_ * root_det_));
        real t15 = (root_ / root_det_);
        j11_ = t13;
        j21_ = t14;
        j22_ = t15;
    } else {
        if (have1_) {
            j11_ = ((real)1.0 / gm_sqrt(big_s11_));
        } else {
            if (have2_) {
                j22_ = ((real)1.0 / gm_sqrt(big_s22_));
            }
        }
    }
    real t16 = ((j11_ * j11_) + (j21_ * j21_));
    real t17 = (j21_ * j22_);
    real t18 = (j22_ * j22_);
    i11_ = t16;
    i12_ = t17;
    i22_ = t18;
    real t19 = (j11_ * e1_);
    real t20 = ((j21_ * e1_) + (j22_ * e2_));
    white1_ = t19;
    white2_ = t20;
    w1_ = (array1_f8){vectors_.p + 22 * (vectors_.n[1]), {vectors_.n[1]}};
    w2_ = (array1_f8){vectors_.p + 23 * (vectors_.n[1]), {vectors_.n[1]}};
    for (int64_t k21 = 0; k21 < count_; k21 += 1) {
        i_ = k21;
        slot_ = (int64_t)(p_.p[((46 + i_))]);
        s_i_ = (array1_f8){s_.p + (i_) * (s_.n[1]), {s_.n[1]}};
        P_i_ = (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}};
        d1_ = (have1_ ? (-s_i_.p[0]) : (real)0.0);
        d2_ = (have2_ ? (-s_i_.p[1]) : (real)0.0);
        s11_ = (P_i_.p[0] + (((slot_ == 31)) ? current_.p[31] : (real)0.0));
        s12_ = P_i_.p[1];
        s22_ = (P_i_.p[((n_ + 1))] + (((slot_ == 32)) ? current_.p[32] : (real)0.0));
        for (int64_t k22 = 0; k22 < n_; k22 += 1) {
            a_ = k22;
            c1_ = ((record_.p[((at_K_ + (2 * a_)))] * s11_) + (record_.p[(((at_K_ + (2 * a_)) + 1))] * s12_));
            c2_ = ((record_.p[((at_K_ + (2 * a_)))] * s12_) + (record_.p[(((at_K_ + (2 * a_)) + 1))] * s22_));
            real t23 = P_i_.p[((a_ * n_))];
            real t24 = P_i_.p[(((a_ * n_) + 1))];
            b1_ = t23;
            b2_ = t24;
            k1_ = (((b1_ - c1_) * i11_) + ((b2_ - c2_) * i12_));
            k2_ = (((b1_ - c1_) * i12_) + ((b2_ - c2_) * i22_));
            s_i_.p[(a_)] = (s_i_.p[(a_)] + ((((k1_ * e1_) + (k2_ * e2_)) + (record_.p[((at_K_ + (2 * a_)))] * d1_)) + (record_.p[(((at_K_ + (2 * a_)) + 1))] * d2_)));
            real t25 = (b1_ - ((real)0.5 * c1_));
            real t26 = (b2_ - ((real)0.5 * c2_));
            w1_.p[(a_)] = t25;
            w2_.p[(a_)] = t26;
        }
        for (int64_t k27 = 0; k27 < n_; k27 += 1) {
            a_ = k27;
            real t28 = record_.p[((at_K_ + (2 * a_)))];
            real t29 = record_.p[(((at_K_ + (2 * a_)) + 1))];
            k1_ = t28;
            k2_ = t29;
            int64_t t30 = (a_ + 1);
            for (int64_t k31 = 0; k31 < t30; k31 += 1) {
                b_ = k31;
                value_ = ((((P_i_.p[(((a_ * n_) + b_))] - (k1_ * w1_.p[(b_)])) - (k2_ * w2_.p[(b_)])) - (w1_.p[(a_)] * record_.p[((at_K_ + (2 * b_)))])) - (w2_.p[(a_)] * record_.p[(((at_K_ + (2 * b_)) + 1))]));
                P_i_.p[(((a_ * n_) + b_))] = value_;
                P_i_.p[(((b_ * n_) + a_))] = value_;
            }
        }
        real t32 = (j11_ * d1_);
        real t33 = ((j21_ * d1_) + (j22_ * d2_));
        f1_ = t32;
        f2_ = t33;
        real t34 = ((j21_ * s11_) + (j22_ * s12_));
        real t35 = ((j21_ * s12_) + (j22_ * s22_));
        t1_ = t34;
        t2_ = t35;
        real t36 = ((j11_ * j11_) * s11_);
        real t37 = (j11_ * t1_);
        real t38 = ((j21_ * t1_) + (j22_ * t2_));
        v11_ = t36;
        v12_ = t37;
        v22_ = t38;
        row_ = (array1_f8){vectors_.p + ((50 + i_)) * (vectors_.n[1]), {vectors_.n[1]}};
        row_.p[0] = f1_;
        row_.p[1] = f2_;
        row_.p[2] = v11_;
        row_.p[3] = v12_;
        row_.p[4] = v22_;
        vectors_.p[(((56 + i_)) * vectors_.n[1] + 0)] = ((((f1_ * white1_) + (f2_ * white2_)) + ((real)0.5 * (v11_ + v22_))) - ((real)0.5 * ((((white1_ * white1_) * v11_) + ((((real)2.0 * white1_) * white2_) * v12_)) + ((white2_ * white2_) * v22_))));
    }
    return;
}

/* estimation/filters/aekf.py:295 _sound */
GM_INLINE bool aekf_sound(Layout layout_, array1_f8 s_, array1_f8 P_s_)
{
    int64_t n_;
    real of_s_;
    real of_P_;
    int64_t a_;
    int64_t b_;
    n_ = layout_.n_;
    of_s_ = (real)0.0;
    of_P_ = (real)0.0;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        a_ = k1;
        of_s_ = (of_s_ + (s_.p[(a_)] * s_.p[(a_)]));
        int64_t t2 = (a_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            b_ = k3;
            of_P_ = (of_P_ + (P_s_.p[(((a_ * n_) + b_))] * P_s_.p[(((a_ * n_) + b_))]));
        }
    }
    return (((of_s_ <= (real)10000000000.0)) && ((of_P_ <= (real)100000000000000.0)));
}

/* estimation/filters/aekf.py:260 differentiate */
GM_APART bool aekf_differentiate(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    int64_t n_;
    array1_f8 memory_;
    array2_f8 vectors_;
    array1_f8 current_;
    int64_t count_;
    array2_f8 s_;
    array2_f8 P_s_;
    int64_t i_;
    int64_t a_;
    n_ = layout_.n_;
    memory_ = belief_.memory_;
    vectors_ = scratch_.vectors_;
    int64_t t1 = gm_bound(41, memory_.n[0]);
    int64_t t2 = gm_bound(115, memory_.n[0]);
    int64_t t3 = gm_span(t1, t2);
    current_ = (array1_f8){memory_.p + t1 * (1), {t3}};
    count_ = (int64_t)(p_.p[45]);
    int64_t t4 = (115 + (6 * n_));
    int64_t t5 = gm_bound(115, memory_.n[0]);
    int64_t t6 = gm_bound(t4, memory_.n[0]);
    int64_t t7 = gm_span(t5, t6);
    s_ = (array2_f8){memory_.p + t5 * (1), {6, n_}};
    int64_t t8 = (115 + (6 * n_));
    int64_t t9 = gm_bound(t8, memory_.n[0]);
    int64_t t10 = gm_span(t9, memory_.n[0]);
    int64_t t11 = (n_ * n_);
    P_s_ = (array2_f8){memory_.p + t9 * (1), {6, t11}};
    aekf_predict(layout_, belief_, (BeliefSensitivity){s_, P_s_, count_}, reading_, current_, p_, scratch_, record_);
    bool t12 = ekf_update(layout_, belief_, reading_.y1_, reading_.y2_, current_, record_);
    if ((!t12)) {
        return false;
    }
    aekf_correct(layout_, (BeliefSensitivity){s_, P_s_, count_}, current_, p_, vectors_, record_);
    for (int64_t k13 = 0; k13 < count_; k13 += 1) {
        i_ = k13;
        bool t14 = aekf_sound(layout_, (array1_f8){s_.p + (i_) * (s_.n[1]), {s_.n[1]}}, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}});
        if ((!t14)) {
            memory_.p[4] = (memory_.p[4] + (real)1.0);
            for (int64_t k15 = 0; k15 < n_; k15 += 1) {
                a_ = k15;
                s_.p[((i_) * s_.n[1] + (a_))] = (real)0.0;
            }
            int64_t t16 = (n_ * n_);
            for (int64_t k17 = 0; k17 < t16; k17 += 1) {
                a_ = k17;
                P_s_.p[((i_) * P_s_.n[1] + (a_))] = (real)0.0;
            }
            vectors_.p[(((56 + i_)) * vectors_.n[1] + 0)] = (real)0.0;
            for (int64_t k18 = 0; k18 < 5; k18 += 1) {
                a_ = k18;
                vectors_.p[(((50 + i_)) * vectors_.n[1] + (a_))] = (real)0.0;
            }
        }
    }
    bool t19 = ekf_healthy(layout_, belief_);
    return t19;
}

/* estimation/filters/aekf.py:253 information */
GM_INLINE real aekf_information(array2_f8 vectors_, int64_t i_, int64_t j_)
{
    array1_f8 a_;
    array1_f8 b_;
    a_ = (array1_f8){vectors_.p + ((50 + i_)) * (vectors_.n[1]), {vectors_.n[1]}};
    b_ = (array1_f8){vectors_.p + ((50 + j_)) * (vectors_.n[1]), {vectors_.n[1]}};
    return (((a_.p[0] * b_.p[0]) + (a_.p[1] * b_.p[1])) + ((real)0.5 * (((a_.p[2] * b_.p[2]) + (((real)2.0 * a_.p[3]) * b_.p[3])) + (a_.p[4] * b_.p[4]))));
}

/* estimation/filters/aekf.py:708 _solve */
GM_INLINE bool aekf_solve(array1_f8 memory_, int64_t count_, real ridge_, array2_f8 vectors_, array1_f8 factor_)
{
    int64_t j_;
    int64_t at_j_;
    int64_t i_;
    int64_t at_i_;
    real total_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < count_; k1 += 1) {
        j_ = k1;
        at_j_ = ((j_ * (j_ + 1)) / 2);
        for (int64_t k2 = j_; k2 < count_; k2 += 1) {
            i_ = k2;
            at_i_ = ((i_ * (i_ + 1)) / 2);
            total_ = (memory_.p[(((20 + at_i_) + j_))] + (((i_ == j_)) ? ridge_ : (real)0.0));
            for (int64_t k3 = 0; k3 < j_; k3 += 1) {
                k_ = k3;
                total_ = (total_ - ((factor_.p[((at_i_ + k_))] * factor_.p[((at_j_ + k_))]) * factor_.p[((((k_ * (k_ + 1)) / 2) + k_))]));
            }
            if ((((i_ == j_)) && (!((total_ > (real)0.0))))) {
                return false;
            }
            factor_.p[((at_i_ + j_))] = (((i_ == j_)) ? ((real)1.0 / total_) : total_);
        }
    }
    for (int64_t k4 = 0; k4 < count_; k4 += 1) {
        i_ = k4;
        total_ = vectors_.p[(((56 + i_)) * vectors_.n[1] + 0)];
        int64_t t5 = i_;
        for (int64_t k6 = 0; k6 < t5; k6 += 1) {
            k_ = k6;
            total_ = (total_ - (factor_.p[((((i_ * (i_ + 1)) / 2) + k_))] * vectors_.p[(((56 + k_)) * vectors_.n[1] + 1)]));
        }
        vectors_.p[(((56 + i_)) * vectors_.n[1] + 1)] = (total_ * factor_.p[((((i_ * (i_ + 1)) / 2) + i_))]);
    }
    int64_t t7 = (count_ - 1);
    for (int64_t k8 = t7; k8 > (-1); k8 += -1) {
        i_ = k8;
        total_ = (real)0.0;
        int64_t t9 = (i_ + 1);
        for (int64_t k10 = t9; k10 < count_; k10 += 1) {
            k_ = k10;
            total_ = (total_ + (factor_.p[((((k_ * (k_ + 1)) / 2) + i_))] * vectors_.p[(((56 + k_)) * vectors_.n[1] + 1)]));
        }
        vectors_.p[(((56 + i_)) * vectors_.n[1] + 1)] = (vectors_.p[(((56 + i_)) * vectors_.n[1] + 1)] - (total_ * factor_.p[((((i_ * (i_ + 1)) / 2) + i_))]));
    }
    for (int64_t k11 = 0; k11 < count_; k11 += 1) {
        i_ = k11;
        if ((!(bool)isfinite(vectors_.p[(((56 + i_)) * vectors_.n[1] + 1)]))) {
            return false;
        }
    }
    return true;
}

/* estimation/filters/aekf.py:228 _range */
GM_STATIC real aekf_range(int64_t slot_)
{
    return (((((slot_ == 3)) || ((slot_ == 4))) || ((slot_ == 26))) ? (real)3.4011973816621555 : (real)13.815510557964274);
}

/* estimation/filters/aekf.py:668 _adapt */
GM_INLINE void aekf_adapt(Layout layout_, array1_f8 memory_, array1_f8 p_, array2_f8 vectors_, array2_f8 matrices_, array1_f8 record_)
{
    int64_t at_scores_;
    int64_t count_;
    real gain_;
    int64_t i_;
    int64_t j_;
    int64_t place_;
    bool limited_;
    bool clipped_;
    real change_;
    int64_t slot_;
    real width_;
    real theta_;
    tuple_2 t1 = step_record_places(layout_.n_);
    at_scores_ = t1.v[8];
    if (((record_.p[((at_scores_ + 2))] == (real)0.0))) {
        return;
    }
    count_ = (int64_t)(p_.p[45]);
    gain_ = memory_.p[2];
    for (int64_t k2 = 0; k2 < count_; k2 += 1) {
        i_ = k2;
        int64_t t3 = (i_ + 1);
        for (int64_t k4 = 0; k4 < t3; k4 += 1) {
            j_ = k4;
            place_ = ((20 + ((i_ * (i_ + 1)) / 2)) + j_);
            real t7 = memory_.p[(place_)];
            real t6 = gain_;
            real t5 = aekf_information(vectors_, i_, j_);
            memory_.p[(place_)] = (t7 + (t6 * (t5 - memory_.p[(place_)])));
        }
    }
    gain_ = (gain_ / (gain_ + memory_.p[3]));
    memory_.p[2] = gain_;
    memory_.p[3] = (memory_.p[3] + (((real)1.0 - p_.p[43]) * (p_.p[44] - memory_.p[3])));
    memory_.p[1] = (memory_.p[1] + (real)1.0);
    if (((memory_.p[1] <= (real)200.0))) {
        return;
    }
    bool t8 = aekf_solve(memory_, count_, (gain_ * (real)20.0), vectors_, (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}});
    if ((!t8)) {
        memory_.p[7] = (memory_.p[7] + (real)1.0);
        return;
    }
    limited_ = false;
    clipped_ = false;
    for (int64_t k9 = 0; k9 < count_; k9 += 1) {
        i_ = k9;
        change_ = ((-gain_) * vectors_.p[(((56 + i_)) * vectors_.n[1] + 1)]);
        if (((gm_fabs(change_) > (real)0.05))) {
            change_ = (((change_ > (real)0.0)) ? (real)0.05 : (real)(-0.05));
            limited_ = true;
        }
        slot_ = (int64_t)(p_.p[((46 + i_))]);
        real t10 = aekf_range(slot_);
        width_ = t10;
        theta_ = (memory_.p[((8 + i_))] + change_);
        if (((gm_fabs((theta_ - memory_.p[((14 + i_))])) > width_))) {
            theta_ = (memory_.p[((14 + i_))] + (((theta_ > memory_.p[((14 + i_))])) ? width_ : (-width_)));
            clipped_ = true;
        }
        memory_.p[((8 + i_))] = theta_;
        memory_.p[gm_at((41 + slot_), memory_.n[0])] = gm_exp(theta_);
    }
    memory_.p[5] = (memory_.p[5] + (limited_ ? (real)1.0 : (real)0.0));
    memory_.p[6] = (memory_.p[6] + (clipped_ ? (real)1.0 : (real)0.0));
    return;
}

/* estimation/filters/aekf.py:206 step */
GM_APART bool aekf_step(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    if (((p_.p[45] == (real)0.0))) {
        bool t1 = ekf_step(layout_, belief_, reading_, p_, scratch_, record_);
        return t1;
    }
    if (((belief_.memory_.p[0] == (real)0.0))) {
        aekf_begin(belief_.memory_, p_);
    }
    bool t2 = aekf_differentiate(layout_, belief_, reading_, p_, scratch_, record_);
    if ((!t2)) {
        return false;
    }
    aekf_adapt(layout_, belief_.memory_, p_, scratch_.vectors_, scratch_.matrices_, record_);
    return true;
}

/* estimation/filters/aekf.py:124 used */
GM_INLINE tuple_14 aekf_used(array1_f8 memory_, array1_f8 p_)
{
    array1_f8 current_;
    if (((memory_.p[0] == (real)0.0))) {
        return (tuple_14){p_, (real)0.0};
    }
    int64_t t1 = gm_bound(41, memory_.n[0]);
    int64_t t2 = gm_bound(115, memory_.n[0]);
    int64_t t3 = gm_span(t1, t2);
    current_ = (array1_f8){memory_.p + t1 * (1), {t3}};
    real t4 = aekf_eigenvalue(current_, p_);
    return (tuple_14){current_, (t4 - p_.p[30])};
}

/* estimation/process_model.py:643 _own_drive */
GM_INLINE tuple_16 process_model_own_drive(bool differ_, array1_f8 lanes_, int64_t at_, tuple_12 torques_, tuple_15 p_)
{
    array1_f8 f_;
    real u_;
    f_ = lanes_;
    u_ = ((f_.p[((at_ + 128))] * torques_.v[0]) - (f_.p[((at_ + 144))] * torques_.v[2]));
    return (tuple_16){u_, (tuple_15){{(p_.v[0] * f_.p[(at_)]), (p_.v[1] * f_.p[((at_ + 16))]), (p_.v[2] * f_.p[((at_ + 32))]), (p_.v[3] * f_.p[((at_ + 48))]), (p_.v[4] * f_.p[((at_ + 64))]), p_.v[5], p_.v[6], p_.v[7], p_.v[8], p_.v[9], p_.v[10], p_.v[11], p_.v[12], (p_.v[13] * f_.p[((at_ + 80))]), (p_.v[14] * f_.p[((at_ + 96))]), p_.v[15], p_.v[16], p_.v[17], p_.v[18], (p_.v[19] * f_.p[((at_ + 112))]), p_.v[20], p_.v[21], p_.v[22], p_.v[23], p_.v[24], p_.v[25], p_.v[26]}}};
}

/* estimation/process_model.py:210 _curve */
GM_INLINE tuple_5 process_model_curve_2(int64_t curve_, array1_f8 z_, int64_t width_, int64_t i_, int64_t at_, tuple_15 p_)
{
    int64_t count_;
    if (((curve_ < 0))) {
        return (tuple_5){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    }
    int64_t t1 = process_model_curve_count(curve_);
    count_ = t1;
    if (((count_ > 1))) {
        return (tuple_5){{z_.p[gm_at((((at_ + 1) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 2) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 3) * width_) + i_), z_.n[0])], p_.v[12]}};
    }
    return (tuple_5){{p_.v[9], (p_.v[9] * p_.v[10]), (((count_ > 0)) ? (p_.v[9] * p_.v[11]) : (real)0.0), p_.v[12]}};
}

/* plant/drive.py:959 steady_arm_load */
GM_INLINE real drive_steady_arm_load_2(real x4_, tuple_15 p_)
{
    return ((p_.v[13] * x4_) + p_.v[18]);
}

/* plant/drive.py:987 gravity */
GM_INLINE real drive_gravity_2(real x2_, tuple_15 p_)
{
    real t1 = elementary_sine((x2_ + p_.v[17]));
    return (p_.v[16] * t1);
}

/* plant/drive.py:965 arm_load */
GM_STATIC real drive_arm_load_2(real x2_, real x4_, tuple_15 p_)
{
    real torque_;
    real t1 = drive_steady_arm_load_2(x4_, p_);
    torque_ = t1;
    if ((((p_.v[14] != (real)0.0)) && ((p_.v[20] <= (real)1.0)))) {
        real t3 = torque_;
        real t2 = friction_law_side((p_.v[15] * x4_), p_.v[20]);
        torque_ = (t3 + (p_.v[14] * t2));
    }
    if (((p_.v[16] != (real)0.0))) {
        real t5 = torque_;
        real t4 = drive_gravity_2(x2_, p_);
        torque_ = (t5 + t4);
    }
    return torque_;
}

/* plant/drive.py:920 arm_constraint */
GM_STATIC real drive_arm_constraint_2(real x3_, real x4_, real tau_k_, real tau_arm_, tuple_15 p_)
{
    if ((((p_.v[20] <= (real)1.0)) || ((p_.v[14] == (real)0.0)))) {
        return (real)0.0;
    }
    real t1 = friction_law_holding((((p_.v[2] * (x3_ - x4_)) + tau_k_) - tau_arm_), ((p_.v[22] * x4_) / p_.v[1]), p_.v[14], p_.v[21], p_.v[23]);
    return t1;
}

/* plant/drive.py:811 motor_friction */
GM_INLINE real drive_motor_friction_2(real x3_, real tau_k_, tuple_15 p_)
{
    real t3 = (p_.v[3] * x3_);
    real t2 = ((p_.v[4] + (p_.v[19] * gm_fabs(tau_k_))) * (real)0.6366197723675814);
    real t1 = elementary_arctan((p_.v[5] * x3_));
    return (t3 + (t2 * t1));
}

/* plant/drive.py:871 motor_acceleration */
GM_INLINE real drive_motor_acceleration_2(real x1_, real x3_, real x4_, real u_, real tau_k_, tuple_15 p_)
{
    real t2 = ((((u_ + p_.v[7]) - (p_.v[2] * (x3_ - x4_))) - tau_k_) - (p_.v[6] * x1_));
    real t1 = drive_motor_friction_2(x3_, tau_k_, p_);
    return ((t2 - t1) * p_.v[0]);
}

/* plant/drive.py:892 motor_acceleration_by_law */
GM_STATIC real drive_motor_acceleration_by_law_2(real x1_, real x3_, real x4_, real u_, real tau_k_, tuple_15 p_)
{
    real torque_;
    real level_;
    if (((p_.v[20] == (real)0.0))) {
        real t1 = drive_motor_acceleration_2(x1_, x3_, x4_, u_, tau_k_, p_);
        return t1;
    }
    torque_ = (((((u_ + p_.v[7]) - (p_.v[2] * (x3_ - x4_))) - tau_k_) - (p_.v[6] * x1_)) - (p_.v[3] * x3_));
    level_ = ((p_.v[4] + p_.v[24]) + (p_.v[19] * gm_fabs(tau_k_)));
    if (((p_.v[20] == (real)1.0))) {
        real t3 = torque_;
        real t2 = friction_law_side((p_.v[5] * x3_), p_.v[20]);
        torque_ = (t3 - (level_ * t2));
    } else {
        real t5 = torque_;
        real t4 = friction_law_holding(torque_, ((p_.v[22] * x3_) / p_.v[0]), level_, p_.v[21], p_.v[23]);
        torque_ = (t5 - t4);
    }
    return (torque_ * p_.v[0]);
}

/* plant/drive.py:941 arm_acceleration */
GM_INLINE real drive_arm_acceleration_2(real x3_, real x4_, real tau_k_, real tau_arm_, tuple_15 p_)
{
    return ((((p_.v[2] * (x3_ - x4_)) + tau_k_) - tau_arm_) * p_.v[1]);
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_3 process_model_accelerations_2(Layout layout_, tuple_4 x_, real u_, real load_, tuple_15 p_)
{
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    real tau_k_;
    x1_ = x_.v[0];
    x2_ = x_.v[1];
    x3_ = x_.v[2];
    x4_ = x_.v[3];
    tau_k_ = x_.v[4];
    if (layout_.loaded_) {
        real t2 = load_;
        real t1 = drive_arm_load_2(x2_, x4_, p_);
        load_ = (t2 + t1);
    }
    if (layout_.law_) {
        real t4 = load_;
        real t3 = drive_arm_constraint_2(x3_, x4_, tau_k_, load_, p_);
        load_ = (t4 + t3);
        real t5 = drive_motor_acceleration_by_law_2(x1_, x3_, x4_, u_, tau_k_, p_);
        real t6 = drive_arm_acceleration_2(x3_, x4_, tau_k_, load_, p_);
        return (tuple_3){{t5, t6}};
    }
    real t7 = drive_motor_acceleration_2(x1_, x3_, x4_, u_, tau_k_, p_);
    real t8 = drive_arm_acceleration_2(x3_, x4_, tau_k_, load_, p_);
    return (tuple_3){{t7, t8}};
}

/* estimation/process_model.py:618 _stage */
GM_INLINE void process_model_stage(Layout layout_, array1_f8 lanes_, int64_t width_, int64_t q_, real part_, bool differ_, tuple_12 torques_, tuple_15 shared_)
{
    int64_t n_;
    int64_t curve_;
    array1_f8 z_;
    int64_t at_curve_;
    int64_t i_;
    real u_;
    tuple_15 drive_;
    tuple_5 law_;
    real memory_;
    int64_t at_;
    tuple_4 x_;
    int64_t last_;
    real x3_;
    real x4_;
    real f_;
    real g_;
    n_ = layout_.n_;
    curve_ = layout_.curve_;
    z_ = lanes_;
    int64_t t1 = process_model_curve_count(curve_);
    at_curve_ = ((n_ - t1) * 16);
    for (int64_t k2 = 0; k2 < width_; k2 += 1) {
        i_ = k2;
        tuple_16 t3 = process_model_own_drive(differ_, z_, (((n_ + 21) * 16) + i_), torques_, shared_);
        u_ = t3.f0;
        drive_ = t3.f1;
        int64_t t4 = process_model_curve_count(curve_);
        tuple_5 t5 = process_model_curve_2(curve_, z_, 16, i_, (n_ - t4), drive_);
        law_ = t5;
        real t6 = process_model_memory(curve_, z_, (at_curve_ + i_), (z_.p[((0 + i_))] - z_.p[((16 + i_))]));
        memory_ = t6;
        at_ = (((n_ + q_) * 16) + i_);
        x_ = (tuple_4){{z_.p[((0 + i_))], z_.p[((16 + i_))], z_.p[((32 + i_))], z_.p[((48 + i_))], z_.p[((64 + i_))]}};
        if (((q_ > 0))) {
            last_ = (at_ - 16);
            real t7 = z_.p[gm_at((last_ + 0), z_.n[0])];
            real t8 = z_.p[gm_at((last_ + 64), z_.n[0])];
            x3_ = t7;
            x4_ = t8;
            x_ = (tuple_4){{(x_.v[0] + (part_ * x3_)), (x_.v[1] + (part_ * x4_)), (x_.v[2] + (part_ * z_.p[gm_at((last_ + 128), z_.n[0])])), (x_.v[3] + (part_ * z_.p[gm_at((last_ + 192), z_.n[0])])), (x_.v[4] + ((part_ * drive_.v[26]) * (x3_ - x4_)))}};
        }
        tuple_4 t9 = process_model_bearing(layout_, x_, (tuple_6){memory_, law_});
        tuple_3 t10 = process_model_accelerations_2(layout_, t9, (u_ - z_.p[((at_ + 256))]), z_.p[((((n_ + 20) * 16) + i_))], drive_);
        f_ = t10.v[0];
        g_ = t10.v[1];
        real t11 = x_.v[2];
        real t12 = x_.v[3];
        z_.p[((at_ + 0))] = t11;
        z_.p[((at_ + 64))] = t12;
        z_.p[((at_ + 128))] = f_;
        z_.p[((at_ + 192))] = g_;
    }
    return;
}

/* estimation/process_model.py:676 _mean */
GM_INLINE real process_model_mean(array1_f8 lanes_, int64_t at_, real sixth_)
{
    return (sixth_ * ((lanes_.p[(at_)] + ((real)2.0 * (lanes_.p[((at_ + 16))] + lanes_.p[((at_ + 32))]))) + lanes_.p[((at_ + 48))]));
}

/* estimation/process_model.py:658 _finish */
GM_INLINE void process_model_finish(Layout layout_, array1_f8 lanes_, int64_t i_, real sixth_, tuple_15 p_)
{
    int64_t n_;
    int64_t curve_;
    array1_f8 z_;
    int64_t at_;
    int64_t at_curve_;
    tuple_5 law_;
    real memory_;
    real moved1_;
    real moved2_;
    n_ = layout_.n_;
    curve_ = layout_.curve_;
    z_ = lanes_;
    int64_t t2 = ((n_ * 16) + i_);
    int64_t t1 = process_model_curve_count(curve_);
    int64_t t3 = (n_ - t1);
    at_ = t2;
    at_curve_ = t3;
    tuple_5 t4 = process_model_curve_2(curve_, z_, 16, i_, at_curve_, p_);
    law_ = t4;
    real t5 = process_model_memory(curve_, z_, ((at_curve_ * 16) + i_), (real)0.0);
    memory_ = t5;
    real t6 = process_model_mean(z_, (at_ + 0), sixth_);
    real t7 = process_model_mean(z_, (at_ + 64), sixth_);
    moved1_ = t6;
    moved2_ = t7;
    z_.p[((0 + i_))] = (z_.p[((0 + i_))] + moved1_);
    z_.p[((16 + i_))] = (z_.p[((16 + i_))] + moved2_);
    real t9 = z_.p[((32 + i_))];
    real t8 = process_model_mean(z_, (at_ + 128), sixth_);
    z_.p[((32 + i_))] = (t9 + t8);
    real t11 = z_.p[((48 + i_))];
    real t10 = process_model_mean(z_, (at_ + 192), sixth_);
    z_.p[((48 + i_))] = (t11 + t10);
    z_.p[((64 + i_))] = (z_.p[((64 + i_))] + (p_.v[26] * (moved1_ - moved2_)));
    int64_t t12 = process_model_curve_count(curve_);
    if (((t12 > 0))) {
        tuple_3 t13 = transmission_play((z_.p[((0 + i_))] - z_.p[((16 + i_))]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
        z_.p[gm_at(((at_curve_ * 16) + i_), z_.n[0])] = t13.v[0];
    }
    return;
}

/* estimation/process_model.py:567 advance_beside */
GM_STATIC void process_model_advance_beside(Layout layout_, array1_f8 lanes_, int64_t count_, bool differ_, tuple_12 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    int64_t n_;
    int64_t width_;
    real h_;
    int64_t at_load_;
    int64_t at_error_;
    int64_t friction_at_;
    real share_;
    tuple_15 drive_;
    int64_t i_;
    int64_t q_;
    tuple_4 error_;
    int64_t t1 = ((count_ + 3) & (-4));
    real t2 = (dt_ / (real)(n_substeps_));
    n_ = layout_.n_;
    width_ = t1;
    h_ = t2;
    int64_t t3 = ((n_ + 20) * 16);
    int64_t t4 = ((n_ + 16) * 16);
    int64_t t5 = ((int64_t)(p_.p[29]) * 16);
    at_load_ = t3;
    at_error_ = t4;
    friction_at_ = t5;
    share_ = (((p_.p[28] > (real)0.0)) ? (real)1.0 : (real)0.0);
    drive_ = (tuple_15){{p_.p[0], p_.p[1], p_.p[2], p_.p[3], p_.p[4], p_.p[5], p_.p[6], p_.p[7], p_.p[8], p_.p[9], p_.p[10], p_.p[11], p_.p[12], p_.p[13], p_.p[14], p_.p[15], p_.p[16], p_.p[17], p_.p[18], p_.p[19], p_.p[20], p_.p[21], p_.p[22], p_.p[23], p_.p[24], p_.p[25], p_.p[26]}};
    for (int64_t k6 = 0; k6 < width_; k6 += 1) {
        i_ = k6;
        lanes_.p[((at_load_ + i_))] = torques_.v[1];
        if (((n_ > 5))) {
            lanes_.p[((at_load_ + i_))] = (lanes_.p[((at_load_ + i_))] + (share_ * lanes_.p[((80 + i_))]));
        }
        for (int64_t k7 = 0; k7 < 4; k7 += 1) {
            q_ = k7;
            lanes_.p[(((at_error_ + (q_ * 16)) + i_))] = (real)0.0;
        }
    }
    for (int64_t k8 = 0; k8 < n_substeps_; k8 += 1) {
        if ((((n_ > 5)) && ((friction_at_ > 0)))) {
            for (int64_t k9 = 0; k9 < width_; k9 += 1) {
                i_ = k9;
                tuple_4 t10 = process_model_decay(lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])], ((real)0.5 * h_), h_, p_);
                error_ = t10;
                for (int64_t k11 = 0; k11 < 4; k11 += 1) {
                    q_ = k11;
                    lanes_.p[(((at_error_ + (q_ * 16)) + i_))] = error_.v[(q_)];
                }
                lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])] = error_.v[4];
            }
        }
        process_model_stage(layout_, lanes_, width_, 0, (real)0.0, differ_, torques_, drive_);
        process_model_stage(layout_, lanes_, width_, 1, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage(layout_, lanes_, width_, 2, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage(layout_, lanes_, width_, 3, h_, differ_, torques_, drive_);
        for (int64_t k12 = 0; k12 < width_; k12 += 1) {
            i_ = k12;
            process_model_finish(layout_, lanes_, i_, (h_ / (real)6.0), drive_);
        }
    }
    return;
}

/* estimation/step_record.py:24 sensitivities */
GM_INLINE tuple_17 step_record_sensitivities(int64_t n_, int64_t length_)
{
    int64_t begin_;
    int64_t size_;
    begin_ = (((4 * n_) + ((3 * n_) * n_)) + 8);
    size_ = gm_div(((length_ - begin_) - 1), 3);
    return (tuple_17){{gm_div(size_, n_), begin_, (begin_ + size_), (begin_ + (2 * size_))}};
}

/* estimation/consider.py:126 accompany */
GM_STATIC bool consider_accompany(Layout layout_, Companions companions_, array1_f8 z_, Reading reading_, tuple_14 used_, array1_f8 record_)
{
    int64_t n_;
    int64_t count_;
    array1_f8 s_;
    array1_f8 lanes_;
    array1_f8 p_;
    real faster_;
    real last_;
    real rate_;
    int64_t j_;
    int64_t i_;
    int64_t at_K_;
    int64_t at_predicted_;
    int64_t at_updated_;
    bool good_;
    int64_t at_;
    real e1_;
    real e2_;
    real value_;
    n_ = layout_.n_;
    count_ = companions_.number_;
    s_ = companions_.s_;
    lanes_ = companions_.lanes_;
    p_ = used_.f0;
    faster_ = used_.f1;
    real t1 = s_.p[(s_.n[0] - 1)];
    last_ = t1;
    s_.p[(s_.n[0] - 1)] = reading_.u_;
    if (((count_ == 0))) {
        return true;
    }
    rate_ = ((bool)isfinite(last_) ? ((reading_.u_ - last_) / reading_.dt_) : (real)0.0);
    for (int64_t k2 = 0; k2 < n_; k2 += 1) {
        j_ = k2;
        for (int64_t k3 = 0; k3 < 16; k3 += 1) {
            i_ = k3;
            lanes_.p[(((j_ * 16) + i_))] = z_.p[(j_)];
        }
        for (int64_t k4 = 0; k4 < count_; k4 += 1) {
            i_ = k4;
            lanes_.p[((((j_ * 16) + 1) + i_))] = (lanes_.p[((((j_ * 16) + 1) + i_))] + s_.p[(((i_ * n_) + j_))]);
        }
    }
    int64_t t6 = (count_ + 1);
    int64_t t5 = drive_substeps(reading_.dt_, (p_.p[30] + faster_));
    process_model_advance_beside(layout_, lanes_, t6, true, (tuple_12){{reading_.u_, reading_.load_, rate_}}, reading_.dt_, t5, p_);
    tuple_2 t7 = step_record_places(n_);
    at_K_ = t7.v[7];
    tuple_17 t8 = step_record_sensitivities(n_, record_.n[0]);
    at_predicted_ = t8.v[1];
    at_updated_ = t8.v[2];
    good_ = true;
    for (int64_t k9 = 0; k9 < count_; k9 += 1) {
        i_ = k9;
        at_ = (i_ * n_);
        real t10 = (lanes_.p[((1 + i_))] - lanes_.p[0]);
        real t11 = (lanes_.p[((17 + i_))] - lanes_.p[16]);
        e1_ = t10;
        e2_ = t11;
        for (int64_t k12 = 0; k12 < n_; k12 += 1) {
            j_ = k12;
            value_ = (lanes_.p[((((j_ * 16) + 1) + i_))] - lanes_.p[((j_ * 16))]);
            record_.p[(((at_predicted_ + at_) + j_))] = value_;
            value_ = (value_ - ((record_.p[((at_K_ + (2 * j_)))] * e1_) + (record_.p[(((at_K_ + (2 * j_)) + 1))] * e2_)));
            record_.p[gm_at(((at_updated_ + at_) + j_), record_.n[0])] = value_;
            s_.p[((at_ + j_))] = value_;
            good_ = (good_ && (bool)isfinite(value_));
        }
    }
    return good_;
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_aekf(Layout layout_, array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple t1 = filter_parts(layout_, 95, 3, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < layout_.n_; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim(layout_, belief_, reading_, p_);
    }
    bool t3 = aekf_step(layout_, belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_14 t4 = aekf_used(belief_.memory_, p_);
    bool t5 = consider_accompany(layout_, companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/filter_kind.py:86 unchanged */
GM_INLINE tuple_14 filter_kind_unchanged(array1_f8 memory_, array1_f8 p_)
{
    return (tuple_14){p_, (real)0.0};
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_ekf(Layout layout_, array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple t1 = filter_parts(layout_, 1, 1, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < layout_.n_; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim(layout_, belief_, reading_, p_);
    }
    bool t3 = ekf_step(layout_, belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_14 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany(layout_, companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/sigma_points.py:46 cholesky */
GM_INLINE bool sigma_points_cholesky(Layout layout_, array1_f8 a_, array1_f8 out_)
{
    int64_t n_;
    int64_t j_;
    real s_;
    int64_t k_;
    real root_;
    real inverse_;
    int64_t i_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        j_ = k1;
        s_ = a_.p[(((j_ * n_) + j_))];
        for (int64_t k2 = 0; k2 < j_; k2 += 1) {
            k_ = k2;
            s_ = (s_ - (out_.p[(((j_ * n_) + k_))] * out_.p[(((j_ * n_) + k_))]));
        }
        if ((!((s_ > (real)0.0)))) {
            return false;
        }
        root_ = gm_sqrt(s_);
        out_.p[(((j_ * n_) + j_))] = root_;
        inverse_ = ((real)1.0 / root_);
        int64_t t3 = (j_ + 1);
        for (int64_t k4 = t3; k4 < n_; k4 += 1) {
            i_ = k4;
            s_ = a_.p[(((i_ * n_) + j_))];
            for (int64_t k5 = 0; k5 < j_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (out_.p[(((i_ * n_) + k_))] * out_.p[(((j_ * n_) + k_))]));
            }
            out_.p[(((i_ * n_) + j_))] = (s_ * inverse_);
            out_.p[(((j_ * n_) + i_))] = (real)0.0;
        }
    }
    return true;
}

/* estimation/filters/srukf.py:169 _upper */
GM_INLINE void srukf_upper(Layout layout_, array1_f8 lower_, array2_f8 out_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            j_ = k2;
            out_.p[((i_) * out_.n[1] + (j_))] = lower_.p[(((j_ * n_) + i_))];
        }
    }
    return;
}

/* estimation/filters/srukf.py:187 _noise */
GM_INLINE void srukf_noise(Layout layout_, array2_f8 rows_, array1_f8 z_, real dt_, array1_f8 p_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            j_ = k2;
            rows_.p[((i_) * rows_.n[1] + (j_))] = (real)0.0;
        }
        real t4 = ((real)0.5 * dt_);
        real t3 = process_model_noise(z_, p_, i_);
        rows_.p[((i_) * rows_.n[1] + (i_))] = gm_sqrt((t4 * t3));
    }
    return;
}

/* estimation/filters/srukf.py:130 triangularise */
GM_INLINE void srukf_triangularise(array2_f8 a_, int64_t columns_, int64_t dense_, int64_t tail_)
{
    int64_t m_;
    int64_t n_;
    int64_t j_;
    int64_t top_;
    int64_t end_;
    real pivot_;
    real s_;
    int64_t i_;
    real norm_;
    real head_;
    real scale_;
    int64_t c_;
    real t_;
    m_ = a_.n[0];
    n_ = a_.n[1];
    for (int64_t k1 = 0; k1 < columns_; k1 += 1) {
        j_ = k1;
        int64_t t2 = gm_max_i((j_ + 1), dense_);
        int64_t t3 = gm_min_i(((tail_ + j_) + 1), m_);
        top_ = t2;
        end_ = t3;
        pivot_ = a_.p[((j_) * a_.n[1] + (j_))];
        s_ = (pivot_ * pivot_);
        int64_t t4 = (j_ + 1);
        for (int64_t k5 = t4; k5 < top_; k5 += 1) {
            i_ = k5;
            s_ = (s_ + (a_.p[((i_) * a_.n[1] + (j_))] * a_.p[((i_) * a_.n[1] + (j_))]));
        }
        for (int64_t k6 = tail_; k6 < end_; k6 += 1) {
            i_ = k6;
            s_ = (s_ + (a_.p[((i_) * a_.n[1] + (j_))] * a_.p[((i_) * a_.n[1] + (j_))]));
        }
        norm_ = gm_sqrt(s_);
        if ((!((norm_ > gm_fabs(pivot_))))) {
            continue;
        }
        if (((pivot_ > (real)0.0))) {
            norm_ = (-norm_);
        }
        head_ = (pivot_ - norm_);
        scale_ = (head_ * norm_);
        int64_t t7 = (j_ + 1);
        for (int64_t k8 = t7; k8 < n_; k8 += 1) {
            c_ = k8;
            t_ = (head_ * a_.p[((j_) * a_.n[1] + (c_))]);
            int64_t t9 = (j_ + 1);
            for (int64_t k10 = t9; k10 < top_; k10 += 1) {
                i_ = k10;
                t_ = (t_ + (a_.p[((i_) * a_.n[1] + (j_))] * a_.p[((i_) * a_.n[1] + (c_))]));
            }
            for (int64_t k11 = tail_; k11 < end_; k11 += 1) {
                i_ = k11;
                t_ = (t_ + (a_.p[((i_) * a_.n[1] + (j_))] * a_.p[((i_) * a_.n[1] + (c_))]));
            }
            t_ = (t_ / scale_);
            a_.p[((j_) * a_.n[1] + (c_))] = (a_.p[((j_) * a_.n[1] + (c_))] + (t_ * head_));
            int64_t t12 = (j_ + 1);
            for (int64_t k13 = t12; k13 < top_; k13 += 1) {
                i_ = k13;
                a_.p[((i_) * a_.n[1] + (c_))] = (a_.p[((i_) * a_.n[1] + (c_))] + (t_ * a_.p[((i_) * a_.n[1] + (j_))]));
            }
            for (int64_t k14 = tail_; k14 < end_; k14 += 1) {
                i_ = k14;
                a_.p[((i_) * a_.n[1] + (c_))] = (a_.p[((i_) * a_.n[1] + (c_))] + (t_ * a_.p[((i_) * a_.n[1] + (j_))]));
            }
        }
        a_.p[((j_) * a_.n[1] + (j_))] = norm_;
    }
    return;
}

/* estimation/filters/srukf.py:178 _lower */
GM_INLINE void srukf_lower(Layout layout_, array2_f8 upper_, array1_f8 out_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            j_ = k2;
            out_.p[(((i_ * n_) + j_))] = (((j_ <= i_)) ? upper_.p[((j_) * upper_.n[1] + (i_))] : (real)0.0);
        }
    }
    return;
}

/* estimation/process_model.py:643 _own_drive */
GM_INLINE tuple_16 process_model_own_drive_2(array1_f8 lanes_, int64_t at_, tuple_12 torques_, tuple_15 p_)
{
    return (tuple_16){torques_.v[0], p_};
}

/* estimation/process_model.py:618 _stage */
GM_INLINE void process_model_stage_2(Layout layout_, array1_f8 lanes_, int64_t width_, int64_t q_, real part_, tuple_12 torques_, tuple_15 shared_)
{
    int64_t n_;
    int64_t curve_;
    array1_f8 z_;
    int64_t at_curve_;
    int64_t i_;
    real u_;
    tuple_15 drive_;
    tuple_5 law_;
    real memory_;
    int64_t at_;
    tuple_4 x_;
    int64_t last_;
    real x3_;
    real x4_;
    real f_;
    real g_;
    n_ = layout_.n_;
    curve_ = layout_.curve_;
    z_ = lanes_;
    int64_t t1 = process_model_curve_count(curve_);
    at_curve_ = ((n_ - t1) * 16);
    for (int64_t k2 = 0; k2 < width_; k2 += 1) {
        i_ = k2;
        tuple_16 t3 = process_model_own_drive_2(z_, (((n_ + 21) * 16) + i_), torques_, shared_);
        u_ = t3.f0;
        drive_ = t3.f1;
        int64_t t4 = process_model_curve_count(curve_);
        tuple_5 t5 = process_model_curve_2(curve_, z_, 16, i_, (n_ - t4), drive_);
        law_ = t5;
        real t6 = process_model_memory(curve_, z_, (at_curve_ + i_), (z_.p[((0 + i_))] - z_.p[((16 + i_))]));
        memory_ = t6;
        at_ = (((n_ + q_) * 16) + i_);
        x_ = (tuple_4){{z_.p[((0 + i_))], z_.p[((16 + i_))], z_.p[((32 + i_))], z_.p[((48 + i_))], z_.p[((64 + i_))]}};
        if (((q_ > 0))) {
            last_ = (at_ - 16);
            real t7 = z_.p[gm_at((last_ + 0), z_.n[0])];
            real t8 = z_.p[gm_at((last_ + 64), z_.n[0])];
            x3_ = t7;
            x4_ = t8;
            x_ = (tuple_4){{(x_.v[0] + (part_ * x3_)), (x_.v[1] + (part_ * x4_)), (x_.v[2] + (part_ * z_.p[gm_at((last_ + 128), z_.n[0])])), (x_.v[3] + (part_ * z_.p[gm_at((last_ + 192), z_.n[0])])), (x_.v[4] + ((part_ * drive_.v[26]) * (x3_ - x4_)))}};
        }
        tuple_4 t9 = process_model_bearing(layout_, x_, (tuple_6){memory_, law_});
        tuple_3 t10 = process_model_accelerations_2(layout_, t9, (u_ - z_.p[((at_ + 256))]), z_.p[((((n_ + 20) * 16) + i_))], drive_);
        f_ = t10.v[0];
        g_ = t10.v[1];
        real t11 = x_.v[2];
        real t12 = x_.v[3];
        z_.p[((at_ + 0))] = t11;
        z_.p[((at_ + 64))] = t12;
        z_.p[((at_ + 128))] = f_;
        z_.p[((at_ + 192))] = g_;
    }
    return;
}

/* estimation/process_model.py:567 advance_beside */
GM_STATIC void process_model_advance_beside_2(Layout layout_, array1_f8 lanes_, int64_t count_, tuple_12 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    int64_t n_;
    int64_t width_;
    real h_;
    int64_t at_load_;
    int64_t at_error_;
    int64_t friction_at_;
    real share_;
    tuple_15 drive_;
    int64_t i_;
    int64_t q_;
    tuple_4 error_;
    int64_t t1 = ((count_ + 3) & (-4));
    real t2 = (dt_ / (real)(n_substeps_));
    n_ = layout_.n_;
    width_ = t1;
    h_ = t2;
    int64_t t3 = ((n_ + 20) * 16);
    int64_t t4 = ((n_ + 16) * 16);
    int64_t t5 = ((int64_t)(p_.p[29]) * 16);
    at_load_ = t3;
    at_error_ = t4;
    friction_at_ = t5;
    share_ = (((p_.p[28] > (real)0.0)) ? (real)1.0 : (real)0.0);
    drive_ = (tuple_15){{p_.p[0], p_.p[1], p_.p[2], p_.p[3], p_.p[4], p_.p[5], p_.p[6], p_.p[7], p_.p[8], p_.p[9], p_.p[10], p_.p[11], p_.p[12], p_.p[13], p_.p[14], p_.p[15], p_.p[16], p_.p[17], p_.p[18], p_.p[19], p_.p[20], p_.p[21], p_.p[22], p_.p[23], p_.p[24], p_.p[25], p_.p[26]}};
    for (int64_t k6 = 0; k6 < width_; k6 += 1) {
        i_ = k6;
        lanes_.p[((at_load_ + i_))] = torques_.v[1];
        if (((n_ > 5))) {
            lanes_.p[((at_load_ + i_))] = (lanes_.p[((at_load_ + i_))] + (share_ * lanes_.p[((80 + i_))]));
        }
        for (int64_t k7 = 0; k7 < 4; k7 += 1) {
            q_ = k7;
            lanes_.p[(((at_error_ + (q_ * 16)) + i_))] = (real)0.0;
        }
    }
    for (int64_t k8 = 0; k8 < n_substeps_; k8 += 1) {
        if ((((n_ > 5)) && ((friction_at_ > 0)))) {
            for (int64_t k9 = 0; k9 < width_; k9 += 1) {
                i_ = k9;
                tuple_4 t10 = process_model_decay(lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])], ((real)0.5 * h_), h_, p_);
                error_ = t10;
                for (int64_t k11 = 0; k11 < 4; k11 += 1) {
                    q_ = k11;
                    lanes_.p[(((at_error_ + (q_ * 16)) + i_))] = error_.v[(q_)];
                }
                lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])] = error_.v[4];
            }
        }
        process_model_stage_2(layout_, lanes_, width_, 0, (real)0.0, torques_, drive_);
        process_model_stage_2(layout_, lanes_, width_, 1, ((real)0.5 * h_), torques_, drive_);
        process_model_stage_2(layout_, lanes_, width_, 2, ((real)0.5 * h_), torques_, drive_);
        process_model_stage_2(layout_, lanes_, width_, 3, h_, torques_, drive_);
        for (int64_t k12 = 0; k12 < width_; k12 += 1) {
            i_ = k12;
            process_model_finish(layout_, lanes_, i_, (h_ / (real)6.0), drive_);
        }
    }
    return;
}

/* estimation/sigma_points.py:79 transform */
GM_INLINE void sigma_points_transform(Layout layout_, array1_f8 z_, array1_f8 factor_, Reading reading_, array1_f8 p_, array2_f8 rows_, array2_f8 matrices_)
{
    int64_t n_;
    real dt_;
    array1_f8 lanes_;
    int64_t counted_;
    real alpha2_;
    real spread_;
    real root_;
    real weight_;
    real shared_;
    int64_t j_;
    int64_t at_;
    real centre_;
    int64_t i_;
    real bends_;
    real plus_;
    real minus_;
    real bend_;
    n_ = layout_.n_;
    dt_ = reading_.dt_;
    int64_t t1 = ((17 * n_) * n_);
    int64_t t2 = ((n_ + 21) * 16);
    int64_t t3 = gm_bound(t2, t1);
    lanes_ = (array1_f8){matrices_.p, {t3}};
    int64_t t4 = drive_substeps(dt_, p_.p[30]);
    counted_ = t4;
    alpha2_ = (p_.p[38] * p_.p[38]);
    spread_ = gm_sqrt((alpha2_ * ((real)(n_) + p_.p[40])));
    root_ = ((real)1.0 / spread_);
    weight_ = (root_ * root_);
    shared_ = (((real)1.0 - gm_sqrt(((real)1.0 + (((p_.p[39] - alpha2_) * (real)(n_)) * weight_)))) / (real)(n_));
    for (int64_t k5 = 0; k5 < n_; k5 += 1) {
        j_ = k5;
        int64_t t6 = (j_ * 16);
        real t7 = z_.p[(j_)];
        at_ = t6;
        centre_ = t7;
        for (int64_t k8 = 0; k8 < 16; k8 += 1) {
            i_ = k8;
            lanes_.p[((at_ + i_))] = centre_;
        }
        for (int64_t k9 = 0; k9 < n_; k9 += 1) {
            i_ = k9;
            lanes_.p[((at_ + i_))] = (centre_ + (spread_ * factor_.p[(((j_ * n_) + i_))]));
            lanes_.p[(((at_ + n_) + i_))] = (centre_ - (spread_ * factor_.p[(((j_ * n_) + i_))]));
        }
    }
    for (int64_t k10 = 0; k10 < counted_; k10 += 1) {
        process_model_advance_beside_2(layout_, lanes_, ((2 * n_) + 1), (tuple_12){{reading_.u_, reading_.load_, (real)0.0}}, (dt_ / (real)(counted_)), 1, p_);
    }
    for (int64_t k11 = 0; k11 < n_; k11 += 1) {
        j_ = k11;
        int64_t t12 = (j_ * 16);
        real t13 = lanes_.p[(((j_ * 16) + (2 * n_)))];
        at_ = t12;
        centre_ = t13;
        bends_ = (real)0.0;
        for (int64_t k14 = 0; k14 < n_; k14 += 1) {
            i_ = k14;
            real t15 = (lanes_.p[((at_ + i_))] - centre_);
            real t16 = (lanes_.p[(((at_ + n_) + i_))] - centre_);
            plus_ = t15;
            minus_ = t16;
            bend_ = ((real)0.5 * (plus_ + minus_));
            rows_.p[((i_) * rows_.n[1] + (j_))] = (((real)0.5 * root_) * (plus_ - minus_));
            rows_.p[(((n_ + i_)) * rows_.n[1] + (j_))] = bend_;
            bends_ = (bends_ + bend_);
        }
        z_.p[(j_)] = (centre_ + (weight_ * bends_));
        for (int64_t k17 = 0; k17 < n_; k17 += 1) {
            i_ = k17;
            rows_.p[(((n_ + i_)) * rows_.n[1] + (j_))] = (root_ * (rows_.p[(((n_ + i_)) * rows_.n[1] + (j_))] - (shared_ * bends_)));
        }
    }
    return;
}

/* kernels/linalg.py:195 _added */
GM_INLINE tuple_10 linalg_added(int64_t n_, real v_, array1_f8 b_, int64_t at_, tuple_10 row_)
{
    return (tuple_10){{(row_.v[0] + (v_ * b_.p[(at_)])), (row_.v[1] + (v_ * b_.p[((at_ + 1))])), (row_.v[2] + (v_ * b_.p[((at_ + 2))])), (row_.v[3] + (v_ * b_.p[((at_ + 3))])), (row_.v[4] + (v_ * b_.p[((at_ + 4))])), (((n_ > 5)) ? (row_.v[5] + (v_ * b_.p[((at_ + 5))])) : (real)0.0), (((n_ > 6)) ? (row_.v[6] + (v_ * b_.p[((at_ + 6))])) : (real)0.0), (((n_ > 7)) ? (row_.v[7] + (v_ * b_.p[((at_ + 7))])) : (real)0.0), (((n_ > 8)) ? (row_.v[8] + (v_ * b_.p[((at_ + 8))])) : (real)0.0), (((n_ > 9)) ? (row_.v[9] + (v_ * b_.p[((at_ + 9))])) : (real)0.0), (((n_ > 10)) ? (row_.v[10] + (v_ * b_.p[((at_ + 10))])) : (real)0.0)}};
}

/* kernels/linalg.py:281 add_transposed_product */
GM_INLINE void linalg_add_transposed_product(Layout layout_, array1_f8 a_, array1_f8 b_, int64_t length_, array1_f8 out_)
{
    int64_t n_;
    int64_t i_;
    tuple_10 row_;
    int64_t k_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        tuple_10 t2 = linalg_added(n_, (real)1.0, out_, (i_ * n_), (tuple_10){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < length_; k3 += 1) {
            k_ = k3;
            tuple_10 t4 = linalg_added(n_, a_.p[(((k_ * n_) + i_))], b_, (k_ * n_), row_);
            row_ = t4;
        }
        linalg_put(n_, row_, out_, (i_ * n_));
    }
    return;
}

/* estimation/sigma_points.py:128 cross_covariance */
GM_INLINE void sigma_points_cross_covariance(Layout layout_, array2_f8 rows_, array1_f8 factor_, array1_f8 P_, array1_f8 slope_, array1_f8 out_)
{
    int64_t n_;
    int64_t j_;
    real inverse_;
    int64_t r_;
    real s_;
    int64_t k_;
    int64_t i_;
    n_ = layout_.n_;
    int64_t t1 = (n_ - 1);
    for (int64_t k2 = t1; k2 > (-1); k2 += -1) {
        j_ = k2;
        inverse_ = ((real)1.0 / factor_.p[(((j_ * n_) + j_))]);
        for (int64_t k3 = 0; k3 < n_; k3 += 1) {
            r_ = k3;
            s_ = rows_.p[((j_) * rows_.n[1] + (r_))];
            int64_t t4 = (j_ + 1);
            for (int64_t k5 = t4; k5 < n_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (slope_.p[(((k_ * n_) + r_))] * factor_.p[(((k_ * n_) + j_))]));
            }
            slope_.p[(((j_ * n_) + r_))] = (s_ * inverse_);
        }
    }
    int64_t t6 = (n_ * n_);
    for (int64_t k7 = 0; k7 < t6; k7 += 1) {
        i_ = k7;
        out_.p[(i_)] = (real)0.0;
    }
    linalg_add_transposed_product(layout_, slope_, P_, n_, out_);
    return;
}

/* estimation/filters/srukf.py:197 _square */
GM_INLINE void srukf_square(Layout layout_, array1_f8 factor_, array1_f8 out_, int64_t at_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    real s_;
    int64_t k_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        int64_t t2 = (i_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            j_ = k3;
            s_ = (real)0.0;
            int64_t t4 = (j_ + 1);
            for (int64_t k5 = 0; k5 < t4; k5 += 1) {
                k_ = k5;
                s_ = (s_ + (factor_.p[(((i_ * n_) + k_))] * factor_.p[(((j_ * n_) + k_))]));
            }
            real t6 = s_;
            real t7 = s_;
            out_.p[(((at_ + (i_ * n_)) + j_))] = t6;
            out_.p[(((at_ + (j_ * n_)) + i_))] = t7;
        }
    }
    return;
}

/* estimation/filters/srukf.py:130 triangularise */
GM_INLINE void srukf_triangularise_2(array2_f8 a_, int64_t columns_, int64_t dense_, int64_t tail_)
{
    int64_t m_;
    int64_t n_;
    int64_t j_;
    int64_t top_;
    int64_t end_;
    real pivot_;
    real s_;
    int64_t i_;
    real norm_;
    real head_;
    real scale_;
    int64_t c_;
    real t_;
    m_ = a_.n[0];
    n_ = a_.n[1];
    for (int64_t k1 = 0; k1 < columns_; k1 += 1) {
        j_ = k1;
        int64_t t2 = gm_max_i((j_ + 1), dense_);
        int64_t t3 = gm_min_i(((tail_ + j_) + 1), m_);
        top_ = t2;
        end_ = t3;
        pivot_ = a_.p[((j_) * a_.n[1] + (j_))];
        s_ = (pivot_ * pivot_);
        int64_t t4 = (j_ + 1);
        for (int64_t k5 = t4; k5 < top_; k5 += 1) {
            i_ = k5;
            s_ = (s_ + (a_.p[((i_) * a_.n[1] + (j_))] * a_.p[((i_) * a_.n[1] + (j_))]));
        }
        for (int64_t k6 = tail_; k6 < end_; k6 += 1) {
            i_ = k6;
            s_ = (s_ + (a_.p[((i_) * a_.n[1] + (j_))] * a_.p[((i_) * a_.n[1] + (j_))]));
        }
        norm_ = gm_sqrt(s_);
        if ((!((norm_ > gm_fabs(pivot_))))) {
            continue;
        }
        if (((pivot_ > (real)0.0))) {
            norm_ = (-norm_);
        }
        head_ = (pivot_ - norm_);
        scale_ = (head_ * norm_);
        int64_t t7 = (j_ + 1);
        for (int64_t k8 = t7; k8 < n_; k8 += 1) {
            c_ = k8;
            t_ = (head_ * a_.p[((j_) * a_.n[1] + (c_))]);
            int64_t t9 = (j_ + 1);
            for (int64_t k10 = t9; k10 < top_; k10 += 1) {
                i_ = k10;
                t_ = (t_ + (a_.p[((i_) * a_.n[1] + (j_))] * a_.p[((i_) * a_.n[1] + (c_))]));
            }
            for (int64_t k11 = tail_; k11 < end_; k11 += 1) {
                i_ = k11;
                t_ = (t_ + (a_.p[((i_) * a_.n[1] + (j_))] * a_.p[((i_) * a_.n[1] + (c_))]));
            }
            t_ = (t_ / scale_);
            a_.p[((j_) * a_.n[1] + (c_))] = (a_.p[((j_) * a_.n[1] + (c_))] + (t_ * head_));
            int64_t t12 = (j_ + 1);
            for (int64_t k13 = t12; k13 < top_; k13 += 1) {
                i_ = k13;
                a_.p[((i_) * a_.n[1] + (c_))] = (a_.p[((i_) * a_.n[1] + (c_))] + (t_ * a_.p[((i_) * a_.n[1] + (j_))]));
            }
            for (int64_t k14 = tail_; k14 < end_; k14 += 1) {
                i_ = k14;
                a_.p[((i_) * a_.n[1] + (c_))] = (a_.p[((i_) * a_.n[1] + (c_))] + (t_ * a_.p[((i_) * a_.n[1] + (j_))]));
            }
        }
        a_.p[((j_) * a_.n[1] + (j_))] = norm_;
    }
    return;
}

/* estimation/filters/srukf.py:82 _update */
GM_INLINE bool srukf_update(Layout layout_, array1_f8 mean_, array1_f8 factor_, real y1_, real y2_, array1_f8 p_, array2_f8 array_, array1_f8 record_)
{
    int64_t n_;
    int64_t at_P_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t at_K_;
    int64_t at_scores_;
    bool have1_;
    bool have2_;
    real e1_;
    real e2_;
    int64_t i_;
    int64_t j_;
    int64_t m_;
    real s11_;
    real s21_;
    real s22_;
    real white1_;
    real white2_;
    real nis_;
    real dof_;
    real k2_;
    n_ = layout_.n_;
    tuple_2 t1 = step_record_places(n_);
    at_P_ = t1.v[1];
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    at_K_ = t1.v[7];
    at_scores_ = t1.v[8];
    bool t2 = (bool)isfinite(y1_);
    bool t3 = (bool)isfinite(y2_);
    have1_ = t2;
    have2_ = t3;
    real t4 = (have1_ ? (y1_ - mean_.p[0]) : NAN);
    real t5 = (have2_ ? (y2_ - mean_.p[1]) : NAN);
    e1_ = t4;
    e2_ = t5;
    record_.p[(at_innovation_)] = e1_;
    record_.p[((at_innovation_ + 1))] = e2_;
    real t6 = (record_.p[(at_P_)] + p_.p[31]);
    real t7 = record_.p[((at_P_ + 1))];
    record_.p[(at_S_)] = t6;
    record_.p[((at_S_ + 1))] = t7;
    record_.p[((at_S_ + 2))] = (record_.p[(((at_P_ + n_) + 1))] + p_.p[32]);
    real t8 = (have1_ ? gm_sqrt(p_.p[31]) : (real)1.0);
    array_.p[0] = t8;
    array_.p[1] = (real)0.0;
    real t9 = (have2_ ? gm_sqrt(p_.p[32]) : (real)1.0);
    array_.p[(1 * array_.n[1] + 0)] = (real)0.0;
    array_.p[(1 * array_.n[1] + 1)] = t9;
    for (int64_t k10 = 0; k10 < 2; k10 += 1) {
        i_ = k10;
        array_.p[(((2 + i_)) * array_.n[1] + 0)] = (have1_ ? factor_.p[(i_)] : (real)0.0);
        array_.p[(((2 + i_)) * array_.n[1] + 1)] = (have2_ ? factor_.p[((n_ + i_))] : (real)0.0);
        for (int64_t k11 = 0; k11 < n_; k11 += 1) {
            j_ = k11;
            array_.p[((i_) * array_.n[1] + ((2 + j_)))] = (real)0.0;
            array_.p[(((2 + i_)) * array_.n[1] + ((2 + j_)))] = factor_.p[(((j_ * n_) + i_))];
        }
    }
    m_ = array_.n[0];
    srukf_triangularise_2(array_, (m_ - 1), m_, m_);
    real t12 = array_.p[0];
    real t13 = array_.p[1];
    real t14 = array_.p[(1 * array_.n[1] + 1)];
    s11_ = t12;
    s21_ = t13;
    s22_ = t14;
    white1_ = (have1_ ? (e1_ / s11_) : (real)0.0);
    white2_ = (have2_ ? ((e2_ - (s21_ * white1_)) / s22_) : (real)0.0);
    nis_ = ((white1_ * white1_) + (white2_ * white2_));
    if ((!(bool)isfinite(nis_))) {
        return false;
    }
    dof_ = ((have1_ ? (real)1.0 : (real)0.0) + (have2_ ? (real)1.0 : (real)0.0));
    record_.p[(at_scores_)] = nis_;
    record_.p[((at_scores_ + 1))] = ((((real)(-0.5) * (nis_ + (dof_ * (real)1.8378770664093453))) - gm_log(gm_fabs(s11_))) - gm_log(gm_fabs(s22_)));
    record_.p[((at_scores_ + 2))] = dof_;
    for (int64_t k15 = 0; k15 < n_; k15 += 1) {
        i_ = k15;
        mean_.p[(i_)] = (mean_.p[(i_)] + ((array_.p[((2 + i_))] * white1_) + (array_.p[(1 * array_.n[1] + ((2 + i_)))] * white2_)));
        k2_ = (array_.p[(1 * array_.n[1] + ((2 + i_)))] / s22_);
        real t16 = ((array_.p[((2 + i_))] - (k2_ * s21_)) / s11_);
        record_.p[((at_K_ + (2 * i_)))] = t16;
        record_.p[(((at_K_ + (2 * i_)) + 1))] = k2_;
        factor_.p[((i_ * n_))] = array_.p[(2 * array_.n[1] + ((2 + i_)))];
        if (((i_ > 0))) {
            factor_.p[(((i_ * n_) + 1))] = array_.p[(3 * array_.n[1] + ((2 + i_)))];
        }
    }
    return true;
}

/* estimation/filters/srukf.py:30 step */
GM_APART bool srukf_step(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    int64_t n_;
    real dt_;
    array1_f8 z_;
    array1_f8 P_;
    array1_f8 memory_;
    array2_f8 vectors_;
    array2_f8 matrices_;
    int64_t at_z_;
    int64_t at_P_;
    int64_t at_cross_;
    int64_t at_z_out_;
    int64_t at_P_out_;
    array1_f8 mean_;
    array1_f8 factor_;
    int64_t i_;
    array2_f8 rows_;
    array2_f8 array_;
    n_ = layout_.n_;
    dt_ = reading_.dt_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    memory_ = belief_.memory_;
    vectors_ = scratch_.vectors_;
    matrices_ = scratch_.matrices_;
    tuple_2 t1 = step_record_places(n_);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_out_ = t1.v[3];
    at_P_out_ = t1.v[4];
    mean_ = (array1_f8){vectors_.p + 0 * (vectors_.n[1]), {vectors_.n[1]}};
    factor_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    if (((memory_.p[0] == (real)0.0))) {
        bool t2 = sigma_points_cholesky(layout_, P_, factor_);
        if ((!t2)) {
            return false;
        }
    } else {
        int64_t t3 = (n_ * n_);
        for (int64_t k4 = 0; k4 < t3; k4 += 1) {
            i_ = k4;
            factor_.p[(i_)] = memory_.p[(i_)];
        }
    }
    for (int64_t k5 = 0; k5 < n_; k5 += 1) {
        i_ = k5;
        mean_.p[(i_)] = z_.p[(i_)];
    }
    int64_t t6 = gm_bound(1, matrices_.n[0]);
    int64_t t7 = gm_bound(4, matrices_.n[0]);
    int64_t t8 = gm_span(t6, t7);
    int64_t t9 = (3 * n_);
    rows_ = (array2_f8){matrices_.p + t6 * (matrices_.n[1]), {t9, n_}};
    srukf_upper(layout_, factor_, rows_);
    int64_t t10 = gm_bound(n_, rows_.n[0]);
    int64_t t11 = gm_span(t10, rows_.n[0]);
    srukf_noise(layout_, (array2_f8){rows_.p + t10 * (rows_.n[1]), {t11, rows_.n[1]}}, mean_, dt_, p_);
    int64_t t12 = (2 * n_);
    int64_t t13 = gm_bound(t12, rows_.n[0]);
    srukf_triangularise((array2_f8){rows_.p, {t13, rows_.n[1]}}, n_, 0, n_);
    srukf_lower(layout_, rows_, factor_);
    int64_t t14 = gm_bound(7, matrices_.n[0]);
    int64_t t15 = gm_span(t14, matrices_.n[0]);
    sigma_points_transform(layout_, mean_, factor_, reading_, p_, rows_, (array2_f8){matrices_.p + t14 * (matrices_.n[1]), {t15, matrices_.n[1]}});
    int64_t t16 = (at_cross_ + (n_ * n_));
    int64_t t17 = gm_bound(at_cross_, record_.n[0]);
    int64_t t18 = gm_bound(t16, record_.n[0]);
    int64_t t19 = gm_span(t17, t18);
    sigma_points_cross_covariance(layout_, rows_, factor_, P_, (array1_f8){matrices_.p + 6 * (matrices_.n[1]), {matrices_.n[1]}}, (array1_f8){record_.p + t17 * (1), {t19}});
    int64_t t20 = (2 * n_);
    int64_t t21 = gm_bound(t20, rows_.n[0]);
    int64_t t22 = gm_span(t21, rows_.n[0]);
    srukf_noise(layout_, (array2_f8){rows_.p + t21 * (rows_.n[1]), {t22, rows_.n[1]}}, mean_, dt_, p_);
    srukf_triangularise(rows_, n_, (2 * n_), (2 * n_));
    srukf_lower(layout_, rows_, factor_);
    srukf_square(layout_, factor_, record_, at_P_);
    for (int64_t k23 = 0; k23 < n_; k23 += 1) {
        i_ = k23;
        record_.p[((at_z_ + i_))] = mean_.p[(i_)];
    }
    int64_t t24 = gm_bound(4, matrices_.n[0]);
    int64_t t25 = gm_bound(6, matrices_.n[0]);
    int64_t t26 = gm_span(t24, t25);
    int64_t t27 = ((2 * n_) * n_);
    int64_t t28 = (4 * (n_ + 2));
    int64_t t29 = gm_bound(t28, t27);
    int64_t t30 = (n_ + 2);
    array_ = (array2_f8){matrices_.p + t24 * (matrices_.n[1]), {4, t30}};
    bool t31 = srukf_update(layout_, mean_, factor_, reading_.y1_, reading_.y2_, p_, array_, record_);
    if ((!t31)) {
        return false;
    }
    srukf_square(layout_, factor_, P_, 0);
    for (int64_t k32 = 0; k32 < n_; k32 += 1) {
        i_ = k32;
        z_.p[(i_)] = mean_.p[(i_)];
        record_.p[((at_z_out_ + i_))] = z_.p[(i_)];
    }
    int64_t t33 = (n_ * n_);
    for (int64_t k34 = 0; k34 < t33; k34 += 1) {
        i_ = k34;
        record_.p[((at_P_out_ + i_))] = P_.p[(i_)];
        memory_.p[(i_)] = factor_.p[(i_)];
    }
    bool t35 = ekf_healthy(layout_, belief_);
    return t35;
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_srukf(Layout layout_, array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple t1 = filter_parts(layout_, 1, 24, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < layout_.n_; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim(layout_, belief_, reading_, p_);
    }
    bool t3 = srukf_step(layout_, belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_14 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany(layout_, companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/filters/ukf.py:38 predict */
GM_INLINE bool ukf_predict(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    int64_t n_;
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    array2_f8 matrices_;
    int64_t at_z_;
    int64_t at_P_;
    int64_t at_cross_;
    array1_f8 factor_;
    array1_f8 slope_;
    array2_f8 rows_;
    array1_f8 cross_;
    array1_f8 P_pred_;
    int64_t i_;
    int64_t j_;
    array1_f8 flat_;
    n_ = layout_.n_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    matrices_ = scratch_.matrices_;
    tuple_2 t1 = step_record_places(n_);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    int64_t t2 = gm_bound(2, matrices_.n[0]);
    int64_t t3 = gm_bound(4, matrices_.n[0]);
    int64_t t4 = gm_span(t2, t3);
    int64_t t5 = (2 * n_);
    factor_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    slope_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    rows_ = (array2_f8){matrices_.p + t2 * (matrices_.n[1]), {t5, n_}};
    int64_t t6 = (at_cross_ + (n_ * n_));
    int64_t t7 = gm_bound(at_cross_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    int64_t t10 = (at_P_ + (n_ * n_));
    int64_t t11 = gm_bound(at_P_, record_.n[0]);
    int64_t t12 = gm_bound(t10, record_.n[0]);
    int64_t t13 = gm_span(t11, t12);
    cross_ = (array1_f8){record_.p + t7 * (1), {t9}};
    P_pred_ = (array1_f8){record_.p + t11 * (1), {t13}};
    for (int64_t k14 = 0; k14 < n_; k14 += 1) {
        i_ = k14;
        for (int64_t k15 = 0; k15 < n_; k15 += 1) {
            j_ = k15;
            slope_.p[(((i_ * n_) + j_))] = P_.p[(((i_ * n_) + j_))];
        }
        real t18 = slope_.p[(((i_ * n_) + i_))];
        real t17 = ((real)0.5 * dt_);
        real t16 = process_model_noise(z_, p_, i_);
        slope_.p[(((i_ * n_) + i_))] = (t18 + (t17 * t16));
    }
    bool t19 = sigma_points_cholesky(layout_, slope_, factor_);
    if ((!t19)) {
        return false;
    }
    int64_t t20 = gm_bound(4, matrices_.n[0]);
    int64_t t21 = gm_span(t20, matrices_.n[0]);
    sigma_points_transform(layout_, z_, factor_, reading_, p_, rows_, (array2_f8){matrices_.p + t20 * (matrices_.n[1]), {t21, matrices_.n[1]}});
    sigma_points_cross_covariance(layout_, rows_, factor_, P_, slope_, cross_);
    for (int64_t k22 = 0; k22 < n_; k22 += 1) {
        i_ = k22;
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
        for (int64_t k23 = 0; k23 < n_; k23 += 1) {
            j_ = k23;
            real t26;
            if (((i_ == j_))) {
            real t25 = ((real)0.5 * dt_);
            real t24 = process_model_noise(z_, p_, i_);
                t26 = (t25 * t24);
            } else {
                t26 = (real)0.0;
            }
            P_pred_.p[(((i_ * n_) + j_))] = t26;
        }
    }
    int64_t t27 = gm_bound(2, matrices_.n[0]);
    int64_t t28 = gm_bound(4, matrices_.n[0]);
    int64_t t29 = gm_span(t27, t28);
    int64_t t30 = ((2 * n_) * n_);
    flat_ = (array1_f8){matrices_.p + t27 * (matrices_.n[1]), {t30}};
    linalg_add_transposed_product(layout_, flat_, flat_, (2 * n_), P_pred_);
    return true;
}

/* estimation/filters/ukf.py:21 step */
GM_APART bool ukf_step(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    bool t1 = ukf_predict(layout_, belief_, reading_, p_, scratch_, record_);
    bool t3 = t1;
    if (t3) {
    bool t2 = ekf_update(layout_, belief_, reading_.y1_, reading_.y2_, p_, record_);
    t3 = t2;
    }
    bool t5 = t3;
    if (t5) {
    bool t4 = ekf_healthy(layout_, belief_);
    t5 = t4;
    }
    return t5;
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_ukf(Layout layout_, array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple t1 = filter_parts(layout_, 1, 21, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < layout_.n_; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim(layout_, belief_, reading_, p_);
    }
    bool t3 = ukf_step(layout_, belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_14 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany(layout_, companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/sample_loop.py:211 _gate */
GM_STATIC int64_t sample_loop_gate(int64_t stamp_, array1_i8 gate_, int64_t max_gap_)
{
    int64_t last_;
    int64_t elapsed_;
    int64_t beyond_;
    if (((stamp_ <= 0))) {
        return 2;
    }
    last_ = gate_.p[0];
    if (((last_ == 0))) {
        return 1;
    }
    elapsed_ = (stamp_ - last_);
    if (((elapsed_ == 0))) {
        return 3;
    }
    if (((0 < elapsed_) && (elapsed_ <= max_gap_))) {
        gate_.p[2] = 0;
        return 0;
    }
    beyond_ = (stamp_ - gate_.p[1]);
    if ((((gate_.p[2] > 0)) && ((0 < beyond_) && (beyond_ <= max_gap_)))) {
        gate_.p[2] = (gate_.p[2] + 1);
    } else {
        gate_.p[2] = 1;
    }
    gate_.p[1] = stamp_;
    if (((gate_.p[2] >= ((((-250000000) < elapsed_) && (elapsed_ < 0)) ? 25 : 3)))) {
        return 1;
    }
    return (((elapsed_ < 0)) ? 4 : 5);
}

/* estimation/sample_loop.py:261 _stops */
GM_STATIC bool sample_loop_stops(int64_t stamp_, array1_i8 gate_)
{
    int64_t at_;
    at_ = gate_.p[8];
    return (((at_ != (-1))) && ((((at_ == 0)) || ((stamp_ >= at_))) || ((stamp_ < (at_ - 1000000000)))));
}

/* estimation/process_model.py:336 begin_curve */
GM_INLINE void process_model_begin_curve(Layout layout_, array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count(layout_.curve_);
    count_ = t1;
    at_ = (layout_.n_ - count_);
    if (((count_ > 0))) {
        z_.p[gm_at((at_ + 0), z_.n[0])] = (z_.p[0] - z_.p[1]);
    }
    if (((count_ > 1))) {
        z_.p[gm_at((at_ + 1), z_.n[0])] = p_.p[9];
        real t2 = (p_.p[9] * p_.p[10]);
        real t3 = (p_.p[9] * p_.p[11]);
        z_.p[gm_at((at_ + 2), z_.n[0])] = t2;
        z_.p[gm_at((at_ + 3), z_.n[0])] = t3;
    }
    return;
}

/* estimation/step_record.py:18 record_size */
GM_STATIC int64_t step_record_record_size_2(int64_t n_, int64_t considered_)
{
    return ((((4 * n_) + ((3 * n_) * n_)) + 9) + ((3 * n_) * considered_));
}

/* estimation/sample_loop.py:385 start */
GM_STATIC void sample_loop_start(Layout layout_, Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
    int64_t n_;
    array1_f8 z_;
    array1_f8 P_;
    bool have1_;
    bool have2_;
    int64_t i_;
    int64_t j_;
    int64_t at_z_;
    int64_t at_P_;
    n_ = layout_.n_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    bool t1 = (bool)isfinite(y1_);
    bool t2 = (bool)isfinite(y2_);
    have1_ = t1;
    have2_ = t2;
    for (int64_t k3 = 0; k3 < n_; k3 += 1) {
        i_ = k3;
        z_.p[(i_)] = (real)0.0;
        for (int64_t k4 = 0; k4 < n_; k4 += 1) {
            j_ = k4;
            P_.p[(((i_ * n_) + j_))] = (((i_ == j_)) ? p_.p[((63 + i_))] : (real)0.0);
        }
    }
    z_.p[0] = (have1_ ? y1_ : y2_);
    z_.p[1] = (have2_ ? y2_ : y1_);
    if ((!have1_)) {
        P_.p[(((0 * n_) + 0))] = (real)100.0;
    }
    if ((!have2_)) {
        P_.p[(((1 * n_) + 1))] = (real)100.0;
    }
    process_model_begin_curve(layout_, z_, p_);
    tuple_2 t5 = step_record_places(n_);
    at_z_ = t5.v[3];
    at_P_ = t5.v[4];
    for (int64_t k6 = 0; k6 < n_; k6 += 1) {
        i_ = k6;
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    int64_t t7 = (n_ * n_);
    for (int64_t k8 = 0; k8 < t7; k8 += 1) {
        i_ = k8;
        record_.p[((at_P_ + i_))] = P_.p[(i_)];
    }
    int64_t t9 = step_record_record_size_2(n_, 0);
    int64_t t10 = (t9 - 1);
    int64_t t11 = gm_bound(t10, record_.n[0]);
    int64_t t12 = gm_bound((-1), record_.n[0]);
    int64_t t13 = gm_span(t11, t12);
    array1_f8 t14 = (array1_f8){record_.p + t11 * (1), {t13}};
    for (int64_t k15 = 0; k15 < t14.n[0]; k15++)
        t14.p[k15 * (1)] = (real)0.0;
    return;
}

/* estimation/filters/aekf.py:133 resume */
GM_STATIC void aekf_resume(array1_f8 memory_)
{
    memory_.p[1] = (real)0.0;
    int64_t t1 = gm_bound(115, memory_.n[0]);
    int64_t t2 = gm_span(t1, memory_.n[0]);
    array1_f8 t3 = (array1_f8){memory_.p + t1 * (1), {t2}};
    for (int64_t k4 = 0; k4 < t3.n[0]; k4++)
        t3.p[k4 * (1)] = (real)0.0;
    return;
}

/* estimation/consider.py:119 restart */
GM_INLINE void consider_restart(Companions companions_)
{
    array1_f8 t1 = (array1_f8){companions_.s_.p, {companions_.s_.n[0]}};
    for (int64_t k2 = 0; k2 < t1.n[0]; k2++)
        t1.p[k2 * (1)] = (real)0.0;
    companions_.s_.p[(companions_.s_.n[0] - 1)] = NAN;
    return;
}

/* estimation/sample_loop.py:329 _save */
GM_INLINE void sample_loop_save(Belief belief_, array1_f8 saved_)
{
    array1_f8 z_;
    array1_f8 P_;
    array1_f8 memory_;
    int64_t n_;
    int64_t m_;
    int64_t i_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    memory_ = belief_.memory_;
    n_ = z_.n[0];
    m_ = P_.n[0];
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        saved_.p[(i_)] = z_.p[(i_)];
    }
    for (int64_t k2 = 0; k2 < m_; k2 += 1) {
        i_ = k2;
        saved_.p[((n_ + i_))] = P_.p[(i_)];
    }
    for (int64_t k3 = 0; k3 < memory_.n[0]; k3 += 1) {
        i_ = k3;
        saved_.p[(((n_ + m_) + i_))] = memory_.p[(i_)];
    }
    return;
}

/* estimation/sample_loop.py:267 _described */
GM_INLINE real sample_loop_described(DescribedLoad described_, real measured_, array1_f8 row_, tuple_19 at_, LoopState state_, Layout layout_, Belief belief_, array1_f8 p_)
{
    int64_t place_;
    real dt_;
    array2_f8 efforts_;
    array1_f8 clock_;
    real last_;
    real load_;
    real deviation_;
    real inertia_;
    real noise_;
    int64_t n_;
    real share_;
    real jump_;
    real variance_;
    int64_t i_;
    if (((described_.time_ == (real)0.0))) {
        return measured_;
    }
    place_ = at_.f0;
    dt_ = at_.f1;
    efforts_ = state_.efforts_;
    clock_ = state_.clock_;
    last_ = efforts_.p[(gm_at((place_ - 1), efforts_.n[0]) * efforts_.n[1] + 1)];
    real t1 = row_.p[2];
    real t2 = row_.p[3];
    real t3 = row_.p[4];
    real t4 = row_.p[5];
    load_ = t1;
    deviation_ = t2;
    inertia_ = t3;
    noise_ = t4;
    if ((!(bool)isfinite(load_))) {
        p_.p[57] = described_.noise_;
        clock_.p[3] = (real)0.0;
        p_.p[56] = described_.torque_noise_;
        load_ = last_;
    } else {
        if (((clock_.p[3] == (real)0.0))) {
            belief_.z_.p[5] = (belief_.z_.p[5] + (last_ - load_));
        } else {
            if (((layout_.curve_ < 0))) {
                belief_.z_.p[4] = (belief_.z_.p[4] + (load_ - last_));
            }
        }
        real t5 = gm_exp(((-dt_) / described_.time_));
        n_ = belief_.z_.n[0];
        share_ = t5;
        if (((clock_.p[3] <= (real)0.0))) {
            jump_ = (clock_.p[3] * (load_ - last_));
            variance_ = (jump_ * jump_);
            clock_.p[3] = ((real)1.0 + variance_);
            belief_.P_.p[(((5 * n_) + 5))] = (belief_.P_.p[(((5 * n_) + 5))] + variance_);
        }
        variance_ = (clock_.p[3] - (real)1.0);
        clock_.p[3] = ((real)1.0 + (gm_exp((((real)(-2.0) * dt_) / (real)0.05)) * variance_));
        belief_.z_.p[5] = (belief_.z_.p[5] * share_);
        for (int64_t k6 = 0; k6 < n_; k6 += 1) {
            i_ = k6;
            belief_.P_.p[(((i_ * n_) + 5))] = (belief_.P_.p[(((i_ * n_) + 5))] * share_);
            belief_.P_.p[(((5 * n_) + i_))] = (belief_.P_.p[(((5 * n_) + i_))] * share_);
        }
        for (int64_t k7 = 0; k7 < state_.companions_.number_; k7 += 1) {
            i_ = k7;
            state_.companions_.s_.p[(((i_ * n_) + 5))] = (state_.companions_.s_.p[(((i_ * n_) + 5))] * share_);
        }
        p_.p[57] = (((variance_ / dt_) + noise_) + gm_min_f(described_.noise_, ((((real)2.0 * deviation_) * deviation_) / described_.time_)));
        if (((layout_.curve_ < 0))) {
            p_.p[56] = (described_.torque_noise_ + (variance_ / (real)0.05));
        }
        p_.p[1] = ((real)1.0 / inertia_);
        p_.p[30] = (described_.eigenvalue_ * gm_max_f((real)1.0, (described_.inertia_ / inertia_)));
    }
    efforts_.p[((place_) * efforts_.n[1] + 1)] = load_;
    return load_;
}

/* estimation/sample_loop.py:353 jumps */
GM_INLINE bool sample_loop_jumps(real error_, real variance_, real usual_, real r_, int64_t step_)
{
    real limit_;
    limit_ = gm_max_f(((real)10.0 * gm_max_f(usual_, ((real)2.0 * gm_sqrt(r_)))), ((real)6.0 * gm_sqrt(variance_)));
    return ((gm_fabs(error_) > (((step_ > 100)) ? limit_ : ((real)10.0 * limit_))));
}

/* estimation/sample_loop.py:341 _put_back */
GM_INLINE void sample_loop_put_back(Belief belief_, array1_f8 saved_)
{
    array1_f8 z_;
    array1_f8 P_;
    array1_f8 memory_;
    int64_t n_;
    int64_t m_;
    int64_t i_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    memory_ = belief_.memory_;
    n_ = z_.n[0];
    m_ = P_.n[0];
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        z_.p[(i_)] = saved_.p[(i_)];
    }
    for (int64_t k2 = 0; k2 < m_; k2 += 1) {
        i_ = k2;
        P_.p[(i_)] = saved_.p[((n_ + i_))];
    }
    for (int64_t k3 = 0; k3 < memory_.n[0]; k3 += 1) {
        i_ = k3;
        memory_.p[(i_)] = saved_.p[(((n_ + m_) + i_))];
    }
    return;
}

/* estimation/sample_loop.py:370 usually */
GM_INLINE real sample_loop_usually(real error_, real usual_)
{
    real size_;
    size_ = gm_fabs(error_);
    if ((!(bool)isfinite(size_))) {
        return usual_;
    }
    if (((usual_ == (real)0.0))) {
        return size_;
    }
    return (((size_ > usual_)) ? (usual_ + ((real)0.25 * (size_ - usual_))) : ((real)0.999 * usual_));
}

/* estimation/sample_loop.py:487 _watch */
GM_INLINE void sample_loop_watch(int64_t n_, array1_f8 record_, array1_f8 clock_)
{
    int64_t at_pred_;
    int64_t at_P_pred_;
    int64_t at_z_;
    int64_t at_P_;
    int64_t place_;
    real excess_;
    tuple_2 t1 = step_record_places(n_);
    at_pred_ = t1.v[0];
    at_P_pred_ = t1.v[1];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    place_ = ((4 * n_) + 4);
    clock_.p[4] = (clock_.p[4] + (record_.p[((at_z_ + 4))] - record_.p[((at_pred_ + 4))]));
    clock_.p[5] = (clock_.p[5] + (record_.p[((at_P_pred_ + place_))] - record_.p[((at_P_ + place_))]));
    if (((clock_.p[5] > ((real)2.0 * record_.p[((at_P_ + place_))])))) {
        excess_ = (((clock_.p[4] * clock_.p[4]) / clock_.p[5]) - (real)1.0);
        clock_.p[7] = (clock_.p[7] + ((excess_ - clock_.p[7]) / (real)25.0));
        clock_.p[6] = (clock_.p[6] + (real)1.0);
        clock_.p[8] = (clock_.p[8] + ((excess_ - clock_.p[8]) / gm_min_f(((real)25.0 + clock_.p[6]), (real)500.0)));
        clock_.p[4] = (real)0.0;
        clock_.p[5] = (real)0.0;
    }
    return;
}

/* estimation/sample_loop.py:509 noise_share */
GM_INLINE real sample_loop_noise_share(array1_f8 clock_)
{
    return gm_max_f(gm_min_f(((real)1.0 + gm_max_f(clock_.p[7], clock_.p[8])), (real)1.0), (real)0.0);
}

/* estimation/consider.py:173 variance_of */
GM_INLINE real consider_variance_of(int64_t n_, array1_f8 record_, int64_t at_, int64_t i_)
{
    real total_;
    int64_t c_;
    total_ = (real)0.0;
    tuple_17 t1 = step_record_sensitivities(n_, record_.n[0]);
    for (int64_t k2 = 0; k2 < t1.v[0]; k2 += 1) {
        c_ = k2;
        total_ = (total_ + (record_.p[gm_at(((at_ + (c_ * n_)) + i_), record_.n[0])] * record_.p[gm_at(((at_ + (c_ * n_)) + i_), record_.n[0])]));
    }
    return total_;
}

/* estimation/process_model.py:298 torque_slopes */
GM_INLINE tuple_4 process_model_torque_slopes(Layout layout_, array1_f8 z_, array1_f8 p_)
{
    int64_t curve_;
    int64_t at_;
    real twist_;
    curve_ = layout_.curve_;
    int64_t t1 = process_model_curve_count(curve_);
    int64_t t2 = (layout_.n_ - t1);
    real t3 = (z_.p[0] - z_.p[1]);
    at_ = t2;
    twist_ = t3;
    real t4 = process_model_memory(curve_, z_, at_, twist_);
    tuple_5 t5 = process_model_curve(curve_, z_, 1, 0, at_, p_);
    tuple_7 t6 = process_model_total(curve_, twist_, t4, t5, z_.p[4]);
    return t6.f1;
}

/* estimation/consider.py:191 variances_of */
GM_INLINE tuple_12 consider_variances_of(Layout layout_, array1_f8 z_, array1_f8 record_, int64_t at_, array1_f8 p_)
{
    int64_t n_;
    int64_t curve_;
    int64_t count_;
    real late_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    tuple_4 slopes_;
    int64_t c_;
    int64_t of_c_;
    real twist_;
    real rate_;
    real torque_;
    int64_t i_;
    n_ = layout_.n_;
    curve_ = layout_.curve_;
    tuple_17 t1 = step_record_sensitivities(n_, record_.n[0]);
    count_ = t1.v[0];
    late_ = (p_.p[34] * z_.p[3]);
    real t2 = (late_ * late_);
    of_twist_ = t2;
    of_rate_ = (real)0.0;
    of_torque_ = (real)0.0;
    tuple_4 t3 = process_model_torque_slopes(layout_, z_, p_);
    slopes_ = t3;
    for (int64_t k4 = 0; k4 < count_; k4 += 1) {
        c_ = k4;
        of_c_ = (at_ + (c_ * n_));
        real t5 = (record_.p[gm_at((of_c_ + 0), record_.n[0])] - record_.p[gm_at((of_c_ + 1), record_.n[0])]);
        real t6 = (record_.p[gm_at((of_c_ + 2), record_.n[0])] - record_.p[gm_at((of_c_ + 3), record_.n[0])]);
        twist_ = t5;
        rate_ = t6;
        torque_ = record_.p[gm_at((of_c_ + 4), record_.n[0])];
        if (((curve_ >= 0))) {
            torque_ = (torque_ + (slopes_.v[0] * twist_));
            int64_t t7 = process_model_curve_count(curve_);
            for (int64_t k8 = 0; k8 < t7; k8 += 1) {
                i_ = k8;
                real t12 = torque_;
                real t11 = slopes_.v[((1 + i_))];
                int64_t t10 = (of_c_ + n_);
                int64_t t9 = process_model_curve_count(curve_);
                torque_ = (t12 + (t11 * record_.p[gm_at(((t10 - t9) + i_), record_.n[0])]));
            }
        }
        of_twist_ = (of_twist_ + (twist_ * twist_));
        of_rate_ = (of_rate_ + (rate_ * rate_));
        of_torque_ = (of_torque_ + (torque_ * torque_));
    }
    return (tuple_12){{of_twist_, of_rate_, of_torque_}};
}

/* estimation/process_model.py:246 torque_of */
GM_INLINE tuple_3 process_model_torque_of(Layout layout_, array1_f8 z_, array1_f8 P_, array1_f8 p_)
{
    int64_t n_;
    int64_t curve_;
    int64_t at_;
    real twist_;
    real tau_k_;
    tuple_4 slopes_;
    real variance_;
    int64_t i_;
    int64_t row_;
    real on_others_;
    int64_t j_;
    n_ = layout_.n_;
    curve_ = layout_.curve_;
    if (((curve_ < 0))) {
        return (tuple_3){{z_.p[4], P_.p[(((4 * n_) + 4))]}};
    }
    int64_t t1 = process_model_curve_count(curve_);
    at_ = (n_ - t1);
    twist_ = (z_.p[0] - z_.p[1]);
    real t2 = process_model_memory(curve_, z_, at_, twist_);
    tuple_5 t3 = process_model_curve(curve_, z_, 1, 0, at_, p_);
    tuple_7 t4 = process_model_total(curve_, twist_, t2, t3, z_.p[4]);
    tau_k_ = t4.f0;
    slopes_ = t4.f1;
    variance_ = ((P_.p[(((4 * n_) + 4))] + ((slopes_.v[0] * slopes_.v[0]) * ((P_.p[(((0 * n_) + 0))] + P_.p[(((1 * n_) + 1))]) - ((real)2.0 * P_.p[(((0 * n_) + 1))])))) + (((real)2.0 * slopes_.v[0]) * (P_.p[(((0 * n_) + 4))] - P_.p[(((1 * n_) + 4))])));
    int64_t t5 = process_model_curve_count(curve_);
    for (int64_t k6 = 0; k6 < t5; k6 += 1) {
        i_ = k6;
        row_ = ((at_ + i_) * n_);
        on_others_ = (P_.p[gm_at((row_ + 4), P_.n[0])] + (slopes_.v[0] * (P_.p[gm_at((row_ + 0), P_.n[0])] - P_.p[gm_at((row_ + 1), P_.n[0])])));
        for (int64_t k7 = 0; k7 < i_; k7 += 1) {
            j_ = k7;
            on_others_ = (on_others_ + (slopes_.v[((1 + j_))] * P_.p[gm_at(((row_ + at_) + j_), P_.n[0])]));
        }
        variance_ = (variance_ + (slopes_.v[((1 + i_))] * (((real)2.0 * on_others_) + (slopes_.v[((1 + i_))] * P_.p[gm_at(((row_ + at_) + i_), P_.n[0])]))));
    }
    return (tuple_3){{tau_k_, gm_max_f(variance_, (real)0.0)}};
}

/* estimation/process_model.py:280 motor_side */
GM_INLINE tuple_3 process_model_motor_side(array1_f8 z_, array1_f8 P_, tuple_3 tau_k_, array1_f8 p_)
{
    real torque_;
    real variance_;
    int64_t n_;
    int64_t i_;
    int64_t t1 = (int64_t)(p_.p[29]);
    torque_ = tau_k_.v[0];
    variance_ = tau_k_.v[1];
    n_ = z_.n[0];
    i_ = t1;
    if (((i_ < 0))) {
        return (tuple_3){{torque_, variance_}};
    }
    return (tuple_3){{(torque_ + z_.p[gm_at(i_, z_.n[0])]), ((variance_ + P_.p[gm_at(((i_ * n_) + i_), P_.n[0])]) + ((real)2.0 * P_.p[gm_at(((4 * n_) + i_), P_.n[0])]))}};
}

/* estimation/process_model.py:315 learned_length */
GM_INLINE tuple_3 process_model_learned_length(array1_f8 z_, array1_f8 P_, int64_t n_, int64_t i_)
{
    int64_t k_;
    real length_;
    real variance_;
    k_ = (n_ - 3);
    length_ = (z_.p[gm_at(i_, z_.n[0])] / z_.p[gm_at(k_, z_.n[0])]);
    variance_ = (P_.p[gm_at(((i_ * n_) + i_), P_.n[0])] + (length_ * ((length_ * P_.p[gm_at(((k_ * n_) + k_), P_.n[0])]) - ((real)2.0 * P_.p[gm_at(((k_ * n_) + i_), P_.n[0])]))));
    return (tuple_3){{length_, (gm_sqrt(gm_max_f(variance_, (real)0.0)) / z_.p[gm_at(k_, z_.n[0])])}};
}

/* estimation/consider.py:173 variance_of */
GM_INLINE real consider_variance_of_2(int64_t n_, array1_f8 record_, int64_t at_, int64_t i_)
{
    real total_;
    int64_t c_;
    total_ = (real)0.0;
    tuple_17 t1 = step_record_sensitivities(n_, record_.n[0]);
    for (int64_t k2 = 0; k2 < t1.v[0]; k2 += 1) {
        c_ = k2;
        total_ = (total_ + (record_.p[gm_at(((at_ + (c_ * n_)) + i_), record_.n[0])] * record_.p[gm_at(((at_ + (c_ * n_)) + i_), record_.n[0])]));
    }
    return total_;
}

/* estimation/sample_loop.py:458 write_innovation */
GM_INLINE void sample_loop_write_innovation(array1_f8 row_, real e1_, real e2_, real s11_, real s12_, real s22_)
{
    bool have1_;
    bool have2_;
    row_.p[18] = e1_;
    row_.p[19] = e2_;
    row_.p[30] = s12_;
    real t1 = gm_sqrt(s11_);
    real t2 = gm_sqrt(s22_);
    row_.p[20] = t1;
    row_.p[21] = t2;
    bool t3 = (bool)isfinite(e1_);
    bool t4 = (bool)isfinite(e2_);
    have1_ = t3;
    have2_ = t4;
    row_.p[22] = (have1_ ? (e1_ / gm_sqrt(s11_)) : NAN);
    row_.p[23] = NAN;
    if ((have1_ && have2_)) {
        row_.p[23] = ((e2_ - ((s12_ / gm_sqrt(s11_)) * row_.p[22])) / gm_sqrt((((s11_ * s22_) - (s12_ * s12_)) / s11_)));
    } else {
        if (have2_) {
            row_.p[23] = (e2_ / gm_sqrt(s22_));
        }
    }
    return;
}

/* estimation/sample_loop.py:515 _write_estimate */
GM_STATIC void sample_loop_write_estimate(Layout layout_, Belief belief_, array1_f8 record_, Reading reading_, array1_f8 p_, real share_, array1_f8 row_)
{
    int64_t n_;
    array1_f8 z_;
    array1_f8 P_;
    int64_t at_s_;
    int64_t i_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    int64_t at_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t at_scores_;
    real e1_;
    real e2_;
    real s11_;
    real s12_;
    real s22_;
    n_ = layout_.n_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_17 t1 = step_record_sensitivities(n_, record_.n[0]);
    at_s_ = t1.v[2];
    for (int64_t k2 = 0; k2 < 7; k2 += 1) {
        i_ = k2;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
        row_.p[gm_at((7 + i_), row_.n[0])] = NAN;
    }
    for (int64_t k3 = 0; k3 < 4; k3 += 1) {
        i_ = k3;
        row_.p[gm_at(i_, row_.n[0])] = z_.p[gm_at(i_, z_.n[0])];
        real t5 = P_.p[gm_at(((i_ * n_) + i_), P_.n[0])];
        real t4 = consider_variance_of_2(n_, record_, at_s_, i_);
        row_.p[gm_at((7 + i_), row_.n[0])] = gm_sqrt((t5 + t4));
    }
    tuple_12 t6 = consider_variances_of(layout_, z_, record_, at_s_, p_);
    of_twist_ = t6.v[0];
    of_rate_ = t6.v[1];
    of_torque_ = t6.v[2];
    tuple_3 t7 = process_model_torque_of(layout_, z_, P_, p_);
    row_.p[4] = t7.v[0];
    variance_ = t7.v[1];
    row_.p[37] = gm_sqrt(variance_);
    tuple_3 t8 = process_model_motor_side(z_, P_, (tuple_3){{row_.p[4], variance_}}, p_);
    row_.p[39] = gm_sqrt(gm_max_f(t8.v[1], (real)0.0));
    row_.p[11] = gm_sqrt((((share_ * variance_) + of_torque_) + (p_.p[33] * p_.p[33])));
    row_.p[40] = NAN;
    row_.p[41] = NAN;
    for (int64_t k9 = 31; k9 < 37; k9 += 1) {
        i_ = k9;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
    }
    int64_t t10 = process_model_curve_count(layout_.curve_);
    if (((t10 > 1))) {
        at_ = (n_ - 3);
        real t11 = z_.p[gm_at(at_, z_.n[0])];
        real t12 = gm_sqrt(P_.p[gm_at(((at_ * n_) + at_), P_.n[0])]);
        row_.p[31] = t11;
        row_.p[34] = t12;
        tuple_3 t13 = process_model_learned_length(z_, P_, n_, (n_ - 2));
        row_.p[32] = t13.v[0];
        row_.p[35] = t13.v[1];
        tuple_3 t14 = process_model_learned_length(z_, P_, n_, (n_ - 1));
        row_.p[33] = t14.v[0];
        row_.p[36] = t14.v[1];
    }
    if (((p_.p[28] > (real)0.0))) {
        i_ = (int64_t)(p_.p[28]);
        row_.p[5] = (z_.p[gm_at(i_, z_.n[0])] + reading_.load_);
        real t16 = P_.p[gm_at(((i_ * n_) + i_), P_.n[0])];
        real t15 = consider_variance_of_2(n_, record_, at_s_, i_);
        row_.p[12] = gm_sqrt((t16 + t15));
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        row_.p[6] = z_.p[gm_at(i_, z_.n[0])];
        real t18 = P_.p[gm_at(((i_ * n_) + i_), P_.n[0])];
        real t17 = consider_variance_of_2(n_, record_, at_s_, i_);
        row_.p[13] = gm_sqrt((t18 + t17));
    }
    row_.p[14] = (z_.p[0] - z_.p[1]);
    row_.p[15] = (z_.p[2] - z_.p[3]);
    row_.p[16] = gm_sqrt((gm_max_f(((P_.p[(((0 * n_) + 0))] + P_.p[(((1 * n_) + 1))]) - ((real)2.0 * P_.p[(((0 * n_) + 1))])), (real)0.0) + of_twist_));
    row_.p[17] = gm_sqrt((gm_max_f(((P_.p[(((2 * n_) + 2))] + P_.p[(((3 * n_) + 3))]) - ((real)2.0 * P_.p[(((2 * n_) + 3))])), (real)0.0) + of_rate_));
    tuple_2 t19 = step_record_places(n_);
    at_innovation_ = t19.v[5];
    at_S_ = t19.v[6];
    at_scores_ = t19.v[8];
    real t20 = record_.p[(at_innovation_)];
    real t21 = record_.p[((at_innovation_ + 1))];
    e1_ = t20;
    e2_ = t21;
    real t22 = record_.p[(at_S_)];
    real t23 = record_.p[((at_S_ + 1))];
    real t24 = record_.p[((at_S_ + 2))];
    s11_ = t22;
    s12_ = t23;
    s22_ = t24;
    sample_loop_write_innovation(row_, e1_, e2_, s11_, s12_, s22_);
    real t25 = record_.p[(at_scores_)];
    real t26 = record_.p[((at_scores_ + 1))];
    row_.p[24] = t25;
    row_.p[25] = t26;
    row_.p[26] = record_.p[((at_scores_ + 2))];
    row_.p[27] = reading_.dt_;
    row_.p[28] = reading_.u_;
    row_.p[29] = reading_.load_;
    row_.p[38] = reading_.y1_;
    return;
}

/* estimation/rts_smoother.py:131 _write */
GM_STATIC void rts_smoother_write(Layout layout_, array1_f8 z_, array1_f8 P_, array1_f8 p_, array1_f8 record_, array1_f8 row_)
{
    int64_t n_;
    int64_t at_smoothed_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    real noise_;
    n_ = layout_.n_;
    tuple_17 t1 = step_record_sensitivities(n_, record_.n[0]);
    at_smoothed_ = t1.v[3];
    tuple_12 t2 = consider_variances_of(layout_, z_, record_, at_smoothed_, p_);
    of_twist_ = t2.v[0];
    of_rate_ = t2.v[1];
    of_torque_ = t2.v[2];
    row_.p[0] = (z_.p[0] - z_.p[1]);
    row_.p[1] = (z_.p[2] - z_.p[3]);
    tuple_3 t3 = process_model_torque_of(layout_, z_, P_, p_);
    row_.p[2] = t3.v[0];
    variance_ = t3.v[1];
    noise_ = gm_max_f(((P_.p[(((0 * n_) + 0))] + P_.p[(((1 * n_) + 1))]) - ((real)2.0 * P_.p[(((0 * n_) + 1))])), (real)0.0);
    real t4 = gm_sqrt(noise_);
    real t5 = gm_sqrt((noise_ + of_twist_));
    row_.p[10] = t4;
    row_.p[3] = t5;
    noise_ = gm_max_f(((P_.p[(((2 * n_) + 2))] + P_.p[(((3 * n_) + 3))]) - ((real)2.0 * P_.p[(((2 * n_) + 3))])), (real)0.0);
    row_.p[11] = gm_sqrt(noise_);
    row_.p[4] = gm_sqrt((noise_ + of_rate_));
    row_.p[12] = gm_sqrt(gm_max_f(variance_, (real)0.0));
    row_.p[5] = gm_sqrt(((gm_max_f(variance_, (real)0.0) + of_torque_) + (p_.p[33] * p_.p[33])));
    tuple_3 t6 = process_model_motor_side(z_, P_, (tuple_3){{row_.p[2], variance_}}, p_);
    row_.p[13] = t6.v[0];
    variance_ = t6.v[1];
    row_.p[14] = gm_sqrt(gm_max_f(variance_, (real)0.0));
    real t7 = z_.p[1];
    real t8 = z_.p[3];
    real t9 = z_.p[2];
    row_.p[6] = t7;
    row_.p[7] = t8;
    row_.p[8] = t9;
    row_.p[9] = record_.p[(record_.n[0] - 1)];
    return;
}

/* kernels/linalg.py:318 solve_positive */
GM_STATIC bool linalg_solve_positive(Layout layout_, array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t n_;
    int64_t j_;
    real s_;
    int64_t k_;
    real inverse_;
    int64_t i_;
    tuple_10 row_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        j_ = k1;
        s_ = a_.p[(((j_ * n_) + j_))];
        for (int64_t k2 = 0; k2 < j_; k2 += 1) {
            k_ = k2;
            s_ = (s_ - (a_.p[(((j_ * n_) + k_))] * a_.p[(((j_ * n_) + k_))]));
        }
        if ((!((s_ > (real)0.0)))) {
            return false;
        }
        inverse_ = ((real)1.0 / gm_sqrt(s_));
        a_.p[(((j_ * n_) + j_))] = inverse_;
        int64_t t3 = (j_ + 1);
        for (int64_t k4 = t3; k4 < n_; k4 += 1) {
            i_ = k4;
            s_ = a_.p[(((i_ * n_) + j_))];
            for (int64_t k5 = 0; k5 < j_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (a_.p[(((i_ * n_) + k_))] * a_.p[(((j_ * n_) + k_))]));
            }
            a_.p[(((i_ * n_) + j_))] = (s_ * inverse_);
        }
    }
    for (int64_t k6 = 0; k6 < n_; k6 += 1) {
        i_ = k6;
        tuple_10 t7 = linalg_added(n_, (real)1.0, b_, (i_ * n_), (tuple_10){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t7;
        int64_t t8 = i_;
        for (int64_t k9 = 0; k9 < t8; k9 += 1) {
            k_ = k9;
            tuple_10 t10 = linalg_added(n_, (-a_.p[(((i_ * n_) + k_))]), out_, (k_ * n_), row_);
            row_ = t10;
        }
        linalg_put(n_, row_, out_, (i_ * n_));
        tuple_10 t11 = linalg_added(n_, a_.p[(((i_ * n_) + i_))], out_, (i_ * n_), (tuple_10){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(n_, t11, out_, (i_ * n_));
    }
    int64_t t12 = (n_ - 1);
    for (int64_t k13 = t12; k13 > (-1); k13 += -1) {
        i_ = k13;
        tuple_10 t14 = linalg_added(n_, (real)1.0, out_, (i_ * n_), (tuple_10){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t14;
        int64_t t15 = (i_ + 1);
        for (int64_t k16 = t15; k16 < n_; k16 += 1) {
            k_ = k16;
            tuple_10 t17 = linalg_added(n_, (-a_.p[(((k_ * n_) + i_))]), out_, (k_ * n_), row_);
            row_ = t17;
        }
        linalg_put(n_, row_, out_, (i_ * n_));
        tuple_10 t18 = linalg_added(n_, a_.p[(((i_ * n_) + i_))], out_, (i_ * n_), (tuple_10){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(n_, t18, out_, (i_ * n_));
    }
    return true;
}

/* kernels/linalg.py:304 transposed_multiply_symmetric */
GM_INLINE void linalg_transposed_multiply_symmetric(Layout layout_, array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t n_;
    int64_t i_;
    tuple_10 row_;
    int64_t k_;
    int64_t j_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        row_ = (tuple_10){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            k_ = k2;
            tuple_10 t3 = linalg_added(n_, a_.p[(((k_ * n_) + i_))], b_, (k_ * n_), row_);
            row_ = t3;
        }
        linalg_put(n_, row_, out_, (i_ * n_));
    }
    for (int64_t k4 = 0; k4 < n_; k4 += 1) {
        i_ = k4;
        int64_t t5 = i_;
        for (int64_t k6 = 0; k6 < t5; k6 += 1) {
            j_ = k6;
            out_.p[(((j_ * n_) + i_))] = out_.p[(((i_ * n_) + j_))];
        }
    }
    return;
}

/* kernels/linalg.py:293 add_product */
GM_INLINE void linalg_add_product(Layout layout_, array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t n_;
    int64_t at_;
    tuple_10 row_;
    int64_t k_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < out_.n[0]; k1 += n_) {
        at_ = k1;
        tuple_10 t2 = linalg_added(n_, (real)1.0, out_, at_, (tuple_10){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < n_; k3 += 1) {
            k_ = k3;
            tuple_10 t4 = linalg_added(n_, a_.p[((at_ + k_))], b_, (k_ * n_), row_);
            row_ = t4;
        }
        linalg_put(n_, row_, out_, at_);
    }
    return;
}

/* estimation/rts_smoother.py:60 smooth */
GM_STATIC void rts_smoother_smooth(Layout layout_, array2_f8 ring_, Span span_, array1_f8 p_, array1_f8 z_, array2_f8 matrices_, array2_f8 out_)
{
    int64_t n_;
    int64_t rows_;
    int64_t newest_;
    int64_t oldest_;
    int64_t keep_until_;
    array1_f8 P_;
    array1_f8 gain_t_;
    array1_f8 factor_;
    array1_f8 change_;
    array1_f8 product_;
    int64_t at_pred_;
    int64_t at_P_pred_;
    int64_t at_cross_;
    int64_t at_z_;
    int64_t at_P_;
    int64_t count_;
    int64_t at_s_pred_;
    int64_t at_s_;
    int64_t at_smoothed_;
    array1_f8 last_;
    int64_t i_;
    int64_t k_;
    array1_f8 record_;
    array1_f8 later_;
    real s_;
    int64_t m_;
    array1_f8 change_s_;
    n_ = layout_.n_;
    rows_ = ring_.n[0];
    newest_ = span_.newest_;
    oldest_ = span_.oldest_;
    keep_until_ = span_.keep_until_;
    P_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    gain_t_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    factor_ = (array1_f8){matrices_.p + 2 * (matrices_.n[1]), {matrices_.n[1]}};
    change_ = (array1_f8){matrices_.p + 3 * (matrices_.n[1]), {matrices_.n[1]}};
    product_ = (array1_f8){matrices_.p + 4 * (matrices_.n[1]), {matrices_.n[1]}};
    tuple_2 t1 = step_record_places(n_);
    at_pred_ = t1.v[0];
    at_P_pred_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    tuple_17 t2 = step_record_sensitivities(n_, ring_.n[1]);
    count_ = t2.v[0];
    at_s_pred_ = t2.v[1];
    at_s_ = t2.v[2];
    at_smoothed_ = t2.v[3];
    last_ = (array1_f8){ring_.p + (gm_mod(newest_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
    int64_t t3 = (n_ * count_);
    for (int64_t k4 = 0; k4 < t3; k4 += 1) {
        i_ = k4;
        last_.p[gm_at((at_smoothed_ + i_), last_.n[0])] = last_.p[gm_at((at_s_ + i_), last_.n[0])];
    }
    for (int64_t k5 = 0; k5 < n_; k5 += 1) {
        i_ = k5;
        z_.p[(i_)] = last_.p[((at_z_ + i_))];
    }
    int64_t t6 = (n_ * n_);
    for (int64_t k7 = 0; k7 < t6; k7 += 1) {
        i_ = k7;
        P_.p[(i_)] = last_.p[((at_P_ + i_))];
    }
    if (((newest_ <= keep_until_))) {
        rts_smoother_write(layout_, z_, P_, p_, last_, (array1_f8){out_.p + gm_at((newest_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
    }
    int64_t t8 = (newest_ - 1);
    int64_t t9 = (oldest_ - 1);
    for (int64_t k10 = t8; k10 > t9; k10 += -1) {
        k_ = k10;
        record_ = (array1_f8){ring_.p + (gm_mod(k_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        later_ = (array1_f8){ring_.p + (gm_mod((k_ + 1), rows_)) * (ring_.n[1]), {ring_.n[1]}};
        int64_t t11 = (n_ * n_);
        for (int64_t k12 = 0; k12 < t11; k12 += 1) {
            i_ = k12;
            factor_.p[(i_)] = later_.p[((at_P_pred_ + i_))];
            change_.p[(i_)] = (P_.p[(i_)] - later_.p[((at_P_pred_ + i_))]);
        }
        int64_t t13 = (at_cross_ + (n_ * n_));
        int64_t t14 = gm_bound(at_cross_, later_.n[0]);
        int64_t t15 = gm_bound(t13, later_.n[0]);
        int64_t t16 = gm_span(t14, t15);
        bool t17 = linalg_solve_positive(layout_, factor_, (array1_f8){later_.p + t14 * (1), {t16}}, gain_t_);
        if (t17) {
            for (int64_t k18 = 0; k18 < n_; k18 += 1) {
                i_ = k18;
                z_.p[(i_)] = (z_.p[(i_)] - later_.p[((at_pred_ + i_))]);
            }
            linalg_multiply(layout_, change_, gain_t_, product_);
            linalg_transposed_multiply_symmetric(layout_, gain_t_, product_, P_);
            int64_t t19 = (n_ * n_);
            for (int64_t k20 = 0; k20 < t19; k20 += 1) {
                i_ = k20;
                P_.p[(i_)] = (P_.p[(i_)] + record_.p[((at_P_ + i_))]);
            }
            for (int64_t k21 = 0; k21 < n_; k21 += 1) {
                i_ = k21;
                s_ = record_.p[((at_z_ + i_))];
                for (int64_t k22 = 0; k22 < n_; k22 += 1) {
                    m_ = k22;
                    s_ = (s_ + (gain_t_.p[(((m_ * n_) + i_))] * z_.p[(m_)]));
                }
                product_.p[(i_)] = s_;
            }
            for (int64_t k23 = 0; k23 < n_; k23 += 1) {
                i_ = k23;
                z_.p[(i_)] = product_.p[(i_)];
            }
            int64_t t24 = (at_smoothed_ + (n_ * count_));
            int64_t t25 = gm_bound(at_smoothed_, later_.n[0]);
            int64_t t26 = gm_bound(t24, later_.n[0]);
            int64_t t27 = gm_span(t25, t26);
            change_s_ = (array1_f8){later_.p + t25 * (1), {t27}};
            int64_t t28 = (n_ * count_);
            for (int64_t k29 = 0; k29 < t28; k29 += 1) {
                i_ = k29;
                change_s_.p[(i_)] = (change_s_.p[(i_)] - later_.p[((at_s_pred_ + i_))]);
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            int64_t t30 = (at_smoothed_ + (n_ * count_));
            int64_t t31 = gm_bound(at_smoothed_, record_.n[0]);
            int64_t t32 = gm_bound(t30, record_.n[0]);
            int64_t t33 = gm_span(t31, t32);
            linalg_add_product(layout_, change_s_, gain_t_, (array1_f8){record_.p + t31 * (1), {t33}});
        } else {
            int64_t t34 = (n_ * count_);
            for (int64_t k35 = 0; k35 < t34; k35 += 1) {
                i_ = k35;
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            for (int64_t k36 = 0; k36 < n_; k36 += 1) {
                i_ = k36;
                z_.p[(i_)] = record_.p[((at_z_ + i_))];
            }
            int64_t t37 = (n_ * n_);
            for (int64_t k38 = 0; k38 < t37; k38 += 1) {
                i_ = k38;
                P_.p[(i_)] = record_.p[((at_P_ + i_))];
            }
        }
        if (((k_ <= keep_until_))) {
            rts_smoother_write(layout_, z_, P_, p_, record_, (array1_f8){out_.p + gm_at((k_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
        }
    }
    return;
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_18 sample_loop_run_aekf(Layout layout_, LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
{
    array1_i8 stamps_;
    array2_f8 inputs_;
    array2_f8 outputs_;
    int64_t max_gap_;
    int64_t delay_;
    int64_t lag_;
    bool load_measured_;
    bool narrow_;
    DescribedLoad described_;
    array1_i8 gate_;
    array1_i8 counts_;
    array1_f8 clock_;
    array2_f8 efforts_;
    array2_f8 ring_;
    array1_i8 ring_stamps_;
    array1_f8 saved_;
    Companions companions_;
    array1_i8 codes_;
    array2_f8 estimates_;
    array1_i8 smoothed_stamps_;
    array2_f8 smoothed_;
    array1_f8 memory_;
    int64_t rows_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t n_smoothed_;
    int64_t k_;
    int64_t stamp_;
    real u_;
    real load_;
    real y1_;
    real y2_;
    bool have_y_;
    int64_t code_;
    bool have_u_;
    int64_t i_;
    int64_t last_;
    real dt_;
    int64_t step_;
    int64_t place_;
    int64_t previous_;
    int64_t acting_;
    real u_acting_;
    Reading reading_;
    array1_f8 record_;
    bool good_;
    real e1_;
    real e2_;
    int64_t bridged_;
    bool in_doubt_;
    real share_;
    bool half_;
    int64_t oldest_;
    int64_t keep_;
    array1_f8 row_;
    stamps_ = stream_.stamps_;
    inputs_ = stream_.inputs_;
    outputs_ = stream_.outputs_;
    max_gap_ = settings_.max_gap_;
    delay_ = settings_.delay_;
    lag_ = settings_.lag_;
    load_measured_ = settings_.load_measured_;
    narrow_ = settings_.narrow_;
    described_ = settings_.described_;
    gate_ = state_.gate_;
    counts_ = state_.counts_;
    clock_ = state_.clock_;
    efforts_ = state_.efforts_;
    ring_ = state_.ring_;
    ring_stamps_ = state_.ring_stamps_;
    saved_ = state_.saved_;
    companions_ = state_.companions_;
    codes_ = output_.codes_;
    estimates_ = output_.estimates_;
    smoothed_stamps_ = output_.smoothed_stamps_;
    smoothed_ = output_.smoothed_;
    memory_ = belief_.memory_;
    rows_ = ring_.n[0];
    tuple_2 t1 = step_record_places(layout_.n_);
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    n_smoothed_ = 0;
    for (int64_t k2 = 0; k2 < stamps_.n[0]; k2 += 1) {
        k_ = k2;
        stamp_ = stamps_.p[(k_)];
        gate_.p[10] = (gate_.p[10] + 1);
        real t3 = inputs_.p[((k_) * inputs_.n[1] + 0)];
        real t4 = inputs_.p[((k_) * inputs_.n[1] + 1)];
        real t5 = outputs_.p[((k_) * outputs_.n[1] + 0)];
        real t6 = outputs_.p[((k_) * outputs_.n[1] + 1)];
        u_ = t3;
        load_ = t4;
        y1_ = t5;
        y2_ = t6;
        if ((((((gm_fabs(u_) > (real)1000000000.0)) || ((gm_fabs(load_) > (real)1000000000.0))) || ((gm_fabs(y1_) > (real)1000000000.0))) || ((gm_fabs(y2_) > (real)1000000000.0)))) {
            counts_.p[10] = (counts_.p[10] + 1);
            real t7 = (((gm_fabs(u_) <= (real)1000000000.0)) ? u_ : NAN);
            real t8 = (((gm_fabs(load_) <= (real)1000000000.0)) ? load_ : NAN);
            u_ = t7;
            load_ = t8;
            real t9 = (((gm_fabs(y1_) <= (real)1000000000.0)) ? y1_ : NAN);
            real t10 = (((gm_fabs(y2_) <= (real)1000000000.0)) ? y2_ : NAN);
            y1_ = t9;
            y2_ = t10;
        }
        have_y_ = ((bool)isfinite(y1_) || (bool)isfinite(y2_));
        int64_t t11 = sample_loop_gate(stamp_, gate_, max_gap_);
        code_ = t11;
        if ((((code_ == 0)) || ((code_ == 1)))) {
            if (((code_ == 1))) {
                gate_.p[4] = stamp_;
                gate_.p[3] = stamp_;
            }
            if ((!(bool)isfinite(y1_))) {
                counts_.p[11] = (counts_.p[11] + 1);
            }
            if ((!(bool)isfinite(y2_))) {
                counts_.p[12] = (counts_.p[12] + 1);
            }
            have_u_ = ((bool)isfinite(u_) && ((!load_measured_) || (bool)isfinite(load_)));
            if ((!have_u_)) {
                counts_.p[13] = (counts_.p[13] + 1);
                if ((((code_ == 1)) || (((stamp_ - gate_.p[3]) > max_gap_)))) {
                    code_ = 6;
                }
            } else {
                if (((!have_y_) && (((code_ == 1)) || (((stamp_ - gate_.p[4]) > max_gap_))))) {
                    code_ = 7;
                }
            }
            if ((((code_ == 6)) || ((code_ == 7)))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
        }
        counts_.p[(code_)] = (counts_.p[(code_)] + 1);
        codes_.p[(k_)] = code_;
        if ((((code_ != 0)) && ((code_ != 1)))) {
            bool t13 = (((code_ == 6)) || ((code_ == 7)));
            if (t13) {
            bool t12 = sample_loop_stops(stamp_, gate_);
            t13 = t12;
            }
            if (t13) {
                return (tuple_18){{(k_ + 1), n_smoothed_}};
            }
            continue;
        }
        if (have_u_) {
            gate_.p[3] = stamp_;
        }
        if (have_y_) {
            gate_.p[4] = stamp_;
        }
        if (((code_ == 1))) {
            gate_.p[0] = stamp_;
            gate_.p[5] = 0;
            gate_.p[2] = 0;
            gate_.p[9] = 0;
            gate_.p[7] = 0;
            array1_f8 t14 = (array1_f8){clock_.p, {clock_.n[0]}};
            for (int64_t k15 = 0; k15 < t14.n[0]; k15++)
                t14.p[k15 * (1)] = (real)0.0;
            for (int64_t k16 = 0; k16 < 64; k16 += 1) {
                i_ = k16;
                real t17 = u_;
                real t18 = (load_measured_ ? load_ : (real)0.0);
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 0)] = t17;
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 1)] = t18;
            }
            gate_.p[6] = stamp_;
            sample_loop_start(layout_, belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            aekf_resume(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        last_ = gate_.p[0];
        dt_ = ((real)((stamp_ - last_)) * (real)1e-09);
        step_ = (gate_.p[5] + 1);
        int64_t t19 = gm_mod(step_, 64);
        int64_t t20 = gm_mod((step_ - 1), 64);
        place_ = t19;
        previous_ = t20;
        efforts_.p[((place_) * efforts_.n[1] + 0)] = ((bool)isfinite(u_) ? u_ : efforts_.p[((previous_) * efforts_.n[1] + 0)]);
        efforts_.p[((place_) * efforts_.n[1] + 1)] = ((bool)isfinite(load_) ? load_ : efforts_.p[((previous_) * efforts_.n[1] + 1)]);
        acting_ = gm_mod(((step_ - 1) - delay_), 64);
        u_acting_ = efforts_.p[((acting_) * efforts_.n[1] + 0)];
        sample_loop_save(belief_, saved_);
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_19){place_, dt_}, state_, layout_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(layout_, belief_, reading_, p_);
        }
        bool t22 = aekf_step(layout_, belief_, reading_, p_, scratch_, record_);
        good_ = t22;
        real t23 = record_.p[(at_innovation_)];
        real t24 = record_.p[((at_innovation_ + 1))];
        e1_ = t23;
        e2_ = t24;
        bool t25 = sample_loop_jumps(e1_, record_.p[(at_S_)], clock_.p[1], p_.p[31], step_);
        bool t27 = t25;
        if (!t27) {
        bool t26 = sample_loop_jumps(e2_, record_.p[((at_S_ + 2))], clock_.p[2], p_.p[32], step_);
        t27 = t26;
        }
        if (t27) {
            sample_loop_put_back(belief_, saved_);
            codes_.p[(k_)] = 9;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[9] = (counts_.p[9] + 1);
            gate_.p[7] = (gate_.p[7] + 1);
            if (((gate_.p[7] >= 3))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
            continue;
        }
        gate_.p[0] = stamp_;
        gate_.p[5] = step_;
        gate_.p[7] = 0;
        if (((clock_.p[0] == (real)0.0))) {
            clock_.p[0] = dt_;
        } else {
            if (((dt_ > ((real)1.7 * clock_.p[0])))) {
                counts_.p[14] = (counts_.p[14] + ((int64_t)(((dt_ / clock_.p[0]) + (real)0.5)) - 1));
            }
            clock_.p[0] = (clock_.p[0] * (((dt_ > clock_.p[0])) ? (real)1.02 : (real)0.9803921568627451));
        }
        bridged_ = (stamp_ - gm_min_i(gm_min_i(last_, gate_.p[3]), gate_.p[4]));
        in_doubt_ = (((bridged_ > 30000000)) && (((real)(bridged_) > ((real)2500000000.0 * clock_.p[0]))));
        if (in_doubt_) {
            gate_.p[6] = stamp_;
        }
        ring_stamps_.p[(gm_mod(step_, rows_))] = stamp_;
        bool t30 = good_;
        if (t30) {
        tuple_14 t28 = aekf_used(memory_, p_);
        bool t29 = consider_accompany(layout_, companions_, saved_, reading_, t28, record_);
        t30 = t29;
        }
        good_ = t30;
        if ((!good_)) {
            codes_.p[(k_)] = 8;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[8] = (counts_.p[8] + 1);
            gate_.p[0] = 0;
            array1_f8 t31 = (array1_f8){memory_.p, {memory_.n[0]}};
            for (int64_t k32 = 0; k32 < t31.n[0]; k32++)
                t31.p[k32 * (1)] = (real)0.0;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if (((narrow_ && ((layout_.curve_ < 0))) && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(layout_.n_, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(layout_, belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
        half_ = ((gm_mod(step_, (rows_ / 2)) == 0));
        if ((((lag_ > 0)) && (half_ || ((gm_div((stamp_ * 2), lag_) != gm_div((last_ * 2), lag_)))))) {
            oldest_ = gate_.p[9];
            keep_ = (half_ ? gm_max_i((oldest_ - 1), (step_ - (rows_ / 2))) : (oldest_ - 1));
            for (;;) {
                if (!(((keep_ < step_)) && ((ring_stamps_.p[(gm_mod((keep_ + 1), rows_))] <= (stamp_ - lag_))))) break;
                keep_ = (keep_ + 1);
            }
            if (((keep_ >= oldest_))) {
                int64_t t39 = keep_;
                int64_t t36 = n_smoothed_;
                int64_t t37 = gm_bound(t36, smoothed_.n[0]);
                int64_t t38 = gm_span(t37, smoothed_.n[0]);
                rts_smoother_smooth(layout_, ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
                int64_t t40 = (keep_ + 1);
                for (int64_t k41 = oldest_; k41 < t40; k41 += 1) {
                    i_ = k41;
                    smoothed_stamps_.p[(n_smoothed_)] = ring_stamps_.p[(gm_mod(i_, rows_))];
                    if (((share_ < (real)1.0))) {
                        row_ = (array1_f8){smoothed_.p + (n_smoothed_) * (smoothed_.n[1]), {smoothed_.n[1]}};
                        row_.p[5] = gm_sqrt(gm_max_f(((row_.p[5] * row_.p[5]) - (((real)1.0 - gm_sqrt(share_)) * (row_.p[12] * row_.p[12]))), (real)0.0));
                    }
                    n_smoothed_ = (n_smoothed_ + 1);
                }
                gate_.p[9] = (keep_ + 1);
            }
        }
        bool t43 = in_doubt_;
        if (!t43) {
        bool t42 = sample_loop_stops(stamp_, gate_);
        t43 = t42;
        }
        if (t43) {
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_18){{stamps_.n[0], n_smoothed_}};
}

/* estimation/filter_kind.py:92 forget */
GM_INLINE void filter_kind_forget(array1_f8 memory_)
{
    array1_f8 t1 = (array1_f8){memory_.p, {memory_.n[0]}};
    for (int64_t k2 = 0; k2 < t1.n[0]; k2++)
        t1.p[k2 * (1)] = (real)0.0;
    return;
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_18 sample_loop_run_ekf(Layout layout_, LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
{
    array1_i8 stamps_;
    array2_f8 inputs_;
    array2_f8 outputs_;
    int64_t max_gap_;
    int64_t delay_;
    int64_t lag_;
    bool load_measured_;
    bool narrow_;
    DescribedLoad described_;
    array1_i8 gate_;
    array1_i8 counts_;
    array1_f8 clock_;
    array2_f8 efforts_;
    array2_f8 ring_;
    array1_i8 ring_stamps_;
    array1_f8 saved_;
    Companions companions_;
    array1_i8 codes_;
    array2_f8 estimates_;
    array1_i8 smoothed_stamps_;
    array2_f8 smoothed_;
    array1_f8 memory_;
    int64_t rows_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t n_smoothed_;
    int64_t k_;
    int64_t stamp_;
    real u_;
    real load_;
    real y1_;
    real y2_;
    bool have_y_;
    int64_t code_;
    bool have_u_;
    int64_t i_;
    int64_t last_;
    real dt_;
    int64_t step_;
    int64_t place_;
    int64_t previous_;
    int64_t acting_;
    real u_acting_;
    Reading reading_;
    array1_f8 record_;
    bool good_;
    real e1_;
    real e2_;
    int64_t bridged_;
    bool in_doubt_;
    real share_;
    bool half_;
    int64_t oldest_;
    int64_t keep_;
    array1_f8 row_;
    stamps_ = stream_.stamps_;
    inputs_ = stream_.inputs_;
    outputs_ = stream_.outputs_;
    max_gap_ = settings_.max_gap_;
    delay_ = settings_.delay_;
    lag_ = settings_.lag_;
    load_measured_ = settings_.load_measured_;
    narrow_ = settings_.narrow_;
    described_ = settings_.described_;
    gate_ = state_.gate_;
    counts_ = state_.counts_;
    clock_ = state_.clock_;
    efforts_ = state_.efforts_;
    ring_ = state_.ring_;
    ring_stamps_ = state_.ring_stamps_;
    saved_ = state_.saved_;
    companions_ = state_.companions_;
    codes_ = output_.codes_;
    estimates_ = output_.estimates_;
    smoothed_stamps_ = output_.smoothed_stamps_;
    smoothed_ = output_.smoothed_;
    memory_ = belief_.memory_;
    rows_ = ring_.n[0];
    tuple_2 t1 = step_record_places(layout_.n_);
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    n_smoothed_ = 0;
    for (int64_t k2 = 0; k2 < stamps_.n[0]; k2 += 1) {
        k_ = k2;
        stamp_ = stamps_.p[(k_)];
        gate_.p[10] = (gate_.p[10] + 1);
        real t3 = inputs_.p[((k_) * inputs_.n[1] + 0)];
        real t4 = inputs_.p[((k_) * inputs_.n[1] + 1)];
        real t5 = outputs_.p[((k_) * outputs_.n[1] + 0)];
        real t6 = outputs_.p[((k_) * outputs_.n[1] + 1)];
        u_ = t3;
        load_ = t4;
        y1_ = t5;
        y2_ = t6;
        if ((((((gm_fabs(u_) > (real)1000000000.0)) || ((gm_fabs(load_) > (real)1000000000.0))) || ((gm_fabs(y1_) > (real)1000000000.0))) || ((gm_fabs(y2_) > (real)1000000000.0)))) {
            counts_.p[10] = (counts_.p[10] + 1);
            real t7 = (((gm_fabs(u_) <= (real)1000000000.0)) ? u_ : NAN);
            real t8 = (((gm_fabs(load_) <= (real)1000000000.0)) ? load_ : NAN);
            u_ = t7;
            load_ = t8;
            real t9 = (((gm_fabs(y1_) <= (real)1000000000.0)) ? y1_ : NAN);
            real t10 = (((gm_fabs(y2_) <= (real)1000000000.0)) ? y2_ : NAN);
            y1_ = t9;
            y2_ = t10;
        }
        have_y_ = ((bool)isfinite(y1_) || (bool)isfinite(y2_));
        int64_t t11 = sample_loop_gate(stamp_, gate_, max_gap_);
        code_ = t11;
        if ((((code_ == 0)) || ((code_ == 1)))) {
            if (((code_ == 1))) {
                gate_.p[4] = stamp_;
                gate_.p[3] = stamp_;
            }
            if ((!(bool)isfinite(y1_))) {
                counts_.p[11] = (counts_.p[11] + 1);
            }
            if ((!(bool)isfinite(y2_))) {
                counts_.p[12] = (counts_.p[12] + 1);
            }
            have_u_ = ((bool)isfinite(u_) && ((!load_measured_) || (bool)isfinite(load_)));
            if ((!have_u_)) {
                counts_.p[13] = (counts_.p[13] + 1);
                if ((((code_ == 1)) || (((stamp_ - gate_.p[3]) > max_gap_)))) {
                    code_ = 6;
                }
            } else {
                if (((!have_y_) && (((code_ == 1)) || (((stamp_ - gate_.p[4]) > max_gap_))))) {
                    code_ = 7;
                }
            }
            if ((((code_ == 6)) || ((code_ == 7)))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
        }
        counts_.p[(code_)] = (counts_.p[(code_)] + 1);
        codes_.p[(k_)] = code_;
        if ((((code_ != 0)) && ((code_ != 1)))) {
            bool t13 = (((code_ == 6)) || ((code_ == 7)));
            if (t13) {
            bool t12 = sample_loop_stops(stamp_, gate_);
            t13 = t12;
            }
            if (t13) {
                return (tuple_18){{(k_ + 1), n_smoothed_}};
            }
            continue;
        }
        if (have_u_) {
            gate_.p[3] = stamp_;
        }
        if (have_y_) {
            gate_.p[4] = stamp_;
        }
        if (((code_ == 1))) {
            gate_.p[0] = stamp_;
            gate_.p[5] = 0;
            gate_.p[2] = 0;
            gate_.p[9] = 0;
            gate_.p[7] = 0;
            array1_f8 t14 = (array1_f8){clock_.p, {clock_.n[0]}};
            for (int64_t k15 = 0; k15 < t14.n[0]; k15++)
                t14.p[k15 * (1)] = (real)0.0;
            for (int64_t k16 = 0; k16 < 64; k16 += 1) {
                i_ = k16;
                real t17 = u_;
                real t18 = (load_measured_ ? load_ : (real)0.0);
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 0)] = t17;
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 1)] = t18;
            }
            gate_.p[6] = stamp_;
            sample_loop_start(layout_, belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        last_ = gate_.p[0];
        dt_ = ((real)((stamp_ - last_)) * (real)1e-09);
        step_ = (gate_.p[5] + 1);
        int64_t t19 = gm_mod(step_, 64);
        int64_t t20 = gm_mod((step_ - 1), 64);
        place_ = t19;
        previous_ = t20;
        efforts_.p[((place_) * efforts_.n[1] + 0)] = ((bool)isfinite(u_) ? u_ : efforts_.p[((previous_) * efforts_.n[1] + 0)]);
        efforts_.p[((place_) * efforts_.n[1] + 1)] = ((bool)isfinite(load_) ? load_ : efforts_.p[((previous_) * efforts_.n[1] + 1)]);
        acting_ = gm_mod(((step_ - 1) - delay_), 64);
        u_acting_ = efforts_.p[((acting_) * efforts_.n[1] + 0)];
        sample_loop_save(belief_, saved_);
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_19){place_, dt_}, state_, layout_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(layout_, belief_, reading_, p_);
        }
        bool t22 = ekf_step(layout_, belief_, reading_, p_, scratch_, record_);
        good_ = t22;
        real t23 = record_.p[(at_innovation_)];
        real t24 = record_.p[((at_innovation_ + 1))];
        e1_ = t23;
        e2_ = t24;
        bool t25 = sample_loop_jumps(e1_, record_.p[(at_S_)], clock_.p[1], p_.p[31], step_);
        bool t27 = t25;
        if (!t27) {
        bool t26 = sample_loop_jumps(e2_, record_.p[((at_S_ + 2))], clock_.p[2], p_.p[32], step_);
        t27 = t26;
        }
        if (t27) {
            sample_loop_put_back(belief_, saved_);
            codes_.p[(k_)] = 9;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[9] = (counts_.p[9] + 1);
            gate_.p[7] = (gate_.p[7] + 1);
            if (((gate_.p[7] >= 3))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
            continue;
        }
        gate_.p[0] = stamp_;
        gate_.p[5] = step_;
        gate_.p[7] = 0;
        if (((clock_.p[0] == (real)0.0))) {
            clock_.p[0] = dt_;
        } else {
            if (((dt_ > ((real)1.7 * clock_.p[0])))) {
                counts_.p[14] = (counts_.p[14] + ((int64_t)(((dt_ / clock_.p[0]) + (real)0.5)) - 1));
            }
            clock_.p[0] = (clock_.p[0] * (((dt_ > clock_.p[0])) ? (real)1.02 : (real)0.9803921568627451));
        }
        bridged_ = (stamp_ - gm_min_i(gm_min_i(last_, gate_.p[3]), gate_.p[4]));
        in_doubt_ = (((bridged_ > 30000000)) && (((real)(bridged_) > ((real)2500000000.0 * clock_.p[0]))));
        if (in_doubt_) {
            gate_.p[6] = stamp_;
        }
        ring_stamps_.p[(gm_mod(step_, rows_))] = stamp_;
        bool t30 = good_;
        if (t30) {
        tuple_14 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany(layout_, companions_, saved_, reading_, t28, record_);
        t30 = t29;
        }
        good_ = t30;
        if ((!good_)) {
            codes_.p[(k_)] = 8;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[8] = (counts_.p[8] + 1);
            gate_.p[0] = 0;
            array1_f8 t31 = (array1_f8){memory_.p, {memory_.n[0]}};
            for (int64_t k32 = 0; k32 < t31.n[0]; k32++)
                t31.p[k32 * (1)] = (real)0.0;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if (((narrow_ && ((layout_.curve_ < 0))) && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(layout_.n_, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(layout_, belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
        half_ = ((gm_mod(step_, (rows_ / 2)) == 0));
        if ((((lag_ > 0)) && (half_ || ((gm_div((stamp_ * 2), lag_) != gm_div((last_ * 2), lag_)))))) {
            oldest_ = gate_.p[9];
            keep_ = (half_ ? gm_max_i((oldest_ - 1), (step_ - (rows_ / 2))) : (oldest_ - 1));
            for (;;) {
                if (!(((keep_ < step_)) && ((ring_stamps_.p[(gm_mod((keep_ + 1), rows_))] <= (stamp_ - lag_))))) break;
                keep_ = (keep_ + 1);
            }
            if (((keep_ >= oldest_))) {
                int64_t t39 = keep_;
                int64_t t36 = n_smoothed_;
                int64_t t37 = gm_bound(t36, smoothed_.n[0]);
                int64_t t38 = gm_span(t37, smoothed_.n[0]);
                rts_smoother_smooth(layout_, ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
                int64_t t40 = (keep_ + 1);
                for (int64_t k41 = oldest_; k41 < t40; k41 += 1) {
                    i_ = k41;
                    smoothed_stamps_.p[(n_smoothed_)] = ring_stamps_.p[(gm_mod(i_, rows_))];
                    if (((share_ < (real)1.0))) {
                        row_ = (array1_f8){smoothed_.p + (n_smoothed_) * (smoothed_.n[1]), {smoothed_.n[1]}};
                        row_.p[5] = gm_sqrt(gm_max_f(((row_.p[5] * row_.p[5]) - (((real)1.0 - gm_sqrt(share_)) * (row_.p[12] * row_.p[12]))), (real)0.0));
                    }
                    n_smoothed_ = (n_smoothed_ + 1);
                }
                gate_.p[9] = (keep_ + 1);
            }
        }
        bool t43 = in_doubt_;
        if (!t43) {
        bool t42 = sample_loop_stops(stamp_, gate_);
        t43 = t42;
        }
        if (t43) {
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_18){{stamps_.n[0], n_smoothed_}};
}

/* estimation/slopes.py:75 _begin */
GM_INLINE void slopes_begin(Belief belief_, int64_t i_, tuple_18 places_, real r_, real dt_)
{
    array1_f8 z_;
    array1_f8 P_;
    array1_f8 memory_;
    int64_t x_;
    int64_t v_;
    int64_t n_;
    real of_P_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    memory_ = belief_.memory_;
    x_ = places_.v[0];
    v_ = places_.v[1];
    n_ = z_.n[0];
    of_P_ = (((P_.p[(((x_ * n_) + x_))] == r_)) ? r_ : (real)0.0);
    memory_.p[((((115 + (6 * n_)) + (((i_ * n_) + x_) * n_)) + x_))] = of_P_;
    memory_.p[(((115 + (i_ * n_)) + v_))] = (((-z_.p[(v_)]) * (of_P_ + r_)) / ((((P_.p[(((v_ * n_) + v_))] * dt_) * dt_) + P_.p[(((x_ * n_) + x_))]) + r_));
    return;
}

/* estimation/filters/aekf.py:247 gradient */
GM_INLINE real aekf_gradient(array2_f8 vectors_, int64_t i_)
{
    return (-vectors_.p[(((56 + i_)) * vectors_.n[1] + 0)]);
}

/* estimation/slopes.py:42 step */
GM_APART bool slopes_step(Layout layout_, Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    array1_f8 memory_;
    array2_f8 vectors_;
    int64_t i_;
    int64_t j_;
    memory_ = belief_.memory_;
    vectors_ = scratch_.vectors_;
    if (((memory_.p[0] == (real)0.0))) {
        memory_.p[0] = (real)1.0;
        for (int64_t k1 = 0; k1 < 74; k1 += 1) {
            i_ = k1;
            memory_.p[((41 + i_))] = p_.p[(i_)];
        }
    }
    if (((memory_.p[1] == (real)0.0))) {
        memory_.p[1] = (real)1.0;
        int64_t t2 = (int64_t)(p_.p[45]);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            if (((p_.p[((46 + i_))] == (real)31.0))) {
                slopes_begin(belief_, i_, (tuple_18){{0, 2}}, p_.p[31], reading_.dt_);
            } else {
                if (((p_.p[((46 + i_))] == (real)32.0))) {
                    slopes_begin(belief_, i_, (tuple_18){{1, 3}}, p_.p[32], reading_.dt_);
                }
            }
        }
    }
    bool t4 = aekf_differentiate(layout_, belief_, reading_, p_, scratch_, record_);
    if ((!t4)) {
        return false;
    }
    int64_t t5 = (int64_t)(p_.p[45]);
    for (int64_t k6 = 0; k6 < t5; k6 += 1) {
        i_ = k6;
        real t8 = memory_.p[((8 + i_))];
        real t7 = aekf_gradient(vectors_, i_);
        memory_.p[((8 + i_))] = (t8 + t7);
        int64_t t9 = (i_ + 1);
        for (int64_t k10 = 0; k10 < t9; k10 += 1) {
            j_ = k10;
            real t12 = memory_.p[(((20 + ((i_ * (i_ + 1)) / 2)) + j_))];
            real t11 = aekf_information(vectors_, i_, j_);
            memory_.p[(((20 + ((i_ * (i_ + 1)) / 2)) + j_))] = (t12 + t11);
        }
    }
    return true;
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_18 sample_loop_run_slopes(Layout layout_, LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
{
    array1_i8 stamps_;
    array2_f8 inputs_;
    array2_f8 outputs_;
    int64_t max_gap_;
    int64_t delay_;
    int64_t lag_;
    bool load_measured_;
    bool narrow_;
    DescribedLoad described_;
    array1_i8 gate_;
    array1_i8 counts_;
    array1_f8 clock_;
    array2_f8 efforts_;
    array2_f8 ring_;
    array1_i8 ring_stamps_;
    array1_f8 saved_;
    Companions companions_;
    array1_i8 codes_;
    array2_f8 estimates_;
    array1_i8 smoothed_stamps_;
    array2_f8 smoothed_;
    array1_f8 memory_;
    int64_t rows_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t n_smoothed_;
    int64_t k_;
    int64_t stamp_;
    real u_;
    real load_;
    real y1_;
    real y2_;
    bool have_y_;
    int64_t code_;
    bool have_u_;
    int64_t i_;
    int64_t last_;
    real dt_;
    int64_t step_;
    int64_t place_;
    int64_t previous_;
    int64_t acting_;
    real u_acting_;
    Reading reading_;
    array1_f8 record_;
    bool good_;
    real e1_;
    real e2_;
    int64_t bridged_;
    bool in_doubt_;
    real share_;
    bool half_;
    int64_t oldest_;
    int64_t keep_;
    array1_f8 row_;
    stamps_ = stream_.stamps_;
    inputs_ = stream_.inputs_;
    outputs_ = stream_.outputs_;
    max_gap_ = settings_.max_gap_;
    delay_ = settings_.delay_;
    lag_ = settings_.lag_;
    load_measured_ = settings_.load_measured_;
    narrow_ = settings_.narrow_;
    described_ = settings_.described_;
    gate_ = state_.gate_;
    counts_ = state_.counts_;
    clock_ = state_.clock_;
    efforts_ = state_.efforts_;
    ring_ = state_.ring_;
    ring_stamps_ = state_.ring_stamps_;
    saved_ = state_.saved_;
    companions_ = state_.companions_;
    codes_ = output_.codes_;
    estimates_ = output_.estimates_;
    smoothed_stamps_ = output_.smoothed_stamps_;
    smoothed_ = output_.smoothed_;
    memory_ = belief_.memory_;
    rows_ = ring_.n[0];
    tuple_2 t1 = step_record_places(layout_.n_);
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    n_smoothed_ = 0;
    for (int64_t k2 = 0; k2 < stamps_.n[0]; k2 += 1) {
        k_ = k2;
        stamp_ = stamps_.p[(k_)];
        gate_.p[10] = (gate_.p[10] + 1);
        real t3 = inputs_.p[((k_) * inputs_.n[1] + 0)];
        real t4 = inputs_.p[((k_) * inputs_.n[1] + 1)];
        real t5 = outputs_.p[((k_) * outputs_.n[1] + 0)];
        real t6 = outputs_.p[((k_) * outputs_.n[1] + 1)];
        u_ = t3;
        load_ = t4;
        y1_ = t5;
        y2_ = t6;
        if ((((((gm_fabs(u_) > (real)1000000000.0)) || ((gm_fabs(load_) > (real)1000000000.0))) || ((gm_fabs(y1_) > (real)1000000000.0))) || ((gm_fabs(y2_) > (real)1000000000.0)))) {
            counts_.p[10] = (counts_.p[10] + 1);
            real t7 = (((gm_fabs(u_) <= (real)1000000000.0)) ? u_ : NAN);
            real t8 = (((gm_fabs(load_) <= (real)1000000000.0)) ? load_ : NAN);
            u_ = t7;
            load_ = t8;
            real t9 = (((gm_fabs(y1_) <= (real)1000000000.0)) ? y1_ : NAN);
            real t10 = (((gm_fabs(y2_) <= (real)1000000000.0)) ? y2_ : NAN);
            y1_ = t9;
            y2_ = t10;
        }
        have_y_ = ((bool)isfinite(y1_) || (bool)isfinite(y2_));
        int64_t t11 = sample_loop_gate(stamp_, gate_, max_gap_);
        code_ = t11;
        if ((((code_ == 0)) || ((code_ == 1)))) {
            if (((code_ == 1))) {
                gate_.p[4] = stamp_;
                gate_.p[3] = stamp_;
            }
            if ((!(bool)isfinite(y1_))) {
                counts_.p[11] = (counts_.p[11] + 1);
            }
            if ((!(bool)isfinite(y2_))) {
                counts_.p[12] = (counts_.p[12] + 1);
            }
            have_u_ = ((bool)isfinite(u_) && ((!load_measured_) || (bool)isfinite(load_)));
            if ((!have_u_)) {
                counts_.p[13] = (counts_.p[13] + 1);
                if ((((code_ == 1)) || (((stamp_ - gate_.p[3]) > max_gap_)))) {
                    code_ = 6;
                }
            } else {
                if (((!have_y_) && (((code_ == 1)) || (((stamp_ - gate_.p[4]) > max_gap_))))) {
                    code_ = 7;
                }
            }
            if ((((code_ == 6)) || ((code_ == 7)))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
        }
        counts_.p[(code_)] = (counts_.p[(code_)] + 1);
        codes_.p[(k_)] = code_;
        if ((((code_ != 0)) && ((code_ != 1)))) {
            bool t13 = (((code_ == 6)) || ((code_ == 7)));
            if (t13) {
            bool t12 = sample_loop_stops(stamp_, gate_);
            t13 = t12;
            }
            if (t13) {
                return (tuple_18){{(k_ + 1), n_smoothed_}};
            }
            continue;
        }
        if (have_u_) {
            gate_.p[3] = stamp_;
        }
        if (have_y_) {
            gate_.p[4] = stamp_;
        }
        if (((code_ == 1))) {
            gate_.p[0] = stamp_;
            gate_.p[5] = 0;
            gate_.p[2] = 0;
            gate_.p[9] = 0;
            gate_.p[7] = 0;
            array1_f8 t14 = (array1_f8){clock_.p, {clock_.n[0]}};
            for (int64_t k15 = 0; k15 < t14.n[0]; k15++)
                t14.p[k15 * (1)] = (real)0.0;
            for (int64_t k16 = 0; k16 < 64; k16 += 1) {
                i_ = k16;
                real t17 = u_;
                real t18 = (load_measured_ ? load_ : (real)0.0);
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 0)] = t17;
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 1)] = t18;
            }
            gate_.p[6] = stamp_;
            sample_loop_start(layout_, belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            aekf_resume(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        last_ = gate_.p[0];
        dt_ = ((real)((stamp_ - last_)) * (real)1e-09);
        step_ = (gate_.p[5] + 1);
        int64_t t19 = gm_mod(step_, 64);
        int64_t t20 = gm_mod((step_ - 1), 64);
        place_ = t19;
        previous_ = t20;
        efforts_.p[((place_) * efforts_.n[1] + 0)] = ((bool)isfinite(u_) ? u_ : efforts_.p[((previous_) * efforts_.n[1] + 0)]);
        efforts_.p[((place_) * efforts_.n[1] + 1)] = ((bool)isfinite(load_) ? load_ : efforts_.p[((previous_) * efforts_.n[1] + 1)]);
        acting_ = gm_mod(((step_ - 1) - delay_), 64);
        u_acting_ = efforts_.p[((acting_) * efforts_.n[1] + 0)];
        sample_loop_save(belief_, saved_);
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_19){place_, dt_}, state_, layout_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(layout_, belief_, reading_, p_);
        }
        bool t22 = slopes_step(layout_, belief_, reading_, p_, scratch_, record_);
        good_ = t22;
        real t23 = record_.p[(at_innovation_)];
        real t24 = record_.p[((at_innovation_ + 1))];
        e1_ = t23;
        e2_ = t24;
        bool t25 = sample_loop_jumps(e1_, record_.p[(at_S_)], clock_.p[1], p_.p[31], step_);
        bool t27 = t25;
        if (!t27) {
        bool t26 = sample_loop_jumps(e2_, record_.p[((at_S_ + 2))], clock_.p[2], p_.p[32], step_);
        t27 = t26;
        }
        if (t27) {
            sample_loop_put_back(belief_, saved_);
            codes_.p[(k_)] = 9;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[9] = (counts_.p[9] + 1);
            gate_.p[7] = (gate_.p[7] + 1);
            if (((gate_.p[7] >= 3))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
            continue;
        }
        gate_.p[0] = stamp_;
        gate_.p[5] = step_;
        gate_.p[7] = 0;
        if (((clock_.p[0] == (real)0.0))) {
            clock_.p[0] = dt_;
        } else {
            if (((dt_ > ((real)1.7 * clock_.p[0])))) {
                counts_.p[14] = (counts_.p[14] + ((int64_t)(((dt_ / clock_.p[0]) + (real)0.5)) - 1));
            }
            clock_.p[0] = (clock_.p[0] * (((dt_ > clock_.p[0])) ? (real)1.02 : (real)0.9803921568627451));
        }
        bridged_ = (stamp_ - gm_min_i(gm_min_i(last_, gate_.p[3]), gate_.p[4]));
        in_doubt_ = (((bridged_ > 30000000)) && (((real)(bridged_) > ((real)2500000000.0 * clock_.p[0]))));
        if (in_doubt_) {
            gate_.p[6] = stamp_;
        }
        ring_stamps_.p[(gm_mod(step_, rows_))] = stamp_;
        bool t30 = good_;
        if (t30) {
        tuple_14 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany(layout_, companions_, saved_, reading_, t28, record_);
        t30 = t29;
        }
        good_ = t30;
        if ((!good_)) {
            codes_.p[(k_)] = 8;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[8] = (counts_.p[8] + 1);
            gate_.p[0] = 0;
            array1_f8 t31 = (array1_f8){memory_.p, {memory_.n[0]}};
            for (int64_t k32 = 0; k32 < t31.n[0]; k32++)
                t31.p[k32 * (1)] = (real)0.0;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if (((narrow_ && ((layout_.curve_ < 0))) && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(layout_.n_, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(layout_, belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
        half_ = ((gm_mod(step_, (rows_ / 2)) == 0));
        if ((((lag_ > 0)) && (half_ || ((gm_div((stamp_ * 2), lag_) != gm_div((last_ * 2), lag_)))))) {
            oldest_ = gate_.p[9];
            keep_ = (half_ ? gm_max_i((oldest_ - 1), (step_ - (rows_ / 2))) : (oldest_ - 1));
            for (;;) {
                if (!(((keep_ < step_)) && ((ring_stamps_.p[(gm_mod((keep_ + 1), rows_))] <= (stamp_ - lag_))))) break;
                keep_ = (keep_ + 1);
            }
            if (((keep_ >= oldest_))) {
                int64_t t39 = keep_;
                int64_t t36 = n_smoothed_;
                int64_t t37 = gm_bound(t36, smoothed_.n[0]);
                int64_t t38 = gm_span(t37, smoothed_.n[0]);
                rts_smoother_smooth(layout_, ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
                int64_t t40 = (keep_ + 1);
                for (int64_t k41 = oldest_; k41 < t40; k41 += 1) {
                    i_ = k41;
                    smoothed_stamps_.p[(n_smoothed_)] = ring_stamps_.p[(gm_mod(i_, rows_))];
                    if (((share_ < (real)1.0))) {
                        row_ = (array1_f8){smoothed_.p + (n_smoothed_) * (smoothed_.n[1]), {smoothed_.n[1]}};
                        row_.p[5] = gm_sqrt(gm_max_f(((row_.p[5] * row_.p[5]) - (((real)1.0 - gm_sqrt(share_)) * (row_.p[12] * row_.p[12]))), (real)0.0));
                    }
                    n_smoothed_ = (n_smoothed_ + 1);
                }
                gate_.p[9] = (keep_ + 1);
            }
        }
        bool t43 = in_doubt_;
        if (!t43) {
        bool t42 = sample_loop_stops(stamp_, gate_);
        t43 = t42;
        }
        if (t43) {
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_18){{stamps_.n[0], n_smoothed_}};
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_18 sample_loop_run_srukf(Layout layout_, LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
{
    array1_i8 stamps_;
    array2_f8 inputs_;
    array2_f8 outputs_;
    int64_t max_gap_;
    int64_t delay_;
    int64_t lag_;
    bool load_measured_;
    bool narrow_;
    DescribedLoad described_;
    array1_i8 gate_;
    array1_i8 counts_;
    array1_f8 clock_;
    array2_f8 efforts_;
    array2_f8 ring_;
    array1_i8 ring_stamps_;
    array1_f8 saved_;
    Companions companions_;
    array1_i8 codes_;
    array2_f8 estimates_;
    array1_i8 smoothed_stamps_;
    array2_f8 smoothed_;
    array1_f8 memory_;
    int64_t rows_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t n_smoothed_;
    int64_t k_;
    int64_t stamp_;
    real u_;
    real load_;
    real y1_;
    real y2_;
    bool have_y_;
    int64_t code_;
    bool have_u_;
    int64_t i_;
    int64_t last_;
    real dt_;
    int64_t step_;
    int64_t place_;
    int64_t previous_;
    int64_t acting_;
    real u_acting_;
    Reading reading_;
    array1_f8 record_;
    bool good_;
    real e1_;
    real e2_;
    int64_t bridged_;
    bool in_doubt_;
    real share_;
    bool half_;
    int64_t oldest_;
    int64_t keep_;
    array1_f8 row_;
    stamps_ = stream_.stamps_;
    inputs_ = stream_.inputs_;
    outputs_ = stream_.outputs_;
    max_gap_ = settings_.max_gap_;
    delay_ = settings_.delay_;
    lag_ = settings_.lag_;
    load_measured_ = settings_.load_measured_;
    narrow_ = settings_.narrow_;
    described_ = settings_.described_;
    gate_ = state_.gate_;
    counts_ = state_.counts_;
    clock_ = state_.clock_;
    efforts_ = state_.efforts_;
    ring_ = state_.ring_;
    ring_stamps_ = state_.ring_stamps_;
    saved_ = state_.saved_;
    companions_ = state_.companions_;
    codes_ = output_.codes_;
    estimates_ = output_.estimates_;
    smoothed_stamps_ = output_.smoothed_stamps_;
    smoothed_ = output_.smoothed_;
    memory_ = belief_.memory_;
    rows_ = ring_.n[0];
    tuple_2 t1 = step_record_places(layout_.n_);
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    n_smoothed_ = 0;
    for (int64_t k2 = 0; k2 < stamps_.n[0]; k2 += 1) {
        k_ = k2;
        stamp_ = stamps_.p[(k_)];
        gate_.p[10] = (gate_.p[10] + 1);
        real t3 = inputs_.p[((k_) * inputs_.n[1] + 0)];
        real t4 = inputs_.p[((k_) * inputs_.n[1] + 1)];
        real t5 = outputs_.p[((k_) * outputs_.n[1] + 0)];
        real t6 = outputs_.p[((k_) * outputs_.n[1] + 1)];
        u_ = t3;
        load_ = t4;
        y1_ = t5;
        y2_ = t6;
        if ((((((gm_fabs(u_) > (real)1000000000.0)) || ((gm_fabs(load_) > (real)1000000000.0))) || ((gm_fabs(y1_) > (real)1000000000.0))) || ((gm_fabs(y2_) > (real)1000000000.0)))) {
            counts_.p[10] = (counts_.p[10] + 1);
            real t7 = (((gm_fabs(u_) <= (real)1000000000.0)) ? u_ : NAN);
            real t8 = (((gm_fabs(load_) <= (real)1000000000.0)) ? load_ : NAN);
            u_ = t7;
            load_ = t8;
            real t9 = (((gm_fabs(y1_) <= (real)1000000000.0)) ? y1_ : NAN);
            real t10 = (((gm_fabs(y2_) <= (real)1000000000.0)) ? y2_ : NAN);
            y1_ = t9;
            y2_ = t10;
        }
        have_y_ = ((bool)isfinite(y1_) || (bool)isfinite(y2_));
        int64_t t11 = sample_loop_gate(stamp_, gate_, max_gap_);
        code_ = t11;
        if ((((code_ == 0)) || ((code_ == 1)))) {
            if (((code_ == 1))) {
                gate_.p[4] = stamp_;
                gate_.p[3] = stamp_;
            }
            if ((!(bool)isfinite(y1_))) {
                counts_.p[11] = (counts_.p[11] + 1);
            }
            if ((!(bool)isfinite(y2_))) {
                counts_.p[12] = (counts_.p[12] + 1);
            }
            have_u_ = ((bool)isfinite(u_) && ((!load_measured_) || (bool)isfinite(load_)));
            if ((!have_u_)) {
                counts_.p[13] = (counts_.p[13] + 1);
                if ((((code_ == 1)) || (((stamp_ - gate_.p[3]) > max_gap_)))) {
                    code_ = 6;
                }
            } else {
                if (((!have_y_) && (((code_ == 1)) || (((stamp_ - gate_.p[4]) > max_gap_))))) {
                    code_ = 7;
                }
            }
            if ((((code_ == 6)) || ((code_ == 7)))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
        }
        counts_.p[(code_)] = (counts_.p[(code_)] + 1);
        codes_.p[(k_)] = code_;
        if ((((code_ != 0)) && ((code_ != 1)))) {
            bool t13 = (((code_ == 6)) || ((code_ == 7)));
            if (t13) {
            bool t12 = sample_loop_stops(stamp_, gate_);
            t13 = t12;
            }
            if (t13) {
                return (tuple_18){{(k_ + 1), n_smoothed_}};
            }
            continue;
        }
        if (have_u_) {
            gate_.p[3] = stamp_;
        }
        if (have_y_) {
            gate_.p[4] = stamp_;
        }
        if (((code_ == 1))) {
            gate_.p[0] = stamp_;
            gate_.p[5] = 0;
            gate_.p[2] = 0;
            gate_.p[9] = 0;
            gate_.p[7] = 0;
            array1_f8 t14 = (array1_f8){clock_.p, {clock_.n[0]}};
            for (int64_t k15 = 0; k15 < t14.n[0]; k15++)
                t14.p[k15 * (1)] = (real)0.0;
            for (int64_t k16 = 0; k16 < 64; k16 += 1) {
                i_ = k16;
                real t17 = u_;
                real t18 = (load_measured_ ? load_ : (real)0.0);
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 0)] = t17;
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 1)] = t18;
            }
            gate_.p[6] = stamp_;
            sample_loop_start(layout_, belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        last_ = gate_.p[0];
        dt_ = ((real)((stamp_ - last_)) * (real)1e-09);
        step_ = (gate_.p[5] + 1);
        int64_t t19 = gm_mod(step_, 64);
        int64_t t20 = gm_mod((step_ - 1), 64);
        place_ = t19;
        previous_ = t20;
        efforts_.p[((place_) * efforts_.n[1] + 0)] = ((bool)isfinite(u_) ? u_ : efforts_.p[((previous_) * efforts_.n[1] + 0)]);
        efforts_.p[((place_) * efforts_.n[1] + 1)] = ((bool)isfinite(load_) ? load_ : efforts_.p[((previous_) * efforts_.n[1] + 1)]);
        acting_ = gm_mod(((step_ - 1) - delay_), 64);
        u_acting_ = efforts_.p[((acting_) * efforts_.n[1] + 0)];
        sample_loop_save(belief_, saved_);
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_19){place_, dt_}, state_, layout_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(layout_, belief_, reading_, p_);
        }
        bool t22 = srukf_step(layout_, belief_, reading_, p_, scratch_, record_);
        good_ = t22;
        real t23 = record_.p[(at_innovation_)];
        real t24 = record_.p[((at_innovation_ + 1))];
        e1_ = t23;
        e2_ = t24;
        bool t25 = sample_loop_jumps(e1_, record_.p[(at_S_)], clock_.p[1], p_.p[31], step_);
        bool t27 = t25;
        if (!t27) {
        bool t26 = sample_loop_jumps(e2_, record_.p[((at_S_ + 2))], clock_.p[2], p_.p[32], step_);
        t27 = t26;
        }
        if (t27) {
            sample_loop_put_back(belief_, saved_);
            codes_.p[(k_)] = 9;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[9] = (counts_.p[9] + 1);
            gate_.p[7] = (gate_.p[7] + 1);
            if (((gate_.p[7] >= 3))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
            continue;
        }
        gate_.p[0] = stamp_;
        gate_.p[5] = step_;
        gate_.p[7] = 0;
        if (((clock_.p[0] == (real)0.0))) {
            clock_.p[0] = dt_;
        } else {
            if (((dt_ > ((real)1.7 * clock_.p[0])))) {
                counts_.p[14] = (counts_.p[14] + ((int64_t)(((dt_ / clock_.p[0]) + (real)0.5)) - 1));
            }
            clock_.p[0] = (clock_.p[0] * (((dt_ > clock_.p[0])) ? (real)1.02 : (real)0.9803921568627451));
        }
        bridged_ = (stamp_ - gm_min_i(gm_min_i(last_, gate_.p[3]), gate_.p[4]));
        in_doubt_ = (((bridged_ > 30000000)) && (((real)(bridged_) > ((real)2500000000.0 * clock_.p[0]))));
        if (in_doubt_) {
            gate_.p[6] = stamp_;
        }
        ring_stamps_.p[(gm_mod(step_, rows_))] = stamp_;
        bool t30 = good_;
        if (t30) {
        tuple_14 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany(layout_, companions_, saved_, reading_, t28, record_);
        t30 = t29;
        }
        good_ = t30;
        if ((!good_)) {
            codes_.p[(k_)] = 8;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[8] = (counts_.p[8] + 1);
            gate_.p[0] = 0;
            array1_f8 t31 = (array1_f8){memory_.p, {memory_.n[0]}};
            for (int64_t k32 = 0; k32 < t31.n[0]; k32++)
                t31.p[k32 * (1)] = (real)0.0;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if (((narrow_ && ((layout_.curve_ < 0))) && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(layout_.n_, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(layout_, belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
        half_ = ((gm_mod(step_, (rows_ / 2)) == 0));
        if ((((lag_ > 0)) && (half_ || ((gm_div((stamp_ * 2), lag_) != gm_div((last_ * 2), lag_)))))) {
            oldest_ = gate_.p[9];
            keep_ = (half_ ? gm_max_i((oldest_ - 1), (step_ - (rows_ / 2))) : (oldest_ - 1));
            for (;;) {
                if (!(((keep_ < step_)) && ((ring_stamps_.p[(gm_mod((keep_ + 1), rows_))] <= (stamp_ - lag_))))) break;
                keep_ = (keep_ + 1);
            }
            if (((keep_ >= oldest_))) {
                int64_t t39 = keep_;
                int64_t t36 = n_smoothed_;
                int64_t t37 = gm_bound(t36, smoothed_.n[0]);
                int64_t t38 = gm_span(t37, smoothed_.n[0]);
                rts_smoother_smooth(layout_, ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
                int64_t t40 = (keep_ + 1);
                for (int64_t k41 = oldest_; k41 < t40; k41 += 1) {
                    i_ = k41;
                    smoothed_stamps_.p[(n_smoothed_)] = ring_stamps_.p[(gm_mod(i_, rows_))];
                    if (((share_ < (real)1.0))) {
                        row_ = (array1_f8){smoothed_.p + (n_smoothed_) * (smoothed_.n[1]), {smoothed_.n[1]}};
                        row_.p[5] = gm_sqrt(gm_max_f(((row_.p[5] * row_.p[5]) - (((real)1.0 - gm_sqrt(share_)) * (row_.p[12] * row_.p[12]))), (real)0.0));
                    }
                    n_smoothed_ = (n_smoothed_ + 1);
                }
                gate_.p[9] = (keep_ + 1);
            }
        }
        bool t43 = in_doubt_;
        if (!t43) {
        bool t42 = sample_loop_stops(stamp_, gate_);
        t43 = t42;
        }
        if (t43) {
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_18){{stamps_.n[0], n_smoothed_}};
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_18 sample_loop_run_ukf(Layout layout_, LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
{
    array1_i8 stamps_;
    array2_f8 inputs_;
    array2_f8 outputs_;
    int64_t max_gap_;
    int64_t delay_;
    int64_t lag_;
    bool load_measured_;
    bool narrow_;
    DescribedLoad described_;
    array1_i8 gate_;
    array1_i8 counts_;
    array1_f8 clock_;
    array2_f8 efforts_;
    array2_f8 ring_;
    array1_i8 ring_stamps_;
    array1_f8 saved_;
    Companions companions_;
    array1_i8 codes_;
    array2_f8 estimates_;
    array1_i8 smoothed_stamps_;
    array2_f8 smoothed_;
    array1_f8 memory_;
    int64_t rows_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t n_smoothed_;
    int64_t k_;
    int64_t stamp_;
    real u_;
    real load_;
    real y1_;
    real y2_;
    bool have_y_;
    int64_t code_;
    bool have_u_;
    int64_t i_;
    int64_t last_;
    real dt_;
    int64_t step_;
    int64_t place_;
    int64_t previous_;
    int64_t acting_;
    real u_acting_;
    Reading reading_;
    array1_f8 record_;
    bool good_;
    real e1_;
    real e2_;
    int64_t bridged_;
    bool in_doubt_;
    real share_;
    bool half_;
    int64_t oldest_;
    int64_t keep_;
    array1_f8 row_;
    stamps_ = stream_.stamps_;
    inputs_ = stream_.inputs_;
    outputs_ = stream_.outputs_;
    max_gap_ = settings_.max_gap_;
    delay_ = settings_.delay_;
    lag_ = settings_.lag_;
    load_measured_ = settings_.load_measured_;
    narrow_ = settings_.narrow_;
    described_ = settings_.described_;
    gate_ = state_.gate_;
    counts_ = state_.counts_;
    clock_ = state_.clock_;
    efforts_ = state_.efforts_;
    ring_ = state_.ring_;
    ring_stamps_ = state_.ring_stamps_;
    saved_ = state_.saved_;
    companions_ = state_.companions_;
    codes_ = output_.codes_;
    estimates_ = output_.estimates_;
    smoothed_stamps_ = output_.smoothed_stamps_;
    smoothed_ = output_.smoothed_;
    memory_ = belief_.memory_;
    rows_ = ring_.n[0];
    tuple_2 t1 = step_record_places(layout_.n_);
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    n_smoothed_ = 0;
    for (int64_t k2 = 0; k2 < stamps_.n[0]; k2 += 1) {
        k_ = k2;
        stamp_ = stamps_.p[(k_)];
        gate_.p[10] = (gate_.p[10] + 1);
        real t3 = inputs_.p[((k_) * inputs_.n[1] + 0)];
        real t4 = inputs_.p[((k_) * inputs_.n[1] + 1)];
        real t5 = outputs_.p[((k_) * outputs_.n[1] + 0)];
        real t6 = outputs_.p[((k_) * outputs_.n[1] + 1)];
        u_ = t3;
        load_ = t4;
        y1_ = t5;
        y2_ = t6;
        if ((((((gm_fabs(u_) > (real)1000000000.0)) || ((gm_fabs(load_) > (real)1000000000.0))) || ((gm_fabs(y1_) > (real)1000000000.0))) || ((gm_fabs(y2_) > (real)1000000000.0)))) {
            counts_.p[10] = (counts_.p[10] + 1);
            real t7 = (((gm_fabs(u_) <= (real)1000000000.0)) ? u_ : NAN);
            real t8 = (((gm_fabs(load_) <= (real)1000000000.0)) ? load_ : NAN);
            u_ = t7;
            load_ = t8;
            real t9 = (((gm_fabs(y1_) <= (real)1000000000.0)) ? y1_ : NAN);
            real t10 = (((gm_fabs(y2_) <= (real)1000000000.0)) ? y2_ : NAN);
            y1_ = t9;
            y2_ = t10;
        }
        have_y_ = ((bool)isfinite(y1_) || (bool)isfinite(y2_));
        int64_t t11 = sample_loop_gate(stamp_, gate_, max_gap_);
        code_ = t11;
        if ((((code_ == 0)) || ((code_ == 1)))) {
            if (((code_ == 1))) {
                gate_.p[4] = stamp_;
                gate_.p[3] = stamp_;
            }
            if ((!(bool)isfinite(y1_))) {
                counts_.p[11] = (counts_.p[11] + 1);
            }
            if ((!(bool)isfinite(y2_))) {
                counts_.p[12] = (counts_.p[12] + 1);
            }
            have_u_ = ((bool)isfinite(u_) && ((!load_measured_) || (bool)isfinite(load_)));
            if ((!have_u_)) {
                counts_.p[13] = (counts_.p[13] + 1);
                if ((((code_ == 1)) || (((stamp_ - gate_.p[3]) > max_gap_)))) {
                    code_ = 6;
                }
            } else {
                if (((!have_y_) && (((code_ == 1)) || (((stamp_ - gate_.p[4]) > max_gap_))))) {
                    code_ = 7;
                }
            }
            if ((((code_ == 6)) || ((code_ == 7)))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
        }
        counts_.p[(code_)] = (counts_.p[(code_)] + 1);
        codes_.p[(k_)] = code_;
        if ((((code_ != 0)) && ((code_ != 1)))) {
            bool t13 = (((code_ == 6)) || ((code_ == 7)));
            if (t13) {
            bool t12 = sample_loop_stops(stamp_, gate_);
            t13 = t12;
            }
            if (t13) {
                return (tuple_18){{(k_ + 1), n_smoothed_}};
            }
            continue;
        }
        if (have_u_) {
            gate_.p[3] = stamp_;
        }
        if (have_y_) {
            gate_.p[4] = stamp_;
        }
        if (((code_ == 1))) {
            gate_.p[0] = stamp_;
            gate_.p[5] = 0;
            gate_.p[2] = 0;
            gate_.p[9] = 0;
            gate_.p[7] = 0;
            array1_f8 t14 = (array1_f8){clock_.p, {clock_.n[0]}};
            for (int64_t k15 = 0; k15 < t14.n[0]; k15++)
                t14.p[k15 * (1)] = (real)0.0;
            for (int64_t k16 = 0; k16 < 64; k16 += 1) {
                i_ = k16;
                real t17 = u_;
                real t18 = (load_measured_ ? load_ : (real)0.0);
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 0)] = t17;
                efforts_.p[(gm_at(i_, efforts_.n[0]) * efforts_.n[1] + 1)] = t18;
            }
            gate_.p[6] = stamp_;
            sample_loop_start(layout_, belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        last_ = gate_.p[0];
        dt_ = ((real)((stamp_ - last_)) * (real)1e-09);
        step_ = (gate_.p[5] + 1);
        int64_t t19 = gm_mod(step_, 64);
        int64_t t20 = gm_mod((step_ - 1), 64);
        place_ = t19;
        previous_ = t20;
        efforts_.p[((place_) * efforts_.n[1] + 0)] = ((bool)isfinite(u_) ? u_ : efforts_.p[((previous_) * efforts_.n[1] + 0)]);
        efforts_.p[((place_) * efforts_.n[1] + 1)] = ((bool)isfinite(load_) ? load_ : efforts_.p[((previous_) * efforts_.n[1] + 1)]);
        acting_ = gm_mod(((step_ - 1) - delay_), 64);
        u_acting_ = efforts_.p[((acting_) * efforts_.n[1] + 0)];
        sample_loop_save(belief_, saved_);
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_19){place_, dt_}, state_, layout_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(layout_, belief_, reading_, p_);
        }
        bool t22 = ukf_step(layout_, belief_, reading_, p_, scratch_, record_);
        good_ = t22;
        real t23 = record_.p[(at_innovation_)];
        real t24 = record_.p[((at_innovation_ + 1))];
        e1_ = t23;
        e2_ = t24;
        bool t25 = sample_loop_jumps(e1_, record_.p[(at_S_)], clock_.p[1], p_.p[31], step_);
        bool t27 = t25;
        if (!t27) {
        bool t26 = sample_loop_jumps(e2_, record_.p[((at_S_ + 2))], clock_.p[2], p_.p[32], step_);
        t27 = t26;
        }
        if (t27) {
            sample_loop_put_back(belief_, saved_);
            codes_.p[(k_)] = 9;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[9] = (counts_.p[9] + 1);
            gate_.p[7] = (gate_.p[7] + 1);
            if (((gate_.p[7] >= 3))) {
                gate_.p[0] = 0;
                gate_.p[2] = 0;
            }
            continue;
        }
        gate_.p[0] = stamp_;
        gate_.p[5] = step_;
        gate_.p[7] = 0;
        if (((clock_.p[0] == (real)0.0))) {
            clock_.p[0] = dt_;
        } else {
            if (((dt_ > ((real)1.7 * clock_.p[0])))) {
                counts_.p[14] = (counts_.p[14] + ((int64_t)(((dt_ / clock_.p[0]) + (real)0.5)) - 1));
            }
            clock_.p[0] = (clock_.p[0] * (((dt_ > clock_.p[0])) ? (real)1.02 : (real)0.9803921568627451));
        }
        bridged_ = (stamp_ - gm_min_i(gm_min_i(last_, gate_.p[3]), gate_.p[4]));
        in_doubt_ = (((bridged_ > 30000000)) && (((real)(bridged_) > ((real)2500000000.0 * clock_.p[0]))));
        if (in_doubt_) {
            gate_.p[6] = stamp_;
        }
        ring_stamps_.p[(gm_mod(step_, rows_))] = stamp_;
        bool t30 = good_;
        if (t30) {
        tuple_14 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany(layout_, companions_, saved_, reading_, t28, record_);
        t30 = t29;
        }
        good_ = t30;
        if ((!good_)) {
            codes_.p[(k_)] = 8;
            counts_.p[0] = (counts_.p[0] - 1);
            counts_.p[8] = (counts_.p[8] + 1);
            gate_.p[0] = 0;
            array1_f8 t31 = (array1_f8){memory_.p, {memory_.n[0]}};
            for (int64_t k32 = 0; k32 < t31.n[0]; k32++)
                t31.p[k32 * (1)] = (real)0.0;
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if (((narrow_ && ((layout_.curve_ < 0))) && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(layout_.n_, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(layout_, belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
        half_ = ((gm_mod(step_, (rows_ / 2)) == 0));
        if ((((lag_ > 0)) && (half_ || ((gm_div((stamp_ * 2), lag_) != gm_div((last_ * 2), lag_)))))) {
            oldest_ = gate_.p[9];
            keep_ = (half_ ? gm_max_i((oldest_ - 1), (step_ - (rows_ / 2))) : (oldest_ - 1));
            for (;;) {
                if (!(((keep_ < step_)) && ((ring_stamps_.p[(gm_mod((keep_ + 1), rows_))] <= (stamp_ - lag_))))) break;
                keep_ = (keep_ + 1);
            }
            if (((keep_ >= oldest_))) {
                int64_t t39 = keep_;
                int64_t t36 = n_smoothed_;
                int64_t t37 = gm_bound(t36, smoothed_.n[0]);
                int64_t t38 = gm_span(t37, smoothed_.n[0]);
                rts_smoother_smooth(layout_, ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
                int64_t t40 = (keep_ + 1);
                for (int64_t k41 = oldest_; k41 < t40; k41 += 1) {
                    i_ = k41;
                    smoothed_stamps_.p[(n_smoothed_)] = ring_stamps_.p[(gm_mod(i_, rows_))];
                    if (((share_ < (real)1.0))) {
                        row_ = (array1_f8){smoothed_.p + (n_smoothed_) * (smoothed_.n[1]), {smoothed_.n[1]}};
                        row_.p[5] = gm_sqrt(gm_max_f(((row_.p[5] * row_.p[5]) - (((real)1.0 - gm_sqrt(share_)) * (row_.p[12] * row_.p[12]))), (real)0.0));
                    }
                    n_smoothed_ = (n_smoothed_ + 1);
                }
                gate_.p[9] = (keep_ + 1);
            }
        }
        bool t43 = in_doubt_;
        if (!t43) {
        bool t42 = sample_loop_stops(stamp_, gate_);
        t43 = t42;
        }
        if (t43) {
            return (tuple_18){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_18){{stamps_.n[0], n_smoothed_}};
}

void gm_estimation_filter__call_aekf(gm_slot *a)
{
    bool r = filter_call_aekf((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (array1_f8){(real *)a[12].p, {a[13].i}}, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d, (real)a[18].d);
    a[0].i = r;
}
void gm_estimation_filter__call_ekf(gm_slot *a)
{
    bool r = filter_call_ekf((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (array1_f8){(real *)a[12].p, {a[13].i}}, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d, (real)a[18].d);
    a[0].i = r;
}
void gm_estimation_filter__call_srukf(gm_slot *a)
{
    bool r = filter_call_srukf((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (array1_f8){(real *)a[12].p, {a[13].i}}, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d, (real)a[18].d);
    a[0].i = r;
}
void gm_estimation_filter__call_ukf(gm_slot *a)
{
    bool r = filter_call_ukf((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (array1_f8){(real *)a[12].p, {a[13].i}}, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d, (real)a[18].d);
    a[0].i = r;
}
void gm_estimation_sample_loop_run_aekf(gm_slot *a)
{
    tuple_18 r = sample_loop_run_aekf((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (LoopSettings){a[12].i, a[13].i, a[14].i, (a[15].i != 0), (a[16].i != 0), (DescribedLoad){(real)a[17].d, (real)a[18].d, (real)a[19].d, (real)a[20].d, (real)a[21].d}}, (array1_f8){(real *)a[22].p, {a[23].i}}, (Stream){(array1_i8){(int64_t *)a[24].p, {a[25].i}}, (array2_f8){(real *)a[26].p, {a[27].i, a[28].i}}, (array2_f8){(real *)a[29].p, {a[30].i, a[31].i}}}, (LoopState){(array1_i8){(int64_t *)a[32].p, {a[33].i}}, (array1_i8){(int64_t *)a[34].p, {a[35].i}}, (array1_f8){(real *)a[36].p, {a[37].i}}, (array2_f8){(real *)a[38].p, {a[39].i, a[40].i}}, (array2_f8){(real *)a[41].p, {a[42].i, a[43].i}}, (array1_i8){(int64_t *)a[44].p, {a[45].i}}, (array1_f8){(real *)a[46].p, {a[47].i}}, (Companions){a[48].i, (array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}}}, (Belief){(array1_f8){(real *)a[53].p, {a[54].i}}, (array1_f8){(real *)a[55].p, {a[56].i}}, (array1_f8){(real *)a[57].p, {a[58].i}}}, (Scratch){(array2_f8){(real *)a[59].p, {a[60].i, a[61].i}}, (array2_f8){(real *)a[62].p, {a[63].i, a[64].i}}}, (Output){(array1_i8){(int64_t *)a[65].p, {a[66].i}}, (array2_f8){(real *)a[67].p, {a[68].i, a[69].i}}, (array1_i8){(int64_t *)a[70].p, {a[71].i}}, (array2_f8){(real *)a[72].p, {a[73].i, a[74].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_ekf(gm_slot *a)
{
    tuple_18 r = sample_loop_run_ekf((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (LoopSettings){a[12].i, a[13].i, a[14].i, (a[15].i != 0), (a[16].i != 0), (DescribedLoad){(real)a[17].d, (real)a[18].d, (real)a[19].d, (real)a[20].d, (real)a[21].d}}, (array1_f8){(real *)a[22].p, {a[23].i}}, (Stream){(array1_i8){(int64_t *)a[24].p, {a[25].i}}, (array2_f8){(real *)a[26].p, {a[27].i, a[28].i}}, (array2_f8){(real *)a[29].p, {a[30].i, a[31].i}}}, (LoopState){(array1_i8){(int64_t *)a[32].p, {a[33].i}}, (array1_i8){(int64_t *)a[34].p, {a[35].i}}, (array1_f8){(real *)a[36].p, {a[37].i}}, (array2_f8){(real *)a[38].p, {a[39].i, a[40].i}}, (array2_f8){(real *)a[41].p, {a[42].i, a[43].i}}, (array1_i8){(int64_t *)a[44].p, {a[45].i}}, (array1_f8){(real *)a[46].p, {a[47].i}}, (Companions){a[48].i, (array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}}}, (Belief){(array1_f8){(real *)a[53].p, {a[54].i}}, (array1_f8){(real *)a[55].p, {a[56].i}}, (array1_f8){(real *)a[57].p, {a[58].i}}}, (Scratch){(array2_f8){(real *)a[59].p, {a[60].i, a[61].i}}, (array2_f8){(real *)a[62].p, {a[63].i, a[64].i}}}, (Output){(array1_i8){(int64_t *)a[65].p, {a[66].i}}, (array2_f8){(real *)a[67].p, {a[68].i, a[69].i}}, (array1_i8){(int64_t *)a[70].p, {a[71].i}}, (array2_f8){(real *)a[72].p, {a[73].i, a[74].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_slopes(gm_slot *a)
{
    tuple_18 r = sample_loop_run_slopes((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (LoopSettings){a[12].i, a[13].i, a[14].i, (a[15].i != 0), (a[16].i != 0), (DescribedLoad){(real)a[17].d, (real)a[18].d, (real)a[19].d, (real)a[20].d, (real)a[21].d}}, (array1_f8){(real *)a[22].p, {a[23].i}}, (Stream){(array1_i8){(int64_t *)a[24].p, {a[25].i}}, (array2_f8){(real *)a[26].p, {a[27].i, a[28].i}}, (array2_f8){(real *)a[29].p, {a[30].i, a[31].i}}}, (LoopState){(array1_i8){(int64_t *)a[32].p, {a[33].i}}, (array1_i8){(int64_t *)a[34].p, {a[35].i}}, (array1_f8){(real *)a[36].p, {a[37].i}}, (array2_f8){(real *)a[38].p, {a[39].i, a[40].i}}, (array2_f8){(real *)a[41].p, {a[42].i, a[43].i}}, (array1_i8){(int64_t *)a[44].p, {a[45].i}}, (array1_f8){(real *)a[46].p, {a[47].i}}, (Companions){a[48].i, (array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}}}, (Belief){(array1_f8){(real *)a[53].p, {a[54].i}}, (array1_f8){(real *)a[55].p, {a[56].i}}, (array1_f8){(real *)a[57].p, {a[58].i}}}, (Scratch){(array2_f8){(real *)a[59].p, {a[60].i, a[61].i}}, (array2_f8){(real *)a[62].p, {a[63].i, a[64].i}}}, (Output){(array1_i8){(int64_t *)a[65].p, {a[66].i}}, (array2_f8){(real *)a[67].p, {a[68].i, a[69].i}}, (array1_i8){(int64_t *)a[70].p, {a[71].i}}, (array2_f8){(real *)a[72].p, {a[73].i, a[74].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_srukf(gm_slot *a)
{
    tuple_18 r = sample_loop_run_srukf((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (LoopSettings){a[12].i, a[13].i, a[14].i, (a[15].i != 0), (a[16].i != 0), (DescribedLoad){(real)a[17].d, (real)a[18].d, (real)a[19].d, (real)a[20].d, (real)a[21].d}}, (array1_f8){(real *)a[22].p, {a[23].i}}, (Stream){(array1_i8){(int64_t *)a[24].p, {a[25].i}}, (array2_f8){(real *)a[26].p, {a[27].i, a[28].i}}, (array2_f8){(real *)a[29].p, {a[30].i, a[31].i}}}, (LoopState){(array1_i8){(int64_t *)a[32].p, {a[33].i}}, (array1_i8){(int64_t *)a[34].p, {a[35].i}}, (array1_f8){(real *)a[36].p, {a[37].i}}, (array2_f8){(real *)a[38].p, {a[39].i, a[40].i}}, (array2_f8){(real *)a[41].p, {a[42].i, a[43].i}}, (array1_i8){(int64_t *)a[44].p, {a[45].i}}, (array1_f8){(real *)a[46].p, {a[47].i}}, (Companions){a[48].i, (array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}}}, (Belief){(array1_f8){(real *)a[53].p, {a[54].i}}, (array1_f8){(real *)a[55].p, {a[56].i}}, (array1_f8){(real *)a[57].p, {a[58].i}}}, (Scratch){(array2_f8){(real *)a[59].p, {a[60].i, a[61].i}}, (array2_f8){(real *)a[62].p, {a[63].i, a[64].i}}}, (Output){(array1_i8){(int64_t *)a[65].p, {a[66].i}}, (array2_f8){(real *)a[67].p, {a[68].i, a[69].i}}, (array1_i8){(int64_t *)a[70].p, {a[71].i}}, (array2_f8){(real *)a[72].p, {a[73].i, a[74].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_ukf(gm_slot *a)
{
    tuple_18 r = sample_loop_run_ukf((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (LoopSettings){a[12].i, a[13].i, a[14].i, (a[15].i != 0), (a[16].i != 0), (DescribedLoad){(real)a[17].d, (real)a[18].d, (real)a[19].d, (real)a[20].d, (real)a[21].d}}, (array1_f8){(real *)a[22].p, {a[23].i}}, (Stream){(array1_i8){(int64_t *)a[24].p, {a[25].i}}, (array2_f8){(real *)a[26].p, {a[27].i, a[28].i}}, (array2_f8){(real *)a[29].p, {a[30].i, a[31].i}}}, (LoopState){(array1_i8){(int64_t *)a[32].p, {a[33].i}}, (array1_i8){(int64_t *)a[34].p, {a[35].i}}, (array1_f8){(real *)a[36].p, {a[37].i}}, (array2_f8){(real *)a[38].p, {a[39].i, a[40].i}}, (array2_f8){(real *)a[41].p, {a[42].i, a[43].i}}, (array1_i8){(int64_t *)a[44].p, {a[45].i}}, (array1_f8){(real *)a[46].p, {a[47].i}}, (Companions){a[48].i, (array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}}}, (Belief){(array1_f8){(real *)a[53].p, {a[54].i}}, (array1_f8){(real *)a[55].p, {a[56].i}}, (array1_f8){(real *)a[57].p, {a[58].i}}}, (Scratch){(array2_f8){(real *)a[59].p, {a[60].i, a[61].i}}, (array2_f8){(real *)a[62].p, {a[63].i, a[64].i}}}, (Output){(array1_i8){(int64_t *)a[65].p, {a[66].i}}, (array2_f8){(real *)a[67].p, {a[68].i, a[69].i}}, (array1_i8){(int64_t *)a[70].p, {a[71].i}}, (array2_f8){(real *)a[72].p, {a[73].i, a[74].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
