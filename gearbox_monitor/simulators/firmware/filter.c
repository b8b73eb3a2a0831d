/* SPDX-License-Identifier: Apache-2.0
 *
 * @TITLE@
 *
 * Extended Kalman filter with the exact tangent of the RK4 step and Joseph's update. See the
 * header for units, signs and calls.
 */
#include "@HEADER@"

#include <string.h>

#define R(x) ((gm_real)(x))
enum { X1, X2, X3, X4, TAU };

/* Values of the drive that the tolerances of the model are stated for. */
typedef struct {
    gm_real inverse_m1, inverse_m2; /* 1 / inertia of motor and arm, 1/(kg m^2) */
    gm_real damping;                /* between motor and arm, N m s/rad */
    gm_real viscous, coulomb;       /* friction of the motor, N m s/rad and N m */
    gm_real load_friction;          /* of the motor, per transmitted torque */
    gm_real arm_viscous, arm_coulomb;
    gm_real sharpness, arm_sharpness; /* of the Coulomb friction, s/rad */
    gm_real gain, delay;              /* of the motor torque; delay in s */
} drive;

/*CONSTANTS*/

/* ------------------------------------------------------------------ functions of one number */

static int is_finite(gm_real x) { return x - x == R(0.0); }
static gm_real size_of(gm_real x) { return x < R(0.0) ? -x : x; }
static gm_real larger(gm_real a, gm_real b) { return a > b ? a : b; }

/* NaN: not measured. */
static gm_real absent(void)
{
    const volatile gm_real zero = R(0.0);
    return zero / zero;
}

/* Square root: a guess from the bits of a float, then Newton's method. */
static gm_real root(gm_real x)
{
    gm_real scale = R(1.0), y;
    float rough;
    uint32_t bits;
    int i;
    if (!(x > R(0.0)))
        return x < R(0.0) ? absent() : x;
    if (x < R(1e-24)) {
        x *= R(1.329227995784916e36); /* 2^120 */
        scale = R(8.673617379884035e-19);
        if (x < R(1e-24)) {
            x *= R(1.329227995784916e36);
            scale = R(7.52316384526264e-37);
        }
    } else if (x > R(1e24)) {
        x *= R(7.52316384526264e-37);
        scale = R(1.152921504606847e18);
    }
    rough = (float)x;
    memcpy(&bits, &rough, sizeof bits);
    bits = (bits >> 1) + 0x1fbd1df5u;
    memcpy(&rough, &bits, sizeof bits);
    y = (gm_real)rough;
    for (i = 0; i < 4; i++)
        y = R(0.5) * (y + x / y);
    return scale * y;
}

#if GM_TANH
/* exp(x), |x| <= 40: 2^k exp(r), |r| <= ln(2)/2. */
static gm_real exponential(gm_real x)
{
    const int32_t k = (int32_t)(x * R(1.4426950408889634) + (x < R(0.0) ? R(-0.5) : R(0.5)));
    const gm_real r = (x - R(k) * R(0.6931471803691238)) - R(k) * R(1.9082149292705877e-10);
    gm_real y = R(1.0), term = R(1.0), power = k < 0 ? R(0.5) : R(2.0);
    int32_t i;
    for (i = 1; i < 16; i++) {
        term *= r / R(i);
        y += term;
    }
    for (i = k < 0 ? -k : k; i > 0; i >>= 1) {
        if (i & 1)
            y *= power;
        power *= power;
    }
    return y;
}
#else
/* Arc tangent, reduced to |t| <= tan(pi/8); there Chebyshev's approximation. */
static gm_real arc_tangent(gm_real x)
{
    const gm_real a = size_of(x);
    gm_real over = a, under = R(1.0), offset = R(0.0), t, z, z2, z4, low, mid, high, y;
    if (a > R(0.41421356237309503)) {
        over = a - R(1.0), under = a + R(1.0), offset = R(0.7853981633974483);
        if (a > R(2.414213562373095))
            over = R(-1.0), under = a, offset = R(1.5707963267948966);
    }
    t = over / under;
    z = t * t, z2 = z * z, z4 = z2 * z2;
    low = z2 * (R(0.11111111105155447) * z - R(0.14285714285659828))
          + (R(0.19999999999999804) * z - R(0.3333333333333333));
    mid = z2 * (R(0.058789289978203436) * z - R(0.06666424885737))
          + (R(0.07692296375032072) * z - R(0.09090908753500875));
    high = z2 * (R(0.016285756841402314) * z - R(0.034570561968958594))
           + (R(0.045515932201417086) * z - R(0.052304542705439556));
    y = offset + (t * z * (z4 * (z4 * high + mid) + low) + t);
    return x < R(0.0) ? -y : y;
}
#endif

#if GM_GRAVITY
/* sin(x), |x| < 1e15; NaN beyond, where the turn is unknown. */
static gm_real sine(gm_real x)
{
    int64_t k;
    gm_real r, z, z2, low, high, y;
    if (!(size_of(x) < R(1e15)))
        return absent();
    k = (int64_t)(x * R(0.3183098861837907) + (x < R(0.0) ? R(-0.5) : R(0.5)));
    r = (x - R(k) * R(3.141592653589793)) - R(k) * R(1.2246467991473532e-16);
    z = r * r, z2 = z * z;
    low = z2 * (R(2.7557319219115013e-06) * z - R(0.00019841269841254795))
          + (R(0.008333333333333316) * z - R(0.16666666666666666));
    high = z2 * (R(2.7312868913092307e-15) * z - R(7.643957622560617e-13))
           + (R(1.6058976915095007e-10) * z - R(2.505210761086116e-08));
    y = r * z * (z2 * z2 * high + low) + r;
    return k % 2 ? -y : y;
}
#endif

