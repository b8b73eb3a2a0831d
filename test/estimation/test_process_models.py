# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Process models of tau_K: stiffness, noise growing with speed, load friction, its error."""
import itertools

from drives import driven, samples_of
import numpy as np
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.estimator import Estimator
from gearbox_monitor.estimation.process_model import noise, pack, state_names, TAU_K
from gearbox_monitor.parameters import EstimatorParameters, FILTER_NAMES
from gearbox_monitor.plant.drive import DriveModel, motor_friction
from gearbox_monitor.plant.simulate import Noise

LOADED = DriveModel().with_(effects=[{'id': 'load_friction', 'Cl': 0.2}])
OPTIONS = [dict(zip(('arm_load', 'tau_k_stiffness', 'q_std_tau_k_speed', 'friction_error_std'), v))
           for v in itertools.product(('none', 'unknown'), (0.0, 5.0), (0.0, 0.5), (0.0, 0.05))]
# Two encoders of 1 mrad on a drive with a wide gap.
NOISE = Noise((0.0, 0.0, 0.2, 0.2), (1e-3, 1e-3))


def packed(model=LOADED, **parameters):
    parameters = EstimatorParameters.from_mapping(parameters)
    model = model.with_(arm_load=parameters.arm_load)
    return pack(model, parameters), len(state_names(model, parameters))


def recorded(model, seconds=4.0, seed=0):
    """Return (Samples at 1 kHz, true tau_K [N])."""
    run = driven(model, seconds, NOISE, seed)
    return samples_of(run), run.tau_k


def test_friction_grows_with_the_load_either_way():
    p = LOADED.pack()
    for torque, speed in itertools.product((-5.0, 5.0), (-2.0, 2.0)):
        more = motor_friction(speed, torque, p) - motor_friction(speed, 0.0, p)
        assert more == pytest.approx(0.2 * 5.0 * np.sign(speed), rel=0.01)


def test_load_friction_needs_its_parameter():
    with pytest.raises(InputError, match='effects.load_friction.Cl: None, expected a number >= 0'):
        DriveModel().with_(effects=[{'id': 'load_friction'}])


def test_filter_with_load_friction_follows_such_a_plant():
    samples, tau_k = recorded(LOADED.with_(half_gap=0.3, stiffness=5.0))
    error = {}
    for name, model in (('without', DriveModel()), ('with', LOADED)):
        found = Estimator(model, {'arm_load': 'none', 'r_std_motor': 1e-3, 'r_std_arm': 1e-3,
                                  'q_std_motor_speed': 0.2, 'q_std_arm_speed': 0.2}).run(samples)
        error[name] = np.sqrt(np.mean((found.tau_k - tau_k[1:])[500:] ** 2))
    assert error['with'] < 0.8 * error['without']


def test_noise_grows_with_speed():
    p, n = packed(q_std_tau_k=3.0, q_std_tau_k_speed=2.0, arm_load='none')
    z = np.zeros(n)
    assert noise(z, p, TAU_K) == pytest.approx(9.0)
    z[2] = -2.0
    assert noise(z, p, TAU_K) == pytest.approx(9.0 + 16.0)
    z[2], z[3] = 0.0, 9.0
    assert [noise(z, p, i) for i in range(n)] == pytest.approx([0.0, 0.0, 0.16, 0.16, 9.0])


@pytest.mark.system
@pytest.mark.parametrize('name', [n for n in FILTER_NAMES if n != 'aekf'])
def test_every_filter_knows_every_process_model(name):
    """All filters agree on an almost linear drive, whatever the model of tau_K."""
    drive = DriveModel().with_(
        coulomb_friction=0.0, half_gap=0.3, stiffness=5.0)
    samples, _ = recorded(drive, 0.5)
    for options in (OPTIONS[0], OPTIONS[-1]):  # the fewest states and the most
        parameters = {**options, 'r_std_motor': 1e-3, 'r_std_arm': 1e-3, 'smoother_lag': 0.0}
        ekf, other = (Estimator(drive, {**parameters, 'filter': f}).run(samples)
                      for f in ('ekf', name))
        assert np.isfinite(other.rows[:, TAU_K]).all()
        np.testing.assert_allclose(other.tau_k, ekf.tau_k, atol=1e-5, err_msg=str(options))
        np.testing.assert_allclose(other.tau_k_std, ekf.tau_k_std, rtol=1e-5,
                                   err_msg=str(options))


def test_friction_error_makes_the_stated_deviation_honest():
    """A filter unaware of load friction understates its error; the state mends that."""
    samples, tau_k = recorded(LOADED.with_(half_gap=0.3, stiffness=5.0), 8.0)
    cover = []
    for std in (0.0, 0.5):
        found = Estimator(DriveModel().exact(), {
            'arm_load': 'none', 'r_std_motor': 1e-3, 'r_std_arm': 1e-3, 'q_std_tau_k': 4.0,
            'tau_k_stiffness': 4.0, 'friction_error_std': std,
            'friction_error_time': 0.1}).run(samples)
        cover.append(np.mean((np.abs(found.tau_k - tau_k[1:]) < found.tau_k_std)[500:]))
    assert cover[0] < 0.5 and 0.6 < cover[1]
    assert np.isfinite(found.tau_e).all() and np.all(found.tau_e_std < 0.5)
