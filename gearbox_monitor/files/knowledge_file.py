# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""Knowledge of a robot in a file: arrays of numpy and one text of JSON, never a pickle."""
import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from gearbox_monitor.diagnosis.robot.evidence import Prior
from gearbox_monitor.diagnosis.robot.knowledge import Knowledge, States, VERSION, Visits
from gearbox_monitor.errors import InputError
from gearbox_monitor.files.opening import read_bytes, write_new

SUFFIX = '.knowledge'
MAX_BYTES = 256 << 20
ARRAYS = ('mean', 'covariance', 'dispersion', 'bursts', 'sizes', 'variance')
OF_STATES = ('states', 'state_deviations')
TEXTS = ('joints', 'kind', 'measured', 'rate', 'references', 'seconds', 'parts',
         'unjudged', 'model')


def save_knowledge(path: str | Path, knowledge: Knowledge) -> None:
    """Write `knowledge` into the new file `path`. Raises InputError."""
    arrays = {'mean': knowledge.prior.mean, 'covariance': knowledge.prior.covariance,
              **{name: getattr(knowledge, name) for name in ARRAYS[2:]},
              'states': knowledge.states.points, 'state_deviations': knowledge.states.deviations}
    arrays |= {f'scatter/{i}': x for i, x in enumerate(knowledge.scatter.values())}
    text = json.dumps({
        'version': VERSION, 'labels': knowledge.prior.labels, 'shapes': knowledge.shapes,
        'scatter': list(knowledge.scatter), 'apart': knowledge.states.apart,
        'visits': {joint: {variable: [v.spacing, sorted(v.seconds.items())]
                           for variable, v in table.items()}
                   for joint, table in knowledge.visits.items()},
        **{name: getattr(knowledge, name) for name in TEXTS}})
    content = io.BytesIO()
    np.savez_compressed(content, text=np.frombuffer(text.encode(), np.uint8), **arrays)
    write_new(path, content.getvalue())


def load_knowledge(path: str | Path, model: str) -> Knowledge:
    """
    Return the Knowledge in the file `path`, of the model file with the hash `model`.

    Raises InputError: damaged, of another version, or of another model.
    """
    try:
        data = read_bytes(Path(path), MAX_BYTES)
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            text = json.loads(bytes(file['text']).decode())
            version = text.get('version')
            if version != VERSION:
                raise InputError(f'{path}: version: {version}, expected {VERSION}: learn it again')
            arrays = {name: np.array(file[name], float) for name in (*ARRAYS, *OF_STATES)}
            scatter = {key: np.array(file[f'scatter/{i}'], float)
                       for i, key in enumerate(text['scatter'])}
        knowledge = _made(text, arrays, scatter)
    except InputError:
        raise
    except Exception as error:  # zip, zlib, numpy and JSON raise many kinds for damaged files
        reason = getattr(error, 'strerror', None) or f'{type(error).__name__}: {error}'
        raise InputError(f'{path}: {reason}, expected a file that learn wrote') from None
    if knowledge.model != model:
        raise InputError(f'{path}: model: learnt with another file or locked joints '
                         f'({knowledge.model[:12]}), expected the one of --model '
                         f'({model[:12]}): learn it again')
    return knowledge


def _made(text: dict[str, Any], arrays: dict[str, Any], scatter: dict[str, Any]) -> Knowledge:
    labels = tuple(str(x) for x in text['labels'])
    n, joints = len(labels), tuple(str(x) for x in text['joints'])
    if arrays['mean'].shape != (n,) or arrays['covariance'].shape != (n, n) or any(
            arrays[name].shape[:1] != (len(joints),) for name in ARRAYS[2:]):
        raise ValueError('arrays do not fit the labels')
    finite = [*scatter.values(), *(x for name, x in arrays.items() if name != 'variance')]
    if not all(np.isfinite(x).all() for x in finite) or np.isnan(arrays['variance']).any():
        raise ValueError('a number is not finite')
    visits = {joint: {variable: Visits(float(spacing), {int(k): float(s) for k, s in seconds})
                      for variable, (spacing, seconds) in table.items()}
              for joint, table in text['visits'].items()}
    return Knowledge(
        Prior(labels, arrays['mean'], arrays['covariance']),
        tuple((int(j), str(name)) for j, name in text['shapes']), scatter, arrays['dispersion'],
        arrays['bursts'], visits, arrays['sizes'], arrays['variance'], joints, str(text['kind']),
        bool(text['measured']), float(text['rate']), tuple(str(x) for x in text['references']),
        float(text['seconds']), int(text['parts']),
        States(arrays['states'], arrays['state_deviations'], float(text['apart'])),
        tuple(str(x) for x in text['unjudged']), str(text['model']))
