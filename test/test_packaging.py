# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The package's files agree with each other, and an installed copy finds what it needs."""
import ast
from importlib import import_module
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest
from sources import nodes, ROOT

import gearbox_monitor
from gearbox_monitor.cli.main import COMMANDS, main

XML = ElementTree.parse(ROOT / 'package.xml').getroot()
SETUP = (ROOT / 'setup.py').read_text(encoding='utf-8')
# imported name -> (key in package.xml or None, distribution in setup.py or None = from ROS).
THIRD_PARTY = {
    'distributed': (None, 'distributed'),  # optional; it and the next have no rosdep key
    'h5py': (None, 'h5py'),
    'pandas': (None, 'pandas'),  # optional: tables of results
    'filterpy': (None, 'filterpy'),  # of tests
    'bam': (None, 'better-actuator-models'),  # optional: runs beside ours; no rosdep key
    'google': (None, None),
    'jinja2': ('python3-jinja2', 'Jinja2'),
    'lz4': ('mcap-ros2-support', 'mcap'),
    'markupsafe': ('python3-jinja2', 'Jinja2'),  # a dependency of it
    'mcap': ('mcap-ros2-support', 'mcap'),
    'mujoco': (None, 'mujoco'),  # optional: the extra that reads and checks its files
    'numpy': ('python3-numpy', 'numpy'),
    'pyarrow': (None, 'pyarrow'),  # no rosdep key
    'rosbags': ('python3-rosbags-pip', 'rosbags'),
    'scipy': ('python3-scipy', 'scipy'),
    'tqdm': ('python3-tqdm', 'tqdm'),
    'yaml': ('python3-yaml', 'PyYAML'),
    'zstandard': ('mcap-ros2-support', 'mcap'),
    **{name: (name, None) for name in (
        'builtin_interfaces', 'diagnostic_msgs', 'geometry_msgs', 'launch', 'launch_ros',
        'rcl_interfaces', 'rclpy', 'rosgraph_msgs', 'sensor_msgs', 'std_msgs', 'std_srvs')},
}


def text_of(tag):
    return XML.findtext(tag).strip()


def imports():
    """Return {top-level name: a file that imports it} of what is not ours."""
    found = {}
    for path in (p for folder in ('gearbox_monitor', 'benchmarks')
                 for p in (ROOT / folder).rglob('*.py')):
        for node in nodes(path):
            names = ([a.name for a in node.names] if isinstance(node, ast.Import) else
                     [node.module] if isinstance(node, ast.ImportFrom) else [])
            for name in names:
                found[name.split('.')[0]] = path.relative_to(ROOT)
    return {name: path for name, path in found.items()
            if name not in (*sys.stdlib_module_names, 'benchmarks', 'gearbox_monitor')}


def test_package_xml_is_valid():
    """An invalid one does not fail to build: ros2 just never finds the package."""
    assert XML.tag == 'package' and XML.get('format') == '3'
    order = [element.tag for element in XML]
    head = ['name', 'version', 'description', 'maintainer', 'license', 'author']
    assert order[:6] == head and order[-1] == 'export'
    assert set(order[6:-1]) == {'build_depend', 'exec_depend', 'test_depend'}
    assert re.fullmatch(r'[a-z][a-z0-9_]*', text_of('name'))
    assert re.fullmatch(r'\d+\.\d+\.\d+', text_of('version'))
    assert text_of('license') == 'Apache-2.0'
    for person in (*XML.iter('maintainer'), *XML.iter('author')):
        assert re.fullmatch(r'[-\w.%+]+@[-\w.]+\.[A-Za-z]{2,}', person.get('email'))
    assert XML.findtext('export/build_type') == 'ament_python'
    dependencies = [e.text for e in XML.iter('exec_depend')]
    assert len(set(dependencies)) == len(dependencies)


def test_one_version():
    version = text_of('version')
    assert gearbox_monitor.__version__ == version
    assert f"version='{version}'" in SETUP
    changelog = (ROOT / 'CHANGELOG.rst').read_text(encoding='utf-8')
    assert re.search(r'^(\d+\.\d+\.\d+) \(', changelog, re.MULTILINE)[1] == version


def test_dependencies_are_declared():
    keys = {e.text for e in XML.iter('exec_depend')}
    for name, path in imports().items():
        assert name in THIRD_PARTY, f'{path}: {name} is in neither package.xml nor setup.py'
        key, distribution = THIRD_PARTY[name]
        assert key is None or key in keys, f'{path}: {name} is not in package.xml'
        assert distribution is None or f"'{distribution}>=" in SETUP, f'{path}: {name}'


def test_entry_points_exist():
    scripts = re.findall(r"'(\w+) = ([\w.]+):(\w+)'", SETUP)
    assert {name for name, _, _ in scripts} == {
        'gearbox_monitor', 'plant_node', 'arm_plant_node', 'estimator_node', 'recorder_node',
        'watch_node'}
    for _, module, function in scripts:
        if '.ros.' in module:
            pytest.importorskip('rclpy')
        assert callable(getattr(import_module(module), function))


