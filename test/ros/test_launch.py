# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The launch files: installed, readable, and with described arguments where launch is at hand."""
import importlib.util
from pathlib import Path
import runpy

import pytest
import setuptools

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / 'gearbox_monitor/ros/launch').glob('*.launch.py'))
# One gearbox each.
SINGLE = {'monitor.launch.py'}
NAMES = {*SINGLE, 'robot.launch.py', 'watch.launch.py'}


def test_are_installed(monkeypatch):
    given = {}
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(setuptools, 'setup', lambda **kwargs: given.update(kwargs))
    runpy.run_path(str(ROOT / 'setup.py'))
    installed = dict(given['data_files'])['share/gearbox_monitor/launch']
    assert {Path(name).name for name in installed} == NAMES == {path.name for path in FILES}
    scripts = given['entry_points']['console_scripts']
    executables = {entry.split('=')[0].strip() for entry in scripts}
    assert {'plant_node', 'estimator_node', 'recorder_node', 'gearbox_monitor'} <= executables


def test_compile():
    for path in FILES:
        compile(path.read_text(), str(path), 'exec')


def _load(name):
    pytest.importorskip('launch')
    pytest.importorskip('launch_ros')
    path = ROOT / 'gearbox_monitor/ros/launch' / name
    spec = importlib.util.spec_from_file_location('launched', path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _nodes(module, **values):
    """Return {executable: node} that the launch file starts with the arguments `values`."""
    from launch import LaunchContext
    context = LaunchContext()
    for argument in module.ARGUMENTS:
        default = ''.join(part.text for part in argument.default_value or ())
        context.launch_configurations[argument.name] = values.get(argument.name, default)
    return {node.node_executable: node for node in module._nodes(context)}


def test_arguments_are_described():
    for name in sorted(NAMES):
        module = _load(name)
        description = module.generate_launch_description()
        arguments = {a.name: a for a in description.get_launch_arguments()}
        wanted = {'use_sim_time', 'params_file', 'log_level'}
        if name in SINGLE:
            wanted |= {'namespace', 'model', 'filter'}
        assert wanted <= set(arguments)
        assert all(a.description and 'no description' not in a.description.lower()
                   for a in arguments.values())


def test_monitor_starts_what_is_asked_for():
    module = _load('monitor.launch.py')
    assert set(_nodes(module)) == {'estimator_node', 'recorder_node'}
    assert set(_nodes(module, record='false', plant='true', model='drive.yaml')) == {
        'estimator_node', 'plant_node'}


def test_watch_starts_an_arm_if_asked_for():
    module = _load('watch.launch.py')
    assert set(_nodes(module)) == {'watch_node'}
    assert set(_nodes(module, plant='true')) == {'watch_node', 'arm_plant_node'}


def test_robot_starts_one_estimator_for_all_gearboxes(tmp_path):
    module = _load('robot.launch.py')
    config = str(ROOT / 'config/robot.yaml')
    blocks = module.node_blocks(config)
    assert blocks == [('/', 'estimator', ('shoulder', 'elbow'))]
    topics = module.topics([*blocks, module.NodeBlock('/left', 'estimator', ())])
    assert {'/estimator/shoulder/snapshot', '/left/estimator/snapshot', '/left/drift_alerts',
            '/joint_states'} <= set(topics)
    assert topics.count('/diagnostics') == 1
    assert set(_nodes(module, params_file=config)) == {'estimator_node', 'recorder_node'}
    arm = tmp_path / 'arm.yaml'
    arm.write_text('{estimator: {}, arm_plant: {}}')
    assert set(_nodes(module, params_file=str(arm))) == {
        'arm_plant_node', 'estimator_node', 'recorder_node'}
    empty = tmp_path / 'empty.yaml'
    empty.write_text('estimators: {}')
    with pytest.raises(RuntimeError, match='no block estimator or /NAMESPACE/estimator'):
        module.node_blocks(str(empty))
    with pytest.raises(RuntimeError, match='nowhere.yaml.*expected a readable YAML'):
        module.node_blocks('nowhere.yaml')
