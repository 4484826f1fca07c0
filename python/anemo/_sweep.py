"""Sweeps: many runs of an experiment over any of its keys, on the workers of Dask.

A run has a key: the hash of its files, of `then`, and of the version. Its worker writes the folder `run=KEY`, and
`result.json` last. A run whose folder has that file is finished and is not repeated.
"""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import functools
import hashlib
import importlib
import inspect
import itertools
import json
import multiprocessing
import os
import re
import sys
import tempfile
import tomllib
import types
import warnings
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from ._anemo import Table, Text
from ._call import performed
from ._error import Error
from ._results import Report

if TYPE_CHECKING:
    import distributed

PathLike = Union[os.PathLike[str], str]
VERSION = metadata.version("anemo")
# Files that an experiment names. A key that begins so goes into that file.
NAMED = ("head", "models", "device")
FILES = ("experiment", *NAMED)


@dataclasses.dataclass(frozen=True)
class Plan:
    """Inputs that all runs share."""

    experiments: list[Path]
    # Varied keys; those in one tuple take the same value.
    keys: list[tuple[str, ...]]
    # All TOML files that a run may need, as tables.
    documents: dict[Path, dict[str, Any]]
    folder: Path
    then: Callable[..., Any] | None
    recordings: bool


def sweep(
    experiment: PathLike | Sequence[PathLike] | None,
    vary: Mapping[str | tuple[str, ...], Any],
    *,
    method: str = "grid",
    samples: int | None = None,
    seed: int = 0,
    then: Callable[..., Any] | None = None,
    reads: Sequence[PathLike] = (),
    recordings: bool = False,
    results: PathLike = "sweep",
    client: distributed.Client | None = None,
) -> Table:
    """Run an experiment over many values of its keys, and gather the results in one table.

    A failed run stands in the table with its sentence and does not stop the others. The same call again does what is
    missing: failed runs, and runs whose files, `then` or version have changed. Needs Dask.

    Parameters
    ----------
    experiment
        The experiment, a TOML file. Several are one run: all take the same values. None where `experiment` is varied
    vary
        Values by key, such as `wind[0].speed_m_s`; without `[0]` in every table of the list. `head.…`, `models.…`
        and `device.…` lead into these files; `experiment`, `head`, `models` and `device` exchange them. Keys in a
        tuple take the same value. Values are a sequence, or a distribution of `scipy.stats`
    method
        `grid`: every combination; `random`: each key drawn by itself; `latin`: a Latin hypercube, each key once in
        every n-th part of its distribution
    samples
        Number of runs of `random` and `latin`
    seed
        Seed of `random` and `latin`. A further key leaves the values of the others
    then
        Called after each run with its recordings as tables. Its numbers become columns: a dict, or an object with a
        `report`
    reads
        Files that `then` reads. A change of their content repeats the runs
    recordings
        Keep recordings in the folders of the runs
    results
        Folder of the runs and of `results.parquet`. All workers have to see it
    client
        Client of `dask.distributed`; by default all cores of this computer, one worker with one thread each
    """
    try:
        dask, pyarrow, parquet = map(importlib.import_module, ("distributed", "pyarrow", "pyarrow.parquet"))
    except ImportError as missing:
        raise Error(f"a sweep needs {missing.name}: pip install distributed pyarrow", 1) from None
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise Error('workers import the script: call anemo.sweep below `if __name__ == "__main__":`', 1)
    given = [experiment] if isinstance(experiment, (str, os.PathLike)) else list(experiment or ())
    keys = [name if isinstance(name, tuple) else (name,) for name in vary]
    plan = Plan([Path(path).resolve() for path in given], keys, {}, Path(results).resolve(), then, recordings)
    columns = [listed(key[0], values) for key, values in zip(keys, vary.values(), strict=True)]
    read(plan, columns)
    drawn = combinations([key[0] for key in keys], columns, method, samples, seed)
    common = [VERSION, fingerprint(then, "", set()), recordings, [content(path) for path in reads]]
    hashes = [digest([common, expanded(plan, values)]) for values in drawn]
    runs = dict(zip(hashes, drawn, strict=True))
    check(plan, runs.values())
    plan.folder.mkdir(parents=True, exist_ok=True)
    with contextlib.ExitStack() as stack:
        if client is None:
            main = sys.modules["__main__"]
            if not os.path.exists(getattr(main, "__file__", None) or ""):
                # A script from stdin has a file that is not there. Workers would look for it.
                vars(main).pop("__file__", None)
            cores = len(os.sched_getaffinity(0))
            cluster = dask.LocalCluster(n_workers=cores, threads_per_worker=1, dashboard_address=None)
            client = stack.enter_context(dask.Client(stack.enter_context(cluster)))
        engine: Any = client
        # One copy for all runs. A copy that is lost with its worker is made again.
        shared = engine.submit(copy.copy, plan, pure=False)
        futures = engine.map(run_of, list(runs), list(runs.values()), plan=shared, pure=False)
        if sys.stdout.isatty():
            dask.progress(futures, notebook=False)
        dask.wait(futures)
        outcomes = dict(zip(runs, map(outcome, futures), strict=True))
    rows = [row(keys, run, runs[run], *outcomes[run]) for run in hashes]
    names = list(dict.fromkeys(name for one in rows for name in one))
    table = pyarrow.table({name: column([one.get(name) for one in rows]) for name in names})
    path = plan.folder / "results.parquet"
    with tempfile.NamedTemporaryFile(dir=plan.folder, suffix=".partial", delete=False) as partial:
        parquet.write_table(table.replace_schema_metadata({"software": f"anemo {VERSION}"}), partial)
    os.replace(partial.name, path)
    failed = sum(one["failed"] != "" for one in rows)
    if failed:
        warnings.warn(f"{failed} of {len(rows)} runs failed: the column `failed` says why", stacklevel=2)
    gathered = Table(table)
    gathered.report = Report({"runs": len(rows), "failed": failed, "results": str(path)})
    return gathered


