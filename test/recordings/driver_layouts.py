# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0


"""
More layouts of logs, of other drivers and tools than those of log_layouts.

Written from what the drivers' manuals say of names, units and order, before the first of them was
read; the numbers are the robot of log_layouts.
"""
from log_layouts import Layout, numbered, Robot, table
import numpy as np

TURN = 2.0 * np.pi


def _franka_ros(folder):
    r, names = Robot(7, 1000.0, seed=31), ['time']
    columns = [r.t]
    for name, values in (('tau_J', r.tau), ('tau_J_d', r.tau_desired), ('dtau_J', 10 * r.external),
                         ('q', r.q), ('q_d', r.setpoint), ('dq', r.dq), ('dq_d', r.dq_setpoint),
                         ('ddq_d', 0.5 * r.q), ('theta', r.q + r.tau / 1e4), ('dtheta', r.dq),
                         ('joint_contact', 0 * r.q), ('tau_ext_hat_filtered', r.external)):
        names += numbered(name + '{}', 7)
        columns += list(values.T)
    return Layout('franka_ros state', table(folder / 'franka_states.csv', names, columns), {
        'position': numbered('q{}', 7), 'velocity': numbered('dq{}', 7),
        'effort': numbered('tau_J{}', 7), 'setpoint': numbered('q_d{}', 7)})


def _ur_torque(folder):
    r, names, columns = Robot(6, 500.0, seed=32), ['timestamp'], [5000.0 + Robot(6, 500.0).t]
    for name, values in (('actual_q', r.q), ('actual_qd', r.dq), ('target_q', r.setpoint),
                         ('target_qdd', 0.4 * r.q), ('actual_current_as_torque', r.tau),
                         ('joint_mode', 253.0 + 0 * r.q), ('actual_TCP_force', r.external)):
        names += numbered(name + '_{}', 6)
        columns += list(values.T)
    names += ['safety_status', 'speed_scaling']
    columns += [1 + 0 * r.t, 1 + 0 * r.t]
    return Layout('UR RTDE, torque', table(folder / 'ur.csv', names, columns), {
        'position': numbered('actual_q_{}', 6), 'velocity': numbered('actual_qd_{}', 6),
        'effort': numbered('actual_current_as_torque_{}', 6),
        'setpoint': numbered('target_q_{}', 6)})


