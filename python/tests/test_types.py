"""The package's annotations, and what a user's own checker makes of a script."""

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

pytest.importorskip("mypy", reason="mypy is not installed: annotations are not checked")


def checked(*what: str, folder: Path) -> str:
    command = [sys.executable, "-m", "mypy", "--cache-dir", str(folder / "cache"), *what]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300).stdout


def test_every_annotation_of_the_package_is_complete(tmp_path):
    package = ROOT / "python/anemo"
    found = checked("--config-file", str(ROOT / "python/pyproject.toml"), str(package), folder=tmp_path)
    assert found.startswith("Success: no issues found"), found


def test_a_script_is_checked_against_the_stubs(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import anemo\n"
        "model = anemo.identify('run.parquet', order=5, mesh=(0.01, 30))\n"
        "gain, error = model.steady_gain()\n"
        "reveal_type(gain)\n"
        "reveal_type(anemo.simulate('a.toml')['time_s'])\n"
        "reveal_type(anemo.calibrate('tunnel.parquet').report)\n"
        "anemo.identify('run.parquet', odrer=5)\n"
        "model.foster(1)\n"
    )
    found = checked("--strict", str(script), folder=tmp_path)
    for line, said in [
        (4, 'Revealed type is "float"'),
        (5, "ndarray"),
        (6, "anemo._results.Report"),
        (7, 'Unexpected keyword argument "odrer"'),
        (8, 'Argument 1 to "foster" of "Model" has incompatible type "int"'),
    ]:
        assert any(part.startswith(f"script.py:{line}:") and said in part for part in found.splitlines()), found
