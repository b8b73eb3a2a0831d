# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The pages, read literally: their commands in order, and what they say of the output."""
from collections.abc import Mapping
from dataclasses import dataclass, field
import os
from pathlib import Path
import re
import shlex
import textwrap

import numpy as np
import pytest
from six_axis_arm import controller_constants, DATA, samples

from gearbox_monitor.cli.main import main
from gearbox_monitor.plant.effects import library

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / 'config'
BLOCK = re.compile(r'(?:`(\S+)`:\n+)? *```(\w*)\n(.*?)```', re.DOTALL)
NAMED = re.compile(r'(?:#|<!--) (\S+\.\w+)')  # the first line of a file that a page shows
NUMBER = re.compile(r'\d+(?:\.\d+)?(?:e[-+]?\d+)?')
UNITS = {'mm': 1e-3, 'cm': 1e-2, 'mrad': 1e-3, 'mN m': 1e-3, '%': 1e-2, 'deg': np.pi / 180.0}


@dataclass(frozen=True)
class Walk:
    """
    Sections of a page, by default all, whose commands go on with each other's files.

    Each block of text is printed as it stands. The files that the page shows are written first.

    claims: {regular expression of a sentence or table: one of all that is printed of it}: its
    figures are printed there, its effects are named. says: {regular expression of a sentence: one
    of what is printed}. fails: beginnings of the commands that end with exit code 1. brings:
    {name: file, or what writes it} that the reader has.
    """

    page: str
    sections: tuple[str, ...] = ()
    claims: Mapping[str, str] = field(default_factory=dict)
    says: Mapping[str, str] = field(default_factory=dict)
    fails: tuple[str, ...] = ()
    brings: Mapping[str, object] = field(default_factory=dict)

    @property
    def text(self):
        """The sections, each below its heading."""
        text = (ROOT / self.page).read_text(encoding='utf-8')
        parts = re.split('^(?=## )', text, flags=re.MULTILINE)
        return [part for part in parts
                if not self.sections or part[3:].partition('\n')[0] in self.sections]


def arm_log(name):
    """Return what writes a log of the six-axis arm as CSV, in torques of its own controller."""
    def write(path):
        x = samples(name)
        x = x[np.isfinite(x).all(axis=1)]
        joints = re.findall(r'<joint name="(\w+)" type="revolute"',
                            (DATA / 'ur10e/ur10e.urdf').read_text())
        names = ['t', *('q_' + joint for joint in joints), *('tau_' + joint for joint in joints)]
        np.savetxt(path, np.column_stack([x[:, :7], x[:, 13:19] * controller_constants()]),
                   '%.9g', ',', header=','.join(names), comments='')
    return write


def served_drive(path):
    """Write drive.yaml with the servo that the section about setpoints describes."""
    block = re.search(r'controller: {kp.*}', (ROOT / 'docs/first_hour.md').read_text())[0]
    path.write_text(re.sub('^controller: null', f'{block}  #', (CONFIG / 'drive.yaml').read_text(),
                           flags=re.MULTILINE))


