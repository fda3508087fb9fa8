"""Frequency, damping, settling, response, gain and phase of drawn runs, computed again from their trajectories by numpy alone.

    tests/metrics/check.py PROGRAM [RUNS] [SEED]

Draws releases from all angles, hanging rods, held starts, steps of pressure and force, and forced rods, with payloads from 0 to
300 g, runs each by the program, and computes every number on its own: the direction from the small swings, the frequency by a
Fourier integral at each frequency, the peaks by the phase of the filtered swing, equation 6 by Gauss and Newton, and the rest
from the end of the run. A number must agree within one per cent, or the program must say why there is none.
"""

import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

import numpy as np

WITHIN = 0.01
TAU = 2.0 * math.pi


def scenario(kind, draw):
    """A scenario's text, and what the script itself has to know of it: the force over time and when it begins."""
    payload = draw.uniform(0.0, 300.0)
    alpha, beta = draw.uniform(0.8, 1.6), draw.uniform(1.0, 6.0)
    pressure = draw.uniform(15.0, 90.0)
    lines = [f'[effects.rayleigh_mass]\nalpha = "{alpha} 1/s"\n[effects.rayleigh_stiffness]\nbeta = "{beta} ms"']
    known = {}
    if kind == "hanging":
        length, mass, stiffness = draw.uniform(0.25, 0.5), draw.uniform(0.03, 0.15), draw.uniform(0.01, 0.05)
        base = draw.uniform(-89.0, -75.0)
        lines.append(
            f'[rod]\nlength = "{length} m"\nmass = "{mass} kg"\nbending_stiffness = "{stiffness} N m^2"\nnodes = 12\n'
            f'base_angle = "{base} deg"\naxial_stiffness = "2000 N"\n[effects.gravity]\nacceleration = "9.81 m/s^2"\n'
            f'[release]\nfrom = "held"\nangle = "{base + draw.uniform(5.0, 30.0)} deg"'
        )
    else:
        lines.append('[rod]\nnodes = 12')
        muscle = f'pressure = "{pressure} psi"'
        lines.append(f'[effects.payload]\nmass = "{payload} g"')
        if kind == "release":
            lines.append('[release]\nfrom = "straight"')
        if kind == "held":
            lines.append(f'[release]\nfrom = "held"\nangle = "{draw.uniform(-60.0, 30.0)} deg"')
        if kind in ("pressure step", "force step", "forced"):
            lines.append('[release]\nfrom = "equilibrium"')
        if kind == "pressure step":
            known["begin"] = draw.uniform(0.5, 3.0)
            to = pressure + draw.choice([-1.0, 1.0]) * draw.uniform(3.0, 8.0)
            ends = [f'["{known["begin"] + k} s", "{p} psi"]' for k, p in [(0.0, pressure), (0.01, to)]]
            muscle = f'pressure = [["0 s", "{pressure} psi"], {", ".join(ends)}]'
        if kind in ("force step", "forced"):
            force, axis = draw.uniform(0.005, 0.05), draw.choice("xz")
            known["begin"] = draw.uniform(0.5, 3.0) if kind == "force step" else 0.0
            known["force"], known["hertz"] = force, draw.uniform(0.3, 3.0)
            law = "f * max(0, sign(time - begin))" if kind == "force step" else "f * sin(2*pi*frequency*time)"
            name, unit, value = ("begin", "s", known["begin"]) if kind == "force step" else ("frequency", "Hz", known["hertz"])
            lines.append(
                f'[effects.motor]\nf = "{force} N"\n{name} = "{value} {unit}"\n[laws.motor]\nplace = "tip"\nkind = "load"\n'
                f'force_{axis} = "{law}"\nparameters.f = {{ unit = "N", default = 0.02, range = [-1, 1] }}\n'
                f'parameters.{name} = {{ unit = "{unit}", default = 1, range = [0, 50] }}'
            )
        lines.append(f'[muscle]\nname = "garbulinski-2022"\n{muscle}')
    lines.append('[run]\nduration = "25 s"\naccuracy = "0.02 mm"\nrate = "200 Hz"')
    return "\n".join(lines) + "\n", known


