(function () {
  'use strict';
  var live = document.getElementById('live'), lost = document.getElementById('lost');
  var source = new EventSource('events');

  source.onopen = function () {  // the server may be another one: begin with an empty page
    live.textContent = '';
    lost.hidden = true;
  };

  source.onerror = function () {
    if (lost.hidden) {
      lost.textContent = 'No connection since ' + new Date().toLocaleTimeString() +
        '. What follows is old.';
      lost.hidden = false;
    }
  };

  source.onmessage = function (event) {
    var parts = JSON.parse(event.data);
    Object.keys(parts).forEach(function (id) {
      var part = document.getElementById(id);
      if (!part) {
        part = document.createElement('section');
        part.id = id;
        live.appendChild(part);
      }
      var folded = part.querySelector('details'), open = folded && folded.open;
      part.innerHTML = parts[id];
      if (folded && part.querySelector('details')) {  // what a reader has opened stays so
        part.querySelector('details').open = open;
      }
    });
  };
}());
