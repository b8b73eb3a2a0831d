# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Make the pictures of pages: python docs/make_pictures.py [PICTURE ..].

Each is the page of a command of the documentation, drawn by a headless Chromium. Every page is
checked at 390 and 1400 px, light and dark, and on paper: nothing scrolls sideways, no text lies on
another one.
Exit code 1: a page fails.
"""
from base64 import b64decode
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
import itertools
import json
import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from typing import Any, Self

import numpy as np

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent))

from gearbox_monitor.estimation.estimates import Estimates, Samples  # noqa: E402
from gearbox_monitor.files.user_files import config_path, load_robot  # noqa: E402
from gearbox_monitor.health.monitor import Monitor  # noqa: E402
from gearbox_monitor.plant.drive import DriveModel  # noqa: E402
from gearbox_monitor.plant.faults import Excitation, Faults, FaultyPlant  # noqa: E402
from gearbox_monitor.plant.simulate import Noise  # noqa: E402
from gearbox_monitor.recordings.topics import signal_values, SIGNALS  # noqa: E402
from gearbox_monitor.report.live_page import GearboxHistory, live_frame, LivePage  # noqa: E402
from gearbox_monitor.report.recording_page import recording_page  # noqa: E402
from gearbox_monitor.report.timeline import MonitorFollower, RecordingFacts, State, Timeline  # noqa: E402
from gearbox_monitor.report.watch_page import watch_page  # noqa: E402
from gearbox_monitor.report.watch_words import watch_data  # noqa: E402
from gearbox_monitor.robot.arm_plant import GapGrowth, WorkingArm  # noqa: E402
from gearbox_monitor.ros.diagnostic_keys import published  # noqa: E402
from gearbox_monitor.ros.live_node import EventServer  # noqa: E402
from gearbox_monitor.watch.fold import begin, step  # noqa: E402
from gearbox_monitor.watch.record import Cutter  # noqa: E402

BROWSERS = 'chromium', 'chromium-browser', 'google-chrome'
SMOOTHED = next(s for s in SIGNALS if s.topic == 'transmission_state_smoothed')
WIDTHS, SCHEMES = (390, 1400), ('light', 'dark')
PAPER = 718  # px: the width of A4 between margins
LIMIT = 250_000  # bytes of a picture
# Lines of text that lie on another one, by the middle of their boxes; labels in plots as well.
FAULTS = """(() => {
const bad = [], width = window.innerWidth, boxes = [];
if (document.documentElement.scrollWidth > width)
  bad.push('scrolls sideways: ' + document.documentElement.scrollWidth + ' px');
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walker.nextNode()) {
  const node = walker.currentNode, parent = node.parentElement;
  if (!node.textContent.trim() || parent.closest('script, style, title') ||
      !parent.checkVisibility({opacityProperty: true, visibilityProperty: true})) continue;
  const range = document.createRange();
  range.selectNodeContents(node);
  for (const box of range.getClientRects())
    if (box.width > 1 && box.height > 1)
      boxes.push({box, words: node.textContent.trim().slice(0, 40)});
}
for (let i = 0; i < boxes.length; i++)
  for (let j = i + 1; j < boxes.length; j++) {
    const a = boxes[i].box, b = boxes[j].box;
    const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
    const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    if (wide > 2 && high > 0.4 * Math.min(a.height, b.height))
      bad.push('"' + boxes[i].words + '" lies on "' + boxes[j].words + '"');
  }
return bad;
})()"""


class Browser:
    """A headless Chromium with one page, driven through a pipe."""

    def __init__(self) -> None:
        program = next(filter(None, map(shutil.which, BROWSERS)), None)
        if program is None:
            sys.exit(f'no browser, expected one of {", ".join(BROWSERS)}')
        read, self._write = os.pipe()
        self._read, write = os.pipe()
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        # The browser reads from descriptor 3 and writes to 4.
        words = [program, '--headless', '--no-sandbox', '--disable-gpu', '--hide-scrollbars',
                 '--remote-debugging-pipe', f'--user-data-dir={self._profile.name}']
        self._process = subprocess.Popen(
            ['sh', '-c', f'exec "$@" 3<&{read} 4>&{write}', 'sh', *words],
            pass_fds=(read, write), stderr=subprocess.DEVNULL)
        os.close(read)
        os.close(write)
        self._numbers, self._rest, self._session = itertools.count(1), b'', ''
        target = self._call('Target.createTarget', url='about:blank')['targetId']
        self._session = self._call('Target.attachToTarget', targetId=target,
                                   flatten=True)['sessionId']

    def __enter__(self) -> Self:
        """Return the browser."""
        return self

    def __exit__(self, *error: object) -> None:
        """End it."""
        self._process.terminate()
        self._process.wait()
        self._profile.cleanup()

    def _call(self, method: str, **params: object) -> dict[str, Any]:
        number = next(self._numbers)
        message = {'id': number, 'method': method, 'params': params}
        if self._session:
            message['sessionId'] = self._session
        os.write(self._write, json.dumps(message).encode() + b'\0')
        while True:
            while b'\0' not in self._rest:
                part = os.read(self._read, 1 << 20)
                if not part:
                    sys.exit('the browser has ended')
                self._rest += part
            text, _, self._rest = self._rest.partition(b'\0')
            answer = json.loads(text)
            if answer.get('id') == number:
                if 'error' in answer:
                    sys.exit(f'{method}: {answer["error"]}')
                return dict(answer['result'])

    def show(self, address: str, width: int, height: int, scheme: str, ready: str) -> None:
        """
        Open `address` in a window of `width` x `height`, until the JavaScript `ready` holds.

        scheme: light, dark, or print: on paper.
        """
        self._call('Emulation.setDeviceMetricsOverride', width=width, height=height,
                   deviceScaleFactor=1, mobile=False)
        self._call('Emulation.setEmulatedMedia', media='print' if scheme == 'print' else 'screen',
                   features=[{'name': 'prefers-color-scheme', 'value': scheme}])
        self._call('Page.navigate', url=address)
        until = time.monotonic() + 60.0
        while not self.value(f'document.readyState == "complete" && {ready}'):
            if time.monotonic() > until:
                sys.exit(f'{address}: not drawn')
            time.sleep(0.1)

    def value(self, script: str) -> Any:
        """Return the value of the JavaScript `script` in the page."""
        result = self._call('Runtime.evaluate', expression=script, returnByValue=True)
        return result['result'].get('value')

    def picture(self, width: int, height: int) -> bytes:
        """Return the PNG of the top of the page."""
        clip = {'x': 0, 'y': 0, 'width': width, 'height': height, 'scale': 1}
        return b64decode(self._call('Page.captureScreenshot', clip=clip,
                                    captureBeyondViewport=True)['data'])


def run(command: str, folder: Path) -> None:
    """Run a `command` of the package in `folder`."""
    code = subprocess.run([sys.executable, '-m', 'gearbox_monitor', *shlex.split(command)],
                          cwd=folder).returncode
    if code not in (0, 1):  # 1: a finding
        sys.exit(code)


@contextmanager
def robot_gap(folder: Path) -> Iterator[str]:
    """Yield the address of the page of an arm that carries a load and has a joint that rubs."""
    run('example arm --robot', folder)
    run('diagnose arm/today.csv --model arm/robot.urdf --reference arm/healthy.csv --out gap',
        folder)
    yield (folder / 'gap/report.html').as_uri()


@contextmanager
def mujoco(folder: Path) -> Iterator[str]:
    """Yield the address of the page of mujoco.md, with what changes in the file."""
    page = (DOCS / 'mujoco.md').read_text(encoding='utf-8')
    for text in re.findall(r'```(?:xml|yaml)\n(.*?)```', page, re.DOTALL):
        (folder / re.findall(r'\S+\.(?:xml|yaml)', text)[0]).write_text(text, encoding='utf-8')
    run('example run --model true.yaml --seconds 10 --process-noise 0', folder)
    run('diagnose run --model robot.xml --joint elbow --values gearbox.yaml --out found '
        '--only arm_inertia gravity',
        folder)
    yield (folder / 'found/report.html').as_uri()


@contextmanager
def fleet(folder: Path) -> Iterator[str]:
    """Yield the address of the page of two gearboxes over half a year, one of which wears."""
    (folder / 'params.yaml').write_text(
        'estimator: {ros__parameters: {arm_load: none}}', encoding='utf-8')
    dates = ('2026-01-15', '2026-02-20', '2026-04-10', '2026-06-15')
    for n, (name, growth) in enumerate((
            ('SN0815', (0, 8, 16, 25)), ('SN0816', (0, 0, 0, 0)))):
        for k, (date, wear) in enumerate(zip(dates, growth)):
            run(f'example archive/{name}/{date} --date {date} --wear {wear} --rate 500 '
                f'--seed {10 * n + k} --seconds 40 --motion varied --process-noise 0', folder)
    run("fleet archive --out fleet --params params.yaml --gearbox 'archive/([^/]+)/'", folder)
    page = folder / 'fleet/fleet.html'  # which names its bags by paths of this machine
    page.write_text(page.read_text(encoding='utf-8').replace(f'{folder}/', ''), encoding='utf-8')
    yield page.as_uri()


@contextmanager
def watch(folder: Path) -> Iterator[str]:
    """Yield the address of the page of the arm of watch.md: it rubs, then holds a load."""
    path, rate, joint = config_path('arm6.urdf'), 100, 1
    arm = WorkingArm(load_robot(str(path)), 1 / rate, 1, GapGrowth(joint))
    known, cutter = begin(path.read_text(encoding='utf-8')), Cutter()
    joints = [j.name for j in known.joints]
    for second in range(840):
        payload = 2.0 if 560 <= second < 680 else 0.0
        run = arm.run(rate, payload, 5.0 if second >= 440 else 0.0)
        stamps = 1_772_438_400_000_000_000 + np.round(run.true.t * 1e9).astype(np.int64)
        for row in zip(stamps.tolist(), run.arm, run.true.u):
            for block in cutter.take(row[0], joints, row[1], (), row[2]):
                known, _ = step(known, block)
    page = folder / 'watch.html'
    page.write_text(watch_page(watch_data(known), known.description, 'Watch'), encoding='utf-8')
    if not known.standing:
        sys.exit('no finding')
    yield page.as_uri()


@contextmanager
def index(folder: Path) -> Iterator[str]:
    """Yield the address of the index of a folder with a recording and its page."""
    run('example run --seconds 20 --rate 500', folder)
    run('report run --model run.drive.yaml', folder)
    run('open .', folder)
    yield (folder / 'index.html').as_uri()


def worn_gearbox(seconds: int) -> Iterator[tuple[Samples, Estimates, Monitor]]:
    """Yield each second of a simulated gearbox whose backlash grows after 40 s."""
    model, rate = DriveModel(), 500
    t = np.arange(seconds * rate) / rate
    plant = FaultyPlant(model, Noise((0.0, 0.0, 0.4, 0.4), (5e-3, 5e-3)), 5,
                        faults=Faults(gap_growth_rate=0.012, gap_growth_start=40.0))
    drive = plant.run(Excitation().torque(t), 1 / rate)
    stamps = 1_772_438_400_000_000_000 + np.round(t * 1e9).astype(np.int64)
    monitor = Monitor(model, {
        'arm_load': 'none', 'drift_window': 2.0, 'false_alarm_interval': 86400.0,
        'angle_bin': 0.0, 'speed_bin': 1.0, 'load_bin': 1.0})
    for second in range(seconds):
        part = slice(rate * second, rate * (second + 1))
        samples = Samples(stamps[part], np.column_stack(
            [drive.u, np.full(len(t), np.nan)])[part], drive.y[part])
        yield samples, monitor.run(samples), monitor


@contextmanager
def report(folder: Path) -> Iterator[str]:
    """Yield the address of the page of a worn gearbox."""
    line = Timeline(10.0)
    follower = MonitorFollower(line)
    for samples, estimates, monitor in worn_gearbox(90):
        follower.take(monitor, samples, estimates)
    line.finish()
    facts = RecordingFacts(monitor.model, monitor.parameters)
    (folder / 'page.html').write_text(
        recording_page(line, facts, 'joint3', 'joint3'), encoding='utf-8')
    yield (folder / 'page.html').as_uri()


@contextmanager
def live(folder: Path) -> Iterator[str]:
    """Yield the address of the live page of a simulated gearbox at the moment of its alert."""
    seconds, gearbox = 90, GearboxHistory('elbow')
    began, wears = time.monotonic() - seconds, False
    for second, (_, estimates, monitor) in enumerate(worn_gearbox(seconds)):
        stamp, values = signal_values(SMOOTHED, estimates, 1.0)
        gearbox.add_motion(stamp, np.column_stack([values['position'], values['effort']]))
        for name, outcome in monitor.outcomes.items():
            gearbox.add_status(began + second, name, int(outcome.level), outcome.message,
                               dict(published(name, outcome.figures)))
        if monitor.health.stages().get('backlash'):
            outcome = monitor.outcomes['backlash']
            gearbox.add_alert(State(outcome.level, 'backlash', outcome.message),
                              '2026-03-02 08:00:46')
            wears = True
            break
    if not wears:
        sys.exit('no alert')
    server = EventServer(live_frame(), '127.0.0.1', 0)
    server.publish(LivePage().parts([gearbox], '/estimator', began + second))
    try:
        yield server.address
    finally:
        server.close()


@dataclass(frozen=True)
class Picture:
    """What is drawn: the top of a page, `width` x `height` pixels; 0: it is checked alone."""

    page: Callable[[Path], AbstractContextManager[str]]
    width: int = 0
    height: int = 0
    ready: str = 'true'


PICTURES = {
    'watch.png': Picture(watch, 1000, 700),
    'robot_gap.png': Picture(robot_gap, 1000, 1010),
    'live.png': Picture(live, 1000, 1275, ready='!!document.querySelector("#condition0")'),
    'mujoco.png': Picture(mujoco, 1000, 820),
    'fleet.png': Picture(fleet, 1000, 1290),
    'report.png': Picture(report, 1000, 1300),
    'index': Picture(index)}


def draw(browser: Browser, name: str, folder: Path) -> list[str]:
    """Draw the picture `name`; return the faults of its page."""
    picture, faults = PICTURES[name], []
    with picture.page(folder) as address:
        for width, scheme in (*itertools.product(WIDTHS, SCHEMES), (PAPER, 'print')):
            browser.show(address, width, 900, scheme, picture.ready)
            faults += [f'{name}: {width} px, {scheme}: {fault}'
                       for fault in browser.value(FAULTS)]
        if not picture.width:
            return faults
        browser.show(address, picture.width, picture.height, 'light', picture.ready)
        data = browser.picture(picture.width, picture.height)
    if len(data) > LIMIT:
        faults.append(f'{name}: {len(data)} bytes, expected at most {LIMIT}')
    (DOCS / name).write_bytes(data)
    return faults


def main(names: list[str]) -> int:
    """Draw the pictures `names`, all without any; return the exit code."""
    faults = []
    with Browser() as browser:
        for name in names or PICTURES:
            with tempfile.TemporaryDirectory() as folder:
                faults += draw(browser, name, Path(folder))
    print('\n'.join(faults) or 'no page scrolls sideways, no text lies on another one')
    return int(bool(faults))


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
