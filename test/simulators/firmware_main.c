/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include "drive.h"

/* Run a filter, and a window where there is one, over two files of stamps and inputs. */
int main(int count, char **paths)
{
    static gm_filter f;
    static gm_output o;
#if defined(GM_PARAMETERS)
    static gm_window w;
    gm_window_begin(&w, NULL, 7);
#endif
    FILE *stamps = fopen(paths[1], "rb"), *inputs = fopen(paths[2], "rb");
    int64_t stamp;
    double in[4];
    int estimates = 0;
    gm_init(&f);
    while (count == 3 && fread(&stamp, 8, 1, stamps) == 1 && fread(in, 8, 4, inputs) == 4) {
        const gm_sample s = {(gm_real)in[0], (gm_real)in[1], (gm_real)in[2], (gm_real)in[3]};
        if (gm_step(&f, stamp, &s, &o) != GM_ESTIMATE)
            continue;
        estimates++;
#if defined(GM_PARAMETERS)
        gm_window_add(&w, &f, &o);
#endif
    }
    printf("%d\n", estimates);
    return fclose(stamps) || fclose(inputs);
}
