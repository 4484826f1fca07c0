# Written by `cargo xtask reference` from the definition of the command line.
"""The commands as functions: what stands in the help of a command stands here."""

from __future__ import annotations

from ._anemo import Model, Table
from ._call import Number, Paths, Source, Words, call, flag, several
from ._results import Head, Network, Report


def identify(
    *records: Source,
    output_file: Paths = None,
    input: Words = None,
    output: Words = None,
    event: Number = None,
    columns: Words = None,
    time_unit: Number = None,
    sample_period: Number = None,
    structure: Number = None,
    gas_temperature: Number = None,
    ambient: Number = None,
    reference: Number = None,
    order: Number = None,
    mesh: Number = None,
    ridge: Number = None,
    non_negative: Number = None,
    initial_state: Number = None,
    feed_through: Number = None,
    dead_time: Number = None,
    free_poles: Number = None,
    tie: bool = False,
    losses: Number = None,
    drift: Number = None,
    plot: Paths = None,
    plot_width: Number = None,
    plot_panel: Words = None,
    report: Paths = None,
) -> Model:
    """Identify a thermal model from a record, with standard errors.

    The model is diffusive: thermal resistances on a logarithmic grid of rates (diffusive mesh).

    The record is a recording of `anemo run`, or any table that a logger writes with the time in its
    first column. Gaps end a segment, across which nothing is taken. Options not given are chosen by
    their evidence, or by block cross-validation, and the reasons printed. The picture shows
    time-constant spectrum (diffusive symbol), fit, the offset's drift if it has one, residuals,
    frequency response and structure function.

    Parameters
    ----------
    records
        The record: .parquet or .csv files; several are segments of one record, or one segment where
        each goes on where the one before ended
    output_file
        Write the model to this .json file
    input
        Input columns, or elements; by default a recording's powers that vary, another table's
        columns that change between the first and the last
    output
        Output columns, or elements; by default the temperatures of a recording's inputs, another
        table's last column
    event
        Column with the labels of the conditions (winds); by default a text column `event`, in
        another table than a recording also `class`, `wind`, `condition`, `phase` or `label`
    columns
        Names of all columns, in their order: for a table without a line of names, or in place of
        them
    time_unit
        Unit of the times; by default what their column's name says (`time_ms`, `t [min]`), or s
        - "s"
        - "ms"
        - "us"
        - "min"
        - "h"
        - "d"
    sample_period
        Distance of the rows in time, s, for a table without times
    structure
        `symbol`: a time-constant spectrum a class; `conductance`: one spectrum, and a conductance a
        class
        - "symbol"
        - "conductance"
    gas_temperature
        Gas temperature for --structure conductance, °C, or its column; estimated if not given
    ambient
        Measured temperature of the surroundings, which the output follows with relaxations of its
        own: a column in °C. For structure `symbol`
    reference
        Class from whose conductance the others are counted; by default the least
    order
        Number of rates, 100 at most
    mesh
        Edges of the logarithmic grid of rates (diffusive mesh), rad/s
    ridge
        Ridge on columns of unit norm; 0 for plain least squares
    non_negative
        Resistances that may not be negative: `auto` (unless cross-validation rejects it; none, of
        structure `conductance`), `all`, `none`, or pairs as INPUT:OUTPUT,…
        By default auto.
    initial_state
        Initial state of the record; chosen if not given
        - "rest": All states zero
        - "settled": As if the first row's inputs had been held for ever
        - "free": Anything
    feed_through
        Whether the output may follow its input at once. This and --dead-time are searched for,
        unless both --order and --mesh are given
    dead_time
        Samples by which the output is late, the same for all inputs
    free_poles
        Number of free rates of an output, 1 to 8, for a small model; the fit starts from that on
        the grid
    tie
        Reciprocal pairs: resistances from input i to output j are those from input j to output i
    losses
        Losses that grow with temperature: power less g (T − T₀)², T₀ being the temperature without
        heating
        - "none": Heat is lost in proportion to temperature
        - "growing": g ≥ 0 of every element is estimated
        - "auto": As `growing` where the record leaves no doubt, else as `none`
        By default auto.
    drift
        Whether the offset moves, as a room's temperature does
        - "auto": If the record shows it: kind and size of most evidence
        - "none": It stands; nothing is averaged either
        - "random-walk": A level with increments that have no memory
        - "integrated-walk": A slope with such increments
        - "correlated": A level that returns within a correlation time
        By default auto.
    plot
        Draw a picture into this .svg, .pdf or .png file
    plot_width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    plot_panel
        Draw only the panels whose captions begin so
    report
        Write a report into this .html file: record, gains, fit, choices, warnings, what the next
        record should be, and the pictures. It needs no other file, and prints on A4
    """
    return call(
        "identify",
        (*records,),
        {
            "--output-file": output_file,
            "--input": several(input),
            "--output": several(output),
            "--event": event,
            "--columns": several(columns),
            "--time-unit": time_unit,
            "--sample-period": sample_period,
            "--structure": structure,
            "--gas-temperature": gas_temperature,
            "--ambient": ambient,
            "--reference": reference,
            "--order": order,
            "--mesh": mesh,
            "--ridge": ridge,
            "--non-negative": non_negative,
            "--initial-state": initial_state,
            "--feed-through": feed_through,
            "--dead-time": dead_time,
            "--free-poles": free_poles,
            "--tie": flag(tie),
            "--losses": losses,
            "--drift": drift,
            "--plot": plot,
            "--plot-width": plot_width,
            "--plot-panel": several(plot_panel),
            "--report": report,
        },
        Model,
    )


