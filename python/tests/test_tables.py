"""Tables go to other libraries and come from them, and say what is wrong with them."""

import anemo
import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
from conftest import heater


def test_every_library_takes_a_table_and_gives_it_back(prbs):
    arrow = pa.table(prbs)
    assert arrow.num_rows == len(prbs) and arrow.column_names == prbs.columns
    power = prbs["power_w_sector1"]
    assert power.dtype == np.float64 and set(np.unique(prbs["heater_sector1"])) == {0.0, 1.0}
    frames = [arrow, pl.DataFrame(prbs), arrow.to_pandas(), duckdb.sql("from arrow").to_arrow_table()]
    for frame in frames:
        back = anemo.Table(frame)
        assert back.columns == prbs.columns
        assert np.array_equal(back["power_w_sector1"], power)
        assert list(back["state"][:3]) == list(prbs["state"][:3])


def test_columns_are_handed_on_without_a_copy(prbs):
    column = pa.table(prbs).column("power_w_sector1").chunk(0)
    again = pa.table(anemo.Table(pa.table(prbs))).column("power_w_sector1").chunk(0)
    assert column.buffers()[1].address == again.buffers()[1].address


def test_a_recording_says_of_itself_what_its_file_says(prbs, short, tmp_path):
    assert prbs.metadata["format"] == "2" and "sphere" in prbs.metadata["head"]
    path = tmp_path / "short.parquet"
    anemo.simulate(short, output_file=path)
    read = anemo.load(path)
    table = anemo.simulate(short)
    assert table.metadata["hash"] == read.metadata["hash"]
    for name in table.columns:
        assert np.array_equal(table[name], read[name], equal_nan=table[name].dtype.kind == "f"), name


def test_a_mapping_of_arrays_is_a_table():
    table = anemo.Table({"time_s": np.arange(4) * 0.5, "u": [0, 1, 1, 0], "event": ["a", "a", "b", "b"]})
    assert (len(table), list(table["event"]), list(table["u"])) == (4, ["a", "a", "b", "b"], [0.0, 1.0, 1.0, 0.0])
    with pytest.raises(anemo.Error, match="column `u` has 3 rows where others have 4"):
        anemo.Table({"time_s": np.arange(4), "u": np.arange(3)})
    with pytest.raises(anemo.Error, match="has no rows"):
        anemo.Table({})
    with pytest.raises(anemo.Error, match="has no columns"):
        anemo.Table(pa.table({}))
    masked = np.ma.masked_array([1.0, 2.0, 3.0, 4.0], mask=[False, True, False, False])
    moments = np.datetime64("2026-01-01T00:00:00") + np.arange(4) * np.timedelta64(500, "ms")
    odd = anemo.Table({"t": moments, "since": moments - moments[0], "y": masked})
    assert list(odd["t"] - odd["t"][0]) == list(odd["since"]) == [0.0, 0.5, 1.0, 1.5]
    assert odd["t"][0] == 1767225600.0 and np.isnan(odd["y"][1]) and odd["y"][3] == 4.0
    with pytest.raises(KeyError, match="did you mean `time_s`"):
        table["time"]


def test_nulls_moments_and_small_types_are_numbers():
    stamps = pa.array([0, 500, 1000], pa.timestamp("ms"))
    table = anemo.Table(
        pa.table(
            {
                "t": stamps,
                "u": pa.array([1, None, 3], pa.int8()),
                "on": pa.array([True, False, None]),
                "y": pa.array([1.5, 2.5, 3.5], pa.float32()),
                "event": pa.array(["a", None, "b"]).dictionary_encode(),
            }
        )
    )
    assert list(table["t"]) == [0.0, 0.5, 1.0]
    assert np.array_equal(table["u"], [1.0, np.nan, 3.0], equal_nan=True)
    assert np.array_equal(table["on"], [1.0, 0.0, np.nan], equal_nan=True)
    assert (list(table["y"]), list(table["event"])) == ([1.5, 2.5, 3.5], ["a", "", "b"])
    nested = anemo.Table(pa.table({"t": [0.0, 1.0], "pair": [[1, 2], [3, 4]]}))
    with pytest.raises(anemo.Error, match="column `pair` is of the type List"):
        nested["pair"]


def test_an_index_of_pandas_is_the_time_or_nothing():
    rows = pd.DataFrame({"t": [0.0, 0.5, 1.0], "u": [0.0, 1.0, 0.0], "y": [1.0, 1.0, 2.0]})
    assert anemo.Table(rows[rows["t"] > 0.2]).columns == ["t", "u", "y"]
    assert anemo.Table(rows.set_index("t")).columns == ["t", "u", "y"]
    stamped = rows[["u", "y"]].set_axis(pd.to_datetime(rows["t"].to_numpy(), unit="s"), axis="index")
    table = anemo.Table(stamped)
    assert table.columns[1:] == ["u", "y"] and list(table[table.columns[0]]) == [0.0, 0.5, 1.0]
    assert "pandas" not in table.metadata


def test_a_unit_that_contradicts_the_name_is_refused():
    field = pa.field("power_w_core", pa.float64(), metadata={"unit": "mW"})
    table = pa.table([[1.0, 2.0]], schema=pa.schema([field]))
    with pytest.raises(anemo.Error, match="is in mW by its metadata and in W by its name"):
        anemo.Table(table)


def test_an_array_is_no_table():
    with pytest.raises(anemo.Error, match="an array has no names"):
        anemo.identify(np.zeros((10, 2)), sample_period=1)


def test_units_other_than_those_of_the_names_are_warned_of():
    record = heater(3, 4000)
    record = {"time_s": record["time_s"], "Heater (mW)": 1e3 * record["power_w_core"], "T (°C)": record["temperature_c_core"]}
    model = anemo.identify(record, input="Heater (mW)", output="T (°C)", free_poles=2, feed_through=False, dead_time=0)
    with pytest.warns(UserWarning, match="numbers are in K/mW"):
        gain = model.foster()["resistance_k_per_w"].sum()
    assert abs(gain - 0.013) < 1e-4


def test_a_missing_file_is_the_sentence_of_the_command_line(tmp_path):
    with pytest.raises(anemo.Error, match="none.parquet: there is no such file") as raised:
        anemo.load(tmp_path / "none.parquet")
    assert raised.value.code == 2


def test_a_frame_is_identified_like_the_file_that_it_came_from(prbs, tmp_path):
    path = tmp_path / "part.csv"
    frame = pa.table(prbs).slice(0, 20_000).to_pandas()[["time_s", "power_w_sector1", "temperature_c_sector1"]]
    frame.to_csv(path, index=False)
    options = {"input": "sector1", "output": "sector1", "order": 5}
    of_file = anemo.identify(path, **options)
    # pandas writes the shortest digits that read back as the same number.
    for source in (frame, pl.from_pandas(frame), {name: frame[name].to_numpy() for name in frame}):
        of_frame = anemo.identify(source, **options)
        assert of_frame.to_json().replace("the table", str(path)) == of_file.to_json()
    assert isinstance(pd.DataFrame(of_file.spectrum()), pd.DataFrame)
