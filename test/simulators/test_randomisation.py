# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Ranges of a population of drives: intervals with a known answer, and the texts made of them."""
import json

import numpy as np
import pytest
from scipy.stats import t as student
import yaml

import gearbox_monitor as gm
from gearbox_monitor.cli.main import main
from gearbox_monitor.diagnosis.joint.parameter_ranges import ranges_of, UnitEstimate
from gearbox_monitor.errors import InputError
from gearbox_monitor.library.ranges import ranges_yaml


def estimate(values, covariance, name='unit'):
    """Return a UnitEstimate with `covariance` of the logarithms."""
    size = np.array(list(values.values()))
    return UnitEstimate(name, values, dict.fromkeys(values, 'N m'),
                        np.asarray(covariance) * np.outer(size, size))


def population(count, seed, covariance, error=1e-3):
    """Return estimates of drives whose logarithms of Cc, Cv have a `covariance`."""
    draws = np.random.default_rng(seed).multivariate_normal([0.0, -1.0], covariance, count)
    return [estimate({'Cc': float(np.exp(a)), 'Cv': float(np.exp(b))}, error ** 2 * np.eye(2))
            for a, b in draws]


def test_interval_without_errors_is_students():
    values = np.array([1.0, 1.2, 0.9, 1.1, 1.05])
    found = ranges_of([estimate({'Cc': v}, [[0.0]]) for v in values])
    logs = np.log(values)
    reach = student.ppf(0.95, 4) * logs.std(ddof=1) * np.sqrt(1.2)
    assert np.log(found.low[0]) == pytest.approx(logs.mean() - reach, abs=1e-3)
    assert np.log(found.high[0]) == pytest.approx(logs.mean() + reach, abs=1e-3)
    assert found.between[0] == pytest.approx(logs.std(ddof=1), rel=1e-6)


def signed(values, error):
    """Return estimates of u0 with one `error`, N m."""
    return [UnitEstimate('unit', {'u0': v}, {'u0': 'N m'}, np.array([[error ** 2]]))
            for v in values]


def test_sign_of_an_offset_is_no_matter_of_the_sample():
    values = np.array([0.001, 0.02, 0.003])
    found = ranges_of(signed(values, 1e-5))
    reach = student.ppf(0.95, 2) * values.std(ddof=1) * np.sqrt(4 / 3)
    assert found.low[0] == pytest.approx(values.mean() - reach, rel=1e-2)
    assert found.logarithmic == (False,)


def test_drives_that_differ_by_more_than_a_large_error_have_that_range():
    values = np.array([0.1, 1.0, 0.01, 0.3])
    wide = ranges_of([estimate({'Cv': v}, [[0.35 ** 2]]) for v in values])
    sharp = ranges_of([estimate({'Cv': v}, [[1e-6]]) for v in values])
    assert 'not determined' in str(wide.combinations[0])
    assert np.log(wide.high / wide.low)[0] > 0.95 * np.log(sharp.high / sharp.low)[0]
    assert wide.between[0] == pytest.approx(np.sqrt(sharp.between[0] ** 2 - 0.35 ** 2), rel=1e-3)


def test_two_drives_show_no_correlation_and_equal_ones_no_difference():
    two = ranges_of([estimate({'Cc': a, 'Cv': b}, 1e-6 * np.eye(2))
                     for a, b in ((1.0, 0.1), (1.2, 0.13))])
    assert two.correlation[0, 1] == 0.0
    equal = ranges_of([estimate({'Cc': 1.0, 'Cv': 0.1}, 1e-4 * np.eye(2))] * 3)
    assert list(equal.between) == [0.0, 0.0]
    assert np.log(equal.high[0]) == pytest.approx(1.645 * 0.01 / np.sqrt(3), rel=0.01)


def test_parameter_at_zero_has_a_range_from_zero():
    found = ranges_of([UnitEstimate('unit', {'actuator_delay.T': v}, {}, np.array([[1e-8]]))
                       for v in (0.0, 0.001, 0.002)])
    assert (found.logarithmic, found.low[0]) == ((False,), 0.0)
    assert found.sample(500)['actuator_delay.T'].min() == 0.0