def validate(
    model: Source,
    record: Source,
    *,
    input: Words = None,
    output: Words = None,
    event: Number = None,
    columns: Words = None,
    time_unit: Number = None,
    sample_period: Number = None,
    start: Number = None,
    plot: Paths = None,
    plot_width: Number = None,
    plot_panel: Words = None,
) -> Report:
    """Predict a record with a model, and report how well.

    The model runs over the record's inputs. The picture shows measured and predicted, residuals,
    and the model.

    Parameters
    ----------
    model
        The model: a .json file of `anemo identify` or `anemo model`
    record
        The record: a .parquet or .csv file
    input
        Input columns, or elements; by default a recording's powers that vary, another table's
        columns that change between the first and the last
    output
        Output columns, or elements; by default the temperatures of a recording's inputs, another
        table's last column
    event
        Column with the labels of the conditions (winds); by default a text column `event`, in
        another table than a recording also `class`, `wind`, `condition`, `phase` or `label`
    columns
        Names of all columns, in their order: for a table without a line of names, or in place of
        them
    time_unit
        Unit of the times; by default what their column's name says (`time_ms`, `t [min]`), or s
        - "s"
        - "ms"
        - "us"
        - "min"
        - "h"
        - "d"
    sample_period
        Distance of the rows in time, s, for a table without times
    start
        Initial state of the model
        - "estimate": Offset, and heat stored before the first row, estimated from the record
        - "continue": End of the identified record, for the rows that follow it; nothing is
        estimated
        - "rest": All states zero, the model's own offset
        By default estimate.
    plot
        Draw a picture into this .svg, .pdf or .png file
    plot_width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    plot_panel
        Draw only the panels whose captions begin so
    """
    return call(
        "validate",
        (model, record,),
        {
            "--input": several(input),
            "--output": several(output),
            "--event": event,
            "--columns": several(columns),
            "--time-unit": time_unit,
            "--sample-period": sample_period,
            "--start": start,
            "--plot": plot,
            "--plot-width": plot_width,
            "--plot-panel": several(plot_panel),
        },
        Report,
    )


def merge(
    *models: Source,
    output_file: Paths = None,
) -> Model:
    """Merge models of different pairs of input and output into one.

    The merged model adds up their responses.

    For elements driven one after the other: identify each from its own record, with all outputs,
    and merge. An output of several models has the offset and residuals of the first; `anemo
    validate` estimates offsets anew.

    Parameters
    ----------
    models
        The models: two or more .json files
    output_file
        Write the merged model to this .json file
    """
    return call(
        "model merge",
        (*models,),
        {
            "--output-file": output_file,
        },
        Model,
    )


def reduce(
    model: Source,
    *,
    order: Number = None,
    free: bool = False,
    mesh: bool = False,
    output_file: Paths = None,
    toml: Paths = None,
    class_: Number = None,
) -> Model:
    """Reduce a model to a few poles in f32, for the board, and report its error

    Parameters
    ----------
    model
        The model: a .json file of `anemo identify` or `anemo model`
    order
        Poles a pair, 1 to 8
        By default 8.
    free
        Place every rate freely (the default)
    mesh
        Keep the rates on a logarithmic grid (diffusive mesh), and place its edges
    output_file
        Write the smaller model to this .json file
    toml
        Write the board's table, as an experiment's `models` has it: 8 rates an element that heats
        itself
    class_
        Event class of that table, where the model has several
    """
    return call(
        "model reduce",
        (model,),
        {
            "--order": order,
            "--free": flag(free),
            "--mesh": flag(mesh),
            "--output-file": output_file,
            "--toml": toml,
            "--class": class_,
        },
        Model,
    )


