# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What `check` says of recordings: each fault of one is found, and a sound one passes."""
import json

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli import check
from gearbox_monitor.cli.main import main
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimates import Samples
from gearbox_monitor.parameters import EstimatorParameters
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import Noise, simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.signals import checks, stamps
from gearbox_monitor.signals.examine import examine, joined
from gearbox_monitor.signals.finding import BAD, OK, PURPOSES, WARN

MODEL = DriveModel()
PARAMETERS = EstimatorParameters(drift_window=2.5, max_gap=0.1)
JOINT_STATE = 'sensor_msgs/msg/JointState'
T0 = 1_700_000_000_000_000_000
N = 16000
DT = 1e-3


def recorded(command=None, noise=5e-3, model=MODEL, n=N, rest=1000):
    """Return Samples of a simulated drive, at rest for the first `rest` samples."""
    u = Excitation().torque(DT * np.arange(n)) if command is None else command
    u[:rest] = 0.0
    drive = simulate(model, u, DT, Noise(measurement=(noise, noise)), seed=1)
    return Samples(T0 + np.arange(n) * 1_000_000, np.column_stack([u, np.full(n, np.nan)]),
                   drive.y)


@pytest.fixture(scope='module')
def sound():
    return recorded()


@pytest.fixture(scope='module')
def half(sound):
    return Samples(*(getattr(sound, name)[:N // 2] for name in ('stamp_ns', 'u', 'y')))


def changed(samples, **fields):
    return Samples(*(fields.get(name, getattr(samples, name)).copy()
                     for name in ('stamp_ns', 'u', 'y')))


def judged(samples, model=MODEL, **parameters):
    """Return ({(group, name): DataFinding}, {purpose: Grade})."""
    found = examine(samples, PARAMETERS.replace(**parameters), model)
    return ({(line.group, line.name): line for line in found.lines},
            {purpose: verdict for purpose, (verdict, _) in found.suits.items()})


def test_a_sound_recording_passes_in_every_line(sound):
    lines, suits = judged(sound)
    assert suits == dict.fromkeys(PURPOSES, OK)
    assert all(line.verdict() == OK and not line.advice for line in lines.values())
    values = {key: line.values for key, line in lines.items()}
    assert values['stamps', 'rate']['rate_hz'] == pytest.approx(1000.0)
    assert values['motor', 'noise']['noise_rad'] == pytest.approx(5e-3, rel=0.05)
    assert values['motion', 'standstill']['rest_s'] == pytest.approx(1.0, abs=0.1)
    assert lines['motion', 'standstill'].figure.endswith('s: fit noise measures the noise there')
    assert values['signs', 'torque and motor']['gain'] == pytest.approx(
        1.0 / MODEL.motor_inertia, rel=0.1)
    # Two reversals per period of the stronger torque, and the gap is crossed in each.
    reversals = values['motion', 'reversals']['reversals']
    assert reversals == pytest.approx(2 * 0.9 * 15, rel=0.05)
    assert values['motion', 'gap traversals']['traversals'] == pytest.approx(reversals, abs=4)


def test_effort_delay_is_measured_in_samples(sound):
    """The torque is logged `delay` samples before it acts."""
    u, delay = sound.u.copy(), 3
    u[:, 0] = np.roll(u[:, 0], -delay)
    lines, _ = judged(changed(sound, u=u), effort_delay=delay)
    line = lines['torque', 'effort delay']
    std = line.values['delay_std_samples']
    assert line.verdict() == OK and std < 0.5
    assert abs(line.values['delay_samples'] - delay) < min(2.0 * std, 0.5)
    line = judged(changed(sound, u=u))[0]['torque', 'effort delay']
    assert line.verdict() == WARN and 'effort_delay: 3' in line.advice


def test_a_delay_that_no_parameter_takes_is_not_advised(sound):
    u = sound.u.copy()
    u[:, 0] = np.roll(u[:, 0], 3)  # logged three samples after it acted
    line = judged(changed(sound, u=u))[0]['torque', 'effort delay']
    assert line.verdict() == WARN and 'takes -1 to 50' in line.figure
    assert 'set effort_delay' not in line.advice and '3 samples too late' in line.advice


def test_no_delay_is_claimed_from_a_slow_motion():
    u = Excitation('triangle', (2.0,), (0.2,)).torque(DT * np.arange(N))
    line = judged(recorded(u, 1e-3))[0]['torque', 'effort delay']
    assert line.verdict() == WARN and line.figure.startswith('not determined')


def frozen(s):
    y = s.y.copy()
    y[5000:6000, 1] = y[5000, 1]
    return changed(s, y=y)


def frozen_for_good(s):
    y = s.y.copy()
    y[2000:, 1] = y[2000, 1]
    return changed(s, y=y)


def efforts(s, part, value):
    u = s.u.copy()
    u[part, 0] = value
    return changed(s, u=u)


def clipped(s):
    return changed(s, y=np.column_stack([np.minimum(s.y[:, 0], s.y[:, 0].max() - 1.0), s.y[:, 1]]))


def wrapped(s):
    y = s.y[:, 1] - s.y[:, 1].mean()
    return changed(s, y=np.column_stack([s.y[:, 0], np.mod(y, 2 * np.pi)]))


def scaled(s, u=1.0, motor=1.0, arm=1.0):
    return changed(s, u=s.u * u, y=s.y * (motor, arm))


def stamped(s, seed=0, jitter=0.0, repeat=0, lose=0.0, hole=0):
    random = np.random.default_rng(seed)
    stamp = s.stamp_ns + (jitter * 1e6 * random.standard_normal(len(s.stamp_ns))).astype(np.int64)
    if repeat:
        stamp[repeat::repeat] = stamp[repeat - 1:-1:repeat]
    keep = random.random(len(stamp)) >= lose
    keep[4000:4000 + hole] = False
    return Samples(stamp[keep], s.u[keep], s.y[keep])


def without_torque(s):
    return changed(s, u=np.full_like(s.u, np.nan))


def one_way(s):
    """Return a drive that holds a weight while it moves: one flank only."""
    loaded = MODEL.with_(effects=[{'id': 'load_torque', 'TL': 2.0}])
    n = len(s.stamp_ns)
    return recorded(2.0 + 0.5 * np.cos(4.0 * DT * np.arange(n)), model=loaded, n=n, rest=0)


SPOILT = [
    (lambda s: scaled(s, u=-1.0), ('signs', 'torque and motor'), 'the wrong way', BAD, PURPOSES),
    (lambda s: scaled(s, arm=-1.0), ('signs', 'motor and arm'), '-1.0', BAD, PURPOSES),
    (lambda s: scaled(s, motor=35.0), ('signs', 'motor and arm'), 'arm moves 0.02998', BAD,
     PURPOSES),
    (lambda s: scaled(s, 1.0, 180 / np.pi, 180 / np.pi), ('model', 'diagnose'), 'in degrees', BAD,
     PURPOSES),
    (frozen, ('arm', 'sticks'), 'frozen', BAD, PURPOSES),
    (frozen_for_good, ('arm', 'sticks'), 'frozen', BAD, PURPOSES),
    (lambda s: efforts(s, slice(3000, 4500), 0.0), ('torque', 'sticks'),
     'longest from 3 s to 4.499 s: 0 N m', WARN, ()),
    (lambda s: efforts(s, slice(1500, N), 9.0), ('torque', 'sticks'), 'clamped', BAD, PURPOSES),
    (lambda s: efforts(s, slice(100, 120), 6.9e220), ('torque', 'unphysical'),
     '20 numbers infinite or beyond 1e9, or far beyond all others, the first 6.9e+220 at 0.1 s',
     WARN, ()),
    (lambda s: efforts(s, slice(700, 701), -5e5), ('torque', 'unphysical'),
     'the first -5e+05 at 0.7 s', WARN, ()),
    (lambda s: changed(s, y=s.y * np.nan), ('motor', 'readings'), 'never measured', BAD, PURPOSES),
    (clipped, ('motor', 'sticks'), 'clipped', BAD, PURPOSES),
    (wrapped, ('arm', 'wraps'), 'jumps of one turn', BAD,
     ('estimation', 'drift')),
    (without_torque, ('torque', 'readings'), 'none', BAD, PURPOSES),
    (lambda s: changed(s, u=0.0 * s.u + (1.0, 0.0)), ('torque', 'readings'), 'throughout', BAD,
     PURPOSES),
    (lambda s: stamped(s, repeat=100), ('stamps', 'order'), '79 repeated', WARN, ()),
    (lambda s: stamped(s, repeat=10), ('stamps', 'order'), 'repeated', BAD, PURPOSES),
    (lambda s: stamped(s, jitter=0.2), ('stamps', 'jitter'), '0.2 ms rms, 20 % of', WARN, ()),
    (lambda s: stamped(s, lose=0.02), ('stamps', 'gaps'), 'samples (', BAD, ('diagnosis',)),
    (lambda s: stamped(s, hole=150), ('stamps', 'gaps'), '1 restart', WARN, ()),
    (one_way, ('motion', 'gap traversals'), '0 % of the windows', BAD, ('drift',)),
    (lambda s: changed(s, stamp_ns=T0 + 40 * (s.stamp_ns - T0)), ('stamps', 'rate'), '25 Hz', BAD,
     ('diagnosis',)),
    (lambda s: changed(s, stamp_ns=T0 + 20 * (s.stamp_ns - T0)), ('stamps', 'rate'), '50 Hz', WARN,
     ()),
]


def test_what_is_wrong_is_said(half):
    for spoil, where, words, verdict, spoilt in SPOILT:
        lines, suits = judged(spoil(half))
        line = lines[where]
        assert line.verdict() == verdict and line.advice, where
        assert words in line.figure
        assert {purpose for purpose in PURPOSES if suits[purpose] == BAD} >= set(spoilt)
        assert 'estimation' in spoilt or suits['estimation'] < BAD


def test_memory_that_nobody_wrote_is_refused(sound):
    for spoilt in (changed(sound, u=sound.u * 1e-309), changed(sound, y=sound.y * 1e-309)):
        with pytest.raises(InputError, match='dead: uninitialised memory'):
            judged(spoilt)


def test_an_outlier_spoils_no_other_line(half):
    y = half.y.copy()
    y[700, 0] = 3000.0
    lines, _ = judged(changed(half, y=y))
    assert lines['motor', 'outliers'].verdict() == WARN
    assert lines['signs', 'motor and arm'].verdict() == OK


def test_one_encoder_suits_the_diagnosis(sound):
    y = np.column_stack([sound.y[:, 0], np.full(N, np.nan)])
    rigid = DriveModel(motor_inertia=MODEL.motor_inertia, arm_inertia=MODEL.arm_inertia
                       ).with_(kind='rigid')
    lines, suits = judged(changed(sound, y=y), None)
    assert suits == {'estimation': BAD, 'drift': BAD, 'diagnosis': WARN}
    assert 'never measured' in lines['arm', 'readings'].figure
    assert lines['signs', 'torque and motor'].verdict() == OK
    lines, suits = judged(changed(sound, y=y), rigid)
    assert suits['estimation'] == BAD
    assert lines['model', 'diagnose'].figure.startswith('accepted')
    lines, suits = judged(changed(sound, y=y))
    assert suits['diagnosis'] < BAD and lines['model', 'diagnose'].figure.startswith('accepted')


def test_values_that_are_held_tell_their_true_rate(sound):
    rows = np.arange(N) // 15 * 15
    lines, suits = judged(changed(sound, y=sound.y[rows]))
    assert lines['motor', 'held'].values['rate_hz'] == pytest.approx(1000.0 / 15)
    assert 'held for 15 rows' in lines['arm', 'held'].figure
    assert 'held for 15 rows' in lines['model', 'diagnose'].figure and suits['diagnosis'] == BAD
    # A coarse encoder repeats itself, too, but in no rhythm.
    for step in (1e-3, 0.02, 0.1, 0.5):
        assert stamps.held_rows(step * np.rint(sound.y[:, 0] / step)) == 1


def test_held_positions_suit_a_servo_alone(sound):
    """At 100 Hz they are too late for a torque, and in time for a setpoint."""
    for controller, verdict in ((None, BAD), ({'kind': 'pd', 'kp': 20.0}, OK)):
        held = changed(sound, y=sound.y[np.arange(N) // 10 * 10])
        lines, _ = judged(held, MODEL.with_(controller=controller))
        assert lines['motor', 'held'].verdict(('diagnosis',)) == verdict
        assert ('measured at 100 Hz' in lines['model', 'diagnose'].figure) == (verdict == BAD)


def test_a_setpoint_is_no_torque(sound):
    beside = checks.torques(sound.u[:, 0], np.arange(N) * 1e-3, True, has_setpoint=True)
    assert [(line.name, line.verdict()) for line in beside] == [('readings', OK), ('used', OK)]
    servo = MODEL.with_(controller={'kind': 'pd', 'kp': 20.0})
    assert [examine(sound, PARAMETERS, servo, beside).lines[5].figure.split()[0]
            for beside in (False, True)] == ['none:', 'recorded,']
    alone = checks.torques(np.full(N, np.nan), np.arange(N) * 1e-3, False, has_setpoint=True)[0]
    assert alone.verdict(('diagnosis',)) == WARN and alone.verdict(('drift',)) == BAD
    for late in (0, 150):
        u = np.column_stack([np.roll(sound.y[:, 0], -late), sound.u[:, 1]])
        line = judged(changed(sound, u=u), None)[0]['torque', 'setpoint']
        assert line.verdict() == BAD and 'a setpoint' in line.figure


def test_a_sign_is_wrong_above_five_standard_errors_only():
    def graded(gain, std, correlation=0.8, work=0.0, work_std=0.1):
        response = checks.TorqueResponse(0.0, 0.1, correlation, gain, std, False, work, work_std)
        return checks.answered(response, 1e-3, 0)[1].verdict()
    assert [graded(-10.0, std) for std in (1.9, 2.1, 5.3)] == [BAD, WARN, WARN]
    assert graded(10.0, 5.3) == OK
    unseen = {'gain': 1.0, 'std': 10.0, 'correlation': 0.0}
    assert graded(**unseen, work=-0.6) == BAD and graded(**unseen, work=-0.4) == WARN
    assert graded(**unseen, work=0.4) == OK


def test_coarse_encoder(sound):
    y = 0.1 * np.rint(sound.y / 0.1)
    line = judged(changed(sound, y=y))[0]['arm', 'resolution']
    assert line.verdict() == WARN and line.values['quantum_rad'] == pytest.approx(0.1)


def test_clock_takes_what_is_later_than_all_before():
    stamp = T0 + 1_000_000 * np.array([0, 1, 2, 2, 3, 4, 4, 1, 5, 6, 7, 8, 12, 13])
    stamp[0] = 0
    found = stamps.clock(stamp)
    assert found.usable.tolist() == [False, True, True, False, True, True, False, False,
                                     *[True] * 6]
    assert found.period == pytest.approx(1e-3) and found.absent.sum() == 3
    assert stamps.clock(stamp[:9]) is None
    with pytest.raises(InputError, match='9 samples, expected 100 or more'):
        judged(Samples(stamp[:9], np.zeros((9, 2)), np.zeros((9, 2))))


def test_a_fault_in_any_part_counts_and_a_part_at_rest_spoils_nothing(sound):
    def part(begin, end, spoil=None):
        some = Samples(*(getattr(sound, name)[begin:end] for name in ('stamp_ns', 'u', 'y')))
        return examine(spoil(some) if spoil else some, PARAMETERS, MODEL)

    def at_rest(s):
        noise = np.random.default_rng(0).normal(0.0, 5e-3, s.y.shape)
        return changed(s, u=np.zeros_like(s.u), y=s.y[0] + noise)

    def stuck(s):
        y = s.y.copy()
        y[2000:3000, 1] = y[2000, 1]
        return changed(s, y=y)

    good = [part(0, 6000), part(6000, 10000, at_rest)]
    assert good[1].suits['estimation'][0] == BAD
    found = joined(good, 2.5)
    assert found.suits['estimation'][0] == good[0].suits['estimation'][0] == OK
    assert found.seconds == pytest.approx(9.999)
    bad = joined([*good, part(10000, 16000, stuck)], 2.5)
    line = next(line for line in bad.lines if line.name == 'sticks')
    assert line.verdict() == BAD and '(part from 10 s on)' in line.figure


def test_lost_and_refused_samples_of_all_parts_are_counted(sound):
    keep = np.setdiff1d(np.arange(N), [*range(1000, 1003), *range(12000, 12010)])
    part = Samples(*(getattr(sound, name)[keep] for name in ('stamp_ns', 'u', 'y')))
    stamp = part.stamp_ns.copy()
    stamp[[500, 9000, 15000]] = stamp[[499, 8999, 14999]]
    part = changed(part, stamp_ns=stamp)
    ends = (0, 5000, len(stamp))
    lines = joined([examine(Samples(*(getattr(part, name)[max(a - 1, 0):b]
                                      for name in ('stamp_ns', 'u', 'y'))), PARAMETERS)
                    for a, b in zip(ends, ends[1:])], 2.5).lines
    order, gaps = (next(line for line in lines if line.name == name) for name in (
        'order', 'gaps'))
    assert order.figure == f'3 repeated; 3 of {N - 13} samples are refused'
    # What repeats is refused, so it is lost, too.
    assert gaps.values['gaps'] == 5 and gaps.values['lost'] == 16
    assert '0.011 s at 11.99' in gaps.figure or '0.011 s at 12 s' in gaps.figure


# ---------------------------------------------------------------------- command line


def write(path, samples, names=('motor', 'arm')):
    raws = encode_joint_states(samples.stamp_ns, names, samples.y[:, :len(names)],
                               effort=samples.u[:, :len(names)])
    with BagWriter(path) as writer:
        writer.add_topic('/left/joint_states', JOINT_STATE)
        for stamp, raw in zip(samples.stamp_ns.tolist(), raws):
            writer.write('/left/joint_states', stamp, raw)
    return str(path)


@pytest.fixture(scope='module')
def bags(sound, tmp_path_factory):
    folder = tmp_path_factory.mktemp('check')
    few = Samples(*(getattr(sound, name)[:12000] for name in ('stamp_ns', 'u', 'y')))
    (folder / 'drive.yaml').write_text(yaml.safe_dump(MODEL.to_dict()))
    write(folder / 'geared', scaled(few, -1.0 / 20.0, -20.0), ('m', 'a'))
    write(folder / 'alone', few, ('m',))
    (folder / 'geared.yaml').write_text(yaml.safe_dump(
        {**MODEL.to_dict(), 'gear_ratio': -20.0}))
    return folder


def test_command(bags, tmp_path, capsys):
    words = ['check', str(bags / 'geared'), '--motor-joint', 'm', '--arm-joint', 'a']
    model = ['--model', str(bags / 'geared.yaml')]
    out = tmp_path / 'found.json'
    assert main([*words, *model, '--json', str(out)]) == 0
    shown = capsys.readouterr().out.replace(str(bags), '')
    assert max(len(line) for line in shown.splitlines() if 'next: ' not in line) <= 80
    assert '\x1b' not in shown
    assert '/left/joint_states sensor_msgs/JointState' in shown
    assert 'next: gearbox_monitor fit noise /geared --model /geared.yaml --out' in shown
    assert '--params FILE  # FILE: motor_joint: m, arm_joint: a' in shown
    assert 'next: gearbox_monitor diagnose /geared --model /geared.yaml --recorded-motor m ' \
        '--recorded-arm a\n' in shown + '\n'
    data = json.loads(out.read_text())
    assert data['suits']['estimation'] == {'verdict': 'yes', 'because': []}
    assert data['joints']['there'] == ['m', 'a'] and data['topics'][0]['messages'] == 12000
    assert main([*words, *model, '--json', str(out)]) == 2
    assert 'exists, expected a new file' in capsys.readouterr().err
    # Without the model file nobody knows the gear, and it says so.
    assert main([*words, '--json', '-']) == 1
    data = json.loads(capsys.readouterr().out)
    line = next(line for line in data['lines'] if line['name'] == 'motor and arm')
    assert line['verdict'] == 'bad' and 'gear_ratio' in line['advice']


def test_command_with_a_long_recording(bags, monkeypatch, capsys):
    words = ['check', str(bags / 'geared'), '--motor-joint', 'm', '--arm-joint', 'a', '--model',
             str(bags / 'geared.yaml'), '--json', '-']
    main(words)
    whole = json.loads(capsys.readouterr().out)
    monkeypatch.setattr(check, 'SAMPLES', 5000)
    monkeypatch.setattr(check, 'WINDOWS', 0)
    main(words)
    parts = json.loads(capsys.readouterr().out)
    assert parts['notes'] == ['evaluated in 2 parts: each line shows the first of the worst '
                              'parts, refused and lost samples are counted in all']
    assert [line['name'] for line in parts['lines']] == [line['name'] for line in whole['lines']]
    length = next(line for line in parts['lines'] if line['name'] == 'length')
    assert length['values']['duration_s'] == pytest.approx(11.999)


def test_command_with_one_joint(bags, capsys):
    words = ['check', str(bags / 'alone'), '--motor-joint', 'm']
    assert main([*words, '--for', 'estimation']) == 1
    assert "no joint 'arm', only m" in capsys.readouterr().out
    assert main([*words, '--for', 'diagnosis']) == 0
    assert 'bad' not in capsys.readouterr().out


WRONG = [
    ([], "no joint 'motor'"), (['--topic', '/joint_states'], 'no topic /joint_states'),
    (['--model', 'nothing.yaml'], 'nothing.yaml: ')]


def test_command_with_bad_input(bags, capsys):
    for options, says in WRONG:
        assert main(['check', str(bags / 'geared'), *options]) == 2
        assert says in capsys.readouterr().err