def test_one_estimate_has_the_range_of_its_error():
    found = ranges_of([UnitEstimate('a', {'u0': -0.2}, {'u0': 'N m'}, np.array([[0.01]]))])
    assert found.low[0] == pytest.approx(-0.2 - 0.16449, abs=2e-3)
    assert found.high[0] == pytest.approx(-0.2 + 0.16449, abs=2e-3)
    assert 'one estimate' in found.notes[0]


def test_errors_are_not_taken_for_differences_between_drives():
    rng = np.random.default_rng(3)
    same = [estimate({'Cc': float(np.exp(0.1 * rng.standard_normal()))}, [[0.01]])
            for _ in range(300)]
    found = ranges_of(same)
    assert found.between[0] < 0.05
    assert np.log(found.high[0] / found.low[0]) < 0.5 * 2 * 1.645 * 0.1


def test_large_error_of_one_estimate_counts_little():
    sure = [estimate({'Cc': v}, [[1e-4]]) for v in (1.0, 1.02, 0.98, 1.01)]
    found = ranges_of([*sure, estimate({'Cc': 2.0}, [[0.06]])])
    assert found.centre[0] == pytest.approx(1.0, abs=0.05)


def test_combination_is_said_and_drawn_along():
    along = np.array([1.0, 1.0]) / np.sqrt(2.0)
    covariance = np.outer(along, along) + 1e-4 * np.eye(2)
    units = [estimate({'m1': np.exp(d), 'Cc': np.exp(-d)}, covariance) for d in (-.1, 0., .1, .05)]
    found = ranges_of(units)
    assert len(found.combinations) == 1
    assert set(found.combinations[0].exponents) == {'m1', 'Cc'}
    assert found.combinations[0].deviation == pytest.approx(1.0, rel=0.01)
    drawn = found.sample(4000, seed=1)
    ratio, product = (np.log(f(drawn['m1'], drawn['Cc'])).std() for f in (np.divide, np.multiply))
    assert ratio < 0.4 < 1.2 < product  # four estimates do not average the open direction away
    assert len(yaml.safe_load(ranges_yaml(found))['known_only_in_combination']) == 1


def test_correlation_between_drives_is_drawn():
    strong = ranges_of(population(30, 0, 0.04 * np.array([[1.0, 0.9], [0.9, 1.0]])))
    drawn = strong.sample(5000, seed=2)
    r = np.corrcoef(np.log(drawn['Cc']), np.log(drawn['Cv']))[0, 1]
    assert r == pytest.approx(0.9, abs=0.1)
    none = ranges_of(population(6, 1, 0.04 * np.eye(2)))
    assert abs(none.correlation[0, 1]) < 0.35
    inside = (drawn['Cc'] > strong.low[0]) & (drawn['Cc'] < strong.high[0])
    assert inside.mean() == pytest.approx(0.9, abs=0.02)


def test_parameters_of_some_estimates_only_are_said():
    found = ranges_of([estimate({'Cc': 1.0}, [[0.01]]),
                       estimate({'Cc': 1.1, 'Cv': 1.0}, 0.01 * np.eye(2))])
    assert found.names == ('Cc',)
    assert any(note.startswith('Cv') for note in found.notes)


def test_coverage_of_new_drives_with_known_variances():
    rng, inside, count = np.random.default_rng(7), 0, 60
    for _ in range(count):
        truth = 0.1 * rng.standard_normal(7)
        found = ranges_of([estimate({'Cc': float(np.exp(t + 0.05 * rng.standard_normal()))},
                                    [[0.0025]]) for t in truth[:6]])
        inside += bool(found.low[0] < np.exp(truth[6]) < found.high[0])
    assert 0.8 < inside / count < 0.99


def written(path, value, error, name='Cc', unit='N m'):
    """Write what fit model writes as JSON."""
    path.write_text(json.dumps({
        'values': {name: {'unit': unit, 'start': 1.0, 'value': value, 'error': error,
                          'determined': True}}, 'covariance': [[error ** 2]]}))
    return str(path)


