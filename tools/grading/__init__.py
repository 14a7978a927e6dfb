"""How submissions are read, repaired, run, marked and reported: the parts of `make grade`.

`intake` reads what was handed in, `course` the exercises, `repair` puts a notebook into the shape
that nbgrader expects, `run` runs and marks one in a kernel of `kernels`, `pool` does so for many at
once and keeps the results, and `report` and `feedback` write what came out.
"""
