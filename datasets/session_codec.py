"""Dataclasses to plain JSON values and back, driven by their type hints; floats survive exactly."""

import json
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from math import isfinite
from types import NoneType, UnionType
from typing import Any, TypeAlias, Union, get_args, get_origin, get_type_hints

import numpy as np

Plain: TypeAlias = "bool | int | float | str | list[Plain] | dict[str, Plain] | None"


@dataclass(frozen=True, slots=True)
class Form:
    """How values of one type are written.

    Attributes:
        encode: value to plain JSON value.
        decode: plain JSON value to an equal value.
        schema: JSON schema of the plain value, for the viewers that open a session.
    """

    encode: Callable[[Any], Plain]
    decode: Callable[[Any], Any]
    schema: dict[str, Plain]


def _float_out(value: float) -> Plain:
    """JSON has no infinities: write them as strings that ``float`` reads."""
    number = float(value)
    return number if isfinite(number) else repr(number)


def _same(value: Any) -> Any:
    return value


_SCALARS: dict[object, Form] = {
    float: Form(_float_out, float, {"type": "number"}),
    int: Form(int, int, {"type": "integer"}),
    bool: Form(bool, bool, {"type": "boolean"}),
    str: Form(str, str, {"type": "string"}),
    NoneType: Form(_same, _same, {"type": "null"}),
}


@cache
def form(hint: Any) -> Form:
    """Find how values of a type are written.

    Args:
        hint: a scalar type, an optional, a union of scalars, a tuple, an array, or a dataclass.

    Returns:
        Encoder, decoder and schema.

    Raises:
        TypeError: if the type has no recorded form.
    """
    origin = get_origin(hint)
    if hint in _SCALARS:
        return _SCALARS[hint]
    if is_dataclass(hint):
        return _record(hint)
    if origin in (Union, UnionType):
        return _union(get_args(hint))
    if origin is tuple:
        return _sequence(get_args(hint))
    if origin is np.ndarray:
        return _array(get_args(get_args(hint)[1])[0])
    raise TypeError(f"no recorded form for {hint}")


def _record(kind: Any) -> Form:
    """Fields that an older file does not know yet are left to their defaults."""
    hints = get_type_hints(kind)
    parts = tuple((field.name, form(hints[field.name])) for field in fields(kind) if field.init)
    newer = {field.name for field in fields(kind) if field.default is not MISSING}

    def _encode(value: Any) -> Plain:
        return {name: part.encode(getattr(value, name)) for name, part in parts}

    def _decode(plain: Any) -> Any:
        known = [one for one in parts if one[0] in plain or one[0] not in newer]
        return kind(**{name: part.decode(plain[name]) for name, part in known})

    properties: dict[str, Plain] = {name: part.schema for name, part in parts}
    return Form(_encode, _decode, {"type": "object", "properties": properties})


def _union(options: tuple[Any, ...]) -> Form:
    """An optional of anything, or a union of scalars that JSON itself tells apart."""
    rest = [form(option) for option in options if option is not NoneType]
    if len(rest) > 1:
        return Form(_same, _same, {"oneOf": [option.schema for option in rest]})
    inner = rest[0]
    return Form(
        lambda value: None if value is None else inner.encode(value),
        lambda plain: None if plain is None else inner.decode(plain),
        inner.schema,
    )


def _sequence(items: tuple[Any, ...]) -> Form:
    """A tuple of any length of one type, or of fixed length with a type for each place."""
    if items[-1] is Ellipsis:
        item = form(items[0])
        return Form(
            lambda value: [item.encode(one) for one in value],
            lambda plain: tuple([item.decode(one) for one in plain]),
            {"type": "array", "items": item.schema},
        )
    parts = tuple(form(one) for one in items)
    return Form(
        lambda value: [part.encode(one) for part, one in zip(parts, value, strict=True)],
        lambda plain: tuple([part.decode(one) for part, one in zip(parts, plain, strict=True)]),
        {"type": "array", "items": {}},
    )


def _array(dtype: Any) -> Form:
    def _decode(plain: Any) -> Any:
        array = np.array(plain, dtype=dtype)
        array.flags.writeable = False
        return array

    def _encode(value: Any) -> Plain:
        plain: Plain = value.tolist()
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            plain = np.vectorize(_float_out, otypes=[object])(value).tolist()
        return plain

    return Form(_encode, _decode, {"type": "array", "items": {}})


def dumps(plain: Plain) -> bytes:
    """Write a plain value as compact JSON; every float reads back to the same bits.

    Args:
        plain: value made by an encoder.

    Returns:
        UTF-8 text.
    """
    # Robot ids given as numpy integers pass through unions unchanged: .item() makes them plain.
    text = json.dumps(plain, separators=(",", ":"), default=lambda number: number.item())
    return text.encode()
