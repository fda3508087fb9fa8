// Measures a page from within, and tells the page that frames it.
addEventListener('load', () => {
  // What is folded away must be readable, too.
  document.querySelectorAll('details').forEach(details => { details.open = true; });
  const texts = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode()); ) {
    if (!node.data.trim() || node.parentElement.closest('script, style')) continue;
    const svg = node.parentElement.closest('svg');
    const range = document.createRange();
    range.selectNodeContents(node);
    const rects = svg ? [node.parentElement.getBoundingClientRect()] : [...range.getClientRects()];
    for (const rect of rects)
      if (rect.width > 0 && rect.height > 0) texts.push({ rect, svg, node, text: node.data.trim().slice(0, 60) });
  }
  const overlaps = [];
  texts.sort((a, b) => a.rect.top - b.rect.top);
  texts.forEach((one, k) => {
    for (let l = k + 1; l < texts.length && texts[l].rect.top < one.rect.bottom; l++) {
      const other = texts[l];
      if (other.node === one.node) continue;
      // Boxes have room above and below the letters: a share of it may be shared.
      const x = Math.min(one.rect.right, other.rect.right) - Math.max(one.rect.left, other.rect.left);
      const y = Math.min(one.rect.bottom, other.rect.bottom) - other.rect.top;
      if (x > 1 && y > 0.3 * Math.min(one.rect.height, other.rect.height)) overlaps.push(`${one.text} | ${other.text}`);
    }
  });
  const cut = texts
    .filter(({ svg, rect }) => {
      if (!svg) return false;
      const page = svg.getBoundingClientRect();
      return rect.left < page.left - 1 || rect.right > page.right + 1 || rect.top < page.top - 1 || rect.bottom > page.bottom + 1;
    })
    .map(({ text }) => text);
  const colour = text => (text.match(/[\d.]+/g) || []).map(Number);
  const light = ([r, g, b]) => {
    const [x, y, z] = [r, g, b].map(v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * x + 0.7152 * y + 0.0722 * z;
  };
  let contrast = 21, faintest = '';
  for (const { node, svg, text } of texts) {
    if (svg) continue;
    let behind = node.parentElement;
    while (behind && colour(getComputedStyle(behind).backgroundColor)[3] === 0) behind = behind.parentElement;
    const [a, b] = [getComputedStyle(node.parentElement).color, getComputedStyle(behind || document.body).backgroundColor];
    const [low, high] = [light(colour(a)), light(colour(b))].sort((p, q) => p - q);
    const own = (high + 0.05) / (low + 0.05);
    if (own < contrast) [contrast, faintest] = [own, text];
  }
  const root = document.documentElement;
  const links = [...document.querySelectorAll('a[href]')].map(link => link.getAttribute('href'));
  parent.postMessage({
    name: location.hash.slice(1),
    texts: texts.length,
    overlaps: overlaps.slice(0, 20),
    cut: cut.slice(0, 20),
    contrast, faintest,
    paper: getComputedStyle(document.body).backgroundColor,
    too_wide: Math.max(0, root.scrollWidth - root.clientWidth),
    resources: performance.getEntriesByType('resource').map(entry => entry.name),
    dead_links: links.filter(link => !link.startsWith('#') || !document.getElementById(link.slice(1))),
    unreachable: [...document.querySelectorAll('.scroll')].filter(box => box.tabIndex !== 0).map(box => box.ariaLabel),
  }, '*');
});
