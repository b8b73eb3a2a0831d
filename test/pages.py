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
