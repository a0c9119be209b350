"""What is wrong and does not stop the cell: told as long as it lasts, and never a fault."""

from __future__ import annotations

from cellctl.assembly import Value


class Notice(Value):
    """Something is wrong that does not stop the cell; it goes when its cause does."""

    code: str
    title: str
    causes: tuple[str, ...]
    remedy: str


NOTICES: dict[str, Notice] = {
    notice.code: notice
    for notice in (
        Notice(
            code="microphone_lost",
            title="The cell does not hear, so nobody can stop it by voice.",
            causes=(
                "The microphone is unplugged, switched off, or gives only silence.",
                "Another sound source took its place.",
                "The sound server has ended or is suspended.",
                "The computer is too busy to listen.",
            ),
            remedy="Plug the microphone in and look at `cellctl microphone`; the cell tries again.",
        ),
        Notice(
            code="loudspeaker_lost",
            title="The cell does not speak; what it says stands on the screen.",
            causes=(
                "The loudspeaker is unplugged, switched off, or muted in the sound settings.",
                "Another one took its place.",
                "The sound server has ended or is suspended.",
                "There is no voice for the language.",
            ),
            remedy="Plug the loudspeaker in and try `cellctl voice test`; the cell tries again.",
        ),
        Notice(
            code="gripper_board_lost",
            title="The gripper's board does not answer on its serial port; its lines work on.",
            causes=("Its USB cable is out.", "Its board has no power."),
            remedy="Check the cable and gripper.port; the cell tries again.",
        ),
        Notice(
            code="gripper_board_mismatch",
            title="Another board answers on the gripper's serial port; its lines work on.",
            causes=("Two serial ports are swapped.", "The board's firmware is of another version."),
            remedy="Correct gripper.port or install the matching firmware; the cell tries again.",
        ),
        Notice(
            code="gripper_uncalibrated",
            title="The gripper runs with its default calibration: its own is damaged or missing.",
            causes=("It is a new board.", "Its EEPROM was damaged when its supply failed."),
            remedy="Set it with `cellctl gripper set`, and `cellctl gripper keep` it.",
        ),
    )
}
"""What is told while the cell goes on, by code."""
