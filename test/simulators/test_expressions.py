# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0
"""What each effect becomes in a file of another simulator, without that simulator."""
from pathlib import Path

import pytest

from gearbox_monitor.errors import InputError
from gearbox_monitor.plant.drive import DriveModel
from gearbox_monitor.plant.effects import EFFECTS
from gearbox_monitor.simulators.mjcf import (
    expression_of, EXPRESSIONS, KINDS, NATIVE, REFUSED, refused, values_of)
from gearbox_monitor.simulators.xml_edit import (
    behind, edited, parse_xml, with_attributes, with_child)

XML = b"""<?xml version="1.0"?>
<!-- a < b > c -->
<mujoco>
\t<worldbody>
\t\t<joint  name = 'a&amp;b' axis="0 0 1"   range="0 1"/> <!-- kept -->
\t</worldbody>
\t<actuator/>
</mujoco>"""


def test_each_effect_is_native_a_construct_or_refused():
    assert set(EXPRESSIONS) <= set(EFFECTS) and expression_of('of a plug-in').kind == REFUSED
    kinds = [expression.kind for expression in EXPRESSIONS.values()]
    assert set(kinds) <= set(KINDS)
    assert kinds.count(NATIVE) >= 23 and len(kinds) - kinds.count(REFUSED) >= 25


def test_the_page_has_the_table():
    text = (Path(__file__).parents[2] / 'docs/effects.md').read_text(encoding='utf-8')
    for name, row in ((name, expression_of(name)) for name in EFFECTS):
        assert f'\n| `{name}` | {row.kind} | {row.words} |' in text


def test_what_is_not_expressed_has_a_reason():
    model = DriveModel().with_(kind='play', effects=[
        {'id': 'mesh_error', 'A': 0.01, 'N': 3, 'phi': 0.0},
        {'id': 'hysteresis_branch', 'h': -0.02, 'ds': 0.02},
        {'id': 'hysteresis_bouc_wen', 'Th': -0.5, 'dh': 0.02}, {'id': 'torque_gain', 'g': 0.1}])
    values, exported = values_of(model)
    reasons = {row.id: row.words for row in refused(exported)}
    assert set(reasons) == {'transmission.kind', 'mesh_error', 'hysteresis_branch',
                            'hysteresis_bouc_wen'}
    assert 'supplies energy' in reasons['hysteresis_bouc_wen']
    assert values.gain == 1.1 and values.passive == ()


def test_lugre_takes_all_coulomb_friction_whatever_the_order():
    effects = [{'id': 'lugre', 'sigma0': 30.0, 'sigma1': 0.1, 'Cs': 0.1, 'vs': 0.2},
               {'id': 'motor_coulomb', 'Cc': 0.5}]
    values, _ = values_of(DriveModel().with_(effects=effects))
    assert values.motor_friction == 0.0
    assert values.passive[0].numbers == (30.0, 0.1, 0.5, 0.6, 0.2)


def test_edits_leave_every_other_byte():
    document = parse_xml(XML, 'a.xml')
    world, actuator = document.root.children
    joint, = world.children
    assert (joint.attributes['name'], joint.line) == ('a&b', 5)
    edits = [*with_attributes(document, joint, {'axis': '1 0 0', 'range': None, 'ref': '2'}),
             with_child(document, actuator, '<motor\n  joint="a"/>'),
             behind(document, joint, '<site/>')]
    expected = XML.replace(b'"0 0 1"   range="0 1"/>', b'"1 0 0" ref="2"/>\n\t\t<site/>')
    expected = expected.replace(
        b'<actuator/>', b'<actuator>\n\t  <motor\n\t    joint="a"/>\n\t</actuator>')
    assert edited(document, edits) == expected
    assert edited(document, []) == XML


def test_another_tag_at_both_ends():
    document = parse_xml(b'<a><motor x="1">\n</motor></a>', 'a.xml')
    edits = with_attributes(document, document.root.children[0], {}, 'general')
    assert edited(document, edits) == b'<a><general x="1">\n</general></a>'


def test_a_broken_file_is_one_line():
    with pytest.raises(InputError, match='a.xml: line 2: mismatched tag, expected XML'):
        parse_xml(b'<a>\n</b>', 'a.xml')
