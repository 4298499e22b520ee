"""Frozen dataclasses inside machine code: `value` teaches them to numba.

A value travels as a plain structure of its fields, whose annotations say of which types: float,
int, bool, an IntEnum, tuples of these, other values. Its methods and properties go along. Checks
in `__post_init__` are Python's: machine code makes values without them, and gives every field.
"""

from collections.abc import Callable
from dataclasses import fields
from enum import IntEnum
from functools import cache, wraps
from inspect import Parameter, Signature
from types import FunctionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from numba import types
from numba.core import cgutils
from numba.extending import (
    NativeValue,
    box,
    lower_builtin,
    make_attribute_wrapper,
    models,
    overload_attribute,
    overload_method,
    register_model,
    type_callable,
    typeof_impl,
    unbox,
)

from control.errors import ControlError

T = TypeVar("T")

_PLAIN: dict[Any, Any] = {float: types.float64, int: types.int64, bool: types.boolean}
_NATIVES: dict[type, type] = {}  # by dataclass; filled while modules are imported


def value(kind: type[T]) -> type[T]:
    """Let compiled functions take, make and give a frozen dataclass.

    Args:
        kind: the dataclass; a field of a type the module does not name is refused when machine
            code first meets it.

    Returns:
        The dataclass itself.
    """
    names = tuple(field.name for field in fields(kind))  # type: ignore[arg-type]
    native = _NATIVES[kind] = type(f"Native{kind.__name__}", (_Native,), {"kind": kind})
    typeof_impl.register(kind)(lambda *_: native())
    register_model(native)(_model)
    for name in names:
        make_attribute_wrapper(native, name, name)
    for name, member in vars(kind).items():
        if isinstance(member, FunctionType) and not name.startswith("_"):
            overload_method(native, name)(_giving(member))
        if isinstance(member, property) and isinstance(member.fget, FunctionType):
            overload_attribute(native, name)(_giving(member.fget))
    _teach_making(kind, native, names)
    unbox(native)(_take)
    box(native)(_give)
    return kind


class _Native(types.Type):
    """The compiler's type of a value."""

    kind: type

    def __init__(self) -> None:
        super().__init__(name=f"{self.kind.__module__}.{self.kind.__qualname__}")

    def __reduce__(self) -> tuple[Any, ...]:
        return _native, (self.kind,)

    @property
    def members(self) -> list[tuple[str, Any]]:
        """Names and the compiler's types of the fields."""
        return _members(self.kind)


def _native(kind: type) -> Any:
    return _NATIVES[kind]()


@cache
def _members(kind: type) -> list[tuple[str, Any]]:
    hints = get_type_hints(kind)
    return [(field.name, _type_of(hints[field.name])) for field in fields(kind)]


def _type_of(annotation: Any) -> Any:
    """The compiler's type for an annotation."""
    if annotation in _PLAIN:
        return _PLAIN[annotation]
    if annotation in _NATIVES:
        return _native(annotation)
    if get_origin(annotation) is tuple:
        return types.Tuple([_type_of(entry) for entry in get_args(annotation)])
    if isinstance(annotation, type) and issubclass(annotation, IntEnum):
        return types.IntEnumMember(annotation, types.int64)
    raise ControlError(f"no machine code for a field of type {annotation}")


def _model(manager: Any, native: _Native) -> Any:
    return models.StructModel(manager, native, native.members)


def _giving(method: FunctionType) -> Callable[..., FunctionType]:
    """What the compiler asks for the implementation of a method."""

    @wraps(method)
    def _implementation(*_: Any, **__: Any) -> FunctionType:
        return method

    return _implementation


def _teach_making(kind: type, native: type, names: tuple[str, ...]) -> None:
    """Calls of the class in machine code, by position or by name, every field given."""

    def _typed(_: Any) -> Any:
        def _typer(*__: Any, **___: Any) -> Any:
            return native()(*(member for _, member in _members(kind)))

        made = Signature([Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in names])
        _typer.__signature__ = _typer.pysig = made  # type: ignore[attr-defined]
        return _typer

    def _lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        made = cgutils.create_struct_proxy(sig.return_type)(context, builder)
        for name, argument in zip(names, args, strict=True):
            setattr(made, name, argument)
        return made._getvalue()

    type_callable(kind)(_typed)
    lower_builtin(kind, *(types.Any,) * len(names))(_lowered)


def _take(native: _Native, instance: Any, c: Any) -> Any:
    """From a Python object to machine code, field by field."""
    made = cgutils.create_struct_proxy(native)(c.context, c.builder)
    failed = cgutils.alloca_once_value(c.builder, cgutils.false_bit)
    for name, member in native.members:
        field = c.pyapi.object_getattr_string(instance, name)
        taken = c.unbox(member, field)
        c.pyapi.decref(field)
        setattr(made, name, taken.value)
        with c.builder.if_then(taken.is_error, likely=False):
            c.builder.store(cgutils.true_bit, failed)
    return NativeValue(made._getvalue(), is_error=c.builder.load(failed))


def _give(native: _Native, native_value: Any, c: Any) -> Any:
    """From machine code to a Python object, checks of `__post_init__` included."""
    made = cgutils.create_struct_proxy(native)(c.context, c.builder, value=native_value)
    entries = [c.box(member, getattr(made, name)) for name, member in native.members]
    kind = c.pyapi.unserialize(c.pyapi.serialize_object(native.kind))
    instance = c.pyapi.call_function_objargs(kind, entries)
    for entry in (*entries, kind):
        c.pyapi.decref(entry)
    return instance
