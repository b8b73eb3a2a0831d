# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What `import` and `check` recommend for the logs of public layouts is accepted as it stands."""
import shlex

from log_layouts import LAYOUTS
import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.files.user_files import save_model
from gearbox_monitor.plant.drive import DriveModel, Transmission

# The simulated robots of log_layouts.
MODEL = DriveModel(
    motor_inertia=0.15, arm_inertia=0.15, viscous_friction=1.5, coulomb_friction=2.0,
    friction_sharpness=20.0, position_gain=0.0, transmission=Transmission('rigid'),
    effects=({'id': 'gravity', 'G': 8.0},), tolerance=0.1)
QUICK = ('_franka', '_ur_rtde', '_odrive', '_twincat')
UNDECIDED = 3


def recommended(capsys, command):
    """Return the commands behind 'next:' that a command prints, and its exit code."""
    code = main(command)
    return [line.removeprefix('next: gearbox_monitor ').partition('  #')[0]
            for line in capsys.readouterr().out.splitlines() if line.startswith('next: ')], code


def run_recommended(capsys, check):
    """Run what `check` recommends as a user would, and return it."""
    commands, code = recommended(capsys, check)
    assert code in (0, 1)
    for number, command in enumerate(commands):
        words = [{'FILE': 'joint.yaml', 'RAD': '0.1', 'params.yaml': f'params{number}.yaml'}
                 .get(word, word) for word in shlex.split(command)]
        # One effect is enough to see that a diagnosis begins.
        words += ['--only', 'motor_viscous'] if words[0] == 'diagnose' else []
        code = main(words)
        assert code in (0, 1) or words[0] == 'accept' and code == UNDECIDED, (
            words, capsys.readouterr().err)
    return commands


@pytest.mark.parametrize('make', [
    make if make.__name__ in QUICK else pytest.param(make, marks=pytest.mark.system)
    for make in LAYOUTS], ids=lambda make: make.__name__.strip('_'))
def test_recommended_commands_are_accepted(tmp_path, capsys, monkeypatch, make):
    if make.__name__ == '_aloha':
        pytest.importorskip('h5py')
    layout = make(tmp_path)
    monkeypatch.chdir(tmp_path)
    save_model(tmp_path / 'drive.yaml', MODEL, [])
    commands, code = recommended(capsys, [
        'import', str(layout.path), '--guess', *layout.options, 'bag'])
    assert code == 0
    checks = [shlex.split(command) for command in commands] or [
        ['check', 'bag', '--motor-joint', 'motor', '--arm-joint', '']]
    for check in checks:
        joint = check[check.index('--motor-joint') + 1]
        (tmp_path / 'joint.yaml').write_text(
            f"estimator: {{ros__parameters: {{motor_joint: '{joint}', arm_joint: ''}}}}\n")
        run_recommended(capsys, [*check, '--model', 'drive.yaml'])


@pytest.mark.system
@pytest.mark.parametrize('options', [
    ('--rate', '100', '--seconds', '6', '--rest', '0.5'),
    ('--rate', '50', '--encoders', 'motor'), ('--rate', '125'), ('--rate', '1000')],
    ids=' '.join)
def test_recommended_commands_for_example_drives(tmp_path, capsys, monkeypatch, options):
    monkeypatch.chdir(tmp_path)
    assert main(['example', 'bag', '--motion', 'varied', *options]) == 0
    capsys.readouterr()
    (tmp_path / 'joint.yaml').write_text('estimator: {ros__parameters: {arm_joint: ""}}\n')
    arm = ['--arm-joint', ''] if 'motor' in options else []
    assert run_recommended(capsys, ['check', 'bag', '--model', 'bag.drive.yaml', *arm])
