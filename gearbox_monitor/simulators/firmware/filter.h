/* SPDX-License-Identifier: Apache-2.0
 *
 * @TITLE@
 *
 * Torque tau_K and twist of a gearbox from motor torque and encoders: the kernels of the node in
 * C99, no heap, no library, no static variables. Each gm_filter is independent of the others:
 *
 *     gm_filter filter;                          once
 *     gm_init(&filter);                          once, and to begin anew
 *     gm_sample in = {torque, load, motor, arm}; once per control period
 *     if (gm_step(&filter, stamp, &in, &out) == GM_ESTIMATE)
 *         use(out.tau_k, out.tau_k_std, out.flags);
 *
 * Quantities are in SI units on the arm side: torque N m = effort times GM_EFFORT_SCALE, motor
 * position rad = angle of the motor over GM_GEAR_RATIO. Positive torque accelerates the motor
 * towards positive angles; positive tau_K accelerates the arm; twist = motor - arm.
 *
 * Estimates are those of the node bit for bit (of an Estimator without smoother), if the compiler
 * neither contracts nor reorders: -ffp-contract=off, no -ffast-math, with which NaN, a value that
 * was not measured, fails. -DGM_FLOAT, in every file, computes in single precision.
 */
#ifndef GM_FILTER_H
#define GM_FILTER_H

#include <stdbool.h>
#include <stdint.h>

#if defined(GM_FLOAT)
typedef float gm_real;
#else
typedef double gm_real;
#endif

/*CONFIG*/

/* What became of a sample: what gm_step returns. Estimates come with GM_ESTIMATE only. */
enum {
    GM_ESTIMATE = 0,
    GM_START = 1,          /* first sample: the filter starts from it */
    GM_ZERO_STAMP = 2,     /* stamp <= 0: refused */
    GM_DUPLICATE = 3,      /* stamp of the sample before: refused */
    GM_BACKWARD = 4,       /* stamp before the last one: refused */
    GM_JUMP = 5,           /* too long after the last one: refused; the third starts anew */
    GM_NO_EFFORT = 6,      /* torque missing for too long: the next complete sample starts anew */
    GM_NO_MEASUREMENT = 7, /* the same, both positions missing */
    GM_DIVERGED = 8,       /* not finite: the next complete sample starts anew */
    GM_POSITION_JUMP = 9   /* implausible position: refused; the third starts anew */
};

/* Bits of gm_output.flags: the prediction errors as the node judges them. Those of a window are
 * judged once per second, over the last 2 s, and stay until the next judgement, not debounced. */
enum {
    GM_SETTLING = 1,       /* less than 3 s since a start or a dropout: nothing is judged */
    GM_BEYOND_GATE = 2,    /* this innovation exceeds 5 predicted standard deviations */
    GM_BIASED = 4,         /* prediction errors biased, over the last 0.5 s */
    GM_LARGER = 8,         /* ... larger than predicted */
    GM_SMALLER = 16,       /* ... smaller than predicted */
    GM_GROSS = 32,         /* ... much larger: do not use tau_K */
    GM_MOTOR_VARIANCE = 64, /* noise of the motor encoder differs from r_std_motor */
    GM_ARM_VARIANCE = 128, /* noise of the arm encoder differs from r_std_arm */
    GM_OUTLIERS = 256,     /* an innovation of the last second exceeded the gate */
    GM_TOO_FEW = 512       /* too few samples to judge by */
};

/* One sample; NaN = not measured. */
typedef struct {
    gm_real torque; /* of the motor, N m */
    gm_real load;   /* on the arm, N m; read only if GM_LOAD_MEASURED */
    gm_real motor;  /* position, rad */
    gm_real arm;    /* position, rad */
} gm_sample;

/* An estimate, as the columns of gearbox_monitor.Estimates: torques N m, angles rad, speeds rad/s,
 * times s. NaN: no such state. */
typedef struct {
/*OUTPUT*/
    uint32_t flags;
} gm_output;

/* The state of one filter. Its members are not part of the interface. */
typedef struct {
/*STATE*/
} gm_filter;

/* Begin: call it once, and to begin anew. */
void gm_init(gm_filter *f);

/* Take one sample, in order, once per control period: the positions, and the torque that acts from
 * the stamp on, GM_DELAY samples later. stamp: ns, from 1 to 2^62, of a clock that never stands
 * still, e.g. the number of the period times its length. Periods may vary; a longer one costs more
 * RK4 steps. Returns one of the codes above; writes `out` for GM_ESTIMATE, else its flags only. */
int gm_step(gm_filter *f, int64_t stamp, const gm_sample *in, gm_output *out);
/*WINDOW*/
#endif
