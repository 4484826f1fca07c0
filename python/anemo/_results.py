"""What the functions give."""

from __future__ import annotations

import json
import os
import tomllib
from pathlib import Path
from typing import Any, Self

from ._anemo import Text
from ._error import Error


class Report(dict[str, Any]):
    """The keys of the command's `--json`, also as attributes; `str(report)` is its summary."""

    def __init__(self, content: dict[str, Any] | None = None, text: str = "") -> None:
        super().__init__(content or {})
        self.text = text

    def __reduce__(self) -> tuple[Any, ...]:
        return Report, (dict(self), self.text)

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"there is no `{name}` here; there is {', '.join(self)}") from None

    def __str__(self) -> str:
        return self.text or json.dumps(self, indent=2)

    def _repr_html_(self) -> str:
        return f"<pre>{escaped(str(self))}</pre>"


def escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


class File:
    """The text of a file, whether it lies on the disk or not."""

    extension = "toml"

    def __init__(self, text: str, folder: os.PathLike[str] | str = ".") -> None:
        self.text = text
        # What the text names is sought from here.
        self.folder = Path(folder).resolve()
        self.report = Report()

    @classmethod
    def read(cls, path: os.PathLike[str] | str) -> Self:
        """Reads a file."""
        try:
            text = Path(path).read_text(encoding="utf-8")
        except OSError as error:
            raise Error(f"{path}: {error.strerror}", 2) from None
        return cls(text, Path(path).resolve().parent)

    def write(self, path: os.PathLike[str] | str) -> None:
        """Writes the file, in whole or not at all."""
        self.__anemo_text__().write(path)

    def __str__(self) -> str:
        return self.report.text or self.text

    def __anemo_text__(self) -> Text:
        return Text(self.folder, self.extension, self.text)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.text == other.text

    __hash__ = None  # type: ignore[assignment]


class Head(File):
    """A head file: elements, limits, calibration. Its tables are `head["calibration"]` and so on."""

    @property
    def content(self) -> dict[str, Any]:
        """All of it, as `tomllib` reads it."""
        return tomllib.loads(self.text)

    @property
    def name(self) -> str:
        """What the head is called."""
        return str(self.content["name"])

    def __getitem__(self, key: str) -> Any:
        return self.content[key]

    def __repr__(self) -> str:
        return f"<anemo.{type(self).__name__} {self.content.get('name', self.content.get('title', ''))}>"


class Experiment(Head):
    """An experiment file: head, drives, winds, duration."""

    @property
    def name(self) -> str:
        """Its title."""
        return str(self.content.get("title", ""))


class Network(File):
    """The quiescent-gas network of a head, as `anemo.calibrate` takes it by `network=`."""

    extension = "json"

    @property
    def content(self) -> dict[str, Any]:
        """All of it."""
        return dict(json.loads(self.text))

    def __repr__(self) -> str:
        return f"<anemo.Network: {len(self.text)} bytes of JSON>"
