"""The physics by which the emulated world judges what stands.

Parts are rigid cubes with magnets on their faces. ``collapse`` tells which of them do not stay
where they are; nothing of it is shared with the planner.
"""

from cellctl.sim.physics.collapse import Collapse, collapse
from cellctl.sim.physics.joints import Joint, Material

__all__ = ["Collapse", "Joint", "Material", "collapse"]
