# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Names of version 0.2 that a user may still type, and what to do without them.

`errors.unknown` looks them up, so that every command, option, parameter and key is refused in the
same words. The table goes with the release after 0.3.
"""
_ROBOT_MOTION = 'diagnose a log of the robot: its verdict lists what the motion did not visit'
_CLOSED = 'gearbox_monitor diagnose LOG --model ROBOT --out DIR writes the file of the robot'
_FORMATS = 'expected --to mjcf or --to urdf with --into FILE'
_FILTER = 'gearbox_monitor replay BAG --filter NAME states error and NIS of a filter'
_HELD = 'gearbox_monitor watch LOG --model robot.urdf states what a robot holds'
_FIRST = 'leave it out: of samples with one stamp the first counts, as in a replay'
# Name as the user types it, an option or its value after its command -> what to do instead.
REMOVED = {
    # commands
    'gearbox_monitor compile': 'leave it out: pip and colcon compile the kernels when they '
    'build the package',
    'gearbox_monitor benchmark': 'run benchmarks from a checkout: python -m benchmarks NAME',
    'gearbox_monitor compare': _FILTER,
    'gearbox_monitor simulate': 'gearbox_monitor diagnose BAG --model FILE --validate BAG2 states '
    'the gap of both models on another recording',
    'gearbox_monitor play': 'ros2 bag play BAG --clock --topics /joint_states publishes '
    'the inputs to live nodes',
    'gearbox_monitor adapt': 'gearbox_monitor fit unit BAG --model FILE --out FOLDER',
    'gearbox_monitor describe': 'gearbox_monitor check ROBOT',
    'gearbox_monitor fit-nominal': 'gearbox_monitor fit model BAG --model FILE',
    'gearbox_monitor suggest': 'gearbox_monitor diagnose BAG --model FILE -v prints next steps, '
    'with the motion that distinguishes effects',
    'gearbox_monitor tune': 'gearbox_monitor fit noise BAG --out FILE',
    # options and their values
    'fit --time-limit': 'timeout SECONDS gearbox_monitor fit ...',
    'accept --write-model': 'gearbox_monitor fit model BAG --model FILE --free K b --out FILE',
    'export --to sdf': _FORMATS,
    'export --to drake': _FORMATS,
    'export --to bam': _FORMATS,
    'export --to isaaclab': 'with --ranges expected --to isaac',
    'live --foxglove': 'connect Foxglove to foxglove_bridge, with the layout config/foxglove.json',
    'live --rerun': 'send the topics with a node of your own, or watch the page of live',
    'replay --csv': 'expected --out FILE.csv',
    'report --replay': 'leave it out: report runs the estimator as replay does',
    'check --setpoint-joint': 'expected --recorded-setpoint',
    'export --arm-joint': 'expected --model-arm-joint',
    **{f'diagnose --{old}': f'expected --{new}' for old, new in (
        ('motor-joint', 'recorded-motor'), ('arm-joint', 'recorded-arm'),
        ('setpoint-joint', 'recorded-setpoint'))},
    'diagnose --repeated': _FIRST,
    'fit --repeated': _FIRST,
    **{f'replay --{name}': _HELD for name in (
        'reference', 'values', 'root', 'recorded', 'prefix', 'convention', 'link', 'empty')},
    'gearbox_monitor payload_node': 'watch_node publishes payload: ros2 launch gearbox_monitor '
    'watch.launch.py',
    # parameters
    'keep_after_error': 'set keep_folder: each ERROR of backlash or friction is kept at once',
    'keep_per_hour': 'set keep_newest: so many recordings stay in keep_folder',
    'keep_space': 'set keep_newest: so many recordings stay in keep_folder',
    'other_publishers': 'two publishers of one joint are an ERROR: stop one or remap its topic',
    'ekf_jacobian': 'leave it out: the tangent is exact wherever the friction law has one',
    'srukf_precision': 'leave it out: the filter computes in float64',
    # endings of files
    '.sdf': 'convert it to URDF or MJCF',
    '.fmu': 'expected module:function, a Python function that runs the unit',
    # keys of mappings
    'format': 'the first bytes of a file say its format',
    'json': 'the list of entries is found',
    'field': 'column: NAME names a field, too: run.q, or run.q 2 for a column of a matrix',
    'second_file': 'put its columns, with their time, into the file: a signal has its own time',
    'missing': 'empty cells are not measured',
    'repeated': _FIRST,
    'unordered': 'stamps are kept as recorded',
    'start_stamp_ns': 'dates are kept, other times begin at 1 s',
    # names of the Python package
    'Filter': "Estimator(model, {'smoother_lag': 0.0}).step(sample) filters a sample",
    'load_robot_logs': 'load_recording(path, robot) returns the log of a robot',
    'suggest_robot': _ROBOT_MOTION,
    'SuggestedRobotMotion': _ROBOT_MOTION,
    'track_payload': _HELD,
    'PayloadTrack': _HELD,
    'verdict.json': _CLOSED,
    # BAGS and the folder of fleet
    '://': 'name a path: mount the archive, or copy it',
    'features/': 'choose a new --out, which gets one row per bag: its bags are analysed again',
    'bags.journal': 'choose a new --out: its bags are analysed again',
}


def refusal(word: object) -> str:
    """Return one line about the removed name `word`, '' if it was never a name."""
    advice = REMOVED.get(str(word))
    return f'gone since 0.3; {advice}' if advice else ''
