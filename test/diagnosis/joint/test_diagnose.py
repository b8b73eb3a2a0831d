# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The command ``diagnose``: what goes in, what comes out. How good verdicts are: test_blind."""
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
import io
import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from gearbox_monitor.cli import diagnose as command
from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.robot.robot_effects import ROBOT_EFFECTS
from gearbox_monitor.files.user_files import load_model
from gearbox_monitor.plant.drive import DriveModel, Transmission
from gearbox_monitor.plant.effects import EFFECTS, LOCATIONS
from gearbox_monitor.plant.faults import Excitation
from gearbox_monitor.plant.simulate import simulate
from gearbox_monitor.recordings.cdr import encode_joint_states
from gearbox_monitor.recordings.read import McapReader
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.report.words import MEANINGS, PLACES

JOINT_STATE = 'sensor_msgs/msg/JointState'
T0 = 1_700_000_000_000_000_000
MODEL = DriveModel()
TRUE = {'id': 'arm_coulomb', 'Cac': 0.05}
FEW = ['--only', 'arm_coulomb', 'motor_viscous', '--seed', '1', '--jobs', '2']
KEYS = {'verdict', 'effect', 'location', 'ranked', 'confusable', 'params', 'gap_before',
        'gap_after', 'closed_fraction', 'closed_fraction_ci', 'sigma', 'nominal',
        'process_torque'}


def record(effects=(), seconds=5.0, seed=1, load=None):
    """Return (t, u, y) of a simulated drive; load [N]: torque on its arm, N m."""
    t = np.arange(int(500 * seconds)) * 2e-3
    u = Excitation('multisine', (4.0, 2.0, 1.0), (0.5, 1.3, 3.1 + 0.1 * seed)).torque(t)
    x = simulate(replace(MODEL, effects=effects), u, 2e-3).x[:, :2]
    return t, u, x + 0.002 * np.random.default_rng(seed).standard_normal(x.shape)


def write_csv(path, t, u, y, *more, header='t,u,motor,arm'):
    np.savetxt(path, np.column_stack([t, u, y, *more]), '%.9g', ',', header=header, comments='')
    return str(path)


