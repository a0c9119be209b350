"""The dashboard on port 29999: one line in, one line out.

Source of commands and replies: Universal Robots, "Dashboard Server e-Series" and "CB-Series".
"""

from __future__ import annotations

import re
import socket
from collections.abc import Callable
from typing import Protocol

from cellctl.sim.ur.net import Connection, Server
from cellctl.sim.ur.options import UrOptions

PORT = 29999
_BANNER = "Connected: Universal Robots Dashboard Server"
_GOODBYE = "Disconnected"
_LINE_LIMIT = 4096


class Pendant(Protocol):
    """What the dashboard asks of the controller, as somebody at the teach pendant would."""

    options: UrOptions

    @property
    def remote(self) -> bool:
        """Whether commands from the network are obeyed."""
        ...

    @property
    def program_state(self) -> str:
        """STOPPED, PLAYING or PAUSED."""
        ...

    @property
    def program_name(self) -> str:
        """Name of the program that was started last; empty before the first."""
        ...

    def robot_mode_name(self) -> str:
        """As the dashboard spells it."""
        ...

    def safety_name(self) -> str:
        """As the dashboard spells it."""
        ...

    def play(self) -> bool:
        """Go on with a paused program; False if there is none or the arm may not move."""
        ...

    def pause(self) -> bool:
        """Pause the running program; False if none runs."""
        ...

    def stop_program(self) -> bool:
        """Stop the program; False if none was running or paused."""
        ...

    def power_on(self) -> bool:
        """Power the arm; False if an emergency stop is pressed."""
        ...

    def power_off(self) -> None:
        """Take the power off the arm."""
        ...

    def release_brakes(self) -> bool:
        """Release the brakes; False if an emergency stop is pressed."""
        ...

    def unlock(self) -> bool:
        """Unlock a protective stop; False if it is too early."""
        ...

    def close_popup(self) -> None:
        """Close the safety popup."""
        ...


def answer(pendant: Pendant, line: str) -> str:
    """Do what a line asks for and return the reply."""
    command = " ".join(line.lower().split())
    if reader := _READERS.get(command):
        return reader(pendant)
    if action := _ACTIONS.get(command):
        return action(pendant) if pendant.remote else f"Failed to execute: {command}"
    for start, reply in _ACCEPTED.items():
        if command.startswith(start):
            return reply
    return f"could not understand: '{line.strip()}'"


def _stop(pendant: Pendant) -> str:
    if pendant.stop_program() or pendant.options.stop_reply == "stopped":
        return "Stopped"
    return "Failed to execute: stop"


def _unlock(pendant: Pendant) -> str:
    if pendant.unlock():
        return "Protective stop releasing"
    return (
        "Cannot unlock protective stop until 5s after occurrence. "
        "Always inspect cause of protective stop before unlocking"
    )


def _power_off(pendant: Pendant) -> str:
    pendant.power_off()
    return "Powering off"


def _close_popup(pendant: Pendant) -> str:
    pendant.close_popup()
    return "closing safety popup"


def _either(done: bool, reply: str, command: str) -> str:
    return reply if done else f"Failed to execute: {command}"


def _version(pendant: Pendant) -> str:
    number = ".".join(str(part) for part in pendant.options.version)
    return f"URSoftware {number} (emulated)"


_ACCEPTED = {
    "addtolog": "Added log message",
    "popup": "showing popup",
    "set user role": "Setting user role",
    "load": "File not found",
    "quit": _GOODBYE,
}
"""Commands with an argument, or without one to carry out; there are no stored programs to load."""

_READERS: dict[str, Callable[[Pendant], str]] = {
    "polyscopeversion": _version,
    "version": lambda pendant: ".".join(str(part) for part in pendant.options.version[:3]),
    "get serial number": lambda pendant: pendant.options.serial_number,
    "get robot model": lambda _pendant: "UR10",
    "is in remote control": lambda pendant: str(pendant.remote).lower(),
    "running": lambda pendant: (
        f"Program running: {str(pendant.program_state == 'PLAYING').lower()}"
    ),
    "robotmode": lambda pendant: f"Robotmode: {pendant.robot_mode_name()}",
    "safetymode": lambda pendant: f"Safetymode: {pendant.safety_name()}",
    "safetystatus": lambda pendant: f"Safetystatus: {pendant.safety_name()}",
    "programstate": lambda pendant: f"{pendant.program_state} {pendant.program_name}".strip(),
    "get loaded program": lambda _pendant: "No program loaded",
    "isprogramsaved": lambda _pendant: "true ",
    "close popup": lambda _pendant: "closing popup",
}

_ACTIONS: dict[str, Callable[[Pendant], str]] = {
    "play": lambda pendant: _either(pendant.play(), "Starting program", "play"),
    "pause": lambda pendant: _either(pendant.pause(), "Pausing program", "pause"),
    "stop": _stop,
    "power on": lambda pendant: _either(pendant.power_on(), "Powering on", "power on"),
    "power off": _power_off,
    "brake release": lambda pendant: _either(
        pendant.release_brakes(), "Brake releasing", "brake release"
    ),
    "unlock protective stop": _unlock,
    "close safety popup": _close_popup,
    "restart safety": lambda _pendant: "Restarting safety",
}


class DashboardConnection(Connection):
    """One dashboard client."""

    def __init__(self, sock: socket.socket, server: Server, pendant: Pendant) -> None:
        super().__init__(sock, server)
        self._pendant = pendant
        self._buffer = b""

    def opened(self) -> None:
        self.send(f"{_BANNER}\n".encode())

    def received(self, data: bytes) -> None:
        self._buffer += data
        *lines, self._buffer = re.split(rb"\r?\n", self._buffer)
        for line in lines:
            reply = answer(self._pendant, line.decode("utf-8", "replace"))
            self.send(f"{reply}\n".encode())
            if reply == _GOODBYE:
                self.close()
                return
        if len(self._buffer) > _LINE_LIMIT:
            self.close()


def dashboard_server(host: str, pendant: Pendant) -> Server:
    """The service on port 29999."""
    return Server(host, PORT, lambda sock, server: DashboardConnection(sock, server, pendant))