REPLAYED = r'^NIS +\S+|^tau_K error .*'
BENCHMARKS = 'benchmarks/README.md'
FIRST_HOUR = {'joint3_drive.yaml': CONFIG / 'drive.yaml'}
ENTRANCES = ('Motor encoder alone', 'Only setpoints')
WALKS = (
    Walk('docs/first_hour.md', tuple(f'{k}. {name}' for k, name in enumerate((
        'Record (5 min)', 'Check the stamps, signs and units (5 min)',
        'Describe the drive (15 min)', 'R and Q (5 min)', 'Look at the result (10 min)',
        'Gates (5 min)', 'Run it and define the healthy state (15 min)', 'Alerts'), 1)),
        says={'lies `first.drive.yaml`': '^first.drive.yaml: the model of the drive',
              'should lie in its band': r'NIS .* 95 % band',
              '`accept` fails the last one': '^Fail',
              '`fleet` draws the growth': r'^SN0815: backlash has grown by 2[456]'},
        fails=('accept june',), brings=FIRST_HOUR),
    Walk('docs/first_hour.md', ENTRANCES[:1], brings=FIRST_HOUR, fails=('diagnose',), says={
        'backlash grew by 25 %': r'^SN0816: backlash has grown by 2\d(.|\n)*'
                                 r'half\s+backlash\s+0\.12[45]'}),
    Walk('docs/first_hour.md', ENTRANCES[1:], fails=('diagnose',),
         brings={'joint3_servo.yaml': served_drive},
         says={'backlash is 30 % wider': r'\(\+30\s+%', r'\[effect\]': '^values +backlash_gap '}),
    Walk('docs/tuning.md', ('A current instead of a torque',),
         claims={r'error\s+falls(.|\n)*?\s+in\s+both\s+cases': REPLAYED}),
    Walk('docs/tuning.md', ('An identified effect in the estimator',),
         brings={'drive.yaml': CONFIG / 'drive.yaml'}, fails=('diagnose',),
         claims={'rms, of [^;]*': 'rms of .*?,', **dict.fromkeys(
             (r'\| `drive.yaml`.*', r'\| `drive.closed.yaml`.*'),
             REPLAYED)}),
    Walk('docs/mujoco.md', ('Tutorial',), fails=('diagnose',)),
    Walk('docs/simulator.md', ('Example: MuJoCo',), fails=('diagnose',)),
    Walk('docs/robot_gap.md', ('A walk without data',), fails=('diagnose',)),
    Walk(BENCHMARKS, ('A real arm',), fails=('diagnose jan31_load.csv',),
         brings={'ur10e.urdf': DATA / 'ur10e/ur10e.urdf',
                 'feb19.csv': arm_log('ur-20_02_19_14harm50sec'),
                 'feb10.csv': arm_log('ur-20_02_10-30sec_12harm'),
                 'jan31.csv': arm_log('ur-20_01_31-unload'),
                 'jan31_load.csv': arm_log('ur-20_01_31-load')},
         says={'# undecided': r'Coulomb\s+friction\s+below\s+about\s+3.7\s+N\s+m'}),
    Walk('docs/real_drives.md', ('1. Import', '2. A model file', '3. Nominal values',
                                 '4. Find the missing effect', '5. The closed simulator'),
         brings={name: DATA / 'emps' / name for name in ('DATA_EMPS.mat', 'DATA_EMPS_PULSES.mat')},
         fails=('diagnose',),
         claims={'closes 91.1 % of the gap': '.* % closed',
                 'falls to 3.2 mm rms': r'\S+ rms after'}),
    Walk(BENCHMARKS, ('A light motor behind a gearbox',),
         fails=('diagnose run20 run23 --model davinci',), brings={
             **{f'{n}.TXT.gz': DATA / f'davinci_backend/{n}.TXT.gz' for n in (20, 22, 23)},
             'davinci_backend_nominal.yaml': CONFIG / 'davinci_backend_nominal.yaml'},
         claims={r'`backlash_gap`, a dead zone of \S+ rad': r'b = \S+',
                 r'`arm_coulomb`, \S+ N m': r'Cac = \S+',
                 r'`mesh_error`(.|\n)*? periods per turn': r'mesh_error [AN] = \S+',
                 r'\| model file, zero.*': r'torque \S+, arm\s+\S+\s+before',
                 r'\| with these.*': r'torque \S+, arm\s+\S+\s+after',
                 r'\| fitted once more.*': r'before, \S+ rms after'}),
    Walk(BENCHMARKS, ('Servos by their setpoints',),
         brings={name: DATA / 'bam_servo_pendulum/xl330' / name for name in (
             '2026-01-15_10h28m42.json.gz', '2026-01-15_10h29m04.json.gz')},
         fails=('diagnose',), claims={r'`load_friction` \(.*\)': r'Cl = \S+'}))


def printed_as(block, output):
    """Return whether the words of a block are printed, with figures that are the same."""
    def split(text):
        text = ' '.join(text.replace('#', '').split())
        return NUMBER.sub('#', text), NUMBER.findall(text)
    (words, figures), (all_words, all_figures) = split(block), split(output)
    starts = [all_words[:m.start()].count('#') for m in re.finditer(re.escape(words), all_words)]
    return any(all(map(same, figures, all_figures[start:])) for start in starts)


