# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The security policy is what the nodes need; nothing runs code of a file or of a message."""
import json
import os
from pathlib import Path
import subprocess
import sys
from xml.etree import ElementTree

from mcap.writer import Writer
import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import RecorderParameters
from gearbox_monitor.recordings.read import open_bag

SECURITY = Path(__file__).parents[2] / 'config/security'
KINDS = {('topics', 'publish'): 'get_publisher_names_and_types_by_node',
         ('topics', 'subscribe'): 'get_subscriber_names_and_types_by_node',
         ('services', 'reply'): 'get_service_names_and_types_by_node',
         ('services', 'request'): 'get_client_names_and_types_by_node'}


def allowed(text):
    """Return {(enclave, namespace, node): {(kind, verb): {full names}}} of a policy."""
    policy = ElementTree.fromstring(text)
    assert policy.get('version') == '0.2.0'
    found = {}
    for enclave in policy.findall('enclaves/enclave'):
        for profile in enclave.findall('profiles/profile'):
            namespace, node = profile.get('ns'), profile.get('node')
            rules = found[enclave.get('path'), namespace, node] = {kind: set() for kind in KINDS}
            for block in profile:
                (verb, word), = block.attrib.items()
                assert word == 'ALLOW'
                names = [item.text for item in block]
                full = {name if name.startswith('/') else f'{namespace.rstrip("/")}/{name}'
                        for name in (n.replace('~/', f'{node}/') for n in names)}
                assert len(full) == len(names), 'named twice'
                assert not full & rules[block.tag, verb]
                rules[block.tag, verb] |= full
    return found


def test_estimator_and_recorder_may_give_no_joints():
    for file in sorted(SECURITY.glob('*.xml')):
        for (_, _, node), rules in allowed(file.read_text(encoding='utf-8')).items():
            assert ('/joint_states' in rules['topics', 'publish']) == (node == 'plant')
            assert not rules['services', 'request']


