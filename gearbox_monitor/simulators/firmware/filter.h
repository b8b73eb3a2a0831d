/* SPDX-License-Identifier: Apache-2.0
 *
 * @TITLE@
 *
 * Torque tau_K and twist of a gearbox from motor torque and encoders: C99, no heap, no libm, no
 * static variables. Each gm_filter is independent of the others. All quantities are in SI units on
 * the arm side: torque N m = effort times GM_EFFORT_SCALE, motor position rad = that of the arm
 * when the gearbox is not twisted. Positive torque accelerates the motor towards positive angles;
 * positive tau_K accelerates the arm; twist = motor - arm.
 *
 * Do not compile with -ffast-math: a value that was not measured is NaN.
 */
#ifndef GM_FILTER_H
#define GM_FILTER_H

#include <stdint.h>

#ifndef GM_REAL
#define GM_REAL double /* or -DGM_REAL=float, in every file that includes this one */
#endif
typedef GM_REAL gm_real;

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

/* Bits of gm_output.flags. Those of a window are judged once per second, over the last 2 s, and
 * stand until the next judgement; they are not debounced. */
enum {
    GM_SETTLING = 1,          /* less than 3 s since a start or a dropout: nothing is judged */
    GM_BEYOND_GATE = 2,       /* this innovation exceeds 5 predicted standard deviations */
    GM_BIASED = 4,            /* prediction errors biased, over the last 0.5 s */
    GM_LARGER = 8,            /* ... larger than predicted */
    GM_SMALLER = 16,          /* ... smaller than predicted */
    GM_GROSS = 32,            /* ... much larger: do not use tau_K */
    GM_MOTOR_VARIANCE = 64,   /* noise of the motor encoder differs from r_std_motor */
    GM_ARM_VARIANCE = 128,    /* noise of the arm encoder differs from r_std_arm */
    GM_OUTLIERS = 256,        /* an innovation of the last second exceeded the gate */
    GM_TOO_FEW = 512          /* too few samples to judge by */
};

/* One sample; NaN = not measured. */
typedef struct {
    gm_real torque; /* of the motor, N m */
    gm_real load;   /* on the arm, N m; read only if GM_LOAD_MEASURED */
    gm_real motor;  /* position, rad */
    gm_real arm;    /* position, rad */
} gm_sample;

typedef struct {
    gm_real tau_k, tau_k_std;             /* N m; with what the tolerances of the model add, and as
                                             the node states it with narrow_std: false */
    gm_real tau_k_noise_std;              /* N m, by noise alone */
    gm_real motor_side;                   /* tau_K and the error of the friction, N m */
    gm_real twist, twist_std;             /* rad */
    gm_real twist_rate, twist_rate_std;   /* rad/s */
    gm_real twist_rate_noise_std;         /* rad/s, by noise alone */
    gm_real motor_speed;                  /* rad/s */
    gm_real torque;                       /* of the motor, as it acted over the step, N m */
    gm_real innovation[2];                /* motor, arm: measured less predicted, rad; or NaN */
    gm_real innovation_std[2];            /* predicted, rad */
    gm_real nis;                          /* normalised innovation squared */
    int dof;                              /* its degrees of freedom: encoders that were read */
    unsigned flags;
} gm_output;

/* Sums over prediction errors, between two judgements. */
typedef struct {
    int32_t samples, count[2], mean_count[2];
    gm_real nis, dof, square[2], mean[2], largest;
} gm_errors;

/* State of one filter. Its members are not part of the interface. */
typedef struct {
    gm_real z[GM_N], P[GM_N * GM_N];
#if GM_COMPANIONS > 0
    gm_real s[GM_COMPANIONS][GM_N]; /* sensitivities to the tolerances */
    gm_real last_torque;
#endif
    gm_real efforts[GM_DELAY + 2][2]; /* torque and load of the last samples */
    gm_real period, usual[2];
    int64_t last, pending_stamp, last_effort, last_measurement, started, due;
    int32_t pending, step, jumps;
    gm_errors errors[2]; /* since the last judgement, and between the two before */
    unsigned flags;
} gm_filter;

/* Begin: call it once, and to begin anew. */
void gm_init(gm_filter *f);

/* Take one sample, in order, once per control period: the positions, and the torque that acts from
 * the stamp on, GM_DELAY samples later. stamp: ns, from 1 to 2^62, of a clock that never stands
 * still, e.g. the number of the period times its length. Periods may vary; a longer one costs more
 * RK4 steps. Returns one of the codes above; writes `out` for GM_ESTIMATE, else its flags only. */
int gm_step(gm_filter *f, int64_t stamp, const gm_sample *in, gm_output *out);

#if GM_ARM_MEASURED
/* What is fitted to a window of the drive, see gm_window. */
enum {
    GM_STIFFNESS, /* N m/rad, in contact */
    GM_HALF_GAP,  /* rad */
    GM_WIDTH,     /* half width of the play, rad */
    GM_ZERO,      /* of the twist, rad */
    GM_VISCOUS,   /* change of the motor's friction, N m s/rad */
    GM_COULOMB,   /* change of the motor's friction, N m */
    GM_GAIN,      /* relative change of the torque gain */
    GM_SHAPE
};

/* Backlash window: normal equations of the torque over the twist, linearised at theta. The host
 * solves normal x = right; theta + x is the next estimate. Sums of several windows with the same
 * theta may be added before. */
typedef struct {
    gm_real theta[GM_SHAPE];
    gm_real normal[GM_SHAPE][GM_SHAPE], right[GM_SHAPE]; /* lower triangle */
    gm_real cost;    /* weighted sum of squared residuals, (N m)^2 */
    int32_t groups;  /* groups of samples that entered */
    /* Not part of the interface: the group under way, and the play. */
    gm_real slope[GM_SHAPE], last[GM_SHAPE], error, error_last, weight, w, w_r;
    int32_t group, count;
    int begun, tracked, paired;
} gm_window;

/* Begin a window at theta (NULL: the values of the model), with so many samples to a group: a
 * 300th of the window's. */
void gm_window_begin(gm_window *w, const gm_real *theta, int32_t group);

/* Add an estimate, one for which gm_step returned GM_ESTIMATE. Leave out those with GM_SETTLING. */
void gm_window_add(gm_window *w, const gm_output *out);
#endif

#endif
