# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
The table of parameters: one truth for node declarations, YAML files, validation and docs.

Standard deviations of process noise are spectral: per square root of a second, so that the sample
rate can change without retuning.
"""
from dataclasses import dataclass
import math

from gearbox_monitor.errors import InputError, Problems, unknown
from gearbox_monitor.plant.excitation import KINDS as EXCITATIONS
from gearbox_monitor.ros.publishers import FOLLOW_FIRST, POLICIES

# When a change takes effect: at once; with a restart of the filter; or never while it runs.
AT_ONCE, RESTART, FIXED = 'at once', 'restart', 'fixed'


@dataclass(frozen=True)
class Parameter:
    """One row: `low` and `high` bound numbers, `choices` strings; `kind` is a Python type."""

    name: str
    default: object
    unit: str
    description: str
    low: float = -math.inf
    high: float = math.inf
    choices: tuple = ()
    change: str = FIXED

    @property
    def kind(self):
        """The type of the value: bool, int, float, str, or list (of str or float)."""
        return type(self.default)

    def check(self, value, source):
        """Return `value` in the parameter's type; raises InputError that names `source`."""
        if self.kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value) if abs(value) < 1 << 1000 else math.copysign(math.inf, value)
        if self.kind is list and isinstance(value, tuple):
            value = list(value)
        good = isinstance(value, self.kind) and (self.kind is not int or
                                                 not isinstance(value, bool))
        numbers = value if self.kind is list else [value]
        if good and all(isinstance(v, (int, float)) for v in numbers):
            good = all(self.low <= v <= self.high for v in numbers)
        if good and self.kind is list and self.default:
            of = type(self.default[0])
            good = all(isinstance(v, (int, float) if of is float else of) for v in value)
        if good and self.choices:
            good = value in self.choices
        if not good:
            raise InputError(f'{source}: {self.name}: {value!r}, expected {self.expected()}')
        return value

    def expected(self):
        """Return what a value must be, in words."""
        if self.choices:
            return 'one of ' + ', '.join(self.choices)
        word = {bool: 'true or false', int: 'a whole number', float: 'a number',
                str: 'a text', list: 'a list'}[self.kind]
        if self.kind is list:
            word += ' of numbers' if isinstance(self.default[0], float) else ' of texts'
        bounds = [f'>= {self.low:g}'] if self.low > -math.inf else []
        bounds += [f'<= {self.high:g}'] if self.high < math.inf else []
        unit = f' ({self.unit})' if self.unit not in ('', '-') else ''
        return ' '.join([word, ' and '.join(bounds)]).strip() + unit


FILTER_NAMES = ('ekf', 'ukf', 'srukf', 'aekf')

