# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The library as a user imports it: from a file or arrays to results, and bad input in words."""
from html import escape

import numpy as np
import pytest

import gearbox_monitor as gm
from gearbox_monitor.diagnosis.joint import nominal
from gearbox_monitor.diagnosis.joint.nominal import Adapted
from gearbox_monitor.library.identify import uniform
from gearbox_monitor.plant.simulate import Noise
from gearbox_monitor.recordings.examples import ExampleMotion, write_example_bag, write_robot_pair

DT = 2e-3
MODEL = gm.DriveModel().with_(gear_ratio=-3.0, torque_constant=0.5)
TRUE = MODEL.with_(effects=[{'id': 'gravity', 'G': 1.5, 'phi': 0.0}])


@pytest.fixture(scope='module')
def trajectory():
    """Return 5 s of a drive with a weight that MODEL lacks."""
    t = np.arange(2500) * DT
    return gm.simulate(TRUE, 5 * np.cos(5.7 * t) + 2 * np.cos(14.5 * t), DT,
                       Noise(measurement=(2e-3, 1e-3)), 1)


def table(run, **changes):
    """Return the columns of a run, the torque as the current that makes it."""
    return {'t': run.t, 'torque': run.u / MODEL.torque_constant, 'motor': run.y[:, 0],
            'arm': run.y[:, 1], **changes}


@pytest.fixture(scope='module')
def verdict(trajectory):
    """Return the verdict on the recording."""
    whole = gm.load_recording(table(trajectory), MODEL, name='whole')
    return gm.diagnose(whole, MODEL, only=['gravity', 'arm_viscous'])


def test_every_source_gives_the_same_recording(trajectory, tmp_path):
    pd = pytest.importorskip('pandas')
    pytest.importorskip('pyarrow')
    columns = table(trajectory)
    frame = pd.DataFrame(columns)
    frame.rename(columns={'torque': 'u'}).to_csv(tmp_path / 'a.csv', index=False)
    frame.to_parquet(tmp_path / 'a.parquet')
    for source in (columns, frame, tmp_path / 'a.csv', str(tmp_path / 'a.parquet')):
        run = gm.load_recording(source, MODEL)
        for name in ('motor', 'arm', 't'):
            np.testing.assert_allclose(getattr(run, name), columns[name], atol=1e-12)
        np.testing.assert_allclose(run.torque, trajectory.u)  # N m, not A
        np.testing.assert_array_equal(run.with_model(gm.DriveModel()).torque,
                                      columns['torque'])
    assert gm.load_recording(tmp_path / 'a.csv', MODEL).name == str(tmp_path / 'a.csv')


def test_a_bag_is_read_again_for_another_gear_ratio(tmp_path):
    write_example_bag(tmp_path / 'bag', MODEL, ExampleMotion(5.0, 200.0, rest=0.5), 1)
    run = gm.load_recording(tmp_path / 'bag', MODEL)
    other = run.with_model(MODEL.with_(gear_ratio=6.0))
    np.testing.assert_allclose(other.motor, -0.5 * run.motor)
    np.testing.assert_allclose(other.torque, -2.0 * run.torque)
    np.testing.assert_array_equal(other.arm, run.arm)
    assert len(gm.estimate(run).stamp_ns) == len(run) - 1
    renamed = gm.load_recording(tmp_path / 'bag', MODEL, joints={'arm': ''})
    assert np.isnan(renamed.arm).all()
    assert np.isnan(gm.estimate(renamed).twist).all()