/* Share of the Coulomb friction at speed times sharpness v, and its slope over v. */
static gm_real side(gm_real v)
{
#if GM_TANH
    const gm_real b = !(v > R(-20.0)) ? R(-20.0) : v > R(20.0) ? R(20.0) : v; /* never NaN */
    return R(1.0) - R(2.0) / (R(1.0) + exponential(R(2.0) * b));
#else
    return R(0.6366197723675814) * arc_tangent(v);
#endif
}

static gm_real side_slope(gm_real v)
{
#if GM_TANH
    const gm_real share = side(v);
    return R(1.0) - share * share;
#else
    return R(0.6366197723675814) / (R(1.0) + v * v);
#endif
}

/* ------------------------------------------------------------------ law of tau_K */

#if GM_CURVE >= 0
#define AT_CURVE (GM_N - GM_CURVE) /* place of the memory; then K, K b, and the hysteresis */

typedef struct {
    gm_real stiffness, offset, shift; /* K, K b and K times the width of the hysteresis */
} curve;

static curve curve_of(const gm_real *z)
{
    curve c;
#if GM_CURVE > 1
    c.stiffness = z[AT_CURVE + 1], c.offset = z[AT_CURVE + 2], c.shift = z[AT_CURVE + 3];
#else
    (void)z;
    c.stiffness = C.stiffness, c.offset = C.stiffness * C.half_gap;
    c.shift = GM_CURVE > 0 ? C.stiffness * C.width : R(0.0);
#endif
    return c;
}

#if GM_CURVE > 0
/* Move the memory of a play; returns which end carries it: 1 up, -1 down, 0 none. */
static gm_real play(gm_real twist, gm_real *memory, gm_real width)
{
    if (twist - *memory > width) {
        *memory = twist - width;
        return R(1.0);
    }
    if (*memory - twist > width) {
        *memory = twist + width;
        return R(-1.0);
    }
    return R(0.0);
}
#endif

/* Torque of the curve; bend: its slopes over twist, memory, K, K b and shift. */
static gm_real elastic(gm_real twist, gm_real memory, curve c, gm_real bend[5])
{
#if GM_CURVE == 0
    const gm_real stretched = c.stiffness * twist;
    const gm_real low = larger(stretched, -c.offset);
    const gm_real torque = stretched - (low < c.offset ? low : c.offset);
    const gm_real s = torque > R(0.0) ? R(1.0) : torque < R(0.0) ? R(-1.0) : R(0.0);
    (void)memory;
    bend[0] = c.stiffness * size_of(s), bend[1] = R(0.0), bend[2] = size_of(s) * twist;
    bend[3] = -s, bend[4] = R(0.0);
    return torque;
#else
    const gm_real width = size_of(c.shift) / c.stiffness;
    gm_real moved = memory;
    const gm_real end = play(twist, &moved, width);
    const gm_real sign = c.shift >= R(0.0) ? R(1.0) : R(-1.0);
    const gm_real open = end == R(0.0) && width != R(0.0) ? R(1.0) : R(0.0);
    const gm_real stretch = end * width + open * (twist - memory);
    const gm_real share = C.hysteresis_stiffness > R(0.0) ? R(0.0) : sign;
    const gm_real shifted = twist - share * stretch, full = c.stiffness * shifted;
    const gm_real torque = full > c.offset ? full - c.offset
                           : full < -c.offset ? full + c.offset : R(0.0);
    const gm_real s = torque > R(0.0) ? R(1.0) : torque < R(0.0) ? R(-1.0) : R(0.0);
    const gm_real slope = c.stiffness * size_of(s);
    const gm_real of_stretch = C.hysteresis_stiffness - share * slope;
    const gm_real of_width = of_stretch * end / c.stiffness;
    bend[0] = slope + of_stretch * open, bend[1] = -of_stretch * open;
    bend[2] = size_of(s) * shifted - of_width * width, bend[3] = -s, bend[4] = of_width * sign;
    return torque + C.hysteresis_stiffness * stretch;
#endif
}

static gm_real memory_of(const gm_real *z)
{
#if GM_CURVE > 0
    return z[AT_CURVE];
#else
    return z[X1] - z[X2];
#endif
}
#endif

/* ------------------------------------------------------------------ equations of the drive */

/* What the tangent needs of one stage of an RK4 step: slopes of the friction over speed and
 * torque, of the load on the arm over position and speed, and of the curve. */
typedef struct {
    gm_real slope, share;
#if GM_ARM_LOAD
    gm_real on_position, on_speed;
#endif
#if GM_CURVE >= 0
    gm_real bend[5];
#endif
} stage;

static void accelerations(const drive *d, const gm_real x[5], gm_real u, gm_real load,
                          gm_real out[2])
{
    const gm_real rate = d->damping * (x[X3] - x[X4]);
#if GM_LOAD_FRICTION
    const gm_real level = d->coulomb + d->load_friction * size_of(x[TAU]);
#else
    const gm_real level = d->coulomb;
#endif
#if GM_ARM_LOAD
    load += d->arm_viscous * x[X4] + C.constant_load;
#if GM_ARM_COULOMB
    load += d->arm_coulomb * side(d->arm_sharpness * x[X4]);
#endif
#if GM_GRAVITY
    load += C.weight * sine(x[X2] + C.weight_phase);
#endif
#endif
    out[0] = (u + C.torque_offset - rate - x[TAU] - C.position_gain * x[X1]
              - (d->viscous * x[X3] + level * side(d->sharpness * x[X3]))) * d->inverse_m1;
    out[1] = (rate + x[TAU] - load) * d->inverse_m2;
}

static void stage_of(const drive *d, const gm_real x[5], stage *s)
{
    const gm_real v = d->sharpness * x[X3];
    gm_real level = d->coulomb;
    s->share = R(1.0);
#if GM_LOAD_FRICTION
    level += d->load_friction * size_of(x[TAU]);
    if (x[TAU] != R(0.0))
        s->share += (x[TAU] > R(0.0) ? d->load_friction : -d->load_friction) * side(v);
#endif
    s->slope = d->viscous + level * d->sharpness * side_slope(v);
#if GM_ARM_LOAD
    s->on_position = R(0.0);
#if GM_GRAVITY
    s->on_position = C.weight * sine(x[X2] + C.weight_phase + R(1.5707963267948966));
#endif
    s->on_speed = d->arm_viscous
                  + d->arm_coulomb * d->arm_sharpness * side_slope(d->arm_sharpness * x[X4]);
#endif
}

