
/* A backlash window: the normal equations of the torque over the twist, linearised at theta, whose
 * places are GM_STIFFNESS (N m/rad), GM_HALF_GAP, GM_WIDTH, GM_ZERO (rad), GM_VISCOUS, GM_COULOMB
 * (N m s/rad, N m: changes of the motor's friction) and GM_GAIN (less than 0: the torque gain is
 * above the model's). The host solves normal x = right over these GM_FITTED places, of whose
 * matrix the lower triangle is written; theta + x is the next estimate. Sums of several windows
 * with the same theta may be added before. */
enum { GM_STIFFNESS, GM_HALF_GAP, GM_WIDTH, GM_ZERO, GM_VISCOUS, GM_COULOMB, GM_GAIN, GM_FITTED };
#define GM_PARAMETERS @PARAMETERS@ /* the width of `normal` */

typedef struct {
/*MEMBERS*/
} gm_window;

/* Begin a window at theta (NULL: the values of the model), with so many samples to a group: a
 * 300th of the window's. */
void gm_window_begin(gm_window *w, const gm_real *theta, int32_t group);

/* Add the estimate that gm_step has just returned GM_ESTIMATE for. Leave out those with
 * GM_SETTLING. */
void gm_window_add(gm_window *w, const gm_filter *f, const gm_output *out);
