# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Bad usage ends before the work begins, with one line and exit code 2."""
import pytest

from benchmarks.__main__ import main as benchmarks_main
from gearbox_monitor.cli.main import main


USAGE = [
    (['diagnose', 'BAG', '--modle', 'M'],
     "diagnose: --modle: no option of this command, did you mean '--model'?;"),
    (['diagnose', 'BAG'],
     '--model: missing; see gearbox_monitor diagnose --help'),
    (['--'], 'COMMAND: missing; see gearbox_monitor --help'),
    (['diagnos', 'BAG'], "COMMAND: 'diagnos', did you mean 'diagnose'?"),
    (['diagnose', 'BAG', '--model', 'M', '--seed', 'x'], "--seed: 'x', expected a whole number;"),
    (['accept', 'BAG', '--confidence', 'x'], "--confidence: 'x', expected a number;"),
    (['check', 'BAG', '--topic'], '--topic: no value, expected one argument;'),
    (['check', 'BAG', 'BAG2'], 'BAG2: one argument too many, expected none;'),
    (['demo', '--duratoin', '20'],
     "--duratoin: no option of this command, did you mean '--duration'?;"),
    (['live', '--port', 'x'], "--port: 'x', expected a whole number from 0 to 65535;"),
    (['diagnose', 'BAG', '--model', 'M', '--re', 'x'],
     '--re: expected one of --recorded-motor, ')]


def test_bad_usage_is_one_line(capsys):
    for words, says in USAGE:
        with pytest.raises(SystemExit, match='2'):
            main(words)
        line, = capsys.readouterr().err.splitlines()
        assert says in line


RESULTS = [
    ['report', 'BAG', '--out'], ['check', 'BAG', '--json'], ['replay', 'BAG', '--out'],
    ['fit', 'model', 'BAG', '--model', 'M', '--out']]


def test_folder_of_a_result_is_checked_first(capsys, tmp_path):
    for words in RESULTS:
        path = tmp_path / 'none' / 'result.png'
        assert main([*words, str(path)]) == 2
        assert f'{path}: no such folder, expected a new name' in capsys.readouterr().err


WRONG_USE = [
    (['fit', 'noise', 'BAG', '--recorded-motor', 'm1', '--out', 'new.yaml'],
     '--recorded-motor: of fit model and fit unit, expected none with fit noise'),
    *((['live', '--estimator', name], f'--estimator: {name!r}, expected the name of a node, such '
       'as estimator or /left/estimator') for name in ('', 'a b', '/', 'left//arm', '2nd')),
    (['diagnose', 'BAG', '--model', 'M', '--validate', 'BAG'],
     'BAG: twice, expected different recordings'),
    (['diagnose', 'BAG', '--model', 'drive.yaml', '--joint', 'elbow'],
     'drive.yaml: a model file, expected the file of a simulator with joint (--joint)'),
    (['fleet', 'BAG', '--out', 'fleet', '--gearbox', 'archive'],
     "--gearbox: 'archive' has no group, expected one around the name of the gearbox: "
     "'archive/([^/]+)/'")]


def test_wrong_use_is_one_line(capsys):
    for words, says in WRONG_USE:
        assert main(words) == 2
        line, = capsys.readouterr().err.splitlines()
        assert line.endswith(says) and line.count(f'{words[0]}: ') == 1


INTO_A_BAG = [
    (['report', 'BAG'], '--out'), (['check', 'BAG'], '--json'), (['fit', 'noise', 'BAG'], '--out'),
    (['replay', 'BAG'], '--out'),
    (['diagnose', 'BAG', '--model', 'M'], '--out'),
    (['diagnose', 'BAG', '--model', 'M'], '--json'),
    (['fit', 'unit', 'BAG', '--model', 'M'], '--out'),
    (['fit', 'model', 'BAG', '--model', 'M'], '--out'), (['fleet', 'BAG'], '--out'),
    (['export', 'M', '--to', 'mjcf'], '--out'), (['example'], '')]


def test_nothing_is_written_into_the_folder_of_a_bag(capsys, tmp_path):
    for words, option in INTO_A_BAG:
        for name in ('metadata.yaml', 'run_0.mcap'):
            (tmp_path / name).write_text('')
        name = str(tmp_path / 'found.yaml')
        assert main([*words, *filter(None, [option]), name]) == 2
        assert f'{name}: in the folder of a bag, which stays as it was recorded' in \
            capsys.readouterr().err
        assert sorted(path.name for path in tmp_path.iterdir()) == ['metadata.yaml', 'run_0.mcap']


BENCHMARK_USAGE = [
    (['nonsense'], "NAME: 'nonsense', expected one of actuators, "),
    (['trust', '--quik'],
     "trust: --quik: no option of this command, did you mean '--quick'?; "
     'see python -m benchmarks trust --help'),
    (['wear', '3'], 'wear: 3: one argument too many, expected none;')]


def test_bad_usage_of_a_benchmark_is_one_line(capsys):
    for words, says in BENCHMARK_USAGE:
        with pytest.raises(SystemExit, match='2'):
            benchmarks_main(words)
        line, = capsys.readouterr().err.splitlines()
        assert line.startswith('python -m benchmarks') and says in line
