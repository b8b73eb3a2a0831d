# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The demo of a whole arm: one estimator watches the gearboxes of six joints."""
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from gearbox_monitor.cli import demo_run
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.resources import config_path
from gearbox_monitor.files.robot_files import load_robot
from gearbox_monitor.files.yaml_files import save_model
from gearbox_monitor.health.backlash.change_tests import COMPONENTS
from gearbox_monitor.health.checks.outcome import Level, Outcome
from gearbox_monitor.parameters import RecorderParameters
from gearbox_monitor.recordings.topics import SNAPSHOT
from gearbox_monitor.robot import example_arm
from gearbox_monitor.robot.working_arm import program

FAULTY = 0     # number of the joint whose gap grows
FILTER = 'ekf'  # takes the load by a description, and tau_K by its curve


class RobotDemo(demo_run.Demo):
    """One run of the demo of an arm."""

    durations = demo_run.ROBOT_MIN_DURATION, 60.0
    plant = 'arm_plant'

    def __init__(self, *arguments: Any) -> None:
        """Take the `arguments` of Demo; write a model file of each joint."""
        description = config_path('arm6.urdf')
        self._description, self._robot = str(description), load_robot(str(description))
        self.gearboxes = tuple(self._robot.joints)
        self.faulty = self.gearboxes[FAULTY]
        self.task = f'the gap of {self.faulty} grows'
        super().__init__(*arguments)
        self.drives = dict(zip(self.gearboxes, example_arm.nominal_drives(self._robot)))
        for name, drive in self.drives.items():
            save_model(self.model_file(name), drive, [f'Drive of {name} in {description.name}.'])

    @property
    def parameter_file(self) -> Path:
        """Parameters of estimator and arm, for robot.launch.py, too."""
        return self.out / 'robot.yaml'

    def model_file(self, joint: str) -> Path:
        """Return the model file of a `joint`."""
        return self.out / f'{joint}.yaml'

    def check_filter(self, name: str) -> None:
        """Raise InputError unless the filter `name` takes the parameters of the arm."""
        if name != FILTER:
            raise InputError(f'--filter: {name!r}, expected {FILTER!r} with --robot')

    @property
    def window(self) -> float:
        """Length of the windows of the gap, s: of the arm's program, which all of them repeat."""
        return len(program(1.0 / self.rate)) / self.rate

    def start_monitoring(self) -> None:
        """Start recorder and estimator."""
        self.start_recorder(topics=[*RecorderParameters().topics, *(
            f'estimator/{name}/{SNAPSHOT}' for name in self.gearboxes)])
        self.parameter_file.write_text(
            '# The gearboxes of the arm, as the demo monitors them.\n'
            + yaml.safe_dump({
                'estimator': {'ros__parameters': self._parameters()},
                'arm_plant': {'ros__parameters': {
                    'rate': self.rate, 'faulty_joint': FAULTY + 1,
                    'gap_growth_rate': self.growth_rate, 'gap_growth_start': self.growth_start}}},
                sort_keys=False), encoding='utf-8')
        self.start('estimator', self.parameter_file, **demo_run.RELIABLE)

    def _parameters(self) -> dict[str, Any]:
        return {'gearboxes': list(self.gearboxes), 'filter': self.filter,
                'robot_description': self._description, 'drift_window': self.window,
                **demo_run.DRIFT,
                **{name: {'model': str(self.model_file(name)),
                          **example_arm.parameters_of(joint)}
                   for joint, name in enumerate(self.gearboxes)}}

    def status(self) -> demo_run.DemoStatus:
        """Return what shows the progress."""
        return RobotDemoStatus(self.duration, self.rate)

    def report(self) -> Any:
        """Return the module that evaluates the bag."""
        from gearbox_monitor.cli import robot_demo_report
        return robot_demo_report


class RobotDemoStatus(demo_run.DemoStatus):
    """Live status of an arm."""

    def gap(self, watcher: Any) -> str:
        """Return the gaps that `watcher` sees, in the order of the joints."""
        gaps = map(_gap, watcher.joints.values())
        return 'gaps ' + ' '.join('-' if gap is None else f'{1e3 * float(gap):.2f}'
                                  for gap in gaps) + ' mrad  '

    def raised(self, watcher: Any) -> list[str]:
        """Return the worst component of each joint that `watcher` sees, with its level."""
        highest = []
        for joint, outcomes in watcher.joints.items():
            unmeasured = COMPONENTS if _gap(outcomes) is None else ()  # a dash shows it
            level, name = max(((outcome.level, name) for name, outcome in outcomes.items()
                               if name not in unmeasured), default=(Level.OK, ''))
            if level:
                highest.append(f'{joint} {name} {level.name}')
        return highest


def _gap(outcomes: Mapping[str, Outcome]) -> str | None:
    """Return the gap among the `outcomes` of a joint, None if it was not measured yet."""
    return outcomes['backlash'].values.get('gap_rad') if 'backlash' in outcomes else None