def test_every_command_explains_itself_with_examples(capsys, monkeypatch):
    monkeypatch.setenv('COLUMNS', '80')
    shown = {}
    for command in COMMANDS:
        with pytest.raises(SystemExit, match='0'):
            main([command, '--help'])
        shown[command] = capsys.readouterr().out
    assert main([]) == 0
    listed = capsys.readouterr().out
    assert re.findall(r'^  (\S+) ', listed, re.MULTILINE) == list(COMMANDS)
    assert max(map(len, listed.splitlines())) <= 80
    for command, text in shown.items():
        assert f'  gearbox_monitor {command}' in text, f'{command}: no example'
        assert '\nexit code: 0 ' in text, command


@pytest.fixture(scope='module')
def installed(tmp_path_factory):
    """Install into a prefix as colcon and pip do; return (prefix, folder of the modules)."""
    pytest.importorskip('setuptools')
    prefix = tmp_path_factory.mktemp('prefix')
    library = prefix / 'lib/python3/site-packages'
    subprocess.run(
        [sys.executable, 'setup.py', '-q', 'build_py', '--build-lib', str(library),
         'install_data', '--install-dir', str(prefix)],
        cwd=ROOT, check=True, capture_output=True)
    return prefix, library


def test_everything_is_installed(installed):
    prefix, library = installed
    share = prefix / 'share/gearbox_monitor'
    for folder, where in (('config', 'config'), ('gearbox_monitor/ros/launch', 'launch')):
        expected = {p.relative_to(ROOT / folder) for p in (ROOT / folder).rglob('*')
                    if p.is_file() and '__pycache__' not in p.parts}
        assert expected == {p.relative_to(share / where) for p in (share / where).rglob('*')
                            if p.is_file()}
    assert (share / 'package.xml').is_file()
    assert (prefix / 'share/ament_index/resource_index/packages/gearbox_monitor').is_file()
    assert [p.name for p in library.iterdir()] == ['gearbox_monitor'], 'no benchmarks, no tests'
    for sources in ('*.py', '*.html', '*.css', '*.js'):
        modules = {p.relative_to(ROOT) for p in (ROOT / 'gearbox_monitor').rglob(sources)
                   if p.parent.name != 'launch'}
        assert modules == {p.relative_to(library) for p in library.rglob(sources)} != set()


def test_installed_copy_finds_its_own_configuration(installed, tmp_path):
    prefix, library = installed
    env = {**os.environ, 'PYTHONPATH': str(library), 'AMENT_PREFIX_PATH': '/nowhere'}
    code = ('from gearbox_monitor.files.user_files import config_path\n'
            'print(config_path("drive.yaml"), config_path("import/emps.yaml"))')
    result = subprocess.run([sys.executable, '-c', code], cwd=tmp_path, env=env, check=True,
                            capture_output=True, text=True)
    config = prefix / 'share/gearbox_monitor/config'
    assert result.stdout.split() == [str(config / 'drive.yaml'), str(config / 'import/emps.yaml')]


def test_installed_copy_renders_a_page(installed, tmp_path):
    _, library = installed
    code = ('from gearbox_monitor.report.builder import Page, render_page\n'
            'from gearbox_monitor.report.fleet_page import bag_problems\n'
            'from gearbox_monitor.report.builder import page_summary\n'
            'print(render_page(Page("a <page>", page_summary("", "<b>"), '
            '[bag_problems([], 3)])))')
    result = subprocess.run([sys.executable, '-c', code], cwd=tmp_path, check=True,
                            env={**os.environ, 'PYTHONPATH': str(library)}, capture_output=True,
                            text=True)
    assert '<h1>a &lt;page&gt;</h1>' in result.stdout and '3 bags were analysed' in result.stdout
    assert '<b>' not in result.stdout
    for asset in ('page.css', 'page.js'):
        text = (ROOT / 'gearbox_monitor/report/assets' / asset).read_text(encoding='utf-8')
        assert text in result.stdout and '</' not in text


def test_missing_configuration_is_one_line(tmp_path):
    from gearbox_monitor.errors import InputError
    from gearbox_monitor.files.user_files import config_path
    with pytest.raises(InputError, match='^nothing.yaml: not found, expected in .*config$'):
        config_path('nothing.yaml')


def test_lines_that_install_extras_work_in_a_checkout():
    """No index has the package: each line is of a checkout, and names extras of setup.py."""
    extras = {*re.findall(r"^        '(\w+)': \[|^        '(\w+)': \w+,", SETUP, re.MULTILINE)}
    extras = {name for pair in extras for name in pair if name}
    assert {'tables', 'ros', 'test', 'mujoco'} <= extras
    files = [*ROOT.glob('*.md'), *ROOT.glob('docs/*.md'), *ROOT.glob('gearbox_monitor/**/*.py')]
    named = set()
    for path in files:
        text = path.read_text(encoding='utf-8')
        assert not re.search(r'pip install[^\n]*gearbox_monitor\[', text), path
        for names in re.findall(r"'?\.\[([a-z,]+)\]", text) + re.findall(
                r"""installed_by\(["'](\w+)["']\)""", text):
            named |= {*names.split(',')}
    # One benchmark needs bam; the other word is a key of entry_points.
    assert named == extras - {'bam', 'console_scripts'}, named ^ extras
