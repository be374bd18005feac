"""Descriptions of logs as TOML files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from stickslip.errors import UsageError
from stickslip.fmi.files import MOST_TEXT, parse_toml, read_limited
from stickslip.fmi.messages import suggestion
from stickslip.logs.description import Column, Description

_KEYS = tuple(field.name for field in fields(Description) if field.name != "gains")
_COLUMN_KEYS = ("name", "index", "unit", "scale", "offset")


def load_description(path: Path) -> Description:
    """Read a description.

    The file holds the fields of ``Description`` by name; ``[columns.ROLE]`` the fields of
    ``Column``, or in short ``columns.ROLE = "NAME"``, with ``index`` for a number from 1;
    ``[controller]`` ``kind`` and the gains.

    Raises
    ------
    UsageError
        When it cannot be read, or a key or value is none that is known.
    """
    try:
        content = parse_toml(read_limited(path, MOST_TEXT))
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError as error:  # not UTF-8, or not TOML
        raise UsageError(f"{path}: not TOML ({' '.join(str(error).split())})") from None
    try:
        return _description(content)
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None


def _description(content: Mapping[str, Any]) -> Description:
    for key in content:
        if key not in _KEYS:
            raise UsageError(f"no key '{key}'{suggestion(key, _KEYS)}")
    given: dict[str, Any] = {}
    for key, value in content.items():
        if key == "columns":
            given[key] = {role: _column(role, one) for role, one in _table(value, key).items()}
        elif key == "controller":
            gains = dict(_table(value, key))
            given["controller"] = _text(gains.pop("kind", None), "controller.kind")
            given["gains"] = {k: _product(v, f"controller.{k}") for k, v in gains.items()}
        elif key in ("motion", "delimiter", "decimal"):
            given[key] = _text(value, key)
        elif key == "confirm":
            given[key] = _texts(value, key)
        elif key == "span":
            given[key] = _span(value)
        elif key in ("encoder_step", "force_limit"):
            given[key] = _product(value, key)
        else:
            given[key] = _number(value, key)
    return Description(**given)


def _column(role: str, value: object) -> Column:
    if isinstance(value, str | int) and not isinstance(value, bool):
        return Column(value)
    table = _table(value, f"columns.{role}")
    for key in table:
        if key not in _COLUMN_KEYS:
            raise UsageError(f"columns.{role}: no key '{key}'{suggestion(key, _COLUMN_KEYS)}")
    if "name" in table and "index" in table:
        raise UsageError(f"columns.{role}: expected name or index, got both")
    index = table.get("index")
    if index is not None and (not isinstance(index, int) or isinstance(index, bool) or index < 1):
        raise UsageError(f"columns.{role}.index = {index!r}: expected a number from 1")
    return Column(
        index if index is not None else _optional_text(table, "name", role),
        _optional_text(table, "unit", role),
        _product(table["scale"], f"columns.{role}.scale") if "scale" in table else None,
        _product(table.get("offset", 0.0), f"columns.{role}.offset"),
    )


def _optional_text(table: Mapping[str, Any], key: str, role: str) -> str | None:
    return _text(table[key], f"columns.{role}.{key}") if key in table else None


def _table(value: object, what: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise UsageError(f"{what} = {value!r}: expected a table")
    return value


def _text(value: object, what: str) -> str:
    if not isinstance(value, str):
        raise UsageError(f"{what} = {value!r}: expected a text")
    return value


def _texts(value: object, what: str) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise UsageError(f"{what} = {value!r}: expected a list of texts")
    return tuple(_text(text, what) for text in value)


def _number(value: object, what: str) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise UsageError(f"{what} = {value!r}: expected a number")
    return float(value)


def _product(value: object, what: str) -> float | str:
    return value if isinstance(value, str) else _number(value, what)


def _span(value: object) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise UsageError(f"span = {value!r}: expected [begin, end] in s")
    return _number(value[0], "span"), _number(value[1], "span")
