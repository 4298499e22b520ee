"""Protobuf messages of other programs, built at run time: no generated code, nothing to compile."""

from collections.abc import Mapping
from typing import Any

_SCALARS = ("bool", "uint32", "float", "double")

Messages = Mapping[str, tuple[str, ...]]


def message_class(package: str, syntax: str, messages: Messages, name: str) -> Any:
    """Build a message's class from lines as a .proto file has them.

    Args:
        package: of the messages, may be empty.
        syntax: "proto2" or "proto3".
        messages: fields by message, each "label type name = number".
        name: of the message wanted.

    Returns:
        Its class, as protobuf's own tools make it.
    """
    # Only who talks to such programs pays for the import.
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

    kinds = descriptor_pb2.FieldDescriptorProto.Type
    labels = descriptor_pb2.FieldDescriptorProto.Label
    file = descriptor_pb2.FileDescriptorProto(
        name=f"{package or name}.proto", package=package, syntax=syntax
    )
    prefix = f".{package}." if package else "."
    for title, fields in messages.items():
        message = file.message_type.add(name=title)
        for field in fields:
            label, kind, called, _, number = field.split()
            made = message.field.add(name=called, number=int(number))
            made.label = labels.Value(f"LABEL_{label.upper()}")
            if kind in _SCALARS:
                made.type = kinds.Value(f"TYPE_{kind.upper()}")
            else:
                made.type, made.type_name = kinds.Value("TYPE_MESSAGE"), prefix + kind
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName((prefix + name)[1:]))
