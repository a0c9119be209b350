"""The JSON schema of what ``cellctl plan --json`` writes, from its model."""

from __future__ import annotations

import json

from cellctl.cli.plan_report import PlanReport


def plan_schema() -> str:
    """JSON schema of the report of a plan or of its refusal."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    schema |= PlanReport.model_json_schema(mode="serialization")
    return json.dumps(schema, indent=2) + "\n"
