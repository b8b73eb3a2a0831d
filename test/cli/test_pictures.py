# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Commands without matplotlib, which is an extra: a picture is refused before the work begins."""
import sys

import pytest

from gearbox_monitor.cli.main import main


@pytest.mark.parametrize('words, option', [
    (['compare', 'BAG', '--png', 'out.png'], '--png'),
    (['simulate', '--model', 'drive.yaml', '--against', 'BAG', '--out', 'pictures'], '--out'),
    (['demo', '--out', 'demo'], 'demo')])
def test_picture_without_matplotlib(words, option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    assert main(words) == 2
    assert f'{option}: matplotlib is not installed, expected pip install ' in \
        capsys.readouterr().err
    assert not list(tmp_path.iterdir())