#if GM_FRICTION_AT > 0
/* The error of the friction at the four stages of a step, and at its end. */
static void decay(gm_real error, gm_real h, gm_real out[5])
{
    const gm_real rate = R(-1.0) / C.friction_error_time;
    out[0] = error;
    out[1] = error + R(0.5) * h * rate * out[0];
    out[2] = error + R(0.5) * h * rate * out[1];
    out[3] = error + h * rate * out[2];
    out[4] = error + h / R(6.0) * rate * (error + R(2.0) * (out[1] + out[2]) + out[3]);
}
#endif

/* Part of a step that each stage of RK4 is at. */
static const gm_real STAGES[4] = {R(0.0), R(0.5), R(0.5), R(1.0)};

/* Advance column j of the tangent by an RK4 step. error: of the friction, by stage; load: what the
 * state adds to the load on the arm; own: its place among the slopes of the curve, or 0. */
static void column(const drive *d, const stage st[4], gm_real phi[][GM_N], int j, gm_real h,
                   const gm_real error[4], gm_real load, int own)
{
    gm_real m[4][5], r[4][2], moved1, moved2;
    int q;
    for (q = 0; q < 4; q++) {
        gm_real torque, push = load, twist_rate, on_motor;
        const gm_real a = STAGES[q] * h;
        const int b = q > 0 ? q - 1 : 0;
        m[q][X1] = phi[X1][j], m[q][X2] = phi[X2][j], m[q][X3] = phi[X3][j];
        m[q][X4] = phi[X4][j], m[q][TAU] = phi[TAU][j];
        if (q > 0) {
            m[q][X1] += a * m[b][X3], m[q][X2] += a * m[b][X4];
            m[q][X3] += a * r[b][0], m[q][X4] += a * r[b][1];
            m[q][TAU] += a * C.tau_k_stiffness * (m[b][X3] - m[b][X4]);
        }
        torque = m[q][TAU];
#if GM_CURVE >= 0
        {
            gm_real source = R(0.0);
#if GM_CURVE > 0
            source = st[q].bend[1] * phi[AT_CURVE][j];
#endif
            if (own > 1)
                source += st[q].bend[own];
            torque = st[q].bend[0] * (m[q][X1] - m[q][X2]) + (torque + source);
        }
#else
        (void)own;
#endif
#if GM_ARM_LOAD
        push += st[q].on_position * m[q][X2] + st[q].on_speed * m[q][X4];
#endif
        twist_rate = m[q][X3] - m[q][X4];
        on_motor = st[q].share * torque
                   + (st[q].slope * m[q][X3] + (C.position_gain * m[q][X1] + error[q]));
        r[q][0] = -d->inverse_m1 * (d->damping * twist_rate + on_motor);
        r[q][1] = d->inverse_m2 * (d->damping * twist_rate + (torque - push));
    }
    moved1 = h / R(6.0) * (R(2.0) * (m[1][X3] + m[2][X3]) + (m[0][X3] + m[3][X3]));
    moved2 = h / R(6.0) * (R(2.0) * (m[1][X4] + m[2][X4]) + (m[0][X4] + m[3][X4]));
    phi[X1][j] = m[0][X1] + moved1;
    phi[X2][j] = m[0][X2] + moved2;
    phi[X3][j] = h / R(6.0) * (R(2.0) * (r[1][0] + r[2][0]) + (r[0][0] + r[3][0])) + m[0][X3];
    phi[X4][j] = h / R(6.0) * (R(2.0) * (r[1][1] + r[2][1]) + (r[0][1] + r[3][1])) + m[0][X4];
    phi[TAU][j] = m[0][TAU] + C.tau_k_stiffness * (moved1 - moved2);
}

