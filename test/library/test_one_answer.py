# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""One stream of windows through every door: one level, one size, one sentence."""
import json

from live import PARAMETERS, worn, write_inputs, write_live
import numpy as np
import pytest
import yaml

import gearbox_monitor as gm
from gearbox_monitor.cli.main import main
from gearbox_monitor.files.baselines import save_baseline
from gearbox_monitor.health.alarms import Level
from gearbox_monitor.health.judgement import accepted, outcomes, sentence, to_data
from gearbox_monitor.health.monitor import Monitor
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.recordings.write import BagWriter
from gearbox_monitor.report.live_page import GearboxHistory, live_summary
from gearbox_monitor.ros.diagnostic_keys import published

MODEL = DriveModel()
# Growth per second from 10 s on, seed of the noise.
HISTORIES = [(float(rate), seed) for seed, rate in enumerate(np.linspace(0.0, 0.095, 20))]
SHORT = (0, 19)


@pytest.mark.parametrize('rate, seed', [
    pytest.param(*history, marks=() if k in SHORT else pytest.mark.system)
    for k, history in enumerate(HISTORIES)])
def test_every_door_gives_the_same_answer(tmp_path, capsys, rate, seed):
    samples = worn({0: 12}.get(seed, 24), seed=seed, rate=rate)
    for name, write in (('live', write_live), ('inputs', lambda writer, samples: None)):
        with BagWriter(tmp_path / name) as writer:
            write_inputs(writer, samples)
            write(writer, samples)
    (tmp_path / 'p.yaml').write_text(yaml.safe_dump(
        {'estimator': {'ros__parameters': PARAMETERS}}))
    (tmp_path / 'm.yaml').write_text(yaml.safe_dump(MODEL.to_dict()))
    options = ['--params', str(tmp_path / 'p.yaml'), '--model', str(tmp_path / 'm.yaml')]
    live = Monitor(MODEL, PARAMETERS)
    live.run(samples)
    level, words = sentence(live.health)
    change = live.health.feature('gap').change
    assert (level > Level.OK) == (rate > 0.0) or 0.0 < rate < 0.03

    def said(*command):
        """Return what a command prints as JSON."""
        capsys.readouterr()
        assert main([*map(str, command)]) == 0
        return json.loads(capsys.readouterr().out)
    for bag, more in (('live', []), ('inputs', options)):
        replayed = said('replay', tmp_path / bag, *more, '--json')
        figures = replayed['wear']
        assert (figures['level'], figures['summary']) == (level.name, words)
        assert figures['features']['gap']['change'] == change
        page = said('report', tmp_path / bag, *more, '--out', tmp_path / f'{bag}.html', '--json',
                    '-')
        assert page['headline'] == f'{words[0].upper()}{words[1:]}.'
        assert level > Level.OK or words.endswith('no earlier recording to compare with')
        assert page['headline'] in replayed['summary']
        box, = said('fleet', tmp_path / bag, *more, '--out', tmp_path / f'{bag}.fleet',
                    '--json')['gearboxes']
        assert box['summary'].split('; ')[0] == words
        assert box['level'] == (level.name if live.health.alerts else None)
        assert box['features']['gap']['change'] == change
    health = gm.estimate(gm.load_recording(tmp_path / 'inputs', MODEL), **PARAMETERS).health
    assert sentence(health) == (level, words)
    heard = GearboxHistory('elbow')
    for name, outcome in live.outcomes.items():
        if name in outcomes(live.health):
            heard.add_status(0.0, name, int(outcome.level), outcome.message,
                             dict(published(name, outcome.figures)))
    live_page = live_summary([heard], 'estimator', 0.0).data
    assert words[1:] in live_page['headline']
    assert live_page['kind'] == ('', 'warn', 'error')[level]
    if rate > 0.09:  # healthy windows of before the change pass for nothing
        assert main(['accept', str(tmp_path / 'live'), '--max-gap', '0.25']) == 1
    restarted = Monitor(MODEL, PARAMETERS, to_data(live.health)).outcomes['backlash'].message
    assert 'no earlier recording' not in restarted


def test_a_baseline_file_counts_at_every_door(tmp_path, capsys):
    """Worn from its first sample on: only the baseline of before can tell."""
    healthy, grown = (worn(seconds, seed=1, rate=0.0, half_gap=half_gap)
                      for seconds, half_gap in ((26, 0.1), (14, 0.1247)))
    monitor = Monitor(MODEL, PARAMETERS)
    monitor.run(healthy)
    file = tmp_path / 'healthy.json'
    save_baseline(file, accepted(monitor.health)[0], 'gearbox', {})
    live = Monitor(MODEL, {**PARAMETERS, 'baseline_file': str(file)},
                   json.loads(file.read_text().splitlines()[0])['health'])
    live.run(grown)
    level, words = sentence(live.health)
    assert level == Level.WARN and 'backlash has grown by 24' in words
    with BagWriter(tmp_path / 'bag') as writer:
        write_inputs(writer, grown)
    (tmp_path / 'p.yaml').write_text(yaml.safe_dump({'estimator': {'ros__parameters': {
        **PARAMETERS, 'baseline_file': str(file)}}}))
    for command in (('replay',), ('report', '--out', str(tmp_path / 'page.html'))):
        capsys.readouterr()
        assert main([command[0], str(tmp_path / 'bag'), '--params', str(tmp_path / 'p.yaml'),
                     *command[1:]]) == 0
        assert words[1:] in ' '.join(capsys.readouterr().out.split())
    assert main(['fleet', str(tmp_path / 'bag'), '--params', str(tmp_path / 'p.yaml'), '--out',
                 str(tmp_path / 'fleet'), '--json']) == 0
    box, = json.loads(capsys.readouterr().out)['gearboxes']
    assert (box['level'], box['summary']) == ('WARN', words)