ESTIMATOR = (
    Parameter('filter', 'ekf', '', 'which filter estimates the torque', choices=FILTER_NAMES),
    Parameter('model', '', '', 'model file of the drive; empty for the packaged drive.yaml'),
    Parameter('motor_joint', 'motor', '', 'name of the motor in joint_states'),
    Parameter('arm_joint', 'arm', '', 'name of the arm in joint_states; empty: there is no arm '
              'encoder, then only the torque is estimated'),
    Parameter('arm_topic', '', '', 'topic of the arm encoder where it comes in messages of its '
              'own (sensor_msgs/JointState); may be joint_states; empty: with the motor'),
    Parameter('pair_tolerance', 0.0005, 's', 'with arm_topic: how far the stamps of motor and arm '
              'in one sample may be apart; less than half the sample period. At speed v they look '
              'like a twist of v times the distance', low=0.0, high=1.0),
    Parameter('other_publishers', FOLLOW_FIRST, '', 'when several publishers give our joints: '
              'take the messages of the first alone; take none until one is left; or accept all',
              choices=POLICIES),
    Parameter('gearbox_serial', 'gearbox', '', 'hardware_id in diagnostics'),
    Parameter('arm_load', 'unknown', '',
              'what acts on the arm besides effects of the model file: none, an unknown load '
              '(estimated), or a measured one (effort of the arm joint); "model" takes the word '
              'of the model file',
              choices=('none', 'unknown', 'measured', 'model')),
    Parameter('effort_delay', 0, 'samples',
              'effort stamped t_k acts on [t_k+d, t_k+d+1); -1: it acted on the sample before',
              low=-1, high=50),
    Parameter('max_gap', 0.25, 's', 'longest gap between stamps, without torque or without '
              'measurement, that is bridged by prediction; a longer one restarts the filter',
              low=1e-3, high=60.0),
    Parameter('smoother_lag', 0.1, 's', 'lag of the smoothed output; 0 switches it off',
              low=0.0, high=1.0),
    Parameter('r_std_motor', 5e-3, 'rad', 'noise of the motor encoder, arm side',
              low=1e-9, high=1e3, change=AT_ONCE),
    Parameter('r_std_arm', 5e-3, 'rad', 'noise of the arm encoder',
              low=1e-9, high=1e3, change=AT_ONCE),
    Parameter('q_std_motor_position', 0.0, 'rad/sqrt(s)', 'process noise of the motor position',
              low=0.0, high=1e6, change=AT_ONCE),
    Parameter('q_std_arm_position', 0.0, 'rad/sqrt(s)', 'process noise of the arm position',
              low=0.0, high=1e6, change=AT_ONCE),
    Parameter('q_std_motor_speed', 0.4, 'rad/s/sqrt(s)', 'process noise of the motor speed',
              low=0.0, high=1e6, change=AT_ONCE),
    Parameter('q_std_arm_speed', 0.4, 'rad/s/sqrt(s)', 'process noise of the arm speed',
              low=0.0, high=1e6, change=AT_ONCE),
    Parameter('q_std_tau_k', 8.0, 'N m/sqrt(s)', 'how fast tau_K may wander',
              low=0.0, high=1e9, change=AT_ONCE),
    Parameter('q_std_tau_k_speed', 0.0, 'N m/sqrt(s) per rad/s', 'how much more it may wander per '
              'motor speed, added to q_std_tau_k in quadrature', low=0.0, high=1e9,
              change=AT_ONCE),
    Parameter('q_std_tau_arm', 8.0, 'N m/sqrt(s)',
              'how fast the unknown load on the arm may wander', low=0.0, high=1e9,
              change=AT_ONCE),
    Parameter('tau_k_stiffness', 0.0, 'N m/rad', "k_p in tau_K' = k_p (x3 - x4) + w; 0 is the "
              "paper's random walk", low=0.0, high=1e12, change=AT_ONCE),
    Parameter('tau_k_model_std', 0.0, 'N m', 'error of the friction model, added to the stated '
              'standard deviation of tau_K in quadrature', low=0.0, high=1e9, change=AT_ONCE),
    Parameter('friction_error_std', 0.0, 'N m', 'standard deviation of a friction error carried '
              'as a state (Ornstein-Uhlenbeck); 0 leaves it out', low=0.0, high=1e9,
              change=RESTART),
    Parameter('friction_error_time', 0.7, 's', 'correlation time of that friction error',
              low=1e-4, high=1e4, change=RESTART),
    Parameter('p0_std_speed', 1.0, 'rad/s', 'standard deviation of the speeds at a start',
              low=1e-9, high=1e6, change=RESTART),
    Parameter('p0_std_torque', 5.0, 'N m', 'standard deviation of tau_K and load at a start',
              low=1e-9, high=1e9, change=RESTART),
    Parameter('ekf_jacobian', 'analytic', '', 'EKF: exact tangent of the discrete map, or forward '
              'differences', choices=('analytic', 'numeric'), change=AT_ONCE),
    Parameter('friction_linearisation', 'tangent', '', 'EKF: friction linearised at the estimate, '
              'or over the uncertainty of the motor speed', choices=('tangent', 'statistical'),
              change=AT_ONCE),
    Parameter('ukf_alpha', 1.0, '-', 'UKF, SRUKF: spread of the sigma points; small values cost '
              'accuracy', low=1e-4, high=10.0, change=AT_ONCE),
    Parameter('ukf_beta', 2.0, '-', 'UKF, SRUKF: weight of the centre in the covariance', low=0.0,
              high=100.0, change=AT_ONCE),
    Parameter('ukf_kappa', 0.0, '-', 'UKF, SRUKF: spread, added to the number of states', low=0.0,
              high=100.0, change=AT_ONCE),
    Parameter('srukf_precision', 'float64', '', 'SRUKF: precision of mean, sigma points and '
              'factor', choices=('float64', 'float32'), change=AT_ONCE),
    Parameter('adapt', ['q_std_tau_k', 'r_std_motor', 'r_std_arm'], '',
              'AEKF: what is adapted, starting from the values given: some of q_std_tau_k, '
              'r_std_motor, r_std_arm, viscous_friction, coulomb_friction, tau_k_stiffness; [""] '
              'for nothing', change=RESTART),
    Parameter('adapt_friction_sharpness', 1.0, 's/rad', 'AEKF: sharpness of the Coulomb friction '
              'that it computes with, at most that of the model', low=1e-3, high=1e9,
              change=RESTART),
    Parameter('adapt_forgetting_start', 0.995, '-', 'AEKF: forgetting factor per measured sample '
              'at a start', low=0.5, high=1.0, change=RESTART),
    Parameter('adapt_forgetting', 0.9998, '-', 'AEKF: forgetting factor that it settles at; '
              '1 / (1 - factor) samples count', low=0.5, high=1.0, change=RESTART),
    Parameter('adapt_forgetting_rate', 0.9995, '-', 'AEKF: how slowly it settles there: 1 / (1 - '
              'rate) samples', low=0.0, high=1.0, change=RESTART),
    Parameter('drift_window', 10.0, 's', 'length of a window that backlash is fitted on',
              low=0.5, high=600.0),
    Parameter('gap_notice', 0.005, '-', 'relative growth of the gap below which nothing is '
              'reported, however sure it is; a smaller one is left to seasons and wear-in',
              low=0.0, high=10.0, change=AT_ONCE),
    Parameter('gap_warn', 0.10, '-', 'relative growth of the gap from which a service is to be '
              'planned', low=0.0, high=10.0, change=AT_ONCE),
    Parameter('gap_error', 0.25, '-', 'relative growth of the gap that is an error, and the limit '
              'of the forecast', low=0.0, high=10.0, change=AT_ONCE),
    Parameter('gap_limit', 0.0, 'rad', 'gap that is an error whatever the baseline; 0: none',
              low=0.0, high=1e3, change=AT_ONCE),
    Parameter('stiffness_warn', 0.10, '-', 'relative loss of stiffness, or change of the torque '
              'gain, or growth of the hysteresis over the load, from which a service is to be '
              'planned', low=0.0, high=10.0, change=AT_ONCE),
    Parameter('stiffness_error', 0.25, '-', 'the same, as an error', low=0.0, high=10.0,
              change=AT_ONCE),
    Parameter('friction_warn', 0.20, '-', 'relative change of friction from which a service is to '
              'be planned; a quarter of it is reported once it is sure', low=0.0, high=10.0,
              change=AT_ONCE),
    Parameter('friction_error', 0.50, '-', 'the same, as an error', low=0.0, high=100.0,
              change=AT_ONCE),
    Parameter('false_alarm_interval', 3.15e7, 's', 'mean running time between two false alarms of '
              'backlash and friction together; shorter finds changes sooner', low=600.0, high=1e12,
              change=AT_ONCE),
    Parameter('baseline_file', '', '', 'backlash when healthy: read at the start, written by '
              '~/save_baseline; empty: the first windows are the baseline'),
    Parameter('baseline_windows', 720, '', 'how many trusted windows each operating point learns '
              'as healthy; 3 are enough to begin with', low=3, high=1000000, change=AT_ONCE),
    Parameter('angle_bin', 3.2, 'rad', 'windows whose mean arm angle is at most half of this away '
              'share a baseline; 0: all angles do', low=0.0, high=1e6, change=AT_ONCE),
    Parameter('speed_bin', 2.0, '-', 'windows whose rms motor speed is within the square root of '
              'this factor share a baseline; 1: all speeds do', low=1.0, high=1e6, change=AT_ONCE),
    Parameter('load_bin', 2.0, '-', 'the same for the rms of tau_K', low=1.0, high=1e6,
              change=AT_ONCE),
    Parameter('temperature_bin', 5.0, 'K', 'windows whose temperature is at most half of this '
              'away share a baseline; 0: all temperatures do', low=0.0, high=1e4, change=AT_ONCE),
    Parameter('temperature_topic', '', '', 'topic with the temperature of the gearbox '
              '(sensor_msgs/Temperature); empty: not known'),
    Parameter('drift_state_file', '', '', 'where baselines, test, alarms and what the aekf has '
              'adapted are kept over a restart, written after each window; empty: not kept'),
    Parameter('snapshot_period', 10.0, 's', 'how often the state is published for replay',
              low=0.1, high=3600.0),
    Parameter('model_gap_after', 60.0, 's', 'the model misses something when prediction errors '
              'were biased or not white in more than half of this time', low=5.0, high=3600.0,
              change=AT_ONCE),
    Parameter('keep_minutes', 5.0, 'min', 'how much of joint_states is kept in memory for '
              '~/keep_recording, 12 MB for 5 min at 1 kHz; 0: nothing', low=0.0, high=60.0),
    Parameter('keep_after_error', 0.0, 's', 'how long after backlash or friction became ERROR the '
              'recording is kept by itself, as by ~/keep_recording; no more than keep_minutes; '
              '0: never', low=0.0, high=3600.0),
    Parameter('keep_folder', '', '', 'where ~/keep_recording puts its folders; empty: where the '
              'node was started'),
)

