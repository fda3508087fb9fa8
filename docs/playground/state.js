// All that a visitor has set: what the core takes, what a link holds.

/** The paper's muscle at 15 psi, with damping of plausible size as in the project's scenarios. */
export function first(catalogue) {
  return {
    muscle: catalogue.muscles[0].name,
    pressure: 15 * catalogue.psi,
    rod: {},
    nodes: 32,
    angle: 0,
    duration: 10,
    rate: 100,
    effects: { payload: { mass: 0 }, rayleigh_mass: { alpha: 1 }, rayleigh_stiffness: { beta: 2e-3 } },
  };
}

/** The state as a fragment of an address. */
export function packed(state) {
  const bytes = new TextEncoder().encode(JSON.stringify(state));
  return btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
}

/** The state that a fragment holds; null where it holds none. A link may be anybody's: shapes are checked here, values
 *  by the core. */
export function unpacked(fragment) {
  try {
    const text = atob(fragment.replace(/^#/, '').replaceAll('-', '+').replaceAll('_', '/'));
    const state = JSON.parse(new TextDecoder().decode(Uint8Array.from(text, letter => letter.charCodeAt(0))));
    const isTable = value => value !== null && typeof value === 'object' && !Array.isArray(value);
    const isSetup = setup => isTable(setup) && isTable(setup.rod) && isTable(setup.effects)
      && Object.values(setup.effects).every(isTable) && setup.nodes <= 128;
    const isWhole = isTable(state) && Array.isArray(state.setups) && [1, 2].includes(state.setups.length)
      && state.setups.every(isSetup) && [1, 0.25, 0.1].includes(state.speed);
    return isWhole ? state : null;
  } catch {
    return null;
  }
}

/** Properties of a muscle without changes of its own at a pressure, from its table: for what a slider shows. */
export function fromTable(catalogue, setup, key) {
  const column = ['length', 'mass', 'bending_stiffness', 'axial_stiffness', 'diameter'].indexOf(key);
  const muscle = catalogue.muscles.find(({ name }) => name === setup.muscle);
  if (!muscle) return setup.rod[key] ?? 0;
  const { pressures, rows } = muscle;
  const next = Math.max(1, pressures.findIndex(pressure => pressure >= setup.pressure - 1));
  const share = (setup.pressure - pressures[next - 1]) / (pressures[next] - pressures[next - 1]);
  return rows[next - 1][column] + share * (rows[next][column] - rows[next - 1][column]);
}

/** The same setup as a plain rod, which needs no pressure. */
export function plain(catalogue, setup) {
  const rod = { ...setup.rod };
  for (const key of ['length', 'mass', 'bending_stiffness', 'diameter']) rod[key] ??= fromTable(catalogue, setup, key);
  return { ...setup, muscle: null, pressure: 0, rod };
}