def listed(name: str, values: Any) -> Any:
    """Values of a key as TOML has them: whole paths of files, Python's numbers. A distribution as it is."""
    if hasattr(values, "ppf"):
        return values
    values = [value.item() if isinstance(value, np.generic) else value for value in values]
    if not values:
        raise Error(f"`{name}` has no values, so there are no runs", 2)
    if name in FILES:
        return [str(Path(value).resolve()) for value in values]
    try:
        toml(values)
    except TypeError as reason:
        raise Error(f"`{name}`: a TOML file has no such value: {reason}", 2) from None
    return values


def combinations(names: list[str], columns: list[Any], method: str, samples: int | None, seed: int) -> list[Any]:
    """Values of every run: a grid, or drawn key by key."""
    if method not in ("grid", "random", "latin"):
        raise Error(f"there is no method `{method}`; there are grid, random and latin", 2)
    if not names:
        raise Error("nothing is varied: give the values of a key, as {'wind.speed_m_s': [1, 2]}", 2)
    if (method == "grid") == (samples is not None) or (samples is not None and samples < 1):
        raise Error("`samples`, 1 or more, is the number of runs of the methods random and latin", 2)
    drawn = []
    for name, values in zip(names, columns, strict=True):
        if samples is None:
            if hasattr(values, "ppf"):
                raise Error(f"`{name}` has a distribution: method='latin' draws from it, a grid takes a list", 2)
            continue
        chance = np.random.default_rng([seed, zlib.crc32(name.encode())])
        share = chance.random(samples)
        if method == "latin":
            # Once in every n-th part (McKay, Beckman and Conover, Technometrics 21, 1979).
            share = (chance.permutation(samples) + share) / samples
        if hasattr(values, "ppf"):
            # Only a distribution of whole numbers has a probability mass. Twelve digits read well.
            is_whole = hasattr(values, "pmf")
            drawn.append([int(one) if is_whole else float(f"{one:.11e}") for one in values.ppf(share)])
        else:
            drawn.append([values[int(one * len(values))] for one in share])
    return list(itertools.product(*columns) if samples is None else zip(*drawn, strict=True))


def read(plan: Plan, columns: list[Any]) -> None:
    """Reads all files that runs may need."""
    named = [name for key in plan.keys for name in key]
    if len(set(named)) < len(named):
        raise Error("a key is varied twice", 2)
    if bool(plan.experiments) == ("experiment" in named):
        raise Error("give an experiment, or vary `experiment`", 2)
    if len({path.stem for path in plan.experiments}) < len(plan.experiments):
        raise Error("two experiments have one name, and names tell their results apart", 2)
    varied = {name: values for key, values in zip(plan.keys, columns, strict=True) for name in key if name in FILES}
    experiments = plan.experiments + [Path(path) for path in varied.get("experiment", ())]
    others = [Path(path) for kind in NAMED for path in varied.get(kind, ())]
    for path in experiments + others:
        plan.documents[path] = document(path)
    for path in experiments:
        own = plan.documents[path]
        for file in [path.parent / str(own[kind]) for kind in NAMED if kind in own and kind not in varied]:
            plan.documents[file] = document(file)