def export(
    model: Source,
    *,
    as_: Number = None,
    pair: Number = None,
    class_: Number = None,
    points: Number = None,
    network: Number = None,
    output_file: Paths = None,
) -> Report:
    """Export a model as a network, a netlist, a table or source text

    Parameters
    ----------
    model
        The model: a .json file of `anemo identify` or `anemo model`
    as_
        
        - "foster": Resistor and capacitor of every pole, side by side and in series
        - "cauer": The ladder of resistors and capacitors with the same impedance
        - "spice": A netlist: 1 V is 1 K, 1 A is 1 W
        - "response": Magnitude and phase of the thermal impedance over frequency
        - "symbol": The time-constant spectrum (diffusive symbol), discrete and continuous, with
        standard errors
        - "structure": Cumulative structure function: heat capacity against resistance from the
        heater
        - "c": Constant tables in f32 for a C program
        - "rust": Constant tables in f32 for a Rust program
    pair
        Pair, where the model has several: columns (power_w_a:temperature_c_b) or elements (a:b)
    class_
        Event class, where the model has several
    points
        Number of frequencies of a response
        By default 200.
    network
        Which network a netlist holds
        - "foster": Resistor and capacitor side by side, in series: any model
        - "cauer": A ladder: models without negative resistances
        By default foster.
    output_file
        Write to this file instead of stdout
    """
    return call(
        "model export",
        (model,),
        {
            "--as": as_,
            "--pair": pair,
            "--class": class_,
            "--points": points,
            "--network": network,
            "--output-file": output_file,
        },
        Report,
    )


def analyse(
    model: Source,
    *,
    pair: Number = None,
    element: Number = None,
    class_: Number = None,
    target: Number = None,
    low: Number = None,
    high: Number = None,
    sample_period: Number = None,
    gas_temperature: Number = None,
    plot: Paths = None,
    plot_width: Number = None,
    plot_panel: Words = None,
) -> Report:
    """Analyse a given loop on a model: does it hold, and how fast.

    `design` chooses a loop from requirements. `analyse` examines one given loop at its set-point.
    `predict` predicts the powers of a whole experiment.

    In the limit of fast sampling the time constants of a loop at its set-point are the transmission
    zeros of the model. One class of one pair is analysed, and every change of the wind from it. The
    picture shows poles, zeros and the step response of the power.

    Parameters
    ----------
    model
        The model: a .json file of `anemo identify` or `anemo model`
    pair
        Pair, where the model has several: columns (power_w_a:temperature_c_b) or elements (a:b)
    element
        Self-heating pair of this element: short for --pair NAME:NAME
    class_
        Event class; by default the reference, or the first
    target
        Set-point, K above the temperature without heating; by default half-way between those that
        the levels can hold
    low
        Power of the low level, W; by default the least input of the identified record
    high
        Power of the high level, W; by default the greatest input
    sample_period
        Sample period of the loop, s; by default the model's
    gas_temperature
        Gas temperature, °C, where the wind is a conductance; by default the model's
    plot
        Draw a picture into this .svg, .pdf or .png file
    plot_width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    plot_panel
        Draw only the panels whose captions begin so
    """
    return call(
        "analyse",
        (model,),
        {
            "--pair": pair,
            "--element": element,
            "--class": class_,
            "--target": target,
            "--low": low,
            "--high": high,
            "--sample-period": sample_period,
            "--gas-temperature": gas_temperature,
            "--plot": plot,
            "--plot-width": plot_width,
            "--plot-panel": several(plot_panel),
        },
        Report,
    )


