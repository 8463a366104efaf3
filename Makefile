# Everything runs in its own virtual environment, built from pyproject.toml when it is missing or older.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
# Arguments for the discovery command, such as: make discover ARGS="experiment=paper seed=3"
ARGS ?=
# Libraries of docs/guides that take other versions of packages than $(VENV) has: only what differs is installed, and found first.
GUIDES := $(VENV)/guides/benchmarl/installed $(VENV)/guides/rllib/installed
# Packages of docs/studies: make study-NAME, with the study's own arguments in ARGS
STUDIES := discovery_of_behaviours calibration calibration_of_real_robots wall_following_and_milling task_rewards

.PHONY: help discover test tests-in-parallel guide-packages lint style types format bench $(STUDIES:%=study-%) paper-study calibration-study study-walls firmware firmware-test firmware-fuzz hardware docs clean

help:
	@echo "make discover   from nothing to a report of ten discovered behaviours (ARGS=\"experiment=paper seed=3\")"
	@echo "make test       ruff, mypy and the tests"
	@echo "make guide-packages  packages that the guide to BenchMARL and RLlib is tested with; make test installs them, too"
	@echo "make bench      speed of simulation and discovery, with tables"
	@echo "make study-discovery_of_behaviours     the paper's figures and tables, and what is better; hours, resumable (ARGS=\"--size paper\")"
	@echo "make study-calibration                 how often hidden effects are found; hours, resumable"
	@echo "make study-calibration_of_real_robots  what the simulation gets wrong about three real robots (ARGS=folder-with-their-logs)"
	@echo "make study-wall_following_and_milling  how often walls are followed and swarms mill, by world; minutes"
	@echo "make study-task_rewards                what each task pays its own behaviour, and random controllers; a minute"
	@echo "make firmware   size of the robot's code on its processors; firmware-test and firmware-fuzz test it there"
	@echo "make hardware   parts and assembly of the robot as STEP and STL, checked and drawn"
	@echo "make docs       the site, into docs/_build/html (needs node and npm)"
	@echo "make format     format the sources"
	@echo "make clean      remove the virtual environment"

discover: $(VENV)/installed-discovery
	@$(BIN)/python -m discovery $(ARGS)

# Types are checked beside the tests: one core idles while the first file or the site is made. What measures processes by the clock is last.
test: style
	@$(MAKE) --no-print-directory guide-packages || echo "not installed: the tests of the guide to BenchMARL and RLlib are skipped" >&2
	@$(MAKE) --no-print-directory -j2 types tests-in-parallel
	$(BIN)/python -m pytest -q -m real_time

tests-in-parallel: $(VENV)/installed-dev
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder -q -m "not real_time"

guide-packages: $(GUIDES)

lint: style types

style: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/installed-dev
	$(BIN)/mypy

format: $(VENV)/installed-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(VENV)/installed-dev
	@$(BIN)/python -m tests.bench.simulation
	@$(BIN)/python -m tests.bench.discovery

$(STUDIES:%=study-%): study-%: $(VENV)/installed-dev
	@$(BIN)/python -m docs.studies.$* $(ARGS)

paper-study: study-discovery_of_behaviours
	@echo "make paper-study is now make study-discovery_of_behaviours" >&2

calibration-study: study-calibration
	@echo "make calibration-study is now make study-calibration" >&2

study-walls: study-wall_following_and_milling
	@echo "make study-walls is now make study-wall_following_and_milling" >&2

firmware: $(VENV)/installed-dev
	$(BIN)/python -m hero_robot.firmware.build --sizes

firmware-test: $(VENV)/installed-dev
	$(BIN)/python -m hero_robot.firmware.build --test

firmware-fuzz: $(VENV)/installed-dev
	$(BIN)/python -m hero_robot.firmware.build --fuzz 1000000

hardware: $(VENV)/installed-hardware
	$(BIN)/python -m hardware.export

docs: $(VENV)/installed-dev
	$(BIN)/python docs/site/build.py

clean:
	rm -rf $(VENV)

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "found '$(PYTHON)', need Python 3.11 or newer; install it, or name it: make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
	  echo "'$(PYTHON) -m venv' failed; on Debian and Ubuntu: apt-get install python3-venv" >&2; exit 1; }

$(VENV)/installed-discovery: pyproject.toml | $(VENV)/bin/python
	@echo "setting up $(VENV) (once; about 7 GB on disk, a few minutes)"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[discovery]"
	@touch $@

$(VENV)/installed-dev: pyproject.toml | $(VENV)/bin/python
	@echo "setting up $(VENV) with what the tests need (once; about 8 GB on disk, a few minutes)"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[discovery,fleet,hardware,video,window,trainers,calibration,docs,dev]"
	@touch $@ $(VENV)/installed-discovery $(VENV)/installed-hardware

$(GUIDES): $(VENV)/guides/%/installed: tests/docs/packages/%.txt | $(VENV)/installed-dev
	@echo "installing what the guide to $* is tested with into $(@D) (once; 0.1 to 0.3 GB, a few seconds)"
	@rm -rf $(@D)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --target $(@D) --requirement $<
	@touch $@

$(VENV)/installed-hardware: pyproject.toml | $(VENV)/bin/python
	@echo "setting up $(VENV) with the CAD kernel (once; about 2 GB)"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[hardware]"
	@touch $@
