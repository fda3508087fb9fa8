"""Two seconds by the simplest contestant: whether case, rod and reference still belong together."""

from case import CASES, TIMES, rms_mm
from contestants import scipy_radau

case, end = CASES["both-dampings"], 2.0
path = scipy_radau.prepare(case, 32, 1e-4, end)()
off = rms_mm(path, case.reference()[TIMES <= end])
assert off < 0.5, f"{off} mm: the mesh of 32 nodes alone leaves some 0.3"
print(f"scipy, 32 nodes, {end} s: {off:.2f} mm from the converged path")