/* Advance the state z by an RK4 step of h s, and the tangent phi with it, unless it is NULL. */
static void rk4(const drive *d, gm_real *z, gm_real (*phi)[GM_N], gm_real u, gm_real load,
                gm_real h)
{
    static const gm_real none[4] = {R(0.0), R(0.0), R(0.0), R(0.0)};
    gm_real x[4][5], f[4][2], moved1, moved2;
    stage st[4];
    int q, j;
#if GM_FRICTION_AT > 0
    gm_real error[5];
#endif
#if GM_CURVE >= 0
    const curve law = curve_of(z);
    gm_real memory = memory_of(z);
#endif
#if GM_LOAD_AT > 0
    load += z[GM_LOAD_AT];
#endif
#if GM_FRICTION_AT > 0
    decay(z[GM_FRICTION_AT], h, error);
    z[GM_FRICTION_AT] = error[4];
#endif
    for (q = 0; q < 4; q++) {
        const gm_real a = STAGES[q] * h;
        const int b = q > 0 ? q - 1 : 0;
        gm_real y[5];
        for (j = 0; j < 5; j++)
            x[q][j] = z[j];
        if (q > 0) {
            x[q][X1] += a * x[b][X3], x[q][X2] += a * x[b][X4];
            x[q][X3] += a * f[b][0], x[q][X4] += a * f[b][1];
            x[q][TAU] += a * C.tau_k_stiffness * (x[b][X3] - x[b][X4]);
        }
        memcpy(y, x[q], sizeof y);
#if GM_CURVE >= 0
        {
            gm_real bend[5];
            y[TAU] += elastic(y[X1] - y[X2], memory, law, bend);
            memcpy(st[q].bend, bend, sizeof bend);
        }
#endif
        if (phi != NULL)
            stage_of(d, y, &st[q]);
#if GM_FRICTION_AT > 0
        accelerations(d, y, u - error[q], load, f[q]);
#else
        accelerations(d, y, u, load, f[q]);
#endif
    }
    moved1 = h / R(6.0) * (x[0][X3] + R(2.0) * (x[1][X3] + x[2][X3]) + x[3][X3]);
    moved2 = h / R(6.0) * (x[0][X4] + R(2.0) * (x[1][X4] + x[2][X4]) + x[3][X4]);
    z[X1] += moved1, z[X2] += moved2;
    z[X3] += h / R(6.0) * (f[0][0] + R(2.0) * (f[1][0] + f[2][0]) + f[3][0]);
    z[X4] += h / R(6.0) * (f[0][1] + R(2.0) * (f[1][1] + f[2][1]) + f[3][1]);
    z[TAU] += C.tau_k_stiffness * (moved1 - moved2);
    if (phi != NULL) {
        for (j = 0; j < 5; j++)
            if (j != X2 || GM_ARM_LOAD || GM_CURVE >= 0)
                column(d, st, phi, j, h, none, R(0.0), 0);
#if GM_LOAD_AT > 0
        column(d, st, phi, GM_LOAD_AT, h, none, R(1.0), 0);
#endif
#if GM_FRICTION_AT > 0
        decay(phi[GM_FRICTION_AT][GM_FRICTION_AT], h, error);
        column(d, st, phi, GM_FRICTION_AT, h, error, R(0.0), 0);
        phi[GM_FRICTION_AT][GM_FRICTION_AT] = error[4];
#endif
#if GM_CURVE > 0
        for (j = 0; j < GM_CURVE; j++)
            column(d, st, phi, AT_CURVE + j, h, none, R(0.0), j > 0 ? j + 1 : 0);
#endif
    }
#if GM_CURVE > 0
    {
        const gm_real width = size_of(law.shift) / law.stiffness;
        const gm_real end = play(z[X1] - z[X2], &memory, width);
        z[AT_CURVE] = memory;
        if (phi != NULL && end != R(0.0)) {
            for (j = 0; j < GM_N; j++)
                phi[AT_CURVE][j] = phi[X1][j] - phi[X2][j];
#if GM_CURVE > 1
            phi[AT_CURVE][AT_CURVE + 1] += end * width / law.stiffness;
            phi[AT_CURVE][AT_CURVE + 3] -= (law.shift >= R(0.0) ? end : -end) / law.stiffness;
#endif
        }
    }
#endif
}

/* Number of RK4 steps that a step of dt s takes. */
static int substeps(gm_real dt)
{
    const gm_real n = dt * C.eigenvalue / R(2.7);
    int whole;
    if (!(n < R(GM_MAX_SUBSTEPS)))
        return GM_MAX_SUBSTEPS;
    whole = (int)n;
    if (R(whole) < n)
        whole++;
    return whole > 1 ? whole : 1;
}

/* ------------------------------------------------------------------ filter */

static gm_real noise(const gm_real *z, int i)
{
    return i == TAU ? C.Q[TAU] + C.q_tau_k_speed * z[X3] * z[X3] : C.Q[i];
}

#if GM_STATISTICAL
static gm_real softened(gm_real sharpness, gm_real variance)
{
    return R(1.0) / root(R(1.0) / (sharpness * sharpness) + variance / R(1.5707963267948966));
}
#endif

/* Predict z, and write the predicted covariance to `prior`. */
static void predict(gm_real *z, const gm_real *P, gm_real u, gm_real load, gm_real dt,
                    gm_real prior[][GM_N])
{
    gm_real phi[GM_N][GM_N], half[GM_N], row[GM_N];
    const int count = substeps(dt);
    drive d = DRIVES[0];
    int i, j, k;
    for (i = 0; i < GM_N; i++) {
        half[i] = R(0.5) * dt * noise(z, i);
        for (j = 0; j < GM_N; j++)
            phi[i][j] = i == j ? R(1.0) : R(0.0);
    }
#if GM_STATISTICAL
    d.sharpness = softened(d.sharpness, P[X3 * GM_N + X3]);
    d.arm_sharpness = softened(d.arm_sharpness, P[X4 * GM_N + X4]);
#endif
    for (i = 0; i < count; i++)
        rk4(&d, z, phi, u, load, dt / R(count));
    for (i = 0; i < GM_N; i++) {
        for (j = 0; j < GM_N; j++)
            row[j] = R(0.0);
        for (k = 0; k < GM_N; k++)
            if (phi[i][k] != R(0.0))
                for (j = 0; j < GM_N; j++)
                    row[j] += phi[i][k] * P[k * GM_N + j];
        for (j = 0; j < GM_N; j++)
            row[j] += phi[i][j] * half[j];
        for (j = 0; j <= i; j++) {
            gm_real sum = R(0.0);
            for (k = 0; k < GM_N; k++)
                sum += row[k] * phi[j][k];
            prior[i][j] = prior[j][i] = sum;
        }
    }
    for (i = 0; i < GM_N; i++)
        prior[i][i] += R(0.5) * dt * noise(z, i);
}

/* Innovation e, its covariance S = (s11, s12, s22), and the inverse of S over what is measured. */
typedef struct {
    gm_real e[2], S[3], inverse[3], nis;
    int have[2], good;
} correction;

