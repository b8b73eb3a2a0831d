/* SPDX-License-Identifier: Apache-2.0 */
#include "drive.h"

int filter_size(void) { return (int)sizeof(gm_filter); }

/* in [n, 4]: torque, load, motor, arm; out [n, columns]: as of an estimate row. */
void batch(gm_filter *f, int n, const int64_t *stamps, const double *in, int *codes, int *flags,
           int columns, double *out)
{
    for (int k = 0; k < n; k++) {
        const gm_sample s = {(gm_real)in[4 * k], (gm_real)in[4 * k + 1], (gm_real)in[4 * k + 2],
                             (gm_real)in[4 * k + 3]};
        gm_output o;
        codes[k] = gm_step(f, stamps[k], &s, &o);
        flags[k] = (int)o.flags;
        for (int i = 0; codes[k] == GM_ESTIMATE && i < columns; i++)
            out[columns * k + i] = (double)(&o.x1)[i];
    }
}

#if defined(GM_PARAMETERS) && !defined(GM_FLOAT)
/* One filter over n samples, its estimates in a window; sums [FITTED, FITTED + 1]. */
void window(int n, const int64_t *stamps, const double *in, const double *theta, int group,
            double *sums)
{
    gm_filter f;
    gm_window w;
    gm_output o;
    gm_init(&f);
    gm_window_begin(&w, theta, group);
    for (int k = 0; k < n; k++) {
        const gm_sample s = {in[4 * k], in[4 * k + 1], in[4 * k + 2], in[4 * k + 3]};
        if (gm_step(&f, stamps[k], &s, &o) == GM_ESTIMATE)
            gm_window_add(&w, &f, &o);
    }
    for (int i = 0; i < GM_FITTED; i++) {
        for (int j = 0; j < GM_FITTED; j++)
            sums[i * (GM_FITTED + 1) + j] = w.normal[i * GM_PARAMETERS + j];
        sums[i * (GM_FITTED + 1) + GM_FITTED] = w.right[i];
    }
}
#endif
