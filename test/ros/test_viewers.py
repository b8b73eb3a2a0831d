# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The layouts for PlotJuggler and Foxglove are in the form these read, and name what is recorded.

The rules are those of their loaders; names and paths are looked up in a recording.
"""
import json
from pathlib import Path
import re
import xml.etree.ElementTree as ElementTree

from live import worn, write_inputs, write_live
import pytest

from gearbox_monitor.recordings.read import open_bag
from gearbox_monitor.recordings.write import BagWriter

CONFIG = Path(__file__).parents[2] / 'config'
JUGGLER = ElementTree.parse(CONFIG / 'plotjuggler.xml').getroot()
FOXGLOVE = json.loads((CONFIG / 'foxglove.json').read_text(encoding='utf-8'))
COLOUR = re.compile('#[0-9a-f]{6}')


@pytest.fixture(scope='module')
def messages(tmp_path_factory):
    """Return {topic: messages} of a recording with an estimator that has a baseline."""
    path, found = tmp_path_factory.mktemp('viewers') / 'bag', {}
    samples = worn(10)
    with BagWriter(path) as writer:
        write_inputs(writer, samples)
        write_live(writer, samples)
    with open_bag(path) as reader:
        for topic, _, _, raw in reader.messages():
            found.setdefault(topic, [])
            if len(found[topic]) < 3000:
                found[topic].append(reader.decode(reader.topics[topic][0], raw))
    return found


# ---------------------------------------------------------------------- PlotJuggler


@pytest.fixture(scope='module')
def series(messages):
    """Return {name of a series: topic it comes from}, as PlotJuggler calls what it reads."""
    found = {}
    for topic, those in messages.items():
        for message in those:
            if hasattr(message, 'status'):
                for status in message.status:
                    owner = '/'.join(filter(None, (topic, status.hardware_id, status.name)))
                    found[f'{owner}/level'] = topic
                    found.update({f'{owner}/{pair.key}': topic for pair in status.values
                                  if re.fullmatch(r'[-+]?\d.*', pair.value)})
            else:
                for field in ('position', 'velocity', 'effort'):
                    for joint, _ in zip(message.name, getattr(message, field)):
                        found[f'{topic}/{joint}/{field}'] = topic
    return found


@pytest.fixture(scope='module')
def made(series):
    """Return {name of a custom series: topic whose stamps it has}; all of them compute."""
    found = {}
    for snippet in JUGGLER.find('customMathEquations'):
        assert snippet.tag == 'snippet' and snippet.get('language') == 'LUA'
        source = snippet.findtext('linked_source')
        more = [e.text for e in snippet.find('additional_sources') or ()]
        assert [e.tag for e in snippet.find('additional_sources') or ()] == [
            f'v{k + 1}' for k in range(len(more))]
        assert {source, *more} <= set(series) and snippet.find('global') is not None
        found[snippet.get('name')] = series[source]
        expression = re.fullmatch(r'return ([-+*\s\dvalue]+)',
                                  snippet.findtext('function'))[1]
        sign = -1.0 if ' - ' in snippet.get('name') else 1.0
        value = eval(expression, {'value': 10.0, 'v1': 0.5})
        assert value == (10.0 + sign * 1.0 if more else sign * 20.0)
    assert not set(found) & set(series)
    return found


def plots():
    return JUGGLER.iter('plot')


def test_plotjuggler_layout_has_the_form_that_is_loaded():
    assert JUGGLER.tag == 'root'
    main, = JUGGLER.findall('tabbed_widget')
    assert (main.get('name'), main.get('parent')) == ('Main Window', 'main_window')
    tabs = main.findall('Tab')
    assert len({tab.get('tab_name') for tab in tabs}) == len(tabs) >= 4
    assert int(main.find('currentTabIndex').get('index')) in range(len(tabs))
    for tab in tabs:
        containers = tab.findall('Container')
        assert len(containers) == int(tab.get('containers')) == 1
        splitters = [child for child in containers[0]]
        assert [s.tag for s in splitters] == ['DockSplitter']
    for splitter in JUGGLER.iter('DockSplitter'):
        sizes = [float(v) for v in splitter.get('sizes').split(';')]
        assert splitter.get('orientation') in ('|', '-')
        assert int(splitter.get('count')) == len(list(splitter)) == len(sizes)
        assert sum(sizes) == pytest.approx(1.0, abs=1e-4)
        assert {child.tag for child in splitter} <= {'DockArea', 'DockSplitter'}
    for area in JUGGLER.iter('DockArea'):
        assert area.get('name') and [child.tag for child in area] == ['plot']
    for plot in plots():
        assert plot.get('mode') in ('TimeSeries', 'XYPlot')
        assert plot.get('style') in ('Lines', 'Dots', 'LinesAndDots', 'Sticks', 'Steps')
        assert plot.get('line_width') in ('1.0', '1.5', '2.0', '3.0')
        names = [curve.get('name') for curve in plot.findall('curve')]
        assert names and len(set(names)) == len(names)
        for curve in plot.findall('curve'):
            assert COLOUR.fullmatch(curve.get('color'))
            assert ('curve_x' in curve.attrib) == (plot.get('mode') == 'XYPlot')


def test_plotjuggler_finds_every_curve(series, made):
    known, shown = {**series, **made}, set()
    for plot in plots():
        for curve in plot.findall('curve'):
            if plot.get('mode') == 'XYPlot':
                # Both must have the same stamps.
                assert known[curve.get('curve_x')] == known[curve.get('curve_y')]
                shown |= {curve.get('curve_x'), curve.get('curve_y')}
            else:
                assert curve.get('name') in known, curve.get('name')
                shown.add(curve.get('name'))
    assert set(made) <= shown
    for wanted in ('/transmission_state_smoothed/transmission/effort',
                   '/diagnostics/gearbox/estimator: backlash/gap_rad',
                   '/diagnostics/gearbox/estimator: observability/level',
                   '/innovations/arm/position'):
        assert wanted in shown


# ---------------------------------------------------------------------- Foxglove


ELEMENT = re.compile(r'\.(\w+)(?:\[(\d+|:)\])?(?:\{(\w+)=="([^"]+)"\})?')


def values(path, messages):
    """Return what a message path gives on all messages of its topic; None where it is none."""
    topic, rest = re.fullmatch(r'((?:/\w+)+)(.*)', path).groups()
    found = messages.get(topic, [])
    if ''.join(match[0] for match in ELEMENT.finditer(rest)) != rest:
        return None
    for name, index, key, wanted in ELEMENT.findall(rest):
        found = [getattr(item, name) for item in found]
        if index:
            found = [item for many in found
                     for item in (many if index == ':' else many[int(index):int(index) + 1])]
        if key:
            found = [item for item in found if getattr(item, key) == wanted]
    return found


def panels(node):
    if isinstance(node, str):
        return [node]
    assert node['direction'] in ('row', 'column') and 5 <= node['splitPercentage'] <= 95
    return panels(node['first']) + panels(node['second'])


def test_foxglove_layout_has_the_form_that_is_loaded():
    assert set(FOXGLOVE) == {'configById', 'globalVariables', 'userNodes', 'playbackConfig',
                             'layout'}
    assert FOXGLOVE['playbackConfig'] == {'speed': 1} and FOXGLOVE['globalVariables'] == {}
    assert sorted(panels(FOXGLOVE['layout'])) == sorted(FOXGLOVE['configById'])
    for name, config in FOXGLOVE['configById'].items():
        kind = name.split('!')[0]
        assert kind in ('Plot', 'StateTransitions', 'DiagnosticSummary')
        if kind == 'DiagnosticSummary':
            assert config['topicToRender'] == '/diagnostics' and config['minLevel'] == 0
            continue
        assert config['paths'] and isinstance(config['isSynced'], bool)
        for path in config['paths']:
            assert path['enabled'] is True and path['label']
            assert path['timestampMethod'] in ('receiveTime', 'headerStamp')
        if kind == 'Plot':
            assert all(COLOUR.fullmatch(path['color']) for path in config['paths'])
            assert config['legendDisplay'] in ('floating', 'top', 'left', 'none')
            assert config['xAxisVal'] == ('custom' if 'xAxisPath' in config else 'timestamp')
    for script in FOXGLOVE['userNodes'].values():
        assert re.search(r'^export const output = "/studio_script/\w+";$', script['sourceCode'],
                         re.MULTILINE)


def test_foxglove_finds_every_path(messages):
    outputs = {}
    for script in FOXGLOVE['userNodes'].values():
        source = script['sourceCode']
        inputs = re.findall(r'"([^"]+)"', re.search(r'inputs = \[([^]]+)\]', source)[1])
        assert set(inputs) <= set(messages)
        kind = re.search(r'type Output = \{([^}]+)\}', source)[1]
        outputs[re.search(r'output = "([^"]+)"', source)[1]] = re.findall(r'(\w+): number', kind)
    for config in FOXGLOVE['configById'].values():
        paths = [*config.get('paths', ()), *filter(None, [config.get('xAxisPath')])]
        for path in (p['value'] for p in paths):
            topic, _, field = path.partition('.')
            if topic in outputs:
                assert field in outputs[topic]
                continue
            found = values(path, messages)
            assert found, path
            assert all(float(value) == float(value) for value in found), path


def test_foxglove_scripts_compute_the_bands(messages, browser):
    """What TypeScript adds is taken away: the rest is run as it stands."""
    def plain(message):
        stamp = message.header.stamp
        return {'header': {'stamp': {'sec': stamp.sec, 'nsec': stamp.nanosec}},
                'name': list(message.name), 'position': message.position.tolist(),
                'effort': message.effort.tolist()}

    def run(name, events):
        source = FOXGLOVE['userNodes'][name]['sourceCode']
        for pattern, rest in (
                (r'import .*\n', ''), (r'type Output = \{[^}]*\};', ''),
                (r'export (default )?', ''),
                (r': Input<[^>]*>(\["message"\])?( \| (Input<[^>]*>|undefined))?', ''),
                (r'\): (Output \| undefined|number)', ')'), (r': (string\[\]|number\b)', '')):
            source = re.sub(pattern, rest, source)
        code = f'{source}\nreturn arguments[0].map(function (e) {{ return script(e) ?? null; }});'
        return browser.execute_script(code, events)
    state, std = (plain(messages[topic][500]) for topic in (
        '/transmission_state', '/transmission_state_stddev'))
    late = plain(messages['/transmission_state_stddev'][501])
    first, second, third = run('torque_band', [
        {'topic': '/transmission_state', 'message': state},
        {'topic': '/transmission_state_stddev', 'message': std},
        {'topic': '/transmission_state_stddev', 'message': late}])
    assert first is None and third is None
    assert second == pytest.approx({
        'twist': state['position'][0], 'tau_k': state['effort'][0],
        'low': state['effort'][0] - 2 * std['effort'][0],
        'high': state['effort'][0] + 2 * std['effort'][0]})
    error, std = (plain(messages[topic][500]) for topic in ('/innovations', '/innovations_stddev'))
    alone = [{**message, 'name': ['arm'], 'position': message['position'][1:]}
             for message in (error, std)]
    events = [{'topic': topic, 'message': message} for pair in ((error, std), alone)
              for topic, message in zip(('/innovations', '/innovations_stddev'), pair)]
    _, both, _, one = run('error_band', events)
    assert both == pytest.approx({
        'motor': error['position'][0], 'motor_low': -2 * std['position'][0],
        'motor_high': 2 * std['position'][0], 'arm': error['position'][1],
        'arm_low': -2 * std['position'][1], 'arm_high': 2 * std['position'][1]})
    assert one['motor'] is None and one['arm'] == both['arm'] and one['arm_low'] == both['arm_low']