static correction innovation_of(const gm_real *z, gm_real prior[][GM_N], gm_real y1, gm_real y2)
{
    correction c;
    gm_real determinant = R(1.0);
    c.have[0] = is_finite(y1), c.have[1] = is_finite(y2);
    c.e[0] = y1 - z[X1], c.e[1] = y2 - z[X2];
    c.S[0] = prior[0][0] + C.r_motor, c.S[1] = prior[0][1], c.S[2] = prior[1][1] + C.r_arm;
    c.inverse[0] = c.inverse[1] = c.inverse[2] = R(0.0);
    if (c.have[0] && c.have[1]) {
        gm_real scale;
        determinant = c.S[0] * c.S[2] - c.S[1] * c.S[1];
        scale = R(1.0) / determinant;
        c.inverse[0] = c.S[2] * scale, c.inverse[1] = -c.S[1] * scale;
        c.inverse[2] = c.S[0] * scale;
    } else if (c.have[0]) {
        determinant = c.S[0];
        c.inverse[0] = R(1.0) / determinant;
    } else if (c.have[1]) {
        determinant = c.S[2];
        c.inverse[2] = R(1.0) / determinant;
    }
    {
        const gm_real e1 = c.have[0] ? c.e[0] : R(0.0), e2 = c.have[1] ? c.e[1] : R(0.0);
        c.nis = e1 * (c.inverse[0] * e1 + c.inverse[1] * e2)
                + e2 * (c.inverse[1] * e1 + c.inverse[2] * e2);
    }
    c.good = determinant > R(0.0) && is_finite(c.nis);
    return c;
}

/* Joseph's update: (I - K H) P (I - K H)' + K R K'. */
static void update(gm_real *z, gm_real *P, gm_real prior[][GM_N], const correction *c,
                   gm_real K[][2])
{
    const gm_real e1 = c->have[0] ? c->e[0] : R(0.0), e2 = c->have[1] ? c->e[1] : R(0.0);
    int i, j;
    for (i = 0; i < GM_N; i++) {
        const gm_real c1 = prior[i][0], c2 = prior[i][1];
        const gm_real k1 = c1 * c->inverse[0] + c2 * c->inverse[1];
        const gm_real k2 = c1 * c->inverse[1] + c2 * c->inverse[2];
        const gm_real a = (i == 0 ? R(1.0) : R(0.0)) - k1, b = (i == 1 ? R(1.0) : R(0.0)) - k2;
        const gm_real t1 = (i > 1 ? c1 : R(0.0)) + a * prior[0][0] + b * prior[0][1];
        const gm_real t2 = (i > 1 ? c2 : R(0.0)) + a * prior[0][1] + b * prior[1][1];
        const gm_real w1 = k1 * C.r_motor - t1, w2 = k2 * C.r_arm - t2;
        K[i][0] = k1, K[i][1] = k2;
        z[i] += k1 * e1 + k2 * e2;
        for (j = 0; j <= i; j++) {
            const gm_real value = b * prior[1][j] + (a * prior[0][j]
                                                     + (i > 1 ? prior[i][j] : R(0.0)));
            P[i * GM_N + j] = P[j * GM_N + i] = w2 * K[j][1] + (w1 * K[j][0] + value);
        }
    }
}

static int healthy(const gm_real *z, const gm_real *P)
{
    int i;
    for (i = 0; i < GM_N; i++)
        if (!(is_finite(z[i]) && P[i * GM_N + i] > R(0.0) && is_finite(P[i * GM_N + i])))
            return 0;
    return 1;
}

#if GM_COMPANIONS > 0
/* Sensitivities to the tolerances: the same step in drives whose values are off. */
static int accompany(gm_filter *f, const gm_real *before, gm_real u, gm_real load, gm_real dt,
                     gm_real K[][2])
{
    const gm_real rate = is_finite(f->last_torque) ? (u - f->last_torque) / dt : R(0.0);
    const int count = substeps(dt);
    gm_real own[GM_N], other[GM_N];
    int i, j, good = 1;
    f->last_torque = u;
    for (i = 0; i <= GM_COMPANIONS; i++) {
        const drive *d = &DRIVES[i];
        gm_real *z = i == 0 ? own : other, e1, e2;
        for (j = 0; j < GM_N; j++)
            z[j] = i == 0 ? before[j] : before[j] + f->s[i - 1][j];
        for (j = 0; j < count; j++)
            rk4(d, z, NULL, d->gain * u - d->delay * rate, load, dt / R(count));
        if (i == 0)
            continue;
        e1 = other[X1] - own[X1], e2 = other[X2] - own[X2];
        for (j = 0; j < GM_N; j++) {
            f->s[i - 1][j] = other[j] - own[j] - (K[j][0] * e1 + K[j][1] * e2);
            good = good && is_finite(f->s[i - 1][j]);
        }
    }
    return good;
}
#endif

/* ------------------------------------------------------------------ trust */

/* High bound of the mean NIS per degree of freedom, and low with sign -1: quantiles of chi-square
 * at the significance of 1e-6, two-sided (Wilson and Hilferty). */
static gm_real nis_limit(gm_real dof, gm_real sign)
{
    const gm_real a = R(2.0) / (R(9.0) * dof);
    const gm_real b = R(1.0) - a + sign * R(4.891638475698590) * root(a);
    return b * b * b;
}

static void judge(gm_filter *f, int64_t stamp)
{
    const gm_errors *a = &f->errors[0], *b = &f->errors[1];
    const gm_real dof = a->dof + b->dof;
    unsigned flags = 0;
    int c;
    if (stamp - f->started < INT64_C(3000000000)) {
        flags = GM_SETTLING;
    } else if (a->samples + b->samples < 100 || dof < R(100.0)) {
        flags = GM_TOO_FEW;
    } else {
        const gm_real ratio = (a->nis + b->nis) / dof;
        const gm_real high = nis_limit(dof, R(1.0)), low = nis_limit(dof, R(-1.0));
        for (c = 0; c < 2; c++) {
            const int32_t count = a->count[c] + b->count[c];
            if (a->mean_count[c] >= 20 && size_of(a->mean[c]) / root(R(a->mean_count[c]))
                                          > R(5.026312836033185))
                flags |= GM_BIASED;
            if (count >= 100) {
                const gm_real v = (a->square[c] + b->square[c]) / R(count);
                if (!(R(0.7) <= v && v <= R(1.4)))
                    flags |= c == 0 ? GM_MOTOR_VARIANCE : GM_ARM_VARIANCE;
            }
        }
        if (!(ratio <= R(2.0)))
            flags |= GM_GROSS;
        else if (ratio > larger(high, R(1.25)))
            flags |= GM_LARGER;
        if (ratio < (low < R(0.75) ? low : R(0.75)))
            flags |= GM_SMALLER;
        if (a->largest > R(5.0))
            flags |= GM_OUTLIERS;
    }
    f->flags = flags;
    f->errors[1] = f->errors[0];
    memset(&f->errors[0], 0, sizeof f->errors[0]);
}

