# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What commands share: where their JSON goes, and which options a user has stated."""
from argparse import ArgumentParser, Namespace
import json
import math

import pytest

from gearbox_monitor.cli.main import declared
from gearbox_monitor.cli.options import show, stated, write_folder, written_options
from gearbox_monitor.errors import InputError

DATA = {'gap': math.nan, 'rows': (1, 2)}
PLAIN = {'gap': None, 'rows': [1, 2]}


def test_json_is_printed_alone_or_written_beside_the_text(tmp_path, capsys):
    file = tmp_path / 'out.json'
    for value, told in (('-', PLAIN), (None, None), (str(file), None)):
        show(Namespace(json=value), DATA, lambda: 'in words')
        out = capsys.readouterr().out
        assert (json.loads(out) if told else out) == (told or 'in words\n')
    assert json.loads(file.read_text()) == PLAIN


def test_json_never_takes_the_place_of_a_file(tmp_path):
    file = tmp_path / 'page.html'
    file.write_text('what --out of the same command has written')
    with pytest.raises(InputError, match='page.html: File exists, expected a new, writable file'):
        show(Namespace(json=str(file)), DATA, str)
    assert file.read_text().startswith('what')


def test_options_that_differ_from_their_defaults_have_their_own_names():
    parser = ArgumentParser()
    declared(parser, 'diagnose')
    parser.set_defaults(parser=parser)

    def options(*words):
        return parser.parse_args(['bag', '--model', 'arm.xml', *words])
    names = ('bag', 'topic', 'motor_joint', 'arm_joint', 'keyframe')
    assert stated(options(), names) == {'bag': ['bag']}
    args = options('--topic', 'joint_states', '--recorded-arm', 'the arm', '--keyframe', '0')
    assert stated(args, names[1:]) == {'--recorded-arm': 'the arm', '--keyframe': '0'}
    assert written_options(args, names[1:]) == "--recorded-arm 'the arm' --keyframe 0"


def test_all_files_are_written_or_none_and_the_one_that_fails_is_named(tmp_path, monkeypatch):
    out = tmp_path / 'out'
    assert write_folder(out, {'a.json': '{}', 'b.html': ''}) == [out / 'a.json', out / 'b.html']
    assert sorted(path.name for path in out.iterdir()) == ['a.json', 'b.html']
    with pytest.raises(InputError, match='out: File exists'):
        write_folder(out, {'c.json': '{}'})
    assert len(list(out.iterdir())) == 2

    def full(self, text, encoding):
        raise OSError(28, 'No space left on device')  # as the system says it: of no file
    monkeypatch.setattr('pathlib.Path.write_text', full)
    with pytest.raises(InputError, match=r'a\.json: No space left on device'):
        write_folder(tmp_path / 'other', {'a.json': '{}'})
    assert list(tmp_path.iterdir()) == [out]