def _sunrise(folder):
    r, names = Robot(7, 500.0, seed=33), ['ZeitSec', 'ZeitNanoSec']
    ns = np.rint(r.t * 1e9).astype(int) + 1_650_000_000_000_000_000
    columns = [[str(n // 10 ** 9) for n in ns], [str(n % 10 ** 9) for n in ns]]
    robot = 'LBR_iiwa_7_R800_1'
    for name, values in (('axisQMsr', r.q), ('axisQCmd', r.setpoint), ('axisTauMsr', r.tau),
                         ('axisTauExtMsr', r.external)):
        names += numbered(f'{name}_{robot}[{{}}]', 7)
        columns += list(values.T)
    return Layout('Sunrise DataRecorder', table(folder / 'recording.log', names, columns, ' '), {
        'position': numbered(f'axisQMsr_{robot}[{{}}]', 7),
        'setpoint': numbered(f'axisQCmd_{robot}[{{}}]', 7),
        'effort': numbered(f'axisTauMsr_{robot}[{{}}]', 7)})


def _abb_egm(folder):
    r, names = Robot(6, 250.0, seed=34), ['header.seqno', 'header.tm']
    columns = [np.arange(len(r.t)) * 1.0, 81000.0 + r.t * 1e3]
    for name, values in (('feedBack.joints.joints', r.q), ('planned.joints.joints', r.setpoint)):
        names += numbered(name + '[{}]', 6)
        columns += list(np.rad2deg(values).T)
    names += ['motorState.state', 'utilizationRate']
    columns += [1 + 0 * r.t, 20 + r.q[:, 0]]
    return Layout('ABB EGM', table(folder / 'egm.csv', names, columns), {
        'position': numbered('feedBack.joints.joints[{}]', 6),
        'setpoint': numbered('planned.joints.joints[{}]', 6)}, {'position': 'deg'}, ('unit',),
        ('--unit', 'position=deg'))


def _fanuc(folder):
    r, names = Robot(6, 125.0, seed=35), ['Time[ms]']
    columns = [r.t * 1e3]
    for k in range(6):
        names += [f'J{k + 1} Actual Position[deg]', f'J{k + 1} Command Position[deg]',
                  f'J{k + 1} Motor Current[A]']
        columns += [np.rad2deg(r.q[:, k]), np.rad2deg(r.setpoint[:, k]), r.current[:, k]]
    return Layout('Fanuc', table(folder / 'fanuc.csv', names, columns), {
        'position': numbered('J{} Actual Position[deg]', 6, 1),
        'setpoint': numbered('J{} Command Position[deg]', 6, 1),
        'effort': numbered('J{} Motor Current[A]', 6, 1)},
        {'position': 'deg', 'setpoint': 'deg', 'effort': 'A'}, ('constant',),
        ('--torque-constant', '10'))


def _doosan(folder):
    r, names = Robot(6, 100.0, seed=36), ['time_stamp']
    columns = [r.t]
    for name, values in (('actual_joint_position', np.rad2deg(r.q)),
                         ('actual_joint_velocity', np.rad2deg(r.dq)),
                         ('target_joint_position', np.rad2deg(r.setpoint)),
                         ('actual_motor_torque', r.tau), ('external_joint_torque', r.external),
                         ('gravity_torque', 8.0 * np.sin(r.q)),
                         ('motor_temperature', 35 + 0 * r.q)):
        names += numbered(name + '[{}]', 6)
        columns += list(values.T)
    return Layout('Doosan RT', table(folder / 'doosan.csv', names, columns), {
        'position': numbered('actual_joint_position[{}]', 6),
        'velocity': numbered('actual_joint_velocity[{}]', 6),
        'setpoint': numbered('target_joint_position[{}]', 6),
        'effort': numbered('actual_motor_torque[{}]', 6)}, {'position': 'deg'}, ('unit',),
        ('--unit', 'position=deg'))


def _elmo(folder):
    r, counts = Robot(1, 1000.0, seed=37), 65536 * 50 / TURN
    names = ['Time [sec]', 'Position [cnt]', 'Position Command [cnt]', 'Velocity [cnt/sec]',
             'Active Current [A]', 'Total Current Command [A]']
    columns = [r.t, np.rint(r.q[:, 0] * counts), np.rint(r.setpoint[:, 0] * counts),
               np.rint(r.dq[:, 0] * counts), r.current[:, 0], r.current_desired[:, 0]]
    return Layout('Elmo recorder', table(folder / 'elmo.csv', names, columns), {
        'position': names[1:2], 'setpoint': names[2:3], 'velocity': names[3:4],
        'effort': names[4:5]}, {'position': 'counts', 'velocity': 'counts/s', 'effort': 'A'},
        ('counts', 'constant'), ('--counts-per-turn', '3276800', '--torque-constant', '2.0'))


def _odrive_can(folder):
    """Write decoded CAN messages: a row for each of them, blank where another one speaks."""
    r = Robot(1, 100.0, seed=38)
    names = ['time', 'axis0.Get_Encoder_Estimates.Pos_Estimate',
             'axis0.Get_Encoder_Estimates.Vel_Estimate', 'axis0.Get_Iq.Iq_Setpoint',
             'axis0.Get_Iq.Iq_Measured', 'axis0.Get_Torques.Torque_Target',
             'axis0.Get_Torques.Torque_Estimate']
    rows = []
    for k, t in enumerate(r.t):
        rows += [
            [f'{t:.6f}', f'{r.q[k, 0] / TURN:.8f}', f'{r.dq[k, 0] / TURN:.8f}', '', '', '', ''],
            [f'{t + 3e-4:.6f}', '', '', f'{r.current_desired[k, 0]:.6f}',
             f'{r.current[k, 0]:.6f}', '', ''],
            [f'{t + 6e-4:.6f}', '', '', '', '', f'{r.tau_desired[k, 0]:.6f}',
             f'{r.tau[k, 0]:.6f}']]
    return Layout('ODrive CAN', table(folder / 'can.csv', names, list(zip(*rows))), {
        'position': names[1:2], 'velocity': names[2:3], 'effort': names[6:7]},
        {'position': 'turns', 'velocity': 'turns/s'})


def _tview(folder):
    r = Robot(1, 200.0, seed=39)
    names = ['timestamp', 'servo_stats.mode', 'servo_stats.position', 'servo_stats.velocity',
             'servo_stats.torque_Nm', 'servo_stats.q_A', 'servo_stats.d_A', 'servo_stats.bus_V',
             'servo_stats.filt_bus_V', 'servo_control.position', 'servo_control.torque_Nm']
    columns = [1.7e9 + r.t, 10 + 0 * r.t, r.q[:, 0] / TURN, r.dq[:, 0] / TURN, r.tau[:, 0],
               r.current[:, 0], 0.01 * r.external[:, 0], 24 + 0 * r.t, 24 + 0 * r.t,
               r.setpoint[:, 0] / TURN, r.tau_desired[:, 0]]
    path = table(folder / 'tview.csv', names, [[f'{v:.6f}' for v in columns[0]], *columns[1:]])
    return Layout('moteus tview', path, {
        'position': names[2:3], 'velocity': names[3:4], 'effort': names[4:5],
        'setpoint': names[9:10]}, {'position': 'turns', 'velocity': 'turns/s'})


def _dynamixel_sdk(folder):
    r = Robot(1, 100.0, seed=40)
    names = ['time', 'goal_position', 'present_position', 'present_velocity', 'present_current',
             'present_input_voltage', 'present_temperature']
    columns = [r.t, np.rint(2048 + r.setpoint[:, 0] * 4096 / TURN),
               np.rint(2048 + r.q[:, 0] * 4096 / TURN),
               np.rint(r.dq[:, 0] * 60 / TURN / 0.229), np.rint(r.current[:, 0] * 1e3 / 2.69),
               120 + 0 * r.t, 35 + 0 * r.t]
    return Layout('Dynamixel SDK', table(folder / 'sdk.csv', names, columns), {
        'position': names[2:3], 'velocity': names[3:4], 'effort': names[4:5],
        'setpoint': names[1:2]}, {'position': 'counts'}, ('counts', 'constant'),
        ('--counts-per-turn', '4096', '--torque-constant', '0.003'))


def _arduino(folder):
    r = Robot(1, 100.0, seed=41)
    names = ['millis', 'target_deg', 'angle_deg', 'pwm']
    columns = [np.rint(1234 + r.t * 1e3), np.rad2deg(r.setpoint[:, 0]), np.rad2deg(r.q[:, 0]),
               np.rint(r.current[:, 0] * 100)]
    return Layout('Arduino', table(folder / 'serial.csv', names, columns), {
        'position': names[2:3], 'setpoint': names[1:2], 'effort': names[3:4]},
        {'position': 'deg', 'setpoint': 'deg'}, ('constant',), ('--torque-constant', '0.1'))


def _tmotor(folder):
    r = Robot(1, 200.0, seed=42)
    names = ['pi_time', 'output_angle', 'output_velocity', 'output_acceleration', 'current_qaxis',
             'output_torque']
    columns = [r.t, r.q[:, 0], r.dq[:, 0], 2.0 * r.q[:, 0], r.current[:, 0], r.tau[:, 0]]
    return Layout('T-Motor CAN', table(folder / 'tmotor.csv', names, columns), {
        'position': names[1:2], 'velocity': names[2:3], 'effort': names[5:6]}, {}, ('effort',),
        ('--use', 'effort=output_torque'))


def _unitree_sdk2(folder):
    joints = [f'{side}_{part}' for side in ('left', 'right')
              for part in ('hip_pitch', 'hip_roll', 'hip_yaw', 'knee', 'ankle_pitch')]
    r = Robot(len(joints), 500.0, seed=43)
    names, columns = ['timestamp'], [1.7e9 + r.t]
    for k, joint in enumerate(joints):
        names += [f'{joint}_q', f'{joint}_dq', f'{joint}_tau_est', f'{joint}_q_des']
        columns += [x[:, k] for x in (r.q, r.dq, r.tau, r.setpoint)]
    path = table(folder / 'g1.csv', names, [[f'{v:.6f}' for v in columns[0]], *columns[1:]])
    return Layout('Unitree SDK2', path, {
        'position': [f'{j}_q' for j in joints], 'velocity': [f'{j}_dq' for j in joints],
        'effort': [f'{j}_tau_est' for j in joints], 'setpoint': [f'{j}_q_des' for j in joints]})


def _spot(folder):
    joints = [f'{leg}.{part}' for leg in ('fl', 'fr', 'hl', 'hr') for part in ('hx', 'hy', 'kn')]
    r = Robot(12, 100.0, seed=44)
    ns = np.rint(r.t * 1e9).astype(int) + 1_680_000_000_900_000_000
    names = ['acquisition_timestamp.seconds', 'acquisition_timestamp.nanos']
    columns = [[str(n // 10 ** 9) for n in ns], [str(n % 10 ** 9) for n in ns]]
    for k, joint in enumerate(joints):
        names += [f'{joint}.{name}' for name in ('position', 'velocity', 'acceleration', 'load')]
        columns += [r.q[:, k], r.dq[:, k], 2.0 * r.q[:, k], r.tau[:, k]]
    return Layout('Spot joint states', table(folder / 'spot.csv', names, columns), {
        'position': [f'{j}.position' for j in joints],
        'velocity': [f'{j}.velocity' for j in joints], 'effort': [f'{j}.load' for j in joints]},
        {}, ('constant',), ('--torque-constant', '1'))


def _foxglove(folder):
    r, joints = Robot(3, 100.0, seed=45), ['waist', 'shoulder', 'elbow']
    ns = np.rint(r.t * 1e9).astype(int) + 1_700_000_000_000_000_000
    names = ['receiveTime', 'header.stamp.sec', 'header.stamp.nsec', 'header.frame_id',
             *numbered('name.{}', 3), *numbered('position.{}', 3), *numbered('velocity.{}', 3),
             *numbered('effort.{}', 3)]
    columns = [[f'{(n + 400_000) * 1e-9:.6f}' for n in ns], [str(n // 10 ** 9) for n in ns],
               [str(n % 10 ** 9) for n in ns], ['base'] * len(ns),
               *([joint] * len(ns) for joint in joints), *r.q.T, *r.dq.T, *r.tau.T]
    return Layout('Foxglove export', table(folder / 'joint_states.csv', names, columns), {
        name: numbered(f'{name}.{{}}', 3) for name in ('position', 'velocity', 'effort')})


def _bagpy(folder):
    r = Robot(3, 100.0, seed=46)
    ns = np.rint(r.t * 1e9).astype(int) + 1_600_000_000_000_000_000
    names = ['Time', 'header.seq', 'header.stamp.secs', 'header.stamp.nsecs', 'header.frame_id',
             'name', *numbered('position_{}', 3), *numbered('velocity_{}', 3),
             *numbered('effort_{}', 3)]
    columns = [[f'{(n + 350_000) * 1e-9:.7f}' for n in ns], [str(k) for k in range(len(ns))],
               [str(n // 10 ** 9) for n in ns], [str(n % 10 ** 9) for n in ns], [''] * len(ns),
               ['"[\'a\', \'b\', \'c\']"'] * len(ns), *r.q.T, *r.dq.T, *r.tau.T]
    return Layout('bagpy', table(folder / 'joint_states.csv', names, columns), {
        name: numbered(f'{name}_{{}}', 3) for name in ('position', 'velocity', 'effort')})


def _timetable(folder):
    r = Robot(2, seed=47)
    names = ['Time', 'q1', 'q2', 'qd1', 'qd2', 'tau1', 'tau2']
    columns = [[f'{t:g} sec' for t in r.t], *r.q.T, *r.dq.T, *r.tau.T]
    return Layout('MATLAB timetable', table(folder / 'timetable.csv', names, columns), {
        'position': names[1:3], 'velocity': names[3:5], 'effort': names[5:7]})


def _labview(folder):
    r = Robot(1, 1000.0, seed=48)
    head = ('LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\n'
            'Decimal_Separator\t.\nMulti_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\n'
            'Date\t2024/05/06\nTime\t10:11:12\n***End_of_Header***\t\n\t\nChannels\t3\t\t\t\n'
            'Samples\t700\t700\t700\t\nY_Unit_Label\tdeg\tdeg/s\tN-m\t\n'
            'X_Dimension\tTime\tTime\tTime\t\nX0\t0\t0\t0\t\nDelta_X\t0.001\t0.001\t0.001\t\n'
            '***End_of_Header***\t\t\t\t\n')
    names = ['X_Value', 'Position', 'Velocity', 'Torque', 'Comment']
    columns = [r.t, np.rad2deg(r.q[:, 0]), np.rad2deg(r.dq[:, 0]), r.tau[:, 0], [''] * len(r.t)]
    return Layout('LabVIEW lvm', table(folder / 'bench.lvm', names, columns, '\t', head), {
        'position': ['Position'], 'velocity': ['Velocity'], 'effort': ['Torque']},
        {'position': 'deg', 'velocity': 'deg/s'})


def _scope(folder):
    """Write an export with a time of its own beside each curve, ms."""
    r = Robot(1, 500.0, seed=49)
    curves = {'Axis1.ActPos': ('deg', np.rad2deg(r.q[:, 0])),
              'Axis1.SetPos': ('deg', np.rad2deg(r.setpoint[:, 0])),
              'Axis1.ActVelo': ('deg/s', np.rad2deg(r.dq[:, 0])),
              'Axis1.ActTorque': ('Nm', r.tau[:, 0])}
    lines = ['Name\tScope Project', 'File\tC:\\scope.svdx', 'Starttime of export\t133000000',
             'Endtime of export\t134000000', '']
    for key, value in (('Name', lambda n: n), ('SymbolComment', lambda n: ''),
                       ('Data-Type', lambda n: 'REAL64'), ('SampleTime[ms]', lambda n: '2'),
                       ('Unit', lambda n: curves[n][0])):
        lines.append('\t'.join(f'{key}\t{value(n)}' for n in curves))
    lines.append('')
    for k, t in enumerate(r.t):
        lines.append('\t'.join(f'{1e3 * t:.9g}\t{values[k]:.9g}'
                               for _, values in curves.values()))
    (folder / 'scope.csv').write_text('\n'.join(lines) + '\n')
    return Layout('TwinCAT scope', folder / 'scope.csv', {
        'position': ['Axis1.ActPos'], 'setpoint': ['Axis1.SetPos'],
        'velocity': ['Axis1.ActVelo'], 'effort': ['Axis1.ActTorque']},
        {'position': 'deg', 'velocity': 'deg/s'})


def _sigmawin(folder):
    r = Robot(1, 1000.0, seed=50)
    names = ['Time[ms]', 'Feedback Speed[min-1]', 'Speed Reference[min-1]', 'Torque Reference[%]',
             'Position Error[pulse]']
    columns = [r.t * 1e3, r.dq[:, 0] * 60 / TURN, r.dq_setpoint[:, 0] * 60 / TURN,
               r.current_desired[:, 0] * 30, np.rint((r.setpoint - r.q)[:, 0] * 1e4)]
    return Layout('SigmaWin trace', table(folder / 'sigma.csv', names, columns), {
        'velocity': names[1:2], 'effort': names[3:4]}, {'velocity': 'rpm', 'effort': '%'},
        ('constant',), ('--torque-constant', '0.033'))


def _long_table(folder):
    """Write a row for each joint of each sample."""
    r, joints = Robot(3, 100.0, seed=51), ['shoulder', 'elbow', 'wrist']
    (folder / 'long.csv').write_text('timestamp,joint_name,position,velocity,effort\n' + ''.join(
        f'{1.7e9 + t:.6f},{joint},{r.q[i, k]:.7f},{r.dq[i, k]:.7f},{r.tau[i, k]:.7f}\n'
        for i, t in enumerate(r.t) for k, joint in enumerate(joints)))
    return Layout('long table', folder / 'long.csv', {
        name: [name] * 3 for name in ('position', 'velocity', 'effort')})


def _two_topics(folder):
    """Write joint states beside what a controller says of the same joints, less often."""
    r, rows, joints = Robot(2, 500.0, seed=52), [], ['joint_a1', 'joint_a2']
    state = '/joint_trajectory_controller/controller_state'
    names = ['__time', *(f'/joint_states/{joint}/{name}' for joint in joints
                         for name in ('effort', 'position', 'velocity')),
             *(f'{state}/{part}/{joint}/{name}' for part in ('error', 'feedback', 'reference')
               for joint in joints for name in ('positions', 'velocities'))]
    for i, t in enumerate(r.t):
        rows.append([f'{1.7e9 + t:.6f}', *(f'{v[i, k]:.7f}' for k in (0, 1)
                                           for v in (r.tau, r.q, r.dq)), *[''] * 12])
        if i % 5 == 0:
            rows.append([f'{1.7e9 + t + 4e-4:.6f}', *[''] * 6, *(
                f'{v[i, k]:.7f}' for pair in ((r.setpoint - r.q, r.dq_setpoint - r.dq),
                                              (r.q, r.dq), (r.setpoint, r.dq_setpoint))
                for k in (0, 1) for v in pair)])
    return Layout('two topics', table(folder / 'pj.csv', names, list(zip(*rows))), {
        'position': [names[2], names[5]], 'velocity': [names[3], names[6]],
        'effort': [names[1], names[4]],
        'setpoint': [f'{state}/reference/{joint}/positions' for joint in joints]})


def _franka_ros2(folder):
    r, state = Robot(3, 500.0, seed=53), '/franka_robot_state_broadcaster/robot_state'
    joints, names, columns = numbered('fr3_joint{}', 3, 1), ['__time'], [
        [f'{1.7e9 + t:.6f}' for t in Robot(3, 500.0).t]]
    for part, values in (
            ('desired_joint_state', (r.tau_desired, r.setpoint, r.dq_setpoint)),
            ('measured_joint_motor_state', (0 * r.q, r.q + r.tau / 1e4, r.dq)),
            ('measured_joint_state', (r.tau, r.q, r.dq)), ('tau_ext_hat_filtered', (r.external,))):
        for k, joint in enumerate(joints):
            names += [f'{state}/{part}/{joint}/{name}' for name, _ in zip(
                ('effort', 'position', 'velocity'), values)]
            columns += [x[:, k] for x in values]
    return Layout('franka_ros2', table(folder / 'fr3.csv', names, columns), {
        name: [f'{state}/{part}_joint_state/{joint}/{column}' for joint in joints]
        for name, part, column in (
            ('position', 'measured', 'position'), ('velocity', 'measured', 'velocity'),
            ('effort', 'measured', 'effort'), ('setpoint', 'desired', 'position'))})


def _axis_letters(folder):
    r, axes = Robot(6, 250.0, seed=54), 'SLURBT'
    names, columns = ['time_ms'], [r.t * 1e3]
    for name, values in (('fb_angle_deg', np.rad2deg(r.q)), ('cmd_angle_deg',
                                                             np.rad2deg(r.setpoint)),
                         ('eff', r.tau)):
        names += [f'{axis}_{name}' for axis in axes]
        columns += list(values.T)
    return Layout('axes by letters', table(folder / 'axes.csv', names, columns), {
        'position': [f'{axis}_fb_angle_deg' for axis in axes],
        'setpoint': [f'{axis}_cmd_angle_deg' for axis in axes],
        'effort': [f'{axis}_eff' for axis in axes]}, {'position': 'deg', 'setpoint': 'deg'})


def _mujoco_motors(folder):
    """Write the torques of motors in the place of setpoints, and a base that is no joint."""
    r = Robot(4, 500.0, seed=55)
    np.savez(folder / 'run.npz', time=r.t, qpos=r.q, qvel=r.dq, ctrl=r.tau,
             base_pos=0.1 * r.setpoint[:, :3])
    return Layout('MuJoCo, motors', folder / 'run.npz', {
        'position': numbered('qpos {}', 4, 1), 'velocity': numbered('qvel {}', 4, 1),
        'effort': numbered('ctrl {}', 4, 1)}, {}, ('effort',), ('--use', 'effort=ctrl'))


LAYOUTS = (_franka_ros, _ur_torque, _sunrise, _abb_egm, _fanuc, _doosan, _elmo, _odrive_can,
           _tview, _dynamixel_sdk, _arduino, _tmotor, _unitree_sdk2, _spot, _foxglove, _bagpy,
           _timetable, _labview, _scope, _sigmawin, _long_table, _two_topics,
           _franka_ros2, _axis_letters, _mujoco_motors)
