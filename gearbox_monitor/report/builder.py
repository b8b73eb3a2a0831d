# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
The builder of all pages: a list of sections becomes one HTML file that loads nothing.

A section gathers its data and names its template. Templates (Jinja2, autoescaped) are in
templates/, style and script in assets/; both are inlined.
"""
import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
import hashlib
from importlib.resources import files
import json
import re
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import escape, Markup

from gearbox_monitor import __version__
from gearbox_monitor.presentation import on_axis
from gearbox_monitor.report.chart import bar_views, chart_view, plane_view


# Parts of texts that no line break divides: options, dates, values with their deviations.
WHOLE = r'--[a-z][a-z-]*|\d{4}-\d\d-\d\d|[+-]?[\d.]+ (± [\d.]+ \S+|%)'


@dataclass(frozen=True)
class Section:
    """
    A part of a page: data gathered beforehand, and the template that shows them.

    template: its file in templates/, which reads the `data` {name: value} as `section` and the
    axis of the drive as `axis`. heading: above the part ('' for a summary); folded: only the
    heading shows until a reader opens it.
    """

    template: str
    data: Mapping[str, Any]
    heading: str = ''
    folded: bool = False


@dataclass(frozen=True)
class Page:
    """A page: its title, the part above the sections, the sections, the axis of the drive."""

    title: str
    summary: Section
    sections: Sequence[Section]
    axis: str = 'rotary'


@dataclass(frozen=True)
class PageTable:
    """
    A table: header and rows of text.

    numeric: columns aligned to the right.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[object]]
    numeric: Sequence[int] = field(default=())


def units_of(text: str, axis: str) -> str:
    """Return `text` with the units of `axis`; escaped text stays escaped."""
    return type(text)(on_axis(text, axis))


def whole_words(text: str) -> Markup:
    """Return `text`, escaped; dates, percent and options such as --model stay in one line."""
    return Markup(re.sub(WHOLE, r'<span class="whole">\g<0></span>',  # noqa: S704
                         str(escape(text))))


@cache
def environment() -> Environment:
    """Return the Jinja2 environment of the pages."""
    jinja = Environment(
        loader=PackageLoader('gearbox_monitor.report'), autoescape=True, trim_blocks=True,
        lstrip_blocks=True, undefined=StrictUndefined)
    for drawer in (units_of, whole_words, chart_view, plane_view, bar_views):
        jinja.filters[drawer.__name__] = drawer
    return jinja


def asset(name: str) -> Markup:
    """Return the file `name` of assets/ as it is, to be inlined."""
    text = files('gearbox_monitor.report').joinpath('assets', name).read_text(encoding='utf-8')
    return Markup(text)  # noqa: S704


def content_policy(script: str) -> str:
    """Return the Content-Security-Policy of a page: nothing is loaded, only `script` runs."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; " \
        'img-src data:'


def render_section(section: Section, axis: str) -> str:
    """Return the HTML of `section` alone, in the units of `axis`."""
    return environment().get_template(section.template).render(
        section=section.data, axis=axis)


def framed(page: Page, template: str, script: str, sources: str = '') -> tuple[str, str]:
    """
    Return a page as HTML, and its Content-Security-Policy.

    Args:
        page: its title and sections.
        template: in templates/.
        script: in assets/.
        sources: further sources that the policy allows.
    """
    code = asset(script)
    policy = content_policy(code) + sources
    return environment().get_template(template).render(
        page=page, axis=page.axis, style=asset('page.css'), script=code, policy=policy,
        version=__version__), policy


def render_page(page: Page) -> str:
    """Return `page` as HTML."""
    return framed(page, 'page.html', 'page.js')[0]


def advice(steps: Sequence[str]) -> Section:
    """Return the section of `steps` to take, most urgent first."""
    return Section('next.html', {'steps': steps}, 'What to do next')


def page_summary(kind: str, headline: str, facts: Sequence[tuple[str, str]] = (),
                 notes: Sequence[str] = ()) -> Section:
    """
    Return the answer of a page.

    Args:
        kind: colour of the sentence: good, warn or error, '' for none.
        headline: the answer in one sentence.
        facts: the main figures, (name, text).
        notes: sentences below.
    """
    return Section('summary.html', {'kind': kind, 'headline': headline, 'facts': facts,
                                    'notes': notes})


def verdict_numbers(data: Mapping[str, Any]) -> Section:
    """Return the section with the `data` of a verdict as JSON."""
    return Section('numbers.html', {'json': json.dumps(data, indent=1)}, 'All numbers')
