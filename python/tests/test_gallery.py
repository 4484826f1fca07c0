"""The gallery: each script runs to its end, whose asserts check what it claims, and draws its picture."""

import importlib.util
import os
import subprocess
import sys

import pytest
from conftest import ROOT

GALLERY = ROOT / "python/gallery"
# What a script needs beside numpy and anemo.
NEEDS = {
    "beside_other_libraries": ["matplotlib", "control", "sippy_unipi", "sysidentpy"],
    "calibration": ["matplotlib"],
    "head_in_the_tunnel": ["matplotlib"],
    "identify_your_csv": ["matplotlib", "pandas"],
    "live_stream": ["matplotlib", "pandas"],
    "mems_laws": ["matplotlib", "scipy"],
    "structure_function": ["matplotlib", "PyRth"],
}


@pytest.mark.parametrize("name", sorted(path.stem for path in GALLERY.glob("*.py")))
def test_a_script_of_the_gallery_runs_and_keeps_its_claims(name, tmp_path):
    missing = [library for library in NEEDS[name] if importlib.util.find_spec(library) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} is not installed: pip install -r python/gallery/requirements.txt")
    # No window; libraries write their caches where they are told.
    environment = {**os.environ, "MPLBACKEND": "Agg", "MPLCONFIGDIR": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, GALLERY / f"{name}.py", tmp_path]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    picture = tmp_path / f"{name}.png"
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 10_000


def test_every_script_is_short_and_of_cells():
    for path in GALLERY.glob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= 120, path
        assert text.startswith("# %% [markdown]\n# # ") and "\n# %%\n" in text, path
        assert text.splitlines()[-1].startswith(("assert", "    assert")), f"{path} ends with its claims"
