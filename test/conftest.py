# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What all tests share: no ROS traffic beyond this machine, no files outside temporary folders."""
import fcntl
import gc
import importlib.util
import os
from pathlib import Path
import shutil
import signal
import sys
import tempfile

import pytest

from gearbox_monitor.ros.middleware import remove_cut_ports

BENCHMARKS = Path(__file__).parent / 'benchmarks'
# Jobs of their own; a test with several markers belongs to the first of these.
JOBS = ('system', 'benchmark', 'prose')
# A word in a file of tests -> the group of files that one process runs.
GROUPS = {'pytest.mark.ros': 'nodes', ', browser': 'pages', 'from sources import': 'sources',
          'from limits import': 'sources'}


def pytest_configure(config):
    # A shell's background job ignores Ctrl-C, and so would all that tests start and interrupt.
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    # Containers often switch the cache of bytecode off; each command of a test would then compile
    # the package's sources for a second.
    sys.dont_write_bytecode = False
    os.environ.pop('PYTHONDONTWRITEBYTECODE', None)
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('MPLBACKEND', 'Agg')
    # As the command line does: threads of BLAS would spin for cores that other tests work on.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    if 'ROS_LOG_DIR' not in os.environ:  # rclpy fails where there is neither this nor a HOME
        logs = tempfile.mkdtemp(prefix='gearbox_monitor_logs_')
        os.environ['ROS_LOG_DIR'] = logs
        config.add_cleanup(lambda: shutil.rmtree(logs, ignore_errors=True))
    if getattr(config.option, 'dist', 'no') == 'load':  # -n 2 alone
        config.option.dist = 'loadfile'
        # A process that crashes would otherwise be replaced and meet the same test for ever.
        if config.option.maxworkerrestart is None:
            config.option.maxworkerrestart = '0'


def pytest_collection_modifyitems(config, items):
    """Leave out tests of a job of its own, unless -m names the marker of that job."""
    kept, left = [], []
    for item in items:
        if BENCHMARKS in item.path.parents:
            item.add_marker('benchmark')
        job = next((name for name in JOBS if item.get_closest_marker(name)), None)
        (left if job and job not in config.option.markexpr else kept).append(item)
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = kept


def pytest_collection_finish():
    """Let the garbage collector pass over what lives as long as the tests: a tenth of the time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(5_000, 10, 20)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """
    Give files that share what is costly to one process of pytest-xdist.

    Nodes would only wait for each other; a browser starts once, and sources are parsed once.
    """
    if config.option.dist != 'loadfile':
        return None
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):

        def _split_scope(self, nodeid):
            name = super()._split_scope(nodeid)
            text = (config.rootpath / name).read_text()
            return next((group for word, group in GROUPS.items() if word in text), name)
    return Scheduling(config, log)


@pytest.hookimpl(hookwrapper=True, tryfirst=True)
def pytest_runtest_protocol(item):
    """Let tests that start nodes run one at a time, also beside another run, and before others."""
    nodes = item.get_closest_marker('ros') is not None
    if 'PYTEST_XDIST_WORKER' in os.environ:
        try:  # nodes keep time: what only computes beside them gives way
            os.setpriority(os.PRIO_PROCESS, 0, 0 if nodes else 10)
        except PermissionError:  # back again: only root may
            pass
    if not nodes:
        yield
        return
    turns = os.path.join(tempfile.gettempdir(), f'gearbox_monitor_nodes_{os.getuid()}')
    with open(turns, 'w') as turn:
        fcntl.flock(turn, fcntl.LOCK_EX)
        remove_cut_ports()
        yield


def pytest_report_header():
    found = {name: importlib.util.find_spec(name) is not None for name in ('rclpy',)}
    return 'found: ' + ', '.join(f'{name} {"yes" if yes else "NO"}' for name, yes in found.items())


@pytest.fixture
def new_folder(tmp_path):
    """Return a function that makes a folder for each case of a table."""
    return lambda: Path(tempfile.mkdtemp(dir=tmp_path))


@pytest.fixture
def graph(tmp_path, monkeypatch):
    """Return a harness.Graph, whose processes end with the test."""
    pytest.importorskip('rclpy')
    from harness import Graph
    graph = Graph(tmp_path, monkeypatch)
    yield graph
    graph.close()


@pytest.fixture(scope='module')
def browser(chromium):
    """Return the Chromium of the session with an empty page, without what others have logged."""
    chromium.get('about:blank')
    for log in ('browser', 'performance'):
        chromium.get_log(log)
    return chromium


@pytest.fixture(scope='session')
def chromium(tmp_path_factory):
    """Return a headless Chromium, which must not talk to anyone."""
    webdriver = pytest.importorskip('selenium.webdriver')
    service = pytest.importorskip('selenium.webdriver.chrome.service')
    binary = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which(
        'google-chrome')
    driver = shutil.which('chromedriver')
    if not binary or not driver:
        pytest.skip('chromium or chromedriver is not installed')
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for flag in ('headless', 'no-sandbox', 'disable-gpu', 'disable-quic', 'no-first-run',
                 'disable-background-networking', 'disable-component-update', 'disable-sync',
                 'disable-dev-shm-usage', f'user-data-dir={tmp_path_factory.mktemp("profile")}'):
        options.add_argument(f'--{flag}')
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL', 'performance': 'ALL'})
    chrome = webdriver.Chrome(options=options, service=service.Service(driver))
    yield chrome
    chrome.quit()