# Values of the model file that can be changed while the estimator runs; their defaults are those
# of the model file (here: of the packaged one). Nothing else in it is both computed with and free.
MODEL = (
    Parameter('motor_inertia', 0.006442, 'kg m^2', 'of the motor, reflected to the arm side',
              low=1e-12, high=1e6, change=RESTART),
    Parameter('arm_inertia', 0.023454, 'kg m^2', 'of the arm', low=1e-12, high=1e6,
              change=RESTART),
    Parameter('damping', 0.01, 'N m s/rad', 'between motor and arm', low=0.0, high=1e9,
              change=RESTART),
    Parameter('viscous_friction', 0.1, 'N m s/rad', 'of the motor', low=-1e9, high=1e9,
              change=RESTART),
    Parameter('coulomb_friction', 0.27, 'N m', 'of the motor', low=0.0, high=1e9, change=RESTART),
    Parameter('friction_sharpness', 100.0, 's/rad', 'of the Coulomb friction around standstill',
              low=1e-9, high=1e9, change=RESTART),
    Parameter('position_gain', 0.01, 'N m/rad', 'of a position loop inside the drive', low=0.0,
              high=1e9, change=RESTART),
    Parameter('torque_offset', 0.0, 'N m', 'added to the commanded torque', low=-1e9, high=1e9,
              change=RESTART),
)
# All that a parameter file may give to the estimator.
SETTINGS = ESTIMATOR + MODEL


