"""Sweeps: on the cores of this computer, or by an engine that hands out their runs."""

from __future__ import annotations

import functools
import json
import os
import shutil
import sysconfig
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._anemo import Sweep
from ._error import Error
from ._results import Report

if TYPE_CHECKING:
    import distributed


def sweep(
    file: os.PathLike[str] | str,
    client: distributed.Client | None = None,
    *,
    output: os.PathLike[str] | str | None = None,
    jobs: int | None = None,
) -> Report:
    """Runs an experiment over many values of its keys, and gathers the results in one table.

    Every run has a folder named by the hash of all that it consists of, so that only what is
    missing is done, whoever did the rest: this function, the command `anemo sweep`, or another
    engine. Runs that fail are listed in the report and do not stop the others.

    Parameters
    ----------
    file
        The sweep: a TOML file. With a client, all workers have to see it, and what it names.
    client
        Of `dask.distributed`: its workers do the runs, one task each; a run whose worker dies is
        done by another. By default the cores of this computer.
    output
        The folder for runs and results; by default one named as the file, here. With a client, all
        workers have to see it.
    jobs
        Runs at a time without a client; by default one for every core.
    """
    file = Path(file).resolve()
    folder = Path(output if output is not None else file.stem).resolve()
    plan = planned(str(file), file.stat().st_mtime_ns if file.exists() else 0)
    if client is None:
        plan.work(folder, jobs or len(os.sched_getaffinity(0)))
    else:
        folder.mkdir(parents=True, exist_ok=True)
        names = [f"anemo-{run}-{os.urandom(4).hex()}" for run in plan.runs]
        engine: Any = client
        done = engine.map(run_of, plan.runs, file=str(file), folder=str(folder), key=names, pure=False)
        engine.gather(done)
    report, text = plan.gather(folder)
    return Report(json.loads(report), text)


def run_of(run: str, file: str, folder: str) -> str | None:
    """What a worker does: one run. Gives the sentence of its failure."""
    return planned(file, os.stat(file).st_mtime_ns).run(run, folder)


@functools.lru_cache(maxsize=4)
def planned(file: str, changed: int) -> Sweep:
    """The plan of a file, worked out once in a process; `changed` tells one version from another."""
    return Sweep(file, command())


def command() -> str:
    """The command `anemo` of this environment, which does the steps behind a run."""
    own = shutil.which("anemo", path=sysconfig.get_path("scripts"))
    found = own or shutil.which("anemo")
    if found is None:
        raise Error("the command `anemo`, which pip installs with this package, is not on the path", 1)
    return found


__all__: list[Any] = ["sweep"]