def test_verdict_shows_itself(verdict, tmp_path):
    finding, = verdict.findings
    assert finding.effect == 'gravity' and abs(finding.values['G'] - 1.5) < 0.01
    assert 0.0 < finding.deviations['phi'] < 0.01  # also of a phase near 0
    assert repr(verdict).startswith('Diagnosis(arm side: weight 1.')
    assert 'explains the whole difference' in ' '.join(str(verdict).split())
    assert '<td>gravity</td><td>arm_side</td><td>G</td>' in verdict._repr_html_()
    page = verdict.to_html(tmp_path / 'page.html')
    assert 'gravity' in page.read_text() and page == tmp_path / 'page.html'
    with pytest.raises(gm.InputError, match='File exists, expected a new, writable file'):
        verdict.to_html(page)
    closed = verdict.model.save(tmp_path / 'closed.yaml')
    assert gm.load_model(closed) == verdict.model != MODEL


def test_tables_have_the_values(verdict, trajectory):
    pytest.importorskip('pandas')
    rows = verdict.to_frame().set_index('parameter')
    assert rows.value['G'] == verdict.findings[0].values['G']
    run = gm.load_recording(trajectory, gm.DriveModel())
    est = gm.estimate(run)
    frame = est.to_frame()
    np.testing.assert_array_equal(frame.tau_k, est.tau_k)
    np.testing.assert_allclose(frame.t, est.t)
    late = frame.smoothed_tau_k.notna()  # all but the start, which has no estimate
    np.testing.assert_array_equal(frame.smoothed_tau_k[late], est.smoothed_tau_k[1:])
    assert list(run.to_frame()) == ['t', 'torque', 'motor', 'arm']


def test_backlash_stands_alone_in_each_window():
    t = np.arange(5000) * DT
    drive = gm.simulate(MODEL, 5 * np.cos(5.7 * t) + 2 * np.cos(14.5 * t), DT,
                        Noise(measurement=(2e-3, 1e-3)), 1)
    run = gm.load_recording(drive, MODEL.with_(gear_ratio=1.0, torque_constant=1.0))
    windows = gm.backlash(run, window=3.0)
    gap = 2.0 * TRUE.transmission.half_gap
    assert len(windows.fits) == 3 and windows.separable
    assert abs(windows.gap.value - gap) < 4.0 * windows.gap.std < 0.1 * gap
    np.testing.assert_allclose(windows.ends, [3.0, 6.0, 10.0], atol=0.5)


def test_a_notebook_shows_the_pages_of_results(verdict, trajectory, tmp_path):
    run = gm.load_recording(trajectory, gm.DriveModel())
    for result in (run, gm.estimate(run), gm.backlash(run, window=3.0),
                   verdict):
        written = result.to_html(tmp_path / f'{type(result).__name__}.html')
        page = written.read_text(encoding='utf-8')
        assert '<path class="' in page and f'srcdoc="{escape(page)}"' in result._repr_html_()
        assert escape(repr(result)) not in page and repr(result) not in page  # words, no code
    with pytest.raises(AttributeError, match='plot: gone since 0.3; to_html'):
        run.plot()


def test_a_recording_for_validation_is_read_for_the_model(verdict, trajectory):
    run = gm.load_recording(table(trajectory), gm.DriveModel(), name='twice the torque')
    again = gm.fit([run], verdict.model, ['Cv', 'Cc'], validate=run)
    assert again.gap_after < 1.2 and again.validation['gap_after'] < 1.2
    assert [v.name for v in again.values] == ['Cv', 'Cc']
    with pytest.raises(AttributeError):
        again.gap_after = 0.0


def test_adapt_keeps_values_that_are_more_likely_and_widens_their_tolerances(monkeypatch):
    t = np.arange(5000) * DT
    drive = gm.DriveModel()
    run = gm.load_recording(gm.simulate(drive, 5 * np.cos(5.7 * t) + 2 * np.cos(14.5 * t), DT,
                                        Noise(measurement=(2e-3, 1e-3)), 1), drive)
    tolerances = {'inertia_tolerance': (0.1, 0.3)}
    for inertia, kept in ((3.0 * drive.arm_inertia, True), (drive.arm_inertia, False)):
        monkeypatch.setattr(nominal, 'adapt', lambda *_, m2=inertia: Adapted(
            drive.with_(arm_inertia=m2), object(), tolerances, {}, {}, []))
        result = gm.adapt(run, drive, tau_k_model='random_walk')
        assert bool(result.kept) == kept == ('less likely' in ''.join(result.open))
        assert result.model == drive.with_(**(
            {'inertia_tolerance': 0.3} if kept else {'arm_inertia': inertia}))


