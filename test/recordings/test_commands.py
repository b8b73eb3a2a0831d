# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One way in: each command takes each kind of file, and its answer is that of the bag."""
import json

import numpy as np
import pyarrow as pa
from pyarrow import parquet
import pytest

import gearbox_monitor as gm
from gearbox_monitor.cli.main import main
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag
from gearbox_monitor.recordings.read import open_bag

MODEL = gm.DriveModel()
ENDINGS = ('csv', 'parquet')  # read at once, and by a process of its own


@pytest.fixture(scope='module')
def files(tmp_path_factory):
    """Return the folder with one run of a drive in files of both kinds, and its bag."""
    folder = tmp_path_factory.mktemp('kinds')
    write_example_bag(folder / 'bag', MODEL, ExampleMotion(5.0, 250.0, rest=0.5), 1)
    MODEL.save(folder / 'drive.yaml')
    with open_bag(folder / 'bag') as reader:
        states = reader.joint_states('/joint_states', ['motor', 'arm'])
    columns = {'t': (states.stamp_ns - states.stamp_ns[0]) * 1e-9 + 1.0,
               'torque': states.effort[:, 0] * MODEL.effort_scale,
               'motor': states.position[:, 0] / MODEL.gear_ratio, 'arm': states.position[:, 1]}
    np.savetxt(folder / 'run.csv', np.column_stack(list(columns.values())), '%.17g', ',',
               header=','.join(columns), comments='')
    parquet.write_table(pa.table(columns), folder / 'run.parquet')
    return folder


def answer(capsys, *words):
    code = main([str(word) for word in words])
    out, err = capsys.readouterr()
    assert code in (0, 1), err
    return json.loads(out)


def test_check_and_replay_say_of_a_file_what_they_say_of_its_bag(files, capsys):
    bag = gm.load_recording(files / 'bag', MODEL)
    for ending in ENDINGS:
        run = gm.load_recording(files / f'run.{ending}', MODEL)
        for name in ('torque', 'motor', 'arm'):
            np.testing.assert_allclose(getattr(run, name), getattr(bag, name), atol=1e-12)
    (bag_suits, of_bag), *others = ((
        answer(capsys, 'check', files / name, '--model', files / 'drive.yaml', '--json', '-'),
        answer(capsys, 'replay', files / name, '--model', files / 'drive.yaml', '--json'))
        for name in ('bag', *map('run.{}'.format, ENDINGS)))
    for suits, of_file in others:
        assert suits['suits'] == bag_suits['suits']
        assert of_file['estimates'] == of_bag['estimates']
        assert of_file['nis'] == pytest.approx(of_bag['nis'], rel=1e-6)


def test_every_command_takes_a_table(files, tmp_path, capsys):
    path, model = files / 'run.csv', files / 'drive.yaml'
    for words in (('report', path, '--model', model, '--out', tmp_path / 'page.html'),
                  ('fit', 'noise', path, '--model', model, '--out', tmp_path / 'p.yaml'),
                  ('diagnose', path, '--model', model, '--only', 'gravity'),
                  ('fit', 'model', path, '--model', model, '--free', 'Cv'),
                  ('fleet', path, '--model', model, '--out', tmp_path / 'fleet',
                   '--workers', '1'),
                  ('import', path, tmp_path / 'bag')):
        assert main([str(word) for word in words]) in (0, 1), (words, capsys.readouterr().err)


def test_questions_and_mappings_are_the_same_at_every_door(files, tmp_path, capsys):
    run = gm.load_recording(files / 'run.parquet', MODEL)
    path = tmp_path / 'bench.csv'
    np.savetxt(path, np.column_stack([run.t, run.torque, np.rad2deg(run.motor),
                                      np.rad2deg(run.arm)]), '%.17g', ',', comments='',
               header='time,torque [Nm],encoder_a [deg],encoder_b [deg]')
    for command in (('check', path), ('replay', path), ('import', path, tmp_path / 'bag')):
        assert main([str(word) for word in command]) == 3
        err = capsys.readouterr().err
        assert 'encoder_a [deg]' in err and '--use' in err and 'column' in err
    use = ('--use', 'motor=encoder_a [deg]', '--use', 'arm=encoder_b [deg]')
    assert main(['import', str(path), '--guess', *use]) == 0
    (tmp_path / 'map.yaml').write_text(capsys.readouterr().out)
    by_answers, by_map = (answer(capsys, 'check', path, *words, '--json', '-')
                          for words in (use, ('--map', tmp_path / 'map.yaml')))
    assert by_answers['lines'] == by_map['lines']