def design(
    model: Source,
    *,
    target: Number = None,
    pair: Number = None,
    element: Number = None,
    wind: Words = None,
    conductance: Number = None,
    gas_temperature: Number = None,
    low: Number = None,
    high: Number = None,
    margin: Number = None,
    ripple: Number = None,
    response: Number = None,
    reach: Number = None,
) -> Report:
    """Choose levels, sample period and set-point of a loop on a model.

    `design` chooses a loop from requirements. `analyse` examines one given loop at its set-point.
    `predict` predicts the powers of a whole experiment.

    The recommended loop is simulated on the model, and the result printed beside the prediction.

    Parameters
    ----------
    model
        The model: a .json file of `anemo identify` or `anemo model`
    target
        Set-point, K above the temperature without heating (of the first wind), or a range that
        would do
    pair
        Pair, where the model has several: columns (power_w_a:temperature_c_b) or elements (a:b)
    element
        Self-heating pair of this element: short for --pair NAME:NAME
    wind
        Winds in which the loop holds its set-point; by default all classes of the model
    conductance
        Winds as a range of ΔG over the reference, W/K, where the wind is a conductance
    gas_temperature
        Gas temperature, °C, where the wind is a conductance; by default the model's
    low
        Power of the low level, W; recommended if not given
    high
        Power of the high level, W; recommended if not given
    margin
        Distance of the levels from the power of every wind, as a share of it
        By default 0.5.
    ripple
        Greatest ripple of the temperature, from peak to peak, K
        By default 0.1.
    response
        Longest settling time of the power after a change of the wind, to within 2 %, s
    reach
        Longest time from rest to the set-point, s
    """
    return call(
        "design",
        (model,),
        {
            "--target": target,
            "--pair": pair,
            "--element": element,
            "--wind": several(wind),
            "--conductance": conductance,
            "--gas-temperature": gas_temperature,
            "--low": low,
            "--high": high,
            "--margin": margin,
            "--ripple": ripple,
            "--response": response,
            "--reach": reach,
        },
        Report,
    )


def predict(
    model: Source,
    experiment: Source,
    *,
    against: Paths = None,
    from_: Number = None,
    window: Number = None,
    output_file: Paths = None,
    plot: Paths = None,
    plot_width: Number = None,
    plot_panel: Words = None,
) -> Report:
    """Predict the powers of an experiment's loops from a model.

    The model was identified open loop.

    `design` chooses a loop from requirements. `analyse` examines one given loop at its set-point.
    `predict` predicts the powers of a whole experiment.

    There are two predictions: the limit of infinitely fast sampling, in which the power of a
    regulated element is the equivalent control, and the one-bit rule at the experiment's sample
    period. The second or, with --against, a recording is compared with the first. Both are
    decimated alike; changes of the wind and approaches to the set-point are left out. The picture
    shows powers and temperatures.

    An experiment on a MEMS capacitor (with a `device`) runs on the model under the very controller:
    mean symbols and shifts, which set-points can be held, and where a loop of first order locks.

    Parameters
    ----------
    model
        The model: a .json file of `anemo identify` or `anemo model`
    experiment
        The experiment: a TOML file
    against
        A recording of this experiment to compare with
    from_
        Initial state of the structure
        - "standby": Every element has long been at its low level, as in standby
        - "rest": Nothing was ever heated
        - "end": End of the record from which the model was identified
        By default standby.
    window
        Window of the decimator, s, 2 to 1625 sample periods; by default 1 s, or 20 of them if
        longer
    output_file
        Write predicted powers (`limit_w_…`, `sampled_w_…`) of every tick to this .csv or .parquet
        file
    plot
        Draw a picture into this .svg, .pdf or .png file
    plot_width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    plot_panel
        Draw only the panels whose captions begin so
    """
    return call(
        "predict",
        (model, experiment,),
        {
            "--against": against,
            "--from": from_,
            "--window": window,
            "--output-file": output_file,
            "--plot": plot,
            "--plot-width": plot_width,
            "--plot-panel": several(plot_panel),
        },
        Report,
    )


def check(
    experiment: Source,
) -> Report:
    """Read an experiment and its head, and report what would run

    Parameters
    ----------
    experiment
        The experiment: a TOML file
    """
    return call(
        "check",
        (experiment,),
        {
        },
        Report,
    )


def simulate(
    experiment: Source,
    *,
    output_file: Paths = None,
    plot: Paths = None,
    plot_width: Number = None,
    plot_panel: Words = None,
) -> Table:
    """Run an experiment and record it.

    The emulated board runs the firmware, and gives the same bits as this process; both simulate
    sensor and wind, as fast as they can. A sensor board understands the same commands. An
    experiment with a `device` in place of a `head` is one on a MEMS capacitor, simulated or read by
    an LCR meter with a bias.

    Ended early, by Ctrl-C or a lost link, it keeps what it has recorded. Exit codes: 0 done, 1
    failed, 2 wrong usage, 3 tripped, 4 ended early.

    Parameters
    ----------
    experiment
        The experiment: a TOML file
    output_file
        Record every tick to this .parquet or .csv file, or to a folder of segments
    plot
        Draw a picture into this .svg, .pdf or .png file
    plot_width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    plot_panel
        Draw only the panels whose captions begin so
    """
    return call(
        "run",
        (experiment,),
        {
            "--output-file": output_file,
            "--plot": plot,
            "--plot-width": plot_width,
            "--plot-panel": several(plot_panel),
        },
        Table,
    )


