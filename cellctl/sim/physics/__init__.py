"""The physics by which the emulated world judges what stands.

Parts are rigid cubes with magnets on their faces. ``collapse`` tells which of them do not stay
where they are, ``parting`` which come along with one that is taken; nothing of it is shared with
the planner.
"""

from cellctl.sim.physics.collapse import Collapse, collapse
from cellctl.sim.physics.joints import Joint, Material
from cellctl.sim.physics.parting import Parting, parting

__all__ = ["Collapse", "Joint", "Material", "Parting", "collapse", "parting"]
