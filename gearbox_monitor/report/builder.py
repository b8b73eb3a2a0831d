# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
The builder of all pages: a skeleton, its style and its script make one file that loads nothing.

Templates (Jinja2, autoescaped) stand in templates/, style and script in assets/.
"""
import base64
import hashlib
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from gearbox_monitor import __version__

ENVIRONMENT = Environment(
    loader=PackageLoader('gearbox_monitor.report'), autoescape=True, undefined=StrictUndefined,
    trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)


def asset(name: str) -> Markup:
    """Return the file `name` of assets/ as it is, to be inlined."""
    text = files('gearbox_monitor.report').joinpath('assets', name).read_text(encoding='utf-8')
    return Markup(text)  # noqa: S704


def content_policy(script: str) -> str:
    """Return the Content-Security-Policy of a page: nothing is loaded, only `script` runs."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; " \
        'img-src data:'


def render_page(title: str, sections: list[tuple[str, str]], summary: str = '') -> str:
    """
    Return a whole page as HTML.

    Args:
        title: plain text of the title and the first heading.
        sections: (heading, HTML) of each part, in order.
        summary: HTML above the first section.

    """
    script = asset('page.js')
    return ENVIRONMENT.get_template('page.html').render(
        title=title, summary=Markup(summary),  # noqa: S704
        sections=[(heading, Markup(content)) for heading, content in sections],  # noqa: S704
        style=asset('page.css'), script=script, policy=content_policy(script),
        version=__version__)