def plot(
    file: Source,
    *,
    output_file: Paths = None,
    width: Number = None,
    format: Number = None,
    panel: Words = None,
    from_: Number = None,
    to: Number = None,
) -> Report:
    """Draw a recording or a model.

    A recording gives wind, temperatures, powers and heater bits over time; a model time-constant
    spectra, frequency responses and structure functions.

    Parameters
    ----------
    file
        The recording, a .parquet or .csv file, or the model, a .json file
    output_file
        The picture: a .svg, .pdf or .png file, or what --format says
    width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    format
        Format of the picture, whatever its name
        - "svg"
        - "pdf"
        - "png": 300 dots an inch
    panel
        Draw only the panels whose captions begin so: magnitude, phase
    from_
        Draw a recording from this time on, s
    to
        Draw a recording until this time, s
    """
    return call(
        "plot",
        (file,),
        {
            "--output-file": output_file,
            "--width": width,
            "--format": format,
            "--panel": several(panel),
            "--from": from_,
            "--to": to,
        },
        Report,
    )


def identify_head(
    *records: Source,
    output_file: Paths = None,
    head: Paths = None,
    elements: Words = None,
    own_poles: Number = None,
    cross_poles: Number = None,
) -> Network:
    """Identify how all elements of a head heat themselves and each other in quiescent gas.

    Convective losses are measured against this quiescent-gas network. It takes one record an
    element, in gas at rest: the element driven pseudo-randomly, all others at their low level.
    Every pair gets as many free rates as its record resolves. The result is a model, whose offsets
    are the temperatures without heating.

    Parameters
    ----------
    records
        The records: one .parquet or .csv file an element, in any order
    output_file
        Write the network to this .json file
    head
        The head, with the number of layers between elements and surface; by default that of the
        records
    elements
        Elements of the network, with commas between them; by default all but `reference` and those
        that only sense. The others, which only measure, are part of the structure
    own_poles
        Most free rates of the self-heating of an element, 1 to 8
        By default 4.
    cross_poles
        Most free rates of the cross-heating of one element by another, 1 to 4
        By default 4.
    """
    return call(
        "head identify",
        (*records,),
        {
            "--output-file": output_file,
            "--head": head,
            "--elements": several(elements),
            "--own-poles": own_poles,
            "--cross-poles": cross_poles,
        },
        Network,
    )


def check_head(
    head: Source,
    *,
    gas: Number = None,
    pressure: Number = None,
    temperature: Number = None,
    overheat: Number = None,
    sample_period: Number = None,
    noise: Number = None,
    plot: Paths = None,
    plot_width: Number = None,
    plot_panel: Words = None,
) -> Report:
    """Report what a head comes to, from its file alone: time constants and gains of its body, the
    power that each element needs by wind, the range of winds, and what noise leaves of the speed.

    All elements are held at the overheat; those that their high level cannot bring there only
    sense. Powers are the least and the greatest over 26 directions. Warnings name what would trip,
    saturate or leave the converter. The picture shows the head by the normals of its surfaces, and
    the powers by wind.

    Parameters
    ----------
    head
        The head: a .toml file with a [body], or a `sensor` of the project
    gas
        The gas; by default that of the file's [body.gas], or air
        - "co2"
        - "air"
    pressure
        Its pressure, Pa; by default the file's, or 101 325
    temperature
        Its temperature and the support's, °C; by default the file's, or 20
    overheat
        Elements over the gas, K
        By default 30.
    sample_period
        Sample period: a bit an element, s
        By default 0.01.
    noise
        Noise of a reading, V rms; by default a code of the converter
    plot
        Draw a picture into this .svg, .pdf or .png file
    plot_width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    plot_panel
        Draw only the panels whose captions begin so
    """
    return call(
        "head check",
        (head,),
        {
            "--gas": gas,
            "--pressure": pressure,
            "--temperature": temperature,
            "--overheat": overheat,
            "--sample-period": sample_period,
            "--noise": noise,
            "--plot": plot,
            "--plot-width": plot_width,
            "--plot-panel": several(plot_panel),
        },
        Report,
    )


