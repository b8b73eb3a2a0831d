# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Each encoder for itself: is it there, how noisy and how fine, does it stick or wrap."""
import numpy as np

from gearbox_monitor.estimation.noise_search import at_rest
from gearbox_monitor.kernels.sensor_noise import lattice, noise_level
from gearbox_monitor.quality.line import BAD, everything, hurts, Line, OK, WARN

NAMES = ('motor', 'arm')
MISSING = (0.01, 0.2)    # share of readings: worth a word; too many
OFF = 1.3                # factor between noise and parameter that the trust indicators notice
COARSE = 0.1             # step over the twist's swing
STUCK = (10, 0.02)       # samples and s on one and the same reading that are looked at
TURN, NEAR_TURN = 2.0 * np.pi, 0.5
NOISY = 1e-6             # of the travel: noise, not rounding of numbers


def noise_of(y):
    """Return (noise, step of the lattice or 0) of readings y [N] (rad), NaN: not measured."""
    known = y[np.isfinite(y)]
    quantum = lattice(known)
    return noise_level(known, quantum), quantum


def measured(y):
    """Return Lines about readings y [N, 2] that are missing."""
    lines = []
    for name, values in zip(NAMES, y.T):
        share = float(np.isnan(values).mean())
        told = {'missing_share': share}
        if share == 1.0:
            lines.append(Line(
                name, 'readings', 'never measured',
                'without it there is no estimate; diagnose takes one encoder, with '
                'transmission.kind: rigid in the model file',
                hurts(BAD, BAD, WARN), told))
            continue
        worst = BAD if share > MISSING[1] else WARN if share > MISSING[0] else OK
        lines.append(Line(
            name, 'readings', 'all there' if share == 0.0 else
            f'{100 * share:.2g} % missing or NaN',
            '' if worst == OK else 'check cable, driver and joint name of this encoder',
            hurts(min(worst, WARN), worst, worst), told))
    return lines


def lines(stamps, y, noises, swing, stated):
    """
    Return Lines about noise and resolution.

    stamps int64 [N] ns and y [N, 2] rad as recorded, stamps increasing; noises ((noise, step),
    ...) of noise_of, None for an encoder without readings; swing (rad): of the twist, or None;
    stated [2] rad: r_std_motor, r_std_arm of the estimator.
    """
    there = [i for i in (0, 1) if noises[i] is not None]
    both = y[:, [there[0], there[-1]]]
    rest = at_rest(stamps, both)
    seconds = 0.0 if rest is None else rest[1]
    told = f'{seconds:.3g} s: tune measures the noise there' if seconds else \
        'none of half a second: tune will find the noise in motion'
    found = [Line('motion', 'standstill', told, values={'rest_s': seconds})]
    for i in there:
        noise, quantum = noises[i]
        told, values = f'{noise:.3g} rad', {'noise_rad': noise, 'quantum_rad': quantum}
        if rest is not None:
            noise = rest[0][there.index(i)]
            told = f'{noise:.3g} rad at rest ({told} throughout)'
            values['noise_at_rest_rad'] = noise
        right = stated[i] / OFF <= noise <= OFF * stated[i]
        found.append(Line(
            NAMES[i], 'noise', f'{told}; r_std_{NAMES[i]} is {stated[i]:.3g}',
            '' if right else 'find R and Q with gearbox_monitor tune',
            {} if right else hurts(WARN, WARN), values))
        if not quantum > 0.0:
            continue
        coarse = swing is not None and quantum > COARSE * swing
        found.append(Line(
            NAMES[i], 'resolution', f'steps of {quantum:.3g} rad'
            + (f', {quantum / swing:.2g} of the swing of the twist' if swing else ''),
            'read the encoder finer (interpolation, both edges), or use one with more lines'
            if coarse else '', hurts(OK, WARN, WARN) if coarse else {}, values))
    return found


def broken(part, noises):
    """
    Return Lines about readings of a Stretch that stick, are clipped or wrap around.

    noises: as of lines.
    """
    found = []
    for i, name in enumerate(NAMES):
        if not part.measured[i]:
            continue
        y = part.y[:, i]
        wraps = _wrapped(part, name, y)
        found += wraps
        if all(part.measured) and not wraps:
            found += _stuck(part, name, y, part.y[:, 1 - i], _play(part, noises, i))
    return found


def _play(part, noises, i):
    """
    Return how far (rad) the other side may go while encoder `i` gives one and the same reading.

    White noise never repeats itself; on a lattice, or without noise, a joint may rest where the
    other one crosses gap and spring.
    """
    (noise, quantum), (other, other_quantum) = noises[i], noises[1 - i]
    still = 20.0 * other + 2.0 * other_quantum
    if quantum == 0.0 and noise > NOISY * np.ptp(part.y[:, i]):
        return still
    low, high = np.percentile(part.y[:, 0] - part.y[:, 1], (25, 75))
    return still + 2.0 * quantum + 4.0 * (high - low)


def _wrapped(part, name, y):
    jump = np.abs(np.diff(y))
    turns = np.flatnonzero(np.abs(jump - TURN) < NEAR_TURN)
    if not len(turns) or jump[turns].min() < 5.0 * np.percentile(jump, 98):
        return []
    return [Line(
        name, 'wraps', f'{len(turns)} jumps of one turn, the first at '
        f'{part.begin + turns[0] * part.dt:.4g} s', 'count the position over turns (unwrap it) '
        'before it is published', everything(BAD), {'wraps': len(turns)})]


def _stuck(part, name, y, other, play):
    """Find a reading that stays the same while the other side goes further than `play` (rad)."""
    edges = np.flatnonzero(np.diff(y)) + 1
    starts = np.append(0, edges)
    lengths = np.diff(np.append(starts, len(y)))
    least = max(STUCK[0], STUCK[1] / part.dt)
    seconds, first = 0.0, None
    for k in np.flatnonzero(lengths >= least):
        run = slice(starts[k], starts[k] + lengths[k])
        if np.ptp(other[run]) > play:
            seconds += lengths[k] * part.dt
            first = starts[k] if first is None else first
    if first is None:
        return []
    at_end = y[first] in (y.min(), y.max()) and np.ptp(y) > 0.0
    what = 'clipped, or an end stop' if at_end else 'frozen'
    return [Line(
        name, 'sticks', f'{what}: one and the same reading for {seconds:.3g} s in all, first at '
        f'{part.begin + first * part.dt:.4g} s, while the other side moves',
        'check encoder, cable and driver; leave end stops out of the motion', everything(BAD),
        {'stuck_s': seconds})]