def write_bag(path, t, u, y, topic, noise=False):
    """Write a bag; with `noise` also what the diagnosis must not read."""
    stamps = T0 + np.rint(t * 1e9).astype(np.int64)
    nothing = np.full(len(t), np.nan)
    states = encode_joint_states(stamps, ['motor', 'arm'], y, effort=np.column_stack([u, nothing]),
                                 frame_id='arm_coulomb' if noise else '')
    truth = encode_joint_states(stamps, ['transmission'], y[:, :1], effort=u[:, None])
    with BagWriter(path) as writer:
        writer.add_topic(topic, JOINT_STATE)
        if noise:
            writer.add_topic('/plant/transmission_state', JOINT_STATE)
            writer.add_topic('/estimator/arm_coulomb', JOINT_STATE)
            writer.add_metadata('gearbox_monitor', {'plant.effects': json.dumps([TRUE])})
        for k, stamp in enumerate(stamps.tolist()):
            writer.write(topic, stamp, states[k])
            if noise:
                writer.write('/plant/transmission_state', stamp, truth[k])
    return str(path)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with model files and recordings."""
    folder = tmp_path_factory.mktemp('diagnose')
    (folder / 'drive.yaml').write_text(yaml.safe_dump(MODEL.to_dict()))
    (folder / 'measured.yaml').write_text(
        yaml.safe_dump(replace(MODEL, arm_load='measured').to_dict()))
    write_csv(folder / 'worn.csv', *record((TRUE,)))
    write_csv(folder / 'worn2.csv', *record((TRUE,), seed=2))
    write_csv(folder / 'good.csv', *record())
    return folder


def call(folder, *words, model='drive.yaml'):
    """Return the exit code of the command."""
    return main(['diagnose', *words, '--model', str(folder / model)])


@pytest.fixture(scope='module')
def worn(folder, tmp_path_factory):
    """Return what one run of the command has written and shown, and its Verdict."""
    out, verdicts = tmp_path_factory.mktemp('worn') / 'out', []
    words = [str(folder / 'worn.csv'), *FEW, '--out', str(out), '--validate',
             str(folder / 'worn2.csv')]
    original = command.diagnose
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as shown:
        patch.setattr(command, 'diagnose', lambda *args, **options: (
            verdicts.append(original(*args, **options)), verdicts[0])[1])
        with redirect_stderr(io.StringIO()) as errors:
            assert call(folder, *words) == 1
    return SimpleNamespace(out=out, words=words, shown=shown.getvalue(),
                           errors=errors.getvalue(), verdict=verdicts[0],
                           data=json.loads((out / 'verdict.json').read_text()))


def test_verdict_as_json(worn):
    data = worn.data
    assert KEYS <= set(data)
    assert (data['verdict'], data['effect'], data['location']) == (
        'effect', 'arm_coulomb', 'arm_side')
    assert data['ranked'][0] == 'arm_coulomb' and set(data['ranked']) <= {*FEW}
    assert data['params']['arm_coulomb']['Cac'] == pytest.approx(0.05, rel=0.1)
    assert data['gap_before'] > 1.2 and data['gap_after'] == pytest.approx(1.0, abs=0.05)
    low, high = data['closed_fraction_ci']
    assert low - 0.02 <= data['closed_fraction'] <= high + 0.02
    assert data['closed_fraction'] > 0.9
    part, = data['findings']
    assert (part['effect'], part['place']) == ('arm_coulomb', 'arm_side')
    assert part['values'] == data['params']['arm_coulomb'] and part['share'] > 0.9
    assert data['remainders'] == []
    assert data['sigma'] == pytest.approx([0.002, 0.002], rel=0.05)
    assert any('few windows' in warning for warning in data['warnings'])
    assert '\r' not in worn.errors and '%|' not in worn.errors  # no bar in a pipe


def test_text_files_and_a_second_recording(folder, worn, capsys):
    out, shown, data = worn.out, worn.shown, worn.data
    first = ' '.join(shown.split('\nmisfit ')[0].split())
    assert first == data['summary'] and first.startswith('arm side: Coulomb friction 0.0')
    assert first.endswith('none in the model. This explains the whole difference.')
    assert 'Cac = 0.0' in shown and ' N m' in shown and 'validation' in shown
    text = shown.replace(str(folder), '').replace(str(out.parent), '')
    assert max(map(len, text.splitlines())) <= 80
    assert len(re.findall(r'^\S', text, re.MULTILINE)) <= 9 and '1. arm_coulomb' not in text  # -v
    assert {p.name for p in out.iterdir()} >= {'drive.closed.yaml', 'verdict.json', 'report.html'}
    assert data['validation']
    model = load_model(out / 'drive.closed.yaml')
    (effect,) = model.effects
    assert effect == {'id': 'arm_coulomb', **data['params']['arm_coulomb']}
    assert replace(model, effects=()) == MODEL
    assert call(folder, *worn.words) == 2
    assert 'exists, expected a new file' in capsys.readouterr().err


@pytest.mark.system
def test_only_the_measurement_topic_counts(folder, tmp_path, capsys, monkeypatch):
    """Without truth, names and parameters in the bag, and with one thread, the same answer."""
    read = []
    blocks = McapReader.blocks
    monkeypatch.setattr(McapReader, 'blocks', lambda self, topics=None: (
        read.append(topics), blocks(self, topics))[1])
    told = []
    for name, topic, noise, jobs in (('arm_coulomb', '/joint_states', True, '2'),
                                     ('b', '/a/joint_states', False, '1')):
        bag = write_bag(tmp_path / name, *record((TRUE,)), topic, noise)
        assert call(folder, bag, *FEW, '--jobs', jobs, '--json', '-') == 1
        told.append(capsys.readouterr().out)
    assert told[0] == told[1]
    assert json.loads(told[0])['effect'] == 'arm_coulomb'
    assert read == [['/joint_states'], ['/a/joint_states']]


@pytest.mark.system
def test_a_measured_load_is_no_gap(folder, tmp_path, capsys):
    t, u, y = record(({'id': 'load_torque', 'TL': 0.4},))
    loaded = write_csv(tmp_path / 'a.csv', t, u, y, np.full(len(t), 0.4),
                       header='t,u,motor,arm,arm_torque')
    few = ['--only', 'load_torque', '--json', '-']
    assert call(folder, loaded, *few, model='measured.yaml') == 0
    assert call(folder, loaded, *few) == 1
    assert 'not used' in capsys.readouterr().out
    assert call(folder, str(folder / 'good.csv'), *few, model='measured.yaml') == 2
    assert 'no torque measured on the arm' in capsys.readouterr().err


@pytest.mark.system
def test_a_drive_with_one_encoder(tmp_path, capsys):
    rigid = replace(MODEL, transmission=Transmission('rigid'))
    (tmp_path / 'rigid.yaml').write_text(yaml.safe_dump(rigid.to_dict()))
    t, u, _ = record()
    x = simulate(replace(rigid, effects=({'id': 'arm_coulomb', 'Cac': 0.05},)), u, 2e-3).x
    y = x[:, 0] + 0.002 * np.random.default_rng(3).standard_normal(len(t))
    for name, columns in (('motor', (y, np.nan * y)), ('arm', (np.nan * y, y))):
        path = write_csv(tmp_path / f'{name}.csv', t, u, np.column_stack(columns))
        main(['diagnose', path, '--only', 'motor_coulomb', 'motor_viscous', 'arm_coulomb',
              f'{name}_encoder_delay', 'backlash_gap', '--model', str(tmp_path / 'rigid.yaml'),
              '--json', '-'])
        out, _ = capsys.readouterr()
        data = json.loads(out)
        # Friction of the arm goes by the motor's name: nothing tells them apart.
        assert (data['effect'], data['location']) == ('motor_coulomb', 'motor_side')
        assert data['params']['motor_coulomb']['Cc'] == pytest.approx(
            MODEL.coulomb_friction + 0.05, rel=0.02)
        assert set(data['ranked']) == {'motor_coulomb', 'motor_viscous', f'{name}_encoder_delay'}
        assert [s is None for s in data['sigma']] == [name != 'motor', name != 'arm']
        assert [gap['reading'] for gap in data['gaps']] == [name]


@pytest.mark.parametrize('side, effect, key, value', [
    (0, 'backlash_gap', 'b', 0.11),
    pytest.param(1, 'stiffness', 'K', 27.0, marks=pytest.mark.system)])
def test_one_encoder_shows_gap_and_stiffness(folder, tmp_path, capsys, side, effect, key, value):
    name, other = (('motor', 'arm'), ('arm', 'motor'))[side]
    t, u, y = record(({'id': effect, key: value},))
    path = write_csv(tmp_path / f'{name}.csv', t, u, y[:, side], header=f't,u,{name}')
    assert call(folder, path, '--only', 'backlash_gap', 'stiffness', f'{other}_encoder_delay',
                '--json', '-') == 1
    data = json.loads(capsys.readouterr().out)
    assert (data['effect'], data['location']) == (effect, 'transmission')
    error = data['standard_errors'][effect][key]
    assert abs(data['params'][effect][key] - value) < 4.0 * error < 0.1 * value
    assert [gap['reading'] for gap in data['gaps']] == [name]
    assert f'{other}_encoder_delay' not in data['ranked']


def test_what_needs_both_encoders_of_an_elastic_drive_says_so(folder, tmp_path, capsys):
    t, u, y = record()
    path = write_csv(tmp_path / 'one.csv', t, u, y[:, 0], header='t,u,motor')
    assert main(['fit', 'model', path, '--model', str(folder / 'drive.yaml')]) == 2
    assert 'one encoder, expected both' in capsys.readouterr().err
    for changes in ({'driven_by': 'position', 'process_torque_time': 0.3},
                    {'process_torque_time': 0.3}, {'transmission': Transmission('play')}):
        (tmp_path / 'other.yaml').write_text(yaml.safe_dump(replace(MODEL, **changes).to_dict()))
        assert main(['diagnose', path, '--model', str(tmp_path / 'other.yaml')]) == 2
        said = capsys.readouterr().err
        assert 'arm: never measured, expected both encoders, or in other.yaml' in said


@pytest.mark.system
@pytest.mark.parametrize('follows', [False, True])
def test_bursts_that_follow_the_torque_are_no_disturbance(folder, tmp_path, capsys, follows):
    """The same torque on the arm, at times of its own or whenever the command is near its peak."""
    _, u, _ = record(seconds=10.0)
    edges = np.flatnonzero(np.diff(u > 0.8 * u.max(), prepend=False, append=False))
    begins, lengths = edges[::2], np.diff(edges)[::2]
    assert len(begins) == 4
    if not follows:
        begins = (begins + 215) % 4750
    bursts = [{'id': 'disturbance', 't0': 2e-3 * begin, 'duration': 2e-3 * length,
               'amplitude': 0.5} for begin, length in zip(begins, lengths)]
    path = write_csv(tmp_path / 'bursts.csv', *record(tuple(bursts), seconds=10.0))
    assert call(folder, path, '--only', 'disturbance', 'motor_viscous', '--json', '-') == 1
    data = json.loads(capsys.readouterr().out)
    assert data['verdict'] == ('unknown' if follows else 'effect')
    assert data['effect'] == (None if follows else 'disturbance')


def test_an_unknown_effect_is_told_by_its_place(folder, tmp_path, capsys):
    path = write_csv(tmp_path / 'heavy.csv', *record(({'id': 'gravity', 'G': 0.01},)))
    report = tmp_path / 'verdict.json'
    assert call(folder, path, '--only', 'arm_viscous', 'torque_gain', '--json', str(report)) == 1
    assert 'no known effect explains it: arm side: ' in ' '.join(capsys.readouterr().out.split())
    rest = json.loads(report.read_text())['remainders'][0]
    assert rest['location'] == 'arm_side'
    assert 0.0 < rest['size'] < 0.02 and rest['channel'] in ('motor', 'arm')


@pytest.mark.system
def test_an_unknown_encoder_zero_is_no_gap(folder, tmp_path, capsys):
    t, u, y = record()
    path = write_csv(tmp_path / 'shifted.csv', t, u, y + (0.0, 0.03))
    (tmp_path / 'zero.yaml').write_text(
        yaml.safe_dump(replace(MODEL, zero_tolerance=0.05).to_dict()))
    few = [*FEW[:3], 'encoder_offset', *FEW[3:], '--json', '-']
    found = {}
    for name in (folder / 'drive.yaml', tmp_path / 'zero.yaml'):
        main(['diagnose', path, *few, '--model', str(name)])
        found[name.name] = json.loads(capsys.readouterr()[0])
    blamed, known = found['drive.yaml'], found['zero.yaml']
    assert blamed['effect'] == 'encoder_offset'
    assert known['verdict'] == 'none'
    assert known['nominal']['zero'] == pytest.approx(0.03, rel=0.05)
    assert known['nominal_shift'] == {'zero': pytest.approx(0.6, rel=0.05)}


def test_bad_recordings_get_no_verdict(folder, tmp_path, capsys):
    t, u, y = record()
    holed = y.copy()
    holed[1000:1200, 1] = np.nan
    for k, (columns, says) in enumerate((
            ((t[:1500], u[:1500], y[:1500]), 'expected at least 4 s'),
            ((t, u, y[:, ::-1]), 'swapped'), ((t, u, -y), 'sign'),
            ((t, u, np.degrees(y)), 'degrees'),
            ((t, u, holed), '200 samples without arm are left out as a gap; 1 gap in'))):
        path = write_csv(tmp_path / f'{k}.csv', *columns)
        out = tmp_path / f'out{k}'
        assert call(folder, path, *FEW, '--out', str(out)) == 2
        told, err = capsys.readouterr()
        assert not told and not out.exists()
        assert says in err and path in err and err.count('\n') == 1


BAD_USAGE = [
    (['worn.csv', '--exclude', 'x'], "--exclude: unknown effect 'x', expected one of actuator_"),
    (['worn.csv', '--only', 'gravity', '--exclude', 'gravity'], 'effects: none remains'),
    (['worn.csv', '--json', 'good.csv'], 'good.csv: exists'),
    (['worn.csv', '--out', 'good.csv'], 'good.csv: exists'),
]


def test_bad_usage(folder, capsys, monkeypatch):
    for words, says in BAD_USAGE:
        monkeypatch.chdir(folder)
        assert call(folder, *words) == 2
        assert says in capsys.readouterr().err


def test_interrupted_it_leaves_nothing(folder, worn, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt
    words = [str(folder / 'worn.csv'), *FEW, '--out', str(tmp_path / 'out'),
             '--json', str(tmp_path / 'verdict.json')]
    with monkeypatch.context() as context:
        context.setattr(command, 'diagnose', interrupted)
        assert call(folder, *words) == 130
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr(command, 'diagnose', lambda *_, **__: worn.verdict)
    monkeypatch.setattr('pathlib.Path.write_text', interrupted)  # of the first one
    assert call(folder, *words) == 130
    assert not list(tmp_path.iterdir())


def test_every_effect_and_place_has_words():
    assert set(MEANINGS) == {*EFFECTS, *(effect.id for effect in ROBOT_EFFECTS)}
    assert set(PLACES) == set(LOCATIONS)
