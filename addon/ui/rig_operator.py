# SPDX-License-Identifier: GPL-3.0-or-later
"""What most operators on a rig have in common: why they are disabled, and how they fail."""

from __future__ import annotations

from bpy.types import Context, Object

from ..native import LibraryError, TugError
from ..rigging.inputs import RigError
from . import state

# What is told to the artist rather than to a programmer.
EXPECTED = (RigError, LibraryError, TugError)


class RigOperator:
    """Derive from it and from Operator; `needs` says what an object must have, and `act` returns
    what to tell the artist, if anything."""

    bl_options = {"REGISTER", "UNDO"}
    needs: tuple[state.Requirement, ...] = ()

    @classmethod
    def poll(cls, context: Context) -> bool:
        reason = state.missing(context, *cls.needs)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context: Context) -> set[str]:
        try:
            told = self.act(context, state.rig_of(context))
        except EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if told:
            self.report({"INFO"}, told)
        return {"FINISHED"}

    def act(self, context: Context, obj: Object) -> str | None:
        raise NotImplementedError