def with_values(model, values):
    """Return (the DriveModel `model` with the values of MODEL in `values`, the other values)."""
    names = {row.name for row in MODEL}
    changes = {name: value for name, value in values.items() if name in names}
    rest = {name: value for name, value in values.items() if name not in names}
    return model.with_(**changes) if changes else model, rest


def defaults(table):
    """Return {name: default} of `table`."""
    return {row.name: row.default for row in table}


def checked(table, values, source):
    """
    Return all parameters of `table` as a dict: `values` where given, defaults elsewhere.

    Raises InputError, naming `source`, for all unknown names, wrong types and values out of range.
    """
    rows, problems = {row.name: row for row in table}, Problems()
    result = defaults(table)
    for name, value in values.items():
        with problems:
            if name not in rows:
                raise InputError(f'{source}: {name}: unknown parameter, {unknown(name, rows)}')
            result[name] = rows[name].check(value, source)
    problems.raise_all()
    return result


# The parameters of the plant's model that can be changed while it runs; their defaults are the
# values of the model file (here: of the packaged one).
PLANT_MODEL = ('stiffness', 'half_gap', 'viscous_friction', 'coulomb_friction')

PLANT = (
    Parameter('model', '', '', 'model file of the drive; empty for the packaged drive.yaml'),
    Parameter('motor_joint', 'motor', '', 'name of the motor in joint_states'),
    Parameter('arm_joint', 'arm', '', 'name of the arm in joint_states'),
    Parameter('rate', 1000.0, 'Hz', 'samples per simulated second', low=100.0, high=2000.0),
    Parameter('speed', 1.0, '-', 'simulated seconds per second; 0: as fast as possible. Any other '
              'speed than 1 publishes /clock', low=0.0, high=1000.0),
    Parameter('publish_clock', False, '', 'publish /clock in real time, too'),
    Parameter('duration', 0.0, 's', 'simulated time after which the plant ends; 0: never',
              low=0.0, high=1e7),
    Parameter('wait_for_subscribers', 0, '', 'start once joint_states and the truth have this '
              'many subscribers together, and they have acknowledged the first sample', low=0,
              high=100),
    Parameter('seed', 0, '', 'seed of the noise', low=0, high=2**31 - 1),
    Parameter('torque_source', 'excitation', '', 'where the torque comes from: the excitation, or '
              'effort_command, held until the next one', choices=('excitation', 'topic')),
    Parameter('command_timeout', 0.5, 's', 'simulated time after which a torque from '
              'effort_command ends; 0: never', low=0.0, high=3600.0, change=AT_ONCE),
    Parameter('excitation', 'multisine', '', 'signal of the torque on the arm side',
              choices=EXCITATIONS, change=AT_ONCE),
    Parameter('amplitudes', [6.0, 2.0], 'N m', 'amplitudes of the excitation, arm side',
              low=-1e6, high=1e6, change=AT_ONCE),
    Parameter('frequencies', [0.9, 2.3], 'Hz', 'frequencies of the excitation', low=0.0,
              high=1000.0, change=AT_ONCE),
    Parameter('period', 20.0, 's', 'time of a chirp there and back', low=0.1, high=1e5,
              change=AT_ONCE),
    Parameter('process_noise', [0.0, 0.0, 0.4, 0.4], 'rad/sqrt(s), rad/s/sqrt(s)',
              'noise on motor and arm position, motor and arm speed', low=0.0, high=1e6,
              change=AT_ONCE),
    Parameter('measurement_noise', [0.005, 0.005], 'rad',
              'noise of motor (arm side) and arm encoder', low=0.0, high=1e3, change=AT_ONCE),
    Parameter('stiffness', 25.0, 'N m/rad', 'stiffness of the transmission in contact; default: '
              'model file', low=1e-9, high=1e12, change=AT_ONCE),
    Parameter('half_gap', 0.1, 'rad', 'half of the backlash before it grows; default: model file',
              low=0.0, high=1e3, change=AT_ONCE),
    Parameter('viscous_friction', 0.1, 'N m s/rad', 'of the motor; default: model file',
              low=-1e9, high=1e9, change=AT_ONCE),
    Parameter('coulomb_friction', 0.27, 'N m', 'of the motor; default: model file',
              low=0.0, high=1e9, change=AT_ONCE),
    Parameter('gap_growth_rate', 0.0, '1/s', 'the gap is half_gap (1 + rate (t - start))',
              low=0.0, high=1e3, change=AT_ONCE),
    Parameter('gap_growth_start', 0.0, 's', 'simulated time at which the gap begins to grow',
              low=0.0, high=1e7, change=AT_ONCE),
    Parameter('gap_growth_max', 10.0, '-', 'relative growth at which the gap stays',
              low=0.0, high=1e3, change=AT_ONCE),
    Parameter('fault_start', 0.0, 's', 'simulated time from which the faults below act', low=0.0,
              high=1e7, change=AT_ONCE),
    Parameter('fault_duration', 0.0, 's', 'how long they act; 0: for ever', low=0.0, high=1e7,
              change=AT_ONCE),
    Parameter('fault_frozen', 'none', '', 'encoders whose last reading stays',
              choices=('none', 'motor', 'arm', 'both'), change=AT_ONCE),
    Parameter('fault_lost', 'none', '', 'encoders that give nothing (NaN)',
              choices=('none', 'motor', 'arm', 'both'), change=AT_ONCE),
    Parameter('fault_delay', [0.0, 0.0], 's', 'readings of motor and arm come so late, in whole '
              'samples', low=0.0, high=1.0, change=AT_ONCE),
    Parameter('fault_scale', [1.0, 1.0], '-', 'readings of motor and arm over true position',
              low=-10.0, high=10.0, change=AT_ONCE),
    Parameter('fault_noise', [1.0, 1.0], '-', 'factor on measurement_noise of motor and arm',
              low=0.0, high=1e4, change=AT_ONCE),
    Parameter('fault_outlier_rate', [0.0, 0.0], '-', 'share of the readings of motor and arm that '
              'are outliers', low=0.0, high=1.0, change=AT_ONCE),
    Parameter('fault_outlier_size', [0.0, 0.0], 'rad', 'outliers of motor (arm side) and arm are '
              'off by this much, either way', low=0.0, high=1e3, change=AT_ONCE),
    Parameter('fault_torque', 1.0, '-', 'torque that acts over torque commanded', low=-10.0,
              high=10.0, change=AT_ONCE),
    Parameter('fault_viscous_friction', 1.0, '-', 'factor on viscous_friction', low=0.0,
              high=100.0, change=AT_ONCE),
    Parameter('fault_coulomb_friction', 1.0, '-', 'factor on coulomb_friction', low=0.0,
              high=100.0, change=AT_ONCE),
    Parameter('fault_stiffness', 1.0, '-', 'factor on stiffness', low=1e-3, high=100.0,
              change=AT_ONCE),
    Parameter('fault_gap', 1.0, '-', 'factor on the gap, all at once', low=0.0, high=100.0,
              change=AT_ONCE),
    Parameter('effects', [''], '', 'effects besides those of the model file, each a text like '
              '"stribeck Cs=0.1 vs=0.2", "" for none; ids and parameters: docs/effects.md',
              change=AT_ONCE),
    Parameter('load_gravity', 0.0, 'N m', 'load on the arm: G sin(arm position)',
              low=-1e6, high=1e6, change=AT_ONCE),
    Parameter('load_coulomb', 0.0, 'N m', 'load on the arm: Coulomb friction',
              low=0.0, high=1e6, change=AT_ONCE),
    Parameter('load_constant', 0.0, 'N m', 'load on the arm: a constant torque',
              low=-1e6, high=1e6, change=AT_ONCE),
    Parameter('measure_arm_load', False, '', 'give the load on the arm as effort of the arm '
              'joint; otherwise that is NaN', change=AT_ONCE),
)