def compare_heads(
    estimates: Source,
    *,
    reference: Paths = None,
    reference_uncertainty: Number = None,
    interval: Number = None,
    from_: Number = None,
    heading: Number = None,
    up: Number = None,
    head: Paths = None,
    output_file: Paths = None,
) -> Report:
    """Compare a head's wind estimates with a reference anemometer beside it: scale and offset of the
    speed.

    The reference's table has `time_s`, of the same clock, and `wind_speed_m_s`, and may have
    `wind_from_deg`. Means over intervals are compared, ten at least; the more speeds differ, the
    better an offset is known. Nothing is changed unless -o requests a head: its calibration gets
    the scale, the next version, and the name of the former one. An offset is no scale and is
    refused there.

    Parameters
    ----------
    estimates
        The estimates: a file of `anemo wind`, a run or a log of the head
    reference
        The reference's table: a .csv or .parquet file
    reference_uncertainty
        Standard uncertainty of the reference's speed, %
    interval
        Length of an interval, s
        By default 60.
    from_
        The first interval begins there, s
        By default 0.
    heading
        Compass direction of the head's x axis, degrees clockwise from north, in place of
        `heading_deg`
    up
        What points up in the head's frame, in place of `up`: 0,0,1 of a head that stands upright,
        0,0,-1 of one that hangs
    head
        The calibrated head; by default that of the estimates
    output_file
        Write a head with this scale, a .toml file
    """
    return call(
        "head compare",
        (estimates,),
        {
            "--reference": reference,
            "--reference-uncertainty": reference_uncertainty,
            "--interval": interval,
            "--from": from_,
            "--heading": heading,
            "--up": up,
            "--head": head,
            "--output-file": output_file,
        },
        Report,
    )


def calibrate(
    *recordings: Source,
    network: Number = None,
    time_constant: Number = None,
    head: Paths = None,
    output_file: Paths = None,
    winds: Paths = None,
    settle: Number = None,
    form: Number = None,
    diameter_mm: Number = None,
    length_mm: Number = None,
    law: Number = None,
    exponent: Number = None,
    elements: Words = None,
    die_mm: Number = None,
    properties: Number = None,
    gravity: Number = None,
    direction_error_max_deg: Number = None,
) -> Head:
    """Calibrate a head in known winds.

    The recordings are runs in a tunnel of known winds, at constant temperature, current or power.
    With the quiescent-gas network they give the convective loss of each surface in every steady
    wind; these losses give the amplitudes of the local Nusselt number over the Reynolds number,
    each surface's gain and conductance to quiescent gas, and the mounting of the head in the
    tunnel. A single element gives King's law and the speed, wires in a plane and sectors round a
    cylinder the wind in their plane, surfaces on a sphere all of it. Errors are cross-validated.
    Winds that do not determine all of this are refused, and the missing ones named.

    In place of recordings, tables of steady winds will do, a row each. Such a table knows the
    network of surfaces that do not warm each other; without --network it takes it from its stillest
    row and --time-constant.

    Parameters
    ----------
    recordings
        The recordings, or tables of steady winds: .parquet or .csv files
    network
        The quiescent-gas network: a .json file of `anemo head identify`
    time_constant
        Of tables without a network: in what time the temperature of a surface follows a step of its
        power in still gas, s
    head
        The head; by default the one that the first recording carries. Elements with a `normal` are
        its surfaces: outward of a sphere or a cylinder, of a wire across it towards the wind
    output_file
        Write the calibrated head to this .toml file
    winds
        Winds by label, a .csv or .parquet file; by default those of the recordings (simulated
        tunnels)
    settle
        Left out at the beginning of every wind, s
        By default 20.
    form
        What the surfaces belong to; by default what the normals and the body of the head say
        - "sphere": parts of a sphere
        - "cube": six parts of a sphere, as the faces of a cube
        - "cylinder": sectors round a cylinder
        - "wires": wires or films in a plane
        - "single": one element: a speed
    diameter_mm
        Diameter of sphere, cylinder or wire, mm; by default that of the head's body, else 10
    length_mm
        Length of cylinder or wire, mm; by default that of the head's body, else 10
    law
        How the loss of a single element or of wires depends on the speed; by default what is better
        at speeds that were left out
        - "king": A + B Uᵐ; of wires with a yaw factor
        - "spline": smooth and rising
    exponent
        Exponent of King's law, if it is known; else it is fitted
    elements
        Which elements with a `normal` are the surfaces; by default all of them. Four of one normal
        are the dice of one card in a square, in winds of the card's plane: the two at the tip (+x),
        the second around the boom from the first, then the two behind, each beside the one before
        it
    die_mm
        Side of a die, mm
        By default 1.5.
    properties
        At which temperature the properties of the gas are taken; by default for a sphere that of
        the film, or what winds of several gas temperatures say, for other forms that of the gas
        - "film": half-way between gas and surfaces
        - "gas": the temperature of the gas
    gravity
        Gravity in the tunnel, m/s², for the rise of the gas that a sphere warms; 0 leaves it out
        By default 9.81.
    direction_error_max_deg
        More uncertain directions are flagged `no-direction`, °
        By default 20.
    """
    return call(
        "calibrate",
        (*recordings,),
        {
            "--network": network,
            "--time-constant": time_constant,
            "--head": head,
            "--output-file": output_file,
            "--winds": winds,
            "--settle": settle,
            "--form": form,
            "--diameter-mm": diameter_mm,
            "--length-mm": length_mm,
            "--law": law,
            "--exponent": exponent,
            "--elements": several(elements),
            "--die-mm": die_mm,
            "--properties": properties,
            "--gravity": gravity,
            "--direction-error-max-deg": direction_error_max_deg,
        },
        Head,
    )


