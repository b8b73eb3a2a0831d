# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

import pytest

ament_flake8 = pytest.importorskip('ament_flake8.main', reason='ament_flake8 comes with apt')


@pytest.mark.flake8
@pytest.mark.linter
def test_flake8():
    rc, errors = ament_flake8.main_with_errors(argv=['--config', 'setup.cfg'])
    assert rc == 0, f'Found {len(errors)} code style errors / warnings:\n' + '\n'.join(errors)
