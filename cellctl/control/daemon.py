"""The daemon: puts the cell together, runs it until a signal, and takes it apart again."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from pathlib import Path

import structlog

from cellctl import __version__
from cellctl.assembling.arm import Arm
from cellctl.assembling.arm_process import RemoteArm
from cellctl.assembling.gripper_board import GripperBoard
from cellctl.assembling.latch_gripper import LatchGripper
from cellctl.boards.constants import ResetCause
from cellctl.clock import Clock, SystemClock
from cellctl.config import CellConfig
from cellctl.control.about import Present, carrying
from cellctl.control.archive import Archive
from cellctl.control.books import Books
from cellctl.control.bus import Bus
from cellctl.control.cell import Cell
from cellctl.control.commands import Commands
from cellctl.control.designing import warm_up
from cellctl.control.devices import Devices
from cellctl.control.dialogue.board import DialogueBoard
from cellctl.control.dialogue.conversation import Conversation
from cellctl.control.dialogue.reading import Phrasebook
from cellctl.control.dialogue.transcript import Transcript
from cellctl.control.dialogue.turns import Turns
from cellctl.control.dismantling import Dismantler
from cellctl.control.ears import LiveEars
from cellctl.control.gripper_reset import settle_reset
from cellctl.control.gripper_watch import GripperWatch
from cellctl.control.health import LoopMonitor
from cellctl.control.journal_store import SqliteJournal
from cellctl.control.monitor import ArmMonitor, arm_view
from cellctl.control.moving import ArmAndLatch
from cellctl.control.notify import Condition, ServiceManager, ServiceReport
from cellctl.control.recollection import Recollection
from cellctl.control.requests import RequestDesk
from cellctl.control.voice import LiveVoice
from cellctl.errors import CellFault, HearingError
from cellctl.feeding.conveyor import Conveyor
from cellctl.feeding.inventory import Counts
from cellctl.feeding.service import BeltService
from cellctl.listening.hearing import Hearing
from cellctl.messages import FaultData, GripperData, LogData, Snapshot, StatusData
from cellctl.speaking.events import Began, Ended
from cellctl.wording import load_wording
from cellctl.worker import WorkerError, WorkerProcess

log = structlog.get_logger(__name__)

_CLOSE_PATIENCE_S = 10.0
_WARM_UP_TIMEOUT_S = 60.0
_DAY_S = 86_400.0


class Daemon:
    """One cell, put together from its configuration.

    Args:
        config: the cell.
    """

    def __init__(self, config: CellConfig) -> None:
        self.config = config
        wording = load_wording(config.dialogue.language, config.dialogue.messages_folder)
        self.clock: Clock = SystemClock(config.cell.clock_rate)
        self.bus = Bus(config.bus, self.clock, config.hearing.max_audio_s)
        self.loop_monitor = LoopMonitor()
        self.arm: Arm = RemoteArm(config, Path(config.journal.path).with_suffix(".speed"))
        self.hearing = Hearing(config.hearing)
        self.designer = WorkerProcess("planner")
        self.journal = SqliteJournal(
            Path(config.journal.path),
            self.clock,
            Counts.at_first(config.limits.inventory_parts, config.feeder.capacity_parts),
            config_sha256=config.sha256,
        )
        gripper_board = GripperWatch(
            partial(GripperBoard, config.gripper) if config.gripper.port is not None else None,
            lambda: self._publish(self._gripper_view()),
            self._gripper_was_reset,
        )
        latch = LatchGripper(self.arm, config, gripper_board.board)
        hands = ArmAndLatch(config, self.clock, self.arm, latch)
        belt = BeltService(
            Conveyor(config.feeder, config.voxel.pitch_m, self.clock),
            config.feeder.retries,
            lambda: self.journal.ledger.counts.belt,
            self._publish,
            reconnect_timeout_s=config.feeder.reconnect_timeout_s,
        )
        self.devices = Devices(self.arm, hands, belt, gripper_board, self.hearing, self.designer)
        self.builder = Dismantler(config, self.clock, hands=hands, belt=belt, journal=self.journal)
        self.cell = Cell(
            config,
            self.clock,
            devices=self.devices,
            builder=self.builder,
            journal=self.journal,
            publish=self._show,
            wording=wording,
        )
        self.service = ServiceReport(
            ServiceManager.from_environment(), self.cell.controller.probe, self._condition
        )
        self.voice = LiveVoice(config, wording, self._publish)
        self.ears = LiveEars(
            config.hearing,
            self.hearing,
            self._state,
            self._publish,
            voice=self.voice,
            asks=lambda: self.conversation.asks,
            changes=lambda text: self.conversation.is_change(text),  # noqa: PLW0108 - made below
            sayings=Phrasebook(wording).sayings,
            say=lambda text: self.conversation.tell(text),  # noqa: PLW0108 - made below
            translated=wording.translated,
        )
        self.turns = Turns(config, self.clock)
        self.dialogue = DialogueBoard(
            self.cell,
            self.clock,
            ears=lambda: self.ears.data.state,
            queue=lambda: self.turns.entries,
            speaker=self.voice,
            publish=lambda data: self.bus.publish(data, self._state()),
        )
        self.voice.heeded_by.append(self._question_voiced)
        commands = Commands(self.cell, Books(self.cell))
        self.conversation = Conversation(
            self.cell,
            self.dialogue,
            commands=commands,
            turns=self.turns,
            clock=self.clock,
            transcript=Transcript(
                config.dialogue.transcripts,
                Path(config.journal.path).with_name("transcripts"),
                self.clock,
            ),
        )
        self.recollection = Recollection(self.clock)
        self.desk = RequestDesk(
            self.cell,
            self.hearing,
            publish=self._show,
            snapshot=self.snapshot,
            ears=self.ears,
            conversation=self.conversation,
            commands=commands,
            archive=Archive(config, lambda: self.cell.job, self.present, self.recollection),
        )

    def present(self) -> Present:
        """What is known of the cell, for those who ask what it consists of."""
        ledger = self.builder.ledger
        return Present(
            identity=self.arm.identity,
            check=self.arm.checked,
            robot_connected=self.arm.state() is not None,
            conveyor=self.devices.belt.view(),
            gripper=self._gripper_view(),
            ears=self.ears.data,
            recogniser=self.cell.wishes.recogniser,
            counts=ledger.counts,
            standing=len(ledger.standing),
            uptime_s=self.loop_monitor.health(0).uptime_s,
        )

    def snapshot(self) -> Snapshot:
        """The whole picture for one who joins late."""
        cell, job = self.cell, self.cell.job
        latched, doubt, shown = cell.controller.latched, self.builder.doubt, cell.sentences.shown
        return Snapshot(
            seq=self.bus.seq,
            version=__version__,
            cell=self.config.cell.name,
            kind=self.config.cell.kind,
            grid=self.config.grid,
            state=cell.last_state.model_copy(update={"state": cell.controller.state}),
            job=shown(job.view()) if job is not None else None,
            plan=job.plan if job is not None else None,
            parts=tuple(job.outcomes) if job is not None else (),
            standing=tuple(sorted(self.builder.standing)),
            inventory=self.builder.ledger.counts.model_dump(),
            doubt=cell.sentences.wording.translated(doubt.sentence) if doubt is not None else "",
            arm=arm_view(self.arm.state()),
            conveyor=self.devices.belt.view(),
            gripper=self._gripper_view(),
            fault=shown(latched.view()) if latched is not None else FaultData(),
            health=self.loop_monitor.health(cell.controller.inbox_size),
            recogniser=cell.wishes.recogniser,
            carrying=carrying(self.config),
            carrying_measured=self.config.robot.carrying_measured,
            ears=self.ears.data,
            voice=self.voice.data,
            dialogue=self.dialogue.data,
        )

    def _state(self) -> str:
        return self.cell.controller.state

    def _question_voiced(self, event: Began | Ended, text: str) -> None:
        """A question's words have begun, or are left to the screen. What ends as it should was said
        of an earlier question of the same words."""
        if isinstance(event, Began) or not event.complete:
            self.dialogue.questions.voiced(text, event.at_s)

    async def _gripper_was_reset(self, cause: ResetCause | None) -> None:
        await settle_reset(
            cause,
            hands=self.devices.hands,
            builder=self.builder,
            controller=self.cell.controller,
            job=self.cell.active_job,
        )

    def _gripper_view(self) -> GripperData:
        return self.devices.gripper_board.view(self.builder.grip.value)

    def _condition(self) -> Condition:
        state = self._state()
        sentence = self.cell.last_state.sentence or f"The cell is {state.replace('_', ', ')}."
        return Condition(up=state != "starting", sentence=sentence)

    def _publish(self, data: StatusData) -> None:
        self._show(data, self._state())

    def _show(self, data: StatusData, state: str) -> None:
        self.bus.publish(self.cell.sentences.shown(data), state)
        self.conversation.note(data)

    def publish_log(self, level: str, message: str) -> None:
        """Put a warning or an error of the log on the bus."""
        data = LogData(level="error" if level == "error" else "warning", message=message)
        self.recollection.logged(data)
        self._publish(data)

    async def _heartbeat(self) -> None:
        while True:
            self._publish(self.loop_monitor.health(self.cell.controller.inbox_size))
            await asyncio.sleep(self.config.bus.heartbeat_s)

    async def _warm_up(self) -> None:
        """Load what listens as soon as the devices are found, and the planner when a wish may come:
        a cell that was cut off in a build has other work to do."""
        await self.cell.left_starting.wait()
        if self.config.hearing.microphone == "none":
            await self.cell.been_idle.wait()
        try:
            self.cell.wishes.recogniser = await self.hearing.warm_up()
        except HearingError as error:
            self.cell.wishes.recogniser = "none"
            log.warning("no speech recognition; typed requests work", reason=str(error))
        await self.cell.been_idle.wait()
        try:
            await self.designer.call(warm_up, timeout_s=_WARM_UP_TIMEOUT_S)
        except WorkerError as error:
            log.warning("the planner cannot be loaded", reason=str(error))

    async def _prune(self) -> None:
        """Let the journal forget what is old, once there is nothing else to do, and every day."""
        await self.cell.been_idle.wait()
        journal = self.config.journal
        while True:
            try:
                await self.journal.prune(journal.keep_days, journal.keep_jobs)
            except CellFault as fault:
                log.warning("journal cannot be pruned", reason=str(fault))
            await asyncio.sleep(_DAY_S)

    async def run(self) -> None:
        """Run until SIGTERM or SIGINT, then let go of everything.

        Raises:
            ConfigError: the bus's end points are taken.
        """
        stop = asyncio.Event()
        loop = asyncio.get_running_loop()
        for number in (signal.SIGTERM, signal.SIGINT):
            loop.add_signal_handler(number, stop.set)
        log.info("cellctl starts", version=__version__, cell=self.config.cell.name)
        try:
            async with self.running() as failed:
                failed.add_done_callback(lambda _: stop.set())
                await stop.wait()
                self.service.stopping()
                if failed.done():
                    failed.result()
        finally:
            for number in (signal.SIGTERM, signal.SIGINT):
                loop.remove_signal_handler(number)
        log.info("cellctl ended")

    @asynccontextmanager
    async def running(self) -> AsyncIterator[asyncio.Future[None]]:
        """Run the cell for as long as the context lasts.

        Yields:
            A future that fails with whatever ends one of the daemon's own tasks: without any of
            them the cell would look alive and not be.
        """
        failed: asyncio.Future[None] = asyncio.get_running_loop().create_future()

        def watch(task: asyncio.Task[None]) -> None:
            error = None if task.cancelled() else task.exception()
            if error is not None and not failed.done():
                log.error("task failed", task=task.get_name(), reason=repr(error))
                failed.set_exception(error)

        self.bus.open()
        try:
            await self.journal.start()
        except CellFault as fault:
            # The cell comes up in this fault, where people see it, and tries again after a reset.
            log.error("journal cannot be opened", reason=str(fault))  # noqa: TRY400
        except BaseException:
            self.bus.close()
            raise
        monitor = ArmMonitor(self.arm, self.clock, self.cell.controller, self._publish)
        async with AsyncExitStack() as stack:
            stack.callback(self.bus.close)
            stack.push_async_callback(self._close_devices)
            for name, work in (
                ("controller", self.cell.controller.run()),
                (
                    "doors",
                    self.bus.serve(self.desk.handle, lambda: self.cell.controller.state),
                ),
                ("heartbeat", self._heartbeat()),
                ("loop monitor", self.loop_monitor.run()),
                ("arm monitor", monitor.run()),
                ("belt watch", self.devices.belt.watch(lambda: self.cell.started)),
                ("gripper watch", self.devices.gripper_board.run()),
                ("live ears", self.ears.run(self.conversation.hear)),
                ("conversation", self.conversation.run()),
                ("voice", self.voice.run()),
                ("warm-up", self._warm_up()),
                ("pruning", self._prune()),
                ("service manager", self.service.run()),
            ):
                task = asyncio.create_task(work, name=name)
                task.add_done_callback(watch)
                stack.push_async_callback(_end, task)
            yield failed

    async def _close_devices(self) -> None:
        await self.desk.close()
        for name, close in (
            ("arm", self.arm.close()),
            ("belt", self.devices.belt.close()),
            ("gripper board", self.devices.gripper_board.close()),
            ("recogniser", self.hearing.close()),
            ("planner", self.designer.close()),
            ("journal", self.journal.close()),
        ):
            try:
                async with asyncio.timeout(_CLOSE_PATIENCE_S):
                    await close
            except Exception:
                log.exception("closing failed", device=name)


async def _end(task: asyncio.Task[None]) -> None:
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
