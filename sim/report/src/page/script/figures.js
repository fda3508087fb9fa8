// Figures of a page: the charts of each, in place of its SVG.

/** Charts of one figure, in place of its SVG. */
function figure(root, data) {
  const all = JSON.parse(data.textContent);
  const own = { charts: [], timed: root.dataset.clock };
  const live = element('div', { className: all.length > 2 ? 'live many' : 'live' });
  for (const chart of all) {
    if (chart.why) live.append(element('p', { className: 'why' }, element('strong', { textContent: chart.title }), ` ${chart.why}`));
    else {
      own.charts.push(new Chart(chart, own));
      live.append(own.charts.at(-1).root);
    }
  }
  root.append(live);
  // One title is enough.
  const title = root.querySelector('figcaption strong')?.textContent;
  own.charts.forEach(chart => { chart.title.hidden = chart.of.title === title; });
  if (root.dataset.choice !== undefined && own.charts.length > 1) choice(live, own.charts);
  root.classList.add('is-live');
  own.charts.forEach(chart => chart.open());
}

/** One chart after the other at one place, so that what differs moves. */
function choice(live, charts) {
  const buttons = [...charts.map(chart => chart.of.title), 'All'].map((name, k) => {
    const button = element('button', { type: 'button', textContent: name });
    button.onclick = () => choose(k);
    return button;
  });
  const choose = chosen => {
    buttons.forEach((button, k) => button.setAttribute('aria-pressed', String(k === chosen)));
    charts.forEach((chart, k) => { chart.root.hidden = chosen < charts.length && k !== chosen; });
  };
  live.prepend(element('div', { className: 'choice' }, ...buttons));
  choose(charts.length);
}
