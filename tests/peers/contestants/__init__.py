"""Who takes part. Each module says at its head what it computes and what it cannot, and has NAME, `settings(case)`, and
`prepare(case, **setting)`: a function that computes the path of the tip once more. Imports, compilation and reading of
the model are its preparation, which is not timed. Ours has `measure` instead, because it is another process.
"""
