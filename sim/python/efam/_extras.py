"""Packages that are optional: each belongs to an extra of pyproject.toml."""

from importlib import import_module
from typing import Any

EXTRAS = {
    "arviz": "posterior",
    "control": "control",
    "gymnasium": "gym",
    "matplotlib": "plots",
    "pandas": "tables",
    "pythonfmu3": "fmu",
    "scipy": "control",
    "tqdm": "progress",
    "xarray": "tables",
}


def optional(module: str) -> Any:
    """The module; without its package an error that names the extra to install."""
    package = module.split(".")[0]
    try:
        import_module(package)
    except ModuleNotFoundError as error:
        if error.name != package:
            raise
        raise ImportError(
            f"{package} is not installed: pip install {package}, or in the copy of efam "
            f'pip install ".[{EXTRAS[package]}]"',
            name=package,
        ) from None
    return import_module(module)