def test_notes_name_their_recording_where_there_are_several(trajectory):
    columns = {**table(trajectory), 'setpoint': trajectory.t}
    first, second = (gm.load_recording(columns, MODEL, name=name) for name in ('run1', 'run2'))
    note = 'column setpoint is not used: the model has no controller'
    assert note in uniform(first, MODEL)[2]
    parts, validation, notes = uniform(first, MODEL, second)
    assert [part.name for part in parts] == ['run1'] and validation.name == 'run2'
    assert {f'run1: {note}', f'run2: {note}'} <= set(notes) and note not in notes


N = 600
T = np.arange(N) * 0.01
GOOD = {'t': T, 'torque': np.sin(T), 'motor': np.cos(T), 'arm': np.cos(T)}


BAD_COLUMNS = [
    ({'torque': np.sin(T)[:-1]}, r'torque: 599 values, expected 600 as of t'),
    ({'motor': np.column_stack([T, T])}, r'motor: shape \(600, 2\), expected one dimension'),
    ({'arm': ['a'] * N}, r"arm: list with 'a', expected numbers: position of the arm in rad"),
    ({'torque': np.full(N, np.nan)}, r'torque: nan in all 600 samples, expected torque in N m'),
    ({'motor': T * np.nan, 'arm': T * np.nan}, r'motor: nan in all 600 samples'),
    ({'t': np.where(T == 0.0, np.nan, T)}, r't: row 0: nan, expected a finite time in s'),
    ({'t': []}, r't: no value, expected some seconds'),
    ({'t': np.full(N, 'NaT', 'datetime64[s]')}, r't: row 0: NaT, expected a date'),
    ({'t': 3.0}, r't: one number \(3\), expected one dimension'),
    ({'torque': 1j * T}, r"torque: ndarray with '0j', expected numbers"),
    ({'u': T}, r'torque and u: both given, expected one of them')]


def test_bad_columns_are_named():
    for changes, message in BAD_COLUMNS:
        with pytest.raises(gm.InputError, match=message):
            gm.load_recording({**GOOD, **changes}, gm.DriveModel())


RUN = gm.load_recording(GOOD, gm.DriveModel())


