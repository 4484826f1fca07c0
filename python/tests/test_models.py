"""Models as numpy arrays and as objects of python-control."""

import copy
import pickle

import anemo
import control
import numpy as np
import pytest
from conftest import EXPERIMENTS, POLES, heater


def test_a_model_pickles_copies_compares_and_prints(model, tmp_path):
    for same in (pickle.loads(pickle.dumps(model)), copy.copy(model), copy.deepcopy(model)):
        assert same == model
    path = tmp_path / "model.json"
    model.write(path)
    assert anemo.Model.read(path) == model and anemo.Model.from_json(path.read_text()) == model
    other = anemo.reduce(model, order=1)
    assert other != model and other.report["order"] == 1
    assert "lost on random bits" in str(other.report) and "result.json" not in str(other.report)
    assert model.report.fit_percent == model.fit_percent and "steady gain" in str(model.report)
    assert repr(model).startswith("<anemo.Model power_w_core → temperature_c_core: 2 rates, fit 99.")
    assert "steady gain" in str(model)
    html = model._repr_html_()
    assert "<svg" in html and "anemo.Model" in html


def test_forms_of_a_model_are_those_of_the_export(model, tmp_path):
    foster = model.foster()
    gain, error = model.steady_gain()
    assert np.isclose(foster["resistance_k_per_w"].sum(), gain, rtol=1e-12)
    assert abs(gain - sum(r for r, _ in POLES)) < 4 * error < 0.1
    assert np.allclose(
        foster["resistance_k_per_w"] * foster["capacitance_j_per_k"], foster["time_constant_s"], rtol=1e-12
    )
    exported = anemo.export(model, as_="foster")
    assert np.array_equal(np.array(exported["rows"])[:, 2], foster["resistance_k_per_w"])
    spectrum = model.spectrum()
    assert np.all(np.diff(spectrum["rate_rad_s"]) > 0) and np.all(spectrum["se_k_per_w"] > 0)
    ladder, steps = model.cauer(), model.structure()
    assert np.allclose(np.cumsum(ladder["resistance_k_per_w"]), steps["cumulative_resistance_k_per_w"])
    assert np.isclose(ladder["resistance_k_per_w"].sum(), gain)


def test_responses_are_those_of_the_poles(model):
    rates, resistances = model.foster()["rate_rad_s"], model.foster()["resistance_k_per_w"]
    omega = np.array([1e-6, 0.01, 1.0])
    response = model.frequency_response(omega)
    assert response.dtype == np.complex128
    assert np.allclose(response, (resistances / (1 + 1j * omega[:, None] / rates)).sum(axis=1), rtol=1e-12)
    time_s = np.array([-1.0, 0.0, 3.0])
    expected = (resistances * rates * np.exp(-np.outer(time_s, rates))).sum(axis=1)
    assert np.allclose(model.impulse(time_s), np.where(time_s < 0, 0, expected), rtol=1e-12)


def test_python_control_steps_the_model_as_validate_does(model):
    again = heater(2)
    system = model.to_control()
    assert np.isclose(system.dt, 0.1) and system.dt == model.sample_period_s
    assert system.input_labels == model.inputs and system.output_labels == model.outputs
    rise = control.forced_response(system, U=again["power_w_core"]).outputs
    rms = float(np.sqrt(np.mean((again["temperature_c_core"] - (model.offset_c + rise)) ** 2)))
    report = anemo.validate(model, again, start="rest")
    assert abs(report.rmse - rms) < 1e-9 * rms
    assert abs(rms - 0.01) < 3e-4, "what is left is the noise"
    faster = model.to_control(dt=0.01)
    assert np.isclose(control.dcgain(faster), model.steady_gain()[0])


def test_a_model_of_two_sectors_has_two_inputs_and_refuses_what_is_ambiguous(prbs):
    two = anemo.identify(
        prbs, input=["sector1", "sector2"], output=["sector1", "sector2"], order=4, drift="none"
    )
    system = two.to_control()
    assert (system.ninputs, system.noutputs) == (2, 2)
    gain = control.dcgain(system)
    assert np.isclose(gain[0, 1], two.steady_gain("sector2:sector1")[0], rtol=1e-9)
    forecast = anemo.predict(two, EXPERIMENTS / "held.toml")
    assert forecast.element == "sector1"
    with pytest.raises(anemo.Error, match="the model has 4 pairs: name one with --pair"):
        two.foster()
    with pytest.raises(anemo.Error, match="no class `gust`"):
        two.to_control(class_="gust")


def test_analysis_takes_a_model(model):
    report = anemo.analyse(model, target=5)
    assert report.text and str(report) == report.text and pickle.loads(pickle.dumps(report)) == report
    with pytest.raises(AttributeError, match="there is no `nothing` here"):
        report.nothing