def wind(
    recording: Source,
    *,
    head: Paths = None,
    bandwidth: Number = None,
    fixed: bool = False,
    every: Number = None,
    gas_temperature: Number = None,
    pressure: Number = None,
    gas_uncertainty: Number = None,
    pressure_uncertainty: Number = None,
    heading: Number = None,
    up: Number = None,
    winds: Paths = None,
    from_: Number = None,
    settle: Number = None,
    field_correction: Number = None,
    write_head: Paths = None,
    output_file: Paths = None,
    plot: Paths = None,
    plot_width: Number = None,
    plot_panel: Words = None,
) -> Table:
    """Estimate the wind from a recording of a calibrated head.

    The wind estimates equal those of the board to the bit: convective losses against the
    quiescent-gas network, conductances, wind vector with standard uncertainty, and quality flags.
    Where the true wind is known (simulated tunnels, or --winds), the errors are reported.

    Four surfaces have one number more than a wind needs. Where it contradicts, the report says
    which slow error of single surfaces would explain it: heat (sun, sky, a resistor that drifts) or
    gain (dust). With --field-correction that is found over the whole recording and taken out; what
    the winds do not determine stays, and widens the uncertainties. A low bandwidth shows most.

    With --write-head a head gets their means over the recording. Whatever uses that head applies
    them, on the board, too. Slow errors of a head that carries corrections are those that are left.

    Parameters
    ----------
    recording
        The recording: a .parquet or .csv file
    head
        The calibrated head (`anemo calibrate`) with the recording's elements; by default the one
        that the recording carries
    bandwidth
        Bandwidth of the convective losses, 0.5 to 50 Hz: low is smooth
        By default 2.
    fixed
        Keep the bandwidth when the wind jumps, instead of raising it for a while
    every
        Output interval, s, a whole number of ticks; by default 0.01 or a tick. An estimate is that
        of its moment, no mean
    gas_temperature
        Gas temperature, °C, or its column; by default that of the head's reference, or the
        recording's
    pressure
        Gas pressure, Pa; by default the recording's
    gas_uncertainty
        Standard uncertainty of the gas temperature, K: goes into those of the wind
    pressure_uncertainty
        Standard uncertainty of the gas pressure, Pa: goes into those of the wind
    heading
        Compass direction of the head's x axis, degrees clockwise from north, in place of
        `heading_deg`
    up
        What points up in the head's frame, in place of `up`: 0,0,1 of a head that stands upright,
        0,0,-1 of one that hangs
    winds
        True winds by label, a .csv or .parquet file as of `anemo calibrate`, for the errors
    from_
        Summary and histograms count estimates from this time on, s; the file has all
        By default 0.
    settle
        So much at the beginning of every label does not count, s
        By default 0.
    field_correction
        Find slow errors of single surfaces in this recording and correct the wind by them
        - "offsets"
        - "gains"
        - "both"
    write_head
        Write a head with these corrections, a .toml file
    output_file
        Write the estimates to this .parquet or .csv file
    plot
        Draw a picture into this .svg, .pdf or .png file
    plot_width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    plot_panel
        Draw only the panels whose captions begin so
    """
    return call(
        "wind",
        (recording,),
        {
            "--head": head,
            "--bandwidth": bandwidth,
            "--fixed": flag(fixed),
            "--every": every,
            "--gas-temperature": gas_temperature,
            "--pressure": pressure,
            "--gas-uncertainty": gas_uncertainty,
            "--pressure-uncertainty": pressure_uncertainty,
            "--heading": heading,
            "--up": up,
            "--winds": winds,
            "--from": from_,
            "--settle": settle,
            "--field-correction": field_correction,
            "--write-head": write_head,
            "--output-file": output_file,
            "--plot": plot,
            "--plot-width": plot_width,
            "--plot-panel": several(plot_panel),
        },
        Table,
    )


