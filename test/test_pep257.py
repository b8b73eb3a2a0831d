# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

import pytest

main = pytest.importorskip('ament_pep257.main', reason='ament_pep257 comes with apt').main


@pytest.mark.linter
@pytest.mark.pep257
def test_pep257():
    assert main(argv=['.', 'test']) == 0, 'Found code style errors / warnings'
