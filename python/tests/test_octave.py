"""The functions for MATLAB and Octave, and the page that shows them, run by Octave."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import anemo
import numpy as np
import pytest
from conftest import EXPERIMENTS, ROOT

scipy_io = pytest.importorskip("scipy.io", reason="scipy is not installed: no .mat file is written")
OCTAVE = shutil.which("octave-cli")
pytestmark = pytest.mark.skipif(OCTAVE is None, reason="octave-cli is not installed: nothing of Octave is tested")
FUNCTIONS = ROOT / "docs/how-to/octave"
PAGE = ROOT / "docs/how-to/use-from-matlab.md"


def octave(folder: Path, script: str, fails: bool = False) -> str:
    """What a script prints."""
    command = [OCTAVE, "--norc", "--no-history", "--eval", f"addpath('{FUNCTIONS}'); {script}"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert (done.returncode != 0) == fails, done.stderr
    return done.stderr if fails else done.stdout


def windy(short: Path) -> anemo.Experiment:
    """A minute with two winds, one second each in turn, and bits on two sectors."""
    text = short.read_text()
    winds = "".join(
        f'[[wind]]\nstart_s = {k}.0\nlabel = "{label}"\nspeed_m_s = {speed}\nazimuth_deg = 45.0\n'
        for k in range(60)
        for label, speed in [[("light air", 1.0), ("gale, gusty", 8.0)][k % 2]]
    )
    return anemo.Experiment(text[: text.index("[[wind]]")] + winds, EXPERIMENTS)


def save_mat(path: Path, table: anemo.Table) -> None:
    columns = {name: table[name] for name in table.columns}
    # Text as objects becomes a cell array.
    cells = {name: column.astype(object) for name, column in columns.items() if column.dtype.kind == "U"}
    scipy_io.savemat(path, columns | cells, oned_as="column")


def predicted_in_octave(folder: Path, recording: str, inputs: list[str]) -> np.ndarray:
    octave(
        folder,
        f"y = predict_anemo(jsondecode(fileread('model.json')), read_anemo('{recording}'));"
        "file = fopen('predicted', 'w'); fwrite(file, y, 'double'); fclose(file);",
    )
    return np.fromfile(folder / "predicted").reshape(len(inputs), -1)


@pytest.mark.parametrize(
    "options",
    [
        {"order": 6},
        {"order": 5, "feed_through": True, "dead_time": 3},
        {"free_poles": 2},
    ],
    ids=["grid", "feed-through and dead time", "free poles"],
)
def test_octave_predicts_what_validate_predicts(short, tmp_path, options):
    sectors = ["sector1", "sector2"]
    run = anemo.simulate(windy(short))
    model = anemo.identify(run, input=sectors, output=sectors, drift="none", **options)
    assert set(model.classes) == {"gale, gusty", "light air"}
    model.write(tmp_path / "model.json")
    save_mat(tmp_path / "run.mat", run)
    predicted = predicted_in_octave(tmp_path, "run.mat", sectors)
    # Against what Octave has predicted nothing is left, row by row, but rounding: R of the two
    # classes cancel in part. 4e-14 was measured.
    columns = {name: run[name] for name in run.columns if name.startswith(("time_s", "power_w", "event"))}
    columns |= {f"temperature_c_{name}": column for name, column in zip(sectors, predicted)}
    report = anemo.validate(model, columns, start="rest")
    for output, column in zip(report.outputs, predicted):
        assert np.std(column) > 0.1
        assert output["rmse"] < 1e-9 * np.std(column), output
    # And the measured output has the error in Octave that it has here.
    rmse = anemo.validate(model, run, start="rest").outputs[0]["rmse"]
    own = np.sqrt(np.mean((predicted[0] - run["temperature_c_sector1"]) ** 2))
    assert abs(own / rmse - 1) < 1e-9


def test_a_csv_and_a_mat_file_are_the_same_record(short, tmp_path):
    anemo.simulate(short, output_file=tmp_path / "run.csv")
    save_mat(tmp_path / "run.mat", anemo.load(tmp_path / "run.csv"))
    printed = octave(
        tmp_path,
        "a = read_anemo('run.csv'); b = read_anemo('run.mat'); printf('%s\\n', a.about.title, b.event{end});"
        "a = rmfield(a, 'about'); b = rmfield(b, 'about'); assert(isequaln(a, b)); assert(numfields(a) > 20);",
    )
    assert printed == "Pseudo-random heating\nlight air\n"


def test_what_octave_writes_is_identified_with_the_same_model(short, tmp_path):
    names = ["time_s", "power_w_sector1", "temperature_c_sector1"]
    run = anemo.simulate(short)
    save_mat(tmp_path / "run.mat", run)
    octave(
        tmp_path,
        f"load('run.mat'); save('-v7', 'back.mat', '{names[0]}', '{names[1]}', '{names[2]}');"
        f"file = fopen('back.csv', 'w'); fprintf(file, '{','.join(names)}\\n');"
        f"fprintf(file, '%.17g,%.17g,%.17g\\n', [{', '.join(names)}]'); fclose(file);",
    )
    of_mat = {name: column.ravel() for name, column in scipy_io.loadmat(tmp_path / "back.mat").items() if name in names}
    options = {"order": 5, "drift": "none"}
    of_run = anemo.identify({name: run[name] for name in names}, **options)
    assert anemo.identify(of_mat, **options) == of_run
    of_csv = anemo.identify(tmp_path / "back.csv", **options)
    assert of_csv.to_json().replace(str(tmp_path / "back.csv"), "the table") == of_run.to_json()


def test_what_the_functions_cannot_do_they_refuse(short, tmp_path):
    (tmp_path / "quoted.csv").write_text('time_s,event\n0,"a, b"\n')
    model = "m = struct('sample_period_s', 0.05, 'losses', 1); "
    gap = "m = struct('sample_period_s', 0.05); r.time_s = [0; 0.05; 0.2]; predict_anemo(m, r)"
    for script, sentence in [
        ("read_anemo('run.parquet')", "run.parquet is neither .csv nor .mat"),
        ("read_anemo('quoted.csv')", "has a comma in a cell"),
        (model + "predict_anemo(m, struct())", "the model has `losses`"),
        (gap, "rows are not always 0.05 s apart"),
    ]:
        assert sentence in octave(tmp_path, script, fails=True)


def test_the_page_does_what_it_shows(tmp_path):
    for name in ("experiments", "heads"):
        (tmp_path / name).symlink_to(ROOT / name)
    beside = os.path.dirname(sys.executable)
    environment = {**os.environ, "PATH": f"{beside}:{os.environ['PATH']}"}
    page = PAGE.read_text(encoding="utf-8")
    saves = "".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL))
    # Octave on a machine without a screen has nothing to draw with.
    script = re.sub(r"^plot.*$", "", "".join(re.findall(r"```matlab\n(.*?)```", page, re.DOTALL)), flags=re.MULTILINE)
    before = re.findall(r"^\$ (anemo .*)$", page, re.MULTILINE)
    after = re.findall(r"^`(anemo identify .*?)`", page, re.MULTILINE)
    assert (len(before), script.count("assert"), len(after)) == (2, 3, 1)
    for commands, then in [(before, script), (after, "")]:
        for command in commands:
            subprocess.run(command, shell=True, check=True, cwd=tmp_path, env=environment, stdout=subprocess.DEVNULL)
        subprocess.run([sys.executable, "-c", saves], check=True, cwd=tmp_path)
        octave(tmp_path, then)
    columns = ["power_w_sector1", "temperature_c_sector1"]
    run = anemo.load(tmp_path / "prbs.parquet")
    of_run = anemo.identify({name: run[name] for name in ["time_s", *columns]}, free_poles=3)
    assert anemo.Model.read(tmp_path / "back.json").steady_gain() == of_run.steady_gain()