RECORDER = (
    Parameter('output', 'gearbox_%Y_%m_%d-%H_%M_%S', '', 'bag directory to create, a pattern of '
              'strftime; it must not exist'),
    Parameter('topics', [
        'joint_states', 'paired_joint_states', 'transmission_state', 'transmission_state_stddev',
        'transmission_state_smoothed', 'innovations', 'innovations_stddev',
        'estimated_joint_states', '/diagnostics', 'drift_alerts', 'estimator/snapshot',
        'plant/transmission_state'], '', 'topics to record, of any type; relative names are in '
        'the namespace of the node'),
    Parameter('compression', 'zstd', '', 'compression of the bag',
              choices=('none', 'lz4', 'zstd')),
    Parameter('max_bag_size', 0, 'bytes', 'size of a file of the bag above which the next one '
              'begins; 0: no limit', low=0, high=10**15),
    Parameter('max_bag_duration', 0.0, 's', 'time of a file of the bag after which the next one '
              'begins; 0: no limit', low=0.0, high=1e9),
    Parameter('sync_period', 0.25, 's', 'time between two moments at which what was written is '
              'brought to the medium, against power cuts; 0: left to the operating system',
              low=0.0, high=60.0),
    Parameter('queue_depth', 4000, 'messages', 'messages that wait for the recorder, per topic; '
              '4000 are 4 s at 1 kHz', low=1, high=1_000_000),
    Parameter('low_space', 500, 'MB', 'free disk space below which to warn', low=0,
              high=1_000_000_000),
    Parameter('gearbox_serial', 'gearbox', '', 'hardware_id in diagnostics, not empty'),
)
