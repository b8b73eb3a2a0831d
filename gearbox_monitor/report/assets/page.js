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
      readout.textContent = words.join(' \u00b7 ');
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