def amplitude(signal, step, hertz):
    """Fourier integral of a signal under a Hann window, at each of some frequencies."""
    time = step * np.arange(len(signal))
    window = np.sin(math.pi * np.arange(len(signal)) / len(signal)) ** 2
    return np.abs(np.exp(-1j * TAU * np.outer(hertz, time)) @ (window * signal))


def highest(signal, step, low, high):
    """Frequency at which that is highest between two, by ever finer grids; none where it is highest at an end."""
    grid = np.linspace(low, high, 400)
    sizes = amplitude(signal, step, grid)
    inner = [k for k in range(1, 399) if sizes[k - 1] < sizes[k] >= sizes[k + 1]]
    if not inner:
        return None
    top = max(inner, key=lambda k: sizes[k])
    for _ in range(4):
        width = grid[1] - grid[0]
        grid = np.linspace(grid[top] - width, grid[top] + width, 41)
        top = int(np.argmax(amplitude(signal, step, grid)))
    return grid[top]


def filtered(signal, step, hertz):
    """The complex swing about a frequency: what a Gaussian filter leaves of positive frequencies, the signal continued evenly."""
    long = np.concatenate([signal[:0:-1], signal])
    frequency = np.fft.fftfreq(len(long), step)
    # At the harmonics less than a thousandth is left.
    pass_band = 2.0 * np.exp(-0.5 * ((frequency - hertz) / (0.25 * hertz)) ** 2) * (frequency > 0.0)
    return np.fft.ifft(np.fft.fft(long) * pass_band)[len(signal) - 1 :]


def direction(path, rest, step, hertz):
    """Unit vector of the small swings about a frequency: from where three per cent of the largest are left to three in a thousand."""
    off = np.column_stack([filtered(along, step, hertz).real for along in (path - rest).T])
    size = np.hypot(*off.T)
    first, last = (np.flatnonzero(size > share * size.max())[-1] for share in (0.03, 0.003))
    small = off[first + 1 : last + 1]
    values, vectors = np.linalg.eigh(small.T @ small)
    along = vectors[:, -1]
    return along if along @ (path[0] - rest) >= 0.0 else -along


