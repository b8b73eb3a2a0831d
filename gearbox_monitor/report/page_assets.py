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
Style and script of every page.

Nothing is loaded from elsewhere. Without the script the page shows everything, unzoomed. Colours
of Okabe and Ito, which colour-blind people can tell apart; light, dark and on paper.
"""

STYLE = """
:root { color-scheme: light dark; --bg: #ffffff; --fg: #1b1d21; --soft: #585d66; --line: #d6d9de;
  --card: #f5f6f8; --recording: #1b1d21; --nominal: #c94f00; --closed: #0072b2;
  --signal: #00795a; --warn: #c94f00; --good: #00795a; --bar: #0072b2;
  --early: #0072b2; --late: #e08a00; }
@media (prefers-color-scheme: dark) { :root { --bg: #15171b; --fg: #e9eaec; --soft: #a3a8b1;
  --line: #3a3e46; --card: #1e2127; --recording: #e9eaec; --nominal: #ff9248; --closed: #63b8ee;
  --signal: #35c99f; --warn: #ff9248; --good: #35c99f; --bar: #3f97cf;
  --early: #63b8ee; --late: #ffb84d; } }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0; background: var(--bg); color: var(--fg);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 20px 24px 60px; }
h1 { font-size: 1.05rem; font-weight: 600; color: var(--soft); margin: 0 0 4px; }
h2 { font-size: 1.25rem; margin: 40px 0 8px; padding-top: 8px; border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 20px 0 6px; }
p { margin: 6px 0 10px; max-width: 46rem; }
.lead { font-size: 1.6rem; line-height: 1.3; font-weight: 650; margin: 0 0 8px; max-width: none; }
.soft, small { color: var(--soft); font-size: .875rem; }
code { font: .9em ui-monospace, Menlo, Consolas, monospace; }
.verdict { background: var(--card); border-left: 6px solid var(--closed); border-radius: 6px;
  padding: 18px 20px; }
.verdict.warn { border-color: var(--warn); } .verdict.good { border-color: var(--good); }
.facts { display: flex; flex-wrap: wrap; gap: 10px 32px; margin: 14px 0 0; padding: 0; }
.facts div { min-width: 7rem; } .facts dt { color: var(--soft); font-size: .8rem; }
.facts dd { margin: 0; font-size: 1.15rem; font-weight: 600; font-variant-numeric: tabular-nums; }
nav { margin: 14px 0 0; display: flex; flex-wrap: wrap; gap: 4px 16px; font-size: .9rem; }
a { color: var(--closed); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 8px 0; }
th, td { text-align: left; padding: 4px 14px 4px 0; border-bottom: 1px solid var(--line);
  vertical-align: top; }
th { font-weight: 600; font-size: .85rem; color: var(--soft); }
td.n, th.n { text-align: right; }
ul { padding-left: 1.2em; max-width: 46rem; } li { margin: 4px 0; }
pre { overflow: auto; max-height: 420px; background: var(--card); padding: 12px; font-size: 12px; }
details { margin: 12px 0; } summary { cursor: pointer; color: var(--closed); }

.bars { margin: 10px 0; display: grid; gap: 7px; }
.bars .row { display: grid; grid-template-columns: minmax(8rem, 15rem) 1fr 8.5rem; gap: 12px;
  align-items: center; font-size: .92rem; }
.bars .track { position: relative; height: 18px; background: var(--card); border-radius: 3px; }
.bars .fill { position: absolute; top: 0; bottom: 0; left: 0; border-radius: 3px;
  background: var(--bar); min-width: 2px; }
.bars .fill.nominal { background: var(--nominal); } .bars .fill.closed { background: var(--bar); }
.bars .fill.faint { opacity: .45; }
.bars .whisker { position: absolute; top: 4px; bottom: 4px; border: solid var(--fg);
  border-width: 0 2px; }
.bars .whisker::after { content: ""; position: absolute; left: 0; right: 0; top: 50%;
  border-top: 2px solid var(--fg); transform: translateY(-1px); }
.bars .value { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.bars small { display: block; line-height: 1.25; }

.grid { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 8px 28px; }
figure { margin: 14px 0 18px; min-width: 0; }
figcaption { font-size: .9rem; font-weight: 600; }
.legend { display: flex; flex-wrap: wrap; gap: 2px 16px; font-size: .85rem; color: var(--soft); }
.legend span { display: inline-flex; align-items: center; gap: 6px; }
.legend svg { width: 26px; height: 8px; }
.tools { float: right; display: none; gap: 4px; } .js .tools { display: flex; }
button { font: inherit; font-size: .85rem; color: var(--fg); background: var(--card);
  border: 1px solid var(--line); border-radius: 5px; padding: 3px 10px; cursor: pointer;
  min-height: 30px; }
button:focus-visible, summary:focus-visible, a:focus-visible { outline: 2px solid var(--closed);
  outline-offset: 1px; }
button[aria-selected=true] { background: var(--closed); color: var(--bg);
  border-color: var(--closed); }
.readout { font-size: .8rem; color: var(--soft); min-height: 1.5em; display: none;
  margin-left: 54px;  font-variant-numeric: tabular-nums; } .js .readout { display: block; }
.panel { margin: 6px 0 0 54px; }
.ylabel { font-size: .78rem; color: var(--soft); margin-left: -54px; }
.plot { position: relative; touch-action: pan-y; }
.plot svg { position: absolute; inset: 0; width: 100%; height: 100%; overflow: hidden;
  border: 1px solid var(--line); }
.js .plot { cursor: crosshair; }
.yt, .xt span { font-size: .75rem; color: var(--soft); position: absolute; line-height: 1;
  font-variant-numeric: tabular-nums; white-space: nowrap; }
.yt { right: calc(100% + 6px); transform: translateY(-50%); }
.xt { position: relative; height: 18px; margin: 4px 0 0 54px; }
.xt span { transform: translateX(-50%); }
.xlabel { font-size: .78rem; color: var(--soft); text-align: center; margin-left: 54px; }
.cursor { position: absolute; top: 0; bottom: 0; width: 0; border-left: 1px solid var(--soft);
  pointer-events: none; display: none; }
.range { position: absolute; top: 0; bottom: 0; background: var(--closed); opacity: .18;
  pointer-events: none; display: none; }
path { fill: none; vector-effect: non-scaling-stroke; stroke-width: 1.5; }
path.grid { stroke: var(--line); stroke-width: 1; }
path.zero { stroke: var(--soft); stroke-width: 1; stroke-dasharray: 2 3; }
path.recording { stroke: var(--recording); stroke-width: 1.8; }
path.nominal { stroke: var(--nominal); stroke-dasharray: 6 3; }
path.closed { stroke: var(--closed); }
path.faint { stroke-width: .8; opacity: .3; stroke-dasharray: none; }
path.firm { stroke-width: 1.8; stroke-dasharray: none; }
path.signal { stroke: var(--signal); stroke-width: 2; }
path.warn { stroke: var(--warn); stroke-dasharray: 8 4; }
path.error { stroke: var(--fg); stroke-dasharray: 2 3; stroke-width: 1.8; }
path.limit { stroke: var(--soft); stroke-dasharray: 5 3; stroke-width: 1.2; }
path.dots { stroke-width: 5; stroke-linecap: round; stroke-dasharray: none; }
path.band { fill: var(--signal); stroke: none; opacity: .18; }
path.band.closed { fill: var(--closed); } path.band.recording { fill: var(--recording); }
path.mark { stroke-width: 1.5; stroke-dasharray: none; }
path.lane { stroke: none; } path.level0 { fill: var(--good); opacity: .6; }
path.level1 { fill: var(--warn); } path.level2 { fill: var(--fg); }

.marks { position: relative; height: 20px; margin-left: 54px; }
.mk { position: absolute; transform: translateX(-50%); font-size: .75rem; font-weight: 600;
  line-height: 1; padding: 3px 5px; border-radius: 4px; background: var(--warn);
  color: var(--bg); white-space: nowrap; }
.mk.error { background: var(--fg); } .mk.good { background: var(--good); }
path.good { stroke: var(--good); }
path.cloud { stroke: var(--soft); stroke-width: 2.5; stroke-linecap: round; opacity: .55;
  display: none; }
path.mean { stroke: var(--early); stroke-width: 1.6;
  stroke: color-mix(in oklab, var(--late) calc(var(--t) * 100%), var(--early)); }
.slice.on path.cloud { display: inline; }
.slice.on path.mean { stroke-width: 3; stroke: var(--fg); }
.picked .slice:not(.on) path.mean { opacity: .3; }
.picked .first:not(.on) path.mean { opacity: 1; stroke-dasharray: 5 3; }
.alone path.cloud { display: inline; }
.early-late { background: linear-gradient(to right in oklab, var(--early), var(--late)); }
.pick { display: none; gap: 8px; align-items: center; font-size: .85rem; margin: 6px 0; }
.js .pick { display: flex; } .pick input { flex: 1 1 8rem; max-width: 26rem; min-width: 0; }
.pick output { min-width: 9em; font-variant-numeric: tabular-nums; }

.tabbar { display: none; flex-wrap: wrap; gap: 6px; margin: 10px 0; }
.js .tabbar { display: flex; }
.js .tab[hidden] { display: none; }
.js .tab > h3 { display: none; }
table.matrix { font-size: .85rem; } table.matrix td, table.matrix th { padding: 5px 8px; }
table.matrix td.cell { text-align: right; border: 1px solid var(--bg); min-width: 3.1em;
  background: rgb(230 120 0 / calc(var(--v) * .75)); }
.heat { display: flex; gap: 12px; align-items: center; font-size: .8rem; color: var(--soft); }
.heat i { display: inline-block; width: 160px; height: 12px; border: 1px solid var(--line); }
.plot rect { shape-rendering: crispEdges; }

@media (max-width: 640px) {
  main { padding: 14px 14px 40px; } .lead { font-size: 1.3rem; }
  .grid { grid-template-columns: minmax(0, 1fr); }
  .bars .row { grid-template-columns: 1fr auto; gap: 2px 10px; }
  .bars .track { grid-column: 1 / -1; order: 3; }
  .verdict { padding: 14px; }
}
@media print {
  :root { color-scheme: light; --bg: #ffffff; --fg: #1b1d21; --soft: #585d66; --line: #d6d9de;
    --card: #f5f6f8; --recording: #1b1d21; --nominal: #c94f00; --closed: #0072b2;
    --signal: #00795a; --warn: #c94f00; --good: #00795a; --bar: #0072b2; --early: #0072b2;
    --late: #e08a00; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  body { font-size: 11pt; } main { max-width: none; padding: 0; }
  .js .tools, .js .readout, .js .tabbar, .js .pick, nav { display: none; }
  .js .tab[hidden] { display: block; } .js .tab > h3 { display: block; }
  figure, .bars, tr { break-inside: avoid; } h2, h3 { break-after: avoid; }
}
"""

SCRIPT = """
(function () {
  'use strict';
  var NONE = 'no value';
  document.documentElement.classList.add('js');

  function short(v, span) {
    if (!isFinite(v)) { return NONE; }
    var digits = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(Math.abs(span) || 1))));
    return v.toFixed(digits);
  }

  function ticks(a, b) {
    var raw = (b - a) / 5, power = Math.pow(10, Math.floor(Math.log10(raw))), out = [], step;
    [1, 2, 5, 10].some(function (m) { step = m * power; return step >= 0.75 * raw; });
    for (var k = Math.ceil(a / step - 1e-9); k * step <= b + 1e-9 * step; k += 1) {
      out.push(k * step);
    }
    return { at: out, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
  }

  function points(path) {
    if (!path.known) {
      path.known = path.getAttribute('d').split(/(?=[ML])/).map(function (word) {
        var pair = word.slice(1).split(' ');
        return [parseFloat(pair[0]), parseFloat(pair[1])];
      });
    }
    return path.known;
  }

  function valueAt(path, x) {
    var list = points(path), low = 0, high = list.length - 1;
    if (high < 0 || x < list[0][0] || x > list[high][0]) { return NaN; }
    while (high - low > 1) {
      var middle = (low + high) >> 1;
      if (list[middle][0] <= x) { low = middle; } else { high = middle; }
    }
    return Math.abs(list[low][0] - x) <= Math.abs(list[high][0] - x)
      ? list[low][1] : list[high][1];
  }

  function marksAt(a, b) {  // ticks, and how far along the axis each stands (0 to 1)
    var marks = ticks(a, b);
    marks.at = marks.at.map(function (v) {
      return { part: (v - a) / (b - a), text: v.toFixed(marks.digits), value: v };
    });
    return marks.at;
  }

  function label(parent, side, part, text, name) {
    var span = document.createElement('span');
    span.style[side] = 100 * part + '%';
    span.textContent = text;
    if (name) { span.className = name; }
    parent.appendChild(span);
  }

  var groups = {};

  document.querySelectorAll('figure.chart').forEach(function (figure) {
    var first = +figure.dataset.from, last = +figure.dataset.to, a = first, b = last;
    var plots = figure.querySelectorAll('.plot'), axis = figure.querySelector('.xt');
    var readout = figure.querySelector('.readout'), unit = figure.dataset.x;

    function unitsOf(x) { return (x - first) / (last - first) * 10000; }

    var members = groups[figure.dataset.group] || [draw];
    if (figure.dataset.group) {
      groups[figure.dataset.group] = members;
      members.push(draw);
    }

    function show(from, to) {
      var width = Math.min(to - from, last - first);
      if (!(width > (last - first) / 500)) { return; }
      var begin = Math.max(first, Math.min(from, last - width));
      members.forEach(function (member) { member(begin, begin + width); });
    }

    function draw(from, to) {
      a = from;
      b = to;
      var lines = '';
      axis.textContent = '';
      marksAt(a, b).forEach(function (mark) {
        label(axis, 'left', mark.part, mark.text);
        lines += 'M' + unitsOf(mark.value) + ' 0V10000';
      });
      figure.querySelectorAll('.mk').forEach(function (mark) {
        var part = (mark.dataset.at - a) / (b - a);
        mark.style.left = 100 * part + '%';
        mark.hidden = part < 0 || part > 1;
      });
      plots.forEach(function (plot) {
        var svg = plot.querySelector('svg');
        svg.setAttribute('viewBox', unitsOf(a) + ' 0 ' + (unitsOf(b) - unitsOf(a)) + ' 10000');
        svg.querySelector('.xgrid').setAttribute('d', lines);
        plot.querySelector('.cursor').style.display = 'none';
      });
      figure.dataset.shown = a + ' ' + b;
    }

    function spanAt(plot, x) {
      var spans = JSON.parse(plot.dataset.spans), words = NONE;
      spans.forEach(function (span) {
        if (span[0] <= x && x <= +plot.dataset.end) { words = span[1]; }
      });
      return words;
    }

    function at(plot, event) {
      var box = plot.getBoundingClientRect();
      var part = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
      return { part: part, x: a + part * (b - a) };
    }

    function read(x, part) {
      var words = [unit + ' ' + short(x, b - a)];
      plots.forEach(function (plot) {
        var low = +plot.dataset.low, high = +plot.dataset.high;
        var cursor = plot.querySelector('.cursor');
        cursor.style.left = 100 * part + '%';
        cursor.style.display = 'block';
        plot.querySelectorAll('path[data-name]').forEach(function (path) {
          var v = high - valueAt(path, unitsOf(x)) / 10000 * (high - low);
          words.push(path.dataset.name + ' ' + short(v, high - low));
        });
        if (plot.dataset.spans) { words.push(spanAt(plot, x)); }
      });
      readout.textContent = words.join(' \\u00b7 ');
    }

    plots.forEach(function (plot) {
      var start = null, range = plot.querySelector('.range');
      plot.addEventListener('pointerdown', function (event) {
        start = at(plot, event);
        if (plot.setPointerCapture) { plot.setPointerCapture(event.pointerId); }
      });
      plot.addEventListener('pointermove', function (event) {
        var here = at(plot, event);
        read(here.x, here.part);
        if (start) {
          range.style.display = 'block';
          range.style.left = 100 * Math.min(start.part, here.part) + '%';
          range.style.width = 100 * Math.abs(start.part - here.part) + '%';
        }
      });
      plot.addEventListener('pointerup', function (event) {
        var here = at(plot, event);
        range.style.display = 'none';
        if (start && Math.abs(here.part - start.part) > 0.01) {
          show(Math.min(start.x, here.x), Math.max(start.x, here.x));
        }
        start = null;
      });
      plot.addEventListener('pointercancel', function () {
        start = null;
        range.style.display = 'none';
      });
      plot.addEventListener('dblclick', function () { show(first, last); });
    });
    figure.querySelectorAll('[data-zoom]').forEach(function (button) {
      button.addEventListener('click', function () {
        var middle = (a + b) / 2, half = (b - a) / 2, what = button.dataset.zoom;
        if (what === 'all') { show(first, last); }
        if (what === 'in') { show(middle - half / 2, middle + half / 2); }
        if (what === 'out') { show(middle - half * 2, middle + half * 2); }
        if (what === 'left') { show(a - half, b - half); }
        if (what === 'right') { show(a + half, b + half); }
      });
    });
  });

  document.querySelectorAll('figure.plane').forEach(function (figure) {
    var d = figure.dataset, whole = [+d.left, +d.right, +d.low, +d.high], now = whole.slice();
    var plot = figure.querySelector('.plot'), svg = plot.querySelector('svg');
    var xt = figure.querySelector('.xt'), yts = figure.querySelector('.yts');
    var range = plot.querySelector('.range'), start = null;

    function part(v, k) { return (v - whole[k]) / (whole[k + 1] - whole[k]); }

    function show(box) {
      var k, width, lines = '', x, y;
      for (k = 0; k < 4; k += 2) {
        width = Math.min(box[k + 1] - box[k], whole[k + 1] - whole[k]);
        if (!(width > (whole[k + 1] - whole[k]) / 200)) { return; }
        now[k] = Math.max(whole[k], Math.min(box[k], whole[k + 1] - width));
        now[k + 1] = now[k] + width;
      }
      x = [part(now[0], 0), part(now[1], 0)];
      y = [1 - part(now[3], 2), 1 - part(now[2], 2)];
      svg.setAttribute('viewBox', [x[0], y[0], x[1] - x[0], y[1] - y[0]].map(function (v) {
        return 10000 * v;
      }).join(' '));
      xt.textContent = yts.textContent = '';
      marksAt(now[0], now[1]).forEach(function (mark) {
        label(xt, 'left', mark.part, mark.text);
        lines += 'M' + 10000 * part(mark.value, 0) + ' 0V10000';
      });
      marksAt(now[2], now[3]).forEach(function (mark) {
        label(yts, 'top', 1 - mark.part, mark.text, 'yt');
        lines += 'M0 ' + 10000 * (1 - part(mark.value, 2)) + 'H10000';
      });
      svg.querySelector('.lattice').setAttribute('d', lines);
      d.shown = now.join(' ');
    }

    function scaled(factor) {
      return [0, 0, 2, 2].map(function (k, i) {
        var half = (now[k + 1] - now[k]) / 2;
        return now[k] + half + (i % 2 ? 1 : -1) * half * factor;
      });
    }

    function at(event) {
      var box = plot.getBoundingClientRect();
      return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height]
        .map(function (v) { return Math.min(1, Math.max(0, v)); });
    }

    function dragged(here) {
      return [Math.min(start[0], here[0]), Math.max(start[0], here[0]),
        Math.min(start[1], here[1]), Math.max(start[1], here[1])];
    }

    plot.addEventListener('pointerdown', function (event) {
      start = at(event);
      if (plot.setPointerCapture) { plot.setPointerCapture(event.pointerId); }
    });
    plot.addEventListener('pointermove', function (event) {
      if (!start) { return; }
      var box = dragged(at(event));
      range.style.display = 'block';
      range.style.left = 100 * box[0] + '%';
      range.style.width = 100 * (box[1] - box[0]) + '%';
      range.style.top = 100 * box[2] + '%';
      range.style.height = 100 * (box[3] - box[2]) + '%';
    });
    plot.addEventListener('pointerup', function (event) {
      var box = start && dragged(at(event)), w = now[1] - now[0], h = now[3] - now[2];
      range.style.display = 'none';
      start = null;
      if (box && box[1] - box[0] > 0.02 && box[3] - box[2] > 0.02) {
        show([now[0] + box[0] * w, now[0] + box[1] * w,
          now[3] - box[3] * h, now[3] - box[2] * h]);
      }
    });
    plot.addEventListener('pointercancel', function () {
      start = null;
      range.style.display = 'none';
    });
    plot.addEventListener('dblclick', function () { show(whole); });
    figure.querySelectorAll('[data-zoom]').forEach(function (button) {
      button.addEventListener('click', function () {
        show(button.dataset.zoom === 'all' ? whole : scaled(
          button.dataset.zoom === 'in' ? 0.5 : 2));
      });
    });

    var slices = figure.querySelectorAll('.slice'), slider = figure.querySelector('.pick input');
    if (!slider) { return; }
    var output = figure.querySelector('output');
    function choose() {
      var k = +slider.value;
      figure.classList.toggle('picked', k > 0);
      slices.forEach(function (slice, i) { slice.classList.toggle('on', i === k - 1); });
      if (k) { slices[k - 1].parentNode.appendChild(slices[k - 1]); }
      output.textContent = k ? slices[k - 1].dataset.name : 'all';
    }
    slider.addEventListener('input', choose);
    figure.querySelectorAll('[data-pick]').forEach(function (button) {
      button.addEventListener('click', function () {
        slider.value = +slider.value + +button.dataset.pick;
        choose();
      });
    });
  });

  document.querySelectorAll('.tabs').forEach(function (tabs) {
    var buttons = tabs.querySelectorAll('.tabbar button');
    var parts = tabs.querySelectorAll('.tab');
    function choose(k) {
      buttons.forEach(function (b, i) { b.setAttribute('aria-selected', String(i === k)); });
      parts.forEach(function (p, i) { p.hidden = i !== k; });
    }
    buttons.forEach(function (button, k) {
      button.addEventListener('click', function () { choose(k); });
    });
    choose(0);
  });
}());
"""
