# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Tables of numbers as text: the digits of repr(), whatever the number."""
import numpy as np
import pytest

from gearbox_monitor.bag import number_text
from gearbox_monitor.bag.number_text import csv_rows

RNG = np.random.default_rng(6)
POWERS = 2.0 ** np.arange(-1074, 1024)
NUMBERS = {
    'any bits': RNG.integers(0, 1 << 64, 50_000, np.uint64).view(float),
    'estimates': RNG.normal(size=20_000),
    'few digits': np.round(RNG.normal(size=20_000) * 1e3, 2),
    'integers': np.round(RNG.normal(size=20_000) * 10.0 ** RNG.integers(0, 20, 20_000)),
    'short decimals': np.array([float(f'{RNG.integers(1, 1000)}e{RNG.integers(-325, 306)}')
                                for _ in range(20_000)]),
    'powers of two and their neighbours': np.concatenate(
        [POWERS, np.nextafter(POWERS, 0), np.nextafter(POWERS, np.inf), -POWERS]),
    'subnormal': RNG.integers(0, 1 << 40, 10_000).astype(np.uint64).view(float),
    'ends of the formats': np.array([
        0.0, -0.0, np.nan, -np.nan, np.inf, -np.inf, 1e15, 1e16, 9999999999999998.0, 1e22, 1e23,
        123456789012345680.0, 1e-4, 9.999e-5, 1e-5, 5e-324, 2.2250738585072014e-308, 0.1, 100.0]),
}


@pytest.mark.parametrize('kind', NUMBERS)
def test_digits_are_those_of_repr(kind):
    numbers = NUMBERS[kind]
    stamps = RNG.integers(-1 << 63, (1 << 63) - 1, len(numbers))
    text = csv_rows(stamps, [numbers, numbers[::-1]]).decode()
    assert text == ''.join(f'{stamp},{a!r},{b!r}\n' for stamp, a, b in zip(
        stamps.tolist(), numbers.tolist(), numbers[::-1].tolist()))


@pytest.mark.parametrize('compiled', [True, False])
def test_rows_without_numbers_and_without_rows(monkeypatch, compiled):
    monkeypatch.setattr(number_text, 'COMPILED', compiled and number_text.COMPILED)
    assert csv_rows(np.array([-1 << 63, 0]), [np.array([0.5, 1e-7])]) == (
        b'-9223372036854775808,0.5\n0,1e-07\n')
    assert csv_rows(np.empty(0, np.int64), [np.empty(0)]) == b''
