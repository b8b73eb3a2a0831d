# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Condition monitor for robot joint gearboxes.

The public names follow. Each is imported from its room when it is first used, so that the import
of the package alone is cheap. docs/python.md shows them at work:

    load_model            the model of a drive, from a model file, MJCF or URDF
    load_recording        a recording of a drive or a robot, from a file of any kind, or arrays
    estimate              torque, twist, trust and backlash over a recording
    backlash              gap and stiffness of a recording, window by window
    diagnose              the effects that the model of a drive or robot lacks in recordings
    fit                   the values of a model, fitted to recordings
    tune                  R and Q of a filter, from a recording
    adapt                 model and parameters of one unit, from its motion
    ranges                of parameters, that a new drive of the kind may have
    load_actuator         an actuator of the catalogue, with its model and ranges
    write_report          the page of a bag
    export_model          a model in the file of a simulator

    load_robot            a whole robot, from an MJCF or URDF file
    learn                 a healthy robot as a reference
    watch_robot           what changes at a robot at work, from recordings of its joints

    DriveModel            the drive: inertias, friction, transmission, effects
    simulate              its motion under a torque, with noise and effects
    Recording             what load_recording returns: signals of all joints
    DriveRecording        the same, with a model of the drive
    ReadOptions               how columns of a log are read whose names do not say it
    RecordingEstimates    what estimate returns
    BacklashWindows       what backlash returns
    Diagnosis             what diagnose returns
    NominalFit            what fit returns
    TunedParameters       what tune returns
    Adapted               what adapt returns
    ParameterRanges       what ranges returns
    CatalogueActuator     what load_actuator returns
    ReportPages           what write_report returns
    Robot                 what load_robot returns
    Watch                 what watch_robot returns
    SimulatorFile         what export_model returns
    InputError            the one exception that bad input raises

    Estimator             one sample in, one estimate out: stamp checks, filter, smoother
    Monitor               trust and drift, judged on what an Estimator yields
    Sample, Samples       one stamped measurement; arrays of them
    Estimate, Estimates   what an Estimator gives for them
    EstimatorParameters   parameters of Estimator and Monitor
"""
from importlib import import_module, metadata
from pathlib import Path
import re
from typing import Any

# Public name -> module that defines it.
_PUBLIC = {
    'DriveModel': 'plant.drive', 'simulate': 'plant.simulate',
    'Estimator': 'estimation.estimator', 'Monitor': 'health.monitor',
    'Sample': 'estimation.estimates', 'Samples': 'estimation.estimates',
    'Estimate': 'estimation.estimates', 'Estimates': 'estimation.estimates',
    'EstimatorParameters': 'parameters',
    'InputError': 'errors', 'NominalFit': 'diagnosis.joint.nominal',
    'Diagnosis': 'library.identify', 'load_model': 'library.simulator_file',
    'Recording': 'signals.recording', 'load_recording': 'library.recording',
    'DriveRecording': 'library.recording', 'ReadOptions': 'recordings.reading',
    'RecordingEstimates': 'library.estimation', 'BacklashWindows': 'library.estimation',
    'estimate': 'library.estimation', 'backlash': 'library.estimation',
    'diagnose': 'library.identify', 'fit': 'library.identify',
    'tune': 'library.identify', 'adapt': 'library.identify', 'TunedParameters': 'library.identify',
    'Adapted': 'diagnosis.joint.nominal', 'export_model': 'library.simulator_file',
    'SimulatorFile': 'library.simulator_file', 'write_report': 'library.recording_report',
    'ReportPages': 'library.recording_report', 'load_robot': 'library.robot',
    'learn': 'library.robot', 'Robot': 'library.robot', 'watch_robot': 'library.robot',
    'Watch': 'watch.record',
    'ranges': 'library.ranges',
    'ParameterRanges': 'diagnosis.joint.parameter_ranges',
    'load_actuator': 'library.simulator_file', 'CatalogueActuator': 'library.simulator_file',
}
__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:
    """Import the public `name` from the module that defines it."""
    if name not in _PUBLIC:
        gone = import_module(f'{__name__}.errors').refusal(name)
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}'
                             + (f': {gone}' if gone else ''))
    return getattr(import_module(f'{__name__}.{_PUBLIC[name]}'), name)


def __dir__() -> list[str]:
    """Return the names defined here, and the public ones."""
    return sorted({*globals(), *_PUBLIC})


def _version() -> str:
    """Return the version by package.xml in a checkout, else by what was installed."""
    checkout = Path(__file__).resolve().parents[1] / 'package.xml'
    if checkout.is_file():
        version = re.search('<version>(.*)</version>', checkout.read_text(encoding='utf-8'))
        return version[1] if version else 'unknown'
    try:
        return metadata.version('gearbox_monitor')
    except metadata.PackageNotFoundError:  # a bare copy of the sources
        return 'unknown'


__version__ = _version()