/* Judge with the first sample of each second; before that, take up the errors of this one. */
static void watch(gm_filter *f, int64_t stamp, const correction *c)
{
    const int64_t second = INT64_C(1000000000);
    if (c != NULL && stamp - f->started >= 2 * second) {
        gm_errors *a = &f->errors[0];
        gm_real white[2];
        int i;
        const gm_real root1 = root(c->S[0]);
        white[0] = c->e[0] / root1;
        white[1] = c->have[0] && c->have[1]
                   ? (c->e[1] - c->S[1] / root1 * white[0])
                     / root((c->S[0] * c->S[2] - c->S[1] * c->S[1]) / c->S[0])
                   : c->e[1] / root(c->S[2]);
        a->samples++;
        a->nis += c->nis, a->dof += R(c->have[0] + c->have[1]);
        for (i = 0; i < 2; i++)
            if (c->have[i]) {
                const gm_real ratio = c->e[i] / root(c->S[2 * i]);
                a->count[i]++;
                a->square[i] += ratio * ratio;
                a->largest = larger(a->largest, size_of(ratio));
                if (stamp > f->due - second / 2) {
                    a->mean_count[i]++;
                    a->mean[i] += white[i];
                }
            }
    }
    if (f->due != 0 && f->due - second <= stamp && stamp < f->due)
        return;
    if (f->due != 0 && stamp >= f->due)
        judge(f, stamp);
    f->due = stamp + second - (f->due != 0 ? stamp % second : 0);
}

static void doubt(gm_filter *f, int64_t stamp)
{
    f->started = stamp;
    f->flags = GM_SETTLING;
    memset(f->errors, 0, sizeof f->errors);
}

/* ------------------------------------------------------------------ samples */

void gm_init(gm_filter *f)
{
    memset(f, 0, sizeof *f);
    f->flags = GM_SETTLING;
}

/* What to do with a sample by its stamp. */
static int gate(gm_filter *f, int64_t stamp)
{
    int64_t elapsed, beyond;
    if (stamp <= 0)
        return GM_ZERO_STAMP;
    if (f->last == 0)
        return GM_START;
    elapsed = stamp - f->last;
    if (elapsed == 0)
        return GM_DUPLICATE;
    if (elapsed > 0 && elapsed <= GM_MAX_GAP) {
        f->pending = 0;
        return GM_ESTIMATE;
    }
    beyond = stamp - f->pending_stamp;
    f->pending = f->pending > 0 && beyond > 0 && beyond <= GM_MAX_GAP ? f->pending + 1 : 1;
    f->pending_stamp = stamp;
    if (f->pending >= (elapsed > INT64_C(-250000000) && elapsed < 0 ? 25 : 3))
        return GM_START;
    return elapsed < 0 ? GM_BACKWARD : GM_JUMP;
}

static void start(gm_filter *f, int64_t stamp, const gm_sample *in)
{
    const int have1 = is_finite(in->motor), have2 = is_finite(in->arm);
    gm_real *z = f->z;
    int i;
    f->last = stamp, f->step = 0, f->pending = 0, f->jumps = 0;
    f->period = f->usual[0] = f->usual[1] = R(0.0);
    doubt(f, stamp);
    for (i = 0; i < GM_DELAY + 2; i++)
        f->efforts[i][0] = in->torque, f->efforts[i][1] = GM_LOAD_MEASURED ? in->load : R(0.0);
    memset(f->P, 0, sizeof f->P);
    for (i = 0; i < GM_N; i++)
        z[i] = R(0.0), f->P[i * GM_N + i] = C.P0[i];
    z[X1] = have1 ? in->motor : in->arm;
    z[X2] = have2 ? in->arm : in->motor;
    if (!have1)
        f->P[X1 * GM_N + X1] = R(100.0);
    if (!have2)
        f->P[X2 * GM_N + X2] = R(100.0);
#if GM_CURVE > 0
    z[AT_CURVE] = z[X1] - z[X2];
#endif
#if GM_CURVE > 1
    z[AT_CURVE + 1] = C.stiffness;
    z[AT_CURVE + 2] = C.stiffness * C.half_gap, z[AT_CURVE + 3] = C.stiffness * C.width;
#endif
#if GM_COMPANIONS > 0
    memset(f->s, 0, sizeof f->s);
    f->last_torque = absent();
#endif
}

static gm_real first_speed(gm_real moved, gm_real dt, gm_real variance, gm_real prior)
{
    if (!is_finite(moved))
        return R(0.0);
    return prior / (prior + variance / (dt * dt)) * moved / dt;
}

static int position_jumps(gm_real error, gm_real variance, gm_real usual, gm_real r, int32_t step)
{
    const gm_real limit = larger(R(10.0) * larger(usual, R(2.0) * root(r)),
                                 R(6.0) * root(variance));
    return size_of(error) > (step > 100 ? limit : R(10.0) * limit);
}

static gm_real usually(gm_real error, gm_real usual)
{
    const gm_real size = size_of(error);
    if (!is_finite(size))
        return usual;
    if (usual == R(0.0))
        return size;
    return size > usual ? usual + R(0.25) * (size - usual) : R(0.999) * usual;
}

