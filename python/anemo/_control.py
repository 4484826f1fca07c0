"""Models as objects of python-control."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from ._error import Error

if TYPE_CHECKING:
    import control

    from ._anemo import Model


def to_control(model: Model, class_: str | None = None, dt: float | None = None) -> control.StateSpace:
    """The model as python-control's StateSpace, in discrete time.

    It is exact for inputs that are held between samples (zero-order hold): every relaxation is a
    state with e^(-rate dt), a dead time a chain of states. Inputs are in W, outputs in K above the
    offsets. `dt` is the record's sample period (s) unless given.
    """
    try:
        import control
    except ImportError:
        raise Error("python-control is missing: pip install control", 1) from None
    a, b, c, d, dt, warning = model._state_space(class_, dt)
    if warning:
        warnings.warn(warning, stacklevel=2)
    return control.ss(a, b, c, d, dt, inputs=model.inputs, outputs=model.outputs)