BAD_CALLS = [
    (lambda: gm.DriveModel('drive.yaml'), "motor_inertia: 'drive.yaml', expected a number; lo"),
    (lambda: gm.DriveModel(transmission='rigid'), "transmission: 'rigid', expected Transmission"),
    (lambda: gm.DriveModel(effects='gravity'), "effects: 'gravity', expected tuple"),
    (lambda: gm.simulate(gm.DriveModel(damping=np.nan), T, DT), 'model: damping: nan, expected a'),
    (lambda: gm.simulate(gm.DriveModel(), T, DT, 0.1), 'noise: 0.1, expected a Noise'),
    (lambda: Noise(measurement=(np.nan, 0.0)), 'Noise: measurement: .* expected 2 finite values'),
    (lambda: gm.simulate(gm.DriveModel(), T, DT, seed=-1), 'seed: -1, expected a whole number'),
    (lambda: gm.DriveModel().save(None), "path: NoneType 'None', expected the path of a new"),
    (lambda: gm.load_model('no.yaml'), 'no.yaml: No such file'),
    (lambda: gm.load_model(3), "path: int '3', expected the path of a model file"),
    (lambda: gm.load_model('robot.xml'), r'robot.xml: the file of a simulator, expected joint'),
    (lambda: gm.load_recording('no.csv', gm.DriveModel()), 'no.csv: no such file'),
    (lambda: gm.load_recording('no.csv', 'drive.yaml'), "model: str 'drive.yaml', expected a Dri"),
    (lambda: gm.load_recording(T, gm.DriveModel()), 'source: ndarray'),
    (lambda: gm.load_recording({'t': T, 'q': T}, gm.DriveModel()), 'no column torque, motor or a'),
    (lambda: gm.load_recording(GOOD, gm.DriveModel(), joints={'art': 'b'}), "did you mean 'arm'"),
    (lambda: gm.load_recording(GOOD, gm.DriveModel(), joints='arm'), "joints: 'arm', expected na"),
    (lambda: gm.estimate('run1'), "recording: str 'run1', expected one recording"),
    (lambda: gm.estimate(RUN, tau_k_modell='mixed'), 'tau_k_modell'),
    (lambda: gm.estimate(RUN, parameters=3), "parameters: int '3', expected EstimatorParameters"),
    (lambda: gm.diagnose(['run1'], gm.DriveModel()), "recordings: 0: str 'run1', expected a rec"),
    (lambda: gm.diagnose([], gm.DriveModel()), 'recordings: none'),
    (lambda: gm.diagnose(RUN, gm.DriveModel(), only='gravity'), "only: 'gravity', expected a li"),
    (lambda: gm.diagnose(RUN, gm.DriveModel(), only=['gravty']), "did you mean 'gravity'"),
    (lambda: gm.diagnose(RUN, gm.DriveModel(), validate=[RUN, RUN]), 'validate: 0: list'),
    (lambda: gm.fit(RUN, gm.DriveModel(), validate='run2'), "validate: 0: str 'run2', expected a"),
    (lambda: gm.diagnose(RUN, gm.DriveModel(), jobs=0), 'jobs: 0, expected a whole nu'),
    (lambda: gm.diagnose(RUN, gm.DriveModel(), seed='a'), "seed: 'a', expected a whole number"),
    (lambda: gm.estimate(gm.load_recording({**GOOD, 't': T[::-1]}, gm.DriveModel())),
     'recording: no estimate of 600 samples'),
    (lambda: gm.backlash(gm.load_recording({**GOOD, 't': T[::-1]}, gm.DriveModel())),
     'recording: no estimate of 600 samples'),
    *((lambda free=free: gm.fit(RUN, gm.DriveModel(), free), f'free: {free!r}, expected a list')
      for free in ('Cv', 3)),
    (lambda: gm.simulate(gm.DriveModel(), [[1.0]], DT), r'u: shape \(1, 1\), expected one dim'),
    (lambda: gm.simulate(gm.DriveModel(), T * np.nan, DT), 'u: nan in sample 0'),
    (lambda: gm.simulate(gm.DriveModel(), T, '1 ms'), "dt: '1 ms', expected the length"),
    (lambda: gm.simulate('drive.yaml', T, DT), "model: str 'drive.yaml'"),
    (lambda: gm.Estimator('drive.yaml'), "model: str 'drive.yaml'"),
    (lambda: gm.Estimator(gm.DriveModel()).run(gm.Samples(np.arange(3), np.zeros(3),
                                                          np.zeros((3, 2)))),
     r'u: shape \(3,\), expected shape \(3, 2\)'),
    (lambda: gm.Estimator(gm.DriveModel()).run(GOOD), 'samples: dict'),
    (lambda: gm.Estimator(gm.DriveModel()).step(gm.Sample(1, ('a', 0.0), (0.0, 0.0))), 'sample: '),
    (lambda: gm.Estimator(gm.DriveModel(), 3), "parameters: int '3', expected EstimatorPara"),
    (lambda: gm.Estimator(gm.DriveModel()).set_parameters(3), "parameters: int '3'"),
]


def test_bad_arguments_are_named():
    for call, message in BAD_CALLS:
        with pytest.raises(gm.InputError, match=message):
            call()


