"""Measures one contestant on one case, all settings one after another; prints a line of JSON for each.

`python measure.py MODULE CASE`. Times are the shortest of some repeats: others may use the machine. Processor time
stands beside wall time; all contestants but those that say otherwise use one thread.
"""

import importlib
import json
import os
import resource
import sys
import time

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"

from case import CASES, rms_mm

MOST_REPEATS, ENOUGH_S = 5, 6.0


def timed(run):
    best, spent, path = [float("inf")] * 2, 0.0, None
    for _ in range(MOST_REPEATS):
        wall, cpu = time.perf_counter(), time.process_time()
        path = run()
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        best, spent = [min(best[0], wall), min(best[1], cpu)], spent + cpu
        if spent > ENOUGH_S:
            break
    return path, *best


def main(module, case):
    of, case = importlib.import_module(f"contestants.{module}"), CASES[case]
    reference, start = case.reference(), time.process_time()  # start: Python, and what it imports
    for setting in of.settings(case):
        if hasattr(of, "measure"):
            path, wall, cpu, steps = of.measure(case, **setting)
            peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        else:
            (path, wall, cpu), steps = timed(of.prepare(case, **setting)), None
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(json.dumps(dict(contestant=of.NAME, case=case.name, setting=setting, wall_s=wall, cpu_s=cpu, steps=steps,
                              error_mm=rms_mm(path, reference), memory_mb=peak / 1024, start_s=start)), flush=True)


main(*sys.argv[1:])
