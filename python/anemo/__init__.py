"""Thermal sigma-delta anemometers: diffusive models, simulated sensors, calibration, wind.

    import anemo

    run = anemo.simulate("experiments/prbs.toml")                 # anemo run --on sim
    model = anemo.identify(run, output="sector1", free_poles=4)   # anemo identify
    print(model)
    model.spectrum(), model.to_control()

Every function but `sweep` is a command of the command line `anemo`, in this process: arguments have
the names of its options, with `_` for `-` (and `from_`, `class_`, `as_`). A record is a path, or a
table of any library (pyarrow, Polars, pandas, DuckDB: whatever has `__arrow_c_stream__`), or a dict
of numpy arrays. Temperatures are in °C, powers in W, times in s, rates in rad/s. Errors are `anemo.Error`,
with the sentence of the command line. While a command works, other Python threads go on, and Ctrl-C
ends it.
"""

from __future__ import annotations

import os as _os
from importlib import metadata as _metadata
from typing import TYPE_CHECKING as _TYPE_CHECKING

from . import _anemo, _commands
from ._anemo import Model, Table
from ._commands import *  # noqa: F403
from ._error import Error, Interrupted
from ._results import Experiment, Head, Network, Report

if _TYPE_CHECKING:
    from ._sweep import sweep
else:

    def __getattr__(name: str) -> object:
        # Who sweeps loads numpy and Dask.
        if name == "sweep":
            from ._sweep import sweep

            return sweep
        raise AttributeError(f"module 'anemo' has no attribute '{name}'")


__version__ = _metadata.version("anemo")
__all__ = [
    "Error",
    "Experiment",
    "Head",
    "Interrupted",
    "Model",
    "Network",
    "Report",
    "Table",
    "load",
    "sweep",
    *_commands.__all__,
]


def load(path: _os.PathLike[str] | str) -> Table:
    """Reads a recording or any other table: .parquet, .csv, a folder of segments, a pattern."""
    return Table.read(path)


_os.register_at_fork(after_in_child=_anemo.forked)