def test_what_is_masked_or_never_measured_is_missing_and_said():
    torque = np.ma.masked_less(np.sin(T), 0.0)
    run = gm.load_recording({**GOOD, 'torque': torque, 'motor': T * np.nan}, gm.DriveModel())
    assert np.isnan(run.torque).sum() == torque.mask.sum() > 0
    assert run.notes == ('motor: nan in all samples, taken as not measured',)


def test_a_page_of_a_bag_is_written_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_example_bag('bag', MODEL, ExampleMotion(3.0, 200.0, rest=0.5), 1)
    MODEL.save('drive.yaml')
    pages = gm.write_report('bag', model='drive.yaml')
    assert str(pages.page) == 'bag.html' and pages.headline in pages.page.read_text()
    assert pages.figures['headline'] == pages.headline and not pages.pages
    for wrong, message in (({}, 'bag.html: exists'),
                           ({'filter': 'kalman', 'out': 'p.html'}, "filter: 'kalman'"),
                           ({'out': 'no/p.html'}, 'no such folder')):
        with pytest.raises(gm.InputError, match=message):
            gm.write_report('bag', model='drive.yaml', **wrong)


def test_a_setpoint_beyond_the_range_of_the_file_is_clipped_for_every_model(tmp_path):
    pytest.importorskip('mujoco')
    (tmp_path / 'arm.xml').write_text(
        '<mujoco><worldbody><body><joint name="elbow" axis="0 0 1" armature="0.01"/>'
        '<geom size=".1" mass="1"/></body></worldbody><actuator><position joint="elbow" kp="9" '
        'ctrllimited="true" ctrlrange="-0.5 0.5"/></actuator></mujoco>')
    model = gm.load_model(tmp_path / 'arm.xml', joint='elbow')
    run = gm.load_recording({'t': T, 'setpoint': np.sin(T), 'motor': 0.1 * T}, model)
    assert run.setpoint.max() == 0.5 and np.isnan(run.torque).all()
    assert any('lie beyond ctrlrange' in note for note in run.notes)
    other = run.with_model(model.with_(damping=0.5))  # no longer the one that was loaded
    np.testing.assert_array_equal(other.setpoint, run.setpoint)
    derived = model.with_(damping=0.5).with_values({'kp': 8.0})
    again = gm.load_recording({'t': T, 'setpoint': np.sin(T), 'motor': 0.1 * T}, derived)
    assert again.setpoint.max() == 0.5 and again.notes == run.notes
    assert 'origin' not in derived.to_dict() and derived != model
    with pytest.raises(gm.InputError, match='no column torque'):
        gm.load_recording({'t': T, 'setpoint': T, 'motor': T}, gm.DriveModel())


def test_robots_and_drives_are_not_confused(tmp_path):
    write_robot_pair(tmp_path / 'arm', 6.0, 1)
    robot = gm.load_robot(tmp_path / 'arm/robot.urdf')
    assert robot.joints == tuple(f'joint{k}' for k in range(1, 7))
    first, second = (gm.load_recording(tmp_path / f'arm/{name}.csv', robot)
                     for name in ('healthy', 'today'))
    assert (first.name, second.name) == ('healthy.csv', 'today.csv')
    for call, message in (
            (lambda: gm.diagnose(RUN, robot), 'logs: DriveRecording'),
            (lambda: gm.diagnose(RUN, gm.DriveModel(), reference='a'), 'reference: of a robot'),
            (lambda: gm.diagnose('a.csv', robot), 'a.csv: no such file'),
            (lambda: gm.diagnose('a.csv', robot, only=['paylod']), "'payload'"),
            (lambda: gm.load_recording('a.csv', robot, joints={'joint9': 'j'}), 'joint'),
            (lambda: gm.load_robot(tmp_path / 'a.csv'), r'expected an MJCF \(.xml\) or URDF')):
        with pytest.raises(gm.InputError, match=message):
            call()
