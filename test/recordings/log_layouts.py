# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Twenty layouts of logs as public drivers and tools write them, made from one motion.

Names, units and order of the columns are those of the drivers; the numbers are a simulated robot.
Each layout says which column is which role, and what nothing in the file can tell.
"""
from dataclasses import dataclass, field
import json

import numpy as np
import pyarrow as pa
from pyarrow import parquet

RATE, SAMPLES = 200.0, 500


@dataclass
class Robot:
    """A motion of `joints`: q, dq, tau, current, setpoint [N, J], N at `rate`."""

    joints: int
    rate: float = RATE
    samples: int = SAMPLES
    seed: int = 0

    def __post_init__(self):
        rng = np.random.default_rng(self.seed)
        self.t = np.arange(self.samples) / self.rate
        a = rng.uniform(0.3, 0.9, (2, self.joints))
        w = rng.uniform(1.5, 4.0, (2, self.joints)) * [[1.0], [2.3]]
        p = rng.uniform(0.0, 6.0, (2, self.joints))

        def _of(t, order):
            angle = w[:, None] * t[None, :, None] + p[:, None] + order * np.pi / 2
            return (a[:, None] * w[:, None] ** order * np.sin(angle)).sum(axis=0)
        noise = rng.standard_normal
        shape = (self.samples, self.joints)
        q, dq, ddq = (_of(self.t, k) for k in range(3))
        self.setpoint = _of(self.t + 0.02, 0)
        self.q = q + 2e-4 * noise(shape)
        self.dq = dq + 0.01 * noise(shape)
        self.dq_setpoint = _of(self.t + 0.02, 1)
        torque = 0.3 * ddq + 1.5 * dq + 2.0 * np.tanh(20 * dq) + 8.0 * np.sin(q)
        self.tau = torque + 0.1 * noise(shape)
        self.tau_model = 0.3 * ddq + 8.0 * np.sin(q)
        self.tau_desired = torque + 0.3 * np.sin(3.0 * q)
        self.external = 0.2 * noise(shape)
        self.current = torque / 10.0 + 0.02 * noise(shape)
        self.current_desired = torque / 10.0


@dataclass
class Layout:
    """
    A file or folder, and what is true of it.

    roles {quantity: names of the columns, in the order of the joints}; units {quantity: unit};
    open: topics that the file leaves open, each worth a question. options: what answers them.
    """

    name: str
    path: object
    roles: dict
    units: dict = field(default_factory=dict)
    open: tuple = ()
    options: tuple = ()


def table(path, names, columns, delimiter=',', head='', ending='\n', decimal='.'):
    """Write `columns` below `names`, of which there may be several rows."""
    rows = [names] if isinstance(names[0], str) else names
    lines = [delimiter.join(row) for row in rows if row]
    for row in zip(*columns):
        cells = [cell if isinstance(cell, str) else f'{cell:.9g}' for cell in row]
        lines.append(delimiter.join(cell.replace('.', decimal) if decimal != '.' else cell
                                    for cell in cells))
    path.write_text(head + ending.join(lines) + ending)
    return path


def numbered(form, count, first=0):
    """Return the names that `form` makes of the numbers from `first` on."""
    return [form.format(k) for k in range(first, first + count)]


def _ur_rtde(folder):
    r, names, columns = Robot(6, 125.0, seed=1), ['timestamp'], [1000.0 + Robot(6, 125.0).t]
    for name, values in (('target_q', r.setpoint), ('target_qd', r.dq_setpoint),
                         ('target_current', r.current_desired), ('target_moment', r.tau_model),
                         ('actual_q', r.q), ('actual_qd', r.dq), ('actual_current', r.current),
                         ('joint_temperatures', 30.0 + 0 * r.q),
                         ('actual_TCP_pose', 0.3 * r.q)):
        names += numbered(name + '_{}', 6)
        columns += list(values.T)
    return Layout('UR RTDE', table(folder / 'robot_data.csv', names, columns, ' '), {
        'position': numbered('actual_q_{}', 6), 'velocity': numbered('actual_qd_{}', 6),
        'setpoint': numbered('target_q_{}', 6), 'effort': numbered('actual_current_{}', 6)},
        {'effort': 'A'}, ('effort',), (
            '--use', 'effort=actual_current', '--torque-constant', '10,10.7,8.5,9,9.5,10.1'))


def _franka(folder):
    r, names = Robot(7, 1000.0, seed=2), ['duration', 'success rate']
    columns = [np.arange(SAMPLES) * 1.0, np.ones(SAMPLES)]
    for name, values in (('state.q', r.q), ('state.q_d', r.setpoint), ('state.dq', r.dq),
                         ('state.dq_d', r.dq_setpoint), ('state.tau_J', r.tau),
                         ('state.tau_ext_hat_filtered', r.external), ('cmd.q_d', r.setpoint),
                         ('cmd.tau_J_d', r.tau_desired)):
        names += numbered(name + '[{}]', 7)
        columns += list(values.T)
    return Layout('libfranka log', table(folder / 'franka.csv', names, columns), {
        'position': numbered('state.q[{}]', 7), 'velocity': numbered('state.dq[{}]', 7),
        'effort': numbered('state.tau_J[{}]', 7),
        'setpoint': (numbered('state.q_d[{}]', 7), numbered('cmd.q_d[{}]', 7))})


def _kuka_fri(folder):
    r = Robot(7, seed=3)
    ns = np.rint(r.t * 1e9).astype(int) + 1_700_000_000_250_000_000
    names = ['timestampSec', 'timestampNanoSec']
    columns = [[str(n // 10 ** 9) for n in ns], [str(n % 10 ** 9) for n in ns]]
    for name, values in (('measuredJointPosition', r.q), ('commandedJointPosition', r.setpoint),
                         ('measuredTorque', r.tau), ('commandedTorque', r.tau_desired),
                         ('externalTorque', r.external)):
        names += numbered(name + '{}', 7, 1)
        columns += list(values.T)
    return Layout('KUKA FRI', table(folder / 'fri.csv', names, columns), {
        'position': numbered('measuredJointPosition{}', 7, 1),
        'setpoint': numbered('commandedJointPosition{}', 7, 1),
        'effort': numbered('measuredTorque{}', 7, 1)})


def _kinova(folder):
    r, names = Robot(7, seed=4), ['timestamp_us']
    columns = [r.t * 1e6]
    for k in range(7):
        for name, values in (('position', np.rad2deg(r.q) % 360.0), ('velocity', np.rad2deg(r.dq)),
                             ('torque', -r.tau), ('current_motor', r.current),
                             ('voltage', 24.0 + 0 * r.q), ('temperature_motor', 35.0 + 0 * r.q)):
            names.append(f'actuators[{k}].{name}')
            columns.append(values[:, k])
    return Layout('Kinova Kortex', table(folder / 'kortex.csv', names, columns), {
        'position': numbered('actuators[{}].position', 7),
        'velocity': numbered('actuators[{}].velocity', 7),
        'effort': numbered('actuators[{}].torque', 7)}, {'position': 'deg', 'velocity': 'deg/s'})


def _xarm(folder):
    r = Robot(6, 100.0, seed=5)
    names, columns = ['time'], [1.7e9 + r.t]
    for name, values in (('angle_J', np.rad2deg(r.q)), ('speed_J', np.rad2deg(r.dq)),
                         ('torque_J', r.tau), ('current_J', r.current)):
        names += numbered(name + '{}', 6, 1)
        columns += list(values.T)
    path = table(folder / 'xarm.csv', names, [[f'{v:.6f}' for v in columns[0]], *columns[1:]])
    return Layout('xArm report', path, {
        'position': numbered('angle_J{}', 6, 1), 'velocity': numbered('speed_J{}', 6, 1),
        'effort': numbered('torque_J{}', 6, 1)}, {'position': 'deg'}, ('unit',),
        ('--unit', 'position=deg'))


def _dynamixel(folder):
    r = Robot(1, 100.0, seed=6)
    names = ['Time [ms]', 'Present Position [tick]', 'Present Velocity [0.229rpm]',
             'Present Current [2.69mA]', 'Present PWM [0.113%]', 'Goal Position [tick]']
    columns = [r.t * 1e3, np.rint(2048 + r.q[:, 0] * 4096 / 6.2831853),
               np.rint(r.dq[:, 0] * 60 / 6.2831853 / 0.229), np.rint(r.current[:, 0] * 1e3 / 2.69),
               np.rint(r.current[:, 0] * 300), np.rint(2048 + r.setpoint[:, 0] * 652)]
    return Layout('Dynamixel wizard', table(folder / 'dxl.csv', names, columns), {
        'position': names[1:2], 'velocity': names[2:3], 'effort': names[3:4],
        'setpoint': names[5:]}, {'position': 'counts', 'velocity': 'rpm', 'effort': 'mA'},
        ('counts', 'constant'), ('--counts-per-turn', '4096', '--torque-constant', '1.2'))


def _odrive(folder):
    r, turn = Robot(1, seed=7), 6.2831853
    names = ['time', 'axis0.pos_estimate', 'axis0.vel_estimate', 'axis0.controller.input_pos',
             'axis0.motor.foc.Iq_setpoint', 'axis0.motor.foc.Iq_measured', 'vbus_voltage']
    columns = [r.t, r.q[:, 0] / turn, r.dq[:, 0] / turn, r.setpoint[:, 0] / turn,
               r.current_desired[:, 0], r.current[:, 0], 24.0 + 0.1 * r.current[:, 0]]
    return Layout('ODrive', table(folder / 'odrive.csv', names, columns), {
        'position': names[1:2], 'velocity': names[2:3], 'setpoint': names[3:4],
        'effort': names[5:6]}, {'position': 'turns', 'velocity': 'turns/s', 'effort': 'A',
                                'setpoint': 'turns'},
        ('constant',), ('--torque-constant', '0.55'))


def _moteus(folder):
    r, turn = Robot(1, seed=8), 6.2831853
    names = ['timestamp', 'mode', 'position', 'velocity', 'torque', 'q_current', 'd_current',
             'abs_position', 'voltage', 'temperature', 'fault']
    columns = [r.t, 10 + 0 * r.t, r.q[:, 0] / turn, r.dq[:, 0] / turn, r.tau[:, 0],
               r.current[:, 0], 0.01 * r.external[:, 0], r.q[:, 0] / turn, 24 + 0 * r.t,
               30 + 0 * r.t, 0 * r.t]
    return Layout('moteus', table(folder / 'moteus.csv', names, columns), {
        'position': names[2:3], 'velocity': names[3:4], 'effort': names[4:5]},
        {'position': 'turns', 'velocity': 'turns/s'})


def _unitree(folder):
    r = Robot(12, 500.0, seed=9)
    names, columns = ['tick'], [1000 + r.t * 1e3]
    for k in range(12):
        for name, values in (('motor_state[{}].q', r.q), ('motor_state[{}].dq', r.dq),
                             ('motor_state[{}].tauEst', r.tau),
                             ('motor_state[{}].temperature', 30 + 0 * r.q),
                             ('motor_cmd[{}].q', r.setpoint), ('motor_cmd[{}].kp', 40 + 0 * r.q),
                             ('motor_cmd[{}].tau', 0 * r.q)):
            names.append(name.format(k))
            columns.append(values[:, k])
    names += ['imu.rpy[0]', 'imu.rpy[1]', 'imu.gyroscope[0]', 'footForce[0]']
    columns += [0.1 * r.q[:, 0], 0.1 * r.q[:, 1], r.dq[:, 2], 20 + r.tau[:, 1]]
    return Layout('Unitree low state', table(folder / 'go1.csv', names, columns), {
        'position': numbered('motor_state[{}].q', 12),
        'velocity': numbered('motor_state[{}].dq', 12),
        'effort': numbered('motor_state[{}].tauEst', 12),
        'setpoint': numbered('motor_cmd[{}].q', 12)})


def _lerobot(folder):
    joints = ['shoulder_pan', 'shoulder_lift', 'elbow_flex', 'wrist_flex', 'wrist_roll', 'gripper']
    r = Robot(6, 30.0, 300, seed=10)
    state, action = np.rad2deg(r.q), np.rad2deg(r.setpoint)
    episode = np.repeat([0, 1], 150)
    path = folder / 'data' / 'chunk-000' / 'episode_000000.parquet'
    path.parent.mkdir(parents=True)
    parquet.write_table(pa.table({
        'action': pa.array(action.astype(np.float32).tolist(), pa.list_(pa.float32())),
        'observation.state': pa.array(state.astype(np.float32).tolist(), pa.list_(pa.float32())),
        'timestamp': pa.array(np.tile(np.arange(150) / 30.0, 2).astype(np.float32)),
        'frame_index': np.tile(np.arange(150), 2), 'episode_index': episode,
        'index': np.arange(300), 'task_index': np.zeros(300, int)}), path)
    (folder / 'meta').mkdir()
    names = [f'{name}.pos' for name in joints]
    (folder / 'meta' / 'info.json').write_text(json.dumps({
        'codebase_version': 'v2.1', 'fps': 30, 'features': {
            'observation.state': {'dtype': 'float32', 'shape': [6], 'names': names}}}))
    return Layout('LeRobot', path, {
        'position': numbered('observation.state.{}', 6, 1),
        'setpoint': numbered('action.{}', 6, 1)},
        {'position': 'deg', 'setpoint': 'deg'}, ('unit',), ('--unit', 'position=deg'))


def _plotjuggler(folder):
    r, rows = Robot(2, seed=11), []
    names = ['__time', *(f'/joint_states/{joint}/{name}' for joint in ('elbow', 'wrist')
                         for name in ('effort', 'position', 'velocity')),
             '/arm_controller/state/desired/elbow/position',
             '/arm_controller/state/desired/wrist/position']
    for i, t in enumerate(r.t):
        values = [f'{v:.6f}' for k in (0, 1) for v in (r.tau[i, k], r.q[i, k], r.dq[i, k])]
        rows.append([f'{1.7e9 + t:.6f}', *values, '', ''])
        if i % 2:
            rows.append([f'{1.7e9 + t + 0.0007:.6f}', *[''] * 6, *map(str, r.setpoint[i])])
    return Layout('PlotJuggler', table(folder / 'pj.csv', names, list(zip(*rows))), {
        'position': [names[2], names[5]], 'velocity': [names[3], names[6]],
        'effort': [names[1], names[4]], 'setpoint': names[7:]})


def _ros2_csv(folder):
    r, joints = Robot(3, 100.0, seed=12), ['elbow_joint', 'shoulder_lift_joint', 'wrist_1_joint']
    ns = np.rint(r.t * 1e9).astype(int) + 1_700_000_000_000_000_000
    lines = [','.join([str(n // 10 ** 9), str(n % 10 ** 9), 'base_link', *joints, *(
        f'{v:.9g}' for v in (*r.q[k], *r.dq[k], *r.tau[k]))]) for k, n in enumerate(ns)]
    (folder / 'echo.csv').write_text('\n'.join(lines) + '\n')
    return Layout('ros2 topic echo --csv', folder / 'echo.csv', {
        name: [f'{name} {joint}' for joint in joints]
        for name in ('position', 'velocity', 'effort')})


def _sage(folder):
    r, text = Robot(6, 50.0, seed=13), folder / 'multisine'
    text.mkdir()

    def _list(row):
        return '"[' + ', '.join(f'{v:.6f}' for v in row) + ']"'
    micros = r.t * 1e6 + 4.97
    head = 'type,timestamp,positions,velocities,torques\n'
    (text / 'state_motor.csv').write_text(head + ''.join(
        f'STATE_MOTOR,{micros[k]:.6f},{_list(r.q[k])},{_list(r.dq[k])},{_list(r.tau[k])}\n'
        for k in range(SAMPLES)))
    (text / 'control.csv').write_text('type,timestamp,positions\n' + ''.join(
        f'CONTROL,{micros[k]:.6f},{_list(r.setpoint[k])}\n' for k in range(SAMPLES)))
    (text / 'event.csv').write_text('type,timestamp,event\nEVENT,0,MOTION_START\n')
    return Layout('SAGE', text, {
        'position': numbered('positions.{}', 6, 1), 'velocity': numbered('velocities.{}', 6, 1),
        'effort': numbered('torques.{}', 6, 1), 'setpoint': numbered('positions.{}', 6, 1)})


def _legged(folder):
    r = Robot(12, 50.0, seed=14)
    legs = [f'{leg}_{part}_joint' for leg in ('FL', 'FR', 'RL', 'RR')
            for part in ('hip', 'thigh', 'calf')]
    np.savez(folder / 'legged.npz', dof_pos=r.q, dof_vel=r.dq, dof_pos_target=r.setpoint,
             torques=r.tau, base_vel=r.dq[:, :3], dof_names=np.array(legs))
    return Layout('legged gym', folder / 'legged.npz', {
        'position': numbered('dof_pos {}', 12, 1), 'velocity': numbered('dof_vel {}', 12, 1),
        'effort': numbered('torques {}', 12, 1), 'setpoint': numbered('dof_pos_target {}', 12, 1)},
        {}, ('time',), ('--rate', '50'))


def _aloha(folder):
    import h5py
    r = Robot(7, 50.0, seed=15)
    with h5py.File(folder / 'episode_0.hdf5', 'w') as file:
        file['action'] = r.setpoint
        for name, values in (('qpos', r.q), ('qvel', r.dq), ('effort', r.tau)):
            file[f'observations/{name}'] = values
    return Layout('ALOHA', folder / 'episode_0.hdf5', {
        'position': numbered('observations.qpos {}', 7, 1),
        'velocity': numbered('observations.qvel {}', 7, 1),
        'effort': numbered('observations.effort {}', 7, 1),
        'setpoint': numbered('action {}', 7, 1)}, {}, ('time',), ('--rate', '50'))


def _rostopic(folder):
    r, joints = Robot(3, 100.0, seed=16), ['joint_a', 'joint_b', 'joint_c']
    ns = np.rint(r.t * 1e9).astype(int) + 1_600_000_000_000_000_000
    names = ['%time', 'field.header.seq', 'field.header.stamp', 'field.header.frame_id',
             *numbered('field.name{}', 3), *numbered('field.position{}', 3),
             *numbered('field.velocity{}', 3), *numbered('field.effort{}', 3)]
    columns = [[str(n + 350_000) for n in ns], np.arange(SAMPLES), [str(n) for n in ns],
               [''] * SAMPLES, *([name] * SAMPLES for name in joints), *r.q.T, *r.dq.T, *r.tau.T]
    return Layout('rostopic echo -p', table(folder / 'rostopic.csv', names, columns), {
        name: numbered(f'field.{name}{{}}', 3) for name in ('position', 'velocity', 'effort')})


def _twincat(folder):
    r = Robot(2, seed=17)
    names = [['Name', *(f'Axis {k}' for k in (1, 2) for _ in range(4))],
             ['Time', *['ActPos', 'SetPos', 'ActVelo', 'ActTorque'] * 2],
             ['[ms]', *['°', '°', '°/s', 'Nm'] * 2]]
    columns = [r.t * 1e3]
    for k in (0, 1):
        columns += [np.rad2deg(r.q[:, k]), np.rad2deg(r.setpoint[:, k]), np.rad2deg(r.dq[:, k]),
                    r.tau[:, k]]
    names[0] = ['', 'Axis 1', '', '', '', 'Axis 2', '', '', '']
    path = table(folder / 'scope.csv', names, columns, ';', decimal=',')
    return Layout('drive scope', path, {
        'position': ['Axis 1 ActPos', 'Axis 2 ActPos'],
        'setpoint': ['Axis 1 SetPos', 'Axis 2 SetPos'],
        'velocity': ['Axis 1 ActVelo', 'Axis 2 ActVelo'],
        'effort': ['Axis 1 ActTorque', 'Axis 2 ActTorque']},
        {'position': 'deg', 'velocity': 'deg/s', 'effort': 'N m'})


def _simplefoc(folder):
    r = Robot(1, 100.0, seed=18)
    names = ['Time [ms]', 'Target', 'Voltage Q', 'Voltage D', 'Current Q', 'Current D', 'Velocity',
             'Angle']
    columns = [r.t * 1e3, r.setpoint[:, 0], 3 * r.current[:, 0], 0.1 * r.external[:, 0],
               r.current[:, 0], 0.02 * r.external[:, 0], r.dq[:, 0], r.q[:, 0]]
    return Layout('SimpleFOC', table(folder / 'foc.csv', names, columns, '\t'), {
        'position': ['Angle'], 'velocity': ['Velocity'], 'effort': ['Current Q'],
        'setpoint': ['Target']}, {'effort': 'A'}, ('constant',), ('--torque-constant', '0.1'))


def _epos(folder):
    r = Robot(1, 1000.0, seed=19)
    names = ['Time [ms]', 'Position actual value [inc]', 'Position demand value [inc]',
             'Velocity actual value averaged [rpm]', 'Current actual value averaged [mA]',
             'Following error actual value [inc]']
    counts = 4 * 500 * 74 / 6.2831853
    columns = [r.t * 1e3, np.rint(r.q[:, 0] * counts), np.rint(r.setpoint[:, 0] * counts),
               r.dq[:, 0] * 74 * 60 / 6.2831853, r.current[:, 0] * 1e3,
               np.rint((r.setpoint - r.q)[:, 0] * counts)]
    return Layout('EPOS recorder', table(folder / 'epos.csv', names, columns, ';'), {
        'position': names[1:2], 'setpoint': names[2:3], 'velocity': names[3:4],
        'effort': names[4:5]}, {'position': 'counts', 'velocity': 'rpm', 'effort': 'mA'},
        ('counts', 'constant'), ('--counts-per-turn', '148000', '--torque-constant', '2.6'))


def _pendulum_bench(folder):
    """Write two joints, each with a filtered copy, a commanded torque and parts of it."""
    r, names, columns = Robot(2, 500.0, seed=20), ['time'], [Robot(2, 500.0).t]

    def _low_pass(values):
        filtered = values.copy()
        for k in range(1, len(values)):
            filtered[k] = filtered[k - 1] + 0.15 * (values[k] - filtered[k - 1])
        return filtered
    for name, values in (('pos_meas', r.q), ('vel_meas', r.dq), ('pos_filt', _low_pass(r.q)),
                         ('vel_filt', _low_pass(r.dq)), ('tau_con', r.tau_desired),
                         ('tau_fric', r.tau - r.tau_model), ('tau_meas', r.tau)):
        names += numbered(name + '{}', 2, 1)
        columns += list(values.T)
    return Layout('pendulum bench', table(folder / 'bench.csv', names, columns), {
        'position': names[1:3], 'velocity': names[3:5], 'effort': names[13:15]})


LAYOUTS = (_ur_rtde, _franka, _kuka_fri, _kinova, _xarm, _dynamixel, _odrive, _moteus, _unitree,
           _lerobot, _plotjuggler, _ros2_csv, _sage, _legged, _aloha, _rostopic, _twincat,
           _simplefoc, _epos, _pendulum_bench)