def document(path: Path) -> dict[str, Any]:
    """A TOML file as a table."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as reason:
        raise Error(f"{path}: {reason.strerror}", 2) from None
    except ValueError as reason:
        raise Error(f"{path}: {reason}", 2) from None


def content(path: PathLike) -> str:
    """Hash of a file."""
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as reason:
        raise Error(f"{path}: {reason.strerror}", 2) from None


def digest(inputs: Any) -> str:
    return hashlib.sha256(json.dumps(inputs, sort_keys=True, default=repr).encode()).hexdigest()[:32]


def fingerprint(value: Any, home: str, seen: set[int]) -> Any:
    """Content of a function for its hash: its code, and the values and own functions that it refers to."""
    if isinstance(value, types.CodeType):
        return [value.co_code.hex(), value.co_names, [fingerprint(part, home, seen) for part in value.co_consts]]
    if isinstance(value, functools.partial):
        return [fingerprint(part, home, seen) for part in (value.func, value.args, value.keywords)]
    if isinstance(value, types.ModuleType):
        return value.__name__
    if inspect.isfunction(value):
        package = value.__module__.partition(".")[0]
        # Functions of libraries count by their names.
        if id(value) in seen or package != (home or package):
            return f"{value.__module__}.{value.__qualname__}"
        captured = inspect.getclosurevars(value)
        named = {**captured.globals, **captured.nonlocals, "": (value.__defaults__, value.__kwdefaults__)}
        seen = seen | {id(value)}
        return [fingerprint(part, package, seen) for part in (value.__code__, *itertools.chain(*named.items()))]
    return importlib.import_module("dask.base").tokenize(value)


def expanded(plan: Plan, values: Sequence[Any]) -> dict[str, dict[str, dict[str, Any]]]:
    """Files of a run as tables, by experiment and kind."""
    given = {name: value for key, value in zip(plan.keys, values, strict=True) for name in key}
    made = {}
    for path in [Path(given["experiment"])] if "experiment" in given else plan.experiments:
        own = copy.deepcopy(plan.documents[path])
        files = {kind: str(file) for kind, file in {**own, **given}.items() if kind in NAMED}
        tables = {kind: copy.deepcopy(plan.documents[path.parent / file]) for kind, file in files.items()}
        tables["experiment"] = {**own, **{kind: f"{path.stem}.{kind}.toml" for kind in files}}
        for name in [name for name in given if name not in FILES]:
            kind, _, key = name.partition(".")
            kind, key = (kind, key) if kind in NAMED else ("experiment", name)
            if kind not in tables:
                raise Error(f"`{name}`: {path.name} names no `{kind}`", 2)
            put(tables[kind], key, copy.deepcopy(given[name]), name)
        made[path.stem] = tables
    return made


def put(table: dict[str, Any], key: str, value: Any, name: str) -> None:
    """Sets a dotted key; without a number in every table of a list."""
    step, _, rest = key.partition(".")
    parts = re.fullmatch(r"([^\[\]]+)(?:\[(\d+)\])?", step)
    if parts is None:
        raise Error(f"`{name}` is no key: one reads as `gas.temperature_c` or `wind[0].speed_m_s`", 2)
    label, index = parts.groups()
    if index is None and not rest:
        table[label] = value
        return
    found = table.setdefault(label, {})
    if index is not None and (not isinstance(found, list) or int(index) >= len(found)):
        raise Error(f"`{name}`: `{label}` has no entry {index}, counted from 0", 2)
    if index is not None and not rest:
        found[int(index)] = value
        return
    for item in [found[int(index)]] if index is not None else found if isinstance(found, list) else [found]:
        if not isinstance(item, dict):
            raise Error(f"`{name}`: `{label}` is no table that could have a key `{rest}`", 2)
        put(item, rest, value, name)


def toml(value: Any) -> str:
    """A value on one line of TOML."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(of)}" for key, of in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value, ensure_ascii=False)


def write(plan: Plan, values: Sequence[Any], folder: Path) -> list[Path]:
    """Writes the files of a run, which `anemo run` takes, too. Gives the experiments."""
    experiments = []
    for stem, tables in expanded(plan, values).items():
        for kind, table in tables.items():
            text = "".join(f"{json.dumps(key)} = {toml(value)}\n" for key, value in table.items())
            path = folder / (f"{stem}.toml" if kind == "experiment" else f"{stem}.{kind}.toml")
            Text(folder, "toml", text).write(path)
        experiments.append(folder / f"{stem}.toml")
    return experiments


