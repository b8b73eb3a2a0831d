# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Make the pictures of pages: python docs/make_pictures.py.

Each is the page of a command of the documentation, drawn by a headless Chromium.
"""
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile

DOCS = Path(__file__).parent
BROWSERS = 'chromium', 'chromium-browser', 'google-chrome'
# Picture: commands, page, width and height in pixels.
PICTURES = {'robot_gap.png': (
    ('example arm --robot',
     'diagnose arm/today.csv --model arm/robot.urdf --reference arm/healthy.csv --out gap'),
    'gap/report.html', 1000, 1010)}


def drawn(page: Path, picture: Path, width: int, height: int) -> None:
    """Draw the top of a `page` as a `picture` of `width` x `height` pixels."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        sys.exit(f'no browser, expected one of {", ".join(BROWSERS)}')
    subprocess.run([browser, '--headless', '--no-sandbox', '--disable-gpu', '--hide-scrollbars',
                    f'--window-size={width},{height}', f'--screenshot={picture}',
                    page.as_uri()], check=True, stderr=subprocess.DEVNULL)


for name, (commands, page, width, height) in PICTURES.items():
    with tempfile.TemporaryDirectory() as folder:
        for command in commands:
            code = subprocess.run([sys.executable, '-m', 'gearbox_monitor', *command.split()],
                                  cwd=folder).returncode
            if code not in (0, 1):  # 1: diagnose identified a difference
                sys.exit(code)
        drawn(Path(folder) / page, DOCS / name, width, height)