def combine(
    *instruments: Source,
    vane: Words = None,
    by: Paths = None,
    winds: Paths = None,
    from_: Number = None,
    settle: Number = None,
    output_file: Paths = None,
    plot: Paths = None,
    plot_width: Number = None,
    plot_panel: Words = None,
) -> Table:
    """Combine instruments that each see a part of the wind.

    Instruments are cards or boards round a boom, booms, cylinders or wires on different axes, a
    vane.

    The files are those of `anemo wind`, one an instrument; a single element knows the speed only.
    In known winds from everywhere, or all around a plane (a tunnel, simulated or with --winds), it
    learns how each instrument answers, its shadows included, and what is left by direction. With
    --by it estimates other winds from that: the vector that is likeliest for all of them. An
    instrument in the lee counts for less. Errors are cross-validated.

    Parameters
    ----------
    instruments
        Files of `anemo wind`, one an instrument, in the same order every time
    vane
        A recording and elements of it that sense the wake of a warm core: three or more that stand
        evenly round it, in their order. They know the direction only
    by
        Estimate winds by this combination, instead of making one
    winds
        Known winds by label, a .csv or .parquet file as of `anemo calibrate`; by default those of
        the first file
    from_
        Rows from this time on count, s
        By default 0.
    settle
        So much at the beginning of every label does not count, s
        By default 0.
    output_file
        Write the combination to this .json file, or with --by the winds to this .parquet or .csv
        file
    plot
        Draw a picture into this .svg, .pdf or .png file
    plot_width
        Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
        Type keeps its size
    plot_panel
        Draw only the panels whose captions begin so
    """
    return call(
        "combine",
        (*instruments,),
        {
            "--vane": several(vane),
            "--by": by,
            "--winds": winds,
            "--from": from_,
            "--settle": settle,
            "--output-file": output_file,
            "--plot": plot,
            "--plot-width": plot_width,
            "--plot-panel": several(plot_panel),
        },
        Table,
    )


def meteorology(
    recording: Source,
    *,
    interval: Number = None,
    from_: Number = None,
    heading: Number = None,
    up: Number = None,
    height: Number = None,
    bandwidth: Number = None,
    temperature_bandwidth: Number = None,
    gravity: Number = None,
    output_file: Paths = None,
) -> Report:
    """Average the wind of a recording: means, gusts, turbulence.

    The recording is a file of `anemo wind` or `anemo combine`, a run or a log of a calibrated head.
    Of every interval: scalar and vector mean, direction from which it blows, standard deviations of
    speed and direction, greatest mean of 3 s (WMO-No. 8). With --height friction velocity, heat
    flux and Obukhov length, where bandwidth and interval hold 90 % of the flux. Estimates with
    disqualifying flags do not count; an interval needs 75 % that do.

    Parameters
    ----------
    recording
        The recording: a file, a folder of segments, or a pattern in quotes
    interval
        Length of an interval, s: 600 and 120 are usual
        By default 600.
    from_
        The first interval begins there, s
        By default 0.
    heading
        Compass direction of the head's x axis, degrees clockwise from north, in place of
        `heading_deg`
    up
        What points up in the head's frame, in place of `up`: 0,0,1 of a head that stands upright,
        0,0,-1 of one that hangs
    height
        Height above the ground, m, for fluxes
    bandwidth
        Bandwidth of the wind, Hz; by default that which the recording states
    temperature_bandwidth
        Bandwidth of the gas temperature, Hz, for the heat flux. A reference element has 0.05 Hz
    gravity
        Gravity, m/s²: 3.71 on Mars
        By default 9.80665.
    output_file
        Write the averages to this .parquet or .csv file, a row an interval
    """
    return call(
        "meteorology",
        (recording,),
        {
            "--interval": interval,
            "--from": from_,
            "--heading": heading,
            "--up": up,
            "--height": height,
            "--bandwidth": bandwidth,
            "--temperature-bandwidth": temperature_bandwidth,
            "--gravity": gravity,
            "--output-file": output_file,
        },
        Report,
    )


__all__ = [
    "identify",
    "validate",
    "merge",
    "reduce",
    "export",
    "analyse",
    "design",
    "predict",
    "check",
    "simulate",
    "plot",
    "identify_head",
    "check_head",
    "compare_heads",
    "calibrate",
    "wind",
    "combine",
    "meteorology",
]
