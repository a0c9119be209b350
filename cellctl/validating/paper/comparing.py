"""The paper's tables beside what this project computes for the same objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import Final

from cellctl.config import CellConfig
from cellctl.validating.paper.claims import claim_table, request_table
from cellctl.validating.paper.performance import fdm_table, speed_table, time_table, volume_table
from cellctl.validating.paper.report import Report, Table
from cellctl.validating.paper.tables import (
    ablation_table,
    count_table,
    order_table,
    overhang_table,
    stack_table,
)
from cellctl.validating.paper.workbench import Workbench

PAPER: Final = "Kyaw et al., Speech to Reality, SCF '25, doi:10.1145/3745778.3766670"


class TableName(StrEnum):
    """The tables, in the order in which they are shown."""

    COUNT = "count"
    OVERHANG = "overhang"
    STACK = "stack"
    ABLATION = "ablation"
    ORDER = "order"
    VOLUME = "volume"
    TIME = "time"
    FDM = "fdm"
    SPEED = "speed"
    REQUESTS = "requests"
    CLAIMS = "claims"


TABLES: Final[Mapping[TableName, Callable[[Workbench], Table]]] = {
    TableName.COUNT: count_table,
    TableName.OVERHANG: overhang_table,
    TableName.STACK: stack_table,
    TableName.ABLATION: ablation_table,
    TableName.ORDER: order_table,
    TableName.VOLUME: volume_table,
    TableName.TIME: time_table,
    TableName.FDM: fdm_table,
    TableName.SPEED: speed_table,
    TableName.REQUESTS: request_table,
    TableName.CLAIMS: claim_table,
}
"""Name -> what makes it."""


def compare(
    config: CellConfig,
    phrase_of: Callable[[str], str],
    names: tuple[TableName, ...] = tuple(TableName),
) -> Report:
    """Compute what the paper prints, by its algorithms and its limits.

    Args:
        config: the cell whose routes, latch and robot are compared.
        phrase_of: what this project makes of a sentence: the phrase that names the object.
        names: which tables.
    """
    bench = Workbench(config, phrase_of)
    tables = tuple(TABLES[name](bench) for name in names)
    return Report(paper=PAPER, cell=config.cell.name, tables=tables)
