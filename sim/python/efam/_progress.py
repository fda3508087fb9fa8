"""Progress of long work, by tqdm where it is installed."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any, Optional

from ._extras import optional

Tell = Callable[[int, int, str], None]


def _is_watched() -> bool:
    """Whether the output goes to a terminal or a notebook."""
    return sys.stderr.isatty() or "ipykernel" in sys.modules


@contextmanager
def bar(name: str, unit: str, progress: Optional[bool]) -> Iterator[Optional[Tell]]:
    """The callback of the work: the part that is done, the whole, and the current step.

    Without `progress` said, a bar is shown where tqdm is installed and somebody looks on.
    """
    if progress is False or (progress is None and not _is_watched()):
        yield None
        return
    if not progress and find_spec("tqdm") is None:
        yield None
        return
    kind: Any = optional("tqdm").tqdm
    # In a notebook tqdm.auto warns where ipywidgets are not there.
    if "ipykernel" in sys.modules and find_spec("ipywidgets"):
        from tqdm.auto import tqdm as in_notebook

        kind = in_notebook
    shown = kind(desc=name, unit=unit, leave=False)

    def tell(done: int, total: int, doing: str) -> None:
        shown.total = total or None
        shown.set_postfix_str(doing, refresh=False)
        shown.n = done
        shown.refresh()

    with shown:
        yield tell
