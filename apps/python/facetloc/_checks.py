# SPDX-License-Identifier: BSD-3-Clause
"""Arguments, with errors that name them."""
from __future__ import annotations

import math
import operator
import os
from typing import Any, NoReturn, Optional

import numpy as np


def refuse(value: Any, name: str, wanted: str) -> NoReturn:
    raise TypeError(f"{name} is of the type {type(value).__name__}, not {wanted}") from None


def checked(value: Any, name: str, kind: type) -> Any:
    """The value. Raises TypeError unless it is of this kind."""
    if not isinstance(value, kind):
        refuse(value, name, kind.__name__)
    return value


def path(value: Any, name: str) -> str:
    """Raises TypeError unless it is a string or an os.PathLike."""
    try:
        return os.fspath(value)
    except TypeError:
        refuse(value, name, "a path")


def image(value: Any, name: str) -> np.ndarray:
    """As an array; its type and shape are checked with its camera. Raises TypeError for other objects."""
    try:
        array = np.asanyarray(value)
    except ValueError:  # rows of several lengths
        refuse(value, name, "an array (height, width)")
    if array.dtype == object:
        refuse(value, name, "an array (height, width)")
    return array


def numbers(value: Any, name: str) -> Optional[np.ndarray]:
    """As an array of real numbers; None stays None."""
    try:
        return None if value is None else np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        refuse(value, name, "an array of numbers")


def whole(value: Any, name: str, least: int = 0) -> int:
    """Raises TypeError unless it is a whole number, ValueError below the least one."""
    try:
        number = operator.index(value)
    except TypeError:
        refuse(value, name, "a whole number")
    if number < least:
        raise ValueError(f"{name} = {number} is impossible: at least {least}")
    return number


def real(value: Any, name: str, least: float = -math.inf, most: float = math.inf) -> float:
    """Raises TypeError unless it is a number, ValueError unless it is finite and within the bounds."""
    try:
        number = float(None if isinstance(value, str) else value)
    except TypeError:
        refuse(value, name, "a number")
    if not (math.isfinite(number) and least <= number <= most):
        bounds = f": it must lie in [{least:g}, {most:g}]" if math.isfinite(least) or math.isfinite(most) else ""
        raise ValueError(f"{name} = {number:g} is impossible{bounds}")
    return number
