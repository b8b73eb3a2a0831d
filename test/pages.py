# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""What tests of pages in a browser share."""
import json


def requests(browser):
    """Return the addresses the page has asked for since the last call."""
    messages = [json.loads(entry['message'])['message']
                for entry in browser.get_log('performance')]
    return [m['params']['request']['url'] for m in messages
            if m['method'] == 'Network.requestWillBeSent']


# Boxes that leave the window, or whose text is wider than they are; plots clip on purpose.
OVERFLOW = """
const width = document.documentElement.clientWidth, bad = [];
if (document.documentElement.scrollWidth > width) bad.push('the page');
for (const e of document.querySelectorAll('main *')) {
  const box = e.getBoundingClientRect();
  if (!box.width || e.closest('.plot svg')) continue;
  if (e.closest('.scroll')) continue;
  if (box.right > width + 0.5 || box.left < -0.5 ||
      (e.matches('td, dd, p, li, pre, figcaption, .row > div') && e.scrollWidth > e.clientWidth + 1
       && getComputedStyle(e).display != 'inline'))
    bad.push(e.tagName + '.' + e.className + ': ' + e.textContent.trim().slice(0, 60));
}
return bad;
"""


def overflowing(browser, address, width):
    """Return the boxes of the page at `address` that are cut off in a window `width` px wide."""
    browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
        'width': width, 'height': 900, 'deviceScaleFactor': 1, 'mobile': width < 600})
    browser.get(address)
    return browser.execute_script(OVERFLOW)