def fit_text(value=1.0, error=0.1, covariance=0.01, name='Cc', unit='N m'):
    """Return the JSON of a fit of one value."""
    return json.dumps({'values': {name: {'unit': unit, 'value': value, 'error': error}},
                       'covariance': [[covariance]]})


BAD_ESTIMATES = [
    (fit_text(-1.0), 'bad.json: Cc: -1, expected no negative number'),
    (fit_text(error=None), 'bad.json: values: Cc: no value, error'),
    (fit_text(error=-0.1), 'bad.json: values: Cc: no value, error'),
    (fit_text(value=True), 'bad.json: values: Cc: no value, error'),
    (fit_text(covariance=float('nan')), 'bad.json: Cc: 1.0 or its error is not finite'),
    (fit_text(covariance=-0.01), 'bad.json: covariance: neither symmetric nor positive'),
    (fit_text(value=5e-324), 'bad.json: Cc: 4.94066e-324 +- 0.1, expected an error'),
    (fit_text(unit='N'), 'Cc: N m in good.json, N in bad.json, expected one unit'),
    (fit_text(name='gain'), "bad.json: 'gain', expected the name of a value of a drive"),
    ('{"values": {"Cc": 1.0}}', 'bad.json: values: Cc: no value, error'),
    ('{"findings": []}', 'bad.json: no finding with values and deviations'),
    ('{"findings": ["x"]}', 'bad.json: findings: no effect, values and deviations'),
    ('{"findings": [{"effect": ["x"]}]}', 'bad.json: findings: no effect, values'),
    ('{"findings": [{"effect": "payload", "values": {}, "deviations": {}, "link": "tip"}]}',
     'bad.json: findings: of a robot, expected a verdict on a drive'),
    ('{"findings": [{"effect": "payload", "values": {}, "deviations": {}}]}',
     "bad.json: findings: effect: 'payload', expected the id of an effect"),
    ('{"accepted": true}', 'bad.json: neither values nor findings'),
    ('{', 'bad.json: no JSON')]


def test_bad_estimate_is_one_line(tmp_path, monkeypatch, capsys):
    for text, words in BAD_ESTIMATES:
        monkeypatch.chdir(tmp_path)
        written(tmp_path / 'good.json', 1.0, 0.1)
        (tmp_path / 'bad.json').write_text(text)
        assert main(['export', 'good.json', 'bad.json', '--to', 'yaml', '--ranges']) == 2
        shown = capsys.readouterr()
        assert words in shown.err
        assert (shown.err.count('\n'), shown.out) == (1, '')


def test_one_file_is_no_two_drives(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / 'a.json', 1.0, 0.1)
    assert main(['export', 'a.json', './a.json', '--to', 'yaml', '--ranges']) == 2
    assert 'a.json: named twice' in capsys.readouterr().err


def test_command_writes_two_drives_that_differ(tmp_path, capsys):
    files = [written(tmp_path / f'{i}.json', v, 0.01) for i, v in enumerate((1.0, 1.5, 1.2))]
    out = tmp_path / 'ranges.yaml'
    assert main(['export', *files, '--to', 'yaml', '--ranges', '--out', str(out)]) == 0
    data = yaml.safe_load(out.read_text())
    row = data['parameters']['Cc']
    assert row['low'] < 1.0 < 1.5 < row['high']
    assert row['distribution'] == 'lognormal'
    assert data['sources'] == files
    assert main(['export', files[0], '--to', 'yaml']) == 2
    assert 'expected it with --ranges' in capsys.readouterr().err


def test_sources_without_errors_are_refused(tmp_path):
    (tmp_path / 'a.json').write_text('{"values": {"Cc": {"value": 1.0}}}')
    with pytest.raises(InputError, match=r'a\.json: values'):
        gm.ranges([tmp_path / 'a.json'])
    one = written(tmp_path / 'b.json', 1.0, 0.1)
    with pytest.raises(InputError, match='in common'):
        gm.ranges([one, written(tmp_path / 'c.json', 1.0, 0.1, 'Cv')])