static void write_output(const gm_filter *f, const correction *c, gm_real u, gm_output *out)
{
    const gm_real *z = f->z, *P = f->P;
    gm_real variance = P[TAU * GM_N + TAU], tau = z[TAU];
    gm_real of_twist = C.encoder_delay_std * z[X4] * (C.encoder_delay_std * z[X4]);
    gm_real of_rate = R(0.0), of_torque = R(0.0);
    int i;
#if GM_CURVE >= 0
    gm_real bend[5];
    tau += elastic(z[X1] - z[X2], memory_of(z), curve_of(z), bend);
    variance += bend[0] * bend[0] * (P[0] + P[GM_N + 1] - R(2.0) * P[1])
                + R(2.0) * bend[0] * (P[TAU] - P[GM_N + TAU]);
#if GM_CURVE > 0
    for (i = 0; i < GM_CURVE; i++) {
        const gm_real *row = P + (AT_CURVE + i) * GM_N;
        gm_real on_others = row[TAU] + bend[0] * (row[X1] - row[X2]);
        int j;
        for (j = 0; j < i; j++)
            on_others += bend[1 + j] * row[AT_CURVE + j];
        variance += bend[1 + i] * (R(2.0) * on_others + bend[1 + i] * row[AT_CURVE + i]);
    }
#endif
    variance = larger(variance, R(0.0));
#endif
#if GM_COMPANIONS > 0
    for (i = 0; i < GM_COMPANIONS; i++) {
        const gm_real *s = f->s[i];
        const gm_real twist = s[X1] - s[X2], rate = s[X3] - s[X4];
        gm_real torque = s[TAU];
#if GM_CURVE >= 0
        torque += bend[0] * twist;
#endif
#if GM_CURVE > 0
        {
            int j;
            for (j = 0; j < GM_CURVE; j++)
                torque += bend[1 + j] * s[AT_CURVE + j];
        }
#endif
        of_twist += twist * twist, of_rate += rate * rate, of_torque += torque * torque;
    }
#endif
    out->tau_k = tau;
    out->tau_k_noise_std = root(variance);
    out->tau_k_std = root(variance + of_torque + C.tau_k_model_std * C.tau_k_model_std);
    out->motor_side = tau;
#if GM_FRICTION_AT > 0
    out->motor_side += z[GM_FRICTION_AT];
#endif
    out->twist = z[X1] - z[X2], out->twist_rate = z[X3] - z[X4];
    out->twist_std = root(larger(P[0] + P[GM_N + 1] - R(2.0) * P[1], R(0.0)) + of_twist);
    variance = larger(P[X3 * GM_N + X3] + P[X4 * GM_N + X4] - R(2.0) * P[X3 * GM_N + X4], R(0.0));
    out->twist_rate_noise_std = root(variance);
    out->twist_rate_std = root(variance + of_rate);
    out->motor_speed = z[X3], out->torque = u;
    out->nis = c->nis, out->dof = c->have[0] + c->have[1];
    for (i = 0; i < 2; i++) {
        out->innovation[i] = c->e[i], out->innovation_std[i] = root(c->S[2 * i]);
        if (c->have[i] && size_of(c->e[i]) > R(5.0) * out->innovation_std[i])
            out->flags |= GM_BEYOND_GATE;
    }
}

/* Take a sample that continues the last one. */
static int estimate(gm_filter *f, int64_t stamp, const gm_sample *in, gm_output *out)
{
    const int64_t last = f->last;
    const gm_real dt = R(stamp - last) * R(1e-9);
    const int32_t step = f->step + 1, rows = GM_DELAY + 2;
    const int32_t place = step % rows, previous = (step - 1) % rows;
    const int32_t acting = (step + 1) % rows; /* the oldest: GM_DELAY + 1 steps ago */
    gm_real z[GM_N], prior[GM_N][GM_N], K[GM_N][2], u, load;
    correction c;
    int64_t bridged;
    int good;
    f->efforts[place][0] = is_finite(in->torque) ? in->torque : f->efforts[previous][0];
    f->efforts[place][1] = is_finite(in->load) ? in->load : f->efforts[previous][1];
    u = f->efforts[acting][0];
    load = GM_LOAD_MEASURED ? f->efforts[acting][1] : R(0.0);
    memcpy(z, f->z, sizeof z);
    if (step == 1) {
        z[X3] = first_speed(in->motor - z[X1], dt, f->P[0] + C.r_motor, f->P[X3 * GM_N + X3]);
        z[X4] = first_speed(in->arm - z[X2], dt, f->P[GM_N + 1] + C.r_arm,
                            f->P[X4 * GM_N + X4]);
    }
    predict(z, f->P, u, load, dt, prior);
    c = innovation_of(z, prior, in->motor, in->arm);
    if (position_jumps(c.e[0], c.S[0], f->usual[0], C.r_motor, step)
        || position_jumps(c.e[1], c.S[2], f->usual[1], C.r_arm, step)) {
        if (++f->jumps >= 3)
            f->last = 0, f->pending = 0; /* the next complete sample starts anew */
        return GM_POSITION_JUMP;
    }
    f->last = stamp, f->step = step, f->jumps = 0;
    if (f->step > INT32_C(2000000000))
        f->step -= (INT32_C(1000000000) / rows) * rows;
    if (f->period == R(0.0))
        f->period = dt;
    else
        f->period *= dt > f->period ? R(1.02) : R(1.0 / 1.02);
    bridged = last < f->last_effort ? last : f->last_effort;
    bridged = stamp - (f->last_measurement < bridged ? f->last_measurement : bridged);
    if (bridged > INT64_C(30000000) && R(bridged) > R(2.5e9) * f->period)
        doubt(f, stamp);
    good = c.good;
    if (good) {
        update(z, f->P, prior, &c, K);
#if GM_CURVE > 1
        {
            gm_real *k = z + AT_CURVE + 1;
            k[0] = larger(k[0], C.stiffness / R(10.0));
            k[0] = k[0] < C.stiffness * R(10.0) ? k[0] : C.stiffness * R(10.0);
            k[1] = larger(k[1], R(0.0));
            if (C.hysteresis_stiffness > R(0.0))
                k[2] = larger(k[2], R(0.0));
        }
#endif
        good = healthy(z, f->P);
    }
#if GM_COMPANIONS > 0
    good = good && accompany(f, f->z, u, load, dt, K);
#endif
    memcpy(f->z, z, sizeof z);
    if (!good) {
        f->last = 0;
        return GM_DIVERGED;
    }
    f->usual[0] = usually(c.e[0], f->usual[0]);
    f->usual[1] = usually(c.e[1], f->usual[1]);
    watch(f, stamp, &c);
    out->flags = f->flags;
    write_output(f, &c, u, out);
    return GM_ESTIMATE;
}

