// Numbers for people: SI inside, units of a laboratory on the screen.

const PREFIXES = [[1, ''], [1e-3, 'm'], [1e-6, 'µ']];
const OWN = {
  rad: [Math.PI / 180, '°'],
  'rad/s': [Math.PI / 180, '°/s'],
  Pa: [1e3, 'kPa'],
};

/** Unit in which a quantity of that size is shown: its SI value, and its symbol. */
export function shown(unit, size) {
  if (unit in OWN) return { factor: OWN[unit][0], symbol: OWN[unit][1] };
  if (unit === 'kg') return { factor: 1e-3, symbol: 'g' };
  if (unit === '') return { factor: 1, symbol: '' };
  const symbol = unit.replaceAll('^2', '²').replaceAll('^3', '³').replaceAll('^4', '⁴').replaceAll(' ', ' ');
  // A prefix belongs to a first unit without a power, such as that of N m².
  if (!/^(m|s|N|J|N m|N m²)$/.test(symbol)) return { factor: 1, symbol };
  const found = PREFIXES.find(([factor]) => Math.abs(size) >= factor * 0.999) ?? PREFIXES.at(-1);
  return { factor: found[0], symbol: found[1] + symbol };
}

/** A number with so many digits that count, without an exponent where it can be read. */
export function digits(value, count = 3) {
  if (!Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return value.toExponential(count - 1).replace('-', '−');
  const after = Math.max(0, count - 1 - Math.floor(Math.log10(size)));
  return value.toFixed(Math.min(after, 8)).replace('-', '−');
}
