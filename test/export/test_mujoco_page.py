# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""Every command of the page about MuJoCo, in order, with the files that it shows."""
from pathlib import Path
import re
import shlex

import pytest

from gearbox_monitor.cli.main import main

mujoco = pytest.importorskip('mujoco')
PAGE = (Path(__file__).parents[2] / 'docs/mujoco.md').read_text(encoding='utf-8')


@pytest.mark.system
def test_from_a_file_and_two_recordings_to_a_file_that_fits(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for text in re.findall(r'```(?:xml|yaml)\n(.*?)```', PAGE, re.DOTALL):
        name = re.match(r'(?:#|<!--) (\S+)', text)[1]
        (tmp_path / name).write_text(text, encoding='utf-8')
    block, = re.findall(r'```sh\n(.*?)```', PAGE, re.DOTALL)
    for line in block.replace('\\\n', ' ').splitlines():
        words = shlex.split(line)[1:]
        if words[0] == 'example':
            words += ['--rate', '400']
        elif words[0] == 'diagnose':  # fewer rivals, for time
            words += ['--only', 'arm_inertia', 'gravity']
        assert main(words) == (words[0] == 'diagnose'), words
    out = capsys.readouterr().out
    before, after, ours = map(float, re.findall(r'(?:MuJoCo|monitor) +(\S+)$', out, re.MULTILINE))
    assert before > 3.0 and after < 1.1 and ours < 1.1
    fits = (tmp_path / 'fits.xml').read_text(encoding='utf-8')
    assert 'is the armature -->' in fits and 'name="elbow_gearbox"' in fits
    m = mujoco.MjModel.from_xml_path('fits.xml')
    assert m.nu == 1 and m.body('forearm').inertia.max() > 0.014
