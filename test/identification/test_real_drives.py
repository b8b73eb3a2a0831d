# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The walk-throughs of docs/real_drives.md, on the recordings of real drives."""
import json
import math
from pathlib import Path
import re
import shlex
import shutil

import pytest

from gearbox_monitor.cli.main import main
from gearbox_monitor.files.yaml_files import load_model

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / 'shared' / 'data'
EMPS, DAVINCI = DATA / 'emps', DATA / 'davinci_backend'
PAGES = (ROOT / 'docs' / 'real_drives.md').read_text(encoding='utf-8').split(
    '## A light motor behind a gearbox')


def commands_of(page):
    """Return the words of the commands on `page`, line by line."""
    return [shlex.split(line) for block in re.findall(r'```sh\n(.*?)```', page, re.DOTALL)
            for line in block.splitlines()]


@pytest.mark.system
@pytest.mark.skipif(not EMPS.exists(), reason='no recordings of the EMPS beside the repository')
def test_walk_through(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for path in EMPS.glob('*.mat'):
        (tmp_path / path.name).symlink_to(path)
    model, = re.findall(r'```yaml\n# drive.yaml\n(.*?)```', PAGES[0], re.DOTALL)
    Path('drive.yaml').write_text(model)
    lines = commands_of(PAGES[0])
    assert [words[1] for words in lines] == [
        'import', 'import', 'fit-nominal', 'diagnose', 'fit-nominal', 'simulate']
    said = {}
    for words in lines:
        if words[1] == 'diagnose':  # fewer rivals, for time
            words += ['--only', 'coulomb_asymmetry', 'viscous_asymmetry', 'torque_offset',
                      '--jobs', '2']
        assert main(words[1:]) in (0, 1), words
        said[words[1]] = capsys.readouterr()[0]

    verdict = json.loads(Path('found/verdict.json').read_text())
    assert verdict['effect'] == 'viscous_asymmetry'
    # N at the rms speed of the motion, 0.09 m/s: the offset that the authors publish
    force = 0.09 * abs(verdict['params']['viscous_asymmetry']['Cva'])
    assert force == pytest.approx(3.165, abs=0.3)
    closed = load_model('closed.yaml')
    assert closed.coulomb_friction > 0.0 and closed.viscous_friction > 0.0
    # Open loop over the whole of the other recording.
    free = verdict['validation']['free_run']
    assert free['before']['motor'] > 0.09
    assert free['after']['motor'] < 0.02
    last, = re.findall(r'motor: \S+ rms before, (\S+) rms after', said['fit-nominal'])
    assert float(last) < 0.007


@pytest.mark.skipif(not DAVINCI.exists(), reason='no recordings of the davinci_backend')
@pytest.mark.system
def test_walk_through_behind_a_gearbox(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for path in DAVINCI.glob('*.TXT.gz'):
        (tmp_path / path.name).symlink_to(path)
    shutil.copy(ROOT / 'config' / 'davinci_backend_nominal.yaml', tmp_path)
    lines = commands_of(PAGES[1])
    assert [words[1] for words in lines] == [
        'import', 'import', 'import', 'diagnose', 'fit-nominal', 'diagnose', 'simulate']
    for words in lines:
        assert main(words[1:]) in (0, 1), words
    said = capsys.readouterr().out
    verdicts = [json.loads(Path(folder, 'verdict.json').read_text())
                for folder in ('found', 'found2')]
    assert [v['effect'] for v in verdicts] == ['backlash_gap+arm_coulomb+mesh_error', None]
    assert verdicts[0]['params']['backlash_gap']['b'] == pytest.approx(0.012, rel=0.05)
    assert verdicts[1]['verdict'] == 'none'
    # The last one is that of simulate: one free run over a recording that took no part.
    before, after = map(float, re.findall(r'^  arm +(\S+) +(\S+)$', said, re.MULTILINE)[-1])
    assert math.degrees(before) > 0.6 and math.degrees(after) < 0.19