int gm_step(gm_filter *f, int64_t stamp, const gm_sample *in, gm_output *out)
{
    gm_sample s = *in;
    int code, have_u = 0, have_y;
    gm_real *const values[4] = {&s.torque, &s.load, &s.motor, &s.arm};
    int i;
    for (i = 0; i < 4; i++)
        if (size_of(*values[i]) > R(1e9))
            *values[i] = absent(); /* no drive has it */
    have_y = is_finite(s.motor) || is_finite(s.arm);
    code = gate(f, stamp);
    out->flags = f->flags;
    if (code == GM_ESTIMATE || code == GM_START) {
        if (code == GM_START)
            f->last_measurement = f->last_effort = stamp;
        have_u = is_finite(s.torque) && (!GM_LOAD_MEASURED || is_finite(s.load));
        if (!have_u) {
            if (code == GM_START || stamp - f->last_effort > GM_MAX_GAP)
                code = GM_NO_EFFORT;
        } else if (!have_y && (code == GM_START || stamp - f->last_measurement > GM_MAX_GAP)) {
            code = GM_NO_MEASUREMENT;
        }
        if (code == GM_NO_EFFORT || code == GM_NO_MEASUREMENT) {
            f->last = 0, f->pending = 0; /* the next complete sample starts anew */
            watch(f, stamp, NULL);
        }
    }
    if (code != GM_ESTIMATE && code != GM_START)
        return code;
    if (have_u)
        f->last_effort = stamp;
    if (have_y)
        f->last_measurement = stamp;
    if (code == GM_START) {
        start(f, stamp, &s);
        watch(f, stamp, NULL);
        out->flags = f->flags;
        return code;
    }
    code = estimate(f, stamp, &s, out);
    out->flags |= f->flags;
    return code;
}

/* ------------------------------------------------------------------ backlash window */

#if GM_ARM_MEASURED
void gm_window_begin(gm_window *w, const gm_real *theta, int32_t group)
{
    memset(w, 0, sizeof *w);
    w->group = group > 0 ? group : 1;
    if (theta != NULL) {
        memcpy(w->theta, theta, sizeof w->theta);
    } else {
        w->theta[GM_STIFFNESS] = C.stiffness;
        w->theta[GM_HALF_GAP] = C.half_gap;
    }
}

static void close_group(gm_window *w)
{
    const gm_real inverse = R(0.5) / R(w->group), weight = w->weight / R(w->group);
    const gm_real mean = inverse * (w->error + w->error_last);
    gm_real pair[GM_SHAPE];
    int p, q;
    if (w->tracked) {
        for (p = 0; p < GM_SHAPE; p++) {
            pair[p] = inverse * (w->slope[p] + w->last[p]);
            w->last[p] = w->slope[p];
        }
        w->error_last = w->error;
        if (w->paired) {
            w->groups++;
            w->cost += weight * mean * mean;
            for (p = 0; p < GM_SHAPE; p++) {
                const gm_real part = weight * pair[p];
                w->right[p] += part * mean;
                for (q = 0; q <= p; q++)
                    w->normal[p][q] += part * pair[q];
            }
        }
        w->paired = 1;
    }
    memset(w->slope, 0, sizeof w->slope);
    w->error = w->weight = R(0.0);
    w->count = 0;
}

void gm_window_add(gm_window *w, const gm_output *out)
{
    const gm_real *t = w->theta;
    const gm_real z = out->twist - t[GM_ZERO], r = size_of(t[GM_WIDTH]);
    const gm_real friction = side(C.side_sharpness * out->motor_speed);
    gm_real y, in_contact = R(0.0), load = R(0.0), weight = R(1.0);
    if (!w->begun)
        w->w = z, w->begun = 1;
    if (z - w->w > r)
        w->w = z - r, w->w_r = R(-1.0), w->tracked = 1;
    else if (w->w - z > r)
        w->w = z + r, w->w_r = R(1.0), w->tracked = 1;
    y = t[GM_WIDTH] >= R(0.0) ? w->w : R(2.0) * z - w->w; /* falls with the zero as z does */
    if (y > t[GM_HALF_GAP])
        in_contact = R(1.0), load = y - t[GM_HALF_GAP];
    else if (y < -t[GM_HALF_GAP])
        in_contact = R(-1.0), load = y + t[GM_HALF_GAP];
    w->slope[GM_STIFFNESS] += load;
    w->slope[GM_HALF_GAP] -= t[GM_STIFFNESS] * in_contact;
    if (in_contact != R(0.0)) {
        w->slope[GM_WIDTH] += t[GM_STIFFNESS] * w->w_r;
        w->slope[GM_ZERO] -= t[GM_STIFFNESS];
    }
    w->slope[GM_VISCOUS] += out->motor_speed;
    w->slope[GM_COULOMB] += friction;
    w->slope[GM_GAIN] -= out->torque;
    w->error += out->motor_side
                - (t[GM_STIFFNESS] * load + t[GM_VISCOUS] * out->motor_speed
                   + t[GM_COULOMB] * friction - t[GM_GAIN] * out->torque);
    /* Friction is uncertain where the speed is not known to be other than 0. */
    if (C.coulomb_friction != R(0.0) && out->twist_rate_noise_std > R(0.0)) {
        const gm_real ratio = out->motor_speed / (R(3.0) * out->twist_rate_noise_std);
        weight = R(0.01) + ratio * ratio / (R(1.0) + ratio * ratio);
    }
    w->weight += weight;
    if (++w->count == w->group)
        close_group(w);
}
#endif
