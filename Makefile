# `make demo` and `make test` do all the set-up by themselves; a second run installs nothing.

SHELL := /bin/bash
.DEFAULT_GOAL := help
.PHONY: help demo test test-hil soak lint format docs pictures protocol firmware flash-gripper flash-conveyor lock \
	setup setup-test install uninstall clean

BIN := .venv/bin
# Where matplotlib keeps its list of fonts, whatever the home directory is like.
export MPLCONFIGDIR := $(CURDIR)/.venv/matplotlib

help: ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+.*:.*## / {printf "  make %-14s %s\n", $$1, $$2}' Makefile

demo: setup ## Speak a wish, watch the emulated cell build it, keep a picture and a report in out/
	@mkdir -p out
	@$(BIN)/cellctl demo --speed 10 --picture out/stool.png --report out/report.json

test: setup-test firmware ## Lint, types, import layers and all tests but the long ones
	@scripts/test

soak: setup-test firmware ## The long proofs; an hour or more
	@$(BIN)/pytest -m soak --timeout 7200

test-hil: setup-test ## The suites for a cell that is there; CONFIG=cell.toml; asks before anything moves
	@test -n "$(CONFIG)" || { echo 'make test-hil CONFIG=cell.toml: name the cell' >&2; exit 2; }
	@CELLCTL_HIL_CONFIG='$(abspath $(CONFIG))' $(BIN)/pytest -s -p no:cacheprovider tests/hil

lint: setup ## ruff, mypy, import-linter
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy
	@$(BIN)/lint-imports

format: setup ## Put the code into shape
	@$(BIN)/ruff check --fix
	@$(BIN)/ruff format

docs: setup ## Write docs/reference anew from the code
	@$(BIN)/python -m cellctl.cli.reference docs/reference

pictures: setup-test ## Take the pictures of the page in docs/images/kiosk anew
	@$(BIN)/python -m tests.kiosk.pictures docs/images/kiosk

protocol: setup ## Write both sides' constants anew from docs/serial-protocol.md
	@$(BIN)/python -m cellctl.boards.protocol_tables docs/serial-protocol.md \
		cellctl/boards/constants.py firmware/common/protocol.h

firmware: setup ## Compile the boards' programs into firmware/build
	@$(MAKE) --no-print-directory -C firmware

flash-gripper: firmware ## Write program and fuses of the gripper's board; PORT=/dev/ttyUSB0
	@scripts/flash gripper '$(PORT)'

flash-conveyor: firmware ## The same for the conveyor's
	@scripts/flash conveyor '$(PORT)'

lock: setup ## Write the lock files anew; `make lock UPGRADE=1` takes newer versions
	@scripts/lock $(if $(UPGRADE),--upgrade)

setup: ## Install what is needed, if anything is
	@scripts/setup

setup-test:
	@scripts/setup --test

install: ## As root: install or upgrade the service; PREFIX=/opt/cellctl, DESTDIR= for packages
	@PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)' scripts/install

uninstall: ## As root: remove the service; PURGE=1 removes configuration and journal too
	@PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)' scripts/uninstall $(if $(PURGE),--purge)

clean: ## Remove everything that was made here, the environment included
	rm -rf .venv out build dist firmware/build *.egg-info .mypy_cache .ruff_cache .pytest_cache \
		.import_linter_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