def vertex(values, top):
    """Place, in samples, and height of a maximum, by a parabola."""
    before, here, after = values[top - 1 : top + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return top + shift, here - 0.25 * (before - after) * shift


def upper_peaks(signal, step, hertz):
    """Time and height of each upper peak: the highest sample within a quarter of a turn of the phase about each full turn.

    Its time is where the swing turns, smoothed by a Hann window of a period, moved by what that is before or after the highest
    samples in the median: the higher of two tops of a crest changes from one to the next.
    """
    phase = np.unwrap(np.angle(filtered(signal, step, hertz)))
    half = round(0.5 / hertz / step)
    window = np.hanning(2 * half + 1)
    smooth = np.convolve(signal, window / window.sum(), "same")
    least = 0.01 * (signal.max() - signal.min())
    peaks = []
    # From a quarter of a turn after the start on, which is no peak.
    for turn in range(math.ceil(phase[0] / TAU + 0.25), int(phase.max() / TAU) + 1):
        inside = np.flatnonzero(np.abs(phase - TAU * turn) < 0.25 * TAU)
        if len(inside) < 3 or inside[-1] + 2 >= len(signal):
            break
        top = inside[np.argmax(signal[inside])]
        around = signal[inside[0] : min(len(signal), inside[-1] + len(inside))]
        if signal[top] - around.min() < least or signal[top] <= 0.0:
            break
        place, height = vertex(signal, top)
        # Near the ends the window is cut off.
        smoothed_top = inside[np.argmax(smooth[inside])]
        is_whole = half <= smoothed_top < len(signal) - half
        peaks.append((place, height, vertex(smooth, smoothed_top)[0] if is_whole else np.nan))
    places, heights, turns = np.array(peaks).reshape(-1, 3).T
    turns += np.nanmedian(places - turns) if np.isfinite(turns).any() else 0.0
    return np.column_stack([step * np.where(np.isfinite(turns), turns, places), heights])


def damping(peaks, hertz):
    """Damping ratio of equation 6, by Gauss and Newton from the logarithms' straight line."""
    time, height = peaks.T
    rate = -np.polyfit(time, np.log(height), 1)[0]
    scale = height[0] * math.exp(rate * time[0])
    for _ in range(50):
        curve = np.exp(-rate * time)
        matrix = np.column_stack([curve, -scale * time * curve])
        change = np.linalg.lstsq(matrix, height - scale * curve, rcond=None)[0]
        scale, rate = scale + change[0], rate + change[1]
    return rate / math.hypot(rate, TAU * hertz)


def settling(values, step, band):
    """When a signal crosses a band for the last time: for a band one per cent wider, and one per cent narrower.

    A crest that comes within that of the band counts or not.
    """
    def last_outside(band):
        outside = np.flatnonzero(np.abs(values) > band)
        if len(outside) == 0:
            return 0.0
        last = outside[-1]
        if last + 1 == len(values):
            return None
        edge = math.copysign(band, values[last])
        return (last + (values[last] - edge) / (values[last] - values[last + 1])) * step

    ends = [last_outside((1.0 + side * WITHIN) * band) for side in (1.0, -1.0)]
    return None if None in ends else ends


def swing(path, rest, step, mode):
    """Frequency, damping ratio and settling of a path about a rest."""
    along = direction(path, rest, step, mode)
    signal = (path - rest) @ along
    left = np.cumsum(signal[::-1] ** 2)[::-1] / np.sum(signal**2)
    kept = max(3, int(np.argmax(left < 1e-4)) or len(signal))
    hertz = highest(signal[:kept], step, 0.5 * mode, 1.5 * mode)
    found = {"settling": settling(signal, step, 0.02 * np.abs(signal).max())}
    if hertz is None:
        return found
    peaks = upper_peaks(signal, step, hertz)
    found["frequency"] = hertz
    if len(peaks) >= 3:
        found["damping ratio"] = damping(peaks, hertz)
    return found


def step_numbers(values, steady, step):
    """What stepinfo says."""
    way = steady - values[0]
    share = (values - values[0]) / way

    def first(level):
        k = int(np.argmax(share >= level))
        return (k - (share[k] - level) / (share[k] - share[k - 1])) * step

    found = {"settling": settling(share - 1.0, step, 0.02), "overshoot": 100.0 * max(0.0, share.max() - 1.0)}
    if share.max() >= 0.9:
        found["rise"] = first(0.9) - first(0.1)
    return found


def response(values, step, known):
    """Gain and phase over the last five periods."""
    count = int(round(5.0 / known["hertz"] / step))
    time = step * np.arange(len(values))[-count:]
    wave = TAU * known["hertz"] * time
    matrix = np.column_stack([np.ones(count), np.sin(wave), np.cos(wave)])
    _, sin, cos = np.linalg.lstsq(matrix, values[-count:], rcond=None)[0]
    return {"gain": math.hypot(sin, cos) / known["force"], "phase": math.atan2(cos, sin)}


class Table:
    """Counts by kind and number."""

    def __init__(self):
        self.rows, self.bad = {}, []

    def add(self, kind, number, own, said, why, unit=None):
        """Holds one number against the script's, or against the ends between which that lies; `unit` is the size that an absolute error is held against."""
        row = self.rows.setdefault((kind, number), {"same": 0, "undefined": 0, "off": 0, "worst": 0.0})
        if said is None:
            row["undefined" if why else "off"] += 1
            if not why:
                self.bad.append(f"{kind}: {number} is null without a reason")
            return
        if own is None:
            row["undefined"] += 1
            return
        if isinstance(own, list):
            own = min(max(said, own[0]), own[1])
        error = abs(said - own) / (unit or abs(own))
        row["worst"] = max(row["worst"], error)
        row["same" if error <= WITHIN else "off"] += 1
        if error > WITHIN:
            self.bad.append(f"{kind}: {number} {said} is {own} by the script")

    def __str__(self):
        head = "| motion | number | within 1 % | not defined | off | largest difference, % |\n|---|---|---|---|---|---|\n"
        line = "| {} | {} | {same} | {undefined} | {off} | {worst:.2f} |"
        rows = [(key, {**row, "worst": 100.0 * row["worst"]}) for key, row in self.rows.items()]
        return head + "\n".join(line.format(*key, **row) for key, row in sorted(rows))


def check(program, kind, draw, folder, table):
    text, known = scenario(kind, draw)
    (folder / "s.toml").write_text(text)
    command = [program, "simulate", "s.toml", "--json", "--no-files", "--trajectory", "--no-error-estimate"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        table.rows.setdefault((kind, "refused"), {"same": 0, "undefined": 0, "off": 0, "worst": 0.0})["undefined"] += 1
        print(f"{kind}: refused: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return
    run = json.loads(done.stdout)["runs"][0]
    trajectory = run["trajectory"]
    time, path = np.array(trajectory["time_s"]), np.column_stack([trajectory["tip_x_m"], trajectory["tip_z_m"]])
    step, missing = time[1] - time[0], run["missing"]
    before = len(table.bad)
    if kind == "forced":
        [event] = run["events"]
        for k, axis in enumerate("xz"):
            own = response(path[:, k], step, known)
            said = event[f"forced_{axis}"] or {"gain_m_per_n": None, "phase_rad": None}
            why = event["missing"].get(f"forced_{axis}")
            table.add(kind, "gain", own["gain"], said["gain_m_per_n"], why)
            turn = said["phase_rad"]
            near = None if turn is None else own["phase"] + TAU * round((turn - own["phase"]) / TAU)
            # One per cent of a right angle.
            table.add(kind, "phase", near, turn, why, 0.25 * TAU)
        table.add(kind, "frequency", None, run["damped_frequency_hz"], missing.get("damped_frequency_hz"))
    else:
        rest = path[-200:].mean(axis=0)
        first = int(math.ceil(known.get("begin", 0.0) / step - 1e-9))
        change = 0.01 if kind == "pressure step" else 0.0
        swinging = path[int(math.ceil((known.get("begin", 0.0) + change) / step - 1e-9)) :]
        own = swing(swinging, rest, step, run["modes"][0]["natural_frequency_hz"])
        own["settling"] = None if own["settling"] is None else [end + change for end in own["settling"]]
        for number, entry in [
            ("frequency", "damped_frequency_hz"),
            ("damping ratio", "damping_ratio"),
            ("settling", "settling_2_percent_s"),
        ]:
            table.add(kind, number, own.get(number), run[entry], missing.get(entry))
        event = run["events"][-1]
        for k, axis in enumerate("xz"):
            said, why = event[axis], event["missing"].get(axis)
            way = rest[k] - path[first, k]
            # Where the way is small, a hundredth of it is below what the end of the run says of the rest.
            if said is None or abs(way) < 1e-3:
                continue
            own = step_numbers(path[first:, k], rest[k], step)
            for number, entry in [("rise", "rise_s"), ("settling", "settling_2_percent_s")]:
                table.add(kind, f"{number}, {axis}", own.get(number), said[entry], why or "not reached")
            table.add(kind, f"overshoot, {axis}", own["overshoot"], said["overshoot_percent"], why, 100.0)
    if len(table.bad) > before:
        print("\n".join(table.bad[before:]) + "\n" + text, file=sys.stderr)


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    runs, seed = (int(sys.argv[k]) if len(sys.argv) > k else usual for k, usual in [(2, 200), (3, 1)])
    kinds = ["release", "held", "hanging", "pressure step", "force step", "forced"]
    table = Table()
    with tempfile.TemporaryDirectory() as folder:
        for run in range(runs):
            check(program, kinds[run % len(kinds)], random.Random(1000 * seed + run), pathlib.Path(folder), table)
    print(table)
    if table.bad:
        sys.exit(f"{len(table.bad)} numbers are off")


main()
