# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""The index of a folder: which page belongs to which recording, and what comes first."""
import json

from gearbox_monitor.cli.main import main
from gearbox_monitor.report.builder import Page, page_summary, render_page


def test_a_folder_gets_an_index(tmp_path, capsys):
    for name in ('arm/monday & co', 'arm/tuesday'):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / 'metadata.yaml').write_text('rosbag2_bagfile_information: {}')
        (tmp_path / name / 'part_0.mcap').write_bytes(b'')
    for name, title, kind, words in (
            ('fleet/fleet.html', 'Fleet', 'good', 'No wear.'),
            ('a b.html', 'Recording arm/tuesday', 'warn', 'Grown & <b>'),
            ('gap/report.html', 'Diagnosis of tuesday, other', '', 'Friction.')):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(render_page(Page(title, page_summary(kind, words), ())))
    (tmp_path / 'foreign.html').write_text('<title>x</title><p class="lead">y</p>')
    for _ in range(2):  # again, with its own index there
        capsys.readouterr()
        assert main(['open', str(tmp_path), '--json']) == 0
    data = json.loads(capsys.readouterr().out)
    assert data['recordings'] == ['arm/monday & co', 'arm/tuesday']
    assert [page['headline'] for page in data['pages']] == ['Grown & <b>', 'No wear.', 'Friction.']
    html = (tmp_path / 'index.html').read_text()
    lead = html[html.index('class="lead"'):]
    assert 'Recording arm/tuesday: Grown &amp; &lt;b&gt;' in lead[:200]
    fleet, monday, tuesday, report, verdict = map(lead.index, (
        'href="fleet/fleet.html"', '<h3>arm/monday &amp; co</h3>', '<h3>arm/tuesday</h3>',
        'href="a%20b.html"', 'href="gap/report.html"'))
    assert fleet < monday < tuesday < report < verdict
    assert 'gearbox_monitor report &#39;arm/monday &amp; co&#39;' in lead and 'foreign' not in html


def test_an_empty_folder_is_refused(tmp_path, capsys):
    assert main(['open', str(tmp_path)]) == 2
    assert 'no recording and no page' in capsys.readouterr().err