def start_live(graph, enclave):
    """Start `gearbox_monitor live` in the namespace /elbow, in its enclave."""
    from processes import DOMAIN, ROOT
    process = subprocess.Popen(
        [sys.executable, '-m', 'gearbox_monitor', 'live', '--port', '0', '--ros-args',
         '--enclave', enclave, '-r', '__ns:=/elbow', '-p', 'use_sim_time:=true'],
        env={**os.environ, 'PYTHONPATH': str(ROOT), 'ROS_DOMAIN_ID': str(DOMAIN)},
        cwd=graph.tmp_path, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    graph.processes.append(process)
    return process


@pytest.mark.ros
@pytest.mark.parametrize('file, nodes', [
    ('policy.xml', ('plant', 'estimator', 'recorder', 'live')),
    ('robot_policy.xml', ('estimator', 'recorder', 'live'))])
def test_policy_is_what_the_nodes_use(file, nodes, tmp_path, monkeypatch):
    """In a namespace, as docs/security.md says; with all that follows a clock."""
    pytest.importorskip('rclpy')
    from diagnostic_msgs.msg import DiagnosticArray
    from harness import Graph
    text = (SECURITY / file).read_text(encoding='utf-8')
    policy = allowed(text.replace('ns="/"', 'ns="/elbow"'))
    assert [key[1:] for key in policy] == [('/elbow', node) for node in nodes]
    graph = Graph(tmp_path, monkeypatch)
    robot = file != 'policy.xml'
    names = ['estimator/shoulder', 'estimator/elbow'] if robot else ['estimator']
    recorded = [f'{name}/snapshot' for name in names]
    recorded += [t for t in RecorderParameters().topics if t != 'estimator/snapshot']
    options = {
        'plant': {'publish_clock': True, 'rate': 100.0}, 'estimator': {'use_sim_time': True},
        'recorder': {'use_sim_time': True, 'output': tmp_path / 'bag',
                     'topics': json.dumps(recorded)}}
    files = {'estimator': ['--params-file', tmp_path / 'robot.yaml']} if robot else {}
    (tmp_path / 'robot.yaml').write_text((SECURITY.parent / 'robot.yaml').read_text().replace(
        'estimator:', '/elbow/estimator:'))
    try:
        spoke = set()
        graph.node.create_subscription(
            DiagnosticArray, '/diagnostics', lambda m: spoke.update(s.name for s in m.status), 50)
        started = [start_live(graph, enclave) if node == 'live' else graph.start(
            f'{node}_node', '--enclave', enclave, '-r', '__ns:=/elbow', *files.get(node, ()),
            **options[node]) for enclave, _, node in reversed(policy)]

        def used():
            found = {}
            names = graph.node.get_node_names_and_namespaces_with_enclaves()
            for name, namespace, enclave in names:
                if name in nodes:
                    found[enclave, namespace, name] = {
                        kind: {topic for topic, _ in getattr(graph.node, ask)(name, namespace)}
                        for kind, ask in KINDS.items()}
            return found

        # All have been made: a node speaks when it is complete, the plant has a truth to tell.
        graph.until(lambda: {f'elbow/{names[-1]}: input', 'elbow/recorder: recording'} <= spoke
                    and (robot or graph.node.count_publishers('/elbow/plant/transmission_state')),
                    'start')
        try:
            graph.until(lambda: used() == policy, timeout=60.0)
        except AssertionError:
            assert used() == policy
        for process in started:
            graph.stop(process)
    finally:
        graph.close()


@pytest.mark.ros
def test_where_security_is_enforced_no_node_runs_without(tmp_path, monkeypatch):
    pytest.importorskip('rclpy')
    from harness import Graph
    for name, value in (('ENABLE', 'true'), ('STRATEGY', 'Enforce'), ('KEYSTORE', str(tmp_path))):
        monkeypatch.setenv(f'ROS_SECURITY_{name}', value)
    graph = Graph.__new__(Graph)  # the test's own node would be refused, too
    graph.tmp_path, graph.processes = tmp_path, []
    process = graph.start('recorder_node', '--enclave', '/gearbox_monitor/recorder')
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 2 and errors.startswith('recorder_node: ') and (
        'SECURITY ERROR' in errors) and errors.count('\n') == 1, errors
    assert not list(tmp_path.glob('gearbox_*'))


def test_definitions_in_a_bag_run_nothing(tmp_path, monkeypatch):
    monkeypatch.delitem(sys.modules, 'this', raising=False)
    for k, (msgtype, definition) in enumerate((
            ('evil/msg/A', 'string X="\'; import this; y=\'"\nuint8 a'),
            ('evil/msg/A', 'string X="""\\\nimport this\n"""\nuint8 a'),
            ('evil/msg/A', 'uint8 a=__import__("this")'),
            ('evil/msg/A', 'uint8[__import__("this").x] a'),
            ('evil/msg/A', 'uint8 a\n    import this'),
            ('evil/msg/A"""\nimport this\n"""', 'uint8 a'),
            ('evil/msg/A:\n  import this\nclass B', 'uint8 a'))):
        path = tmp_path / f'{k}.mcap'
        with open(path, 'wb') as file:
            writer = Writer(file)
            writer.start('ros2')
            schema = writer.register_schema(msgtype, 'ros2msg', definition.encode())
            channel = writer.register_channel('/a', 'cdr', schema)
            writer.add_message(channel, 1, b'\0\1\0\0\1', 1)
            writer.finish()
        with open_bag(path) as bag:
            for found, *_ in bag.topics.values():
                try:
                    bag.decode(found, b'\0\1\0\0\1')
                except InputError as error:
                    assert '\n' not in str(error)
        assert 'this' not in sys.modules, (msgtype, definition)


def test_a_type_on_the_graph_imports_only_messages(monkeypatch):
    pytest.importorskip('rclpy')
    from gearbox_monitor.ros.convert import import_message
    monkeypatch.delitem(sys.modules, 'this', raising=False)
    for msgtype in ('this/msg/A', 'json.tool/msg/A', '/msg/A', 'this', 'no_such_thing/msg/A'):
        with pytest.raises(ImportError):
            import_message(msgtype)
    assert 'this' not in sys.modules
    assert import_message('sensor_msgs/msg/JointState').__name__ == 'JointState'
