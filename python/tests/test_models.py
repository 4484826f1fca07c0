"""Models as numpy arrays and as objects of python-control."""

import copy
import pickle

import anemo
import control
import numpy as np
import pytest
from conftest import EXPERIMENTS


def test_a_model_pickles_copies_compares_and_prints(model, tmp_path):
    for same in (pickle.loads(pickle.dumps(model)), copy.copy(model), copy.deepcopy(model)):
        assert same == model
    path = tmp_path / "model.json"
    model.write(path)
    assert anemo.Model.read(path) == model and anemo.Model.from_json(path.read_text()) == model
    other = anemo.reduce(model, order=2)
    assert other != model and other.report["order"] == 2
    assert repr(model).startswith("<anemo.Model power_w_sector1 → temperature_c_sector1: 6 rates")
    assert "steady gain" in str(model)
    html = model._repr_html_()
    assert "<svg" in html and "anemo.Model" in html


def test_forms_of_a_model_are_those_of_the_export(model, tmp_path):
    foster = model.foster()
    # Steady gain is the sum of the resistances, and every cell's R C is its time constant.
    gain, error = model.steady_gain()
    assert np.isclose(foster["resistance_k_per_w"].sum(), gain, rtol=1e-12) and 0 < error < 0.01 * gain
    assert np.allclose(
        foster["resistance_k_per_w"] * foster["capacitance_j_per_k"], foster["time_constant_s"], rtol=1e-12
    )
    exported = anemo.export(model, as_="foster")
    assert np.array_equal(np.array(exported["rows"])[:, 2], foster["resistance_k_per_w"])
    spectrum = model.spectrum()
    assert np.all(np.diff(spectrum["rate_rad_s"]) > 0) and np.all(spectrum["se_k_per_w"] > 0)
    omega = np.array([1e-6, 0.01, 1.0])
    response = model.frequency_response(omega)
    assert response.dtype == np.complex128 and np.isclose(abs(response[0]), gain, rtol=1e-3)
    time_s = np.linspace(0, 2000, 200_001)
    # The integral of the impulse response is what the slow rates have reached by then.
    reached = np.trapezoid(model.impulse(time_s), time_s)
    slow = foster["rate_rad_s"] < 5
    expected = (foster["resistance_k_per_w"] * (1 - np.exp(-foster["rate_rad_s"] * 2000)))[slow].sum()
    assert abs(reached - expected) < 0.01 * gain


def test_python_control_steps_the_model_as_validate_does(model):
    again = anemo.simulate(
        anemo.Experiment(
            (EXPERIMENTS / "prbs.toml").read_text().replace("seed = 1", "seed = 2"), EXPERIMENTS
        )
    )
    system = model.to_control()
    assert system.dt == model.sample_period_s == 0.05
    assert system.input_labels == model.inputs and system.output_labels == model.outputs
    power, measured = again["power_w_sector1"], again["temperature_c_sector1"]
    rise = control.forced_response(system, U=power).outputs
    rms = float(np.sqrt(np.mean((measured - (model.offset_c + rise)) ** 2)))
    report = anemo.validate(model, again, start="rest")
    assert abs(report["outputs"][0]["rms_k"] - rms) < 1e-6 * rms, (report, rms)


def test_a_model_of_two_sectors_has_two_inputs_and_refuses_what_is_ambiguous(prbs):
    two = anemo.identify(
        prbs, input=["sector1", "sector2"], output=["sector1", "sector2"], order=4, drift="none"
    )
    system = two.to_control()
    assert (system.ninputs, system.noutputs) == (2, 2)
    gain = control.dcgain(system)
    assert np.isclose(gain[0, 1], two.steady_gain("sector2:sector1")[0], rtol=1e-9)
    with pytest.raises(anemo.Error, match="the model has 4 pairs: name one with --pair"):
        two.foster()
    with pytest.raises(anemo.Error, match="no class `gust`"):
        two.to_control(class_="gust")


def test_analysis_design_and_prediction_take_a_model(model):
    report = anemo.analyse(model, target=15)
    assert "text" not in report and str(report).strip()
    with pytest.raises(AttributeError, match="there is no `nothing` here"):
        report.nothing
    forecast = anemo.predict(model, EXPERIMENTS / "held.toml")
    assert forecast["elements"][0]["element"] == "sector1"