def check(plan: Plan, runs: Iterable[Sequence[Any]]) -> None:
    """Refuses a sweep without a run that can be read: a wrong key is wrong in all of them."""
    first = ""
    for values in runs:
        with tempfile.TemporaryDirectory(prefix="anemo-") as folder:
            try:
                for path in write(plan, values, Path(folder)):
                    performed("check", (path,), {})
                return
            except Error as reason:
                first = first or str(reason).replace(f"{folder}{os.sep}", "")
    raise Error(f"no run of the sweep can be read; the first: {first}", 2)


def outcome(future: Any) -> tuple[dict[str, Any], str]:
    """Results of a run, and the sentence of its failure or nothing."""
    reason = future.exception()
    return future.result() if reason is None else ({}, f"its worker failed: {one_line(reason)}")


def run_of(key: str, values: Sequence[Any], plan: Plan) -> tuple[dict[str, Any], str]:
    """Work of a worker: one run, unless it is finished."""
    os.environ["RAYON_NUM_THREADS"] = "1"
    folder = plan.folder / f"run={key}"
    result = folder / "result.json"
    try:
        if not result.is_file():
            folder.mkdir(exist_ok=True)
            Text(folder, "json", json.dumps(done(plan, values, folder))).write(result)
        return json.loads(result.read_text(encoding="utf-8")), ""
    except Exception as reason:
        kind = "" if isinstance(reason, Error) else f"{type(reason).__name__}: "
        return {}, f"{kind}{one_line(reason)}"


def one_line(reason: BaseException) -> str:
    return " ".join(str(reason).split())


def done(plan: Plan, values: Sequence[Any], folder: Path) -> dict[str, Any]:
    """Runs the experiments of a run and calls `then`; gives the results by column."""
    results: dict[str, Any] = {}
    tables = []
    with warnings.catch_warnings():
        # A run that trips is a result; the column `trips_0_cause` says so.
        warnings.simplefilter("ignore")
        for path in write(plan, values, folder):
            kept = path.with_suffix(".parquet") if plan.recordings else None
            _, report, table = performed("run", (path,), {"--output-file": kept}, None if kept else "--output-file")
            if "ended" in report:
                raise Error(f"ended early: {report['ended']}")
            tables.append(Table.read(kept) if kept else Table(table))
            prefix = identifier(path.stem) if len(plan.experiments) > 1 else ""
            flatten(prefix, {**report, **steady(tables[-1])}, results)
        found = None if plan.then is None else plan.then(*tables)
    more: dict[str, Any] = {}
    flatten("", getattr(found, "report", found), more)
    if both := results.keys() & more.keys():
        raise Error(f"`then` gives the column `{min(both)}`, which the run has, too")
    return {**results, **more}


def steady(table: Table) -> dict[str, float]:
    """Means over the last quarter of a run, without missing readings."""
    measured = [name for name in table.columns if name.startswith(("power_w_", "temperature_c_"))]
    last = {f"steady_{name}": table[name][3 * len(table) // 4 :] for name in measured}
    return {name: float(np.nanmean(values)) for name, values in last.items() if np.isfinite(values).any()}


def identifier(name: str) -> str:
    """A name that needs no quotes in SQL or Python."""
    return re.sub(r"[^0-9A-Za-z]+", "_", name).strip("_")


def flatten(name: str, value: Any, columns: dict[str, Any]) -> None:
    """Every number, truth value and text of nested dicts and lists, named by the keys that lead to it."""
    if isinstance(value, (Mapping, list, tuple)):
        for key, of in value.items() if isinstance(value, Mapping) else enumerate(value):
            flatten(f"{name}_{identifier(str(key))}".strip("_"), of, columns)
    elif value is not None:
        columns[name or "result"] = value.item() if isinstance(value, np.generic) else value


def row(keys: list[tuple[str, ...]], run: str, values: Any, results: dict[str, Any], failed: str) -> dict[str, Any]:
    """A row of the table: hash of the run, varied values, sentence, results."""
    cells = [json.dumps(value) if isinstance(value, (Mapping, list, tuple)) else value for value in values]
    own = {"run": run, **{identifier(key[0]): cell for key, cell in zip(keys, cells, strict=True)}, "failed": failed}
    return {**own, **{f"result_{name}" if name in own else name: value for name, value in results.items()}}


def column(cells: list[Any]) -> list[Any]:
    """Cells of one type: all as text where text stands among numbers."""
    kinds = {"text" if isinstance(cell, str) else isinstance(cell, bool) for cell in cells if cell is not None}
    return cells if len(kinds) < 2 else [None if cell is None else str(cell) for cell in cells]
