/* SPDX-License-Identifier: Apache-2.0 */
#include "drive.h"

#if !GM_ARM_MEASURED /* no windows */
typedef int gm_window;
#endif

int filter_size(void) { return (int)sizeof(gm_filter); }
int window_size(void) { return (int)sizeof(gm_window); }

/* in [n, 4]: torque, load, motor, arm; out [n, 13]: see test_firmware.COLUMNS. */
void batch(gm_filter *f, gm_window *w, int n, const int64_t *stamps, const double *in, int *codes,
           int *flags, double *out)
{
    for (int k = 0; k < n; k++) {
        const gm_sample s = {(gm_real)in[4 * k], (gm_real)in[4 * k + 1], (gm_real)in[4 * k + 2],
                             (gm_real)in[4 * k + 3]};
        gm_output o;
        codes[k] = gm_step(f, stamps[k], &s, &o);
        flags[k] = (int)o.flags;
        if (codes[k] != GM_ESTIMATE)
            continue;
        const gm_real values[13] = {
            o.tau_k, o.tau_k_std, o.tau_k_noise_std, o.twist, o.twist_std, o.twist_rate,
            o.motor_speed, o.innovation[0], o.innovation[1], o.nis, o.motor_side, o.torque,
            o.twist_rate_noise_std};
        for (int i = 0; i < 13; i++)
            out[13 * k + i] = (double)values[i];
#if GM_ARM_MEASURED
        if (w)
            gm_window_add(w, &o);
#else
        (void)w;
#endif
    }
}

#if GM_ARM_MEASURED
void sums(const gm_window *w, double *out)
{
    for (int i = 0; i < GM_SHAPE; i++)
        for (int j = 0; j <= i; j++)
            out[i * GM_SHAPE + j] = (double)w->normal[i][j];
    for (int i = 0; i < GM_SHAPE; i++)
        out[GM_SHAPE * GM_SHAPE + i] = (double)w->right[i];
}
#endif
