"""The pages of docs/reference that describe the bus, from the models of its messages."""

from __future__ import annotations

import inspect
import json
from typing import Any

from pydantic import BaseModel, TypeAdapter

from cellctl import messages
from cellctl.assembly import Value
from cellctl.messages import (
    OPERATOR_COMMANDS,
    SCHEMA_VERSION,
    TOPICS,
    ControlReply,
    ControlRequest,
    StatusMessage,
)


def _schema(title: str, model: type[BaseModel]) -> str:
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title}
    schema |= TypeAdapter(model).json_schema(mode="serialization")
    return json.dumps(schema, indent=2) + "\n"


def status_schema() -> str:
    """JSON schema of status messages: the envelope, and what ``data`` is for each topic."""
    envelope = StatusMessage.model_json_schema(mode="serialization")
    topics: dict[str, Any] = {}
    definitions: dict[str, Any] = {}
    for topic, model in TOPICS.items():
        schema = model.model_json_schema(mode="serialization", ref_template="#/$defs/{model}")
        definitions |= schema.pop("$defs", {})
        definitions[model.__name__] = schema
        topics[topic] = {
            "if": {"properties": {"topic": {"const": topic}}},
            "then": {"properties": {"data": {"$ref": f"#/$defs/{model.__name__}"}}},
        }
    whole = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **envelope,
        "allOf": list(topics.values()),
        "$defs": definitions,
    }
    return json.dumps(whole, indent=2) + "\n"


def request_schema() -> str:
    """JSON schema of requests."""
    return _schema("ControlRequest", ControlRequest)


def reply_schema() -> str:
    """JSON schema of replies."""
    return _schema("ControlReply", ControlReply)


def _about(model: type[BaseModel]) -> str:
    """The first line of a topic's docstring, without the topic's name."""
    line = (inspect.getdoc(model) or "").partition("\n")[0]
    text = line.partition(": ")[2]
    return (text[0].upper() + text[1:]).replace("``", "`")


def bus_page(note: str) -> str:
    """Topics, commands and their roles."""
    topics = "\n".join(
        f"| `{topic}` | {_about(model)} | {', '.join(f'`{name}`' for name in model.model_fields)} |"
        for topic, model in TOPICS.items()
    )
    commands = []
    for model in vars(messages).values():
        if not (isinstance(model, type) and issubclass(model, Value)):
            continue
        field = model.model_fields.get("command")
        if field is None or not model.__name__.endswith("Command"):
            continue
        names = getattr(field.annotation, "__args__", ())
        arguments = [f"`{name}`" for name in model.model_fields if name != "command"]
        for name in names:
            who = "operator" if name in OPERATOR_COMMANDS else "visitor, operator"
            commands.append(f"| `{name}` | {', '.join(arguments) or 'none'} | {who} |")
    return "\n".join(
        [
            note,
            "# The bus\n",
            f"Schema version {SCHEMA_VERSION}. The end points are `bus.status`, `bus.visitor` and "
            "`bus.operator` of the configuration.\n",
            "## Status\n",
            "A PUB socket. Each message has two frames: the topic, and a JSON document "
            "([schema](bus-status.schema.json)) with `seq`, `time`, `cell_time_s`, `state`, "
            "`topic` and `data`. `seq` counts all messages: a gap means that some were lost, and "
            "`snapshot` gives the whole picture to go on from.\n",
            "| topic | what | data |\n| --- | --- | --- |\n" + topics + "\n",
            "## The two doors\n",
            "Two ROUTER sockets, the visitor's and the operator's; what may be asked follows from "
            "the door. Connect a DEALER or a REQ and send one "
            "JSON frame ([schema](bus-request.schema.json)), followed by the bytes of the file "
            "for `hear` and `build`. Every request gets one reply "
            "([schema](bus-reply.schema.json)) with its `id`, and either a result or a typed "
            "error: `invalid` (no valid request), `refused` (not now, or not at this door), "
            "`busy` (too many are under way: ask again), "
            "`usage` (its contents make no sense), `internal`. The reply to `file` is followed by "
            "the bytes of that file; a visitor gets those of the job under way, or of the last "
            "one.\n",
            "| command | arguments | doors |\n| --- | --- | --- |\n" + "\n".join(commands) + "\n",
        ]
    )