def same(stated, printed, unit=1.0):
    """Return whether the figure `stated`, in units of `unit`, is `printed`, rounded."""
    mantissa, _, exponent = stated.partition('e')
    last = 10.0 ** (int(exponent or 0) - len(mantissa.partition('.')[2]))
    error = abs(float(stated) * unit - float(printed))
    return error <= max(0.6 * last * unit, 2e-3 * float(stated) * unit)


def unprinted(claim, output, printed):
    """Return the effects of a claim that the output lacks, and figures not in `printed` of it."""
    text = re.sub(r'\]\([^)]*\)', ']', claim)
    lacking = [name for name in re.findall('`([^`]*)`', text)
               if name in library() and not re.search(rf'^(values)? +{name} ', output,
                                                      re.MULTILINE)]
    lines = [match[0] for match in re.finditer(printed, output, re.MULTILINE)]
    figures, plain = NUMBER.findall('\n'.join(lines)), re.sub('`[^`]*`', '', text)
    for match in NUMBER.finditer(plain):
        after = plain[match.end():].lstrip()
        units = [1.0, *(unit for name, unit in UNITS.items() if after.startswith(name))]
        if not any(same(match[0], figure, unit) for figure in figures for unit in units):
            lacking.append(match[0])
    return lacking


def test_a_wrong_figure_and_a_missing_effect_are_told():
    output = 'values  lugre Fc = 0.27 N m\nNIS  1.974 (2 when right)\n  motor  0.1829  0.0453\n'
    line = '^  motor .*'
    for claim, lacking in (('183 mm to 45 mm', []), ('183 mm to 47 mm', ['47']),
                           ('1.97', ['1.97']), ('`lugre`, 45 mm', []),
                           ('`gravity`, 0.18', ['gravity'])):
        assert unprinted(claim, output, line) == lacking
    assert printed_as('NIS 1.974 (2 when\n right)', output)
    for block in ('NIS 1.964 (2 when right)', 'NIS 1.974 (2 if right)', 'NIS 1.974 1.974'):
        assert not printed_as(block, output)


@pytest.mark.system
@pytest.mark.parametrize('walk', WALKS, ids=lambda w: ' '.join([w.page, *w.sections[:1]]))
def test_walk(walk, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, source in walk.brings.items():
        if callable(source) or DATA in source.parents:
            if not DATA.is_dir():
                pytest.skip('needs ../shared/data')
        if callable(source):
            source(tmp_path / name)
        else:
            (tmp_path / name).symlink_to(source)
    for match in BLOCK.finditer('\n'.join(walk.text)):
        name = match[1] or (NAMED.match(match[3].lstrip()) or ['', ''])[1]
        if match[2] in ('yaml', 'xml', 'python') and name:
            (tmp_path / name).write_text(textwrap.dedent(match[3]))
    output = ''
    for section in walk.text:
        used = sum(os.times()[:4])
        for match in BLOCK.finditer(section):
            if match[2] in ('', 'text'):
                assert printed_as(match[3], output), f'{match[3]}\n{output}'
            elif match[2] == 'sh':
                for line in match[3].replace('\\\n', ' ').splitlines():
                    words = shlex.split(line, comments=True)
                    if line.startswith('# '):
                        assert printed_as(line[2:], output), f'{line}\n{output}'
                    elif words[:1] == ['gearbox_monitor'] and not words[2].isupper():
                        expected = 3 if line.endswith('# undecided') else any(
                            line[16:].startswith(name) for name in walk.fails)
                        assert main(words[1:]) == expected, (line, capsys.readouterr())
                        output += capsys.readouterr().out
        minutes = re.search(r'## .*\((\d+) min\)', section)
        assert not minutes or sum(os.times()[:4]) - used < 60.0 * float(minutes[1]), minutes
    text = '\n'.join(walk.text)
    for claim, printed in walk.claims.items():
        assert unprinted(re.search(claim, text)[0], output, printed) == [], f'{claim}\n{output}'
    for sentence, printed in walk.says.items():
        assert re.search(sentence, text), sentence
        assert re.search(printed, output, re.MULTILINE), f'{sentence}: {printed}\n{output}'
