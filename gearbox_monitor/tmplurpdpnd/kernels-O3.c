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

typedef struct { uint8_t *p; int64_t n[1]; } array1_u1;
typedef struct { int64_t *p; int64_t n[1]; } array1_i8;
typedef struct { array1_i8 v[2]; } tuple;
typedef struct { uint64_t *p; int64_t n[1]; } array1_u8;
typedef struct { int64_t f0; array1_u8 f1; array1_u8 f2; array1_u8 f3; } tuple_2;
typedef struct { uint64_t *p; int64_t n[2]; } array2_u8;
typedef struct { bool *p; int64_t n[1]; } array1_b1;
typedef struct { array1_i8 f0; array2_u8 f1; array1_b1 f2; } tuple_3;
typedef struct { int32_t *p; int64_t n[1]; } array1_i4;
typedef struct { array1_i8 offset_; array1_i8 size_; array1_i4 number_; array1_u8 log_ns_; array1_u8 publish_ns_; } MessageIndex;
typedef struct { int64_t v[2]; } tuple_4;
typedef struct { real *p; int64_t n[1]; } array1_f8;
typedef struct { array1_f8 z_; array1_f8 P_; array1_f8 memory_; } Belief;
typedef struct { real *p; int64_t n[2]; } array2_f8;
typedef struct { array2_f8 vectors_; array2_f8 matrices_; } Scratch;
typedef struct { int64_t number_; array1_f8 s_; array1_f8 lanes_; } Companions;
typedef struct { Belief f0; array1_f8 f1; Scratch f2; array1_f8 f3; Companions f4; array1_f8 f5; } tuple_5;
typedef struct { real dt_; real u_; real load_; real y1_; real y2_; } Reading;
typedef struct { int64_t v[9]; } tuple_6;
typedef struct { real v[2]; } tuple_7;
typedef struct { real v[5]; } tuple_8;
typedef struct { real v[4]; } tuple_9;
typedef struct { real f0; tuple_9 f1; } tuple_10;
typedef struct { real f0; tuple_8 f1; } tuple_11;
typedef struct { tuple_8 v[4]; } tuple_12;
typedef struct { tuple_7 v[4]; } tuple_13;
typedef struct { tuple_9 slopes_; tuple_9 shares_; tuple_13 arms_; tuple_12 bends_; real h_; bool first_; } Stages;
typedef struct { real v[7]; } tuple_14;
typedef struct { real v[3]; } tuple_15;
typedef struct { array2_f8 z_; array2_f8 P_; int64_t n_theta_; } BeliefSensitivity;
typedef struct { int64_t f0; tuple_7 f1; } tuple_16;
typedef struct { array1_f8 f0; real f1; } tuple_17;
typedef struct { real v[27]; } tuple_18;
typedef struct { real f0; tuple_18 f1; } tuple_19;
typedef struct { int64_t v[4]; } tuple_20;
typedef struct { real v[11]; } tuple_21;
typedef struct { array1_f8 p_; array1_f8 e_; array1_f8 theta_; int64_t call_; } PackedDrive;
typedef struct { int64_t *p; int64_t n[2]; } array2_i8;
typedef struct { array1_f8 length_; array1_i8 part_; array1_i8 ends_; array1_f8 span_; array2_i8 reads_; array1_i8 shift_; } SampleSchedule;
typedef struct { array2_f8 y_; array2_f8 u_; array2_f8 extra_; real dt_; array1_i8 begin_; array1_i8 end_; array1_f8 variance_; array1_f8 torque_; real fade_; int64_t every_; } FilterInput;
typedef struct { array2_f8 states_; array1_i8 places_; array2_f8 covariance_; array1_f8 moves_; } FilterStart;
typedef struct { real *p; int64_t n[3]; } array3_f8;
typedef struct { real *p; int64_t n[4]; } array4_f8;
typedef struct { array3_f8 begin_; array3_f8 end_; array4_f8 tangent_; array3_f8 covariance_; array2_f8 innovation_; array2_f8 variance_; array3_f8 gain_; array2_f8 slope_; array2_f8 position_; array2_f8 speed_; } FilterTrace;
typedef struct { real *p; int64_t n[2]; int64_t s[2]; } view2_f8;
typedef struct { real f0; real f1; real f2; real f3; array1_f8 f4; } tuple_22;
typedef struct { tuple_9 f0; real f1; } tuple_23;
typedef struct { array1_f8 v[2]; } tuple_24;
typedef struct { real A_; real N_; real phi_; } mesh_error;
typedef struct { real h_; real ds_; } hysteresis_branch;
typedef struct { array1_f8 v[3]; } tuple_25;
typedef struct { array1_f8 f0; int64_t f1; } tuple_26;
typedef struct { real K3_; } hardening;
typedef struct { real Th_; real dh_; } hysteresis_bouc_wen;
typedef struct { real A_; real phi_; } motor_encoder_eccentricity;
typedef struct { array1_f8 f0; } tuple_27;
typedef struct { real umax_; } saturation;
typedef struct { real g_; } torque_gain;
typedef struct { array1_f8 f0; real f1; array1_f8 f2; array1_f8 f3; } tuple_28;
typedef struct { real viscous_; real coulomb_; real sharpness_; real law_; } MotorFriction;
typedef struct { real Cs_; real vs_; } stribeck;
typedef struct { real sigma0_; real sigma1_; real Cs_; real vs_; } lugre;
typedef struct { real Ca_; } coulomb_asymmetry;
typedef struct { real Cva_; } viscous_asymmetry;
typedef struct { real r_; real T_; } viscous_drift;
typedef struct { array1_f8 f0; real f1; array1_f8 f2; } tuple_29;
typedef struct { array1_f8 f0; int64_t f1; int64_t f2; real f3; array1_f8 f4; array1_f8 f5; } tuple_30;
typedef struct { real *p; int64_t n[1]; int64_t s[1]; } view1_f8;
typedef struct { real f0; } tuple_31;
typedef struct { view1_f8 f0; } tuple_32;
typedef struct { real v[6]; } tuple_33;
typedef struct { real v[8]; } tuple_34;
typedef struct { real f0; tuple_15 f1; PackedDrive f2; } tuple_35;
typedef struct { array1_f8 f0; tuple_34 f1; real f2; real f3; } tuple_36;
typedef struct { array1_f8 f0; real f1; real f2; } tuple_37;
typedef struct { array1_f8 f0; tuple_34 f1; real f2; real f3; MotorFriction f4; } tuple_38;
typedef struct { real f0; real f1; MotorFriction f2; } tuple_39;
typedef struct { array1_f8 f0; tuple_34 f1; real f2; real f3; real f4; MotorFriction f5; } tuple_40;
typedef struct { tuple_9 f0; tuple_34 f1; } tuple_41;
typedef struct { real c_; } encoder_offset;
typedef struct { PackedDrive v[2]; } tuple_42;
typedef struct { array1_f8 weights_; array1_f8 alone_; array1_i8 stamps_; array2_f8 history_; array1_i8 places_; array1_f8 prior_; array2_f8 aligned_; array1_i8 next_row_; } Mixture;
typedef struct { array2_i8 codes_; array3_f8 rows_; array2_i8 smoothed_stamps_; array3_f8 smoothed_; array1_i8 n_smoothed_; } Outputs;
typedef struct { array1_i8 codes_; array2_f8 estimates_; array1_i8 smoothed_stamps_; array2_f8 smoothed_; } Output;
typedef struct { int64_t n_; bool loaded_; int64_t curve_; bool law_; } Layout;
typedef struct { int64_t newest_; int64_t oldest_; int64_t keep_until_; } Span;
typedef struct { real time_; real noise_; real torque_noise_; real eigenvalue_; real inertia_; } DescribedLoad;
typedef struct { int64_t max_gap_; int64_t delay_; int64_t lag_; bool load_measured_; bool narrow_; DescribedLoad described_; } LoopSettings;
typedef struct { array1_i8 stamps_; array2_f8 inputs_; array2_f8 outputs_; } Stream;
typedef struct { array1_i8 gate_; array1_i8 counts_; array1_f8 clock_; array2_f8 efforts_; array2_f8 ring_; array1_i8 ring_stamps_; array1_f8 saved_; Companions companions_; } LoopState;
typedef struct { int64_t f0; real f1; } tuple_43;
typedef struct { real f0; int64_t f1; } tuple_44;
typedef struct { bool *p; int64_t n[2]; } array2_b1;
typedef struct { bool passive_; bool by_height_; real side_; tuple_15 friction_; int64_t group_; bool paired_; int64_t block_; real huber_; } ElasticLaw;
typedef struct { ElasticLaw law_; array2_f8 data_; array1_f8 weights_; array1_f8 units_; array1_f8 prior_; array1_f8 base_; array1_f8 low_; array1_f8 high_; bool strict_; } Problem;
typedef struct { real start_; real raised_; real raised_from_; real largest_; real lowered_; real smallest_; int64_t attempts_; real hopeless_; real absolute_; real relative_; bool level_; } Damping;
typedef struct { array3_f8 f0; array2_f8 f1; array2_f8 f2; } tuple_45;
typedef struct { tuple_45 blocks_; array1_f8 residuals_; array3_f8 normals_; array2_f8 vectors_; } Room;
typedef struct { array1_i8 begin_; array1_i8 first_; int64_t length_; array1_i8 carry_at_; array1_i8 extra_at_; } RunSpans;
typedef struct { array2_f8 states_; array2_f8 memory_; } Begin;
typedef struct { array2_f8 u_; array2_f8 extra_; real dt_; } Driving;
typedef struct { array3_f8 y_; array2_f8 carry_; } RunResult;
typedef struct { array1_f8 t_; array2_f8 u_; array2_f8 extra_; real dt_; } Schedule;
typedef struct { array3_f8 numbers_; array1_f8 std_; } ProcessNoise;
typedef struct { array1_f8 f0; array2_f8 f1; } tuple_46;
typedef struct { array1_i8 parent_; array1_i8 source_; array1_f8 ratio_; array1_f8 offset_; array1_f8 prismatic_; array3_f8 rotation_; array2_f8 origin_; array2_f8 axis_; array1_i8 body_joint_; array1_f8 mass_; array2_f8 com_; array3_f8 inertia_; array1_f8 amounts_; array1_f8 deviations_; array1_f8 gravity_; array2_f8 frames_; array2_f8 bodies_; } RobotArrays;
typedef struct { array2_f8 joints_; array1_i8 clock_; array2_f8 acting_; } MotionState;
typedef struct { real v[9]; } tuple_47;
typedef struct { tuple_15 v[2]; } tuple_48;
typedef struct { array2_f8 p_; array1_f8 kp_; array1_f8 kd_; } ServoDrives;
typedef struct { array2_f8 matrix_; array1_f8 right_; array2_f8 motion_; array2_f8 slopes_; } ArmScratch;

GM_STATIC const int64_t constant[22] = {0, 7, 1, 8, 2, 9, 3, 10, 4, 11, 5, 12, 6, 13, 14, 16, 15, 17, 4, 37, 4, 39};
GM_STATIC const int64_t constant_2[14] = {0, 3, 1, 4, 2, 5, 0, 10, 1, 11, 2, 12, 13, 14};

/* bag/message_block.py:22 word */
GM_INLINE uint64_t message_block_word(array1_u1 data_, uint64_t offset_)
{
    uint64_t value_;
    int64_t i_;
    value_ = UINT64_C(0);
    for (int64_t k1 = 0; k1 < 8; k1 += 1) {
        i_ = k1;
        value_ = (value_ | ((uint64_t)(data_.p[((offset_ + (uint64_t)(i_)))]) << (uint64_t)((8 * i_))));
    }
    return value_;
}

/* bag/cdr.py:134 _decode_rows */
GM_STATIC void cdr_decode_rows(array1_u1 data_, tuple block_, tuple_2 layout_, array1_i8 columns_, tuple_3 decoded_)
{
    array1_i8 offsets_;
    array1_i8 sizes_;
    int64_t needed_;
    array1_u8 starts_;
    array1_u8 mask_;
    array1_u8 fixed_;
    array1_i8 stamps_;
    array2_u8 values_;
    array1_b1 done_;
    int64_t k_;
    uint64_t begin_;
    uint64_t different_;
    int64_t i_;
    uint64_t time_;
    int64_t sec_;
    int64_t nanosec_;
    offsets_ = block_.v[0];
    sizes_ = block_.v[1];
    needed_ = layout_.f0;
    starts_ = layout_.f1;
    mask_ = layout_.f2;
    fixed_ = layout_.f3;
    stamps_ = decoded_.f0;
    values_ = decoded_.f1;
    done_ = decoded_.f2;
    for (int64_t k1 = 0; k1 < offsets_.n[0]; k1 += 1) {
        k_ = k1;
        done_.p[(k_)] = false;
        if (((sizes_.p[(k_)] < needed_))) {
            continue;
        }
        uint64_t t2 = (uint64_t)(offsets_.p[(k_)]);
        begin_ = t2;
        different_ = UINT64_C(0);
        for (int64_t k3 = 0; k3 < starts_.n[0]; k3 += 1) {
            i_ = k3;
            uint64_t t5 = different_;
            uint64_t t4 = message_block_word(data_, (begin_ + starts_.p[(i_)]));
            different_ = (t5 | ((t4 & mask_.p[(i_)]) ^ fixed_.p[(i_)]));
        }
        if (((different_ != (uint64_t)(0)))) {
            continue;
        }
        done_.p[(k_)] = true;
        uint64_t t6 = message_block_word(data_, (begin_ + UINT64_C(4)));
        time_ = t6;
        int64_t t7 = (int64_t)((time_ & UINT64_C(4294967295)));
        int64_t t8 = (int64_t)((time_ >> UINT64_C(32)));
        sec_ = t7;
        nanosec_ = t8;
        if (((sec_ >= INT64_C(2147483648)))) {
            sec_ = (sec_ - INT64_C(4294967296));
        }
        stamps_.p[(k_)] = ((sec_ * 1000000000) + nanosec_);
        for (int64_t k9 = 0; k9 < columns_.n[0]; k9 += 1) {
            i_ = k9;
            if (((columns_.p[(i_)] >= 0))) {
                uint64_t t10 = message_block_word(data_, (begin_ + (uint64_t)(columns_.p[(i_)])));
                values_.p[((k_) * values_.n[1] + (i_))] = t10;
            }
        }
    }
    return;
}

/* bag/message_block.py:31 copy */
GM_INLINE void message_block_copy(array1_u1 source_, int64_t begin_, int64_t size_, array1_u1 target_, int64_t place_)
{
    int64_t i_;
    for (int64_t k1 = 0; k1 < size_; k1 += 1) {
        i_ = k1;
        target_.p[(((uint64_t)(place_) + (uint64_t)(i_)))] = source_.p[(((uint64_t)(begin_) + (uint64_t)(i_)))];
    }
    return;
}

/* bag/message_block.py:31 copy */
GM_INLINE void message_block_copy_2(array1_u1 source_, int64_t begin_, int64_t size_, array1_u1 target_, int64_t place_)
{
    int64_t i_;
    for (int64_t k1 = 0; k1 < size_; k1 += 1) {
        i_ = k1;
        target_.p[(((uint64_t)(place_) + (uint64_t)(i_)))] = source_.p[(((uint64_t)(begin_) + (uint64_t)(i_)))];
    }
    return;
}

/* bag/message_block.py:132 _gather */
GM_STATIC void message_block_gather(array1_u1 heads_, int64_t width_, array1_u1 data_, tuple block_, array1_u1 out_)
{
    array1_i8 offsets_;
    array1_i8 sizes_;
    int64_t position_;
    int64_t k_;
    offsets_ = block_.v[0];
    sizes_ = block_.v[1];
    position_ = 0;
    for (int64_t k1 = 0; k1 < offsets_.n[0]; k1 += 1) {
        k_ = k1;
        message_block_copy_2(heads_, (k_ * width_), width_, out_, position_);
        message_block_copy_2(data_, offsets_.p[(k_)], sizes_.p[(k_)], out_, (position_ + width_));
        position_ = (position_ + (width_ + sizes_.p[(k_)]));
    }
    return;
}

/* bag/message_block.py:55 find_messages */
GM_STATIC tuple_4 message_block_find_messages(array1_u1 data_, int64_t begin_, int64_t end_, array1_i4 number_of_, bool stop_, int64_t row_, MessageIndex index_)
{
    uint64_t offset_;
    uint64_t last_;
    uint64_t length_;
    int64_t number_;
    uint64_t t1 = (uint64_t)(begin_);
    uint64_t t2 = (uint64_t)(end_);
    offset_ = t1;
    last_ = t2;
    for (;;) {
        if (!(((offset_ + UINT64_C(9)) <= last_))) break;
        uint64_t t3 = message_block_word(data_, (offset_ + UINT64_C(1)));
        length_ = t3;
        if ((((data_.p[(offset_)] == 0)) || ((length_ > ((last_ - offset_) - UINT64_C(9)))))) {
            break;
        }
        if ((((data_.p[(offset_)] == 5)) && ((length_ >= UINT64_C(22))))) {
            number_ = number_of_.p[((data_.p[((offset_ + UINT64_C(9)))] + (256 * data_.p[((offset_ + UINT64_C(10)))])))];
            if (((number_ >= 0))) {
                uint64_t t4 = (offset_ + UINT64_C(31));
                uint64_t t5 = (length_ - UINT64_C(22));
                index_.offset_.p[gm_at(row_, index_.offset_.n[0])] = (int64_t)(t4);
                index_.size_.p[gm_at(row_, index_.size_.n[0])] = (int64_t)(t5);
                index_.number_.p[gm_at(row_, index_.number_.n[0])] = number_;
                uint64_t t6 = message_block_word(data_, (offset_ + UINT64_C(15)));
                index_.log_ns_.p[gm_at(row_, index_.log_ns_.n[0])] = t6;
                uint64_t t7 = message_block_word(data_, (offset_ + UINT64_C(23)));
                index_.publish_ns_.p[gm_at(row_, index_.publish_ns_.n[0])] = t7;
                row_ = (row_ + 1);
            }
        } else {
            if (stop_) {
                break;
            }
        }
        offset_ = (offset_ + (UINT64_C(9) + length_));
    }
    return (tuple_4){{row_, (int64_t)(offset_)}};
}

/* estimation/step_record.py:18 record_size */
GM_STATIC int64_t step_record_record_size(int64_t n_, int64_t considered_)
{
    return ((((4 * n_) + ((3 * n_) * n_)) + 9) + ((3 * n_) * considered_));
}

/* estimation/filter.py:36 _parts */
GM_INLINE tuple_5 filter_parts(int64_t n_vectors_, int64_t n_matrices_, array1_f8 room_)
{
    int64_t count_;
    int64_t at_matrices_;
    int64_t at_record_;
    int64_t at_lanes_;
    int64_t at_s_;
    int64_t at_before_;
    int64_t at_memory_;
    int64_t t1 = (int64_t)(room_.p[0]);
    count_ = t1;
    at_matrices_ = (117 + (n_vectors_ * 6));
    at_record_ = (at_matrices_ + (n_matrices_ * 36));
    int64_t t2 = step_record_record_size(6, count_);
    at_lanes_ = (at_record_ + t2);
    at_s_ = (at_lanes_ + 592);
    at_before_ = ((at_s_ + (6 * count_)) + 1);
    at_memory_ = (at_before_ + 6);
    int64_t t3 = gm_bound(1, room_.n[0]);
    int64_t t4 = gm_bound(7, room_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = gm_bound(7, room_.n[0]);
    int64_t t7 = gm_bound(43, room_.n[0]);
    int64_t t8 = gm_span(t6, t7);
    int64_t t9 = gm_bound(at_memory_, room_.n[0]);
    int64_t t10 = gm_span(t9, room_.n[0]);
    int64_t t11 = gm_bound(43, room_.n[0]);
    int64_t t12 = gm_bound(117, room_.n[0]);
    int64_t t13 = gm_span(t11, t12);
    int64_t t14 = gm_bound(117, room_.n[0]);
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
    return (tuple_5){(Belief){(array1_f8){room_.p + t3 * (1), {t5}}, (array1_f8){room_.p + t6 * (1), {t8}}, (array1_f8){room_.p + t9 * (1), {t10}}}, (array1_f8){room_.p + t11 * (1), {t13}}, (Scratch){(array2_f8){room_.p + t14 * (1), {n_vectors_, 6}}, (array2_f8){room_.p + t17 * (1), {n_matrices_, 36}}}, (array1_f8){room_.p + t20 * (1), {t22}}, (Companions){count_, (array1_f8){room_.p + t23 * (1), {t25}}, (array1_f8){room_.p + t26 * (1), {t28}}}, (array1_f8){room_.p + t29 * (1), {t31}}};
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
GM_INLINE void sample_loop_aim(Belief belief_, Reading reading_, array1_f8 p_)
{
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    real t1 = sample_loop_first_speed((reading_.y1_ - z_.p[0]), dt_, (P_.p[0] + p_.p[31]), P_.p[14]);
    z_.p[2] = t1;
    real t2 = sample_loop_first_speed((reading_.y2_ - z_.p[1]), dt_, (P_.p[7] + p_.p[32]), P_.p[21]);
    z_.p[3] = t2;
    return;
}

/* estimation/step_record.py:39 places */
GM_INLINE tuple_6 step_record_places(int64_t n_)
{
    int64_t m_;
    int64_t begin_;
    m_ = (n_ * n_);
    begin_ = ((2 * n_) + (3 * m_));
    return (tuple_6){{0, n_, (n_ + m_), (n_ + (2 * m_)), ((2 * n_) + (2 * m_)), begin_, (begin_ + 2), (begin_ + 5), ((begin_ + 5) + (2 * n_))}};
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
GM_INLINE tuple_8 process_model_decay(real error_, real half_, real h_, array1_f8 p_)
{
    real rate_;
    real second_;
    real third_;
    real fourth_;
    rate_ = ((real)(-1.0) / p_.p[27]);
    second_ = (error_ + ((half_ * rate_) * error_));
    third_ = (error_ + ((half_ * rate_) * second_));
    fourth_ = (error_ + ((h_ * rate_) * third_));
    return (tuple_8){{error_, second_, third_, fourth_, (error_ + (((h_ / (real)6.0) * rate_) * ((error_ + ((real)2.0 * (second_ + third_))) + fourth_)))}};
}

/* estimation/process_model.py:210 _curve */
GM_INLINE tuple_9 process_model_curve(int64_t curve_, array1_f8 z_, int64_t width_, int64_t i_, int64_t at_, array1_f8 p_)
{
    int64_t count_;
    if (((curve_ < 0))) {
        return (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    }
    int64_t t1 = process_model_curve_count(curve_);
    count_ = t1;
    if (((count_ > 1))) {
        return (tuple_9){{z_.p[gm_at((((at_ + 1) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 2) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 3) * width_) + i_), z_.n[0])], p_.p[12]}};
    }
    return (tuple_9){{p_.p[9], (p_.p[9] * p_.p[10]), (((count_ > 0)) ? (p_.p[9] * p_.p[11]) : (real)0.0), p_.p[12]}};
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
GM_INLINE tuple_11 transmission_dead_zone_torque(real twist_, real stiffness_, real offset_)
{
    real stretched_;
    real torque_;
    real side_;
    stretched_ = (stiffness_ * twist_);
    torque_ = (stretched_ - gm_min_f(gm_max_f(stretched_, (-offset_)), offset_));
    side_ = (((torque_ != (real)0.0)) ? gm_copysign((real)1.0, torque_) : (real)0.0);
    return (tuple_11){torque_, (tuple_8){{(stiffness_ * gm_fabs(side_)), (real)0.0, (gm_fabs(side_) * twist_), (-side_), (real)0.0}}};
}

/* plant/transmission.py:70 play */
GM_INLINE tuple_7 transmission_play(real twist_, real memory_, real width_)
{
    if ((((twist_ - memory_) > width_))) {
        return (tuple_7){{(twist_ - width_), (real)1.0}};
    }
    if ((((memory_ - twist_) > width_))) {
        return (tuple_7){{(twist_ + width_), (real)(-1.0)}};
    }
    return (tuple_7){{memory_, (real)0.0}};
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
GM_INLINE tuple_11 transmission_elastic_torque(real twist_, real memory_, tuple_9 curve_)
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
    tuple_7 t1 = transmission_play(twist_, memory_, width_);
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
    return (tuple_11){(torque_ + (added_ * stretch_)), (tuple_8){{(slope_ + (of_stretch_ * free_)), ((-of_stretch_) * free_), ((gm_fabs(side_) * shifted_) - (of_width_ * width_)), (-side_), (of_width_ * sign_)}}};
}

/* estimation/process_model.py:233 _total */
GM_INLINE tuple_11 process_model_total(int64_t curve_, real twist_, real memory_, tuple_9 law_, real tau_k_)
{
    real torque_;
    tuple_8 slopes_;
    if (((curve_ < 0))) {
        return (tuple_11){tau_k_, (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}}};
    }
    int64_t t1 = process_model_curve_count(curve_);
    if (((t1 == 0))) {
        tuple_11 t2 = transmission_dead_zone_torque(twist_, law_.v[0], law_.v[1]);
        torque_ = t2.f0;
        slopes_ = t2.f1;
    } else {
        tuple_11 t3 = transmission_elastic_torque(twist_, memory_, law_);
        torque_ = t3.f0;
        slopes_ = t3.f1;
    }
    return (tuple_11){(tau_k_ + torque_), slopes_};
}

/* estimation/process_model.py:547 _bearing */
GM_INLINE tuple_8 process_model_bearing(tuple_8 x_, tuple_10 elastic_)
{
    real tau_k_;
    tuple_11 t1 = process_model_total((-1), (x_.v[0] - x_.v[1]), elastic_.f0, elastic_.f1, x_.v[4]);
    tau_k_ = t1.f0;
    return (tuple_8){{x_.v[0], x_.v[1], x_.v[2], x_.v[3], tau_k_}};
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

/* plant/drive.py:941 arm_acceleration */
GM_INLINE real drive_arm_acceleration(real x3_, real x4_, real tau_k_, real tau_arm_, array1_f8 p_)
{
    return ((((p_.p[2] * (x3_ - x4_)) + tau_k_) - tau_arm_) * p_.p[1]);
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations(tuple_8 x_, real u_, real load_, array1_f8 p_)
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
    real t1 = drive_motor_acceleration(x1_, x3_, x4_, u_, tau_k_, p_);
    real t2 = drive_arm_acceleration(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t1, t2}};
}

/* estimation/process_model.py:520 _advanced */
GM_INLINE tuple_8 process_model_advanced(tuple_8 x_, tuple_10 elastic_, tuple_9 error_, tuple_7 torques_, real h_, array1_f8 p_)
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
    tuple_8 y_;
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
    tuple_8 t3 = process_model_bearing(x_, elastic_);
    tuple_7 t4 = process_model_accelerations(t3, (u_ - error_.v[0]), load_, p_);
    f1_ = t4.v[0];
    g1_ = t4.v[1];
    real t5 = (x3_ + (half_ * f1_));
    real t6 = (x4_ + (half_ * g1_));
    b3_ = t5;
    b4_ = t6;
    y_ = (tuple_8){{(x1_ + (half_ * x3_)), (x2_ + (half_ * x4_)), b3_, b4_, (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)))}};
    tuple_8 t7 = process_model_bearing(y_, elastic_);
    tuple_7 t8 = process_model_accelerations(t7, (u_ - error_.v[1]), load_, p_);
    f2_ = t8.v[0];
    g2_ = t8.v[1];
    real t9 = (x3_ + (half_ * f2_));
    real t10 = (x4_ + (half_ * g2_));
    c3_ = t9;
    c4_ = t10;
    y_ = (tuple_8){{(x1_ + (half_ * b3_)), (x2_ + (half_ * b4_)), c3_, c4_, (tau_k_ + ((half_ * p_.p[26]) * (b3_ - b4_)))}};
    tuple_8 t11 = process_model_bearing(y_, elastic_);
    tuple_7 t12 = process_model_accelerations(t11, (u_ - error_.v[2]), load_, p_);
    f3_ = t12.v[0];
    g3_ = t12.v[1];
    real t13 = (x3_ + (h_ * f3_));
    real t14 = (x4_ + (h_ * g3_));
    d3_ = t13;
    d4_ = t14;
    y_ = (tuple_8){{(x1_ + (h_ * c3_)), (x2_ + (h_ * c4_)), d3_, d4_, (tau_k_ + ((h_ * p_.p[26]) * (c3_ - c4_)))}};
    tuple_8 t15 = process_model_bearing(y_, elastic_);
    tuple_7 t16 = process_model_accelerations(t15, (u_ - error_.v[3]), load_, p_);
    f4_ = t16.v[0];
    g4_ = t16.v[1];
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (b3_ + c3_))) + d3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (b4_ + c4_))) + d4_));
    return (tuple_8){{(x1_ + moved1_), (x2_ + moved2_), (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_))), (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_))), (tau_k_ + (p_.p[26] * (moved1_ - moved2_)))}};
}

/* estimation/process_model.py:499 _advance_one */
GM_INLINE void process_model_advance_one(array1_f8 z_, tuple_7 torques_, real h_, array1_f8 p_)
{
    real u_;
    real load_;
    int64_t at_curve_;
    tuple_8 error_;
    tuple_8 x_;
    tuple_9 law_;
    real memory_;
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    int64_t t1 = process_model_curve_count((-1));
    at_curve_ = (6 - t1);
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t2 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], ((real)0.5 * h_), h_, p_);
        error_ = t2;
        z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])] = error_.v[4];
    }
    x_ = (tuple_8){{z_.p[0], z_.p[1], z_.p[2], z_.p[3], z_.p[4]}};
    tuple_9 t3 = process_model_curve((-1), z_, 1, 0, at_curve_, p_);
    law_ = t3;
    real t4 = process_model_memory((-1), z_, at_curve_, (x_.v[0] - x_.v[1]));
    memory_ = t4;
    tuple_8 t5 = process_model_advanced(x_, (tuple_10){memory_, law_}, (tuple_9){{error_.v[0], error_.v[1], error_.v[2], error_.v[3]}}, (tuple_7){{u_, load_}}, h_, p_);
    x_ = t5;
    int64_t t6 = process_model_curve_count((-1));
    if (((t6 > 0))) {
        tuple_7 t7 = transmission_play((x_.v[0] - x_.v[1]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
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
GM_STATIC void process_model_advance(array1_f8 z_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (dt_ / (real)(n_substeps_));
    for (int64_t k1 = 0; k1 < n_substeps_; k1 += 1) {
        process_model_advance_one(z_, torques_, h_, p_);
    }
    return;
}

/* estimation/process_model.py:1044 propagate_numeric */
GM_STATIC void process_model_propagate_numeric(array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_, array1_f8 start_)
{
    int64_t i_;
    int64_t j_;
    array1_f8 moved_;
    real step_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        start_.p[(i_)] = z_.p[(i_)];
    }
    process_model_advance(z_, torques_, dt_, n_substeps_, p_);
    for (int64_t k2 = 0; k2 < 6; k2 += 1) {
        j_ = k2;
        int64_t t3 = (j_ * 6);
        int64_t t4 = ((j_ + 1) * 6);
        int64_t t5 = gm_bound(t3, phi_.n[0]);
        int64_t t6 = gm_bound(t4, phi_.n[0]);
        int64_t t7 = gm_span(t5, t6);
        moved_ = (array1_f8){phi_.p + t5 * (1), {t7}};
        for (int64_t k8 = 0; k8 < 6; k8 += 1) {
            i_ = k8;
            moved_.p[(i_)] = start_.p[(i_)];
        }
        moved_.p[(j_)] = (moved_.p[(j_)] + ((real)1e-06 * gm_max_f((real)1.0, gm_fabs(start_.p[(j_)]))));
        step_ = (moved_.p[(j_)] - start_.p[(j_)]);
        process_model_advance(moved_, torques_, dt_, n_substeps_, p_);
        for (int64_t k9 = 0; k9 < 6; k9 += 1) {
            i_ = k9;
            moved_.p[(i_)] = ((moved_.p[(i_)] - z_.p[(i_)]) / step_);
        }
    }
    for (int64_t k10 = 0; k10 < 6; k10 += 1) {
        i_ = k10;
        int64_t t11 = i_;
        for (int64_t k12 = 0; k12 < t11; k12 += 1) {
            j_ = k12;
            real t13 = phi_.p[(((j_ * 6) + i_))];
            real t14 = phi_.p[(((i_ * 6) + j_))];
            phi_.p[(((i_ * 6) + j_))] = t13;
            phi_.p[(((j_ * 6) + i_))] = t14;
        }
    }
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row(array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t count_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (6 - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((6 - count_) * 6) + j_), phi_.n[0])];
}

/* estimation/process_model.py:791 _begin */
GM_INLINE tuple_8 process_model_begin(int64_t n_, array1_f8 phi_, int64_t j_, bool first_)
{
    if (first_) {
        return (tuple_8){{(((j_ == 0)) ? (real)1.0 : (real)0.0), (((j_ == 2)) ? (real)1.0 : (real)0.0), (((j_ == 3)) ? (real)1.0 : (real)0.0), (((j_ == 4)) ? (real)1.0 : (real)0.0), (((j_ == 1)) ? (real)1.0 : (real)0.0)}};
    }
    return (tuple_8){{phi_.p[(((0 * n_) + j_))], phi_.p[(((2 * n_) + j_))], phi_.p[(((3 * n_) + j_))], phi_.p[(((4 * n_) + j_))], phi_.p[(((1 * n_) + j_))]}};
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
GM_INLINE tuple_7 process_model_slopes(bool law_, real x3_, real tau_k_, array1_f8 p_)
{
    if (law_) {
        real t1 = drive_motor_friction_slope_by_law(x3_, tau_k_, p_);
        real t2 = drive_motor_friction_load_slope(x3_, tau_k_, p_);
        return (tuple_7){{t1, ((real)1.0 + t2)}};
    }
    real t3 = drive_motor_friction_slope(x3_, tau_k_, p_);
    real t4 = drive_motor_friction_load_slope(x3_, tau_k_, p_);
    return (tuple_7){{t3, ((real)1.0 + t4)}};
}

/* plant/drive.py:993 arm_load_slopes */
GM_STATIC tuple_7 drive_arm_load_slopes(real x2_, real x4_, array1_f8 p_)
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
    return (tuple_7){{(((p_.p[16] != (real)0.0)) ? (p_.p[16] * gm_cos((x2_ + p_.p[17]))) : (real)0.0), on_speed_}};
}

/* estimation/process_model.py:687 _load_slopes */
GM_INLINE tuple_7 process_model_load_slopes(bool loaded_, real x2_, real x4_, array1_f8 p_)
{
    if ((!loaded_)) {
        return (tuple_7){{(real)0.0, (real)0.0}};
    }
    tuple_7 t1 = drive_arm_load_slopes(x2_, x4_, p_);
    return t1;
}

/* estimation/process_model.py:748 _bent */
GM_INLINE tuple_8 process_model_bent(int64_t curve_, tuple_8 bend_, real source_, tuple_8 m_)
{
    if (((curve_ < 0))) {
        return m_;
    }
    return (tuple_8){{m_.v[0], m_.v[1], m_.v[2], gm_fma(bend_.v[0], (m_.v[0] - m_.v[4]), (m_.v[3] + source_)), m_.v[4]}};
}

/* estimation/process_model.py:756 _four_bent */
GM_INLINE tuple_12 process_model_four_bent(int64_t curve_, tuple_8 bend_, tuple_9 memory_, tuple_12 m_)
{
    if (((curve_ < 0))) {
        return m_;
    }
    tuple_8 t1 = process_model_bent(curve_, bend_, (bend_.v[1] * memory_.v[0]), m_.v[0]);
    tuple_8 t2 = process_model_bent(curve_, bend_, (bend_.v[1] * memory_.v[1]), m_.v[1]);
    tuple_8 t3 = process_model_bent(curve_, bend_, (bend_.v[1] * memory_.v[2]), m_.v[2]);
    tuple_8 t4 = process_model_bent(curve_, bend_, (bend_.v[1] * memory_.v[3]), m_.v[3]);
    return (tuple_12){{t1, t2, t3, t4}};
}

/* estimation/process_model.py:694 answer */
GM_INLINE real process_model_answer(bool loaded_, tuple_7 arm_, real load_, tuple_8 m_)
{
    if ((!loaded_)) {
        return load_;
    }
    return ((load_ + (arm_.v[0] * m_.v[4])) + (arm_.v[1] * m_.v[2]));
}

/* estimation/process_model.py:711 rates */
GM_INLINE tuple_7 process_model_rates(tuple_8 m_, real slope_, real share_, real error_, real load_, array1_f8 p_)
{
    real twist_rate_;
    real on_motor_;
    twist_rate_ = (m_.v[1] - m_.v[2]);
    on_motor_ = gm_fma(share_, m_.v[3], gm_fma(slope_, m_.v[1], gm_fma(p_.p[6], m_.v[0], error_)));
    return (tuple_7){{((-p_.p[0]) * gm_fma(p_.p[2], twist_rate_, on_motor_)), (p_.p[1] * gm_fma(p_.p[2], twist_rate_, (m_.v[3] - load_)))}};
}

/* estimation/process_model.py:776 _four_rates */
GM_INLINE tuple_13 process_model_four_rates(bool loaded_, tuple_12 m_, real slope_, real share_, tuple_7 arm_, array1_f8 p_)
{
    real t1 = process_model_answer(loaded_, arm_, (real)0.0, m_.v[0]);
    tuple_7 t2 = process_model_rates(m_.v[0], slope_, share_, (real)0.0, t1, p_);
    real t3 = process_model_answer(loaded_, arm_, (real)0.0, m_.v[1]);
    tuple_7 t4 = process_model_rates(m_.v[1], slope_, share_, (real)0.0, t3, p_);
    real t5 = process_model_answer(loaded_, arm_, (real)0.0, m_.v[2]);
    tuple_7 t6 = process_model_rates(m_.v[2], slope_, share_, (real)0.0, t5, p_);
    real t7 = process_model_answer(loaded_, arm_, (real)0.0, m_.v[3]);
    tuple_7 t8 = process_model_rates(m_.v[3], slope_, share_, (real)0.0, t7, p_);
    return (tuple_13){{t2, t4, t6, t8}};
}

/* estimation/process_model.py:731 along */
GM_INLINE tuple_8 process_model_along(tuple_8 start_, real a_, tuple_8 m_, tuple_7 r_, array1_f8 p_)
{
    return (tuple_8){{gm_fma(a_, m_.v[1], start_.v[0]), gm_fma(a_, r_.v[0], start_.v[1]), gm_fma(a_, r_.v[1], start_.v[2]), gm_fma((a_ * p_.p[26]), (m_.v[1] - m_.v[2]), start_.v[3]), gm_fma(a_, m_.v[2], start_.v[4])}};
}

/* estimation/process_model.py:785 _four_along */
GM_INLINE tuple_12 process_model_four_along(tuple_12 start_, real a_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
{
    tuple_8 t1 = process_model_along(start_.v[0], a_, m_.v[0], r_.v[0], p_);
    tuple_8 t2 = process_model_along(start_.v[1], a_, m_.v[1], r_.v[1], p_);
    tuple_8 t3 = process_model_along(start_.v[2], a_, m_.v[2], r_.v[2], p_);
    tuple_8 t4 = process_model_along(start_.v[3], a_, m_.v[3], r_.v[3], p_);
    return (tuple_12){{t1, t2, t3, t4}};
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
{
    real moved1_;
    real moved2_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[((0 + j_))] = (m_.v[0].v[0] + moved1_);
    phi_.p[((6 + j_))] = (m_.v[0].v[4] + moved2_);
    phi_.p[((12 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[((18 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[((24 + j_))] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2(array1_f8 phi_, Stages stages_, array1_f8 p_)
{
    int64_t i_;
    if (stages_.first_) {
        for (int64_t k1 = 0; k1 < 6; k1 += 1) {
            i_ = k1;
            phi_.p[(((i_ * 6) + 1))] = (((i_ == 1)) ? (real)1.0 : (real)0.0);
        }
    }
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row_2(array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t count_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (6 - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((6 - count_) * 6) + j_), phi_.n[0])];
}

/* estimation/process_model.py:791 _begin */
GM_INLINE tuple_8 process_model_begin_2(int64_t n_, array1_f8 phi_, int64_t j_, bool first_)
{
    if (first_) {
        return (tuple_8){{(((j_ == 0)) ? (real)1.0 : (real)0.0), (((j_ == 2)) ? (real)1.0 : (real)0.0), (((j_ == 3)) ? (real)1.0 : (real)0.0), (((j_ == 4)) ? (real)1.0 : (real)0.0), (((j_ == 1)) ? (real)1.0 : (real)0.0)}};
    }
    return (tuple_8){{phi_.p[gm_at(((0 * n_) + j_), phi_.n[0])], phi_.p[gm_at(((2 * n_) + j_), phi_.n[0])], phi_.p[gm_at(((3 * n_) + j_), phi_.n[0])], phi_.p[gm_at(((4 * n_) + j_), phi_.n[0])], phi_.p[gm_at(((1 * n_) + j_), phi_.n[0])]}};
}

/* estimation/process_model.py:854 _source */
GM_INLINE real process_model_source(tuple_8 bend_, real memory_, int64_t own_)
{
    return ((((bend_.v[1] * memory_) + (((own_ == 2)) ? bend_.v[2] : (real)0.0)) + (((own_ == 3)) ? bend_.v[3] : (real)0.0)) + (((own_ == 4)) ? bend_.v[4] : (real)0.0));
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_2(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
{
    real moved1_;
    real moved2_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[gm_at((0 + j_), phi_.n[0])] = (m_.v[0].v[0] + moved1_);
    phi_.p[gm_at((6 + j_), phi_.n[0])] = (m_.v[0].v[4] + moved2_);
    phi_.p[gm_at((12 + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[gm_at((18 + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[gm_at((24 + j_), phi_.n[0])] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column(array1_f8 phi_, int64_t j_, Stages stages_, tuple_9 errors_, tuple_7 sources_, array1_f8 p_)
{
    tuple_9 slopes_;
    tuple_9 shares_;
    tuple_13 arms_;
    tuple_12 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_8 m1_;
    tuple_8 c1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_8 c2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_8 c3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_8 c4_;
    tuple_7 r4_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_2(phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_8 t3 = process_model_begin_2(6, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_8 t5 = process_model_bent((-1), bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(false, arms_.v[0], load_, m1_);
    tuple_7 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_8 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_8 t10 = process_model_bent((-1), bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(false, arms_.v[1], load_, m2_);
    tuple_7 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_8 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_8 t15 = process_model_bent((-1), bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(false, arms_.v[2], load_, m3_);
    tuple_7 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_8 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_8 t20 = process_model_bent((-1), bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(false, arms_.v[3], load_, m4_);
    tuple_7 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_2(phi_, j_, h_, (tuple_12){{m1_, m2_, m3_, m4_}}, (tuple_13){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:995 _columns_of_curve */
GM_INLINE void process_model_columns_of_curve(array1_f8 z_, array1_f8 phi_, real memory_, tuple_9 law_, Stages stages_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    tuple_9 none_;
    real width_;
    real end_;
    int64_t j_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    int64_t t2 = (6 - count_);
    at_ = t2;
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((count_ > 0))) {
        process_model_column(phi_, (at_ + 0), stages_, none_, (tuple_7){{(real)0.0, (real)0.0}}, p_);
    }
    if (((count_ > 1))) {
        process_model_column(phi_, (at_ + 1), stages_, none_, (tuple_7){{(real)0.0, (real)2.0}}, p_);
        process_model_column(phi_, (at_ + 2), stages_, none_, (tuple_7){{(real)0.0, (real)3.0}}, p_);
        process_model_column(phi_, (at_ + 3), stages_, none_, (tuple_7){{(real)0.0, (real)4.0}}, p_);
    }
    if (((count_ > 0))) {
        width_ = (gm_fabs(law_.v[2]) / law_.v[0]);
        tuple_7 t3 = transmission_play((z_.p[0] - z_.p[1]), memory_, width_);
        z_.p[gm_at((at_ + 0), z_.n[0])] = t3.v[0];
        end_ = t3.v[1];
        if (((end_ != (real)0.0))) {
            for (int64_t k4 = 0; k4 < 6; k4 += 1) {
                j_ = k4;
                phi_.p[gm_at((((at_ + 0) * 6) + j_), phi_.n[0])] = (phi_.p[((0 + j_))] - phi_.p[((6 + j_))]);
            }
            if (((count_ > 1))) {
                phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 1), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 1), phi_.n[0])] + ((end_ * width_) / law_.v[0]));
                phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 3), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 3), phi_.n[0])] - ((((law_.v[2] >= (real)0.0)) ? end_ : (-end_)) / law_.v[0]));
            }
        }
    }
    return;
}

/* estimation/process_model.py:883 rk4 */
GM_INLINE void process_model_rk4(array1_f8 z_, array1_f8 phi_, bool first_, tuple_7 torques_, real h_, array1_f8 p_)
{
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
    tuple_9 law_;
    real memory_;
    tuple_9 rows_;
    tuple_8 error_;
    tuple_12 m1_;
    real total_;
    tuple_8 bend1_;
    real slope1_;
    real share1_;
    tuple_7 arm1_;
    real f1_;
    real g1_;
    tuple_13 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_8 bend2_;
    real slope2_;
    real share2_;
    tuple_7 arm2_;
    real f2_;
    real g2_;
    tuple_12 m2_;
    tuple_13 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_8 bend3_;
    real slope3_;
    real share3_;
    tuple_7 arm3_;
    real f3_;
    real g3_;
    tuple_12 m3_;
    tuple_13 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_8 bend4_;
    real slope4_;
    real share4_;
    tuple_7 arm4_;
    real f4_;
    real g4_;
    tuple_12 m4_;
    tuple_13 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
    int64_t i_;
    int64_t j_;
    tuple_9 none_;
    tuple_8 fades_;
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
    int64_t t8 = process_model_curve_count((-1));
    at_curve_ = (6 - t8);
    tuple_9 t9 = process_model_curve((-1), z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory((-1), z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row(phi_, 0, first_);
    real t12 = process_model_memory_row(phi_, 2, first_);
    real t13 = process_model_memory_row(phi_, 3, first_);
    real t14 = process_model_memory_row(phi_, 4, first_);
    rows_ = (tuple_9){{t11, t12, t13, t14}};
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t15 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], half_, h_, p_);
        error_ = t15;
    }
    tuple_8 t16 = process_model_begin(6, phi_, 0, first_);
    tuple_8 t17 = process_model_begin(6, phi_, 2, first_);
    tuple_8 t18 = process_model_begin(6, phi_, 3, first_);
    tuple_8 t19 = process_model_begin(6, phi_, 4, first_);
    m1_ = (tuple_12){{t16, t17, t18, t19}};
    tuple_11 t20 = process_model_total((-1), (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t20.f0;
    bend1_ = t20.f1;
    tuple_7 t21 = process_model_slopes(false, x3_, total_, p_);
    slope1_ = t21.v[0];
    share1_ = t21.v[1];
    tuple_7 t22 = process_model_load_slopes(false, x2_, x4_, p_);
    arm1_ = t22;
    tuple_7 t23 = process_model_accelerations((tuple_8){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t23.v[0];
    g1_ = t23.v[1];
    tuple_12 t24 = process_model_four_bent((-1), bend1_, rows_, m1_);
    tuple_13 t25 = process_model_four_rates(false, t24, slope1_, share1_, arm1_, p_);
    r1_ = t25;
    real t26 = (x2_ + (half_ * x4_));
    real t27 = (x3_ + (half_ * f1_));
    real t28 = (x4_ + (half_ * g1_));
    y2_ = t26;
    y3_ = t27;
    y4_ = t28;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_11 t29 = process_model_total((-1), ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t29.f0;
    bend2_ = t29.f1;
    tuple_7 t30 = process_model_slopes(false, y3_, total_, p_);
    slope2_ = t30.v[0];
    share2_ = t30.v[1];
    tuple_7 t31 = process_model_load_slopes(false, y2_, y4_, p_);
    arm2_ = t31;
    tuple_7 t32 = process_model_accelerations((tuple_8){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t32.v[0];
    g2_ = t32.v[1];
    tuple_12 t33 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t33;
    tuple_12 t34 = process_model_four_bent((-1), bend2_, rows_, m2_);
    tuple_13 t35 = process_model_four_rates(false, t34, slope2_, share2_, arm2_, p_);
    r2_ = t35;
    real t36 = (x2_ + (half_ * y4_));
    real t37 = (x3_ + (half_ * f2_));
    real t38 = (x4_ + (half_ * g2_));
    v2_ = t36;
    v3_ = t37;
    v4_ = t38;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_11 t39 = process_model_total((-1), ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t39.f0;
    bend3_ = t39.f1;
    tuple_7 t40 = process_model_slopes(false, v3_, total_, p_);
    slope3_ = t40.v[0];
    share3_ = t40.v[1];
    tuple_7 t41 = process_model_load_slopes(false, v2_, v4_, p_);
    arm3_ = t41;
    tuple_7 t42 = process_model_accelerations((tuple_8){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t42.v[0];
    g3_ = t42.v[1];
    tuple_12 t43 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t43;
    tuple_12 t44 = process_model_four_bent((-1), bend3_, rows_, m3_);
    tuple_13 t45 = process_model_four_rates(false, t44, slope3_, share3_, arm3_, p_);
    r3_ = t45;
    real t46 = (x2_ + (h_ * v4_));
    real t47 = (x3_ + (h_ * f3_));
    real t48 = (x4_ + (h_ * g3_));
    w2_ = t46;
    w3_ = t47;
    w4_ = t48;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_11 t49 = process_model_total((-1), ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t49.f0;
    bend4_ = t49.f1;
    tuple_7 t50 = process_model_slopes(false, w3_, total_, p_);
    slope4_ = t50.v[0];
    share4_ = t50.v[1];
    tuple_7 t51 = process_model_load_slopes(false, w2_, w4_, p_);
    arm4_ = t51;
    tuple_7 t52 = process_model_accelerations((tuple_8){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t52.v[0];
    g4_ = t52.v[1];
    tuple_12 t53 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t53;
    tuple_12 t54 = process_model_four_bent((-1), bend4_, rows_, m4_);
    tuple_13 t55 = process_model_four_rates(false, t54, slope4_, share4_, arm4_, p_);
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
    process_model_end(phi_, 0, h_, (tuple_12){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_13){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_);
    process_model_end(phi_, 2, h_, (tuple_12){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_13){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_);
    process_model_end(phi_, 3, h_, (tuple_12){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_13){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_);
    process_model_end(phi_, 4, h_, (tuple_12){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_13){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_);
    stages_ = (Stages){(tuple_9){{slope1_, slope2_, slope3_, slope4_}}, (tuple_9){{share1_, share2_, share3_, share4_}}, (tuple_13){{arm1_, arm2_, arm3_, arm4_}}, (tuple_12){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2(phi_, stages_, p_);
    if (first_) {
        for (int64_t k58 = 5; k58 < 6; k58 += 1) {
            i_ = k58;
            for (int64_t k59 = 0; k59 < 6; k59 += 1) {
                j_ = k59;
                phi_.p[gm_at(((i_ * 6) + j_), phi_.n[0])] = (((i_ == j_)) ? (real)1.0 : (real)0.0);
            }
        }
    }
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        process_model_column(phi_, (int64_t)(p_.p[28]), stages_, none_, (tuple_7){{(real)1.0, (real)0.0}}, p_);
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        z_.p[gm_at(i_, z_.n[0])] = error_.v[4];
        tuple_8 t60 = process_model_decay(phi_.p[gm_at(((i_ * 6) + i_), phi_.n[0])], half_, h_, p_);
        fades_ = t60;
        process_model_column(phi_, i_, stages_, (tuple_9){{fades_.v[0], fades_.v[1], fades_.v[2], fades_.v[3]}}, (tuple_7){{(real)0.0, (real)0.0}}, p_);
        phi_.p[gm_at(((i_ * 6) + i_), phi_.n[0])] = fades_.v[4];
    }
    process_model_columns_of_curve(z_, phi_, memory_, law_, stages_, p_);
    return;
}

/* estimation/process_model.py:1018 propagate */
GM_INLINE void process_model_propagate(array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (((n_substeps_ > 1)) ? (dt_ / (real)(n_substeps_)) : dt_);
    process_model_rk4(z_, phi_, true, torques_, h_, p_);
    for (int64_t k1 = 1; k1 < n_substeps_; k1 += 1) {
        process_model_rk4(z_, phi_, false, torques_, h_, p_);
    }
    return;
}

/* kernels/linalg.py:49 _row */
GM_INLINE tuple_14 linalg_row(int64_t n_, int64_t unit_, array1_f8 a_, int64_t i_, array1_f8 b_)
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
    return (tuple_14){{s0_, s1_, s2_, s3_, s4_, s5_, s6_}};
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

/* kernels/linalg.py:100 carry */
GM_INLINE void linalg_carry(array1_f8 phi_, array1_f8 P_, array1_f8 half_, array1_f8 cross_, array1_f8 out_)
{
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
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        tuple_14 t2 = linalg_row(6, 1, phi_, i_, P_);
        s0_ = t2.v[0];
        s1_ = t2.v[1];
        s2_ = t2.v[2];
        s3_ = t2.v[3];
        s4_ = t2.v[4];
        s5_ = t2.v[5];
        s6_ = t2.v[6];
        at_ = (i_ * 6);
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
        cross_.p[((at_ + 5))] = s5_;
        s5_ = gm_fma(phi_.p[((at_ + 5))], half_.p[5], s5_);
        for (int64_t k11 = 0; k11 < 6; k11 += 1) {
            j_ = k11;
            at_ = (j_ * 6);
            value_ = (s0_ * phi_.p[(at_)]);
            if (((j_ == 1))) {
                value_ = gm_fma(s1_, phi_.p[((at_ + 1))], value_);
            }
            value_ = gm_fma(s4_, phi_.p[((at_ + 4))], gm_fma(s3_, phi_.p[((at_ + 3))], gm_fma(s2_, phi_.p[((at_ + 2))], value_)));
            value_ = gm_fma(s5_, phi_.p[((at_ + 5))], value_);
            linalg_mirrored(out_, 6, i_, j_, value_);
        }
    }
    return;
}

/* estimation/filters/ekf.py:56 predict */
GM_INLINE void ekf_predict(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
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
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    tuple_6 t1 = step_record_places(6);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    phi_ = (array1_f8){scratch_.matrices_.p + 0 * (scratch_.matrices_.n[1]), {scratch_.matrices_.n[1]}};
    int64_t t2 = (at_cross_ + 36);
    int64_t t3 = gm_bound(at_cross_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = (at_P_ + 36);
    int64_t t7 = gm_bound(at_P_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    cross_ = (array1_f8){record_.p + t3 * (1), {t5}};
    P_pred_ = (array1_f8){record_.p + t7 * (1), {t9}};
    for (int64_t k10 = 0; k10 < 6; k10 += 1) {
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
        real t16 = process_model_softened_sharpness(motor_, P_.p[14]);
        p_.p[5] = t16;
        real t17 = process_model_softened_sharpness(arm_, P_.p[21]);
        p_.p[15] = t17;
    }
    if (((p_.p[36] > (real)0.0))) {
        process_model_propagate_numeric(z_, phi_, (tuple_7){{reading_.u_, reading_.load_}}, dt_, counted_, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}});
    } else {
        process_model_propagate(z_, phi_, (tuple_7){{reading_.u_, reading_.load_}}, dt_, counted_, p_);
    }
    if (((p_.p[37] > (real)0.0))) {
        p_.p[5] = motor_;
        p_.p[15] = arm_;
    }
    int64_t t18 = (at_z_ + 6);
    int64_t t19 = gm_bound(at_z_, record_.n[0]);
    int64_t t20 = gm_bound(t18, record_.n[0]);
    int64_t t21 = gm_span(t19, t20);
    linalg_carry(phi_, P_, (array1_f8){record_.p + t19 * (1), {t21}}, cross_, P_pred_);
    for (int64_t k22 = 0; k22 < 6; k22 += 1) {
        i_ = k22;
        real t25 = P_pred_.p[(((i_ * 6) + i_))];
        real t24 = ((real)0.5 * dt_);
        real t23 = process_model_noise(z_, p_, i_);
        P_pred_.p[(((i_ * 6) + i_))] = (t25 + (t24 * t23));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    return;
}

/* estimation/filters/ekf.py:153 inverse */
GM_INLINE tuple_15 ekf_inverse(real s11_, real s12_, real s22_, real determinant_)
{
    real scale_;
    scale_ = ((real)1.0 / determinant_);
    return (tuple_15){{(s22_ * scale_), ((-s12_) * scale_), (s11_ * scale_)}};
}

/* estimation/filters/ekf.py:160 mahalanobis */
GM_INLINE real ekf_mahalanobis(real e1_, real e2_, real i11_, real i12_, real i22_)
{
    return ((e1_ * ((i11_ * e1_) + (i12_ * e2_))) + (e2_ * ((i12_ * e1_) + (i22_ * e2_))));
}

/* estimation/filters/ekf.py:169 joseph */
GM_INLINE tuple_9 ekf_joseph(int64_t i_, tuple_7 gain_, tuple_7 column_, tuple_15 prior_, tuple_7 r_)
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
    return (tuple_9){{a_, b_, ((gain_.v[0] * r_.v[0]) - t1_), ((gain_.v[1] * r_.v[1]) - t2_)}};
}

/* estimation/filters/ekf.py:191 joseph_element */
GM_INLINE real ekf_joseph_element(int64_t i_, real prior_, tuple_9 row_, tuple_7 column_j_, tuple_7 gain_)
{
    real predicted_;
    predicted_ = gm_fma(row_.v[1], column_j_.v[1], gm_fma(row_.v[0], column_j_.v[0], (((i_ > 1)) ? prior_ : (real)(-0.0))));
    return gm_fma(row_.v[3], gain_.v[1], gm_fma(row_.v[2], gain_.v[0], predicted_));
}

/* estimation/filters/ekf.py:88 update */
GM_INLINE bool ekf_update(Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
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
    tuple_9 row_;
    int64_t j_;
    real value_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_6 t1 = step_record_places(6);
    at_prior_ = t1.v[1];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    at_K_ = t1.v[7];
    at_scores_ = t1.v[8];
    int64_t t2 = (at_prior_ + 36);
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
    real t12 = (prior_.p[7] + r2_);
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
        tuple_15 t13 = ekf_inverse(s11_, s12_, s22_, determinant_);
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
    for (int64_t k15 = 0; k15 < 6; k15 += 1) {
        i_ = k15;
        real t16 = prior_.p[((i_ * 6))];
        real t17 = prior_.p[(((i_ * 6) + 1))];
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
        tuple_9 t20 = ekf_joseph(i_, (tuple_7){{k1_, k2_}}, (tuple_7){{c1_, c2_}}, (tuple_15){{prior_.p[0], prior_.p[1], prior_.p[7]}}, (tuple_7){{r1_, r2_}});
        row_ = t20;
        int64_t t21 = (i_ + 1);
        for (int64_t k22 = 0; k22 < t21; k22 += 1) {
            j_ = k22;
            real t23 = ekf_joseph_element(i_, prior_.p[(((i_ * 6) + j_))], row_, (tuple_7){{prior_.p[(j_)], prior_.p[((6 + j_))]}}, (tuple_7){{record_.p[((at_K_ + (2 * j_)))], record_.p[(((at_K_ + (2 * j_)) + 1))]}});
            value_ = t23;
            P_.p[(((i_ * 6) + j_))] = value_;
            P_.p[(((j_ * 6) + i_))] = value_;
            record_.p[(((at_P_ + (i_ * 6)) + j_))] = value_;
            record_.p[(((at_P_ + (j_ * 6)) + i_))] = value_;
        }
    }
    return true;
}

/* estimation/process_model.py:356 bound_curve */
GM_INLINE void process_model_bound_curve(array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    if (((count_ > 1))) {
        at_ = (6 - count_);
        z_.p[gm_at((at_ + 1), z_.n[0])] = gm_min_f(gm_max_f(z_.p[gm_at((at_ + 1), z_.n[0])], (p_.p[9] / (real)10.0)), (p_.p[9] * (real)10.0));
        z_.p[gm_at((at_ + 2), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 2), z_.n[0])], (real)0.0);
        if (((p_.p[12] > (real)0.0))) {
            z_.p[gm_at((at_ + 3), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 3), z_.n[0])], (real)0.0);
        }
    }
    return;
}

/* estimation/filters/ekf.py:208 healthy */
GM_INLINE bool ekf_healthy(Belief belief_)
{
    array1_f8 z_;
    array1_f8 P_;
    int64_t i_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        if ((!(((bool)isfinite(z_.p[(i_)]) && ((P_.p[(((i_ * 6) + i_))] > (real)0.0))) && (bool)isfinite(P_.p[(((i_ * 6) + i_))])))) {
            return false;
        }
    }
    return true;
}

/* estimation/filters/ekf.py:30 step */
GM_APART bool ekf_step(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    ekf_predict(belief_, reading_, p_, scratch_, record_);
    bool t1 = ekf_update(belief_, reading_.y1_, reading_.y2_, p_, record_);
    if ((!t1)) {
        return false;
    }
    process_model_bound_curve(belief_.z_, p_);
    bool t2 = ekf_healthy(belief_);
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
GM_INLINE void aekf_add_noise(array1_f8 z_, BeliefSensitivity sensitivity_, real half_, array1_f8 current_, array1_f8 p_)
{
    array2_f8 s_;
    array2_f8 P_s_;
    int64_t count_;
    int64_t i_;
    real q_;
    int64_t at_;
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    for (int64_t k1 = 0; k1 < count_; k1 += 1) {
        i_ = k1;
        q_ = ((((real)2.0 * current_.p[35]) * z_.p[2]) * s_.p[((i_) * s_.n[1] + 2)]);
        if (((p_.p[((46 + i_))] == (real)56.0))) {
            q_ = (q_ + current_.p[56]);
        }
        P_s_.p[((i_) * P_s_.n[1] + 28)] = (P_s_.p[((i_) * P_s_.n[1] + 28)] + (half_ * q_));
        at_ = ((int64_t)(p_.p[((46 + i_))]) - 52);
        if ((((0 <= at_) && (at_ < 6)) && ((at_ != 4)))) {
            P_s_.p[((i_) * P_s_.n[1] + gm_at(((at_ * 6) + at_), P_s_.n[1]))] = (P_s_.p[((i_) * P_s_.n[1] + gm_at(((at_ * 6) + at_), P_s_.n[1]))] + (half_ * current_.p[gm_at((52 + at_), current_.n[0])]));
        }
    }
    return;
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_3(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_, array2_f8 trace_)
{
    real moved1_;
    real moved2_;
    int64_t q_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[((0 + j_))] = (m_.v[0].v[0] + moved1_);
    phi_.p[((6 + j_))] = (m_.v[0].v[4] + moved2_);
    phi_.p[((12 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[((18 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[((24 + j_))] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
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
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2_2(array1_f8 phi_, Stages stages_, array1_f8 p_, array2_f8 trace_)
{
    int64_t i_;
    int64_t q_;
    if (stages_.first_) {
        for (int64_t k1 = 0; k1 < 6; k1 += 1) {
            i_ = k1;
            phi_.p[(((i_ * 6) + 1))] = (((i_ == 1)) ? (real)1.0 : (real)0.0);
        }
    }
    for (int64_t k2 = 0; k2 < 12; k2 += 1) {
        q_ = k2;
        trace_.p[((q_) * trace_.n[1] + 1)] = (real)0.0;
    }
    return;
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_4(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_, array2_f8 trace_)
{
    real moved1_;
    real moved2_;
    int64_t q_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[gm_at((0 + j_), phi_.n[0])] = (m_.v[0].v[0] + moved1_);
    phi_.p[gm_at((6 + j_), phi_.n[0])] = (m_.v[0].v[4] + moved2_);
    phi_.p[gm_at((12 + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[gm_at((18 + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[gm_at((24 + j_), phi_.n[0])] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
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
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_2(array1_f8 phi_, int64_t j_, Stages stages_, tuple_9 errors_, tuple_7 sources_, array1_f8 p_, array2_f8 trace_)
{
    tuple_9 slopes_;
    tuple_9 shares_;
    tuple_13 arms_;
    tuple_12 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_8 m1_;
    tuple_8 c1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_8 c2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_8 c3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_8 c4_;
    tuple_7 r4_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_2(phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_8 t3 = process_model_begin_2(6, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_8 t5 = process_model_bent((-1), bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(false, arms_.v[0], load_, m1_);
    tuple_7 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_8 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_8 t10 = process_model_bent((-1), bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(false, arms_.v[1], load_, m2_);
    tuple_7 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_8 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_8 t15 = process_model_bent((-1), bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(false, arms_.v[2], load_, m3_);
    tuple_7 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_8 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_8 t20 = process_model_bent((-1), bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(false, arms_.v[3], load_, m4_);
    tuple_7 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_4(phi_, j_, h_, (tuple_12){{m1_, m2_, m3_, m4_}}, (tuple_13){{r1_, r2_, r3_, r4_}}, p_, trace_);
    return;
}

/* estimation/process_model.py:995 _columns_of_curve */
GM_INLINE void process_model_columns_of_curve_2(array1_f8 z_, array1_f8 phi_, real memory_, tuple_9 law_, Stages stages_, array1_f8 p_, array2_f8 trace_)
{
    int64_t count_;
    int64_t at_;
    tuple_9 none_;
    real width_;
    real end_;
    int64_t j_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    int64_t t2 = (6 - count_);
    at_ = t2;
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((count_ > 0))) {
        process_model_column_2(phi_, (at_ + 0), stages_, none_, (tuple_7){{(real)0.0, (real)0.0}}, p_, trace_);
    }
    if (((count_ > 1))) {
        process_model_column_2(phi_, (at_ + 1), stages_, none_, (tuple_7){{(real)0.0, (real)2.0}}, p_, trace_);
        process_model_column_2(phi_, (at_ + 2), stages_, none_, (tuple_7){{(real)0.0, (real)3.0}}, p_, trace_);
        process_model_column_2(phi_, (at_ + 3), stages_, none_, (tuple_7){{(real)0.0, (real)4.0}}, p_, trace_);
    }
    if (((count_ > 0))) {
        width_ = (gm_fabs(law_.v[2]) / law_.v[0]);
        tuple_7 t3 = transmission_play((z_.p[0] - z_.p[1]), memory_, width_);
        z_.p[gm_at((at_ + 0), z_.n[0])] = t3.v[0];
        end_ = t3.v[1];
        if (((end_ != (real)0.0))) {
            for (int64_t k4 = 0; k4 < 6; k4 += 1) {
                j_ = k4;
                phi_.p[gm_at((((at_ + 0) * 6) + j_), phi_.n[0])] = (phi_.p[((0 + j_))] - phi_.p[((6 + j_))]);
            }
            if (((count_ > 1))) {
                phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 1), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 1), phi_.n[0])] + ((end_ * width_) / law_.v[0]));
                phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 3), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 3), phi_.n[0])] - ((((law_.v[2] >= (real)0.0)) ? end_ : (-end_)) / law_.v[0]));
            }
        }
    }
    return;
}

/* estimation/process_model.py:883 rk4 */
GM_INLINE void process_model_rk4_2(array1_f8 z_, array1_f8 phi_, bool first_, tuple_7 torques_, real h_, array1_f8 p_, array2_f8 trace_)
{
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
    tuple_9 law_;
    real memory_;
    tuple_9 rows_;
    tuple_8 error_;
    tuple_12 m1_;
    real total_;
    tuple_8 bend1_;
    real slope1_;
    real share1_;
    tuple_7 arm1_;
    real f1_;
    real g1_;
    tuple_13 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_8 bend2_;
    real slope2_;
    real share2_;
    tuple_7 arm2_;
    real f2_;
    real g2_;
    tuple_12 m2_;
    tuple_13 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_8 bend3_;
    real slope3_;
    real share3_;
    tuple_7 arm3_;
    real f3_;
    real g3_;
    tuple_12 m3_;
    tuple_13 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_8 bend4_;
    real slope4_;
    real share4_;
    tuple_7 arm4_;
    real f4_;
    real g4_;
    tuple_12 m4_;
    tuple_13 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
    int64_t i_;
    int64_t j_;
    tuple_9 none_;
    tuple_8 fades_;
    int64_t q_;
    real value_;
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
    int64_t t8 = process_model_curve_count((-1));
    at_curve_ = (6 - t8);
    tuple_9 t9 = process_model_curve((-1), z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory((-1), z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row(phi_, 0, first_);
    real t12 = process_model_memory_row(phi_, 2, first_);
    real t13 = process_model_memory_row(phi_, 3, first_);
    real t14 = process_model_memory_row(phi_, 4, first_);
    rows_ = (tuple_9){{t11, t12, t13, t14}};
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t15 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], half_, h_, p_);
        error_ = t15;
    }
    tuple_8 t16 = process_model_begin(6, phi_, 0, first_);
    tuple_8 t17 = process_model_begin(6, phi_, 2, first_);
    tuple_8 t18 = process_model_begin(6, phi_, 3, first_);
    tuple_8 t19 = process_model_begin(6, phi_, 4, first_);
    m1_ = (tuple_12){{t16, t17, t18, t19}};
    tuple_11 t20 = process_model_total((-1), (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t20.f0;
    bend1_ = t20.f1;
    tuple_7 t21 = process_model_slopes(false, x3_, total_, p_);
    slope1_ = t21.v[0];
    share1_ = t21.v[1];
    tuple_7 t22 = process_model_load_slopes(false, x2_, x4_, p_);
    arm1_ = t22;
    tuple_7 t23 = process_model_accelerations((tuple_8){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t23.v[0];
    g1_ = t23.v[1];
    tuple_12 t24 = process_model_four_bent((-1), bend1_, rows_, m1_);
    tuple_13 t25 = process_model_four_rates(false, t24, slope1_, share1_, arm1_, p_);
    r1_ = t25;
    real t26 = (x2_ + (half_ * x4_));
    real t27 = (x3_ + (half_ * f1_));
    real t28 = (x4_ + (half_ * g1_));
    y2_ = t26;
    y3_ = t27;
    y4_ = t28;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_11 t29 = process_model_total((-1), ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t29.f0;
    bend2_ = t29.f1;
    tuple_7 t30 = process_model_slopes(false, y3_, total_, p_);
    slope2_ = t30.v[0];
    share2_ = t30.v[1];
    tuple_7 t31 = process_model_load_slopes(false, y2_, y4_, p_);
    arm2_ = t31;
    tuple_7 t32 = process_model_accelerations((tuple_8){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t32.v[0];
    g2_ = t32.v[1];
    tuple_12 t33 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t33;
    tuple_12 t34 = process_model_four_bent((-1), bend2_, rows_, m2_);
    tuple_13 t35 = process_model_four_rates(false, t34, slope2_, share2_, arm2_, p_);
    r2_ = t35;
    real t36 = (x2_ + (half_ * y4_));
    real t37 = (x3_ + (half_ * f2_));
    real t38 = (x4_ + (half_ * g2_));
    v2_ = t36;
    v3_ = t37;
    v4_ = t38;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_11 t39 = process_model_total((-1), ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t39.f0;
    bend3_ = t39.f1;
    tuple_7 t40 = process_model_slopes(false, v3_, total_, p_);
    slope3_ = t40.v[0];
    share3_ = t40.v[1];
    tuple_7 t41 = process_model_load_slopes(false, v2_, v4_, p_);
    arm3_ = t41;
    tuple_7 t42 = process_model_accelerations((tuple_8){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t42.v[0];
    g3_ = t42.v[1];
    tuple_12 t43 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t43;
    tuple_12 t44 = process_model_four_bent((-1), bend3_, rows_, m3_);
    tuple_13 t45 = process_model_four_rates(false, t44, slope3_, share3_, arm3_, p_);
    r3_ = t45;
    real t46 = (x2_ + (h_ * v4_));
    real t47 = (x3_ + (h_ * f3_));
    real t48 = (x4_ + (h_ * g3_));
    w2_ = t46;
    w3_ = t47;
    w4_ = t48;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_11 t49 = process_model_total((-1), ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t49.f0;
    bend4_ = t49.f1;
    tuple_7 t50 = process_model_slopes(false, w3_, total_, p_);
    slope4_ = t50.v[0];
    share4_ = t50.v[1];
    tuple_7 t51 = process_model_load_slopes(false, w2_, w4_, p_);
    arm4_ = t51;
    tuple_7 t52 = process_model_accelerations((tuple_8){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t52.v[0];
    g4_ = t52.v[1];
    tuple_12 t53 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t53;
    tuple_12 t54 = process_model_four_bent((-1), bend4_, rows_, m4_);
    tuple_13 t55 = process_model_four_rates(false, t54, slope4_, share4_, arm4_, p_);
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
    process_model_end_3(phi_, 0, h_, (tuple_12){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_13){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_, trace_);
    process_model_end_3(phi_, 2, h_, (tuple_12){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_13){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_, trace_);
    process_model_end_3(phi_, 3, h_, (tuple_12){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_13){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_, trace_);
    process_model_end_3(phi_, 4, h_, (tuple_12){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_13){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_, trace_);
    stages_ = (Stages){(tuple_9){{slope1_, slope2_, slope3_, slope4_}}, (tuple_9){{share1_, share2_, share3_, share4_}}, (tuple_13){{arm1_, arm2_, arm3_, arm4_}}, (tuple_12){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2_2(phi_, stages_, p_, trace_);
    if (first_) {
        for (int64_t k58 = 5; k58 < 6; k58 += 1) {
            i_ = k58;
            for (int64_t k59 = 0; k59 < 6; k59 += 1) {
                j_ = k59;
                phi_.p[gm_at(((i_ * 6) + j_), phi_.n[0])] = (((i_ == j_)) ? (real)1.0 : (real)0.0);
            }
        }
    }
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        process_model_column_2(phi_, (int64_t)(p_.p[28]), stages_, none_, (tuple_7){{(real)1.0, (real)0.0}}, p_, trace_);
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        z_.p[gm_at(i_, z_.n[0])] = error_.v[4];
        tuple_8 t60 = process_model_decay(phi_.p[gm_at(((i_ * 6) + i_), phi_.n[0])], half_, h_, p_);
        fades_ = t60;
        process_model_column_2(phi_, i_, stages_, (tuple_9){{fades_.v[0], fades_.v[1], fades_.v[2], fades_.v[3]}}, (tuple_7){{(real)0.0, (real)0.0}}, p_, trace_);
        phi_.p[gm_at(((i_ * 6) + i_), phi_.n[0])] = fades_.v[4];
    }
    process_model_columns_of_curve_2(z_, phi_, memory_, law_, stages_, p_, trace_);
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

/* kernels/linalg.py:49 _row */
GM_INLINE tuple_14 linalg_row_2(int64_t n_, int64_t unit_, array1_f8 a_, int64_t i_, array1_f8 b_)
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
    return (tuple_14){{s0_, s1_, s2_, s3_, s4_, s5_, s6_}};
}

/* kernels/linalg.py:22 multiply */
GM_INLINE void linalg_multiply(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t i_;
    real s0_;
    real s1_;
    real s2_;
    real s3_;
    real s4_;
    real s5_;
    real s6_;
    int64_t at_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        tuple_14 t2 = linalg_row_2(6, (-1), a_, i_, b_);
        s0_ = t2.v[0];
        s1_ = t2.v[1];
        s2_ = t2.v[2];
        s3_ = t2.v[3];
        s4_ = t2.v[4];
        s5_ = t2.v[5];
        s6_ = t2.v[6];
        at_ = (i_ * 6);
        out_.p[(at_)] = s0_;
        out_.p[((at_ + 1))] = s1_;
        out_.p[((at_ + 2))] = s2_;
        out_.p[((at_ + 3))] = s3_;
        out_.p[((at_ + 4))] = s4_;
        out_.p[((at_ + 5))] = s5_;
    }
    return;
}

/* kernels/linalg.py:73 multiply_symmetric */
GM_INLINE void linalg_multiply_symmetric(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
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
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        s0_ = (real)0.0;
        s1_ = (real)0.0;
        s2_ = (real)0.0;
        s3_ = (real)0.0;
        s4_ = (real)0.0;
        s5_ = (real)0.0;
        s6_ = (real)0.0;
        for (int64_t k2 = 0; k2 < 6; k2 += 1) {
            k_ = k2;
            v_ = a_.p[(((i_ * 6) + k_))];
            s0_ = gm_fma(v_, b_.p[(k_)], s0_);
            s1_ = gm_fma(v_, b_.p[((6 + k_))], s1_);
            s2_ = gm_fma(v_, b_.p[((12 + k_))], s2_);
            s3_ = gm_fma(v_, b_.p[((18 + k_))], s3_);
            s4_ = gm_fma(v_, b_.p[((24 + k_))], s4_);
            s5_ = gm_fma(v_, b_.p[((30 + k_))], s5_);
        }
        linalg_mirrored(out_, 6, i_, 0, s0_);
        linalg_mirrored(out_, 6, i_, 1, s1_);
        linalg_mirrored(out_, 6, i_, 2, s2_);
        linalg_mirrored(out_, 6, i_, 3, s3_);
        linalg_mirrored(out_, 6, i_, 4, s4_);
        linalg_mirrored(out_, 6, i_, 5, s5_);
        linalg_mirrored(out_, 6, i_, 6, s6_);
    }
    return;
}

/* estimation/filters/aekf.py:315 _arm */
GM_INLINE tuple_7 aekf_arm(bool loaded_, int64_t q_, array2_f8 vectors_)
{
    if ((!loaded_)) {
        return (tuple_7){{(real)0.0, (real)0.0}};
    }
    return (tuple_7){{vectors_.p[((vectors_.n[0] - 2) * vectors_.n[1] + (q_))], vectors_.p[((vectors_.n[0] - 1) * vectors_.n[1] + (q_))]}};
}

/* estimation/filters/aekf.py:323 _apply */
GM_INLINE tuple_8 aekf_apply(bool loaded_, tuple_8 v_, int64_t stage_, array1_f8 current_, array2_f8 vectors_)
{
    tuple_8 m_;
    real load_;
    tuple_7 r_;
    m_ = (tuple_8){{v_.v[0], v_.v[2], v_.v[3], v_.v[4], v_.v[1]}};
    tuple_7 t1 = aekf_arm(loaded_, stage_, vectors_);
    real t2 = process_model_answer(loaded_, t1, (real)0.0, m_);
    load_ = t2;
    tuple_7 t3 = process_model_rates(m_, vectors_.p[(15 * vectors_.n[1] + (stage_))], vectors_.p[(16 * vectors_.n[1] + (stage_))], (real)0.0, load_, current_);
    r_ = t3;
    return (tuple_8){{v_.v[2], v_.v[3], r_.v[0], r_.v[1], (current_.p[26] * (v_.v[2] - v_.v[3]))}};
}

/* estimation/filters/aekf.py:354 _sum */
GM_INLINE tuple_8 aekf_sum(real a_, tuple_8 v_, real b_, tuple_8 w_)
{
    return (tuple_8){{((a_ * v_.v[0]) + (b_ * w_.v[0])), ((a_ * v_.v[1]) + (b_ * w_.v[1])), ((a_ * v_.v[2]) + (b_ * w_.v[2])), ((a_ * v_.v[3]) + (b_ * w_.v[3])), ((a_ * v_.v[4]) + (b_ * w_.v[4]))}};
}

/* estimation/filters/aekf.py:360 _write */
GM_INLINE void aekf_write(array1_f8 row_, tuple_8 v_, int64_t n_)
{
    int64_t j_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        j_ = k1;
        row_.p[(j_)] = (((j_ < 5)) ? v_.v[(j_)] : (real)0.0);
    }
    return;
}

/* estimation/filters/aekf.py:366 _answers */
GM_INLINE void aekf_answers(tuple_8 unit_, int64_t g_, real h_, array1_f8 current_, array2_f8 vectors_)
{
    tuple_8 a3_;
    tuple_8 a2_;
    tuple_8 a32_;
    tuple_8 end_;
    tuple_8 a1_;
    tuple_8 a21_;
    tuple_8 a321_;
    tuple_8 t1 = aekf_apply(false, unit_, 3, current_, vectors_);
    a3_ = t1;
    tuple_8 t2 = aekf_sum((h_ / (real)3.0), unit_, ((h_ * h_) / (real)6.0), a3_);
    aekf_write((array1_f8){vectors_.p + ((g_ + 2)) * (vectors_.n[1]), {vectors_.n[1]}}, t2, 6);
    tuple_8 t3 = aekf_apply(false, unit_, 2, current_, vectors_);
    a2_ = t3;
    tuple_8 t4 = aekf_apply(false, a2_, 3, current_, vectors_);
    a32_ = t4;
    tuple_8 t5 = aekf_sum((h_ / (real)3.0), a2_, ((h_ * h_) / (real)6.0), a32_);
    end_ = t5;
    tuple_8 t6 = aekf_sum((h_ / (real)3.0), unit_, ((real)0.5 * h_), end_);
    aekf_write((array1_f8){vectors_.p + ((g_ + 1)) * (vectors_.n[1]), {vectors_.n[1]}}, t6, 6);
    tuple_8 t7 = aekf_apply(false, unit_, 1, current_, vectors_);
    a1_ = t7;
    tuple_8 t8 = aekf_apply(false, a1_, 2, current_, vectors_);
    a21_ = t8;
    tuple_8 t9 = aekf_apply(false, a21_, 3, current_, vectors_);
    a321_ = t9;
    tuple_8 t10 = aekf_sum((h_ / (real)3.0), a21_, ((h_ * h_) / (real)6.0), a321_);
    end_ = t10;
    tuple_8 t11 = aekf_sum((h_ / (real)3.0), a1_, ((real)0.5 * h_), end_);
    end_ = t11;
    tuple_8 t12 = aekf_sum((h_ / (real)6.0), unit_, ((real)0.5 * h_), end_);
    aekf_write((array1_f8){vectors_.p + (g_) * (vectors_.n[1]), {vectors_.n[1]}}, t12, 6);
    return;
}

/* estimation/filters/aekf.py:534 _times */
GM_INLINE void aekf_times(array1_f8 product_, int64_t source_, array1_f8 flat_, int64_t out_)
{
    int64_t a_;
    real v0_;
    real v1_;
    real v2_;
    real v3_;
    int64_t b_;
    real v_;
    int64_t at_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        a_ = k1;
        v0_ = (real)0.0;
        v1_ = (real)0.0;
        v2_ = (real)0.0;
        v3_ = (real)0.0;
        for (int64_t k2 = 0; k2 < 6; k2 += 1) {
            b_ = k2;
            real t3 = product_.p[(((a_ * 6) + b_))];
            int64_t t4 = ((source_ * 6) + b_);
            v_ = t3;
            at_ = t4;
            real t5 = gm_fma(v_, flat_.p[(at_)], v0_);
            real t6 = gm_fma(v_, flat_.p[((at_ + 6))], v1_);
            v0_ = t5;
            v1_ = t6;
            real t7 = gm_fma(v_, flat_.p[((at_ + 12))], v2_);
            real t8 = gm_fma(v_, flat_.p[((at_ + 18))], v3_);
            v2_ = t7;
            v3_ = t8;
        }
        at_ = ((out_ * 6) + a_);
        real t9 = v0_;
        real t10 = v1_;
        real t11 = v2_;
        real t12 = v3_;
        flat_.p[(at_)] = t9;
        flat_.p[((at_ + 6))] = t10;
        flat_.p[((at_ + 12))] = t11;
        flat_.p[((at_ + 18))] = t12;
    }
    return;
}

/* estimation/filters/aekf.py:389 _sensitivity_rates */
GM_INLINE tuple_7 aekf_sensitivity_rates(bool loaded_, tuple_8 m_, int64_t q_, tuple_16 theta_, real error_, real load_, array1_f8 current_, array2_f8 vectors_)
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
    tuple_7 t1 = aekf_arm(loaded_, q_, vectors_);
    real t2 = process_model_answer(loaded_, t1, load_, m_);
    tuple_7 t6 = process_model_rates(m_, t3, t4, t5, t2, current_);
    return t6;
}

/* estimation/filters/aekf.py:458 _added */
GM_INLINE tuple_8 aekf_added(tuple_8 m_, real torque_)
{
    return (tuple_8){{m_.v[0], m_.v[1], m_.v[2], (m_.v[3] + torque_), m_.v[4]}};
}

/* estimation/filters/aekf.py:423 _advance_sensitivity */
GM_INLINE void aekf_advance_sensitivity(array1_f8 s_, tuple_16 theta_, real h_, array1_f8 current_, array2_f8 vectors_)
{
    int64_t slot_;
    real half_;
    real sixth_;
    tuple_8 error_;
    real load_;
    tuple_9 twist_;
    tuple_8 m1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_7 r4_;
    real moved1_;
    real moved2_;
    slot_ = theta_.f0;
    real t1 = ((real)0.5 * h_);
    real t2 = (h_ / (real)6.0);
    half_ = t1;
    sixth_ = t2;
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    load_ = (real)0.0;
    if (((current_.p[28] > (real)0.0))) {
        load_ = s_.p[gm_at((int64_t)(current_.p[28]), s_.n[0])];
    }
    if (((current_.p[29] > (real)0.0))) {
        tuple_8 t3 = process_model_decay(s_.p[gm_at((int64_t)(current_.p[29]), s_.n[0])], half_, h_, current_);
        error_ = t3;
        s_.p[gm_at((int64_t)(current_.p[29]), s_.n[0])] = error_.v[4];
    }
    twist_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((slot_ == 26))) {
        twist_ = (tuple_9){{(current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 0)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 1)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 2)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 3)])}};
    }
    m1_ = (tuple_8){{s_.p[0], s_.p[2], s_.p[3], s_.p[4], s_.p[1]}};
    tuple_7 t4 = aekf_sensitivity_rates(false, m1_, 0, theta_, error_.v[0], load_, current_, vectors_);
    r1_ = t4;
    tuple_8 t5 = process_model_along(m1_, half_, m1_, r1_, current_);
    tuple_8 t6 = aekf_added(t5, (half_ * twist_.v[0]));
    m2_ = t6;
    tuple_7 t7 = aekf_sensitivity_rates(false, m2_, 1, theta_, error_.v[1], load_, current_, vectors_);
    r2_ = t7;
    tuple_8 t8 = process_model_along(m1_, half_, m2_, r2_, current_);
    tuple_8 t9 = aekf_added(t8, (half_ * twist_.v[1]));
    m3_ = t9;
    tuple_7 t10 = aekf_sensitivity_rates(false, m3_, 2, theta_, error_.v[2], load_, current_, vectors_);
    r3_ = t10;
    tuple_8 t11 = process_model_along(m1_, h_, m3_, r3_, current_);
    tuple_8 t12 = aekf_added(t11, (h_ * twist_.v[2]));
    m4_ = t12;
    tuple_7 t13 = aekf_sensitivity_rates(false, m4_, 3, theta_, error_.v[3], load_, current_, vectors_);
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
GM_INLINE void aekf_add_products(array1_f8 P_i_, real factor_, int64_t at_, real h_, int64_t g_, int64_t w_, array1_f8 flat_)
{
    int64_t a_;
    int64_t b_;
    real total_;
    int64_t q_;
    real value_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        a_ = k1;
        int64_t t2 = (a_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            b_ = k3;
            total_ = (real)0.0;
            for (int64_t k4 = 0; k4 < 3; k4 += 1) {
                q_ = k4;
                total_ = gm_fma(flat_.p[((((g_ + q_) * 6) + a_))], flat_.p[((((w_ + q_) * 6) + b_))], total_);
                total_ = gm_fma(flat_.p[((((w_ + q_) * 6) + a_))], flat_.p[((((g_ + q_) * 6) + b_))], total_);
            }
            if (((a_ == at_))) {
                total_ = (total_ + ((h_ / (real)6.0) * flat_.p[((((w_ + 3) * 6) + b_))]));
            }
            if (((b_ == at_))) {
                total_ = (total_ + ((h_ / (real)6.0) * flat_.p[((((w_ + 3) * 6) + a_))]));
            }
            value_ = (P_i_.p[(((a_ * 6) + b_))] + (factor_ * total_));
            P_i_.p[(((a_ * 6) + b_))] = value_;
            P_i_.p[(((b_ * 6) + a_))] = value_;
        }
    }
    return;
}

/* estimation/filters/aekf.py:548 _advance_covariance */
GM_INLINE void aekf_advance_covariance(array1_f8 P_i_, int64_t slot_, real h_, array1_f8 current_, array2_f8 vectors_, array1_f8 flat_)
{
    int64_t q_;
    real c_;
    real d_;
    int64_t a_;
    real w_;
    for (int64_t k1 = 0; k1 < 4; k1 += 1) {
        q_ = k1;
        real t2 = vectors_.p[(24 * vectors_.n[1] + (q_))];
        real t3 = vectors_.p[(25 * vectors_.n[1] + (q_))];
        c_ = t2;
        d_ = t3;
        for (int64_t k4 = 0; k4 < 6; k4 += 1) {
            a_ = k4;
            w_ = (c_ * flat_.p[((((30 + q_) * 6) + a_))]);
            if (((current_.p[19] > (real)0.0))) {
                w_ = (w_ + (d_ * flat_.p[((((34 + q_) * 6) + a_))]));
            }
            flat_.p[((((46 + q_) * 6) + a_))] = w_;
        }
    }
    aekf_add_products(P_i_, (real)1.0, 2, h_, 26, 46, flat_);
    if (((slot_ == 26))) {
        aekf_add_products(P_i_, current_.p[26], 4, h_, 38, 42, flat_);
    }
    return;
}

/* estimation/filters/aekf.py:463 _predict */
GM_INLINE void aekf_predict(Belief belief_, BeliefSensitivity sensitivity_, Reading reading_, array1_f8 current_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    tuple_7 torques_;
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
    tuple_7 sharper_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    torques_ = (tuple_7){{reading_.u_, reading_.load_}};
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    vectors_ = scratch_.vectors_;
    matrices_ = scratch_.matrices_;
    tuple_6 t1 = step_record_places(6);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    product_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    change_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    phi_ = (array1_f8){matrices_.p + 2 * (matrices_.n[1]), {matrices_.n[1]}};
    int64_t t2 = (at_cross_ + 36);
    int64_t t3 = gm_bound(at_cross_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = (at_P_ + 36);
    int64_t t7 = gm_bound(at_P_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    cross_ = (array1_f8){record_.p + t3 * (1), {t5}};
    P_pred_ = (array1_f8){record_.p + t7 * (1), {t9}};
    flat_ = (array1_f8){vectors_.p, {570}};
    with_twist_ = false;
    with_atan_ = false;
    with_viscous_ = false;
    for (int64_t k10 = 0; k10 < count_; k10 += 1) {
        i_ = k10;
        with_twist_ = (with_twist_ | ((p_.p[((46 + i_))] == (real)26.0)));
        with_atan_ = (with_atan_ | ((p_.p[((46 + i_))] == (real)4.0)));
        with_viscous_ = (with_viscous_ | ((p_.p[((46 + i_))] == (real)3.0)));
    }
    stiffer_ = ((with_twist_ || with_atan_) || with_viscous_);
    real t12;
    if (stiffer_) {
    real t11 = aekf_eigenvalue(current_, p_);
        t12 = t11;
    } else {
        t12 = p_.p[30];
    }
    int64_t t13 = drive_substeps(dt_, t12);
    counted_ = t13;
    h_ = (dt_ / (real)(counted_));
    half_ = ((real)0.5 * dt_);
    real t14 = current_.p[5];
    real t15 = current_.p[15];
    motor_ = t14;
    arm_ = t15;
    if (((p_.p[37] > (real)0.0))) {
        real t16 = process_model_softened_sharpness(motor_, P_.p[14]);
        current_.p[5] = t16;
        real t17 = process_model_softened_sharpness(arm_, P_.p[21]);
        current_.p[15] = t17;
        for (int64_t k18 = 0; k18 < count_; k18 += 1) {
            i_ = k18;
            row_ = (array1_f8){vectors_.p + ((78 + i_)) * (vectors_.n[1]), {vectors_.n[1]}};
            row_.p[0] = ((((-current_.p[5]) * current_.p[5]) / (real)3.141592653589793) * P_s_.p[((i_) * P_s_.n[1] + 14)]);
            row_.p[1] = ((((-current_.p[15]) * current_.p[15]) / (real)3.141592653589793) * P_s_.p[((i_) * P_s_.n[1] + 21)]);
        }
    }
    aekf_add_noise(z_, sensitivity_, half_, current_, p_);
    for (int64_t k19 = 0; k19 < 6; k19 += 1) {
        i_ = k19;
        real t20 = process_model_noise(z_, current_, i_);
        record_.p[((at_z_ + i_))] = (half_ * t20);
    }
    for (int64_t k21 = 0; k21 < counted_; k21 += 1) {
        part_ = k21;
        process_model_rk4_2(z_, phi_, true, torques_, h_, current_, vectors_);
        aekf_look(false, with_atan_, current_, vectors_);
        if (((part_ == 0))) {
            linalg_multiply(phi_, P_, cross_);
            for (int64_t k22 = 0; k22 < 6; k22 += 1) {
                i_ = k22;
                for (int64_t k23 = 0; k23 < 6; k23 += 1) {
                    j_ = k23;
                    product_.p[(((i_ * 6) + j_))] = gm_fma(phi_.p[(((i_ * 6) + j_))], record_.p[((at_z_ + j_))], cross_.p[(((i_ * 6) + j_))]);
                }
            }
        } else {
            linalg_multiply(phi_, cross_, product_);
            for (int64_t k24 = 0; k24 < 36; k24 += 1) {
                i_ = k24;
                cross_.p[(i_)] = product_.p[(i_)];
            }
            linalg_multiply(phi_, P_pred_, product_);
        }
        linalg_multiply_symmetric(product_, phi_, P_pred_);
        aekf_answers((tuple_8){{(real)0.0, (real)0.0, (real)1.0, (real)0.0, (real)0.0}}, 26, h_, current_, vectors_);
        aekf_times(product_, 0, flat_, 30);
        if (((current_.p[19] > (real)0.0))) {
            aekf_times(product_, 8, flat_, 34);
        }
        if (with_twist_) {
            aekf_answers((tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)1.0}}, 38, h_, current_, vectors_);
            aekf_times(product_, 4, flat_, 42);
        }
        for (int64_t k25 = 0; k25 < count_; k25 += 1) {
            i_ = k25;
            slot_ = (int64_t)(p_.p[((46 + i_))]);
            sharper_ = (tuple_7){{vectors_.p[(((78 + i_)) * vectors_.n[1] + 0)], vectors_.p[(((78 + i_)) * vectors_.n[1] + 1)]}};
            aekf_advance_sensitivity((array1_f8){s_.p + (i_) * (s_.n[1]), {s_.n[1]}}, (tuple_16){slot_, sharper_}, h_, current_, vectors_);
            linalg_multiply(phi_, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}}, change_);
            linalg_multiply_symmetric(change_, phi_, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}});
            aekf_advance_covariance((array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}}, slot_, h_, current_, vectors_, flat_);
        }
    }
    current_.p[5] = motor_;
    current_.p[15] = arm_;
    aekf_add_noise(z_, sensitivity_, half_, current_, p_);
    for (int64_t k26 = 0; k26 < 6; k26 += 1) {
        i_ = k26;
        real t28 = P_pred_.p[(((i_ * 6) + i_))];
        real t27 = process_model_noise(z_, current_, i_);
        P_pred_.p[(((i_ * 6) + i_))] = (t28 + (half_ * t27));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    return;
}

/* estimation/filters/aekf.py:610 _correct */
GM_INLINE void aekf_correct(BeliefSensitivity sensitivity_, array1_f8 current_, array1_f8 p_, array2_f8 vectors_, array1_f8 record_)
{
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
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    tuple_6 t1 = step_record_places(6);
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
        s22_ = (P_i_.p[7] + (((slot_ == 32)) ? current_.p[32] : (real)0.0));
        for (int64_t k22 = 0; k22 < 6; k22 += 1) {
            a_ = k22;
            c1_ = ((record_.p[((at_K_ + (2 * a_)))] * s11_) + (record_.p[(((at_K_ + (2 * a_)) + 1))] * s12_));
            c2_ = ((record_.p[((at_K_ + (2 * a_)))] * s12_) + (record_.p[(((at_K_ + (2 * a_)) + 1))] * s22_));
            real t23 = P_i_.p[((a_ * 6))];
            real t24 = P_i_.p[(((a_ * 6) + 1))];
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
        for (int64_t k27 = 0; k27 < 6; k27 += 1) {
            a_ = k27;
            real t28 = record_.p[((at_K_ + (2 * a_)))];
            real t29 = record_.p[(((at_K_ + (2 * a_)) + 1))];
            k1_ = t28;
            k2_ = t29;
            int64_t t30 = (a_ + 1);
            for (int64_t k31 = 0; k31 < t30; k31 += 1) {
                b_ = k31;
                value_ = ((((P_i_.p[(((a_ * 6) + b_))] - (k1_ * w1_.p[(b_)])) - (k2_ * w2_.p[(b_)])) - (w1_.p[(a_)] * record_.p[((at_K_ + (2 * b_)))])) - (w2_.p[(a_)] * record_.p[(((at_K_ + (2 * b_)) + 1))]));
                P_i_.p[(((a_ * 6) + b_))] = value_;
                P_i_.p[(((b_ * 6) + a_))] = value_;
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
GM_INLINE bool aekf_sound(array1_f8 s_, array1_f8 P_s_)
{
    real of_s_;
    real of_P_;
    int64_t a_;
    int64_t b_;
    of_s_ = (real)0.0;
    of_P_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        a_ = k1;
        of_s_ = (of_s_ + (s_.p[(a_)] * s_.p[(a_)]));
        int64_t t2 = (a_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            b_ = k3;
            of_P_ = (of_P_ + (P_s_.p[(((a_ * 6) + b_))] * P_s_.p[(((a_ * 6) + b_))]));
        }
    }
    return (((of_s_ <= (real)10000000000.0)) && ((of_P_ <= (real)100000000000000.0)));
}

/* estimation/filters/aekf.py:260 differentiate */
GM_APART bool aekf_differentiate(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    array1_f8 memory_;
    array2_f8 vectors_;
    array1_f8 current_;
    int64_t count_;
    array2_f8 s_;
    array2_f8 P_s_;
    int64_t i_;
    int64_t a_;
    memory_ = belief_.memory_;
    vectors_ = scratch_.vectors_;
    int64_t t1 = gm_bound(41, memory_.n[0]);
    int64_t t2 = gm_bound(115, memory_.n[0]);
    int64_t t3 = gm_span(t1, t2);
    current_ = (array1_f8){memory_.p + t1 * (1), {t3}};
    count_ = (int64_t)(p_.p[45]);
    int64_t t4 = gm_bound(115, memory_.n[0]);
    int64_t t5 = gm_bound(151, memory_.n[0]);
    int64_t t6 = gm_span(t4, t5);
    s_ = (array2_f8){memory_.p + t4 * (1), {6, 6}};
    int64_t t7 = gm_bound(151, memory_.n[0]);
    int64_t t8 = gm_span(t7, memory_.n[0]);
    P_s_ = (array2_f8){memory_.p + t7 * (1), {6, 36}};
    aekf_predict(belief_, (BeliefSensitivity){s_, P_s_, count_}, reading_, current_, p_, scratch_, record_);
    bool t9 = ekf_update(belief_, reading_.y1_, reading_.y2_, current_, record_);
    if ((!t9)) {
        return false;
    }
    aekf_correct((BeliefSensitivity){s_, P_s_, count_}, current_, p_, vectors_, record_);
    for (int64_t k10 = 0; k10 < count_; k10 += 1) {
        i_ = k10;
        bool t11 = aekf_sound((array1_f8){s_.p + (i_) * (s_.n[1]), {s_.n[1]}}, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}});
        if ((!t11)) {
            memory_.p[4] = (memory_.p[4] + (real)1.0);
            for (int64_t k12 = 0; k12 < 6; k12 += 1) {
                a_ = k12;
                s_.p[((i_) * s_.n[1] + (a_))] = (real)0.0;
            }
            for (int64_t k13 = 0; k13 < 36; k13 += 1) {
                a_ = k13;
                P_s_.p[((i_) * P_s_.n[1] + (a_))] = (real)0.0;
            }
            vectors_.p[(((56 + i_)) * vectors_.n[1] + 0)] = (real)0.0;
            for (int64_t k14 = 0; k14 < 5; k14 += 1) {
                a_ = k14;
                vectors_.p[(((50 + i_)) * vectors_.n[1] + (a_))] = (real)0.0;
            }
        }
    }
    bool t15 = ekf_healthy(belief_);
    return t15;
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
GM_INLINE void aekf_adapt(array1_f8 memory_, array1_f8 p_, array2_f8 vectors_, array2_f8 matrices_, array1_f8 record_)
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
    tuple_6 t1 = step_record_places(6);
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
GM_APART bool aekf_step(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    if (((p_.p[45] == (real)0.0))) {
        bool t1 = ekf_step(belief_, reading_, p_, scratch_, record_);
        return t1;
    }
    if (((belief_.memory_.p[0] == (real)0.0))) {
        aekf_begin(belief_.memory_, p_);
    }
    bool t2 = aekf_differentiate(belief_, reading_, p_, scratch_, record_);
    if ((!t2)) {
        return false;
    }
    aekf_adapt(belief_.memory_, p_, scratch_.vectors_, scratch_.matrices_, record_);
    return true;
}

/* estimation/filters/aekf.py:124 used */
GM_INLINE tuple_17 aekf_used(array1_f8 memory_, array1_f8 p_)
{
    array1_f8 current_;
    if (((memory_.p[0] == (real)0.0))) {
        return (tuple_17){p_, (real)0.0};
    }
    int64_t t1 = gm_bound(41, memory_.n[0]);
    int64_t t2 = gm_bound(115, memory_.n[0]);
    int64_t t3 = gm_span(t1, t2);
    current_ = (array1_f8){memory_.p + t1 * (1), {t3}};
    real t4 = aekf_eigenvalue(current_, p_);
    return (tuple_17){current_, (t4 - p_.p[30])};
}

/* estimation/process_model.py:643 _own_drive */
GM_INLINE tuple_19 process_model_own_drive(bool differ_, array1_f8 lanes_, int64_t at_, tuple_15 torques_, tuple_18 p_)
{
    array1_f8 f_;
    real u_;
    f_ = lanes_;
    u_ = ((f_.p[((at_ + 128))] * torques_.v[0]) - (f_.p[((at_ + 144))] * torques_.v[2]));
    return (tuple_19){u_, (tuple_18){{(p_.v[0] * f_.p[(at_)]), (p_.v[1] * f_.p[((at_ + 16))]), (p_.v[2] * f_.p[((at_ + 32))]), (p_.v[3] * f_.p[((at_ + 48))]), (p_.v[4] * f_.p[((at_ + 64))]), p_.v[5], p_.v[6], p_.v[7], p_.v[8], p_.v[9], p_.v[10], p_.v[11], p_.v[12], (p_.v[13] * f_.p[((at_ + 80))]), (p_.v[14] * f_.p[((at_ + 96))]), p_.v[15], p_.v[16], p_.v[17], p_.v[18], (p_.v[19] * f_.p[((at_ + 112))]), p_.v[20], p_.v[21], p_.v[22], p_.v[23], p_.v[24], p_.v[25], p_.v[26]}}};
}

/* estimation/process_model.py:210 _curve */
GM_INLINE tuple_9 process_model_curve_2(int64_t curve_, array1_f8 z_, int64_t width_, int64_t i_, int64_t at_, tuple_18 p_)
{
    int64_t count_;
    if (((curve_ < 0))) {
        return (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    }
    int64_t t1 = process_model_curve_count(curve_);
    count_ = t1;
    if (((count_ > 1))) {
        return (tuple_9){{z_.p[gm_at((((at_ + 1) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 2) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 3) * width_) + i_), z_.n[0])], p_.v[12]}};
    }
    return (tuple_9){{p_.v[9], (p_.v[9] * p_.v[10]), (((count_ > 0)) ? (p_.v[9] * p_.v[11]) : (real)0.0), p_.v[12]}};
}

/* plant/drive.py:811 motor_friction */
GM_INLINE real drive_motor_friction_2(real x3_, real tau_k_, tuple_18 p_)
{
    real t3 = (p_.v[3] * x3_);
    real t2 = ((p_.v[4] + (p_.v[19] * gm_fabs(tau_k_))) * (real)0.6366197723675814);
    real t1 = elementary_arctan((p_.v[5] * x3_));
    return (t3 + (t2 * t1));
}

/* plant/drive.py:871 motor_acceleration */
GM_INLINE real drive_motor_acceleration_2(real x1_, real x3_, real x4_, real u_, real tau_k_, tuple_18 p_)
{
    real t2 = ((((u_ + p_.v[7]) - (p_.v[2] * (x3_ - x4_))) - tau_k_) - (p_.v[6] * x1_));
    real t1 = drive_motor_friction_2(x3_, tau_k_, p_);
    return ((t2 - t1) * p_.v[0]);
}

/* plant/drive.py:941 arm_acceleration */
GM_INLINE real drive_arm_acceleration_2(real x3_, real x4_, real tau_k_, real tau_arm_, tuple_18 p_)
{
    return ((((p_.v[2] * (x3_ - x4_)) + tau_k_) - tau_arm_) * p_.v[1]);
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations_2(tuple_8 x_, real u_, real load_, tuple_18 p_)
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
    real t1 = drive_motor_acceleration_2(x1_, x3_, x4_, u_, tau_k_, p_);
    real t2 = drive_arm_acceleration_2(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t1, t2}};
}

/* estimation/process_model.py:618 _stage */
GM_INLINE void process_model_stage(array1_f8 lanes_, int64_t width_, int64_t q_, real part_, bool differ_, tuple_15 torques_, tuple_18 shared_)
{
    array1_f8 z_;
    int64_t at_curve_;
    int64_t i_;
    real u_;
    tuple_18 drive_;
    tuple_9 law_;
    real memory_;
    int64_t at_;
    tuple_8 x_;
    int64_t last_;
    real x3_;
    real x4_;
    real f_;
    real g_;
    z_ = lanes_;
    int64_t t1 = process_model_curve_count((-1));
    at_curve_ = ((6 - t1) * 16);
    for (int64_t k2 = 0; k2 < width_; k2 += 1) {
        i_ = k2;
        tuple_19 t3 = process_model_own_drive(differ_, z_, (432 + i_), torques_, shared_);
        u_ = t3.f0;
        drive_ = t3.f1;
        int64_t t4 = process_model_curve_count((-1));
        tuple_9 t5 = process_model_curve_2((-1), z_, 16, i_, (6 - t4), drive_);
        law_ = t5;
        real t6 = process_model_memory((-1), z_, (at_curve_ + i_), (z_.p[((0 + i_))] - z_.p[((16 + i_))]));
        memory_ = t6;
        at_ = (((6 + q_) * 16) + i_);
        x_ = (tuple_8){{z_.p[((0 + i_))], z_.p[((16 + i_))], z_.p[((32 + i_))], z_.p[((48 + i_))], z_.p[((64 + i_))]}};
        if (((q_ > 0))) {
            last_ = (at_ - 16);
            real t7 = z_.p[gm_at((last_ + 0), z_.n[0])];
            real t8 = z_.p[gm_at((last_ + 64), z_.n[0])];
            x3_ = t7;
            x4_ = t8;
            x_ = (tuple_8){{(x_.v[0] + (part_ * x3_)), (x_.v[1] + (part_ * x4_)), (x_.v[2] + (part_ * z_.p[gm_at((last_ + 128), z_.n[0])])), (x_.v[3] + (part_ * z_.p[gm_at((last_ + 192), z_.n[0])])), (x_.v[4] + ((part_ * drive_.v[26]) * (x3_ - x4_)))}};
        }
        tuple_8 t9 = process_model_bearing(x_, (tuple_10){memory_, law_});
        tuple_7 t10 = process_model_accelerations_2(t9, (u_ - z_.p[((at_ + 256))]), z_.p[((416 + i_))], drive_);
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
GM_INLINE void process_model_finish(array1_f8 lanes_, int64_t i_, real sixth_, tuple_18 p_)
{
    array1_f8 z_;
    int64_t at_;
    int64_t at_curve_;
    tuple_9 law_;
    real memory_;
    real moved1_;
    real moved2_;
    z_ = lanes_;
    int64_t t2 = (96 + i_);
    int64_t t1 = process_model_curve_count((-1));
    int64_t t3 = (6 - t1);
    at_ = t2;
    at_curve_ = t3;
    tuple_9 t4 = process_model_curve_2((-1), z_, 16, i_, at_curve_, p_);
    law_ = t4;
    real t5 = process_model_memory((-1), z_, ((at_curve_ * 16) + i_), (real)0.0);
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
    int64_t t12 = process_model_curve_count((-1));
    if (((t12 > 0))) {
        tuple_7 t13 = transmission_play((z_.p[((0 + i_))] - z_.p[((16 + i_))]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
        z_.p[gm_at(((at_curve_ * 16) + i_), z_.n[0])] = t13.v[0];
    }
    return;
}

/* estimation/process_model.py:567 advance_beside */
GM_STATIC void process_model_advance_beside(array1_f8 lanes_, int64_t count_, bool differ_, tuple_15 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    int64_t width_;
    real h_;
    int64_t friction_at_;
    real share_;
    tuple_18 drive_;
    int64_t i_;
    int64_t q_;
    tuple_8 error_;
    int64_t t1 = ((count_ + 3) & (-4));
    real t2 = (dt_ / (real)(n_substeps_));
    width_ = t1;
    h_ = t2;
    int64_t t3 = ((int64_t)(p_.p[29]) * 16);
    friction_at_ = t3;
    share_ = (((p_.p[28] > (real)0.0)) ? (real)1.0 : (real)0.0);
    drive_ = (tuple_18){{p_.p[0], p_.p[1], p_.p[2], p_.p[3], p_.p[4], p_.p[5], p_.p[6], p_.p[7], p_.p[8], p_.p[9], p_.p[10], p_.p[11], p_.p[12], p_.p[13], p_.p[14], p_.p[15], p_.p[16], p_.p[17], p_.p[18], p_.p[19], p_.p[20], p_.p[21], p_.p[22], p_.p[23], p_.p[24], p_.p[25], p_.p[26]}};
    for (int64_t k4 = 0; k4 < width_; k4 += 1) {
        i_ = k4;
        lanes_.p[((416 + i_))] = torques_.v[1];
        lanes_.p[((416 + i_))] = (lanes_.p[((416 + i_))] + (share_ * lanes_.p[((80 + i_))]));
        for (int64_t k5 = 0; k5 < 4; k5 += 1) {
            q_ = k5;
            lanes_.p[(((352 + (q_ * 16)) + i_))] = (real)0.0;
        }
    }
    for (int64_t k6 = 0; k6 < n_substeps_; k6 += 1) {
        if (((friction_at_ > 0))) {
            for (int64_t k7 = 0; k7 < width_; k7 += 1) {
                i_ = k7;
                tuple_8 t8 = process_model_decay(lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])], ((real)0.5 * h_), h_, p_);
                error_ = t8;
                for (int64_t k9 = 0; k9 < 4; k9 += 1) {
                    q_ = k9;
                    lanes_.p[(((352 + (q_ * 16)) + i_))] = error_.v[(q_)];
                }
                lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])] = error_.v[4];
            }
        }
        process_model_stage(lanes_, width_, 0, (real)0.0, differ_, torques_, drive_);
        process_model_stage(lanes_, width_, 1, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage(lanes_, width_, 2, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage(lanes_, width_, 3, h_, differ_, torques_, drive_);
        for (int64_t k10 = 0; k10 < width_; k10 += 1) {
            i_ = k10;
            process_model_finish(lanes_, i_, (h_ / (real)6.0), drive_);
        }
    }
    return;
}

/* estimation/step_record.py:24 sensitivities */
GM_INLINE tuple_20 step_record_sensitivities(int64_t n_, int64_t length_)
{
    int64_t begin_;
    int64_t size_;
    begin_ = (((4 * n_) + ((3 * n_) * n_)) + 8);
    size_ = gm_div(((length_ - begin_) - 1), 3);
    return (tuple_20){{gm_div(size_, n_), begin_, (begin_ + size_), (begin_ + (2 * size_))}};
}

/* estimation/consider.py:126 accompany */
GM_STATIC bool consider_accompany(Companions companions_, array1_f8 z_, Reading reading_, tuple_17 used_, array1_f8 record_)
{
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
    for (int64_t k2 = 0; k2 < 6; k2 += 1) {
        j_ = k2;
        for (int64_t k3 = 0; k3 < 16; k3 += 1) {
            i_ = k3;
            lanes_.p[(((j_ * 16) + i_))] = z_.p[(j_)];
        }
        for (int64_t k4 = 0; k4 < count_; k4 += 1) {
            i_ = k4;
            lanes_.p[((((j_ * 16) + 1) + i_))] = (lanes_.p[((((j_ * 16) + 1) + i_))] + s_.p[(((i_ * 6) + j_))]);
        }
    }
    int64_t t6 = (count_ + 1);
    int64_t t5 = drive_substeps(reading_.dt_, (p_.p[30] + faster_));
    process_model_advance_beside(lanes_, t6, true, (tuple_15){{reading_.u_, reading_.load_, rate_}}, reading_.dt_, t5, p_);
    tuple_6 t7 = step_record_places(6);
    at_K_ = t7.v[7];
    tuple_20 t8 = step_record_sensitivities(6, record_.n[0]);
    at_predicted_ = t8.v[1];
    at_updated_ = t8.v[2];
    good_ = true;
    for (int64_t k9 = 0; k9 < count_; k9 += 1) {
        i_ = k9;
        at_ = (i_ * 6);
        real t10 = (lanes_.p[((1 + i_))] - lanes_.p[0]);
        real t11 = (lanes_.p[((17 + i_))] - lanes_.p[16]);
        e1_ = t10;
        e2_ = t11;
        for (int64_t k12 = 0; k12 < 6; k12 += 1) {
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
GM_STATIC bool filter_call_aekf(array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple_5 t1 = filter_parts(95, 3, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < 6; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim(belief_, reading_, p_);
    }
    bool t3 = aekf_step(belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_17 t4 = aekf_used(belief_.memory_, p_);
    bool t5 = consider_accompany(companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/filter.py:36 _parts */
GM_INLINE tuple_5 filter_parts_2(int64_t n_vectors_, int64_t n_matrices_, array1_f8 room_)
{
    int64_t count_;
    int64_t at_matrices_;
    int64_t at_record_;
    int64_t at_lanes_;
    int64_t at_s_;
    int64_t at_before_;
    int64_t at_memory_;
    int64_t t1 = (int64_t)(room_.p[0]);
    count_ = t1;
    at_matrices_ = (105 + (n_vectors_ * 5));
    at_record_ = (at_matrices_ + (n_matrices_ * 25));
    int64_t t2 = step_record_record_size(5, count_);
    at_lanes_ = (at_record_ + t2);
    at_s_ = (at_lanes_ + 576);
    at_before_ = ((at_s_ + (5 * count_)) + 1);
    at_memory_ = (at_before_ + 5);
    int64_t t3 = gm_bound(1, room_.n[0]);
    int64_t t4 = gm_bound(6, room_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = gm_bound(6, room_.n[0]);
    int64_t t7 = gm_bound(31, room_.n[0]);
    int64_t t8 = gm_span(t6, t7);
    int64_t t9 = gm_bound(at_memory_, room_.n[0]);
    int64_t t10 = gm_span(t9, room_.n[0]);
    int64_t t11 = gm_bound(31, room_.n[0]);
    int64_t t12 = gm_bound(105, room_.n[0]);
    int64_t t13 = gm_span(t11, t12);
    int64_t t14 = gm_bound(105, room_.n[0]);
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
    return (tuple_5){(Belief){(array1_f8){room_.p + t3 * (1), {t5}}, (array1_f8){room_.p + t6 * (1), {t8}}, (array1_f8){room_.p + t9 * (1), {t10}}}, (array1_f8){room_.p + t11 * (1), {t13}}, (Scratch){(array2_f8){room_.p + t14 * (1), {n_vectors_, 5}}, (array2_f8){room_.p + t17 * (1), {n_matrices_, 25}}}, (array1_f8){room_.p + t20 * (1), {t22}}, (Companions){count_, (array1_f8){room_.p + t23 * (1), {t25}}, (array1_f8){room_.p + t26 * (1), {t28}}}, (array1_f8){room_.p + t29 * (1), {t31}}};
}

/* estimation/sample_loop.py:441 aim */
GM_INLINE void sample_loop_aim_2(Belief belief_, Reading reading_, array1_f8 p_)
{
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    real t1 = sample_loop_first_speed((reading_.y1_ - z_.p[0]), dt_, (P_.p[0] + p_.p[31]), P_.p[12]);
    z_.p[2] = t1;
    real t2 = sample_loop_first_speed((reading_.y2_ - z_.p[1]), dt_, (P_.p[6] + p_.p[32]), P_.p[18]);
    z_.p[3] = t2;
    return;
}

/* estimation/process_model.py:547 _bearing */
GM_INLINE tuple_8 process_model_bearing_2(tuple_8 x_, tuple_10 elastic_)
{
    real tau_k_;
    tuple_11 t1 = process_model_total((-1), (x_.v[0] - x_.v[1]), elastic_.f0, elastic_.f1, x_.v[4]);
    tau_k_ = t1.f0;
    return (tuple_8){{x_.v[0], x_.v[1], x_.v[2], x_.v[3], tau_k_}};
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations_3(tuple_8 x_, real u_, real load_, array1_f8 p_)
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
    real t1 = drive_motor_acceleration(x1_, x3_, x4_, u_, tau_k_, p_);
    real t2 = drive_arm_acceleration(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t1, t2}};
}

/* estimation/process_model.py:520 _advanced */
GM_INLINE tuple_8 process_model_advanced_2(tuple_8 x_, tuple_10 elastic_, tuple_9 error_, tuple_7 torques_, real h_, array1_f8 p_)
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
    tuple_8 y_;
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
    tuple_8 t3 = process_model_bearing_2(x_, elastic_);
    tuple_7 t4 = process_model_accelerations_3(t3, (u_ - error_.v[0]), load_, p_);
    f1_ = t4.v[0];
    g1_ = t4.v[1];
    real t5 = (x3_ + (half_ * f1_));
    real t6 = (x4_ + (half_ * g1_));
    b3_ = t5;
    b4_ = t6;
    y_ = (tuple_8){{(x1_ + (half_ * x3_)), (x2_ + (half_ * x4_)), b3_, b4_, (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)))}};
    tuple_8 t7 = process_model_bearing_2(y_, elastic_);
    tuple_7 t8 = process_model_accelerations_3(t7, (u_ - error_.v[1]), load_, p_);
    f2_ = t8.v[0];
    g2_ = t8.v[1];
    real t9 = (x3_ + (half_ * f2_));
    real t10 = (x4_ + (half_ * g2_));
    c3_ = t9;
    c4_ = t10;
    y_ = (tuple_8){{(x1_ + (half_ * b3_)), (x2_ + (half_ * b4_)), c3_, c4_, (tau_k_ + ((half_ * p_.p[26]) * (b3_ - b4_)))}};
    tuple_8 t11 = process_model_bearing_2(y_, elastic_);
    tuple_7 t12 = process_model_accelerations_3(t11, (u_ - error_.v[2]), load_, p_);
    f3_ = t12.v[0];
    g3_ = t12.v[1];
    real t13 = (x3_ + (h_ * f3_));
    real t14 = (x4_ + (h_ * g3_));
    d3_ = t13;
    d4_ = t14;
    y_ = (tuple_8){{(x1_ + (h_ * c3_)), (x2_ + (h_ * c4_)), d3_, d4_, (tau_k_ + ((h_ * p_.p[26]) * (c3_ - c4_)))}};
    tuple_8 t15 = process_model_bearing_2(y_, elastic_);
    tuple_7 t16 = process_model_accelerations_3(t15, (u_ - error_.v[3]), load_, p_);
    f4_ = t16.v[0];
    g4_ = t16.v[1];
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (b3_ + c3_))) + d3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (b4_ + c4_))) + d4_));
    return (tuple_8){{(x1_ + moved1_), (x2_ + moved2_), (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_))), (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_))), (tau_k_ + (p_.p[26] * (moved1_ - moved2_)))}};
}

/* estimation/process_model.py:499 _advance_one */
GM_INLINE void process_model_advance_one_2(array1_f8 z_, tuple_7 torques_, real h_, array1_f8 p_)
{
    real u_;
    real load_;
    int64_t at_curve_;
    tuple_8 error_;
    tuple_8 x_;
    tuple_9 law_;
    real memory_;
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    int64_t t1 = process_model_curve_count((-1));
    at_curve_ = (5 - t1);
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t2 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], ((real)0.5 * h_), h_, p_);
        error_ = t2;
        z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])] = error_.v[4];
    }
    x_ = (tuple_8){{z_.p[0], z_.p[1], z_.p[2], z_.p[3], z_.p[4]}};
    tuple_9 t3 = process_model_curve((-1), z_, 1, 0, at_curve_, p_);
    law_ = t3;
    real t4 = process_model_memory((-1), z_, at_curve_, (x_.v[0] - x_.v[1]));
    memory_ = t4;
    tuple_8 t5 = process_model_advanced_2(x_, (tuple_10){memory_, law_}, (tuple_9){{error_.v[0], error_.v[1], error_.v[2], error_.v[3]}}, (tuple_7){{u_, load_}}, h_, p_);
    x_ = t5;
    int64_t t6 = process_model_curve_count((-1));
    if (((t6 > 0))) {
        tuple_7 t7 = transmission_play((x_.v[0] - x_.v[1]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
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
GM_STATIC void process_model_advance_2(array1_f8 z_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (dt_ / (real)(n_substeps_));
    for (int64_t k1 = 0; k1 < n_substeps_; k1 += 1) {
        process_model_advance_one_2(z_, torques_, h_, p_);
    }
    return;
}

/* estimation/process_model.py:1044 propagate_numeric */
GM_STATIC void process_model_propagate_numeric_2(array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_, array1_f8 start_)
{
    int64_t i_;
    int64_t j_;
    array1_f8 moved_;
    real step_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        start_.p[(i_)] = z_.p[(i_)];
    }
    process_model_advance_2(z_, torques_, dt_, n_substeps_, p_);
    for (int64_t k2 = 0; k2 < 5; k2 += 1) {
        j_ = k2;
        int64_t t3 = (j_ * 5);
        int64_t t4 = ((j_ + 1) * 5);
        int64_t t5 = gm_bound(t3, phi_.n[0]);
        int64_t t6 = gm_bound(t4, phi_.n[0]);
        int64_t t7 = gm_span(t5, t6);
        moved_ = (array1_f8){phi_.p + t5 * (1), {t7}};
        for (int64_t k8 = 0; k8 < 5; k8 += 1) {
            i_ = k8;
            moved_.p[(i_)] = start_.p[(i_)];
        }
        moved_.p[(j_)] = (moved_.p[(j_)] + ((real)1e-06 * gm_max_f((real)1.0, gm_fabs(start_.p[(j_)]))));
        step_ = (moved_.p[(j_)] - start_.p[(j_)]);
        process_model_advance_2(moved_, torques_, dt_, n_substeps_, p_);
        for (int64_t k9 = 0; k9 < 5; k9 += 1) {
            i_ = k9;
            moved_.p[(i_)] = ((moved_.p[(i_)] - z_.p[(i_)]) / step_);
        }
    }
    for (int64_t k10 = 0; k10 < 5; k10 += 1) {
        i_ = k10;
        int64_t t11 = i_;
        for (int64_t k12 = 0; k12 < t11; k12 += 1) {
            j_ = k12;
            real t13 = phi_.p[(((j_ * 5) + i_))];
            real t14 = phi_.p[(((i_ * 5) + j_))];
            phi_.p[(((i_ * 5) + j_))] = t13;
            phi_.p[(((j_ * 5) + i_))] = t14;
        }
    }
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row_3(array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t count_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (5 - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((5 - count_) * 5) + j_), phi_.n[0])];
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_5(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
{
    real moved1_;
    real moved2_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[((0 + j_))] = (m_.v[0].v[0] + moved1_);
    phi_.p[((5 + j_))] = (m_.v[0].v[4] + moved2_);
    phi_.p[((10 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[((15 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[((20 + j_))] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2_3(array1_f8 phi_, Stages stages_, array1_f8 p_)
{
    int64_t i_;
    if (stages_.first_) {
        for (int64_t k1 = 0; k1 < 5; k1 += 1) {
            i_ = k1;
            phi_.p[(((i_ * 5) + 1))] = (((i_ == 1)) ? (real)1.0 : (real)0.0);
        }
    }
    return;
}

/* estimation/process_model.py:883 rk4 */
GM_INLINE void process_model_rk4_3(array1_f8 z_, array1_f8 phi_, bool first_, tuple_7 torques_, real h_, array1_f8 p_)
{
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
    tuple_9 law_;
    real memory_;
    tuple_9 rows_;
    tuple_8 error_;
    tuple_12 m1_;
    real total_;
    tuple_8 bend1_;
    real slope1_;
    real share1_;
    tuple_7 arm1_;
    real f1_;
    real g1_;
    tuple_13 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_8 bend2_;
    real slope2_;
    real share2_;
    tuple_7 arm2_;
    real f2_;
    real g2_;
    tuple_12 m2_;
    tuple_13 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_8 bend3_;
    real slope3_;
    real share3_;
    tuple_7 arm3_;
    real f3_;
    real g3_;
    tuple_12 m3_;
    tuple_13 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_8 bend4_;
    real slope4_;
    real share4_;
    tuple_7 arm4_;
    real f4_;
    real g4_;
    tuple_12 m4_;
    tuple_13 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
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
    int64_t t8 = process_model_curve_count((-1));
    at_curve_ = (5 - t8);
    tuple_9 t9 = process_model_curve((-1), z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory((-1), z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row_3(phi_, 0, first_);
    real t12 = process_model_memory_row_3(phi_, 2, first_);
    real t13 = process_model_memory_row_3(phi_, 3, first_);
    real t14 = process_model_memory_row_3(phi_, 4, first_);
    rows_ = (tuple_9){{t11, t12, t13, t14}};
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    tuple_8 t15 = process_model_begin(5, phi_, 0, first_);
    tuple_8 t16 = process_model_begin(5, phi_, 2, first_);
    tuple_8 t17 = process_model_begin(5, phi_, 3, first_);
    tuple_8 t18 = process_model_begin(5, phi_, 4, first_);
    m1_ = (tuple_12){{t15, t16, t17, t18}};
    tuple_11 t19 = process_model_total((-1), (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t19.f0;
    bend1_ = t19.f1;
    tuple_7 t20 = process_model_slopes(false, x3_, total_, p_);
    slope1_ = t20.v[0];
    share1_ = t20.v[1];
    tuple_7 t21 = process_model_load_slopes(false, x2_, x4_, p_);
    arm1_ = t21;
    tuple_7 t22 = process_model_accelerations_3((tuple_8){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t22.v[0];
    g1_ = t22.v[1];
    tuple_12 t23 = process_model_four_bent((-1), bend1_, rows_, m1_);
    tuple_13 t24 = process_model_four_rates(false, t23, slope1_, share1_, arm1_, p_);
    r1_ = t24;
    real t25 = (x2_ + (half_ * x4_));
    real t26 = (x3_ + (half_ * f1_));
    real t27 = (x4_ + (half_ * g1_));
    y2_ = t25;
    y3_ = t26;
    y4_ = t27;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_11 t28 = process_model_total((-1), ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t28.f0;
    bend2_ = t28.f1;
    tuple_7 t29 = process_model_slopes(false, y3_, total_, p_);
    slope2_ = t29.v[0];
    share2_ = t29.v[1];
    tuple_7 t30 = process_model_load_slopes(false, y2_, y4_, p_);
    arm2_ = t30;
    tuple_7 t31 = process_model_accelerations_3((tuple_8){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t31.v[0];
    g2_ = t31.v[1];
    tuple_12 t32 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t32;
    tuple_12 t33 = process_model_four_bent((-1), bend2_, rows_, m2_);
    tuple_13 t34 = process_model_four_rates(false, t33, slope2_, share2_, arm2_, p_);
    r2_ = t34;
    real t35 = (x2_ + (half_ * y4_));
    real t36 = (x3_ + (half_ * f2_));
    real t37 = (x4_ + (half_ * g2_));
    v2_ = t35;
    v3_ = t36;
    v4_ = t37;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_11 t38 = process_model_total((-1), ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t38.f0;
    bend3_ = t38.f1;
    tuple_7 t39 = process_model_slopes(false, v3_, total_, p_);
    slope3_ = t39.v[0];
    share3_ = t39.v[1];
    tuple_7 t40 = process_model_load_slopes(false, v2_, v4_, p_);
    arm3_ = t40;
    tuple_7 t41 = process_model_accelerations_3((tuple_8){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t41.v[0];
    g3_ = t41.v[1];
    tuple_12 t42 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t42;
    tuple_12 t43 = process_model_four_bent((-1), bend3_, rows_, m3_);
    tuple_13 t44 = process_model_four_rates(false, t43, slope3_, share3_, arm3_, p_);
    r3_ = t44;
    real t45 = (x2_ + (h_ * v4_));
    real t46 = (x3_ + (h_ * f3_));
    real t47 = (x4_ + (h_ * g3_));
    w2_ = t45;
    w3_ = t46;
    w4_ = t47;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_11 t48 = process_model_total((-1), ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t48.f0;
    bend4_ = t48.f1;
    tuple_7 t49 = process_model_slopes(false, w3_, total_, p_);
    slope4_ = t49.v[0];
    share4_ = t49.v[1];
    tuple_7 t50 = process_model_load_slopes(false, w2_, w4_, p_);
    arm4_ = t50;
    tuple_7 t51 = process_model_accelerations_3((tuple_8){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t51.v[0];
    g4_ = t51.v[1];
    tuple_12 t52 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t52;
    tuple_12 t53 = process_model_four_bent((-1), bend4_, rows_, m4_);
    tuple_13 t54 = process_model_four_rates(false, t53, slope4_, share4_, arm4_, p_);
    r4_ = t54;
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (y3_ + v3_))) + w3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (y4_ + v4_))) + w4_));
    real t55 = (x1_ + moved1_);
    real t56 = (x2_ + moved2_);
    z_.p[0] = t55;
    z_.p[1] = t56;
    z_.p[2] = (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_)));
    z_.p[3] = (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_)));
    z_.p[4] = (tau_k_ + (p_.p[26] * (moved1_ - moved2_)));
    process_model_end_5(phi_, 0, h_, (tuple_12){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_13){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_);
    process_model_end_5(phi_, 2, h_, (tuple_12){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_13){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_);
    process_model_end_5(phi_, 3, h_, (tuple_12){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_13){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_);
    process_model_end_5(phi_, 4, h_, (tuple_12){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_13){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_);
    stages_ = (Stages){(tuple_9){{slope1_, slope2_, slope3_, slope4_}}, (tuple_9){{share1_, share2_, share3_, share4_}}, (tuple_13){{arm1_, arm2_, arm3_, arm4_}}, (tuple_12){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2_3(phi_, stages_, p_);
    return;
}

/* estimation/process_model.py:1018 propagate */
GM_INLINE void process_model_propagate_2(array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (((n_substeps_ > 1)) ? (dt_ / (real)(n_substeps_)) : dt_);
    process_model_rk4_3(z_, phi_, true, torques_, h_, p_);
    for (int64_t k1 = 1; k1 < n_substeps_; k1 += 1) {
        process_model_rk4_3(z_, phi_, false, torques_, h_, p_);
    }
    return;
}

/* kernels/linalg.py:100 carry */
GM_INLINE void linalg_carry_2(array1_f8 phi_, array1_f8 P_, array1_f8 half_, array1_f8 cross_, array1_f8 out_)
{
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
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        tuple_14 t2 = linalg_row(5, 1, phi_, i_, P_);
        s0_ = t2.v[0];
        s1_ = t2.v[1];
        s2_ = t2.v[2];
        s3_ = t2.v[3];
        s4_ = t2.v[4];
        s5_ = t2.v[5];
        s6_ = t2.v[6];
        at_ = (i_ * 5);
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
        for (int64_t k11 = 0; k11 < 5; k11 += 1) {
            j_ = k11;
            at_ = (j_ * 5);
            value_ = (s0_ * phi_.p[(at_)]);
            if (((j_ == 1))) {
                value_ = gm_fma(s1_, phi_.p[((at_ + 1))], value_);
            }
            value_ = gm_fma(s4_, phi_.p[((at_ + 4))], gm_fma(s3_, phi_.p[((at_ + 3))], gm_fma(s2_, phi_.p[((at_ + 2))], value_)));
            linalg_mirrored(out_, 5, i_, j_, value_);
        }
    }
    return;
}

/* estimation/filters/ekf.py:56 predict */
GM_INLINE void ekf_predict_2(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
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
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    tuple_6 t1 = step_record_places(5);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    phi_ = (array1_f8){scratch_.matrices_.p + 0 * (scratch_.matrices_.n[1]), {scratch_.matrices_.n[1]}};
    int64_t t2 = (at_cross_ + 25);
    int64_t t3 = gm_bound(at_cross_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = (at_P_ + 25);
    int64_t t7 = gm_bound(at_P_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    cross_ = (array1_f8){record_.p + t3 * (1), {t5}};
    P_pred_ = (array1_f8){record_.p + t7 * (1), {t9}};
    for (int64_t k10 = 0; k10 < 5; k10 += 1) {
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
        real t16 = process_model_softened_sharpness(motor_, P_.p[12]);
        p_.p[5] = t16;
        real t17 = process_model_softened_sharpness(arm_, P_.p[18]);
        p_.p[15] = t17;
    }
    if (((p_.p[36] > (real)0.0))) {
        process_model_propagate_numeric_2(z_, phi_, (tuple_7){{reading_.u_, reading_.load_}}, dt_, counted_, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}});
    } else {
        process_model_propagate_2(z_, phi_, (tuple_7){{reading_.u_, reading_.load_}}, dt_, counted_, p_);
    }
    if (((p_.p[37] > (real)0.0))) {
        p_.p[5] = motor_;
        p_.p[15] = arm_;
    }
    int64_t t18 = (at_z_ + 5);
    int64_t t19 = gm_bound(at_z_, record_.n[0]);
    int64_t t20 = gm_bound(t18, record_.n[0]);
    int64_t t21 = gm_span(t19, t20);
    linalg_carry_2(phi_, P_, (array1_f8){record_.p + t19 * (1), {t21}}, cross_, P_pred_);
    for (int64_t k22 = 0; k22 < 5; k22 += 1) {
        i_ = k22;
        real t25 = P_pred_.p[(((i_ * 5) + i_))];
        real t24 = ((real)0.5 * dt_);
        real t23 = process_model_noise(z_, p_, i_);
        P_pred_.p[(((i_ * 5) + i_))] = (t25 + (t24 * t23));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    return;
}

/* estimation/filters/ekf.py:88 update */
GM_INLINE bool ekf_update_2(Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
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
    tuple_9 row_;
    int64_t j_;
    real value_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_6 t1 = step_record_places(5);
    at_prior_ = t1.v[1];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    at_K_ = t1.v[7];
    at_scores_ = t1.v[8];
    int64_t t2 = (at_prior_ + 25);
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
    real t12 = (prior_.p[6] + r2_);
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
        tuple_15 t13 = ekf_inverse(s11_, s12_, s22_, determinant_);
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
    for (int64_t k15 = 0; k15 < 5; k15 += 1) {
        i_ = k15;
        real t16 = prior_.p[((i_ * 5))];
        real t17 = prior_.p[(((i_ * 5) + 1))];
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
        tuple_9 t20 = ekf_joseph(i_, (tuple_7){{k1_, k2_}}, (tuple_7){{c1_, c2_}}, (tuple_15){{prior_.p[0], prior_.p[1], prior_.p[6]}}, (tuple_7){{r1_, r2_}});
        row_ = t20;
        int64_t t21 = (i_ + 1);
        for (int64_t k22 = 0; k22 < t21; k22 += 1) {
            j_ = k22;
            real t23 = ekf_joseph_element(i_, prior_.p[(((i_ * 5) + j_))], row_, (tuple_7){{prior_.p[(j_)], prior_.p[((5 + j_))]}}, (tuple_7){{record_.p[((at_K_ + (2 * j_)))], record_.p[(((at_K_ + (2 * j_)) + 1))]}});
            value_ = t23;
            P_.p[(((i_ * 5) + j_))] = value_;
            P_.p[(((j_ * 5) + i_))] = value_;
            record_.p[(((at_P_ + (i_ * 5)) + j_))] = value_;
            record_.p[(((at_P_ + (j_ * 5)) + i_))] = value_;
        }
    }
    return true;
}

/* estimation/process_model.py:356 bound_curve */
GM_INLINE void process_model_bound_curve_2(array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    if (((count_ > 1))) {
        at_ = (5 - count_);
        z_.p[gm_at((at_ + 1), z_.n[0])] = gm_min_f(gm_max_f(z_.p[gm_at((at_ + 1), z_.n[0])], (p_.p[9] / (real)10.0)), (p_.p[9] * (real)10.0));
        z_.p[gm_at((at_ + 2), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 2), z_.n[0])], (real)0.0);
        if (((p_.p[12] > (real)0.0))) {
            z_.p[gm_at((at_ + 3), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 3), z_.n[0])], (real)0.0);
        }
    }
    return;
}

/* estimation/filters/ekf.py:208 healthy */
GM_INLINE bool ekf_healthy_2(Belief belief_)
{
    array1_f8 z_;
    array1_f8 P_;
    int64_t i_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        if ((!(((bool)isfinite(z_.p[(i_)]) && ((P_.p[(((i_ * 5) + i_))] > (real)0.0))) && (bool)isfinite(P_.p[(((i_ * 5) + i_))])))) {
            return false;
        }
    }
    return true;
}

/* estimation/filters/ekf.py:30 step */
GM_APART bool ekf_step_2(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    ekf_predict_2(belief_, reading_, p_, scratch_, record_);
    bool t1 = ekf_update_2(belief_, reading_.y1_, reading_.y2_, p_, record_);
    if ((!t1)) {
        return false;
    }
    process_model_bound_curve_2(belief_.z_, p_);
    bool t2 = ekf_healthy_2(belief_);
    return t2;
}

/* estimation/filters/aekf.py:595 _add_noise */
GM_INLINE void aekf_add_noise_2(array1_f8 z_, BeliefSensitivity sensitivity_, real half_, array1_f8 current_, array1_f8 p_)
{
    array2_f8 s_;
    array2_f8 P_s_;
    int64_t count_;
    int64_t i_;
    real q_;
    int64_t at_;
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    for (int64_t k1 = 0; k1 < count_; k1 += 1) {
        i_ = k1;
        q_ = ((((real)2.0 * current_.p[35]) * z_.p[2]) * s_.p[((i_) * s_.n[1] + 2)]);
        if (((p_.p[((46 + i_))] == (real)56.0))) {
            q_ = (q_ + current_.p[56]);
        }
        P_s_.p[((i_) * P_s_.n[1] + 24)] = (P_s_.p[((i_) * P_s_.n[1] + 24)] + (half_ * q_));
        at_ = ((int64_t)(p_.p[((46 + i_))]) - 52);
        if ((((0 <= at_) && (at_ < 5)) && ((at_ != 4)))) {
            P_s_.p[((i_) * P_s_.n[1] + gm_at(((at_ * 5) + at_), P_s_.n[1]))] = (P_s_.p[((i_) * P_s_.n[1] + gm_at(((at_ * 5) + at_), P_s_.n[1]))] + (half_ * current_.p[gm_at((52 + at_), current_.n[0])]));
        }
    }
    return;
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_6(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_, array2_f8 trace_)
{
    real moved1_;
    real moved2_;
    int64_t q_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[((0 + j_))] = (m_.v[0].v[0] + moved1_);
    phi_.p[((5 + j_))] = (m_.v[0].v[4] + moved2_);
    phi_.p[((10 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[((15 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[((20 + j_))] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
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
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2_4(array1_f8 phi_, Stages stages_, array1_f8 p_, array2_f8 trace_)
{
    int64_t i_;
    int64_t q_;
    if (stages_.first_) {
        for (int64_t k1 = 0; k1 < 5; k1 += 1) {
            i_ = k1;
            phi_.p[(((i_ * 5) + 1))] = (((i_ == 1)) ? (real)1.0 : (real)0.0);
        }
    }
    for (int64_t k2 = 0; k2 < 12; k2 += 1) {
        q_ = k2;
        trace_.p[((q_) * trace_.n[1] + 1)] = (real)0.0;
    }
    return;
}

/* estimation/process_model.py:883 rk4 */
GM_INLINE void process_model_rk4_4(array1_f8 z_, array1_f8 phi_, bool first_, tuple_7 torques_, real h_, array1_f8 p_, array2_f8 trace_)
{
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
    tuple_9 law_;
    real memory_;
    tuple_9 rows_;
    tuple_8 error_;
    tuple_12 m1_;
    real total_;
    tuple_8 bend1_;
    real slope1_;
    real share1_;
    tuple_7 arm1_;
    real f1_;
    real g1_;
    tuple_13 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_8 bend2_;
    real slope2_;
    real share2_;
    tuple_7 arm2_;
    real f2_;
    real g2_;
    tuple_12 m2_;
    tuple_13 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_8 bend3_;
    real slope3_;
    real share3_;
    tuple_7 arm3_;
    real f3_;
    real g3_;
    tuple_12 m3_;
    tuple_13 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_8 bend4_;
    real slope4_;
    real share4_;
    tuple_7 arm4_;
    real f4_;
    real g4_;
    tuple_12 m4_;
    tuple_13 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
    int64_t q_;
    real value_;
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
    int64_t t8 = process_model_curve_count((-1));
    at_curve_ = (5 - t8);
    tuple_9 t9 = process_model_curve((-1), z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory((-1), z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row_3(phi_, 0, first_);
    real t12 = process_model_memory_row_3(phi_, 2, first_);
    real t13 = process_model_memory_row_3(phi_, 3, first_);
    real t14 = process_model_memory_row_3(phi_, 4, first_);
    rows_ = (tuple_9){{t11, t12, t13, t14}};
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    tuple_8 t15 = process_model_begin(5, phi_, 0, first_);
    tuple_8 t16 = process_model_begin(5, phi_, 2, first_);
    tuple_8 t17 = process_model_begin(5, phi_, 3, first_);
    tuple_8 t18 = process_model_begin(5, phi_, 4, first_);
    m1_ = (tuple_12){{t15, t16, t17, t18}};
    tuple_11 t19 = process_model_total((-1), (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t19.f0;
    bend1_ = t19.f1;
    tuple_7 t20 = process_model_slopes(false, x3_, total_, p_);
    slope1_ = t20.v[0];
    share1_ = t20.v[1];
    tuple_7 t21 = process_model_load_slopes(false, x2_, x4_, p_);
    arm1_ = t21;
    tuple_7 t22 = process_model_accelerations_3((tuple_8){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t22.v[0];
    g1_ = t22.v[1];
    tuple_12 t23 = process_model_four_bent((-1), bend1_, rows_, m1_);
    tuple_13 t24 = process_model_four_rates(false, t23, slope1_, share1_, arm1_, p_);
    r1_ = t24;
    real t25 = (x2_ + (half_ * x4_));
    real t26 = (x3_ + (half_ * f1_));
    real t27 = (x4_ + (half_ * g1_));
    y2_ = t25;
    y3_ = t26;
    y4_ = t27;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_11 t28 = process_model_total((-1), ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t28.f0;
    bend2_ = t28.f1;
    tuple_7 t29 = process_model_slopes(false, y3_, total_, p_);
    slope2_ = t29.v[0];
    share2_ = t29.v[1];
    tuple_7 t30 = process_model_load_slopes(false, y2_, y4_, p_);
    arm2_ = t30;
    tuple_7 t31 = process_model_accelerations_3((tuple_8){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t31.v[0];
    g2_ = t31.v[1];
    tuple_12 t32 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t32;
    tuple_12 t33 = process_model_four_bent((-1), bend2_, rows_, m2_);
    tuple_13 t34 = process_model_four_rates(false, t33, slope2_, share2_, arm2_, p_);
    r2_ = t34;
    real t35 = (x2_ + (half_ * y4_));
    real t36 = (x3_ + (half_ * f2_));
    real t37 = (x4_ + (half_ * g2_));
    v2_ = t35;
    v3_ = t36;
    v4_ = t37;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_11 t38 = process_model_total((-1), ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t38.f0;
    bend3_ = t38.f1;
    tuple_7 t39 = process_model_slopes(false, v3_, total_, p_);
    slope3_ = t39.v[0];
    share3_ = t39.v[1];
    tuple_7 t40 = process_model_load_slopes(false, v2_, v4_, p_);
    arm3_ = t40;
    tuple_7 t41 = process_model_accelerations_3((tuple_8){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t41.v[0];
    g3_ = t41.v[1];
    tuple_12 t42 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t42;
    tuple_12 t43 = process_model_four_bent((-1), bend3_, rows_, m3_);
    tuple_13 t44 = process_model_four_rates(false, t43, slope3_, share3_, arm3_, p_);
    r3_ = t44;
    real t45 = (x2_ + (h_ * v4_));
    real t46 = (x3_ + (h_ * f3_));
    real t47 = (x4_ + (h_ * g3_));
    w2_ = t45;
    w3_ = t46;
    w4_ = t47;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_11 t48 = process_model_total((-1), ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t48.f0;
    bend4_ = t48.f1;
    tuple_7 t49 = process_model_slopes(false, w3_, total_, p_);
    slope4_ = t49.v[0];
    share4_ = t49.v[1];
    tuple_7 t50 = process_model_load_slopes(false, w2_, w4_, p_);
    arm4_ = t50;
    tuple_7 t51 = process_model_accelerations_3((tuple_8){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t51.v[0];
    g4_ = t51.v[1];
    tuple_12 t52 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t52;
    tuple_12 t53 = process_model_four_bent((-1), bend4_, rows_, m4_);
    tuple_13 t54 = process_model_four_rates(false, t53, slope4_, share4_, arm4_, p_);
    r4_ = t54;
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (y3_ + v3_))) + w3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (y4_ + v4_))) + w4_));
    real t55 = (x1_ + moved1_);
    real t56 = (x2_ + moved2_);
    z_.p[0] = t55;
    z_.p[1] = t56;
    z_.p[2] = (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_)));
    z_.p[3] = (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_)));
    z_.p[4] = (tau_k_ + (p_.p[26] * (moved1_ - moved2_)));
    process_model_end_6(phi_, 0, h_, (tuple_12){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_13){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_, trace_);
    process_model_end_6(phi_, 2, h_, (tuple_12){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_13){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_, trace_);
    process_model_end_6(phi_, 3, h_, (tuple_12){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_13){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_, trace_);
    process_model_end_6(phi_, 4, h_, (tuple_12){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_13){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_, trace_);
    stages_ = (Stages){(tuple_9){{slope1_, slope2_, slope3_, slope4_}}, (tuple_9){{share1_, share2_, share3_, share4_}}, (tuple_13){{arm1_, arm2_, arm3_, arm4_}}, (tuple_12){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2_4(phi_, stages_, p_, trace_);
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
    for (int64_t k60 = 0; k60 < 4; k60 += 1) {
        q_ = k60;
        real t61 = stages_.slopes_.v[(q_)];
        real t62 = stages_.shares_.v[(q_)];
        trace_.p[(15 * trace_.n[1] + (q_))] = t61;
        trace_.p[(16 * trace_.n[1] + (q_))] = t62;
    }
    return;
}

/* kernels/linalg.py:22 multiply */
GM_INLINE void linalg_multiply_2(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t i_;
    real s0_;
    real s1_;
    real s2_;
    real s3_;
    real s4_;
    real s5_;
    real s6_;
    int64_t at_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        tuple_14 t2 = linalg_row_2(5, (-1), a_, i_, b_);
        s0_ = t2.v[0];
        s1_ = t2.v[1];
        s2_ = t2.v[2];
        s3_ = t2.v[3];
        s4_ = t2.v[4];
        s5_ = t2.v[5];
        s6_ = t2.v[6];
        at_ = (i_ * 5);
        out_.p[(at_)] = s0_;
        out_.p[((at_ + 1))] = s1_;
        out_.p[((at_ + 2))] = s2_;
        out_.p[((at_ + 3))] = s3_;
        out_.p[((at_ + 4))] = s4_;
    }
    return;
}

/* kernels/linalg.py:73 multiply_symmetric */
GM_INLINE void linalg_multiply_symmetric_2(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
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
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        s0_ = (real)0.0;
        s1_ = (real)0.0;
        s2_ = (real)0.0;
        s3_ = (real)0.0;
        s4_ = (real)0.0;
        s5_ = (real)0.0;
        s6_ = (real)0.0;
        for (int64_t k2 = 0; k2 < 5; k2 += 1) {
            k_ = k2;
            v_ = a_.p[(((i_ * 5) + k_))];
            s0_ = gm_fma(v_, b_.p[(k_)], s0_);
            s1_ = gm_fma(v_, b_.p[((5 + k_))], s1_);
            s2_ = gm_fma(v_, b_.p[((10 + k_))], s2_);
            s3_ = gm_fma(v_, b_.p[((15 + k_))], s3_);
            s4_ = gm_fma(v_, b_.p[((20 + k_))], s4_);
        }
        linalg_mirrored(out_, 5, i_, 0, s0_);
        linalg_mirrored(out_, 5, i_, 1, s1_);
        linalg_mirrored(out_, 5, i_, 2, s2_);
        linalg_mirrored(out_, 5, i_, 3, s3_);
        linalg_mirrored(out_, 5, i_, 4, s4_);
        linalg_mirrored(out_, 5, i_, 5, s5_);
        linalg_mirrored(out_, 5, i_, 6, s6_);
    }
    return;
}

/* estimation/filters/aekf.py:366 _answers */
GM_INLINE void aekf_answers_2(tuple_8 unit_, int64_t g_, real h_, array1_f8 current_, array2_f8 vectors_)
{
    tuple_8 a3_;
    tuple_8 a2_;
    tuple_8 a32_;
    tuple_8 end_;
    tuple_8 a1_;
    tuple_8 a21_;
    tuple_8 a321_;
    tuple_8 t1 = aekf_apply(false, unit_, 3, current_, vectors_);
    a3_ = t1;
    tuple_8 t2 = aekf_sum((h_ / (real)3.0), unit_, ((h_ * h_) / (real)6.0), a3_);
    aekf_write((array1_f8){vectors_.p + ((g_ + 2)) * (vectors_.n[1]), {vectors_.n[1]}}, t2, 5);
    tuple_8 t3 = aekf_apply(false, unit_, 2, current_, vectors_);
    a2_ = t3;
    tuple_8 t4 = aekf_apply(false, a2_, 3, current_, vectors_);
    a32_ = t4;
    tuple_8 t5 = aekf_sum((h_ / (real)3.0), a2_, ((h_ * h_) / (real)6.0), a32_);
    end_ = t5;
    tuple_8 t6 = aekf_sum((h_ / (real)3.0), unit_, ((real)0.5 * h_), end_);
    aekf_write((array1_f8){vectors_.p + ((g_ + 1)) * (vectors_.n[1]), {vectors_.n[1]}}, t6, 5);
    tuple_8 t7 = aekf_apply(false, unit_, 1, current_, vectors_);
    a1_ = t7;
    tuple_8 t8 = aekf_apply(false, a1_, 2, current_, vectors_);
    a21_ = t8;
    tuple_8 t9 = aekf_apply(false, a21_, 3, current_, vectors_);
    a321_ = t9;
    tuple_8 t10 = aekf_sum((h_ / (real)3.0), a21_, ((h_ * h_) / (real)6.0), a321_);
    end_ = t10;
    tuple_8 t11 = aekf_sum((h_ / (real)3.0), a1_, ((real)0.5 * h_), end_);
    end_ = t11;
    tuple_8 t12 = aekf_sum((h_ / (real)6.0), unit_, ((real)0.5 * h_), end_);
    aekf_write((array1_f8){vectors_.p + (g_) * (vectors_.n[1]), {vectors_.n[1]}}, t12, 5);
    return;
}

/* estimation/filters/aekf.py:534 _times */
GM_INLINE void aekf_times_2(array1_f8 product_, int64_t source_, array1_f8 flat_, int64_t out_)
{
    int64_t a_;
    real v0_;
    real v1_;
    real v2_;
    real v3_;
    int64_t b_;
    real v_;
    int64_t at_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        a_ = k1;
        v0_ = (real)0.0;
        v1_ = (real)0.0;
        v2_ = (real)0.0;
        v3_ = (real)0.0;
        for (int64_t k2 = 0; k2 < 5; k2 += 1) {
            b_ = k2;
            real t3 = product_.p[(((a_ * 5) + b_))];
            int64_t t4 = ((source_ * 5) + b_);
            v_ = t3;
            at_ = t4;
            real t5 = gm_fma(v_, flat_.p[(at_)], v0_);
            real t6 = gm_fma(v_, flat_.p[((at_ + 5))], v1_);
            v0_ = t5;
            v1_ = t6;
            real t7 = gm_fma(v_, flat_.p[((at_ + 10))], v2_);
            real t8 = gm_fma(v_, flat_.p[((at_ + 15))], v3_);
            v2_ = t7;
            v3_ = t8;
        }
        at_ = ((out_ * 5) + a_);
        real t9 = v0_;
        real t10 = v1_;
        real t11 = v2_;
        real t12 = v3_;
        flat_.p[(at_)] = t9;
        flat_.p[((at_ + 5))] = t10;
        flat_.p[((at_ + 10))] = t11;
        flat_.p[((at_ + 15))] = t12;
    }
    return;
}

/* estimation/filters/aekf.py:423 _advance_sensitivity */
GM_INLINE void aekf_advance_sensitivity_2(array1_f8 s_, tuple_16 theta_, real h_, array1_f8 current_, array2_f8 vectors_)
{
    int64_t slot_;
    real half_;
    real sixth_;
    tuple_8 error_;
    real load_;
    tuple_9 twist_;
    tuple_8 m1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_7 r4_;
    real moved1_;
    real moved2_;
    slot_ = theta_.f0;
    real t1 = ((real)0.5 * h_);
    real t2 = (h_ / (real)6.0);
    half_ = t1;
    sixth_ = t2;
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    load_ = (real)0.0;
    twist_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((slot_ == 26))) {
        twist_ = (tuple_9){{(current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 0)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 1)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 2)]), (current_.p[26] * vectors_.p[(19 * vectors_.n[1] + 3)])}};
    }
    m1_ = (tuple_8){{s_.p[0], s_.p[2], s_.p[3], s_.p[4], s_.p[1]}};
    tuple_7 t3 = aekf_sensitivity_rates(false, m1_, 0, theta_, error_.v[0], load_, current_, vectors_);
    r1_ = t3;
    tuple_8 t4 = process_model_along(m1_, half_, m1_, r1_, current_);
    tuple_8 t5 = aekf_added(t4, (half_ * twist_.v[0]));
    m2_ = t5;
    tuple_7 t6 = aekf_sensitivity_rates(false, m2_, 1, theta_, error_.v[1], load_, current_, vectors_);
    r2_ = t6;
    tuple_8 t7 = process_model_along(m1_, half_, m2_, r2_, current_);
    tuple_8 t8 = aekf_added(t7, (half_ * twist_.v[1]));
    m3_ = t8;
    tuple_7 t9 = aekf_sensitivity_rates(false, m3_, 2, theta_, error_.v[2], load_, current_, vectors_);
    r3_ = t9;
    tuple_8 t10 = process_model_along(m1_, h_, m3_, r3_, current_);
    tuple_8 t11 = aekf_added(t10, (h_ * twist_.v[2]));
    m4_ = t11;
    tuple_7 t12 = aekf_sensitivity_rates(false, m4_, 3, theta_, error_.v[3], load_, current_, vectors_);
    r4_ = t12;
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
GM_INLINE void aekf_add_products_2(array1_f8 P_i_, real factor_, int64_t at_, real h_, int64_t g_, int64_t w_, array1_f8 flat_)
{
    int64_t a_;
    int64_t b_;
    real total_;
    int64_t q_;
    real value_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        a_ = k1;
        int64_t t2 = (a_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            b_ = k3;
            total_ = (real)0.0;
            for (int64_t k4 = 0; k4 < 3; k4 += 1) {
                q_ = k4;
                total_ = gm_fma(flat_.p[((((g_ + q_) * 5) + a_))], flat_.p[((((w_ + q_) * 5) + b_))], total_);
                total_ = gm_fma(flat_.p[((((w_ + q_) * 5) + a_))], flat_.p[((((g_ + q_) * 5) + b_))], total_);
            }
            if (((a_ == at_))) {
                total_ = (total_ + ((h_ / (real)6.0) * flat_.p[((((w_ + 3) * 5) + b_))]));
            }
            if (((b_ == at_))) {
                total_ = (total_ + ((h_ / (real)6.0) * flat_.p[((((w_ + 3) * 5) + a_))]));
            }
            value_ = (P_i_.p[(((a_ * 5) + b_))] + (factor_ * total_));
            P_i_.p[(((a_ * 5) + b_))] = value_;
            P_i_.p[(((b_ * 5) + a_))] = value_;
        }
    }
    return;
}

/* estimation/filters/aekf.py:548 _advance_covariance */
GM_INLINE void aekf_advance_covariance_2(array1_f8 P_i_, int64_t slot_, real h_, array1_f8 current_, array2_f8 vectors_, array1_f8 flat_)
{
    int64_t q_;
    real c_;
    real d_;
    int64_t a_;
    real w_;
    for (int64_t k1 = 0; k1 < 4; k1 += 1) {
        q_ = k1;
        real t2 = vectors_.p[(24 * vectors_.n[1] + (q_))];
        real t3 = vectors_.p[(25 * vectors_.n[1] + (q_))];
        c_ = t2;
        d_ = t3;
        for (int64_t k4 = 0; k4 < 5; k4 += 1) {
            a_ = k4;
            w_ = (c_ * flat_.p[((((30 + q_) * 5) + a_))]);
            if (((current_.p[19] > (real)0.0))) {
                w_ = (w_ + (d_ * flat_.p[((((34 + q_) * 5) + a_))]));
            }
            flat_.p[((((46 + q_) * 5) + a_))] = w_;
        }
    }
    aekf_add_products_2(P_i_, (real)1.0, 2, h_, 26, 46, flat_);
    if (((slot_ == 26))) {
        aekf_add_products_2(P_i_, current_.p[26], 4, h_, 38, 42, flat_);
    }
    return;
}

/* estimation/filters/aekf.py:463 _predict */
GM_INLINE void aekf_predict_2(Belief belief_, BeliefSensitivity sensitivity_, Reading reading_, array1_f8 current_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    tuple_7 torques_;
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
    tuple_7 sharper_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    torques_ = (tuple_7){{reading_.u_, reading_.load_}};
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    vectors_ = scratch_.vectors_;
    matrices_ = scratch_.matrices_;
    tuple_6 t1 = step_record_places(5);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    product_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    change_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    phi_ = (array1_f8){matrices_.p + 2 * (matrices_.n[1]), {matrices_.n[1]}};
    int64_t t2 = (at_cross_ + 25);
    int64_t t3 = gm_bound(at_cross_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = (at_P_ + 25);
    int64_t t7 = gm_bound(at_P_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    cross_ = (array1_f8){record_.p + t3 * (1), {t5}};
    P_pred_ = (array1_f8){record_.p + t7 * (1), {t9}};
    flat_ = (array1_f8){vectors_.p, {475}};
    with_twist_ = false;
    with_atan_ = false;
    with_viscous_ = false;
    for (int64_t k10 = 0; k10 < count_; k10 += 1) {
        i_ = k10;
        with_twist_ = (with_twist_ | ((p_.p[((46 + i_))] == (real)26.0)));
        with_atan_ = (with_atan_ | ((p_.p[((46 + i_))] == (real)4.0)));
        with_viscous_ = (with_viscous_ | ((p_.p[((46 + i_))] == (real)3.0)));
    }
    stiffer_ = ((with_twist_ || with_atan_) || with_viscous_);
    real t12;
    if (stiffer_) {
    real t11 = aekf_eigenvalue(current_, p_);
        t12 = t11;
    } else {
        t12 = p_.p[30];
    }
    int64_t t13 = drive_substeps(dt_, t12);
    counted_ = t13;
    h_ = (dt_ / (real)(counted_));
    half_ = ((real)0.5 * dt_);
    real t14 = current_.p[5];
    real t15 = current_.p[15];
    motor_ = t14;
    arm_ = t15;
    if (((p_.p[37] > (real)0.0))) {
        real t16 = process_model_softened_sharpness(motor_, P_.p[12]);
        current_.p[5] = t16;
        real t17 = process_model_softened_sharpness(arm_, P_.p[18]);
        current_.p[15] = t17;
        for (int64_t k18 = 0; k18 < count_; k18 += 1) {
            i_ = k18;
            row_ = (array1_f8){vectors_.p + ((78 + i_)) * (vectors_.n[1]), {vectors_.n[1]}};
            row_.p[0] = ((((-current_.p[5]) * current_.p[5]) / (real)3.141592653589793) * P_s_.p[((i_) * P_s_.n[1] + 12)]);
            row_.p[1] = ((((-current_.p[15]) * current_.p[15]) / (real)3.141592653589793) * P_s_.p[((i_) * P_s_.n[1] + 18)]);
        }
    }
    aekf_add_noise_2(z_, sensitivity_, half_, current_, p_);
    for (int64_t k19 = 0; k19 < 5; k19 += 1) {
        i_ = k19;
        real t20 = process_model_noise(z_, current_, i_);
        record_.p[((at_z_ + i_))] = (half_ * t20);
    }
    for (int64_t k21 = 0; k21 < counted_; k21 += 1) {
        part_ = k21;
        process_model_rk4_4(z_, phi_, true, torques_, h_, current_, vectors_);
        aekf_look(false, with_atan_, current_, vectors_);
        if (((part_ == 0))) {
            linalg_multiply_2(phi_, P_, cross_);
            for (int64_t k22 = 0; k22 < 5; k22 += 1) {
                i_ = k22;
                for (int64_t k23 = 0; k23 < 5; k23 += 1) {
                    j_ = k23;
                    product_.p[(((i_ * 5) + j_))] = gm_fma(phi_.p[(((i_ * 5) + j_))], record_.p[((at_z_ + j_))], cross_.p[(((i_ * 5) + j_))]);
                }
            }
        } else {
            linalg_multiply_2(phi_, cross_, product_);
            for (int64_t k24 = 0; k24 < 25; k24 += 1) {
                i_ = k24;
                cross_.p[(i_)] = product_.p[(i_)];
            }
            linalg_multiply_2(phi_, P_pred_, product_);
        }
        linalg_multiply_symmetric_2(product_, phi_, P_pred_);
        aekf_answers_2((tuple_8){{(real)0.0, (real)0.0, (real)1.0, (real)0.0, (real)0.0}}, 26, h_, current_, vectors_);
        aekf_times_2(product_, 0, flat_, 30);
        if (((current_.p[19] > (real)0.0))) {
            aekf_times_2(product_, 8, flat_, 34);
        }
        if (with_twist_) {
            aekf_answers_2((tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)1.0}}, 38, h_, current_, vectors_);
            aekf_times_2(product_, 4, flat_, 42);
        }
        for (int64_t k25 = 0; k25 < count_; k25 += 1) {
            i_ = k25;
            slot_ = (int64_t)(p_.p[((46 + i_))]);
            sharper_ = (tuple_7){{vectors_.p[(((78 + i_)) * vectors_.n[1] + 0)], vectors_.p[(((78 + i_)) * vectors_.n[1] + 1)]}};
            aekf_advance_sensitivity_2((array1_f8){s_.p + (i_) * (s_.n[1]), {s_.n[1]}}, (tuple_16){slot_, sharper_}, h_, current_, vectors_);
            linalg_multiply_2(phi_, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}}, change_);
            linalg_multiply_symmetric_2(change_, phi_, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}});
            aekf_advance_covariance_2((array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}}, slot_, h_, current_, vectors_, flat_);
        }
    }
    current_.p[5] = motor_;
    current_.p[15] = arm_;
    aekf_add_noise_2(z_, sensitivity_, half_, current_, p_);
    for (int64_t k26 = 0; k26 < 5; k26 += 1) {
        i_ = k26;
        real t28 = P_pred_.p[(((i_ * 5) + i_))];
        real t27 = process_model_noise(z_, current_, i_);
        P_pred_.p[(((i_ * 5) + i_))] = (t28 + (half_ * t27));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    return;
}

/* estimation/filters/aekf.py:610 _correct */
GM_INLINE void aekf_correct_2(BeliefSensitivity sensitivity_, array1_f8 current_, array1_f8 p_, array2_f8 vectors_, array1_f8 record_)
{
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
    s_ = sensitivity_.z_;
    P_s_ = sensitivity_.P_;
    count_ = sensitivity_.n_theta_;
    tuple_6 t1 = step_record_places(5);
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
        s22_ = (P_i_.p[6] + (((slot_ == 32)) ? current_.p[32] : (real)0.0));
        for (int64_t k22 = 0; k22 < 5; k22 += 1) {
            a_ = k22;
            c1_ = ((record_.p[((at_K_ + (2 * a_)))] * s11_) + (record_.p[(((at_K_ + (2 * a_)) + 1))] * s12_));
            c2_ = ((record_.p[((at_K_ + (2 * a_)))] * s12_) + (record_.p[(((at_K_ + (2 * a_)) + 1))] * s22_));
            real t23 = P_i_.p[((a_ * 5))];
            real t24 = P_i_.p[(((a_ * 5) + 1))];
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
        for (int64_t k27 = 0; k27 < 5; k27 += 1) {
            a_ = k27;
            real t28 = record_.p[((at_K_ + (2 * a_)))];
            real t29 = record_.p[(((at_K_ + (2 * a_)) + 1))];
            k1_ = t28;
            k2_ = t29;
            int64_t t30 = (a_ + 1);
            for (int64_t k31 = 0; k31 < t30; k31 += 1) {
                b_ = k31;
                value_ = ((((P_i_.p[(((a_ * 5) + b_))] - (k1_ * w1_.p[(b_)])) - (k2_ * w2_.p[(b_)])) - (w1_.p[(a_)] * record_.p[((at_K_ + (2 * b_)))])) - (w2_.p[(a_)] * record_.p[(((at_K_ + (2 * b_)) + 1))]));
                P_i_.p[(((a_ * 5) + b_))] = value_;
                P_i_.p[(((b_ * 5) + a_))] = value_;
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
GM_INLINE bool aekf_sound_2(array1_f8 s_, array1_f8 P_s_)
{
    real of_s_;
    real of_P_;
    int64_t a_;
    int64_t b_;
    of_s_ = (real)0.0;
    of_P_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        a_ = k1;
        of_s_ = (of_s_ + (s_.p[(a_)] * s_.p[(a_)]));
        int64_t t2 = (a_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            b_ = k3;
            of_P_ = (of_P_ + (P_s_.p[(((a_ * 5) + b_))] * P_s_.p[(((a_ * 5) + b_))]));
        }
    }
    return (((of_s_ <= (real)10000000000.0)) && ((of_P_ <= (real)100000000000000.0)));
}

/* estimation/filters/aekf.py:260 differentiate */
GM_APART bool aekf_differentiate_2(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    array1_f8 memory_;
    array2_f8 vectors_;
    array1_f8 current_;
    int64_t count_;
    array2_f8 s_;
    array2_f8 P_s_;
    int64_t i_;
    int64_t a_;
    memory_ = belief_.memory_;
    vectors_ = scratch_.vectors_;
    int64_t t1 = gm_bound(41, memory_.n[0]);
    int64_t t2 = gm_bound(115, memory_.n[0]);
    int64_t t3 = gm_span(t1, t2);
    current_ = (array1_f8){memory_.p + t1 * (1), {t3}};
    count_ = (int64_t)(p_.p[45]);
    int64_t t4 = gm_bound(115, memory_.n[0]);
    int64_t t5 = gm_bound(145, memory_.n[0]);
    int64_t t6 = gm_span(t4, t5);
    s_ = (array2_f8){memory_.p + t4 * (1), {6, 5}};
    int64_t t7 = gm_bound(145, memory_.n[0]);
    int64_t t8 = gm_span(t7, memory_.n[0]);
    P_s_ = (array2_f8){memory_.p + t7 * (1), {6, 25}};
    aekf_predict_2(belief_, (BeliefSensitivity){s_, P_s_, count_}, reading_, current_, p_, scratch_, record_);
    bool t9 = ekf_update_2(belief_, reading_.y1_, reading_.y2_, current_, record_);
    if ((!t9)) {
        return false;
    }
    aekf_correct_2((BeliefSensitivity){s_, P_s_, count_}, current_, p_, vectors_, record_);
    for (int64_t k10 = 0; k10 < count_; k10 += 1) {
        i_ = k10;
        bool t11 = aekf_sound_2((array1_f8){s_.p + (i_) * (s_.n[1]), {s_.n[1]}}, (array1_f8){P_s_.p + (i_) * (P_s_.n[1]), {P_s_.n[1]}});
        if ((!t11)) {
            memory_.p[4] = (memory_.p[4] + (real)1.0);
            for (int64_t k12 = 0; k12 < 5; k12 += 1) {
                a_ = k12;
                s_.p[((i_) * s_.n[1] + (a_))] = (real)0.0;
            }
            for (int64_t k13 = 0; k13 < 25; k13 += 1) {
                a_ = k13;
                P_s_.p[((i_) * P_s_.n[1] + (a_))] = (real)0.0;
            }
            vectors_.p[(((56 + i_)) * vectors_.n[1] + 0)] = (real)0.0;
            for (int64_t k14 = 0; k14 < 5; k14 += 1) {
                a_ = k14;
                vectors_.p[(((50 + i_)) * vectors_.n[1] + (a_))] = (real)0.0;
            }
        }
    }
    bool t15 = ekf_healthy_2(belief_);
    return t15;
}

/* estimation/filters/aekf.py:668 _adapt */
GM_INLINE void aekf_adapt_2(array1_f8 memory_, array1_f8 p_, array2_f8 vectors_, array2_f8 matrices_, array1_f8 record_)
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
    tuple_6 t1 = step_record_places(5);
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
GM_APART bool aekf_step_2(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    if (((p_.p[45] == (real)0.0))) {
        bool t1 = ekf_step_2(belief_, reading_, p_, scratch_, record_);
        return t1;
    }
    if (((belief_.memory_.p[0] == (real)0.0))) {
        aekf_begin(belief_.memory_, p_);
    }
    bool t2 = aekf_differentiate_2(belief_, reading_, p_, scratch_, record_);
    if ((!t2)) {
        return false;
    }
    aekf_adapt_2(belief_.memory_, p_, scratch_.vectors_, scratch_.matrices_, record_);
    return true;
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations_4(tuple_8 x_, real u_, real load_, tuple_18 p_)
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
    real t1 = drive_motor_acceleration_2(x1_, x3_, x4_, u_, tau_k_, p_);
    real t2 = drive_arm_acceleration_2(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t1, t2}};
}

/* estimation/process_model.py:618 _stage */
GM_INLINE void process_model_stage_2(array1_f8 lanes_, int64_t width_, int64_t q_, real part_, bool differ_, tuple_15 torques_, tuple_18 shared_)
{
    array1_f8 z_;
    int64_t at_curve_;
    int64_t i_;
    real u_;
    tuple_18 drive_;
    tuple_9 law_;
    real memory_;
    int64_t at_;
    tuple_8 x_;
    int64_t last_;
    real x3_;
    real x4_;
    real f_;
    real g_;
    z_ = lanes_;
    int64_t t1 = process_model_curve_count((-1));
    at_curve_ = ((5 - t1) * 16);
    for (int64_t k2 = 0; k2 < width_; k2 += 1) {
        i_ = k2;
        tuple_19 t3 = process_model_own_drive(differ_, z_, (416 + i_), torques_, shared_);
        u_ = t3.f0;
        drive_ = t3.f1;
        int64_t t4 = process_model_curve_count((-1));
        tuple_9 t5 = process_model_curve_2((-1), z_, 16, i_, (5 - t4), drive_);
        law_ = t5;
        real t6 = process_model_memory((-1), z_, (at_curve_ + i_), (z_.p[((0 + i_))] - z_.p[((16 + i_))]));
        memory_ = t6;
        at_ = (((5 + q_) * 16) + i_);
        x_ = (tuple_8){{z_.p[((0 + i_))], z_.p[((16 + i_))], z_.p[((32 + i_))], z_.p[((48 + i_))], z_.p[((64 + i_))]}};
        if (((q_ > 0))) {
            last_ = (at_ - 16);
            real t7 = z_.p[gm_at((last_ + 0), z_.n[0])];
            real t8 = z_.p[gm_at((last_ + 64), z_.n[0])];
            x3_ = t7;
            x4_ = t8;
            x_ = (tuple_8){{(x_.v[0] + (part_ * x3_)), (x_.v[1] + (part_ * x4_)), (x_.v[2] + (part_ * z_.p[gm_at((last_ + 128), z_.n[0])])), (x_.v[3] + (part_ * z_.p[gm_at((last_ + 192), z_.n[0])])), (x_.v[4] + ((part_ * drive_.v[26]) * (x3_ - x4_)))}};
        }
        tuple_8 t9 = process_model_bearing_2(x_, (tuple_10){memory_, law_});
        tuple_7 t10 = process_model_accelerations_4(t9, (u_ - z_.p[((at_ + 256))]), z_.p[((400 + i_))], drive_);
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

/* estimation/process_model.py:658 _finish */
GM_INLINE void process_model_finish_2(array1_f8 lanes_, int64_t i_, real sixth_, tuple_18 p_)
{
    array1_f8 z_;
    int64_t at_;
    int64_t at_curve_;
    tuple_9 law_;
    real memory_;
    real moved1_;
    real moved2_;
    z_ = lanes_;
    int64_t t2 = (80 + i_);
    int64_t t1 = process_model_curve_count((-1));
    int64_t t3 = (5 - t1);
    at_ = t2;
    at_curve_ = t3;
    tuple_9 t4 = process_model_curve_2((-1), z_, 16, i_, at_curve_, p_);
    law_ = t4;
    real t5 = process_model_memory((-1), z_, ((at_curve_ * 16) + i_), (real)0.0);
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
    int64_t t12 = process_model_curve_count((-1));
    if (((t12 > 0))) {
        tuple_7 t13 = transmission_play((z_.p[((0 + i_))] - z_.p[((16 + i_))]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
        z_.p[gm_at(((at_curve_ * 16) + i_), z_.n[0])] = t13.v[0];
    }
    return;
}

/* estimation/process_model.py:567 advance_beside */
GM_STATIC void process_model_advance_beside_2(array1_f8 lanes_, int64_t count_, bool differ_, tuple_15 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    int64_t width_;
    real h_;
    int64_t friction_at_;
    real share_;
    tuple_18 drive_;
    int64_t i_;
    int64_t q_;
    int64_t t1 = ((count_ + 3) & (-4));
    real t2 = (dt_ / (real)(n_substeps_));
    width_ = t1;
    h_ = t2;
    int64_t t3 = ((int64_t)(p_.p[29]) * 16);
    friction_at_ = t3;
    share_ = (((p_.p[28] > (real)0.0)) ? (real)1.0 : (real)0.0);
    drive_ = (tuple_18){{p_.p[0], p_.p[1], p_.p[2], p_.p[3], p_.p[4], p_.p[5], p_.p[6], p_.p[7], p_.p[8], p_.p[9], p_.p[10], p_.p[11], p_.p[12], p_.p[13], p_.p[14], p_.p[15], p_.p[16], p_.p[17], p_.p[18], p_.p[19], p_.p[20], p_.p[21], p_.p[22], p_.p[23], p_.p[24], p_.p[25], p_.p[26]}};
    for (int64_t k4 = 0; k4 < width_; k4 += 1) {
        i_ = k4;
        lanes_.p[((400 + i_))] = torques_.v[1];
        for (int64_t k5 = 0; k5 < 4; k5 += 1) {
            q_ = k5;
            lanes_.p[(((336 + (q_ * 16)) + i_))] = (real)0.0;
        }
    }
    for (int64_t k6 = 0; k6 < n_substeps_; k6 += 1) {
        process_model_stage_2(lanes_, width_, 0, (real)0.0, differ_, torques_, drive_);
        process_model_stage_2(lanes_, width_, 1, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage_2(lanes_, width_, 2, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage_2(lanes_, width_, 3, h_, differ_, torques_, drive_);
        for (int64_t k7 = 0; k7 < width_; k7 += 1) {
            i_ = k7;
            process_model_finish_2(lanes_, i_, (h_ / (real)6.0), drive_);
        }
    }
    return;
}

/* estimation/consider.py:126 accompany */
GM_STATIC bool consider_accompany_2(Companions companions_, array1_f8 z_, Reading reading_, tuple_17 used_, array1_f8 record_)
{
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
    for (int64_t k2 = 0; k2 < 5; k2 += 1) {
        j_ = k2;
        for (int64_t k3 = 0; k3 < 16; k3 += 1) {
            i_ = k3;
            lanes_.p[(((j_ * 16) + i_))] = z_.p[(j_)];
        }
        for (int64_t k4 = 0; k4 < count_; k4 += 1) {
            i_ = k4;
            lanes_.p[((((j_ * 16) + 1) + i_))] = (lanes_.p[((((j_ * 16) + 1) + i_))] + s_.p[(((i_ * 5) + j_))]);
        }
    }
    int64_t t6 = (count_ + 1);
    int64_t t5 = drive_substeps(reading_.dt_, (p_.p[30] + faster_));
    process_model_advance_beside_2(lanes_, t6, true, (tuple_15){{reading_.u_, reading_.load_, rate_}}, reading_.dt_, t5, p_);
    tuple_6 t7 = step_record_places(5);
    at_K_ = t7.v[7];
    tuple_20 t8 = step_record_sensitivities(5, record_.n[0]);
    at_predicted_ = t8.v[1];
    at_updated_ = t8.v[2];
    good_ = true;
    for (int64_t k9 = 0; k9 < count_; k9 += 1) {
        i_ = k9;
        at_ = (i_ * 5);
        real t10 = (lanes_.p[((1 + i_))] - lanes_.p[0]);
        real t11 = (lanes_.p[((17 + i_))] - lanes_.p[16]);
        e1_ = t10;
        e2_ = t11;
        for (int64_t k12 = 0; k12 < 5; k12 += 1) {
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
GM_STATIC bool filter_call_aekf_2(array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple_5 t1 = filter_parts_2(95, 3, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < 5; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim_2(belief_, reading_, p_);
    }
    bool t3 = aekf_step_2(belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_17 t4 = aekf_used(belief_.memory_, p_);
    bool t5 = consider_accompany_2(companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/filter_kind.py:86 unchanged */
GM_INLINE tuple_17 filter_kind_unchanged(array1_f8 memory_, array1_f8 p_)
{
    return (tuple_17){p_, (real)0.0};
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_ekf(array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple_5 t1 = filter_parts(1, 1, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < 6; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim(belief_, reading_, p_);
    }
    bool t3 = ekf_step(belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_17 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany(companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_ekf_2(array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple_5 t1 = filter_parts_2(1, 1, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < 5; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim_2(belief_, reading_, p_);
    }
    bool t3 = ekf_step_2(belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_17 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany_2(companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/sigma_points.py:46 cholesky */
GM_INLINE bool sigma_points_cholesky(array1_f8 a_, array1_f8 out_)
{
    int64_t j_;
    real s_;
    int64_t k_;
    real root_;
    real inverse_;
    int64_t i_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        j_ = k1;
        s_ = a_.p[(((j_ * 6) + j_))];
        for (int64_t k2 = 0; k2 < j_; k2 += 1) {
            k_ = k2;
            s_ = (s_ - (out_.p[(((j_ * 6) + k_))] * out_.p[(((j_ * 6) + k_))]));
        }
        if ((!((s_ > (real)0.0)))) {
            return false;
        }
        root_ = gm_sqrt(s_);
        out_.p[(((j_ * 6) + j_))] = root_;
        inverse_ = ((real)1.0 / root_);
        int64_t t3 = (j_ + 1);
        for (int64_t k4 = t3; k4 < 6; k4 += 1) {
            i_ = k4;
            s_ = a_.p[(((i_ * 6) + j_))];
            for (int64_t k5 = 0; k5 < j_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (out_.p[(((i_ * 6) + k_))] * out_.p[(((j_ * 6) + k_))]));
            }
            out_.p[(((i_ * 6) + j_))] = (s_ * inverse_);
            out_.p[(((j_ * 6) + i_))] = (real)0.0;
        }
    }
    return true;
}

/* estimation/filters/srukf.py:169 _upper */
GM_INLINE void srukf_upper(array1_f8 lower_, array2_f8 out_)
{
    int64_t i_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < 6; k2 += 1) {
            j_ = k2;
            out_.p[((i_) * out_.n[1] + (j_))] = lower_.p[(((j_ * 6) + i_))];
        }
    }
    return;
}

/* estimation/filters/srukf.py:187 _noise */
GM_INLINE void srukf_noise(array2_f8 rows_, array1_f8 z_, real dt_, array1_f8 p_)
{
    int64_t i_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < 6; k2 += 1) {
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
GM_INLINE void srukf_lower(array2_f8 upper_, array1_f8 out_)
{
    int64_t i_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < 6; k2 += 1) {
            j_ = k2;
            out_.p[(((i_ * 6) + j_))] = (((j_ <= i_)) ? upper_.p[((j_) * upper_.n[1] + (i_))] : (real)0.0);
        }
    }
    return;
}

/* estimation/process_model.py:643 _own_drive */
GM_INLINE tuple_19 process_model_own_drive_2(array1_f8 lanes_, int64_t at_, tuple_15 torques_, tuple_18 p_)
{
    return (tuple_19){torques_.v[0], p_};
}

/* estimation/process_model.py:618 _stage */
GM_INLINE void process_model_stage_3(array1_f8 lanes_, int64_t width_, int64_t q_, real part_, tuple_15 torques_, tuple_18 shared_)
{
    array1_f8 z_;
    int64_t at_curve_;
    int64_t i_;
    real u_;
    tuple_18 drive_;
    tuple_9 law_;
    real memory_;
    int64_t at_;
    tuple_8 x_;
    int64_t last_;
    real x3_;
    real x4_;
    real f_;
    real g_;
    z_ = lanes_;
    int64_t t1 = process_model_curve_count((-1));
    at_curve_ = ((6 - t1) * 16);
    for (int64_t k2 = 0; k2 < width_; k2 += 1) {
        i_ = k2;
        tuple_19 t3 = process_model_own_drive_2(z_, (432 + i_), torques_, shared_);
        u_ = t3.f0;
        drive_ = t3.f1;
        int64_t t4 = process_model_curve_count((-1));
        tuple_9 t5 = process_model_curve_2((-1), z_, 16, i_, (6 - t4), drive_);
        law_ = t5;
        real t6 = process_model_memory((-1), z_, (at_curve_ + i_), (z_.p[((0 + i_))] - z_.p[((16 + i_))]));
        memory_ = t6;
        at_ = (((6 + q_) * 16) + i_);
        x_ = (tuple_8){{z_.p[((0 + i_))], z_.p[((16 + i_))], z_.p[((32 + i_))], z_.p[((48 + i_))], z_.p[((64 + i_))]}};
        if (((q_ > 0))) {
            last_ = (at_ - 16);
            real t7 = z_.p[gm_at((last_ + 0), z_.n[0])];
            real t8 = z_.p[gm_at((last_ + 64), z_.n[0])];
            x3_ = t7;
            x4_ = t8;
            x_ = (tuple_8){{(x_.v[0] + (part_ * x3_)), (x_.v[1] + (part_ * x4_)), (x_.v[2] + (part_ * z_.p[gm_at((last_ + 128), z_.n[0])])), (x_.v[3] + (part_ * z_.p[gm_at((last_ + 192), z_.n[0])])), (x_.v[4] + ((part_ * drive_.v[26]) * (x3_ - x4_)))}};
        }
        tuple_8 t9 = process_model_bearing(x_, (tuple_10){memory_, law_});
        tuple_7 t10 = process_model_accelerations_2(t9, (u_ - z_.p[((at_ + 256))]), z_.p[((416 + i_))], drive_);
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
GM_STATIC void process_model_advance_beside_3(array1_f8 lanes_, int64_t count_, tuple_15 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    int64_t width_;
    real h_;
    int64_t friction_at_;
    real share_;
    tuple_18 drive_;
    int64_t i_;
    int64_t q_;
    tuple_8 error_;
    int64_t t1 = ((count_ + 3) & (-4));
    real t2 = (dt_ / (real)(n_substeps_));
    width_ = t1;
    h_ = t2;
    int64_t t3 = ((int64_t)(p_.p[29]) * 16);
    friction_at_ = t3;
    share_ = (((p_.p[28] > (real)0.0)) ? (real)1.0 : (real)0.0);
    drive_ = (tuple_18){{p_.p[0], p_.p[1], p_.p[2], p_.p[3], p_.p[4], p_.p[5], p_.p[6], p_.p[7], p_.p[8], p_.p[9], p_.p[10], p_.p[11], p_.p[12], p_.p[13], p_.p[14], p_.p[15], p_.p[16], p_.p[17], p_.p[18], p_.p[19], p_.p[20], p_.p[21], p_.p[22], p_.p[23], p_.p[24], p_.p[25], p_.p[26]}};
    for (int64_t k4 = 0; k4 < width_; k4 += 1) {
        i_ = k4;
        lanes_.p[((416 + i_))] = torques_.v[1];
        lanes_.p[((416 + i_))] = (lanes_.p[((416 + i_))] + (share_ * lanes_.p[((80 + i_))]));
        for (int64_t k5 = 0; k5 < 4; k5 += 1) {
            q_ = k5;
            lanes_.p[(((352 + (q_ * 16)) + i_))] = (real)0.0;
        }
    }
    for (int64_t k6 = 0; k6 < n_substeps_; k6 += 1) {
        if (((friction_at_ > 0))) {
            for (int64_t k7 = 0; k7 < width_; k7 += 1) {
                i_ = k7;
                tuple_8 t8 = process_model_decay(lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])], ((real)0.5 * h_), h_, p_);
                error_ = t8;
                for (int64_t k9 = 0; k9 < 4; k9 += 1) {
                    q_ = k9;
                    lanes_.p[(((352 + (q_ * 16)) + i_))] = error_.v[(q_)];
                }
                lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])] = error_.v[4];
            }
        }
        process_model_stage_3(lanes_, width_, 0, (real)0.0, torques_, drive_);
        process_model_stage_3(lanes_, width_, 1, ((real)0.5 * h_), torques_, drive_);
        process_model_stage_3(lanes_, width_, 2, ((real)0.5 * h_), torques_, drive_);
        process_model_stage_3(lanes_, width_, 3, h_, torques_, drive_);
        for (int64_t k10 = 0; k10 < width_; k10 += 1) {
            i_ = k10;
            process_model_finish(lanes_, i_, (h_ / (real)6.0), drive_);
        }
    }
    return;
}

/* estimation/sigma_points.py:79 transform */
GM_INLINE void sigma_points_transform(array1_f8 z_, array1_f8 factor_, Reading reading_, array1_f8 p_, array2_f8 rows_, array2_f8 matrices_)
{
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
    dt_ = reading_.dt_;
    int64_t t1 = gm_bound(432, 612);
    lanes_ = (array1_f8){matrices_.p, {t1}};
    int64_t t2 = drive_substeps(dt_, p_.p[30]);
    counted_ = t2;
    alpha2_ = (p_.p[38] * p_.p[38]);
    spread_ = gm_sqrt((alpha2_ * ((real)6.0 + p_.p[40])));
    root_ = ((real)1.0 / spread_);
    weight_ = (root_ * root_);
    shared_ = (((real)1.0 - gm_sqrt(((real)1.0 + (((p_.p[39] - alpha2_) * (real)6.0) * weight_)))) / (real)6.0);
    for (int64_t k3 = 0; k3 < 6; k3 += 1) {
        j_ = k3;
        int64_t t4 = (j_ * 16);
        real t5 = z_.p[(j_)];
        at_ = t4;
        centre_ = t5;
        for (int64_t k6 = 0; k6 < 16; k6 += 1) {
            i_ = k6;
            lanes_.p[((at_ + i_))] = centre_;
        }
        for (int64_t k7 = 0; k7 < 6; k7 += 1) {
            i_ = k7;
            lanes_.p[((at_ + i_))] = (centre_ + (spread_ * factor_.p[(((j_ * 6) + i_))]));
            lanes_.p[(((at_ + 6) + i_))] = (centre_ - (spread_ * factor_.p[(((j_ * 6) + i_))]));
        }
    }
    for (int64_t k8 = 0; k8 < counted_; k8 += 1) {
        process_model_advance_beside_3(lanes_, 13, (tuple_15){{reading_.u_, reading_.load_, (real)0.0}}, (dt_ / (real)(counted_)), 1, p_);
    }
    for (int64_t k9 = 0; k9 < 6; k9 += 1) {
        j_ = k9;
        int64_t t10 = (j_ * 16);
        real t11 = lanes_.p[(((j_ * 16) + 12))];
        at_ = t10;
        centre_ = t11;
        bends_ = (real)0.0;
        for (int64_t k12 = 0; k12 < 6; k12 += 1) {
            i_ = k12;
            real t13 = (lanes_.p[((at_ + i_))] - centre_);
            real t14 = (lanes_.p[(((at_ + 6) + i_))] - centre_);
            plus_ = t13;
            minus_ = t14;
            bend_ = ((real)0.5 * (plus_ + minus_));
            rows_.p[((i_) * rows_.n[1] + (j_))] = (((real)0.5 * root_) * (plus_ - minus_));
            rows_.p[(((6 + i_)) * rows_.n[1] + (j_))] = bend_;
            bends_ = (bends_ + bend_);
        }
        z_.p[(j_)] = (centre_ + (weight_ * bends_));
        for (int64_t k15 = 0; k15 < 6; k15 += 1) {
            i_ = k15;
            rows_.p[(((6 + i_)) * rows_.n[1] + (j_))] = (root_ * (rows_.p[(((6 + i_)) * rows_.n[1] + (j_))] - (shared_ * bends_)));
        }
    }
    return;
}

/* kernels/linalg.py:195 _added */
GM_INLINE tuple_21 linalg_added(int64_t n_, real v_, array1_f8 b_, int64_t at_, tuple_21 row_)
{
    return (tuple_21){{(row_.v[0] + (v_ * b_.p[(at_)])), (row_.v[1] + (v_ * b_.p[((at_ + 1))])), (row_.v[2] + (v_ * b_.p[((at_ + 2))])), (row_.v[3] + (v_ * b_.p[((at_ + 3))])), (row_.v[4] + (v_ * b_.p[((at_ + 4))])), (((n_ > 5)) ? (row_.v[5] + (v_ * b_.p[((at_ + 5))])) : (real)0.0), (((n_ > 6)) ? (row_.v[6] + (v_ * b_.p[((at_ + 6))])) : (real)0.0), (((n_ > 7)) ? (row_.v[7] + (v_ * b_.p[((at_ + 7))])) : (real)0.0), (((n_ > 8)) ? (row_.v[8] + (v_ * b_.p[((at_ + 8))])) : (real)0.0), (((n_ > 9)) ? (row_.v[9] + (v_ * b_.p[((at_ + 9))])) : (real)0.0), (((n_ > 10)) ? (row_.v[10] + (v_ * b_.p[((at_ + 10))])) : (real)0.0)}};
}

/* kernels/linalg.py:252 _put */
GM_INLINE void linalg_put(int64_t n_, tuple_21 row_, array1_f8 out_, int64_t at_)
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

/* kernels/linalg.py:281 add_transposed_product */
GM_INLINE void linalg_add_transposed_product(array1_f8 a_, array1_f8 b_, int64_t length_, array1_f8 out_)
{
    int64_t i_;
    tuple_21 row_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        tuple_21 t2 = linalg_added(6, (real)1.0, out_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < length_; k3 += 1) {
            k_ = k3;
            tuple_21 t4 = linalg_added(6, a_.p[(((k_ * 6) + i_))], b_, (k_ * 6), row_);
            row_ = t4;
        }
        linalg_put(6, row_, out_, (i_ * 6));
    }
    return;
}

/* estimation/sigma_points.py:128 cross_covariance */
GM_INLINE void sigma_points_cross_covariance(array2_f8 rows_, array1_f8 factor_, array1_f8 P_, array1_f8 slope_, array1_f8 out_)
{
    int64_t j_;
    real inverse_;
    int64_t r_;
    real s_;
    int64_t k_;
    int64_t i_;
    for (int64_t k1 = 5; k1 > (-1); k1 += -1) {
        j_ = k1;
        inverse_ = ((real)1.0 / factor_.p[(((j_ * 6) + j_))]);
        for (int64_t k2 = 0; k2 < 6; k2 += 1) {
            r_ = k2;
            s_ = rows_.p[((j_) * rows_.n[1] + (r_))];
            int64_t t3 = (j_ + 1);
            for (int64_t k4 = t3; k4 < 6; k4 += 1) {
                k_ = k4;
                s_ = (s_ - (slope_.p[(((k_ * 6) + r_))] * factor_.p[(((k_ * 6) + j_))]));
            }
            slope_.p[(((j_ * 6) + r_))] = (s_ * inverse_);
        }
    }
    for (int64_t k5 = 0; k5 < 36; k5 += 1) {
        i_ = k5;
        out_.p[(i_)] = (real)0.0;
    }
    linalg_add_transposed_product(slope_, P_, 6, out_);
    return;
}

/* estimation/filters/srukf.py:197 _square */
GM_INLINE void srukf_square(array1_f8 factor_, array1_f8 out_, int64_t at_)
{
    int64_t i_;
    int64_t j_;
    real s_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        int64_t t2 = (i_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            j_ = k3;
            s_ = (real)0.0;
            int64_t t4 = (j_ + 1);
            for (int64_t k5 = 0; k5 < t4; k5 += 1) {
                k_ = k5;
                s_ = (s_ + (factor_.p[(((i_ * 6) + k_))] * factor_.p[(((j_ * 6) + k_))]));
            }
            real t6 = s_;
            real t7 = s_;
            out_.p[(((at_ + (i_ * 6)) + j_))] = t6;
            out_.p[(((at_ + (j_ * 6)) + i_))] = t7;
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
GM_INLINE bool srukf_update(array1_f8 mean_, array1_f8 factor_, real y1_, real y2_, array1_f8 p_, array2_f8 array_, array1_f8 record_)
{
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
    tuple_6 t1 = step_record_places(6);
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
    record_.p[((at_S_ + 2))] = (record_.p[(((at_P_ + 6) + 1))] + p_.p[32]);
    real t8 = (have1_ ? gm_sqrt(p_.p[31]) : (real)1.0);
    array_.p[0] = t8;
    array_.p[1] = (real)0.0;
    real t9 = (have2_ ? gm_sqrt(p_.p[32]) : (real)1.0);
    array_.p[(1 * array_.n[1] + 0)] = (real)0.0;
    array_.p[(1 * array_.n[1] + 1)] = t9;
    for (int64_t k10 = 0; k10 < 2; k10 += 1) {
        i_ = k10;
        array_.p[(((2 + i_)) * array_.n[1] + 0)] = (have1_ ? factor_.p[(i_)] : (real)0.0);
        array_.p[(((2 + i_)) * array_.n[1] + 1)] = (have2_ ? factor_.p[((6 + i_))] : (real)0.0);
        for (int64_t k11 = 0; k11 < 6; k11 += 1) {
            j_ = k11;
            array_.p[((i_) * array_.n[1] + ((2 + j_)))] = (real)0.0;
            array_.p[(((2 + i_)) * array_.n[1] + ((2 + j_)))] = factor_.p[(((j_ * 6) + i_))];
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
    for (int64_t k15 = 0; k15 < 6; k15 += 1) {
        i_ = k15;
        mean_.p[(i_)] = (mean_.p[(i_)] + ((array_.p[((2 + i_))] * white1_) + (array_.p[(1 * array_.n[1] + ((2 + i_)))] * white2_)));
        k2_ = (array_.p[(1 * array_.n[1] + ((2 + i_)))] / s22_);
        real t16 = ((array_.p[((2 + i_))] - (k2_ * s21_)) / s11_);
        record_.p[((at_K_ + (2 * i_)))] = t16;
        record_.p[(((at_K_ + (2 * i_)) + 1))] = k2_;
        factor_.p[((i_ * 6))] = array_.p[(2 * array_.n[1] + ((2 + i_)))];
        if (((i_ > 0))) {
            factor_.p[(((i_ * 6) + 1))] = array_.p[(3 * array_.n[1] + ((2 + i_)))];
        }
    }
    return true;
}

/* estimation/filters/srukf.py:30 step */
GM_APART bool srukf_step(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
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
    dt_ = reading_.dt_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    memory_ = belief_.memory_;
    vectors_ = scratch_.vectors_;
    matrices_ = scratch_.matrices_;
    tuple_6 t1 = step_record_places(6);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_out_ = t1.v[3];
    at_P_out_ = t1.v[4];
    mean_ = (array1_f8){vectors_.p + 0 * (vectors_.n[1]), {vectors_.n[1]}};
    factor_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    if (((memory_.p[0] == (real)0.0))) {
        bool t2 = sigma_points_cholesky(P_, factor_);
        if ((!t2)) {
            return false;
        }
    } else {
        for (int64_t k3 = 0; k3 < 36; k3 += 1) {
            i_ = k3;
            factor_.p[(i_)] = memory_.p[(i_)];
        }
    }
    for (int64_t k4 = 0; k4 < 6; k4 += 1) {
        i_ = k4;
        mean_.p[(i_)] = z_.p[(i_)];
    }
    int64_t t5 = gm_bound(1, matrices_.n[0]);
    int64_t t6 = gm_bound(4, matrices_.n[0]);
    int64_t t7 = gm_span(t5, t6);
    rows_ = (array2_f8){matrices_.p + t5 * (matrices_.n[1]), {18, 6}};
    srukf_upper(factor_, rows_);
    int64_t t8 = gm_bound(6, rows_.n[0]);
    int64_t t9 = gm_span(t8, rows_.n[0]);
    srukf_noise((array2_f8){rows_.p + t8 * (rows_.n[1]), {t9, rows_.n[1]}}, mean_, dt_, p_);
    int64_t t10 = gm_bound(12, rows_.n[0]);
    srukf_triangularise((array2_f8){rows_.p, {t10, rows_.n[1]}}, 6, 0, 6);
    srukf_lower(rows_, factor_);
    int64_t t11 = gm_bound(7, matrices_.n[0]);
    int64_t t12 = gm_span(t11, matrices_.n[0]);
    sigma_points_transform(mean_, factor_, reading_, p_, rows_, (array2_f8){matrices_.p + t11 * (matrices_.n[1]), {t12, matrices_.n[1]}});
    int64_t t13 = (at_cross_ + 36);
    int64_t t14 = gm_bound(at_cross_, record_.n[0]);
    int64_t t15 = gm_bound(t13, record_.n[0]);
    int64_t t16 = gm_span(t14, t15);
    sigma_points_cross_covariance(rows_, factor_, P_, (array1_f8){matrices_.p + 6 * (matrices_.n[1]), {matrices_.n[1]}}, (array1_f8){record_.p + t14 * (1), {t16}});
    int64_t t17 = gm_bound(12, rows_.n[0]);
    int64_t t18 = gm_span(t17, rows_.n[0]);
    srukf_noise((array2_f8){rows_.p + t17 * (rows_.n[1]), {t18, rows_.n[1]}}, mean_, dt_, p_);
    srukf_triangularise(rows_, 6, 12, 12);
    srukf_lower(rows_, factor_);
    srukf_square(factor_, record_, at_P_);
    for (int64_t k19 = 0; k19 < 6; k19 += 1) {
        i_ = k19;
        record_.p[((at_z_ + i_))] = mean_.p[(i_)];
    }
    int64_t t20 = gm_bound(4, matrices_.n[0]);
    int64_t t21 = gm_bound(6, matrices_.n[0]);
    int64_t t22 = gm_span(t20, t21);
    int64_t t23 = gm_bound(32, 72);
    array_ = (array2_f8){matrices_.p + t20 * (matrices_.n[1]), {4, 8}};
    bool t24 = srukf_update(mean_, factor_, reading_.y1_, reading_.y2_, p_, array_, record_);
    if ((!t24)) {
        return false;
    }
    srukf_square(factor_, P_, 0);
    for (int64_t k25 = 0; k25 < 6; k25 += 1) {
        i_ = k25;
        z_.p[(i_)] = mean_.p[(i_)];
        record_.p[((at_z_out_ + i_))] = z_.p[(i_)];
    }
    for (int64_t k26 = 0; k26 < 36; k26 += 1) {
        i_ = k26;
        record_.p[((at_P_out_ + i_))] = P_.p[(i_)];
        memory_.p[(i_)] = factor_.p[(i_)];
    }
    bool t27 = ekf_healthy(belief_);
    return t27;
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_srukf(array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple_5 t1 = filter_parts(1, 24, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < 6; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim(belief_, reading_, p_);
    }
    bool t3 = srukf_step(belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_17 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany(companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/sigma_points.py:46 cholesky */
GM_INLINE bool sigma_points_cholesky_2(array1_f8 a_, array1_f8 out_)
{
    int64_t j_;
    real s_;
    int64_t k_;
    real root_;
    real inverse_;
    int64_t i_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        j_ = k1;
        s_ = a_.p[(((j_ * 5) + j_))];
        for (int64_t k2 = 0; k2 < j_; k2 += 1) {
            k_ = k2;
            s_ = (s_ - (out_.p[(((j_ * 5) + k_))] * out_.p[(((j_ * 5) + k_))]));
        }
        if ((!((s_ > (real)0.0)))) {
            return false;
        }
        root_ = gm_sqrt(s_);
        out_.p[(((j_ * 5) + j_))] = root_;
        inverse_ = ((real)1.0 / root_);
        int64_t t3 = (j_ + 1);
        for (int64_t k4 = t3; k4 < 5; k4 += 1) {
            i_ = k4;
            s_ = a_.p[(((i_ * 5) + j_))];
            for (int64_t k5 = 0; k5 < j_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (out_.p[(((i_ * 5) + k_))] * out_.p[(((j_ * 5) + k_))]));
            }
            out_.p[(((i_ * 5) + j_))] = (s_ * inverse_);
            out_.p[(((j_ * 5) + i_))] = (real)0.0;
        }
    }
    return true;
}

/* estimation/filters/srukf.py:169 _upper */
GM_INLINE void srukf_upper_2(array1_f8 lower_, array2_f8 out_)
{
    int64_t i_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < 5; k2 += 1) {
            j_ = k2;
            out_.p[((i_) * out_.n[1] + (j_))] = lower_.p[(((j_ * 5) + i_))];
        }
    }
    return;
}

/* estimation/filters/srukf.py:187 _noise */
GM_INLINE void srukf_noise_2(array2_f8 rows_, array1_f8 z_, real dt_, array1_f8 p_)
{
    int64_t i_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < 5; k2 += 1) {
            j_ = k2;
            rows_.p[((i_) * rows_.n[1] + (j_))] = (real)0.0;
        }
        real t4 = ((real)0.5 * dt_);
        real t3 = process_model_noise(z_, p_, i_);
        rows_.p[((i_) * rows_.n[1] + (i_))] = gm_sqrt((t4 * t3));
    }
    return;
}

/* estimation/filters/srukf.py:178 _lower */
GM_INLINE void srukf_lower_2(array2_f8 upper_, array1_f8 out_)
{
    int64_t i_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < 5; k2 += 1) {
            j_ = k2;
            out_.p[(((i_ * 5) + j_))] = (((j_ <= i_)) ? upper_.p[((j_) * upper_.n[1] + (i_))] : (real)0.0);
        }
    }
    return;
}

/* estimation/process_model.py:618 _stage */
GM_INLINE void process_model_stage_4(array1_f8 lanes_, int64_t width_, int64_t q_, real part_, tuple_15 torques_, tuple_18 shared_)
{
    array1_f8 z_;
    int64_t at_curve_;
    int64_t i_;
    real u_;
    tuple_18 drive_;
    tuple_9 law_;
    real memory_;
    int64_t at_;
    tuple_8 x_;
    int64_t last_;
    real x3_;
    real x4_;
    real f_;
    real g_;
    z_ = lanes_;
    int64_t t1 = process_model_curve_count((-1));
    at_curve_ = ((5 - t1) * 16);
    for (int64_t k2 = 0; k2 < width_; k2 += 1) {
        i_ = k2;
        tuple_19 t3 = process_model_own_drive_2(z_, (416 + i_), torques_, shared_);
        u_ = t3.f0;
        drive_ = t3.f1;
        int64_t t4 = process_model_curve_count((-1));
        tuple_9 t5 = process_model_curve_2((-1), z_, 16, i_, (5 - t4), drive_);
        law_ = t5;
        real t6 = process_model_memory((-1), z_, (at_curve_ + i_), (z_.p[((0 + i_))] - z_.p[((16 + i_))]));
        memory_ = t6;
        at_ = (((5 + q_) * 16) + i_);
        x_ = (tuple_8){{z_.p[((0 + i_))], z_.p[((16 + i_))], z_.p[((32 + i_))], z_.p[((48 + i_))], z_.p[((64 + i_))]}};
        if (((q_ > 0))) {
            last_ = (at_ - 16);
            real t7 = z_.p[gm_at((last_ + 0), z_.n[0])];
            real t8 = z_.p[gm_at((last_ + 64), z_.n[0])];
            x3_ = t7;
            x4_ = t8;
            x_ = (tuple_8){{(x_.v[0] + (part_ * x3_)), (x_.v[1] + (part_ * x4_)), (x_.v[2] + (part_ * z_.p[gm_at((last_ + 128), z_.n[0])])), (x_.v[3] + (part_ * z_.p[gm_at((last_ + 192), z_.n[0])])), (x_.v[4] + ((part_ * drive_.v[26]) * (x3_ - x4_)))}};
        }
        tuple_8 t9 = process_model_bearing_2(x_, (tuple_10){memory_, law_});
        tuple_7 t10 = process_model_accelerations_4(t9, (u_ - z_.p[((at_ + 256))]), z_.p[((400 + i_))], drive_);
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
GM_STATIC void process_model_advance_beside_4(array1_f8 lanes_, int64_t count_, tuple_15 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    int64_t width_;
    real h_;
    int64_t friction_at_;
    real share_;
    tuple_18 drive_;
    int64_t i_;
    int64_t q_;
    int64_t t1 = ((count_ + 3) & (-4));
    real t2 = (dt_ / (real)(n_substeps_));
    width_ = t1;
    h_ = t2;
    int64_t t3 = ((int64_t)(p_.p[29]) * 16);
    friction_at_ = t3;
    share_ = (((p_.p[28] > (real)0.0)) ? (real)1.0 : (real)0.0);
    drive_ = (tuple_18){{p_.p[0], p_.p[1], p_.p[2], p_.p[3], p_.p[4], p_.p[5], p_.p[6], p_.p[7], p_.p[8], p_.p[9], p_.p[10], p_.p[11], p_.p[12], p_.p[13], p_.p[14], p_.p[15], p_.p[16], p_.p[17], p_.p[18], p_.p[19], p_.p[20], p_.p[21], p_.p[22], p_.p[23], p_.p[24], p_.p[25], p_.p[26]}};
    for (int64_t k4 = 0; k4 < width_; k4 += 1) {
        i_ = k4;
        lanes_.p[((400 + i_))] = torques_.v[1];
        for (int64_t k5 = 0; k5 < 4; k5 += 1) {
            q_ = k5;
            lanes_.p[(((336 + (q_ * 16)) + i_))] = (real)0.0;
        }
    }
    for (int64_t k6 = 0; k6 < n_substeps_; k6 += 1) {
        process_model_stage_4(lanes_, width_, 0, (real)0.0, torques_, drive_);
        process_model_stage_4(lanes_, width_, 1, ((real)0.5 * h_), torques_, drive_);
        process_model_stage_4(lanes_, width_, 2, ((real)0.5 * h_), torques_, drive_);
        process_model_stage_4(lanes_, width_, 3, h_, torques_, drive_);
        for (int64_t k7 = 0; k7 < width_; k7 += 1) {
            i_ = k7;
            process_model_finish_2(lanes_, i_, (h_ / (real)6.0), drive_);
        }
    }
    return;
}

/* estimation/sigma_points.py:79 transform */
GM_INLINE void sigma_points_transform_2(array1_f8 z_, array1_f8 factor_, Reading reading_, array1_f8 p_, array2_f8 rows_, array2_f8 matrices_)
{
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
    dt_ = reading_.dt_;
    int64_t t1 = gm_bound(416, 425);
    lanes_ = (array1_f8){matrices_.p, {t1}};
    int64_t t2 = drive_substeps(dt_, p_.p[30]);
    counted_ = t2;
    alpha2_ = (p_.p[38] * p_.p[38]);
    spread_ = gm_sqrt((alpha2_ * ((real)5.0 + p_.p[40])));
    root_ = ((real)1.0 / spread_);
    weight_ = (root_ * root_);
    shared_ = (((real)1.0 - gm_sqrt(((real)1.0 + (((p_.p[39] - alpha2_) * (real)5.0) * weight_)))) / (real)5.0);
    for (int64_t k3 = 0; k3 < 5; k3 += 1) {
        j_ = k3;
        int64_t t4 = (j_ * 16);
        real t5 = z_.p[(j_)];
        at_ = t4;
        centre_ = t5;
        for (int64_t k6 = 0; k6 < 16; k6 += 1) {
            i_ = k6;
            lanes_.p[((at_ + i_))] = centre_;
        }
        for (int64_t k7 = 0; k7 < 5; k7 += 1) {
            i_ = k7;
            lanes_.p[((at_ + i_))] = (centre_ + (spread_ * factor_.p[(((j_ * 5) + i_))]));
            lanes_.p[(((at_ + 5) + i_))] = (centre_ - (spread_ * factor_.p[(((j_ * 5) + i_))]));
        }
    }
    for (int64_t k8 = 0; k8 < counted_; k8 += 1) {
        process_model_advance_beside_4(lanes_, 11, (tuple_15){{reading_.u_, reading_.load_, (real)0.0}}, (dt_ / (real)(counted_)), 1, p_);
    }
    for (int64_t k9 = 0; k9 < 5; k9 += 1) {
        j_ = k9;
        int64_t t10 = (j_ * 16);
        real t11 = lanes_.p[(((j_ * 16) + 10))];
        at_ = t10;
        centre_ = t11;
        bends_ = (real)0.0;
        for (int64_t k12 = 0; k12 < 5; k12 += 1) {
            i_ = k12;
            real t13 = (lanes_.p[((at_ + i_))] - centre_);
            real t14 = (lanes_.p[(((at_ + 5) + i_))] - centre_);
            plus_ = t13;
            minus_ = t14;
            bend_ = ((real)0.5 * (plus_ + minus_));
            rows_.p[((i_) * rows_.n[1] + (j_))] = (((real)0.5 * root_) * (plus_ - minus_));
            rows_.p[(((5 + i_)) * rows_.n[1] + (j_))] = bend_;
            bends_ = (bends_ + bend_);
        }
        z_.p[(j_)] = (centre_ + (weight_ * bends_));
        for (int64_t k15 = 0; k15 < 5; k15 += 1) {
            i_ = k15;
            rows_.p[(((5 + i_)) * rows_.n[1] + (j_))] = (root_ * (rows_.p[(((5 + i_)) * rows_.n[1] + (j_))] - (shared_ * bends_)));
        }
    }
    return;
}

/* kernels/linalg.py:281 add_transposed_product */
GM_INLINE void linalg_add_transposed_product_2(array1_f8 a_, array1_f8 b_, int64_t length_, array1_f8 out_)
{
    int64_t i_;
    tuple_21 row_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        tuple_21 t2 = linalg_added(5, (real)1.0, out_, (i_ * 5), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < length_; k3 += 1) {
            k_ = k3;
            tuple_21 t4 = linalg_added(5, a_.p[(((k_ * 5) + i_))], b_, (k_ * 5), row_);
            row_ = t4;
        }
        linalg_put(5, row_, out_, (i_ * 5));
    }
    return;
}

/* estimation/sigma_points.py:128 cross_covariance */
GM_INLINE void sigma_points_cross_covariance_2(array2_f8 rows_, array1_f8 factor_, array1_f8 P_, array1_f8 slope_, array1_f8 out_)
{
    int64_t j_;
    real inverse_;
    int64_t r_;
    real s_;
    int64_t k_;
    int64_t i_;
    for (int64_t k1 = 4; k1 > (-1); k1 += -1) {
        j_ = k1;
        inverse_ = ((real)1.0 / factor_.p[(((j_ * 5) + j_))]);
        for (int64_t k2 = 0; k2 < 5; k2 += 1) {
            r_ = k2;
            s_ = rows_.p[((j_) * rows_.n[1] + (r_))];
            int64_t t3 = (j_ + 1);
            for (int64_t k4 = t3; k4 < 5; k4 += 1) {
                k_ = k4;
                s_ = (s_ - (slope_.p[(((k_ * 5) + r_))] * factor_.p[(((k_ * 5) + j_))]));
            }
            slope_.p[(((j_ * 5) + r_))] = (s_ * inverse_);
        }
    }
    for (int64_t k5 = 0; k5 < 25; k5 += 1) {
        i_ = k5;
        out_.p[(i_)] = (real)0.0;
    }
    linalg_add_transposed_product_2(slope_, P_, 5, out_);
    return;
}

/* estimation/filters/srukf.py:197 _square */
GM_INLINE void srukf_square_2(array1_f8 factor_, array1_f8 out_, int64_t at_)
{
    int64_t i_;
    int64_t j_;
    real s_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        int64_t t2 = (i_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            j_ = k3;
            s_ = (real)0.0;
            int64_t t4 = (j_ + 1);
            for (int64_t k5 = 0; k5 < t4; k5 += 1) {
                k_ = k5;
                s_ = (s_ + (factor_.p[(((i_ * 5) + k_))] * factor_.p[(((j_ * 5) + k_))]));
            }
            real t6 = s_;
            real t7 = s_;
            out_.p[(((at_ + (i_ * 5)) + j_))] = t6;
            out_.p[(((at_ + (j_ * 5)) + i_))] = t7;
        }
    }
    return;
}

/* estimation/filters/srukf.py:82 _update */
GM_INLINE bool srukf_update_2(array1_f8 mean_, array1_f8 factor_, real y1_, real y2_, array1_f8 p_, array2_f8 array_, array1_f8 record_)
{
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
    tuple_6 t1 = step_record_places(5);
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
    record_.p[((at_S_ + 2))] = (record_.p[(((at_P_ + 5) + 1))] + p_.p[32]);
    real t8 = (have1_ ? gm_sqrt(p_.p[31]) : (real)1.0);
    array_.p[0] = t8;
    array_.p[1] = (real)0.0;
    real t9 = (have2_ ? gm_sqrt(p_.p[32]) : (real)1.0);
    array_.p[(1 * array_.n[1] + 0)] = (real)0.0;
    array_.p[(1 * array_.n[1] + 1)] = t9;
    for (int64_t k10 = 0; k10 < 2; k10 += 1) {
        i_ = k10;
        array_.p[(((2 + i_)) * array_.n[1] + 0)] = (have1_ ? factor_.p[(i_)] : (real)0.0);
        array_.p[(((2 + i_)) * array_.n[1] + 1)] = (have2_ ? factor_.p[((5 + i_))] : (real)0.0);
        for (int64_t k11 = 0; k11 < 5; k11 += 1) {
            j_ = k11;
            array_.p[((i_) * array_.n[1] + ((2 + j_)))] = (real)0.0;
            array_.p[(((2 + i_)) * array_.n[1] + ((2 + j_)))] = factor_.p[(((j_ * 5) + i_))];
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
    for (int64_t k15 = 0; k15 < 5; k15 += 1) {
        i_ = k15;
        mean_.p[(i_)] = (mean_.p[(i_)] + ((array_.p[((2 + i_))] * white1_) + (array_.p[(1 * array_.n[1] + ((2 + i_)))] * white2_)));
        k2_ = (array_.p[(1 * array_.n[1] + ((2 + i_)))] / s22_);
        real t16 = ((array_.p[((2 + i_))] - (k2_ * s21_)) / s11_);
        record_.p[((at_K_ + (2 * i_)))] = t16;
        record_.p[(((at_K_ + (2 * i_)) + 1))] = k2_;
        factor_.p[((i_ * 5))] = array_.p[(2 * array_.n[1] + ((2 + i_)))];
        if (((i_ > 0))) {
            factor_.p[(((i_ * 5) + 1))] = array_.p[(3 * array_.n[1] + ((2 + i_)))];
        }
    }
    return true;
}

/* estimation/filters/srukf.py:30 step */
GM_APART bool srukf_step_2(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
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
    dt_ = reading_.dt_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    memory_ = belief_.memory_;
    vectors_ = scratch_.vectors_;
    matrices_ = scratch_.matrices_;
    tuple_6 t1 = step_record_places(5);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_out_ = t1.v[3];
    at_P_out_ = t1.v[4];
    mean_ = (array1_f8){vectors_.p + 0 * (vectors_.n[1]), {vectors_.n[1]}};
    factor_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    if (((memory_.p[0] == (real)0.0))) {
        bool t2 = sigma_points_cholesky_2(P_, factor_);
        if ((!t2)) {
            return false;
        }
    } else {
        for (int64_t k3 = 0; k3 < 25; k3 += 1) {
            i_ = k3;
            factor_.p[(i_)] = memory_.p[(i_)];
        }
    }
    for (int64_t k4 = 0; k4 < 5; k4 += 1) {
        i_ = k4;
        mean_.p[(i_)] = z_.p[(i_)];
    }
    int64_t t5 = gm_bound(1, matrices_.n[0]);
    int64_t t6 = gm_bound(4, matrices_.n[0]);
    int64_t t7 = gm_span(t5, t6);
    rows_ = (array2_f8){matrices_.p + t5 * (matrices_.n[1]), {15, 5}};
    srukf_upper_2(factor_, rows_);
    int64_t t8 = gm_bound(5, rows_.n[0]);
    int64_t t9 = gm_span(t8, rows_.n[0]);
    srukf_noise_2((array2_f8){rows_.p + t8 * (rows_.n[1]), {t9, rows_.n[1]}}, mean_, dt_, p_);
    int64_t t10 = gm_bound(10, rows_.n[0]);
    srukf_triangularise((array2_f8){rows_.p, {t10, rows_.n[1]}}, 5, 0, 5);
    srukf_lower_2(rows_, factor_);
    int64_t t11 = gm_bound(7, matrices_.n[0]);
    int64_t t12 = gm_span(t11, matrices_.n[0]);
    sigma_points_transform_2(mean_, factor_, reading_, p_, rows_, (array2_f8){matrices_.p + t11 * (matrices_.n[1]), {t12, matrices_.n[1]}});
    int64_t t13 = (at_cross_ + 25);
    int64_t t14 = gm_bound(at_cross_, record_.n[0]);
    int64_t t15 = gm_bound(t13, record_.n[0]);
    int64_t t16 = gm_span(t14, t15);
    sigma_points_cross_covariance_2(rows_, factor_, P_, (array1_f8){matrices_.p + 6 * (matrices_.n[1]), {matrices_.n[1]}}, (array1_f8){record_.p + t14 * (1), {t16}});
    int64_t t17 = gm_bound(10, rows_.n[0]);
    int64_t t18 = gm_span(t17, rows_.n[0]);
    srukf_noise_2((array2_f8){rows_.p + t17 * (rows_.n[1]), {t18, rows_.n[1]}}, mean_, dt_, p_);
    srukf_triangularise(rows_, 5, 10, 10);
    srukf_lower_2(rows_, factor_);
    srukf_square_2(factor_, record_, at_P_);
    for (int64_t k19 = 0; k19 < 5; k19 += 1) {
        i_ = k19;
        record_.p[((at_z_ + i_))] = mean_.p[(i_)];
    }
    int64_t t20 = gm_bound(4, matrices_.n[0]);
    int64_t t21 = gm_bound(6, matrices_.n[0]);
    int64_t t22 = gm_span(t20, t21);
    int64_t t23 = gm_bound(28, 50);
    array_ = (array2_f8){matrices_.p + t20 * (matrices_.n[1]), {4, 7}};
    bool t24 = srukf_update_2(mean_, factor_, reading_.y1_, reading_.y2_, p_, array_, record_);
    if ((!t24)) {
        return false;
    }
    srukf_square_2(factor_, P_, 0);
    for (int64_t k25 = 0; k25 < 5; k25 += 1) {
        i_ = k25;
        z_.p[(i_)] = mean_.p[(i_)];
        record_.p[((at_z_out_ + i_))] = z_.p[(i_)];
    }
    for (int64_t k26 = 0; k26 < 25; k26 += 1) {
        i_ = k26;
        record_.p[((at_P_out_ + i_))] = P_.p[(i_)];
        memory_.p[(i_)] = factor_.p[(i_)];
    }
    bool t27 = ekf_healthy_2(belief_);
    return t27;
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_srukf_2(array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple_5 t1 = filter_parts_2(1, 24, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < 5; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim_2(belief_, reading_, p_);
    }
    bool t3 = srukf_step_2(belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_17 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany_2(companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/filters/ukf.py:38 predict */
GM_INLINE bool ukf_predict(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
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
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    matrices_ = scratch_.matrices_;
    tuple_6 t1 = step_record_places(6);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    int64_t t2 = gm_bound(2, matrices_.n[0]);
    int64_t t3 = gm_bound(4, matrices_.n[0]);
    int64_t t4 = gm_span(t2, t3);
    factor_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    slope_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    rows_ = (array2_f8){matrices_.p + t2 * (matrices_.n[1]), {12, 6}};
    int64_t t5 = (at_cross_ + 36);
    int64_t t6 = gm_bound(at_cross_, record_.n[0]);
    int64_t t7 = gm_bound(t5, record_.n[0]);
    int64_t t8 = gm_span(t6, t7);
    int64_t t9 = (at_P_ + 36);
    int64_t t10 = gm_bound(at_P_, record_.n[0]);
    int64_t t11 = gm_bound(t9, record_.n[0]);
    int64_t t12 = gm_span(t10, t11);
    cross_ = (array1_f8){record_.p + t6 * (1), {t8}};
    P_pred_ = (array1_f8){record_.p + t10 * (1), {t12}};
    for (int64_t k13 = 0; k13 < 6; k13 += 1) {
        i_ = k13;
        for (int64_t k14 = 0; k14 < 6; k14 += 1) {
            j_ = k14;
            slope_.p[(((i_ * 6) + j_))] = P_.p[(((i_ * 6) + j_))];
        }
        real t17 = slope_.p[(((i_ * 6) + i_))];
        real t16 = ((real)0.5 * dt_);
        real t15 = process_model_noise(z_, p_, i_);
        slope_.p[(((i_ * 6) + i_))] = (t17 + (t16 * t15));
    }
    bool t18 = sigma_points_cholesky(slope_, factor_);
    if ((!t18)) {
        return false;
    }
    int64_t t19 = gm_bound(4, matrices_.n[0]);
    int64_t t20 = gm_span(t19, matrices_.n[0]);
    sigma_points_transform(z_, factor_, reading_, p_, rows_, (array2_f8){matrices_.p + t19 * (matrices_.n[1]), {t20, matrices_.n[1]}});
    sigma_points_cross_covariance(rows_, factor_, P_, slope_, cross_);
    for (int64_t k21 = 0; k21 < 6; k21 += 1) {
        i_ = k21;
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
        for (int64_t k22 = 0; k22 < 6; k22 += 1) {
            j_ = k22;
            real t25;
            if (((i_ == j_))) {
            real t24 = ((real)0.5 * dt_);
            real t23 = process_model_noise(z_, p_, i_);
                t25 = (t24 * t23);
            } else {
                t25 = (real)0.0;
            }
            P_pred_.p[(((i_ * 6) + j_))] = t25;
        }
    }
    int64_t t26 = gm_bound(2, matrices_.n[0]);
    int64_t t27 = gm_bound(4, matrices_.n[0]);
    int64_t t28 = gm_span(t26, t27);
    flat_ = (array1_f8){matrices_.p + t26 * (matrices_.n[1]), {72}};
    linalg_add_transposed_product(flat_, flat_, 12, P_pred_);
    return true;
}

/* estimation/filters/ukf.py:21 step */
GM_APART bool ukf_step(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    bool t1 = ukf_predict(belief_, reading_, p_, scratch_, record_);
    bool t3 = t1;
    if (t3) {
    bool t2 = ekf_update(belief_, reading_.y1_, reading_.y2_, p_, record_);
    t3 = t2;
    }
    bool t5 = t3;
    if (t5) {
    bool t4 = ekf_healthy(belief_);
    t5 = t4;
    }
    return t5;
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_ukf(array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple_5 t1 = filter_parts(1, 21, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < 6; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim(belief_, reading_, p_);
    }
    bool t3 = ukf_step(belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_17 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany(companions_, previous_, reading_, t4, record_);
    return t5;
}

/* estimation/filters/ukf.py:38 predict */
GM_INLINE bool ukf_predict_2(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
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
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    matrices_ = scratch_.matrices_;
    tuple_6 t1 = step_record_places(5);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    int64_t t2 = gm_bound(2, matrices_.n[0]);
    int64_t t3 = gm_bound(4, matrices_.n[0]);
    int64_t t4 = gm_span(t2, t3);
    factor_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    slope_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    rows_ = (array2_f8){matrices_.p + t2 * (matrices_.n[1]), {10, 5}};
    int64_t t5 = (at_cross_ + 25);
    int64_t t6 = gm_bound(at_cross_, record_.n[0]);
    int64_t t7 = gm_bound(t5, record_.n[0]);
    int64_t t8 = gm_span(t6, t7);
    int64_t t9 = (at_P_ + 25);
    int64_t t10 = gm_bound(at_P_, record_.n[0]);
    int64_t t11 = gm_bound(t9, record_.n[0]);
    int64_t t12 = gm_span(t10, t11);
    cross_ = (array1_f8){record_.p + t6 * (1), {t8}};
    P_pred_ = (array1_f8){record_.p + t10 * (1), {t12}};
    for (int64_t k13 = 0; k13 < 5; k13 += 1) {
        i_ = k13;
        for (int64_t k14 = 0; k14 < 5; k14 += 1) {
            j_ = k14;
            slope_.p[(((i_ * 5) + j_))] = P_.p[(((i_ * 5) + j_))];
        }
        real t17 = slope_.p[(((i_ * 5) + i_))];
        real t16 = ((real)0.5 * dt_);
        real t15 = process_model_noise(z_, p_, i_);
        slope_.p[(((i_ * 5) + i_))] = (t17 + (t16 * t15));
    }
    bool t18 = sigma_points_cholesky_2(slope_, factor_);
    if ((!t18)) {
        return false;
    }
    int64_t t19 = gm_bound(4, matrices_.n[0]);
    int64_t t20 = gm_span(t19, matrices_.n[0]);
    sigma_points_transform_2(z_, factor_, reading_, p_, rows_, (array2_f8){matrices_.p + t19 * (matrices_.n[1]), {t20, matrices_.n[1]}});
    sigma_points_cross_covariance_2(rows_, factor_, P_, slope_, cross_);
    for (int64_t k21 = 0; k21 < 5; k21 += 1) {
        i_ = k21;
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
        for (int64_t k22 = 0; k22 < 5; k22 += 1) {
            j_ = k22;
            real t25;
            if (((i_ == j_))) {
            real t24 = ((real)0.5 * dt_);
            real t23 = process_model_noise(z_, p_, i_);
                t25 = (t24 * t23);
            } else {
                t25 = (real)0.0;
            }
            P_pred_.p[(((i_ * 5) + j_))] = t25;
        }
    }
    int64_t t26 = gm_bound(2, matrices_.n[0]);
    int64_t t27 = gm_bound(4, matrices_.n[0]);
    int64_t t28 = gm_span(t26, t27);
    flat_ = (array1_f8){matrices_.p + t26 * (matrices_.n[1]), {50}};
    linalg_add_transposed_product_2(flat_, flat_, 10, P_pred_);
    return true;
}

/* estimation/filters/ukf.py:21 step */
GM_APART bool ukf_step_2(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    bool t1 = ukf_predict_2(belief_, reading_, p_, scratch_, record_);
    bool t3 = t1;
    if (t3) {
    bool t2 = ekf_update_2(belief_, reading_.y1_, reading_.y2_, p_, record_);
    t3 = t2;
    }
    bool t5 = t3;
    if (t5) {
    bool t4 = ekf_healthy_2(belief_);
    t5 = t4;
    }
    return t5;
}

/* estimation/filter.py:63 _call */
GM_STATIC bool filter_call_ukf_2(array1_f8 room_, real dt_, real u_, real load_, real y1_, real y2_)
{
    Belief belief_;
    array1_f8 p_;
    Scratch scratch_;
    array1_f8 record_;
    Companions companions_;
    array1_f8 previous_;
    Reading reading_;
    int64_t i_;
    tuple_5 t1 = filter_parts_2(1, 21, room_);
    belief_ = t1.f0;
    p_ = t1.f1;
    scratch_ = t1.f2;
    record_ = t1.f3;
    companions_ = t1.f4;
    previous_ = t1.f5;
    reading_ = (Reading){dt_, u_, load_, y1_, y2_};
    for (int64_t k2 = 0; k2 < 5; k2 += 1) {
        i_ = k2;
        previous_.p[(i_)] = belief_.z_.p[(i_)];
    }
    if ((!(bool)isfinite(companions_.s_.p[(companions_.s_.n[0] - 1)]))) {
        sample_loop_aim_2(belief_, reading_, p_);
    }
    bool t3 = ukf_step_2(belief_, reading_, p_, scratch_, record_);
    if ((!t3)) {
        return false;
    }
    tuple_17 t4 = filter_kind_unchanged(belief_.memory_, p_);
    bool t5 = consider_accompany_2(companions_, previous_, reading_, t4, record_);
    return t5;
}

/* plant/batch.py:314 step_form */
GM_INLINE int64_t batch_step_form(PackedDrive drive_)
{
    array1_f8 p_;
    array1_f8 e_;
    bool plain_;
    p_ = drive_.p_;
    e_ = drive_.e_;
    if (((p_.p[8] != (real)0.0))) {
        return 2;
    }
    if ((((p_.p[20] != (real)0.0)) || ((p_.p[25] != (real)0.0)))) {
        return 2;
    }
    plain_ = (((p_.p[14] == (real)0.0)) && ((p_.p[16] == (real)0.0)));
    {
        plain_ = (plain_ && ((e_.p[0] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[2] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[6] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[7] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[8] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[10] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[13] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[14] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[16] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[18] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[29] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[41] == (real)0.0)));
    }
    {
        plain_ = (plain_ && ((e_.p[75] == (real)0.0)));
    }
    return (plain_ ? 0 : 1);
}

/* estimation/innovation_filter.py:303 _spread */
GM_INLINE void innovation_filter_spread(int64_t g_, int64_t width_, array3_f8 room_, FilterStart start_, array1_f8 s_)
{
    int64_t n_;
    int64_t i_;
    int64_t row_;
    int64_t j_;
    n_ = start_.places_.n[0];
    for (int64_t k1 = 0; k1 < 13; k1 += 1) {
        i_ = k1;
        row_ = ((((i_ == 12)) ? 224 : (16 * i_)) + (width_ * g_));
        for (int64_t k2 = 0; k2 < width_; k2 += 1) {
            j_ = k2;
            s_.p[gm_at((row_ + j_), s_.n[0])] = room_.p[(((g_) * room_.n[1] + ((n_ + i_))) * room_.n[2] + 0)];
        }
        for (int64_t k3 = 0; k3 < n_; k3 += 1) {
            j_ = k3;
            if (((start_.places_.p[(j_)] == i_))) {
                s_.p[gm_at(((row_ + 1) + j_), s_.n[0])] = (s_.p[gm_at(((row_ + 1) + j_), s_.n[0])] + start_.moves_.p[(j_)]);
            }
        }
    }
    return;
}

/* plant/drive.py:959 steady_arm_load */
GM_INLINE real drive_steady_arm_load(real x4_, array1_f8 p_)
{
    return ((p_.p[13] * x4_) + p_.p[18]);
}

/* plant/batch.py:69 _derivative */
GM_INLINE tuple_9 batch_derivative(real t_, tuple_9 x_, real m_, tuple_22 inputs_)
{
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    real u_;
    real on_motor_;
    real on_arm_;
    real in_gearbox_;
    array1_f8 p_;
    real tau_k_;
    x1_ = x_.v[0];
    x2_ = x_.v[1];
    x3_ = x_.v[2];
    x4_ = x_.v[3];
    u_ = inputs_.f0;
    on_motor_ = inputs_.f1;
    on_arm_ = inputs_.f2;
    in_gearbox_ = inputs_.f3;
    p_ = inputs_.f4;
    real t2 = p_.p[9];
    real t1 = transmission_dead_zone((x1_ - x2_), p_.p[10]);
    tau_k_ = ((t2 * t1) + in_gearbox_);
    real t3 = drive_motor_acceleration(x1_, x3_, x4_, (u_ + on_motor_), tau_k_, p_);
    real t4 = drive_steady_arm_load(x4_, p_);
    real t5 = drive_arm_acceleration(x3_, x4_, tau_k_, (t4 - on_arm_), p_);
    return (tuple_9){{x3_, x4_, t3, t5}};
}

/* plant/batch.py:83 _no_brake */
GM_INLINE tuple_7 batch_no_brake(real h_, tuple_9 x_, real m_, tuple_22 inputs_)
{
    return (tuple_7){{(real)0.0, (real)0.0}};
}

/* plant/batch.py:78 _no_memories */
GM_INLINE real batch_no_memories(real m_, tuple_9 x_, real x3_, real x4_, real h_, tuple_22 inputs_)
{
    return m_;
}

/* plant/runge_kutta.py:36 integrator.<locals>.step */
GM_INLINE tuple_23 runge_kutta_step(real t_, tuple_9 x_, real m_, real h_, tuple_22 inputs_)
{
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    real half_;
    real a1_;
    real a2_;
    real a3_;
    real a4_;
    real motor_;
    real arm_;
    real v1_;
    real v2_;
    tuple_9 change_;
    real b1_;
    real b2_;
    real b3_;
    real b4_;
    real c1_;
    real c2_;
    real c3_;
    real c4_;
    real d1_;
    real d2_;
    real d3_;
    real d4_;
    x1_ = x_.v[0];
    x2_ = x_.v[1];
    x3_ = x_.v[2];
    x4_ = x_.v[3];
    half_ = ((real)0.5 * h_);
    tuple_9 t1 = batch_derivative(t_, x_, m_, inputs_);
    a1_ = t1.v[0];
    a2_ = t1.v[1];
    a3_ = t1.v[2];
    a4_ = t1.v[3];
    tuple_7 t2 = batch_no_brake(h_, x_, m_, inputs_);
    motor_ = t2.v[0];
    arm_ = t2.v[1];
    if (((motor_ != (real)0.0))) {
        real t3 = (x3_ + ((h_ * motor_) * a3_));
        real t4 = (x4_ + ((h_ * arm_) * a4_));
        v1_ = t3;
        v2_ = t4;
        change_ = (tuple_9){{(h_ * v1_), (h_ * v2_), ((h_ * motor_) * a3_), ((h_ * arm_) * a4_)}};
        real t6 = change_.v[0];
        real t7 = change_.v[1];
        real t8 = change_.v[2];
        real t9 = change_.v[3];
        real t5 = batch_no_memories(m_, x_, v1_, v2_, h_, inputs_);
        return (tuple_23){(tuple_9){{t6, t7, t8, t9}}, t5};
    }
    real t11 = (t_ + half_);
    real t12 = (x1_ + (half_ * a1_));
    real t13 = (x2_ + (half_ * a2_));
    real t14 = (x3_ + (half_ * a3_));
    real t15 = (x4_ + (half_ * a4_));
    real t10 = batch_no_memories(m_, x_, a1_, a2_, half_, inputs_);
    tuple_9 t16 = batch_derivative(t11, (tuple_9){{t12, t13, t14, t15}}, t10, inputs_);
    b1_ = t16.v[0];
    b2_ = t16.v[1];
    b3_ = t16.v[2];
    b4_ = t16.v[3];
    real t18 = (t_ + half_);
    real t19 = (x1_ + (half_ * b1_));
    real t20 = (x2_ + (half_ * b2_));
    real t21 = (x3_ + (half_ * b3_));
    real t22 = (x4_ + (half_ * b4_));
    real t17 = batch_no_memories(m_, x_, b1_, b2_, half_, inputs_);
    tuple_9 t23 = batch_derivative(t18, (tuple_9){{t19, t20, t21, t22}}, t17, inputs_);
    c1_ = t23.v[0];
    c2_ = t23.v[1];
    c3_ = t23.v[2];
    c4_ = t23.v[3];
    real t25 = (t_ + h_);
    real t26 = (x1_ + (h_ * c1_));
    real t27 = (x2_ + (h_ * c2_));
    real t28 = (x3_ + (h_ * c3_));
    real t29 = (x4_ + (h_ * c4_));
    real t24 = batch_no_memories(m_, x_, c1_, c2_, h_, inputs_);
    tuple_9 t30 = batch_derivative(t25, (tuple_9){{t26, t27, t28, t29}}, t24, inputs_);
    d1_ = t30.v[0];
    d2_ = t30.v[1];
    d3_ = t30.v[2];
    d4_ = t30.v[3];
    real t31 = ((((a1_ + ((real)2.0 * b1_)) + ((real)2.0 * c1_)) + d1_) / (real)6.0);
    real t32 = ((((a2_ + ((real)2.0 * b2_)) + ((real)2.0 * c2_)) + d2_) / (real)6.0);
    v1_ = t31;
    v2_ = t32;
    change_ = (tuple_9){{(h_ * v1_), (h_ * v2_), ((h_ / (real)6.0) * (((a3_ + ((real)2.0 * b3_)) + ((real)2.0 * c3_)) + d3_)), ((h_ / (real)6.0) * (((a4_ + ((real)2.0 * b4_)) + ((real)2.0 * c4_)) + d4_))}};
    real t34 = change_.v[0];
    real t35 = change_.v[1];
    real t36 = change_.v[2];
    real t37 = change_.v[3];
    real t33 = batch_no_memories(m_, x_, v1_, v2_, h_, inputs_);
    return (tuple_23){(tuple_9){{t34, t35, t36, t37}}, t33};
}

/* plant/batch.py:91 _step */
GM_STATIC void batch_step(array1_f8 s_, real h_, array1_f8 p_)
{
    int64_t i_;
    tuple_9 change_;
    for (int64_t k1 = 0; k1 < 16; k1 += 1) {
        i_ = k1;
        tuple_23 t2 = runge_kutta_step(s_.p[((192 + i_))], (tuple_9){{s_.p[((0 + i_))], s_.p[((16 + i_))], s_.p[((32 + i_))], s_.p[((48 + i_))]}}, (real)0.0, h_, (tuple_22){s_.p[((208 + i_))], s_.p[((224 + i_))], s_.p[((240 + i_))], s_.p[((256 + i_))], p_});
        change_ = t2.f0;
        s_.p[((0 + i_))] = (s_.p[((0 + i_))] + change_.v[0]);
        s_.p[((16 + i_))] = (s_.p[((16 + i_))] + change_.v[1]);
        s_.p[((32 + i_))] = (s_.p[((32 + i_))] + change_.v[2]);
        s_.p[((48 + i_))] = (s_.p[((48 + i_))] + change_.v[3]);
    }
    return;
}

/* plant/batch.py:114 _loops.<locals>.nothing */
GM_INLINE void batch_nothing(tuple_24 arguments_)
{
    return;
}

/* plant/effects/composition.py:82 term_of.<locals>._three */
GM_INLINE mesh_error composition_three(array1_f8 e_)
{
    return (mesh_error){e_.p[18], e_.p[19], e_.p[20]};
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

/* plant/effects/gearbox.py:190 mesh_twist */
GM_INLINE real gearbox_mesh_twist(mesh_error c_, real x1_, real x2_, real z_)
{
    real t1 = elementary_sine(((c_.N_ * x1_) + c_.phi_));
    return (c_.A_ * t1);
}

/* plant/batch.py:147 _twist.<locals>.term */
GM_INLINE void batch_term(array1_f8 s_, array1_f8 e_)
{
    mesh_error c_;
    int64_t i_;
    if (((e_.p[18] != (real)0.0))) {
        mesh_error t1 = composition_three(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t5 = s_.p[((560 + i_))];
            real t4 = gearbox_mesh_twist(c_, s_.p[((272 + i_))], s_.p[((288 + i_))], s_.p[((336 + i_))]);
            s_.p[((560 + i_))] = (t5 + t4);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_2(tuple_24 arguments_)
{
    batch_nothing((tuple_24){{arguments_.v[0], arguments_.v[1]}});
    batch_term(arguments_.v[0], arguments_.v[1]);
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE hysteresis_branch composition_two(array1_f8 e_)
{
    return (hysteresis_branch){e_.p[16], e_.p[17]};
}

/* plant/effects/gearbox.py:149 branch_twist */
GM_INLINE real gearbox_branch_twist(hysteresis_branch c_, real x1_, real x2_, real z_)
{
    return (-(c_.h_ * z_));
}

/* plant/batch.py:147 _twist.<locals>.term */
GM_INLINE void batch_term_2(array1_f8 s_, array1_f8 e_)
{
    hysteresis_branch c_;
    int64_t i_;
    if (((e_.p[16] != (real)0.0))) {
        hysteresis_branch t1 = composition_two(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t5 = s_.p[((560 + i_))];
            real t4 = gearbox_branch_twist(c_, s_.p[((272 + i_))], s_.p[((288 + i_))], s_.p[((384 + i_))]);
            s_.p[((560 + i_))] = (t5 + t4);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both(tuple_24 arguments_)
{
    batch_both_2((tuple_24){{arguments_.v[0], arguments_.v[1]}});
    batch_term_2(arguments_.v[0], arguments_.v[1]);
    return;
}

/* plant/batch.py:114 _loops.<locals>.nothing */
GM_INLINE void batch_nothing_2(tuple_25 arguments_)
{
    return;
}

/* plant/effects/composition.py:73 term_of.<locals>._array */
GM_INLINE tuple_26 composition_array(array1_f8 e_)
{
    return (tuple_26){e_, 41};
}

/* plant/effects/torque_map.py:32 interpolated */
GM_STATIC real torque_map_interpolated(array1_f8 e_, int64_t k_, real x_)
{
    int64_t last_;
    int64_t knots_;
    int64_t values_;
    int64_t i_;
    real share_;
    int64_t t1 = ((int64_t)(e_.p[((k_ + 1))]) - 1);
    int64_t t2 = (k_ + 2);
    int64_t t3 = (k_ + 18);
    last_ = t1;
    knots_ = t2;
    values_ = t3;
    if ((!((x_ > e_.p[(knots_)])))) {
        return e_.p[(values_)];
    }
    for (int64_t k4 = 0; k4 < last_; k4 += 1) {
        i_ = k4;
        if (((x_ < e_.p[(((knots_ + i_) + 1))]))) {
            share_ = ((x_ - e_.p[((knots_ + i_))]) / (e_.p[(((knots_ + i_) + 1))] - e_.p[((knots_ + i_))]));
            return (e_.p[((values_ + i_))] + (share_ * (e_.p[(((values_ + i_) + 1))] - e_.p[((values_ + i_))])));
        }
    }
    return e_.p[gm_at((values_ + last_), e_.n[0])];
}

/* plant/effects/torque_map.py:125 map_of_twist */
GM_INLINE real torque_map_map_of_twist(tuple_26 c_, real twist_, real z_, real half_gap_)
{
    array1_f8 e_;
    int64_t k_;
    e_ = c_.f0;
    k_ = c_.f1;
    real t2;
    if (((e_.p[(k_)] == (real)8.0))) {
    real t1 = torque_map_interpolated(e_, k_, twist_);
        t2 = t1;
    } else {
        t2 = (real)0.0;
    }
    return t2;
}

/* plant/batch.py:159 _elastic.<locals>.term */
GM_INLINE void batch_term_3(array1_f8 s_, array1_f8 p_, array1_f8 e_)
{
    tuple_26 c_;
    int64_t i_;
    if (((e_.p[41] != (real)0.0))) {
        tuple_26 t1 = composition_array(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t5 = s_.p[((576 + i_))];
            real t4 = torque_map_map_of_twist(c_, s_.p[((560 + i_))], s_.p[((336 + i_))], p_.p[10]);
            s_.p[((576 + i_))] = (t5 + t4);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_5(tuple_25 arguments_)
{
    batch_nothing_2((tuple_25){{arguments_.v[0], arguments_.v[1], arguments_.v[2]}});
    batch_term_3(arguments_.v[0], arguments_.v[1], arguments_.v[2]);
    return;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE hardening composition_one(array1_f8 e_)
{
    return (hardening){e_.p[13]};
}

/* plant/effects/gearbox.py:66 hardening_torque */
GM_INLINE real gearbox_hardening_torque(hardening c_, real twist_, real z_, real half_gap_)
{
    real out_;
    real t1 = transmission_dead_zone(twist_, half_gap_);
    out_ = t1;
    return (((c_.K3_ * out_) * out_) * out_);
}

/* plant/batch.py:159 _elastic.<locals>.term */
GM_INLINE void batch_term_4(array1_f8 s_, array1_f8 p_, array1_f8 e_)
{
    hardening c_;
    int64_t i_;
    if (((e_.p[13] != (real)0.0))) {
        hardening t1 = composition_one(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t5 = s_.p[((576 + i_))];
            real t4 = gearbox_hardening_torque(c_, s_.p[((560 + i_))], s_.p[((336 + i_))], p_.p[10]);
            s_.p[((576 + i_))] = (t5 + t4);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_4(tuple_25 arguments_)
{
    batch_both_5((tuple_25){{arguments_.v[0], arguments_.v[1], arguments_.v[2]}});
    batch_term_4(arguments_.v[0], arguments_.v[1], arguments_.v[2]);
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE hysteresis_bouc_wen composition_two_2(array1_f8 e_)
{
    return (hysteresis_bouc_wen){e_.p[14], e_.p[15]};
}

/* plant/effects/gearbox.py:92 bouc_wen_torque */
GM_INLINE real gearbox_bouc_wen_torque(hysteresis_bouc_wen c_, real twist_, real z_, real half_gap_)
{
    return (c_.Th_ * z_);
}

/* plant/batch.py:159 _elastic.<locals>.term */
GM_INLINE void batch_term_5(array1_f8 s_, array1_f8 p_, array1_f8 e_)
{
    hysteresis_bouc_wen c_;
    int64_t i_;
    if (((e_.p[14] != (real)0.0))) {
        hysteresis_bouc_wen t1 = composition_two_2(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t5 = s_.p[((576 + i_))];
            real t4 = gearbox_bouc_wen_torque(c_, s_.p[((560 + i_))], s_.p[((368 + i_))], p_.p[10]);
            s_.p[((576 + i_))] = (t5 + t4);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_3(tuple_25 arguments_)
{
    batch_both_4((tuple_25){{arguments_.v[0], arguments_.v[1], arguments_.v[2]}});
    batch_term_5(arguments_.v[0], arguments_.v[1], arguments_.v[2]);
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE motor_encoder_eccentricity composition_two_3(array1_f8 e_)
{
    return (motor_encoder_eccentricity){e_.p[32], e_.p[33]};
}

/* plant/effects/encoder.py:13 eccentricity_error */
GM_INLINE tuple_15 encoder_eccentricity_error(motor_encoder_eccentricity c_, real x_)
{
    real error_;
    error_ = (c_.A_ * gm_sin((x_ + c_.phi_)));
    return (tuple_15){{error_, (c_.A_ * gm_cos((x_ + c_.phi_))), (-error_)}};
}

/* plant/effects/composition.py:163 _error.<locals>._term */
GM_INLINE tuple_15 composition_term(tuple_15 total_, array1_f8 e_, real x_)
{
    real error_;
    real slope_;
    real curvature_;
    if (((e_.p[32] != (real)0.0))) {
        motor_encoder_eccentricity t1 = composition_two_3(e_);
        tuple_15 t2 = encoder_eccentricity_error(t1, x_);
        error_ = t2.v[0];
        slope_ = t2.v[1];
        curvature_ = t2.v[2];
        return (tuple_15){{(total_.v[0] + error_), (total_.v[1] + slope_), (total_.v[2] + curvature_)}};
    }
    return total_;
}

/* plant/effects/composition.py:211 _limited */
GM_INLINE real composition_limited(real u_, array1_f8 e_)
{
    real limit_;
    limit_ = gm_min_f(e_.p[77], e_.p[21]);
    return gm_min_f(gm_max_f(u_, (-limit_)), limit_);
}

/* plant/effects/composition.py:217 _control_law */
GM_INLINE real composition_control_law(real r_, array1_f8 e_, real x1_, real x3_, real integral_)
{
    real error_;
    real slope_;
    tuple_15 t1 = composition_term((tuple_15){{(real)0.0, (real)0.0, (real)0.0}}, e_, x1_);
    error_ = t1.v[0];
    slope_ = t1.v[1];
    real t3 = e_.p[75];
    real t2 = transmission_dead_zone(((r_ - x1_) - error_), e_.p[22]);
    real t4 = composition_limited((((t3 * t2) + integral_) - ((e_.p[76] * x3_) * ((real)1.0 + slope_))), e_);
    return t4;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE saturation composition_one_2(array1_f8 e_)
{
    return (saturation){e_.p[28]};
}

/* plant/effects/actuator.py:78 clipped_command */
GM_INLINE real actuator_clipped_command(saturation c_, real u_)
{
    return gm_min_f(gm_max_f(u_, (-c_.umax_)), c_.umax_);
}

/* plant/effects/composition.py:142 _command.<locals>._term */
GM_INLINE real composition_term_2(real u_, array1_f8 e_)
{
    if (((e_.p[28] != INFINITY))) {
        saturation t1 = composition_one_2(e_);
        real t2 = actuator_clipped_command(t1, u_);
        u_ = t2;
    }
    return u_;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE torque_gain composition_one_3(array1_f8 e_)
{
    return (torque_gain){e_.p[25]};
}

/* plant/effects/actuator.py:18 scaled_command */
GM_INLINE real actuator_scaled_command(torque_gain c_, real u_)
{
    return (u_ * ((real)1.0 + c_.g_));
}

/* plant/effects/composition.py:142 _command.<locals>._term */
GM_INLINE real composition_term_3(real u_, array1_f8 e_)
{
    if (((e_.p[25] != (real)0.0))) {
        torque_gain t1 = composition_one_3(e_);
        real t2 = actuator_scaled_command(t1, u_);
        u_ = t2;
    }
    return u_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both(real value_, tuple_27 arguments_)
{
    real t1 = composition_term_2(value_, arguments_.f0);
    real t2 = composition_term_3(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:225 servo */
GM_INLINE real composition_servo(real r_, array1_f8 e_, real x1_, real x3_, tuple_9 memory_)
{
    real integral_;
    real a_;
    real b_;
    real c_;
    real u_;
    if (((e_.p[75] == (real)0.0))) {
        return r_;
    }
    integral_ = memory_.v[0];
    a_ = memory_.v[1];
    b_ = memory_.v[2];
    c_ = memory_.v[3];
    real t1 = composition_control_law(r_, e_, x1_, x3_, integral_);
    u_ = t1;
    if (((e_.p[79] > (real)0.0))) {
        real t2 = composition_limited(((((real)57.20254024714855 * c_) + ((real)2.0 * (((real)(-16.601270123574242) * a_) - ((real)20.58318427938701 * b_)))) - u_), e_);
        u_ = t2;
    }
    real t3 = composition_both(u_, (tuple_27){e_});
    return t3;
}

/* plant/batch.py:114 _loops.<locals>.nothing */
GM_INLINE void batch_nothing_3(tuple_24 arguments_)
{
    return;
}

/* plant/effects/composition.py:82 term_of.<locals>._three */
GM_INLINE mesh_error composition_three_2(array1_f8 e_)
{
    return (mesh_error){e_.p[29], e_.p[30], e_.p[31]};
}

/* plant/effects/actuator.py:141 ripple_gain */
GM_INLINE real actuator_ripple_gain(mesh_error c_, real x1_)
{
    real t1 = elementary_sine(((c_.N_ * x1_) + c_.phi_));
    return ((real)1.0 + (c_.A_ * t1));
}

/* plant/effects/actuator.py:147 with_ripple */
GM_INLINE real actuator_with_ripple(mesh_error c_, real x1_, real x3_, real u_)
{
    real t1 = actuator_ripple_gain(c_, x1_);
    return (u_ * t1);
}

/* plant/batch.py:170 _motor_torque.<locals>.term */
GM_INLINE void batch_term_6(array1_f8 s_, array1_f8 e_)
{
    mesh_error c_;
    int64_t i_;
    if (((e_.p[29] != (real)0.0))) {
        mesh_error t1 = composition_three_2(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t4 = actuator_with_ripple(c_, s_.p[((272 + i_))], s_.p[((304 + i_))], s_.p[((608 + i_))]);
            s_.p[((608 + i_))] = t4;
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_8(tuple_24 arguments_)
{
    batch_nothing_3((tuple_24){{arguments_.v[0], arguments_.v[1]}});
    batch_term_6(arguments_.v[0], arguments_.v[1]);
    return;
}

/* plant/effects/composition.py:73 term_of.<locals>._array */
GM_INLINE tuple_26 composition_array_2(array1_f8 e_)
{
    return (tuple_26){e_, 41};
}

/* plant/effects/torque_map.py:78 with_map */
GM_INLINE real torque_map_with_map(tuple_26 c_, real x1_, real x3_, real u_)
{
    array1_f8 e_;
    int64_t k_;
    e_ = c_.f0;
    k_ = c_.f1;
    if (((e_.p[(k_)] == (real)3.0))) {
        real t1 = torque_map_interpolated(e_, k_, x1_);
        return (u_ + t1);
    }
    if (((e_.p[(k_)] == (real)4.0))) {
        real t2 = torque_map_interpolated(e_, k_, u_);
        return (u_ + t2);
    }
    return u_;
}

/* plant/batch.py:170 _motor_torque.<locals>.term */
GM_INLINE void batch_term_7(array1_f8 s_, array1_f8 e_)
{
    tuple_26 c_;
    int64_t i_;
    if (((e_.p[41] != (real)0.0))) {
        tuple_26 t1 = composition_array_2(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t4 = torque_map_with_map(c_, s_.p[((272 + i_))], s_.p[((304 + i_))], s_.p[((608 + i_))]);
            s_.p[((608 + i_))] = t4;
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_7(tuple_24 arguments_)
{
    batch_both_8((tuple_24){{arguments_.v[0], arguments_.v[1]}});
    batch_term_7(arguments_.v[0], arguments_.v[1]);
    return;
}

/* plant/effects/composition.py:82 term_of.<locals>._three */
GM_INLINE mesh_error composition_three_3(array1_f8 e_)
{
    return (mesh_error){e_.p[10], e_.p[11], e_.p[12]};
}

/* plant/effects/motor_side.py:334 with_cogging */
GM_INLINE real motor_side_with_cogging(mesh_error c_, real x1_, real x3_, real u_)
{
    real t1 = elementary_sine(((c_.N_ * x1_) + c_.phi_));
    return (u_ + (c_.A_ * t1));
}

/* plant/batch.py:170 _motor_torque.<locals>.term */
GM_INLINE void batch_term_8(array1_f8 s_, array1_f8 e_)
{
    mesh_error c_;
    int64_t i_;
    if (((e_.p[10] != (real)0.0))) {
        mesh_error t1 = composition_three_3(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t4 = motor_side_with_cogging(c_, s_.p[((272 + i_))], s_.p[((304 + i_))], s_.p[((608 + i_))]);
            s_.p[((608 + i_))] = t4;
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_6(tuple_24 arguments_)
{
    batch_both_7((tuple_24){{arguments_.v[0], arguments_.v[1]}});
    batch_term_8(arguments_.v[0], arguments_.v[1]);
    return;
}

/* plant/batch.py:114 _loops.<locals>.nothing */
GM_INLINE void batch_nothing_4(tuple_28 arguments_)
{
    return;
}

/* plant/effects/composition.py:73 term_of.<locals>._array */
GM_INLINE tuple_26 composition_array_3(array1_f8 e_)
{
    return (tuple_26){e_, 41};
}

/* plant/effects/torque_map.py:55 map_friction */
GM_INLINE real torque_map_map_friction(tuple_26 c_, real t_, real x3_, real z_, MotorFriction base_)
{
    array1_f8 e_;
    int64_t k_;
    e_ = c_.f0;
    k_ = c_.f1;
    if (((e_.p[(k_)] == (real)1.0))) {
        real t1 = torque_map_interpolated(e_, k_, x3_);
        return (-t1);
    }
    if (((e_.p[(k_)] == (real)2.0))) {
        real t2 = torque_map_interpolated(e_, k_, t_);
        return (-t2);
    }
    return (real)0.0;
}

/* plant/batch.py:123 _friction.<locals>.term */
GM_INLINE void batch_term_9(array1_f8 s_, real elapsed_, array1_f8 p_, array1_f8 e_)
{
    tuple_26 c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[41] != (real)0.0))) {
        tuple_26 t1 = composition_array_3(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t9 = s_.p[((624 + i_))];
            real t8 = torque_map_map_friction(c_, (s_.p[((192 + i_))] + elapsed_), s_.p[((304 + i_))], s_.p[((336 + i_))], base_);
            s_.p[((624 + i_))] = (t9 + t8);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_14(tuple_28 arguments_)
{
    batch_nothing_4((tuple_28){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3});
    batch_term_9(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3);
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE stribeck composition_two_4(array1_f8 e_)
{
    return (stribeck){e_.p[0], e_.p[1]};
}

/* plant/effects/motor_side.py:40 friction_side */
GM_INLINE real motor_side_friction_side(real x3_, MotorFriction base_)
{
    real t1 = friction_law_side((base_.sharpness_ * x3_), base_.law_);
    return t1;
}

/* plant/effects/motor_side.py:82 stribeck_torque */
GM_INLINE real motor_side_stribeck_torque(stribeck c_, real t_, real x3_, real z_, MotorFriction base_)
{
    real v_;
    v_ = (x3_ / c_.vs_);
    real t1 = elementary_exponential(((-v_) * v_));
    real t3 = (c_.Cs_ * t1);
    real t2 = motor_side_friction_side(x3_, base_);
    return (t3 * t2);
}

/* plant/batch.py:123 _friction.<locals>.term */
GM_INLINE void batch_term_10(array1_f8 s_, real elapsed_, array1_f8 p_, array1_f8 e_)
{
    stribeck c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[0] != (real)0.0))) {
        stribeck t1 = composition_two_4(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t9 = s_.p[((624 + i_))];
            real t8 = motor_side_stribeck_torque(c_, (s_.p[((192 + i_))] + elapsed_), s_.p[((304 + i_))], s_.p[((336 + i_))], base_);
            s_.p[((624 + i_))] = (t9 + t8);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_13(tuple_28 arguments_)
{
    batch_both_14((tuple_28){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3});
    batch_term_10(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3);
    return;
}

/* plant/effects/composition.py:85 term_of.<locals>._four */
GM_INLINE lugre composition_four(array1_f8 e_)
{
    return (lugre){e_.p[2], e_.p[3], e_.p[4], e_.p[5]};
}

/* plant/effects/motor_side.py:123 lugre_level */
GM_INLINE real motor_side_lugre_level(lugre c_, real x3_, MotorFriction base_)
{
    real v_;
    v_ = (x3_ / c_.vs_);
    real t1 = elementary_exponential(((-v_) * v_));
    return (base_.coulomb_ + (c_.Cs_ * t1));
}

/* plant/effects/motor_side.py:140 lugre_torque */
GM_INLINE real motor_side_lugre_torque(lugre c_, real t_, real x3_, real z_, MotorFriction base_)
{
    real g_;
    real slip_;
    real bristles_;
    real t1 = motor_side_lugre_level(c_, x3_, base_);
    g_ = t1;
    slip_ = (((g_ > (real)0.0)) ? ((gm_fabs(x3_) * z_) / g_) : (real)0.0);
    bristles_ = ((c_.sigma0_ * z_) + (c_.sigma1_ * (x3_ - (c_.sigma0_ * slip_))));
    real t3;
    if (((base_.law_ <= (real)1.0))) {
    real t2 = motor_side_friction_side(x3_, base_);
        t3 = (bristles_ - (base_.coulomb_ * t2));
    } else {
        t3 = bristles_;
    }
    return t3;
}

/* plant/batch.py:123 _friction.<locals>.term */
GM_INLINE void batch_term_11(array1_f8 s_, real elapsed_, array1_f8 p_, array1_f8 e_)
{
    lugre c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[2] != (real)0.0))) {
        lugre t1 = composition_four(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t9 = s_.p[((624 + i_))];
            real t8 = motor_side_lugre_torque(c_, (s_.p[((192 + i_))] + elapsed_), s_.p[((304 + i_))], s_.p[((352 + i_))], base_);
            s_.p[((624 + i_))] = (t9 + t8);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_12(tuple_28 arguments_)
{
    batch_both_13((tuple_28){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3});
    batch_term_11(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3);
    return;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE coulomb_asymmetry composition_one_4(array1_f8 e_)
{
    return (coulomb_asymmetry){e_.p[6]};
}

/* plant/effects/motor_side.py:207 asymmetry_torque */
GM_INLINE real motor_side_asymmetry_torque(coulomb_asymmetry c_, real t_, real x3_, real z_, MotorFriction base_)
{
    real t1 = motor_side_friction_side(x3_, base_);
    return (c_.Ca_ * gm_fabs(t1));
}

/* plant/batch.py:123 _friction.<locals>.term */
GM_INLINE void batch_term_12(array1_f8 s_, real elapsed_, array1_f8 p_, array1_f8 e_)
{
    coulomb_asymmetry c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[6] != (real)0.0))) {
        coulomb_asymmetry t1 = composition_one_4(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t9 = s_.p[((624 + i_))];
            real t8 = motor_side_asymmetry_torque(c_, (s_.p[((192 + i_))] + elapsed_), s_.p[((304 + i_))], s_.p[((336 + i_))], base_);
            s_.p[((624 + i_))] = (t9 + t8);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_11(tuple_28 arguments_)
{
    batch_both_12((tuple_28){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3});
    batch_term_12(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3);
    return;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE viscous_asymmetry composition_one_5(array1_f8 e_)
{
    return (viscous_asymmetry){e_.p[7]};
}

/* plant/effects/motor_side.py:237 viscous_asymmetry_torque */
GM_INLINE real motor_side_viscous_asymmetry_torque(viscous_asymmetry c_, real t_, real x3_, real z_, MotorFriction base_)
{
    return (c_.Cva_ * gm_fabs(x3_));
}

/* plant/batch.py:123 _friction.<locals>.term */
GM_INLINE void batch_term_13(array1_f8 s_, real elapsed_, array1_f8 p_, array1_f8 e_)
{
    viscous_asymmetry c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[7] != (real)0.0))) {
        viscous_asymmetry t1 = composition_one_5(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t9 = s_.p[((624 + i_))];
            real t8 = motor_side_viscous_asymmetry_torque(c_, (s_.p[((192 + i_))] + elapsed_), s_.p[((304 + i_))], s_.p[((336 + i_))], base_);
            s_.p[((624 + i_))] = (t9 + t8);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_10(tuple_28 arguments_)
{
    batch_both_11((tuple_28){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3});
    batch_term_13(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3);
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE viscous_drift composition_two_5(array1_f8 e_)
{
    return (viscous_drift){e_.p[8], e_.p[9]};
}

/* plant/effects/motor_side.py:294 drift_torque */
GM_INLINE real motor_side_drift_torque(viscous_drift c_, real t_, real x3_, real z_, MotorFriction base_)
{
    real t2 = (base_.viscous_ * c_.r_);
    real t1 = elementary_exponential(((-t_) / c_.T_));
    return ((t2 * ((real)1.0 - t1)) * x3_);
}

/* plant/batch.py:123 _friction.<locals>.term */
GM_INLINE void batch_term_14(array1_f8 s_, real elapsed_, array1_f8 p_, array1_f8 e_)
{
    viscous_drift c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[8] != (real)0.0))) {
        viscous_drift t1 = composition_two_5(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t9 = s_.p[((624 + i_))];
            real t8 = motor_side_drift_torque(c_, (s_.p[((192 + i_))] + elapsed_), s_.p[((304 + i_))], s_.p[((336 + i_))], base_);
            s_.p[((624 + i_))] = (t9 + t8);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_9(tuple_28 arguments_)
{
    batch_both_10((tuple_28){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3});
    batch_term_14(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3);
    return;
}

/* plant/friction_law.py:77 side */
GM_INLINE real friction_law_side_2(real v_, int64_t law_)
{
    if (((law_ == 1))) {
        real t1 = elementary_exponential(((real)2.0 * gm_min_f(gm_max_f(v_, (real)(-20.0)), (real)20.0)));
        return ((real)1.0 - ((real)2.0 / ((real)1.0 + t1)));
    }
    real t2 = elementary_arctan(v_);
    return ((real)0.6366197723675814 * t2);
}

/* plant/drive.py:987 gravity */
GM_INLINE real drive_gravity(real x2_, array1_f8 p_)
{
    real t2 = p_.p[16];
    real t1 = elementary_sine((x2_ + p_.p[17]));
    return (t2 * t1);
}

/* plant/batch.py:114 _loops.<locals>.nothing */
GM_INLINE void batch_nothing_5(tuple_29 arguments_)
{
    return;
}

/* plant/effects/composition.py:73 term_of.<locals>._array */
GM_INLINE tuple_26 composition_array_4(array1_f8 e_)
{
    return (tuple_26){e_, 41};
}

/* plant/effects/torque_map.py:100 map_on_arm */
GM_INLINE real torque_map_map_on_arm(tuple_26 c_, real t_, real x2_, real x4_, real z_)
{
    array1_f8 e_;
    int64_t k_;
    e_ = c_.f0;
    k_ = c_.f1;
    if (((e_.p[(k_)] == (real)5.0))) {
        real t1 = torque_map_interpolated(e_, k_, x4_);
        return (-t1);
    }
    if (((e_.p[(k_)] == (real)7.0))) {
        real t2 = torque_map_interpolated(e_, k_, x2_);
        return (-t2);
    }
    if (((e_.p[(k_)] == (real)6.0))) {
        real t3 = torque_map_interpolated(e_, k_, t_);
        return (-t3);
    }
    return (real)0.0;
}

/* plant/batch.py:135 _arm_torque.<locals>.term */
GM_INLINE void batch_term_15(array1_f8 s_, real elapsed_, array1_f8 e_)
{
    tuple_26 c_;
    int64_t i_;
    if (((e_.p[41] != (real)0.0))) {
        tuple_26 t1 = composition_array_4(e_);
        c_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            real t5 = s_.p[((592 + i_))];
            real t4 = torque_map_map_on_arm(c_, (s_.p[((192 + i_))] + elapsed_), s_.p[((288 + i_))], s_.p[((320 + i_))], s_.p[((336 + i_))]);
            s_.p[((592 + i_))] = (t5 + t4);
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_15(tuple_29 arguments_)
{
    batch_nothing_5((tuple_29){arguments_.f0, arguments_.f1, arguments_.f2});
    batch_term_15(arguments_.f0, arguments_.f1, arguments_.f2);
    return;
}

/* plant/batch.py:213 _rates */
GM_STATIC void batch_rates(array1_f8 s_, real elapsed_, array1_f8 p_, array1_f8 e_)
{
    int64_t lanes_;
    int64_t i_;
    real u_;
    real tau_k_;
    real motor_;
    lanes_ = (s_.n[0] / 40);
    for (int64_t k1 = 0; k1 < lanes_; k1 += 1) {
        i_ = k1;
        s_.p[((560 + i_))] = (s_.p[((272 + i_))] - s_.p[((288 + i_))]);
        s_.p[((624 + i_))] = (real)0.0;
        s_.p[((608 + i_))] = s_.p[((208 + i_))];
        real t2 = drive_steady_arm_load(s_.p[((320 + i_))], p_);
        s_.p[((592 + i_))] = t2;
    }
    batch_both((tuple_24){{s_, e_}});
    for (int64_t k3 = 0; k3 < lanes_; k3 += 1) {
        i_ = k3;
        real t5 = p_.p[9];
        real t4 = transmission_dead_zone(s_.p[((560 + i_))], p_.p[10]);
        s_.p[((576 + i_))] = (t5 * t4);
    }
    batch_both_3((tuple_25){{s_, p_, e_}});
    if (((e_.p[75] != (real)0.0))) {
        for (int64_t k6 = 0; k6 < lanes_; k6 += 1) {
            i_ = k6;
            real t7 = composition_servo(s_.p[((208 + i_))], e_, s_.p[((272 + i_))], s_.p[((304 + i_))], (tuple_9){{s_.p[((400 + i_))], s_.p[((416 + i_))], s_.p[((432 + i_))], s_.p[((448 + i_))]}});
            s_.p[((608 + i_))] = t7;
        }
    }
    batch_both_6((tuple_24){{s_, e_}});
    batch_both_9((tuple_28){s_, elapsed_, p_, e_});
    if (((p_.p[14] != (real)0.0))) {
        for (int64_t k8 = 0; k8 < lanes_; k8 += 1) {
            i_ = k8;
            real t11 = s_.p[((592 + i_))];
            real t10 = p_.p[14];
            real t9 = friction_law_side_2((p_.p[15] * s_.p[((320 + i_))]), 0);
            s_.p[((592 + i_))] = (t11 + (t10 * t9));
        }
    }
    if (((p_.p[16] != (real)0.0))) {
        for (int64_t k12 = 0; k12 < lanes_; k12 += 1) {
            i_ = k12;
            real t14 = s_.p[((592 + i_))];
            real t13 = drive_gravity(s_.p[((288 + i_))], p_);
            s_.p[((592 + i_))] = (t14 + t13);
        }
    }
    batch_both_15((tuple_29){s_, elapsed_, e_});
    for (int64_t k15 = 0; k15 < lanes_; k15 += 1) {
        i_ = k15;
        real t16 = s_.p[((208 + i_))];
        real t17 = (s_.p[((576 + i_))] + s_.p[((256 + i_))]);
        u_ = t16;
        tau_k_ = t17;
        motor_ = ((s_.p[((608 + i_))] - u_) - s_.p[((624 + i_))]);
        real t18 = drive_motor_acceleration(s_.p[((272 + i_))], s_.p[((304 + i_))], s_.p[((320 + i_))], ((u_ + motor_) + s_.p[((224 + i_))]), tau_k_, p_);
        s_.p[((464 + i_))] = t18;
        real t19 = drive_arm_acceleration(s_.p[((304 + i_))], s_.p[((320 + i_))], tau_k_, (s_.p[((592 + i_))] - s_.p[((240 + i_))]), p_);
        s_.p[((480 + i_))] = t19;
    }
    return;
}

/* plant/batch.py:114 _loops.<locals>.nothing */
GM_INLINE void batch_nothing_6(tuple_30 arguments_)
{
    return;
}

/* plant/effects/composition.py:85 term_of.<locals>._four */
GM_INLINE lugre composition_four_2(array1_f8 e_)
{
    return (lugre){e_.p[2], e_.p[3], e_.p[4], e_.p[5]};
}

/* plant/effects/motor_side.py:123 lugre_level */
GM_INLINE real motor_side_lugre_level_2(lugre c_, real x3_, MotorFriction base_)
{
    real v_;
    v_ = (x3_ / c_.vs_);
    real t1 = elementary_exponential(((-v_) * v_));
    return (base_.coulomb_ + (c_.Cs_ * t1));
}

/* plant/effects/motor_side.py:23 relaxed */
GM_INLINE real motor_side_relaxed(real memory_, real target_, real rate_, real h_)
{
    real t2 = (memory_ - target_);
    real t1 = elementary_exponential(((-rate_) * h_));
    return (target_ + (t2 * t1));
}

/* plant/effects/motor_side.py:162 bristle */
GM_INLINE real motor_side_bristle(lugre c_, real z_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real g_;
    real t1 = motor_side_lugre_level_2(c_, x3_, base_);
    g_ = t1;
    if ((((x3_ == (real)0.0)) || ((g_ <= (real)0.0)))) {
        return z_;
    }
    real t2 = motor_side_relaxed(z_, gm_copysign((g_ / c_.sigma0_), x3_), ((c_.sigma0_ * gm_fabs(x3_)) / g_), h_);
    return t2;
}

/* plant/batch.py:182 _memory.<locals>.term */
GM_INLINE void batch_term_16(array1_f8 s_, int64_t x3_, int64_t x4_, real h_, array1_f8 p_, array1_f8 e_)
{
    lugre c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[2] != (real)0.0))) {
        lugre t1 = composition_four_2(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t8 = motor_side_bristle(c_, s_.p[((80 + i_))], s_.p[((x3_ + i_))], s_.p[((x4_ + i_))], h_, base_);
            s_.p[((352 + i_))] = t8;
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_18(tuple_30 arguments_)
{
    batch_nothing_6((tuple_30){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5});
    batch_term_16(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5);
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE hysteresis_bouc_wen composition_two_6(array1_f8 e_)
{
    return (hysteresis_bouc_wen){e_.p[14], e_.p[15]};
}

/* plant/effects/gearbox.py:109 loop_memory */
GM_INLINE real gearbox_loop_memory(hysteresis_bouc_wen c_, real z_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real rate_;
    rate_ = (x3_ - x4_);
    real t1 = motor_side_relaxed(z_, gm_copysign((real)1.0, rate_), (gm_fabs(rate_) / c_.dh_), h_);
    return t1;
}

/* plant/batch.py:182 _memory.<locals>.term */
GM_INLINE void batch_term_17(array1_f8 s_, int64_t x3_, int64_t x4_, real h_, array1_f8 p_, array1_f8 e_)
{
    hysteresis_bouc_wen c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[14] != (real)0.0))) {
        hysteresis_bouc_wen t1 = composition_two_6(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t8 = gearbox_loop_memory(c_, s_.p[((96 + i_))], s_.p[((x3_ + i_))], s_.p[((x4_ + i_))], h_, base_);
            s_.p[((368 + i_))] = t8;
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_17(tuple_30 arguments_)
{
    batch_both_18((tuple_30){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5});
    batch_term_17(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5);
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE hysteresis_branch composition_two_7(array1_f8 e_)
{
    return (hysteresis_branch){e_.p[16], e_.p[17]};
}

/* plant/effects/gearbox.py:109 loop_memory */
GM_INLINE real gearbox_loop_memory_2(hysteresis_branch c_, real z_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real rate_;
    rate_ = (x3_ - x4_);
    real t1 = motor_side_relaxed(z_, gm_copysign((real)1.0, rate_), (gm_fabs(rate_) / c_.ds_), h_);
    return t1;
}

/* plant/batch.py:182 _memory.<locals>.term */
GM_INLINE void batch_term_18(array1_f8 s_, int64_t x3_, int64_t x4_, real h_, array1_f8 p_, array1_f8 e_)
{
    hysteresis_branch c_;
    MotorFriction base_;
    int64_t i_;
    if (((e_.p[16] != (real)0.0))) {
        hysteresis_branch t1 = composition_two_7(e_);
        real t2 = p_.p[3];
        real t3 = p_.p[4];
        real t4 = p_.p[5];
        real t5 = p_.p[20];
        c_ = t1;
        base_ = (MotorFriction){t2, t3, t4, t5};
        int64_t t6 = (s_.n[0] / 40);
        for (int64_t k7 = 0; k7 < t6; k7 += 1) {
            i_ = k7;
            real t8 = gearbox_loop_memory_2(c_, s_.p[((112 + i_))], s_.p[((x3_ + i_))], s_.p[((x4_ + i_))], h_, base_);
            s_.p[((384 + i_))] = t8;
        }
    }
    return;
}

/* plant/batch.py:109 _loops.<locals>.joined.<locals>.both */
GM_INLINE void batch_both_16(tuple_30 arguments_)
{
    batch_both_17((tuple_30){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5});
    batch_term_18(arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5);
    return;
}

/* plant/effects/composition.py:278 late_fade */
GM_INLINE tuple_9 composition_late_fade(real h_, array1_f8 e_)
{
    real spans_;
    real fade_;
    if (((e_.p[79] == (real)0.0))) {
        return (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    }
    spans_ = (h_ / e_.p[79]);
    real t1 = elementary_exponential(((real)(-3.6778146453739153) * spans_));
    fade_ = t1;
    real t3 = (fade_ * gm_cos(((real)3.5087619195674447 * spans_)));
    real t4 = (fade_ * gm_sin(((real)3.5087619195674447 * spans_)));
    real t2 = elementary_exponential(((real)(-4.644370709252172) * spans_));
    return (tuple_9){{spans_, t3, t4, t2}};
}

/* plant/effects/composition.py:295 advanced_servo */
GM_INLINE tuple_9 composition_advanced_servo(tuple_9 memory_, tuple_15 begin_, real x3_, real h_, tuple_9 late_, array1_f8 e_)
{
    real integral_;
    real a_;
    real b_;
    real c_;
    real r_;
    real x1_;
    real v_;
    real middle_;
    real error_;
    real spans_;
    real cosine_;
    real sine_;
    real fade_;
    real first_;
    real last_;
    real slope_;
    real ga_;
    real gb_;
    real fa_;
    real fb_;
    real gc_;
    real fc_;
    integral_ = memory_.v[0];
    a_ = memory_.v[1];
    b_ = memory_.v[2];
    c_ = memory_.v[3];
    r_ = begin_.v[0];
    x1_ = begin_.v[1];
    v_ = begin_.v[2];
    if (((e_.p[78] > (real)0.0))) {
        middle_ = (x1_ + (((real)0.5 * h_) * x3_));
        tuple_15 t1 = composition_term((tuple_15){{(real)0.0, (real)0.0, (real)0.0}}, e_, middle_);
        error_ = t1.v[0];
        real t4 = integral_;
        real t3 = (h_ * e_.p[78]);
        real t2 = transmission_dead_zone(((r_ - middle_) - error_), e_.p[22]);
        real t5 = composition_limited((t4 + (t3 * t2)), e_);
        integral_ = t5;
    }
    if (((e_.p[79] > (real)0.0))) {
        spans_ = late_.v[0];
        cosine_ = late_.v[1];
        sine_ = late_.v[2];
        fade_ = late_.v[3];
        real t6 = composition_control_law(r_, e_, x1_, v_, memory_.v[0]);
        first_ = t6;
        real t7 = composition_control_law(r_, e_, (x1_ + (h_ * x3_)), (((real)2.0 * x3_) - v_), integral_);
        last_ = t7;
        slope_ = ((last_ - first_) / spans_);
        real t8 = ((-slope_) * (real)(-0.14234278844194384));
        real t9 = ((-slope_) * (real)(-0.13579992570815375));
        ga_ = t8;
        gb_ = t9;
        fa_ = (((ga_ - first_) * (real)(-0.14234278844194384)) - (gb_ * (real)(-0.13579992570815375)));
        fb_ = (((ga_ - first_) * (real)(-0.13579992570815375)) + (gb_ * (real)(-0.14234278844194384)));
        gc_ = ((-slope_) / (real)(-4.644370709252172));
        fc_ = ((gc_ - first_) / (real)(-4.644370709252172));
        real t10 = (((fa_ + (ga_ * spans_)) + ((a_ - fa_) * cosine_)) - ((b_ - fb_) * sine_));
        real t11 = (((fb_ + (gb_ * spans_)) + ((a_ - fa_) * sine_)) + ((b_ - fb_) * cosine_));
        a_ = t10;
        b_ = t11;
        c_ = ((fc_ + (gc_ * spans_)) + ((c_ - fc_) * fade_));
    }
    return (tuple_9){{integral_, a_, b_, c_}};
}

/* plant/batch.py:200 _memory_loops */
GM_INLINE void batch_memory_loops(array1_f8 s_, int64_t x3_, int64_t x4_, real h_, array1_f8 p_, array1_f8 e_)
{
    tuple_9 fade_;
    int64_t i_;
    batch_both_16((tuple_30){s_, x3_, x4_, h_, p_, e_});
    if ((((e_.p[78] > (real)0.0)) || ((e_.p[79] > (real)0.0)))) {
        tuple_9 t1 = composition_late_fade(h_, e_);
        fade_ = t1;
        int64_t t2 = (s_.n[0] / 40);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            i_ = k3;
            tuple_9 t4 = composition_advanced_servo((tuple_9){{s_.p[((128 + i_))], s_.p[((144 + i_))], s_.p[((160 + i_))], s_.p[((176 + i_))]}}, (tuple_15){{s_.p[((208 + i_))], s_.p[((0 + i_))], s_.p[((32 + i_))]}}, s_.p[((x3_ + i_))], h_, fade_, e_);
            s_.p[((400 + i_))] = t4.v[0];
            s_.p[((416 + i_))] = t4.v[1];
            s_.p[((432 + i_))] = t4.v[2];
            s_.p[((448 + i_))] = t4.v[3];
        }
    }
    return;
}

/* plant/batch.py:249 _step_with_effects */
GM_APART void batch_step_with_effects(array1_f8 s_, real h_, array1_f8 p_, array1_f8 e_)
{
    int64_t lanes_;
    real half_;
    int64_t i_;
    int64_t stage_;
    real elapsed_;
    real factor_;
    real span_;
    lanes_ = (s_.n[0] / 40);
    half_ = ((real)0.5 * h_);
    for (int64_t k1 = 0; k1 < lanes_; k1 += 1) {
        i_ = k1;
        real t2 = s_.p[((0 + i_))];
        real t3 = s_.p[((16 + i_))];
        real t4 = s_.p[((32 + i_))];
        real t5 = s_.p[((48 + i_))];
        s_.p[((272 + i_))] = t2;
        s_.p[((288 + i_))] = t3;
        s_.p[((304 + i_))] = t4;
        s_.p[((320 + i_))] = t5;
    }
    int64_t t6 = (8 * lanes_);
    for (int64_t k7 = 0; k7 < t6; k7 += 1) {
        i_ = k7;
        s_.p[((336 + i_))] = s_.p[((64 + i_))];
    }
    for (int64_t k8 = 0; k8 < 4; k8 += 1) {
        stage_ = k8;
        elapsed_ = (((stage_ == 0)) ? (real)0.0 : (((stage_ < 3)) ? half_ : h_));
        batch_rates(s_, elapsed_, p_, e_);
        if (((stage_ == 0))) {
            for (int64_t k9 = 0; k9 < lanes_; k9 += 1) {
                i_ = k9;
                real t10 = s_.p[((304 + i_))];
                real t11 = s_.p[((320 + i_))];
                s_.p[((496 + i_))] = t10;
                s_.p[((512 + i_))] = t11;
                real t12 = s_.p[((464 + i_))];
                real t13 = s_.p[((480 + i_))];
                s_.p[((528 + i_))] = t12;
                s_.p[((544 + i_))] = t13;
            }
        } else {
            factor_ = (((stage_ == 3)) ? (real)1.0 : (real)2.0);
            for (int64_t k14 = 0; k14 < lanes_; k14 += 1) {
                i_ = k14;
                s_.p[((496 + i_))] = (s_.p[((496 + i_))] + (factor_ * s_.p[((304 + i_))]));
                s_.p[((512 + i_))] = (s_.p[((512 + i_))] + (factor_ * s_.p[((320 + i_))]));
                s_.p[((528 + i_))] = (s_.p[((528 + i_))] + (factor_ * s_.p[((464 + i_))]));
                s_.p[((544 + i_))] = (s_.p[((544 + i_))] + (factor_ * s_.p[((480 + i_))]));
            }
        }
        if (((stage_ < 3))) {
            span_ = (((stage_ < 2)) ? half_ : h_);
            batch_memory_loops(s_, 304, 320, span_, p_, e_);
            for (int64_t k15 = 0; k15 < lanes_; k15 += 1) {
                i_ = k15;
                s_.p[((272 + i_))] = (s_.p[((0 + i_))] + (span_ * s_.p[((304 + i_))]));
                s_.p[((288 + i_))] = (s_.p[((16 + i_))] + (span_ * s_.p[((320 + i_))]));
                s_.p[((304 + i_))] = (s_.p[((32 + i_))] + (span_ * s_.p[((464 + i_))]));
                s_.p[((320 + i_))] = (s_.p[((48 + i_))] + (span_ * s_.p[((480 + i_))]));
            }
        }
    }
    for (int64_t k16 = 0; k16 < lanes_; k16 += 1) {
        i_ = k16;
        real t17 = (s_.p[((496 + i_))] / (real)6.0);
        real t18 = (s_.p[((512 + i_))] / (real)6.0);
        s_.p[((496 + i_))] = t17;
        s_.p[((512 + i_))] = t18;
    }
    batch_memory_loops(s_, 496, 512, h_, p_, e_);
    for (int64_t k19 = 0; k19 < lanes_; k19 += 1) {
        i_ = k19;
        s_.p[((0 + i_))] = (s_.p[((0 + i_))] + (h_ * s_.p[((496 + i_))]));
        s_.p[((16 + i_))] = (s_.p[((16 + i_))] + (h_ * s_.p[((512 + i_))]));
        s_.p[((32 + i_))] = (s_.p[((32 + i_))] + ((h_ / (real)6.0) * s_.p[((528 + i_))]));
        s_.p[((48 + i_))] = (s_.p[((48 + i_))] + ((h_ / (real)6.0) * s_.p[((544 + i_))]));
        s_.p[((192 + i_))] = (s_.p[((192 + i_))] + h_);
    }
    int64_t t20 = (8 * lanes_);
    for (int64_t k21 = 0; k21 < t20; k21 += 1) {
        i_ = k21;
        s_.p[((64 + i_))] = s_.p[((336 + i_))];
    }
    return;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_7 composition_term_4(tuple_31 memories_, view1_f8 state_)
{
    return (tuple_7){{memories_.f0, state_.p[5 * state_.s[0]]}};
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_15 composition_term_5(tuple_7 memories_, view1_f8 state_)
{
    return (tuple_15){{memories_.v[0], memories_.v[1], state_.p[6 * state_.s[0]]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_15 composition_both_7(tuple_31 value_, tuple_32 arguments_)
{
    tuple_7 t1 = composition_term_4(value_, arguments_.f0);
    tuple_15 t2 = composition_term_5(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_9 composition_term_6(tuple_15 memories_, view1_f8 state_)
{
    return (tuple_9){{memories_.v[0], memories_.v[1], memories_.v[2], state_.p[7 * state_.s[0]]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_9 composition_both_6(tuple_31 value_, tuple_32 arguments_)
{
    tuple_15 t1 = composition_both_7(value_, (tuple_32){arguments_.f0});
    tuple_9 t2 = composition_term_6(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_8 composition_term_7(tuple_9 memories_, view1_f8 state_)
{
    return (tuple_8){{memories_.v[0], memories_.v[1], memories_.v[2], memories_.v[3], state_.p[8 * state_.s[0]]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_8 composition_both_5(tuple_31 value_, tuple_32 arguments_)
{
    tuple_9 t1 = composition_both_6(value_, (tuple_32){arguments_.f0});
    tuple_8 t2 = composition_term_7(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_33 composition_term_8(tuple_8 memories_, view1_f8 state_)
{
    return (tuple_33){{memories_.v[0], memories_.v[1], memories_.v[2], memories_.v[3], memories_.v[4], state_.p[9 * state_.s[0]]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_33 composition_both_4(tuple_31 value_, tuple_32 arguments_)
{
    tuple_8 t1 = composition_both_5(value_, (tuple_32){arguments_.f0});
    tuple_33 t2 = composition_term_8(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_14 composition_term_9(tuple_33 memories_, view1_f8 state_)
{
    return (tuple_14){{memories_.v[0], memories_.v[1], memories_.v[2], memories_.v[3], memories_.v[4], memories_.v[5], state_.p[10 * state_.s[0]]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_14 composition_both_3(tuple_31 value_, tuple_32 arguments_)
{
    tuple_33 t1 = composition_both_4(value_, (tuple_32){arguments_.f0});
    tuple_14 t2 = composition_term_9(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_34 composition_term_10(tuple_14 memories_, view1_f8 state_)
{
    return (tuple_34){{memories_.v[0], memories_.v[1], memories_.v[2], memories_.v[3], memories_.v[4], memories_.v[5], memories_.v[6], state_.p[11 * state_.s[0]]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_34 composition_both_2(tuple_31 value_, tuple_32 arguments_)
{
    tuple_14 t1 = composition_both_3(value_, (tuple_32){arguments_.f0});
    tuple_34 t2 = composition_term_10(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:376 stored_memories */
GM_INLINE tuple_34 composition_stored_memories(view1_f8 state_)
{
    tuple_34 t1 = composition_both_2((tuple_31){state_.p[4 * state_.s[0]]}, (tuple_32){state_});
    return t1;
}

/* plant/effects/composition.py:82 term_of.<locals>._three */
GM_INLINE mesh_error composition_three_4(array1_f8 e_)
{
    return (mesh_error){e_.p[18], e_.p[19], e_.p[20]};
}

/* plant/effects/gearbox.py:190 mesh_twist */
GM_INLINE real gearbox_mesh_twist_2(mesh_error c_, real x1_, real x2_, real z_)
{
    real t1 = elementary_sine(((c_.N_ * x1_) + c_.phi_));
    return (c_.A_ * t1);
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_11(real value_, array1_f8 e_, tuple_34 m_, tuple_7 arguments_)
{
    if (((e_.p[18] != (real)0.0))) {
        real t3 = value_;
        mesh_error t1 = composition_three_4(e_);
        real t2 = gearbox_mesh_twist_2(t1, arguments_.v[0], arguments_.v[1], m_.v[0]);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE hysteresis_branch composition_two_8(array1_f8 e_)
{
    return (hysteresis_branch){e_.p[16], e_.p[17]};
}

/* plant/effects/gearbox.py:149 branch_twist */
GM_INLINE real gearbox_branch_twist_2(hysteresis_branch c_, real x1_, real x2_, real z_)
{
    return (-(c_.h_ * z_));
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_12(real value_, array1_f8 e_, tuple_34 m_, tuple_7 arguments_)
{
    if (((e_.p[16] != (real)0.0))) {
        real t3 = value_;
        hysteresis_branch t1 = composition_two_8(e_);
        real t2 = gearbox_branch_twist_2(t1, arguments_.v[0], arguments_.v[1], m_.v[3]);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_8(real value_, tuple_36 arguments_)
{
    real t1 = composition_term_11(value_, arguments_.f0, arguments_.f1, (tuple_7){{arguments_.f2, arguments_.f3}});
    real t2 = composition_term_12(t1, arguments_.f0, arguments_.f1, (tuple_7){{arguments_.f2, arguments_.f3}});
    return t2;
}

/* plant/transmission.py:30 transmission_torque */
GM_INLINE tuple_7 transmission_transmission_torque(real twist_, real memory_, int64_t kind_, real stiffness_, real half_gap_, real width_, real hysteresis_stiffness_)
{
    real lower_;
    real upper_;
    real tau_k_;
    if (((kind_ == 1))) {
        real t1 = transmission_dead_zone((twist_ - width_), half_gap_);
        lower_ = (stiffness_ * t1);
        real t2 = transmission_dead_zone((twist_ + width_), half_gap_);
        upper_ = (stiffness_ * t2);
        memory_ = gm_min_f(gm_max_f(memory_, lower_), upper_);
        return (tuple_7){{memory_, memory_}};
    }
    if (((kind_ == 3))) {
        return (tuple_7){{(real)0.0, memory_}};
    }
    real t3 = transmission_dead_zone(twist_, half_gap_);
    tau_k_ = (stiffness_ * t3);
    if (((kind_ == 2))) {
        memory_ = gm_min_f(gm_max_f(memory_, (twist_ - width_)), (twist_ + width_));
        tau_k_ = (tau_k_ + (hysteresis_stiffness_ * (twist_ - memory_)));
    }
    return (tuple_7){{tau_k_, memory_}};
}

/* plant/effects/composition.py:73 term_of.<locals>._array */
GM_INLINE tuple_26 composition_array_5(array1_f8 e_)
{
    return (tuple_26){e_, 41};
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_13(real value_, array1_f8 e_, tuple_34 m_, tuple_7 arguments_)
{
    if (((e_.p[41] != (real)0.0))) {
        real t3 = value_;
        tuple_26 t1 = composition_array_5(e_);
        real t2 = torque_map_map_of_twist(t1, arguments_.v[0], m_.v[0], arguments_.v[1]);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE hardening composition_one_6(array1_f8 e_)
{
    return (hardening){e_.p[13]};
}

/* plant/effects/gearbox.py:66 hardening_torque */
GM_INLINE real gearbox_hardening_torque_2(hardening c_, real twist_, real z_, real half_gap_)
{
    real out_;
    real t1 = transmission_dead_zone(twist_, half_gap_);
    out_ = t1;
    return (((c_.K3_ * out_) * out_) * out_);
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_14(real value_, array1_f8 e_, tuple_34 m_, tuple_7 arguments_)
{
    if (((e_.p[13] != (real)0.0))) {
        real t3 = value_;
        hardening t1 = composition_one_6(e_);
        real t2 = gearbox_hardening_torque_2(t1, arguments_.v[0], m_.v[0], arguments_.v[1]);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_10(real value_, tuple_36 arguments_)
{
    real t1 = composition_term_13(value_, arguments_.f0, arguments_.f1, (tuple_7){{arguments_.f2, arguments_.f3}});
    real t2 = composition_term_14(t1, arguments_.f0, arguments_.f1, (tuple_7){{arguments_.f2, arguments_.f3}});
    return t2;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE hysteresis_bouc_wen composition_two_9(array1_f8 e_)
{
    return (hysteresis_bouc_wen){e_.p[14], e_.p[15]};
}

/* plant/effects/gearbox.py:92 bouc_wen_torque */
GM_INLINE real gearbox_bouc_wen_torque_2(hysteresis_bouc_wen c_, real twist_, real z_, real half_gap_)
{
    return (c_.Th_ * z_);
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_15(real value_, array1_f8 e_, tuple_34 m_, tuple_7 arguments_)
{
    if (((e_.p[14] != (real)0.0))) {
        real t3 = value_;
        hysteresis_bouc_wen t1 = composition_two_9(e_);
        real t2 = gearbox_bouc_wen_torque_2(t1, arguments_.v[0], m_.v[2], arguments_.v[1]);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_9(real value_, tuple_36 arguments_)
{
    real t1 = composition_both_10(value_, (tuple_36){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3});
    real t2 = composition_term_15(t1, arguments_.f0, arguments_.f1, (tuple_7){{arguments_.f2, arguments_.f3}});
    return t2;
}

/* plant/effects/composition.py:382 elastic_torque */
GM_INLINE real composition_elastic_torque(real x1_, real x2_, tuple_34 m_, array1_f8 p_, array1_f8 e_)
{
    real twist_;
    real tau_k_;
    real t1 = composition_both_8((x1_ - x2_), (tuple_36){e_, m_, x1_, x2_});
    twist_ = t1;
    tuple_7 t2 = transmission_transmission_torque(twist_, m_.v[0], (int64_t)(p_.p[8]), p_.p[9], p_.p[10], p_.p[11], p_.p[12]);
    tau_k_ = t2.v[0];
    real t3 = composition_both_9(tau_k_, (tuple_36){e_, m_, twist_, p_.p[10]});
    return t3;
}

/* plant/effects/composition.py:82 term_of.<locals>._three */
GM_INLINE mesh_error composition_three_5(array1_f8 e_)
{
    return (mesh_error){e_.p[29], e_.p[30], e_.p[31]};
}

/* plant/effects/actuator.py:141 ripple_gain */
GM_INLINE real actuator_ripple_gain_2(mesh_error c_, real x1_)
{
    real t1 = elementary_sine(((c_.N_ * x1_) + c_.phi_));
    return ((real)1.0 + (c_.A_ * t1));
}

/* plant/effects/actuator.py:147 with_ripple */
GM_INLINE real actuator_with_ripple_2(mesh_error c_, real x1_, real x3_, real u_)
{
    real t1 = actuator_ripple_gain_2(c_, x1_);
    return (u_ * t1);
}

/* plant/effects/composition.py:121 _motor_torque.<locals>._term */
GM_INLINE real composition_term_16(real u_, array1_f8 e_, real x1_, real x3_)
{
    if (((e_.p[29] != (real)0.0))) {
        mesh_error t1 = composition_three_5(e_);
        real t2 = actuator_with_ripple_2(t1, x1_, x3_, u_);
        u_ = t2;
    }
    return u_;
}

/* plant/effects/composition.py:73 term_of.<locals>._array */
GM_INLINE tuple_26 composition_array_6(array1_f8 e_)
{
    return (tuple_26){e_, 41};
}

/* plant/effects/composition.py:121 _motor_torque.<locals>._term */
GM_INLINE real composition_term_17(real u_, array1_f8 e_, real x1_, real x3_)
{
    if (((e_.p[41] != (real)0.0))) {
        tuple_26 t1 = composition_array_6(e_);
        real t2 = torque_map_with_map(t1, x1_, x3_, u_);
        u_ = t2;
    }
    return u_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_12(real value_, tuple_37 arguments_)
{
    real t1 = composition_term_16(value_, arguments_.f0, arguments_.f1, arguments_.f2);
    real t2 = composition_term_17(t1, arguments_.f0, arguments_.f1, arguments_.f2);
    return t2;
}

/* plant/effects/composition.py:82 term_of.<locals>._three */
GM_INLINE mesh_error composition_three_6(array1_f8 e_)
{
    return (mesh_error){e_.p[10], e_.p[11], e_.p[12]};
}

/* plant/effects/motor_side.py:334 with_cogging */
GM_INLINE real motor_side_with_cogging_2(mesh_error c_, real x1_, real x3_, real u_)
{
    real t1 = elementary_sine(((c_.N_ * x1_) + c_.phi_));
    return (u_ + (c_.A_ * t1));
}

/* plant/effects/composition.py:121 _motor_torque.<locals>._term */
GM_INLINE real composition_term_18(real u_, array1_f8 e_, real x1_, real x3_)
{
    if (((e_.p[10] != (real)0.0))) {
        mesh_error t1 = composition_three_6(e_);
        real t2 = motor_side_with_cogging_2(t1, x1_, x3_, u_);
        u_ = t2;
    }
    return u_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_11(real value_, tuple_37 arguments_)
{
    real t1 = composition_both_12(value_, (tuple_37){arguments_.f0, arguments_.f1, arguments_.f2});
    real t2 = composition_term_18(t1, arguments_.f0, arguments_.f1, arguments_.f2);
    return t2;
}

/* plant/effects/composition.py:335 motor_effects */
GM_INLINE real composition_motor_effects(real u_, array1_f8 e_, real x1_, real x3_, tuple_34 m_)
{
    real t1 = composition_servo(u_, e_, x1_, x3_, (tuple_9){{m_.v[4], m_.v[5], m_.v[6], m_.v[7]}});
    real t2 = composition_both_11(t1, (tuple_37){e_, x1_, x3_});
    return t2;
}

/* plant/effects/composition.py:73 term_of.<locals>._array */
GM_INLINE tuple_26 composition_array_7(array1_f8 e_)
{
    return (tuple_26){e_, 41};
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_19(real value_, array1_f8 e_, tuple_34 m_, tuple_39 arguments_)
{
    if (((e_.p[41] != (real)0.0))) {
        real t3 = value_;
        tuple_26 t1 = composition_array_7(e_);
        real t2 = torque_map_map_friction(t1, arguments_.f0, arguments_.f1, m_.v[0], arguments_.f2);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE stribeck composition_two_10(array1_f8 e_)
{
    return (stribeck){e_.p[0], e_.p[1]};
}

/* plant/effects/motor_side.py:82 stribeck_torque */
GM_INLINE real motor_side_stribeck_torque_2(stribeck c_, real t_, real x3_, real z_, MotorFriction base_)
{
    real v_;
    v_ = (x3_ / c_.vs_);
    real t1 = elementary_exponential(((-v_) * v_));
    real t3 = (c_.Cs_ * t1);
    real t2 = motor_side_friction_side(x3_, base_);
    return (t3 * t2);
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_20(real value_, array1_f8 e_, tuple_34 m_, tuple_39 arguments_)
{
    if (((e_.p[0] != (real)0.0))) {
        real t3 = value_;
        stribeck t1 = composition_two_10(e_);
        real t2 = motor_side_stribeck_torque_2(t1, arguments_.f0, arguments_.f1, m_.v[0], arguments_.f2);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_17(real value_, tuple_38 arguments_)
{
    real t1 = composition_term_19(value_, arguments_.f0, arguments_.f1, (tuple_39){arguments_.f2, arguments_.f3, arguments_.f4});
    real t2 = composition_term_20(t1, arguments_.f0, arguments_.f1, (tuple_39){arguments_.f2, arguments_.f3, arguments_.f4});
    return t2;
}

/* plant/effects/composition.py:85 term_of.<locals>._four */
GM_INLINE lugre composition_four_3(array1_f8 e_)
{
    return (lugre){e_.p[2], e_.p[3], e_.p[4], e_.p[5]};
}

/* plant/effects/motor_side.py:123 lugre_level */
GM_INLINE real motor_side_lugre_level_3(lugre c_, real x3_, MotorFriction base_)
{
    real v_;
    v_ = (x3_ / c_.vs_);
    real t1 = elementary_exponential(((-v_) * v_));
    return (base_.coulomb_ + (c_.Cs_ * t1));
}

/* plant/effects/motor_side.py:140 lugre_torque */
GM_INLINE real motor_side_lugre_torque_2(lugre c_, real t_, real x3_, real z_, MotorFriction base_)
{
    real g_;
    real slip_;
    real bristles_;
    real t1 = motor_side_lugre_level_3(c_, x3_, base_);
    g_ = t1;
    slip_ = (((g_ > (real)0.0)) ? ((gm_fabs(x3_) * z_) / g_) : (real)0.0);
    bristles_ = ((c_.sigma0_ * z_) + (c_.sigma1_ * (x3_ - (c_.sigma0_ * slip_))));
    real t3;
    if (((base_.law_ <= (real)1.0))) {
    real t2 = motor_side_friction_side(x3_, base_);
        t3 = (bristles_ - (base_.coulomb_ * t2));
    } else {
        t3 = bristles_;
    }
    return t3;
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_21(real value_, array1_f8 e_, tuple_34 m_, tuple_39 arguments_)
{
    if (((e_.p[2] != (real)0.0))) {
        real t3 = value_;
        lugre t1 = composition_four_3(e_);
        real t2 = motor_side_lugre_torque_2(t1, arguments_.f0, arguments_.f1, m_.v[1], arguments_.f2);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_16(real value_, tuple_38 arguments_)
{
    real t1 = composition_both_17(value_, (tuple_38){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4});
    real t2 = composition_term_21(t1, arguments_.f0, arguments_.f1, (tuple_39){arguments_.f2, arguments_.f3, arguments_.f4});
    return t2;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE coulomb_asymmetry composition_one_7(array1_f8 e_)
{
    return (coulomb_asymmetry){e_.p[6]};
}

/* plant/effects/motor_side.py:207 asymmetry_torque */
GM_INLINE real motor_side_asymmetry_torque_2(coulomb_asymmetry c_, real t_, real x3_, real z_, MotorFriction base_)
{
    real t1 = motor_side_friction_side(x3_, base_);
    return (c_.Ca_ * gm_fabs(t1));
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_22(real value_, array1_f8 e_, tuple_34 m_, tuple_39 arguments_)
{
    if (((e_.p[6] != (real)0.0))) {
        real t3 = value_;
        coulomb_asymmetry t1 = composition_one_7(e_);
        real t2 = motor_side_asymmetry_torque_2(t1, arguments_.f0, arguments_.f1, m_.v[0], arguments_.f2);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_15(real value_, tuple_38 arguments_)
{
    real t1 = composition_both_16(value_, (tuple_38){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4});
    real t2 = composition_term_22(t1, arguments_.f0, arguments_.f1, (tuple_39){arguments_.f2, arguments_.f3, arguments_.f4});
    return t2;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE viscous_asymmetry composition_one_8(array1_f8 e_)
{
    return (viscous_asymmetry){e_.p[7]};
}

/* plant/effects/motor_side.py:237 viscous_asymmetry_torque */
GM_INLINE real motor_side_viscous_asymmetry_torque_2(viscous_asymmetry c_, real t_, real x3_, real z_, MotorFriction base_)
{
    return (c_.Cva_ * gm_fabs(x3_));
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_23(real value_, array1_f8 e_, tuple_34 m_, tuple_39 arguments_)
{
    if (((e_.p[7] != (real)0.0))) {
        real t3 = value_;
        viscous_asymmetry t1 = composition_one_8(e_);
        real t2 = motor_side_viscous_asymmetry_torque_2(t1, arguments_.f0, arguments_.f1, m_.v[0], arguments_.f2);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_14(real value_, tuple_38 arguments_)
{
    real t1 = composition_both_15(value_, (tuple_38){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4});
    real t2 = composition_term_23(t1, arguments_.f0, arguments_.f1, (tuple_39){arguments_.f2, arguments_.f3, arguments_.f4});
    return t2;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE viscous_drift composition_two_11(array1_f8 e_)
{
    return (viscous_drift){e_.p[8], e_.p[9]};
}

/* plant/effects/motor_side.py:294 drift_torque */
GM_INLINE real motor_side_drift_torque_2(viscous_drift c_, real t_, real x3_, real z_, MotorFriction base_)
{
    real t2 = (base_.viscous_ * c_.r_);
    real t1 = elementary_exponential(((-t_) / c_.T_));
    return ((t2 * ((real)1.0 - t1)) * x3_);
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_24(real value_, array1_f8 e_, tuple_34 m_, tuple_39 arguments_)
{
    if (((e_.p[8] != (real)0.0))) {
        real t3 = value_;
        viscous_drift t1 = composition_two_11(e_);
        real t2 = motor_side_drift_torque_2(t1, arguments_.f0, arguments_.f1, m_.v[0], arguments_.f2);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_13(real value_, tuple_38 arguments_)
{
    real t1 = composition_both_14(value_, (tuple_38){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4});
    real t2 = composition_term_24(t1, arguments_.f0, arguments_.f1, (tuple_39){arguments_.f2, arguments_.f3, arguments_.f4});
    return t2;
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

/* plant/effects/composition.py:73 term_of.<locals>._array */
GM_INLINE tuple_26 composition_array_8(array1_f8 e_)
{
    return (tuple_26){e_, 41};
}

/* plant/effects/composition.py:109 _added.<locals>._of.<locals>._term */
GM_INLINE real composition_term_25(real value_, array1_f8 e_, tuple_34 m_, tuple_15 arguments_)
{
    if (((e_.p[41] != (real)0.0))) {
        real t3 = value_;
        tuple_26 t1 = composition_array_8(e_);
        real t2 = torque_map_map_on_arm(t1, arguments_.v[0], arguments_.v[1], arguments_.v[2], m_.v[0]);
        value_ = (t3 + t2);
    }
    return value_;
}

/* plant/simulate.py:123 plugged */
GM_INLINE tuple_15 simulate_plugged(real t_, real x1_, real x2_, real x3_, real x4_, real u_, real tau_k_, array1_f8 theta_)
{
    return (tuple_15){{(real)0.0, (real)0.0, (real)0.0}};
}

/* plant/simulate.py:145 torques */
GM_INLINE tuple_15 simulate_torques(real t_, tuple_9 x_, tuple_34 m_, real u_, PackedDrive drive_)
{
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    array1_f8 p_;
    array1_f8 e_;
    real tau_k_;
    real motor_;
    real tau_arm_;
    real on_motor_;
    real on_arm_;
    real in_gearbox_;
    x1_ = x_.v[0];
    x2_ = x_.v[1];
    x3_ = x_.v[2];
    x4_ = x_.v[3];
    p_ = drive_.p_;
    e_ = drive_.e_;
    real t1 = composition_elastic_torque(x1_, x2_, m_, p_, e_);
    tau_k_ = t1;
    real t2 = composition_motor_effects(u_, e_, x1_, x3_, m_);
    real t4 = (t2 - u_);
    real t3 = composition_both_13((real)0.0, (tuple_38){e_, m_, t_, x3_, (MotorFriction){p_.p[3], p_.p[4], p_.p[5], p_.p[20]}});
    motor_ = (t4 - t3);
    real t5 = drive_arm_load(x2_, x4_, p_);
    real t6 = composition_term_25(t5, e_, m_, (tuple_15){{t_, x2_, x4_}});
    tau_arm_ = t6;
    tuple_15 t7 = simulate_plugged(t_, x1_, x2_, x3_, x4_, u_, tau_k_, drive_.theta_);
    on_motor_ = t7.v[0];
    on_arm_ = t7.v[1];
    in_gearbox_ = t7.v[2];
    if (((drive_.call_ != 0))) {
        real t8[3];
        gm_called(t8, drive_.call_, t_, x1_, x2_, x3_, x4_, u_, tau_k_, drive_.theta_.p, drive_.theta_.n[0]);
        on_motor_ = t8[0];
        on_arm_ = t8[1];
        in_gearbox_ = t8[2];
    }
    return (tuple_15){{(tau_k_ + in_gearbox_), (tau_arm_ + on_arm_), (motor_ + on_motor_)}};
}

/* plant/friction_law.py:113 holding */
GM_INLINE real friction_law_holding(real torque_, real moving_, real limit_, real softness_, real static_)
{
    real needed_;
    needed_ = ((torque_ + moving_) / ((real)1.0 + softness_));
    return (((gm_fabs(needed_) <= (static_ * limit_))) ? needed_ : gm_copysign(limit_, needed_));
}

/* plant/drive.py:1041 _held_torque */
GM_STATIC real drive_held_torque(real x1_, real x3_, real u_, real tau_arm_, array1_f8 p_)
{
    real m2_;
    real both_;
    real driving_;
    real level_;
    real torque_;
    real friction_;
    m2_ = ((real)1.0 / p_.p[1]);
    both_ = (((real)1.0 / p_.p[0]) + m2_);
    driving_ = ((((u_ + p_.p[7]) - (p_.p[6] * x1_)) - (p_.p[3] * x3_)) - tau_arm_);
    real t1 = (p_.p[4] + p_.p[24]);
    level_ = t1;
    torque_ = (real)0.0;
    int64_t t2 = (((p_.p[19] != (real)0.0)) ? 2 : 1);
    for (int64_t k3 = 0; k3 < t2; k3 += 1) {
        real t4 = friction_law_holding(driving_, ((p_.p[22] * x3_) * both_), (level_ + (p_.p[19] * gm_fabs(torque_))), p_.p[21], p_.p[23]);
        friction_ = t4;
        torque_ = (((m2_ * (driving_ - friction_)) / both_) + tau_arm_);
    }
    return torque_;
}

/* plant/drive.py:1014 rigid_torque */
GM_STATIC real drive_rigid_torque(real x1_, real x3_, real u_, real tau_arm_, array1_f8 p_)
{
    real both_;
    real friction_;
    real c_;
    real k_;
    if (((p_.p[20] > (real)1.0))) {
        real t1 = drive_held_torque(x1_, x3_, u_, tau_arm_, p_);
        return t1;
    }
    both_ = ((real)1.0 / (p_.p[0] + p_.p[1]));
    real t4 = (p_.p[3] * x3_);
    real t3 = p_.p[4];
    real t2 = friction_law_side((p_.p[5] * x3_), p_.p[20]);
    friction_ = (t4 + (t3 * t2));
    c_ = (both_ * ((p_.p[0] * (((u_ + p_.p[7]) - friction_) - (p_.p[6] * x1_))) + (p_.p[1] * tau_arm_)));
    real t6 = (both_ * p_.p[0]);
    real t5 = drive_motor_friction_load_slope(x3_, (real)1.0, p_);
    k_ = (t6 * t5);
    return (((c_ > (real)0.0)) ? (c_ / ((real)1.0 + k_)) : (c_ / ((real)1.0 - k_)));
}

/* plant/simulate.py:173 constrained */
GM_INLINE real simulate_constrained(tuple_9 x_, real u_, tuple_15 extra_, tuple_15 acting_, array1_f8 p_)
{
    if ((((int64_t)(p_.p[8]) == 3))) {
        real t1 = drive_rigid_torque(x_.v[0], x_.v[2], ((u_ + acting_.v[2]) + extra_.v[0]), (acting_.v[1] - extra_.v[1]), p_);
        return t1;
    }
    return (acting_.v[0] + extra_.v[2]);
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

/* plant/simulate.py:193 derivative */
GM_INLINE tuple_9 simulate_derivative(real t_, tuple_9 x_, tuple_34 m_, tuple_35 inputs_)
{
    real u_;
    tuple_15 extra_;
    PackedDrive drive_;
    tuple_15 acting_;
    real tau_k_;
    array1_f8 p_;
    real tau_arm_;
    real arm_;
    u_ = inputs_.f0;
    extra_ = inputs_.f1;
    drive_ = inputs_.f2;
    tuple_15 t1 = simulate_torques(t_, x_, m_, u_, drive_);
    acting_ = t1;
    real t2 = simulate_constrained(x_, u_, extra_, acting_, drive_.p_);
    tau_k_ = t2;
    real t3 = (acting_.v[1] - extra_.v[1]);
    p_ = drive_.p_;
    tau_arm_ = t3;
    real t5 = tau_arm_;
    real t4 = drive_arm_constraint(x_.v[2], x_.v[3], tau_k_, tau_arm_, p_);
    tau_arm_ = (t5 + t4);
    real t6 = drive_arm_acceleration(x_.v[2], x_.v[3], tau_k_, tau_arm_, p_);
    arm_ = t6;
    if ((((p_.p[20] > (real)1.0)) && (((int64_t)(p_.p[8]) == 3)))) {
        return (tuple_9){{x_.v[2], x_.v[3], arm_, arm_}};
    }
    real t7 = drive_motor_acceleration_by_law(x_.v[0], x_.v[2], x_.v[3], ((u_ + acting_.v[2]) + extra_.v[0]), tau_k_, p_);
    return (tuple_9){{x_.v[2], x_.v[3], t7, arm_}};
}

/* plant/effects/composition.py:253 step_damper */
GM_INLINE real composition_step_damper(real r_, array1_f8 e_, real x1_, real x3_, tuple_34 m_)
{
    real bristles_;
    real limit_;
    bool free_;
    bristles_ = (((e_.p[2] != (real)0.0)) ? e_.p[3] : (real)0.0);
    if ((((e_.p[75] == (real)0.0)) || ((e_.p[76] == (real)0.0)))) {
        return bristles_;
    }
    limit_ = gm_min_f(e_.p[77], e_.p[21]);
    real t1 = composition_control_law(r_, e_, x1_, x3_, m_.v[4]);
    free_ = ((gm_fabs(t1) < limit_));
    return (free_ ? (bristles_ + e_.p[76]) : bristles_);
}

/* plant/drive.py:765 braked */
GM_INLINE tuple_7 drive_braked(real h_, real damper_, array1_f8 p_)
{
    real motor_;
    real arm_;
    real both_;
    if (((p_.p[25] == (real)0.0))) {
        return (tuple_7){{(real)0.0, (real)0.0}};
    }
    if (((p_.p[25] == (real)3.0))) {
        return (tuple_7){{(real)1.0, (real)1.0}};
    }
    real t1 = p_.p[3];
    real t2 = p_.p[13];
    motor_ = t1;
    arm_ = t2;
    if (((p_.p[25] == (real)2.0))) {
        real t3 = ((motor_ + p_.p[2]) + damper_);
        real t4 = (arm_ + p_.p[2]);
        motor_ = t3;
        arm_ = t4;
    }
    if (((p_.p[8] == (real)3.0))) {
        both_ = ((real)1.0 / ((real)1.0 + ((h_ * (motor_ + arm_)) / (((real)1.0 / p_.p[0]) + ((real)1.0 / p_.p[1])))));
        return (tuple_7){{both_, both_}};
    }
    return (tuple_7){{((real)1.0 / ((real)1.0 + ((h_ * motor_) * p_.p[0]))), ((real)1.0 / ((real)1.0 + ((h_ * arm_) * p_.p[1])))}};
}

/* plant/simulate.py:226 _brake */
GM_INLINE tuple_7 simulate_brake(real h_, tuple_9 x_, tuple_34 m_, tuple_35 inputs_)
{
    real u_;
    PackedDrive drive_;
    u_ = inputs_.f0;
    drive_ = inputs_.f2;
    real t1 = composition_step_damper(u_, drive_.e_, x_.v[0], x_.v[2], m_);
    tuple_7 t2 = drive_braked(h_, t1, drive_.p_);
    return t2;
}

/* plant/effects/composition.py:85 term_of.<locals>._four */
GM_INLINE lugre composition_four_4(array1_f8 e_)
{
    return (lugre){e_.p[2], e_.p[3], e_.p[4], e_.p[5]};
}

/* plant/effects/motor_side.py:123 lugre_level */
GM_INLINE real motor_side_lugre_level_4(lugre c_, real x3_, MotorFriction base_)
{
    real v_;
    v_ = (x3_ / c_.vs_);
    real t1 = elementary_exponential(((-v_) * v_));
    return (base_.coulomb_ + (c_.Cs_ * t1));
}

/* plant/effects/motor_side.py:162 bristle */
GM_INLINE real motor_side_bristle_2(lugre c_, real z_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real g_;
    real t1 = motor_side_lugre_level_4(c_, x3_, base_);
    g_ = t1;
    if ((((x3_ == (real)0.0)) || ((g_ <= (real)0.0)))) {
        return z_;
    }
    real t2 = motor_side_relaxed(z_, gm_copysign((g_ / c_.sigma0_), x3_), ((c_.sigma0_ * gm_fabs(x3_)) / g_), h_);
    return t2;
}

/* plant/effects/composition.py:174 _memory.<locals>._term */
GM_INLINE tuple_7 composition_term_26(tuple_31 advanced_, array1_f8 e_, tuple_34 m_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real z_;
    z_ = m_.v[1];
    if (((e_.p[2] != (real)0.0))) {
        lugre t1 = composition_four_4(e_);
        real t2 = motor_side_bristle_2(t1, z_, x3_, x4_, h_, base_);
        z_ = t2;
    }
    return (tuple_7){{advanced_.f0, z_}};
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE hysteresis_bouc_wen composition_two_12(array1_f8 e_)
{
    return (hysteresis_bouc_wen){e_.p[14], e_.p[15]};
}

/* plant/effects/gearbox.py:109 loop_memory */
GM_INLINE real gearbox_loop_memory_3(hysteresis_bouc_wen c_, real z_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real rate_;
    rate_ = (x3_ - x4_);
    real t1 = motor_side_relaxed(z_, gm_copysign((real)1.0, rate_), (gm_fabs(rate_) / c_.dh_), h_);
    return t1;
}

/* plant/effects/composition.py:174 _memory.<locals>._term */
GM_INLINE tuple_15 composition_term_27(tuple_7 advanced_, array1_f8 e_, tuple_34 m_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real z_;
    z_ = m_.v[2];
    if (((e_.p[14] != (real)0.0))) {
        hysteresis_bouc_wen t1 = composition_two_12(e_);
        real t2 = gearbox_loop_memory_3(t1, z_, x3_, x4_, h_, base_);
        z_ = t2;
    }
    return (tuple_15){{advanced_.v[0], advanced_.v[1], z_}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_15 composition_both_19(tuple_31 value_, tuple_40 arguments_)
{
    tuple_7 t1 = composition_term_26(value_, arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5);
    tuple_15 t2 = composition_term_27(t1, arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5);
    return t2;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE hysteresis_branch composition_two_13(array1_f8 e_)
{
    return (hysteresis_branch){e_.p[16], e_.p[17]};
}

/* plant/effects/gearbox.py:109 loop_memory */
GM_INLINE real gearbox_loop_memory_4(hysteresis_branch c_, real z_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real rate_;
    rate_ = (x3_ - x4_);
    real t1 = motor_side_relaxed(z_, gm_copysign((real)1.0, rate_), (gm_fabs(rate_) / c_.ds_), h_);
    return t1;
}

/* plant/effects/composition.py:174 _memory.<locals>._term */
GM_INLINE tuple_9 composition_term_28(tuple_15 advanced_, array1_f8 e_, tuple_34 m_, real x3_, real x4_, real h_, MotorFriction base_)
{
    real z_;
    z_ = m_.v[3];
    if (((e_.p[16] != (real)0.0))) {
        hysteresis_branch t1 = composition_two_13(e_);
        real t2 = gearbox_loop_memory_4(t1, z_, x3_, x4_, h_, base_);
        z_ = t2;
    }
    return (tuple_9){{advanced_.v[0], advanced_.v[1], advanced_.v[2], z_}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_9 composition_both_18(tuple_31 value_, tuple_40 arguments_)
{
    tuple_15 t1 = composition_both_19(value_, (tuple_40){arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5});
    tuple_9 t2 = composition_term_28(t1, arguments_.f0, arguments_.f1, arguments_.f2, arguments_.f3, arguments_.f4, arguments_.f5);
    return t2;
}

/* plant/effects/composition.py:354 advanced_memories */
GM_INLINE tuple_34 composition_advanced_memories(tuple_34 m_, tuple_15 begin_, real x3_, real x4_, real h_, MotorFriction base_, array1_f8 e_)
{
    tuple_9 t1 = composition_both_18((tuple_31){m_.v[0]}, (tuple_40){e_, m_, x3_, x4_, h_, base_});
    tuple_9 t2 = composition_late_fade(h_, e_);
    tuple_9 t3 = composition_advanced_servo((tuple_9){{m_.v[4], m_.v[5], m_.v[6], m_.v[7]}}, begin_, x3_, h_, t2, e_);
    return (tuple_34){{t1.v[0], t1.v[1], t1.v[2], t1.v[3], t3.v[0], t3.v[1], t3.v[2], t3.v[3]}};
}

/* plant/simulate.py:219 _memories */
GM_INLINE tuple_34 simulate_memories(tuple_34 m_, tuple_9 x_, real x3_, real x4_, real h_, tuple_35 inputs_)
{
    array1_f8 p_;
    p_ = inputs_.f2.p_;
    tuple_34 t1 = composition_advanced_memories(m_, (tuple_15){{inputs_.f0, x_.v[0], x_.v[2]}}, x3_, x4_, h_, (MotorFriction){p_.p[3], p_.p[4], p_.p[5], p_.p[20]}, inputs_.f2.e_);
    return t1;
}

/* plant/runge_kutta.py:36 integrator.<locals>.step */
GM_INLINE tuple_41 runge_kutta_step_2(real t_, tuple_9 x_, tuple_34 m_, real h_, tuple_35 inputs_)
{
    real x1_;
    real x2_;
    real x3_;
    real x4_;
    real half_;
    real a1_;
    real a2_;
    real a3_;
    real a4_;
    real motor_;
    real arm_;
    real v1_;
    real v2_;
    tuple_9 change_;
    real b1_;
    real b2_;
    real b3_;
    real b4_;
    real c1_;
    real c2_;
    real c3_;
    real c4_;
    real d1_;
    real d2_;
    real d3_;
    real d4_;
    x1_ = x_.v[0];
    x2_ = x_.v[1];
    x3_ = x_.v[2];
    x4_ = x_.v[3];
    half_ = ((real)0.5 * h_);
    tuple_9 t1 = simulate_derivative(t_, x_, m_, inputs_);
    a1_ = t1.v[0];
    a2_ = t1.v[1];
    a3_ = t1.v[2];
    a4_ = t1.v[3];
    tuple_7 t2 = simulate_brake(h_, x_, m_, inputs_);
    motor_ = t2.v[0];
    arm_ = t2.v[1];
    if (((motor_ != (real)0.0))) {
        real t3 = (x3_ + ((h_ * motor_) * a3_));
        real t4 = (x4_ + ((h_ * arm_) * a4_));
        v1_ = t3;
        v2_ = t4;
        change_ = (tuple_9){{(h_ * v1_), (h_ * v2_), ((h_ * motor_) * a3_), ((h_ * arm_) * a4_)}};
        real t6 = change_.v[0];
        real t7 = change_.v[1];
        real t8 = change_.v[2];
        real t9 = change_.v[3];
        tuple_34 t5 = simulate_memories(m_, x_, v1_, v2_, h_, inputs_);
        return (tuple_41){(tuple_9){{t6, t7, t8, t9}}, t5};
    }
    real t11 = (t_ + half_);
    real t12 = (x1_ + (half_ * a1_));
    real t13 = (x2_ + (half_ * a2_));
    real t14 = (x3_ + (half_ * a3_));
    real t15 = (x4_ + (half_ * a4_));
    tuple_34 t10 = simulate_memories(m_, x_, a1_, a2_, half_, inputs_);
    tuple_9 t16 = simulate_derivative(t11, (tuple_9){{t12, t13, t14, t15}}, t10, inputs_);
    b1_ = t16.v[0];
    b2_ = t16.v[1];
    b3_ = t16.v[2];
    b4_ = t16.v[3];
    real t18 = (t_ + half_);
    real t19 = (x1_ + (half_ * b1_));
    real t20 = (x2_ + (half_ * b2_));
    real t21 = (x3_ + (half_ * b3_));
    real t22 = (x4_ + (half_ * b4_));
    tuple_34 t17 = simulate_memories(m_, x_, b1_, b2_, half_, inputs_);
    tuple_9 t23 = simulate_derivative(t18, (tuple_9){{t19, t20, t21, t22}}, t17, inputs_);
    c1_ = t23.v[0];
    c2_ = t23.v[1];
    c3_ = t23.v[2];
    c4_ = t23.v[3];
    real t25 = (t_ + h_);
    real t26 = (x1_ + (h_ * c1_));
    real t27 = (x2_ + (h_ * c2_));
    real t28 = (x3_ + (h_ * c3_));
    real t29 = (x4_ + (h_ * c4_));
    tuple_34 t24 = simulate_memories(m_, x_, c1_, c2_, h_, inputs_);
    tuple_9 t30 = simulate_derivative(t25, (tuple_9){{t26, t27, t28, t29}}, t24, inputs_);
    d1_ = t30.v[0];
    d2_ = t30.v[1];
    d3_ = t30.v[2];
    d4_ = t30.v[3];
    real t31 = ((((a1_ + ((real)2.0 * b1_)) + ((real)2.0 * c1_)) + d1_) / (real)6.0);
    real t32 = ((((a2_ + ((real)2.0 * b2_)) + ((real)2.0 * c2_)) + d2_) / (real)6.0);
    v1_ = t31;
    v2_ = t32;
    change_ = (tuple_9){{(h_ * v1_), (h_ * v2_), ((h_ / (real)6.0) * (((a3_ + ((real)2.0 * b3_)) + ((real)2.0 * c3_)) + d3_)), ((h_ / (real)6.0) * (((a4_ + ((real)2.0 * b4_)) + ((real)2.0 * c4_)) + d4_))}};
    real t34 = change_.v[0];
    real t35 = change_.v[1];
    real t36 = change_.v[2];
    real t37 = change_.v[3];
    tuple_34 t33 = simulate_memories(m_, x_, v1_, v2_, h_, inputs_);
    return (tuple_41){(tuple_9){{t34, t35, t36, t37}}, t33};
}

/* plant/simulate.py:235 play_after */
GM_INLINE real simulate_play_after(tuple_9 x_, tuple_34 m_, array1_f8 p_)
{
    tuple_7 t1 = transmission_transmission_torque((x_.v[0] - x_.v[1]), m_.v[0], (int64_t)(p_.p[8]), p_.p[9], p_.p[10], p_.p[11], p_.p[12]);
    return t1.v[1];
}

/* plant/batch.py:298 _step_each */
GM_APART void batch_step_each(array1_f8 s_, real h_, PackedDrive drive_)
{
    int64_t i_;
    view1_f8 state_;
    tuple_9 change_;
    tuple_34 m_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 16; k1 += 1) {
        i_ = k1;
        int64_t t2 = gm_bound(i_, s_.n[0]);
        int64_t t3 = gm_span(t2, s_.n[0]);
        int64_t t4 = (t3 + 15) / 16;
        state_ = (view1_f8){s_.p + t2 * (1), {t4}, {(1) * 16}};
        real t6 = s_.p[((192 + i_))];
        real t7 = state_.p[0 * state_.s[0]];
        real t8 = state_.p[1 * state_.s[0]];
        real t9 = state_.p[2 * state_.s[0]];
        real t10 = state_.p[3 * state_.s[0]];
        tuple_34 t5 = composition_stored_memories(state_);
        tuple_41 t11 = runge_kutta_step_2(t6, (tuple_9){{t7, t8, t9, t10}}, t5, h_, (tuple_35){s_.p[((208 + i_))], (tuple_15){{s_.p[((224 + i_))], s_.p[((240 + i_))], s_.p[((256 + i_))]}}, drive_});
        change_ = t11.f0;
        m_ = t11.f1;
        for (int64_t k12 = 0; k12 < 4; k12 += 1) {
            j_ = k12;
            state_.p[(j_) * state_.s[0]] = (state_.p[(j_) * state_.s[0]] + change_.v[(j_)]);
        }
        for (int64_t k13 = 1; k13 < 8; k13 += 1) {
            j_ = k13;
            state_.p[((4 + j_)) * state_.s[0]] = m_.v[(j_)];
        }
        real t14 = simulate_play_after((tuple_9){{state_.p[0 * state_.s[0]], state_.p[1 * state_.s[0]], state_.p[2 * state_.s[0]], state_.p[3 * state_.s[0]]}}, m_, drive_.p_);
        state_.p[4 * state_.s[0]] = t14;
        s_.p[((192 + i_))] = (s_.p[((192 + i_))] + h_);
    }
    return;
}

/* plant/batch.py:328 step_lanes */
GM_INLINE void batch_step_lanes(array1_f8 s_, real h_, int64_t form_, PackedDrive drive_)
{
    if (((form_ == 0))) {
        batch_step(s_, h_, drive_.p_);
    } else {
        if (((form_ == 1))) {
            batch_step_with_effects(s_, h_, drive_.p_, drive_.e_);
        } else {
            batch_step_each(s_, h_, drive_);
        }
    }
    return;
}

/* estimation/innovation_filter.py:127 _noise_of */
GM_INLINE real innovation_filter_noise_of(int64_t side_, array2_f8 F_, array1_f8 torque_, array1_f8 p_)
{
    real inverse_;
    real slope_;
    real size_;
    real t1 = (((side_ == 0)) ? p_.p[0] : p_.p[1]);
    real t2 = F_.p[(((2 + side_)) * F_.n[1] + ((2 + side_)))];
    inverse_ = t1;
    slope_ = t2;
    size_ = torque_.p[(side_)];
    if ((((int64_t)(p_.p[8]) == 3))) {
        inverse_ = ((p_.p[0] * p_.p[1]) / (p_.p[0] + p_.p[1]));
        real t3 = (F_.p[(2 * F_.n[1] + 2)] + F_.p[(2 * F_.n[1] + 3)]);
        real t4 = torque_.p[0];
        slope_ = t3;
        size_ = t4;
    }
    return (((size_ * inverse_) * (real)0.5) * ((real)1.0 + slope_));
}

/* estimation/innovation_filter.py:139 _predict */
GM_INLINE void innovation_filter_predict(array2_f8 F_, view2_f8 P_, view2_f8 product_, real span_, FilterInput data_, PackedDrive drive_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    real total_;
    int64_t k_;
    bool rigid_;
    int64_t first_;
    real v_;
    n_ = F_.n[0];
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            j_ = k2;
            total_ = (real)0.0;
            for (int64_t k3 = 0; k3 < n_; k3 += 1) {
                k_ = k3;
                total_ = (total_ + (F_.p[((i_) * F_.n[1] + (k_))] * P_.p[(k_) * P_.s[0] + (j_) * P_.s[1]]));
            }
            product_.p[(i_) * product_.s[0] + (j_) * product_.s[1]] = total_;
        }
    }
    for (int64_t k4 = 0; k4 < n_; k4 += 1) {
        i_ = k4;
        int64_t t5 = (i_ + 1);
        for (int64_t k6 = 0; k6 < t5; k6 += 1) {
            j_ = k6;
            total_ = (real)0.0;
            for (int64_t k7 = 0; k7 < n_; k7 += 1) {
                k_ = k7;
                total_ = (total_ + (product_.p[(i_) * product_.s[0] + (k_) * product_.s[1]] * F_.p[((j_) * F_.n[1] + (k_))]));
            }
            P_.p[(i_) * P_.s[0] + (j_) * P_.s[1]] = total_;
            P_.p[(j_) * P_.s[0] + (i_) * P_.s[1]] = total_;
        }
    }
    bool t8 = (((int64_t)(drive_.p_.p[8]) == 3));
    rigid_ = t8;
    first_ = 0;
    if (((data_.fade_ > (real)0.0))) {
        P_.p[4 * P_.s[0] + 4 * P_.s[1]] = (P_.p[4 * P_.s[0] + 4 * P_.s[1]] + ((data_.torque_.p[0] * data_.torque_.p[0]) * ((real)1.0 - gm_pow(data_.fade_, (((real)2.0 * span_) / data_.dt_)))));
        first_ = (rigid_ ? 2 : 1);
    }
    int64_t t9 = first_;
    for (int64_t k10 = t9; k10 < 2; k10 += 1) {
        i_ = k10;
        int64_t t11 = first_;
        for (int64_t k12 = t11; k12 < 2; k12 += 1) {
            j_ = k12;
            if ((((i_ == j_)) || rigid_)) {
                real t13 = innovation_filter_noise_of(i_, F_, data_.torque_, drive_.p_);
                real t14 = innovation_filter_noise_of(j_, F_, data_.torque_, drive_.p_);
                v_ = (((t13 * t14) * data_.dt_) * span_);
                P_.p[((2 + i_)) * P_.s[0] + ((2 + j_)) * P_.s[1]] = (P_.p[((2 + i_)) * P_.s[0] + ((2 + j_)) * P_.s[1]] + v_);
                P_.p[(i_) * P_.s[0] + ((2 + j_)) * P_.s[1]] = (P_.p[(i_) * P_.s[0] + ((2 + j_)) * P_.s[1]] + (((real)0.5 * v_) * span_));
                P_.p[((2 + i_)) * P_.s[0] + (j_) * P_.s[1]] = (P_.p[((2 + i_)) * P_.s[0] + (j_) * P_.s[1]] + (((real)0.5 * v_) * span_));
                P_.p[(i_) * P_.s[0] + (j_) * P_.s[1]] = (P_.p[(i_) * P_.s[0] + (j_) * P_.s[1]] + (((v_ * span_) * span_) / (real)3.0));
            }
        }
    }
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE motor_encoder_eccentricity composition_two_14(array1_f8 e_)
{
    return (motor_encoder_eccentricity){e_.p[36], e_.p[37]};
}

/* plant/effects/encoder.py:13 eccentricity_error */
GM_INLINE tuple_15 encoder_eccentricity_error_2(motor_encoder_eccentricity c_, real x_)
{
    real error_;
    error_ = (c_.A_ * gm_sin((x_ + c_.phi_)));
    return (tuple_15){{error_, (c_.A_ * gm_cos((x_ + c_.phi_))), (-error_)}};
}

/* plant/effects/composition.py:163 _error.<locals>._term */
GM_INLINE tuple_15 composition_term_29(tuple_15 total_, array1_f8 e_, real x_)
{
    real error_;
    real slope_;
    real curvature_;
    if (((e_.p[36] != (real)0.0))) {
        motor_encoder_eccentricity t1 = composition_two_14(e_);
        tuple_15 t2 = encoder_eccentricity_error_2(t1, x_);
        error_ = t2.v[0];
        slope_ = t2.v[1];
        curvature_ = t2.v[2];
        return (tuple_15){{(total_.v[0] + error_), (total_.v[1] + slope_), (total_.v[2] + curvature_)}};
    }
    return total_;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE encoder_offset composition_one_9(array1_f8 e_)
{
    return (encoder_offset){e_.p[40]};
}

/* plant/effects/encoder.py:94 offset_error */
GM_INLINE tuple_15 encoder_offset_error(encoder_offset c_, real x_)
{
    return (tuple_15){{c_.c_, (real)0.0, (real)0.0}};
}

/* plant/effects/composition.py:163 _error.<locals>._term */
GM_INLINE tuple_15 composition_term_30(tuple_15 total_, array1_f8 e_, real x_)
{
    real error_;
    real slope_;
    real curvature_;
    if (((e_.p[40] != (real)0.0))) {
        encoder_offset t1 = composition_one_9(e_);
        tuple_15 t2 = encoder_offset_error(t1, x_);
        error_ = t2.v[0];
        slope_ = t2.v[1];
        curvature_ = t2.v[2];
        return (tuple_15){{(total_.v[0] + error_), (total_.v[1] + slope_), (total_.v[2] + curvature_)}};
    }
    return total_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_15 composition_both_20(tuple_15 value_, tuple_17 arguments_)
{
    tuple_15 t1 = composition_term_29(value_, arguments_.f0, arguments_.f1);
    tuple_15 t2 = composition_term_30(t1, arguments_.f0, arguments_.f1);
    return t2;
}

/* estimation/innovation_filter.py:122 _error */
GM_INLINE tuple_15 innovation_filter_error(int64_t channel_, array1_f8 e_, real x_)
{
    tuple_15 t3;
    if (((channel_ == 0))) {
    tuple_15 t1 = composition_term((tuple_15){{(real)0.0, (real)0.0, (real)0.0}}, e_, x_);
        t3 = t1;
    } else {
    tuple_15 t2 = composition_both_20((tuple_15){{(real)0.0, (real)0.0, (real)0.0}}, (tuple_17){e_, x_});
        t3 = t2;
    }
    return t3;
}

/* estimation/innovation_filter.py:173 _correct */
GM_INLINE real innovation_filter_correct(view2_f8 P_, int64_t channel_, real slope_, real variance_, array1_f8 gain_)
{
    int64_t n_;
    real s_;
    int64_t i_;
    int64_t j_;
    n_ = P_.n[0];
    s_ = (variance_ + ((slope_ * slope_) * P_.p[(channel_) * P_.s[0] + (channel_) * P_.s[1]]));
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        gain_.p[(i_)] = ((P_.p[(i_) * P_.s[0] + (channel_) * P_.s[1]] * slope_) / s_);
    }
    for (int64_t k2 = 0; k2 < n_; k2 += 1) {
        i_ = k2;
        int64_t t3 = (i_ + 1);
        for (int64_t k4 = 0; k4 < t3; k4 += 1) {
            j_ = k4;
            P_.p[(i_) * P_.s[0] + (j_) * P_.s[1]] = (P_.p[(i_) * P_.s[0] + (j_) * P_.s[1]] - ((gain_.p[(i_)] * gain_.p[(j_)]) * s_));
            P_.p[(j_) * P_.s[0] + (i_) * P_.s[1]] = P_.p[(i_) * P_.s[0] + (j_) * P_.s[1]];
        }
    }
    return s_;
}

/* estimation/innovation_filter.py:187 filtered */
GM_STATIC real innovation_filter_filtered(PackedDrive drive_, SampleSchedule schedule_, FilterInput data_, FilterStart start_, array1_f8 s_, array3_f8 room_, FilterTrace trace_)
{
    array1_f8 e_;
    array1_i8 places_;
    array1_f8 moves_;
    int64_t n_;
    int64_t last_;
    int64_t groups_;
    int64_t width_;
    int64_t form_;
    real result_;
    view2_f8 product_;
    int64_t pair_;
    int64_t steps_;
    int64_t g_;
    int64_t c_;
    int64_t i_;
    int64_t j_;
    int64_t k_;
    int64_t at_;
    int64_t q_;
    int64_t m_;
    int64_t base_;
    array2_f8 F_;
    real fade_;
    int64_t row_;
    int64_t channel_;
    int64_t reading_;
    real x_;
    real error_;
    real slope_;
    array1_f8 gain_;
    real variance_;
    real innovation_;
    e_ = drive_.e_;
    places_ = start_.places_;
    moves_ = start_.moves_;
    int64_t t1 = (data_.begin_.n[0] - 1);
    int64_t t2 = (room_.n[0] - 1);
    n_ = places_.n[0];
    last_ = t1;
    groups_ = t2;
    width_ = gm_div(16, groups_);
    int64_t t3 = batch_step_form(drive_);
    form_ = t3;
    result_ = (real)0.0;
    int64_t t4 = gm_bound(n_, room_.n[1]);
    int64_t t5 = gm_bound(n_, room_.n[2]);
    product_ = (view2_f8){room_.p + gm_at(groups_, room_.n[0]) * (room_.n[1] * room_.n[2]), {t4, t5}, {room_.n[2], 1}};
    int64_t t6 = (last_ + 1);
    for (int64_t k7 = 0; groups_ > 0 ? k7 < t6 : k7 > t6; k7 += groups_) {
        pair_ = k7;
        steps_ = 0;
        for (int64_t k8 = 0; k8 < groups_; k8 += 1) {
            g_ = k8;
            c_ = gm_min_i((pair_ + g_), last_);
            steps_ = gm_max_i(steps_, ((data_.end_.p[gm_at(c_, data_.end_.n[0])] - data_.begin_.p[gm_at(c_, data_.begin_.n[0])]) - 1));
            for (int64_t k9 = 0; k9 < 13; k9 += 1) {
                i_ = k9;
                room_.p[(((g_) * room_.n[1] + gm_at((n_ + i_), room_.n[1])) * room_.n[2] + 0)] = start_.states_.p[(gm_at(c_, start_.states_.n[0]) * start_.states_.n[1] + gm_at(i_, start_.states_.n[1]))];
            }
            for (int64_t k10 = 0; k10 < n_; k10 += 1) {
                i_ = k10;
                for (int64_t k11 = 0; k11 < n_; k11 += 1) {
                    j_ = k11;
                    room_.p[(((g_) * room_.n[1] + gm_at(i_, room_.n[1])) * room_.n[2] + (j_))] = start_.covariance_.p[(gm_at(i_, start_.covariance_.n[0]) * start_.covariance_.n[1] + (j_))];
                }
            }
        }
        int64_t t12 = (steps_ + 1);
        for (int64_t k13 = 0; k13 < t12; k13 += 1) {
            k_ = k13;
            for (int64_t k14 = 0; k14 < groups_; k14 += 1) {
                g_ = k14;
                c_ = gm_min_i((pair_ + g_), last_);
                at_ = gm_min_i((data_.begin_.p[gm_at(c_, data_.begin_.n[0])] + k_), (data_.end_.p[gm_at(c_, data_.end_.n[0])] - 1));
                if (((((data_.begin_.p[gm_at(c_, data_.begin_.n[0])] + k_) < data_.end_.p[gm_at(c_, data_.end_.n[0])])) && (((pair_ + g_) <= last_)))) {
                    for (int64_t k15 = 0; k15 < 13; k15 += 1) {
                        i_ = k15;
                        trace_.begin_.p[((gm_at(at_, trace_.begin_.n[0]) * trace_.begin_.n[1] + 0) * trace_.begin_.n[2] + gm_at(i_, trace_.begin_.n[2]))] = room_.p[(((g_) * room_.n[1] + gm_at((n_ + i_), room_.n[1])) * room_.n[2] + 0)];
                    }
                    for (int64_t k16 = 0; k16 < n_; k16 += 1) {
                        i_ = k16;
                        for (int64_t k17 = 0; k17 < n_; k17 += 1) {
                            j_ = k17;
                            trace_.covariance_.p[((gm_at(at_, trace_.covariance_.n[0]) * trace_.covariance_.n[1] + gm_at(i_, trace_.covariance_.n[1])) * trace_.covariance_.n[2] + (j_))] = room_.p[(((g_) * room_.n[1] + gm_at(i_, room_.n[1])) * room_.n[2] + (j_))];
                        }
                    }
                }
                int64_t t18 = (width_ * g_);
                int64_t t19 = (width_ * (g_ + 1));
                for (int64_t k20 = t18; k20 < t19; k20 += 1) {
                    i_ = k20;
                    s_.p[gm_at((192 + i_), s_.n[0])] = ((real)(at_) * data_.dt_);
                    for (int64_t k21 = 0; k21 < 3; k21 += 1) {
                        j_ = k21;
                        s_.p[gm_at(((224 + (16 * j_)) + i_), s_.n[0])] = data_.extra_.p[(gm_at(at_, data_.extra_.n[0]) * data_.extra_.n[1] + (j_))];
                    }
                }
                innovation_filter_spread(g_, width_, room_, start_, s_);
            }
            if (((k_ == steps_))) {
                break;
            }
            for (int64_t k22 = 0; k22 < schedule_.length_.n[0]; k22 += 1) {
                q_ = k22;
                for (int64_t k23 = 0; k23 < groups_; k23 += 1) {
                    g_ = k23;
                    c_ = gm_min_i((pair_ + g_), last_);
                    at_ = gm_min_i((data_.begin_.p[gm_at(c_, data_.begin_.n[0])] + k_), (data_.end_.p[gm_at(c_, data_.end_.n[0])] - 1));
                    int64_t t24 = (width_ * g_);
                    int64_t t25 = (width_ * (g_ + 1));
                    for (int64_t k26 = t24; k26 < t25; k26 += 1) {
                        i_ = k26;
                        s_.p[gm_at((208 + i_), s_.n[0])] = data_.u_.p[(gm_at(at_, data_.u_.n[0]) * data_.u_.n[1] + gm_at(schedule_.part_.p[(q_)], data_.u_.n[1]))];
                    }
                }
                batch_step_lanes(s_, schedule_.length_.p[(q_)], form_, drive_);
                m_ = schedule_.ends_.p[(q_)];
                if (((m_ < 0))) {
                    continue;
                }
                for (int64_t k27 = 0; k27 < groups_; k27 += 1) {
                    g_ = k27;
                    c_ = gm_min_i((pair_ + g_), last_);
                    at_ = (data_.begin_.p[gm_at(c_, data_.begin_.n[0])] + k_);
                    if ((((at_ >= (data_.end_.p[gm_at(c_, data_.end_.n[0])] - 1))) || (((pair_ + g_) > last_)))) {
                        continue;
                    }
                    base_ = (width_ * g_);
                    F_ = (array2_f8){trace_.tangent_.p + gm_at(at_, trace_.tangent_.n[0]) * (trace_.tangent_.n[1] * trace_.tangent_.n[2] * trace_.tangent_.n[3]) + gm_at(m_, trace_.tangent_.n[1]) * (trace_.tangent_.n[2] * trace_.tangent_.n[3]), {trace_.tangent_.n[2], trace_.tangent_.n[3]}};
                    for (int64_t k28 = 0; k28 < n_; k28 += 1) {
                        i_ = k28;
                        if (((places_.p[gm_at(i_, places_.n[0])] == 12))) {
                            fade_ = gm_pow(data_.fade_, (schedule_.span_.p[gm_at(m_, schedule_.span_.n[0])] / data_.dt_));
                            for (int64_t k29 = 0; k29 < n_; k29 += 1) {
                                j_ = k29;
                                F_.p[(gm_at(i_, F_.n[0]) * F_.n[1] + (j_))] = (((i_ == j_)) ? fade_ : (real)0.0);
                            }
                            room_.p[(((g_) * room_.n[1] + ((n_ + 12))) * room_.n[2] + 0)] = (room_.p[(((g_) * room_.n[1] + ((n_ + 12))) * room_.n[2] + 0)] * fade_);
                            trace_.end_.p[((gm_at(at_, trace_.end_.n[0]) * trace_.end_.n[1] + gm_at(m_, trace_.end_.n[1])) * trace_.end_.n[2] + gm_at(i_, trace_.end_.n[2]))] = room_.p[(((g_) * room_.n[1] + ((n_ + 12))) * room_.n[2] + 0)];
                            continue;
                        }
                        row_ = ((16 * places_.p[gm_at(i_, places_.n[0])]) + base_);
                        for (int64_t k30 = 0; k30 < n_; k30 += 1) {
                            j_ = k30;
                            F_.p[(gm_at(i_, F_.n[0]) * F_.n[1] + (j_))] = ((s_.p[gm_at(((row_ + 1) + j_), s_.n[0])] - s_.p[gm_at(row_, s_.n[0])]) / moves_.p[(j_)]);
                        }
                        trace_.end_.p[((gm_at(at_, trace_.end_.n[0]) * trace_.end_.n[1] + gm_at(m_, trace_.end_.n[1])) * trace_.end_.n[2] + gm_at(i_, trace_.end_.n[2]))] = s_.p[gm_at(row_, s_.n[0])];
                    }
                    for (int64_t k31 = 0; k31 < 12; k31 += 1) {
                        i_ = k31;
                        room_.p[(((g_) * room_.n[1] + gm_at((n_ + i_), room_.n[1])) * room_.n[2] + 0)] = s_.p[gm_at(((16 * i_) + base_), s_.n[0])];
                    }
                    if (((!((gm_fabs(s_.p[gm_at(base_, s_.n[0])]) < (real)1000000.0))) || (!((gm_fabs(s_.p[gm_at((16 + base_), s_.n[0])]) < (real)1000000.0))))) {
                        return INFINITY;
                    }
                    int64_t t32 = gm_bound(n_, room_.n[1]);
                    int64_t t33 = gm_bound(n_, room_.n[2]);
                    innovation_filter_predict(F_, (view2_f8){room_.p + (g_) * (room_.n[1] * room_.n[2]), {t32, t33}, {room_.n[2], 1}}, product_, schedule_.span_.p[gm_at(m_, schedule_.span_.n[0])], data_, drive_);
                    for (int64_t k34 = 0; k34 < 2; k34 += 1) {
                        channel_ = k34;
                        reading_ = ((at_ + 1) + schedule_.shift_.p[(channel_)]);
                        if (((((schedule_.reads_.p[(gm_at(m_, schedule_.reads_.n[0]) * schedule_.reads_.n[1] + (channel_))] == 0)) || ((reading_ >= data_.end_.p[gm_at(c_, data_.end_.n[0])]))) || ((gm_mod(reading_, data_.every_) != 0)))) {
                            continue;
                        }
                        x_ = room_.p[(((g_) * room_.n[1] + ((n_ + channel_))) * room_.n[2] + 0)];
                        tuple_15 t35 = innovation_filter_error(channel_, e_, x_);
                        error_ = t35.v[0];
                        slope_ = t35.v[1];
                        slope_ = (slope_ + (real)1.0);
                        trace_.position_.p[(gm_at(at_, trace_.position_.n[0]) * trace_.position_.n[1] + (channel_))] = x_;
                        trace_.speed_.p[(gm_at(at_, trace_.speed_.n[0]) * trace_.speed_.n[1] + (channel_))] = room_.p[(((g_) * room_.n[1] + (((n_ + 2) + channel_))) * room_.n[2] + 0)];
                        trace_.slope_.p[(gm_at(at_, trace_.slope_.n[0]) * trace_.slope_.n[1] + (channel_))] = slope_;
                        gain_ = (array1_f8){trace_.gain_.p + gm_at(at_, trace_.gain_.n[0]) * (trace_.gain_.n[1] * trace_.gain_.n[2]) + (channel_) * (trace_.gain_.n[2]), {trace_.gain_.n[2]}};
                        int64_t t36 = gm_bound(n_, room_.n[1]);
                        int64_t t37 = gm_bound(n_, room_.n[2]);
                        real t38 = innovation_filter_correct((view2_f8){room_.p + (g_) * (room_.n[1] * room_.n[2]), {t36, t37}, {room_.n[2], 1}}, channel_, slope_, data_.variance_.p[(channel_)], gain_);
                        variance_ = t38;
                        innovation_ = ((data_.y_.p[(gm_at(reading_, data_.y_.n[0]) * data_.y_.n[1] + (channel_))] - x_) - error_);
                        for (int64_t k39 = 0; k39 < n_; k39 += 1) {
                            i_ = k39;
                            room_.p[(((g_) * room_.n[1] + gm_at((n_ + places_.p[gm_at(i_, places_.n[0])]), room_.n[1])) * room_.n[2] + 0)] = (room_.p[(((g_) * room_.n[1] + gm_at((n_ + places_.p[gm_at(i_, places_.n[0])]), room_.n[1])) * room_.n[2] + 0)] + (gain_.p[gm_at(i_, gain_.n[0])] * innovation_));
                        }
                        trace_.innovation_.p[(gm_at(at_, trace_.innovation_.n[0]) * trace_.innovation_.n[1] + (channel_))] = innovation_;
                        trace_.variance_.p[(gm_at(at_, trace_.variance_.n[0]) * trace_.variance_.n[1] + (channel_))] = variance_;
                        result_ = (result_ + ((((innovation_ * innovation_) / variance_) - (real)1.0) + gm_log((variance_ / data_.variance_.p[(channel_)]))));
                    }
                    if (((m_ < (schedule_.span_.n[0] - 1)))) {
                        for (int64_t k40 = 0; k40 < 13; k40 += 1) {
                            i_ = k40;
                            trace_.begin_.p[((gm_at(at_, trace_.begin_.n[0]) * trace_.begin_.n[1] + gm_at((m_ + 1), trace_.begin_.n[1])) * trace_.begin_.n[2] + gm_at(i_, trace_.begin_.n[2]))] = room_.p[(((g_) * room_.n[1] + gm_at((n_ + i_), room_.n[1])) * room_.n[2] + 0)];
                        }
                        innovation_filter_spread(g_, width_, room_, start_, s_);
                    }
                }
            }
        }
    }
    return ((bool)isfinite(result_) ? result_ : INFINITY);
}

/* estimation/innovation_filter.py:362 _carry */
GM_INLINE void innovation_filter_carry(array2_f8 F_, array1_f8 d_, array1_f8 moved_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    n_ = F_.n[0];
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            j_ = k2;
            moved_.p[(i_)] = (moved_.p[(i_)] + (F_.p[((i_) * F_.n[1] + (j_))] * d_.p[(j_)]));
        }
    }
    for (int64_t k3 = 0; k3 < n_; k3 += 1) {
        i_ = k3;
        d_.p[(i_)] = moved_.p[(i_)];
    }
    return;
}

/* estimation/innovation_filter.py:373 _along */
GM_STATIC void innovation_filter_along(tuple_42 drives_, SampleSchedule schedule_, FilterInput data_, FilterTrace trace_, array3_f8 ends_, array1_f8 room_, array2_f8 change_)
{
    int64_t n_;
    array1_f8 d_;
    array1_f8 moved_;
    tuple_7 delays_;
    int64_t c_;
    int64_t i_;
    int64_t at_;
    int64_t m_;
    int64_t channel_;
    real slope_;
    real x_;
    real reading_;
    n_ = ends_.n[2];
    int64_t t1 = gm_bound(n_, room_.n[0]);
    int64_t t2 = gm_bound(n_, room_.n[0]);
    int64_t t3 = gm_span(t2, room_.n[0]);
    d_ = (array1_f8){room_.p, {t1}};
    moved_ = (array1_f8){room_.p + t2 * (1), {t3}};
    delays_ = (tuple_7){{(drives_.v[1].e_.p[35] - drives_.v[0].e_.p[35]), (drives_.v[1].e_.p[39] - drives_.v[0].e_.p[39])}};
    for (int64_t k4 = 0; k4 < data_.begin_.n[0]; k4 += 1) {
        c_ = k4;
        for (int64_t k5 = 0; k5 < n_; k5 += 1) {
            i_ = k5;
            d_.p[(i_)] = (real)0.0;
        }
        int64_t t6 = data_.begin_.p[(c_)];
        int64_t t7 = (data_.end_.p[(c_)] - 1);
        for (int64_t k8 = t6; k8 < t7; k8 += 1) {
            at_ = k8;
            for (int64_t k9 = 0; k9 < schedule_.span_.n[0]; k9 += 1) {
                m_ = k9;
                for (int64_t k10 = 0; k10 < n_; k10 += 1) {
                    i_ = k10;
                    moved_.p[(i_)] = ends_.p[((gm_at(at_, ends_.n[0]) * ends_.n[1] + (m_)) * ends_.n[2] + (i_))];
                }
                innovation_filter_carry((array2_f8){trace_.tangent_.p + gm_at(at_, trace_.tangent_.n[0]) * (trace_.tangent_.n[1] * trace_.tangent_.n[2] * trace_.tangent_.n[3]) + (m_) * (trace_.tangent_.n[2] * trace_.tangent_.n[3]), {trace_.tangent_.n[2], trace_.tangent_.n[3]}}, d_, moved_);
                for (int64_t k11 = 0; k11 < 2; k11 += 1) {
                    channel_ = k11;
                    if (((schedule_.reads_.p[((m_) * schedule_.reads_.n[1] + (channel_))] == 0))) {
                        continue;
                    }
                    slope_ = trace_.slope_.p[(gm_at(at_, trace_.slope_.n[0]) * trace_.slope_.n[1] + (channel_))];
                    if (((slope_ == (real)0.0))) {
                        continue;
                    }
                    x_ = trace_.position_.p[(gm_at(at_, trace_.position_.n[0]) * trace_.position_.n[1] + (channel_))];
                    tuple_15 t12 = innovation_filter_error(channel_, drives_.v[1].e_, x_);
                    tuple_15 t13 = innovation_filter_error(channel_, drives_.v[0].e_, x_);
                    reading_ = ((t12.v[0] - t13.v[0]) + (slope_ * (d_.p[(channel_)] - (delays_.v[(channel_)] * trace_.speed_.p[(gm_at(at_, trace_.speed_.n[0]) * trace_.speed_.n[1] + (channel_))]))));
                    change_.p[(gm_at(at_, change_.n[0]) * change_.n[1] + (channel_))] = (-reading_);
                    for (int64_t k14 = 0; k14 < n_; k14 += 1) {
                        i_ = k14;
                        d_.p[(i_)] = (d_.p[(i_)] - (trace_.gain_.p[((gm_at(at_, trace_.gain_.n[0]) * trace_.gain_.n[1] + (channel_)) * trace_.gain_.n[2] + (i_))] * reading_));
                    }
                }
            }
        }
    }
    return;
}

/* estimation/innovation_filter.py:316 sensitivity */
GM_STATIC void innovation_filter_sensitivity(tuple_42 drives_, SampleSchedule schedule_, FilterInput data_, array1_i8 places_, array1_f8 s_, FilterTrace trace_, array3_f8 ends_, array2_f8 change_)
{
    PackedDrive drive_;
    int64_t n_;
    int64_t form_;
    int64_t c_;
    int64_t first_;
    real elapsed_;
    int64_t m_;
    int64_t q_;
    int64_t i_;
    int64_t at_;
    int64_t j_;
    drive_ = drives_.v[1];
    n_ = places_.n[0];
    int64_t t1 = batch_step_form(drive_);
    form_ = t1;
    for (int64_t k2 = 0; k2 < data_.begin_.n[0]; k2 += 1) {
        c_ = k2;
        int64_t t3 = data_.begin_.p[(c_)];
        int64_t t4 = (data_.end_.p[(c_)] - 1);
        for (int64_t k5 = t3; k5 < t4; k5 += 16) {
            first_ = k5;
            elapsed_ = (real)0.0;
            m_ = (-1);
            for (int64_t k6 = 0; k6 < schedule_.length_.n[0]; k6 += 1) {
                q_ = k6;
                if ((((q_ == 0)) || ((schedule_.ends_.p[gm_at((q_ - 1), schedule_.ends_.n[0])] >= 0)))) {
                    m_ = (m_ + 1);
                    for (int64_t k7 = 0; k7 < 16; k7 += 1) {
                        i_ = k7;
                        at_ = gm_min_i((first_ + i_), (data_.end_.p[(c_)] - 2));
                        for (int64_t k8 = 0; k8 < 12; k8 += 1) {
                            j_ = k8;
                            s_.p[(((16 * j_) + i_))] = trace_.begin_.p[((gm_at(at_, trace_.begin_.n[0]) * trace_.begin_.n[1] + gm_at(m_, trace_.begin_.n[1])) * trace_.begin_.n[2] + (j_))];
                        }
                        s_.p[((192 + i_))] = (((real)(at_) * data_.dt_) + elapsed_);
                        for (int64_t k9 = 0; k9 < 3; k9 += 1) {
                            j_ = k9;
                            s_.p[(((224 + (16 * j_)) + i_))] = data_.extra_.p[(gm_at(at_, data_.extra_.n[0]) * data_.extra_.n[1] + (j_))];
                        }
                        s_.p[((224 + i_))] = trace_.begin_.p[((gm_at(at_, trace_.begin_.n[0]) * trace_.begin_.n[1] + gm_at(m_, trace_.begin_.n[1])) * trace_.begin_.n[2] + 12)];
                    }
                }
                for (int64_t k10 = 0; k10 < 16; k10 += 1) {
                    i_ = k10;
                    s_.p[((208 + i_))] = data_.u_.p[(gm_at(gm_min_i((first_ + i_), (data_.end_.p[(c_)] - 2)), data_.u_.n[0]) * data_.u_.n[1] + gm_at(schedule_.part_.p[(q_)], data_.u_.n[1]))];
                }
                batch_step_lanes(s_, schedule_.length_.p[(q_)], form_, drive_);
                elapsed_ = (elapsed_ + schedule_.length_.p[(q_)]);
                if (((schedule_.ends_.p[(q_)] >= 0))) {
                    int64_t t11 = gm_min_i(16, ((data_.end_.p[(c_)] - 1) - first_));
                    for (int64_t k12 = 0; k12 < t11; k12 += 1) {
                        i_ = k12;
                        for (int64_t k13 = 0; k13 < n_; k13 += 1) {
                            j_ = k13;
                            ends_.p[((gm_at((first_ + i_), ends_.n[0]) * ends_.n[1] + gm_at(m_, ends_.n[1])) * ends_.n[2] + (j_))] = (((places_.p[(j_)] == 12)) ? (real)0.0 : (s_.p[gm_at(((16 * places_.p[(j_)]) + i_), s_.n[0])] - trace_.end_.p[((gm_at((first_ + i_), trace_.end_.n[0]) * trace_.end_.n[1] + gm_at(m_, trace_.end_.n[1])) * trace_.end_.n[2] + (j_))]));
                        }
                    }
                }
            }
        }
    }
    int64_t t14 = (2 * n_);
    int64_t t15 = gm_bound(t14, s_.n[0]);
    innovation_filter_along(drives_, schedule_, data_, trace_, ends_, (array1_f8){s_.p, {t15}}, change_);
    return;
}

/* estimation/innovation_filter.py:455 smoothed */
GM_STATIC void innovation_filter_smoothed(SampleSchedule schedule_, FilterInput data_, array1_i8 places_, FilterTrace trace_, array1_f8 room_, array2_f8 states_)
{
    int64_t n_;
    array1_f8 adjoint_;
    array1_f8 moved_;
    int64_t c_;
    int64_t i_;
    int64_t at_;
    int64_t m_;
    int64_t channel_;
    real slope_;
    real total_;
    int64_t j_;
    n_ = places_.n[0];
    int64_t t1 = gm_bound(n_, room_.n[0]);
    int64_t t2 = (2 * n_);
    int64_t t3 = gm_bound(n_, room_.n[0]);
    int64_t t4 = gm_bound(t2, room_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    adjoint_ = (array1_f8){room_.p, {t1}};
    moved_ = (array1_f8){room_.p + t3 * (1), {t5}};
    for (int64_t k6 = 0; k6 < data_.begin_.n[0]; k6 += 1) {
        c_ = k6;
        for (int64_t k7 = 0; k7 < n_; k7 += 1) {
            i_ = k7;
            adjoint_.p[(i_)] = (real)0.0;
        }
        int64_t t8 = (data_.end_.p[(c_)] - 1);
        int64_t t9 = (data_.begin_.p[(c_)] - 1);
        for (int64_t k10 = t8; k10 > t9; k10 += -1) {
            at_ = k10;
            if (((at_ < (data_.end_.p[(c_)] - 1)))) {
                int64_t t11 = (schedule_.span_.n[0] - 1);
                for (int64_t k12 = t11; k12 > (-1); k12 += -1) {
                    m_ = k12;
                    for (int64_t k13 = 1; k13 > (-1); k13 += -1) {
                        channel_ = k13;
                        slope_ = trace_.slope_.p[(gm_at(at_, trace_.slope_.n[0]) * trace_.slope_.n[1] + (channel_))];
                        if ((((schedule_.reads_.p[((m_) * schedule_.reads_.n[1] + (channel_))] == 0)) || ((slope_ == (real)0.0)))) {
                            continue;
                        }
                        total_ = (trace_.innovation_.p[(gm_at(at_, trace_.innovation_.n[0]) * trace_.innovation_.n[1] + (channel_))] / trace_.variance_.p[(gm_at(at_, trace_.variance_.n[0]) * trace_.variance_.n[1] + (channel_))]);
                        for (int64_t k14 = 0; k14 < n_; k14 += 1) {
                            i_ = k14;
                            total_ = (total_ - (trace_.gain_.p[((gm_at(at_, trace_.gain_.n[0]) * trace_.gain_.n[1] + (channel_)) * trace_.gain_.n[2] + (i_))] * adjoint_.p[(i_)]));
                        }
                        adjoint_.p[(channel_)] = (adjoint_.p[(channel_)] + (slope_ * total_));
                    }
                    for (int64_t k15 = 0; k15 < n_; k15 += 1) {
                        j_ = k15;
                        total_ = (real)0.0;
                        for (int64_t k16 = 0; k16 < n_; k16 += 1) {
                            i_ = k16;
                            total_ = (total_ + (trace_.tangent_.p[(((gm_at(at_, trace_.tangent_.n[0]) * trace_.tangent_.n[1] + (m_)) * trace_.tangent_.n[2] + (i_)) * trace_.tangent_.n[3] + (j_))] * adjoint_.p[(i_)]));
                        }
                        moved_.p[(j_)] = total_;
                    }
                    for (int64_t k17 = 0; k17 < n_; k17 += 1) {
                        j_ = k17;
                        adjoint_.p[(j_)] = moved_.p[(j_)];
                    }
                }
            }
            for (int64_t k18 = 0; k18 < 13; k18 += 1) {
                i_ = k18;
                states_.p[(gm_at(at_, states_.n[0]) * states_.n[1] + (i_))] = trace_.begin_.p[((gm_at(at_, trace_.begin_.n[0]) * trace_.begin_.n[1] + 0) * trace_.begin_.n[2] + (i_))];
            }
            for (int64_t k19 = 0; k19 < n_; k19 += 1) {
                i_ = k19;
                for (int64_t k20 = 0; k20 < n_; k20 += 1) {
                    j_ = k20;
                    states_.p[(gm_at(at_, states_.n[0]) * states_.n[1] + gm_at(places_.p[(i_)], states_.n[1]))] = (states_.p[(gm_at(at_, states_.n[0]) * states_.n[1] + gm_at(places_.p[(i_)], states_.n[1]))] + (trace_.covariance_.p[((gm_at(at_, trace_.covariance_.n[0]) * trace_.covariance_.n[1] + (i_)) * trace_.covariance_.n[2] + (j_))] * adjoint_.p[(j_)]));
                }
            }
        }
    }
    return;
}

/* estimation/innovation_filter.py:139 _predict */
GM_INLINE void innovation_filter_predict_2(array2_f8 F_, array2_f8 P_, array2_f8 product_, real span_, FilterInput data_, PackedDrive drive_)
{
    int64_t n_;
    int64_t i_;
    int64_t j_;
    real total_;
    int64_t k_;
    bool rigid_;
    int64_t first_;
    real v_;
    n_ = F_.n[0];
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            j_ = k2;
            total_ = (real)0.0;
            for (int64_t k3 = 0; k3 < n_; k3 += 1) {
                k_ = k3;
                total_ = (total_ + (F_.p[((i_) * F_.n[1] + (k_))] * P_.p[((k_) * P_.n[1] + (j_))]));
            }
            product_.p[((i_) * product_.n[1] + (j_))] = total_;
        }
    }
    for (int64_t k4 = 0; k4 < n_; k4 += 1) {
        i_ = k4;
        int64_t t5 = (i_ + 1);
        for (int64_t k6 = 0; k6 < t5; k6 += 1) {
            j_ = k6;
            total_ = (real)0.0;
            for (int64_t k7 = 0; k7 < n_; k7 += 1) {
                k_ = k7;
                total_ = (total_ + (product_.p[((i_) * product_.n[1] + (k_))] * F_.p[((j_) * F_.n[1] + (k_))]));
            }
            P_.p[((i_) * P_.n[1] + (j_))] = total_;
            P_.p[((j_) * P_.n[1] + (i_))] = total_;
        }
    }
    bool t8 = (((int64_t)(drive_.p_.p[8]) == 3));
    rigid_ = t8;
    first_ = 0;
    if (((data_.fade_ > (real)0.0))) {
        P_.p[(4 * P_.n[1] + 4)] = (P_.p[(4 * P_.n[1] + 4)] + ((data_.torque_.p[0] * data_.torque_.p[0]) * ((real)1.0 - gm_pow(data_.fade_, (((real)2.0 * span_) / data_.dt_)))));
        first_ = (rigid_ ? 2 : 1);
    }
    int64_t t9 = first_;
    for (int64_t k10 = t9; k10 < 2; k10 += 1) {
        i_ = k10;
        int64_t t11 = first_;
        for (int64_t k12 = t11; k12 < 2; k12 += 1) {
            j_ = k12;
            if ((((i_ == j_)) || rigid_)) {
                real t13 = innovation_filter_noise_of(i_, F_, data_.torque_, drive_.p_);
                real t14 = innovation_filter_noise_of(j_, F_, data_.torque_, drive_.p_);
                v_ = (((t13 * t14) * data_.dt_) * span_);
                P_.p[(((2 + i_)) * P_.n[1] + ((2 + j_)))] = (P_.p[(((2 + i_)) * P_.n[1] + ((2 + j_)))] + v_);
                P_.p[((i_) * P_.n[1] + ((2 + j_)))] = (P_.p[((i_) * P_.n[1] + ((2 + j_)))] + (((real)0.5 * v_) * span_));
                P_.p[(((2 + i_)) * P_.n[1] + (j_))] = (P_.p[(((2 + i_)) * P_.n[1] + (j_))] + (((real)0.5 * v_) * span_));
                P_.p[((i_) * P_.n[1] + (j_))] = (P_.p[((i_) * P_.n[1] + (j_))] + (((v_ * span_) * span_) / (real)3.0));
            }
        }
    }
    return;
}

/* estimation/innovation_filter.py:173 _correct */
GM_INLINE real innovation_filter_correct_2(array2_f8 P_, int64_t channel_, real slope_, real variance_, array1_f8 gain_)
{
    int64_t n_;
    real s_;
    int64_t i_;
    int64_t j_;
    n_ = P_.n[0];
    s_ = (variance_ + ((slope_ * slope_) * P_.p[((channel_) * P_.n[1] + (channel_))]));
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        gain_.p[(i_)] = ((P_.p[((i_) * P_.n[1] + (channel_))] * slope_) / s_);
    }
    for (int64_t k2 = 0; k2 < n_; k2 += 1) {
        i_ = k2;
        int64_t t3 = (i_ + 1);
        for (int64_t k4 = 0; k4 < t3; k4 += 1) {
            j_ = k4;
            P_.p[((i_) * P_.n[1] + (j_))] = (P_.p[((i_) * P_.n[1] + (j_))] - ((gain_.p[(i_)] * gain_.p[(j_)]) * s_));
            P_.p[((j_) * P_.n[1] + (i_))] = P_.p[((i_) * P_.n[1] + (j_))];
        }
    }
    return s_;
}

/* estimation/innovation_filter.py:404 with_noise */
GM_STATIC real innovation_filter_with_noise(PackedDrive drive_, SampleSchedule schedule_, FilterInput data_, FilterStart start_, FilterTrace trace_, array2_f8 room_, array2_f8 change_, array2_f8 variance_)
{
    int64_t n_;
    array2_f8 P_;
    array2_f8 product_;
    array1_f8 d_;
    array1_f8 moved_;
    array1_f8 gain_;
    real result_;
    int64_t c_;
    int64_t i_;
    int64_t j_;
    int64_t at_;
    int64_t m_;
    array2_f8 F_;
    int64_t channel_;
    real slope_;
    real v_;
    real old_;
    real new_;
    n_ = start_.places_.n[0];
    int64_t t1 = gm_bound(n_, room_.n[0]);
    int64_t t2 = (2 * n_);
    int64_t t3 = gm_bound(n_, room_.n[0]);
    int64_t t4 = gm_bound(t2, room_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    P_ = (array2_f8){room_.p, {t1, room_.n[1]}};
    product_ = (array2_f8){room_.p + t3 * (room_.n[1]), {t5, room_.n[1]}};
    d_ = (array1_f8){room_.p + ((2 * n_)) * (room_.n[1]), {room_.n[1]}};
    moved_ = (array1_f8){room_.p + (((2 * n_) + 1)) * (room_.n[1]), {room_.n[1]}};
    gain_ = (array1_f8){room_.p + (((2 * n_) + 2)) * (room_.n[1]), {room_.n[1]}};
    result_ = (real)0.0;
    for (int64_t k6 = 0; k6 < data_.begin_.n[0]; k6 += 1) {
        c_ = k6;
        for (int64_t k7 = 0; k7 < n_; k7 += 1) {
            i_ = k7;
            d_.p[(i_)] = (real)0.0;
            for (int64_t k8 = 0; k8 < n_; k8 += 1) {
                j_ = k8;
                P_.p[((i_) * P_.n[1] + (j_))] = start_.covariance_.p[((i_) * start_.covariance_.n[1] + (j_))];
            }
        }
        int64_t t9 = data_.begin_.p[(c_)];
        int64_t t10 = (data_.end_.p[(c_)] - 1);
        for (int64_t k11 = t9; k11 < t10; k11 += 1) {
            at_ = k11;
            for (int64_t k12 = 0; k12 < schedule_.span_.n[0]; k12 += 1) {
                m_ = k12;
                F_ = (array2_f8){trace_.tangent_.p + gm_at(at_, trace_.tangent_.n[0]) * (trace_.tangent_.n[1] * trace_.tangent_.n[2] * trace_.tangent_.n[3]) + (m_) * (trace_.tangent_.n[2] * trace_.tangent_.n[3]), {trace_.tangent_.n[2], trace_.tangent_.n[3]}};
                for (int64_t k13 = 0; k13 < n_; k13 += 1) {
                    i_ = k13;
                    moved_.p[(i_)] = (real)0.0;
                }
                innovation_filter_carry(F_, d_, moved_);
                innovation_filter_predict_2(F_, P_, product_, schedule_.span_.p[(m_)], data_, drive_);
                for (int64_t k14 = 0; k14 < 2; k14 += 1) {
                    channel_ = k14;
                    if (((schedule_.reads_.p[((m_) * schedule_.reads_.n[1] + (channel_))] == 0))) {
                        continue;
                    }
                    slope_ = trace_.slope_.p[(gm_at(at_, trace_.slope_.n[0]) * trace_.slope_.n[1] + (channel_))];
                    if (((slope_ == (real)0.0))) {
                        continue;
                    }
                    real t15 = innovation_filter_correct_2(P_, channel_, slope_, data_.variance_.p[(channel_)], gain_);
                    v_ = t15;
                    old_ = trace_.innovation_.p[(gm_at(at_, trace_.innovation_.n[0]) * trace_.innovation_.n[1] + (channel_))];
                    new_ = (old_ - (slope_ * d_.p[(channel_)]));
                    for (int64_t k16 = 0; k16 < n_; k16 += 1) {
                        i_ = k16;
                        d_.p[(i_)] = (d_.p[(i_)] + ((gain_.p[(i_)] * new_) - (trace_.gain_.p[((gm_at(at_, trace_.gain_.n[0]) * trace_.gain_.n[1] + (channel_)) * trace_.gain_.n[2] + (i_))] * old_)));
                    }
                    real t17 = (new_ - old_);
                    change_.p[(gm_at(at_, change_.n[0]) * change_.n[1] + (channel_))] = t17;
                    variance_.p[(gm_at(at_, variance_.n[0]) * variance_.n[1] + (channel_))] = v_;
                    result_ = (result_ + ((((new_ * new_) / v_) - (real)1.0) + gm_log((v_ / data_.variance_.p[(channel_)]))));
                }
            }
        }
    }
    return ((bool)isfinite(result_) ? result_ : INFINITY);
}

/* estimation/model_bank.py:151 _remember */
GM_INLINE void model_bank_remember(Mixture carried_, int64_t stamp_)
{
    int64_t place_;
    int64_t m_;
    place_ = gm_mod(carried_.places_.p[0], 8192);
    carried_.stamps_.p[(place_)] = stamp_;
    for (int64_t k1 = 0; k1 < 3; k1 += 1) {
        m_ = k1;
        carried_.history_.p[((place_) * carried_.history_.n[1] + (m_))] = carried_.weights_.p[(m_)];
    }
    carried_.places_.p[0] = (carried_.places_.p[0] + 1);
    return;
}

/* estimation/model_bank.py:160 begin */
GM_STATIC void model_bank_begin(Mixture carried_, int64_t stamp_)
{
    array1_i8 t1 = (array1_i8){carried_.places_.p, {carried_.places_.n[0]}};
    for (int64_t k2 = 0; k2 < t1.n[0]; k2++)
        t1.p[k2 * (1)] = 0;
    model_bank_remember(carried_, stamp_);
    return;
}

/* estimation/model_bank.py:182 _weigh */
GM_INLINE real model_bank_weigh(Mixture carried_, Outputs members_, int64_t k_)
{
    array1_f8 weights_;
    array1_f8 prior_;
    array3_f8 rows_;
    real stay_;
    real total_;
    real highest_;
    int64_t m_;
    real likelihood_;
    weights_ = carried_.weights_;
    prior_ = carried_.prior_;
    rows_ = members_.rows_;
    stay_ = gm_exp(((-rows_.p[((k_) * rows_.n[2] + 27)]) / (real)100.0));
    total_ = (real)0.0;
    highest_ = (-INFINITY);
    for (int64_t k1 = 0; k1 < 3; k1 += 1) {
        m_ = k1;
        prior_.p[(m_)] = (real)0.0;
        if (((members_.codes_.p[((m_) * members_.codes_.n[1] + (k_))] == 0))) {
            prior_.p[(m_)] = ((stay_ * weights_.p[(m_)]) + (((real)1.0 - stay_) / (real)3.0));
            total_ = (total_ + prior_.p[(m_)]);
            highest_ = gm_max_f(highest_, rows_.p[(((m_) * rows_.n[1] + (k_)) * rows_.n[2] + 25)]);
        }
    }
    likelihood_ = (real)0.0;
    for (int64_t k2 = 0; k2 < 3; k2 += 1) {
        m_ = k2;
        prior_.p[(m_)] = (prior_.p[(m_)] / total_);
        weights_.p[(m_)] = (((prior_.p[(m_)] > (real)0.0)) ? (prior_.p[(m_)] * gm_exp((rows_.p[(((m_) * rows_.n[1] + (k_)) * rows_.n[2] + 25)] - highest_))) : (real)0.0);
        likelihood_ = (likelihood_ + weights_.p[(m_)]);
    }
    for (int64_t k3 = 0; k3 < 3; k3 += 1) {
        m_ = k3;
        weights_.p[(m_)] = (weights_.p[(m_)] / likelihood_);
    }
    carried_.alone_.p[0] = (carried_.alone_.p[0] + ((weights_.p[0] - carried_.alone_.p[0]) * gm_min_f((rows_.p[((k_) * rows_.n[2] + 27)] / (real)3.0), (real)1.0)));
    return (highest_ + gm_log(likelihood_));
}

/* estimation/model_bank.py:167 _moments */
GM_INLINE tuple_7 model_bank_moments(array1_f8 weights_, view2_f8 rows_, int64_t mean_, int64_t std_)
{
    real first_;
    real total_;
    real square_;
    int64_t m_;
    real difference_;
    real deviation_;
    first_ = rows_.p[0 * rows_.s[0] + gm_at(mean_, rows_.n[1]) * rows_.s[1]];
    if ((!(bool)isfinite(first_))) {
        return (tuple_7){{NAN, NAN}};
    }
    total_ = (real)0.0;
    square_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 3; k1 += 1) {
        m_ = k1;
        if (((weights_.p[(m_)] > (real)0.0))) {
            real t2 = (rows_.p[(m_) * rows_.s[0] + gm_at(mean_, rows_.n[1]) * rows_.s[1]] - first_);
            real t3 = rows_.p[(m_) * rows_.s[0] + gm_at(std_, rows_.n[1]) * rows_.s[1]];
            difference_ = t2;
            deviation_ = t3;
            total_ = (total_ + (weights_.p[(m_)] * difference_));
            square_ = (square_ + (weights_.p[(m_)] * ((deviation_ * deviation_) + (difference_ * difference_))));
        }
    }
    return (tuple_7){{(first_ + total_), gm_sqrt(gm_max_f((square_ - (total_ * total_)), (real)0.0))}};
}

/* estimation/model_bank.py:167 _moments */
GM_INLINE tuple_7 model_bank_moments_2(array1_f8 weights_, view2_f8 rows_, int64_t mean_, int64_t std_)
{
    real first_;
    real total_;
    real square_;
    int64_t m_;
    real difference_;
    real deviation_;
    first_ = rows_.p[0 * rows_.s[0] + (mean_) * rows_.s[1]];
    if ((!(bool)isfinite(first_))) {
        return (tuple_7){{NAN, NAN}};
    }
    total_ = (real)0.0;
    square_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 3; k1 += 1) {
        m_ = k1;
        if (((weights_.p[(m_)] > (real)0.0))) {
            real t2 = (rows_.p[(m_) * rows_.s[0] + (mean_) * rows_.s[1]] - first_);
            real t3 = rows_.p[(m_) * rows_.s[0] + (std_) * rows_.s[1]];
            difference_ = t2;
            deviation_ = t3;
            total_ = (total_ + (weights_.p[(m_)] * difference_));
            square_ = (square_ + (weights_.p[(m_)] * ((deviation_ * deviation_) + (difference_ * difference_))));
        }
    }
    return (tuple_7){{(first_ + total_), gm_sqrt(gm_max_f((square_ - (total_ * total_)), (real)0.0))}};
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

/* estimation/model_bank.py:205 _mix_row */
GM_INLINE void model_bank_mix_row(Mixture carried_, view2_f8 rows_, array1_f8 row_)
{
    array1_f8 weights_;
    array1_f8 prior_;
    int64_t i_;
    int64_t mean_;
    int64_t std_;
    int64_t column_;
    real e1_;
    real s1_;
    real e2_;
    real s2_;
    bool both_;
    real s12_;
    int64_t m_;
    real white_;
    bool learned_;
    weights_ = carried_.weights_;
    prior_ = carried_.prior_;
    for (int64_t k1 = 0; k1 < 11; k1 += 1) {
        i_ = k1;
        int64_t t2 = (((int64_t *)constant))[((i_) * 2 + 0)];
        int64_t t3 = (((int64_t *)constant))[((i_) * 2 + 1)];
        mean_ = t2;
        std_ = t3;
        tuple_7 t4 = model_bank_moments(weights_, rows_, mean_, std_);
        row_.p[gm_at(mean_, row_.n[0])] = t4.v[0];
        row_.p[gm_at(std_, row_.n[0])] = t4.v[1];
    }
    {
        column_ = 26;
        row_.p[(column_)] = rows_.p[0 * rows_.s[0] + (column_) * rows_.s[1]];
    }
    {
        column_ = 27;
        row_.p[(column_)] = rows_.p[0 * rows_.s[0] + (column_) * rows_.s[1]];
    }
    {
        column_ = 28;
        row_.p[(column_)] = rows_.p[0 * rows_.s[0] + (column_) * rows_.s[1]];
    }
    {
        column_ = 29;
        row_.p[(column_)] = rows_.p[0 * rows_.s[0] + (column_) * rows_.s[1]];
    }
    {
        column_ = 38;
        row_.p[(column_)] = rows_.p[0 * rows_.s[0] + (column_) * rows_.s[1]];
    }
    tuple_7 t6 = model_bank_moments_2(prior_, rows_, 18, 20);
    e1_ = t6.v[0];
    s1_ = t6.v[1];
    tuple_7 t7 = model_bank_moments_2(prior_, rows_, 19, 21);
    e2_ = t7.v[0];
    s2_ = t7.v[1];
    both_ = ((bool)isfinite(e1_) && (bool)isfinite(e2_));
    s12_ = (real)0.0;
    for (int64_t k8 = 0; k8 < 3; k8 += 1) {
        m_ = k8;
        if (((prior_.p[(m_)] > (real)0.0))) {
            s12_ = (s12_ + (prior_.p[(m_)] * rows_.p[(m_) * rows_.s[0] + 30 * rows_.s[1]]));
            if (both_) {
                s12_ = (s12_ + ((prior_.p[(m_)] * (rows_.p[(m_) * rows_.s[0] + 18 * rows_.s[1]] - e1_)) * (rows_.p[(m_) * rows_.s[0] + 19 * rows_.s[1]] - e2_)));
            }
        }
    }
    sample_loop_write_innovation(row_, e1_, e2_, (s1_ * s1_), s12_, (s2_ * s2_));
    row_.p[24] = (real)0.0;
    real t9 = row_.p[22];
    real t10 = row_.p[23];
    {
        white_ = t9;
        if ((bool)isfinite(white_)) {
            row_.p[24] = (row_.p[24] + (white_ * white_));
        }
    }
    {
        white_ = t10;
        if ((bool)isfinite(white_)) {
            row_.p[24] = (row_.p[24] + (white_ * white_));
        }
    }
    learned_ = ((prior_.p[2] > (real)0.0));
    for (int64_t k12 = 31; k12 < 37; k12 += 1) {
        column_ = k12;
        row_.p[(column_)] = (learned_ ? rows_.p[2 * rows_.s[0] + (column_) * rows_.s[1]] : NAN);
    }
    real t13 = weights_.p[1];
    real t14 = weights_.p[2];
    row_.p[40] = t13;
    row_.p[41] = t14;
    return;
}

/* estimation/model_bank.py:269 mix */
GM_STATIC void model_bank_mix(Mixture carried_, Outputs members_, array1_i8 stamps_, Output output_)
{
    array1_f8 weights_;
    int64_t k_;
    int64_t code_;
    weights_ = carried_.weights_;
    for (int64_t k1 = 0; k1 < stamps_.n[0]; k1 += 1) {
        k_ = k1;
        code_ = members_.codes_.p[(k_)];
        output_.codes_.p[(k_)] = code_;
        if (((code_ == 1))) {
            array1_f8 t2 = (array1_f8){weights_.p, {weights_.n[0]}};
            for (int64_t k3 = 0; k3 < t2.n[0]; k3++)
                t2.p[k3 * (1)] = (real)0.3333333333333333;
            carried_.places_.p[2] = carried_.places_.p[0];
            model_bank_remember(carried_, stamps_.p[(k_)]);
        } else {
            if (((code_ == 0))) {
                real t4 = model_bank_weigh(carried_, members_, k_);
                output_.estimates_.p[((k_) * output_.estimates_.n[1] + 25)] = t4;
                model_bank_mix_row(carried_, (view2_f8){members_.rows_.p + (k_) * (members_.rows_.n[2]), {members_.rows_.n[0], members_.rows_.n[2]}, {members_.rows_.n[1] * members_.rows_.n[2], 1}}, (array1_f8){output_.estimates_.p + (k_) * (output_.estimates_.n[1]), {output_.estimates_.n[1]}});
                model_bank_remember(carried_, stamps_.p[(k_)]);
            }
        }
    }
    return;
}

/* estimation/model_bank.py:167 _moments */
GM_INLINE tuple_7 model_bank_moments_3(array1_f8 weights_, view2_f8 rows_, int64_t mean_, int64_t std_)
{
    real first_;
    real total_;
    real square_;
    int64_t m_;
    real difference_;
    real deviation_;
    first_ = rows_.p[0 * rows_.s[0] + gm_at(mean_, rows_.n[1]) * rows_.s[1]];
    if ((!(bool)isfinite(first_))) {
        return (tuple_7){{NAN, NAN}};
    }
    total_ = (real)0.0;
    square_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 3; k1 += 1) {
        m_ = k1;
        if (((weights_.p[(m_)] > (real)0.0))) {
            real t2 = (rows_.p[(m_) * rows_.s[0] + gm_at(mean_, rows_.n[1]) * rows_.s[1]] - first_);
            real t3 = rows_.p[(m_) * rows_.s[0] + (std_) * rows_.s[1]];
            difference_ = t2;
            deviation_ = t3;
            total_ = (total_ + (weights_.p[(m_)] * difference_));
            square_ = (square_ + (weights_.p[(m_)] * ((deviation_ * deviation_) + (difference_ * difference_))));
        }
    }
    return (tuple_7){{(first_ + total_), gm_sqrt(gm_max_f((square_ - (total_ * total_)), (real)0.0))}};
}

/* estimation/model_bank.py:250 mix_smoothed_row */
GM_STATIC void model_bank_mix_smoothed_row(array1_f8 weights_, view2_f8 rows_, array1_f8 row_)
{
    int64_t j_;
    int64_t mean_;
    int64_t std_;
    for (int64_t k1 = 0; k1 < 7; k1 += 1) {
        j_ = k1;
        int64_t t2 = (((int64_t *)constant_2))[((j_) * 2 + 0)];
        int64_t t3 = (((int64_t *)constant_2))[((j_) * 2 + 1)];
        mean_ = t2;
        std_ = t3;
        tuple_7 t4 = model_bank_moments(weights_, rows_, mean_, std_);
        row_.p[gm_at(mean_, row_.n[0])] = t4.v[0];
        row_.p[gm_at(std_, row_.n[0])] = t4.v[1];
    }
    {
        mean_ = 6;
        tuple_7 t6 = model_bank_moments_3(weights_, rows_, mean_, 3);
        row_.p[gm_at(mean_, row_.n[0])] = t6.v[0];
    }
    {
        mean_ = 7;
        tuple_7 t7 = model_bank_moments_3(weights_, rows_, mean_, 3);
        row_.p[gm_at(mean_, row_.n[0])] = t7.v[0];
    }
    {
        mean_ = 8;
        tuple_7 t8 = model_bank_moments_3(weights_, rows_, mean_, 3);
        row_.p[gm_at(mean_, row_.n[0])] = t8.v[0];
    }
    row_.p[9] = rows_.p[0 * rows_.s[0] + 9 * rows_.s[1]];
    return;
}

/* estimation/model_bank.py:235 mix_interval */
GM_STATIC void model_bank_mix_interval(array2_f8 weights_, array3_f8 rows_, array2_f8 out_)
{
    int64_t i_;
    for (int64_t k1 = 0; k1 < weights_.n[0]; k1 += 1) {
        i_ = k1;
        model_bank_mix_smoothed_row((array1_f8){weights_.p + (i_) * (weights_.n[1]), {weights_.n[1]}}, (view2_f8){rows_.p + (i_) * (rows_.n[2]), {rows_.n[0], rows_.n[2]}, {rows_.n[1] * rows_.n[2], 1}}, (array1_f8){out_.p + (i_) * (out_.n[1]), {out_.n[1]}});
    }
    return;
}

/* estimation/model_bank.py:167 _moments */
GM_INLINE tuple_7 model_bank_moments_4(array1_f8 weights_, array2_f8 rows_, int64_t mean_, int64_t std_)
{
    real first_;
    real total_;
    real square_;
    int64_t m_;
    real difference_;
    real deviation_;
    first_ = rows_.p[gm_at(mean_, rows_.n[1])];
    if ((!(bool)isfinite(first_))) {
        return (tuple_7){{NAN, NAN}};
    }
    total_ = (real)0.0;
    square_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 3; k1 += 1) {
        m_ = k1;
        if (((weights_.p[(m_)] > (real)0.0))) {
            real t2 = (rows_.p[((m_) * rows_.n[1] + gm_at(mean_, rows_.n[1]))] - first_);
            real t3 = rows_.p[((m_) * rows_.n[1] + gm_at(std_, rows_.n[1]))];
            difference_ = t2;
            deviation_ = t3;
            total_ = (total_ + (weights_.p[(m_)] * difference_));
            square_ = (square_ + (weights_.p[(m_)] * ((deviation_ * deviation_) + (difference_ * difference_))));
        }
    }
    return (tuple_7){{(first_ + total_), gm_sqrt(gm_max_f((square_ - (total_ * total_)), (real)0.0))}};
}

/* estimation/model_bank.py:167 _moments */
GM_INLINE tuple_7 model_bank_moments_5(array1_f8 weights_, array2_f8 rows_, int64_t mean_, int64_t std_)
{
    real first_;
    real total_;
    real square_;
    int64_t m_;
    real difference_;
    real deviation_;
    first_ = rows_.p[gm_at(mean_, rows_.n[1])];
    if ((!(bool)isfinite(first_))) {
        return (tuple_7){{NAN, NAN}};
    }
    total_ = (real)0.0;
    square_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 3; k1 += 1) {
        m_ = k1;
        if (((weights_.p[(m_)] > (real)0.0))) {
            real t2 = (rows_.p[((m_) * rows_.n[1] + gm_at(mean_, rows_.n[1]))] - first_);
            real t3 = rows_.p[((m_) * rows_.n[1] + (std_))];
            difference_ = t2;
            deviation_ = t3;
            total_ = (total_ + (weights_.p[(m_)] * difference_));
            square_ = (square_ + (weights_.p[(m_)] * ((deviation_ * deviation_) + (difference_ * difference_))));
        }
    }
    return (tuple_7){{(first_ + total_), gm_sqrt(gm_max_f((square_ - (total_ * total_)), (real)0.0))}};
}

/* estimation/model_bank.py:250 mix_smoothed_row */
GM_STATIC void model_bank_mix_smoothed_row_2(array1_f8 weights_, array2_f8 rows_, array1_f8 row_)
{
    int64_t j_;
    int64_t mean_;
    int64_t std_;
    for (int64_t k1 = 0; k1 < 7; k1 += 1) {
        j_ = k1;
        int64_t t2 = (((int64_t *)constant_2))[((j_) * 2 + 0)];
        int64_t t3 = (((int64_t *)constant_2))[((j_) * 2 + 1)];
        mean_ = t2;
        std_ = t3;
        tuple_7 t4 = model_bank_moments_4(weights_, rows_, mean_, std_);
        row_.p[gm_at(mean_, row_.n[0])] = t4.v[0];
        row_.p[gm_at(std_, row_.n[0])] = t4.v[1];
    }
    {
        mean_ = 6;
        tuple_7 t6 = model_bank_moments_5(weights_, rows_, mean_, 3);
        row_.p[gm_at(mean_, row_.n[0])] = t6.v[0];
    }
    {
        mean_ = 7;
        tuple_7 t7 = model_bank_moments_5(weights_, rows_, mean_, 3);
        row_.p[gm_at(mean_, row_.n[0])] = t7.v[0];
    }
    {
        mean_ = 8;
        tuple_7 t8 = model_bank_moments_5(weights_, rows_, mean_, 3);
        row_.p[gm_at(mean_, row_.n[0])] = t8.v[0];
    }
    row_.p[9] = rows_.p[9];
    return;
}

/* estimation/model_bank.py:295 mix_smoothed */
GM_STATIC void model_bank_mix_smoothed(Mixture carried_, Outputs members_, Output output_)
{
    array1_f8 prior_;
    array1_i8 places_;
    array2_f8 aligned_;
    array2_i8 stamps_;
    array1_i8 n_;
    array1_i8 next_row_;
    int64_t i_;
    int64_t stamp_;
    real total_;
    int64_t m_;
    int64_t j_;
    int64_t column_;
    prior_ = carried_.prior_;
    places_ = carried_.places_;
    aligned_ = carried_.aligned_;
    stamps_ = members_.smoothed_stamps_;
    n_ = members_.n_smoothed_;
    next_row_ = carried_.next_row_;
    array1_i8 t1 = (array1_i8){next_row_.p, {next_row_.n[0]}};
    for (int64_t k2 = 0; k2 < t1.n[0]; k2++)
        t1.p[k2 * (1)] = 0;
    int64_t t3 = n_.p[0];
    for (int64_t k4 = 0; k4 < t3; k4 += 1) {
        i_ = k4;
        stamp_ = stamps_.p[(i_)];
        for (;;) {
            if (!(((places_.p[1] < places_.p[0])) && ((carried_.stamps_.p[(gm_mod(places_.p[1], 8192))] != stamp_)))) break;
            places_.p[1] = (places_.p[1] + 1);
        }
        total_ = (real)0.0;
        for (int64_t k5 = 0; k5 < 3; k5 += 1) {
            m_ = k5;
            j_ = next_row_.p[(m_)];
            for (;;) {
                if (!(((j_ < n_.p[(m_)])) && ((stamps_.p[((m_) * stamps_.n[1] + gm_at(j_, stamps_.n[1]))] < stamp_)))) break;
                j_ = (j_ + 1);
            }
            next_row_.p[(m_)] = j_;
            prior_.p[(m_)] = (real)0.0;
            if ((((j_ < n_.p[(m_)])) && ((stamps_.p[((m_) * stamps_.n[1] + gm_at(j_, stamps_.n[1]))] == stamp_)))) {
                prior_.p[(m_)] = carried_.history_.p[((gm_mod(places_.p[1], 8192)) * carried_.history_.n[1] + (m_))];
                for (int64_t k6 = 0; k6 < 15; k6 += 1) {
                    column_ = k6;
                    aligned_.p[((m_) * aligned_.n[1] + (column_))] = members_.smoothed_.p[(((m_) * members_.smoothed_.n[1] + gm_at(j_, members_.smoothed_.n[1])) * members_.smoothed_.n[2] + (column_))];
                }
            }
            total_ = (total_ + prior_.p[(m_)]);
        }
        for (int64_t k7 = 0; k7 < 3; k7 += 1) {
            m_ = k7;
            prior_.p[(m_)] = (((total_ > (real)0.0)) ? (prior_.p[(m_)] / total_) : (((m_ == 0)) ? (real)1.0 : (real)0.0));
        }
        output_.smoothed_stamps_.p[(i_)] = stamp_;
        model_bank_mix_smoothed_row_2(prior_, aligned_, (array1_f8){output_.smoothed_.p + (i_) * (output_.smoothed_.n[1]), {output_.smoothed_.n[1]}});
    }
    places_.p[1] = gm_max_i(places_.p[1], places_.p[2]);
    return;
}

/* estimation/process_model.py:547 _bearing */
GM_INLINE tuple_8 process_model_bearing_3(Layout layout_, tuple_8 x_, tuple_10 elastic_)
{
    real tau_k_;
    tuple_11 t1 = process_model_total(layout_.curve_, (x_.v[0] - x_.v[1]), elastic_.f0, elastic_.f1, x_.v[4]);
    tau_k_ = t1.f0;
    return (tuple_8){{x_.v[0], x_.v[1], x_.v[2], x_.v[3], tau_k_}};
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations_5(Layout layout_, tuple_8 x_, real u_, real load_, array1_f8 p_)
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
        return (tuple_7){{t5, t6}};
    }
    real t7 = drive_motor_acceleration(x1_, x3_, x4_, u_, tau_k_, p_);
    real t8 = drive_arm_acceleration(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t7, t8}};
}

/* estimation/process_model.py:520 _advanced */
GM_INLINE tuple_8 process_model_advanced_3(Layout layout_, tuple_8 x_, tuple_10 elastic_, tuple_9 error_, tuple_7 torques_, real h_, array1_f8 p_)
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
    tuple_8 y_;
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
    tuple_8 t3 = process_model_bearing_3(layout_, x_, elastic_);
    tuple_7 t4 = process_model_accelerations_5(layout_, t3, (u_ - error_.v[0]), load_, p_);
    f1_ = t4.v[0];
    g1_ = t4.v[1];
    real t5 = (x3_ + (half_ * f1_));
    real t6 = (x4_ + (half_ * g1_));
    b3_ = t5;
    b4_ = t6;
    y_ = (tuple_8){{(x1_ + (half_ * x3_)), (x2_ + (half_ * x4_)), b3_, b4_, (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)))}};
    tuple_8 t7 = process_model_bearing_3(layout_, y_, elastic_);
    tuple_7 t8 = process_model_accelerations_5(layout_, t7, (u_ - error_.v[1]), load_, p_);
    f2_ = t8.v[0];
    g2_ = t8.v[1];
    real t9 = (x3_ + (half_ * f2_));
    real t10 = (x4_ + (half_ * g2_));
    c3_ = t9;
    c4_ = t10;
    y_ = (tuple_8){{(x1_ + (half_ * b3_)), (x2_ + (half_ * b4_)), c3_, c4_, (tau_k_ + ((half_ * p_.p[26]) * (b3_ - b4_)))}};
    tuple_8 t11 = process_model_bearing_3(layout_, y_, elastic_);
    tuple_7 t12 = process_model_accelerations_5(layout_, t11, (u_ - error_.v[2]), load_, p_);
    f3_ = t12.v[0];
    g3_ = t12.v[1];
    real t13 = (x3_ + (h_ * f3_));
    real t14 = (x4_ + (h_ * g3_));
    d3_ = t13;
    d4_ = t14;
    y_ = (tuple_8){{(x1_ + (h_ * c3_)), (x2_ + (h_ * c4_)), d3_, d4_, (tau_k_ + ((h_ * p_.p[26]) * (c3_ - c4_)))}};
    tuple_8 t15 = process_model_bearing_3(layout_, y_, elastic_);
    tuple_7 t16 = process_model_accelerations_5(layout_, t15, (u_ - error_.v[3]), load_, p_);
    f4_ = t16.v[0];
    g4_ = t16.v[1];
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (b3_ + c3_))) + d3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (b4_ + c4_))) + d4_));
    return (tuple_8){{(x1_ + moved1_), (x2_ + moved2_), (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_))), (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_))), (tau_k_ + (p_.p[26] * (moved1_ - moved2_)))}};
}

/* estimation/process_model.py:499 _advance_one */
GM_INLINE void process_model_advance_one_3(Layout layout_, array1_f8 z_, tuple_7 torques_, real h_, array1_f8 p_)
{
    real u_;
    real load_;
    int64_t curve_;
    int64_t at_curve_;
    tuple_8 error_;
    tuple_8 x_;
    tuple_9 law_;
    real memory_;
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    curve_ = layout_.curve_;
    int64_t t1 = process_model_curve_count(curve_);
    at_curve_ = (layout_.n_ - t1);
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t2 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], ((real)0.5 * h_), h_, p_);
        error_ = t2;
        z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])] = error_.v[4];
    }
    x_ = (tuple_8){{z_.p[0], z_.p[1], z_.p[2], z_.p[3], z_.p[4]}};
    tuple_9 t3 = process_model_curve(curve_, z_, 1, 0, at_curve_, p_);
    law_ = t3;
    real t4 = process_model_memory(curve_, z_, at_curve_, (x_.v[0] - x_.v[1]));
    memory_ = t4;
    tuple_8 t5 = process_model_advanced_3(layout_, x_, (tuple_10){memory_, law_}, (tuple_9){{error_.v[0], error_.v[1], error_.v[2], error_.v[3]}}, (tuple_7){{u_, load_}}, h_, p_);
    x_ = t5;
    int64_t t6 = process_model_curve_count(curve_);
    if (((t6 > 0))) {
        tuple_7 t7 = transmission_play((x_.v[0] - x_.v[1]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
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
GM_STATIC void process_model_advance_3(Layout layout_, array1_f8 z_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (dt_ / (real)(n_substeps_));
    for (int64_t k1 = 0; k1 < n_substeps_; k1 += 1) {
        process_model_advance_one_3(layout_, z_, torques_, h_, p_);
    }
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row_4(Layout layout_, array1_f8 phi_, int64_t j_, bool first_)
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

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_7(Layout layout_, array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
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

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_3(Layout layout_, array1_f8 phi_, int64_t j_, Stages stages_, tuple_9 errors_, tuple_7 sources_, array1_f8 p_)
{
    bool loaded_;
    int64_t curve_;
    tuple_9 slopes_;
    tuple_9 shares_;
    tuple_13 arms_;
    tuple_12 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_8 m1_;
    tuple_8 c1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_8 c2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_8 c3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_8 c4_;
    tuple_7 r4_;
    loaded_ = layout_.loaded_;
    curve_ = layout_.curve_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_4(layout_, phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_8 t3 = process_model_begin(layout_.n_, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_8 t5 = process_model_bent(curve_, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(loaded_, arms_.v[0], load_, m1_);
    tuple_7 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_8 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_8 t10 = process_model_bent(curve_, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(loaded_, arms_.v[1], load_, m2_);
    tuple_7 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_8 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_8 t15 = process_model_bent(curve_, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(loaded_, arms_.v[2], load_, m3_);
    tuple_7 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_8 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_8 t20 = process_model_bent(curve_, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(loaded_, arms_.v[3], load_, m4_);
    tuple_7 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_7(layout_, phi_, j_, h_, (tuple_12){{m1_, m2_, m3_, m4_}}, (tuple_13){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2_5(Layout layout_, array1_f8 phi_, Stages stages_, array1_f8 p_)
{
    int64_t n_;
    int64_t i_;
    n_ = layout_.n_;
    if ((layout_.loaded_ || ((layout_.curve_ >= 0)))) {
        process_model_column_3(layout_, phi_, 1, stages_, (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}}, (tuple_7){{(real)0.0, (real)0.0}}, p_);
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
GM_INLINE real process_model_memory_row_5(Layout layout_, array1_f8 phi_, int64_t j_, bool first_)
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

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_8(Layout layout_, array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
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
GM_INLINE void process_model_column_4(Layout layout_, array1_f8 phi_, int64_t j_, Stages stages_, tuple_9 errors_, tuple_7 sources_, array1_f8 p_)
{
    bool loaded_;
    int64_t curve_;
    tuple_9 slopes_;
    tuple_9 shares_;
    tuple_13 arms_;
    tuple_12 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_8 m1_;
    tuple_8 c1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_8 c2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_8 c3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_8 c4_;
    tuple_7 r4_;
    loaded_ = layout_.loaded_;
    curve_ = layout_.curve_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_5(layout_, phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_8 t3 = process_model_begin_2(layout_.n_, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_8 t5 = process_model_bent(curve_, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(loaded_, arms_.v[0], load_, m1_);
    tuple_7 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_8 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_8 t10 = process_model_bent(curve_, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(loaded_, arms_.v[1], load_, m2_);
    tuple_7 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_8 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_8 t15 = process_model_bent(curve_, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(loaded_, arms_.v[2], load_, m3_);
    tuple_7 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_8 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_8 t20 = process_model_bent(curve_, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(loaded_, arms_.v[3], load_, m4_);
    tuple_7 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_8(layout_, phi_, j_, h_, (tuple_12){{m1_, m2_, m3_, m4_}}, (tuple_13){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:995 _columns_of_curve */
GM_INLINE void process_model_columns_of_curve_3(Layout layout_, array1_f8 z_, array1_f8 phi_, real memory_, tuple_9 law_, Stages stages_, array1_f8 p_)
{
    int64_t n_;
    int64_t count_;
    int64_t at_;
    tuple_9 none_;
    real width_;
    real end_;
    int64_t j_;
    int64_t t1 = process_model_curve_count(layout_.curve_);
    n_ = layout_.n_;
    count_ = t1;
    int64_t t2 = (n_ - count_);
    at_ = t2;
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((count_ > 0))) {
        process_model_column_4(layout_, phi_, (at_ + 0), stages_, none_, (tuple_7){{(real)0.0, (real)0.0}}, p_);
    }
    if (((count_ > 1))) {
        process_model_column_4(layout_, phi_, (at_ + 1), stages_, none_, (tuple_7){{(real)0.0, (real)2.0}}, p_);
        process_model_column_4(layout_, phi_, (at_ + 2), stages_, none_, (tuple_7){{(real)0.0, (real)3.0}}, p_);
        process_model_column_4(layout_, phi_, (at_ + 3), stages_, none_, (tuple_7){{(real)0.0, (real)4.0}}, p_);
    }
    if (((count_ > 0))) {
        width_ = (gm_fabs(law_.v[2]) / law_.v[0]);
        tuple_7 t3 = transmission_play((z_.p[0] - z_.p[1]), memory_, width_);
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
GM_INLINE void process_model_rk4_5(Layout layout_, array1_f8 z_, array1_f8 phi_, bool first_, tuple_7 torques_, real h_, array1_f8 p_)
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
    tuple_9 law_;
    real memory_;
    tuple_9 rows_;
    tuple_8 error_;
    tuple_12 m1_;
    real total_;
    tuple_8 bend1_;
    real slope1_;
    real share1_;
    tuple_7 arm1_;
    real f1_;
    real g1_;
    tuple_13 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_8 bend2_;
    real slope2_;
    real share2_;
    tuple_7 arm2_;
    real f2_;
    real g2_;
    tuple_12 m2_;
    tuple_13 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_8 bend3_;
    real slope3_;
    real share3_;
    tuple_7 arm3_;
    real f3_;
    real g3_;
    tuple_12 m3_;
    tuple_13 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_8 bend4_;
    real slope4_;
    real share4_;
    tuple_7 arm4_;
    real f4_;
    real g4_;
    tuple_12 m4_;
    tuple_13 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
    int64_t i_;
    int64_t j_;
    tuple_9 none_;
    tuple_8 fades_;
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
    tuple_9 t9 = process_model_curve(curve_, z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory(curve_, z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row_4(layout_, phi_, 0, first_);
    real t12 = process_model_memory_row_4(layout_, phi_, 2, first_);
    real t13 = process_model_memory_row_4(layout_, phi_, 3, first_);
    real t14 = process_model_memory_row_4(layout_, phi_, 4, first_);
    rows_ = (tuple_9){{t11, t12, t13, t14}};
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((n_ > 5))) {
        if (((p_.p[28] > (real)0.0))) {
            load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
        }
        if (((p_.p[29] > (real)0.0))) {
            tuple_8 t15 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], half_, h_, p_);
            error_ = t15;
        }
    }
    tuple_8 t16 = process_model_begin(n_, phi_, 0, first_);
    tuple_8 t17 = process_model_begin(n_, phi_, 2, first_);
    tuple_8 t18 = process_model_begin(n_, phi_, 3, first_);
    tuple_8 t19 = process_model_begin(n_, phi_, 4, first_);
    m1_ = (tuple_12){{t16, t17, t18, t19}};
    tuple_11 t20 = process_model_total(curve_, (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t20.f0;
    bend1_ = t20.f1;
    tuple_7 t21 = process_model_slopes(layout_.law_, x3_, total_, p_);
    slope1_ = t21.v[0];
    share1_ = t21.v[1];
    tuple_7 t22 = process_model_load_slopes(loaded_, x2_, x4_, p_);
    arm1_ = t22;
    tuple_7 t23 = process_model_accelerations_5(layout_, (tuple_8){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t23.v[0];
    g1_ = t23.v[1];
    tuple_12 t24 = process_model_four_bent(curve_, bend1_, rows_, m1_);
    tuple_13 t25 = process_model_four_rates(loaded_, t24, slope1_, share1_, arm1_, p_);
    r1_ = t25;
    real t26 = (x2_ + (half_ * x4_));
    real t27 = (x3_ + (half_ * f1_));
    real t28 = (x4_ + (half_ * g1_));
    y2_ = t26;
    y3_ = t27;
    y4_ = t28;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_11 t29 = process_model_total(curve_, ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t29.f0;
    bend2_ = t29.f1;
    tuple_7 t30 = process_model_slopes(layout_.law_, y3_, total_, p_);
    slope2_ = t30.v[0];
    share2_ = t30.v[1];
    tuple_7 t31 = process_model_load_slopes(loaded_, y2_, y4_, p_);
    arm2_ = t31;
    tuple_7 t32 = process_model_accelerations_5(layout_, (tuple_8){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t32.v[0];
    g2_ = t32.v[1];
    tuple_12 t33 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t33;
    tuple_12 t34 = process_model_four_bent(curve_, bend2_, rows_, m2_);
    tuple_13 t35 = process_model_four_rates(loaded_, t34, slope2_, share2_, arm2_, p_);
    r2_ = t35;
    real t36 = (x2_ + (half_ * y4_));
    real t37 = (x3_ + (half_ * f2_));
    real t38 = (x4_ + (half_ * g2_));
    v2_ = t36;
    v3_ = t37;
    v4_ = t38;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_11 t39 = process_model_total(curve_, ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t39.f0;
    bend3_ = t39.f1;
    tuple_7 t40 = process_model_slopes(layout_.law_, v3_, total_, p_);
    slope3_ = t40.v[0];
    share3_ = t40.v[1];
    tuple_7 t41 = process_model_load_slopes(loaded_, v2_, v4_, p_);
    arm3_ = t41;
    tuple_7 t42 = process_model_accelerations_5(layout_, (tuple_8){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t42.v[0];
    g3_ = t42.v[1];
    tuple_12 t43 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t43;
    tuple_12 t44 = process_model_four_bent(curve_, bend3_, rows_, m3_);
    tuple_13 t45 = process_model_four_rates(loaded_, t44, slope3_, share3_, arm3_, p_);
    r3_ = t45;
    real t46 = (x2_ + (h_ * v4_));
    real t47 = (x3_ + (h_ * f3_));
    real t48 = (x4_ + (h_ * g3_));
    w2_ = t46;
    w3_ = t47;
    w4_ = t48;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_11 t49 = process_model_total(curve_, ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t49.f0;
    bend4_ = t49.f1;
    tuple_7 t50 = process_model_slopes(layout_.law_, w3_, total_, p_);
    slope4_ = t50.v[0];
    share4_ = t50.v[1];
    tuple_7 t51 = process_model_load_slopes(loaded_, w2_, w4_, p_);
    arm4_ = t51;
    tuple_7 t52 = process_model_accelerations_5(layout_, (tuple_8){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t52.v[0];
    g4_ = t52.v[1];
    tuple_12 t53 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t53;
    tuple_12 t54 = process_model_four_bent(curve_, bend4_, rows_, m4_);
    tuple_13 t55 = process_model_four_rates(loaded_, t54, slope4_, share4_, arm4_, p_);
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
    process_model_end_7(layout_, phi_, 0, h_, (tuple_12){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_13){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_);
    process_model_end_7(layout_, phi_, 2, h_, (tuple_12){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_13){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_);
    process_model_end_7(layout_, phi_, 3, h_, (tuple_12){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_13){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_);
    process_model_end_7(layout_, phi_, 4, h_, (tuple_12){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_13){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_);
    stages_ = (Stages){(tuple_9){{slope1_, slope2_, slope3_, slope4_}}, (tuple_9){{share1_, share2_, share3_, share4_}}, (tuple_13){{arm1_, arm2_, arm3_, arm4_}}, (tuple_12){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2_5(layout_, phi_, stages_, p_);
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
        none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        if (((p_.p[28] > (real)0.0))) {
            process_model_column_4(layout_, phi_, (int64_t)(p_.p[28]), stages_, none_, (tuple_7){{(real)1.0, (real)0.0}}, p_);
        }
        if (((p_.p[29] > (real)0.0))) {
            i_ = (int64_t)(p_.p[29]);
            z_.p[gm_at(i_, z_.n[0])] = error_.v[4];
            tuple_8 t60 = process_model_decay(phi_.p[gm_at(((i_ * n_) + i_), phi_.n[0])], half_, h_, p_);
            fades_ = t60;
            process_model_column_4(layout_, phi_, i_, stages_, (tuple_9){{fades_.v[0], fades_.v[1], fades_.v[2], fades_.v[3]}}, (tuple_7){{(real)0.0, (real)0.0}}, p_);
            phi_.p[gm_at(((i_ * n_) + i_), phi_.n[0])] = fades_.v[4];
        }
        process_model_columns_of_curve_3(layout_, z_, phi_, memory_, law_, stages_, p_);
    }
    return;
}

/* estimation/process_model.py:1018 propagate */
GM_INLINE void process_model_propagate_3(Layout layout_, array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (((n_substeps_ > 1)) ? (dt_ / (real)(n_substeps_)) : dt_);
    process_model_rk4_5(layout_, z_, phi_, true, torques_, h_, p_);
    for (int64_t k1 = 1; k1 < n_substeps_; k1 += 1) {
        process_model_rk4_5(layout_, z_, phi_, false, torques_, h_, p_);
    }
    return;
}

/* estimation/process_model.py:376 _has_load */
GM_INLINE bool process_model_has_load(array1_f8 p_)
{
    return (((((p_.p[13] != (real)0.0)) || ((p_.p[14] != (real)0.0))) || ((p_.p[16] != (real)0.0))) || ((p_.p[18] != (real)0.0)));
}

/* estimation/process_model.py:413 tangent */
GM_STATIC void process_model_tangent(array1_f8 z_, array2_f8 m_, array1_f8 p_, array2_f8 out_)
{
    real slope_;
    real share_;
    bool loaded_;
    tuple_7 arm_;
    int64_t load_at_;
    int64_t friction_at_;
    int64_t j_;
    real load_;
    real error_;
    tuple_8 column_;
    real t1 = drive_motor_friction_slope_by_law(z_.p[2], z_.p[4], p_);
    slope_ = t1;
    real t2 = drive_motor_friction_load_slope(z_.p[2], z_.p[4], p_);
    share_ = ((real)1.0 + t2);
    bool t3 = process_model_has_load(p_);
    tuple_7 t4 = drive_arm_load_slopes(z_.p[1], z_.p[3], p_);
    loaded_ = t3;
    arm_ = t4;
    int64_t t5 = (int64_t)(p_.p[28]);
    int64_t t6 = (int64_t)(p_.p[29]);
    load_at_ = t5;
    friction_at_ = t6;
    for (int64_t k7 = 0; k7 < m_.n[1]; k7 += 1) {
        j_ = k7;
        load_ = (real)0.0;
        error_ = (real)0.0;
        if (((load_at_ > 0))) {
            load_ = m_.p[(gm_at(load_at_, m_.n[0]) * m_.n[1] + (j_))];
            out_.p[(gm_at(load_at_, out_.n[0]) * out_.n[1] + (j_))] = (real)0.0;
        }
        if (((friction_at_ > 0))) {
            error_ = m_.p[(gm_at(friction_at_, m_.n[0]) * m_.n[1] + (j_))];
            out_.p[(gm_at(friction_at_, out_.n[0]) * out_.n[1] + (j_))] = ((-error_) / p_.p[27]);
        }
        column_ = (tuple_8){{m_.p[(j_)], m_.p[(2 * m_.n[1] + (j_))], m_.p[(3 * m_.n[1] + (j_))], m_.p[(4 * m_.n[1] + (j_))], m_.p[(1 * m_.n[1] + (j_))]}};
        if (loaded_) {
            real t8 = process_model_answer(true, arm_, load_, column_);
            load_ = t8;
        }
        tuple_7 t9 = process_model_rates(column_, slope_, share_, error_, load_, p_);
        out_.p[(2 * out_.n[1] + (j_))] = t9.v[0];
        out_.p[(3 * out_.n[1] + (j_))] = t9.v[1];
        real t10 = m_.p[(2 * m_.n[1] + (j_))];
        real t11 = m_.p[(3 * m_.n[1] + (j_))];
        out_.p[(j_)] = t10;
        out_.p[(1 * out_.n[1] + (j_))] = t11;
        out_.p[(4 * out_.n[1] + (j_))] = (p_.p[26] * (m_.p[(2 * m_.n[1] + (j_))] - m_.p[(3 * m_.n[1] + (j_))]));
    }
    return;
}

/* estimation/process_model.py:298 torque_slopes */
GM_INLINE tuple_8 process_model_torque_slopes(Layout layout_, array1_f8 z_, array1_f8 p_)
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
    tuple_9 t5 = process_model_curve(curve_, z_, 1, 0, at_, p_);
    tuple_11 t6 = process_model_total(curve_, twist_, t4, t5, z_.p[4]);
    return t6.f1;
}

/* estimation/consider.py:191 variances_of */
GM_INLINE tuple_15 consider_variances_of(Layout layout_, array1_f8 z_, array1_f8 record_, int64_t at_, array1_f8 p_)
{
    int64_t n_;
    int64_t curve_;
    int64_t count_;
    real late_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    tuple_8 slopes_;
    int64_t c_;
    int64_t of_c_;
    real twist_;
    real rate_;
    real torque_;
    int64_t i_;
    n_ = layout_.n_;
    curve_ = layout_.curve_;
    tuple_20 t1 = step_record_sensitivities(n_, record_.n[0]);
    count_ = t1.v[0];
    late_ = (p_.p[34] * z_.p[3]);
    real t2 = (late_ * late_);
    of_twist_ = t2;
    of_rate_ = (real)0.0;
    of_torque_ = (real)0.0;
    tuple_8 t3 = process_model_torque_slopes(layout_, z_, p_);
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
    return (tuple_15){{of_twist_, of_rate_, of_torque_}};
}

/* estimation/process_model.py:246 torque_of */
GM_INLINE tuple_7 process_model_torque_of(Layout layout_, array1_f8 z_, array1_f8 P_, array1_f8 p_)
{
    int64_t n_;
    int64_t curve_;
    int64_t at_;
    real twist_;
    real tau_k_;
    tuple_8 slopes_;
    real variance_;
    int64_t i_;
    int64_t row_;
    real on_others_;
    int64_t j_;
    n_ = layout_.n_;
    curve_ = layout_.curve_;
    if (((curve_ < 0))) {
        return (tuple_7){{z_.p[4], P_.p[(((4 * n_) + 4))]}};
    }
    int64_t t1 = process_model_curve_count(curve_);
    at_ = (n_ - t1);
    twist_ = (z_.p[0] - z_.p[1]);
    real t2 = process_model_memory(curve_, z_, at_, twist_);
    tuple_9 t3 = process_model_curve(curve_, z_, 1, 0, at_, p_);
    tuple_11 t4 = process_model_total(curve_, twist_, t2, t3, z_.p[4]);
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
    return (tuple_7){{tau_k_, gm_max_f(variance_, (real)0.0)}};
}

/* estimation/process_model.py:280 motor_side */
GM_INLINE tuple_7 process_model_motor_side(array1_f8 z_, array1_f8 P_, tuple_7 tau_k_, array1_f8 p_)
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
        return (tuple_7){{torque_, variance_}};
    }
    return (tuple_7){{(torque_ + z_.p[gm_at(i_, z_.n[0])]), ((variance_ + P_.p[gm_at(((i_ * n_) + i_), P_.n[0])]) + ((real)2.0 * P_.p[gm_at(((4 * n_) + i_), P_.n[0])]))}};
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
    tuple_20 t1 = step_record_sensitivities(n_, record_.n[0]);
    at_smoothed_ = t1.v[3];
    tuple_15 t2 = consider_variances_of(layout_, z_, record_, at_smoothed_, p_);
    of_twist_ = t2.v[0];
    of_rate_ = t2.v[1];
    of_torque_ = t2.v[2];
    row_.p[0] = (z_.p[0] - z_.p[1]);
    row_.p[1] = (z_.p[2] - z_.p[3]);
    tuple_7 t3 = process_model_torque_of(layout_, z_, P_, p_);
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
    tuple_7 t6 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[2], variance_}}, p_);
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
    tuple_21 row_;
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
        tuple_21 t7 = linalg_added(n_, (real)1.0, b_, (i_ * n_), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t7;
        int64_t t8 = i_;
        for (int64_t k9 = 0; k9 < t8; k9 += 1) {
            k_ = k9;
            tuple_21 t10 = linalg_added(n_, (-a_.p[(((i_ * n_) + k_))]), out_, (k_ * n_), row_);
            row_ = t10;
        }
        linalg_put(n_, row_, out_, (i_ * n_));
        tuple_21 t11 = linalg_added(n_, a_.p[(((i_ * n_) + i_))], out_, (i_ * n_), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(n_, t11, out_, (i_ * n_));
    }
    int64_t t12 = (n_ - 1);
    for (int64_t k13 = t12; k13 > (-1); k13 += -1) {
        i_ = k13;
        tuple_21 t14 = linalg_added(n_, (real)1.0, out_, (i_ * n_), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t14;
        int64_t t15 = (i_ + 1);
        for (int64_t k16 = t15; k16 < n_; k16 += 1) {
            k_ = k16;
            tuple_21 t17 = linalg_added(n_, (-a_.p[(((k_ * n_) + i_))]), out_, (k_ * n_), row_);
            row_ = t17;
        }
        linalg_put(n_, row_, out_, (i_ * n_));
        tuple_21 t18 = linalg_added(n_, a_.p[(((i_ * n_) + i_))], out_, (i_ * n_), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(n_, t18, out_, (i_ * n_));
    }
    return true;
}

/* kernels/linalg.py:22 multiply */
GM_INLINE void linalg_multiply_3(Layout layout_, array1_f8 a_, array1_f8 b_, array1_f8 out_)
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
        tuple_14 t6 = linalg_row_2(n_, (-1), a_, i_, b_);
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

/* kernels/linalg.py:304 transposed_multiply_symmetric */
GM_INLINE void linalg_transposed_multiply_symmetric(Layout layout_, array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t n_;
    int64_t i_;
    tuple_21 row_;
    int64_t k_;
    int64_t j_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        row_ = (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            k_ = k2;
            tuple_21 t3 = linalg_added(n_, a_.p[(((k_ * n_) + i_))], b_, (k_ * n_), row_);
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
    tuple_21 row_;
    int64_t k_;
    n_ = layout_.n_;
    for (int64_t k1 = 0; k1 < out_.n[0]; k1 += n_) {
        at_ = k1;
        tuple_21 t2 = linalg_added(n_, (real)1.0, out_, at_, (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < n_; k3 += 1) {
            k_ = k3;
            tuple_21 t4 = linalg_added(n_, a_.p[((at_ + k_))], b_, (k_ * n_), row_);
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
    tuple_6 t1 = step_record_places(n_);
    at_pred_ = t1.v[0];
    at_P_pred_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    tuple_20 t2 = step_record_sensitivities(n_, ring_.n[1]);
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
            linalg_multiply_3(layout_, change_, gain_t_, product_);
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

/* estimation/sample_loop.py:236 _stamp_codes */
GM_STATIC void sample_loop_stamp_codes(array1_i8 stamps_, int64_t max_gap_, array1_i8 codes_, array1_i8 gate_)
{
    int64_t k_;
    for (int64_t k1 = 0; k1 < stamps_.n[0]; k1 += 1) {
        k_ = k1;
        int64_t t2 = sample_loop_gate(stamps_.p[(k_)], gate_, max_gap_);
        codes_.p[(k_)] = t2;
        if (((codes_.p[(k_)] == 1))) {
            gate_.p[2] = 0;
        }
        if ((((codes_.p[(k_)] == 0)) || ((codes_.p[(k_)] == 1)))) {
            gate_.p[0] = stamps_.p[(k_)];
        }
    }
    return;
}

/* estimation/sample_loop.py:261 _stops */
GM_STATIC bool sample_loop_stops(int64_t stamp_, array1_i8 gate_)
{
    int64_t at_;
    at_ = gate_.p[8];
    return (((at_ != (-1))) && ((((at_ == 0)) || ((stamp_ >= at_))) || ((stamp_ < (at_ - 1000000000)))));
}

/* estimation/process_model.py:336 begin_curve */
GM_INLINE void process_model_begin_curve(array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    at_ = (6 - count_);
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
GM_STATIC void sample_loop_start(Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
    array1_f8 z_;
    array1_f8 P_;
    bool have1_;
    bool have2_;
    int64_t i_;
    int64_t j_;
    int64_t at_z_;
    int64_t at_P_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    bool t1 = (bool)isfinite(y1_);
    bool t2 = (bool)isfinite(y2_);
    have1_ = t1;
    have2_ = t2;
    for (int64_t k3 = 0; k3 < 6; k3 += 1) {
        i_ = k3;
        z_.p[(i_)] = (real)0.0;
        for (int64_t k4 = 0; k4 < 6; k4 += 1) {
            j_ = k4;
            P_.p[(((i_ * 6) + j_))] = (((i_ == j_)) ? p_.p[((63 + i_))] : (real)0.0);
        }
    }
    z_.p[0] = (have1_ ? y1_ : y2_);
    z_.p[1] = (have2_ ? y2_ : y1_);
    if ((!have1_)) {
        P_.p[0] = (real)100.0;
    }
    if ((!have2_)) {
        P_.p[7] = (real)100.0;
    }
    process_model_begin_curve(z_, p_);
    tuple_6 t5 = step_record_places(6);
    at_z_ = t5.v[3];
    at_P_ = t5.v[4];
    for (int64_t k6 = 0; k6 < 6; k6 += 1) {
        i_ = k6;
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    for (int64_t k7 = 0; k7 < 36; k7 += 1) {
        i_ = k7;
        record_.p[((at_P_ + i_))] = P_.p[(i_)];
    }
    int64_t t8 = step_record_record_size_2(6, 0);
    int64_t t9 = (t8 - 1);
    int64_t t10 = gm_bound(t9, record_.n[0]);
    int64_t t11 = gm_bound((-1), record_.n[0]);
    int64_t t12 = gm_span(t10, t11);
    array1_f8 t13 = (array1_f8){record_.p + t10 * (1), {t12}};
    for (int64_t k14 = 0; k14 < t13.n[0]; k14++)
        t13.p[k14 * (1)] = (real)0.0;
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
GM_INLINE real sample_loop_described(DescribedLoad described_, real measured_, array1_f8 row_, tuple_43 at_, LoopState state_, Belief belief_, array1_f8 p_)
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
            belief_.z_.p[4] = (belief_.z_.p[4] + (load_ - last_));
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
        p_.p[56] = (described_.torque_noise_ + (variance_ / (real)0.05));
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
    tuple_6 t1 = step_record_places(n_);
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
    tuple_20 t1 = step_record_sensitivities(n_, record_.n[0]);
    for (int64_t k2 = 0; k2 < t1.v[0]; k2 += 1) {
        c_ = k2;
        total_ = (total_ + (record_.p[gm_at(((at_ + (c_ * n_)) + i_), record_.n[0])] * record_.p[gm_at(((at_ + (c_ * n_)) + i_), record_.n[0])]));
    }
    return total_;
}

/* estimation/process_model.py:298 torque_slopes */
GM_INLINE tuple_8 process_model_torque_slopes_2(array1_f8 z_, array1_f8 p_)
{
    int64_t at_;
    real twist_;
    int64_t t1 = process_model_curve_count((-1));
    int64_t t2 = (6 - t1);
    real t3 = (z_.p[0] - z_.p[1]);
    at_ = t2;
    twist_ = t3;
    real t4 = process_model_memory((-1), z_, at_, twist_);
    tuple_9 t5 = process_model_curve((-1), z_, 1, 0, at_, p_);
    tuple_11 t6 = process_model_total((-1), twist_, t4, t5, z_.p[4]);
    return t6.f1;
}

/* estimation/consider.py:191 variances_of */
GM_INLINE tuple_15 consider_variances_of_2(array1_f8 z_, array1_f8 record_, int64_t at_, array1_f8 p_)
{
    int64_t count_;
    real late_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    tuple_8 slopes_;
    int64_t c_;
    int64_t of_c_;
    real twist_;
    real rate_;
    real torque_;
    tuple_20 t1 = step_record_sensitivities(6, record_.n[0]);
    count_ = t1.v[0];
    late_ = (p_.p[34] * z_.p[3]);
    real t2 = (late_ * late_);
    of_twist_ = t2;
    of_rate_ = (real)0.0;
    of_torque_ = (real)0.0;
    tuple_8 t3 = process_model_torque_slopes_2(z_, p_);
    slopes_ = t3;
    for (int64_t k4 = 0; k4 < count_; k4 += 1) {
        c_ = k4;
        of_c_ = (at_ + (c_ * 6));
        real t5 = (record_.p[gm_at((of_c_ + 0), record_.n[0])] - record_.p[gm_at((of_c_ + 1), record_.n[0])]);
        real t6 = (record_.p[gm_at((of_c_ + 2), record_.n[0])] - record_.p[gm_at((of_c_ + 3), record_.n[0])]);
        twist_ = t5;
        rate_ = t6;
        torque_ = record_.p[gm_at((of_c_ + 4), record_.n[0])];
        of_twist_ = (of_twist_ + (twist_ * twist_));
        of_rate_ = (of_rate_ + (rate_ * rate_));
        of_torque_ = (of_torque_ + (torque_ * torque_));
    }
    return (tuple_15){{of_twist_, of_rate_, of_torque_}};
}

/* estimation/process_model.py:246 torque_of */
GM_INLINE tuple_7 process_model_torque_of_2(array1_f8 z_, array1_f8 P_, array1_f8 p_)
{
    return (tuple_7){{z_.p[4], P_.p[28]}};
}

/* estimation/process_model.py:315 learned_length */
GM_INLINE tuple_7 process_model_learned_length(array1_f8 z_, array1_f8 P_, int64_t n_, int64_t i_)
{
    int64_t k_;
    real length_;
    real variance_;
    k_ = (n_ - 3);
    length_ = (z_.p[(i_)] / z_.p[gm_at(k_, z_.n[0])]);
    variance_ = (P_.p[(((i_ * n_) + i_))] + (length_ * ((length_ * P_.p[gm_at(((k_ * n_) + k_), P_.n[0])]) - ((real)2.0 * P_.p[gm_at(((k_ * n_) + i_), P_.n[0])]))));
    return (tuple_7){{length_, (gm_sqrt(gm_max_f(variance_, (real)0.0)) / z_.p[gm_at(k_, z_.n[0])])}};
}

/* estimation/consider.py:173 variance_of */
GM_INLINE real consider_variance_of_2(int64_t n_, array1_f8 record_, int64_t at_, int64_t i_)
{
    real total_;
    int64_t c_;
    total_ = (real)0.0;
    tuple_20 t1 = step_record_sensitivities(n_, record_.n[0]);
    for (int64_t k2 = 0; k2 < t1.v[0]; k2 += 1) {
        c_ = k2;
        total_ = (total_ + (record_.p[gm_at(((at_ + (c_ * n_)) + i_), record_.n[0])] * record_.p[gm_at(((at_ + (c_ * n_)) + i_), record_.n[0])]));
    }
    return total_;
}

/* estimation/sample_loop.py:515 _write_estimate */
GM_STATIC void sample_loop_write_estimate(Belief belief_, array1_f8 record_, Reading reading_, array1_f8 p_, real share_, array1_f8 row_)
{
    array1_f8 z_;
    array1_f8 P_;
    int64_t at_s_;
    int64_t i_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t at_scores_;
    real e1_;
    real e2_;
    real s11_;
    real s12_;
    real s22_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_20 t1 = step_record_sensitivities(6, record_.n[0]);
    at_s_ = t1.v[2];
    for (int64_t k2 = 0; k2 < 7; k2 += 1) {
        i_ = k2;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
        row_.p[gm_at((7 + i_), row_.n[0])] = NAN;
    }
    for (int64_t k3 = 0; k3 < 4; k3 += 1) {
        i_ = k3;
        row_.p[gm_at(i_, row_.n[0])] = z_.p[gm_at(i_, z_.n[0])];
        real t5 = P_.p[gm_at(((i_ * 6) + i_), P_.n[0])];
        real t4 = consider_variance_of_2(6, record_, at_s_, i_);
        row_.p[gm_at((7 + i_), row_.n[0])] = gm_sqrt((t5 + t4));
    }
    tuple_15 t6 = consider_variances_of_2(z_, record_, at_s_, p_);
    of_twist_ = t6.v[0];
    of_rate_ = t6.v[1];
    of_torque_ = t6.v[2];
    tuple_7 t7 = process_model_torque_of_2(z_, P_, p_);
    row_.p[4] = t7.v[0];
    variance_ = t7.v[1];
    row_.p[37] = gm_sqrt(variance_);
    tuple_7 t8 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[4], variance_}}, p_);
    row_.p[39] = gm_sqrt(gm_max_f(t8.v[1], (real)0.0));
    row_.p[11] = gm_sqrt((((share_ * variance_) + of_torque_) + (p_.p[33] * p_.p[33])));
    row_.p[40] = NAN;
    row_.p[41] = NAN;
    for (int64_t k9 = 31; k9 < 37; k9 += 1) {
        i_ = k9;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
    }
    int64_t t10 = process_model_curve_count((-1));
    if (((t10 > 1))) {
        real t11 = z_.p[3];
        real t12 = gm_sqrt(P_.p[21]);
        row_.p[31] = t11;
        row_.p[34] = t12;
        tuple_7 t13 = process_model_learned_length(z_, P_, 6, 4);
        row_.p[32] = t13.v[0];
        row_.p[35] = t13.v[1];
        tuple_7 t14 = process_model_learned_length(z_, P_, 6, 5);
        row_.p[33] = t14.v[0];
        row_.p[36] = t14.v[1];
    }
    if (((p_.p[28] > (real)0.0))) {
        i_ = (int64_t)(p_.p[28]);
        row_.p[5] = (z_.p[gm_at(i_, z_.n[0])] + reading_.load_);
        real t16 = P_.p[gm_at(((i_ * 6) + i_), P_.n[0])];
        real t15 = consider_variance_of_2(6, record_, at_s_, i_);
        row_.p[12] = gm_sqrt((t16 + t15));
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        row_.p[6] = z_.p[gm_at(i_, z_.n[0])];
        real t18 = P_.p[gm_at(((i_ * 6) + i_), P_.n[0])];
        real t17 = consider_variance_of_2(6, record_, at_s_, i_);
        row_.p[13] = gm_sqrt((t18 + t17));
    }
    row_.p[14] = (z_.p[0] - z_.p[1]);
    row_.p[15] = (z_.p[2] - z_.p[3]);
    row_.p[16] = gm_sqrt((gm_max_f(((P_.p[0] + P_.p[7]) - ((real)2.0 * P_.p[1])), (real)0.0) + of_twist_));
    row_.p[17] = gm_sqrt((gm_max_f(((P_.p[14] + P_.p[21]) - ((real)2.0 * P_.p[15])), (real)0.0) + of_rate_));
    tuple_6 t19 = step_record_places(6);
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
GM_STATIC void rts_smoother_write_2(array1_f8 z_, array1_f8 P_, array1_f8 p_, array1_f8 record_, array1_f8 row_)
{
    int64_t at_smoothed_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    real noise_;
    tuple_20 t1 = step_record_sensitivities(6, record_.n[0]);
    at_smoothed_ = t1.v[3];
    tuple_15 t2 = consider_variances_of_2(z_, record_, at_smoothed_, p_);
    of_twist_ = t2.v[0];
    of_rate_ = t2.v[1];
    of_torque_ = t2.v[2];
    row_.p[0] = (z_.p[0] - z_.p[1]);
    row_.p[1] = (z_.p[2] - z_.p[3]);
    tuple_7 t3 = process_model_torque_of_2(z_, P_, p_);
    row_.p[2] = t3.v[0];
    variance_ = t3.v[1];
    noise_ = gm_max_f(((P_.p[0] + P_.p[7]) - ((real)2.0 * P_.p[1])), (real)0.0);
    real t4 = gm_sqrt(noise_);
    real t5 = gm_sqrt((noise_ + of_twist_));
    row_.p[10] = t4;
    row_.p[3] = t5;
    noise_ = gm_max_f(((P_.p[14] + P_.p[21]) - ((real)2.0 * P_.p[15])), (real)0.0);
    row_.p[11] = gm_sqrt(noise_);
    row_.p[4] = gm_sqrt((noise_ + of_rate_));
    row_.p[12] = gm_sqrt(gm_max_f(variance_, (real)0.0));
    row_.p[5] = gm_sqrt(((gm_max_f(variance_, (real)0.0) + of_torque_) + (p_.p[33] * p_.p[33])));
    tuple_7 t6 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[2], variance_}}, p_);
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
GM_STATIC bool linalg_solve_positive_2(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t j_;
    real s_;
    int64_t k_;
    real inverse_;
    int64_t i_;
    tuple_21 row_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        j_ = k1;
        s_ = a_.p[(((j_ * 6) + j_))];
        for (int64_t k2 = 0; k2 < j_; k2 += 1) {
            k_ = k2;
            s_ = (s_ - (a_.p[(((j_ * 6) + k_))] * a_.p[(((j_ * 6) + k_))]));
        }
        if ((!((s_ > (real)0.0)))) {
            return false;
        }
        inverse_ = ((real)1.0 / gm_sqrt(s_));
        a_.p[(((j_ * 6) + j_))] = inverse_;
        int64_t t3 = (j_ + 1);
        for (int64_t k4 = t3; k4 < 6; k4 += 1) {
            i_ = k4;
            s_ = a_.p[(((i_ * 6) + j_))];
            for (int64_t k5 = 0; k5 < j_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (a_.p[(((i_ * 6) + k_))] * a_.p[(((j_ * 6) + k_))]));
            }
            a_.p[(((i_ * 6) + j_))] = (s_ * inverse_);
        }
    }
    for (int64_t k6 = 0; k6 < 6; k6 += 1) {
        i_ = k6;
        tuple_21 t7 = linalg_added(6, (real)1.0, b_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t7;
        int64_t t8 = i_;
        for (int64_t k9 = 0; k9 < t8; k9 += 1) {
            k_ = k9;
            tuple_21 t10 = linalg_added(6, (-a_.p[(((i_ * 6) + k_))]), out_, (k_ * 6), row_);
            row_ = t10;
        }
        linalg_put(6, row_, out_, (i_ * 6));
        tuple_21 t11 = linalg_added(6, a_.p[(((i_ * 6) + i_))], out_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(6, t11, out_, (i_ * 6));
    }
    for (int64_t k12 = 5; k12 > (-1); k12 += -1) {
        i_ = k12;
        tuple_21 t13 = linalg_added(6, (real)1.0, out_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t13;
        int64_t t14 = (i_ + 1);
        for (int64_t k15 = t14; k15 < 6; k15 += 1) {
            k_ = k15;
            tuple_21 t16 = linalg_added(6, (-a_.p[(((k_ * 6) + i_))]), out_, (k_ * 6), row_);
            row_ = t16;
        }
        linalg_put(6, row_, out_, (i_ * 6));
        tuple_21 t17 = linalg_added(6, a_.p[(((i_ * 6) + i_))], out_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(6, t17, out_, (i_ * 6));
    }
    return true;
}

/* kernels/linalg.py:304 transposed_multiply_symmetric */
GM_INLINE void linalg_transposed_multiply_symmetric_2(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t i_;
    tuple_21 row_;
    int64_t k_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        row_ = (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        for (int64_t k2 = 0; k2 < 6; k2 += 1) {
            k_ = k2;
            tuple_21 t3 = linalg_added(6, a_.p[(((k_ * 6) + i_))], b_, (k_ * 6), row_);
            row_ = t3;
        }
        linalg_put(6, row_, out_, (i_ * 6));
    }
    for (int64_t k4 = 0; k4 < 6; k4 += 1) {
        i_ = k4;
        int64_t t5 = i_;
        for (int64_t k6 = 0; k6 < t5; k6 += 1) {
            j_ = k6;
            out_.p[(((j_ * 6) + i_))] = out_.p[(((i_ * 6) + j_))];
        }
    }
    return;
}

/* kernels/linalg.py:293 add_product */
GM_INLINE void linalg_add_product_2(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t at_;
    tuple_21 row_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < out_.n[0]; k1 += 6) {
        at_ = k1;
        tuple_21 t2 = linalg_added(6, (real)1.0, out_, at_, (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < 6; k3 += 1) {
            k_ = k3;
            tuple_21 t4 = linalg_added(6, a_.p[((at_ + k_))], b_, (k_ * 6), row_);
            row_ = t4;
        }
        linalg_put(6, row_, out_, at_);
    }
    return;
}

/* estimation/rts_smoother.py:60 smooth */
GM_STATIC void rts_smoother_smooth_2(array2_f8 ring_, Span span_, array1_f8 p_, array1_f8 z_, array2_f8 matrices_, array2_f8 out_)
{
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
    rows_ = ring_.n[0];
    newest_ = span_.newest_;
    oldest_ = span_.oldest_;
    keep_until_ = span_.keep_until_;
    P_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    gain_t_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    factor_ = (array1_f8){matrices_.p + 2 * (matrices_.n[1]), {matrices_.n[1]}};
    change_ = (array1_f8){matrices_.p + 3 * (matrices_.n[1]), {matrices_.n[1]}};
    product_ = (array1_f8){matrices_.p + 4 * (matrices_.n[1]), {matrices_.n[1]}};
    tuple_6 t1 = step_record_places(6);
    at_pred_ = t1.v[0];
    at_P_pred_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    tuple_20 t2 = step_record_sensitivities(6, ring_.n[1]);
    count_ = t2.v[0];
    at_s_pred_ = t2.v[1];
    at_s_ = t2.v[2];
    at_smoothed_ = t2.v[3];
    last_ = (array1_f8){ring_.p + (gm_mod(newest_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
    int64_t t3 = (6 * count_);
    for (int64_t k4 = 0; k4 < t3; k4 += 1) {
        i_ = k4;
        last_.p[gm_at((at_smoothed_ + i_), last_.n[0])] = last_.p[gm_at((at_s_ + i_), last_.n[0])];
    }
    for (int64_t k5 = 0; k5 < 6; k5 += 1) {
        i_ = k5;
        z_.p[(i_)] = last_.p[((at_z_ + i_))];
    }
    for (int64_t k6 = 0; k6 < 36; k6 += 1) {
        i_ = k6;
        P_.p[(i_)] = last_.p[((at_P_ + i_))];
    }
    if (((newest_ <= keep_until_))) {
        rts_smoother_write_2(z_, P_, p_, last_, (array1_f8){out_.p + gm_at((newest_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
    }
    int64_t t7 = (newest_ - 1);
    int64_t t8 = (oldest_ - 1);
    for (int64_t k9 = t7; k9 > t8; k9 += -1) {
        k_ = k9;
        record_ = (array1_f8){ring_.p + (gm_mod(k_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        later_ = (array1_f8){ring_.p + (gm_mod((k_ + 1), rows_)) * (ring_.n[1]), {ring_.n[1]}};
        for (int64_t k10 = 0; k10 < 36; k10 += 1) {
            i_ = k10;
            factor_.p[(i_)] = later_.p[((at_P_pred_ + i_))];
            change_.p[(i_)] = (P_.p[(i_)] - later_.p[((at_P_pred_ + i_))]);
        }
        int64_t t11 = (at_cross_ + 36);
        int64_t t12 = gm_bound(at_cross_, later_.n[0]);
        int64_t t13 = gm_bound(t11, later_.n[0]);
        int64_t t14 = gm_span(t12, t13);
        bool t15 = linalg_solve_positive_2(factor_, (array1_f8){later_.p + t12 * (1), {t14}}, gain_t_);
        if (t15) {
            for (int64_t k16 = 0; k16 < 6; k16 += 1) {
                i_ = k16;
                z_.p[(i_)] = (z_.p[(i_)] - later_.p[((at_pred_ + i_))]);
            }
            linalg_multiply(change_, gain_t_, product_);
            linalg_transposed_multiply_symmetric_2(gain_t_, product_, P_);
            for (int64_t k17 = 0; k17 < 36; k17 += 1) {
                i_ = k17;
                P_.p[(i_)] = (P_.p[(i_)] + record_.p[((at_P_ + i_))]);
            }
            for (int64_t k18 = 0; k18 < 6; k18 += 1) {
                i_ = k18;
                s_ = record_.p[((at_z_ + i_))];
                for (int64_t k19 = 0; k19 < 6; k19 += 1) {
                    m_ = k19;
                    s_ = (s_ + (gain_t_.p[(((m_ * 6) + i_))] * z_.p[(m_)]));
                }
                product_.p[(i_)] = s_;
            }
            for (int64_t k20 = 0; k20 < 6; k20 += 1) {
                i_ = k20;
                z_.p[(i_)] = product_.p[(i_)];
            }
            int64_t t21 = (at_smoothed_ + (6 * count_));
            int64_t t22 = gm_bound(at_smoothed_, later_.n[0]);
            int64_t t23 = gm_bound(t21, later_.n[0]);
            int64_t t24 = gm_span(t22, t23);
            change_s_ = (array1_f8){later_.p + t22 * (1), {t24}};
            int64_t t25 = (6 * count_);
            for (int64_t k26 = 0; k26 < t25; k26 += 1) {
                i_ = k26;
                change_s_.p[(i_)] = (change_s_.p[(i_)] - later_.p[((at_s_pred_ + i_))]);
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            int64_t t27 = (at_smoothed_ + (6 * count_));
            int64_t t28 = gm_bound(at_smoothed_, record_.n[0]);
            int64_t t29 = gm_bound(t27, record_.n[0]);
            int64_t t30 = gm_span(t28, t29);
            linalg_add_product_2(change_s_, gain_t_, (array1_f8){record_.p + t28 * (1), {t30}});
        } else {
            int64_t t31 = (6 * count_);
            for (int64_t k32 = 0; k32 < t31; k32 += 1) {
                i_ = k32;
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            for (int64_t k33 = 0; k33 < 6; k33 += 1) {
                i_ = k33;
                z_.p[(i_)] = record_.p[((at_z_ + i_))];
            }
            for (int64_t k34 = 0; k34 < 36; k34 += 1) {
                i_ = k34;
                P_.p[(i_)] = record_.p[((at_P_ + i_))];
            }
        }
        if (((k_ <= keep_until_))) {
            rts_smoother_write_2(z_, P_, p_, record_, (array1_f8){out_.p + gm_at((k_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
        }
    }
    return;
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_aekf(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(6);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            aekf_resume(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(belief_, reading_, p_);
        }
        bool t22 = aekf_step(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = aekf_used(memory_, p_);
        bool t29 = consider_accompany(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(6, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_2(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/process_model.py:336 begin_curve */
GM_INLINE void process_model_begin_curve_2(array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count((-1));
    count_ = t1;
    at_ = (5 - count_);
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

/* estimation/sample_loop.py:385 start */
GM_STATIC void sample_loop_start_2(Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
    array1_f8 z_;
    array1_f8 P_;
    bool have1_;
    bool have2_;
    int64_t i_;
    int64_t j_;
    int64_t at_z_;
    int64_t at_P_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    bool t1 = (bool)isfinite(y1_);
    bool t2 = (bool)isfinite(y2_);
    have1_ = t1;
    have2_ = t2;
    for (int64_t k3 = 0; k3 < 5; k3 += 1) {
        i_ = k3;
        z_.p[(i_)] = (real)0.0;
        for (int64_t k4 = 0; k4 < 5; k4 += 1) {
            j_ = k4;
            P_.p[(((i_ * 5) + j_))] = (((i_ == j_)) ? p_.p[((63 + i_))] : (real)0.0);
        }
    }
    z_.p[0] = (have1_ ? y1_ : y2_);
    z_.p[1] = (have2_ ? y2_ : y1_);
    if ((!have1_)) {
        P_.p[0] = (real)100.0;
    }
    if ((!have2_)) {
        P_.p[6] = (real)100.0;
    }
    process_model_begin_curve_2(z_, p_);
    tuple_6 t5 = step_record_places(5);
    at_z_ = t5.v[3];
    at_P_ = t5.v[4];
    for (int64_t k6 = 0; k6 < 5; k6 += 1) {
        i_ = k6;
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    for (int64_t k7 = 0; k7 < 25; k7 += 1) {
        i_ = k7;
        record_.p[((at_P_ + i_))] = P_.p[(i_)];
    }
    int64_t t8 = step_record_record_size_2(5, 0);
    int64_t t9 = (t8 - 1);
    int64_t t10 = gm_bound(t9, record_.n[0]);
    int64_t t11 = gm_bound((-1), record_.n[0]);
    int64_t t12 = gm_span(t10, t11);
    array1_f8 t13 = (array1_f8){record_.p + t10 * (1), {t12}};
    for (int64_t k14 = 0; k14 < t13.n[0]; k14++)
        t13.p[k14 * (1)] = (real)0.0;
    return;
}

/* estimation/sample_loop.py:267 _described */
GM_INLINE real sample_loop_described_2(DescribedLoad described_, real measured_, array1_f8 row_, tuple_43 at_, LoopState state_, Belief belief_, array1_f8 p_)
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
            belief_.z_.p[4] = (belief_.z_.p[4] + (load_ - last_));
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
        p_.p[56] = (described_.torque_noise_ + (variance_ / (real)0.05));
        p_.p[1] = ((real)1.0 / inertia_);
        p_.p[30] = (described_.eigenvalue_ * gm_max_f((real)1.0, (described_.inertia_ / inertia_)));
    }
    efforts_.p[((place_) * efforts_.n[1] + 1)] = load_;
    return load_;
}

/* estimation/process_model.py:298 torque_slopes */
GM_INLINE tuple_8 process_model_torque_slopes_3(array1_f8 z_, array1_f8 p_)
{
    int64_t at_;
    real twist_;
    int64_t t1 = process_model_curve_count((-1));
    int64_t t2 = (5 - t1);
    real t3 = (z_.p[0] - z_.p[1]);
    at_ = t2;
    twist_ = t3;
    real t4 = process_model_memory((-1), z_, at_, twist_);
    tuple_9 t5 = process_model_curve((-1), z_, 1, 0, at_, p_);
    tuple_11 t6 = process_model_total((-1), twist_, t4, t5, z_.p[4]);
    return t6.f1;
}

/* estimation/consider.py:191 variances_of */
GM_INLINE tuple_15 consider_variances_of_3(array1_f8 z_, array1_f8 record_, int64_t at_, array1_f8 p_)
{
    int64_t count_;
    real late_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    tuple_8 slopes_;
    int64_t c_;
    int64_t of_c_;
    real twist_;
    real rate_;
    real torque_;
    tuple_20 t1 = step_record_sensitivities(5, record_.n[0]);
    count_ = t1.v[0];
    late_ = (p_.p[34] * z_.p[3]);
    real t2 = (late_ * late_);
    of_twist_ = t2;
    of_rate_ = (real)0.0;
    of_torque_ = (real)0.0;
    tuple_8 t3 = process_model_torque_slopes_3(z_, p_);
    slopes_ = t3;
    for (int64_t k4 = 0; k4 < count_; k4 += 1) {
        c_ = k4;
        of_c_ = (at_ + (c_ * 5));
        real t5 = (record_.p[gm_at((of_c_ + 0), record_.n[0])] - record_.p[gm_at((of_c_ + 1), record_.n[0])]);
        real t6 = (record_.p[gm_at((of_c_ + 2), record_.n[0])] - record_.p[gm_at((of_c_ + 3), record_.n[0])]);
        twist_ = t5;
        rate_ = t6;
        torque_ = record_.p[gm_at((of_c_ + 4), record_.n[0])];
        of_twist_ = (of_twist_ + (twist_ * twist_));
        of_rate_ = (of_rate_ + (rate_ * rate_));
        of_torque_ = (of_torque_ + (torque_ * torque_));
    }
    return (tuple_15){{of_twist_, of_rate_, of_torque_}};
}

/* estimation/process_model.py:246 torque_of */
GM_INLINE tuple_7 process_model_torque_of_3(array1_f8 z_, array1_f8 P_, array1_f8 p_)
{
    return (tuple_7){{z_.p[4], P_.p[24]}};
}

/* estimation/sample_loop.py:515 _write_estimate */
GM_STATIC void sample_loop_write_estimate_2(Belief belief_, array1_f8 record_, Reading reading_, array1_f8 p_, real share_, array1_f8 row_)
{
    array1_f8 z_;
    array1_f8 P_;
    int64_t at_s_;
    int64_t i_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t at_scores_;
    real e1_;
    real e2_;
    real s11_;
    real s12_;
    real s22_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_20 t1 = step_record_sensitivities(5, record_.n[0]);
    at_s_ = t1.v[2];
    for (int64_t k2 = 0; k2 < 7; k2 += 1) {
        i_ = k2;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
        row_.p[gm_at((7 + i_), row_.n[0])] = NAN;
    }
    for (int64_t k3 = 0; k3 < 4; k3 += 1) {
        i_ = k3;
        row_.p[gm_at(i_, row_.n[0])] = z_.p[gm_at(i_, z_.n[0])];
        real t5 = P_.p[gm_at(((i_ * 5) + i_), P_.n[0])];
        real t4 = consider_variance_of_2(5, record_, at_s_, i_);
        row_.p[gm_at((7 + i_), row_.n[0])] = gm_sqrt((t5 + t4));
    }
    tuple_15 t6 = consider_variances_of_3(z_, record_, at_s_, p_);
    of_twist_ = t6.v[0];
    of_rate_ = t6.v[1];
    of_torque_ = t6.v[2];
    tuple_7 t7 = process_model_torque_of_3(z_, P_, p_);
    row_.p[4] = t7.v[0];
    variance_ = t7.v[1];
    row_.p[37] = gm_sqrt(variance_);
    tuple_7 t8 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[4], variance_}}, p_);
    row_.p[39] = gm_sqrt(gm_max_f(t8.v[1], (real)0.0));
    row_.p[11] = gm_sqrt((((share_ * variance_) + of_torque_) + (p_.p[33] * p_.p[33])));
    row_.p[40] = NAN;
    row_.p[41] = NAN;
    for (int64_t k9 = 31; k9 < 37; k9 += 1) {
        i_ = k9;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
    }
    int64_t t10 = process_model_curve_count((-1));
    if (((t10 > 1))) {
        real t11 = z_.p[2];
        real t12 = gm_sqrt(P_.p[12]);
        row_.p[31] = t11;
        row_.p[34] = t12;
        tuple_7 t13 = process_model_learned_length(z_, P_, 5, 3);
        row_.p[32] = t13.v[0];
        row_.p[35] = t13.v[1];
        tuple_7 t14 = process_model_learned_length(z_, P_, 5, 4);
        row_.p[33] = t14.v[0];
        row_.p[36] = t14.v[1];
    }
    if (((p_.p[28] > (real)0.0))) {
        i_ = (int64_t)(p_.p[28]);
        row_.p[5] = (z_.p[gm_at(i_, z_.n[0])] + reading_.load_);
        real t16 = P_.p[gm_at(((i_ * 5) + i_), P_.n[0])];
        real t15 = consider_variance_of_2(5, record_, at_s_, i_);
        row_.p[12] = gm_sqrt((t16 + t15));
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        row_.p[6] = z_.p[gm_at(i_, z_.n[0])];
        real t18 = P_.p[gm_at(((i_ * 5) + i_), P_.n[0])];
        real t17 = consider_variance_of_2(5, record_, at_s_, i_);
        row_.p[13] = gm_sqrt((t18 + t17));
    }
    row_.p[14] = (z_.p[0] - z_.p[1]);
    row_.p[15] = (z_.p[2] - z_.p[3]);
    row_.p[16] = gm_sqrt((gm_max_f(((P_.p[0] + P_.p[6]) - ((real)2.0 * P_.p[1])), (real)0.0) + of_twist_));
    row_.p[17] = gm_sqrt((gm_max_f(((P_.p[12] + P_.p[18]) - ((real)2.0 * P_.p[13])), (real)0.0) + of_rate_));
    tuple_6 t19 = step_record_places(5);
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
GM_STATIC void rts_smoother_write_3(array1_f8 z_, array1_f8 P_, array1_f8 p_, array1_f8 record_, array1_f8 row_)
{
    int64_t at_smoothed_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    real noise_;
    tuple_20 t1 = step_record_sensitivities(5, record_.n[0]);
    at_smoothed_ = t1.v[3];
    tuple_15 t2 = consider_variances_of_3(z_, record_, at_smoothed_, p_);
    of_twist_ = t2.v[0];
    of_rate_ = t2.v[1];
    of_torque_ = t2.v[2];
    row_.p[0] = (z_.p[0] - z_.p[1]);
    row_.p[1] = (z_.p[2] - z_.p[3]);
    tuple_7 t3 = process_model_torque_of_3(z_, P_, p_);
    row_.p[2] = t3.v[0];
    variance_ = t3.v[1];
    noise_ = gm_max_f(((P_.p[0] + P_.p[6]) - ((real)2.0 * P_.p[1])), (real)0.0);
    real t4 = gm_sqrt(noise_);
    real t5 = gm_sqrt((noise_ + of_twist_));
    row_.p[10] = t4;
    row_.p[3] = t5;
    noise_ = gm_max_f(((P_.p[12] + P_.p[18]) - ((real)2.0 * P_.p[13])), (real)0.0);
    row_.p[11] = gm_sqrt(noise_);
    row_.p[4] = gm_sqrt((noise_ + of_rate_));
    row_.p[12] = gm_sqrt(gm_max_f(variance_, (real)0.0));
    row_.p[5] = gm_sqrt(((gm_max_f(variance_, (real)0.0) + of_torque_) + (p_.p[33] * p_.p[33])));
    tuple_7 t6 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[2], variance_}}, p_);
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
GM_STATIC bool linalg_solve_positive_3(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t j_;
    real s_;
    int64_t k_;
    real inverse_;
    int64_t i_;
    tuple_21 row_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        j_ = k1;
        s_ = a_.p[(((j_ * 5) + j_))];
        for (int64_t k2 = 0; k2 < j_; k2 += 1) {
            k_ = k2;
            s_ = (s_ - (a_.p[(((j_ * 5) + k_))] * a_.p[(((j_ * 5) + k_))]));
        }
        if ((!((s_ > (real)0.0)))) {
            return false;
        }
        inverse_ = ((real)1.0 / gm_sqrt(s_));
        a_.p[(((j_ * 5) + j_))] = inverse_;
        int64_t t3 = (j_ + 1);
        for (int64_t k4 = t3; k4 < 5; k4 += 1) {
            i_ = k4;
            s_ = a_.p[(((i_ * 5) + j_))];
            for (int64_t k5 = 0; k5 < j_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (a_.p[(((i_ * 5) + k_))] * a_.p[(((j_ * 5) + k_))]));
            }
            a_.p[(((i_ * 5) + j_))] = (s_ * inverse_);
        }
    }
    for (int64_t k6 = 0; k6 < 5; k6 += 1) {
        i_ = k6;
        tuple_21 t7 = linalg_added(5, (real)1.0, b_, (i_ * 5), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t7;
        int64_t t8 = i_;
        for (int64_t k9 = 0; k9 < t8; k9 += 1) {
            k_ = k9;
            tuple_21 t10 = linalg_added(5, (-a_.p[(((i_ * 5) + k_))]), out_, (k_ * 5), row_);
            row_ = t10;
        }
        linalg_put(5, row_, out_, (i_ * 5));
        tuple_21 t11 = linalg_added(5, a_.p[(((i_ * 5) + i_))], out_, (i_ * 5), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(5, t11, out_, (i_ * 5));
    }
    for (int64_t k12 = 4; k12 > (-1); k12 += -1) {
        i_ = k12;
        tuple_21 t13 = linalg_added(5, (real)1.0, out_, (i_ * 5), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t13;
        int64_t t14 = (i_ + 1);
        for (int64_t k15 = t14; k15 < 5; k15 += 1) {
            k_ = k15;
            tuple_21 t16 = linalg_added(5, (-a_.p[(((k_ * 5) + i_))]), out_, (k_ * 5), row_);
            row_ = t16;
        }
        linalg_put(5, row_, out_, (i_ * 5));
        tuple_21 t17 = linalg_added(5, a_.p[(((i_ * 5) + i_))], out_, (i_ * 5), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(5, t17, out_, (i_ * 5));
    }
    return true;
}

/* kernels/linalg.py:304 transposed_multiply_symmetric */
GM_INLINE void linalg_transposed_multiply_symmetric_3(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t i_;
    tuple_21 row_;
    int64_t k_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 5; k1 += 1) {
        i_ = k1;
        row_ = (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        for (int64_t k2 = 0; k2 < 5; k2 += 1) {
            k_ = k2;
            tuple_21 t3 = linalg_added(5, a_.p[(((k_ * 5) + i_))], b_, (k_ * 5), row_);
            row_ = t3;
        }
        linalg_put(5, row_, out_, (i_ * 5));
    }
    for (int64_t k4 = 0; k4 < 5; k4 += 1) {
        i_ = k4;
        int64_t t5 = i_;
        for (int64_t k6 = 0; k6 < t5; k6 += 1) {
            j_ = k6;
            out_.p[(((j_ * 5) + i_))] = out_.p[(((i_ * 5) + j_))];
        }
    }
    return;
}

/* kernels/linalg.py:293 add_product */
GM_INLINE void linalg_add_product_3(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t at_;
    tuple_21 row_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < out_.n[0]; k1 += 5) {
        at_ = k1;
        tuple_21 t2 = linalg_added(5, (real)1.0, out_, at_, (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < 5; k3 += 1) {
            k_ = k3;
            tuple_21 t4 = linalg_added(5, a_.p[((at_ + k_))], b_, (k_ * 5), row_);
            row_ = t4;
        }
        linalg_put(5, row_, out_, at_);
    }
    return;
}

/* estimation/rts_smoother.py:60 smooth */
GM_STATIC void rts_smoother_smooth_3(array2_f8 ring_, Span span_, array1_f8 p_, array1_f8 z_, array2_f8 matrices_, array2_f8 out_)
{
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
    rows_ = ring_.n[0];
    newest_ = span_.newest_;
    oldest_ = span_.oldest_;
    keep_until_ = span_.keep_until_;
    P_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    gain_t_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    factor_ = (array1_f8){matrices_.p + 2 * (matrices_.n[1]), {matrices_.n[1]}};
    change_ = (array1_f8){matrices_.p + 3 * (matrices_.n[1]), {matrices_.n[1]}};
    product_ = (array1_f8){matrices_.p + 4 * (matrices_.n[1]), {matrices_.n[1]}};
    tuple_6 t1 = step_record_places(5);
    at_pred_ = t1.v[0];
    at_P_pred_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    tuple_20 t2 = step_record_sensitivities(5, ring_.n[1]);
    count_ = t2.v[0];
    at_s_pred_ = t2.v[1];
    at_s_ = t2.v[2];
    at_smoothed_ = t2.v[3];
    last_ = (array1_f8){ring_.p + (gm_mod(newest_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
    int64_t t3 = (5 * count_);
    for (int64_t k4 = 0; k4 < t3; k4 += 1) {
        i_ = k4;
        last_.p[gm_at((at_smoothed_ + i_), last_.n[0])] = last_.p[gm_at((at_s_ + i_), last_.n[0])];
    }
    for (int64_t k5 = 0; k5 < 5; k5 += 1) {
        i_ = k5;
        z_.p[(i_)] = last_.p[((at_z_ + i_))];
    }
    for (int64_t k6 = 0; k6 < 25; k6 += 1) {
        i_ = k6;
        P_.p[(i_)] = last_.p[((at_P_ + i_))];
    }
    if (((newest_ <= keep_until_))) {
        rts_smoother_write_3(z_, P_, p_, last_, (array1_f8){out_.p + gm_at((newest_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
    }
    int64_t t7 = (newest_ - 1);
    int64_t t8 = (oldest_ - 1);
    for (int64_t k9 = t7; k9 > t8; k9 += -1) {
        k_ = k9;
        record_ = (array1_f8){ring_.p + (gm_mod(k_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        later_ = (array1_f8){ring_.p + (gm_mod((k_ + 1), rows_)) * (ring_.n[1]), {ring_.n[1]}};
        for (int64_t k10 = 0; k10 < 25; k10 += 1) {
            i_ = k10;
            factor_.p[(i_)] = later_.p[((at_P_pred_ + i_))];
            change_.p[(i_)] = (P_.p[(i_)] - later_.p[((at_P_pred_ + i_))]);
        }
        int64_t t11 = (at_cross_ + 25);
        int64_t t12 = gm_bound(at_cross_, later_.n[0]);
        int64_t t13 = gm_bound(t11, later_.n[0]);
        int64_t t14 = gm_span(t12, t13);
        bool t15 = linalg_solve_positive_3(factor_, (array1_f8){later_.p + t12 * (1), {t14}}, gain_t_);
        if (t15) {
            for (int64_t k16 = 0; k16 < 5; k16 += 1) {
                i_ = k16;
                z_.p[(i_)] = (z_.p[(i_)] - later_.p[((at_pred_ + i_))]);
            }
            linalg_multiply_2(change_, gain_t_, product_);
            linalg_transposed_multiply_symmetric_3(gain_t_, product_, P_);
            for (int64_t k17 = 0; k17 < 25; k17 += 1) {
                i_ = k17;
                P_.p[(i_)] = (P_.p[(i_)] + record_.p[((at_P_ + i_))]);
            }
            for (int64_t k18 = 0; k18 < 5; k18 += 1) {
                i_ = k18;
                s_ = record_.p[((at_z_ + i_))];
                for (int64_t k19 = 0; k19 < 5; k19 += 1) {
                    m_ = k19;
                    s_ = (s_ + (gain_t_.p[(((m_ * 5) + i_))] * z_.p[(m_)]));
                }
                product_.p[(i_)] = s_;
            }
            for (int64_t k20 = 0; k20 < 5; k20 += 1) {
                i_ = k20;
                z_.p[(i_)] = product_.p[(i_)];
            }
            int64_t t21 = (at_smoothed_ + (5 * count_));
            int64_t t22 = gm_bound(at_smoothed_, later_.n[0]);
            int64_t t23 = gm_bound(t21, later_.n[0]);
            int64_t t24 = gm_span(t22, t23);
            change_s_ = (array1_f8){later_.p + t22 * (1), {t24}};
            int64_t t25 = (5 * count_);
            for (int64_t k26 = 0; k26 < t25; k26 += 1) {
                i_ = k26;
                change_s_.p[(i_)] = (change_s_.p[(i_)] - later_.p[((at_s_pred_ + i_))]);
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            int64_t t27 = (at_smoothed_ + (5 * count_));
            int64_t t28 = gm_bound(at_smoothed_, record_.n[0]);
            int64_t t29 = gm_bound(t27, record_.n[0]);
            int64_t t30 = gm_span(t28, t29);
            linalg_add_product_3(change_s_, gain_t_, (array1_f8){record_.p + t28 * (1), {t30}});
        } else {
            int64_t t31 = (5 * count_);
            for (int64_t k32 = 0; k32 < t31; k32 += 1) {
                i_ = k32;
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            for (int64_t k33 = 0; k33 < 5; k33 += 1) {
                i_ = k33;
                z_.p[(i_)] = record_.p[((at_z_ + i_))];
            }
            for (int64_t k34 = 0; k34 < 25; k34 += 1) {
                i_ = k34;
                P_.p[(i_)] = record_.p[((at_P_ + i_))];
            }
        }
        if (((k_ <= keep_until_))) {
            rts_smoother_write_3(z_, P_, p_, record_, (array1_f8){out_.p + gm_at((k_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
        }
    }
    return;
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_aekf_2(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(5);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start_2(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            aekf_resume(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described_2(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim_2(belief_, reading_, p_);
        }
        bool t22 = aekf_step_2(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = aekf_used(memory_, p_);
        bool t29 = consider_accompany_2(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(5, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate_2(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_3(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
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
GM_STATIC tuple_4 sample_loop_run_ekf(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(6);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(belief_, reading_, p_);
        }
        bool t22 = ekf_step(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(6, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_2(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_ekf_2(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(5);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start_2(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described_2(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim_2(belief_, reading_, p_);
        }
        bool t22 = ekf_step_2(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany_2(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(5, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate_2(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_3(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/process_model.py:204 curve_count */
GM_INLINE int64_t process_model_curve_count_2(int64_t curve_)
{
    return gm_max_i(curve_, 0);
}

/* estimation/process_model.py:336 begin_curve */
GM_INLINE void process_model_begin_curve_3(array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count_2(0);
    count_ = t1;
    at_ = (6 - count_);
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

/* estimation/sample_loop.py:385 start */
GM_STATIC void sample_loop_start_3(Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
    array1_f8 z_;
    array1_f8 P_;
    bool have1_;
    bool have2_;
    int64_t i_;
    int64_t j_;
    int64_t at_z_;
    int64_t at_P_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    bool t1 = (bool)isfinite(y1_);
    bool t2 = (bool)isfinite(y2_);
    have1_ = t1;
    have2_ = t2;
    for (int64_t k3 = 0; k3 < 6; k3 += 1) {
        i_ = k3;
        z_.p[(i_)] = (real)0.0;
        for (int64_t k4 = 0; k4 < 6; k4 += 1) {
            j_ = k4;
            P_.p[(((i_ * 6) + j_))] = (((i_ == j_)) ? p_.p[((63 + i_))] : (real)0.0);
        }
    }
    z_.p[0] = (have1_ ? y1_ : y2_);
    z_.p[1] = (have2_ ? y2_ : y1_);
    if ((!have1_)) {
        P_.p[0] = (real)100.0;
    }
    if ((!have2_)) {
        P_.p[7] = (real)100.0;
    }
    process_model_begin_curve_3(z_, p_);
    tuple_6 t5 = step_record_places(6);
    at_z_ = t5.v[3];
    at_P_ = t5.v[4];
    for (int64_t k6 = 0; k6 < 6; k6 += 1) {
        i_ = k6;
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    for (int64_t k7 = 0; k7 < 36; k7 += 1) {
        i_ = k7;
        record_.p[((at_P_ + i_))] = P_.p[(i_)];
    }
    int64_t t8 = step_record_record_size_2(6, 0);
    int64_t t9 = (t8 - 1);
    int64_t t10 = gm_bound(t9, record_.n[0]);
    int64_t t11 = gm_bound((-1), record_.n[0]);
    int64_t t12 = gm_span(t10, t11);
    array1_f8 t13 = (array1_f8){record_.p + t10 * (1), {t12}};
    for (int64_t k14 = 0; k14 < t13.n[0]; k14++)
        t13.p[k14 * (1)] = (real)0.0;
    return;
}

/* estimation/sample_loop.py:267 _described */
GM_INLINE real sample_loop_described_3(DescribedLoad described_, real measured_, array1_f8 row_, tuple_43 at_, LoopState state_, Belief belief_, array1_f8 p_)
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
        p_.p[1] = ((real)1.0 / inertia_);
        p_.p[30] = (described_.eigenvalue_ * gm_max_f((real)1.0, (described_.inertia_ / inertia_)));
    }
    efforts_.p[((place_) * efforts_.n[1] + 1)] = load_;
    return load_;
}

/* estimation/sample_loop.py:441 aim */
GM_INLINE void sample_loop_aim_3(Belief belief_, Reading reading_, array1_f8 p_)
{
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    real t1 = sample_loop_first_speed((reading_.y1_ - z_.p[0]), dt_, (P_.p[0] + p_.p[31]), P_.p[14]);
    z_.p[2] = t1;
    real t2 = sample_loop_first_speed((reading_.y2_ - z_.p[1]), dt_, (P_.p[7] + p_.p[32]), P_.p[21]);
    z_.p[3] = t2;
    return;
}

/* estimation/process_model.py:210 _curve */
GM_INLINE tuple_9 process_model_curve_3(int64_t curve_, array1_f8 z_, int64_t width_, int64_t i_, int64_t at_, array1_f8 p_)
{
    int64_t count_;
    if (((curve_ < 0))) {
        return (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    }
    int64_t t1 = process_model_curve_count_2(curve_);
    count_ = t1;
    if (((count_ > 1))) {
        return (tuple_9){{z_.p[gm_at((((at_ + 1) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 2) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 3) * width_) + i_), z_.n[0])], p_.p[12]}};
    }
    return (tuple_9){{p_.p[9], (p_.p[9] * p_.p[10]), (((count_ > 0)) ? (p_.p[9] * p_.p[11]) : (real)0.0), p_.p[12]}};
}

/* estimation/process_model.py:223 _memory */
GM_INLINE real process_model_memory_2(int64_t curve_, array1_f8 z_, int64_t at_, real otherwise_)
{
    if (((curve_ < 0))) {
        return otherwise_;
    }
    int64_t t1 = process_model_curve_count_2(curve_);
    if (((t1 > 0))) {
        return z_.p[gm_at(at_, z_.n[0])];
    }
    return otherwise_;
}

/* estimation/process_model.py:233 _total */
GM_INLINE tuple_11 process_model_total_2(int64_t curve_, real twist_, real memory_, tuple_9 law_, real tau_k_)
{
    real torque_;
    tuple_8 slopes_;
    if (((curve_ < 0))) {
        return (tuple_11){tau_k_, (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}}};
    }
    int64_t t1 = process_model_curve_count_2(curve_);
    if (((t1 == 0))) {
        tuple_11 t2 = transmission_dead_zone_torque(twist_, law_.v[0], law_.v[1]);
        torque_ = t2.f0;
        slopes_ = t2.f1;
    } else {
        tuple_11 t3 = transmission_elastic_torque(twist_, memory_, law_);
        torque_ = t3.f0;
        slopes_ = t3.f1;
    }
    return (tuple_11){(tau_k_ + torque_), slopes_};
}

/* estimation/process_model.py:547 _bearing */
GM_INLINE tuple_8 process_model_bearing_4(tuple_8 x_, tuple_10 elastic_)
{
    real tau_k_;
    tuple_11 t1 = process_model_total_2(0, (x_.v[0] - x_.v[1]), elastic_.f0, elastic_.f1, x_.v[4]);
    tau_k_ = t1.f0;
    return (tuple_8){{x_.v[0], x_.v[1], x_.v[2], x_.v[3], tau_k_}};
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations_6(tuple_8 x_, real u_, real load_, array1_f8 p_)
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
    real t1 = drive_motor_acceleration(x1_, x3_, x4_, u_, tau_k_, p_);
    real t2 = drive_arm_acceleration(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t1, t2}};
}

/* estimation/process_model.py:520 _advanced */
GM_INLINE tuple_8 process_model_advanced_4(tuple_8 x_, tuple_10 elastic_, tuple_9 error_, tuple_7 torques_, real h_, array1_f8 p_)
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
    tuple_8 y_;
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
    tuple_8 t3 = process_model_bearing_4(x_, elastic_);
    tuple_7 t4 = process_model_accelerations_6(t3, (u_ - error_.v[0]), load_, p_);
    f1_ = t4.v[0];
    g1_ = t4.v[1];
    real t5 = (x3_ + (half_ * f1_));
    real t6 = (x4_ + (half_ * g1_));
    b3_ = t5;
    b4_ = t6;
    y_ = (tuple_8){{(x1_ + (half_ * x3_)), (x2_ + (half_ * x4_)), b3_, b4_, (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)))}};
    tuple_8 t7 = process_model_bearing_4(y_, elastic_);
    tuple_7 t8 = process_model_accelerations_6(t7, (u_ - error_.v[1]), load_, p_);
    f2_ = t8.v[0];
    g2_ = t8.v[1];
    real t9 = (x3_ + (half_ * f2_));
    real t10 = (x4_ + (half_ * g2_));
    c3_ = t9;
    c4_ = t10;
    y_ = (tuple_8){{(x1_ + (half_ * b3_)), (x2_ + (half_ * b4_)), c3_, c4_, (tau_k_ + ((half_ * p_.p[26]) * (b3_ - b4_)))}};
    tuple_8 t11 = process_model_bearing_4(y_, elastic_);
    tuple_7 t12 = process_model_accelerations_6(t11, (u_ - error_.v[2]), load_, p_);
    f3_ = t12.v[0];
    g3_ = t12.v[1];
    real t13 = (x3_ + (h_ * f3_));
    real t14 = (x4_ + (h_ * g3_));
    d3_ = t13;
    d4_ = t14;
    y_ = (tuple_8){{(x1_ + (h_ * c3_)), (x2_ + (h_ * c4_)), d3_, d4_, (tau_k_ + ((h_ * p_.p[26]) * (c3_ - c4_)))}};
    tuple_8 t15 = process_model_bearing_4(y_, elastic_);
    tuple_7 t16 = process_model_accelerations_6(t15, (u_ - error_.v[3]), load_, p_);
    f4_ = t16.v[0];
    g4_ = t16.v[1];
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (b3_ + c3_))) + d3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (b4_ + c4_))) + d4_));
    return (tuple_8){{(x1_ + moved1_), (x2_ + moved2_), (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_))), (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_))), (tau_k_ + (p_.p[26] * (moved1_ - moved2_)))}};
}

/* estimation/process_model.py:499 _advance_one */
GM_INLINE void process_model_advance_one_4(array1_f8 z_, tuple_7 torques_, real h_, array1_f8 p_)
{
    real u_;
    real load_;
    int64_t at_curve_;
    tuple_8 error_;
    tuple_8 x_;
    tuple_9 law_;
    real memory_;
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    int64_t t1 = process_model_curve_count_2(0);
    at_curve_ = (6 - t1);
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t2 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], ((real)0.5 * h_), h_, p_);
        error_ = t2;
        z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])] = error_.v[4];
    }
    x_ = (tuple_8){{z_.p[0], z_.p[1], z_.p[2], z_.p[3], z_.p[4]}};
    tuple_9 t3 = process_model_curve_3(0, z_, 1, 0, at_curve_, p_);
    law_ = t3;
    real t4 = process_model_memory_2(0, z_, at_curve_, (x_.v[0] - x_.v[1]));
    memory_ = t4;
    tuple_8 t5 = process_model_advanced_4(x_, (tuple_10){memory_, law_}, (tuple_9){{error_.v[0], error_.v[1], error_.v[2], error_.v[3]}}, (tuple_7){{u_, load_}}, h_, p_);
    x_ = t5;
    int64_t t6 = process_model_curve_count_2(0);
    if (((t6 > 0))) {
        tuple_7 t7 = transmission_play((x_.v[0] - x_.v[1]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
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
GM_STATIC void process_model_advance_4(array1_f8 z_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (dt_ / (real)(n_substeps_));
    for (int64_t k1 = 0; k1 < n_substeps_; k1 += 1) {
        process_model_advance_one_4(z_, torques_, h_, p_);
    }
    return;
}

/* estimation/process_model.py:1044 propagate_numeric */
GM_STATIC void process_model_propagate_numeric_3(array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_, array1_f8 start_)
{
    int64_t i_;
    int64_t j_;
    array1_f8 moved_;
    real step_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        start_.p[(i_)] = z_.p[(i_)];
    }
    process_model_advance_4(z_, torques_, dt_, n_substeps_, p_);
    for (int64_t k2 = 0; k2 < 6; k2 += 1) {
        j_ = k2;
        int64_t t3 = (j_ * 6);
        int64_t t4 = ((j_ + 1) * 6);
        int64_t t5 = gm_bound(t3, phi_.n[0]);
        int64_t t6 = gm_bound(t4, phi_.n[0]);
        int64_t t7 = gm_span(t5, t6);
        moved_ = (array1_f8){phi_.p + t5 * (1), {t7}};
        for (int64_t k8 = 0; k8 < 6; k8 += 1) {
            i_ = k8;
            moved_.p[(i_)] = start_.p[(i_)];
        }
        moved_.p[(j_)] = (moved_.p[(j_)] + ((real)1e-06 * gm_max_f((real)1.0, gm_fabs(start_.p[(j_)]))));
        step_ = (moved_.p[(j_)] - start_.p[(j_)]);
        process_model_advance_4(moved_, torques_, dt_, n_substeps_, p_);
        for (int64_t k9 = 0; k9 < 6; k9 += 1) {
            i_ = k9;
            moved_.p[(i_)] = ((moved_.p[(i_)] - z_.p[(i_)]) / step_);
        }
    }
    for (int64_t k10 = 0; k10 < 6; k10 += 1) {
        i_ = k10;
        int64_t t11 = i_;
        for (int64_t k12 = 0; k12 < t11; k12 += 1) {
            j_ = k12;
            real t13 = phi_.p[(((j_ * 6) + i_))];
            real t14 = phi_.p[(((i_ * 6) + j_))];
            phi_.p[(((i_ * 6) + j_))] = t13;
            phi_.p[(((j_ * 6) + i_))] = t14;
        }
    }
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row_6(array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t count_;
    int64_t t1 = process_model_curve_count_2(0);
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (6 - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((6 - count_) * 6) + j_), phi_.n[0])];
}

/* estimation/process_model.py:748 _bent */
GM_INLINE tuple_8 process_model_bent_2(int64_t curve_, tuple_8 bend_, real source_, tuple_8 m_)
{
    if (((curve_ < 0))) {
        return m_;
    }
    return (tuple_8){{m_.v[0], m_.v[1], m_.v[2], gm_fma(bend_.v[0], (m_.v[0] - m_.v[4]), (m_.v[3] + source_)), m_.v[4]}};
}

/* estimation/process_model.py:756 _four_bent */
GM_INLINE tuple_12 process_model_four_bent_2(int64_t curve_, tuple_8 bend_, tuple_9 memory_, tuple_12 m_)
{
    if (((curve_ < 0))) {
        return m_;
    }
    tuple_8 t1 = process_model_bent_2(curve_, bend_, (bend_.v[1] * memory_.v[0]), m_.v[0]);
    tuple_8 t2 = process_model_bent_2(curve_, bend_, (bend_.v[1] * memory_.v[1]), m_.v[1]);
    tuple_8 t3 = process_model_bent_2(curve_, bend_, (bend_.v[1] * memory_.v[2]), m_.v[2]);
    tuple_8 t4 = process_model_bent_2(curve_, bend_, (bend_.v[1] * memory_.v[3]), m_.v[3]);
    return (tuple_12){{t1, t2, t3, t4}};
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_9(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
{
    real moved1_;
    real moved2_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[((0 + j_))] = (m_.v[0].v[0] + moved1_);
    phi_.p[((6 + j_))] = (m_.v[0].v[4] + moved2_);
    phi_.p[((12 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[((18 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[((24 + j_))] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_5(array1_f8 phi_, int64_t j_, Stages stages_, tuple_9 errors_, tuple_7 sources_, array1_f8 p_)
{
    tuple_9 slopes_;
    tuple_9 shares_;
    tuple_13 arms_;
    tuple_12 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_8 m1_;
    tuple_8 c1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_8 c2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_8 c3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_8 c4_;
    tuple_7 r4_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_6(phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_8 t3 = process_model_begin(6, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_8 t5 = process_model_bent_2(0, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(false, arms_.v[0], load_, m1_);
    tuple_7 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_8 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_8 t10 = process_model_bent_2(0, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(false, arms_.v[1], load_, m2_);
    tuple_7 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_8 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_8 t15 = process_model_bent_2(0, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(false, arms_.v[2], load_, m3_);
    tuple_7 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_8 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_8 t20 = process_model_bent_2(0, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(false, arms_.v[3], load_, m4_);
    tuple_7 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_9(phi_, j_, h_, (tuple_12){{m1_, m2_, m3_, m4_}}, (tuple_13){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2_6(array1_f8 phi_, Stages stages_, array1_f8 p_)
{
    process_model_column_5(phi_, 1, stages_, (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}}, (tuple_7){{(real)0.0, (real)0.0}}, p_);
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row_7(array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t count_;
    int64_t t1 = process_model_curve_count_2(0);
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (6 - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((6 - count_) * 6) + j_), phi_.n[0])];
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_10(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
{
    real moved1_;
    real moved2_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[gm_at((0 + j_), phi_.n[0])] = (m_.v[0].v[0] + moved1_);
    phi_.p[gm_at((6 + j_), phi_.n[0])] = (m_.v[0].v[4] + moved2_);
    phi_.p[gm_at((12 + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[gm_at((18 + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[gm_at((24 + j_), phi_.n[0])] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_6(array1_f8 phi_, int64_t j_, Stages stages_, tuple_9 errors_, tuple_7 sources_, array1_f8 p_)
{
    tuple_9 slopes_;
    tuple_9 shares_;
    tuple_13 arms_;
    tuple_12 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_8 m1_;
    tuple_8 c1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_8 c2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_8 c3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_8 c4_;
    tuple_7 r4_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_7(phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_8 t3 = process_model_begin_2(6, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_8 t5 = process_model_bent_2(0, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(false, arms_.v[0], load_, m1_);
    tuple_7 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_8 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_8 t10 = process_model_bent_2(0, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(false, arms_.v[1], load_, m2_);
    tuple_7 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_8 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_8 t15 = process_model_bent_2(0, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(false, arms_.v[2], load_, m3_);
    tuple_7 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_8 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_8 t20 = process_model_bent_2(0, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(false, arms_.v[3], load_, m4_);
    tuple_7 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_10(phi_, j_, h_, (tuple_12){{m1_, m2_, m3_, m4_}}, (tuple_13){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:995 _columns_of_curve */
GM_INLINE void process_model_columns_of_curve_4(array1_f8 z_, array1_f8 phi_, real memory_, tuple_9 law_, Stages stages_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    tuple_9 none_;
    real width_;
    real end_;
    int64_t j_;
    int64_t t1 = process_model_curve_count_2(0);
    count_ = t1;
    int64_t t2 = (6 - count_);
    at_ = t2;
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((count_ > 0))) {
        process_model_column_6(phi_, (at_ + 0), stages_, none_, (tuple_7){{(real)0.0, (real)0.0}}, p_);
    }
    if (((count_ > 1))) {
        process_model_column_6(phi_, (at_ + 1), stages_, none_, (tuple_7){{(real)0.0, (real)2.0}}, p_);
        process_model_column_6(phi_, (at_ + 2), stages_, none_, (tuple_7){{(real)0.0, (real)3.0}}, p_);
        process_model_column_6(phi_, (at_ + 3), stages_, none_, (tuple_7){{(real)0.0, (real)4.0}}, p_);
    }
    if (((count_ > 0))) {
        width_ = (gm_fabs(law_.v[2]) / law_.v[0]);
        tuple_7 t3 = transmission_play((z_.p[0] - z_.p[1]), memory_, width_);
        z_.p[gm_at((at_ + 0), z_.n[0])] = t3.v[0];
        end_ = t3.v[1];
        if (((end_ != (real)0.0))) {
            for (int64_t k4 = 0; k4 < 6; k4 += 1) {
                j_ = k4;
                phi_.p[gm_at((((at_ + 0) * 6) + j_), phi_.n[0])] = (phi_.p[((0 + j_))] - phi_.p[((6 + j_))]);
            }
            if (((count_ > 1))) {
                phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 1), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 1), phi_.n[0])] + ((end_ * width_) / law_.v[0]));
                phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 3), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * 6) + at_) + 3), phi_.n[0])] - ((((law_.v[2] >= (real)0.0)) ? end_ : (-end_)) / law_.v[0]));
            }
        }
    }
    return;
}

/* estimation/process_model.py:883 rk4 */
GM_INLINE void process_model_rk4_6(array1_f8 z_, array1_f8 phi_, bool first_, tuple_7 torques_, real h_, array1_f8 p_)
{
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
    tuple_9 law_;
    real memory_;
    tuple_9 rows_;
    tuple_8 error_;
    tuple_12 m1_;
    real total_;
    tuple_8 bend1_;
    real slope1_;
    real share1_;
    tuple_7 arm1_;
    real f1_;
    real g1_;
    tuple_13 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_8 bend2_;
    real slope2_;
    real share2_;
    tuple_7 arm2_;
    real f2_;
    real g2_;
    tuple_12 m2_;
    tuple_13 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_8 bend3_;
    real slope3_;
    real share3_;
    tuple_7 arm3_;
    real f3_;
    real g3_;
    tuple_12 m3_;
    tuple_13 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_8 bend4_;
    real slope4_;
    real share4_;
    tuple_7 arm4_;
    real f4_;
    real g4_;
    tuple_12 m4_;
    tuple_13 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
    int64_t i_;
    int64_t j_;
    tuple_9 none_;
    tuple_8 fades_;
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
    int64_t t8 = process_model_curve_count_2(0);
    at_curve_ = (6 - t8);
    tuple_9 t9 = process_model_curve_3(0, z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory_2(0, z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row_6(phi_, 0, first_);
    real t12 = process_model_memory_row_6(phi_, 2, first_);
    real t13 = process_model_memory_row_6(phi_, 3, first_);
    real t14 = process_model_memory_row_6(phi_, 4, first_);
    rows_ = (tuple_9){{t11, t12, t13, t14}};
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t15 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], half_, h_, p_);
        error_ = t15;
    }
    tuple_8 t16 = process_model_begin(6, phi_, 0, first_);
    tuple_8 t17 = process_model_begin(6, phi_, 2, first_);
    tuple_8 t18 = process_model_begin(6, phi_, 3, first_);
    tuple_8 t19 = process_model_begin(6, phi_, 4, first_);
    m1_ = (tuple_12){{t16, t17, t18, t19}};
    tuple_11 t20 = process_model_total_2(0, (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t20.f0;
    bend1_ = t20.f1;
    tuple_7 t21 = process_model_slopes(false, x3_, total_, p_);
    slope1_ = t21.v[0];
    share1_ = t21.v[1];
    tuple_7 t22 = process_model_load_slopes(false, x2_, x4_, p_);
    arm1_ = t22;
    tuple_7 t23 = process_model_accelerations_6((tuple_8){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t23.v[0];
    g1_ = t23.v[1];
    tuple_12 t24 = process_model_four_bent_2(0, bend1_, rows_, m1_);
    tuple_13 t25 = process_model_four_rates(false, t24, slope1_, share1_, arm1_, p_);
    r1_ = t25;
    real t26 = (x2_ + (half_ * x4_));
    real t27 = (x3_ + (half_ * f1_));
    real t28 = (x4_ + (half_ * g1_));
    y2_ = t26;
    y3_ = t27;
    y4_ = t28;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_11 t29 = process_model_total_2(0, ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t29.f0;
    bend2_ = t29.f1;
    tuple_7 t30 = process_model_slopes(false, y3_, total_, p_);
    slope2_ = t30.v[0];
    share2_ = t30.v[1];
    tuple_7 t31 = process_model_load_slopes(false, y2_, y4_, p_);
    arm2_ = t31;
    tuple_7 t32 = process_model_accelerations_6((tuple_8){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t32.v[0];
    g2_ = t32.v[1];
    tuple_12 t33 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t33;
    tuple_12 t34 = process_model_four_bent_2(0, bend2_, rows_, m2_);
    tuple_13 t35 = process_model_four_rates(false, t34, slope2_, share2_, arm2_, p_);
    r2_ = t35;
    real t36 = (x2_ + (half_ * y4_));
    real t37 = (x3_ + (half_ * f2_));
    real t38 = (x4_ + (half_ * g2_));
    v2_ = t36;
    v3_ = t37;
    v4_ = t38;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_11 t39 = process_model_total_2(0, ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t39.f0;
    bend3_ = t39.f1;
    tuple_7 t40 = process_model_slopes(false, v3_, total_, p_);
    slope3_ = t40.v[0];
    share3_ = t40.v[1];
    tuple_7 t41 = process_model_load_slopes(false, v2_, v4_, p_);
    arm3_ = t41;
    tuple_7 t42 = process_model_accelerations_6((tuple_8){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t42.v[0];
    g3_ = t42.v[1];
    tuple_12 t43 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t43;
    tuple_12 t44 = process_model_four_bent_2(0, bend3_, rows_, m3_);
    tuple_13 t45 = process_model_four_rates(false, t44, slope3_, share3_, arm3_, p_);
    r3_ = t45;
    real t46 = (x2_ + (h_ * v4_));
    real t47 = (x3_ + (h_ * f3_));
    real t48 = (x4_ + (h_ * g3_));
    w2_ = t46;
    w3_ = t47;
    w4_ = t48;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_11 t49 = process_model_total_2(0, ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t49.f0;
    bend4_ = t49.f1;
    tuple_7 t50 = process_model_slopes(false, w3_, total_, p_);
    slope4_ = t50.v[0];
    share4_ = t50.v[1];
    tuple_7 t51 = process_model_load_slopes(false, w2_, w4_, p_);
    arm4_ = t51;
    tuple_7 t52 = process_model_accelerations_6((tuple_8){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t52.v[0];
    g4_ = t52.v[1];
    tuple_12 t53 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t53;
    tuple_12 t54 = process_model_four_bent_2(0, bend4_, rows_, m4_);
    tuple_13 t55 = process_model_four_rates(false, t54, slope4_, share4_, arm4_, p_);
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
    process_model_end_9(phi_, 0, h_, (tuple_12){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_13){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_);
    process_model_end_9(phi_, 2, h_, (tuple_12){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_13){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_);
    process_model_end_9(phi_, 3, h_, (tuple_12){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_13){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_);
    process_model_end_9(phi_, 4, h_, (tuple_12){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_13){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_);
    stages_ = (Stages){(tuple_9){{slope1_, slope2_, slope3_, slope4_}}, (tuple_9){{share1_, share2_, share3_, share4_}}, (tuple_13){{arm1_, arm2_, arm3_, arm4_}}, (tuple_12){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2_6(phi_, stages_, p_);
    if (first_) {
        for (int64_t k58 = 5; k58 < 6; k58 += 1) {
            i_ = k58;
            for (int64_t k59 = 0; k59 < 6; k59 += 1) {
                j_ = k59;
                phi_.p[gm_at(((i_ * 6) + j_), phi_.n[0])] = (((i_ == j_)) ? (real)1.0 : (real)0.0);
            }
        }
    }
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        process_model_column_6(phi_, (int64_t)(p_.p[28]), stages_, none_, (tuple_7){{(real)1.0, (real)0.0}}, p_);
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        z_.p[gm_at(i_, z_.n[0])] = error_.v[4];
        tuple_8 t60 = process_model_decay(phi_.p[gm_at(((i_ * 6) + i_), phi_.n[0])], half_, h_, p_);
        fades_ = t60;
        process_model_column_6(phi_, i_, stages_, (tuple_9){{fades_.v[0], fades_.v[1], fades_.v[2], fades_.v[3]}}, (tuple_7){{(real)0.0, (real)0.0}}, p_);
        phi_.p[gm_at(((i_ * 6) + i_), phi_.n[0])] = fades_.v[4];
    }
    process_model_columns_of_curve_4(z_, phi_, memory_, law_, stages_, p_);
    return;
}

/* estimation/process_model.py:1018 propagate */
GM_INLINE void process_model_propagate_4(array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (((n_substeps_ > 1)) ? (dt_ / (real)(n_substeps_)) : dt_);
    process_model_rk4_6(z_, phi_, true, torques_, h_, p_);
    for (int64_t k1 = 1; k1 < n_substeps_; k1 += 1) {
        process_model_rk4_6(z_, phi_, false, torques_, h_, p_);
    }
    return;
}

/* kernels/linalg.py:172 _moves */
GM_INLINE bool linalg_moves(int64_t i_, int64_t memory_)
{
    return (((i_ < 4)) || ((4 < i_) && (i_ <= memory_)));
}

/* kernels/linalg.py:178 _fused */
GM_INLINE tuple_21 linalg_fused(int64_t n_, real v_, array1_f8 b_, int64_t at_, tuple_21 row_)
{
    return (tuple_21){{gm_fma(v_, b_.p[(at_)], row_.v[0]), gm_fma(v_, b_.p[((at_ + 1))], row_.v[1]), gm_fma(v_, b_.p[((at_ + 2))], row_.v[2]), gm_fma(v_, b_.p[((at_ + 3))], row_.v[3]), gm_fma(v_, b_.p[((at_ + 4))], row_.v[4]), (((n_ > 5)) ? gm_fma(v_, b_.p[((at_ + 5))], row_.v[5]) : (real)0.0), (((n_ > 6)) ? gm_fma(v_, b_.p[((at_ + 6))], row_.v[6]) : (real)0.0), (((n_ > 7)) ? gm_fma(v_, b_.p[((at_ + 7))], row_.v[7]) : (real)0.0), (((n_ > 8)) ? gm_fma(v_, b_.p[((at_ + 8))], row_.v[8]) : (real)0.0), (((n_ > 9)) ? gm_fma(v_, b_.p[((at_ + 9))], row_.v[9]) : (real)0.0), (((n_ > 10)) ? gm_fma(v_, b_.p[((at_ + 10))], row_.v[10]) : (real)0.0)}};
}

/* kernels/linalg.py:212 _weighted */
GM_INLINE tuple_21 linalg_weighted(int64_t n_, array1_f8 phi_, int64_t at_, array1_f8 half_, tuple_21 row_)
{
    return (tuple_21){{gm_fma(phi_.p[(at_)], half_.p[0], row_.v[0]), gm_fma(phi_.p[((at_ + 1))], half_.p[1], row_.v[1]), gm_fma(phi_.p[((at_ + 2))], half_.p[2], row_.v[2]), gm_fma(phi_.p[((at_ + 3))], half_.p[3], row_.v[3]), gm_fma(phi_.p[((at_ + 4))], half_.p[4], row_.v[4]), (((n_ > 5)) ? gm_fma(phi_.p[((at_ + 5))], half_.p[5], row_.v[5]) : (real)0.0), (((n_ > 6)) ? gm_fma(phi_.p[((at_ + 6))], half_.p[6], row_.v[6]) : (real)0.0), (((n_ > 7)) ? gm_fma(phi_.p[((at_ + 7))], half_.p[7], row_.v[7]) : (real)0.0), (((n_ > 8)) ? gm_fma(phi_.p[((at_ + 8))], half_.p[8], row_.v[8]) : (real)0.0), (((n_ > 9)) ? gm_fma(phi_.p[((at_ + 9))], half_.p[9], row_.v[9]) : (real)0.0), (((n_ > 10)) ? gm_fma(phi_.p[((at_ + 10))], half_.p[10], row_.v[10]) : (real)0.0)}};
}

/* kernels/linalg.py:229 _product */
GM_INLINE real linalg_product(int64_t n_, tuple_21 row_, array1_f8 b_, int64_t at_)
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

/* kernels/linalg.py:141 _carry_curve */
GM_INLINE void linalg_carry_curve(int64_t curve_, int64_t n_, array1_f8 phi_, array1_f8 P_, array1_f8 half_, array1_f8 cross_, array1_f8 out_)
{
    int64_t memory_;
    int64_t i_;
    int64_t j_;
    int64_t at_;
    tuple_21 row_;
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
            row_ = (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
            for (int64_t k7 = 0; k7 < n_; k7 += 1) {
                k_ = k7;
                tuple_21 t8 = linalg_fused(n_, phi_.p[((at_ + k_))], P_, (k_ * n_), row_);
                row_ = t8;
            }
            linalg_put(n_, row_, cross_, at_);
            tuple_21 t9 = linalg_weighted(n_, phi_, at_, half_, row_);
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

/* kernels/linalg.py:100 carry */
GM_INLINE void linalg_carry_3(array1_f8 phi_, array1_f8 P_, array1_f8 half_, array1_f8 cross_, array1_f8 out_)
{
    linalg_carry_curve(0, 6, phi_, P_, half_, cross_, out_);
    return;
}

/* estimation/filters/ekf.py:56 predict */
GM_INLINE void ekf_predict_3(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
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
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    tuple_6 t1 = step_record_places(6);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    phi_ = (array1_f8){scratch_.matrices_.p + 0 * (scratch_.matrices_.n[1]), {scratch_.matrices_.n[1]}};
    int64_t t2 = (at_cross_ + 36);
    int64_t t3 = gm_bound(at_cross_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = (at_P_ + 36);
    int64_t t7 = gm_bound(at_P_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    cross_ = (array1_f8){record_.p + t3 * (1), {t5}};
    P_pred_ = (array1_f8){record_.p + t7 * (1), {t9}};
    for (int64_t k10 = 0; k10 < 6; k10 += 1) {
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
        real t16 = process_model_softened_sharpness(motor_, P_.p[14]);
        p_.p[5] = t16;
        real t17 = process_model_softened_sharpness(arm_, P_.p[21]);
        p_.p[15] = t17;
    }
    if (((p_.p[36] > (real)0.0))) {
        process_model_propagate_numeric_3(z_, phi_, (tuple_7){{reading_.u_, reading_.load_}}, dt_, counted_, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}});
    } else {
        process_model_propagate_4(z_, phi_, (tuple_7){{reading_.u_, reading_.load_}}, dt_, counted_, p_);
    }
    if (((p_.p[37] > (real)0.0))) {
        p_.p[5] = motor_;
        p_.p[15] = arm_;
    }
    int64_t t18 = (at_z_ + 6);
    int64_t t19 = gm_bound(at_z_, record_.n[0]);
    int64_t t20 = gm_bound(t18, record_.n[0]);
    int64_t t21 = gm_span(t19, t20);
    linalg_carry_3(phi_, P_, (array1_f8){record_.p + t19 * (1), {t21}}, cross_, P_pred_);
    for (int64_t k22 = 0; k22 < 6; k22 += 1) {
        i_ = k22;
        real t25 = P_pred_.p[(((i_ * 6) + i_))];
        real t24 = ((real)0.5 * dt_);
        real t23 = process_model_noise(z_, p_, i_);
        P_pred_.p[(((i_ * 6) + i_))] = (t25 + (t24 * t23));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    return;
}

/* estimation/filters/ekf.py:88 update */
GM_INLINE bool ekf_update_3(Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
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
    tuple_9 row_;
    int64_t j_;
    real value_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_6 t1 = step_record_places(6);
    at_prior_ = t1.v[1];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    at_K_ = t1.v[7];
    at_scores_ = t1.v[8];
    int64_t t2 = (at_prior_ + 36);
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
    real t12 = (prior_.p[7] + r2_);
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
        tuple_15 t13 = ekf_inverse(s11_, s12_, s22_, determinant_);
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
    for (int64_t k15 = 0; k15 < 6; k15 += 1) {
        i_ = k15;
        real t16 = prior_.p[((i_ * 6))];
        real t17 = prior_.p[(((i_ * 6) + 1))];
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
        tuple_9 t20 = ekf_joseph(i_, (tuple_7){{k1_, k2_}}, (tuple_7){{c1_, c2_}}, (tuple_15){{prior_.p[0], prior_.p[1], prior_.p[7]}}, (tuple_7){{r1_, r2_}});
        row_ = t20;
        int64_t t21 = (i_ + 1);
        for (int64_t k22 = 0; k22 < t21; k22 += 1) {
            j_ = k22;
            real t23 = ekf_joseph_element(i_, prior_.p[(((i_ * 6) + j_))], row_, (tuple_7){{prior_.p[(j_)], prior_.p[((6 + j_))]}}, (tuple_7){{record_.p[((at_K_ + (2 * j_)))], record_.p[(((at_K_ + (2 * j_)) + 1))]}});
            value_ = t23;
            P_.p[(((i_ * 6) + j_))] = value_;
            P_.p[(((j_ * 6) + i_))] = value_;
            record_.p[(((at_P_ + (i_ * 6)) + j_))] = value_;
            record_.p[(((at_P_ + (j_ * 6)) + i_))] = value_;
        }
    }
    return true;
}

/* estimation/process_model.py:356 bound_curve */
GM_INLINE void process_model_bound_curve_3(array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count_2(0);
    count_ = t1;
    if (((count_ > 1))) {
        at_ = (6 - count_);
        z_.p[gm_at((at_ + 1), z_.n[0])] = gm_min_f(gm_max_f(z_.p[gm_at((at_ + 1), z_.n[0])], (p_.p[9] / (real)10.0)), (p_.p[9] * (real)10.0));
        z_.p[gm_at((at_ + 2), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 2), z_.n[0])], (real)0.0);
        if (((p_.p[12] > (real)0.0))) {
            z_.p[gm_at((at_ + 3), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 3), z_.n[0])], (real)0.0);
        }
    }
    return;
}

/* estimation/filters/ekf.py:208 healthy */
GM_INLINE bool ekf_healthy_3(Belief belief_)
{
    array1_f8 z_;
    array1_f8 P_;
    int64_t i_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        if ((!(((bool)isfinite(z_.p[(i_)]) && ((P_.p[(((i_ * 6) + i_))] > (real)0.0))) && (bool)isfinite(P_.p[(((i_ * 6) + i_))])))) {
            return false;
        }
    }
    return true;
}

/* estimation/filters/ekf.py:30 step */
GM_APART bool ekf_step_3(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    ekf_predict_3(belief_, reading_, p_, scratch_, record_);
    bool t1 = ekf_update_3(belief_, reading_.y1_, reading_.y2_, p_, record_);
    if ((!t1)) {
        return false;
    }
    process_model_bound_curve_3(belief_.z_, p_);
    bool t2 = ekf_healthy_3(belief_);
    return t2;
}

/* estimation/process_model.py:210 _curve */
GM_INLINE tuple_9 process_model_curve_4(int64_t curve_, array1_f8 z_, int64_t width_, int64_t i_, int64_t at_, tuple_18 p_)
{
    int64_t count_;
    if (((curve_ < 0))) {
        return (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    }
    int64_t t1 = process_model_curve_count_2(curve_);
    count_ = t1;
    if (((count_ > 1))) {
        return (tuple_9){{z_.p[gm_at((((at_ + 1) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 2) * width_) + i_), z_.n[0])], z_.p[gm_at((((at_ + 3) * width_) + i_), z_.n[0])], p_.v[12]}};
    }
    return (tuple_9){{p_.v[9], (p_.v[9] * p_.v[10]), (((count_ > 0)) ? (p_.v[9] * p_.v[11]) : (real)0.0), p_.v[12]}};
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations_7(tuple_8 x_, real u_, real load_, tuple_18 p_)
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
    real t1 = drive_motor_acceleration_2(x1_, x3_, x4_, u_, tau_k_, p_);
    real t2 = drive_arm_acceleration_2(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t1, t2}};
}

/* estimation/process_model.py:618 _stage */
GM_INLINE void process_model_stage_5(array1_f8 lanes_, int64_t width_, int64_t q_, real part_, bool differ_, tuple_15 torques_, tuple_18 shared_)
{
    array1_f8 z_;
    int64_t at_curve_;
    int64_t i_;
    real u_;
    tuple_18 drive_;
    tuple_9 law_;
    real memory_;
    int64_t at_;
    tuple_8 x_;
    int64_t last_;
    real x3_;
    real x4_;
    real f_;
    real g_;
    z_ = lanes_;
    int64_t t1 = process_model_curve_count_2(0);
    at_curve_ = ((6 - t1) * 16);
    for (int64_t k2 = 0; k2 < width_; k2 += 1) {
        i_ = k2;
        tuple_19 t3 = process_model_own_drive(differ_, z_, (432 + i_), torques_, shared_);
        u_ = t3.f0;
        drive_ = t3.f1;
        int64_t t4 = process_model_curve_count_2(0);
        tuple_9 t5 = process_model_curve_4(0, z_, 16, i_, (6 - t4), drive_);
        law_ = t5;
        real t6 = process_model_memory_2(0, z_, (at_curve_ + i_), (z_.p[((0 + i_))] - z_.p[((16 + i_))]));
        memory_ = t6;
        at_ = (((6 + q_) * 16) + i_);
        x_ = (tuple_8){{z_.p[((0 + i_))], z_.p[((16 + i_))], z_.p[((32 + i_))], z_.p[((48 + i_))], z_.p[((64 + i_))]}};
        if (((q_ > 0))) {
            last_ = (at_ - 16);
            real t7 = z_.p[gm_at((last_ + 0), z_.n[0])];
            real t8 = z_.p[gm_at((last_ + 64), z_.n[0])];
            x3_ = t7;
            x4_ = t8;
            x_ = (tuple_8){{(x_.v[0] + (part_ * x3_)), (x_.v[1] + (part_ * x4_)), (x_.v[2] + (part_ * z_.p[gm_at((last_ + 128), z_.n[0])])), (x_.v[3] + (part_ * z_.p[gm_at((last_ + 192), z_.n[0])])), (x_.v[4] + ((part_ * drive_.v[26]) * (x3_ - x4_)))}};
        }
        tuple_8 t9 = process_model_bearing_4(x_, (tuple_10){memory_, law_});
        tuple_7 t10 = process_model_accelerations_7(t9, (u_ - z_.p[((at_ + 256))]), z_.p[((416 + i_))], drive_);
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

/* estimation/process_model.py:658 _finish */
GM_INLINE void process_model_finish_3(array1_f8 lanes_, int64_t i_, real sixth_, tuple_18 p_)
{
    array1_f8 z_;
    int64_t at_;
    int64_t at_curve_;
    tuple_9 law_;
    real memory_;
    real moved1_;
    real moved2_;
    z_ = lanes_;
    int64_t t2 = (96 + i_);
    int64_t t1 = process_model_curve_count_2(0);
    int64_t t3 = (6 - t1);
    at_ = t2;
    at_curve_ = t3;
    tuple_9 t4 = process_model_curve_4(0, z_, 16, i_, at_curve_, p_);
    law_ = t4;
    real t5 = process_model_memory_2(0, z_, ((at_curve_ * 16) + i_), (real)0.0);
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
    int64_t t12 = process_model_curve_count_2(0);
    if (((t12 > 0))) {
        tuple_7 t13 = transmission_play((z_.p[((0 + i_))] - z_.p[((16 + i_))]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
        z_.p[gm_at(((at_curve_ * 16) + i_), z_.n[0])] = t13.v[0];
    }
    return;
}

/* estimation/process_model.py:567 advance_beside */
GM_STATIC void process_model_advance_beside_5(array1_f8 lanes_, int64_t count_, bool differ_, tuple_15 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    int64_t width_;
    real h_;
    int64_t friction_at_;
    real share_;
    tuple_18 drive_;
    int64_t i_;
    int64_t q_;
    tuple_8 error_;
    int64_t t1 = ((count_ + 3) & (-4));
    real t2 = (dt_ / (real)(n_substeps_));
    width_ = t1;
    h_ = t2;
    int64_t t3 = ((int64_t)(p_.p[29]) * 16);
    friction_at_ = t3;
    share_ = (((p_.p[28] > (real)0.0)) ? (real)1.0 : (real)0.0);
    drive_ = (tuple_18){{p_.p[0], p_.p[1], p_.p[2], p_.p[3], p_.p[4], p_.p[5], p_.p[6], p_.p[7], p_.p[8], p_.p[9], p_.p[10], p_.p[11], p_.p[12], p_.p[13], p_.p[14], p_.p[15], p_.p[16], p_.p[17], p_.p[18], p_.p[19], p_.p[20], p_.p[21], p_.p[22], p_.p[23], p_.p[24], p_.p[25], p_.p[26]}};
    for (int64_t k4 = 0; k4 < width_; k4 += 1) {
        i_ = k4;
        lanes_.p[((416 + i_))] = torques_.v[1];
        lanes_.p[((416 + i_))] = (lanes_.p[((416 + i_))] + (share_ * lanes_.p[((80 + i_))]));
        for (int64_t k5 = 0; k5 < 4; k5 += 1) {
            q_ = k5;
            lanes_.p[(((352 + (q_ * 16)) + i_))] = (real)0.0;
        }
    }
    for (int64_t k6 = 0; k6 < n_substeps_; k6 += 1) {
        if (((friction_at_ > 0))) {
            for (int64_t k7 = 0; k7 < width_; k7 += 1) {
                i_ = k7;
                tuple_8 t8 = process_model_decay(lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])], ((real)0.5 * h_), h_, p_);
                error_ = t8;
                for (int64_t k9 = 0; k9 < 4; k9 += 1) {
                    q_ = k9;
                    lanes_.p[(((352 + (q_ * 16)) + i_))] = error_.v[(q_)];
                }
                lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])] = error_.v[4];
            }
        }
        process_model_stage_5(lanes_, width_, 0, (real)0.0, differ_, torques_, drive_);
        process_model_stage_5(lanes_, width_, 1, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage_5(lanes_, width_, 2, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage_5(lanes_, width_, 3, h_, differ_, torques_, drive_);
        for (int64_t k10 = 0; k10 < width_; k10 += 1) {
            i_ = k10;
            process_model_finish_3(lanes_, i_, (h_ / (real)6.0), drive_);
        }
    }
    return;
}

/* estimation/consider.py:126 accompany */
GM_STATIC bool consider_accompany_3(Companions companions_, array1_f8 z_, Reading reading_, tuple_17 used_, array1_f8 record_)
{
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
    for (int64_t k2 = 0; k2 < 6; k2 += 1) {
        j_ = k2;
        for (int64_t k3 = 0; k3 < 16; k3 += 1) {
            i_ = k3;
            lanes_.p[(((j_ * 16) + i_))] = z_.p[(j_)];
        }
        for (int64_t k4 = 0; k4 < count_; k4 += 1) {
            i_ = k4;
            lanes_.p[((((j_ * 16) + 1) + i_))] = (lanes_.p[((((j_ * 16) + 1) + i_))] + s_.p[(((i_ * 6) + j_))]);
        }
    }
    int64_t t6 = (count_ + 1);
    int64_t t5 = drive_substeps(reading_.dt_, (p_.p[30] + faster_));
    process_model_advance_beside_5(lanes_, t6, true, (tuple_15){{reading_.u_, reading_.load_, rate_}}, reading_.dt_, t5, p_);
    tuple_6 t7 = step_record_places(6);
    at_K_ = t7.v[7];
    tuple_20 t8 = step_record_sensitivities(6, record_.n[0]);
    at_predicted_ = t8.v[1];
    at_updated_ = t8.v[2];
    good_ = true;
    for (int64_t k9 = 0; k9 < count_; k9 += 1) {
        i_ = k9;
        at_ = (i_ * 6);
        real t10 = (lanes_.p[((1 + i_))] - lanes_.p[0]);
        real t11 = (lanes_.p[((17 + i_))] - lanes_.p[16]);
        e1_ = t10;
        e2_ = t11;
        for (int64_t k12 = 0; k12 < 6; k12 += 1) {
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

/* estimation/process_model.py:298 torque_slopes */
GM_INLINE tuple_8 process_model_torque_slopes_4(array1_f8 z_, array1_f8 p_)
{
    int64_t at_;
    real twist_;
    int64_t t1 = process_model_curve_count_2(0);
    int64_t t2 = (6 - t1);
    real t3 = (z_.p[0] - z_.p[1]);
    at_ = t2;
    twist_ = t3;
    real t4 = process_model_memory_2(0, z_, at_, twist_);
    tuple_9 t5 = process_model_curve_3(0, z_, 1, 0, at_, p_);
    tuple_11 t6 = process_model_total_2(0, twist_, t4, t5, z_.p[4]);
    return t6.f1;
}

/* estimation/consider.py:191 variances_of */
GM_INLINE tuple_15 consider_variances_of_4(array1_f8 z_, array1_f8 record_, int64_t at_, array1_f8 p_)
{
    int64_t count_;
    real late_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    tuple_8 slopes_;
    int64_t c_;
    int64_t of_c_;
    real twist_;
    real rate_;
    real torque_;
    int64_t i_;
    tuple_20 t1 = step_record_sensitivities(6, record_.n[0]);
    count_ = t1.v[0];
    late_ = (p_.p[34] * z_.p[3]);
    real t2 = (late_ * late_);
    of_twist_ = t2;
    of_rate_ = (real)0.0;
    of_torque_ = (real)0.0;
    tuple_8 t3 = process_model_torque_slopes_4(z_, p_);
    slopes_ = t3;
    for (int64_t k4 = 0; k4 < count_; k4 += 1) {
        c_ = k4;
        of_c_ = (at_ + (c_ * 6));
        real t5 = (record_.p[gm_at((of_c_ + 0), record_.n[0])] - record_.p[gm_at((of_c_ + 1), record_.n[0])]);
        real t6 = (record_.p[gm_at((of_c_ + 2), record_.n[0])] - record_.p[gm_at((of_c_ + 3), record_.n[0])]);
        twist_ = t5;
        rate_ = t6;
        torque_ = record_.p[gm_at((of_c_ + 4), record_.n[0])];
        torque_ = (torque_ + (slopes_.v[0] * twist_));
        int64_t t7 = process_model_curve_count_2(0);
        for (int64_t k8 = 0; k8 < t7; k8 += 1) {
            i_ = k8;
            real t12 = torque_;
            real t11 = slopes_.v[((1 + i_))];
            int64_t t10 = (of_c_ + 6);
            int64_t t9 = process_model_curve_count_2(0);
            torque_ = (t12 + (t11 * record_.p[gm_at(((t10 - t9) + i_), record_.n[0])]));
        }
        of_twist_ = (of_twist_ + (twist_ * twist_));
        of_rate_ = (of_rate_ + (rate_ * rate_));
        of_torque_ = (of_torque_ + (torque_ * torque_));
    }
    return (tuple_15){{of_twist_, of_rate_, of_torque_}};
}

/* estimation/process_model.py:246 torque_of */
GM_INLINE tuple_7 process_model_torque_of_4(array1_f8 z_, array1_f8 P_, array1_f8 p_)
{
    int64_t at_;
    real twist_;
    real tau_k_;
    tuple_8 slopes_;
    real variance_;
    int64_t i_;
    int64_t row_;
    real on_others_;
    int64_t j_;
    int64_t t1 = process_model_curve_count_2(0);
    at_ = (6 - t1);
    twist_ = (z_.p[0] - z_.p[1]);
    real t2 = process_model_memory_2(0, z_, at_, twist_);
    tuple_9 t3 = process_model_curve_3(0, z_, 1, 0, at_, p_);
    tuple_11 t4 = process_model_total_2(0, twist_, t2, t3, z_.p[4]);
    tau_k_ = t4.f0;
    slopes_ = t4.f1;
    variance_ = ((P_.p[28] + ((slopes_.v[0] * slopes_.v[0]) * ((P_.p[0] + P_.p[7]) - ((real)2.0 * P_.p[1])))) + (((real)2.0 * slopes_.v[0]) * (P_.p[4] - P_.p[10])));
    int64_t t5 = process_model_curve_count_2(0);
    for (int64_t k6 = 0; k6 < t5; k6 += 1) {
        i_ = k6;
        row_ = ((at_ + i_) * 6);
        on_others_ = (P_.p[gm_at((row_ + 4), P_.n[0])] + (slopes_.v[0] * (P_.p[gm_at((row_ + 0), P_.n[0])] - P_.p[gm_at((row_ + 1), P_.n[0])])));
        for (int64_t k7 = 0; k7 < i_; k7 += 1) {
            j_ = k7;
            on_others_ = (on_others_ + (slopes_.v[((1 + j_))] * P_.p[gm_at(((row_ + at_) + j_), P_.n[0])]));
        }
        variance_ = (variance_ + (slopes_.v[((1 + i_))] * (((real)2.0 * on_others_) + (slopes_.v[((1 + i_))] * P_.p[gm_at(((row_ + at_) + i_), P_.n[0])]))));
    }
    return (tuple_7){{tau_k_, gm_max_f(variance_, (real)0.0)}};
}

/* estimation/sample_loop.py:515 _write_estimate */
GM_STATIC void sample_loop_write_estimate_3(Belief belief_, array1_f8 record_, Reading reading_, array1_f8 p_, real share_, array1_f8 row_)
{
    array1_f8 z_;
    array1_f8 P_;
    int64_t at_s_;
    int64_t i_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t at_scores_;
    real e1_;
    real e2_;
    real s11_;
    real s12_;
    real s22_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_20 t1 = step_record_sensitivities(6, record_.n[0]);
    at_s_ = t1.v[2];
    for (int64_t k2 = 0; k2 < 7; k2 += 1) {
        i_ = k2;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
        row_.p[gm_at((7 + i_), row_.n[0])] = NAN;
    }
    for (int64_t k3 = 0; k3 < 4; k3 += 1) {
        i_ = k3;
        row_.p[gm_at(i_, row_.n[0])] = z_.p[gm_at(i_, z_.n[0])];
        real t5 = P_.p[gm_at(((i_ * 6) + i_), P_.n[0])];
        real t4 = consider_variance_of_2(6, record_, at_s_, i_);
        row_.p[gm_at((7 + i_), row_.n[0])] = gm_sqrt((t5 + t4));
    }
    tuple_15 t6 = consider_variances_of_4(z_, record_, at_s_, p_);
    of_twist_ = t6.v[0];
    of_rate_ = t6.v[1];
    of_torque_ = t6.v[2];
    tuple_7 t7 = process_model_torque_of_4(z_, P_, p_);
    row_.p[4] = t7.v[0];
    variance_ = t7.v[1];
    row_.p[37] = gm_sqrt(variance_);
    tuple_7 t8 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[4], variance_}}, p_);
    row_.p[39] = gm_sqrt(gm_max_f(t8.v[1], (real)0.0));
    row_.p[11] = gm_sqrt((((share_ * variance_) + of_torque_) + (p_.p[33] * p_.p[33])));
    row_.p[40] = NAN;
    row_.p[41] = NAN;
    for (int64_t k9 = 31; k9 < 37; k9 += 1) {
        i_ = k9;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
    }
    int64_t t10 = process_model_curve_count_2(0);
    if (((t10 > 1))) {
        real t11 = z_.p[3];
        real t12 = gm_sqrt(P_.p[21]);
        row_.p[31] = t11;
        row_.p[34] = t12;
        tuple_7 t13 = process_model_learned_length(z_, P_, 6, 4);
        row_.p[32] = t13.v[0];
        row_.p[35] = t13.v[1];
        tuple_7 t14 = process_model_learned_length(z_, P_, 6, 5);
        row_.p[33] = t14.v[0];
        row_.p[36] = t14.v[1];
    }
    if (((p_.p[28] > (real)0.0))) {
        i_ = (int64_t)(p_.p[28]);
        row_.p[5] = (z_.p[gm_at(i_, z_.n[0])] + reading_.load_);
        real t16 = P_.p[gm_at(((i_ * 6) + i_), P_.n[0])];
        real t15 = consider_variance_of_2(6, record_, at_s_, i_);
        row_.p[12] = gm_sqrt((t16 + t15));
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        row_.p[6] = z_.p[gm_at(i_, z_.n[0])];
        real t18 = P_.p[gm_at(((i_ * 6) + i_), P_.n[0])];
        real t17 = consider_variance_of_2(6, record_, at_s_, i_);
        row_.p[13] = gm_sqrt((t18 + t17));
    }
    row_.p[14] = (z_.p[0] - z_.p[1]);
    row_.p[15] = (z_.p[2] - z_.p[3]);
    row_.p[16] = gm_sqrt((gm_max_f(((P_.p[0] + P_.p[7]) - ((real)2.0 * P_.p[1])), (real)0.0) + of_twist_));
    row_.p[17] = gm_sqrt((gm_max_f(((P_.p[14] + P_.p[21]) - ((real)2.0 * P_.p[15])), (real)0.0) + of_rate_));
    tuple_6 t19 = step_record_places(6);
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
GM_STATIC void rts_smoother_write_4(array1_f8 z_, array1_f8 P_, array1_f8 p_, array1_f8 record_, array1_f8 row_)
{
    int64_t at_smoothed_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    real noise_;
    tuple_20 t1 = step_record_sensitivities(6, record_.n[0]);
    at_smoothed_ = t1.v[3];
    tuple_15 t2 = consider_variances_of_4(z_, record_, at_smoothed_, p_);
    of_twist_ = t2.v[0];
    of_rate_ = t2.v[1];
    of_torque_ = t2.v[2];
    row_.p[0] = (z_.p[0] - z_.p[1]);
    row_.p[1] = (z_.p[2] - z_.p[3]);
    tuple_7 t3 = process_model_torque_of_4(z_, P_, p_);
    row_.p[2] = t3.v[0];
    variance_ = t3.v[1];
    noise_ = gm_max_f(((P_.p[0] + P_.p[7]) - ((real)2.0 * P_.p[1])), (real)0.0);
    real t4 = gm_sqrt(noise_);
    real t5 = gm_sqrt((noise_ + of_twist_));
    row_.p[10] = t4;
    row_.p[3] = t5;
    noise_ = gm_max_f(((P_.p[14] + P_.p[21]) - ((real)2.0 * P_.p[15])), (real)0.0);
    row_.p[11] = gm_sqrt(noise_);
    row_.p[4] = gm_sqrt((noise_ + of_rate_));
    row_.p[12] = gm_sqrt(gm_max_f(variance_, (real)0.0));
    row_.p[5] = gm_sqrt(((gm_max_f(variance_, (real)0.0) + of_torque_) + (p_.p[33] * p_.p[33])));
    tuple_7 t6 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[2], variance_}}, p_);
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
GM_STATIC bool linalg_solve_positive_4(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t j_;
    real s_;
    int64_t k_;
    real inverse_;
    int64_t i_;
    tuple_21 row_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        j_ = k1;
        s_ = a_.p[(((j_ * 6) + j_))];
        for (int64_t k2 = 0; k2 < j_; k2 += 1) {
            k_ = k2;
            s_ = (s_ - (a_.p[(((j_ * 6) + k_))] * a_.p[(((j_ * 6) + k_))]));
        }
        if ((!((s_ > (real)0.0)))) {
            return false;
        }
        inverse_ = ((real)1.0 / gm_sqrt(s_));
        a_.p[(((j_ * 6) + j_))] = inverse_;
        int64_t t3 = (j_ + 1);
        for (int64_t k4 = t3; k4 < 6; k4 += 1) {
            i_ = k4;
            s_ = a_.p[(((i_ * 6) + j_))];
            for (int64_t k5 = 0; k5 < j_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (a_.p[(((i_ * 6) + k_))] * a_.p[(((j_ * 6) + k_))]));
            }
            a_.p[(((i_ * 6) + j_))] = (s_ * inverse_);
        }
    }
    for (int64_t k6 = 0; k6 < 6; k6 += 1) {
        i_ = k6;
        tuple_21 t7 = linalg_added(6, (real)1.0, b_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t7;
        int64_t t8 = i_;
        for (int64_t k9 = 0; k9 < t8; k9 += 1) {
            k_ = k9;
            tuple_21 t10 = linalg_added(6, (-a_.p[(((i_ * 6) + k_))]), out_, (k_ * 6), row_);
            row_ = t10;
        }
        linalg_put(6, row_, out_, (i_ * 6));
        tuple_21 t11 = linalg_added(6, a_.p[(((i_ * 6) + i_))], out_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(6, t11, out_, (i_ * 6));
    }
    for (int64_t k12 = 5; k12 > (-1); k12 += -1) {
        i_ = k12;
        tuple_21 t13 = linalg_added(6, (real)1.0, out_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t13;
        int64_t t14 = (i_ + 1);
        for (int64_t k15 = t14; k15 < 6; k15 += 1) {
            k_ = k15;
            tuple_21 t16 = linalg_added(6, (-a_.p[(((k_ * 6) + i_))]), out_, (k_ * 6), row_);
            row_ = t16;
        }
        linalg_put(6, row_, out_, (i_ * 6));
        tuple_21 t17 = linalg_added(6, a_.p[(((i_ * 6) + i_))], out_, (i_ * 6), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(6, t17, out_, (i_ * 6));
    }
    return true;
}

/* kernels/linalg.py:22 multiply */
GM_INLINE void linalg_multiply_4(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t i_;
    real s0_;
    real s1_;
    real s2_;
    real s3_;
    real s4_;
    real s5_;
    real s6_;
    int64_t at_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        tuple_14 t2 = linalg_row_2(6, (-1), a_, i_, b_);
        s0_ = t2.v[0];
        s1_ = t2.v[1];
        s2_ = t2.v[2];
        s3_ = t2.v[3];
        s4_ = t2.v[4];
        s5_ = t2.v[5];
        s6_ = t2.v[6];
        at_ = (i_ * 6);
        out_.p[(at_)] = s0_;
        out_.p[((at_ + 1))] = s1_;
        out_.p[((at_ + 2))] = s2_;
        out_.p[((at_ + 3))] = s3_;
        out_.p[((at_ + 4))] = s4_;
        out_.p[((at_ + 5))] = s5_;
    }
    return;
}

/* kernels/linalg.py:304 transposed_multiply_symmetric */
GM_INLINE void linalg_transposed_multiply_symmetric_4(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t i_;
    tuple_21 row_;
    int64_t k_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 6; k1 += 1) {
        i_ = k1;
        row_ = (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        for (int64_t k2 = 0; k2 < 6; k2 += 1) {
            k_ = k2;
            tuple_21 t3 = linalg_added(6, a_.p[(((k_ * 6) + i_))], b_, (k_ * 6), row_);
            row_ = t3;
        }
        linalg_put(6, row_, out_, (i_ * 6));
    }
    for (int64_t k4 = 0; k4 < 6; k4 += 1) {
        i_ = k4;
        int64_t t5 = i_;
        for (int64_t k6 = 0; k6 < t5; k6 += 1) {
            j_ = k6;
            out_.p[(((j_ * 6) + i_))] = out_.p[(((i_ * 6) + j_))];
        }
    }
    return;
}

/* kernels/linalg.py:293 add_product */
GM_INLINE void linalg_add_product_4(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t at_;
    tuple_21 row_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < out_.n[0]; k1 += 6) {
        at_ = k1;
        tuple_21 t2 = linalg_added(6, (real)1.0, out_, at_, (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < 6; k3 += 1) {
            k_ = k3;
            tuple_21 t4 = linalg_added(6, a_.p[((at_ + k_))], b_, (k_ * 6), row_);
            row_ = t4;
        }
        linalg_put(6, row_, out_, at_);
    }
    return;
}

/* estimation/rts_smoother.py:60 smooth */
GM_STATIC void rts_smoother_smooth_4(array2_f8 ring_, Span span_, array1_f8 p_, array1_f8 z_, array2_f8 matrices_, array2_f8 out_)
{
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
    rows_ = ring_.n[0];
    newest_ = span_.newest_;
    oldest_ = span_.oldest_;
    keep_until_ = span_.keep_until_;
    P_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    gain_t_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    factor_ = (array1_f8){matrices_.p + 2 * (matrices_.n[1]), {matrices_.n[1]}};
    change_ = (array1_f8){matrices_.p + 3 * (matrices_.n[1]), {matrices_.n[1]}};
    product_ = (array1_f8){matrices_.p + 4 * (matrices_.n[1]), {matrices_.n[1]}};
    tuple_6 t1 = step_record_places(6);
    at_pred_ = t1.v[0];
    at_P_pred_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    tuple_20 t2 = step_record_sensitivities(6, ring_.n[1]);
    count_ = t2.v[0];
    at_s_pred_ = t2.v[1];
    at_s_ = t2.v[2];
    at_smoothed_ = t2.v[3];
    last_ = (array1_f8){ring_.p + (gm_mod(newest_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
    int64_t t3 = (6 * count_);
    for (int64_t k4 = 0; k4 < t3; k4 += 1) {
        i_ = k4;
        last_.p[gm_at((at_smoothed_ + i_), last_.n[0])] = last_.p[gm_at((at_s_ + i_), last_.n[0])];
    }
    for (int64_t k5 = 0; k5 < 6; k5 += 1) {
        i_ = k5;
        z_.p[(i_)] = last_.p[((at_z_ + i_))];
    }
    for (int64_t k6 = 0; k6 < 36; k6 += 1) {
        i_ = k6;
        P_.p[(i_)] = last_.p[((at_P_ + i_))];
    }
    if (((newest_ <= keep_until_))) {
        rts_smoother_write_4(z_, P_, p_, last_, (array1_f8){out_.p + gm_at((newest_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
    }
    int64_t t7 = (newest_ - 1);
    int64_t t8 = (oldest_ - 1);
    for (int64_t k9 = t7; k9 > t8; k9 += -1) {
        k_ = k9;
        record_ = (array1_f8){ring_.p + (gm_mod(k_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        later_ = (array1_f8){ring_.p + (gm_mod((k_ + 1), rows_)) * (ring_.n[1]), {ring_.n[1]}};
        for (int64_t k10 = 0; k10 < 36; k10 += 1) {
            i_ = k10;
            factor_.p[(i_)] = later_.p[((at_P_pred_ + i_))];
            change_.p[(i_)] = (P_.p[(i_)] - later_.p[((at_P_pred_ + i_))]);
        }
        int64_t t11 = (at_cross_ + 36);
        int64_t t12 = gm_bound(at_cross_, later_.n[0]);
        int64_t t13 = gm_bound(t11, later_.n[0]);
        int64_t t14 = gm_span(t12, t13);
        bool t15 = linalg_solve_positive_4(factor_, (array1_f8){later_.p + t12 * (1), {t14}}, gain_t_);
        if (t15) {
            for (int64_t k16 = 0; k16 < 6; k16 += 1) {
                i_ = k16;
                z_.p[(i_)] = (z_.p[(i_)] - later_.p[((at_pred_ + i_))]);
            }
            linalg_multiply_4(change_, gain_t_, product_);
            linalg_transposed_multiply_symmetric_4(gain_t_, product_, P_);
            for (int64_t k17 = 0; k17 < 36; k17 += 1) {
                i_ = k17;
                P_.p[(i_)] = (P_.p[(i_)] + record_.p[((at_P_ + i_))]);
            }
            for (int64_t k18 = 0; k18 < 6; k18 += 1) {
                i_ = k18;
                s_ = record_.p[((at_z_ + i_))];
                for (int64_t k19 = 0; k19 < 6; k19 += 1) {
                    m_ = k19;
                    s_ = (s_ + (gain_t_.p[(((m_ * 6) + i_))] * z_.p[(m_)]));
                }
                product_.p[(i_)] = s_;
            }
            for (int64_t k20 = 0; k20 < 6; k20 += 1) {
                i_ = k20;
                z_.p[(i_)] = product_.p[(i_)];
            }
            int64_t t21 = (at_smoothed_ + (6 * count_));
            int64_t t22 = gm_bound(at_smoothed_, later_.n[0]);
            int64_t t23 = gm_bound(t21, later_.n[0]);
            int64_t t24 = gm_span(t22, t23);
            change_s_ = (array1_f8){later_.p + t22 * (1), {t24}};
            int64_t t25 = (6 * count_);
            for (int64_t k26 = 0; k26 < t25; k26 += 1) {
                i_ = k26;
                change_s_.p[(i_)] = (change_s_.p[(i_)] - later_.p[((at_s_pred_ + i_))]);
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            int64_t t27 = (at_smoothed_ + (6 * count_));
            int64_t t28 = gm_bound(at_smoothed_, record_.n[0]);
            int64_t t29 = gm_bound(t27, record_.n[0]);
            int64_t t30 = gm_span(t28, t29);
            linalg_add_product_4(change_s_, gain_t_, (array1_f8){record_.p + t28 * (1), {t30}});
        } else {
            int64_t t31 = (6 * count_);
            for (int64_t k32 = 0; k32 < t31; k32 += 1) {
                i_ = k32;
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            for (int64_t k33 = 0; k33 < 6; k33 += 1) {
                i_ = k33;
                z_.p[(i_)] = record_.p[((at_z_ + i_))];
            }
            for (int64_t k34 = 0; k34 < 36; k34 += 1) {
                i_ = k34;
                P_.p[(i_)] = record_.p[((at_P_ + i_))];
            }
        }
        if (((k_ <= keep_until_))) {
            rts_smoother_write_4(z_, P_, p_, record_, (array1_f8){out_.p + gm_at((k_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
        }
    }
    return;
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_ekf_3(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(6);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start_3(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described_3(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim_3(belief_, reading_, p_);
        }
        bool t22 = ekf_step_3(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany_3(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate_3(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_4(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/process_model.py:336 begin_curve */
GM_INLINE void process_model_begin_curve_4(array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count_2(4);
    count_ = t1;
    at_ = (10 - count_);
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

/* estimation/sample_loop.py:385 start */
GM_STATIC void sample_loop_start_4(Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
    array1_f8 z_;
    array1_f8 P_;
    bool have1_;
    bool have2_;
    int64_t i_;
    int64_t j_;
    int64_t at_z_;
    int64_t at_P_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    bool t1 = (bool)isfinite(y1_);
    bool t2 = (bool)isfinite(y2_);
    have1_ = t1;
    have2_ = t2;
    for (int64_t k3 = 0; k3 < 10; k3 += 1) {
        i_ = k3;
        z_.p[(i_)] = (real)0.0;
        for (int64_t k4 = 0; k4 < 10; k4 += 1) {
            j_ = k4;
            P_.p[(((i_ * 10) + j_))] = (((i_ == j_)) ? p_.p[((63 + i_))] : (real)0.0);
        }
    }
    z_.p[0] = (have1_ ? y1_ : y2_);
    z_.p[1] = (have2_ ? y2_ : y1_);
    if ((!have1_)) {
        P_.p[0] = (real)100.0;
    }
    if ((!have2_)) {
        P_.p[11] = (real)100.0;
    }
    process_model_begin_curve_4(z_, p_);
    tuple_6 t5 = step_record_places(10);
    at_z_ = t5.v[3];
    at_P_ = t5.v[4];
    for (int64_t k6 = 0; k6 < 10; k6 += 1) {
        i_ = k6;
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    for (int64_t k7 = 0; k7 < 100; k7 += 1) {
        i_ = k7;
        record_.p[((at_P_ + i_))] = P_.p[(i_)];
    }
    int64_t t8 = step_record_record_size_2(10, 0);
    int64_t t9 = (t8 - 1);
    int64_t t10 = gm_bound(t9, record_.n[0]);
    int64_t t11 = gm_bound((-1), record_.n[0]);
    int64_t t12 = gm_span(t10, t11);
    array1_f8 t13 = (array1_f8){record_.p + t10 * (1), {t12}};
    for (int64_t k14 = 0; k14 < t13.n[0]; k14++)
        t13.p[k14 * (1)] = (real)0.0;
    return;
}

/* estimation/sample_loop.py:267 _described */
GM_INLINE real sample_loop_described_4(DescribedLoad described_, real measured_, array1_f8 row_, tuple_43 at_, LoopState state_, Belief belief_, array1_f8 p_)
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
        p_.p[1] = ((real)1.0 / inertia_);
        p_.p[30] = (described_.eigenvalue_ * gm_max_f((real)1.0, (described_.inertia_ / inertia_)));
    }
    efforts_.p[((place_) * efforts_.n[1] + 1)] = load_;
    return load_;
}

/* estimation/sample_loop.py:441 aim */
GM_INLINE void sample_loop_aim_4(Belief belief_, Reading reading_, array1_f8 p_)
{
    array1_f8 z_;
    array1_f8 P_;
    real dt_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    real t1 = sample_loop_first_speed((reading_.y1_ - z_.p[0]), dt_, (P_.p[0] + p_.p[31]), P_.p[22]);
    z_.p[2] = t1;
    real t2 = sample_loop_first_speed((reading_.y2_ - z_.p[1]), dt_, (P_.p[11] + p_.p[32]), P_.p[33]);
    z_.p[3] = t2;
    return;
}

/* estimation/process_model.py:547 _bearing */
GM_INLINE tuple_8 process_model_bearing_5(tuple_8 x_, tuple_10 elastic_)
{
    real tau_k_;
    tuple_11 t1 = process_model_total_2(4, (x_.v[0] - x_.v[1]), elastic_.f0, elastic_.f1, x_.v[4]);
    tau_k_ = t1.f0;
    return (tuple_8){{x_.v[0], x_.v[1], x_.v[2], x_.v[3], tau_k_}};
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations_8(tuple_8 x_, real u_, real load_, array1_f8 p_)
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
    real t1 = drive_motor_acceleration(x1_, x3_, x4_, u_, tau_k_, p_);
    real t2 = drive_arm_acceleration(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t1, t2}};
}

/* estimation/process_model.py:520 _advanced */
GM_INLINE tuple_8 process_model_advanced_5(tuple_8 x_, tuple_10 elastic_, tuple_9 error_, tuple_7 torques_, real h_, array1_f8 p_)
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
    tuple_8 y_;
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
    tuple_8 t3 = process_model_bearing_5(x_, elastic_);
    tuple_7 t4 = process_model_accelerations_8(t3, (u_ - error_.v[0]), load_, p_);
    f1_ = t4.v[0];
    g1_ = t4.v[1];
    real t5 = (x3_ + (half_ * f1_));
    real t6 = (x4_ + (half_ * g1_));
    b3_ = t5;
    b4_ = t6;
    y_ = (tuple_8){{(x1_ + (half_ * x3_)), (x2_ + (half_ * x4_)), b3_, b4_, (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)))}};
    tuple_8 t7 = process_model_bearing_5(y_, elastic_);
    tuple_7 t8 = process_model_accelerations_8(t7, (u_ - error_.v[1]), load_, p_);
    f2_ = t8.v[0];
    g2_ = t8.v[1];
    real t9 = (x3_ + (half_ * f2_));
    real t10 = (x4_ + (half_ * g2_));
    c3_ = t9;
    c4_ = t10;
    y_ = (tuple_8){{(x1_ + (half_ * b3_)), (x2_ + (half_ * b4_)), c3_, c4_, (tau_k_ + ((half_ * p_.p[26]) * (b3_ - b4_)))}};
    tuple_8 t11 = process_model_bearing_5(y_, elastic_);
    tuple_7 t12 = process_model_accelerations_8(t11, (u_ - error_.v[2]), load_, p_);
    f3_ = t12.v[0];
    g3_ = t12.v[1];
    real t13 = (x3_ + (h_ * f3_));
    real t14 = (x4_ + (h_ * g3_));
    d3_ = t13;
    d4_ = t14;
    y_ = (tuple_8){{(x1_ + (h_ * c3_)), (x2_ + (h_ * c4_)), d3_, d4_, (tau_k_ + ((h_ * p_.p[26]) * (c3_ - c4_)))}};
    tuple_8 t15 = process_model_bearing_5(y_, elastic_);
    tuple_7 t16 = process_model_accelerations_8(t15, (u_ - error_.v[3]), load_, p_);
    f4_ = t16.v[0];
    g4_ = t16.v[1];
    moved1_ = (sixth_ * ((x3_ + ((real)2.0 * (b3_ + c3_))) + d3_));
    moved2_ = (sixth_ * ((x4_ + ((real)2.0 * (b4_ + c4_))) + d4_));
    return (tuple_8){{(x1_ + moved1_), (x2_ + moved2_), (x3_ + (sixth_ * ((f1_ + ((real)2.0 * (f2_ + f3_))) + f4_))), (x4_ + (sixth_ * ((g1_ + ((real)2.0 * (g2_ + g3_))) + g4_))), (tau_k_ + (p_.p[26] * (moved1_ - moved2_)))}};
}

/* estimation/process_model.py:499 _advance_one */
GM_INLINE void process_model_advance_one_5(array1_f8 z_, tuple_7 torques_, real h_, array1_f8 p_)
{
    real u_;
    real load_;
    int64_t at_curve_;
    tuple_8 error_;
    tuple_8 x_;
    tuple_9 law_;
    real memory_;
    u_ = torques_.v[0];
    load_ = torques_.v[1];
    int64_t t1 = process_model_curve_count_2(4);
    at_curve_ = (10 - t1);
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t2 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], ((real)0.5 * h_), h_, p_);
        error_ = t2;
        z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])] = error_.v[4];
    }
    x_ = (tuple_8){{z_.p[0], z_.p[1], z_.p[2], z_.p[3], z_.p[4]}};
    tuple_9 t3 = process_model_curve_3(4, z_, 1, 0, at_curve_, p_);
    law_ = t3;
    real t4 = process_model_memory_2(4, z_, at_curve_, (x_.v[0] - x_.v[1]));
    memory_ = t4;
    tuple_8 t5 = process_model_advanced_5(x_, (tuple_10){memory_, law_}, (tuple_9){{error_.v[0], error_.v[1], error_.v[2], error_.v[3]}}, (tuple_7){{u_, load_}}, h_, p_);
    x_ = t5;
    int64_t t6 = process_model_curve_count_2(4);
    if (((t6 > 0))) {
        tuple_7 t7 = transmission_play((x_.v[0] - x_.v[1]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
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
GM_STATIC void process_model_advance_5(array1_f8 z_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (dt_ / (real)(n_substeps_));
    for (int64_t k1 = 0; k1 < n_substeps_; k1 += 1) {
        process_model_advance_one_5(z_, torques_, h_, p_);
    }
    return;
}

/* estimation/process_model.py:1044 propagate_numeric */
GM_STATIC void process_model_propagate_numeric_4(array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_, array1_f8 start_)
{
    int64_t i_;
    int64_t j_;
    array1_f8 moved_;
    real step_;
    for (int64_t k1 = 0; k1 < 10; k1 += 1) {
        i_ = k1;
        start_.p[(i_)] = z_.p[(i_)];
    }
    process_model_advance_5(z_, torques_, dt_, n_substeps_, p_);
    for (int64_t k2 = 0; k2 < 10; k2 += 1) {
        j_ = k2;
        int64_t t3 = (j_ * 10);
        int64_t t4 = ((j_ + 1) * 10);
        int64_t t5 = gm_bound(t3, phi_.n[0]);
        int64_t t6 = gm_bound(t4, phi_.n[0]);
        int64_t t7 = gm_span(t5, t6);
        moved_ = (array1_f8){phi_.p + t5 * (1), {t7}};
        for (int64_t k8 = 0; k8 < 10; k8 += 1) {
            i_ = k8;
            moved_.p[(i_)] = start_.p[(i_)];
        }
        moved_.p[(j_)] = (moved_.p[(j_)] + ((real)1e-06 * gm_max_f((real)1.0, gm_fabs(start_.p[(j_)]))));
        step_ = (moved_.p[(j_)] - start_.p[(j_)]);
        process_model_advance_5(moved_, torques_, dt_, n_substeps_, p_);
        for (int64_t k9 = 0; k9 < 10; k9 += 1) {
            i_ = k9;
            moved_.p[(i_)] = ((moved_.p[(i_)] - z_.p[(i_)]) / step_);
        }
    }
    for (int64_t k10 = 0; k10 < 10; k10 += 1) {
        i_ = k10;
        int64_t t11 = i_;
        for (int64_t k12 = 0; k12 < t11; k12 += 1) {
            j_ = k12;
            real t13 = phi_.p[(((j_ * 10) + i_))];
            real t14 = phi_.p[(((i_ * 10) + j_))];
            phi_.p[(((i_ * 10) + j_))] = t13;
            phi_.p[(((j_ * 10) + i_))] = t14;
        }
    }
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row_8(array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t count_;
    int64_t t1 = process_model_curve_count_2(4);
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (10 - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((10 - count_) * 10) + j_), phi_.n[0])];
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_11(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
{
    real moved1_;
    real moved2_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[((0 + j_))] = (m_.v[0].v[0] + moved1_);
    phi_.p[((10 + j_))] = (m_.v[0].v[4] + moved2_);
    phi_.p[((20 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[((30 + j_))] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[((40 + j_))] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_7(array1_f8 phi_, int64_t j_, Stages stages_, tuple_9 errors_, tuple_7 sources_, array1_f8 p_)
{
    tuple_9 slopes_;
    tuple_9 shares_;
    tuple_13 arms_;
    tuple_12 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_8 m1_;
    tuple_8 c1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_8 c2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_8 c3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_8 c4_;
    tuple_7 r4_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_8(phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_8 t3 = process_model_begin(10, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_8 t5 = process_model_bent_2(4, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(false, arms_.v[0], load_, m1_);
    tuple_7 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_8 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_8 t10 = process_model_bent_2(4, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(false, arms_.v[1], load_, m2_);
    tuple_7 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_8 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_8 t15 = process_model_bent_2(4, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(false, arms_.v[2], load_, m3_);
    tuple_7 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_8 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_8 t20 = process_model_bent_2(4, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(false, arms_.v[3], load_, m4_);
    tuple_7 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_11(phi_, j_, h_, (tuple_12){{m1_, m2_, m3_, m4_}}, (tuple_13){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:860 _column_of_x2 */
GM_INLINE void process_model_column_of_x2_7(array1_f8 phi_, Stages stages_, array1_f8 p_)
{
    process_model_column_7(phi_, 1, stages_, (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}}, (tuple_7){{(real)0.0, (real)0.0}}, p_);
    return;
}

/* estimation/process_model.py:767 _memory_row */
GM_INLINE real process_model_memory_row_9(array1_f8 phi_, int64_t j_, bool first_)
{
    int64_t count_;
    int64_t t1 = process_model_curve_count_2(4);
    count_ = t1;
    if ((((count_ == 0)) || first_)) {
        return ((((count_ > 0)) && ((j_ == (10 - count_)))) ? (real)1.0 : (real)0.0);
    }
    return phi_.p[gm_at((((10 - count_) * 10) + j_), phi_.n[0])];
}

/* estimation/process_model.py:801 _end */
GM_INLINE void process_model_end_12(array1_f8 phi_, int64_t j_, real h_, tuple_12 m_, tuple_13 r_, array1_f8 p_)
{
    real moved1_;
    real moved2_;
    moved1_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[1] + m_.v[2].v[1]), (m_.v[0].v[1] + m_.v[3].v[1])));
    moved2_ = ((h_ / (real)6.0) * gm_fma((real)2.0, (m_.v[1].v[2] + m_.v[2].v[2]), (m_.v[0].v[2] + m_.v[3].v[2])));
    phi_.p[gm_at((0 + j_), phi_.n[0])] = (m_.v[0].v[0] + moved1_);
    phi_.p[gm_at((10 + j_), phi_.n[0])] = (m_.v[0].v[4] + moved2_);
    phi_.p[gm_at((20 + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[0] + r_.v[2].v[0]), (r_.v[0].v[0] + r_.v[3].v[0])), m_.v[0].v[1]);
    phi_.p[gm_at((30 + j_), phi_.n[0])] = gm_fma((h_ / (real)6.0), gm_fma((real)2.0, (r_.v[1].v[1] + r_.v[2].v[1]), (r_.v[0].v[1] + r_.v[3].v[1])), m_.v[0].v[2]);
    phi_.p[gm_at((40 + j_), phi_.n[0])] = (m_.v[0].v[3] + (p_.p[26] * (moved1_ - moved2_)));
    return;
}

/* estimation/process_model.py:827 _column */
GM_INLINE void process_model_column_8(array1_f8 phi_, int64_t j_, Stages stages_, tuple_9 errors_, tuple_7 sources_, array1_f8 p_)
{
    tuple_9 slopes_;
    tuple_9 shares_;
    tuple_13 arms_;
    tuple_12 bends_;
    real h_;
    bool first_;
    real load_;
    int64_t own_;
    real memory_;
    tuple_8 m1_;
    tuple_8 c1_;
    tuple_7 r1_;
    tuple_8 m2_;
    tuple_8 c2_;
    tuple_7 r2_;
    tuple_8 m3_;
    tuple_8 c3_;
    tuple_7 r3_;
    tuple_8 m4_;
    tuple_8 c4_;
    tuple_7 r4_;
    slopes_ = stages_.slopes_;
    shares_ = stages_.shares_;
    arms_ = stages_.arms_;
    bends_ = stages_.bends_;
    h_ = stages_.h_;
    first_ = stages_.first_;
    int64_t t2 = (int64_t)(sources_.v[1]);
    real t1 = process_model_memory_row_9(phi_, j_, first_);
    load_ = sources_.v[0];
    own_ = t2;
    memory_ = t1;
    tuple_8 t3 = process_model_begin_2(10, phi_, j_, first_);
    m1_ = t3;
    real t4 = process_model_source(bends_.v[0], memory_, own_);
    tuple_8 t5 = process_model_bent_2(4, bends_.v[0], t4, m1_);
    c1_ = t5;
    real t6 = process_model_answer(false, arms_.v[0], load_, m1_);
    tuple_7 t7 = process_model_rates(c1_, slopes_.v[0], shares_.v[0], errors_.v[0], t6, p_);
    r1_ = t7;
    tuple_8 t8 = process_model_along(m1_, ((real)0.5 * h_), m1_, r1_, p_);
    m2_ = t8;
    real t9 = process_model_source(bends_.v[1], memory_, own_);
    tuple_8 t10 = process_model_bent_2(4, bends_.v[1], t9, m2_);
    c2_ = t10;
    real t11 = process_model_answer(false, arms_.v[1], load_, m2_);
    tuple_7 t12 = process_model_rates(c2_, slopes_.v[1], shares_.v[1], errors_.v[1], t11, p_);
    r2_ = t12;
    tuple_8 t13 = process_model_along(m1_, ((real)0.5 * h_), m2_, r2_, p_);
    m3_ = t13;
    real t14 = process_model_source(bends_.v[2], memory_, own_);
    tuple_8 t15 = process_model_bent_2(4, bends_.v[2], t14, m3_);
    c3_ = t15;
    real t16 = process_model_answer(false, arms_.v[2], load_, m3_);
    tuple_7 t17 = process_model_rates(c3_, slopes_.v[2], shares_.v[2], errors_.v[2], t16, p_);
    r3_ = t17;
    tuple_8 t18 = process_model_along(m1_, h_, m3_, r3_, p_);
    m4_ = t18;
    real t19 = process_model_source(bends_.v[3], memory_, own_);
    tuple_8 t20 = process_model_bent_2(4, bends_.v[3], t19, m4_);
    c4_ = t20;
    real t21 = process_model_answer(false, arms_.v[3], load_, m4_);
    tuple_7 t22 = process_model_rates(c4_, slopes_.v[3], shares_.v[3], errors_.v[3], t21, p_);
    r4_ = t22;
    process_model_end_12(phi_, j_, h_, (tuple_12){{m1_, m2_, m3_, m4_}}, (tuple_13){{r1_, r2_, r3_, r4_}}, p_);
    return;
}

/* estimation/process_model.py:995 _columns_of_curve */
GM_INLINE void process_model_columns_of_curve_5(array1_f8 z_, array1_f8 phi_, real memory_, tuple_9 law_, Stages stages_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    tuple_9 none_;
    real width_;
    real end_;
    int64_t j_;
    int64_t t1 = process_model_curve_count_2(4);
    count_ = t1;
    int64_t t2 = (10 - count_);
    at_ = t2;
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((count_ > 0))) {
        process_model_column_8(phi_, (at_ + 0), stages_, none_, (tuple_7){{(real)0.0, (real)0.0}}, p_);
    }
    if (((count_ > 1))) {
        process_model_column_8(phi_, (at_ + 1), stages_, none_, (tuple_7){{(real)0.0, (real)2.0}}, p_);
        process_model_column_8(phi_, (at_ + 2), stages_, none_, (tuple_7){{(real)0.0, (real)3.0}}, p_);
        process_model_column_8(phi_, (at_ + 3), stages_, none_, (tuple_7){{(real)0.0, (real)4.0}}, p_);
    }
    if (((count_ > 0))) {
        width_ = (gm_fabs(law_.v[2]) / law_.v[0]);
        tuple_7 t3 = transmission_play((z_.p[0] - z_.p[1]), memory_, width_);
        z_.p[gm_at((at_ + 0), z_.n[0])] = t3.v[0];
        end_ = t3.v[1];
        if (((end_ != (real)0.0))) {
            for (int64_t k4 = 0; k4 < 10; k4 += 1) {
                j_ = k4;
                phi_.p[gm_at((((at_ + 0) * 10) + j_), phi_.n[0])] = (phi_.p[((0 + j_))] - phi_.p[((10 + j_))]);
            }
            if (((count_ > 1))) {
                phi_.p[gm_at(((((at_ + 0) * 10) + at_) + 1), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * 10) + at_) + 1), phi_.n[0])] + ((end_ * width_) / law_.v[0]));
                phi_.p[gm_at(((((at_ + 0) * 10) + at_) + 3), phi_.n[0])] = (phi_.p[gm_at(((((at_ + 0) * 10) + at_) + 3), phi_.n[0])] - ((((law_.v[2] >= (real)0.0)) ? end_ : (-end_)) / law_.v[0]));
            }
        }
    }
    return;
}

/* estimation/process_model.py:883 rk4 */
GM_INLINE void process_model_rk4_7(array1_f8 z_, array1_f8 phi_, bool first_, tuple_7 torques_, real h_, array1_f8 p_)
{
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
    tuple_9 law_;
    real memory_;
    tuple_9 rows_;
    tuple_8 error_;
    tuple_12 m1_;
    real total_;
    tuple_8 bend1_;
    real slope1_;
    real share1_;
    tuple_7 arm1_;
    real f1_;
    real g1_;
    tuple_13 r1_;
    real y2_;
    real y3_;
    real y4_;
    real tau_y_;
    tuple_8 bend2_;
    real slope2_;
    real share2_;
    tuple_7 arm2_;
    real f2_;
    real g2_;
    tuple_12 m2_;
    tuple_13 r2_;
    real v2_;
    real v3_;
    real v4_;
    real tau_v_;
    tuple_8 bend3_;
    real slope3_;
    real share3_;
    tuple_7 arm3_;
    real f3_;
    real g3_;
    tuple_12 m3_;
    tuple_13 r3_;
    real w2_;
    real w3_;
    real w4_;
    real tau_w_;
    tuple_8 bend4_;
    real slope4_;
    real share4_;
    tuple_7 arm4_;
    real f4_;
    real g4_;
    tuple_12 m4_;
    tuple_13 r4_;
    real moved1_;
    real moved2_;
    Stages stages_;
    int64_t i_;
    int64_t j_;
    tuple_9 none_;
    tuple_8 fades_;
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
    int64_t t8 = process_model_curve_count_2(4);
    at_curve_ = (10 - t8);
    tuple_9 t9 = process_model_curve_3(4, z_, 1, 0, at_curve_, p_);
    real t10 = process_model_memory_2(4, z_, at_curve_, (x1_ - x2_));
    law_ = t9;
    memory_ = t10;
    real t11 = process_model_memory_row_8(phi_, 0, first_);
    real t12 = process_model_memory_row_8(phi_, 2, first_);
    real t13 = process_model_memory_row_8(phi_, 3, first_);
    real t14 = process_model_memory_row_8(phi_, 4, first_);
    rows_ = (tuple_9){{t11, t12, t13, t14}};
    error_ = (tuple_8){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        load_ = (load_ + z_.p[gm_at((int64_t)(p_.p[28]), z_.n[0])]);
    }
    if (((p_.p[29] > (real)0.0))) {
        tuple_8 t15 = process_model_decay(z_.p[gm_at((int64_t)(p_.p[29]), z_.n[0])], half_, h_, p_);
        error_ = t15;
    }
    tuple_8 t16 = process_model_begin(10, phi_, 0, first_);
    tuple_8 t17 = process_model_begin(10, phi_, 2, first_);
    tuple_8 t18 = process_model_begin(10, phi_, 3, first_);
    tuple_8 t19 = process_model_begin(10, phi_, 4, first_);
    m1_ = (tuple_12){{t16, t17, t18, t19}};
    tuple_11 t20 = process_model_total_2(4, (x1_ - x2_), memory_, law_, tau_k_);
    total_ = t20.f0;
    bend1_ = t20.f1;
    tuple_7 t21 = process_model_slopes(false, x3_, total_, p_);
    slope1_ = t21.v[0];
    share1_ = t21.v[1];
    tuple_7 t22 = process_model_load_slopes(false, x2_, x4_, p_);
    arm1_ = t22;
    tuple_7 t23 = process_model_accelerations_8((tuple_8){{x1_, x2_, x3_, x4_, total_}}, (u_ - error_.v[0]), load_, p_);
    f1_ = t23.v[0];
    g1_ = t23.v[1];
    tuple_12 t24 = process_model_four_bent_2(4, bend1_, rows_, m1_);
    tuple_13 t25 = process_model_four_rates(false, t24, slope1_, share1_, arm1_, p_);
    r1_ = t25;
    real t26 = (x2_ + (half_ * x4_));
    real t27 = (x3_ + (half_ * f1_));
    real t28 = (x4_ + (half_ * g1_));
    y2_ = t26;
    y3_ = t27;
    y4_ = t28;
    tau_y_ = (tau_k_ + ((half_ * p_.p[26]) * (x3_ - x4_)));
    tuple_11 t29 = process_model_total_2(4, ((x1_ + (half_ * x3_)) - y2_), memory_, law_, tau_y_);
    total_ = t29.f0;
    bend2_ = t29.f1;
    tuple_7 t30 = process_model_slopes(false, y3_, total_, p_);
    slope2_ = t30.v[0];
    share2_ = t30.v[1];
    tuple_7 t31 = process_model_load_slopes(false, y2_, y4_, p_);
    arm2_ = t31;
    tuple_7 t32 = process_model_accelerations_8((tuple_8){{(x1_ + (half_ * x3_)), y2_, y3_, y4_, total_}}, (u_ - error_.v[1]), load_, p_);
    f2_ = t32.v[0];
    g2_ = t32.v[1];
    tuple_12 t33 = process_model_four_along(m1_, half_, m1_, r1_, p_);
    m2_ = t33;
    tuple_12 t34 = process_model_four_bent_2(4, bend2_, rows_, m2_);
    tuple_13 t35 = process_model_four_rates(false, t34, slope2_, share2_, arm2_, p_);
    r2_ = t35;
    real t36 = (x2_ + (half_ * y4_));
    real t37 = (x3_ + (half_ * f2_));
    real t38 = (x4_ + (half_ * g2_));
    v2_ = t36;
    v3_ = t37;
    v4_ = t38;
    tau_v_ = (tau_k_ + ((half_ * p_.p[26]) * (y3_ - y4_)));
    tuple_11 t39 = process_model_total_2(4, ((x1_ + (half_ * y3_)) - v2_), memory_, law_, tau_v_);
    total_ = t39.f0;
    bend3_ = t39.f1;
    tuple_7 t40 = process_model_slopes(false, v3_, total_, p_);
    slope3_ = t40.v[0];
    share3_ = t40.v[1];
    tuple_7 t41 = process_model_load_slopes(false, v2_, v4_, p_);
    arm3_ = t41;
    tuple_7 t42 = process_model_accelerations_8((tuple_8){{(x1_ + (half_ * y3_)), v2_, v3_, v4_, total_}}, (u_ - error_.v[2]), load_, p_);
    f3_ = t42.v[0];
    g3_ = t42.v[1];
    tuple_12 t43 = process_model_four_along(m1_, half_, m2_, r2_, p_);
    m3_ = t43;
    tuple_12 t44 = process_model_four_bent_2(4, bend3_, rows_, m3_);
    tuple_13 t45 = process_model_four_rates(false, t44, slope3_, share3_, arm3_, p_);
    r3_ = t45;
    real t46 = (x2_ + (h_ * v4_));
    real t47 = (x3_ + (h_ * f3_));
    real t48 = (x4_ + (h_ * g3_));
    w2_ = t46;
    w3_ = t47;
    w4_ = t48;
    tau_w_ = (tau_k_ + ((h_ * p_.p[26]) * (v3_ - v4_)));
    tuple_11 t49 = process_model_total_2(4, ((x1_ + (h_ * v3_)) - w2_), memory_, law_, tau_w_);
    total_ = t49.f0;
    bend4_ = t49.f1;
    tuple_7 t50 = process_model_slopes(false, w3_, total_, p_);
    slope4_ = t50.v[0];
    share4_ = t50.v[1];
    tuple_7 t51 = process_model_load_slopes(false, w2_, w4_, p_);
    arm4_ = t51;
    tuple_7 t52 = process_model_accelerations_8((tuple_8){{(x1_ + (h_ * v3_)), w2_, w3_, w4_, total_}}, (u_ - error_.v[3]), load_, p_);
    f4_ = t52.v[0];
    g4_ = t52.v[1];
    tuple_12 t53 = process_model_four_along(m1_, h_, m3_, r3_, p_);
    m4_ = t53;
    tuple_12 t54 = process_model_four_bent_2(4, bend4_, rows_, m4_);
    tuple_13 t55 = process_model_four_rates(false, t54, slope4_, share4_, arm4_, p_);
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
    process_model_end_11(phi_, 0, h_, (tuple_12){{m1_.v[0], m2_.v[0], m3_.v[0], m4_.v[0]}}, (tuple_13){{r1_.v[0], r2_.v[0], r3_.v[0], r4_.v[0]}}, p_);
    process_model_end_11(phi_, 2, h_, (tuple_12){{m1_.v[1], m2_.v[1], m3_.v[1], m4_.v[1]}}, (tuple_13){{r1_.v[1], r2_.v[1], r3_.v[1], r4_.v[1]}}, p_);
    process_model_end_11(phi_, 3, h_, (tuple_12){{m1_.v[2], m2_.v[2], m3_.v[2], m4_.v[2]}}, (tuple_13){{r1_.v[2], r2_.v[2], r3_.v[2], r4_.v[2]}}, p_);
    process_model_end_11(phi_, 4, h_, (tuple_12){{m1_.v[3], m2_.v[3], m3_.v[3], m4_.v[3]}}, (tuple_13){{r1_.v[3], r2_.v[3], r3_.v[3], r4_.v[3]}}, p_);
    stages_ = (Stages){(tuple_9){{slope1_, slope2_, slope3_, slope4_}}, (tuple_9){{share1_, share2_, share3_, share4_}}, (tuple_13){{arm1_, arm2_, arm3_, arm4_}}, (tuple_12){{bend1_, bend2_, bend3_, bend4_}}, h_, first_};
    process_model_column_of_x2_7(phi_, stages_, p_);
    if (first_) {
        for (int64_t k58 = 5; k58 < 10; k58 += 1) {
            i_ = k58;
            for (int64_t k59 = 0; k59 < 10; k59 += 1) {
                j_ = k59;
                phi_.p[gm_at(((i_ * 10) + j_), phi_.n[0])] = (((i_ == j_)) ? (real)1.0 : (real)0.0);
            }
        }
    }
    none_ = (tuple_9){{(real)0.0, (real)0.0, (real)0.0, (real)0.0}};
    if (((p_.p[28] > (real)0.0))) {
        process_model_column_8(phi_, (int64_t)(p_.p[28]), stages_, none_, (tuple_7){{(real)1.0, (real)0.0}}, p_);
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        z_.p[gm_at(i_, z_.n[0])] = error_.v[4];
        tuple_8 t60 = process_model_decay(phi_.p[gm_at(((i_ * 10) + i_), phi_.n[0])], half_, h_, p_);
        fades_ = t60;
        process_model_column_8(phi_, i_, stages_, (tuple_9){{fades_.v[0], fades_.v[1], fades_.v[2], fades_.v[3]}}, (tuple_7){{(real)0.0, (real)0.0}}, p_);
        phi_.p[gm_at(((i_ * 10) + i_), phi_.n[0])] = fades_.v[4];
    }
    process_model_columns_of_curve_5(z_, phi_, memory_, law_, stages_, p_);
    return;
}

/* estimation/process_model.py:1018 propagate */
GM_INLINE void process_model_propagate_5(array1_f8 z_, array1_f8 phi_, tuple_7 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    real h_;
    h_ = (((n_substeps_ > 1)) ? (dt_ / (real)(n_substeps_)) : dt_);
    process_model_rk4_7(z_, phi_, true, torques_, h_, p_);
    for (int64_t k1 = 1; k1 < n_substeps_; k1 += 1) {
        process_model_rk4_7(z_, phi_, false, torques_, h_, p_);
    }
    return;
}

/* kernels/linalg.py:100 carry */
GM_INLINE void linalg_carry_4(array1_f8 phi_, array1_f8 P_, array1_f8 half_, array1_f8 cross_, array1_f8 out_)
{
    linalg_carry_curve(4, 10, phi_, P_, half_, cross_, out_);
    return;
}

/* estimation/filters/ekf.py:56 predict */
GM_INLINE void ekf_predict_4(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
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
    z_ = belief_.z_;
    P_ = belief_.P_;
    dt_ = reading_.dt_;
    tuple_6 t1 = step_record_places(10);
    at_z_ = t1.v[0];
    at_P_ = t1.v[1];
    at_cross_ = t1.v[2];
    phi_ = (array1_f8){scratch_.matrices_.p + 0 * (scratch_.matrices_.n[1]), {scratch_.matrices_.n[1]}};
    int64_t t2 = (at_cross_ + 100);
    int64_t t3 = gm_bound(at_cross_, record_.n[0]);
    int64_t t4 = gm_bound(t2, record_.n[0]);
    int64_t t5 = gm_span(t3, t4);
    int64_t t6 = (at_P_ + 100);
    int64_t t7 = gm_bound(at_P_, record_.n[0]);
    int64_t t8 = gm_bound(t6, record_.n[0]);
    int64_t t9 = gm_span(t7, t8);
    cross_ = (array1_f8){record_.p + t3 * (1), {t5}};
    P_pred_ = (array1_f8){record_.p + t7 * (1), {t9}};
    for (int64_t k10 = 0; k10 < 10; k10 += 1) {
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
        real t16 = process_model_softened_sharpness(motor_, P_.p[22]);
        p_.p[5] = t16;
        real t17 = process_model_softened_sharpness(arm_, P_.p[33]);
        p_.p[15] = t17;
    }
    if (((p_.p[36] > (real)0.0))) {
        process_model_propagate_numeric_4(z_, phi_, (tuple_7){{reading_.u_, reading_.load_}}, dt_, counted_, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}});
    } else {
        process_model_propagate_5(z_, phi_, (tuple_7){{reading_.u_, reading_.load_}}, dt_, counted_, p_);
    }
    if (((p_.p[37] > (real)0.0))) {
        p_.p[5] = motor_;
        p_.p[15] = arm_;
    }
    int64_t t18 = (at_z_ + 10);
    int64_t t19 = gm_bound(at_z_, record_.n[0]);
    int64_t t20 = gm_bound(t18, record_.n[0]);
    int64_t t21 = gm_span(t19, t20);
    linalg_carry_4(phi_, P_, (array1_f8){record_.p + t19 * (1), {t21}}, cross_, P_pred_);
    for (int64_t k22 = 0; k22 < 10; k22 += 1) {
        i_ = k22;
        real t25 = P_pred_.p[(((i_ * 10) + i_))];
        real t24 = ((real)0.5 * dt_);
        real t23 = process_model_noise(z_, p_, i_);
        P_pred_.p[(((i_ * 10) + i_))] = (t25 + (t24 * t23));
        record_.p[((at_z_ + i_))] = z_.p[(i_)];
    }
    return;
}

/* estimation/filters/ekf.py:88 update */
GM_INLINE bool ekf_update_4(Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
{
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
    tuple_9 row_;
    int64_t j_;
    real value_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_6 t1 = step_record_places(10);
    at_prior_ = t1.v[1];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    at_innovation_ = t1.v[5];
    at_S_ = t1.v[6];
    at_K_ = t1.v[7];
    at_scores_ = t1.v[8];
    int64_t t2 = (at_prior_ + 100);
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
    real t12 = (prior_.p[11] + r2_);
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
        tuple_15 t13 = ekf_inverse(s11_, s12_, s22_, determinant_);
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
    for (int64_t k15 = 0; k15 < 10; k15 += 1) {
        i_ = k15;
        real t16 = prior_.p[((i_ * 10))];
        real t17 = prior_.p[(((i_ * 10) + 1))];
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
        tuple_9 t20 = ekf_joseph(i_, (tuple_7){{k1_, k2_}}, (tuple_7){{c1_, c2_}}, (tuple_15){{prior_.p[0], prior_.p[1], prior_.p[11]}}, (tuple_7){{r1_, r2_}});
        row_ = t20;
        int64_t t21 = (i_ + 1);
        for (int64_t k22 = 0; k22 < t21; k22 += 1) {
            j_ = k22;
            real t23 = ekf_joseph_element(i_, prior_.p[(((i_ * 10) + j_))], row_, (tuple_7){{prior_.p[(j_)], prior_.p[((10 + j_))]}}, (tuple_7){{record_.p[((at_K_ + (2 * j_)))], record_.p[(((at_K_ + (2 * j_)) + 1))]}});
            value_ = t23;
            P_.p[(((i_ * 10) + j_))] = value_;
            P_.p[(((j_ * 10) + i_))] = value_;
            record_.p[(((at_P_ + (i_ * 10)) + j_))] = value_;
            record_.p[(((at_P_ + (j_ * 10)) + i_))] = value_;
        }
    }
    return true;
}

/* estimation/process_model.py:356 bound_curve */
GM_INLINE void process_model_bound_curve_4(array1_f8 z_, array1_f8 p_)
{
    int64_t count_;
    int64_t at_;
    int64_t t1 = process_model_curve_count_2(4);
    count_ = t1;
    if (((count_ > 1))) {
        at_ = (10 - count_);
        z_.p[gm_at((at_ + 1), z_.n[0])] = gm_min_f(gm_max_f(z_.p[gm_at((at_ + 1), z_.n[0])], (p_.p[9] / (real)10.0)), (p_.p[9] * (real)10.0));
        z_.p[gm_at((at_ + 2), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 2), z_.n[0])], (real)0.0);
        if (((p_.p[12] > (real)0.0))) {
            z_.p[gm_at((at_ + 3), z_.n[0])] = gm_max_f(z_.p[gm_at((at_ + 3), z_.n[0])], (real)0.0);
        }
    }
    return;
}

/* estimation/filters/ekf.py:208 healthy */
GM_INLINE bool ekf_healthy_4(Belief belief_)
{
    array1_f8 z_;
    array1_f8 P_;
    int64_t i_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    for (int64_t k1 = 0; k1 < 10; k1 += 1) {
        i_ = k1;
        if ((!(((bool)isfinite(z_.p[(i_)]) && ((P_.p[(((i_ * 10) + i_))] > (real)0.0))) && (bool)isfinite(P_.p[(((i_ * 10) + i_))])))) {
            return false;
        }
    }
    return true;
}

/* estimation/filters/ekf.py:30 step */
GM_APART bool ekf_step_4(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
{
    ekf_predict_4(belief_, reading_, p_, scratch_, record_);
    bool t1 = ekf_update_4(belief_, reading_.y1_, reading_.y2_, p_, record_);
    if ((!t1)) {
        return false;
    }
    process_model_bound_curve_4(belief_.z_, p_);
    bool t2 = ekf_healthy_4(belief_);
    return t2;
}

/* estimation/process_model.py:554 _accelerations */
GM_INLINE tuple_7 process_model_accelerations_9(tuple_8 x_, real u_, real load_, tuple_18 p_)
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
    real t1 = drive_motor_acceleration_2(x1_, x3_, x4_, u_, tau_k_, p_);
    real t2 = drive_arm_acceleration_2(x3_, x4_, tau_k_, load_, p_);
    return (tuple_7){{t1, t2}};
}

/* estimation/process_model.py:618 _stage */
GM_INLINE void process_model_stage_6(array1_f8 lanes_, int64_t width_, int64_t q_, real part_, bool differ_, tuple_15 torques_, tuple_18 shared_)
{
    array1_f8 z_;
    int64_t at_curve_;
    int64_t i_;
    real u_;
    tuple_18 drive_;
    tuple_9 law_;
    real memory_;
    int64_t at_;
    tuple_8 x_;
    int64_t last_;
    real x3_;
    real x4_;
    real f_;
    real g_;
    z_ = lanes_;
    int64_t t1 = process_model_curve_count_2(4);
    at_curve_ = ((10 - t1) * 16);
    for (int64_t k2 = 0; k2 < width_; k2 += 1) {
        i_ = k2;
        tuple_19 t3 = process_model_own_drive(differ_, z_, (496 + i_), torques_, shared_);
        u_ = t3.f0;
        drive_ = t3.f1;
        int64_t t4 = process_model_curve_count_2(4);
        tuple_9 t5 = process_model_curve_4(4, z_, 16, i_, (10 - t4), drive_);
        law_ = t5;
        real t6 = process_model_memory_2(4, z_, (at_curve_ + i_), (z_.p[((0 + i_))] - z_.p[((16 + i_))]));
        memory_ = t6;
        at_ = (((10 + q_) * 16) + i_);
        x_ = (tuple_8){{z_.p[((0 + i_))], z_.p[((16 + i_))], z_.p[((32 + i_))], z_.p[((48 + i_))], z_.p[((64 + i_))]}};
        if (((q_ > 0))) {
            last_ = (at_ - 16);
            real t7 = z_.p[gm_at((last_ + 0), z_.n[0])];
            real t8 = z_.p[gm_at((last_ + 64), z_.n[0])];
            x3_ = t7;
            x4_ = t8;
            x_ = (tuple_8){{(x_.v[0] + (part_ * x3_)), (x_.v[1] + (part_ * x4_)), (x_.v[2] + (part_ * z_.p[gm_at((last_ + 128), z_.n[0])])), (x_.v[3] + (part_ * z_.p[gm_at((last_ + 192), z_.n[0])])), (x_.v[4] + ((part_ * drive_.v[26]) * (x3_ - x4_)))}};
        }
        tuple_8 t9 = process_model_bearing_5(x_, (tuple_10){memory_, law_});
        tuple_7 t10 = process_model_accelerations_9(t9, (u_ - z_.p[((at_ + 256))]), z_.p[((480 + i_))], drive_);
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

/* estimation/process_model.py:658 _finish */
GM_INLINE void process_model_finish_4(array1_f8 lanes_, int64_t i_, real sixth_, tuple_18 p_)
{
    array1_f8 z_;
    int64_t at_;
    int64_t at_curve_;
    tuple_9 law_;
    real memory_;
    real moved1_;
    real moved2_;
    z_ = lanes_;
    int64_t t2 = (160 + i_);
    int64_t t1 = process_model_curve_count_2(4);
    int64_t t3 = (10 - t1);
    at_ = t2;
    at_curve_ = t3;
    tuple_9 t4 = process_model_curve_4(4, z_, 16, i_, at_curve_, p_);
    law_ = t4;
    real t5 = process_model_memory_2(4, z_, ((at_curve_ * 16) + i_), (real)0.0);
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
    int64_t t12 = process_model_curve_count_2(4);
    if (((t12 > 0))) {
        tuple_7 t13 = transmission_play((z_.p[((0 + i_))] - z_.p[((16 + i_))]), memory_, (gm_fabs(law_.v[2]) / law_.v[0]));
        z_.p[gm_at(((at_curve_ * 16) + i_), z_.n[0])] = t13.v[0];
    }
    return;
}

/* estimation/process_model.py:567 advance_beside */
GM_STATIC void process_model_advance_beside_6(array1_f8 lanes_, int64_t count_, bool differ_, tuple_15 torques_, real dt_, int64_t n_substeps_, array1_f8 p_)
{
    int64_t width_;
    real h_;
    int64_t friction_at_;
    real share_;
    tuple_18 drive_;
    int64_t i_;
    int64_t q_;
    tuple_8 error_;
    int64_t t1 = ((count_ + 3) & (-4));
    real t2 = (dt_ / (real)(n_substeps_));
    width_ = t1;
    h_ = t2;
    int64_t t3 = ((int64_t)(p_.p[29]) * 16);
    friction_at_ = t3;
    share_ = (((p_.p[28] > (real)0.0)) ? (real)1.0 : (real)0.0);
    drive_ = (tuple_18){{p_.p[0], p_.p[1], p_.p[2], p_.p[3], p_.p[4], p_.p[5], p_.p[6], p_.p[7], p_.p[8], p_.p[9], p_.p[10], p_.p[11], p_.p[12], p_.p[13], p_.p[14], p_.p[15], p_.p[16], p_.p[17], p_.p[18], p_.p[19], p_.p[20], p_.p[21], p_.p[22], p_.p[23], p_.p[24], p_.p[25], p_.p[26]}};
    for (int64_t k4 = 0; k4 < width_; k4 += 1) {
        i_ = k4;
        lanes_.p[((480 + i_))] = torques_.v[1];
        lanes_.p[((480 + i_))] = (lanes_.p[((480 + i_))] + (share_ * lanes_.p[((80 + i_))]));
        for (int64_t k5 = 0; k5 < 4; k5 += 1) {
            q_ = k5;
            lanes_.p[(((416 + (q_ * 16)) + i_))] = (real)0.0;
        }
    }
    for (int64_t k6 = 0; k6 < n_substeps_; k6 += 1) {
        if (((friction_at_ > 0))) {
            for (int64_t k7 = 0; k7 < width_; k7 += 1) {
                i_ = k7;
                tuple_8 t8 = process_model_decay(lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])], ((real)0.5 * h_), h_, p_);
                error_ = t8;
                for (int64_t k9 = 0; k9 < 4; k9 += 1) {
                    q_ = k9;
                    lanes_.p[(((416 + (q_ * 16)) + i_))] = error_.v[(q_)];
                }
                lanes_.p[gm_at((friction_at_ + i_), lanes_.n[0])] = error_.v[4];
            }
        }
        process_model_stage_6(lanes_, width_, 0, (real)0.0, differ_, torques_, drive_);
        process_model_stage_6(lanes_, width_, 1, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage_6(lanes_, width_, 2, ((real)0.5 * h_), differ_, torques_, drive_);
        process_model_stage_6(lanes_, width_, 3, h_, differ_, torques_, drive_);
        for (int64_t k10 = 0; k10 < width_; k10 += 1) {
            i_ = k10;
            process_model_finish_4(lanes_, i_, (h_ / (real)6.0), drive_);
        }
    }
    return;
}

/* estimation/consider.py:126 accompany */
GM_STATIC bool consider_accompany_4(Companions companions_, array1_f8 z_, Reading reading_, tuple_17 used_, array1_f8 record_)
{
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
    for (int64_t k2 = 0; k2 < 10; k2 += 1) {
        j_ = k2;
        for (int64_t k3 = 0; k3 < 16; k3 += 1) {
            i_ = k3;
            lanes_.p[(((j_ * 16) + i_))] = z_.p[(j_)];
        }
        for (int64_t k4 = 0; k4 < count_; k4 += 1) {
            i_ = k4;
            lanes_.p[((((j_ * 16) + 1) + i_))] = (lanes_.p[((((j_ * 16) + 1) + i_))] + s_.p[(((i_ * 10) + j_))]);
        }
    }
    int64_t t6 = (count_ + 1);
    int64_t t5 = drive_substeps(reading_.dt_, (p_.p[30] + faster_));
    process_model_advance_beside_6(lanes_, t6, true, (tuple_15){{reading_.u_, reading_.load_, rate_}}, reading_.dt_, t5, p_);
    tuple_6 t7 = step_record_places(10);
    at_K_ = t7.v[7];
    tuple_20 t8 = step_record_sensitivities(10, record_.n[0]);
    at_predicted_ = t8.v[1];
    at_updated_ = t8.v[2];
    good_ = true;
    for (int64_t k9 = 0; k9 < count_; k9 += 1) {
        i_ = k9;
        at_ = (i_ * 10);
        real t10 = (lanes_.p[((1 + i_))] - lanes_.p[0]);
        real t11 = (lanes_.p[((17 + i_))] - lanes_.p[16]);
        e1_ = t10;
        e2_ = t11;
        for (int64_t k12 = 0; k12 < 10; k12 += 1) {
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

/* estimation/process_model.py:298 torque_slopes */
GM_INLINE tuple_8 process_model_torque_slopes_5(array1_f8 z_, array1_f8 p_)
{
    int64_t at_;
    real twist_;
    int64_t t1 = process_model_curve_count_2(4);
    int64_t t2 = (10 - t1);
    real t3 = (z_.p[0] - z_.p[1]);
    at_ = t2;
    twist_ = t3;
    real t4 = process_model_memory_2(4, z_, at_, twist_);
    tuple_9 t5 = process_model_curve_3(4, z_, 1, 0, at_, p_);
    tuple_11 t6 = process_model_total_2(4, twist_, t4, t5, z_.p[4]);
    return t6.f1;
}

/* estimation/consider.py:191 variances_of */
GM_INLINE tuple_15 consider_variances_of_5(array1_f8 z_, array1_f8 record_, int64_t at_, array1_f8 p_)
{
    int64_t count_;
    real late_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    tuple_8 slopes_;
    int64_t c_;
    int64_t of_c_;
    real twist_;
    real rate_;
    real torque_;
    int64_t i_;
    tuple_20 t1 = step_record_sensitivities(10, record_.n[0]);
    count_ = t1.v[0];
    late_ = (p_.p[34] * z_.p[3]);
    real t2 = (late_ * late_);
    of_twist_ = t2;
    of_rate_ = (real)0.0;
    of_torque_ = (real)0.0;
    tuple_8 t3 = process_model_torque_slopes_5(z_, p_);
    slopes_ = t3;
    for (int64_t k4 = 0; k4 < count_; k4 += 1) {
        c_ = k4;
        of_c_ = (at_ + (c_ * 10));
        real t5 = (record_.p[gm_at((of_c_ + 0), record_.n[0])] - record_.p[gm_at((of_c_ + 1), record_.n[0])]);
        real t6 = (record_.p[gm_at((of_c_ + 2), record_.n[0])] - record_.p[gm_at((of_c_ + 3), record_.n[0])]);
        twist_ = t5;
        rate_ = t6;
        torque_ = record_.p[gm_at((of_c_ + 4), record_.n[0])];
        torque_ = (torque_ + (slopes_.v[0] * twist_));
        int64_t t7 = process_model_curve_count_2(4);
        for (int64_t k8 = 0; k8 < t7; k8 += 1) {
            i_ = k8;
            real t12 = torque_;
            real t11 = slopes_.v[((1 + i_))];
            int64_t t10 = (of_c_ + 10);
            int64_t t9 = process_model_curve_count_2(4);
            torque_ = (t12 + (t11 * record_.p[gm_at(((t10 - t9) + i_), record_.n[0])]));
        }
        of_twist_ = (of_twist_ + (twist_ * twist_));
        of_rate_ = (of_rate_ + (rate_ * rate_));
        of_torque_ = (of_torque_ + (torque_ * torque_));
    }
    return (tuple_15){{of_twist_, of_rate_, of_torque_}};
}

/* estimation/process_model.py:246 torque_of */
GM_INLINE tuple_7 process_model_torque_of_5(array1_f8 z_, array1_f8 P_, array1_f8 p_)
{
    int64_t at_;
    real twist_;
    real tau_k_;
    tuple_8 slopes_;
    real variance_;
    int64_t i_;
    int64_t row_;
    real on_others_;
    int64_t j_;
    int64_t t1 = process_model_curve_count_2(4);
    at_ = (10 - t1);
    twist_ = (z_.p[0] - z_.p[1]);
    real t2 = process_model_memory_2(4, z_, at_, twist_);
    tuple_9 t3 = process_model_curve_3(4, z_, 1, 0, at_, p_);
    tuple_11 t4 = process_model_total_2(4, twist_, t2, t3, z_.p[4]);
    tau_k_ = t4.f0;
    slopes_ = t4.f1;
    variance_ = ((P_.p[44] + ((slopes_.v[0] * slopes_.v[0]) * ((P_.p[0] + P_.p[11]) - ((real)2.0 * P_.p[1])))) + (((real)2.0 * slopes_.v[0]) * (P_.p[4] - P_.p[14])));
    int64_t t5 = process_model_curve_count_2(4);
    for (int64_t k6 = 0; k6 < t5; k6 += 1) {
        i_ = k6;
        row_ = ((at_ + i_) * 10);
        on_others_ = (P_.p[gm_at((row_ + 4), P_.n[0])] + (slopes_.v[0] * (P_.p[gm_at((row_ + 0), P_.n[0])] - P_.p[gm_at((row_ + 1), P_.n[0])])));
        for (int64_t k7 = 0; k7 < i_; k7 += 1) {
            j_ = k7;
            on_others_ = (on_others_ + (slopes_.v[((1 + j_))] * P_.p[gm_at(((row_ + at_) + j_), P_.n[0])]));
        }
        variance_ = (variance_ + (slopes_.v[((1 + i_))] * (((real)2.0 * on_others_) + (slopes_.v[((1 + i_))] * P_.p[gm_at(((row_ + at_) + i_), P_.n[0])]))));
    }
    return (tuple_7){{tau_k_, gm_max_f(variance_, (real)0.0)}};
}

/* estimation/sample_loop.py:515 _write_estimate */
GM_STATIC void sample_loop_write_estimate_4(Belief belief_, array1_f8 record_, Reading reading_, array1_f8 p_, real share_, array1_f8 row_)
{
    array1_f8 z_;
    array1_f8 P_;
    int64_t at_s_;
    int64_t i_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    int64_t at_innovation_;
    int64_t at_S_;
    int64_t at_scores_;
    real e1_;
    real e2_;
    real s11_;
    real s12_;
    real s22_;
    z_ = belief_.z_;
    P_ = belief_.P_;
    tuple_20 t1 = step_record_sensitivities(10, record_.n[0]);
    at_s_ = t1.v[2];
    for (int64_t k2 = 0; k2 < 7; k2 += 1) {
        i_ = k2;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
        row_.p[gm_at((7 + i_), row_.n[0])] = NAN;
    }
    for (int64_t k3 = 0; k3 < 4; k3 += 1) {
        i_ = k3;
        row_.p[gm_at(i_, row_.n[0])] = z_.p[gm_at(i_, z_.n[0])];
        real t5 = P_.p[gm_at(((i_ * 10) + i_), P_.n[0])];
        real t4 = consider_variance_of_2(10, record_, at_s_, i_);
        row_.p[gm_at((7 + i_), row_.n[0])] = gm_sqrt((t5 + t4));
    }
    tuple_15 t6 = consider_variances_of_5(z_, record_, at_s_, p_);
    of_twist_ = t6.v[0];
    of_rate_ = t6.v[1];
    of_torque_ = t6.v[2];
    tuple_7 t7 = process_model_torque_of_5(z_, P_, p_);
    row_.p[4] = t7.v[0];
    variance_ = t7.v[1];
    row_.p[37] = gm_sqrt(variance_);
    tuple_7 t8 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[4], variance_}}, p_);
    row_.p[39] = gm_sqrt(gm_max_f(t8.v[1], (real)0.0));
    row_.p[11] = gm_sqrt((((share_ * variance_) + of_torque_) + (p_.p[33] * p_.p[33])));
    row_.p[40] = NAN;
    row_.p[41] = NAN;
    for (int64_t k9 = 31; k9 < 37; k9 += 1) {
        i_ = k9;
        row_.p[gm_at(i_, row_.n[0])] = NAN;
    }
    int64_t t10 = process_model_curve_count_2(4);
    if (((t10 > 1))) {
        real t11 = z_.p[7];
        real t12 = gm_sqrt(P_.p[77]);
        row_.p[31] = t11;
        row_.p[34] = t12;
        tuple_7 t13 = process_model_learned_length(z_, P_, 10, 8);
        row_.p[32] = t13.v[0];
        row_.p[35] = t13.v[1];
        tuple_7 t14 = process_model_learned_length(z_, P_, 10, 9);
        row_.p[33] = t14.v[0];
        row_.p[36] = t14.v[1];
    }
    if (((p_.p[28] > (real)0.0))) {
        i_ = (int64_t)(p_.p[28]);
        row_.p[5] = (z_.p[gm_at(i_, z_.n[0])] + reading_.load_);
        real t16 = P_.p[gm_at(((i_ * 10) + i_), P_.n[0])];
        real t15 = consider_variance_of_2(10, record_, at_s_, i_);
        row_.p[12] = gm_sqrt((t16 + t15));
    }
    if (((p_.p[29] > (real)0.0))) {
        i_ = (int64_t)(p_.p[29]);
        row_.p[6] = z_.p[gm_at(i_, z_.n[0])];
        real t18 = P_.p[gm_at(((i_ * 10) + i_), P_.n[0])];
        real t17 = consider_variance_of_2(10, record_, at_s_, i_);
        row_.p[13] = gm_sqrt((t18 + t17));
    }
    row_.p[14] = (z_.p[0] - z_.p[1]);
    row_.p[15] = (z_.p[2] - z_.p[3]);
    row_.p[16] = gm_sqrt((gm_max_f(((P_.p[0] + P_.p[11]) - ((real)2.0 * P_.p[1])), (real)0.0) + of_twist_));
    row_.p[17] = gm_sqrt((gm_max_f(((P_.p[22] + P_.p[33]) - ((real)2.0 * P_.p[23])), (real)0.0) + of_rate_));
    tuple_6 t19 = step_record_places(10);
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
GM_STATIC void rts_smoother_write_5(array1_f8 z_, array1_f8 P_, array1_f8 p_, array1_f8 record_, array1_f8 row_)
{
    int64_t at_smoothed_;
    real of_twist_;
    real of_rate_;
    real of_torque_;
    real variance_;
    real noise_;
    tuple_20 t1 = step_record_sensitivities(10, record_.n[0]);
    at_smoothed_ = t1.v[3];
    tuple_15 t2 = consider_variances_of_5(z_, record_, at_smoothed_, p_);
    of_twist_ = t2.v[0];
    of_rate_ = t2.v[1];
    of_torque_ = t2.v[2];
    row_.p[0] = (z_.p[0] - z_.p[1]);
    row_.p[1] = (z_.p[2] - z_.p[3]);
    tuple_7 t3 = process_model_torque_of_5(z_, P_, p_);
    row_.p[2] = t3.v[0];
    variance_ = t3.v[1];
    noise_ = gm_max_f(((P_.p[0] + P_.p[11]) - ((real)2.0 * P_.p[1])), (real)0.0);
    real t4 = gm_sqrt(noise_);
    real t5 = gm_sqrt((noise_ + of_twist_));
    row_.p[10] = t4;
    row_.p[3] = t5;
    noise_ = gm_max_f(((P_.p[22] + P_.p[33]) - ((real)2.0 * P_.p[23])), (real)0.0);
    row_.p[11] = gm_sqrt(noise_);
    row_.p[4] = gm_sqrt((noise_ + of_rate_));
    row_.p[12] = gm_sqrt(gm_max_f(variance_, (real)0.0));
    row_.p[5] = gm_sqrt(((gm_max_f(variance_, (real)0.0) + of_torque_) + (p_.p[33] * p_.p[33])));
    tuple_7 t6 = process_model_motor_side(z_, P_, (tuple_7){{row_.p[2], variance_}}, p_);
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
GM_STATIC bool linalg_solve_positive_5(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t j_;
    real s_;
    int64_t k_;
    real inverse_;
    int64_t i_;
    tuple_21 row_;
    for (int64_t k1 = 0; k1 < 10; k1 += 1) {
        j_ = k1;
        s_ = a_.p[(((j_ * 10) + j_))];
        for (int64_t k2 = 0; k2 < j_; k2 += 1) {
            k_ = k2;
            s_ = (s_ - (a_.p[(((j_ * 10) + k_))] * a_.p[(((j_ * 10) + k_))]));
        }
        if ((!((s_ > (real)0.0)))) {
            return false;
        }
        inverse_ = ((real)1.0 / gm_sqrt(s_));
        a_.p[(((j_ * 10) + j_))] = inverse_;
        int64_t t3 = (j_ + 1);
        for (int64_t k4 = t3; k4 < 10; k4 += 1) {
            i_ = k4;
            s_ = a_.p[(((i_ * 10) + j_))];
            for (int64_t k5 = 0; k5 < j_; k5 += 1) {
                k_ = k5;
                s_ = (s_ - (a_.p[(((i_ * 10) + k_))] * a_.p[(((j_ * 10) + k_))]));
            }
            a_.p[(((i_ * 10) + j_))] = (s_ * inverse_);
        }
    }
    for (int64_t k6 = 0; k6 < 10; k6 += 1) {
        i_ = k6;
        tuple_21 t7 = linalg_added(10, (real)1.0, b_, (i_ * 10), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t7;
        int64_t t8 = i_;
        for (int64_t k9 = 0; k9 < t8; k9 += 1) {
            k_ = k9;
            tuple_21 t10 = linalg_added(10, (-a_.p[(((i_ * 10) + k_))]), out_, (k_ * 10), row_);
            row_ = t10;
        }
        linalg_put(10, row_, out_, (i_ * 10));
        tuple_21 t11 = linalg_added(10, a_.p[(((i_ * 10) + i_))], out_, (i_ * 10), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(10, t11, out_, (i_ * 10));
    }
    for (int64_t k12 = 9; k12 > (-1); k12 += -1) {
        i_ = k12;
        tuple_21 t13 = linalg_added(10, (real)1.0, out_, (i_ * 10), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t13;
        int64_t t14 = (i_ + 1);
        for (int64_t k15 = t14; k15 < 10; k15 += 1) {
            k_ = k15;
            tuple_21 t16 = linalg_added(10, (-a_.p[(((k_ * 10) + i_))]), out_, (k_ * 10), row_);
            row_ = t16;
        }
        linalg_put(10, row_, out_, (i_ * 10));
        tuple_21 t17 = linalg_added(10, a_.p[(((i_ * 10) + i_))], out_, (i_ * 10), (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        linalg_put(10, t17, out_, (i_ * 10));
    }
    return true;
}

/* kernels/linalg.py:22 multiply */
GM_INLINE void linalg_multiply_5(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t i_;
    int64_t j_;
    int64_t k_;
    real v_;
    for (int64_t k1 = 0; k1 < 10; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < 10; k2 += 1) {
            j_ = k2;
            out_.p[(((i_ * 10) + j_))] = (real)0.0;
        }
        for (int64_t k3 = 0; k3 < 10; k3 += 1) {
            k_ = k3;
            v_ = a_.p[(((i_ * 10) + k_))];
            for (int64_t k4 = 0; k4 < 10; k4 += 1) {
                j_ = k4;
                out_.p[(((i_ * 10) + j_))] = gm_fma(v_, b_.p[(((k_ * 10) + j_))], out_.p[(((i_ * 10) + j_))]);
            }
        }
    }
    return;
}

/* kernels/linalg.py:304 transposed_multiply_symmetric */
GM_INLINE void linalg_transposed_multiply_symmetric_5(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t i_;
    tuple_21 row_;
    int64_t k_;
    int64_t j_;
    for (int64_t k1 = 0; k1 < 10; k1 += 1) {
        i_ = k1;
        row_ = (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}};
        for (int64_t k2 = 0; k2 < 10; k2 += 1) {
            k_ = k2;
            tuple_21 t3 = linalg_added(10, a_.p[(((k_ * 10) + i_))], b_, (k_ * 10), row_);
            row_ = t3;
        }
        linalg_put(10, row_, out_, (i_ * 10));
    }
    for (int64_t k4 = 0; k4 < 10; k4 += 1) {
        i_ = k4;
        int64_t t5 = i_;
        for (int64_t k6 = 0; k6 < t5; k6 += 1) {
            j_ = k6;
            out_.p[(((j_ * 10) + i_))] = out_.p[(((i_ * 10) + j_))];
        }
    }
    return;
}

/* kernels/linalg.py:293 add_product */
GM_INLINE void linalg_add_product_5(array1_f8 a_, array1_f8 b_, array1_f8 out_)
{
    int64_t at_;
    tuple_21 row_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < out_.n[0]; k1 += 10) {
        at_ = k1;
        tuple_21 t2 = linalg_added(10, (real)1.0, out_, at_, (tuple_21){{(real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0, (real)0.0}});
        row_ = t2;
        for (int64_t k3 = 0; k3 < 10; k3 += 1) {
            k_ = k3;
            tuple_21 t4 = linalg_added(10, a_.p[((at_ + k_))], b_, (k_ * 10), row_);
            row_ = t4;
        }
        linalg_put(10, row_, out_, at_);
    }
    return;
}

/* estimation/rts_smoother.py:60 smooth */
GM_STATIC void rts_smoother_smooth_5(array2_f8 ring_, Span span_, array1_f8 p_, array1_f8 z_, array2_f8 matrices_, array2_f8 out_)
{
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
    rows_ = ring_.n[0];
    newest_ = span_.newest_;
    oldest_ = span_.oldest_;
    keep_until_ = span_.keep_until_;
    P_ = (array1_f8){matrices_.p + 0 * (matrices_.n[1]), {matrices_.n[1]}};
    gain_t_ = (array1_f8){matrices_.p + 1 * (matrices_.n[1]), {matrices_.n[1]}};
    factor_ = (array1_f8){matrices_.p + 2 * (matrices_.n[1]), {matrices_.n[1]}};
    change_ = (array1_f8){matrices_.p + 3 * (matrices_.n[1]), {matrices_.n[1]}};
    product_ = (array1_f8){matrices_.p + 4 * (matrices_.n[1]), {matrices_.n[1]}};
    tuple_6 t1 = step_record_places(10);
    at_pred_ = t1.v[0];
    at_P_pred_ = t1.v[1];
    at_cross_ = t1.v[2];
    at_z_ = t1.v[3];
    at_P_ = t1.v[4];
    tuple_20 t2 = step_record_sensitivities(10, ring_.n[1]);
    count_ = t2.v[0];
    at_s_pred_ = t2.v[1];
    at_s_ = t2.v[2];
    at_smoothed_ = t2.v[3];
    last_ = (array1_f8){ring_.p + (gm_mod(newest_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
    int64_t t3 = (10 * count_);
    for (int64_t k4 = 0; k4 < t3; k4 += 1) {
        i_ = k4;
        last_.p[gm_at((at_smoothed_ + i_), last_.n[0])] = last_.p[gm_at((at_s_ + i_), last_.n[0])];
    }
    for (int64_t k5 = 0; k5 < 10; k5 += 1) {
        i_ = k5;
        z_.p[(i_)] = last_.p[((at_z_ + i_))];
    }
    for (int64_t k6 = 0; k6 < 100; k6 += 1) {
        i_ = k6;
        P_.p[(i_)] = last_.p[((at_P_ + i_))];
    }
    if (((newest_ <= keep_until_))) {
        rts_smoother_write_5(z_, P_, p_, last_, (array1_f8){out_.p + gm_at((newest_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
    }
    int64_t t7 = (newest_ - 1);
    int64_t t8 = (oldest_ - 1);
    for (int64_t k9 = t7; k9 > t8; k9 += -1) {
        k_ = k9;
        record_ = (array1_f8){ring_.p + (gm_mod(k_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        later_ = (array1_f8){ring_.p + (gm_mod((k_ + 1), rows_)) * (ring_.n[1]), {ring_.n[1]}};
        for (int64_t k10 = 0; k10 < 100; k10 += 1) {
            i_ = k10;
            factor_.p[(i_)] = later_.p[((at_P_pred_ + i_))];
            change_.p[(i_)] = (P_.p[(i_)] - later_.p[((at_P_pred_ + i_))]);
        }
        int64_t t11 = (at_cross_ + 100);
        int64_t t12 = gm_bound(at_cross_, later_.n[0]);
        int64_t t13 = gm_bound(t11, later_.n[0]);
        int64_t t14 = gm_span(t12, t13);
        bool t15 = linalg_solve_positive_5(factor_, (array1_f8){later_.p + t12 * (1), {t14}}, gain_t_);
        if (t15) {
            for (int64_t k16 = 0; k16 < 10; k16 += 1) {
                i_ = k16;
                z_.p[(i_)] = (z_.p[(i_)] - later_.p[((at_pred_ + i_))]);
            }
            linalg_multiply_5(change_, gain_t_, product_);
            linalg_transposed_multiply_symmetric_5(gain_t_, product_, P_);
            for (int64_t k17 = 0; k17 < 100; k17 += 1) {
                i_ = k17;
                P_.p[(i_)] = (P_.p[(i_)] + record_.p[((at_P_ + i_))]);
            }
            for (int64_t k18 = 0; k18 < 10; k18 += 1) {
                i_ = k18;
                s_ = record_.p[((at_z_ + i_))];
                for (int64_t k19 = 0; k19 < 10; k19 += 1) {
                    m_ = k19;
                    s_ = (s_ + (gain_t_.p[(((m_ * 10) + i_))] * z_.p[(m_)]));
                }
                product_.p[(i_)] = s_;
            }
            for (int64_t k20 = 0; k20 < 10; k20 += 1) {
                i_ = k20;
                z_.p[(i_)] = product_.p[(i_)];
            }
            int64_t t21 = (at_smoothed_ + (10 * count_));
            int64_t t22 = gm_bound(at_smoothed_, later_.n[0]);
            int64_t t23 = gm_bound(t21, later_.n[0]);
            int64_t t24 = gm_span(t22, t23);
            change_s_ = (array1_f8){later_.p + t22 * (1), {t24}};
            int64_t t25 = (10 * count_);
            for (int64_t k26 = 0; k26 < t25; k26 += 1) {
                i_ = k26;
                change_s_.p[(i_)] = (change_s_.p[(i_)] - later_.p[((at_s_pred_ + i_))]);
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            int64_t t27 = (at_smoothed_ + (10 * count_));
            int64_t t28 = gm_bound(at_smoothed_, record_.n[0]);
            int64_t t29 = gm_bound(t27, record_.n[0]);
            int64_t t30 = gm_span(t28, t29);
            linalg_add_product_5(change_s_, gain_t_, (array1_f8){record_.p + t28 * (1), {t30}});
        } else {
            int64_t t31 = (10 * count_);
            for (int64_t k32 = 0; k32 < t31; k32 += 1) {
                i_ = k32;
                record_.p[gm_at((at_smoothed_ + i_), record_.n[0])] = record_.p[gm_at((at_s_ + i_), record_.n[0])];
            }
            for (int64_t k33 = 0; k33 < 10; k33 += 1) {
                i_ = k33;
                z_.p[(i_)] = record_.p[((at_z_ + i_))];
            }
            for (int64_t k34 = 0; k34 < 100; k34 += 1) {
                i_ = k34;
                P_.p[(i_)] = record_.p[((at_P_ + i_))];
            }
        }
        if (((k_ <= keep_until_))) {
            rts_smoother_write_5(z_, P_, p_, record_, (array1_f8){out_.p + gm_at((k_ - oldest_), out_.n[0]) * (out_.n[1]), {out_.n[1]}});
        }
    }
    return;
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_ekf_4(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(10);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start_4(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described_4(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim_4(belief_, reading_, p_);
        }
        bool t22 = ekf_step_4(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany_4(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate_4(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_5(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/slopes.py:75 _begin */
GM_INLINE void slopes_begin(Belief belief_, int64_t i_, tuple_4 places_, real r_, real dt_)
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
GM_APART bool slopes_step(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
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
                slopes_begin(belief_, i_, (tuple_4){{0, 2}}, p_.p[31], reading_.dt_);
            } else {
                if (((p_.p[((46 + i_))] == (real)32.0))) {
                    slopes_begin(belief_, i_, (tuple_4){{1, 3}}, p_.p[32], reading_.dt_);
                }
            }
        }
    }
    bool t4 = aekf_differentiate(belief_, reading_, p_, scratch_, record_);
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
GM_STATIC tuple_4 sample_loop_run_slopes(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(6);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            aekf_resume(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(belief_, reading_, p_);
        }
        bool t22 = slopes_step(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(6, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_2(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/slopes.py:42 step */
GM_APART bool slopes_step_2(Belief belief_, Reading reading_, array1_f8 p_, Scratch scratch_, array1_f8 record_)
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
                slopes_begin(belief_, i_, (tuple_4){{0, 2}}, p_.p[31], reading_.dt_);
            } else {
                if (((p_.p[((46 + i_))] == (real)32.0))) {
                    slopes_begin(belief_, i_, (tuple_4){{1, 3}}, p_.p[32], reading_.dt_);
                }
            }
        }
    }
    bool t4 = aekf_differentiate_2(belief_, reading_, p_, scratch_, record_);
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
GM_STATIC tuple_4 sample_loop_run_slopes_2(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(5);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start_2(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            aekf_resume(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described_2(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim_2(belief_, reading_, p_);
        }
        bool t22 = slopes_step_2(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany_2(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(5, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate_2(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_3(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_srukf(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(6);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(belief_, reading_, p_);
        }
        bool t22 = srukf_step(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(6, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_2(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_srukf_2(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(5);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start_2(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described_2(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim_2(belief_, reading_, p_);
        }
        bool t22 = srukf_step_2(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany_2(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(5, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate_2(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_3(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_ukf(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(6);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim(belief_, reading_, p_);
        }
        bool t22 = ukf_step(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(6, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_2(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/sample_loop.py:565 run */
GM_STATIC tuple_4 sample_loop_run_ukf_2(LoopSettings settings_, array1_f8 p_, Stream stream_, LoopState state_, Belief belief_, Scratch scratch_, Output output_)
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
    tuple_6 t1 = step_record_places(5);
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
                return (tuple_4){{(k_ + 1), n_smoothed_}};
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
            sample_loop_start_2(belief_, y1_, y2_, p_, (array1_f8){ring_.p + 0 * (ring_.n[1]), {ring_.n[1]}});
            ring_.p[(ring_.n[1] - 1)] = u_;
            filter_kind_forget(memory_);
            consider_restart(companions_);
            ring_stamps_.p[0] = stamp_;
            return (tuple_4){{(k_ + 1), n_smoothed_}};
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
        real t21 = sample_loop_described_2(described_, (load_measured_ ? efforts_.p[((acting_) * efforts_.n[1] + 1)] : (real)0.0), (array1_f8){inputs_.p + (k_) * (inputs_.n[1]), {inputs_.n[1]}}, (tuple_43){place_, dt_}, state_, belief_, p_);
        load_ = t21;
        reading_ = (Reading){dt_, u_acting_, load_, y1_, y2_};
        record_ = (array1_f8){ring_.p + (gm_mod(step_, rows_)) * (ring_.n[1]), {ring_.n[1]}};
        record_.p[(at_innovation_)] = (real)0.0;
        record_.p[((at_innovation_ + 1))] = (real)0.0;
        record_.p[(at_S_)] = (real)0.0;
        record_.p[((at_S_ + 2))] = (real)0.0;
        if (((step_ == 1))) {
            sample_loop_aim_2(belief_, reading_, p_);
        }
        bool t22 = ukf_step_2(belief_, reading_, p_, scratch_, record_);
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
        tuple_17 t28 = filter_kind_unchanged(memory_, p_);
        bool t29 = consider_accompany_2(companions_, saved_, reading_, t28, record_);
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
        real t33 = sample_loop_usually(e1_, clock_.p[1]);
        clock_.p[1] = t33;
        real t34 = sample_loop_usually(e2_, clock_.p[2]);
        clock_.p[2] = t34;
        record_.p[(record_.n[0] - 1)] = u_acting_;
        if ((narrow_ && ((p_.p[26] == (real)0.0)))) {
            sample_loop_watch(5, record_, clock_);
        }
        real t35 = sample_loop_noise_share(clock_);
        share_ = t35;
        sample_loop_write_estimate_2(belief_, record_, reading_, p_, share_, (array1_f8){estimates_.p + (k_) * (estimates_.n[1]), {estimates_.n[1]}});
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
                rts_smoother_smooth_3(ring_, (Span){step_, oldest_, t39}, p_, (array1_f8){scratch_.vectors_.p + 0 * (scratch_.vectors_.n[1]), {scratch_.vectors_.n[1]}}, scratch_.matrices_, (array2_f8){smoothed_.p + t37 * (smoothed_.n[1]), {t38, smoothed_.n[1]}});
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
            return (tuple_4){{(k_ + 1), n_smoothed_}};
        }
    }
    return (tuple_4){{stamps_.n[0], n_smoothed_}};
}

/* estimation/process_model.py:336 begin_curve */
GM_INLINE void process_model_begin_curve_5(Layout layout_, array1_f8 z_, array1_f8 p_)
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

/* estimation/sample_loop.py:385 start */
GM_STATIC void sample_loop_start_5(Layout layout_, Belief belief_, real y1_, real y2_, array1_f8 p_, array1_f8 record_)
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
    process_model_begin_curve_5(layout_, z_, p_);
    tuple_6 t5 = step_record_places(n_);
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

/* estimation/whiteness.py:17 _centre */
GM_STATIC int64_t whiteness_centre(array1_f8 column_, array1_f8 out_)
{
    int64_t at_;
    real total_;
    int64_t i_;
    real mean_;
    at_ = 20;
    total_ = (real)0.0;
    for (int64_t k1 = 0; k1 < column_.n[0]; k1 += 1) {
        i_ = k1;
        if ((bool)isfinite(column_.p[(i_)])) {
            out_.p[(at_)] = column_.p[(i_)];
            total_ = (total_ + column_.p[(i_)]);
            at_ = (at_ + 1);
        }
    }
    mean_ = (total_ / (real)((at_ - 20)));
    int64_t t2 = at_;
    for (int64_t k3 = 20; k3 < t2; k3 += 1) {
        i_ = k3;
        out_.p[(i_)] = (out_.p[(i_)] - mean_);
    }
    return at_;
}

/* monitoring/checks/elastic_curve.py:190 _stretches */
GM_STATIC void elastic_curve_stretches(array1_f8 twist_, real width_, real side_, array1_f8 stretch_)
{
    real memory_;
    int64_t i_;
    memory_ = (twist_.p[0] - (side_ * width_));
    for (int64_t k1 = 0; k1 < twist_.n[0]; k1 += 1) {
        i_ = k1;
        memory_ = gm_min_f(gm_max_f(memory_, (twist_.p[(i_)] - width_)), (twist_.p[(i_)] + width_));
        stretch_.p[(i_)] = (twist_.p[(i_)] - memory_);
    }
    return;
}

/* monitoring/checks/innovation.py:76 _finite_sum */
GM_STATIC tuple_44 innovation_finite_sum(array1_f8 column_)
{
    real total_;
    int64_t count_;
    int64_t i_;
    total_ = (real)0.0;
    count_ = 0;
    for (int64_t k1 = 0; k1 < column_.n[0]; k1 += 1) {
        i_ = k1;
        if ((bool)isfinite(column_.p[(i_)])) {
            total_ = (total_ + column_.p[(i_)]);
            count_ = (count_ + 1);
        }
    }
    return (tuple_44){total_, count_};
}

/* monitoring/checks/innovation.py:87 _sizes */
GM_STATIC tuple_15 innovation_sizes(array2_f8 errors_, array2_f8 stds_, int64_t newest_)
{
    int64_t n_;
    real motor_;
    real arm_;
    real largest_;
    int64_t c_;
    real total_;
    int64_t count_;
    int64_t i_;
    real ratio_;
    n_ = errors_.n[0];
    motor_ = (real)1.0;
    arm_ = (real)1.0;
    largest_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 2; k1 += 1) {
        c_ = k1;
        total_ = (real)0.0;
        count_ = 0;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            i_ = k2;
            if ((bool)isfinite(errors_.p[((i_) * errors_.n[1] + (c_))])) {
                ratio_ = (errors_.p[((i_) * errors_.n[1] + (c_))] / stds_.p[((i_) * stds_.n[1] + (c_))]);
                total_ = (total_ + (ratio_ * ratio_));
                count_ = (count_ + 1);
                if (((i_ >= (n_ - newest_)))) {
                    largest_ = gm_max_f(largest_, gm_fabs(ratio_));
                }
            }
        }
        if ((((count_ >= 100)) && ((c_ == 0)))) {
            motor_ = (total_ / (real)(count_));
        } else {
            if (((count_ >= 100))) {
                arm_ = (total_ / (real)(count_));
            }
        }
    }
    return (tuple_15){{motor_, arm_, largest_}};
}

/* monitoring/checks/observability.py:88 _braked */
GM_INLINE tuple_7 observability_braked(real rate_)
{
    real speed_;
    if ((!((gm_fabs(rate_) > (real)1e-06)))) {
        return (tuple_7){{(real)1.0, (real)1.0}};
    }
    speed_ = (((real)1.0 - gm_exp((-rate_))) / rate_);
    return (tuple_7){{speed_, (((real)2.0 * ((real)1.0 - speed_)) / rate_)}};
}

/* monitoring/checks/observability.py:46 _gramian */
GM_STATIC void observability_gramian(array2_f8 states_, array1_f8 dts_, array2_b1 measured_, array1_f8 p_, array2_f8 gramian_, array2_f8 product_, array2_f8 slope_)
{
    int64_t n_;
    real omega_;
    int64_t i_;
    int64_t j_;
    int64_t k_;
    int64_t c_;
    real r_;
    array1_f8 z_;
    int64_t count_;
    real h_;
    real motor_speed_;
    real motor_way_;
    real arm_speed_;
    real arm_way_;
    real motor_;
    real arm_;
    n_ = states_.n[1];
    omega_ = gm_sqrt((p_.p[26] * (p_.p[0] + p_.p[1])));
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            j_ = k2;
            product_.p[((i_) * product_.n[1] + (j_))] = (((i_ == j_)) ? (real)1.0 : (real)0.0);
            gramian_.p[((i_) * gramian_.n[1] + (j_))] = (real)0.0;
        }
    }
    for (int64_t k3 = 0; k3 < states_.n[0]; k3 += 1) {
        k_ = k3;
        for (int64_t k4 = 0; k4 < 2; k4 += 1) {
            c_ = k4;
            if (measured_.p[((k_) * measured_.n[1] + (c_))]) {
                r_ = (((c_ == 0)) ? p_.p[31] : p_.p[32]);
                for (int64_t k5 = 0; k5 < n_; k5 += 1) {
                    i_ = k5;
                    for (int64_t k6 = 0; k6 < n_; k6 += 1) {
                        j_ = k6;
                        gramian_.p[((i_) * gramian_.n[1] + (j_))] = (gramian_.p[((i_) * gramian_.n[1] + (j_))] + ((product_.p[((c_) * product_.n[1] + (i_))] * product_.p[((c_) * product_.n[1] + (j_))]) / r_));
                    }
                }
            }
        }
        z_ = (array1_f8){states_.p + (k_) * (states_.n[1]), {states_.n[1]}};
        count_ = (1 + (int64_t)((dts_.p[(k_)] * omega_)));
        h_ = (dts_.p[(k_)] / (real)(count_));
        real t7 = drive_motor_friction_slope(z_.p[2], z_.p[4], p_);
        tuple_7 t8 = observability_braked(((h_ * (t7 + p_.p[2])) * p_.p[0]));
        motor_speed_ = t8.v[0];
        motor_way_ = t8.v[1];
        tuple_7 t9 = drive_arm_load_slopes(z_.p[1], z_.p[3], p_);
        tuple_7 t10 = observability_braked(((h_ * t9.v[1]) * p_.p[1]));
        arm_speed_ = t10.v[0];
        arm_way_ = t10.v[1];
        for (int64_t k11 = 0; k11 < count_; k11 += 1) {
            process_model_tangent(z_, product_, p_, slope_);
            for (int64_t k12 = 0; k12 < n_; k12 += 1) {
                j_ = k12;
                real t13 = (h_ * slope_.p[(2 * slope_.n[1] + (j_))]);
                real t14 = (h_ * slope_.p[(3 * slope_.n[1] + (j_))]);
                motor_ = t13;
                arm_ = t14;
                product_.p[(j_)] = (product_.p[(j_)] + (h_ * (product_.p[(2 * product_.n[1] + (j_))] + (((real)0.5 * motor_way_) * motor_))));
                product_.p[(1 * product_.n[1] + (j_))] = (product_.p[(1 * product_.n[1] + (j_))] + (h_ * (product_.p[(3 * product_.n[1] + (j_))] + (((real)0.5 * arm_way_) * arm_))));
                product_.p[(2 * product_.n[1] + (j_))] = (product_.p[(2 * product_.n[1] + (j_))] + (motor_speed_ * motor_));
                product_.p[(3 * product_.n[1] + (j_))] = (product_.p[(3 * product_.n[1] + (j_))] + (arm_speed_ * arm_));
                product_.p[(4 * product_.n[1] + (j_))] = (product_.p[(4 * product_.n[1] + (j_))] + ((h_ * slope_.p[(4 * slope_.n[1] + (j_))]) + ((((real)0.5 * h_) * p_.p[26]) * ((motor_way_ * motor_) - (arm_way_ * arm_)))));
                for (int64_t k15 = 5; k15 < n_; k15 += 1) {
                    i_ = k15;
                    product_.p[((i_) * product_.n[1] + (j_))] = (product_.p[((i_) * product_.n[1] + (j_))] + (h_ * slope_.p[((i_) * slope_.n[1] + (j_))]));
                }
            }
        }
    }
    return;
}

/* monitoring/elastic_regression.py:71 normal_equations */
GM_STATIC tuple_7 elastic_regression_normal_equations(array1_f8 theta_, array1_b1 free_, ElasticLaw law_, array2_f8 data_, array1_f8 weights_, array1_f8 units_, tuple_45 blocks_, array1_f8 residuals_)
{
    real k_;
    real b_;
    real zero_;
    real r_;
    real per_width_;
    real spring_;
    real sign_;
    real lower_;
    array3_f8 normal_;
    array2_f8 right_;
    array2_f8 room_;
    array1_f8 slope_;
    array1_f8 last_;
    array1_f8 part_;
    real w_;
    real side_;
    real x2_carried_;
    real x4_carried_;
    real error_last_;
    real cost_;
    int64_t contacts_;
    bool paired_;
    real share_;
    real elastic_share_;
    int64_t j_;
    int64_t p_;
    real error_;
    int64_t i_;
    real x2_;
    real x4_;
    real x3_;
    real u_;
    real friction_;
    real z_;
    real stretch_;
    real load_;
    real flank_;
    real steep_;
    real of_stretch_;
    real elastic_;
    real torque_;
    real viscous_;
    real coulomb_;
    real damping_;
    real missing_;
    real both_;
    real e_;
    real size_;
    real weight_;
    int64_t at_;
    real weighted_;
    int64_t q_;
    real t1 = theta_.p[0];
    real t2 = theta_.p[1];
    real t3 = theta_.p[3];
    real t4 = gm_fabs(theta_.p[2]);
    k_ = t1;
    b_ = t2;
    zero_ = t3;
    r_ = t4;
    per_width_ = ((law_.by_height_ && ((r_ > (real)0.0))) ? ((real)1.0 / r_) : (real)0.0);
    spring_ = (theta_.p[7] * (law_.by_height_ ? per_width_ : (real)1.0));
    real t5 = (law_.passive_ ? (real)0.0 : (real)1.0);
    sign_ = (real)1.0;
    lower_ = t5;
    if (((theta_.p[2] < (real)0.0))) {
        real t6 = (-lower_);
        sign_ = (real)(-1.0);
        lower_ = t6;
    }
    normal_ = blocks_.f0;
    right_ = blocks_.f1;
    room_ = blocks_.f2;
    slope_ = (array1_f8){room_.p + 0 * (room_.n[1]), {room_.n[1]}};
    last_ = (array1_f8){room_.p + 1 * (room_.n[1]), {room_.n[1]}};
    part_ = (array1_f8){room_.p + 2 * (room_.n[1]), {room_.n[1]}};
    real t7 = data_.p[2];
    real t8 = data_.p[3];
    w_ = (real)0.0;
    side_ = law_.side_;
    x2_carried_ = t7;
    x4_carried_ = t8;
    bool t9 = (!law_.paired_);
    error_last_ = (real)0.0;
    cost_ = (real)0.0;
    contacts_ = 0;
    paired_ = t9;
    share_ = ((law_.paired_ ? (real)0.5 : (real)1.0) / (real)(law_.group_));
    elastic_share_ = ((real)1.0 - theta_.p[10]);
    for (int64_t k10 = 0; k10 < residuals_.n[0]; k10 += 1) {
        j_ = k10;
        for (int64_t k11 = 0; k11 < 11; k11 += 1) {
            p_ = k11;
            slope_.p[(p_)] = (real)0.0;
        }
        error_ = (real)0.0;
        int64_t t12 = (j_ * law_.group_);
        int64_t t13 = ((j_ + 1) * law_.group_);
        for (int64_t k14 = t12; k14 < t13; k14 += 1) {
            i_ = k14;
            real t15 = data_.p[(gm_at(i_, data_.n[0]) * data_.n[1] + 2)];
            real t16 = data_.p[(gm_at(i_, data_.n[0]) * data_.n[1] + 3)];
            real t17 = data_.p[(gm_at(i_, data_.n[0]) * data_.n[1] + 4)];
            real t18 = data_.p[(gm_at(i_, data_.n[0]) * data_.n[1] + 6)];
            real t19 = data_.p[(gm_at(i_, data_.n[0]) * data_.n[1] + 5)];
            x2_ = t15;
            x4_ = t16;
            x3_ = t17;
            u_ = t18;
            friction_ = t19;
            z_ = (((data_.p[(gm_at(i_, data_.n[0]) * data_.n[1] + 0)] - zero_) - (theta_.p[8] * x2_)) - (theta_.p[9] * x4_));
            if (((i_ == 0))) {
                w_ = (z_ - (side_ * r_));
            }
            if (((((z_ - w_) > r_)) || (((w_ - z_) > r_)))) {
                side_ = (((z_ > w_)) ? (real)1.0 : (real)(-1.0));
                real t20 = (z_ - (side_ * r_));
                w_ = t20;
                x2_carried_ = x2_;
                x4_carried_ = x4_;
            }
            stretch_ = (z_ - w_);
            real t21 = transmission_dead_zone((z_ - (lower_ * stretch_)), b_);
            load_ = t21;
            flank_ = (((load_ > (real)0.0)) ? (real)1.0 : (((load_ < (real)0.0)) ? (real)(-1.0) : (real)0.0));
            if (((load_ != (real)0.0))) {
                contacts_ = (contacts_ + 1);
            }
            steep_ = (k_ * gm_fabs(flank_));
            of_stretch_ = (spring_ - (lower_ * steep_));
            elastic_ = ((k_ * load_) + (spring_ * stretch_));
            slope_.p[0] = (slope_.p[0] + (elastic_share_ * load_));
            slope_.p[1] = (slope_.p[1] - ((elastic_share_ * k_) * flank_));
            slope_.p[2] = (slope_.p[2] + ((elastic_share_ * sign_) * ((of_stretch_ * side_) - ((spring_ * per_width_) * stretch_))));
            slope_.p[3] = (slope_.p[3] - (elastic_share_ * steep_));
            slope_.p[7] = (slope_.p[7] + ((elastic_share_ * stretch_) * (law_.by_height_ ? per_width_ : (real)1.0)));
            slope_.p[8] = (slope_.p[8] - (elastic_share_ * ((steep_ * x2_) + (of_stretch_ * (x2_ - x2_carried_)))));
            slope_.p[9] = (slope_.p[9] - (elastic_share_ * ((steep_ * x4_) + (of_stretch_ * (x4_ - x4_carried_)))));
            slope_.p[4] = (slope_.p[4] + x3_);
            slope_.p[5] = (slope_.p[5] + friction_);
            slope_.p[6] = (slope_.p[6] + u_);
            torque_ = (((elastic_ + (theta_.p[4] * x3_)) + (theta_.p[5] * friction_)) + (theta_.p[6] * u_));
            if (free_.p[10]) {
                viscous_ = law_.friction_.v[0];
                coulomb_ = law_.friction_.v[1];
                damping_ = law_.friction_.v[2];
                missing_ = ((((u_ - elastic_) - (damping_ * data_.p[(gm_at(i_, data_.n[0]) * data_.n[1] + 1)])) - (viscous_ * x3_)) - (coulomb_ * friction_));
                slope_.p[10] = (slope_.p[10] + missing_);
                torque_ = (torque_ + (theta_.p[10] * missing_));
            }
            error_ = (error_ + (data_.p[(gm_at(i_, data_.n[0]) * data_.n[1] + 7)] - torque_));
        }
        residuals_.p[(j_)] = (real)0.0;
        if (((side_ == (real)0.0))) {
            continue;
        }
        both_ = (share_ * units_.p[(j_)]);
        for (int64_t k22 = 0; k22 < 11; k22 += 1) {
            p_ = k22;
            part_.p[(p_)] = (both_ * (slope_.p[(p_)] + last_.p[(p_)]));
            if (law_.paired_) {
                last_.p[(p_)] = slope_.p[(p_)];
            }
        }
        e_ = (both_ * (error_ + error_last_));
        if (law_.paired_) {
            error_last_ = error_;
            if ((!paired_)) {
                paired_ = true;
                continue;
            }
        }
        residuals_.p[(j_)] = e_;
        size_ = gm_fabs(e_);
        weight_ = (weights_.p[(j_)] / gm_max_f((real)1.0, (size_ / law_.huber_)));
        cost_ = (cost_ + (weights_.p[(j_)] * (((size_ < law_.huber_)) ? (e_ * e_) : (law_.huber_ * (((real)2.0 * size_) - law_.huber_)))));
        at_ = gm_div(j_, law_.block_);
        for (int64_t k23 = 0; k23 < 11; k23 += 1) {
            p_ = k23;
            if (free_.p[(p_)]) {
                weighted_ = (weight_ * part_.p[(p_)]);
                right_.p[(gm_at(at_, right_.n[0]) * right_.n[1] + (p_))] = (right_.p[(gm_at(at_, right_.n[0]) * right_.n[1] + (p_))] + (weighted_ * e_));
                int64_t t24 = (p_ + 1);
                for (int64_t k25 = 0; k25 < t24; k25 += 1) {
                    q_ = k25;
                    if (free_.p[(q_)]) {
                        normal_.p[((gm_at(at_, normal_.n[0]) * normal_.n[1] + (p_)) * normal_.n[2] + (q_))] = (normal_.p[((gm_at(at_, normal_.n[0]) * normal_.n[1] + (p_)) * normal_.n[2] + (q_))] + (weighted_ * part_.p[(q_)]));
                    }
                }
            }
        }
    }
    for (int64_t k26 = 0; k26 < normal_.n[0]; k26 += 1) {
        at_ = k26;
        for (int64_t k27 = 0; k27 < 11; k27 += 1) {
            p_ = k27;
            int64_t t28 = p_;
            for (int64_t k29 = 0; k29 < t28; k29 += 1) {
                q_ = k29;
                normal_.p[((gm_at(at_, normal_.n[0]) * normal_.n[1] + (q_)) * normal_.n[2] + (p_))] = normal_.p[((gm_at(at_, normal_.n[0]) * normal_.n[1] + (p_)) * normal_.n[2] + (q_))];
            }
        }
    }
    return (tuple_7){{cost_, ((real)(contacts_) / (real)(gm_max_i(data_.n[0], 1)))}};
}

/* monitoring/elastic_regression.py:204 _evaluated */
GM_STATIC real elastic_regression_evaluated(array1_f8 theta_, array1_b1 free_, Problem problem_, Room room_, array2_f8 normal_, array1_f8 right_)
{
    array3_f8 normals_;
    array2_f8 rights_;
    array2_f8 sums_;
    array1_f8 at_;
    bool beyond_;
    real cost_;
    int64_t p_;
    real x_;
    int64_t k_;
    int64_t q_;
    normals_ = room_.blocks_.f0;
    rights_ = room_.blocks_.f1;
    sums_ = room_.blocks_.f2;
    at_ = (array1_f8){room_.vectors_.p + 0 * (room_.vectors_.n[1]), {room_.vectors_.n[1]}};
    beyond_ = false;
    cost_ = (real)0.0;
    for (int64_t k1 = 0; k1 < 11; k1 += 1) {
        p_ = k1;
        x_ = theta_.p[(p_)];
        if (((x_ < problem_.low_.p[(p_)]))) {
            x_ = problem_.low_.p[(p_)];
        } else {
            if (((x_ > problem_.high_.p[(p_)]))) {
                x_ = problem_.high_.p[(p_)];
            }
        }
        if (free_.p[(p_)]) {
            beyond_ = (beyond_ | ((x_ != theta_.p[(p_)])));
            cost_ = (cost_ + ((problem_.prior_.p[(p_)] * x_) * x_));
        }
        real t2 = x_;
        real t3 = (problem_.base_.p[(p_)] + x_);
        theta_.p[(p_)] = t2;
        at_.p[(p_)] = t3;
        for (int64_t k4 = 0; k4 < sums_.n[0]; k4 += 1) {
            k_ = k4;
            sums_.p[((k_) * sums_.n[1] + (p_))] = (real)0.0;
        }
        for (int64_t k5 = 0; k5 < rights_.n[0]; k5 += 1) {
            k_ = k5;
            rights_.p[((k_) * rights_.n[1] + (p_))] = (real)0.0;
            for (int64_t k6 = 0; k6 < 11; k6 += 1) {
                q_ = k6;
                normals_.p[(((k_) * normals_.n[1] + (p_)) * normals_.n[2] + (q_))] = (real)0.0;
            }
        }
    }
    real t8 = cost_;
    tuple_7 t7 = elastic_regression_normal_equations(at_, free_, problem_.law_, problem_.data_, problem_.weights_, problem_.units_, room_.blocks_, room_.residuals_);
    cost_ = (t8 + t7.v[0]);
    for (int64_t k9 = 0; k9 < 11; k9 += 1) {
        p_ = k9;
        right_.p[(p_)] = (free_.p[(p_)] ? ((-problem_.prior_.p[(p_)]) * theta_.p[(p_)]) : (real)0.0);
        for (int64_t k10 = 0; k10 < 11; k10 += 1) {
            q_ = k10;
            normal_.p[((p_) * normal_.n[1] + (q_))] = ((((p_ == q_)) && free_.p[(p_)]) ? problem_.prior_.p[(p_)] : (real)0.0);
        }
        for (int64_t k11 = 0; k11 < rights_.n[0]; k11 += 1) {
            k_ = k11;
            right_.p[(p_)] = (right_.p[(p_)] + rights_.p[((k_) * rights_.n[1] + (p_))]);
            for (int64_t k12 = 0; k12 < 11; k12 += 1) {
                q_ = k12;
                normal_.p[((p_) * normal_.n[1] + (q_))] = (normal_.p[((p_) * normal_.n[1] + (q_))] + normals_.p[(((k_) * normals_.n[1] + (p_)) * normals_.n[2] + (q_))]);
            }
        }
    }
    return ((problem_.strict_ && beyond_) ? INFINITY : cost_);
}

/* monitoring/elastic_regression.py:239 _step */
GM_STATIC bool elastic_regression_step(array2_f8 normal_, array1_f8 right_, real damping_, Damping rule_, array2_f8 factor_, array1_f8 step_)
{
    int64_t i_;
    real added_;
    int64_t j_;
    real value_;
    int64_t k_;
    for (int64_t k1 = 0; k1 < 11; k1 += 1) {
        i_ = k1;
        added_ = ((normal_.p[((i_) * normal_.n[1] + (i_))] * (damping_ + rule_.relative_)) + rule_.absolute_);
        step_.p[(i_)] = right_.p[(i_)];
        int64_t t2 = (i_ + 1);
        for (int64_t k3 = 0; k3 < t2; k3 += 1) {
            j_ = k3;
            value_ = normal_.p[((i_) * normal_.n[1] + (j_))];
            if (((i_ == j_))) {
                value_ = (value_ + (((added_ > (real)0.0)) ? added_ : (real)1.0));
            }
            int64_t t4 = j_;
            for (int64_t k5 = 0; k5 < t4; k5 += 1) {
                k_ = k5;
                value_ = (value_ - (factor_.p[((i_) * factor_.n[1] + (k_))] * factor_.p[((j_) * factor_.n[1] + (k_))]));
            }
            if (((i_ > j_))) {
                factor_.p[((i_) * factor_.n[1] + (j_))] = (value_ / factor_.p[((j_) * factor_.n[1] + (j_))]);
                step_.p[(i_)] = (step_.p[(i_)] - (factor_.p[((i_) * factor_.n[1] + (j_))] * step_.p[(j_)]));
            } else {
                if (((value_ > (real)0.0))) {
                    factor_.p[((i_) * factor_.n[1] + (i_))] = gm_sqrt(value_);
                } else {
                    return false;
                }
            }
        }
        step_.p[(i_)] = (step_.p[(i_)] / factor_.p[((i_) * factor_.n[1] + (i_))]);
    }
    for (int64_t k6 = 10; k6 > (-1); k6 += -1) {
        i_ = k6;
        int64_t t7 = (i_ + 1);
        for (int64_t k8 = t7; k8 < 11; k8 += 1) {
            j_ = k8;
            step_.p[(i_)] = (step_.p[(i_)] - (factor_.p[((j_) * factor_.n[1] + (i_))] * step_.p[(j_)]));
        }
        step_.p[(i_)] = (step_.p[(i_)] / factor_.p[((i_) * factor_.n[1] + (i_))]);
    }
    return true;
}

/* monitoring/elastic_regression.py:267 _minimise */
GM_STATIC void elastic_regression_minimise(array1_f8 theta_, array1_b1 free_, Problem problem_, Damping rule_, real tolerance_, int64_t iterations_, Room room_)
{
    array2_f8 normal_;
    array2_f8 next_normal_;
    array2_f8 factor_;
    array1_f8 right_;
    array1_f8 next_right_;
    array1_f8 trial_;
    real cost_;
    real damping_;
    int64_t failures_;
    real gain_;
    int64_t p_;
    int64_t q_;
    bool solved_;
    normal_ = (array2_f8){room_.normals_.p + 0 * (room_.normals_.n[1] * room_.normals_.n[2]), {room_.normals_.n[1], room_.normals_.n[2]}};
    next_normal_ = (array2_f8){room_.normals_.p + 1 * (room_.normals_.n[1] * room_.normals_.n[2]), {room_.normals_.n[1], room_.normals_.n[2]}};
    factor_ = (array2_f8){room_.normals_.p + 2 * (room_.normals_.n[1] * room_.normals_.n[2]), {room_.normals_.n[1], room_.normals_.n[2]}};
    right_ = (array1_f8){room_.vectors_.p + 1 * (room_.vectors_.n[1]), {room_.vectors_.n[1]}};
    next_right_ = (array1_f8){room_.vectors_.p + 2 * (room_.vectors_.n[1]), {room_.vectors_.n[1]}};
    trial_ = (array1_f8){room_.vectors_.p + 3 * (room_.vectors_.n[1]), {room_.vectors_.n[1]}};
    real t1 = elastic_regression_evaluated(theta_, free_, problem_, room_, normal_, right_);
    cost_ = t1;
    damping_ = rule_.start_;
    failures_ = 0;
    for (int64_t k2 = 0; k2 < iterations_; k2 += 1) {
        gain_ = (-INFINITY);
        bool t3 = elastic_regression_step(normal_, right_, damping_, rule_, factor_, trial_);
        if (t3) {
            for (int64_t k4 = 0; k4 < 11; k4 += 1) {
                p_ = k4;
                trial_.p[(p_)] = (trial_.p[(p_)] + theta_.p[(p_)]);
            }
            real t6 = cost_;
            real t5 = elastic_regression_evaluated(trial_, free_, problem_, room_, next_normal_, next_right_);
            gain_ = (t6 - t5);
        }
        if ((((gain_ > (real)0.0)) || (rule_.level_ && ((gain_ == (real)0.0))))) {
            for (int64_t k7 = 0; k7 < 11; k7 += 1) {
                p_ = k7;
                real t8 = trial_.p[(p_)];
                real t9 = next_right_.p[(p_)];
                theta_.p[(p_)] = t8;
                right_.p[(p_)] = t9;
                for (int64_t k10 = 0; k10 < 11; k10 += 1) {
                    q_ = k10;
                    normal_.p[((p_) * normal_.n[1] + (q_))] = next_normal_.p[((p_) * next_normal_.n[1] + (q_))];
                }
            }
            solved_ = ((gain_ <= (tolerance_ * cost_)));
            cost_ = (cost_ - gain_);
            real t11 = gm_max_f((damping_ * rule_.lowered_), rule_.smallest_);
            damping_ = t11;
            failures_ = 0;
        } else {
            damping_ = gm_min_f(gm_max_f((damping_ * rule_.raised_), rule_.raised_from_), rule_.largest_);
            failures_ = (failures_ + 1);
            solved_ = (((failures_ >= rule_.attempts_)) || ((damping_ > rule_.hopeless_)));
        }
        if (solved_) {
            break;
        }
    }
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE motor_encoder_eccentricity composition_two_15(array1_f8 e_)
{
    return (motor_encoder_eccentricity){e_.p[32], e_.p[33]};
}

/* plant/effects/encoder.py:13 eccentricity_error */
GM_INLINE tuple_15 encoder_eccentricity_error_3(motor_encoder_eccentricity c_, real x_)
{
    real error_;
    error_ = (c_.A_ * gm_sin((x_ + c_.phi_)));
    return (tuple_15){{error_, (c_.A_ * gm_cos((x_ + c_.phi_))), (-error_)}};
}

/* plant/effects/composition.py:153 _moved.<locals>._term */
GM_INLINE real composition_term_31(real position_, array1_f8 e_)
{
    if (((e_.p[32] != (real)0.0))) {
        real t3 = position_;
        motor_encoder_eccentricity t1 = composition_two_15(e_);
        tuple_15 t2 = encoder_eccentricity_error_3(t1, position_);
        position_ = (t3 + ((real)1.0 * t2.v[0]));
    }
    return position_;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE motor_encoder_eccentricity composition_two_16(array1_f8 e_)
{
    return (motor_encoder_eccentricity){e_.p[36], e_.p[37]};
}

/* plant/effects/encoder.py:13 eccentricity_error */
GM_INLINE tuple_15 encoder_eccentricity_error_4(motor_encoder_eccentricity c_, real x_)
{
    real error_;
    error_ = (c_.A_ * gm_sin((x_ + c_.phi_)));
    return (tuple_15){{error_, (c_.A_ * gm_cos((x_ + c_.phi_))), (-error_)}};
}

/* plant/effects/composition.py:153 _moved.<locals>._term */
GM_INLINE real composition_term_32(real position_, array1_f8 e_)
{
    if (((e_.p[36] != (real)0.0))) {
        real t3 = position_;
        motor_encoder_eccentricity t1 = composition_two_16(e_);
        tuple_15 t2 = encoder_eccentricity_error_4(t1, position_);
        position_ = (t3 + ((real)1.0 * t2.v[0]));
    }
    return position_;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE encoder_offset composition_one_10(array1_f8 e_)
{
    return (encoder_offset){e_.p[40]};
}

/* plant/effects/encoder.py:94 offset_error */
GM_INLINE tuple_15 encoder_offset_error_2(encoder_offset c_, real x_)
{
    return (tuple_15){{c_.c_, (real)0.0, (real)0.0}};
}

/* plant/effects/composition.py:153 _moved.<locals>._term */
GM_INLINE real composition_term_33(real position_, array1_f8 e_)
{
    if (((e_.p[40] != (real)0.0))) {
        real t3 = position_;
        encoder_offset t1 = composition_one_10(e_);
        tuple_15 t2 = encoder_offset_error_2(t1, position_);
        position_ = (t3 + ((real)1.0 * t2.v[0]));
    }
    return position_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_21(real value_, tuple_27 arguments_)
{
    real t1 = composition_term_32(value_, arguments_.f0);
    real t2 = composition_term_33(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:481 reading */
GM_STATIC real composition_reading(array2_f8 x_, int64_t k_, int64_t i_, real dt_, array1_f8 e_)
{
    real delay_;
    real position_;
    real f_;
    int64_t j_;
    real a_;
    real b_;
    real va_;
    real vb_;
    delay_ = ((((i_ == 0)) ? e_.p[35] : e_.p[39]) / dt_);
    position_ = x_.p[(gm_at(k_, x_.n[0]) * x_.n[1] + (i_))];
    if (((delay_ > (real)0.0))) {
        f_ = ((real)((int64_t)gm_ceil(delay_)) - delay_);
        j_ = (k_ - (int64_t)gm_ceil(delay_));
        if (((j_ < 0))) {
            position_ = x_.p[(i_)];
        } else {
            real t1 = x_.p[(gm_at(j_, x_.n[0]) * x_.n[1] + (i_))];
            real t2 = x_.p[(gm_at((j_ + 1), x_.n[0]) * x_.n[1] + (i_))];
            a_ = t1;
            b_ = t2;
            real t3 = (x_.p[(gm_at(j_, x_.n[0]) * x_.n[1] + ((2 + i_)))] * dt_);
            real t4 = (x_.p[(gm_at((j_ + 1), x_.n[0]) * x_.n[1] + ((2 + i_)))] * dt_);
            va_ = t3;
            vb_ = t4;
            position_ = (a_ + (f_ * (va_ + (f_ * (((((real)3.0 * (b_ - a_)) - ((real)2.0 * va_)) - vb_) + (f_ * ((((real)2.0 * (a_ - b_)) + va_) + vb_)))))));
        }
    }
    real t7;
    if (((i_ == 0))) {
    real t5 = composition_term_31(position_, e_);
        t7 = t5;
    } else {
    real t6 = composition_both_21(position_, (tuple_27){e_});
        t7 = t6;
    }
    return t7;
}

/* plant/batch.py:357 runs */
GM_STATIC void batch_runs(RunSpans spans_, Begin start_, Driving driving_, PackedDrive drive_, array1_f8 s_, array3_f8 path_, RunResult result_)
{
    array1_i8 begin_;
    array1_i8 first_;
    int64_t length_;
    array1_i8 carry_at_;
    array1_i8 extra_at_;
    array2_f8 u_;
    array2_f8 extra_;
    real dt_;
    int64_t n_;
    real h_;
    int64_t last_;
    int64_t form_;
    int64_t group_;
    int64_t longest_;
    int64_t i_;
    int64_t w_;
    int64_t j_;
    int64_t k_;
    int64_t at_;
    int64_t part_;
    array2_f8 rows_;
    int64_t lead_;
    begin_ = spans_.begin_;
    first_ = spans_.first_;
    length_ = spans_.length_;
    carry_at_ = spans_.carry_at_;
    extra_at_ = spans_.extra_at_;
    u_ = driving_.u_;
    extra_ = driving_.extra_;
    dt_ = driving_.dt_;
    n_ = u_.n[1];
    real t1 = (dt_ / (real)(n_));
    int64_t t2 = (begin_.n[0] - 1);
    h_ = t1;
    last_ = t2;
    int64_t t3 = batch_step_form(drive_);
    form_ = t3;
    for (int64_t k4 = 0; k4 < begin_.n[0]; k4 += 16) {
        group_ = k4;
        longest_ = 0;
        for (int64_t k5 = 0; k5 < 16; k5 += 1) {
            i_ = k5;
            w_ = gm_min_i((group_ + i_), last_);
            longest_ = gm_max_i(longest_, (first_.p[gm_at(w_, first_.n[0])] - begin_.p[gm_at(w_, begin_.n[0])]));
            for (int64_t k6 = 0; k6 < 4; k6 += 1) {
                j_ = k6;
                s_.p[(((0 + (16 * j_)) + i_))] = start_.states_.p[(gm_at(w_, start_.states_.n[0]) * start_.states_.n[1] + (j_))];
            }
            for (int64_t k7 = 0; k7 < 8; k7 += 1) {
                j_ = k7;
                s_.p[(((64 + (16 * j_)) + i_))] = start_.memory_.p[(gm_at(w_, start_.memory_.n[0]) * start_.memory_.n[1] + (j_))];
            }
        }
        int64_t t8 = ((longest_ + length_) + 1);
        for (int64_t k9 = 0; k9 < t8; k9 += 1) {
            k_ = k9;
            for (int64_t k10 = 0; k10 < 16; k10 += 1) {
                i_ = k10;
                w_ = gm_min_i((group_ + i_), last_);
                at_ = (begin_.p[gm_at(w_, begin_.n[0])] + k_);
                if (((at_ == carry_at_.p[gm_at(w_, carry_at_.n[0])]))) {
                    for (int64_t k11 = 0; k11 < 12; k11 += 1) {
                        j_ = k11;
                        result_.carry_.p[(gm_at(w_, result_.carry_.n[0]) * result_.carry_.n[1] + (j_))] = s_.p[(((0 + (16 * j_)) + i_))];
                    }
                }
                s_.p[((192 + i_))] = ((real)(at_) * dt_);
                at_ = gm_min_i((extra_at_.p[gm_at(w_, extra_at_.n[0])] + k_), (extra_.n[0] - 1));
                for (int64_t k12 = 0; k12 < 3; k12 += 1) {
                    j_ = k12;
                    s_.p[(((224 + (16 * j_)) + i_))] = extra_.p[(gm_at(at_, extra_.n[0]) * extra_.n[1] + (j_))];
                }
            }
            if (((k_ == (longest_ + length_)))) {
                break;
            }
            for (int64_t k13 = 0; k13 < 16; k13 += 1) {
                i_ = k13;
                for (int64_t k14 = 0; k14 < 4; k14 += 1) {
                    j_ = k14;
                    path_.p[(((i_) * path_.n[1] + (k_)) * path_.n[2] + (j_))] = s_.p[(((0 + (16 * j_)) + i_))];
                }
            }
            for (int64_t k15 = 0; k15 < n_; k15 += 1) {
                part_ = k15;
                for (int64_t k16 = 0; k16 < 16; k16 += 1) {
                    i_ = k16;
                    s_.p[((208 + i_))] = u_.p[(gm_at(gm_min_i((begin_.p[gm_at(gm_min_i((group_ + i_), last_), begin_.n[0])] + k_), (u_.n[0] - 1)), u_.n[0]) * u_.n[1] + (part_))];
                }
                batch_step_lanes(s_, h_, form_, drive_);
            }
        }
        int64_t t17 = gm_min_i((group_ + 16), (last_ + 1));
        for (int64_t k18 = group_; k18 < t17; k18 += 1) {
            w_ = k18;
            int64_t t19 = (first_.p[gm_at(w_, first_.n[0])] - begin_.p[gm_at(w_, begin_.n[0])]);
            rows_ = (array2_f8){path_.p + gm_at((w_ - group_), path_.n[0]) * (path_.n[1] * path_.n[2]), {path_.n[1], path_.n[2]}};
            lead_ = t19;
            for (int64_t k20 = 0; k20 < length_; k20 += 1) {
                k_ = k20;
                real t21 = composition_reading(rows_, (lead_ + k_), 0, dt_, drive_.e_);
                result_.y_.p[((gm_at(w_, result_.y_.n[0]) * result_.y_.n[1] + (k_)) * result_.y_.n[2] + 0)] = t21;
                real t22 = composition_reading(rows_, (lead_ + k_), 1, dt_, drive_.e_);
                result_.y_.p[((gm_at(w_, result_.y_.n[0]) * result_.y_.n[1] + (k_)) * result_.y_.n[2] + 1)] = t22;
            }
        }
    }
    return;
}

/* plant/effects/composition.py:436 actuator */
GM_STATIC real composition_actuator(array1_f8 u_, int64_t past_, real act_, real dt_, array1_f8 e_, array2_f8 out_)
{
    int64_t n_;
    real h_;
    real lag_;
    real delay_;
    real fade_;
    real share_;
    int64_t k_;
    int64_t i_;
    real command_;
    real begin_;
    int64_t first_;
    int64_t last_;
    real over_;
    n_ = out_.n[1];
    h_ = (dt_ / (real)(n_));
    real t1 = (e_.p[26] + e_.p[24]);
    real t2 = (e_.p[27] + e_.p[23]);
    lag_ = t1;
    delay_ = t2;
    fade_ = (((lag_ > (real)0.0)) ? gm_exp(((-h_) / lag_)) : (real)0.0);
    share_ = ((lag_ / h_) * ((real)1.0 - fade_));
    for (int64_t k3 = 0; k3 < out_.n[0]; k3 += 1) {
        k_ = k3;
        for (int64_t k4 = 0; k4 < n_; k4 += 1) {
            i_ = k4;
            command_ = u_.p[gm_at((past_ + k_), u_.n[0])];
            if (((delay_ > (real)0.0))) {
                begin_ = ((((real)(i_) * h_) - delay_) / dt_);
                first_ = (int64_t)gm_floor(begin_);
                last_ = (int64_t)gm_floor((begin_ + ((real)1.0 / (real)(n_))));
                command_ = u_.p[(gm_max_i(0, ((past_ + k_) + first_)))];
                if (((last_ > first_))) {
                    over_ = (((begin_ + ((real)1.0 / (real)(n_))) - (real)(last_)) * (real)(n_));
                    command_ = (command_ + (over_ * (u_.p[(gm_max_i(0, ((past_ + k_) + last_)))] - command_)));
                }
            }
            if (((e_.p[75] == (real)0.0))) {
                real t5 = composition_both(command_, (tuple_27){e_});
                command_ = t5;
            }
            if (((lag_ > (real)0.0))) {
                out_.p[((k_) * out_.n[1] + (i_))] = (((e_.p[82] != (real)0.0)) ? act_ : (command_ + ((act_ - command_) * share_)));
                act_ = (command_ + ((act_ - command_) * fade_));
            } else {
                real t6 = command_;
                out_.p[((k_) * out_.n[1] + (i_))] = t6;
                act_ = t6;
            }
        }
    }
    return act_;
}

/* plant/effects/composition.py:409 lead */
GM_STATIC void composition_lead(array1_f8 r_, array1_f8 past_, real dt_, array1_f8 e_)
{
    real kp_;
    real ki_;
    int64_t k_;
    real slope_;
    real earlier_;
    real torque_;
    real ahead_;
    if ((((e_.p[80] == (real)0.0)) && ((e_.p[81] == (real)0.0)))) {
        return;
    }
    real t1 = e_.p[75];
    real t2 = e_.p[78];
    kp_ = t1;
    ki_ = t2;
    for (int64_t k3 = 0; k3 < r_.n[0]; k3 += 1) {
        k_ = k3;
        real t4 = ((r_.p[(k_)] - past_.p[0]) / dt_);
        real t5 = ((past_.p[0] - past_.p[1]) / dt_);
        slope_ = t4;
        earlier_ = t5;
        torque_ = ((e_.p[80] * slope_) + ((e_.p[81] * (slope_ - earlier_)) / dt_));
        real t6 = past_.p[0];
        real t7 = r_.p[(k_)];
        past_.p[1] = t6;
        past_.p[0] = t7;
        ahead_ = ((torque_ - (ki_ * past_.p[2])) / (kp_ + (((real)0.5 * ki_) * dt_)));
        past_.p[2] = (past_.p[2] + (ahead_ * dt_));
        r_.p[(k_)] = (r_.p[(k_)] + ahead_);
    }
    return;
}

/* plant/effects/composition.py:403 steady_command */
GM_STATIC real composition_steady_command(real u_, array1_f8 e_)
{
    real t2;
    if (((e_.p[75] != (real)0.0))) {
        t2 = u_;
    } else {
    real t1 = composition_both(u_, (tuple_27){e_});
        t2 = t1;
    }
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_7 composition_term_34(tuple_31 memories_, array1_f8 state_)
{
    return (tuple_7){{memories_.f0, state_.p[5]}};
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_15 composition_term_35(tuple_7 memories_, array1_f8 state_)
{
    return (tuple_15){{memories_.v[0], memories_.v[1], state_.p[6]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_15 composition_both_27(tuple_31 value_, tuple_27 arguments_)
{
    tuple_7 t1 = composition_term_34(value_, arguments_.f0);
    tuple_15 t2 = composition_term_35(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_9 composition_term_36(tuple_15 memories_, array1_f8 state_)
{
    return (tuple_9){{memories_.v[0], memories_.v[1], memories_.v[2], state_.p[7]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_9 composition_both_26(tuple_31 value_, tuple_27 arguments_)
{
    tuple_15 t1 = composition_both_27(value_, (tuple_27){arguments_.f0});
    tuple_9 t2 = composition_term_36(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_8 composition_term_37(tuple_9 memories_, array1_f8 state_)
{
    return (tuple_8){{memories_.v[0], memories_.v[1], memories_.v[2], memories_.v[3], state_.p[8]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_8 composition_both_25(tuple_31 value_, tuple_27 arguments_)
{
    tuple_9 t1 = composition_both_26(value_, (tuple_27){arguments_.f0});
    tuple_8 t2 = composition_term_37(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_33 composition_term_38(tuple_8 memories_, array1_f8 state_)
{
    return (tuple_33){{memories_.v[0], memories_.v[1], memories_.v[2], memories_.v[3], memories_.v[4], state_.p[9]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_33 composition_both_24(tuple_31 value_, tuple_27 arguments_)
{
    tuple_8 t1 = composition_both_25(value_, (tuple_27){arguments_.f0});
    tuple_33 t2 = composition_term_38(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_14 composition_term_39(tuple_33 memories_, array1_f8 state_)
{
    return (tuple_14){{memories_.v[0], memories_.v[1], memories_.v[2], memories_.v[3], memories_.v[4], memories_.v[5], state_.p[10]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_14 composition_both_23(tuple_31 value_, tuple_27 arguments_)
{
    tuple_33 t1 = composition_both_24(value_, (tuple_27){arguments_.f0});
    tuple_14 t2 = composition_term_39(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:183 _stored.<locals>._term */
GM_INLINE tuple_34 composition_term_40(tuple_14 memories_, array1_f8 state_)
{
    return (tuple_34){{memories_.v[0], memories_.v[1], memories_.v[2], memories_.v[3], memories_.v[4], memories_.v[5], memories_.v[6], state_.p[11]}};
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE tuple_34 composition_both_22(tuple_31 value_, tuple_27 arguments_)
{
    tuple_14 t1 = composition_both_23(value_, (tuple_27){arguments_.f0});
    tuple_34 t2 = composition_term_40(t1, arguments_.f0);
    return t2;
}

/* plant/effects/composition.py:376 stored_memories */
GM_INLINE tuple_34 composition_stored_memories_2(array1_f8 state_)
{
    tuple_34 t1 = composition_both_22((tuple_31){state_.p[4]}, (tuple_27){state_});
    return t1;
}

/* plant/equivalent_torque.py:35 torque_difference */
GM_STATIC tuple_7 equivalent_torque_torque_difference(real t_, array1_f8 state_, real u_, tuple_15 extra_, tuple_42 drives_)
{
    PackedDrive closed_;
    PackedDrive expressed_;
    tuple_9 x_;
    tuple_34 m_;
    tuple_9 target_;
    tuple_9 own_;
    closed_ = drives_.v[0];
    expressed_ = drives_.v[1];
    real t2 = state_.p[0];
    real t3 = state_.p[1];
    real t4 = state_.p[2];
    real t5 = state_.p[3];
    tuple_34 t1 = composition_stored_memories_2(state_);
    x_ = (tuple_9){{t2, t3, t4, t5}};
    m_ = t1;
    tuple_9 t6 = simulate_derivative(t_, x_, m_, (tuple_35){u_, extra_, closed_});
    target_ = t6;
    tuple_9 t7 = simulate_derivative(t_, x_, m_, (tuple_35){u_, extra_, expressed_});
    own_ = t7;
    return (tuple_7){{((target_.v[2] - own_.v[2]) / expressed_.p_.p[0]), ((target_.v[3] - own_.v[3]) / expressed_.p_.p[1])}};
}

/* plant/simulate.py:242 advance */
GM_STATIC void simulate_advance(array1_f8 state_, real t_, real dt_, array1_f8 u_, tuple_15 extra_, array2_f8 numbers_, array1_f8 std_, PackedDrive drive_, real tolerance_)
{
    int64_t n_;
    array1_f8 p_;
    real h_;
    real root_h_;
    tuple_9 x_;
    tuple_34 m_;
    int64_t i_;
    tuple_35 inputs_;
    int64_t at_;
    int64_t size_;
    real begin_;
    real length_;
    tuple_9 whole_;
    tuple_9 y_;
    tuple_34 w_;
    int64_t part_;
    tuple_9 change_;
    real error_;
    n_ = u_.n[0];
    p_ = drive_.p_;
    h_ = (dt_ / (real)(n_));
    root_h_ = gm_sqrt(h_);
    x_ = (tuple_9){{state_.p[0], state_.p[1], state_.p[2], state_.p[3]}};
    tuple_34 t1 = composition_stored_memories_2(state_);
    m_ = t1;
    for (int64_t k2 = 0; k2 < n_; k2 += 1) {
        i_ = k2;
        inputs_ = (tuple_35){u_.p[(i_)], extra_, drive_};
        at_ = 0;
        size_ = 256;
        for (;;) {
            if (!((at_ < 256))) break;
            real t3 = (t_ + ((h_ * (real)(at_)) / (real)256.0));
            real t4 = ((h_ * (real)(size_)) / (real)256.0);
            begin_ = t3;
            length_ = t4;
            real t5 = x_.v[0];
            real t6 = x_.v[1];
            real t7 = x_.v[2];
            real t8 = x_.v[3];
            real t9 = x_.v[0];
            real t10 = x_.v[1];
            real t11 = x_.v[2];
            real t12 = x_.v[3];
            real t13 = m_.v[0];
            real t14 = m_.v[1];
            real t15 = m_.v[2];
            real t16 = m_.v[3];
            real t17 = m_.v[4];
            real t18 = m_.v[5];
            real t19 = m_.v[6];
            real t20 = m_.v[7];
            whole_ = (tuple_9){{t5, t6, t7, t8}};
            y_ = (tuple_9){{t9, t10, t11, t12}};
            w_ = (tuple_34){{t13, t14, t15, t16, t17, t18, t19, t20}};
            int64_t t21 = (((tolerance_ > (real)0.0)) ? 3 : 1);
            for (int64_t k22 = 0; k22 < t21; k22 += 1) {
                part_ = k22;
                if (((part_ == 1))) {
                    real t23 = y_.v[0];
                    real t24 = y_.v[1];
                    real t25 = y_.v[2];
                    real t26 = y_.v[3];
                    real t27 = x_.v[0];
                    real t28 = x_.v[1];
                    real t29 = x_.v[2];
                    real t30 = x_.v[3];
                    real t31 = m_.v[0];
                    real t32 = m_.v[1];
                    real t33 = m_.v[2];
                    real t34 = m_.v[3];
                    real t35 = m_.v[4];
                    real t36 = m_.v[5];
                    real t37 = m_.v[6];
                    real t38 = m_.v[7];
                    real t39 = ((real)0.5 * length_);
                    whole_ = (tuple_9){{t23, t24, t25, t26}};
                    y_ = (tuple_9){{t27, t28, t29, t30}};
                    w_ = (tuple_34){{t31, t32, t33, t34, t35, t36, t37, t38}};
                    length_ = t39;
                } else {
                    if (((part_ == 2))) {
                        begin_ = (begin_ + length_);
                    }
                }
                tuple_41 t40 = runge_kutta_step_2(begin_, y_, w_, length_, inputs_);
                change_ = t40.f0;
                w_ = t40.f1;
                y_ = (tuple_9){{(y_.v[0] + change_.v[0]), (y_.v[1] + change_.v[1]), (y_.v[2] + change_.v[2]), (y_.v[3] + change_.v[3])}};
                real t41 = simulate_play_after(y_, w_, p_);
                w_ = (tuple_34){{t41, w_.v[1], w_.v[2], w_.v[3], w_.v[4], w_.v[5], w_.v[6], w_.v[7]}};
            }
            error_ = (real)0.0;
            if (((tolerance_ > (real)0.0))) {
                error_ = gm_max_f(gm_max_f(gm_max_f(gm_fabs((y_.v[0] - whole_.v[0])), gm_fabs((y_.v[1] - whole_.v[1]))), gm_fabs((y_.v[2] - whole_.v[2]))), gm_fabs((y_.v[3] - whole_.v[3])));
            }
            if ((((size_ > 1)) && (!((error_ <= tolerance_))))) {
                size_ = (size_ / 2);
                continue;
            }
            real t42 = y_.v[0];
            real t43 = y_.v[1];
            real t44 = y_.v[2];
            real t45 = y_.v[3];
            real t46 = w_.v[0];
            real t47 = w_.v[1];
            real t48 = w_.v[2];
            real t49 = w_.v[3];
            real t50 = w_.v[4];
            real t51 = w_.v[5];
            real t52 = w_.v[6];
            real t53 = w_.v[7];
            x_ = (tuple_9){{t42, t43, t44, t45}};
            m_ = (tuple_34){{t46, t47, t48, t49, t50, t51, t52, t53}};
            at_ = (at_ + size_);
            if ((((error_ <= ((real)0.03125 * tolerance_))) && (((at_ % (2 * size_)) == 0)))) {
                size_ = (size_ * 2);
            }
        }
        if ((((((std_.p[0] + std_.p[1]) + std_.p[2]) + std_.p[3]) > (real)0.0))) {
            x_ = (tuple_9){{(x_.v[0] + ((root_h_ * std_.p[0]) * numbers_.p[((i_) * numbers_.n[1] + 0)])), (x_.v[1] + ((root_h_ * std_.p[1]) * numbers_.p[((i_) * numbers_.n[1] + 1)])), (x_.v[2] + ((root_h_ * std_.p[2]) * numbers_.p[((i_) * numbers_.n[1] + 2)])), (x_.v[3] + ((root_h_ * std_.p[3]) * numbers_.p[((i_) * numbers_.n[1] + 3)]))}};
            real t54 = simulate_play_after(x_, m_, p_);
            m_ = (tuple_34){{t54, m_.v[1], m_.v[2], m_.v[3], m_.v[4], m_.v[5], m_.v[6], m_.v[7]}};
        }
        t_ = (t_ + h_);
    }
    state_.p[0] = x_.v[0];
    state_.p[1] = x_.v[1];
    state_.p[2] = x_.v[2];
    state_.p[3] = x_.v[3];
    for (int64_t k55 = 0; k55 < 8; k55 += 1) {
        i_ = k55;
        state_.p[((4 + i_))] = m_.v[(i_)];
    }
    return;
}

/* plant/equivalent_torque.py:59 _run */
GM_STATIC void equivalent_torque_run(array1_f8 state_, Schedule schedule_, ProcessNoise noise_, tuple_42 drives_, array2_f8 torque_)
{
    array1_f8 t_;
    array2_f8 u_;
    array2_f8 extra_;
    real dt_;
    int64_t n_;
    real h_;
    int64_t k_;
    tuple_15 external_;
    int64_t i_;
    real at_;
    tuple_7 first_;
    tuple_7 second_;
    t_ = schedule_.t_;
    u_ = schedule_.u_;
    extra_ = schedule_.extra_;
    dt_ = schedule_.dt_;
    n_ = u_.n[1];
    h_ = (dt_ / (real)(n_));
    for (int64_t k1 = 0; k1 < u_.n[0]; k1 += 1) {
        k_ = k1;
        external_ = (tuple_15){{extra_.p[((k_) * extra_.n[1] + 0)], extra_.p[((k_) * extra_.n[1] + 1)], extra_.p[((k_) * extra_.n[1] + 2)]}};
        torque_.p[((k_) * torque_.n[1] + 0)] = external_.v[0];
        torque_.p[((k_) * torque_.n[1] + 1)] = external_.v[1];
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            i_ = k2;
            at_ = (t_.p[(k_)] + ((real)(i_) * h_));
            tuple_7 t3 = equivalent_torque_torque_difference(at_, state_, u_.p[((k_) * u_.n[1] + (i_))], external_, drives_);
            first_ = t3;
            int64_t t4 = (i_ + 1);
            int64_t t5 = gm_bound(i_, u_.n[1]);
            int64_t t6 = gm_bound(t4, u_.n[1]);
            int64_t t7 = gm_span(t5, t6);
            simulate_advance(state_, at_, h_, (array1_f8){u_.p + (k_) * (u_.n[1]) + t5 * (1), {t7}}, external_, (array2_f8){noise_.numbers_.p + 0 * (noise_.numbers_.n[1] * noise_.numbers_.n[2]), {noise_.numbers_.n[1], noise_.numbers_.n[2]}}, noise_.std_, drives_.v[0], (real)0.0);
            tuple_7 t8 = equivalent_torque_torque_difference((at_ + h_), state_, u_.p[((k_) * u_.n[1] + (i_))], external_, drives_);
            second_ = t8;
            torque_.p[((k_) * torque_.n[1] + 0)] = (torque_.p[((k_) * torque_.n[1] + 0)] + ((u_.p[((k_) * u_.n[1] + (i_))] + ((real)0.5 * (first_.v[0] + second_.v[0]))) / (real)(n_)));
            torque_.p[((k_) * torque_.n[1] + 1)] = (torque_.p[((k_) * torque_.n[1] + 1)] + (((real)0.5 * (first_.v[1] + second_.v[1])) / (real)(n_)));
        }
    }
    return;
}

/* plant/effects/composition.py:82 term_of.<locals>._three */
GM_INLINE mesh_error composition_three_7(array1_f8 e_)
{
    return (mesh_error){e_.p[29], e_.p[30], e_.p[31]};
}

/* plant/effects/actuator.py:141 ripple_gain */
GM_INLINE real actuator_ripple_gain_3(mesh_error c_, real x1_)
{
    real t1 = elementary_sine(((c_.N_ * x1_) + c_.phi_));
    return ((real)1.0 + (c_.A_ * t1));
}

/* plant/effects/composition.py:131 _motor_gain.<locals>._term */
GM_INLINE real composition_term_41(real gain_, array1_f8 e_, real x1_)
{
    if (((e_.p[29] != (real)0.0))) {
        real t3 = gain_;
        mesh_error t1 = composition_three_7(e_);
        real t2 = actuator_ripple_gain_3(t1, x1_);
        gain_ = (t3 * t2);
    }
    return gain_;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE torque_gain composition_one_11(array1_f8 e_)
{
    return (torque_gain){e_.p[25]};
}

/* plant/effects/actuator.py:24 gain_of_command */
GM_INLINE real actuator_gain_of_command(torque_gain c_, real x1_)
{
    return ((real)1.0 + c_.g_);
}

/* plant/effects/composition.py:131 _motor_gain.<locals>._term */
GM_INLINE real composition_term_42(real gain_, array1_f8 e_, real x1_)
{
    if (((e_.p[25] != (real)0.0))) {
        real t3 = gain_;
        torque_gain t1 = composition_one_11(e_);
        real t2 = actuator_gain_of_command(t1, x1_);
        gain_ = (t3 * t2);
    }
    return gain_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_28(real value_, tuple_17 arguments_)
{
    real t1 = composition_term_41(value_, arguments_.f0, arguments_.f1);
    real t2 = composition_term_42(t1, arguments_.f0, arguments_.f1);
    return t2;
}

/* plant/equivalent_torque.py:180 gains */
GM_STATIC void equivalent_torque_gains(array1_f8 x1_, array1_f8 e_, array1_f8 out_)
{
    int64_t k_;
    for (int64_t k1 = 0; k1 < x1_.n[0]; k1 += 1) {
        k_ = k1;
        real t2 = composition_both_28((real)1.0, (tuple_17){e_, x1_.p[(k_)]});
        out_.p[(k_)] = t2;
    }
    return;
}

/* plant/equivalent_torque.py:78 lacking_twist */
GM_STATIC real equivalent_torque_lacking_twist(real lacks_, real x1_, real x2_, tuple_34 m_, tuple_7 sizes_, PackedDrive drive_)
{
    array1_f8 p_;
    array1_f8 e_;
    real size_;
    real torque_;
    real sign_;
    real here_;
    real near_;
    real slope_;
    real secant_;
    real low_;
    real high_;
    real middle_;
    p_ = drive_.p_;
    e_ = drive_.e_;
    size_ = sizes_.v[0];
    torque_ = sizes_.v[1];
    sign_ = (((lacks_ > (real)0.0)) ? (real)1.0 : (real)(-1.0));
    real t1 = composition_elastic_torque(x1_, x2_, m_, p_, e_);
    real t2 = ((real)0.1 * size_);
    here_ = t1;
    near_ = t2;
    real t3 = composition_elastic_torque(x1_, (x2_ - near_), m_, p_, e_);
    real t4 = composition_elastic_torque(x1_, (x2_ + near_), m_, p_, e_);
    slope_ = ((t3 - t4) / ((real)2.0 * near_));
    secant_ = (((real)0.1 * torque_) / size_);
    real t5 = ((sign_ * lacks_) / gm_sqrt(((slope_ * slope_) + (secant_ * secant_))));
    low_ = (real)0.0;
    high_ = t5;
    real t6 = composition_elastic_torque(x1_, (x2_ - (sign_ * high_)), m_, p_, e_);
    if ((((sign_ * ((t6 - here_) - lacks_)) < (real)0.0))) {
        return (sign_ * high_);
    }
    for (int64_t k7 = 0; k7 < 12; k7 += 1) {
        middle_ = ((real)0.5 * (low_ + high_));
        real t8 = composition_elastic_torque(x1_, (x2_ - (sign_ * middle_)), m_, p_, e_);
        if ((((sign_ * ((t8 - here_) - lacks_)) < (real)0.0))) {
            low_ = middle_;
        } else {
            high_ = middle_;
        }
    }
    return ((sign_ * (real)0.5) * (low_ + high_));
}

/* plant/equivalent_torque.py:115 imbalance */
GM_STATIC void equivalent_torque_imbalance(tuple_46 path_, real step_, tuple_7 sizes_, array1_f8 torque_, array2_f8 extra_, PackedDrive drive_, array1_f8 state_, array2_f8 out_)
{
    array1_f8 t_;
    array2_f8 motion_;
    array1_f8 p_;
    array1_f8 e_;
    MotorFriction base_;
    int64_t k_;
    tuple_34 m_;
    tuple_9 x_;
    int64_t i_;
    tuple_9 rate_;
    t_ = path_.f0;
    motion_ = path_.f1;
    p_ = drive_.p_;
    e_ = drive_.e_;
    base_ = (MotorFriction){p_.p[3], p_.p[4], p_.p[5], p_.p[20]};
    for (int64_t k1 = 0; k1 < t_.n[0]; k1 += 1) {
        k_ = k1;
        tuple_34 t2 = composition_stored_memories_2(state_);
        m_ = t2;
        x_ = (tuple_9){{motion_.p[((k_) * motion_.n[1] + 0)], motion_.p[((k_) * motion_.n[1] + 1)], motion_.p[((k_) * motion_.n[1] + 2)], motion_.p[((k_) * motion_.n[1] + 3)]}};
        if ((((step_ > (real)0.0)) && ((k_ > 0)))) {
            tuple_34 t3 = composition_advanced_memories(m_, (tuple_15){{(real)0.0, (real)0.0, (real)0.0}}, ((real)0.5 * (motion_.p[(gm_at((k_ - 1), motion_.n[0]) * motion_.n[1] + 2)] + x_.v[2])), ((real)0.5 * (motion_.p[(gm_at((k_ - 1), motion_.n[0]) * motion_.n[1] + 3)] + x_.v[3])), step_, base_, e_);
            m_ = t3;
            real t4 = simulate_play_after(x_, m_, p_);
            state_.p[4] = t4;
            int64_t t5 = (state_.n[0] - 4);
            for (int64_t k6 = 1; k6 < t5; k6 += 1) {
                i_ = k6;
                state_.p[((4 + i_))] = m_.v[(i_)];
            }
            tuple_34 t7 = composition_stored_memories_2(state_);
            m_ = t7;
        }
        tuple_9 t8 = simulate_derivative(t_.p[(k_)], x_, m_, (tuple_35){torque_.p[(k_)], (tuple_15){{extra_.p[((k_) * extra_.n[1] + 0)], extra_.p[((k_) * extra_.n[1] + 1)], extra_.p[((k_) * extra_.n[1] + 2)]}}, drive_});
        rate_ = t8;
        out_.p[((k_) * out_.n[1] + 1)] = ((motion_.p[((k_) * motion_.n[1] + 5)] - rate_.v[3]) / p_.p[1]);
        out_.p[((k_) * out_.n[1] + 0)] = (((motion_.p[((k_) * motion_.n[1] + 4)] - rate_.v[2]) / p_.p[0]) + out_.p[((k_) * out_.n[1] + 1)]);
        if ((((step_ > (real)0.0)) && (((int64_t)(p_.p[8]) != 3)))) {
            real t9 = equivalent_torque_lacking_twist(out_.p[((k_) * out_.n[1] + 1)], x_.v[0], x_.v[1], m_, sizes_, drive_);
            out_.p[((k_) * out_.n[1] + 2)] = t9;
        }
    }
    return;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE motor_encoder_eccentricity composition_two_17(array1_f8 e_)
{
    return (motor_encoder_eccentricity){e_.p[32], e_.p[33]};
}

/* plant/effects/encoder.py:13 eccentricity_error */
GM_INLINE tuple_15 encoder_eccentricity_error_5(motor_encoder_eccentricity c_, real x_)
{
    real error_;
    error_ = (c_.A_ * gm_sin((x_ + c_.phi_)));
    return (tuple_15){{error_, (c_.A_ * gm_cos((x_ + c_.phi_))), (-error_)}};
}

/* plant/effects/composition.py:153 _moved.<locals>._term */
GM_INLINE real composition_term_43(real position_, array1_f8 e_)
{
    if (((e_.p[32] != (real)0.0))) {
        real t3 = position_;
        motor_encoder_eccentricity t1 = composition_two_17(e_);
        tuple_15 t2 = encoder_eccentricity_error_5(t1, position_);
        position_ = (t3 + ((real)(-1.0) * t2.v[0]));
    }
    return position_;
}

/* plant/effects/composition.py:76 term_of.<locals>._one */
GM_INLINE encoder_offset composition_one_12(array1_f8 e_)
{
    return (encoder_offset){e_.p[40]};
}

/* plant/effects/encoder.py:94 offset_error */
GM_INLINE tuple_15 encoder_offset_error_3(encoder_offset c_, real x_)
{
    return (tuple_15){{c_.c_, (real)0.0, (real)0.0}};
}

/* plant/effects/composition.py:153 _moved.<locals>._term */
GM_INLINE real composition_term_44(real position_, array1_f8 e_)
{
    if (((e_.p[40] != (real)0.0))) {
        real t3 = position_;
        encoder_offset t1 = composition_one_12(e_);
        tuple_15 t2 = encoder_offset_error_3(t1, position_);
        position_ = (t3 + ((real)(-1.0) * t2.v[0]));
    }
    return position_;
}

/* plant/effects/composition.py:79 term_of.<locals>._two */
GM_INLINE motor_encoder_eccentricity composition_two_18(array1_f8 e_)
{
    return (motor_encoder_eccentricity){e_.p[36], e_.p[37]};
}

/* plant/effects/encoder.py:13 eccentricity_error */
GM_INLINE tuple_15 encoder_eccentricity_error_6(motor_encoder_eccentricity c_, real x_)
{
    real error_;
    error_ = (c_.A_ * gm_sin((x_ + c_.phi_)));
    return (tuple_15){{error_, (c_.A_ * gm_cos((x_ + c_.phi_))), (-error_)}};
}

/* plant/effects/composition.py:153 _moved.<locals>._term */
GM_INLINE real composition_term_45(real position_, array1_f8 e_)
{
    if (((e_.p[36] != (real)0.0))) {
        real t3 = position_;
        motor_encoder_eccentricity t1 = composition_two_18(e_);
        tuple_15 t2 = encoder_eccentricity_error_6(t1, position_);
        position_ = (t3 + ((real)(-1.0) * t2.v[0]));
    }
    return position_;
}

/* plant/effects/composition.py:98 chained.<locals>._joined.<locals>._both */
GM_INLINE real composition_both_29(real value_, tuple_27 arguments_)
{
    real t1 = composition_term_44(value_, arguments_.f0);
    real t2 = composition_term_45(t1, arguments_.f0);
    return t2;
}

/* plant/equivalent_torque.py:152 true_motion */
GM_STATIC void equivalent_torque_true_motion(array2_f8 read_, real dt_, array1_f8 e_, array2_f8 out_)
{
    int64_t n_;
    int64_t side_;
    real late_;
    int64_t k_;
    int64_t i_;
    real h_;
    real y_;
    real v_;
    real a_;
    real error_;
    real slope_;
    real curvature_;
    n_ = read_.n[0];
    for (int64_t k1 = 0; k1 < 2; k1 += 1) {
        side_ = k1;
        late_ = (e_.p[((((side_ == 0)) ? 35 : 39))] / dt_);
        for (int64_t k2 = 0; k2 < n_; k2 += 1) {
            k_ = k2;
            i_ = gm_min_i((int64_t)(((real)(k_) + late_)), (n_ - 1));
            h_ = (((((real)(k_) + late_) < (real)(n_))) ? ((((real)(k_) + late_) - (real)(i_)) * dt_) : (real)0.0);
            real t3 = read_.p[(gm_at(i_, read_.n[0]) * read_.n[1] + (side_))];
            real t4 = read_.p[(gm_at(i_, read_.n[0]) * read_.n[1] + ((2 + side_)))];
            real t5 = read_.p[(gm_at(i_, read_.n[0]) * read_.n[1] + ((4 + side_)))];
            y_ = t3;
            v_ = t4;
            a_ = t5;
            real t6 = (y_ + (h_ * (v_ + (((real)0.5 * h_) * a_))));
            real t7 = (v_ + (h_ * a_));
            y_ = t6;
            v_ = t7;
            a_ = (a_ + ((h_ / dt_) * (read_.p[(gm_at(gm_min_i((i_ + 1), (n_ - 1)), read_.n[0]) * read_.n[1] + ((4 + side_)))] - a_)));
            if (((side_ == 0))) {
                real t8 = composition_term_43(y_, e_);
                tuple_15 t9 = composition_term((tuple_15){{(real)0.0, (real)0.0, (real)0.0}}, e_, t8);
                error_ = t9.v[0];
                slope_ = t9.v[1];
                curvature_ = t9.v[2];
            } else {
                real t10 = composition_both_29(y_, (tuple_27){e_});
                tuple_15 t11 = composition_both_20((tuple_15){{(real)0.0, (real)0.0, (real)0.0}}, (tuple_17){e_, t10});
                error_ = t11.v[0];
                slope_ = t11.v[1];
                curvature_ = t11.v[2];
            }
            real t12 = (y_ - error_);
            real t13 = (v_ * ((real)1.0 - slope_));
            out_.p[((k_) * out_.n[1] + (side_))] = t12;
            out_.p[((k_) * out_.n[1] + ((2 + side_)))] = t13;
            out_.p[((k_) * out_.n[1] + ((4 + side_)))] = ((a_ * ((real)1.0 - slope_)) - ((curvature_ * v_) * v_));
        }
    }
    return;
}

/* plant/free_runs.py:57 free_runs */
GM_STATIC void free_runs_free_runs(RunSpans spans_, Begin start_, Driving driving_, PackedDrive drive_, ProcessNoise noise_, array2_f8 rows_, RunResult result_)
{
    array1_i8 begin_;
    array1_i8 first_;
    int64_t length_;
    array1_i8 carry_at_;
    array1_i8 extra_at_;
    array2_f8 u_;
    array2_f8 extra_;
    real dt_;
    array3_f8 y_;
    array2_f8 carry_;
    int64_t w_;
    array1_f8 state_;
    int64_t i_;
    array2_f8 path_;
    int64_t lead_;
    int64_t k_;
    array1_f8 row_;
    tuple_15 external_;
    begin_ = spans_.begin_;
    first_ = spans_.first_;
    length_ = spans_.length_;
    carry_at_ = spans_.carry_at_;
    extra_at_ = spans_.extra_at_;
    u_ = driving_.u_;
    extra_ = driving_.extra_;
    dt_ = driving_.dt_;
    y_ = result_.y_;
    carry_ = result_.carry_;
    for (int64_t k1 = 0; k1 < begin_.n[0]; k1 += 1) {
        w_ = k1;
        state_ = (array1_f8){rows_.p + 0 * (rows_.n[1]), {rows_.n[1]}};
        for (int64_t k2 = 0; k2 < 4; k2 += 1) {
            i_ = k2;
            state_.p[(i_)] = start_.states_.p[((w_) * start_.states_.n[1] + (i_))];
        }
        for (int64_t k3 = 0; k3 < 8; k3 += 1) {
            i_ = k3;
            state_.p[((4 + i_))] = start_.memory_.p[((w_) * start_.memory_.n[1] + (i_))];
        }
        int64_t t4 = gm_bound(1, rows_.n[0]);
        int64_t t5 = gm_span(t4, rows_.n[0]);
        path_ = (array2_f8){rows_.p + t4 * (rows_.n[1]), {t5, rows_.n[1]}};
        lead_ = (first_.p[(w_)] - begin_.p[(w_)]);
        int64_t t6 = begin_.p[(w_)];
        int64_t t7 = (first_.p[(w_)] + length_);
        for (int64_t k8 = t6; k8 < t7; k8 += 1) {
            k_ = k8;
            for (int64_t k9 = 0; k9 < 12; k9 += 1) {
                i_ = k9;
                path_.p[(gm_at((k_ - begin_.p[(w_)]), path_.n[0]) * path_.n[1] + (i_))] = state_.p[(i_)];
            }
            if (((k_ == carry_at_.p[(w_)]))) {
                for (int64_t k10 = 0; k10 < 12; k10 += 1) {
                    i_ = k10;
                    carry_.p[((w_) * carry_.n[1] + (i_))] = state_.p[(i_)];
                }
            }
            row_ = (array1_f8){extra_.p + gm_at(((extra_at_.p[(w_)] + k_) - begin_.p[(w_)]), extra_.n[0]) * (extra_.n[1]), {extra_.n[1]}};
            external_ = (tuple_15){{row_.p[0], row_.p[1], row_.p[2]}};
            simulate_advance(state_, ((real)(k_) * dt_), dt_, (array1_f8){u_.p + gm_at(k_, u_.n[0]) * (u_.n[1]), {u_.n[1]}}, external_, (array2_f8){noise_.numbers_.p + 0 * (noise_.numbers_.n[1] * noise_.numbers_.n[2]), {noise_.numbers_.n[1], noise_.numbers_.n[2]}}, noise_.std_, drive_, (real)0.0);
        }
        if (((carry_at_.p[(w_)] == (first_.p[(w_)] + length_)))) {
            for (int64_t k11 = 0; k11 < 12; k11 += 1) {
                i_ = k11;
                carry_.p[((w_) * carry_.n[1] + (i_))] = state_.p[(i_)];
            }
        }
        for (int64_t k12 = 0; k12 < length_; k12 += 1) {
            k_ = k12;
            real t13 = composition_reading(path_, (lead_ + k_), 0, dt_, drive_.e_);
            y_.p[(((w_) * y_.n[1] + gm_at(k_, y_.n[1])) * y_.n[2] + 0)] = t13;
            real t14 = composition_reading(path_, (lead_ + k_), 1, dt_, drive_.e_);
            y_.p[(((w_) * y_.n[1] + gm_at(k_, y_.n[1])) * y_.n[2] + 1)] = t14;
        }
    }
    return;
}

/* plant/simulate.py:307 _run */
GM_STATIC void simulate_run(array1_f8 state_, Schedule schedule_, ProcessNoise noise_, PackedDrive drive_, array2_f8 x_, array2_f8 tau_, real tolerance_)
{
    array1_f8 t_;
    array2_f8 u_;
    array2_f8 extra_;
    real dt_;
    int64_t k_;
    int64_t i_;
    tuple_15 external_;
    tuple_9 at_;
    tuple_15 acting_;
    t_ = schedule_.t_;
    u_ = schedule_.u_;
    extra_ = schedule_.extra_;
    dt_ = schedule_.dt_;
    for (int64_t k1 = 0; k1 < u_.n[0]; k1 += 1) {
        k_ = k1;
        for (int64_t k2 = 0; k2 < 4; k2 += 1) {
            i_ = k2;
            x_.p[((k_) * x_.n[1] + (i_))] = state_.p[(i_)];
        }
        external_ = (tuple_15){{extra_.p[((k_) * extra_.n[1] + 0)], extra_.p[((k_) * extra_.n[1] + 1)], extra_.p[((k_) * extra_.n[1] + 2)]}};
        at_ = (tuple_9){{state_.p[0], state_.p[1], state_.p[2], state_.p[3]}};
        real t4 = t_.p[(k_)];
        tuple_34 t3 = composition_stored_memories_2(state_);
        tuple_15 t5 = simulate_torques(t4, at_, t3, u_.p[((k_) * u_.n[1] + 0)], drive_);
        acting_ = t5;
        real t6 = simulate_constrained(at_, u_.p[((k_) * u_.n[1] + 0)], external_, acting_, drive_.p_);
        tau_.p[((k_) * tau_.n[1] + 0)] = t6;
        tau_.p[((k_) * tau_.n[1] + 1)] = (acting_.v[1] - external_.v[1]);
        real t8 = tau_.p[((k_) * tau_.n[1] + 1)];
        real t7 = drive_arm_constraint(at_.v[2], at_.v[3], tau_.p[((k_) * tau_.n[1] + 0)], tau_.p[((k_) * tau_.n[1] + 1)], drive_.p_);
        tau_.p[((k_) * tau_.n[1] + 1)] = (t8 + t7);
        simulate_advance(state_, t_.p[(k_)], dt_, (array1_f8){u_.p + (k_) * (u_.n[1]), {u_.n[1]}}, external_, (array2_f8){noise_.numbers_.p + (k_) * (noise_.numbers_.n[1] * noise_.numbers_.n[2]), {noise_.numbers_.n[1], noise_.numbers_.n[2]}}, noise_.std_, drive_, tolerance_);
    }
    return;
}

/* plant/simulate.py:506 read_all */
GM_STATIC void simulate_read_all(array2_f8 x_, int64_t begin_, real dt_, array1_f8 e_, array2_f8 y_)
{
    int64_t k_;
    for (int64_t k1 = 0; k1 < y_.n[0]; k1 += 1) {
        k_ = k1;
        real t2 = composition_reading(x_, (begin_ + k_), 0, dt_, e_);
        y_.p[((k_) * y_.n[1] + 0)] = t2;
        real t3 = composition_reading(x_, (begin_ + k_), 1, dt_, e_);
        y_.p[((k_) * y_.n[1] + 1)] = t3;
    }
    return;
}

/* robot/arm_load.py:46 _follow */
GM_STATIC bool arm_load_follow(MotionState motion_, int64_t stamp_, array1_f8 positions_, real time_)
{
    array2_f8 joints_;
    array1_i8 clock_;
    int64_t elapsed_;
    real dt_;
    int64_t i_;
    real fading_;
    real late_;
    real fresh_;
    real gain1_;
    real gain2_;
    real gain3_;
    real q_;
    real v_;
    real a_;
    real error_;
    joints_ = motion_.joints_;
    clock_ = motion_.clock_;
    elapsed_ = (stamp_ - clock_.p[0]);
    dt_ = ((real)(elapsed_) * (real)1e-09);
    if ((((clock_.p[0] > 0)) && (((real)(-0.25) < dt_) && (dt_ <= (real)0.0)))) {
        return false;
    }
    if (((((clock_.p[0] == 0)) || ((dt_ < (real)0.0))) || ((dt_ > (real)0.25)))) {
        for (int64_t k1 = 0; k1 < positions_.n[0]; k1 += 1) {
            i_ = k1;
            real t2 = positions_.p[(i_)];
            joints_.p[(i_)] = t2;
            joints_.p[(1 * joints_.n[1] + (i_))] = (real)0.0;
            joints_.p[(2 * joints_.n[1] + (i_))] = (real)0.0;
            joints_.p[(3 * joints_.n[1] + (i_))] = (real)0.0;
            joints_.p[(4 * joints_.n[1] + (i_))] = ((bool)isfinite(positions_.p[(i_)]) ? (real)0.0 : INFINITY);
        }
        clock_.p[0] = stamp_;
        clock_.p[1] = 0;
        return false;
    }
    clock_.p[0] = stamp_;
    clock_.p[1] = (clock_.p[1] + elapsed_);
    real t3 = gm_exp(((-dt_) / time_));
    real t4 = ((real)1.0 - gm_exp(((-dt_) / ((real)3.0 * time_))));
    fading_ = t3;
    late_ = t4;
    fresh_ = ((real)1.0 - fading_);
    gain1_ = ((real)1.0 - ((fading_ * fading_) * fading_));
    gain2_ = ((((real)1.5 * (fresh_ * fresh_)) * ((real)1.0 + fading_)) / dt_);
    gain3_ = (((fresh_ * fresh_) * fresh_) / (dt_ * dt_));
    for (int64_t k5 = 0; k5 < positions_.n[0]; k5 += 1) {
        i_ = k5;
        real t6 = joints_.p[(i_)];
        real t7 = joints_.p[(1 * joints_.n[1] + (i_))];
        real t8 = joints_.p[(2 * joints_.n[1] + (i_))];
        q_ = t6;
        v_ = t7;
        a_ = t8;
        real t9 = (q_ + (dt_ * (v_ + (((real)0.5 * dt_) * a_))));
        real t10 = (v_ + (dt_ * a_));
        q_ = t9;
        v_ = t10;
        error_ = (positions_.p[(i_)] - q_);
        if (((bool)isfinite(positions_.p[(i_)]) && (!((joints_.p[(4 * joints_.n[1] + (i_))] <= (real)0.25))))) {
            real t11 = positions_.p[(i_)];
            q_ = t11;
            v_ = (real)0.0;
            a_ = (real)0.0;
            error_ = (real)0.0;
            clock_.p[1] = 0;
        }
        if ((bool)isfinite(error_)) {
            real t12 = (q_ + (gain1_ * error_));
            real t13 = (v_ + (gain2_ * error_));
            joints_.p[(i_)] = t12;
            joints_.p[(1 * joints_.n[1] + (i_))] = t13;
            real t14 = (a_ + (gain3_ * error_));
            joints_.p[(2 * joints_.n[1] + (i_))] = t14;
            joints_.p[(4 * joints_.n[1] + (i_))] = (real)0.0;
        } else {
            real t15 = q_;
            real t16 = v_;
            joints_.p[(i_)] = t15;
            joints_.p[(1 * joints_.n[1] + (i_))] = t16;
            joints_.p[(4 * joints_.n[1] + (i_))] = (joints_.p[(4 * joints_.n[1] + (i_))] + dt_);
        }
        joints_.p[(3 * joints_.n[1] + (i_))] = (joints_.p[(3 * joints_.n[1] + (i_))] + (late_ * (joints_.p[(2 * joints_.n[1] + (i_))] - joints_.p[(3 * joints_.n[1] + (i_))])));
    }
    return true;
}

/* robot/dynamics.py:124 _turned */
GM_INLINE tuple_15 dynamics_turned(array1_f8 frame_, tuple_15 a_)
{
    return (tuple_15){{(((frame_.p[0] * a_.v[0]) + (frame_.p[1] * a_.v[1])) + (frame_.p[2] * a_.v[2])), (((frame_.p[3] * a_.v[0]) + (frame_.p[4] * a_.v[1])) + (frame_.p[5] * a_.v[2])), (((frame_.p[6] * a_.v[0]) + (frame_.p[7] * a_.v[1])) + (frame_.p[8] * a_.v[2]))}};
}

/* robot/dynamics.py:190 _place_frame */
GM_INLINE void dynamics_place_frame(RobotArrays robot_, int64_t i_, tuple_15 axis_, real angle_)
{
    real c_;
    real s_;
    real x_;
    real y_;
    real z_;
    real k_;
    tuple_47 about_;
    array1_f8 frame_;
    int64_t parent_;
    int64_t row_;
    tuple_15 mount_;
    int64_t column_;
    tuple_15 a_;
    real t1 = gm_cos(angle_);
    real t2 = gm_sin(angle_);
    c_ = t1;
    s_ = t2;
    x_ = axis_.v[0];
    y_ = axis_.v[1];
    z_ = axis_.v[2];
    k_ = ((real)1.0 - c_);
    about_ = (tuple_47){{(c_ + ((x_ * x_) * k_)), (((x_ * y_) * k_) - (z_ * s_)), (((x_ * z_) * k_) + (y_ * s_)), (((y_ * x_) * k_) + (z_ * s_)), (c_ + ((y_ * y_) * k_)), (((y_ * z_) * k_) - (x_ * s_)), (((z_ * x_) * k_) - (y_ * s_)), (((z_ * y_) * k_) + (x_ * s_)), (c_ + ((z_ * z_) * k_))}};
    int64_t t3 = robot_.parent_.p[(i_)];
    frame_ = (array1_f8){robot_.frames_.p + (i_) * (robot_.frames_.n[1]), {robot_.frames_.n[1]}};
    parent_ = t3;
    for (int64_t k4 = 0; k4 < 3; k4 += 1) {
        row_ = k4;
        mount_ = (tuple_15){{robot_.rotation_.p[(((i_) * robot_.rotation_.n[1] + (row_)) * robot_.rotation_.n[2] + 0)], robot_.rotation_.p[(((i_) * robot_.rotation_.n[1] + (row_)) * robot_.rotation_.n[2] + 1)], robot_.rotation_.p[(((i_) * robot_.rotation_.n[1] + (row_)) * robot_.rotation_.n[2] + 2)]}};
        for (int64_t k5 = 0; k5 < 3; k5 += 1) {
            column_ = k5;
            frame_.p[(((3 * row_) + column_))] = (((mount_.v[0] * about_.v[(column_)]) + (mount_.v[1] * about_.v[((3 + column_))])) + (mount_.v[2] * about_.v[((6 + column_))]));
        }
    }
    if (((parent_ >= 0))) {
        for (int64_t k6 = 0; k6 < 3; k6 += 1) {
            column_ = k6;
            tuple_15 t7 = dynamics_turned((array1_f8){robot_.frames_.p + gm_at(parent_, robot_.frames_.n[0]) * (robot_.frames_.n[1]), {robot_.frames_.n[1]}}, (tuple_15){{frame_.p[(column_)], frame_.p[((3 + column_))], frame_.p[((6 + column_))]}});
            a_ = t7;
            frame_.p[(column_)] = a_.v[0];
            frame_.p[((3 + column_))] = a_.v[1];
            frame_.p[((6 + column_))] = a_.v[2];
        }
    }
    return;
}

/* robot/dynamics.py:114 _at */
GM_INLINE tuple_15 dynamics_at(array1_f8 row_, int64_t i_)
{
    return (tuple_15){{row_.p[(i_)], row_.p[((i_ + 1))], row_.p[((i_ + 2))]}};
}

/* robot/dynamics.py:104 _cross */
GM_INLINE tuple_15 dynamics_cross(tuple_15 a_, tuple_15 b_)
{
    return (tuple_15){{((a_.v[1] * b_.v[2]) - (a_.v[2] * b_.v[1])), ((a_.v[2] * b_.v[0]) - (a_.v[0] * b_.v[2])), ((a_.v[0] * b_.v[1]) - (a_.v[1] * b_.v[0]))}};
}

/* robot/dynamics.py:119 _put */
GM_INLINE void dynamics_put(array1_f8 row_, int64_t i_, tuple_15 a_)
{
    row_.p[(i_)] = a_.v[0];
    row_.p[((i_ + 1))] = a_.v[1];
    row_.p[((i_ + 2))] = a_.v[2];
    return;
}

/* robot/dynamics.py:132 _times */
GM_INLINE tuple_15 dynamics_times(array1_f8 tensor_, tuple_15 a_)
{
    int64_t t1 = gm_bound(9, tensor_.n[0]);
    int64_t t2 = gm_span(t1, tensor_.n[0]);
    tuple_15 t3 = dynamics_turned((array1_f8){tensor_.p + t1 * (1), {t2}}, a_);
    return t3;
}

/* robot/dynamics.py:212 _move_body */
GM_INLINE void dynamics_move_body(RobotArrays robot_, int64_t b_)
{
    array1_f8 body_;
    array1_f8 frame_;
    tuple_15 r_;
    int64_t column_;
    tuple_15 a_;
    int64_t row_;
    int64_t at_;
    tuple_15 omega_;
    tuple_15 alpha_;
    tuple_15 inner_;
    tuple_15 outer_;
    tuple_15 spin_;
    tuple_15 turning_;
    tuple_15 origin_;
    real mass_;
    int64_t k_;
    body_ = (array1_f8){robot_.bodies_.p + (b_) * (robot_.bodies_.n[1]), {robot_.bodies_.n[1]}};
    frame_ = (array1_f8){robot_.frames_.p + gm_at(robot_.body_joint_.p[(b_)], robot_.frames_.n[0]) * (robot_.frames_.n[1]), {robot_.frames_.n[1]}};
    tuple_15 t1 = dynamics_turned(frame_, (tuple_15){{robot_.com_.p[((b_) * robot_.com_.n[1] + 0)], robot_.com_.p[((b_) * robot_.com_.n[1] + 1)], robot_.com_.p[((b_) * robot_.com_.n[1] + 2)]}});
    r_ = t1;
    for (int64_t k2 = 0; k2 < 3; k2 += 1) {
        column_ = k2;
        tuple_15 t3 = dynamics_turned(frame_, (tuple_15){{robot_.inertia_.p[(((b_) * robot_.inertia_.n[1] + 0) * robot_.inertia_.n[2] + (column_))], robot_.inertia_.p[(((b_) * robot_.inertia_.n[1] + 1) * robot_.inertia_.n[2] + (column_))], robot_.inertia_.p[(((b_) * robot_.inertia_.n[1] + 2) * robot_.inertia_.n[2] + (column_))]}});
        a_ = t3;
        body_.p[((9 + column_))] = a_.v[0];
        body_.p[((12 + column_))] = a_.v[1];
        body_.p[((15 + column_))] = a_.v[2];
    }
    for (int64_t k4 = 0; k4 < 3; k4 += 1) {
        row_ = k4;
        at_ = (9 + (3 * row_));
        tuple_15 t5 = dynamics_at(body_, at_);
        tuple_15 t6 = dynamics_turned(frame_, t5);
        dynamics_put(body_, at_, t6);
    }
    tuple_15 t7 = dynamics_at(frame_, 15);
    tuple_15 t8 = dynamics_at(frame_, 18);
    omega_ = t7;
    alpha_ = t8;
    tuple_15 t9 = dynamics_cross(alpha_, r_);
    tuple_15 t10 = dynamics_cross(omega_, r_);
    tuple_15 t11 = dynamics_cross(omega_, t10);
    inner_ = t9;
    outer_ = t11;
    tuple_15 t12 = dynamics_times(body_, omega_);
    tuple_15 t13 = dynamics_cross(omega_, t12);
    tuple_15 t14 = dynamics_times(body_, alpha_);
    spin_ = t13;
    turning_ = t14;
    tuple_15 t15 = dynamics_at(frame_, 9);
    real t16 = robot_.mass_.p[(b_)];
    origin_ = t15;
    mass_ = t16;
    for (int64_t k17 = 0; k17 < 3; k17 += 1) {
        k_ = k17;
        body_.p[((0 + k_))] = (origin_.v[(k_)] + r_.v[(k_)]);
        body_.p[((3 + k_))] = (mass_ * ((frame_.p[((21 + k_))] + inner_.v[(k_)]) + outer_.v[(k_)]));
        body_.p[((6 + k_))] = (turning_.v[(k_)] + spin_.v[(k_)]);
    }
    return;
}

/* robot/dynamics.py:137 move */
GM_STATIC void dynamics_move(RobotArrays robot_, array2_f8 motion_)
{
    array2_f8 frames_;
    int64_t i_;
    array1_f8 frame_;
    int64_t j_;
    real q_;
    real v_;
    real a_;
    tuple_15 axis_;
    bool slides_;
    int64_t parent_;
    tuple_15 at_;
    tuple_15 omega_;
    tuple_15 alpha_;
    tuple_15 base_;
    tuple_15 acceleration_;
    array1_f8 parent_frame_;
    tuple_15 s_;
    tuple_15 inner_;
    tuple_15 outer_;
    tuple_15 swing_;
    int64_t b_;
    frames_ = robot_.frames_;
    for (int64_t k1 = 0; k1 < frames_.n[0]; k1 += 1) {
        i_ = k1;
        int64_t t2 = robot_.source_.p[(i_)];
        frame_ = (array1_f8){frames_.p + (i_) * (frames_.n[1]), {frames_.n[1]}};
        j_ = t2;
        q_ = ((robot_.ratio_.p[(i_)] * motion_.p[gm_at(j_, motion_.n[1])]) + robot_.offset_.p[(i_)]);
        real t3 = (robot_.ratio_.p[(i_)] * motion_.p[(1 * motion_.n[1] + gm_at(j_, motion_.n[1]))]);
        real t4 = (robot_.ratio_.p[(i_)] * motion_.p[(2 * motion_.n[1] + gm_at(j_, motion_.n[1]))]);
        v_ = t3;
        a_ = t4;
        axis_ = (tuple_15){{robot_.axis_.p[((i_) * robot_.axis_.n[1] + 0)], robot_.axis_.p[((i_) * robot_.axis_.n[1] + 1)], robot_.axis_.p[((i_) * robot_.axis_.n[1] + 2)]}};
        slides_ = ((robot_.prismatic_.p[(i_)] > (real)0.0));
        dynamics_place_frame(robot_, i_, axis_, (slides_ ? (real)0.0 : q_));
        parent_ = robot_.parent_.p[(i_)];
        at_ = (tuple_15){{robot_.origin_.p[((i_) * robot_.origin_.n[1] + 0)], robot_.origin_.p[((i_) * robot_.origin_.n[1] + 1)], robot_.origin_.p[((i_) * robot_.origin_.n[1] + 2)]}};
        omega_ = (tuple_15){{(real)0.0, (real)0.0, (real)0.0}};
        alpha_ = (tuple_15){{(real)0.0, (real)0.0, (real)0.0}};
        base_ = (tuple_15){{(real)0.0, (real)0.0, (real)0.0}};
        acceleration_ = (tuple_15){{(-robot_.gravity_.p[0]), (-robot_.gravity_.p[1]), (-robot_.gravity_.p[2])}};
        if (((parent_ >= 0))) {
            parent_frame_ = (array1_f8){frames_.p + gm_at(parent_, frames_.n[0]) * (frames_.n[1]), {frames_.n[1]}};
            tuple_15 t5 = dynamics_turned(parent_frame_, at_);
            tuple_15 t6 = dynamics_at(parent_frame_, 9);
            at_ = t5;
            base_ = t6;
            tuple_15 t7 = dynamics_at(parent_frame_, 15);
            tuple_15 t8 = dynamics_at(parent_frame_, 18);
            omega_ = t7;
            alpha_ = t8;
            tuple_15 t9 = dynamics_at(parent_frame_, 21);
            acceleration_ = t9;
        }
        tuple_15 t10 = dynamics_turned(frame_, axis_);
        s_ = t10;
        if (slides_) {
            at_ = (tuple_15){{(at_.v[0] + (s_.v[0] * q_)), (at_.v[1] + (s_.v[1] * q_)), (at_.v[2] + (s_.v[2] * q_))}};
        }
        tuple_15 t11 = dynamics_cross(alpha_, at_);
        real t13 = omega_.v[0];
        real t14 = omega_.v[1];
        real t15 = omega_.v[2];
        tuple_15 t12 = dynamics_cross(omega_, at_);
        tuple_15 t16 = dynamics_cross((tuple_15){{t13, t14, t15}}, t12);
        inner_ = t11;
        outer_ = t16;
        acceleration_ = (tuple_15){{((acceleration_.v[0] + inner_.v[0]) + outer_.v[0]), ((acceleration_.v[1] + inner_.v[1]) + outer_.v[1]), ((acceleration_.v[2] + inner_.v[2]) + outer_.v[2])}};
        tuple_15 t17 = dynamics_cross(omega_, s_);
        swing_ = t17;
        if (slides_) {
            acceleration_ = (tuple_15){{((acceleration_.v[0] + (a_ * s_.v[0])) + (((real)2.0 * v_) * swing_.v[0])), ((acceleration_.v[1] + (a_ * s_.v[1])) + (((real)2.0 * v_) * swing_.v[1])), ((acceleration_.v[2] + (a_ * s_.v[2])) + (((real)2.0 * v_) * swing_.v[2]))}};
        } else {
            alpha_ = (tuple_15){{((alpha_.v[0] + (a_ * s_.v[0])) + (v_ * swing_.v[0])), ((alpha_.v[1] + (a_ * s_.v[1])) + (v_ * swing_.v[1])), ((alpha_.v[2] + (a_ * s_.v[2])) + (v_ * swing_.v[2]))}};
            omega_ = (tuple_15){{(omega_.v[0] + (v_ * s_.v[0])), (omega_.v[1] + (v_ * s_.v[1])), (omega_.v[2] + (v_ * s_.v[2]))}};
        }
        dynamics_put(frame_, 9, (tuple_15){{(base_.v[0] + at_.v[0]), (base_.v[1] + at_.v[1]), (base_.v[2] + at_.v[2])}});
        dynamics_put(frame_, 12, s_);
        dynamics_put(frame_, 15, omega_);
        dynamics_put(frame_, 18, alpha_);
        dynamics_put(frame_, 21, acceleration_);
    }
    for (int64_t k18 = 0; k18 < robot_.bodies_.n[0]; k18 += 1) {
        b_ = k18;
        dynamics_move_body(robot_, b_);
    }
    return;
}

/* robot/dynamics.py:234 _jacobians */
GM_INLINE tuple_48 dynamics_jacobians(RobotArrays robot_, int64_t b_, int64_t joint_)
{
    array1_f8 body_;
    int64_t i_;
    tuple_15 linear_;
    tuple_15 angular_;
    array1_f8 frame_;
    real k_;
    tuple_15 s_;
    tuple_15 arm_;
    int64_t t1 = robot_.body_joint_.p[(b_)];
    body_ = (array1_f8){robot_.bodies_.p + (b_) * (robot_.bodies_.n[1]), {robot_.bodies_.n[1]}};
    i_ = t1;
    linear_ = (tuple_15){{(real)0.0, (real)0.0, (real)0.0}};
    angular_ = (tuple_15){{(real)0.0, (real)0.0, (real)0.0}};
    for (;;) {
        if (!((i_ >= 0))) break;
        if (((robot_.source_.p[gm_at(i_, robot_.source_.n[0])] == joint_))) {
            real t2 = robot_.ratio_.p[gm_at(i_, robot_.ratio_.n[0])];
            frame_ = (array1_f8){robot_.frames_.p + gm_at(i_, robot_.frames_.n[0]) * (robot_.frames_.n[1]), {robot_.frames_.n[1]}};
            k_ = t2;
            tuple_15 t3 = dynamics_at(frame_, 12);
            s_ = t3;
            if (((robot_.prismatic_.p[gm_at(i_, robot_.prismatic_.n[0])] > (real)0.0))) {
                linear_ = (tuple_15){{(linear_.v[0] + (k_ * s_.v[0])), (linear_.v[1] + (k_ * s_.v[1])), (linear_.v[2] + (k_ * s_.v[2]))}};
            } else {
                tuple_15 t4 = dynamics_cross(s_, (tuple_15){{(body_.p[0] - frame_.p[9]), (body_.p[1] - frame_.p[10]), (body_.p[2] - frame_.p[11])}});
                arm_ = t4;
                linear_ = (tuple_15){{(linear_.v[0] + (k_ * arm_.v[0])), (linear_.v[1] + (k_ * arm_.v[1])), (linear_.v[2] + (k_ * arm_.v[2]))}};
                angular_ = (tuple_15){{(angular_.v[0] + (k_ * s_.v[0])), (angular_.v[1] + (k_ * s_.v[1])), (angular_.v[2] + (k_ * s_.v[2]))}};
            }
        }
        i_ = robot_.parent_.p[gm_at(i_, robot_.parent_.n[0])];
    }
    return (tuple_48){{linear_, angular_}};
}

/* robot/dynamics.py:109 _dot */
GM_INLINE real dynamics_dot(tuple_15 a_, tuple_15 b_)
{
    return (((a_.v[0] * b_.v[0]) + (a_.v[1] * b_.v[1])) + (a_.v[2] * b_.v[2]));
}

/* robot/dynamics.py:254 torque_on */
GM_STATIC tuple_15 dynamics_torque_on(RobotArrays robot_, int64_t joint_, real acceleration_)
{
    real torque_;
    real variance_;
    real inertia_;
    int64_t b_;
    array1_f8 body_;
    tuple_15 linear_;
    tuple_15 angular_;
    real by_mass_;
    real by_inertia_;
    real of_mass_;
    real of_inertia_;
    real amount_;
    real deviation_;
    torque_ = (real)0.0;
    variance_ = (real)0.0;
    inertia_ = (real)0.0;
    for (int64_t k1 = 0; k1 < robot_.bodies_.n[0]; k1 += 1) {
        b_ = k1;
        body_ = (array1_f8){robot_.bodies_.p + (b_) * (robot_.bodies_.n[1]), {robot_.bodies_.n[1]}};
        tuple_48 t2 = dynamics_jacobians(robot_, b_, joint_);
        linear_ = t2.v[0];
        angular_ = t2.v[1];
        tuple_15 t3 = dynamics_at(body_, 3);
        real t4 = dynamics_dot(linear_, t3);
        tuple_15 t5 = dynamics_at(body_, 6);
        real t6 = dynamics_dot(angular_, t5);
        by_mass_ = t4;
        by_inertia_ = t6;
        real t8 = robot_.mass_.p[(b_)];
        real t7 = dynamics_dot(linear_, linear_);
        real t11 = (t8 * t7);
        tuple_15 t9 = dynamics_times(body_, angular_);
        real t10 = dynamics_dot(angular_, t9);
        of_mass_ = t11;
        of_inertia_ = t10;
        real t12 = robot_.amounts_.p[(b_)];
        real t13 = robot_.deviations_.p[(b_)];
        amount_ = t12;
        deviation_ = t13;
        torque_ = (torque_ + (amount_ * (by_mass_ + by_inertia_)));
        inertia_ = (inertia_ + (amount_ * (of_mass_ + of_inertia_)));
        real t14 = (by_mass_ + (acceleration_ * of_mass_));
        real t15 = (by_inertia_ + (acceleration_ * of_inertia_));
        by_mass_ = t14;
        by_inertia_ = t15;
        variance_ = (variance_ + ((deviation_ * deviation_) * ((by_mass_ * by_mass_) + (by_inertia_ * by_inertia_))));
    }
    return (tuple_15){{torque_, variance_, inertia_}};
}

/* robot/arm_load.py:85 write_loads */
GM_STATIC void arm_load_write_loads(RobotArrays robot_, MotionState motion_, int64_t joint_, real time_, array1_i8 stamps_, array2_f8 positions_, array2_f8 out_, array1_f8 weight_)
{
    array2_f8 joints_;
    array1_i8 clock_;
    array2_f8 acting_;
    int64_t k_;
    bool good_;
    int64_t i_;
    real variance_;
    real lag_;
    joints_ = motion_.joints_;
    clock_ = motion_.clock_;
    acting_ = motion_.acting_;
    for (int64_t k1 = 0; k1 < stamps_.n[0]; k1 += 1) {
        k_ = k1;
        bool t2 = arm_load_follow(motion_, stamps_.p[(k_)], (array1_f8){positions_.p + (k_) * (positions_.n[1]), {positions_.n[1]}}, time_);
        good_ = t2;
        good_ = (good_ && ((((real)(clock_.p[1]) * (real)1e-09) > ((real)10.0 * time_))));
        for (int64_t k3 = 0; k3 < joints_.n[1]; k3 += 1) {
            i_ = k3;
            good_ = (good_ && ((joints_.p[(4 * joints_.n[1] + (i_))] <= (real)0.25)));
        }
        if ((!good_)) {
            array1_f8 t4 = (array1_f8){out_.p + (k_) * (out_.n[1]), {out_.n[1]}};
            for (int64_t k5 = 0; k5 < t4.n[0]; k5++)
                t4.p[k5 * (1)] = NAN;
            if (((weight_.n[0] > 0))) {
                weight_.p[(k_)] = NAN;
            }
            continue;
        }
        if (((weight_.n[0] > 0))) {
            for (int64_t k6 = 0; k6 < joints_.n[1]; k6 += 1) {
                i_ = k6;
                real t7 = joints_.p[(i_)];
                acting_.p[(i_)] = t7;
                acting_.p[(1 * acting_.n[1] + (i_))] = (real)0.0;
                acting_.p[(2 * acting_.n[1] + (i_))] = (real)0.0;
            }
            dynamics_move(robot_, acting_);
            tuple_15 t8 = dynamics_torque_on(robot_, joint_, (real)0.0);
            weight_.p[(k_)] = t8.v[0];
        }
        for (int64_t k9 = 0; k9 < joints_.n[1]; k9 += 1) {
            i_ = k9;
            real t10 = joints_.p[(i_)];
            real t11 = joints_.p[(1 * joints_.n[1] + (i_))];
            real t12 = joints_.p[(2 * joints_.n[1] + (i_))];
            acting_.p[(i_)] = t10;
            acting_.p[(1 * acting_.n[1] + (i_))] = t11;
            acting_.p[(2 * acting_.n[1] + (i_))] = t12;
        }
        acting_.p[(2 * acting_.n[1] + gm_at(joint_, acting_.n[1]))] = (real)0.0;
        dynamics_move(robot_, acting_);
        tuple_15 t13 = dynamics_torque_on(robot_, joint_, joints_.p[(2 * joints_.n[1] + gm_at(joint_, joints_.n[1]))]);
        out_.p[((k_) * out_.n[1] + 0)] = t13.v[0];
        variance_ = t13.v[1];
        out_.p[((k_) * out_.n[1] + 2)] = t13.v[2];
        for (int64_t k14 = 0; k14 < joints_.n[1]; k14 += 1) {
            i_ = k14;
            acting_.p[(2 * acting_.n[1] + (i_))] = (((i_ != joint_)) ? joints_.p[(3 * joints_.n[1] + (i_))] : (real)0.0);
        }
        dynamics_move(robot_, acting_);
        tuple_15 t15 = dynamics_torque_on(robot_, joint_, (real)0.0);
        lag_ = (t15.v[0] - out_.p[((k_) * out_.n[1] + 0)]);
        out_.p[((k_) * out_.n[1] + 1)] = gm_sqrt(variance_);
        out_.p[((k_) * out_.n[1] + 3)] = ((((real)2.0 * lag_) * lag_) / ((real)3.0 * time_));
    }
    return;
}

/* robot/dynamics.py:234 _jacobians */
GM_INLINE tuple_48 dynamics_jacobians_2(RobotArrays robot_, int64_t b_, int64_t joint_)
{
    array1_f8 body_;
    int64_t i_;
    tuple_15 linear_;
    tuple_15 angular_;
    array1_f8 frame_;
    real k_;
    tuple_15 s_;
    tuple_15 arm_;
    int64_t t1 = robot_.body_joint_.p[(b_)];
    body_ = (array1_f8){robot_.bodies_.p + (b_) * (robot_.bodies_.n[1]), {robot_.bodies_.n[1]}};
    i_ = t1;
    linear_ = (tuple_15){{(real)0.0, (real)0.0, (real)0.0}};
    angular_ = (tuple_15){{(real)0.0, (real)0.0, (real)0.0}};
    for (;;) {
        if (!((i_ >= 0))) break;
        if (((robot_.source_.p[gm_at(i_, robot_.source_.n[0])] == joint_))) {
            real t2 = robot_.ratio_.p[gm_at(i_, robot_.ratio_.n[0])];
            frame_ = (array1_f8){robot_.frames_.p + gm_at(i_, robot_.frames_.n[0]) * (robot_.frames_.n[1]), {robot_.frames_.n[1]}};
            k_ = t2;
            tuple_15 t3 = dynamics_at(frame_, 12);
            s_ = t3;
            if (((robot_.prismatic_.p[gm_at(i_, robot_.prismatic_.n[0])] > (real)0.0))) {
                linear_ = (tuple_15){{(linear_.v[0] + (k_ * s_.v[0])), (linear_.v[1] + (k_ * s_.v[1])), (linear_.v[2] + (k_ * s_.v[2]))}};
            } else {
                tuple_15 t4 = dynamics_cross(s_, (tuple_15){{(body_.p[0] - frame_.p[9]), (body_.p[1] - frame_.p[10]), (body_.p[2] - frame_.p[11])}});
                arm_ = t4;
                linear_ = (tuple_15){{(linear_.v[0] + (k_ * arm_.v[0])), (linear_.v[1] + (k_ * arm_.v[1])), (linear_.v[2] + (k_ * arm_.v[2]))}};
                angular_ = (tuple_15){{(angular_.v[0] + (k_ * s_.v[0])), (angular_.v[1] + (k_ * s_.v[1])), (angular_.v[2] + (k_ * s_.v[2]))}};
            }
        }
        i_ = robot_.parent_.p[gm_at(i_, robot_.parent_.n[0])];
    }
    return (tuple_48){{linear_, angular_}};
}

/* robot/dynamics.py:254 torque_on */
GM_STATIC tuple_15 dynamics_torque_on_2(RobotArrays robot_, int64_t joint_, real acceleration_)
{
    real torque_;
    real variance_;
    real inertia_;
    int64_t b_;
    array1_f8 body_;
    tuple_15 linear_;
    tuple_15 angular_;
    real by_mass_;
    real by_inertia_;
    real of_mass_;
    real of_inertia_;
    real amount_;
    real deviation_;
    torque_ = (real)0.0;
    variance_ = (real)0.0;
    inertia_ = (real)0.0;
    for (int64_t k1 = 0; k1 < robot_.bodies_.n[0]; k1 += 1) {
        b_ = k1;
        body_ = (array1_f8){robot_.bodies_.p + (b_) * (robot_.bodies_.n[1]), {robot_.bodies_.n[1]}};
        tuple_48 t2 = dynamics_jacobians_2(robot_, b_, joint_);
        linear_ = t2.v[0];
        angular_ = t2.v[1];
        tuple_15 t3 = dynamics_at(body_, 3);
        real t4 = dynamics_dot(linear_, t3);
        tuple_15 t5 = dynamics_at(body_, 6);
        real t6 = dynamics_dot(angular_, t5);
        by_mass_ = t4;
        by_inertia_ = t6;
        real t8 = robot_.mass_.p[(b_)];
        real t7 = dynamics_dot(linear_, linear_);
        real t11 = (t8 * t7);
        tuple_15 t9 = dynamics_times(body_, angular_);
        real t10 = dynamics_dot(angular_, t9);
        of_mass_ = t11;
        of_inertia_ = t10;
        real t12 = robot_.amounts_.p[(b_)];
        real t13 = robot_.deviations_.p[(b_)];
        amount_ = t12;
        deviation_ = t13;
        torque_ = (torque_ + (amount_ * (by_mass_ + by_inertia_)));
        inertia_ = (inertia_ + (amount_ * (of_mass_ + of_inertia_)));
        real t14 = (by_mass_ + (acceleration_ * of_mass_));
        real t15 = (by_inertia_ + (acceleration_ * of_inertia_));
        by_mass_ = t14;
        by_inertia_ = t15;
        variance_ = (variance_ + ((deviation_ * deviation_) * ((by_mass_ * by_mass_) + (by_inertia_ * by_inertia_))));
    }
    return (tuple_15){{torque_, variance_, inertia_}};
}

/* robot/dynamics.py:285 coupled_inertia */
GM_STATIC real dynamics_coupled_inertia(RobotArrays robot_, int64_t i_, int64_t j_)
{
    real total_;
    int64_t b_;
    tuple_15 linear_;
    tuple_15 angular_;
    tuple_15 of_linear_;
    tuple_15 of_angular_;
    total_ = (real)0.0;
    for (int64_t k1 = 0; k1 < robot_.bodies_.n[0]; k1 += 1) {
        b_ = k1;
        tuple_48 t2 = dynamics_jacobians_2(robot_, b_, i_);
        linear_ = t2.v[0];
        angular_ = t2.v[1];
        tuple_48 t3 = dynamics_jacobians_2(robot_, b_, j_);
        of_linear_ = t3.v[0];
        of_angular_ = t3.v[1];
        real t10 = total_;
        real t9 = robot_.amounts_.p[(b_)];
        real t5 = robot_.mass_.p[(b_)];
        real t4 = dynamics_dot(linear_, of_linear_);
        real t8 = (t5 * t4);
        tuple_15 t6 = dynamics_times((array1_f8){robot_.bodies_.p + (b_) * (robot_.bodies_.n[1]), {robot_.bodies_.n[1]}}, of_angular_);
        real t7 = dynamics_dot(angular_, t6);
        total_ = (t10 + (t9 * (t8 + t7)));
    }
    return total_;
}

/* robot/arm_plant.py:62 _slopes */
GM_STATIC void arm_plant_slopes(RobotArrays robot_, array2_f8 p_, array1_f8 x_, array1_f8 u_, ArmScratch scratch_, array1_f8 out_)
{
    array2_f8 matrix_;
    array1_f8 right_;
    array2_f8 motion_;
    int64_t n_;
    int64_t i_;
    real x3_;
    real x4_;
    real tau_k_;
    int64_t j_;
    real total_;
    int64_t k_;
    matrix_ = scratch_.matrix_;
    right_ = scratch_.right_;
    motion_ = scratch_.motion_;
    n_ = u_.n[0];
    for (int64_t k1 = 0; k1 < n_; k1 += 1) {
        i_ = k1;
        real t2 = x_.p[((n_ + i_))];
        real t3 = x_.p[(((3 * n_) + i_))];
        motion_.p[(i_)] = t2;
        motion_.p[(1 * motion_.n[1] + (i_))] = t3;
        motion_.p[(2 * motion_.n[1] + (i_))] = (real)0.0;
    }
    dynamics_move(robot_, motion_);
    for (int64_t k4 = 0; k4 < n_; k4 += 1) {
        i_ = k4;
        real t5 = x_.p[(((2 * n_) + i_))];
        real t6 = x_.p[(((3 * n_) + i_))];
        x3_ = t5;
        x4_ = t6;
        real t8 = p_.p[((i_) * p_.n[1] + 9)];
        real t7 = transmission_dead_zone((x_.p[(i_)] - x_.p[((n_ + i_))]), p_.p[((i_) * p_.n[1] + 10)]);
        tau_k_ = (t8 * t7);
        out_.p[(i_)] = x3_;
        out_.p[((n_ + i_))] = x4_;
        real t9 = drive_motor_acceleration(x_.p[(i_)], x3_, x4_, u_.p[(i_)], tau_k_, (array1_f8){p_.p + (i_) * (p_.n[1]), {p_.n[1]}});
        out_.p[(((2 * n_) + i_))] = t9;
        real t11 = (tau_k_ + (p_.p[((i_) * p_.n[1] + 2)] * (x3_ - x4_)));
        tuple_15 t10 = dynamics_torque_on_2(robot_, i_, (real)0.0);
        right_.p[(i_)] = (t11 - t10.v[0]);
        int64_t t12 = (i_ + 1);
        for (int64_t k13 = 0; k13 < t12; k13 += 1) {
            j_ = k13;
            real t14 = dynamics_coupled_inertia(robot_, i_, j_);
            matrix_.p[((i_) * matrix_.n[1] + (j_))] = t14;
        }
    }
    for (int64_t k15 = 0; k15 < n_; k15 += 1) {
        i_ = k15;
        int64_t t16 = (i_ + 1);
        for (int64_t k17 = 0; k17 < t16; k17 += 1) {
            j_ = k17;
            total_ = matrix_.p[((i_) * matrix_.n[1] + (j_))];
            int64_t t18 = j_;
            for (int64_t k19 = 0; k19 < t18; k19 += 1) {
                k_ = k19;
                total_ = (total_ - (matrix_.p[((i_) * matrix_.n[1] + (k_))] * matrix_.p[((j_) * matrix_.n[1] + (k_))]));
            }
            matrix_.p[((i_) * matrix_.n[1] + (j_))] = (((i_ == j_)) ? gm_sqrt(total_) : (total_ / matrix_.p[((j_) * matrix_.n[1] + (j_))]));
        }
    }
    for (int64_t k20 = 0; k20 < n_; k20 += 1) {
        i_ = k20;
        int64_t t21 = i_;
        for (int64_t k22 = 0; k22 < t21; k22 += 1) {
            k_ = k22;
            right_.p[(i_)] = (right_.p[(i_)] - (matrix_.p[((i_) * matrix_.n[1] + (k_))] * right_.p[(k_)]));
        }
        right_.p[(i_)] = (right_.p[(i_)] / matrix_.p[((i_) * matrix_.n[1] + (i_))]);
    }
    int64_t t23 = (n_ - 1);
    for (int64_t k24 = t23; k24 > (-1); k24 += -1) {
        i_ = k24;
        int64_t t25 = (i_ + 1);
        for (int64_t k26 = t25; k26 < n_; k26 += 1) {
            k_ = k26;
            right_.p[(i_)] = (right_.p[(i_)] - (matrix_.p[((k_) * matrix_.n[1] + (i_))] * right_.p[(k_)]));
        }
        right_.p[(i_)] = (right_.p[(i_)] / matrix_.p[((i_) * matrix_.n[1] + (i_))]);
        out_.p[(((3 * n_) + i_))] = right_.p[(i_)];
    }
    return;
}

/* robot/arm_plant.py:96 _run */
GM_STATIC void arm_plant_run(RobotArrays robot_, ServoDrives drives_, array3_f8 references_, array1_f8 payload_, array1_f8 x_, real dt_, ArmScratch scratch_, array3_f8 out_)
{
    array2_f8 p_;
    array1_f8 kp_;
    array1_f8 kd_;
    int64_t substeps_;
    int64_t n_;
    array2_f8 slopes_;
    real h_;
    array1_f8 u_;
    int64_t k_;
    int64_t i_;
    array1_f8 stage_;
    int64_t q_;
    real a_;
    p_ = drives_.p_;
    kp_ = drives_.kp_;
    kd_ = drives_.kd_;
    substeps_ = (int64_t)gm_ceil((dt_ / (real)0.0005));
    real t1 = (dt_ / (real)(substeps_));
    n_ = p_.n[0];
    slopes_ = scratch_.slopes_;
    h_ = t1;
    int64_t t2 = gm_bound(n_, slopes_.n[1]);
    u_ = (array1_f8){slopes_.p + 4 * (slopes_.n[1]), {t2}};
    for (int64_t k3 = 0; k3 < references_.n[0]; k3 += 1) {
        k_ = k3;
        robot_.amounts_.p[(robot_.amounts_.n[0] - 1)] = payload_.p[(k_)];
        for (int64_t k4 = 0; k4 < n_; k4 += 1) {
            i_ = k4;
            u_.p[(i_)] = ((kp_.p[(i_)] * (references_.p[(((k_) * references_.n[1] + 0) * references_.n[2] + (i_))] - x_.p[(i_)])) + (kd_.p[(i_)] * (references_.p[(((k_) * references_.n[1] + 1) * references_.n[2] + (i_))] - x_.p[(((2 * n_) + i_))])));
            real t5 = u_.p[(i_)];
            real t6 = x_.p[(i_)];
            real t7 = x_.p[((n_ + i_))];
            out_.p[(((k_) * out_.n[1] + 0) * out_.n[2] + (i_))] = t5;
            out_.p[(((k_) * out_.n[1] + 1) * out_.n[2] + (i_))] = t6;
            out_.p[(((k_) * out_.n[1] + 2) * out_.n[2] + (i_))] = t7;
            real t9 = p_.p[((i_) * p_.n[1] + 9)];
            real t8 = transmission_dead_zone((x_.p[(i_)] - x_.p[((n_ + i_))]), p_.p[((i_) * p_.n[1] + 10)]);
            out_.p[(((k_) * out_.n[1] + 3) * out_.n[2] + (i_))] = (t9 * t8);
        }
        for (int64_t k10 = 0; k10 < substeps_; k10 += 1) {
            stage_ = (array1_f8){scratch_.slopes_.p + 5 * (scratch_.slopes_.n[1]), {scratch_.slopes_.n[1]}};
            for (int64_t k11 = 0; k11 < 4; k11 += 1) {
                q_ = k11;
                a_ = (((q_ == 0)) ? (real)0.0 : (((q_ == 3)) ? h_ : ((real)0.5 * h_)));
                int64_t t12 = (4 * n_);
                for (int64_t k13 = 0; k13 < t12; k13 += 1) {
                    i_ = k13;
                    stage_.p[(i_)] = (x_.p[(i_)] + ((q_ != 0) ? (a_ * slopes_.p[(gm_at((q_ - 1), slopes_.n[0]) * slopes_.n[1] + (i_))]) : (real)0.0));
                }
                arm_plant_slopes(robot_, p_, stage_, u_, scratch_, (array1_f8){slopes_.p + (q_) * (slopes_.n[1]), {slopes_.n[1]}});
            }
            int64_t t14 = (4 * n_);
            for (int64_t k15 = 0; k15 < t14; k15 += 1) {
                i_ = k15;
                x_.p[(i_)] = (x_.p[(i_)] + ((h_ / (real)6.0) * ((slopes_.p[(i_)] + ((real)2.0 * (slopes_.p[(1 * slopes_.n[1] + (i_))] + slopes_.p[(2 * slopes_.n[1] + (i_))]))) + slopes_.p[(3 * slopes_.n[1] + (i_))])));
            }
        }
    }
    return;
}

/* robot/dynamics.py:285 coupled_inertia */
GM_STATIC real dynamics_coupled_inertia_2(RobotArrays robot_, int64_t i_, int64_t j_)
{
    real total_;
    int64_t b_;
    tuple_15 linear_;
    tuple_15 angular_;
    tuple_15 of_linear_;
    tuple_15 of_angular_;
    total_ = (real)0.0;
    for (int64_t k1 = 0; k1 < robot_.bodies_.n[0]; k1 += 1) {
        b_ = k1;
        tuple_48 t2 = dynamics_jacobians(robot_, b_, i_);
        linear_ = t2.v[0];
        angular_ = t2.v[1];
        tuple_48 t3 = dynamics_jacobians(robot_, b_, j_);
        of_linear_ = t3.v[0];
        of_angular_ = t3.v[1];
        real t10 = total_;
        real t9 = robot_.amounts_.p[(b_)];
        real t5 = robot_.mass_.p[(b_)];
        real t4 = dynamics_dot(linear_, of_linear_);
        real t8 = (t5 * t4);
        tuple_15 t6 = dynamics_times((array1_f8){robot_.bodies_.p + (b_) * (robot_.bodies_.n[1]), {robot_.bodies_.n[1]}}, of_angular_);
        real t7 = dynamics_dot(angular_, t6);
        total_ = (t10 + (t9 * (t8 + t7)));
    }
    return total_;
}

void gm_bag_cdr__decode_rows(gm_slot *a)
{
    cdr_decode_rows((array1_u1){(uint8_t *)a[8].p, {a[9].i}}, (tuple){{(array1_i8){(int64_t *)a[10].p, {a[11].i}}, (array1_i8){(int64_t *)a[12].p, {a[13].i}}}}, (tuple_2){a[14].i, (array1_u8){(uint64_t *)a[15].p, {a[16].i}}, (array1_u8){(uint64_t *)a[17].p, {a[18].i}}, (array1_u8){(uint64_t *)a[19].p, {a[20].i}}}, (array1_i8){(int64_t *)a[21].p, {a[22].i}}, (tuple_3){(array1_i8){(int64_t *)a[23].p, {a[24].i}}, (array2_u8){(uint64_t *)a[25].p, {a[26].i, a[27].i}}, (array1_b1){(bool *)a[28].p, {a[29].i}}});
}
void gm_bag_message_block__gather(gm_slot *a)
{
    message_block_gather((array1_u1){(uint8_t *)a[8].p, {a[9].i}}, a[10].i, (array1_u1){(uint8_t *)a[11].p, {a[12].i}}, (tuple){{(array1_i8){(int64_t *)a[13].p, {a[14].i}}, (array1_i8){(int64_t *)a[15].p, {a[16].i}}}}, (array1_u1){(uint8_t *)a[17].p, {a[18].i}});
}
void gm_bag_message_block_find_messages(gm_slot *a)
{
    tuple_4 r = message_block_find_messages((array1_u1){(uint8_t *)a[8].p, {a[9].i}}, a[10].i, a[11].i, (array1_i4){(int32_t *)a[12].p, {a[13].i}}, (a[14].i != 0), a[15].i, (MessageIndex){(array1_i8){(int64_t *)a[16].p, {a[17].i}}, (array1_i8){(int64_t *)a[18].p, {a[19].i}}, (array1_i4){(int32_t *)a[20].p, {a[21].i}}, (array1_u8){(uint64_t *)a[22].p, {a[23].i}}, (array1_u8){(uint64_t *)a[24].p, {a[25].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_filter__call_aekf_0(gm_slot *a)
{
    bool r = filter_call_aekf((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (real)a[12].d, (real)a[13].d, (real)a[14].d);
    a[0].i = r;
}
void gm_estimation_filter__call_aekf_1(gm_slot *a)
{
    bool r = filter_call_aekf_2((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (real)a[12].d, (real)a[13].d, (real)a[14].d);
    a[0].i = r;
}
void gm_estimation_filter__call_ekf_0(gm_slot *a)
{
    bool r = filter_call_ekf((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (real)a[12].d, (real)a[13].d, (real)a[14].d);
    a[0].i = r;
}
void gm_estimation_filter__call_ekf_1(gm_slot *a)
{
    bool r = filter_call_ekf_2((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (real)a[12].d, (real)a[13].d, (real)a[14].d);
    a[0].i = r;
}
void gm_estimation_filter__call_srukf_0(gm_slot *a)
{
    bool r = filter_call_srukf((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (real)a[12].d, (real)a[13].d, (real)a[14].d);
    a[0].i = r;
}
void gm_estimation_filter__call_srukf_1(gm_slot *a)
{
    bool r = filter_call_srukf_2((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (real)a[12].d, (real)a[13].d, (real)a[14].d);
    a[0].i = r;
}
void gm_estimation_filter__call_ukf_0(gm_slot *a)
{
    bool r = filter_call_ukf((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (real)a[12].d, (real)a[13].d, (real)a[14].d);
    a[0].i = r;
}
void gm_estimation_filter__call_ukf_1(gm_slot *a)
{
    bool r = filter_call_ukf_2((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (real)a[12].d, (real)a[13].d, (real)a[14].d);
    a[0].i = r;
}
void gm_estimation_innovation_filter_filtered(gm_slot *a)
{
    real r = innovation_filter_filtered((PackedDrive){(array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}}, a[14].i}, (SampleSchedule){(array1_f8){(real *)a[15].p, {a[16].i}}, (array1_i8){(int64_t *)a[17].p, {a[18].i}}, (array1_i8){(int64_t *)a[19].p, {a[20].i}}, (array1_f8){(real *)a[21].p, {a[22].i}}, (array2_i8){(int64_t *)a[23].p, {a[24].i, a[25].i}}, (array1_i8){(int64_t *)a[26].p, {a[27].i}}}, (FilterInput){(array2_f8){(real *)a[28].p, {a[29].i, a[30].i}}, (array2_f8){(real *)a[31].p, {a[32].i, a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (real)a[37].d, (array1_i8){(int64_t *)a[38].p, {a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (array1_f8){(real *)a[44].p, {a[45].i}}, (real)a[46].d, a[47].i}, (FilterStart){(array2_f8){(real *)a[48].p, {a[49].i, a[50].i}}, (array1_i8){(int64_t *)a[51].p, {a[52].i}}, (array2_f8){(real *)a[53].p, {a[54].i, a[55].i}}, (array1_f8){(real *)a[56].p, {a[57].i}}}, (array1_f8){(real *)a[58].p, {a[59].i}}, (array3_f8){(real *)a[60].p, {a[61].i, a[62].i, a[63].i}}, (FilterTrace){(array3_f8){(real *)a[64].p, {a[65].i, a[66].i, a[67].i}}, (array3_f8){(real *)a[68].p, {a[69].i, a[70].i, a[71].i}}, (array4_f8){(real *)a[72].p, {a[73].i, a[74].i, a[75].i, a[76].i}}, (array3_f8){(real *)a[77].p, {a[78].i, a[79].i, a[80].i}}, (array2_f8){(real *)a[81].p, {a[82].i, a[83].i}}, (array2_f8){(real *)a[84].p, {a[85].i, a[86].i}}, (array3_f8){(real *)a[87].p, {a[88].i, a[89].i, a[90].i}}, (array2_f8){(real *)a[91].p, {a[92].i, a[93].i}}, (array2_f8){(real *)a[94].p, {a[95].i, a[96].i}}, (array2_f8){(real *)a[97].p, {a[98].i, a[99].i}}});
    a[0].d = r;
}
void gm_estimation_innovation_filter_sensitivity(gm_slot *a)
{
    innovation_filter_sensitivity((tuple_42){{(PackedDrive){(array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}}, a[14].i}, (PackedDrive){(array1_f8){(real *)a[15].p, {a[16].i}}, (array1_f8){(real *)a[17].p, {a[18].i}}, (array1_f8){(real *)a[19].p, {a[20].i}}, a[21].i}}}, (SampleSchedule){(array1_f8){(real *)a[22].p, {a[23].i}}, (array1_i8){(int64_t *)a[24].p, {a[25].i}}, (array1_i8){(int64_t *)a[26].p, {a[27].i}}, (array1_f8){(real *)a[28].p, {a[29].i}}, (array2_i8){(int64_t *)a[30].p, {a[31].i, a[32].i}}, (array1_i8){(int64_t *)a[33].p, {a[34].i}}}, (FilterInput){(array2_f8){(real *)a[35].p, {a[36].i, a[37].i}}, (array2_f8){(real *)a[38].p, {a[39].i, a[40].i}}, (array2_f8){(real *)a[41].p, {a[42].i, a[43].i}}, (real)a[44].d, (array1_i8){(int64_t *)a[45].p, {a[46].i}}, (array1_i8){(int64_t *)a[47].p, {a[48].i}}, (array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (real)a[53].d, a[54].i}, (array1_i8){(int64_t *)a[55].p, {a[56].i}}, (array1_f8){(real *)a[57].p, {a[58].i}}, (FilterTrace){(array3_f8){(real *)a[59].p, {a[60].i, a[61].i, a[62].i}}, (array3_f8){(real *)a[63].p, {a[64].i, a[65].i, a[66].i}}, (array4_f8){(real *)a[67].p, {a[68].i, a[69].i, a[70].i, a[71].i}}, (array3_f8){(real *)a[72].p, {a[73].i, a[74].i, a[75].i}}, (array2_f8){(real *)a[76].p, {a[77].i, a[78].i}}, (array2_f8){(real *)a[79].p, {a[80].i, a[81].i}}, (array3_f8){(real *)a[82].p, {a[83].i, a[84].i, a[85].i}}, (array2_f8){(real *)a[86].p, {a[87].i, a[88].i}}, (array2_f8){(real *)a[89].p, {a[90].i, a[91].i}}, (array2_f8){(real *)a[92].p, {a[93].i, a[94].i}}}, (array3_f8){(real *)a[95].p, {a[96].i, a[97].i, a[98].i}}, (array2_f8){(real *)a[99].p, {a[100].i, a[101].i}});
}
void gm_estimation_innovation_filter_smoothed(gm_slot *a)
{
    innovation_filter_smoothed((SampleSchedule){(array1_f8){(real *)a[8].p, {a[9].i}}, (array1_i8){(int64_t *)a[10].p, {a[11].i}}, (array1_i8){(int64_t *)a[12].p, {a[13].i}}, (array1_f8){(real *)a[14].p, {a[15].i}}, (array2_i8){(int64_t *)a[16].p, {a[17].i, a[18].i}}, (array1_i8){(int64_t *)a[19].p, {a[20].i}}}, (FilterInput){(array2_f8){(real *)a[21].p, {a[22].i, a[23].i}}, (array2_f8){(real *)a[24].p, {a[25].i, a[26].i}}, (array2_f8){(real *)a[27].p, {a[28].i, a[29].i}}, (real)a[30].d, (array1_i8){(int64_t *)a[31].p, {a[32].i}}, (array1_i8){(int64_t *)a[33].p, {a[34].i}}, (array1_f8){(real *)a[35].p, {a[36].i}}, (array1_f8){(real *)a[37].p, {a[38].i}}, (real)a[39].d, a[40].i}, (array1_i8){(int64_t *)a[41].p, {a[42].i}}, (FilterTrace){(array3_f8){(real *)a[43].p, {a[44].i, a[45].i, a[46].i}}, (array3_f8){(real *)a[47].p, {a[48].i, a[49].i, a[50].i}}, (array4_f8){(real *)a[51].p, {a[52].i, a[53].i, a[54].i, a[55].i}}, (array3_f8){(real *)a[56].p, {a[57].i, a[58].i, a[59].i}}, (array2_f8){(real *)a[60].p, {a[61].i, a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array3_f8){(real *)a[66].p, {a[67].i, a[68].i, a[69].i}}, (array2_f8){(real *)a[70].p, {a[71].i, a[72].i}}, (array2_f8){(real *)a[73].p, {a[74].i, a[75].i}}, (array2_f8){(real *)a[76].p, {a[77].i, a[78].i}}}, (array1_f8){(real *)a[79].p, {a[80].i}}, (array2_f8){(real *)a[81].p, {a[82].i, a[83].i}});
}
void gm_estimation_innovation_filter_with_noise(gm_slot *a)
{
    real r = innovation_filter_with_noise((PackedDrive){(array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}}, a[14].i}, (SampleSchedule){(array1_f8){(real *)a[15].p, {a[16].i}}, (array1_i8){(int64_t *)a[17].p, {a[18].i}}, (array1_i8){(int64_t *)a[19].p, {a[20].i}}, (array1_f8){(real *)a[21].p, {a[22].i}}, (array2_i8){(int64_t *)a[23].p, {a[24].i, a[25].i}}, (array1_i8){(int64_t *)a[26].p, {a[27].i}}}, (FilterInput){(array2_f8){(real *)a[28].p, {a[29].i, a[30].i}}, (array2_f8){(real *)a[31].p, {a[32].i, a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (real)a[37].d, (array1_i8){(int64_t *)a[38].p, {a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (array1_f8){(real *)a[44].p, {a[45].i}}, (real)a[46].d, a[47].i}, (FilterStart){(array2_f8){(real *)a[48].p, {a[49].i, a[50].i}}, (array1_i8){(int64_t *)a[51].p, {a[52].i}}, (array2_f8){(real *)a[53].p, {a[54].i, a[55].i}}, (array1_f8){(real *)a[56].p, {a[57].i}}}, (FilterTrace){(array3_f8){(real *)a[58].p, {a[59].i, a[60].i, a[61].i}}, (array3_f8){(real *)a[62].p, {a[63].i, a[64].i, a[65].i}}, (array4_f8){(real *)a[66].p, {a[67].i, a[68].i, a[69].i, a[70].i}}, (array3_f8){(real *)a[71].p, {a[72].i, a[73].i, a[74].i}}, (array2_f8){(real *)a[75].p, {a[76].i, a[77].i}}, (array2_f8){(real *)a[78].p, {a[79].i, a[80].i}}, (array3_f8){(real *)a[81].p, {a[82].i, a[83].i, a[84].i}}, (array2_f8){(real *)a[85].p, {a[86].i, a[87].i}}, (array2_f8){(real *)a[88].p, {a[89].i, a[90].i}}, (array2_f8){(real *)a[91].p, {a[92].i, a[93].i}}}, (array2_f8){(real *)a[94].p, {a[95].i, a[96].i}}, (array2_f8){(real *)a[97].p, {a[98].i, a[99].i}}, (array2_f8){(real *)a[100].p, {a[101].i, a[102].i}});
    a[0].d = r;
}
void gm_estimation_model_bank_begin(gm_slot *a)
{
    model_bank_begin((Mixture){(array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}}, (array1_i8){(int64_t *)a[12].p, {a[13].i}}, (array2_f8){(real *)a[14].p, {a[15].i, a[16].i}}, (array1_i8){(int64_t *)a[17].p, {a[18].i}}, (array1_f8){(real *)a[19].p, {a[20].i}}, (array2_f8){(real *)a[21].p, {a[22].i, a[23].i}}, (array1_i8){(int64_t *)a[24].p, {a[25].i}}}, a[26].i);
}
void gm_estimation_model_bank_mix(gm_slot *a)
{
    model_bank_mix((Mixture){(array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}}, (array1_i8){(int64_t *)a[12].p, {a[13].i}}, (array2_f8){(real *)a[14].p, {a[15].i, a[16].i}}, (array1_i8){(int64_t *)a[17].p, {a[18].i}}, (array1_f8){(real *)a[19].p, {a[20].i}}, (array2_f8){(real *)a[21].p, {a[22].i, a[23].i}}, (array1_i8){(int64_t *)a[24].p, {a[25].i}}}, (Outputs){(array2_i8){(int64_t *)a[26].p, {a[27].i, a[28].i}}, (array3_f8){(real *)a[29].p, {a[30].i, a[31].i, a[32].i}}, (array2_i8){(int64_t *)a[33].p, {a[34].i, a[35].i}}, (array3_f8){(real *)a[36].p, {a[37].i, a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}}, (array1_i8){(int64_t *)a[42].p, {a[43].i}}, (Output){(array1_i8){(int64_t *)a[44].p, {a[45].i}}, (array2_f8){(real *)a[46].p, {a[47].i, a[48].i}}, (array1_i8){(int64_t *)a[49].p, {a[50].i}}, (array2_f8){(real *)a[51].p, {a[52].i, a[53].i}}});
}
void gm_estimation_model_bank_mix_interval(gm_slot *a)
{
    model_bank_mix_interval((array2_f8){(real *)a[8].p, {a[9].i, a[10].i}}, (array3_f8){(real *)a[11].p, {a[12].i, a[13].i, a[14].i}}, (array2_f8){(real *)a[15].p, {a[16].i, a[17].i}});
}
void gm_estimation_model_bank_mix_smoothed(gm_slot *a)
{
    model_bank_mix_smoothed((Mixture){(array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}}, (array1_i8){(int64_t *)a[12].p, {a[13].i}}, (array2_f8){(real *)a[14].p, {a[15].i, a[16].i}}, (array1_i8){(int64_t *)a[17].p, {a[18].i}}, (array1_f8){(real *)a[19].p, {a[20].i}}, (array2_f8){(real *)a[21].p, {a[22].i, a[23].i}}, (array1_i8){(int64_t *)a[24].p, {a[25].i}}}, (Outputs){(array2_i8){(int64_t *)a[26].p, {a[27].i, a[28].i}}, (array3_f8){(real *)a[29].p, {a[30].i, a[31].i, a[32].i}}, (array2_i8){(int64_t *)a[33].p, {a[34].i, a[35].i}}, (array3_f8){(real *)a[36].p, {a[37].i, a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}}, (Output){(array1_i8){(int64_t *)a[42].p, {a[43].i}}, (array2_f8){(real *)a[44].p, {a[45].i, a[46].i}}, (array1_i8){(int64_t *)a[47].p, {a[48].i}}, (array2_f8){(real *)a[49].p, {a[50].i, a[51].i}}});
}
void gm_estimation_process_model_advance(gm_slot *a)
{
    process_model_advance_3((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (array1_f8){(real *)a[12].p, {a[13].i}}, (tuple_7){{(real)a[14].d, (real)a[15].d}}, (real)a[16].d, a[17].i, (array1_f8){(real *)a[18].p, {a[19].i}});
}
void gm_estimation_process_model_propagate(gm_slot *a)
{
    process_model_propagate_3((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (array1_f8){(real *)a[12].p, {a[13].i}}, (array1_f8){(real *)a[14].p, {a[15].i}}, (tuple_7){{(real)a[16].d, (real)a[17].d}}, (real)a[18].d, a[19].i, (array1_f8){(real *)a[20].p, {a[21].i}});
}
void gm_estimation_process_model_tangent(gm_slot *a)
{
    process_model_tangent((array1_f8){(real *)a[8].p, {a[9].i}}, (array2_f8){(real *)a[10].p, {a[11].i, a[12].i}}, (array1_f8){(real *)a[13].p, {a[14].i}}, (array2_f8){(real *)a[15].p, {a[16].i, a[17].i}});
}
void gm_estimation_rts_smoother_smooth(gm_slot *a)
{
    rts_smoother_smooth((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (array2_f8){(real *)a[12].p, {a[13].i, a[14].i}}, (Span){a[15].i, a[16].i, a[17].i}, (array1_f8){(real *)a[18].p, {a[19].i}}, (array1_f8){(real *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}});
}
void gm_estimation_sample_loop__stamp_codes(gm_slot *a)
{
    sample_loop_stamp_codes((array1_i8){(int64_t *)a[8].p, {a[9].i}}, a[10].i, (array1_i8){(int64_t *)a[11].p, {a[12].i}}, (array1_i8){(int64_t *)a[13].p, {a[14].i}});
}
void gm_estimation_sample_loop_run_aekf_0(gm_slot *a)
{
    tuple_4 r = sample_loop_run_aekf((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_aekf_1(gm_slot *a)
{
    tuple_4 r = sample_loop_run_aekf_2((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_ekf_0(gm_slot *a)
{
    tuple_4 r = sample_loop_run_ekf((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_ekf_1(gm_slot *a)
{
    tuple_4 r = sample_loop_run_ekf_2((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_ekf_2(gm_slot *a)
{
    tuple_4 r = sample_loop_run_ekf_3((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_ekf_3(gm_slot *a)
{
    tuple_4 r = sample_loop_run_ekf_4((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_slopes_0(gm_slot *a)
{
    tuple_4 r = sample_loop_run_slopes((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_slopes_1(gm_slot *a)
{
    tuple_4 r = sample_loop_run_slopes_2((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_srukf_0(gm_slot *a)
{
    tuple_4 r = sample_loop_run_srukf((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_srukf_1(gm_slot *a)
{
    tuple_4 r = sample_loop_run_srukf_2((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_ukf_0(gm_slot *a)
{
    tuple_4 r = sample_loop_run_ukf((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_run_ukf_1(gm_slot *a)
{
    tuple_4 r = sample_loop_run_ukf_2((LoopSettings){a[8].i, a[9].i, a[10].i, (a[11].i != 0), (a[12].i != 0), (DescribedLoad){(real)a[13].d, (real)a[14].d, (real)a[15].d, (real)a[16].d, (real)a[17].d}}, (array1_f8){(real *)a[18].p, {a[19].i}}, (Stream){(array1_i8){(int64_t *)a[20].p, {a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}}, (LoopState){(array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_i8){(int64_t *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array2_f8){(real *)a[34].p, {a[35].i, a[36].i}}, (array2_f8){(real *)a[37].p, {a[38].i, a[39].i}}, (array1_i8){(int64_t *)a[40].p, {a[41].i}}, (array1_f8){(real *)a[42].p, {a[43].i}}, (Companions){a[44].i, (array1_f8){(real *)a[45].p, {a[46].i}}, (array1_f8){(real *)a[47].p, {a[48].i}}}}, (Belief){(array1_f8){(real *)a[49].p, {a[50].i}}, (array1_f8){(real *)a[51].p, {a[52].i}}, (array1_f8){(real *)a[53].p, {a[54].i}}}, (Scratch){(array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (Output){(array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array1_i8){(int64_t *)a[66].p, {a[67].i}}, (array2_f8){(real *)a[68].p, {a[69].i, a[70].i}}});
    a[0].i = r.v[0];
    a[1].i = r.v[1];
}
void gm_estimation_sample_loop_start(gm_slot *a)
{
    sample_loop_start_5((Layout){a[8].i, (a[9].i != 0), a[10].i, (a[11].i != 0)}, (Belief){(array1_f8){(real *)a[12].p, {a[13].i}}, (array1_f8){(real *)a[14].p, {a[15].i}}, (array1_f8){(real *)a[16].p, {a[17].i}}}, (real)a[18].d, (real)a[19].d, (array1_f8){(real *)a[20].p, {a[21].i}}, (array1_f8){(real *)a[22].p, {a[23].i}});
}
void gm_estimation_whiteness__centre(gm_slot *a)
{
    int64_t r = whiteness_centre((array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}});
    a[0].i = r;
}
void gm_monitoring_checks_elastic_curve__stretches(gm_slot *a)
{
    elastic_curve_stretches((array1_f8){(real *)a[8].p, {a[9].i}}, (real)a[10].d, (real)a[11].d, (array1_f8){(real *)a[12].p, {a[13].i}});
}
void gm_monitoring_checks_innovation__finite_sum(gm_slot *a)
{
    tuple_44 r = innovation_finite_sum((array1_f8){(real *)a[8].p, {a[9].i}});
    a[0].d = r.f0;
    a[1].i = r.f1;
}
void gm_monitoring_checks_innovation__sizes(gm_slot *a)
{
    tuple_15 r = innovation_sizes((array2_f8){(real *)a[8].p, {a[9].i, a[10].i}}, (array2_f8){(real *)a[11].p, {a[12].i, a[13].i}}, a[14].i);
    a[0].d = r.v[0];
    a[1].d = r.v[1];
    a[2].d = r.v[2];
}
void gm_monitoring_checks_observability__gramian(gm_slot *a)
{
    observability_gramian((array2_f8){(real *)a[8].p, {a[9].i, a[10].i}}, (array1_f8){(real *)a[11].p, {a[12].i}}, (array2_b1){(bool *)a[13].p, {a[14].i, a[15].i}}, (array1_f8){(real *)a[16].p, {a[17].i}}, (array2_f8){(real *)a[18].p, {a[19].i, a[20].i}}, (array2_f8){(real *)a[21].p, {a[22].i, a[23].i}}, (array2_f8){(real *)a[24].p, {a[25].i, a[26].i}});
}
void gm_monitoring_elastic_regression__minimise(gm_slot *a)
{
    elastic_regression_minimise((array1_f8){(real *)a[8].p, {a[9].i}}, (array1_b1){(bool *)a[10].p, {a[11].i}}, (Problem){(ElasticLaw){(a[12].i != 0), (a[13].i != 0), (real)a[14].d, (tuple_15){{(real)a[15].d, (real)a[16].d, (real)a[17].d}}, a[18].i, (a[19].i != 0), a[20].i, (real)a[21].d}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array1_f8){(real *)a[25].p, {a[26].i}}, (array1_f8){(real *)a[27].p, {a[28].i}}, (array1_f8){(real *)a[29].p, {a[30].i}}, (array1_f8){(real *)a[31].p, {a[32].i}}, (array1_f8){(real *)a[33].p, {a[34].i}}, (array1_f8){(real *)a[35].p, {a[36].i}}, (a[37].i != 0)}, (Damping){(real)a[38].d, (real)a[39].d, (real)a[40].d, (real)a[41].d, (real)a[42].d, (real)a[43].d, a[44].i, (real)a[45].d, (real)a[46].d, (real)a[47].d, (a[48].i != 0)}, (real)a[49].d, a[50].i, (Room){(tuple_45){(array3_f8){(real *)a[51].p, {a[52].i, a[53].i, a[54].i}}, (array2_f8){(real *)a[55].p, {a[56].i, a[57].i}}, (array2_f8){(real *)a[58].p, {a[59].i, a[60].i}}}, (array1_f8){(real *)a[61].p, {a[62].i}}, (array3_f8){(real *)a[63].p, {a[64].i, a[65].i, a[66].i}}, (array2_f8){(real *)a[67].p, {a[68].i, a[69].i}}});
}
void gm_monitoring_elastic_regression_normal_equations(gm_slot *a)
{
    tuple_7 r = elastic_regression_normal_equations((array1_f8){(real *)a[8].p, {a[9].i}}, (array1_b1){(bool *)a[10].p, {a[11].i}}, (ElasticLaw){(a[12].i != 0), (a[13].i != 0), (real)a[14].d, (tuple_15){{(real)a[15].d, (real)a[16].d, (real)a[17].d}}, a[18].i, (a[19].i != 0), a[20].i, (real)a[21].d}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array1_f8){(real *)a[25].p, {a[26].i}}, (array1_f8){(real *)a[27].p, {a[28].i}}, (tuple_45){(array3_f8){(real *)a[29].p, {a[30].i, a[31].i, a[32].i}}, (array2_f8){(real *)a[33].p, {a[34].i, a[35].i}}, (array2_f8){(real *)a[36].p, {a[37].i, a[38].i}}}, (array1_f8){(real *)a[39].p, {a[40].i}});
    a[0].d = r.v[0];
    a[1].d = r.v[1];
}
void gm_plant_batch_runs(gm_slot *a)
{
    batch_runs((RunSpans){(array1_i8){(int64_t *)a[8].p, {a[9].i}}, (array1_i8){(int64_t *)a[10].p, {a[11].i}}, a[12].i, (array1_i8){(int64_t *)a[13].p, {a[14].i}}, (array1_i8){(int64_t *)a[15].p, {a[16].i}}}, (Begin){(array2_f8){(real *)a[17].p, {a[18].i, a[19].i}}, (array2_f8){(real *)a[20].p, {a[21].i, a[22].i}}}, (Driving){(array2_f8){(real *)a[23].p, {a[24].i, a[25].i}}, (array2_f8){(real *)a[26].p, {a[27].i, a[28].i}}, (real)a[29].d}, (PackedDrive){(array1_f8){(real *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array1_f8){(real *)a[34].p, {a[35].i}}, a[36].i}, (array1_f8){(real *)a[37].p, {a[38].i}}, (array3_f8){(real *)a[39].p, {a[40].i, a[41].i, a[42].i}}, (RunResult){(array3_f8){(real *)a[43].p, {a[44].i, a[45].i, a[46].i}}, (array2_f8){(real *)a[47].p, {a[48].i, a[49].i}}});
}
void gm_plant_effects_composition_actuator(gm_slot *a)
{
    real r = composition_actuator((array1_f8){(real *)a[8].p, {a[9].i}}, a[10].i, (real)a[11].d, (real)a[12].d, (array1_f8){(real *)a[13].p, {a[14].i}}, (array2_f8){(real *)a[15].p, {a[16].i, a[17].i}});
    a[0].d = r;
}
void gm_plant_effects_composition_lead(gm_slot *a)
{
    composition_lead((array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}}, (real)a[12].d, (array1_f8){(real *)a[13].p, {a[14].i}});
}
void gm_plant_effects_composition_steady_command(gm_slot *a)
{
    real r = composition_steady_command((real)a[8].d, (array1_f8){(real *)a[9].p, {a[10].i}});
    a[0].d = r;
}
void gm_plant_equivalent_torque__run(gm_slot *a)
{
    equivalent_torque_run((array1_f8){(real *)a[8].p, {a[9].i}}, (Schedule){(array1_f8){(real *)a[10].p, {a[11].i}}, (array2_f8){(real *)a[12].p, {a[13].i, a[14].i}}, (array2_f8){(real *)a[15].p, {a[16].i, a[17].i}}, (real)a[18].d}, (ProcessNoise){(array3_f8){(real *)a[19].p, {a[20].i, a[21].i, a[22].i}}, (array1_f8){(real *)a[23].p, {a[24].i}}}, (tuple_42){{(PackedDrive){(array1_f8){(real *)a[25].p, {a[26].i}}, (array1_f8){(real *)a[27].p, {a[28].i}}, (array1_f8){(real *)a[29].p, {a[30].i}}, a[31].i}, (PackedDrive){(array1_f8){(real *)a[32].p, {a[33].i}}, (array1_f8){(real *)a[34].p, {a[35].i}}, (array1_f8){(real *)a[36].p, {a[37].i}}, a[38].i}}}, (array2_f8){(real *)a[39].p, {a[40].i, a[41].i}});
}
void gm_plant_equivalent_torque_gains(gm_slot *a)
{
    equivalent_torque_gains((array1_f8){(real *)a[8].p, {a[9].i}}, (array1_f8){(real *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}});
}
void gm_plant_equivalent_torque_imbalance(gm_slot *a)
{
    equivalent_torque_imbalance((tuple_46){(array1_f8){(real *)a[8].p, {a[9].i}}, (array2_f8){(real *)a[10].p, {a[11].i, a[12].i}}}, (real)a[13].d, (tuple_7){{(real)a[14].d, (real)a[15].d}}, (array1_f8){(real *)a[16].p, {a[17].i}}, (array2_f8){(real *)a[18].p, {a[19].i, a[20].i}}, (PackedDrive){(array1_f8){(real *)a[21].p, {a[22].i}}, (array1_f8){(real *)a[23].p, {a[24].i}}, (array1_f8){(real *)a[25].p, {a[26].i}}, a[27].i}, (array1_f8){(real *)a[28].p, {a[29].i}}, (array2_f8){(real *)a[30].p, {a[31].i, a[32].i}});
}
void gm_plant_equivalent_torque_true_motion(gm_slot *a)
{
    equivalent_torque_true_motion((array2_f8){(real *)a[8].p, {a[9].i, a[10].i}}, (real)a[11].d, (array1_f8){(real *)a[12].p, {a[13].i}}, (array2_f8){(real *)a[14].p, {a[15].i, a[16].i}});
}
void gm_plant_free_runs_free_runs(gm_slot *a)
{
    free_runs_free_runs((RunSpans){(array1_i8){(int64_t *)a[8].p, {a[9].i}}, (array1_i8){(int64_t *)a[10].p, {a[11].i}}, a[12].i, (array1_i8){(int64_t *)a[13].p, {a[14].i}}, (array1_i8){(int64_t *)a[15].p, {a[16].i}}}, (Begin){(array2_f8){(real *)a[17].p, {a[18].i, a[19].i}}, (array2_f8){(real *)a[20].p, {a[21].i, a[22].i}}}, (Driving){(array2_f8){(real *)a[23].p, {a[24].i, a[25].i}}, (array2_f8){(real *)a[26].p, {a[27].i, a[28].i}}, (real)a[29].d}, (PackedDrive){(array1_f8){(real *)a[30].p, {a[31].i}}, (array1_f8){(real *)a[32].p, {a[33].i}}, (array1_f8){(real *)a[34].p, {a[35].i}}, a[36].i}, (ProcessNoise){(array3_f8){(real *)a[37].p, {a[38].i, a[39].i, a[40].i}}, (array1_f8){(real *)a[41].p, {a[42].i}}}, (array2_f8){(real *)a[43].p, {a[44].i, a[45].i}}, (RunResult){(array3_f8){(real *)a[46].p, {a[47].i, a[48].i, a[49].i}}, (array2_f8){(real *)a[50].p, {a[51].i, a[52].i}}});
}
void gm_plant_simulate__run(gm_slot *a)
{
    simulate_run((array1_f8){(real *)a[8].p, {a[9].i}}, (Schedule){(array1_f8){(real *)a[10].p, {a[11].i}}, (array2_f8){(real *)a[12].p, {a[13].i, a[14].i}}, (array2_f8){(real *)a[15].p, {a[16].i, a[17].i}}, (real)a[18].d}, (ProcessNoise){(array3_f8){(real *)a[19].p, {a[20].i, a[21].i, a[22].i}}, (array1_f8){(real *)a[23].p, {a[24].i}}}, (PackedDrive){(array1_f8){(real *)a[25].p, {a[26].i}}, (array1_f8){(real *)a[27].p, {a[28].i}}, (array1_f8){(real *)a[29].p, {a[30].i}}, a[31].i}, (array2_f8){(real *)a[32].p, {a[33].i, a[34].i}}, (array2_f8){(real *)a[35].p, {a[36].i, a[37].i}}, (real)a[38].d);
}
void gm_plant_simulate_read_all(gm_slot *a)
{
    simulate_read_all((array2_f8){(real *)a[8].p, {a[9].i, a[10].i}}, a[11].i, (real)a[12].d, (array1_f8){(real *)a[13].p, {a[14].i}}, (array2_f8){(real *)a[15].p, {a[16].i, a[17].i}});
}
void gm_robot_arm_load_write_loads(gm_slot *a)
{
    arm_load_write_loads((RobotArrays){(array1_i8){(int64_t *)a[8].p, {a[9].i}}, (array1_i8){(int64_t *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}}, (array1_f8){(real *)a[14].p, {a[15].i}}, (array1_f8){(real *)a[16].p, {a[17].i}}, (array3_f8){(real *)a[18].p, {a[19].i, a[20].i, a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}, (array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_f8){(real *)a[30].p, {a[31].i}}, (array2_f8){(real *)a[32].p, {a[33].i, a[34].i}}, (array3_f8){(real *)a[35].p, {a[36].i, a[37].i, a[38].i}}, (array1_f8){(real *)a[39].p, {a[40].i}}, (array1_f8){(real *)a[41].p, {a[42].i}}, (array1_f8){(real *)a[43].p, {a[44].i}}, (array2_f8){(real *)a[45].p, {a[46].i, a[47].i}}, (array2_f8){(real *)a[48].p, {a[49].i, a[50].i}}}, (MotionState){(array2_f8){(real *)a[51].p, {a[52].i, a[53].i}}, (array1_i8){(int64_t *)a[54].p, {a[55].i}}, (array2_f8){(real *)a[56].p, {a[57].i, a[58].i}}}, a[59].i, (real)a[60].d, (array1_i8){(int64_t *)a[61].p, {a[62].i}}, (array2_f8){(real *)a[63].p, {a[64].i, a[65].i}}, (array2_f8){(real *)a[66].p, {a[67].i, a[68].i}}, (array1_f8){(real *)a[69].p, {a[70].i}});
}
void gm_robot_arm_plant__run(gm_slot *a)
{
    arm_plant_run((RobotArrays){(array1_i8){(int64_t *)a[8].p, {a[9].i}}, (array1_i8){(int64_t *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}}, (array1_f8){(real *)a[14].p, {a[15].i}}, (array1_f8){(real *)a[16].p, {a[17].i}}, (array3_f8){(real *)a[18].p, {a[19].i, a[20].i, a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}, (array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_f8){(real *)a[30].p, {a[31].i}}, (array2_f8){(real *)a[32].p, {a[33].i, a[34].i}}, (array3_f8){(real *)a[35].p, {a[36].i, a[37].i, a[38].i}}, (array1_f8){(real *)a[39].p, {a[40].i}}, (array1_f8){(real *)a[41].p, {a[42].i}}, (array1_f8){(real *)a[43].p, {a[44].i}}, (array2_f8){(real *)a[45].p, {a[46].i, a[47].i}}, (array2_f8){(real *)a[48].p, {a[49].i, a[50].i}}}, (ServoDrives){(array2_f8){(real *)a[51].p, {a[52].i, a[53].i}}, (array1_f8){(real *)a[54].p, {a[55].i}}, (array1_f8){(real *)a[56].p, {a[57].i}}}, (array3_f8){(real *)a[58].p, {a[59].i, a[60].i, a[61].i}}, (array1_f8){(real *)a[62].p, {a[63].i}}, (array1_f8){(real *)a[64].p, {a[65].i}}, (real)a[66].d, (ArmScratch){(array2_f8){(real *)a[67].p, {a[68].i, a[69].i}}, (array1_f8){(real *)a[70].p, {a[71].i}}, (array2_f8){(real *)a[72].p, {a[73].i, a[74].i}}, (array2_f8){(real *)a[75].p, {a[76].i, a[77].i}}}, (array3_f8){(real *)a[78].p, {a[79].i, a[80].i, a[81].i}});
}
void gm_robot_dynamics_coupled_inertia(gm_slot *a)
{
    real r = dynamics_coupled_inertia_2((RobotArrays){(array1_i8){(int64_t *)a[8].p, {a[9].i}}, (array1_i8){(int64_t *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}}, (array1_f8){(real *)a[14].p, {a[15].i}}, (array1_f8){(real *)a[16].p, {a[17].i}}, (array3_f8){(real *)a[18].p, {a[19].i, a[20].i, a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}, (array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_f8){(real *)a[30].p, {a[31].i}}, (array2_f8){(real *)a[32].p, {a[33].i, a[34].i}}, (array3_f8){(real *)a[35].p, {a[36].i, a[37].i, a[38].i}}, (array1_f8){(real *)a[39].p, {a[40].i}}, (array1_f8){(real *)a[41].p, {a[42].i}}, (array1_f8){(real *)a[43].p, {a[44].i}}, (array2_f8){(real *)a[45].p, {a[46].i, a[47].i}}, (array2_f8){(real *)a[48].p, {a[49].i, a[50].i}}}, a[51].i, a[52].i);
    a[0].d = r;
}
void gm_robot_dynamics_move(gm_slot *a)
{
    dynamics_move((RobotArrays){(array1_i8){(int64_t *)a[8].p, {a[9].i}}, (array1_i8){(int64_t *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}}, (array1_f8){(real *)a[14].p, {a[15].i}}, (array1_f8){(real *)a[16].p, {a[17].i}}, (array3_f8){(real *)a[18].p, {a[19].i, a[20].i, a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}, (array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_f8){(real *)a[30].p, {a[31].i}}, (array2_f8){(real *)a[32].p, {a[33].i, a[34].i}}, (array3_f8){(real *)a[35].p, {a[36].i, a[37].i, a[38].i}}, (array1_f8){(real *)a[39].p, {a[40].i}}, (array1_f8){(real *)a[41].p, {a[42].i}}, (array1_f8){(real *)a[43].p, {a[44].i}}, (array2_f8){(real *)a[45].p, {a[46].i, a[47].i}}, (array2_f8){(real *)a[48].p, {a[49].i, a[50].i}}}, (array2_f8){(real *)a[51].p, {a[52].i, a[53].i}});
}
void gm_robot_dynamics_torque_on(gm_slot *a)
{
    tuple_15 r = dynamics_torque_on((RobotArrays){(array1_i8){(int64_t *)a[8].p, {a[9].i}}, (array1_i8){(int64_t *)a[10].p, {a[11].i}}, (array1_f8){(real *)a[12].p, {a[13].i}}, (array1_f8){(real *)a[14].p, {a[15].i}}, (array1_f8){(real *)a[16].p, {a[17].i}}, (array3_f8){(real *)a[18].p, {a[19].i, a[20].i, a[21].i}}, (array2_f8){(real *)a[22].p, {a[23].i, a[24].i}}, (array2_f8){(real *)a[25].p, {a[26].i, a[27].i}}, (array1_i8){(int64_t *)a[28].p, {a[29].i}}, (array1_f8){(real *)a[30].p, {a[31].i}}, (array2_f8){(real *)a[32].p, {a[33].i, a[34].i}}, (array3_f8){(real *)a[35].p, {a[36].i, a[37].i, a[38].i}}, (array1_f8){(real *)a[39].p, {a[40].i}}, (array1_f8){(real *)a[41].p, {a[42].i}}, (array1_f8){(real *)a[43].p, {a[44].i}}, (array2_f8){(real *)a[45].p, {a[46].i, a[47].i}}, (array2_f8){(real *)a[48].p, {a[49].i, a[50].i}}}, a[51].i, (real)a[52].d);
    a[0].d = r.v[0];
    a[1].d = r.v[1];
    a[2].d = r.v[2];
}
const char *gm_sources = "bag/__init__.py\nbag/cdr.py\nbag/message_block.py\ncompiled.py\nerrors.py\nestimation/__init__.py\nestimation/adaptation.py\nestimation/consider.py\nestimation/estimates.py\nestimation/estimator.py\nestimation/filter.py\nestimation/filter_kind.py\nestimation/filter_setup.py\nestimation/filterpy_reference.py\nestimation/filters/__init__.py\nestimation/filters/aekf.py\nestimation/filters/ekf.py\nestimation/filters/srukf.py\nestimation/filters/ukf.py\nestimation/innovation_filter.py\nestimation/model_bank.py\nestimation/noise_search.py\nestimation/process_model.py\nestimation/rts_smoother.py\nestimation/sample_loop.py\nestimation/score.py\nestimation/sigma_points.py\nestimation/slopes.py\nestimation/snapshot.py\nestimation/step_record.py\nestimation/torque_model.py\nestimation/whiteness.py\nkernels/__init__.py\nkernels/array_input.py\nkernels/callback.py\nkernels/declared.py\nkernels/elementary.py\nkernels/kernel.py\nkernels/levenberg_marquardt.py\nkernels/library.py\nkernels/linalg.py\nkernels/linear_least_squares.py\nkernels/sensor_noise.py\nkernels/translate/__init__.py\nkernels/translate/arrays.py\nkernels/translate/expressions.py\nkernels/translate/frame.py\nkernels/translate/program.py\nkernels/translate/source.py\nkernels/translate/statements.py\nkernels/translate/values.py\nkernels/types.py\nmonitoring/__init__.py\nmonitoring/alert_limits.py\nmonitoring/checks/__init__.py\nmonitoring/checks/elastic_curve.py\nmonitoring/checks/innovation.py\nmonitoring/checks/observability.py\nmonitoring/checks/outcome.py\nmonitoring/checks/row_check.py\nmonitoring/elastic_regression.py\nparameters.py\nplant/__init__.py\nplant/batch.py\nplant/drive.py\nplant/effects/__init__.py\nplant/effects/actuator.py\nplant/effects/arm_side.py\nplant/effects/balance_column.py\nplant/effects/composition.py\nplant/effects/controller.py\nplant/effects/effect.py\nplant/effects/encoder.py\nplant/effects/gearbox.py\nplant/effects/motor_side.py\nplant/effects/registry.py\nplant/effects/torque_map.py\nplant/equivalent_torque.py\nplant/excitation.py\nplant/free_runs.py\nplant/friction_law.py\nplant/origin.py\nplant/runge_kutta.py\nplant/simulate.py\nplant/transmission.py\nplant/units.py\npresentation.py\nrobot/__init__.py\nrobot/arm_load.py\nrobot/arm_plant.py\nrobot/description.py\nrobot/dynamics.py";
const char *gm_digest = "d5304d0fa9e2352b80a3817c2c2f0fbdf9d424ebcf176354228ce8083ffd21fe";
const char *gm_text = "a7e6d579b8fadbe4cd11f7645d6408445e8432491e552950fa58e45dd817fd18";
