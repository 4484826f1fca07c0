"""From the arguments of a function to the words of a command, and back to an object."""

from __future__ import annotations

import json
import numbers
import os
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, Union, cast

from ._anemo import Model, Table, Text, perform
from ._error import Error, Interrupted
from ._results import Head, Report

# A file, or what stands for one: a table of any library, a model, a head, an experiment.
Source = Any
# A number, a word, or a pair of numbers.
Number = Union[str, float, int, bool, tuple[float, float], None]
# One word or several.
Words = Union[str, Sequence[str], None]
# A file, or what stands for one.
Paths = Any

# What a command gives: a class.
Result = TypeVar("Result")

FLAG = object()


def flag(value: bool) -> Any:
    """An option that is given or not."""
    if isinstance(value, str):
        raise Error(f"`{value}` stands where True or False belongs", 2)
    return FLAG if value else None


class Several(tuple[Any, ...]):
    """Values of an option that is given once for each."""


def several(value: Words) -> Several | None:
    """An option that may be given several times."""
    return Several([value]) if isinstance(value, str) else None if value is None else Several(value)


def word(value: Any) -> Any:
    """A value as the command line has it, or an object that stands for a file."""
    if isinstance(value, (str, Model, Table, Text)):
        return value
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (tuple, list)) and all(isinstance(part, numbers.Real) for part in value):
        return ":".join(str(word(part)) for part in value)
    if hasattr(value, "__anemo_text__"):
        return value.__anemo_text__()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "__arrow_c_stream__"):
        return Table(value)
    if isinstance(value, Mapping):
        return Table(dict(value))
    if getattr(value, "shape", ()) != ():
        raise Error("an array has no names: give a table, or a dict of names to one-dimensional arrays", 2)
    plain = value.item() if hasattr(value, "item") else value
    if isinstance(plain, bool):
        return word(plain)
    if not isinstance(plain, numbers.Real):
        raise Error(f"{type(value).__name__} is no file, no table and no number", 2)
    # The shortest text that is read as the same number.
    return repr(plain)


def words_of(command: str, given: tuple[Any, ...], options: dict[str, Any]) -> list[tuple[str, Any]]:
    words: list[tuple[str, Any]] = [("", part) for part in command.split()]
    for value in given:
        if value is not None:
            # A path that begins with a hyphen is no option.
            value = word(value)
            words.append(("", f"./{value}" if isinstance(value, str) and value.startswith("-") else value))
    for option, value in options.items():
        if value is FLAG:
            words.append(("", option))
        elif isinstance(value, Several):
            words += [(f"{option}=", word(part)) for part in value]
        elif value is not None:
            words.append((f"{option}=", word(value)))
    return words


def call(command: str, given: tuple[Any, ...], options: dict[str, Any], result: type[Result]) -> Result:
    """Carries out a command, and makes a `result` of what it gives."""
    made: Any
    if result is Report:
        made = performed(command, given, options)[1]
    elif result is Table:
        # Without a file to write to, the rows come back as a table.
        place = "--output-file" if options.get("--output-file") is None else None
        _, report, table = performed(command, given, options, place)
        made = report if table is None else table
        if table is not None:
            table.report = report
    elif command == "identify":
        text, report, _ = performed(command, given, options)
        made = Model.from_json(text)
        made.report = report
    else:
        readable: Any = result
        extension = "toml" if readable is Head else "json"
        with tempfile.TemporaryDirectory(prefix="anemo-") as folder:
            path = options.get("--output-file") or Path(folder, f"result.{extension}")
            _, report, _ = performed(command, given, {**options, "--output-file": path})
            made = readable.read(os.fspath(path))
        if options.get("--output-file") is None:
            # The file that stood in between is nobody's.
            report.text = "".join(line for line in report.text.splitlines(True) if folder not in line).rstrip()
        made.report = report
    return cast(Result, made)


def performed(
    command: str, given: tuple[Any, ...], options: dict[str, Any], place: str | None = None
) -> tuple[str, Report, Table | None]:
    """Carries out a command: its JSON, its report, and the table that is wanted."""
    words = words_of(command, given, options)
    if command == "run":
        words.append(("", "--on=sim"))
    text, printed, said, code, sentence, table, stopped = perform(words, place)
    report = Report(json.loads(text) if text else {}, printed)
    if stopped is not None:
        if table is not None:
            table.report = report
        raise Interrupted(table) if isinstance(stopped, KeyboardInterrupt) else stopped
    for warning in said:
        warnings.warn(warning, stacklevel=4)
    if sentence is not None:
        # A run that tripped or ended early has recorded something, which is not thrown away.
        if code not in (3, 4) or table is None:
            raise Error(sentence, code)
        warnings.warn(sentence, stacklevel=4)
    return text or "", report, table
